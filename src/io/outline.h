/* The part's outline as seen from above, and passes along it: the outline itself, then the same
 * ever farther inside. Polygons are Clipper's. */
#ifndef BTG_IO_OUTLINE_H
#define BTG_IO_OUTLINE_H

#include "bitangent/bitangent.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct btg_outline_def {
    double side_step_mm;    /* between passes; at most that is left in the middle to either side */
    double forward_step_mm; /* most between the points of a pass, which are evenly apart */
    double overrun_mm;      /* of the first pass beyond the outline, 0 or more */
} btg_outline_def;

/* Closed passes, the outermost first: each ends at the point it began with. *points is malloc'd,
 * for the caller to free. Errors: ERROR_ARGUMENT (steps not positive, more than BTG_FOOTPRINT_MAX
 * points, nothing of the part has a width, or this build has no Clipper), ERROR_MEMORY. */
btg_status btg_outline_passes(const btg_outline_def *def, const btg_part *part,
                              btg_footprint_point **points, size_t *count, btg_message *message);

/* The outline is that of facets about so near the part, mm. */
#define BTG_OUTLINE_CHORD_MM 0.05

/* The same of triangles, three corners x, y each: Clipper's part of it. *why: what is wrong. */
btg_status btg_outline_trace(const btg_outline_def *def, const double *xy, size_t triangles,
                             btg_footprint_point **points, size_t *count, const char **why);

#ifdef __cplusplus
}
#endif

#endif
