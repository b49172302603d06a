/* Rays from a dense grid of part points under the tool's shadow, as M. Singh, S. Bedi, S. Mann,
 * "Tool Positioning in Five Axis Machining on a Tensor Product Surface using Circular Rays" (VCRF),
 * section 4, prints them; its equation 13 in the linear form it reduces to (core/ray.c). No search:
 * the best ray is the answer, as near as the grid is dense. The paper's limit to the shadow is kept
 * as well, so a second contact beside it is not seen.
 *
 * A second level for the drop, as in the same authors' GPU paper, fires another grid around the
 * best ray. The VCRF paper prints none, but its table 3 (contacts 0.003 mm off) would need rays
 * 0.01 mm apart, 1e10 of them in its table 5's 10 s. It matters for the tilt: about a P that is
 * 0.05 mm off, rays from beside P meet the tool degrees too soon. The tilt has one level: a second
 * one would fire from still nearer to P, and err the more.
 *
 * Points are evaluated once a part instead of once a position. They lie in tiles, each inside a
 * ball, so that those under the shadow are found without looking at all. */
#include "methods/internal.h"

/* Points of a part at the most: 24 bytes each. */
#define POINTS_MAX 8000000
/* Points along a side of a tile. */
#define TILE 24
/* Rays across the second level, which is two steps of the first wide (GPU paper: 50 pixels). */
#define ZOOM 50
/* Lines across a surface, and pieces of each, whose lengths say how many points it gets. */
#define LINES  5
#define CHORDS 16

typedef struct tile {
    btg_vec3 centre;
    double radius;
    uint32_t item;
    uint32_t a0, b0, na, nb;   /* its points of the item's grid */
    uint32_t steps_a, steps_b; /* of that grid */
    size_t first;              /* point */
} tile;

struct btg_grid {
    const btg_backend_setup *setup;
    btg_backend_setup own;
    btg_method_counts *counts;
    double spacing, shadow; /* mm; radius of the tool's shadow */
    int levels;
    btg_vec3 *points;
    tile *tiles;
    size_t point_count, tile_count;
};

/* a and b run over 0..1 on triangles as on patches. */
static btg_place place_of(const btg_part *part, uint32_t item, double a, double b) {
    return (btg_place){item, a, item < part->patch_count ? b : b * (1 - a)};
}

static btg_vec3 point_of(const btg_part *part, btg_place place) {
    if (place.item < part->patch_count)
        return btg_patch_point(&part->patches[place.item], place.u, place.v);
    btg_vec3 k[3];
    btg_triangle_corners(part, place.item - part->patch_count, k);
    btg_vec3 s = vec_mad(k[0], vec_sub(k[1], k[0]), place.u);
    return vec_mad(s, vec_sub(k[2], k[0]), place.v);
}

/* Greatest length across an item along a (or b). */
static double length_across(const btg_part *part, uint32_t item, bool along_a) {
    double longest = 0;
    for (int line = 0; line < LINES; line++) {
        double across = (double)line / (LINES - 1), length = 0;
        btg_vec3 last = vec(0, 0, 0);
        for (int k = 0; k <= CHORDS; k++) {
            double t = (double)k / CHORDS;
            btg_place at =
                along_a ? place_of(part, item, t, across) : place_of(part, item, across, t);
            btg_vec3 s = point_of(part, at);
            if (k > 0) length += vec_norm(vec_sub(s, last));
            last = s;
        }
        longest = fmax(longest, length);
    }
    return longest;
}

static uint32_t steps_of(double length, double spacing) {
    double n = ceil(length / spacing);
    return n > POINTS_MAX ? POINTS_MAX : n < 1 ? 1 : (uint32_t)n;
}

static uint32_t least(uint32_t a, uint32_t b) {
    return a < b ? a : b;
}

/* Counts an item's tiles and points; lays them out where there is room. */
static void lay_item(btg_grid *g, uint32_t item, bool fill) {
    const btg_part *part = g->setup->part;
    uint32_t na = steps_of(length_across(part, item, true), g->spacing);
    uint32_t nb = steps_of(length_across(part, item, false), g->spacing);
    if (!fill && (double)(na + 1) * (nb + 1) > POINTS_MAX) {
        g->point_count = POINTS_MAX + 1;
        return;
    }
    for (uint32_t a = 0; a <= na; a += TILE)
        for (uint32_t b = 0; b <= nb; b += TILE) {
            tile t = {.item = item, .a0 = a, .b0 = b, .steps_a = na, .steps_b = nb};
            t.na = least(TILE, na + 1 - a);
            t.nb = least(TILE, nb + 1 - b);
            t.first = g->point_count;
            if (fill) g->tiles[g->tile_count] = t;
            g->tile_count++;
            g->point_count += (size_t)t.na * t.nb;
        }
}

static btg_place tile_place(const btg_grid *g, const tile *t, size_t k) {
    double a = (double)(t->a0 + k / t->nb) / t->steps_a;
    double b = (double)(t->b0 + k % t->nb) / t->steps_b;
    return place_of(g->setup->part, t->item, a, b);
}

static void fill_tile(btg_grid *g, tile *t) {
    size_t count = (size_t)t->na * t->nb;
    btg_vec3 *p = g->points + t->first;
    for (size_t k = 0; k < count; k++)
        p[k] = point_of(g->setup->part, tile_place(g, t, k));
    t->centre = p[count / 2];
    for (size_t k = 0; k < count; k++)
        t->radius = fmax(t->radius, vec_norm(vec_sub(p[k], t->centre)));
}

static bool lay(btg_grid *g, bool fill) {
    const btg_part *part = g->setup->part;
    uint32_t items = part->patch_count + part->triangle_count;
    g->point_count = g->tile_count = 0;
    for (uint32_t i = 0; i < items && g->point_count <= POINTS_MAX; i++)
        lay_item(g, i, fill);
    return g->point_count <= POINTS_MAX;
}

static double shadow_of(const btg_tool *tool) {
    double shadow = 0;
    for (uint32_t i = 0; i < tool->element_count; i++)
        shadow = fmax(shadow, tool->element[i].ring_radius_mm + tool->element[i].corner_radius_mm);
    return shadow;
}

btg_status btg_grid_create(const btg_backend_setup *setup, const char *name, btg_grid **grid,
                           btg_message *message) {
    const btg_method_context *context = btg_method_context_of(setup);
    btg_grid *g = btg_allocate(&setup->allocator, 1, sizeof *g);
    if (!g) return btg_fail(message, BTG_ERROR_MEMORY, "method %s: out of memory", name);
    *g = (btg_grid){.own = *setup, .counts = context->counts};
    g->setup = &g->own;
    g->spacing = context->def->ray_spacing_mm;
    g->levels = context->def->levels;
    g->shadow = shadow_of(&setup->tool);
    if (!lay(g, false)) {
        btg_grid_destroy(g);
        return btg_fail(message, BTG_ERROR_UNSUPPORTED,
                        "method %s: rays %g mm apart are more than %d on this part; give a larger "
                        "--ray-spacing",
                        name, context->def->ray_spacing_mm, POINTS_MAX);
    }
    g->points = btg_allocate(&setup->allocator, g->point_count, sizeof *g->points);
    g->tiles = btg_allocate(&setup->allocator, g->tile_count, sizeof *g->tiles);
    if (!g->points || !g->tiles) {
        btg_grid_destroy(g);
        return btg_fail(message, BTG_ERROR_MEMORY, "method %s: out of memory for its rays", name);
    }
    lay(g, true);
    for (size_t i = 0; i < g->tile_count; i++)
        fill_tile(g, &g->tiles[i]);
    *grid = g;
    return BTG_OK;
}

void btg_grid_destroy(btg_grid *grid) {
    if (!grid) return;
    btg_allocator allocator = grid->own.allocator;
    btg_release(&allocator, grid->points);
    btg_release(&allocator, grid->tiles);
    btg_release(&allocator, grid);
}

const btg_backend_setup *btg_grid_setup(const btg_grid *grid) {
    return &grid->own;
}

/* ---- rays --------------------------------------------------------------------------------- */

typedef struct best {
    bool found;
    btg_ray_hit hit;
    btg_place place;
    btg_vec3 point;
    double step_a, step_b; /* of the grid around it */
    uint64_t rays;
} best;

static bool beats(const btg_ray_query *q, btg_vec3 s, best *b) {
    btg_ray_hit hit;
    b->rays++;
    if (!btg_ray_cast(q, s, &hit) || (b->found && hit.value <= b->hit.value)) return false;
    b->found = true;
    b->hit = hit;
    b->point = s;
    return true;
}

/* All rays of one tile from under the shadow, the cylinder of that radius about an axis. */
static void cast_tile(const btg_grid *g, const tile *t, const btg_ray_query *q, btg_vec3 foot,
                      best *b) {
    size_t count = (size_t)t->na * t->nb;
    double shadow2 = g->shadow * g->shadow;
    for (size_t k = 0; k < count; k++) {
        btg_vec3 s = g->points[t->first + k], d = vec_sub(s, foot);
        if (vec_norm2(vec_cross(d, q->w)) > shadow2 || !beats(q, s, b)) continue;
        b->place = tile_place(g, t, k);
        b->step_a = 1.0 / t->steps_a;
        b->step_b = 1.0 / t->steps_b;
    }
}

/* The second level: one step to all sides of the best so far. */
static void zoom(const btg_grid *g, const btg_ray_query *q, best *b) {
    const btg_part *part = g->setup->part;
    bool patch = b->place.item < part->patch_count;
    double a0 = b->place.u, b0 = b->place.v;
    if (!patch) b0 = a0 < 1 ? b0 / (1 - a0) : 0;
    for (int i = -ZOOM / 2; i <= ZOOM / 2; i++)
        for (int j = -ZOOM / 2; j <= ZOOM / 2; j++) {
            double u = a0 + 2.0 * i / ZOOM * b->step_a, v = b0 + 2.0 * j / ZOOM * b->step_b;
            if (!(u >= 0 && u <= 1 && v >= 0 && v <= 1)) continue;
            btg_place at = place_of(part, b->place.item, u, v);
            if (beats(q, point_of(part, at), b)) b->place = at;
        }
}

static best cast_all(const btg_grid *g, const btg_ray_query *q, btg_vec3 foot) {
    best b = {0};
    for (size_t i = 0; i < g->tile_count; i++) {
        const tile *t = &g->tiles[i];
        double near = g->shadow + t->radius;
        if (vec_norm2(vec_cross(vec_sub(t->centre, foot), q->w)) > near * near) continue;
        cast_tile(g, t, q, foot, &b);
    }
    if (g->levels > 1 && b.found && q->op == BTG_OP_DROP) zoom(g, q, &b);
    g->counts->rays += b.rays;
    return b;
}

static btg_contact contact_of(const btg_ray_query *q, const best *b) {
    return btg_method_contact(q, b->hit.value, b->hit.element, b->place, b->point);
}

static uint32_t nodes_of(const best *b) {
    return b->rays < UINT32_MAX ? (uint32_t)b->rays : UINT32_MAX;
}

btg_status btg_grid_drop(void *grid, const btg_drop_query *queries, size_t count,
                         btg_drop_result *results) {
    const btg_grid *g = grid;
    for (size_t i = 0; i < count; i++) {
        btg_ray_query q = btg_ray_query_drop(&g->setup->tool, &queries[i]);
        best b = cast_all(g, &q, queries[i].origin);
        btg_drop_result r = {.status = BTG_NO_CONTACT, .bound_mm = NAN, .nodes = nodes_of(&b)};
        if (b.found) {
            r.status = BTG_OK;
            r.height_mm = b.hit.value;
            r.element = b.hit.element;
            r.contact = contact_of(&q, &b);
        }
        results[i] = r;
    }
    return BTG_OK;
}

/* No clearance about P, as the paper has none: what comes of it shows in its tables. */
btg_status btg_grid_tilt(void *grid, const btg_tilt_query *queries, size_t count,
                         btg_tilt_result *results) {
    const btg_grid *g = grid;
    double ro = g->setup->tool.element[0].ring_radius_mm;
    for (size_t i = 0; i < count; i++) {
        btg_ray_query q = btg_ray_query_tilt(&g->setup->tool, &queries[i]);
        q.p_clearance2 = 0;
        best b = cast_all(g, &q, vec_mad(queries[i].o1, queries[i].v, ro));
        btg_tilt_result r = {.status = BTG_SINGLE_CONTACT,
                             .tilt_rad = queries[i].max_tilt_rad,
                             .bound_mm = NAN,
                             .nodes = nodes_of(&b)};
        if (b.found && -b.hit.value <= queries[i].max_tilt_rad) {
            r.status = BTG_OK;
            r.tilt_rad = fmax(-b.hit.value, 0);
            r.element = b.hit.element;
            r.contact = contact_of(&q, &b);
        }
        results[i] = r;
    }
    return BTG_OK;
}

/* ---- the method --------------------------------------------------------------------------- */

static btg_status open(const btg_backend_setup *setup, void **state, btg_message *message) {
    btg_grid *grid;
    btg_status status = btg_grid_create(setup, "vcrf-grid", &grid, message);
    if (status == BTG_OK) *state = grid;
    return status;
}

static void close(void *state) {
    btg_grid_destroy(state);
}

static btg_status drop(void *state, const btg_drop_query *queries, size_t count,
                       btg_drop_result *results) {
    btg_grid *g = state;
    g->counts->drops += count;
    return btg_grid_drop(g, queries, count, results);
}

static btg_status tilt(void *state, const btg_tilt_query *queries, size_t count,
                       btg_tilt_result *results) {
    btg_grid *g = state;
    g->counts->tilts += count;
    return btg_grid_tilt(g, queries, count, results);
}

const btg_backend_table btg_method_vcrf_grid = {
    .name = "vcrf-grid",
    .summary = "vertical and circular rays from a dense grid under the tool's shadow",
    .open = open,
    .close = close,
    .drop = drop,
    .tilt = tilt};
