/* Pieces of the part side by side, and bounds of their distance to a tool. Internal. */
#ifndef BTG_CORE_BLOCK_H
#define BTG_CORE_BLOCK_H

#include "core/ray.h"
#include "core/part.h"

/* Bounds of third derivatives are this at the least, mm: subnormal numbers take a processor's long
 * way. */
#define BTG_THIRD_MIN 1e-30f

/* A piece of a patch: parameters u +- hu, v +- hv. */
typedef struct btg_piece {
    double u, v, hu, hv;
    float third[4];    /* bounds of its third derivatives, in units of half sides (part.h) */
    uint32_t item;     /* patch */
    uint32_t quarters; /* stored; 0: none */
    btg_cut cut;       /* how it is cut */
} btg_piece;

/* Pieces that are cut at a time. */
#define BTG_PIECES (BTG_BLOCK / 4)

/* The quarters of up to BTG_PIECES pieces, four by four; of the first, piece k is
 *     s + su a + sv b + (suu a^2 + 2 suv a b + svv b^2) / 2,    |a|, |b| <= 1,
 * up to error[k]; without the last term, up to bend[k]. Of triangles it is the half of that where
 * a + b <= 0. Instead of quarters it may hold whole triangles, or children of tree nodes: then the
 * fields from item on mean nothing. */
typedef struct btg_block {
    uint32_t count;       /* pieces, the first ones */
    bool triangles;       /* of triangles all */
    unsigned turned;      /* bits: quarters of triangles that are upside down */
    btg_surface_block at; /* in units of half sides */
    BTG_ALIGNED double error[BTG_BLOCK], bend[BTG_BLOCK];
    double radius[BTG_BLOCK]; /* of a ball about s that holds the piece */
    double u[BTG_BLOCK], v[BTG_BLOCK], hu[BTG_BLOCK], hv[BTG_BLOCK]; /* its parameters' box */
    double side_u2[BTG_BLOCK], side_v2[BTG_BLOCK]; /* squares of half lengths along u and v, bends
                                                      and errors included; of patches */
    uint32_t item[BTG_BLOCK];
    btg_piece whole[BTG_PIECES]; /* of patches: what was cut */
} btg_block;

/* Room for what the bounds leave from one stage to the next. */
typedef struct btg_block_room {
    BTG_ALIGNED double of[44][BTG_BLOCK];
} btg_block_room;

/* Distances of a block's pieces to a round element as placed. Bits: 1 << k for piece k. */
typedef struct btg_block_bound {
    BTG_ALIGNED double distance[BTG_BLOCK]; /* of the centre */
    double height[BTG_BLOCK]; /* of the centre above the element's ring, along the axis */
    double top[BTG_BLOCK];    /* no point of the piece is higher than that */
    double low[BTG_BLOCK];    /* no point of the piece is nearer than that */
    double form[BTG_BLOCK];   /* the same by its quadratic form alone, third-order error and all */
    double least[BTG_BLOCK];  /* it comes about as near as that, and where: */
    double s[BTG_BLOCK], t[BTG_BLOCK];
    unsigned deep; /* bits: low < enough */
    unsigned tail; /* bits of patches: form < enough for its third-order error alone */
    unsigned high; /* bits: top > 0 */
    btg_block_room room;
} btg_block_bound;

/* Bits of all pieces. */
static inline unsigned btg_block_bits(const btg_block *block) {
    return (1u << block->count) - 1;
}

/* Number of the lowest bit that is set; bits is not 0. */
static inline int btg_lowest_bit(unsigned bits) {
#if defined(__GNUC__)
    return __builtin_ctz(bits);
#else
    int k = 0;
    for (; !(bits & 1); bits >>= 1)
        k++;
    return k;
#endif
}

/* The patch as one piece. */
void btg_piece_root(const btg_part *part, uint32_t item, btg_piece *piece);

/* How a piece is best cut: across its longer side, bend included. */
btg_cut btg_piece_cut(const btg_part *part, const btg_piece *piece);

/* Cuts up to BTG_PIECES pieces into four each: all of patches or all of triangles. */
void btg_block_make(const btg_part *part, const btg_piece *const piece[], uint32_t pieces,
                    btg_block *block);

/* The four children of each of up to BTG_PIECES tree nodes; those that are none repeat the first.
 */
void btg_block_of_nodes(const btg_node *const node[], uint32_t nodes, btg_block *block);

/* Up to BTG_BLOCK whole triangles. */
void btg_block_of_triangles(const btg_part *part, const uint32_t *triangles, uint32_t count,
                            btg_block *block);

/* Where a and b lead in piece k, and the piece by itself. */
btg_place btg_block_place(const btg_block *block, int k, double a, double b);
void btg_block_quarter(const btg_part *part, const btg_block *block, int k, btg_piece *piece);

/* Bounds for an element with a round corner. Where no piece's ball comes nearer than `enough`,
 * low is the balls' alone and least the centres'. */
void btg_block_bounds(const btg_block *block, const btg_tool_element *element,
                      const btg_placement *placement, double enough, btg_block_bound *bound);

/* Bits of the pieces of an item all of whose parameters are within `reach` of (u, v), measured by
 * the speeds. */
unsigned btg_block_about(const btg_block *block, btg_place about, double speed_u, double speed_v,
                         double reach);

/* Bits of the pieces whose balls are no larger than that. */
unsigned btg_block_small(const btg_block *block, double radius);

/* Bits of the pieces whose balls, `gap` wider, hold a point. */
unsigned btg_block_near(const btg_block *block, btg_vec3 point, double gap);

/* The gradient of those distances at piece k's centre, unit. */
btg_vec3 btg_block_normal(const btg_block *block, int k, const btg_tool_element *element,
                          const btg_placement *placement);

static ALWAYS_INLINE lanes btg_block_dot(lanes3 a, btg_vec3 b) {
    return lanes3_dot(a, (lanes3){lanes_all(b.x), lanes_all(b.y), lanes_all(b.z)});
}

static inline btg_vec3 btg_block_vector(const lanes3_memory *a, int k) {
    return vec(a->at[0][k], a->at[1][k], a->at[2][k]);
}

#endif
