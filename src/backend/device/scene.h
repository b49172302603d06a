/* A part and a tool as a device's buffers hold them, queries and winners between them and the core:
 * what every device back end shares. Internal.
 *
 * The device searches in single precision; what it finds is where the core starts (geometry:
 * devices search, the core polishes). Nothing here need be proven. */
#ifndef BTG_BACKEND_DEVICE_SCENE_H
#define BTG_BACKEND_DEVICE_SCENE_H

#include "backend/internal.h"
#include "core/vec.h"
#include "layout.h"

typedef struct btg_scene {
    btg_gpu_scene head;
    btg_gpu_vec4 *geometry;
    size_t count;    /* of geometry */
    btg_vec3 middle; /* of the part: coordinates on the device are from here */
} btg_scene;

/* How finely a part is cut; lengths in mm. */
typedef struct btg_cell_size {
    double side;     /* of a cell, about */
    double pitch;    /* of samples on it */
    double residual; /* of its quadratic piece, about */
} btg_cell_size;

/* Cuts patches and triangles into cells small against the tool and builds the tree over them.
 * `wanted`: their size as parts of the tool's radius; all 0: what a search on the device wants.
 * `bytes_max`: what the device takes in one buffer. ERROR_MEMORY, or ERROR_UNSUPPORTED where the
 * part does not fit. */
btg_status btg_scene_make(const btg_backend_setup *setup, const btg_cell_size *wanted,
                          size_t bytes_max, btg_scene *scene, btg_message *message);
void btg_scene_free(const btg_allocator *allocator, btg_scene *scene);

/* ---- cells.c ------------------------------------------------------------------------------ */

/* Cells an item is cut into, along u and v; a triangle's are those with i + j < *nu = *nv. */
void btg_cells_count(const btg_part *part, uint32_t item, const btg_cell_size *size, uint32_t *nu,
                     uint32_t *nv);
/* Cell (i, j) as the device holds it (layout.h), and the centre of its ball. */
btg_vec3 btg_cells_fill(const btg_part *part, uint32_t item, uint32_t nu, uint32_t nv, uint32_t i,
                        uint32_t j, const btg_cell_size *size, btg_vec3 middle,
                        btg_gpu_vec4 cell[BTG_GPU_CELL]);

/* High and low part of a coordinate triple from the middle. */
void btg_gpu_split(btg_vec3 p, btg_gpu_vec4 *high, btg_gpu_vec4 *low);
float btg_gpu_bits(uint32_t bits);

/* ---- queries.c ---------------------------------------------------------------------------- */

/* DROP: *shift is what a winner's value lacks to the height. */
void btg_gpu_pack_drop(const btg_scene *scene, const btg_drop_query *query, btg_gpu_query *out,
                       double *shift);
void btg_gpu_pack_tilt(const btg_backend_setup *setup, const btg_scene *scene,
                       const btg_tilt_query *query, btg_gpu_query *out);

/* A winner as the place the core's search starts from; false: none. */
bool btg_gpu_start(const btg_backend_setup *setup, const btg_gpu_winner *winner, btg_place *start);

/* The same after a TILT: none so close to P that the core knows better. */
bool btg_gpu_start_tilt(const btg_backend_setup *setup, const btg_tilt_query *query,
                        const btg_gpu_winner *winner, btg_place *start);

/* A winner as the answer, not polished: BTG_OK and the like with no bound proven. */
void btg_gpu_raw_drop(const btg_backend_setup *setup, const btg_drop_query *query,
                      const btg_gpu_winner *winner, double shift, btg_drop_result *result);
void btg_gpu_raw_tilt(const btg_backend_setup *setup, const btg_tilt_query *query,
                      const btg_gpu_winner *winner, btg_tilt_result *result);

#endif
