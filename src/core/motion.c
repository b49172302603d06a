/* The tool between two poses.
 *
 * The cutter is balls of its minor radius about the points of its ring (or disc). Between two
 * moments such a point moves by at most s: the tip's way and the turn's. Of the ball that rolls
 * from one place to the other, two balls at its ends miss Ri - sqrt(Ri^2 - (s/2)^2) at most; a
 * sharp rim misses half of s. To that comes how the points leave the straight way: the sagitta of
 * the turn.
 *
 * Machines turn the axis evenly, or along the chord between its two directions; at the same moment
 * the two differ by less than TIMING * turn^3 up to a turn of TURN_MOST (the series begins with
 * t (1 - t) (1 - 2 t) / 6 <= 0.0161 of it). The chord's greatest speed is 2 tan(turn / 2). */
#include "core/motion.h"

#define TIMING    0.019
#define TURN_MOST 1.6
/* Share of the error that may stand for the two ways; where they differ more both are looked at. */
#define TIMING_SHARE 0.05
#define STEPS_GROW   1.1

static double angle_between(btg_vec3 a, btg_vec3 b) {
    return atan2(vec_norm(vec_cross(a, b)), vec_dot(a, b));
}

btg_motion_pose btg_motion_at(const btg_motion_pose *a, const btg_motion_pose *b, double t,
                              bool chord) {
    btg_motion_pose p = {.tip = vec_mad(a->tip, vec_sub(b->tip, a->tip), t)};
    double angle = angle_between(a->axis, b->axis);
    btg_vec3 way = vec_sub(b->axis, a->axis);
    if (chord || angle < 1e-6) {
        p.axis = vec_unit(vec_mad(a->axis, way, t));
        return p;
    }
    btg_vec3 across = vec_unit(vec_mad(b->axis, a->axis, -vec_dot(a->axis, b->axis)));
    p.axis =
        vec_unit(vec_add(vec_scale(a->axis, cos(angle * t)), vec_scale(across, sin(angle * t))));
    return p;
}

/* ---- moments ------------------------------------------------------------------------------ */

/* What two balls of this radius, s apart, miss of the one that rolls between them. */
static double missed(double radius, double s) {
    double half = 0.5 * s;
    if (half >= radius) return half;
    return half * half / (radius + sqrt(radius * radius - half * half));
}

btg_motion_plan btg_motion_steps(const btg_tool *tool, const btg_motion_pose *a,
                                 const btg_motion_pose *b, double error, uint32_t most) {
    const btg_tool_element *cutter = &tool->element[0];
    double arm = norm2(cutter->ring_radius_mm, cutter->corner_radius_mm);
    double way = vec_norm(vec_sub(b->tip, a->tip)), turn = angle_between(a->axis, b->axis);
    double apart = arm * TIMING * turn * turn * turn, n = 1;
    btg_motion_plan plan = {.both = apart > TIMING_SHARE * error};
    if (turn > TURN_MOST) return plan;
    double room = plan.both ? error : error - apart, speed = 2 * tan(0.5 * turn);
    while (n <= most) {
        /* The arc's sagitta, and as much again for a turn that is not even. */
        double part = speed / n, s = way / n + arm * part;
        if (missed(cutter->corner_radius_mm, s) + arm * part * part / 4 <= room) break;
        n = max2(n + 1, floor(n * STEPS_GROW));
    }
    if (n <= most) plan.steps = (uint32_t)n;
    return plan;
}

btg_drop_query btg_motion_query(const btg_tool *tool, const btg_motion_pose *pose) {
    return (btg_drop_query){.origin =
                                vec_mad(pose->tip, pose->axis, tool->element[0].corner_radius_mm),
                            .axis = pose->axis};
}

/* ---- lean --------------------------------------------------------------------------------- */

/* The arm of the tilt, from the pseudo-insert's centre to the axis. */
static btg_vec3 arm_of(const btg_tool *tool, const btg_position *p, btg_vec3 *o1) {
    double ri = tool->element[0].corner_radius_mm;
    *o1 = vec_mad(p->p.point, p->p.normal, ri);
    return vec_unit(vec_sub(vec_mad(p->tip, p->axis, ri), *o1));
}

static bool leans(const btg_tool *tool, const btg_position *p) {
    return p->tilt_rad > 0 && tool->element[0].ring_radius_mm > 0 && vec_finite(p->p.point);
}

void btg_motion_lean(const btg_tool *tool, double tilt, btg_position *p) {
    if (!leans(tool, p) || tilt >= p->tilt_rad) return;
    btg_vec3 o1, v = arm_of(tool, p, &o1), w = p->axis;
    double back = p->tilt_rad - max2(tilt, 0), c = cos(back), s = sin(back);
    btg_vec3 arm = vec_unit(vec_mad(vec_scale(v, c), w, s));
    p->axis = vec_unit(vec_mad(vec_scale(w, c), v, -s));
    p->tip = vec_mad(vec_mad(o1, arm, tool->element[0].ring_radius_mm), p->axis,
                     -tool->element[0].corner_radius_mm);
    p->tilt_rad = max2(tilt, 0);
    p->inclination_rad += back;
    p->status = BTG_SINGLE_CONTACT;
    p->q = (btg_contact){.point = vec_nan(), .normal = vec_nan()};
}

/* Unspun, an axis leans by its tilt from +z toward the arm as seen from above. With leans a >= b
 * and directions d apart the axes are a - b + 2 asin(sin(b) sin(d / 2)) apart at most, which is no
 * more than a - (1 - k) b, k = 2 sin(d / 2). For k >= 1 both at most turn / k will do; for k < 1
 * no two leans that fulfil the second condition exceed that either. */
btg_motion_bond btg_motion_bind(const btg_tool *tool, const btg_position *a, const btg_position *b,
                                double turn) {
    btg_motion_bond bond = {.cap = INFINITY, .turn = turn, .share = 1};
    if (!leans(tool, a) || !leans(tool, b)) return bond;
    btg_vec3 o1, va = arm_of(tool, a, &o1), vb = arm_of(tool, b, &o1);
    double d = angle_between(vec(va.x, va.y, 0), vec(vb.x, vb.y, 0)), k = 2 * sin(0.5 * d);
    if (k > 0) bond.cap = turn / k;
    bond.share = max2(1 - k, 0);
    return bond;
}
