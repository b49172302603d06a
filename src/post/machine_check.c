/* What a machine must be to be one, and the machines that are built in. */
#include "post/internal.h"

#include <string.h>

#define MACHINE_DEF_VERSION 1
/* Sine of the angle between two directions below which they count as one: a machine drawn with
 * such axes is a mistake. */
#define PARALLEL_SINE 1e-3
/* Largest speed, acceleration, angle (in turns some 160) and coordinate that makes sense. */
#define RATE_MAX 1e9
/* Smallest, a second: below, programs' feeds have no digits left. */
#define RATE_MIN  1e-4
#define ANGLE_MAX 1e3

#define DEGREES(x) ((x) * (BTG_PI / 180))

static btg_status refuse(btg_message *message, const char *member, const char *reason) {
    return btg_fail(message, BTG_ERROR_ARGUMENT, "%s: %s", member, reason);
}

static bool length_ok(double x) {
    return fabs(x) <= BTG_LENGTH_MAX;
}

static bool vec_ok(btg_vec3 a) {
    return length_ok(a.x) && length_ok(a.y) && length_ok(a.z);
}

/* `limit`: the largest finite bound. */
static bool range_ok(double min, double max, double limit) {
    bool min_ok = min == -INFINITY || fabs(min) <= limit;
    bool max_ok = max == INFINITY || fabs(max) <= limit;
    return min_ok && max_ok && min < max;
}

static bool rate_ok(double x) {
    return x >= RATE_MIN && x <= RATE_MAX;
}

static btg_status check_linear(const btg_linear_def *l, int i, btg_message *message) {
    char member[32] = "linear.";
    member[7] = (char)('X' + i);
    if (!range_ok(l->min_mm, l->max_mm, BTG_LENGTH_MAX)) {
        return refuse(message, strcat(member, ".limits_mm"),
                      "no range from a lower to a higher number; give two within 1e6 mm");
    }
    if (!rate_ok(l->speed_mm_per_s)) {
        return refuse(message, strcat(member, ".speed_mm_per_s"),
                      "not above 0.0001 mm/s; give a speed");
    }
    if (!rate_ok(l->acceleration_mm_per_s2)) {
        return refuse(message, strcat(member, ".acceleration_mm_per_s2"),
                      "not above 0.0001 mm/s2; give an acceleration");
    }
    return BTG_OK;
}

static btg_status check_rotary(const btg_rotary_def *r, int i, btg_message *message) {
    char member[48] = "rotary[0].";
    member[7] = (char)('0' + i);
    if (r->letter != 'A' && r->letter != 'B' && r->letter != 'C') {
        return refuse(message, strcat(member, "axis"), "no rotary axis; give A, B or C");
    }
    if (!vec_ok(r->direction) || !(vec_norm(r->direction) > 0)) {
        return refuse(message, strcat(member, "direction"),
                      "no direction; give x, y, z, not all 0");
    }
    if (!vec_ok(r->pivot)) {
        return refuse(message, strcat(member, "pivot_mm"), "not a point within 1e6 mm");
    }
    if (!range_ok(r->min_rad, r->max_rad, ANGLE_MAX)) {
        return refuse(message, strcat(member, "limits_deg"),
                      "no range from a lower to a higher angle; give two, or leave them out");
    }
    if (r->min_rad > BTG_PI || r->max_rad < -BTG_PI) {
        return refuse(message, strcat(member, "limits_deg"),
                      "the range is more than half a turn from 0; give one about 0");
    }
    if (!rate_ok(r->speed_rad_per_s)) {
        return refuse(message, strcat(member, "speed_deg_per_s"),
                      "not above 0.006 degrees/s; give a speed");
    }
    if (!rate_ok(r->acceleration_rad_per_s2)) {
        return refuse(message, strcat(member, "acceleration_deg_per_s2"),
                      "not above 0.006 degrees/s2; give an acceleration");
    }
    return BTG_OK;
}

static bool parallel(btg_vec3 a, btg_vec3 b) {
    return vec_norm(vec_cross(a, b)) < PARALLEL_SINE;
}

/* The axis that would turn the tool about itself, or the part about the tool. */
static int useless_axis(const btg_machine_def *d) {
    const btg_vec3 up = {0, 0, 1};
    if (!d->rotary[0].in_head && !d->rotary[1].in_head) {
        return parallel(d->rotary[0].direction, up) ? 0 : -1;
    }
    for (int i = 1; i >= 0; i--) {
        if (d->rotary[i].in_head) return parallel(d->rotary[i].direction, up) ? i : -1;
    }
    return -1;
}

static btg_status check_axes(const btg_machine_def *d, btg_message *message) {
    if (d->rotary[0].letter == d->rotary[1].letter) {
        return refuse(message, "rotary[1].axis", "the same letter as the first; give another");
    }
    if (parallel(d->rotary[0].direction, d->rotary[1].direction)) {
        return refuse(message, "rotary[1].direction",
                      "parallel to the first; five axes need two directions");
    }
    int useless = useless_axis(d);
    if (useless >= 0) {
        return refuse(message, useless == 0 ? "rotary[0].direction" : "rotary[1].direction",
                      "parallel to the spindle, so it tilts nothing; the axis that carries the "
                      "other comes first, give them in that order");
    }
    return BTG_OK;
}

static btg_status check_program(const btg_machine_def *d, btg_message *message) {
    if (!vec_ok(d->part_origin)) {
        return refuse(message, "part_origin_mm", "not a point within 1e6 mm");
    }
    if (!(d->tool_length_mm >= 0 && d->tool_length_mm <= BTG_LENGTH_MAX)) {
        return refuse(message, "tool_length_mm", "not a length from 0 to 1e6 mm");
    }
    if (!isnan(d->retract_z_mm) && !length_ok(d->retract_z_mm)) {
        return refuse(message, "retract_z_mm", "not a height within 1e6 mm");
    }
    if ((int)d->control < 0 || d->control > BTG_CONTROL_HEIDENHAIN) {
        return refuse(message, "program.control",
                      "unknown; give linuxcnc, fanuc, siemens or heidenhain");
    }
    bool able = d->control == BTG_CONTROL_FANUC || d->control == BTG_CONTROL_SIEMENS;
    if (d->vectors && (!able || !d->tcp)) {
        return refuse(message, "program.orientation",
                      "vectors need fanuc or siemens with tcp; give angles");
    }
    return BTG_OK;
}

btg_status btg_machine_init(const btg_machine_def *def, btg_machine *machine,
                            btg_message *message) {
    if (!def || !machine) return refuse(message, "machine", "definition or result is NULL");
    if (def->version != MACHINE_DEF_VERSION) {
        return refuse(message, "machine", "unknown version; start from btg_machine_def_default()");
    }
    btg_status status = BTG_OK;
    for (int i = 0; i < 3 && status == BTG_OK; i++)
        status = check_linear(&def->linear[i], i, message);
    for (int i = 0; i < 2 && status == BTG_OK; i++)
        status = check_rotary(&def->rotary[i], i, message);
    if (status != BTG_OK) return status;
    btg_machine result = {.def = *def};
    for (int i = 0; i < 2; i++)
        result.def.rotary[i].direction = vec_unit(def->rotary[i].direction);
    status = check_axes(&result.def, message);
    if (status == BTG_OK) status = check_program(&result.def, message);
    if (status == BTG_OK) *machine = result;
    return status;
}

/* ---- built in ----------------------------------------------------------------------------- */

static btg_rotary_def rotary(char letter, int in_head, btg_vec3 direction, double limit_deg) {
    btg_rotary_def r = btg_machine_def_default().rotary[0];
    r.letter = letter;
    r.in_head = in_head;
    r.direction = direction;
    r.min_rad = -DEGREES(limit_deg);
    r.max_rad = DEGREES(limit_deg);
    return r;
}

static btg_machine_def named(const char *name, btg_control control) {
    btg_machine_def d = btg_machine_def_default();
    strcpy(d.name, name);
    d.control = control;
    for (int i = 0; i < 3; i++) {
        d.linear[i].min_mm = -500;
        d.linear[i].max_mm = 500;
    }
    d.retract_z_mm = 500;
    return d;
}

/* A table A or B that carries a table C, with LinuxCNC's directions: the part turns by +angle. */
static btg_machine_def trt(const char *name, char letter) {
    btg_machine_def d = named(name, BTG_CONTROL_LINUXCNC);
    btg_vec3 tilt = letter == 'A' ? vec(1, 0, 0) : vec(0, 1, 0);
    d.rotary[0] = rotary(letter, 0, tilt, 120);
    d.rotary[1] = rotary('C', 0, vec(0, 0, 1), 36000);
    d.inverse_time = 1;
    return d;
}

#define BUILT_IN 5

btg_status btg_machine_at(size_t index, btg_machine_def *def) {
    if (!def || index >= BUILT_IN) return BTG_ERROR_ARGUMENT;
    btg_machine_def d;
    switch (index) {
    case 0:
        d = trt("xyzac-trt", 'A');
        break;
    case 1:
        d = trt("xyzbc-trt", 'B');
        break;
    case 2:
        d = named("fanuc", BTG_CONTROL_FANUC);
        d.rotary[0] = rotary('A', 0, vec(-1, 0, 0), 120);
        d.rotary[1] = rotary('C', 0, vec(0, 0, -1), INFINITY);
        break;
    case 3:
        d = named("siemens", BTG_CONTROL_SIEMENS);
        d.vectors = 1;
        d.rotary[0] = rotary('C', 1, vec(0, 0, 1), 360);
        d.rotary[1] = rotary('A', 1, vec(1, 0, 0), 110);
        break;
    default:
        d = named("heidenhain", BTG_CONTROL_HEIDENHAIN);
        d.rotary[0] = rotary('B', 1, vec(0, 1, 0), 110);
        d.rotary[1] = rotary('C', 0, vec(0, 0, -1), INFINITY);
        break;
    }
    *def = d;
    return BTG_OK;
}

btg_status btg_machine_find(const char *name, btg_machine_def *def) {
    btg_machine_def d;
    if (!name || !def) return BTG_ERROR_ARGUMENT;
    for (size_t i = 0; btg_machine_at(i, &d) == BTG_OK; i++) {
        if (strcmp(name, d.name) != 0) continue;
        *def = d;
        return BTG_OK;
    }
    return BTG_ERROR_ARGUMENT;
}
