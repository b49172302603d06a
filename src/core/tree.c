/* Search trees: binary trees of tiles inside each patch, and one binary tree of boxes over all
 * patches and triangles, split at the median so that its depth is bounded. */
#include "core/tree.h"
#include "core/cell.h"

#include <string.h>

/* Stored tiles end where they are this flat (bend over size): there a made one costs no more to
 * test and a deeper tree only leaves the cache. */
#define TILE_FLATNESS 0.008
/* Bounds for patches that are never flat, at a collapsed edge for one: levels stored at the most,
 * and the smallest tile as a part of the patch. What is still bent is cut further on the way. */
#define TILE_DEPTH_MAX 12
#define TILE_SMALLEST  0.004
#define ITEMS_A_LEAF   4

/* ---- tiles -------------------------------------------------------------------------------- */

static btg_status reserve(const btg_allocator *allocator, btg_tile_list *list, uint32_t extra) {
    if (list->capacity - list->count >= extra) return BTG_OK;
    if (list->count > BTG_TILE_CHILD / 2) return BTG_ERROR_MEMORY;
    uint32_t capacity = list->capacity < 512 ? 1024 : 2 * list->capacity;
    btg_tile *tiles = btg_allocate(allocator, capacity, sizeof *tiles);
    if (!tiles) return BTG_ERROR_MEMORY;
    if (list->count) memcpy(tiles, list->tiles, list->count * sizeof *tiles);
    btg_release(allocator, list->tiles);
    list->tiles = tiles;
    list->capacity = capacity;
    return BTG_OK;
}

static double float_norm(const float a[3]) {
    return sqrt((double)a[0] * a[0] + (double)a[1] * a[1] + (double)a[2] * a[2]);
}

typedef struct tile_build {
    const btg_allocator *allocator;
    double scale;
    double smallest; /* tile, mm */
    btg_tile_list *list;
    uint32_t depth; /* reached */
    double *third;  /* of the patch (part.h) */
} tile_build;

/* A leaf's third derivatives, in the patch's parameters: halved `in_u` and `in_v` times. */
static void add_third(const btg_net *net, int in_u, int in_v, double third[4]) {
    double local[4] = {0, 0, 0, 0};
    btg_net_third(net, local);
    for (int k = 0; k < 4; k++)
        third[k] = fmax(third[k], ldexp(local[k], (3 - k) * in_u + k * in_v));
}

static double tile_size(const btg_tile *t) {
    double a = float_norm(t->a), b = float_norm(t->b);
    return (a > b ? a : b) + t->bend_uu + t->bend_uv + t->bend_vv;
}

/* The side whose halving takes more off the bend; none when the tile is flat or small enough. */
static bool want_split(const btg_tile *t, double smallest, bool *along_u) {
    double a = float_norm(t->a), b = float_norm(t->b), size = a > b ? a : b;
    double total = (double)t->bend_uu + t->bend_uv + t->bend_vv;
    *along_u = t->bend_uu > t->bend_vv || (t->bend_uu == t->bend_vv && a >= b);
    return total > TILE_FLATNESS * size && size + total > smallest;
}

static btg_status grow(tile_build *build, const btg_net *net, uint32_t at, int in_u, int in_v) {
    bool along_u;
    uint32_t level = (uint32_t)(in_u + in_v);
    if (level > build->depth) build->depth = level;
    if (level >= TILE_DEPTH_MAX ||
        !want_split(&build->list->tiles[at], build->smallest, &along_u)) {
        add_third(net, in_u, in_v, build->third);
        return BTG_OK;
    }
    btg_status status = reserve(build->allocator, build->list, 2);
    if (status) return status;
    uint32_t child = build->list->count;
    build->list->count += 2;
    btg_net half[2];
    btg_net_split(net, along_u, &half[0], &half[1]);
    for (int i = 0; i < 2; i++)
        btg_net_tile(&half[i], build->scale, &build->list->tiles[child + (uint32_t)i]);
    build->list->tiles[at].child = child | (along_u ? 0 : BTG_TILE_SPLIT_V);
    for (int i = 0; i < 2 && !status; i++)
        status = grow(build, &half[i], child + (uint32_t)i, in_u + along_u, in_v + !along_u);
    return status;
}

btg_status btg_tree_add_patch(const btg_allocator *allocator, const btg_net *net, double scale,
                              btg_tile_list *list, uint32_t *root, uint32_t *depth,
                              double third[4]) {
    /* Child 0 means leaf, so tile 0 is never a child: the first patch's root. */
    btg_status status = reserve(allocator, list, 1);
    if (status) return status;
    *root = list->count++;
    btg_net_tile(net, scale, &list->tiles[*root]);
    double smallest = TILE_SMALLEST * tile_size(&list->tiles[*root]);
    tile_build build = {allocator, scale, smallest, list, *depth, third};
    status = grow(&build, net, *root, 0, 0);
    *depth = build.depth;
    return status;
}

/* ---- boxes -------------------------------------------------------------------------------- */

typedef struct box {
    double low[3], high[3];
} box;

static void box_empty(box *b) {
    for (int k = 0; k < 3; k++) {
        b->low[k] = INFINITY;
        b->high[k] = -INFINITY;
    }
}

static void box_add(box *b, const box *c) {
    for (int k = 0; k < 3; k++) {
        b->low[k] = fmin(b->low[k], c->low[k]);
        b->high[k] = fmax(b->high[k], c->high[k]);
    }
}

static void triangle_box(const btg_part *part, uint32_t triangle, box *b) {
    btg_vec3 corner[3];
    btg_triangle_corners(part, triangle, corner);
    box_empty(b);
    for (int i = 0; i < 3; i++) {
        box p = {{corner[i].x, corner[i].y, corner[i].z}, {corner[i].x, corner[i].y, corner[i].z}};
        box_add(b, &p);
    }
}

/* A patch lies within its control points. */
static void patch_box(const btg_part *part, uint32_t patch, box *b) {
    const btg_patch *p = &part->patches[patch];
    int count = (p->degree_u + 1) * (p->degree_v + 1);
    box_empty(b);
    for (int i = 0; i < count; i++) {
        const double *c = p->coefficients + 4 * i;
        double w = c[3], slack = 1e-14 * part->scale;
        box q;
        for (int k = 0; k < 3; k++) {
            q.low[k] = c[k] / w - slack;
            q.high[k] = c[k] / w + slack;
        }
        box_add(b, &q);
    }
}

static void item_box(const btg_part *part, uint32_t item, box *b) {
    if (item < part->patch_count)
        patch_box(part, item, b);
    else
        triangle_box(part, item - part->patch_count, b);
}

static double item_middle(const btg_part *part, uint32_t item, int axis) {
    box b;
    item_box(part, item, &b);
    return b.low[axis] + b.high[axis];
}

static void set_node(btg_box_node *node, const box *b) {
    for (int k = 0; k < 3; k++) {
        float centre = (float)(0.5 * (b->low[k] + b->high[k]));
        double half = fmax(b->high[k] - (double)centre, (double)centre - b->low[k]);
        float h = (float)half;
        node->centre[k] = centre;
        node->half[k] = h < half ? nextafterf(h, INFINITY) : h;
    }
}

/* Items and the key they are split by, side by side while the tree is built. */
typedef struct sort_item {
    double key;
    uint32_t item;
} sort_item;

static void swap_items(sort_item *a, sort_item *b) {
    sort_item t = *a;
    *a = *b;
    *b = t;
}

/* Puts the k smallest first: quickselect with three-way partition, the pivot's place scattered so
 * that no order of the input is a slow one. */
static void select_smallest(sort_item *s, size_t count, size_t k) {
    size_t low = 0, high = count - 1;
    uint64_t scatter = 0x9e3779b97f4a7c15u;
    while (low < high) {
        scatter = scatter * 6364136223846793005u + 1442695040888963407u;
        double pivot = s[low + (size_t)(scatter >> 33) % (high - low + 1)].key;
        size_t below = low, i = low, above = high + 1;
        while (i < above) {
            if (s[i].key < pivot)
                swap_items(&s[below++], &s[i++]);
            else if (s[i].key > pivot)
                swap_items(&s[--above], &s[i]);
            else
                i++;
        }
        if (k < below)
            high = below - 1;
        else if (k >= above)
            low = above;
        else
            return;
    }
}

typedef struct box_build {
    btg_part *part;
    sort_item *scratch;
} box_build;

static void build_node(box_build *build, uint32_t at, uint32_t first, uint32_t count,
                       uint32_t level) {
    btg_part *part = build->part;
    if (level > part->node_depth) part->node_depth = level;
    box all;
    box_empty(&all);
    for (uint32_t i = first; i < first + count; i++) {
        box b;
        item_box(part, part->items[i], &b);
        box_add(&all, &b);
    }
    btg_box_node *node = &part->nodes[at];
    set_node(node, &all);
    bool has_patch = false;
    for (uint32_t i = first; i < first + count && count <= ITEMS_A_LEAF; i++)
        has_patch |= part->items[i] < part->patch_count;
    if (count == 1 || (count <= ITEMS_A_LEAF && !has_patch)) {
        node->first = first;
        node->count = count;
        return;
    }
    int axis = 0;
    for (int k = 1; k < 3; k++)
        if (all.high[k] - all.low[k] > all.high[axis] - all.low[axis]) axis = k;
    sort_item *s = build->scratch + first;
    for (uint32_t i = 0; i < count; i++) {
        s[i].item = part->items[first + i];
        s[i].key = item_middle(part, s[i].item, axis);
    }
    uint32_t half = count / 2;
    select_smallest(s, count, half);
    for (uint32_t i = 0; i < count; i++)
        part->items[first + i] = s[i].item;
    uint32_t child = part->node_count;
    part->node_count += 2;
    node->first = child;
    node->count = 0;
    build_node(build, child, first, half, level + 1);
    build_node(build, child + 1, first + half, count - half, level + 1);
}

btg_status btg_tree_build_boxes(btg_part *part) {
    uint32_t count = part->patch_count + part->triangle_count;
    part->items = btg_allocate(&part->allocator, count, sizeof *part->items);
    part->nodes = btg_allocate(&part->allocator, 2 * (size_t)count, sizeof *part->nodes);
    sort_item *scratch = btg_allocate(&part->allocator, count, sizeof *scratch);
    btg_status status = part->items && part->nodes && scratch ? BTG_OK : BTG_ERROR_MEMORY;
    if (!status) {
        for (uint32_t i = 0; i < count; i++)
            part->items[i] = i;
        box_build build = {part, scratch};
        part->node_count = 1;
        build_node(&build, 0, 0, count, 0);
    }
    btg_release(&part->allocator, scratch);
    return status;
}
