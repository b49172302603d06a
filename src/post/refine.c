/* More points where the machine's own way between two of them is not the one wanted: the tip on a
 * straight line, the axis turning evenly from one direction to the other. With tool-centre-point
 * control the tip is right and the axis follows the rotary joints; without, both stray. */
#include "post/internal.h"

/* Halvings of one way. Where as many do not do, joints would have to turn on the spot next to the
 * pole: the tool is lifted for that. */
#define DEPTH_MAX 16

static btg_vec3 between(btg_vec3 a, btg_vec3 b, double part) {
    return vec_mad(vec_scale(a, 1 - part), b, part);
}

static double angle_between(btg_vec3 a, btg_vec3 b) {
    return atan2(vec_norm(vec_cross(a, b)), vec_dot(a, b));
}

/* Distance of p from the line; *part: the place of it that is nearest, where there is one. */
static double from_line(btg_vec3 a, btg_vec3 b, btg_vec3 p, double *part) {
    btg_vec3 way = vec_sub(b, a), arm = vec_sub(p, a);
    double n2 = vec_norm2(way);
    if (n2 > 0) *part = fmin(fmax(vec_dot(arm, way) / n2, 0), 1);
    return vec_norm(n2 > 0 ? vec_mad(arm, way, -*part) : arm);
}

void btg_stray(const btg_program *p, const btg_stop *a, const btg_stop *b, double *tip_mm,
               double *axis_rad) {
    const btg_machine *m = &p->machine;
    double turn = fabs(b->angle[0] - a->angle[0]) + fabs(b->angle[1] - a->angle[1]);
    *tip_mm = *axis_rad = 0;
    if (turn == 0 || (m->def.tcp && m->def.vectors)) return;
    /* Both ways bend by at most turn^2; a chord strays by an eighth of that. */
    if (m->def.tcp && turn * turn / 4 <= p->axis_tolerance_rad) return;
    btg_vec3 from = vec(0, 0, 0), to = from;
    if (!m->def.tcp) {
        from = btg_machine_linear(m, a->tip, a->angle);
        to = btg_machine_linear(m, b->tip, b->angle);
    }
    for (int k = 1; k <= 3; k++) {
        double part = k / 4.0;
        double angle[2] = {a->angle[0] + (b->angle[0] - a->angle[0]) * part,
                           a->angle[1] + (b->angle[1] - a->angle[1]) * part};
        /* Joints alone also bring the tip along unevenly: the axis goes with the tip. */
        double along = part;
        if (!m->def.tcp) {
            btg_vec3 tip = btg_machine_tip(m, between(from, to, part), angle);
            *tip_mm = fmax(*tip_mm, from_line(a->tip, b->tip, tip, &along));
        }
        btg_vec3 wanted = between(a->axis, b->axis, along);
        *axis_rad = fmax(*axis_rad, angle_between(btg_machine_axis(m, angle), wanted));
    }
}

btg_stop btg_middle(const btg_program *p, const btg_stop *a, const btg_stop *b) {
    double near[2] = {(a->angle[0] + b->angle[0]) / 2, (a->angle[1] + b->angle[1]) / 2};
    btg_stop s = {.tip = between(a->tip, b->tip, 0.5), .axis = vec_unit(vec_add(a->axis, b->axis))};
    if (!btg_choice_nearest(&p->machine, s.axis, 0, near, s.angle)) {
        s.angle[0] = near[0];
        s.angle[1] = near[1];
        s.axis = btg_machine_axis(&p->machine, near);
    }
    for (int j = 0; j < 2; j++) {
        const btg_rotary_def *r = &p->machine.def.rotary[j];
        double within = fmin(fmax(s.angle[j], r->min_rad), r->max_rad);
        if (within == s.angle[j]) continue;
        s.angle[j] = within;
        s.axis = btg_machine_axis(&p->machine, s.angle);
    }
    return s;
}

static void cut(btg_program *p, const btg_stop *a, const btg_stop *b, int depth) {
    double tip, axis;
    btg_stray(p, a, b, &tip, &axis);
    if (tip <= p->def.tolerance_mm && axis <= p->axis_tolerance_rad) {
        btg_pace_add(p, b);
        return;
    }
    if (depth == DEPTH_MAX) {
        p->at = *a;
        p->info.retracts++;
        btg_travel(p, b);
        return;
    }
    btg_stop middle = btg_middle(p, a, b);
    p->info.inserted++;
    cut(p, a, &middle, depth + 1);
    cut(p, &middle, b, depth + 1);
}

void btg_refine(btg_program *p, const btg_stop *a, const btg_stop *b) {
    cut(p, a, b, 0);
}
