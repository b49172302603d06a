/* A tool path as it is looked at in space: what is kept of each position, whatever the output.
 * Internal to the program. */
#ifndef BTG_IO_SCENE_H
#define BTG_IO_SCENE_H

#include "io/output.h"
#include "io/row.h"

/* mm and radians; NaN where a value does not exist. What is there for the eye is in single
 * precision. */
typedef struct btg_scene_stop {
    double foot_mm[2];
    btg_vec3 exact_tip, exact_axis;
    float tip[3], axis[3], p[3], q[3];
    float tilt_rad;
    int8_t status; /* btg_status */
    bool linked;   /* the tool goes straight to it from the stop before */
    uint32_t pass, point;
} btg_scene_stop;

/* Zeroed when empty. */
typedef struct btg_scene {
    btg_scene_stop *stops;
    size_t count, capacity;
    bool short_of_memory; /* latched: stops are missing */
} btg_scene;

/* Retracts are left out; `linked`: the tool goes straight to the position from the one before. */
void btg_scene_add(btg_scene *scene, const btg_row *row, bool linked);
void btg_scene_release(btg_scene *scene);

/* The stop with the largest tilt, where a tool is worth showing; SIZE_MAX when none touches. */
size_t btg_scene_best(const btg_scene *scene);
/* Radius at which marks of all contacts stay apart, mm. */
double btg_scene_mark_mm(const btg_scene *scene, const btg_part *part, const btg_tool *tool);
/* How far up the tool is drawn over its tip, mm: shank and holder, or a little over the cutter. */
double btg_scene_tool_mm(const btg_tool *tool);

/* A glTF 2.0 binary in metres, y up: the part, the path of the tip, tool axes, contacts P and Q and
 * the lines between them, and the tool at btg_scene_best, which an animation leads along the
 * path. Errors: ERROR_MEMORY, ERROR_FILE; ERROR_ARGUMENT when it would be over 2 GB. */
btg_status btg_scene_glb(const btg_scene *scene, const btg_part *part, const btg_tool *tool,
                         const char *title, btg_output *output, btg_message *message);

#endif
