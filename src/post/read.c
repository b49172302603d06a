/* What the words of a program mean to its control; see read.h. */
#include "post/read.h"
#include "post/internal.h"

#include <string.h>

#define RADIANS(x) ((x) * (BTG_PI / 180))
#define DEGREES(x) ((x) * (180 / BTG_PI))
/* A program's numbers are rounded: a joint may be this far beyond a limit. */
#define LIMIT_SLACK_MM  1e-3
#define LIMIT_SLACK_RAD 2e-5
/* A tool vector's length may differ from 1 by this much. */
#define VECTOR_SLACK 1e-3
/* Feeds are in mm per minute where the tip moves by more than this, else in degrees. */
#define STILL_MM 1e-6

#define AGAIN "not understood; give straight moves in absolute millimetres"

void btg_reader_open(btg_reader *r, const btg_machine *machine, double error_mm, double reach_mm) {
    memset(r, 0, sizeof *r);
    r->machine = machine;
    r->error_mm = error_mm;
    r->reach_mm = reach_mm;
    r->motion = -1;
    r->tool = r->promised[0] = r->promised[1] = -1;
    /* LinuxCNC's kinematics are on from the start, its joints at 0. */
    r->tcp = machine->def.control == BTG_CONTROL_LINUXCNC && machine->def.tcp;
    r->known[3] = r->known[4] = r->tcp;
}

static bool is(const btg_reader *r, btg_control control) {
    return r->machine->def.control == control;
}

static btg_status refuse(btg_message *message, const char *reason) {
    return btg_fail(message, BTG_ERROR_FORMAT, "%s", reason);
}

/* ---- where it stands ------------------------------------------------------------------------ */

static bool all_known(const btg_reader *r) {
    return r->known[0] && r->known[1] && r->known[2] && r->known[3] && r->known[4];
}

/* From joints to the tip in the part frame, or back. Unknown what one of them is: then all linear
 * ones are. */
static void set_tcp(btg_reader *r, bool tcp, bool vectors) {
    btg_vec3 at = vec(r->at[0], r->at[1], r->at[2]);
    if (r->vectors && !vectors) r->known[3] = r->known[4] = false;
    if (tcp && vectors && !r->vectors) r->axis = btg_machine_axis(r->machine, r->at + 3);
    r->vectors = tcp && vectors;
    if (tcp == r->tcp) return;
    r->tcp = tcp;
    if (all_known(r)) {
        at = tcp ? btg_machine_tip(r->machine, at, r->at + 3)
                 : btg_machine_linear(r->machine, at, r->at + 3);
        r->at[0] = at.x, r->at[1] = at.y, r->at[2] = at.z;
        return;
    }
    r->known[0] = r->known[1] = r->known[2] = false;
    r->posed = false;
}

/* What a linear word is measured from. */
static double origin(const btg_reader *r, int i, bool machine_frame) {
    const btg_machine_def *d = &r->machine->def;
    double length = i == 2 ? d->tool_length_mm : 0, offset = vec_at(d->part_origin, i);
    /* Machine coordinates under LinuxCNC's kinematics: the tip's, turned back, and the length. */
    if (r->tcp) return machine_frame ? -offset - length : 0;
    if (machine_frame) return 0;
    return offset + (r->length ? length : 0);
}

/* ---- codes that last ------------------------------------------------------------------------ */

static btg_status set_length(btg_reader *r, const btg_block *b, int code, btg_message *message) {
    bool under = code != 430;
    if (under && !is(r, BTG_CONTROL_FANUC))
        return refuse(message, "G43.4 and G43.5 are Fanuc's; give another machine");
    if (b->has['H' - 'A'] && r->tool >= 0 && (long)b->value['H' - 'A'] != r->tool)
        return refuse(message, "H is not the tool in the spindle; give its number");
    r->length = true;
    if (is(r, BTG_CONTROL_FANUC)) set_tcp(r, under, code == 435);
    return BTG_OK;
}

static btg_status take_g(btg_reader *r, const btg_block *b, int code, bool *machine_frame,
                         btg_message *message) {
    bool siemens = is(r, BTG_CONTROL_SIEMENS);
    switch (code) {
    case 0:
    case 10:
        r->motion = code / 10;
        return BTG_OK;
    case 170: /* planes, millimetres, absolute, nothing compensated, smoothing, work offset */
    case 400:
    case 540:
    case 640:
    case 900:
        return BTG_OK;
    case 210:
    case 800:
        if (!siemens) return BTG_OK;
        break;
    case 710:
    case 7100:
        if (siemens) return BTG_OK;
        break;
    case 430:
    case 434:
    case 435:
        if (!siemens) return set_length(r, b, code, message);
        break;
    case 490:
        if (siemens) break;
        r->length = false;
        if (is(r, BTG_CONTROL_FANUC)) set_tcp(r, false, false);
        return BTG_OK;
    case 530:
        *machine_frame = true;
        if (!siemens) return BTG_OK;
        break;
    case 930:
    case 940:
        r->inverse_time = code == 930;
        return BTG_OK;
    default:
        break;
    }
    return btg_fail(message, BTG_ERROR_FORMAT, "'G%g': " AGAIN, code / 10.0);
}

static btg_status take_m(btg_reader *r, int code, bool *machine_frame, btg_message *message) {
    bool heidenhain = is(r, BTG_CONTROL_HEIDENHAIN);
    bool plain = code <= 9 && code != 2;
    if (code == 2 || code == 30) {
        r->ended = true;
    } else if (heidenhain && code == 91) {
        *machine_frame = true;
    } else if (heidenhain && (code == 128 || code == 129)) {
        set_tcp(r, code == 128, false);
    } else if (!plain && !(code == 428 && is(r, BTG_CONTROL_LINUXCNC) && r->tcp)) {
        return btg_fail(message, BTG_ERROR_FORMAT, "'M%d': " AGAIN, code);
    }
    return BTG_OK;
}

static btg_status take_keywords(btg_reader *r, const btg_block *b, btg_message *message) {
    unsigned k = b->keywords;
    if (k & BTG_KEYWORD_TRAFOOF) set_tcp(r, false, false);
    if (k & BTG_KEYWORD_TRAORI) set_tcp(r, true, false);
    if (k & (BTG_KEYWORD_ORIVECT | BTG_KEYWORD_ORIAXES)) {
        if (!r->tcp) return refuse(message, "ORIVECT or ORIAXES without TRAORI; give it first");
        set_tcp(r, true, (k & BTG_KEYWORD_ORIVECT) != 0);
    }
    if (k & BTG_KEYWORD_TOOL) {
        r->tool = b->tool;
        r->length = true;
    }
    if (k & BTG_KEYWORD_BEGIN) r->inside = true;
    if (k & BTG_KEYWORD_END) r->ended = true;
    if (k & BTG_KEYWORD_L) r->motion = k & BTG_KEYWORD_FMAX ? 0 : 1;
    return BTG_OK;
}

/* Words that go with nothing in the line, or with nothing at all. */
static btg_status check_letters(const btg_reader *r, const btg_block *b, btg_message *message) {
    char known[32] = "NTSFXYZ";
    size_t n = strlen(known);
    for (int i = 0; i < 2; i++)
        known[n++] = r->machine->def.rotary[i].letter;
    for (int i = 0; i < b->g_count; i++) {
        if (b->g[i] >= 430 && b->g[i] < 440) known[n++] = 'H';
        if (b->g[i] == 640) known[n++] = 'P', known[n++] = 'Q';
        if (n > sizeof known - 8) break;
    }
    if (is(r, BTG_CONTROL_FANUC)) known[n++] = 'O';
    if (is(r, BTG_CONTROL_SIEMENS)) known[n++] = 'D';
    if (is(r, BTG_CONTROL_HEIDENHAIN) && b->value['R' - 'A'] == 0) known[n++] = 'R';
    if (is(r, BTG_CONTROL_FANUC) && r->vectors)
        known[n++] = 'I', known[n++] = 'J', known[n++] = 'K';
    for (int i = 0; i < 26; i++)
        if (b->has[i] && !memchr(known, 'A' + i, n))
            return btg_fail(message, BTG_ERROR_FORMAT, "'%c': " AGAIN, 'A' + i);
    return BTG_OK;
}

static btg_status take_modal(btg_reader *r, const btg_block *b, bool *machine_frame,
                             btg_message *message) {
    btg_status status = BTG_OK;
    *machine_frame = (b->keywords & BTG_KEYWORD_SUPA) != 0;
    if (b->has['T' - 'A']) r->tool = (long)b->value['T' - 'A'];
    if (b->has['D' - 'A']) r->length = b->value['D' - 'A'] != 0;
    for (int i = 0; i < b->g_count && status == BTG_OK; i++)
        status = take_g(r, b, b->g[i], machine_frame, message);
    for (int i = 0; i < b->m_count && status == BTG_OK; i++)
        status = take_m(r, b->m[i], machine_frame, message);
    if (status == BTG_OK) status = take_keywords(r, b, message);
    if (status == BTG_OK) status = check_letters(r, b, message);
    if (status != BTG_OK || !b->has['F' - 'A']) return status;
    if (!(b->value['F' - 'A'] > 0)) return refuse(message, "F is not above 0; give a feed");
    if (!r->inverse_time) r->feed = b->value['F' - 'A'];
    return BTG_OK;
}

/* ---- motion --------------------------------------------------------------------------------- */

/* The line's tool vector. False: it has none. */
static bool find_vector(const btg_reader *r, const btg_block *b, btg_vec3 *axis, bool *whole) {
    bool fanuc = is(r, BTG_CONTROL_FANUC) && r->vectors;
    int have = 0;
    double v[3];
    for (int i = 0; i < 3; i++) {
        have += fanuc ? b->has['I' - 'A' + i] : b->has_vector[i];
        v[i] = fanuc ? b->value['I' - 'A' + i] : b->vector[i];
    }
    *axis = vec(v[0], v[1], v[2]);
    *whole = have == 3 && fabs(vec_norm(*axis) - 1) < VECTOR_SLACK;
    *axis = vec_unit(*axis);
    return have > 0;
}

/* Where the line leads: positions and what is known of them. */
static btg_status find_target(btg_reader *r, const btg_block *b, bool machine_frame, double to[5],
                              bool *linear, bool *any, btg_message *message) {
    *linear = *any = false;
    memcpy(to, r->at, 5 * sizeof *to);
    for (int i = 0; i < 5; i++) {
        int letter = i < 3 ? 'X' + i : r->machine->def.rotary[i - 3].letter;
        if (!b->has[letter - 'A']) continue;
        double value = b->value[letter - 'A'];
        if (i >= 3 && r->vectors)
            return refuse(message, "an angle while the tool's axis is a vector; give one kind");
        if (fabs(value) > BTG_LENGTH_MAX)
            return refuse(message, "a coordinate beyond 1e6; give mm and degrees");
        to[i] = i < 3 ? value + origin(r, i, machine_frame) : RADIANS(value);
        r->known[i] = true;
        *any = true;
        if (i < 3) *linear = true;
    }
    return BTG_OK;
}

static btg_status check_motion(const btg_reader *r, bool linear, bool machine_frame,
                               btg_message *message) {
    if (r->motion < 0) return refuse(message, "a coordinate before G0 or G1; say which");
    if (r->ended) return refuse(message, "a move after the program's end; take it out");
    if (is(r, BTG_CONTROL_HEIDENHAIN) && !r->inside)
        return refuse(message, "no BEGIN PGM before the first move; the beginning is cut off");
    if (machine_frame && r->tcp && !is(r, BTG_CONTROL_LINUXCNC))
        return refuse(message, "machine coordinates while the tip is under control; cancel that");
    if (linear && !machine_frame && !r->length)
        return refuse(message, "a move before the tool's length counts; give G43, D1 or TOOL CALL");
    return BTG_OK;
}

/* How long the line takes. 0: as long as it may, or not to be said. */
static btg_status find_seconds(const btg_reader *r, const btg_block *b, btg_way *way,
                               btg_message *message) {
    if (r->motion == 0) return BTG_OK;
    if (b->keywords & BTG_KEYWORD_FT) {
        way->seconds = b->seconds;
    } else if (r->inverse_time) {
        if (!b->has['F' - 'A']) return refuse(message, "G93 and no F in the line; give one");
        way->seconds = 60 / b->value['F' - 'A'];
    } else {
        if (!(r->feed > 0)) return refuse(message, "a cut before the first F; give a feed");
        double length = vec_norm(vec_sub(way->to, way->from));
        double turn =
            hypot(way->angle_to[0] - way->angle_from[0], way->angle_to[1] - way->angle_from[1]);
        if (way->kind == BTG_WAY_VECTORS) turn = 0;
        /* Controls differ in how they add mm and degrees where joints move alone. */
        if (way->kind == BTG_WAY_JOINTS) return BTG_OK;
        way->seconds = (length > STILL_MM ? length : DEGREES(turn)) * 60 / r->feed;
    }
    return BTG_OK;
}

static btg_status move(btg_reader *r, const btg_block *b, bool machine_frame,
                       btg_message *message) {
    double to[5];
    bool linear, any, whole;
    btg_vec3 axis;
    btg_status status = find_target(r, b, machine_frame, to, &linear, &any, message);
    bool vector = find_vector(r, b, &axis, &whole);
    if (status != BTG_OK || !(any || vector)) return status;
    if (vector && !r->vectors)
        return refuse(message, "a tool vector without ORIVECT or G43.5; give that first");
    if (vector && !whole)
        return refuse(message, "the tool vector is not whole, or not of length 1; give all three");
    status = check_motion(r, linear, machine_frame, message);
    if (status != BTG_OK) return status;
    if (!machine_frame) r->moves++;
    btg_way *w = &r->way;
    *w = (btg_way){.kind = r->vectors ? BTG_WAY_VECTORS
                           : r->tcp   ? BTG_WAY_TCP
                                      : BTG_WAY_JOINTS,
                   .from = vec(r->at[0], r->at[1], r->at[2]),
                   .to = vec(to[0], to[1], to[2]),
                   .angle_from = {r->at[3], r->at[4]},
                   .angle_to = {to[3], to[4]},
                   .axis_from = r->axis,
                   .axis_to = vector ? axis : r->axis};
    memcpy(r->at, to, sizeof to);
    r->axis = w->axis_to;
    status = find_seconds(r, b, w, message);
    r->under_way = all_known(r);
    if (r->motion == 1 && !(r->under_way && r->posed))
        return refuse(message, "a cut before it is known where the machine stands; give a rapid "
                               "with all axes first");
    if (!r->under_way) r->posed = false;
    r->part = r->posed ? 0 : 1;
    r->step = 1;
    if (r->under_way && r->posed) btg_way_at(r->machine, w, 0, &r->last);
    return status;
}

btg_status btg_reader_line(btg_reader *r, const char *text, btg_message *message) {
    btg_block b;
    bool machine_frame = false;
    btg_status status = btg_block_parse(r->machine->def.control, text, &b, message);
    if (status != BTG_OK) return status;
    for (int i = 0; i < 2; i++)
        if (b.promised[i] >= 0) r->promised[i] = b.promised[i];
    if (b.any) r->blocks++;
    if (b.counted) r->counted = true;
    bool ended = r->ended;
    status = take_modal(r, &b, &machine_frame, message);
    if (status != BTG_OK) return status;
    /* The line that ends a program may move before it does. */
    bool ends = r->ended && !ended;
    if (ends) r->ended = false;
    status = move(r, &b, machine_frame, message);
    if (ends) r->ended = true;
    return status;
}

/* ---- poses ---------------------------------------------------------------------------------- */

static btg_status check_limits(const btg_reader *r, const btg_way_pose *p, btg_message *message) {
    const btg_machine_def *d = &r->machine->def;
    if (r->way.kind == BTG_WAY_VECTORS) return BTG_OK;
    for (int j = 0; j < 5; j++) {
        bool turns = j >= 3;
        double at = turns ? p->angle[j - 3] : vec_at(p->linear, j);
        double low = turns ? d->rotary[j - 3].min_rad : d->linear[j].min_mm;
        double high = turns ? d->rotary[j - 3].max_rad : d->linear[j].max_mm;
        double slack = turns ? LIMIT_SLACK_RAD : LIMIT_SLACK_MM, unit = turns ? DEGREES(1) : 1;
        if (at >= low - slack && at <= high + slack) continue;
        return btg_fail(message, BTG_ERROR_UNSUPPORTED,
                        "joint %c comes to %.3f %s, beyond its limits (%.3f to %.3f); change the "
                        "program or the machine",
                        turns ? d->rotary[j - 3].letter : 'X' + j, at * unit,
                        turns ? "degrees" : "mm", low * unit, high * unit);
    }
    return BTG_OK;
}

btg_status btg_reader_pose(btg_reader *r, btg_reader_place *place, bool *any,
                           btg_message *message) {
    btg_way_pose p;
    *any = r->under_way;
    if (!r->under_way) return BTG_OK;
    double from = r->part, to = 1;
    bool linked = r->posed;
    if (linked)
        to = btg_way_piece(r->machine, &r->way, from, 2 * r->step, r->error_mm, r->reach_mm);
    btg_way_at(r->machine, &r->way, to, &p);
    btg_status status = check_limits(r, &p, message);
    if (status != BTG_OK) return status;
    if (linked) {
        int joint = 0;
        double haste = btg_way_haste(r->machine, &r->way, from, to, &r->last, &p, &joint);
        if (haste > r->haste) r->haste = haste, r->hasty_joint = joint;
    }
    r->step = to - from;
    r->part = to;
    r->last = p;
    r->posed = true;
    r->under_way = to < 1;
    *place = (btg_reader_place){p.tip, p.axis, linked, to < 1};
    return BTG_OK;
}
