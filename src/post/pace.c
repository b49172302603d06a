/* How long each cutting block takes: what the feed asks, or longer, so that no joint is faster or
 * accelerates more than it can. A control that plans in the part's coordinates does not see the
 * joints' limits (LinuxCNC under its kinematics modules does not). */
#include "post/internal.h"

#include <string.h>

/* Turning by more than this is looked at in pieces: in between, linear joints may run faster than
 * the ends tell. */
#define PIECE_RAD  0.05
#define PIECES_MAX 256
/* Rounds in which neighbours share a change of speed that is too great. What is left after them
 * the last pass puts on the later one alone. */
#define SHARE_ROUNDS 8
/* The last pass lengthens by this factor until the change of speed fits, which it does when the
 * block is long enough; 200 of them are a factor of 1e8. */
#define LENGTHEN     1.1
#define LENGTHEN_MAX 200
/* mm and radians: less is no motion. Far below what a program's numbers show. */
#define STILL 1e-9
/* Below this excess a change of speed fits. */
#define FITS 1.0001

static double speed_of(const btg_machine_def *d, int joint) {
    return joint < 3 ? d->linear[joint].speed_mm_per_s : d->rotary[joint - 3].speed_rad_per_s;
}

static double acceleration_of(const btg_machine_def *d, int joint) {
    return joint < 3 ? d->linear[joint].acceleration_mm_per_s2
                     : d->rotary[joint - 3].acceleration_rad_per_s2;
}

/* Joints at a part of the way from a to b, as the control moves. */
static void joints_at(const btg_machine *m, const btg_stop *a, const btg_stop *b, double part,
                      double joint[5]) {
    for (int j = 0; j < 2; j++)
        joint[3 + j] = a->angle[j] + (b->angle[j] - a->angle[j]) * part;
    btg_vec3 tip = vec_mad(vec_scale(a->tip, 1 - part), b->tip, part);
    btg_vec3 linear = btg_machine_linear(m, tip, joint + 3);
    joint[0] = linear.x;
    joint[1] = linear.y;
    joint[2] = linear.z;
}

static void check_limits(btg_program *p, const double joint[5]) {
    btg_vec3 linear = vec(joint[0], joint[1], joint[2]);
    int i = btg_machine_beyond(&p->machine, linear);
    if (i < 0 || p->status != BTG_OK) return;
    const btg_linear_def *l = &p->machine.def.linear[i];
    btg_program_latch(p, btg_fail(&p->message, BTG_ERROR_UNSUPPORTED,
                                  "machine %s: the way needs joint %c at %.3f mm (limits %.3f "
                                  "to %.3f); move part_origin_mm or take another machine",
                                  p->machine.def.name, 'X' + i, joint[i], l->min_mm, l->max_mm));
}

/* Shortest time from a to b by speeds and by the acceleration within: the way bends. With `rest`
 * the joints start and end at rest. */
static double shortest(btg_program *p, const btg_stop *a, const btg_stop *b, bool rest) {
    const btg_machine_def *d = &p->machine.def;
    double turn = fabs(b->angle[0] - a->angle[0]) + fabs(b->angle[1] - a->angle[1]);
    int n = d->tcp && turn > STILL ? (int)fmin(1 + ceil(turn / PIECE_RAD), PIECES_MAX) : 1;
    double before[5], now[5], step[5] = {0}, seconds = 0;
    joints_at(&p->machine, a, b, 0, before);
    for (int k = 1; k <= n; k++) {
        joints_at(&p->machine, a, b, (double)k / n, now);
        check_limits(p, now);
        for (int j = 0; j < 5; j++) {
            double delta = now[j] - before[j], bend = fabs(delta - step[j]);
            double rate = acceleration_of(d, j);
            /* The speed changes within a piece by what it changes from one to the next. */
            double most = fabs(delta) + (k > 1 ? bend / 2 : 0);
            if (k == 2) most = fmax(most, fabs(step[j]) + bend / 2);
            seconds = fmax(seconds, most * n / speed_of(d, j));
            if (k > 1) seconds = fmax(seconds, n * sqrt(bend / rate));
            if (rest) seconds = fmax(seconds, 2 * sqrt(fabs(delta) * n / rate));
            step[j] = delta;
        }
        memcpy(before, now, sizeof now);
    }
    return seconds;
}

double btg_pace_alone(btg_program *p, const btg_stop *a, const btg_stop *b) {
    return shortest(p, a, b, true);
}

/* ---- changes of speed --------------------------------------------------------------------- */

/* Largest change of a joint's speed from one block to the next, over what it may change in half
 * of both. */
static double excess(const btg_machine_def *d, const btg_move *a, const btg_move *b) {
    double most = 0, half = (a->seconds + b->seconds) / 2;
    for (int j = 0; j < 5; j++) {
        double change = fabs(b->delta[j] / b->seconds - a->delta[j] / a->seconds);
        most = fmax(most, change / (acceleration_of(d, j) * half));
    }
    return most;
}

static bool share(btg_program *p) {
    bool changed = false;
    for (int i = p->moves_fixed; i < p->move_count; i++) {
        if (i == 0) continue;
        btg_move *a = &p->moves[i - 1], *b = &p->moves[i];
        double over = excess(&p->machine.def, a, b);
        if (over <= FITS) continue;
        double longer = sqrt(over);
        if (i - 1 >= p->moves_fixed) a->seconds *= longer;
        b->seconds *= longer;
        changed = true;
    }
    return changed;
}

static void fit(btg_program *p) {
    int round = 0;
    while (round < SHARE_ROUNDS && share(p))
        round++;
    for (int i = p->moves_fixed > 0 ? p->moves_fixed : 1; i < p->move_count; i++) {
        btg_move *b = &p->moves[i];
        for (int k = 0; k < LENGTHEN_MAX; k++) {
            if (excess(&p->machine.def, &p->moves[i - 1], b) <= FITS) break;
            b->seconds *= LENGTHEN;
        }
    }
}

/* ---- the queue ---------------------------------------------------------------------------- */

static void write_moves(btg_program *p, int end) {
    for (int i = p->moves_fixed; i < end; i++) {
        const btg_move *m = &p->moves[i];
        if (m->seconds > m->wanted_seconds * FITS) p->info.slowed++;
        p->info.cut_seconds += m->seconds;
        btg_gcode_cut(p, &m->end, m->seconds, m->length_mm, hypot(m->delta[3], m->delta[4]));
    }
    p->moves_fixed = end;
}

/* Room for more: three quarters leave; the last of those stays for its speed. */
static void make_room(btg_program *p) {
    int leave = p->move_count * 3 / 4, kept = leave - 1;
    fit(p);
    write_moves(p, leave);
    memmove(p->moves, p->moves + kept, (size_t)(p->move_count - kept) * sizeof *p->moves);
    p->move_count -= kept;
    p->moves_fixed = 1;
}

void btg_pace_start(btg_program *p, const btg_stop *stop) {
    p->paced = *stop;
    p->move_count = p->moves_fixed = 0;
    joints_at(&p->machine, stop, stop, 0, p->paced_joint);
}

void btg_pace_add(btg_program *p, const btg_stop *stop) {
    double joint[5];
    joints_at(&p->machine, stop, stop, 0, joint);
    double seconds = shortest(p, &p->paced, stop, false);
    double length = vec_norm(vec_sub(stop->tip, p->paced.tip));
    double wanted = length * 60 / p->def.feed_mm_per_min;
    bool still = true;
    btg_move m = {.end = *stop, .length_mm = length, .wanted_seconds = wanted};
    for (int j = 0; j < 5; j++) {
        m.delta[j] = joint[j] - p->paced_joint[j];
        if (fabs(m.delta[j]) > STILL) still = false;
    }
    if (still) return;
    m.seconds = fmax(seconds, wanted);
    if (p->move_count == BTG_MOVES_MAX) make_room(p);
    p->moves[p->move_count++] = m;
    p->paced = *stop;
    memcpy(p->paced_joint, joint, sizeof joint);
}

void btg_pace_drain(btg_program *p) {
    fit(p);
    write_moves(p, p->move_count);
    p->move_count = p->moves_fixed = 0;
}
