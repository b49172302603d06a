/* Tools and pieces of parts that several groups of cases use. */
#ifndef BTG_TESTS_SHAPES_H
#define BTG_TESTS_SHAPES_H

#include "conformance.h"

/* Tools by number: usual, Ro < Ri, Ro > Ri, Ro = Ri, bullnoses, flat, ball. */
#define SHAPE_TOOLS 8
void shape_tool(fixture *f, int number);
/* As above, but only those that can tilt on any part. */
#define SHAPE_RING_TOOLS 7

static inline void shape_put(model_surface *s, int index, btg_vec3 p) {
    s->points[3 * index] = p.x;
    s->points[3 * index + 1] = p.y;
    s->points[3 * index + 2] = p.z;
}

/* Distance of the tool's ring (of its disc, if it is closed) to a vertical line at distance e of
 * the axis. */
double shape_gap(const fixture *f, double e);

#endif
