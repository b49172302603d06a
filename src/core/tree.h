/* Building the search trees of a part. Internal; set-up only. */
#ifndef BTG_CORE_TREE_H
#define BTG_CORE_TREE_H

#include "core/surface.h"

/* An array that grows through the part's allocator. */
typedef struct btg_tile_list {
    btg_tile *tiles;
    uint32_t count, capacity;
} btg_tile_list;

/* The tree of one patch's tiles, down to pieces flat enough to hold in memory. Returns the root
 * in *root, raises *depth to its height and `third` to the patch's bounds (part.h). */
btg_status btg_tree_add_patch(const btg_allocator *allocator, const btg_net *net, double scale,
                              btg_tile_list *list, uint32_t *root, uint32_t *depth,
                              double third[4]);

/* The tree of boxes over all items of a part whose patches, tiles and triangles are in place. */
btg_status btg_tree_build_boxes(btg_part *part);

#endif
