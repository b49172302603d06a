/* Depth images in one or two levels, after M. Singh, S. Bedi, S. Mann, "A GPU Method and Error
 * Analysis of Multi-Point Positioning of a Toroidal Tool for 5-Axis Machining", 2024: windows as
 * wide as the tool, then windows two pixels wide about each valley that may be the lowest. */
#include "backend/osmesa/search.h"
#include "core/part.h"

#include <string.h>

/* Side of the atlas, where one tile is not larger. */
#define ATLAS_SIDE 2048
/* About P circular rays graze the part: a view straight at it, that far to each side, in sizes of
 * the cutter. */
#define CONTACT_REACH 0.5
/* Its pixels a side where there is one level alone. */
#define CONTACT_PIXELS 50
/* What the wide view leaves to that one: all within. */
#define CONTACT_COVERS 0.45
/* Radius about P, in sizes of the cutter, and power d, in squares of it: nearer, a point does not
 * tell its angle in single precision, nor where P itself is a fine pixel off. The osculating limit
 * answers there, and the core's polish. */
#define P_RADIUS 0.05
#define P_POWER  6e-4
/* Cells larger than that part of half a window are cut, in so many along each side at the most. */
#define PIECE    2
#define CUTS_MAX 64
/* A pixel's worth of height as an angle, for a first choice of valleys: at that many sizes of the
 * cutter from O1. */
#define LEVER 0.5
/* The lowest valley, and others as low. */
#define VALLEYS BTG_RASTER_PICKS_MAX
/* Of a fine window: its lowest place, and those where a valley may leave it. */
#define RIMS 2
/* Windows a query at once, at the most: valleys of two coarse views. */
#define TILES_MAX (2 * BTG_RASTER_PICKS_MAX)
/* Windows whose middles are that near, part of half a side, are the same. */
#define SAME 0.75f
/* Of the part's box, for what stands out of it by rounding. */
#define BOX_MARGIN 0.01
/* What single precision tells of a depth. */
#define ROUNDING 3e-7f

uint32_t btg_raster_search_atlas(const btg_raster_options *options, uint32_t most) {
    uint32_t side = options->window > ATLAS_SIDE ? options->window : ATLAS_SIDE;
    return side < most ? side : most;
}

/* Of a fine shot and of the one that follows it. */
static size_t tile_room(const btg_raster_search *s) {
    return (size_t)2 * TILES_MAX * s->capacity;
}

static bool make_shot(btg_raster_shot *shot, const btg_allocator *allocator, size_t tiles) {
    shot->tiles = btg_allocate(allocator, tiles, sizeof *shot->tiles);
    shot->picks = btg_allocate(allocator, tiles * BTG_RASTER_PICKS_MAX, sizeof *shot->picks);
    return shot->tiles && shot->picks;
}

btg_status btg_raster_search_room(btg_raster_search *s, const btg_allocator *allocator,
                                  uint32_t capacity, btg_message *message) {
    s->capacity = capacity;
    s->queries = btg_allocate(allocator, capacity, sizeof *s->queries);
    s->best = btg_allocate(allocator, capacity, sizeof *s->best);
    s->seen = btg_allocate(allocator, capacity, sizeof *s->seen);
    bool all = make_shot(&s->coarse, allocator, 2 * (size_t)capacity) &&
               make_shot(&s->fine, allocator, tile_room(s));
    s->list = btg_allocate(allocator, BTG_RASTER_DRAW, sizeof *s->list);
    s->pieces = btg_allocate(allocator, BTG_RASTER_DRAW, sizeof *s->pieces);
    all = all && s->queries && s->best && s->seen && s->list && s->pieces;
    if (all) return BTG_OK;
    return btg_fail(message, BTG_ERROR_MEMORY, "osmesa: out of memory for %lu queries at once",
                    (unsigned long)capacity);
}

void btg_raster_search_free(btg_raster_search *s, const btg_allocator *allocator) {
    btg_scene_free(allocator, &s->scene);
    btg_release(allocator, s->queries);
    btg_release(allocator, s->best);
    btg_release(allocator, s->seen);
    btg_release(allocator, s->coarse.tiles);
    btg_release(allocator, s->coarse.picks);
    btg_release(allocator, s->fine.tiles);
    btg_release(allocator, s->fine.picks);
    btg_release(allocator, s->list);
    btg_release(allocator, s->pieces);
}

/* ---- windows ------------------------------------------------------------------------------ */

static double cutter_size(const btg_raster_search *s) {
    const btg_tool_element *e = &s->tool.element[0];
    return e->corner_radius_mm > 0 ? e->corner_radius_mm : e->ring_radius_mm;
}

static double tool_radius(const btg_raster_search *s) {
    double radius = 0;
    for (uint32_t i = 0; i < s->tool.element_count; i++) {
        const btg_tool_element *e = &s->tool.element[i];
        radius = max2(radius, e->ring_radius_mm + e->corner_radius_mm);
    }
    return radius;
}

/* How far the tool reaches from the u axis through O1. */
static double tilt_reach(const btg_raster_search *s) {
    double major = s->tool.element[0].ring_radius_mm;
    double reach = 2 * major + s->tool.element[0].corner_radius_mm;
    for (uint32_t i = 1; i < s->tool.element_count; i++) {
        const btg_tool_element *e = &s->tool.element[i];
        double high = max2(fabs(e->from_mm), fabs(e->to_mm));
        reach = max2(reach, norm2(major + e->ring_radius_mm, high));
    }
    return reach;
}

/* The lowest and the highest value that a query can have. DROP: from the middle of the part's box,
 * along the axis. */
static void set_range(const btg_raster_search *s, uint32_t query, uint32_t view, double *low,
                      double *high) {
    *low = -0.5 * BTG_PI;
    *high = 0;
    if (view != BTG_VIEW_PLANE) return;
    const btg_part_info *info = &s->part->info;
    btg_gpu_vec4 w = s->queries[query].w;
    btg_vec3 half_side = vec_scale(vec_sub(info->box_max, info->box_min), 0.5 * (1 + BOX_MARGIN));
    double far = fabs(w.x) * half_side.x + fabs(w.y) * half_side.y + fabs(w.z) * half_side.z;
    double from = cutter_size(s);
    for (uint32_t i = 1; i < s->tool.element_count; i++)
        from = max2(from, s->tool.element[i].from_mm);
    *low = -far - from;
    *high = far + (1 + BOX_MARGIN) * cutter_size(s);
}

/* A window of a query; `leave`: radius about P, in sizes of the cutter. */
static btg_raster_tile tile_of(const btg_raster_search *s, uint32_t query, uint32_t view,
                               btg_gpu_vec4 window, double leave) {
    double size = cutter_size(s), radius = leave * size, power = P_POWER * size * size, low, high;
    set_range(s, query, view, &low, &high);
    return (btg_raster_tile){
        .window = window,
        .at = {query, view, 0, 0},
        .limits = {(float)(radius * radius), (float)power, (float)high, (float)(1 / (high - low))}};
}

static btg_raster_tile whole(const btg_raster_search *s, btg_op op, uint32_t query) {
    float radius = (float)tool_radius(s), reach = (float)(0.5 * tilt_reach(s));
    if (op == BTG_OP_DROP)
        return tile_of(s, query, BTG_VIEW_PLANE, (btg_gpu_vec4){0, 0, radius, radius}, 0);
    return tile_of(s, query, BTG_VIEW_CYLINDER, (btg_gpu_vec4){0, reach, radius, reach},
                   CONTACT_COVERS);
}

static btg_raster_tile at_contact(const btg_raster_search *s, uint32_t query) {
    float half = (float)(CONTACT_REACH * cutter_size(s));
    return tile_of(s, query, BTG_VIEW_CONTACT, (btg_gpu_vec4){0, 0, half, half}, P_RADIUS);
}

/* Two pixels wide about a place; or as wide as before. */
static btg_raster_tile closer(const btg_raster_search *s, const btg_search_best *at,
                              uint32_t pixels, bool zoom) {
    const btg_raster_tile *t = &at->tile;
    float k = zoom ? 2.0f / (float)pixels : 1;
    double middle[2];
    btg_view view = btg_view_make(&s->scene, &s->queries[t->at.x], t->at.y);
    btg_view_point(&view, btg_view_unpack(&s->scene, at->cell, at->place).point, middle);
    btg_gpu_vec4 window = {(float)middle[0], (float)middle[1], k * t->window.z, k * t->window.w};
    return tile_of(s, t->at.x, t->at.y, window, P_RADIUS);
}

/* ---- passes ------------------------------------------------------------------------------- */

static btg_raster_pass make_pass(const btg_raster_search *s, btg_op op, uint32_t pixels,
                                 bool coarse) {
    btg_raster_pass pass = {.size = {pixels, 1, s->raster.first_piece, !coarse}};
    double pixel = 2 * tool_radius(s) / pixels * (coarse ? 1 : 2.0 / pixels);
    double lever = op == BTG_OP_DROP ? 1 : LEVER * cutter_size(s);
    pass.scale.x = pass.scale.y = (float)(2.0 / s->raster.side);
    pass.scale.z = (float)(pixel / lever);
    if (s->options.levels == 2) pass.size.y = coarse ? VALLEYS : 1 + RIMS;
    return pass;
}

typedef struct drawing {
    const btg_raster_search *search;
    const btg_part *part;
    btg_view view; /* of the tile */
    double window[4];
    uint32_t tile;
    size_t count, pieces;
} drawing;

static void flush(drawing *d) {
    const btg_raster_search *s = d->search;
    btg_raster_draw(&s->raster, s->list, d->count, (const btg_gpu_vec4(*)[BTG_GPU_CELL])s->pieces,
                    d->pieces);
    d->count = d->pieces = 0;
}

static void draw_cell(drawing *d, uint32_t cell) {
    d->search->list[d->count++] = (btg_raster_entry){d->tile, cell};
}

static void take_piece(void *user, const btg_gpu_vec4 piece[BTG_GPU_CELL]) {
    drawing *d = user;
    const btg_raster_search *s = d->search;
    if (d->count == BTG_RASTER_DRAW) flush(d);
    memcpy(s->pieces[d->pieces], piece, sizeof s->pieces[0]);
    draw_cell(d, s->raster.first_piece + (uint32_t)d->pieces++);
}

static void take_cell(void *user, uint32_t cell) {
    drawing *d = user;
    btg_view_pieces sink = {take_piece, d};
    double cuts =
        ceil(btg_view_radius(&d->view, cell) / (PIECE * min2(d->window[2], d->window[3])));
    if (cuts > 1) {
        btg_view_cut(&d->view, d->part, d->window, cell,
                     cuts < CUTS_MAX ? (uint32_t)cuts : CUTS_MAX, &sink);
        return;
    }
    if (d->count == BTG_RASTER_DRAW) flush(d);
    draw_cell(d, cell);
}

static void draw_tile(drawing *d, uint32_t index, const btg_raster_tile *tile) {
    const btg_raster_search *s = d->search;
    const double window[4] = {tile->window.x, tile->window.y, tile->window.z, tile->window.w};
    btg_view_sink sink = {take_cell, d};
    memcpy(d->window, window, sizeof window);
    d->tile = index;
    d->view = btg_view_make(&s->scene, &s->queries[tile->at.x], tile->at.y);
    btg_view_cells(&d->view, d->window, &sink);
}

/* One atlas of tiles. */
static btg_status draw_some(btg_raster_search *s, btg_op op, const btg_raster_shot *shot,
                            uint32_t first, uint32_t count) {
    drawing d = {.search = s, .part = s->part};
    btg_raster_tile *tiles = shot->tiles + first;
    btg_raster_begin(&s->raster, op, &shot->pass, tiles, count);
    for (uint32_t i = 0; i < count; i++)
        draw_tile(&d, i, &tiles[i]);
    flush(&d);
    return btg_raster_finish(&s->raster, &shot->pass, count,
                             shot->picks + (size_t)first * shot->pass.size.y);
}

/* Any number of tiles. */
static btg_status draw(btg_raster_search *s, btg_op op, const btg_raster_shot *shot) {
    uint32_t room = btg_raster_capacity(&s->raster, shot->pass.size.x);
    for (uint32_t i = 0; i < shot->count; i += room) {
        uint32_t n = shot->count - i < room ? shot->count - i : room;
        btg_status status = draw_some(s, op, shot, i, n);
        if (status != BTG_OK) return status;
    }
    return BTG_OK;
}

/* ---- valleys ------------------------------------------------------------------------------ */

static btg_search_best best_of(const btg_raster_tile *tile, const btg_raster_pick *pick) {
    return (btg_search_best){.found = pick->depth < 1,
                             .depth = pick->depth,
                             .cell = pick->cell & ((1u << BTG_RASTER_ELEMENT) - 1),
                             .element = pick->cell >> BTG_RASTER_ELEMENT,
                             .place = pick->place,
                             .tile = *tile};
}

/* The lower one stays, of two as low that which was there; but a fine one replaces a coarse one. */
static void keep(btg_search_best *best, const btg_search_best *other) {
    uint32_t pick = best->pick;
    bool lower = !best->found || best->coarse || other->depth < best->depth;
    if (!other->found || !lower) return;
    *best = *other;
    best->pick = pick;
}

static void keep_firsts(btg_raster_search *s, const btg_raster_shot *shot) {
    for (uint32_t i = 0; i < shot->count; i++) {
        btg_search_best b = best_of(&shot->tiles[i], &shot->picks[(size_t)i * shot->pass.size.y]);
        keep(&s->best[shot->tiles[i].at.x], &b);
    }
}

static btg_status shoot(btg_raster_search *s, btg_op op, btg_raster_shot *shot) {
    btg_status status = draw(s, op, shot);
    if (status == BTG_OK) keep_firsts(s, shot);
    return status;
}

/* Whether the query has not had that window yet, and may have more: then it has now. Those about
 * coarse places always have room. */
static bool is_new(btg_raster_search *s, const btg_raster_tile *tile, bool zoom) {
    const uint32_t most = BTG_SEARCH_SEEN - (zoom ? 0 : TILES_MAX);
    btg_search_seen *seen = &s->seen[tile->at.x];
    for (uint32_t i = 0; i < seen->count; i++) {
        if (seen->view[i] == tile->at.y &&
            fabsf(seen->at[i][0] - tile->window.x) < SAME * tile->window.z &&
            fabsf(seen->at[i][1] - tile->window.y) < SAME * tile->window.w)
            return false;
    }
    if (seen->count >= most) return false;
    seen->view[seen->count] = tile->at.y;
    seen->at[seen->count][0] = tile->window.x;
    seen->at[seen->count++][1] = tile->window.y;
    return true;
}

static float value_of(const btg_search_best *at) {
    return at->tile.limits.z - at->depth / at->tile.limits.w;
}

/* What a place may be deeper than its pixel shows. */
static float hidden(const btg_raster_search *s, const btg_search_best *at, uint32_t pixels) {
    const btg_raster_tile *t = &at->tile;
    double half_pixel[2] = {t->window.z / pixels, t->window.w / pixels};
    btg_view view = btg_view_make(&s->scene, &s->queries[t->at.x], t->at.y);
    btg_view_hit hit = {at->cell, at->place, at->element, value_of(at)};
    return (float)btg_view_hidden(&view, &hit, norm2(half_pixel[0], half_pixel[1])) * t->limits.w +
           ROUNDING;
}

/* Adds a window about what was seen, if it may be lower than what is known. */
static uint32_t look_closer(btg_raster_search *s, uint32_t pixels, const btg_search_best *at,
                            bool zoom, btg_raster_tile *to) {
    float over = at->depth - s->best[at->tile.at.x].depth;
    if (!at->found || (over > 0 && over > hidden(s, at, pixels))) return 0;
    btg_raster_tile tile = closer(s, at, pixels, zoom);
    /* The wide view has what lies farther from P. */
    double most = CONTACT_REACH * cutter_size(s);
    if (tile.at.y == BTG_VIEW_CONTACT && norm2(tile.window.x, tile.window.y) > most) return 0;
    if (!is_new(s, &tile, zoom)) return 0;
    *to = tile;
    return 1;
}

/* Windows about the places where a valley may leave those that were: pixels hide how its floor
 * slopes, so that the lowest pixel alone does not tell the way. */
static void follow(btg_raster_search *s, btg_raster_shot *fine) {
    uint32_t picks = fine->pass.size.y;
    btg_raster_tile *to = fine->tiles + fine->count, *end = fine->tiles + tile_room(s);
    for (uint32_t i = 0; i < fine->count * picks && to < end; i++) {
        btg_search_best b = best_of(&fine->tiles[i / picks], &fine->picks[i]);
        if (i % picks > 0) to += look_closer(s, fine->pass.size.x, &b, false, to);
    }
    uint32_t count = (uint32_t)(to - fine->tiles) - fine->count;
    memmove(fine->tiles, fine->tiles + fine->count, count * sizeof *fine->tiles);
    fine->count = count;
}

/* Windows about picks: each query's best, or all others that may still beat what is known. */
static void zoom(btg_raster_search *s, const btg_raster_shot *coarse, bool firsts,
                 btg_raster_shot *fine) {
    uint32_t picks = coarse->pass.size.y, pixels = coarse->pass.size.x;
    for (uint32_t i = 0; i < coarse->count * picks; i++) {
        btg_search_best b = best_of(&coarse->tiles[i / picks], &coarse->picks[i]);
        if ((i == s->best[b.tile.at.x].pick) == firsts)
            fine->count += look_closer(s, pixels, &b, true, fine->tiles + fine->count);
    }
}

static void note_picks(btg_raster_search *s, const btg_raster_shot *coarse) {
    for (uint32_t i = coarse->count; i-- > 0;) {
        btg_search_best *best = &s->best[coarse->tiles[i].at.x];
        uint32_t pick = i * coarse->pass.size.y;
        best->coarse = true;
        if (coarse->picks[pick].depth == best->depth) best->pick = pick;
    }
}

static btg_status search_fine(btg_raster_search *s, btg_op op, const btg_raster_shot *coarse) {
    btg_raster_shot *fine = &s->fine;
    fine->pass = make_pass(s, op, coarse->pass.size.x, false);
    fine->count = 0;
    note_picks(s, coarse);
    zoom(s, coarse, true, fine);
    for (bool others = true; fine->count > 0; others = false) {
        btg_status status = shoot(s, op, fine);
        if (status != BTG_OK) return status;
        follow(s, fine);
        if (others) zoom(s, coarse, false, fine);
    }
    return BTG_OK;
}

/* One level alone, or the first of two. */
static btg_status search_coarse(btg_raster_search *s, btg_op op, uint32_t pixels, bool wide,
                                bool contact, uint32_t count) {
    btg_raster_shot *shot = &s->coarse;
    shot->pass = make_pass(s, op, pixels, true);
    shot->count = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (wide) shot->tiles[shot->count++] = whole(s, op, i);
        if (contact) shot->tiles[shot->count++] = at_contact(s, i);
    }
    btg_status status = shoot(s, op, shot);
    if (status == BTG_OK && s->options.levels == 2) status = search_fine(s, op, shot);
    return status;
}

/* ---- whole -------------------------------------------------------------------------------- */

static btg_gpu_winner winner_of(const btg_raster_search *s, const btg_search_best *b) {
    btg_gpu_winner w = {0};
    if (!b->found) return w;
    btg_view_place at = btg_view_unpack(&s->scene, b->cell, b->place);
    w.found = 1;
    w.value = value_of(b);
    w.u = (float)at.u;
    w.v = (float)at.v;
    w.item = at.item;
    w.element = b->element;
    return w;
}

btg_status btg_raster_search_run(btg_raster_search *s, btg_op op, uint32_t count,
                                 btg_gpu_winner *winners) {
    bool tilt = op == BTG_OP_TILT, one = s->options.levels == 1;
    for (uint32_t i = 0; i < count; i++)
        s->best[i] = (btg_search_best){.depth = 1}, s->seen[i].count = 0;
    btg_raster_queries(&s->raster, s->queries, count);
    btg_status status = search_coarse(s, op, s->options.window, true, tilt && !one, count);
    if (status == BTG_OK && tilt && one)
        status = search_coarse(s, op, CONTACT_PIXELS, false, true, count);
    for (uint32_t i = 0; i < count && status == BTG_OK; i++)
        winners[i] = winner_of(s, &s->best[i]);
    return status;
}
