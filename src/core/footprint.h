/* Footprint points one by one, for those who do not want them all in memory. Internal. */
#ifndef BTG_CORE_FOOTPRINT_H
#define BTG_CORE_FOOTPRINT_H

#include "bitangent/bitangent.h"

/* A checked footprint: how many passes, and points a pass. */
typedef struct btg_footprint_layout {
    btg_footprint_def def;
    uint32_t passes;
    uint32_t points; /* a pass, without lifts */
    uint32_t lifts;  /* a pass: 0 or 2 */
    size_t total;    /* all, lifts included */
} btg_footprint_layout;

/* Errors as btg_footprint_count. */
btg_status btg_footprint_plan(const btg_footprint_def *def, btg_footprint_layout *layout,
                              btg_message *message);
/* index < total; in order. */
btg_footprint_point btg_footprint_at(const btg_footprint_layout *layout, size_t index);

#endif
