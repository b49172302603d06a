/* How deep a placed tool is in a part, by dense samples and a search about the deepest of them,
 * with btg_tool_distance alone: what proven bounds are held against. */
#ifndef BTG_TESTS_UNIT_HARD_DEPTH_H
#define BTG_TESTS_UNIT_HARD_DEPTH_H

#include "core/part.h"

/* A part and samples of its patches. */
typedef struct hard_field {
    const btg_part *part;
    btg_vec3 *sample;
} hard_field;

hard_field hard_field_make(const btg_part *part);
void hard_field_free(hard_field *field);

/* A tool where it stands. */
typedef struct hard_pose {
    const btg_tool *tool;
    btg_vec3 centre, axis;
} hard_pose;

btg_vec3 hard_point(const btg_part *part, btg_place place);
double hard_distance(const hard_field *field, const hard_pose *pose, btg_place place);

/* The least distance about a place that can be reached downhill from it by steps from `step` of
 * the parameters on; along ravines as well as that goes. */
double hard_descend(const hard_field *field, const hard_pose *pose, btg_place from, double step);

/* The least distance of the whole part; and, unless NULL, downhill from one place more. */
double hard_least_distance(const hard_field *field, const hard_pose *pose, const btg_place *also);

/* The place of an item nearest to a point, and how near that is. */
double hard_nearest(const btg_part *part, uint32_t item, btg_vec3 point, btg_place *place);

#endif
