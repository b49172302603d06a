#include "io/outline.h"
#include "core/facets.h"

#include <stdlib.h>

#define FACETS_MAX 2000000

static double *corners(const btg_facets *facets) {
    double *xy = malloc((facets->triangle_count + 1) * 6 * sizeof *xy);
    for (size_t i = 0; xy && i < facets->triangle_count; i++)
        for (int k = 0; k < 3; k++) {
            btg_vec3 p = facets->points[facets->triangles[i][k]];
            xy[6 * i + 2 * k] = p.x;
            xy[6 * i + 2 * k + 1] = p.y;
        }
    return xy;
}

btg_status btg_outline_passes(const btg_outline_def *def, const btg_part *part,
                              btg_footprint_point **points, size_t *count, btg_message *message) {
    btg_facets_def facets_def = {.chord_mm = BTG_OUTLINE_CHORD_MM, .triangles_max = FACETS_MAX};
    btg_facets facets = {0};
    if (!(def->side_step_mm > 0 && def->forward_step_mm > 0 && def->overrun_mm >= 0))
        return btg_fail(message, BTG_ERROR_ARGUMENT, "contour: steps must be more than 0");
    btg_status status = btg_facets_make(part, &facets_def, &facets, message);
    if (status != BTG_OK) return status;
    const char *why = "out of memory";
    double *xy = corners(&facets);
    status = xy ? btg_outline_trace(def, xy, facets.triangle_count, points, count, &why)
                : BTG_ERROR_MEMORY;
    free(xy);
    btg_facets_free(&facets);
    return status == BTG_OK ? status : btg_fail(message, status, "contour: %s", why);
}
