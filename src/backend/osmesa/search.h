/* Depth images of many queries at once: coarse, then fine over each valley. Internal. */
#ifndef BTG_BACKEND_OSMESA_SEARCH_H
#define BTG_BACKEND_OSMESA_SEARCH_H

#include "backend/osmesa/view.h"

typedef struct btg_raster_options {
    uint32_t levels; /* 1 or 2 */
    uint32_t window; /* pixels a tile's side */
} btg_raster_options;

typedef struct btg_search_best {
    bool found, coarse; /* coarse: the first level's, whatever a fine window shows is better */
    float depth;
    uint32_t cell, element, place;
    uint32_t pick;        /* of the coarse level, by index */
    btg_raster_tile tile; /* that it was seen in */
} btg_search_best;

/* Fine windows a query may have. */
#define BTG_SEARCH_SEEN 32

/* Those it has had: middle and view. */
typedef struct btg_search_seen {
    uint32_t count, view[BTG_SEARCH_SEEN];
    float at[BTG_SEARCH_SEEN][2];
} btg_search_seen;

/* Tiles of one pass, and what they come to. */
typedef struct btg_raster_shot {
    btg_raster_pass pass;
    btg_raster_tile *tiles;
    btg_raster_pick *picks; /* pass.size.y a tile */
    uint32_t count;         /* of tiles */
} btg_raster_shot;

typedef struct btg_raster_search {
    btg_raster raster;
    btg_scene scene; /* with geometry of its own */
    const btg_part *part;
    btg_tool tool;
    btg_raster_options options;
    uint32_t capacity; /* queries */
    btg_gpu_query *queries;
    btg_search_best *best;
    btg_search_seen *seen;
    btg_raster_shot coarse, fine;
    btg_raster_entry *list;
    btg_gpu_vec4 (*pieces)[BTG_GPU_CELL];
} btg_raster_search;

/* Pixels of the atlas a side: enough that it holds one tile, and on small ones many. */
uint32_t btg_raster_search_atlas(const btg_raster_options *options, uint32_t most);
btg_status btg_raster_search_room(btg_raster_search *search, const btg_allocator *allocator,
                                  uint32_t capacity, btg_message *message);
void btg_raster_search_free(btg_raster_search *search, const btg_allocator *allocator);

/* Answers search->queries[0 .. count - 1]. */
btg_status btg_raster_search_run(btg_raster_search *search, btg_op op, uint32_t count,
                                 btg_gpu_winner *winners);

#endif
