/* From solved positions to the rows that files take: what the motion between them needs, and the
 * lifts of the footprint. */
#ifndef BTG_APP_ROWS_H
#define BTG_APP_ROWS_H

#include "app/feet.h"
#include "app/sink.h"
#include "bitangent/motion.h"

typedef struct rows {
    const feet *feet;
    const btg_tool *tool;
    sinks *sinks;
    summary *summary;
    double clear_z_mm;
    btg_motion *motion; /* NULL: the way between positions is not looked at */
    uint64_t added;     /* positions */
    uint64_t given;     /* rows */
    size_t next;        /* of the footprint's points: the first that is in no row yet */
    bool any;           /* there is a last position: */
    btg_footprint_point at;
    btg_position last;
} rows;

/* What rows point to outlives them. Errors as btg_motion_create. */
btg_status rows_open(rows *r, const path_options *options, btg_backend *backend,
                     btg_message *message);
/* The next position, over `point`. Errors as btg_motion_add. */
btg_status rows_add(rows *r, btg_footprint_point point, const btg_position *position);
btg_status rows_end(rows *r);
void rows_close(rows *r);

#endif
