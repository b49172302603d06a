/* The tool between two poses: how it moves, how far a few moments of that are from all of it, and
 * what it may lean less. Internal; see bitangent/motion.h. */
#ifndef BTG_CORE_MOTION_H
#define BTG_CORE_MOTION_H

#include "core/vec.h"

/* A pose by its tip and axis. */
typedef struct btg_motion_pose {
    btg_vec3 tip, axis;
} btg_motion_pose;

/* Part t of the way from a to b: the tip on a straight line, the axis turned evenly, or (`chord`)
 * toward the point at t of the line between its two directions. Machines do either. */
btg_motion_pose btg_motion_at(const btg_motion_pose *a, const btg_motion_pose *b, double t,
                              bool chord);

/* Moments to look at, at 0, 1 / steps, 2 / steps, ... of the way. */
typedef struct btg_motion_plan {
    uint32_t steps; /* 0: the way is too long for as many as may be */
    bool both;      /* the two ways of turning are to be looked at both, not the even one alone */
} btg_motion_plan;

/* The fewest that leave no point of the swept cutter farther than `error` from the cutter at one of
 * them, whichever way the axis turns; up to `most`. */
btg_motion_plan btg_motion_steps(const btg_tool *tool, const btg_motion_pose *a,
                                 const btg_motion_pose *b, double error, uint32_t most);

/* DROP along the pose's own axis: its height is how far the tool has to back out to be clear, and
 * so no less than how deep it is in the part; above that height it is clear everywhere. */
btg_drop_query btg_motion_query(const btg_tool *tool, const btg_motion_pose *pose);

/* The tool of an unspun position leans by `tilt` (0 .. its own) instead, about P: P stays, Q is
 * lost. All that the tilt went through on its way to Q is clear of the part. */
void btg_motion_lean(const btg_tool *tool, double tilt, btg_position *position);

/* How the leans of two unspun neighbours bind each other when their axes may be `turn` apart:
 * both at most `cap`, and the greater at most turn + share * the lesser. */
typedef struct btg_motion_bond {
    double cap, turn, share;
} btg_motion_bond;

btg_motion_bond btg_motion_bind(const btg_tool *tool, const btg_position *a, const btg_position *b,
                                double turn);

#endif
