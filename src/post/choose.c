/* Which solution and which turn of the rotary joints each position takes: the cheapest way through
 * a graph with one column of states a position, found by dynamic programming.
 *
 * A state is one of the two solutions and, where a joint's limits leave room for more than one, the
 * turn it is in. A joint with no limits, or with very wide ones, always goes to the nearest turn.
 */
#include "post/internal.h"

#include <stdio.h>
#include <string.h>

/* Limits of up to this many radians: each turn within them is a state of its own. */
#define RANGE_OF_STATES (6 * BTG_PI)

/* Costs are seconds at full rotary speed. A rewind costs more than any turning it could save, a
 * gap in the cut still more. */
#define REWIND_COST 1e4
#define GAP_COST    1e6
/* Settles ties, always in the same way: the first solution, where it costs nothing. */
#define TIE_COST 1e-9

#define GAP_FLAG  0x80
#define NO_REWIND 0xff

/* Turning that needs no look at what the tool does on the way: its axis strays by the square. */
#define SMALL_TURN_RAD (BTG_PI / 6)
/* Pieces in which a turn close to a limit is looked at. */
#define LIMIT_SAMPLES 8

static int solution_of(int state) {
    return state & 1;
}

/* Turn of a rotary joint in this state. */
static int turn_of(const btg_choice *c, int state, int joint) {
    int rest = state / 2;
    if (joint == 1 && c->turns[0] > 0) rest /= c->turns[0];
    if (joint == 0 && c->turns[0] > 0) rest %= c->turns[0];
    return c->first_turn[joint] + rest;
}

static void plan_turns(btg_choice *c) {
    c->states = 2;
    for (int j = 0; j < 2; j++) {
        const btg_rotary_def *r = &c->machine->def.rotary[j];
        double range = r->max_rad - r->min_rad;
        c->turns[j] = c->first_turn[j] = 0;
        c->wide[j] = range > RANGE_OF_STATES && range < INFINITY;
        if (c->wide[j]) c->turns[j] = 2;
        if (c->wide[j]) c->states *= 2;
        if (!(range <= RANGE_OF_STATES)) continue;
        int low = (int)ceil((r->min_rad - BTG_PI - BTG_LIMIT_SLACK_RAD) / (2 * BTG_PI));
        int high = (int)floor((r->max_rad + BTG_PI + BTG_LIMIT_SLACK_RAD) / (2 * BTG_PI));
        c->first_turn[j] = low;
        c->turns[j] = high - low + 1;
        c->states *= c->turns[j];
    }
}

btg_status btg_choice_open(btg_choice *c, const btg_machine *machine, double cone_rad,
                           size_t window, const btg_allocator *allocator) {
    memset(c, 0, sizeof *c);
    c->machine = machine;
    c->cone_rad = cone_rad;
    c->capacity = window;
    plan_turns(c);
    size_t states = (size_t)c->states;
    c->nodes = btg_allocate(allocator, window, sizeof *c->nodes);
    c->from = btg_allocate(allocator, window, states);
    c->rewind = btg_allocate(allocator, window, states);
    if (c->nodes && c->from && c->rewind) return BTG_OK;
    btg_choice_close(c, allocator);
    return BTG_ERROR_MEMORY;
}

void btg_choice_close(btg_choice *c, const btg_allocator *allocator) {
    btg_release(allocator, c->nodes);
    btg_release(allocator, c->from);
    btg_release(allocator, c->rewind);
    c->nodes = NULL;
    c->from = c->rewind = NULL;
}

/* ---- one state ---------------------------------------------------------------------------- */

static double nearest_turn(double base, double near) {
    return base + 2 * BTG_PI * round((near - base) / (2 * BTG_PI));
}

static bool allowed(const btg_rotary_def *r, double angle) {
    return angle >= r->min_rad - BTG_LIMIT_SLACK_RAD && angle <= r->max_rad + BTG_LIMIT_SLACK_RAD;
}

static double middle_of(const btg_rotary_def *r) {
    return (r->min_rad + r->max_rad) / 2;
}

/* Angles of a state at a node when the joints come from `near`. With `freely` they come over the
 * part, not along a cut. */
static bool place(const btg_choice *c, const btg_choice_node *node, int state, const double near[2],
                  bool freely, double at[2]) {
    if (!node->usable[solution_of(state)]) return false;
    for (int j = 0; j < 2; j++) {
        const btg_rotary_def *r = &c->machine->def.rotary[j];
        double base = node->base[solution_of(state)][j];
        if (j == node->free_axis) {
            at[j] = near[j];
        } else if (c->turns[j] > 0 && !c->wide[j]) {
            at[j] = base + 2 * BTG_PI * turn_of(c, state, j);
        } else {
            bool unwind = c->wide[j] && freely && turn_of(c, state, j) == 1;
            at[j] = nearest_turn(base, unwind ? middle_of(r) : near[j]);
        }
        if (!allowed(r, at[j])) return false;
    }
    return true;
}

static double travel_cost(const btg_choice *c, const double a[2], const double b[2]) {
    const btg_rotary_def *r = c->machine->def.rotary;
    return fabs(b[0] - a[0]) / r[0].speed_rad_per_s + fabs(b[1] - a[1]) / r[1].speed_rad_per_s;
}

static double angle_between(btg_vec3 a, btg_vec3 b) {
    return atan2(vec_norm(vec_cross(a, b)), vec_dot(a, b));
}

static double room_at(const btg_rotary_def *r, double angle) {
    return fmin(angle - r->min_rad, r->max_rad - angle);
}

/* Between a and b, both within the limits, a joint comes beyond one. */
static bool bulges(const btg_choice *c, const btg_choice_node *from, const btg_choice_node *to,
                   const double a[2], const double b[2]) {
    double turn = fabs(b[0] - a[0]) + fabs(b[1] - a[1]);
    bool close = false;
    for (int j = 0; j < 2; j++) {
        const btg_rotary_def *r = &c->machine->def.rotary[j];
        close = close || fmin(room_at(r, a[j]), room_at(r, b[j])) < turn;
    }
    for (int k = 1; k < LIMIT_SAMPLES && close; k++) {
        double part = (double)k / LIMIT_SAMPLES, at[2];
        double near[2] = {a[0] + (b[0] - a[0]) * part, a[1] + (b[1] - a[1]) * part};
        btg_vec3 axis = vec_unit(vec_mad(vec_scale(from->axis, 1 - part), to->axis, part));
        if (!btg_choice_nearest(c->machine, axis, c->cone_rad, near, at)) return true;
        if (!btg_choice_allowed(c->machine, at)) return true;
    }
    return false;
}

/* The tool can be cut along from a to b: no joint makes more than half a turn, and half-way the
 * axis is no further from where it belongs than the path itself turns it. From one solution to the
 * other the way leads through the pole: only where the path does, too. */
static bool continuous(const btg_choice *c, const btg_choice_node *from, const btg_choice_node *to,
                       const double a[2], const double b[2], bool other_solution) {
    bool flips = other_solution && from->free_axis < 0 && to->free_axis < 0;
    double t0 = fabs(b[0] - a[0]), t1 = fabs(b[1] - a[1]);
    if (t0 <= SMALL_TURN_RAD && t1 <= SMALL_TURN_RAD && !flips) return !bulges(c, from, to, a, b);
    if (fmax(t0, t1) > BTG_PI + BTG_LIMIT_SLACK_RAD) return false;
    double half[2] = {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2};
    btg_vec3 middle = vec_unit(vec_add(from->axis, to->axis));
    double stray = angle_between(btg_machine_axis(c->machine, half), middle);
    double most = 2 * c->cone_rad;
    if (!flips) most += angle_between(from->axis, to->axis) + SMALL_TURN_RAD / 1e3;
    return stray <= most && !bulges(c, from, to, a, b);
}

/* ---- a column ----------------------------------------------------------------------------- */

static void first_column(btg_choice *c, const btg_choice_node *node) {
    const double home[2] = {0, 0};
    for (int s = 0; s < c->states; s++) {
        c->now.cost[s] = INFINITY;
        if (!place(c, node, s, home, true, c->now.at[s])) continue;
        c->now.cost[s] = travel_cost(c, home, c->now.at[s]) + TIE_COST * solution_of(s);
    }
}

/* Before leaving node i: what each state costs when the tool may be lifted there and set down
 * again with the joints in another one. */
static void add_rewinds(btg_choice *c, size_t i) {
    uint8_t *rewind = c->rewind + i * (size_t)c->states;
    c->turned = c->now;
    for (int s = 0; s < c->states; s++) {
        rewind[s] = NO_REWIND;
        for (int p = 0; p < c->states; p++) {
            double at[2], cost = c->now.cost[p] + REWIND_COST;
            if (p == s || !(cost < c->turned.cost[s])) continue;
            if (!place(c, &c->nodes[i], s, c->now.at[p], true, at)) continue;
            cost += travel_cost(c, c->now.at[p], at);
            if (!(cost < c->turned.cost[s])) continue;
            c->turned.cost[s] = cost;
            memcpy(c->turned.at[s], at, sizeof at);
            rewind[s] = (uint8_t)p;
        }
    }
}

typedef enum reach { CUT, TRAVEL, GAP } reach;

/* Along a cut: on the pole a state stays the one it was, because the solutions are the same there;
 * where limits are wide one that has unwound stays apart from one that has not. */
static bool follows(const btg_choice *c, const btg_choice_node *to, int before, int state) {
    if (to->free_axis >= 0 && state != before) return false;
    for (int j = 0; j < 2; j++) {
        if (c->wide[j] && turn_of(c, before, j) != turn_of(c, state, j)) return false;
    }
    return true;
}

/* The next column from c->turned. False: no state is possible. */
static bool next_column(btg_choice *c, size_t i, reach how) {
    const btg_choice_node *from = &c->nodes[i - 1], *to = &c->nodes[i];
    uint8_t *back = c->from + i * (size_t)c->states;
    bool any = false;
    for (int s = 0; s < c->states; s++) {
        double best = INFINITY;
        for (int p = 0; p < c->states; p++) {
            double at[2], cost = c->turned.cost[p] + (how == GAP ? GAP_COST : 0);
            if (!(cost < best) || !place(c, to, s, c->turned.at[p], how != CUT, at)) continue;
            if (how == CUT && !follows(c, to, p, s)) continue;
            cost += travel_cost(c, c->turned.at[p], at) + TIE_COST * solution_of(s);
            if (!(cost < best)) continue;
            if (how == CUT &&
                !continuous(c, from, to, c->turned.at[p], at, solution_of(p) != solution_of(s)))
                continue;
            best = cost;
            back[s] = (uint8_t)(p | (how == GAP ? GAP_FLAG : 0));
            memcpy(c->now.at[s], at, sizeof at);
        }
        c->now.cost[s] = best;
        any = any || best < INFINITY;
    }
    return any;
}

/* ---- nodes -------------------------------------------------------------------------------- */

#define DEGREES(x) ((x) * (180 / BTG_PI))

/* Some turn of this angle is within the limits. */
static bool allows(const btg_rotary_def *r, double angle) {
    if (!isfinite(r->min_rad) || !isfinite(r->max_rad)) return true;
    double above = r->min_rad - BTG_LIMIT_SLACK_RAD - angle;
    return allowed(r, angle + 2 * BTG_PI * ceil(above / (2 * BTG_PI)));
}

/* Why these angles will not do. */
static void say_reason(const btg_choice *c, const btg_choice_node *n, const double angle[2],
                       int free_axis, char *text, size_t size) {
    const btg_machine_def *d = &c->machine->def;
    for (int j = 0; j < 2; j++) {
        const btg_rotary_def *r = &d->rotary[j];
        if (allows(r, angle[j]) || free_axis == j) continue;
        snprintf(text, size, "joint %c at %.3f degrees (limits %.3f to %.3f)", r->letter,
                 DEGREES(angle[j]), DEGREES(r->min_rad), DEGREES(r->max_rad));
        return;
    }
    btg_vec3 linear = btg_machine_linear(c->machine, n->tip, angle);
    int i = btg_machine_beyond(c->machine, linear);
    if (i < 0) i = 0;
    snprintf(text, size, "joint %c at %.3f mm (limits %.3f to %.3f)", 'X' + i, vec_at(linear, i),
             d->linear[i].min_mm, d->linear[i].max_mm);
}

static btg_status out_of_reach(const btg_choice *c, const btg_choice_node *n,
                               btg_message *message) {
    char text[2][96] = {"an axis that it cannot take", ""};
    double angle[2][2];
    int free_axis;
    if (btg_machine_angles(c->machine, n->axis, c->cone_rad, angle, &free_axis)) {
        for (int k = 0; k < 2; k++)
            say_reason(c, n, angle[k], free_axis, text[k], sizeof text[k]);
    }
    if (strcmp(text[0], text[1]) == 0) text[1][0] = '\0';
    return btg_fail(message, BTG_ERROR_UNSUPPORTED,
                    "machine %s: tip %.3f, %.3f, %.3f mm needs %s%s%s; lower --max-tilt, move "
                    "part_origin_mm, or take another machine",
                    c->machine->def.name, n->tip.x, n->tip.y, n->tip.z, text[0],
                    text[1][0] ? " or " : "", text[1]);
}

static bool fill(const btg_choice *c, btg_choice_node *n) {
    int free_axis;
    if (!btg_machine_angles(c->machine, n->axis, c->cone_rad, n->base, &free_axis)) return false;
    n->free_axis = (int8_t)free_axis;
    for (int k = 0; k < 2; k++) {
        btg_vec3 linear = btg_machine_linear(c->machine, n->tip, n->base[k]);
        n->usable[k] = free_axis >= 0 || btg_machine_beyond(c->machine, linear) < 0;
    }
    return true;
}

btg_status btg_choice_add(btg_choice *c, btg_vec3 tip, btg_vec3 axis, bool linked,
                          btg_message *message) {
    size_t i = c->count;
    btg_choice_node *n = &c->nodes[i];
    *n = (btg_choice_node){.tip = tip, .axis = axis, .linked = linked && i > 0};
    if (!fill(c, n)) return out_of_reach(c, n, message);
    bool any = false;
    if (i == 0) {
        first_column(c, n);
        for (int s = 0; s < c->states; s++)
            any = any || c->now.cost[s] < INFINITY;
    } else if (n->linked) {
        add_rewinds(c, i - 1);
        any = next_column(c, i, CUT) || next_column(c, i, GAP);
    } else {
        memset(c->rewind + (i - 1) * (size_t)c->states, NO_REWIND, (size_t)c->states);
        c->turned = c->now;
        any = next_column(c, i, TRAVEL);
    }
    if (!any) return out_of_reach(c, n, message);
    c->count++;
    return BTG_OK;
}

/* ---- the way back ------------------------------------------------------------------------- */

static void trace(btg_choice *c) {
    int best = 0;
    for (int s = 1; s < c->states; s++) {
        if (c->now.cost[s] < c->now.cost[best]) best = s;
    }
    size_t last = c->count - 1, states = (size_t)c->states;
    c->nodes[last].arrive = c->nodes[last].leave = (uint8_t)best;
    for (size_t i = last; i > 0; i--) {
        uint8_t back = c->from[i * states + c->nodes[i].arrive];
        btg_choice_node *before = &c->nodes[i - 1];
        if (back & GAP_FLAG) {
            c->nodes[i].gap = true;
            c->nodes[i].linked = false;
        }
        before->leave = back & (uint8_t)~GAP_FLAG;
        uint8_t rewind = c->rewind[(i - 1) * states + before->leave];
        before->arrive = rewind == NO_REWIND ? before->leave : rewind;
    }
}

/* Angles along the chosen way. The first node's are there already, if it is one carried over. */
static void follow(btg_choice *c, bool carried) {
    double at[2] = {0, 0};
    for (size_t i = 0; i < c->count; i++) {
        btg_choice_node *n = &c->nodes[i];
        if (i == 0 && carried) {
            memcpy(at, n->arrive_at, sizeof at);
        } else {
            place(c, n, n->arrive, at, !n->linked, at);
            memcpy(n->arrive_at, at, sizeof at);
        }
        if (n->leave != n->arrive) place(c, n, n->leave, at, true, at);
        memcpy(n->leave_at, at, sizeof at);
    }
}

/* Nodes first .. last-1 stand on the pole, linked: their free joint goes evenly from the angle
 * before to the one after, or is where it will be needed from the start. */
static void smooth_run(btg_choice *c, size_t first, size_t last) {
    int j = c->nodes[first].free_axis;
    bool before = c->nodes[first].linked, after = last < c->count && c->nodes[last].linked;
    if (!after) return;
    double b = c->nodes[last].arrive_at[j];
    double a = before ? c->nodes[first - 1].leave_at[j] : b;
    size_t steps = last - first + 1;
    for (size_t i = first; i < last; i++) {
        double part = (double)(i - first + 1) / (double)steps;
        c->nodes[i].arrive_at[j] = c->nodes[i].leave_at[j] = a + (b - a) * part;
    }
}

static void smooth(btg_choice *c, size_t from) {
    for (size_t i = from; i < c->count;) {
        size_t end = i + 1;
        if (c->nodes[i].free_axis >= 0 && c->nodes[i].arrive == c->nodes[i].leave) {
            while (end < c->count && c->nodes[end].linked && c->nodes[end].free_axis >= 0 &&
                   c->nodes[end].arrive == c->nodes[end].leave)
                end++;
            smooth_run(c, i, end);
        }
        i = end;
    }
}

void btg_choice_settle(btg_choice *c) {
    if (c->count == 0) return;
    trace(c);
    bool carried = c->settled;
    follow(c, carried);
    smooth(c, carried ? 1 : 0);
    c->settled = true;
}

void btg_choice_forget(btg_choice *c) {
    if (c->count == 0) return;
    btg_choice_node *last = &c->nodes[c->count - 1];
    int state = last->leave;
    for (int s = 0; s < c->states; s++)
        c->now.cost[s] = s == state ? 0 : INFINITY;
    c->nodes[0] = *last;
    c->count = 1;
}

bool btg_choice_allowed(const btg_machine *machine, const double angle[2]) {
    const btg_rotary_def *r = machine->def.rotary;
    return allowed(&r[0], angle[0]) && allowed(&r[1], angle[1]);
}

bool btg_choice_nearest(const btg_machine *machine, btg_vec3 axis, double cone,
                        const double near[2], double angle[2]) {
    double base[2][2], best = INFINITY;
    int free_axis;
    if (!btg_machine_angles(machine, axis, cone, base, &free_axis)) return false;
    for (int k = 0; k < 2; k++) {
        double at[2], cost = 0;
        for (int j = 0; j < 2; j++) {
            at[j] = j == free_axis ? near[j] : nearest_turn(base[k][j], near[j]);
            cost += fabs(at[j] - near[j]);
        }
        if (!(cost < best)) continue;
        best = cost;
        memcpy(angle, at, sizeof at);
    }
    return true;
}
