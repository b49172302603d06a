/* The search tree: pieces of patches and triangles put in Morton order, and cut where the highest
 * bits of their codes differ, four ways a node. */
#include "core/sheet.h"
#include "core/tree.h"

#include <string.h>

/* Patches are cut into pieces, down to this depth, until their bend is this part of their size.
 * What stands in nodes need not be evaluated. */
#define PIECE_DEPTH 4
#define PIECE_BEND  0.015

/* Triangles for every node, about. */
#define NODE_TRIANGLES 8

/* Morton codes: bits a coordinate, and bits sorted at a time. */
#define CODE_BITS  16
#define DIGIT_BITS 12
#define DIGITS     4

typedef struct coded {
    uint64_t code;
    uint32_t item;
} coded;

typedef struct tree_build {
    btg_part *part;
    coded *item;
    uint32_t node_capacity, node_guess;
    bool triangles; /* else pieces */
    btg_status status;
} tree_build;

/* ---- pieces ------------------------------------------------------------------------------- */

static bool flat_enough(const btg_part *part, const btg_piece *piece) {
    btg_sheet s;
    btg_sheet_of_piece(part, piece, &s);
    double bend = 0.5 * (vec_norm(s.uu) + vec_norm(s.vv)) + vec_norm(s.uv) + s.error;
    return bend <= PIECE_BEND * (vec_norm(s.a) + vec_norm(s.b));
}

/* Pieces of one patch: counted, and kept where `out` is not NULL. */
static uint32_t cut_patch(const btg_part *part, const btg_piece *piece, int depth, btg_piece *out) {
    if (depth == PIECE_DEPTH || flat_enough(part, piece)) {
        if (out) *out = *piece;
        return 1;
    }
    btg_block block;
    btg_piece quarter;
    uint32_t count = 0;
    btg_block_make(part, &piece, 1, &block);
    for (int k = 0; k < 4; k++) {
        btg_block_quarter(part, &block, k, &quarter);
        count += cut_patch(part, &quarter, depth + 1, out ? out + count : NULL);
    }
    return count;
}

static btg_status make_pieces(btg_part *part) {
    size_t count = 0;
    btg_piece root;
    for (uint32_t i = 0; i < part->patch_count; i++) {
        btg_piece_root(part, i, &root);
        count += cut_patch(part, &root, 0, NULL);
    }
    if (count > UINT32_MAX / 2) return BTG_ERROR_MEMORY;
    part->pieces = btg_allocate(&part->allocator, count, sizeof *part->pieces);
    if (!part->pieces && count) return BTG_ERROR_MEMORY;
    for (uint32_t i = 0; i < part->patch_count; i++) {
        btg_piece_root(part, i, &root);
        part->piece_count += cut_patch(part, &root, 0, part->pieces + part->piece_count);
    }
    return BTG_OK;
}

/* ---- order -------------------------------------------------------------------------------- */

static btg_vec3 middle(const tree_build *build, uint32_t item) {
    const btg_part *part = build->part;
    if (build->triangles) {
        btg_vec3 c[3];
        btg_triangle_corners(part, item, c);
        return vec_scale(vec_add(c[0], vec_add(c[1], c[2])), 1.0 / 3);
    }
    const btg_piece *p = &part->pieces[item];
    btg_surface_point s;
    btg_patch_evaluate(&part->patches[p->item], p->u, p->v, &s);
    return s.s;
}

/* Bits apart by two zeros each. */
static uint64_t spread(double x) {
    uint64_t b = (uint64_t)x;
    b = (b | b << 16) & 0x0000ff0000ffu;
    b = (b | b << 8) & 0x00f00f00f00fu;
    b = (b | b << 4) & 0x0c30c30c30c3u;
    return (b | b << 2) & 0x249249249249u;
}

static void set_codes(tree_build *build, uint32_t count) {
    btg_vec3 low = vec(INFINITY, INFINITY, INFINITY), high = vec_scale(low, -1);
    for (uint32_t i = 0; i < count; i++) {
        btg_vec3 p = middle(build, i);
        low = vec(min2(low.x, p.x), min2(low.y, p.y), min2(low.z, p.z));
        high = vec(max2(high.x, p.x), max2(high.y, p.y), max2(high.z, p.z));
    }
    btg_vec3 size = vec_sub(high, low);
    double widest = max2(size.x, max2(size.y, size.z)), cells = (1 << CODE_BITS) - 1;
    double k = widest > 0 ? cells / widest : 0;
    for (uint32_t i = 0; i < count; i++) {
        btg_vec3 p = vec_scale(vec_sub(middle(build, i), low), k);
        build->item[i].code = spread(p.x) << 2 | spread(p.y) << 1 | spread(p.z);
        build->item[i].item = i;
    }
}

/* Least digit first; the order of equal codes stays. */
static void sort_codes(coded *item, coded *other, uint32_t count) {
    enum { VALUES = 1 << DIGIT_BITS };
    for (int digit = 0; digit < DIGITS; digit++) {
        uint32_t at[VALUES] = {0}, sum = 0;
        int shift = digit * DIGIT_BITS;
        for (uint32_t i = 0; i < count; i++)
            at[item[i].code >> shift & (VALUES - 1)]++;
        for (int k = 0; k < VALUES; k++) {
            uint32_t n = at[k];
            at[k] = sum;
            sum += n;
        }
        for (uint32_t i = 0; i < count; i++)
            other[at[item[i].code >> shift & (VALUES - 1)]++] = item[i];
        coded *t = item;
        item = other;
        other = t;
    }
}

/* ---- nodes -------------------------------------------------------------------------------- */

/* Where a range of codes is cut: at their highest differing bit; equal ones in the middle. */
static uint32_t cut_range(const coded *item, uint32_t first, uint32_t count) {
    uint64_t low = item[first].code, high = item[first + count - 1].code, differ = low ^ high;
    if (differ == 0) return count / 2;
    int bit = 0;
    while (differ >>= 1)
        bit++;
    uint32_t a = 0, b = count; /* the bit is 0 below a, 1 from b on */
    while (a < b) {
        uint32_t mid = a + (b - a) / 2;
        if (item[first + mid].code >> bit & 1)
            b = mid;
        else
            a = mid + 1;
    }
    return a;
}

static bool is_leaf(const tree_build *build, uint32_t count) {
    return count <= (build->triangles ? BTG_LEAF_TRIANGLES : 1);
}

static uint32_t new_node(tree_build *build) {
    btg_part *part = build->part;
    if (part->node_count == build->node_capacity) {
        uint32_t capacity = build->node_capacity ? 2 * build->node_capacity : build->node_guess;
        btg_node *nodes = btg_allocate(&part->allocator, capacity, sizeof *nodes);
        if (!nodes) {
            build->status = BTG_ERROR_MEMORY;
            return BTG_NODE_NONE;
        }
        if (part->nodes) memcpy(nodes, part->nodes, part->node_count * sizeof *nodes);
        btg_release(&part->allocator, part->nodes);
        part->nodes = nodes;
        build->node_capacity = capacity;
    }
    return part->node_count++;
}

static void set_vector(float to[3][4], int k, btg_vec3 v) {
    to[0][k] = (float)v.x;
    to[1][k] = (float)v.y;
    to[2][k] = (float)v.z;
}

static float float_above(double x) {
    return (float)(x * (1 + 2e-7)) + 1e-30f;
}

static void set_child(const btg_part *part, btg_node *node, int k, const btg_sheet *s) {
    double a = vec_norm(s->a), b = vec_norm(s->b), uv = vec_norm(s->uv);
    double bend = 0.5 * (vec_norm(s->uu) + vec_norm(s->vv)) + uv;
    set_vector(node->centre, k, s->centre);
    set_vector(node->a, k, s->a);
    set_vector(node->b, k, s->b);
    set_vector(node->uu, k, s->uu);
    set_vector(node->uv, k, s->uv);
    set_vector(node->vv, k, s->vv);
    /* floats are off by half a unit in the last place, along each of three axes */
    double error = s->error + 1.1e-7 * (part->scale + a + b + bend);
    node->error[k] = float_above(error);
    node->bend[k] = float_above(bend + error);
    node->radius[k] = float_above(s->radius + (error - s->error));
}

static void build_node(tree_build *build, uint32_t at, uint32_t first, uint32_t count,
                       uint32_t level, btg_sheet *whole);

/* One child of a node, and its sheet. */
static void build_child(tree_build *build, uint32_t at, int k, uint32_t first, uint32_t count,
                        uint32_t level, btg_sheet *sheet) {
    btg_part *part = build->part;
    uint32_t child = first;
    btg_child kind = build->triangles ? BTG_CHILD_TRIANGLES : BTG_CHILD_PIECE;
    if (!is_leaf(build, count)) {
        kind = BTG_CHILD_NODE;
        child = new_node(build);
        if (build->status) return;
        build_node(build, child, first, count, level + 1, sheet);
    } else if (build->triangles) {
        btg_sheet_of_triangles(part, part->order + first, count, sheet);
    } else {
        child = build->item[first].item;
        btg_sheet_of_piece(part, &part->pieces[child], sheet);
    }
    btg_node *node = &part->nodes[at];
    node->child[k] = child;
    node->kind[k] = (uint8_t)kind;
    node->count[k] = (uint8_t)(kind == BTG_CHILD_TRIANGLES ? count : 0);
    set_child(part, node, k, sheet);
}

static void build_node(tree_build *build, uint32_t at, uint32_t first, uint32_t count,
                       uint32_t level, btg_sheet *whole) {
    btg_part *part = build->part;
    uint32_t start[5] = {first, 0}, n = 1;
    btg_sheet child[4];
    if (level + 1 > part->node_depth) part->node_depth = level + 1;
    start[1] = first + count;
    for (int round = 0; round < 2; round++) /* every range that is no leaf in two, twice */
        for (uint32_t i = 0; i < n && n < 4; i++) {
            uint32_t size = start[i + 1] - start[i];
            if (is_leaf(build, size)) continue;
            memmove(&start[i + 2], &start[i + 1], (n - i) * sizeof *start);
            start[i + 1] = start[i] + cut_range(build->item, start[i], size);
            n++;
            i++;
        }
    for (uint32_t k = 0; k < n && !build->status; k++)
        build_child(build, at, (int)k, start[k], start[k + 1] - start[k], level, &child[k]);
    if (build->status) return;
    btg_node *node = &part->nodes[at];
    for (uint32_t k = n; k < 4; k++) {
        set_child(part, node, (int)k, &child[0]);
        node->kind[k] = BTG_CHILD_NONE;
        node->child[k] = node->count[k] = 0;
    }
    if (n == 1)
        *whole = child[0];
    else
        btg_sheet_merge(child, (int)n, whole);
}

static btg_status build_over(btg_part *part, tree_build *build, uint32_t count, uint32_t *root) {
    *root = BTG_NODE_NONE;
    if (count == 0) return BTG_OK;
    const btg_allocator *allocator = &part->allocator;
    coded *item = btg_allocate(allocator, count, sizeof *item);
    coded *other = btg_allocate(allocator, count, sizeof *other);
    if (item && other) {
        build->item = item;
        set_codes(build, count);
        sort_codes(item, other, count);
        for (uint32_t i = 0; build->triangles && i < count; i++)
            part->order[i] = item[i].item;
        *root = new_node(build);
        btg_sheet whole;
        if (!build->status) build_node(build, *root, 0, count, 0, &whole);
    } else {
        build->status = BTG_ERROR_MEMORY;
    }
    btg_release(allocator, item);
    btg_release(allocator, other);
    return build->status;
}

/* Gives back what the nodes' array has too much. */
static btg_status trim(btg_part *part) {
    btg_node *nodes =
        btg_shrink(&part->allocator, part->nodes, part->node_count, sizeof *part->nodes);
    if (!nodes) return BTG_ERROR_MEMORY;
    part->nodes = nodes;
    return BTG_OK;
}

btg_status btg_tree_build(btg_part *part) {
    btg_status status = make_pieces(part);
    if (status) return status;
    part->order = btg_allocate(&part->allocator, part->triangle_count, sizeof *part->order);
    if (!part->order && part->triangle_count) return BTG_ERROR_MEMORY;
    /* Memory that is not needed is not touched, and given back. */
    uint32_t guess = 32 + part->piece_count / 2 + part->triangle_count / NODE_TRIANGLES;
    tree_build build = {.part = part, .node_guess = guess};
    status = build_over(part, &build, part->piece_count, &part->root[0]);
    build.triangles = true;
    if (!status) status = build_over(part, &build, part->triangle_count, &part->root[1]);
    return status ? status : trim(part);
}
