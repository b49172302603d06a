/* Where the tool is dropped: a pattern over the part's rectangle, passes along its outline, or the
 * points of a file. */
#ifndef BTG_APP_FEET_H
#define BTG_APP_FEET_H

#include "app/options.h"
#include "bitangent/backend.h"
#include "core/footprint.h"

typedef struct feet {
    size_t total;               /* lifts included */
    double *xy;                 /* points of a file, or NULL */
    btg_footprint_point *along; /* the outline, or NULL: */
    btg_footprint_layout layout;
} feet;

/* Errors as points_read, btg_outline_passes and btg_footprint_count. */
btg_status feet_open(feet *f, const path_options *options, const btg_part *part,
                     btg_message *message);
/* `options` with the side step that their scallop asks for. Errors as btg_side_step. */
btg_status feet_side_step(path_options *options, const btg_part *part, const btg_tool *tool,
                          btg_backend *backend, btg_message *message);
void feet_close(feet *f);
btg_footprint_point feet_at(const feet *f, size_t index);
/* The tool goes straight to this point from the one before. */
bool feet_linked(const feet *f, btg_footprint_point point);

#endif
