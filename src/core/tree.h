/* Building the search trees of a part. Internal; set-up only. */
#ifndef BTG_CORE_TREE_H
#define BTG_CORE_TREE_H

#include "core/surface.h"

/* An array that grows through the part's allocator. */
typedef struct btg_quarters_list {
    btg_quarters *at;
    uint32_t count, capacity;
} btg_quarters_list;

/* Bounds of a patch's third derivatives and the stored quarters of it. The part's patch `index`
 * must evaluate already. Raises *depth to the levels stored. */
btg_status btg_tree_add_patch(const btg_part *part, const btg_net *net, uint32_t index,
                              btg_quarters_list *list, uint32_t *depth);

/* The tree over all pieces and triangles of a part whose patches and triangles are in place. */
btg_status btg_tree_build(btg_part *part);

#endif
