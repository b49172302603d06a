/* Which cells a tile can show, and where on it a point is: the processor's side of raster.vert.
 * Internal. */
#ifndef BTG_BACKEND_OSMESA_VIEW_H
#define BTG_BACKEND_OSMESA_VIEW_H

#include "backend/osmesa/raster.h"

/* What is kept of a scene: its tree of balls and its cells. */
typedef struct btg_view {
    const btg_scene *scene;
    const btg_gpu_query *query;
    uint32_t kind; /* BTG_VIEW_... */
    btg_vec3 u, v, w;
    btg_vec3 p, n; /* TILT: first contact and its normal, in that frame */
} btg_view;

btg_view btg_view_make(const btg_scene *scene, const btg_gpu_query *query, uint32_t kind);
/* Image coordinates of a point given from the middle of the part. */
void btg_view_point(const btg_view *view, btg_vec3 point, double at[2]);

/* Takes the cells that a window (middle, half sides) may show, one by one. */
typedef struct btg_view_sink {
    void (*take)(void *user, uint32_t cell);
    void *user;
} btg_view_sink;
void btg_view_cells(const btg_view *view, const double window[4], const btg_view_sink *sink);

/* Of the ball about a cell. */
double btg_view_radius(const btg_view *view, uint32_t cell);

/* The pieces of a cell, cut in `cuts` along each side, that the window may show: as raster.vert
 * takes them, from the surface itself. */
typedef struct btg_view_pieces {
    void (*take)(void *user, const btg_gpu_vec4 piece[BTG_GPU_CELL]);
    void *user;
} btg_view_pieces;
void btg_view_cut(const btg_view *view, const btg_part *part, const double window[4], uint32_t cell,
                  uint32_t cuts, const btg_view_pieces *sink);

/* A place on a cell as a pick has it: item, u and v, and the point from the middle of the part. */
typedef struct btg_view_place {
    uint32_t item;
    double u, v;
    btg_vec3 point;
} btg_view_place;
btg_view_place btg_view_unpack(const btg_scene *scene, uint32_t cell, uint32_t packed);

/* What a pixel shows: a place on a cell, the tool's element that meets it and at what value. */
typedef struct btg_view_hit {
    uint32_t cell, packed, element;
    double value;
} btg_view_hit;

/* How much higher values may be within `reach` of it in the image: of a part and a cutter that
 * curve away from each other, and on an edge of the part also of their slopes. */
double btg_view_hidden(const btg_view *view, const btg_view_hit *hit, double reach);

#endif
