/* Tiles drawn and reduced by OpenGL: what runs on the device of the back end osmesa. Internal.
 *
 * All calls are made with the context entered. Errors: ERROR_MEMORY, ERROR_DEVICE. */
#ifndef BTG_BACKEND_OSMESA_RASTER_H
#define BTG_BACKEND_OSMESA_RASTER_H

#include "backend/context/context.h"
#include "backend/device/scene.h"
#include "core/ray.h"
#include "tiles.h"

typedef enum btg_raster_buffer {
    BTG_RASTER_BUFFER_SCENE,
    BTG_RASTER_BUFFER_PASS,
    BTG_RASTER_BUFFER_GEOMETRY,
    BTG_RASTER_BUFFER_QUERIES,
    BTG_RASTER_BUFFER_TILES,
    BTG_RASTER_BUFFER_LIST,
    BTG_RASTER_BUFFER_PICKS,
    BTG_RASTER_BUFFER_CORNERS, /* indices of two triangles a cell */
    BTG_RASTER_BUFFERS
} btg_raster_buffer;

typedef struct btg_raster {
    const btg_gl *gl;
    uint32_t side;             /* of the atlas, pixels */
    GLuint program[2], reduce; /* the first two by btg_op */
    GLuint buffer[BTG_RASTER_BUFFERS];
    GLuint vertices, frame, depth, place;
    uint32_t first_piece; /* as index of a cell */
    size_t pieces_at;     /* in the geometry's buffer, bytes */
} btg_raster;

/* Cells a draw, and pieces among them, at the most. */
#define BTG_RASTER_DRAW 32768

/* A tile and a cell to draw into it. */
typedef struct btg_raster_entry {
    uint32_t tile, cell;
} btg_raster_entry;

/* What one buffer may hold; the largest side of an atlas; ERROR_UNSUPPORTED where the driver lacks
 * GL_ARB_gl_spirv. */
btg_status btg_raster_limits(const btg_context *context, size_t *buffer_bytes, uint32_t *side,
                             btg_message *message);
/* `side`: of the atlas; `window`: of the largest tile. *bytes: memory of the
 * device. On error what there is stays for unload. */
btg_status btg_raster_load(btg_raster *raster, const btg_context *context, const btg_scene *scene,
                           uint32_t side, uint32_t window, size_t *bytes, btg_message *message);
void btg_raster_unload(btg_raster *raster);

/* Tiles of `pixels` a side that the atlas holds. */
uint32_t btg_raster_capacity(const btg_raster *raster, uint32_t pixels);

void btg_raster_queries(const btg_raster *raster, const btg_gpu_query *queries, size_t count);
/* Empties the first `count` <= capacity places and gives each tile its own: tiles[].at.z, .w. */
void btg_raster_begin(const btg_raster *raster, btg_op op, const btg_raster_pass *pass,
                      btg_raster_tile *tiles, uint32_t count);
/* Draws; as often as need be. Pieces hold for this draw alone. */
void btg_raster_draw(const btg_raster *raster, const btg_raster_entry *list, size_t count,
                     const btg_gpu_vec4 (*pieces)[BTG_GPU_CELL], size_t piece_count);
/* pass->size.y picks a tile, the best first. */
btg_status btg_raster_finish(const btg_raster *raster, const btg_raster_pass *pass, uint32_t count,
                             btg_raster_pick *picks);

#endif
