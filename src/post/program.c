/* From positions to cuts and to the ways between them. */
#include "post/internal.h"

#include <string.h>

#define PROGRAM_DEF_VERSION 1
/* Slower ones have no digits left in the words. */
#define FEED_MIN 1e-3

/* The tip's way between cuts, over the part, may stray by this much; it is led that much higher. */
#define TRAVEL_TOLERANCE_MM 1.0
#define TRAVEL_DEPTH_MAX    8
/* Points at which the lean on such a way is looked at. */
#define LEAN_SAMPLES 32
/* Halvings of the way to a limit, and how close two ends of it count as the same. */
#define LIMIT_HALVINGS 40
#define LIMIT_CLOSE    1e-6
/* Smallest share of the tolerance that a number's last digit stands for. */
#define ROUNDING_SHARE 0.1

btg_program_def btg_program_def_default(void) {
    btg_program_def def;
    memset(&def, 0, sizeof def);
    def.version = PROGRAM_DEF_VERSION;
    def.feed_mm_per_min = 1000;
    def.clear_z_mm = NAN;
    def.approach_mm = 2;
    def.tolerance_mm = 0.002;
    def.cone_rad = NAN;
    def.tool_number = 1;
    def.spindle_rpm = 3000;
    def.window = 262144;
    return def;
}

void btg_program_latch(btg_program *p, btg_status status) {
    if (status != BTG_OK && p->status == BTG_OK) p->status = status;
}

/* ---- set-up ------------------------------------------------------------------------------- */

static btg_status refuse(btg_message *message, const char *what, double value) {
    return btg_fail(message, BTG_ERROR_ARGUMENT, "program: %s, not %g", what, value);
}

static btg_status check(const btg_program_def *d, btg_message *message) {
    if (d->version != PROGRAM_DEF_VERSION) {
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "program: unknown version; start from btg_program_def_default()");
    }
    if (!d->write) {
        return btg_fail(message, BTG_ERROR_ARGUMENT, "program: no function to write with");
    }
    if (!(d->feed_mm_per_min >= FEED_MIN && d->feed_mm_per_min <= BTG_LENGTH_MAX)) {
        return refuse(message, "give a feed of 0.001 to 1e6 mm per minute", d->feed_mm_per_min);
    }
    if (!(fabs(d->clear_z_mm) <= BTG_LENGTH_MAX)) {
        return refuse(message, "give a height over the part to retract to, in mm", d->clear_z_mm);
    }
    if (!(d->approach_mm >= 0 && d->approach_mm <= BTG_LENGTH_MAX)) {
        return refuse(message, "give an approach of 0 or more mm", d->approach_mm);
    }
    if (!(d->tolerance_mm >= 1e-6 && d->tolerance_mm <= 1)) {
        return refuse(message, "give a tolerance of 1e-6 to 1 mm", d->tolerance_mm);
    }
    if (!isnan(d->cone_rad) && !(d->cone_rad >= 0 && d->cone_rad <= BTG_PI / 4)) {
        return refuse(message, "give a cone of 0 to pi/4", d->cone_rad);
    }
    if (!(d->spindle_rpm >= 0 && d->spindle_rpm <= 1e6)) {
        return refuse(message, "give a spindle speed of 0 to 1e6", d->spindle_rpm);
    }
    if (d->tool_number > 99999999) {
        return refuse(message, "give a tool number of up to 8 digits", (double)d->tool_number);
    }
    if (d->window < 2 || d->window > SIZE_MAX / sizeof(btg_choice_node)) {
        return refuse(message, "give a window of at least 2 positions", (double)d->window);
    }
    return BTG_OK;
}

/* Decimals with which a rounding error times `reach` is a small share of the tolerance. */
static int decimals(double tolerance, double reach) {
    double unit = 1;
    int n = 0;
    while (n < BTG_DECIMALS_MAX - 1 && 0.5 * unit * reach > ROUNDING_SHARE * tolerance) {
        unit /= 10;
        n++;
    }
    return n < 1 ? 1 : n;
}

/* How far from the rotary axes a turn may move the tool: without tool-centre-point control, all of
 * the machine. */
static double turning_reach(const btg_machine_def *d, double cutter) {
    if (d->tcp) return cutter;
    double reach = d->tool_length_mm + cutter + 500;
    for (int i = 0; i < 2; i++)
        reach += vec_norm(
            vec_sub(d->rotary[i].pivot, d->rotary[i].in_head ? vec(0, 0, 0) : d->part_origin));
    return reach;
}

static void set_up(btg_program *p) {
    const btg_tool_def *t = &p->tool.def;
    p->reach_mm = t->major_radius_mm + t->minor_radius_mm;
    p->axis_tolerance_rad = fmin(p->def.tolerance_mm / p->reach_mm, 0.01);
    if (isnan(p->def.cone_rad)) p->def.cone_rad = p->axis_tolerance_rad / 2;
    p->decimals_mm = decimals(p->def.tolerance_mm, 1);
    p->decimals_deg =
        decimals(p->def.tolerance_mm, turning_reach(&p->machine.def, p->reach_mm) * BTG_PI / 180);
    p->broken = true;
    p->motion = -1;
    p->last_feed = NAN;
}

btg_status btg_program_create(const btg_program_def *def, const btg_machine *machine,
                              const btg_tool *tool, btg_program **program, btg_message *message) {
    if (!def || !machine || !tool || !program) {
        return btg_fail(message, BTG_ERROR_ARGUMENT, "program: an argument is NULL");
    }
    btg_status status = check(def, message);
    if (status != BTG_OK) return status;
    btg_program *p = btg_allocate(&def->allocator, 1, sizeof *p);
    if (!p) return btg_fail(message, BTG_ERROR_MEMORY, "program: out of memory");
    memset(p, 0, sizeof *p);
    p->def = *def;
    p->machine = *machine;
    p->tool = *tool;
    set_up(p);
    status =
        btg_choice_open(&p->choice, &p->machine, p->def.cone_rad, def->window, &def->allocator);
    if (status != BTG_OK) {
        btg_release(&def->allocator, p);
        return btg_fail(message, status, "program: no memory for %zu positions; lower the window",
                        def->window);
    }
    btg_gcode_begin(p);
    p->def.name = NULL;
    *program = p;
    return BTG_OK;
}

void btg_program_destroy(btg_program *p) {
    if (!p) return;
    btg_allocator allocator = p->def.allocator;
    btg_choice_close(&p->choice, &allocator);
    btg_release(&allocator, p);
}

/* ---- ways over the part ------------------------------------------------------------------- */

static double lift_z(const btg_program *p, btg_vec3 tip, btg_vec3 axis) {
    return fmax(tip.z, btg_post_lift_z(&p->tool, axis, p->def.clear_z_mm));
}

static btg_stop above(const btg_stop *stop, double z) {
    btg_stop s = *stop;
    s.tip.z = z;
    return s;
}

/* Height at which the tool, leaning as it does on the way, stays clear. */
static double travel_z(const btg_program *p, const btg_stop *a, const btg_stop *b) {
    double z = fmax(lift_z(p, a->tip, a->axis), lift_z(p, b->tip, b->axis));
    for (int k = 1; k < LEAN_SAMPLES; k++) {
        double part = (double)k / LEAN_SAMPLES;
        double angle[2] = {a->angle[0] + (b->angle[0] - a->angle[0]) * part,
                           a->angle[1] + (b->angle[1] - a->angle[1]) * part};
        btg_vec3 axis = btg_machine_axis(&p->machine, angle);
        z = fmax(z, btg_post_lift_z(&p->tool, axis, p->def.clear_z_mm));
    }
    return p->machine.def.tcp ? z : z + TRAVEL_TOLERANCE_MM;
}

/* Joints alone: in pieces whose tips stay near the straight way. */
static void across_in_pieces(btg_program *p, const btg_stop *a, const btg_stop *b, int depth) {
    double tip, axis;
    btg_stray(p, a, b, &tip, &axis);
    if (depth == TRAVEL_DEPTH_MAX || tip <= TRAVEL_TOLERANCE_MM) {
        btg_pace_alone(p, a, b);
        btg_gcode_rapid(p, b);
        return;
    }
    btg_stop middle = {.tip = vec_scale(vec_add(a->tip, b->tip), 0.5)};
    for (int j = 0; j < 2; j++)
        middle.angle[j] = (a->angle[j] + b->angle[j]) / 2;
    middle.axis = btg_machine_axis(&p->machine, middle.angle);
    across_in_pieces(p, a, &middle, depth + 1);
    across_in_pieces(p, &middle, b, depth + 1);
}

/* LinuxCNC does not hold joints to their speeds while its kinematics turn: those ways are timed. */
static void across(btg_program *p, const btg_stop *b) {
    const btg_machine_def *d = &p->machine.def;
    const btg_stop a = p->at;
    bool turns = a.angle[0] != b->angle[0] || a.angle[1] != b->angle[1];
    p->at = *b;
    if (!d->tcp && turns) {
        across_in_pieces(p, &a, b, 0);
        return;
    }
    double seconds = btg_pace_alone(p, &a, b);
    if (d->tcp && turns && d->control == BTG_CONTROL_LINUXCNC) {
        double turn = hypot(b->angle[0] - a.angle[0], b->angle[1] - a.angle[1]);
        btg_gcode_cut(p, b, seconds, vec_norm(vec_sub(b->tip, a.tip)), turn);
    } else {
        btg_gcode_rapid(p, b);
    }
}

void btg_travel(btg_program *p, const btg_stop *b) {
    btg_stop start = above(b, b->tip.z + p->def.approach_mm);
    if (p->started) {
        double z = travel_z(p, &p->at, b);
        btg_stop up = above(&p->at, z), over = above(b, z);
        btg_pace_drain(p);
        across(p, &up);
        across(p, &over);
    } else {
        /* Under LinuxCNC's kinematics the joints cannot turn before the tool is over the part. */
        bool late = p->machine.def.tcp && p->machine.def.control == BTG_CONTROL_LINUXCNC;
        btg_stop rest = {.tip = b->tip, .axis = {0, 0, 1}};
        if (!late) rest = *b;
        btg_stop over = above(b, travel_z(p, &rest, b));
        p->at = above(&rest, over.tip.z);
        btg_gcode_first(p, &p->at);
        across(p, &over);
    }
    if (start.tip.z < p->at.tip.z) across(p, &start);
    p->started = true;
    btg_pace_start(p, &p->at);
    btg_pace_add(p, b);
    p->at = *b;
}

/* ---- positions ---------------------------------------------------------------------------- */

static btg_stop stop_of(const btg_program *p, const btg_choice_node *n, const double angle[2]) {
    btg_stop s = {.tip = n->tip, .axis = n->axis, .angle = {angle[0], angle[1]}};
    if (n->free_axis >= 0 && !p->machine.def.vectors) s.axis = btg_machine_axis(&p->machine, angle);
    return s;
}

/* The point at `part` of the way from a to b, joints near those of `near`. */
static bool on_the_way(const btg_program *p, const btg_stop *a, const btg_stop *b, double part,
                       const btg_stop *near, btg_stop *s) {
    s->tip = vec_mad(vec_scale(a->tip, 1 - part), b->tip, part);
    s->axis = vec_unit(vec_mad(vec_scale(a->axis, 1 - part), b->axis, part));
    return btg_choice_nearest(&p->machine, s->axis, 0, near->angle, s->angle) &&
           btg_choice_allowed(&p->machine, s->angle);
}

/* How far from a towards b the limits let the joints go as they stand at a; *s: that point. */
static double as_far_as(const btg_program *p, const btg_stop *a, const btg_stop *b, btg_stop *s) {
    double low = 0, high = 1;
    *s = *a;
    for (int i = 0; i < LIMIT_HALVINGS; i++) {
        btg_stop try;
        double part = (low + high) / 2;
        bool ok = on_the_way(p, a, b, part, s, &try);
        if (ok) *s = try;
        if (ok) low = part;
        if (!ok) high = part;
    }
    return low;
}

/* A limit lies between: up to it, over the part to the other end of the range, and on. Where that
 * is a turn away both are the same pose; a smaller range leaves a gap. */
static void cross_limit(btg_program *p, const btg_stop *b) {
    btg_stop a = p->at, near, far;
    double from = as_far_as(p, &a, b, &near), back = as_far_as(p, b, &a, &far);
    p->info.rewinds++;
    p->info.retracts++;
    if (from + back < 1 - LIMIT_CLOSE) p->info.gaps++;
    if (from > 0) btg_refine(p, &a, &near);
    p->at = near;
    btg_travel(p, &far);
    if (back > 0) btg_refine(p, &far, b);
    p->at = *b;
}

/* The joints go to another solution or turn, the tool lifted. A control that is given vectors
 * does that by itself. */
static void turn_over(btg_program *p, const btg_choice_node *n) {
    btg_stop turned = stop_of(p, n, n->leave_at);
    if (p->machine.def.vectors) {
        btg_pace_drain(p);
        btg_pace_start(p, &turned);
        p->at = turned;
        return;
    }
    p->info.retracts++;
    p->info.rewinds++;
    btg_travel(p, &turned);
}

static void write_node(btg_program *p, const btg_choice_node *before, const btg_choice_node *n) {
    btg_stop stop = stop_of(p, n, n->arrive_at);
    if (n->gap) {
        cross_limit(p, &stop);
        return;
    }
    if (!before || !n->linked) {
        if (before) p->info.retracts++;
        btg_travel(p, &stop);
        return;
    }
    if (before->leave != before->arrive) turn_over(p, before);
    btg_refine(p, &p->at, &stop);
    p->at = stop;
}

/* Decides and writes all nodes; the last one stays, as the place to go on from. */
static void settle(btg_program *p) {
    btg_choice *c = &p->choice;
    bool carried = c->settled;
    btg_choice_settle(c);
    for (size_t i = carried ? 1 : 0; i < c->count && p->status == BTG_OK; i++)
        write_node(p, i > 0 ? &c->nodes[i - 1] : NULL, &c->nodes[i]);
    btg_choice_forget(c);
}

static bool usable(const btg_position *q) {
    return fabs(q->tip.x) <= BTG_LENGTH_MAX && fabs(q->tip.y) <= BTG_LENGTH_MAX &&
           fabs(q->tip.z) <= BTG_LENGTH_MAX && fabs(vec_norm2(q->axis) - 1) < 1e-6;
}

static btg_status give(btg_program *p, btg_message *message) {
    if (p->status == BTG_OK) return BTG_OK;
    if (!p->message.text[0]) btg_fail(&p->message, p->status, "program: cannot write");
    return btg_fail(message, p->status, "%s", p->message.text);
}

btg_status btg_program_add(btg_program *p, const btg_position *position, int link,
                           btg_message *message) {
    if (!p || !position) return btg_fail(message, BTG_ERROR_ARGUMENT, "program: argument is NULL");
    if (p->status != BTG_OK) return give(p, message);
    if (position->status < 0 || position->status == BTG_NO_CONTACT) {
        p->broken = true;
        return BTG_OK;
    }
    if (!usable(position)) {
        p->status = btg_fail(&p->message, BTG_ERROR_ARGUMENT,
                             "program: position %llu is not finite or its axis not unit",
                             (unsigned long long)p->info.positions);
        return give(p, message);
    }
    if (p->choice.count == p->choice.capacity) settle(p);
    if (p->status == BTG_OK) {
        p->status = btg_choice_add(&p->choice, position->tip, vec_unit(position->axis),
                                   link && !p->broken, &p->message);
    }
    p->broken = false;
    p->info.positions++;
    return give(p, message);
}

/* LinuxCNC's kinematics stay on: only with the joints at 0 is its Z the machine's. */
static void turn_home(btg_program *p) {
    const btg_machine_def *d = &p->machine.def;
    bool stays = d->tcp && d->control == BTG_CONTROL_LINUXCNC;
    if (!stays || isnan(d->retract_z_mm)) return;
    btg_stop home = {.tip = p->at.tip, .axis = {0, 0, 1}};
    home.tip.z = travel_z(p, &p->at, &home);
    across(p, &home);
}

btg_status btg_program_end(btg_program *p, btg_program_info *info, btg_message *message) {
    if (!p) return btg_fail(message, BTG_ERROR_ARGUMENT, "program: argument is NULL");
    settle(p);
    if (p->started && p->status == BTG_OK) {
        btg_pace_drain(p);
        btg_stop up = above(&p->at, lift_z(p, p->at.tip, p->at.axis));
        across(p, &up);
        turn_home(p);
    }
    if (p->status == BTG_OK) {
        btg_gcode_end(p);
        btg_gcode_flush(p);
    }
    if (info) *info = p->info;
    return give(p, message);
}
