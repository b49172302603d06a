/* The tree of balls over a part's cells: cells in the order of a space-filling curve (G. M. Morton,
 * 1966), and above them each FAN in a row under one ball. */
#include "backend/device/scene.h"
#include "core/part.h"

#include <stdlib.h>
#include <string.h>

/* Sizes as parts of the tool's radius: a cell is small against the tool's curvature, samples are
 * near enough to lead to every peak that a tool's width holds. Larger ones are quicker, and will do
 * where the core looks everywhere again: near P, where a cell's piece misses P by its residual,
 * they may lead astray. */
#define CELL_SIDE           0.5
#define CELL_SIDE_POLISHED  0.8
#define CELL_PITCH          0.1
#define CELL_PITCH_POLISHED 0.2
#define CELL_RESIDUAL       0.003
/* Expansions of the surface about a winner that nobody polishes. */
#define FOLLOW 2
/* Cells at the most, where the part does not need more: some 130 MB. */
#define CELLS_WANTED (1u << 20)
/* A part too large for these sizes is cut that much coarser, so often. */
#define COARSER     1.5
#define COARSENINGS 40

_Static_assert(sizeof(btg_gpu_scene) == 16 * (2 + BTG_GPU_LEVELS + BTG_GPU_ELEMENTS), "layout");
_Static_assert(sizeof(btg_gpu_query) == 16 * 7, "layout");
_Static_assert(sizeof(btg_gpu_winner) == 32, "layout");
_Static_assert(BTG_GPU_ELEMENTS == 2 + BTG_HOLDER_MAX, "layout");

typedef struct draft {
    uint64_t key; /* place on the curve */
    btg_gpu_vec4 cell[BTG_GPU_CELL];
} draft;

typedef struct builder {
    const btg_part *part;
    const btg_allocator *allocator;
    btg_cell_size size;
    btg_scene *scene;
    draft *drafts;
    size_t cells, patches, coefficients; /* counts; the last in vec4s */
    bool follow;                         /* winners */
    uint32_t levels;
    size_t nodes[BTG_GPU_LEVELS];
} builder;

/* ---- how many ----------------------------------------------------------------------------- */

static size_t cells_of(uint32_t nu, uint32_t nv, bool triangle) {
    return triangle ? (size_t)nu * (nu + 1) / 2 : (size_t)nu * nv;
}

static size_t count_cells(const builder *b) {
    size_t cells = 0, items = (size_t)b->part->patch_count + b->part->triangle_count;
    for (size_t i = 0; i < items; i++) {
        uint32_t nu, nv;
        btg_cells_count(b->part, (uint32_t)i, &b->size, &nu, &nv);
        cells += cells_of(nu, nv, i >= b->part->patch_count);
    }
    return cells;
}

/* Nodes of each level above `cells`; what all takes, in vec4s. */
static size_t lay_out(builder *b) {
    size_t total = b->cells * BTG_GPU_CELL + BTG_GPU_PATCH * b->patches + b->coefficients;
    size_t n = b->cells;
    b->levels = 0;
    for (;;) {
        b->nodes[b->levels++] = n;
        total += n;
        if (n == 1 && b->levels > 1) return total;
        n = (n + BTG_GPU_FAN - 1) / BTG_GPU_FAN;
    }
}

static btg_status choose_size(builder *b, const btg_tool *tool, const btg_cell_size *wanted,
                              size_t bytes_max, btg_message *message) {
    const btg_tool_element *e = &tool->element[0];
    double radius = e->ring_radius_mm + e->corner_radius_mm;
    double pitch = b->follow ? CELL_PITCH : CELL_PITCH_POLISHED;
    double side = b->follow ? CELL_SIDE : CELL_SIDE_POLISHED;
    b->size = (btg_cell_size){side, pitch, CELL_RESIDUAL};
    if (wanted->side > 0) b->size = *wanted;
    b->size.side *= radius;
    b->size.pitch *= radius;
    b->size.residual *= radius;
    size_t items = (size_t)b->part->patch_count + b->part->triangle_count, bytes = 0;
    for (int i = 0; i < COARSENINGS; i++) {
        b->cells = count_cells(b);
        bytes = lay_out(b) * sizeof(btg_gpu_vec4);
        bool enough = b->cells <= CELLS_WANTED || b->cells == items;
        if (enough && bytes <= bytes_max) return BTG_OK;
        if (b->cells == items) break;
        b->size.side *= COARSER;
        b->size.pitch *= COARSER;
        b->size.residual *= COARSER * COARSER * COARSER;
    }
    return btg_fail(message, BTG_ERROR_UNSUPPORTED,
                    "the part needs %zu MB in one buffer of the device, which takes %zu; split the "
                    "part or use the back end cpu",
                    bytes >> 20, bytes_max >> 20);
}

/* ---- cells in order ----------------------------------------------------------------------- */

/* The lowest 21 bits, two zeros between each. */
static uint64_t spread(uint64_t x) {
    x &= 0x1fffff;
    x = (x | x << 32) & 0x1f00000000ffffu;
    x = (x | x << 16) & 0x1f0000ff0000ffu;
    x = (x | x << 8) & 0x100f00f00f00f00fu;
    x = (x | x << 4) & 0x10c30c30c30c30c3u;
    return (x | x << 2) & 0x1249249249249249u;
}

static uint64_t curve_key(btg_vec3 p, double half) {
    const double c[3] = {p.x, p.y, p.z};
    uint64_t key = 0;
    for (int k = 0; k < 3; k++) {
        double x = 0.5 + 0.499 * c[k] / half;
        x = x < 0 ? 0 : (x > 1 ? 1 : x);
        key |= spread((uint64_t)(x * 0x1fffff)) << k;
    }
    return key;
}

static int by_key(const void *a, const void *b) {
    const draft *x = a, *y = b;
    if (x->key != y->key) return x->key < y->key ? -1 : 1;
    return memcmp(x->cell, y->cell, sizeof x->cell); /* the same order everywhere */
}

static void fill_item(builder *b, uint32_t item, double half, size_t *at) {
    uint32_t nu, nv;
    bool triangle = item >= b->part->patch_count;
    btg_cells_count(b->part, item, &b->size, &nu, &nv);
    for (uint32_t i = 0; i < nu; i++)
        for (uint32_t j = 0; j < nv && (!triangle || i + j < nu); j++) {
            draft *d = &b->drafts[(*at)++];
            btg_vec3 c =
                btg_cells_fill(b->part, item, nu, nv, i, j, &b->size, b->scene->middle, d->cell);
            d->key = curve_key(c, half);
        }
}

static void fill_cells(builder *b, size_t at_cells) {
    const btg_part_info *info = &b->part->info;
    btg_vec3 half = vec_scale(vec_sub(info->box_max, info->box_min), 0.5);
    double most = max2(max2(half.x, half.y), max2(half.z, 1e-6));
    uint32_t items = b->part->patch_count + b->part->triangle_count;
    size_t count = 0;
    for (uint32_t i = 0; i < items; i++)
        fill_item(b, i, most, &count);
    qsort(b->drafts, count, sizeof *b->drafts, by_key);
    for (size_t i = 0; i < count; i++)
        memcpy(b->scene->geometry + at_cells + i * BTG_GPU_CELL, b->drafts[i].cell,
               sizeof b->drafts[i].cell);
}

/* ---- balls -------------------------------------------------------------------------------- */

static btg_vec3 centre_of(btg_gpu_vec4 ball) {
    return vec(ball.x, ball.y, ball.z);
}

/* A ball about the middle of others' centres. */
static btg_gpu_vec4 ball_over(const btg_gpu_vec4 *balls, size_t count) {
    btg_vec3 sum = vec(0, 0, 0);
    for (size_t i = 0; i < count; i++)
        sum = vec_add(sum, centre_of(balls[i]));
    btg_gpu_vec4 ball, low;
    btg_gpu_split(vec_scale(sum, 1.0 / (double)count), &ball, &low);
    double radius = 0;
    for (size_t i = 0; i < count; i++) {
        double far = vec_norm(vec_sub(centre_of(balls[i]), centre_of(ball)));
        radius = max2(radius, far + balls[i].w);
    }
    ball.w = (float)(radius * (1 + 1e-6));
    return ball;
}

static void fill_levels(builder *b, size_t at_cells) {
    btg_gpu_vec4 *g = b->scene->geometry;
    size_t at = 0, below = 0;
    for (uint32_t level = 0; level < b->levels; level++) {
        for (size_t i = 0; i < b->nodes[level]; i++) {
            if (level == 0) {
                g[at + i] = g[at_cells + i * BTG_GPU_CELL];
                continue;
            }
            size_t first = i * BTG_GPU_FAN, left = b->nodes[level - 1] - first;
            g[at + i] = ball_over(g + below + first, left < BTG_GPU_FAN ? left : BTG_GPU_FAN);
        }
        b->scene->head.level[level] =
            (btg_gpu_uvec4){.x = (uint32_t)at, .y = (uint32_t)b->nodes[level]};
        below = at;
        at += b->nodes[level];
    }
}

/* ---- patches ------------------------------------------------------------------------------ */

static size_t patch_points(const btg_patch *p) {
    return (size_t)(p->degree_u + 1) * (size_t)(p->degree_v + 1);
}

static void fill_patches(builder *b, size_t at_patches) {
    btg_gpu_vec4 *g = b->scene->geometry;
    size_t at = at_patches + BTG_GPU_PATCH * b->patches;
    for (uint32_t i = 0; i < b->part->patch_count; i++) {
        const btg_patch *p = &b->part->patches[i];
        btg_gpu_vec4 *head = g + at_patches + (size_t)BTG_GPU_PATCH * i;
        uint32_t bits = p->degree_u + 16u * p->degree_v + (p->rational ? 256u : 0);
        btg_gpu_split(vec_sub(p->origin, b->scene->middle), &head[0], &head[1]);
        head[0].w = btg_gpu_bits((uint32_t)at);
        head[1].w = btg_gpu_bits(bits);
        for (size_t k = 0; k < patch_points(p); k++, at++) {
            const double *c = p->power + 4 * k;
            g[at] = (btg_gpu_vec4){(float)c[0], (float)c[1], (float)c[2], (float)c[3]};
        }
    }
}

static void fill_head(builder *b, const btg_tool *tool, size_t at_cells, size_t at_patches) {
    uint32_t follow = b->follow ? FOLLOW : 0;
    btg_gpu_scene *head = &b->scene->head;
    head->counts = (btg_gpu_uvec4){b->part->patch_count, b->levels, tool->element_count,
                                   tool->element[0].hollow != 0};
    head->starts = (btg_gpu_uvec4){.x = (uint32_t)at_cells, .y = (uint32_t)at_patches, .z = follow};
    for (uint32_t i = 0; i < tool->element_count; i++) {
        const btg_tool_element *e = &tool->element[i];
        head->element[i] = (btg_gpu_vec4){(float)e->ring_radius_mm, (float)e->corner_radius_mm,
                                          (float)e->from_mm, (float)e->to_mm};
    }
}

/* ---- whole -------------------------------------------------------------------------------- */

static btg_status build(builder *b, const btg_tool *tool, btg_message *message) {
    btg_scene *scene = b->scene;
    scene->count = lay_out(b);
    scene->geometry = btg_allocate(b->allocator, scene->count, sizeof *scene->geometry);
    b->drafts = btg_allocate(b->allocator, b->cells, sizeof *b->drafts);
    if (!scene->geometry || !b->drafts) {
        btg_release(b->allocator, b->drafts);
        btg_scene_free(b->allocator, scene);
        return btg_fail(message, BTG_ERROR_MEMORY, "back end: no memory for %zu cells of the part",
                        b->cells);
    }
    size_t at_cells = 0;
    for (uint32_t i = 0; i < b->levels; i++)
        at_cells += b->nodes[i];
    size_t at_patches = at_cells + b->cells * BTG_GPU_CELL;
    fill_cells(b, at_cells);
    fill_levels(b, at_cells);
    fill_patches(b, at_patches);
    fill_head(b, tool, at_cells, at_patches);
    btg_release(b->allocator, b->drafts);
    return BTG_OK;
}

btg_status btg_scene_make(const btg_backend_setup *setup, const btg_cell_size *wanted,
                          size_t bytes_max, btg_scene *scene, btg_message *message) {
    const btg_part *part = setup->part;
    btg_scene made = {.middle = vec_scale(vec_add(part->info.box_min, part->info.box_max), 0.5)};
    builder b = {
        .part = part, .allocator = &setup->allocator, .scene = &made, .follow = setup->raw};
    b.patches = part->patch_count;
    for (uint32_t i = 0; i < part->patch_count; i++)
        b.coefficients += patch_points(&part->patches[i]);
    btg_status status = choose_size(&b, &setup->tool, wanted, bytes_max, message);
    if (status == BTG_OK) status = build(&b, &setup->tool, message);
    if (status == BTG_OK) *scene = made;
    return status;
}

void btg_scene_free(const btg_allocator *allocator, btg_scene *scene) {
    btg_release(allocator, scene->geometry);
    *scene = (btg_scene){0};
}
