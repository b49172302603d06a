/* What a part is made of, for the search and the back ends. Internal. */
#ifndef BTG_CORE_PART_H
#define BTG_CORE_PART_H

#include "core/lanes.h"
#include "core/vec.h"

#define BTG_ORDER_MAX (BTG_DEGREE_MAX + 1)

/* A Bezier patch, one piece of a given surface. Points are (w x, w y, w z, w), v fastest; w is 1
 * unless rational. */
typedef struct btg_patch {
    const double *coefficients; /* Bezier net: (degree_u + 1) (degree_v + 1) points */
    const double *power; /* the same of W (S - origin), as a polynomial in u - 1/2, v - 1/2 */
    btg_vec3 origin;
    double rounding;  /* of an evaluated point, at most, mm */
    double third[4];  /* bounds of |Suuu|, |Suuv|, |Suvv|, |Svvv| over the patch */
    uint32_t quarter; /* its quarters, index into quarters; 0: none are stored */
    uint8_t degree_u, degree_v;
    uint8_t cut; /* btg_cut of its quarters */
    bool rational;
    uint32_t surface;                /* index of the surface it was cut from */
    double domain_u[2], domain_v[2]; /* its piece of that surface's domain */
} btg_patch;

/* How a piece of a patch is cut into four. */
typedef enum btg_cut { BTG_CUT_BOTH, BTG_CUT_U, BTG_CUT_V } btg_cut;

/* Four pieces that one piece of a patch is cut into: what cannot be had by evaluating. */
typedef struct btg_quarters {
    float third[4][4]; /* bounds of the third derivatives over piece [..][k], in units of its half
                          sides: |Suuu| hu^3, |Suuv| hu^2 hv, ..., mm; rounded up */
    uint32_t child[4]; /* its quarters; 0: none are stored */
    uint8_t cut[4];    /* btg_cut of those */
} btg_quarters;

/* What a child of a tree node is. */
typedef enum btg_child {
    BTG_CHILD_NONE,
    BTG_CHILD_NODE,     /* index into nodes */
    BTG_CHILD_PIECE,    /* index into pieces */
    BTG_CHILD_TRIANGLES /* first of some triangles in order */
} btg_child;

#define BTG_LEAF_TRIANGLES 8

/* A node of the tree over pieces of patches and triangles: four quadratic sheets (sheet.h) side by
 * side, rounded outward; those that are no child repeat the first. */
typedef struct btg_node {
    float centre[3][4], a[3][4], b[3][4], uu[3][4], uv[3][4], vv[3][4];
    float error[4], bend[4], radius[4]; /* as of a block (block.h) */
    uint32_t child[4];
    uint8_t kind[4];  /* btg_child */
    uint8_t count[4]; /* triangles */
} btg_node;

#define BTG_NODE_NONE UINT32_MAX

struct btg_part {
    btg_allocator allocator;
    btg_part_info info;
    double scale; /* largest coordinate, mm: the rounding error of a point is a few 1e-16 of it */

    uint32_t patch_count, triangle_count;
    btg_patch *patches;
    double *coefficients; /* nets, then power forms */
    btg_quarters *quarters;
    uint32_t quarters_count;

    btg_vec3 *vertices;
    uint32_t (*triangles)[3];

    struct btg_piece *pieces; /* of patches, that the tree stands on (block.h) */
    uint32_t piece_count;

    btg_node *nodes;
    uint32_t node_count;
    uint32_t root[2];                    /* over pieces, over triangles; BTG_NODE_NONE */
    uint32_t node_depth, quarters_depth; /* bound the search's stack */
    uint32_t *order;                     /* triangles as the tree's leaves name them */
};

/* A checked allocation through the part's allocator: NULL when count * size overflows. */
void *btg_allocate(const btg_allocator *allocator, size_t count, size_t size);
void btg_release(const btg_allocator *allocator, void *memory);
/* What is left of an array when its first `count` are: in place where that may be. NULL: no memory
 * for it; then the array stays as it is. */
void *btg_shrink(const btg_allocator *allocator, void *memory, size_t count, size_t size);

/* Writes `text` (printf) into message, when that is not NULL. Returns status. */
btg_status btg_fail(btg_message *message, btg_status status, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 3, 4)))
#endif
    ;

/* ---- evaluate.c, surface.c ---------------------------------------------------------------- */

/* Point and derivatives of a patch; u, v in 0..1. */
void btg_patch_evaluate(const btg_patch *patch, double u, double v, btg_surface_point *point);
/* The same side by side: `fours` times four places, each four on its patch. Of the others something
 * is written, too, which must be no trap: all of u and v hold numbers. */
typedef struct btg_surface_block {
    lanes3_memory s, su, sv, suu, suv, svv;
} btg_surface_block;
void btg_patch_evaluate_block(const btg_patch *const patch[], int fours, const double u[BTG_BLOCK],
                              const double v[BTG_BLOCK], btg_surface_block *out);
/* Point alone, from the Bezier net: another way to the same. */
btg_vec3 btg_patch_point(const btg_patch *patch, double u, double v);

/* ---- part.c ------------------------------------------------------------------------------- */

static inline void btg_triangle_corners(const btg_part *part, uint32_t triangle,
                                        btg_vec3 corner[3]) {
    for (int i = 0; i < 3; i++)
        corner[i] = part->vertices[part->triangles[triangle][i]];
}

/* Point and derivatives at any item; u, v are not checked. */
void btg_part_point(const btg_part *part, btg_place place, btg_surface_point *point);

#endif
