/* Tiles of depth images as C and GLSL both see them. Internal.
 *
 * A tile is one view of the part, in one query's frame; many share an atlas, one draw and one
 * reduction. Of what covers a pixel the largest value (core/ray.h) wins, by the depth test. */
#ifndef BTG_SHADERS_TILES_H
#define BTG_SHADERS_TILES_H

#include "layout.h"

#define BTG_RASTER_PASS  1 /* bindings beside those of layout.h; this one is a uniform block */
#define BTG_RASTER_TILES 4
#define BTG_RASTER_LIST  5
#define BTG_RASTER_PICKS 6

#define BTG_RASTER_PICKS_MAX 4 /* valleys a tile */

/* Views: what a point (su, sv, sw) of the query's frame has for coordinates in the image. */
#define BTG_VIEW_PLANE    0u /* su, sv: along the axis, vertical rays are points */
#define BTG_VIEW_CYLINDER 1u /* su, sqrt(sv^2 + sw^2): circular rays are points */
#define BTG_VIEW_CONTACT  2u /* su, and along the insert from P: straight at the part there, where
                                circular rays graze it */

BTG_GPU_STRUCT(btg_raster_tile) {
    BTG_GPU_VEC4 window; /* middle and half sides, mm */
    BTG_GPU_UVEC4 at;    /* query, view, place in the atlas: column, row of its first pixel */
    BTG_GPU_VEC4 limits; /* TILT: squared radius left out about P; least power d of a point; and of
                            both: depth = (z - value) w */
};

/* Cells are drawn as they stand in the scene, or as pieces: laid out as cells, behind the scene's
 * geometry, but with the index of their cell as bits in place of the samples. */

BTG_GPU_STRUCT(btg_raster_pass) {
    BTG_GPU_UVEC4 size; /* pixels a tile's side, picks a tile, first piece as index of a cell; 1: picks
                           besides the best are on the tile's rim */
    BTG_GPU_VEC4 scale; /* 2 / atlas width, 2 / height; value that picks besides the best are within */
};

/* What a tile comes to; depth 1: nothing. */
BTG_GPU_STRUCT(btg_raster_pick) {
    BTG_GPU_FLOAT depth;
    BTG_GPU_UINT cell;  /* of the scene; from bit BTG_RASTER_ELEMENT the tool's element */
    BTG_GPU_UINT place; /* s, t on the cell, -1..1: two 16-bit halves */
    BTG_GPU_UINT pixel; /* row * side + column */
};
#define BTG_RASTER_ELEMENT 28

#endif
