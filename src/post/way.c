/* The machine's own way from where one block ends to where the next one does. */
#include "post/internal.h"
#include "post/read.h"

/* A piece turns by no more than this: so short that what it strays by is a parabola's height, with
 * a little of the third order, and three points of it tell. */
#define PIECE_RAD 0.1
#define MARGIN    1.1 /* over the three */
/* Shortest piece: turning on the spot next to the pole needs many, never more than this. */
#define PIECE_LEAST 1e-7

static btg_vec3 mixed(btg_vec3 a, btg_vec3 b, double part) {
    return vec_mad(vec_scale(a, 1 - part), b, part);
}

void btg_way_at(const btg_machine *machine, const btg_way *way, double part, btg_way_pose *pose) {
    btg_vec3 at = mixed(way->from, way->to, part);
    if (way->kind == BTG_WAY_VECTORS) {
        *pose = (btg_way_pose){.tip = at, .axis = vec_turned(way->axis_from, way->axis_to, part)};
        return;
    }
    for (int j = 0; j < 2; j++)
        pose->angle[j] = way->angle_from[j] * (1 - part) + way->angle_to[j] * part;
    bool tcp = way->kind == BTG_WAY_TCP;
    pose->axis = btg_machine_axis(machine, pose->angle);
    pose->tip = tcp ? at : btg_machine_tip(machine, at, pose->angle);
    pose->linear = tcp ? btg_machine_linear(machine, at, pose->angle) : at;
}

static double stray(const btg_machine *machine, const btg_way *way, double from, double to,
                    double reach) {
    btg_way_pose a, b, at;
    double most = 0;
    btg_way_at(machine, way, from, &a);
    btg_way_at(machine, way, to, &b);
    for (int k = 1; k <= 3; k++) {
        double part = 0.25 * k;
        btg_way_at(machine, way, from + (to - from) * part, &at);
        double tip = vec_norm(vec_sub(at.tip, mixed(a.tip, b.tip, part)));
        double axis = vec_norm(vec_sub(at.axis, vec_turned(a.axis, b.axis, part)));
        most = max2(most, tip + reach * axis);
    }
    return MARGIN * most;
}

double btg_way_piece(const btg_machine *machine, const btg_way *way, double from, double most,
                     double error_mm, double reach_mm) {
    if (way->kind == BTG_WAY_VECTORS) return 1;
    double turn =
        fabs(way->angle_to[0] - way->angle_from[0]) + fabs(way->angle_to[1] - way->angle_from[1]);
    if (turn == 0) return 1;
    double step = min2(min2(most, 1 - from), PIECE_RAD / turn);
    while (step > PIECE_LEAST && stray(machine, way, from, from + step, reach_mm) > error_mm)
        step *= 0.5;
    return from + step >= 1 - PIECE_LEAST ? 1 : from + step;
}

double btg_way_haste(const btg_machine *machine, const btg_way *way, double from, double to,
                     const btg_way_pose *a, const btg_way_pose *b, int *joint) {
    const btg_machine_def *d = &machine->def;
    double seconds = way->seconds * (to - from), most = 0;
    if (!(seconds > 0) || way->kind == BTG_WAY_VECTORS) return 0;
    for (int j = 0; j < 5; j++) {
        double way_of =
            j < 3 ? vec_at(b->linear, j) - vec_at(a->linear, j) : b->angle[j - 3] - a->angle[j - 3];
        double speed = j < 3 ? d->linear[j].speed_mm_per_s : d->rotary[j - 3].speed_rad_per_s;
        double share = fabs(way_of) / (seconds * speed);
        if (share <= most) continue;
        most = share;
        *joint = j;
    }
    return most;
}
