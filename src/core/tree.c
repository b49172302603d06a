/* Search trees: what bounds the pieces of each patch, and one binary tree of boxes over all patches
 * and triangles, split at the median so that its depth is bounded. */
#include "core/tree.h"
#include "core/block.h"

#include <string.h>

/* Pieces are stored while their third-order error is more than this part of their size and cutting
 * them tells more than that it falls with the cube; but not for ever where it never gets small, at
 * a collapsed edge for one. */
#define SMALL_ERROR    0.002
#define TELLS_MORE     0.7
#define QUARTERS_DEPTH 6
#define ITEMS_A_LEAF   4

/* ---- quarters ----------------------------------------------------------------------------- */

static btg_status reserve(const btg_allocator *allocator, btg_quarters_list *list) {
    if (list->count < list->capacity) return BTG_OK;
    if (list->count > UINT32_MAX / 4) return BTG_ERROR_MEMORY;
    uint32_t capacity = list->capacity < 64 ? 128 : 2 * list->capacity;
    btg_quarters *at = btg_allocate(allocator, capacity, sizeof *at);
    if (!at) return BTG_ERROR_MEMORY;
    if (list->at) memcpy(at, list->at, list->count * sizeof *at);
    btg_release(allocator, list->at);
    list->at = at;
    list->capacity = capacity;
    return BTG_OK;
}

static float round_up(double x) {
    float f = (float)x;
    return f < x ? nextafterf(f, INFINITY) : f;
}

static void quarter_nets(const btg_net *net, btg_cut cut, btg_net quarter[4]) {
    if (cut == BTG_CUT_BOTH) {
        btg_net low, high; /* in v, then in u: piece 1 is the one at high u and low v */
        btg_net_split(net, false, &low, &high);
        btg_net_split(&low, true, &quarter[0], &quarter[1]);
        btg_net_split(&high, true, &quarter[2], &quarter[3]);
        return;
    }
    btg_net low, high;
    btg_net_split(net, cut == BTG_CUT_U, &low, &high);
    btg_net_split(&low, cut == BTG_CUT_U, &quarter[0], &quarter[1]);
    btg_net_split(&high, cut == BTG_CUT_U, &quarter[2], &quarter[3]);
}

static double error_of(const float third[4]) {
    return ((double)third[0] + 3 * ((double)third[1] + (double)third[2]) + (double)third[3]) / 6;
}

typedef struct quarters_build {
    const btg_part *part;
    btg_quarters_list *list;
    uint32_t depth; /* reached */
} quarters_build;

/* Stores the quarters of a piece where they tell more than the piece does; *at is 0 where they do
 * not. */
static btg_status grow(quarters_build *build, const btg_net *net, const btg_piece *piece,
                       uint32_t level, uint32_t *at) {
    btg_block block;
    *at = 0;
    if (level >= QUARTERS_DEPTH) return BTG_OK;
    btg_block_make(build->part, piece, &block);
    btg_net quarter[4];
    quarter_nets(net, piece->cut, quarter);
    btg_piece piece_of[4];
    bool wanted = false;
    for (int k = 0; k < 4; k++) {
        btg_piece *q = &piece_of[k];
        btg_block_quarter(build->part, &block, k, q);
        double before = error_of(q->third), third[4] = {0, 0, 0, 0};
        btg_net_third(&quarter[k], third);
        for (int i = 0; i < 4; i++) {
            float own = round_up(0.125 * third[i]);
            if (own < q->third[i]) q->third[i] = own;
        }
        wanted |=
            before > SMALL_ERROR * block.radius[k] && error_of(q->third) < TELLS_MORE * before;
    }
    if (!wanted) return BTG_OK;
    btg_status status = reserve(&build->part->allocator, build->list);
    if (status) return status;
    *at = build->list->count++;
    if (level + 1 > build->depth) build->depth = level + 1;
    for (int k = 0; k < 4 && !status; k++) {
        uint32_t child;
        status = grow(build, &quarter[k], &piece_of[k], level + 1, &child);
        btg_quarters *q = &build->list->at[*at];
        q->child[k] = child;
        q->cut[k] = (uint8_t)piece_of[k].cut;
        for (int i = 0; i < 4; i++)
            q->third[i][k] = piece_of[k].third[i];
    }
    return status;
}

btg_status btg_tree_add_patch(const btg_part *part, const btg_net *net, uint32_t index,
                              btg_quarters_list *list, uint32_t *depth) {
    btg_patch *patch = &part->patches[index];
    if (list->count == 0) list->count = 1; /* 0 means none */
    btg_net_third(net, patch->third);
    btg_piece root;
    btg_piece_root(part, index, &root);
    root.cut = btg_piece_cut(part, &root);
    patch->cut = (uint8_t)root.cut;
    quarters_build build = {part, list, *depth};
    btg_status status = reserve(&part->allocator, list);
    if (!status) status = grow(&build, net, &root, 0, &patch->quarter);
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
