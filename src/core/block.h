/* Four pieces of a patch side by side, and bounds of their distance to a tool. Internal. */
#ifndef BTG_CORE_BLOCK_H
#define BTG_CORE_BLOCK_H

#include "core/ray.h"
#include "core/part.h"

/* A piece of a patch: parameters u +- hu, v +- hv. */
typedef struct btg_piece {
    double u, v, hu, hv;
    float third[4];    /* bounds of its third derivatives, in units of half sides (part.h) */
    uint32_t item;     /* patch */
    uint32_t quarters; /* stored; 0: none */
    btg_cut cut;       /* how it is cut */
} btg_piece;

/* The four quarters of a piece: quarter k is
 *     s + su a + sv b + (suu a^2 + 2 suv a b + svv b^2) / 2,    |a|, |b| <= 1,
 * up to error[k]; without the last term, up to bend[k]. */
typedef struct btg_block {
    btg_surface_four at;                 /* in units of half sides */
    double error[4], bend[4], radius[4]; /* radius of a ball about s that holds it */
    double u[4], v[4], hu, hv;
    double side_u[4], side_v[4]; /* half lengths along u and v, bends and errors included */
    btg_piece whole;
} btg_block;

/* Distances of a block's pieces to a round element as placed. */
typedef struct btg_block_bound {
    double distance[4]; /* of the centre */
    double height[4];   /* of the centre above the element's ring, along the axis */
    double top[4];      /* no point of the piece is higher than that */
    double low[4];      /* no point of the piece is nearer than that */
    double form[4];     /* the same by its quadratic form alone, third-order error and all */
    double least[4];    /* it comes about as near as that, and where: */
    double s[4], t[4];
} btg_block_bound;

/* The patch as one piece. */
void btg_piece_root(const btg_part *part, uint32_t item, btg_piece *piece);

/* How a piece is best cut: across its longer side, bend included. */
btg_cut btg_piece_cut(const btg_part *part, const btg_piece *piece);

/* Cuts a piece into four. */
void btg_block_make(const btg_part *part, const btg_piece *piece, btg_block *block);

/* The four children of a tree node; of the block's fields only the first four. */
void btg_block_of_node(const btg_node *node, btg_block *block);

/* Triangles, one to four, each as the parallelogram it is half of; fields as of a node. */
void btg_block_of_triangles(const btg_part *part, const uint32_t *triangles, uint32_t count,
                            btg_block *block);

/* Quarter k by itself. */
void btg_block_quarter(const btg_part *part, const btg_block *block, int k, btg_piece *piece);

/* Bounds for an element with a round corner. Where no piece's ball comes nearer than `enough`,
 * low is the balls' alone and least the centres'. */
void btg_block_bounds(const btg_block *block, const btg_tool_element *element,
                      const btg_placement *placement, double enough, btg_block_bound *bound);

/* The gradient of those distances at piece k's centre, unit. */
btg_vec3 btg_block_normal(const btg_block *block, int k, const btg_tool_element *element,
                          const btg_placement *placement);

static inline btg_vec3 btg_block_vector(const lanes3_memory *a, int k) {
    return vec(a->at[0][k], a->at[1][k], a->at[2][k]);
}

#endif
