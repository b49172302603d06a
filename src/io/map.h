/* The field of a verification as CSV, as a picture and as a coloured model. Internal to the
 * program. */
#ifndef BTG_IO_MAP_H
#define BTG_IO_MAP_H

#include "bitangent/verify.h"
#include "io/output.h"

/* Deviations, mm, between which the part counts as finished: [-gouge, scallop]. */
typedef struct btg_map_scale {
    double gouge_mm, scallop_mm;
} btg_map_scale;

/* Colour of a deviation, 0 .. 1 each: grey-green where finished, blues (more left) and reds
 * (gouged) in steps of a factor of 10 beyond. */
void btg_map_colour(const btg_map_scale *scale, double deviation, float rgb[3]);

/* x,y,part_z,stock_z,deviation: one line a cell that has part. */
btg_status btg_map_csv(const btg_verify_map *map, btg_output *output, btg_message *message);
/* ERROR_NOT_BUILT without Cairo. */
btg_status btg_map_png(const btg_verify_map *map, const btg_verify_result *result,
                       const btg_map_scale *scale, const char *title, btg_output *output,
                       btg_message *message);
/* The part's upper side, coloured, in metres, y up; at most 1000 x 1000 of its cells, the worst of
 * those that fall together. */
btg_status btg_map_glb(const btg_verify_map *map, const btg_map_scale *scale, const char *title,
                       btg_output *output, btg_message *message);

#endif
