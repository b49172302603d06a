/* What a part is made of, for the search and the back ends. Internal. */
#ifndef BTG_CORE_PART_H
#define BTG_CORE_PART_H

#include "core/vec.h"

/* A Bezier patch, one piece of a given surface. Coefficients: (degree_u + 1) * (degree_v + 1)
 * points (w x, w y, w z, w), v fastest; w is 1 unless rational. */
typedef struct btg_patch {
    const double *coefficients;
    uint8_t degree_u, degree_v;
    bool rational;
    uint32_t surface;                /* index of the surface it was cut from */
    double domain_u[2], domain_v[2]; /* its piece of that surface's domain */
    double third[4];                 /* bounds of |Suuu|, |Suuv|, |Suvv|, |Svvv| over the patch */
} btg_patch;

/* A node of a patch's own binary tree: the sub-patch is centre + a s + b t, |s|, |t| <= 1, up to
 * an error of at most bend_uu + bend_uv + bend_vv. Halving a side divides a or b by 2, and the
 * bends by 4, 2 or 1. */
typedef struct btg_tile {
    btg_vec3 centre;
    float a[3], b[3];
    float bend_uu, bend_uv, bend_vv; /* rounded up, rounding of centre, a and b included */
    uint32_t child; /* index of the first of two children; 0: a leaf. BTG_TILE_SPLIT_V is set when
                       they are halves in v */
} btg_tile;

#define BTG_TILE_SPLIT_V 0x80000000u
#define BTG_TILE_CHILD   0x7fffffffu

/* A node of the tree over patches and triangles: an axis-parallel box, rounded outward. */
typedef struct btg_box_node {
    float centre[3], half[3];
    uint32_t first; /* inner: index of the first of two children; leaf: first entry of `items` */
    uint32_t count; /* 0: inner; else number of items */
} btg_box_node;

struct btg_part {
    btg_allocator allocator;
    btg_part_info info;
    double scale; /* largest coordinate, mm: the rounding error of a point is a few 1e-16 of it */

    uint32_t patch_count, triangle_count;
    btg_patch *patches;
    uint32_t *patch_root; /* index into tiles, one a patch */
    double *coefficients;
    btg_tile *tiles;
    uint32_t tile_count;

    btg_vec3 *vertices;
    uint32_t (*triangles)[3];

    btg_box_node *nodes;
    uint32_t node_count, node_depth, tile_depth; /* depths bound the search's stack */
    uint32_t *items; /* patches first (index < patch_count), then triangles */
};

/* A checked allocation through the part's allocator: NULL when count * size overflows. */
void *btg_allocate(const btg_allocator *allocator, size_t count, size_t size);
void btg_release(const btg_allocator *allocator, void *memory);

/* Writes `text` (printf) into message, when that is not NULL. Returns status. */
btg_status btg_fail(btg_message *message, btg_status status, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 3, 4)))
#endif
    ;

/* ---- surface.c ---------------------------------------------------------------------------- */

/* Point and derivatives of a patch; u, v in 0..1. */
void btg_patch_evaluate(const btg_patch *patch, double u, double v, btg_surface_point *point);
/* Point alone: cheaper. */
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
