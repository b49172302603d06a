/* Stands in for outline_clipper.cpp in a build without Clipper. */
#include "io/outline.h"

btg_status btg_outline_trace(const btg_outline_def *def, const double *xy, size_t triangles,
                             btg_footprint_point **points, size_t *count, const char **why) {
    (void)def, (void)xy, (void)triangles, (void)points, (void)count;
    *why = "this build has no Clipper (libpolyclipping-dev); give another footprint";
    return BTG_ERROR_ARGUMENT;
}
