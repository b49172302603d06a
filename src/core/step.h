/* One step uphill from a place of the part. Internal. */
#ifndef BTG_CORE_STEP_H
#define BTG_CORE_STEP_H

#include "core/search.h"

typedef struct btg_step {
    bool newton;   /* the model's own; else it was bent until it was convex, or cut short */
    double du, dv; /* straight, in the item's parameters */
    double speed_u, speed_v;       /* mm */
    double by_value;               /* how fast the distance to the tool falls with the value, mm */
    bool round;                    /* else straight: along the tool's ring, at r from its axis */
    double r, along, out;          /* along the ring and outward, mm */
    double along_uv[2], out_uv[2]; /* parameters of unit steps, at its start */
} btg_step;

/* The step from a place and its point, with the tool placed at its value and the distance there. */
void btg_step_make(const btg_search *search, btg_place at, const btg_surface_point *point,
                   const btg_placement *tool, const btg_ray_distance *distance, btg_step *step);

/* Where a part of the step leads, held inside the item's domain. */
btg_place btg_step_move(const btg_search *search, btg_place from, const btg_step *step,
                        double part);

#endif
