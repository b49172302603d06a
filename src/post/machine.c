/* Kinematics of machines with two rotary axes.
 *
 * A table turns the part, a head the tool: with T the table's motion, H the head's and J the linear
 * joints, T(part point) = J + H(tool point), where the tool point is (0, 0, -length) from the
 * spindle's nose. All three kinds give the tool's axis by one equation,
 *
 *     turn(e1, q1) turn(e2, q2) u = w
 *
 *     two in the table   u = axis in the part, w = z
 *     two in the head    u = z, w = axis in the part
 *     one in each        u = axis in the part, w = z, e1 the head's with its angle reversed
 *
 * solved in closed form: both circles meet at c = alpha e1 + beta e2 + gamma e1 x e2, twice. */
#include "post/internal.h"

#include <string.h>

#define MACHINE_DEF_VERSION 1

/* How far below 0 rounding may bring the square of gamma: directions have unit length. */
#define GAMMA_SLACK 1e-13
/* Sine of the angle to the pole that counts as the pole itself: below it the free joint's angle is
 * noise of the axis' last digits. */
#define POLE_SINE 1e-9
/* A unit vector's squared length may be off by this much. */
#define UNIT_SLACK 1e-6

static const btg_vec3 up = {0, 0, 1};

btg_machine_def btg_machine_def_default(void) {
    btg_machine_def def;
    memset(&def, 0, sizeof def);
    def.version = MACHINE_DEF_VERSION;
    strcpy(def.name, "machine");
    for (int i = 0; i < 3; i++)
        def.linear[i] = (btg_linear_def){-INFINITY, INFINITY, 250, 2500};
    for (int i = 0; i < 2; i++) {
        def.rotary[i].min_rad = -INFINITY;
        def.rotary[i].max_rad = INFINITY;
        def.rotary[i].speed_rad_per_s = BTG_PI / 3;
        def.rotary[i].acceleration_rad_per_s2 = BTG_PI;
    }
    def.tool_length_mm = 100;
    def.retract_z_mm = NAN;
    def.tcp = 1;
    return def;
}

/* ---- turning ------------------------------------------------------------------------------ */

static btg_vec3 turn(btg_vec3 e, double angle, btg_vec3 a) {
    double s = sin(angle), c = cos(angle);
    btg_vec3 r = vec_scale(a, c);
    r = vec_mad(r, vec_cross(e, a), s);
    return vec_mad(r, e, vec_dot(e, a) * (1 - c));
}

static btg_vec3 turn_about(const btg_rotary_def *r, double angle, btg_vec3 a) {
    return vec_add(turn(r->direction, angle, vec_sub(a, r->pivot)), r->pivot);
}

/* Angle about e that turns a towards b. From the parts across e alone: next to e they are what is
 * left of nearly equal numbers otherwise. */
static double angle_about(btg_vec3 e, btg_vec3 a, btg_vec3 b) {
    btg_vec3 p = vec_cross(e, a), q = vec_cross(e, b);
    return atan2(vec_dot(e, vec_cross(p, q)), vec_dot(p, q));
}

/* The head's rotary in a machine with one in each. */
static int head_of(const btg_machine_def *d) {
    return d->rotary[0].in_head ? 0 : 1;
}

static bool one_in_each(const btg_machine_def *d) {
    return d->rotary[0].in_head != d->rotary[1].in_head;
}

/* The equation's constant parts; the axis goes where u or w is missing. */
typedef struct equation {
    int first, second; /* rotary joints */
    double sign;       /* of the first one's angle */
    bool axis_is_w;
} equation;

static equation equation_of(const btg_machine_def *d) {
    if (one_in_each(d)) return (equation){head_of(d), 1 - head_of(d), -1, false};
    return (equation){0, 1, 1, d->rotary[0].in_head != 0};
}

/* ---- angles ------------------------------------------------------------------------------- */

static bool meet(btg_vec3 e1, btg_vec3 e2, btg_vec3 u, btg_vec3 w, btg_vec3 c[2]) {
    double d = vec_dot(e1, e2), eu = vec_dot(e2, u), ew = vec_dot(e1, w);
    btg_vec3 n = vec_cross(e1, e2);
    double n2 = vec_norm2(n);
    double alpha = (ew - d * eu) / n2, beta = (eu - d * ew) / n2;
    /* |c|^2 = 1, split so that no small difference of large numbers is left next to the pole. */
    double across_u = vec_norm2(vec_cross(u, e2)) - alpha * alpha * n2;
    double across_w = vec_norm2(vec_cross(w, e1)) - beta * beta * n2;
    double g2 = fabs(alpha) < fabs(beta) ? across_u : across_w;
    if (g2 < -GAMMA_SLACK) return false;
    double gamma = sqrt(fmax(g2, 0) / n2);
    btg_vec3 flat = vec_mad(vec_scale(e1, alpha), e2, beta);
    c[0] = vec_mad(flat, n, gamma);
    c[1] = vec_mad(flat, n, -gamma);
    return true;
}

static double wrap(double angle) {
    return angle > BTG_PI ? angle - 2 * BTG_PI : angle <= -BTG_PI ? angle + 2 * BTG_PI : angle;
}

bool btg_machine_angles(const btg_machine *machine, btg_vec3 axis, double cone, double angle[2][2],
                        int *free_axis) {
    const btg_machine_def *d = &machine->def;
    equation q = equation_of(d);
    btg_vec3 e1 = d->rotary[q.first].direction, e2 = d->rotary[q.second].direction;
    btg_vec3 pole = q.axis_is_w ? e1 : e2;
    double along = vec_dot(axis, pole);
    double away = vec_norm(vec_cross(axis, pole));
    bool at_pole = away <= fmax(POLE_SINE, sin(fmin(cone, BTG_PI / 2)));
    if (at_pole) axis = vec_scale(pole, along < 0 ? -1 : 1);
    btg_vec3 u = q.axis_is_w ? up : axis, w = q.axis_is_w ? axis : up;
    btg_vec3 c[2];
    *free_axis = at_pole ? (q.axis_is_w ? q.first : q.second) : -1;
    if (!meet(e1, e2, u, w, c)) return false;
    for (int k = 0; k < 2; k++) {
        angle[k][q.first] = wrap(q.sign * angle_about(e1, c[k], w));
        angle[k][q.second] = wrap(angle_about(e2, u, c[k]));
        if (at_pole) angle[k][*free_axis] = 0;
    }
    return true;
}

btg_vec3 btg_machine_axis(const btg_machine *machine, const double angle[2]) {
    const btg_machine_def *d = &machine->def;
    btg_vec3 a = up;
    for (int i = 1; i >= 0; i--) {
        if (d->rotary[i].in_head) a = turn(d->rotary[i].direction, angle[i], a);
    }
    for (int i = 0; i < 2; i++) {
        if (!d->rotary[i].in_head) a = turn(d->rotary[i].direction, -angle[i], a);
    }
    return a;
}

/* ---- points ------------------------------------------------------------------------------- */

/* The tip from the nose. */
static btg_vec3 head_tip(const btg_machine_def *d, const double angle[2]) {
    btg_vec3 a = vec(0, 0, -d->tool_length_mm);
    for (int i = 1; i >= 0; i--) {
        if (d->rotary[i].in_head) a = turn_about(&d->rotary[i], angle[i], a);
    }
    return a;
}

btg_vec3 btg_machine_linear(const btg_machine *machine, btg_vec3 tip, const double angle[2]) {
    const btg_machine_def *d = &machine->def;
    btg_vec3 a = vec_add(tip, d->part_origin);
    for (int i = 1; i >= 0; i--) {
        if (!d->rotary[i].in_head) a = turn_about(&d->rotary[i], angle[i], a);
    }
    return vec_sub(a, head_tip(d, angle));
}

btg_vec3 btg_machine_tip(const btg_machine *machine, btg_vec3 linear, const double angle[2]) {
    const btg_machine_def *d = &machine->def;
    btg_vec3 a = vec_add(linear, head_tip(d, angle));
    for (int i = 0; i < 2; i++) {
        if (!d->rotary[i].in_head) a = turn_about(&d->rotary[i], -angle[i], a);
    }
    return vec_sub(a, d->part_origin);
}

int btg_machine_beyond(const btg_machine *machine, btg_vec3 linear) {
    for (int i = 0; i < 3; i++) {
        const btg_linear_def *l = &machine->def.linear[i];
        double x = vec_at(linear, i);
        if (!(x >= l->min_mm - BTG_LIMIT_SLACK_MM && x <= l->max_mm + BTG_LIMIT_SLACK_MM)) return i;
    }
    return -1;
}

static bool within(btg_vec3 a) {
    return fabs(a.x) <= BTG_LENGTH_MAX && fabs(a.y) <= BTG_LENGTH_MAX &&
           fabs(a.z) <= BTG_LENGTH_MAX;
}

btg_status btg_machine_inverse(const btg_machine *machine, btg_vec3 tip, btg_vec3 axis,
                               btg_joints joints[2]) {
    double angle[2][2];
    int free_axis;
    if (!machine || !joints || !within(tip) || !(fabs(vec_norm2(axis) - 1) < UNIT_SLACK)) {
        return BTG_ERROR_ARGUMENT;
    }
    if (!btg_machine_angles(machine, vec_unit(axis), 0, angle, &free_axis)) {
        return BTG_ERROR_UNSUPPORTED;
    }
    for (int k = 0; k < 2; k++) {
        btg_vec3 linear = btg_machine_linear(machine, tip, angle[k]);
        joints[k] = (btg_joints){{linear.x, linear.y, linear.z}, {angle[k][0], angle[k][1]}};
    }
    return BTG_OK;
}

btg_status btg_machine_forward(const btg_machine *machine, const btg_joints *joints, btg_vec3 *tip,
                               btg_vec3 *axis) {
    if (!machine || !joints || !tip || !axis) return BTG_ERROR_ARGUMENT;
    btg_vec3 linear = vec(joints->linear_mm[0], joints->linear_mm[1], joints->linear_mm[2]);
    if (!vec_finite(linear) || !isfinite(joints->rotary_rad[0]) ||
        !isfinite(joints->rotary_rad[1])) {
        return BTG_ERROR_ARGUMENT;
    }
    *tip = btg_machine_tip(machine, linear, joints->rotary_rad);
    *axis = btg_machine_axis(machine, joints->rotary_rad);
    return BTG_OK;
}

/* ---- reach -------------------------------------------------------------------------------- */

#define RING_STEP_RAD (0.5 * (BTG_PI / 180))
#define RING_AXES     360
#define RING_HALVINGS 40
/* What leans by less is the pole, which is reached anyhow. */
#define RING_LEAST_RAD 1e-6

/* Some turn of the joint that gives the angle is within its limits. */
static bool some_turn_fits(const btg_rotary_def *r, double angle) {
    if (r->min_rad == -INFINITY || r->max_rad == INFINITY)
        return r->max_rad > r->min_rad; /* one end is open: some turn fits */
    double turns = ceil((r->min_rad - BTG_LIMIT_SLACK_RAD - angle) / (2 * BTG_PI));
    return angle + 2 * BTG_PI * turns <= r->max_rad + BTG_LIMIT_SLACK_RAD;
}

static bool reaches(const btg_machine *m, btg_vec3 axis) {
    double angle[2][2];
    int free_axis;
    if (!btg_machine_angles(m, axis, 0, angle, &free_axis)) return false;
    for (int k = 0; k < 2; k++) {
        bool all = true;
        for (int j = 0; j < 2; j++)
            all = all && (j == free_axis || some_turn_fits(&m->def.rotary[j], angle[k][j]));
        if (all) return true;
    }
    return false;
}

static bool reaches_ring(const btg_machine *m, double tilt) {
    for (int i = 0; i < RING_AXES; i++) {
        double way = i * (2 * BTG_PI / RING_AXES), s = sin(tilt);
        if (!reaches(m, vec(s * cos(way), s * sin(way), cos(tilt)))) return false;
    }
    return true;
}

double btg_machine_max_tilt(const btg_machine *m, double most) {
    double good = 0, bad = 0;
    while (bad < most) {
        bad = min2(good + RING_STEP_RAD, most);
        if (!reaches_ring(m, bad)) break;
        good = bad;
    }
    for (int i = 0; good < bad && i < RING_HALVINGS; i++) {
        double middle = (good + bad) / 2;
        if (reaches_ring(m, middle))
            good = middle;
        else
            bad = middle;
    }
    return good > RING_LEAST_RAD ? good : 0;
}
