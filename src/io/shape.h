/* Triangles to look at: of a part, and of a tool. Internal to the program. */
#ifndef BTG_IO_SHAPE_H
#define BTG_IO_SHAPE_H

#include "bitangent/bitangent.h"

#include <stdbool.h>

/* mm, right-handed; triangles counter-clockwise seen from where the normals point. */
typedef struct btg_shape {
    float *points, *normals; /* 3 a point; normals unit */
    uint32_t *indices;       /* 3 a triangle */
    size_t point_count, index_count;
    size_t point_room, index_room;
    bool short_of_memory; /* latched: what is there is not all */
} btg_shape;

/* What a solid of revolution stands for, for its colour. */
typedef enum btg_solid { BTG_SOLID_INSERT, BTG_SOLID_SHANK, BTG_SOLID_HOLDER } btg_solid;

/* The part's facets, outward or, of an open sheet, upward; surfaces stray by 1e-4 of its size, or
 * by more where that takes over `most` triangles. Adds to `shape`, zeroed at first. ERROR_MEMORY,
 * also when its own triangles are more than that. */
btg_status btg_shape_part(btg_shape *shape, const btg_part *part, size_t most,
                          btg_message *message);

/* Element `index` of the tool, tip at the origin, axis +z. A cutter reaches up to its torus
 * centre, a hollow one is the ring. */
btg_status btg_shape_tool(btg_shape *shape, const btg_tool *tool, uint32_t index);
btg_solid btg_shape_solid(const btg_tool *tool, uint32_t index);
/* What carries a cutter that has no shank: a rod that collides with nothing, for the eye. */
btg_status btg_shape_rod(btg_shape *shape, const btg_tool *tool, double length_mm);

/* A mark at a place: eight faces. */
void btg_shape_mark(btg_shape *shape, const float at[3], float radius_mm);

void btg_shape_release(btg_shape *shape);

#endif
