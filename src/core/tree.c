/* What bounds the quarters of each patch. The tree over the pieces is in tree_nodes.c. */
#include "core/tree.h"
#include "core/block.h"

#include <string.h>

/* Pieces are stored while their third-order error is more than this part of their size and cutting
 * them tells more than that it falls with the cube; but not for ever where it never gets small, at
 * a collapsed edge for one. */
#define SMALL_ERROR    0.002
#define TELLS_MORE     0.7
#define QUARTERS_DEPTH 6

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
    btg_block_make(build->part, &piece, 1, &block);
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
            float own = round_up(max2(0.125 * third[i], (double)BTG_THIRD_MIN));
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
