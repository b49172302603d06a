/* A part as triangles with normals: what screens and files of triangles show of exact surfaces.
 * Internal; set-up only. */
#ifndef BTG_CORE_FACETS_H
#define BTG_CORE_FACETS_H

#include "core/part.h"

#define BTG_FACETS_SIDE_MAX 256 /* cells along u or v of one patch */

typedef struct btg_facets_def {
    double chord_mm;      /* > 0: how far a facet may be from its surface, about; patches that need
                             more than BTG_FACETS_SIDE_MAX cells a side stay coarser */
    size_t triangles_max; /* 0: any number; more than this is refused */
    btg_allocator allocator;
} btg_facets_def;

/* Part frame, mm. Vertices of a patch lie on it, in a grid, each with the surface's unit normal;
 * those of a mesh's triangle are its own, with its normal. Where neither surface nor triangle has a
 * normal it is +z. Orientation is the item's own: normals may point to either side. */
typedef struct btg_facets {
    size_t vertex_count, triangle_count;
    btg_vec3 *points, *normals;
    uint32_t (*triangles)[3];
    btg_allocator allocator;
} btg_facets;

/* *facets is untouched on error. ERROR_ARGUMENT (chord not positive and finite), ERROR_MEMORY (or
 * more triangles than def->triangles_max, or than 32-bit numbers of vertices reach). */
btg_status btg_facets_make(const btg_part *part, const btg_facets_def *def, btg_facets *facets,
                           btg_message *message);
void btg_facets_free(btg_facets *facets); /* a zeroed one is fine */

#endif
