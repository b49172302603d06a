/* The text of a program, for each control. Words are left out where they repeat the line before;
 * a line that would move nothing is not written. */
#include "post/internal.h"

#include <string.h>

/* Room kept for one line. */
#define LINE_ROOM 512
/* Decimals of a tool vector. */
#define VECTOR_DECIMALS 7
/* Feeds in mm per minute change when they have to, or when they could rise by this factor: not on
 * every line for a trifle. */
#define FEED_RISE 1.02
/* Feeds keep this many digits at least. */
#define FEED_DIGITS 1e4
#define FEED_LEAST  1e-4

#define DEGREES(x) ((x) * (180 / BTG_PI))

/* ---- text --------------------------------------------------------------------------------- */

void btg_gcode_flush(btg_program *p) {
    if (p->text_size > 0 && p->status == BTG_OK) {
        btg_program_latch(p, p->def.write(p->text, p->text_size, p->def.user));
    }
    p->text_size = 0;
}

static void text(btg_program *p, const char *s) {
    size_t size = strlen(s);
    if (p->text_size + size > sizeof p->text) return;
    memcpy(p->text + p->text_size, s, size);
    p->text_size += size;
}

static void number(btg_program *p, int64_t scaled, int decimals, int least) {
    char *end = p->text + p->text_size;
    p->text_size = (size_t)(btg_number_text(end, scaled, decimals, least) - p->text);
}

static void whole(btg_program *p, uint64_t value) {
    number(p, (int64_t)value, 0, 0);
}

static bool is(const btg_program *p, btg_control control) {
    return p->machine.def.control == control;
}

static void begin_line(btg_program *p) {
    if (p->text_size + LINE_ROOM > sizeof p->text) btg_gcode_flush(p);
    if (!is(p, BTG_CONTROL_HEIDENHAIN)) return;
    whole(p, p->line++);
    text(p, " ");
}

static void end_line(btg_program *p) {
    text(p, "\n");
    p->lines++;
}

static void line(btg_program *p, const char *s) {
    begin_line(p);
    text(p, s);
    end_line(p);
}

/* Where a file of some controls begins and ends: no block. */
static void put_percent(btg_program *p) {
    begin_line(p);
    text(p, "%\n");
}

/* Only what comments and program names of all controls can hold. */
static void make_name(btg_program *p, const char *s) {
    size_t n = 0;
    for (; *s && n < sizeof p->name - 1; s++) {
        char c = *s;
        if (c >= 'a' && c <= 'z') c = (char)(c - 'a' + 'A');
        bool ok = (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-';
        p->name[n++] = ok ? c : '_';
    }
    p->name[n] = '\0';
}

static void comment(btg_program *p, const char *s, const char *value) {
    bool round = is(p, BTG_CONTROL_LINUXCNC) || is(p, BTG_CONTROL_FANUC);
    begin_line(p);
    text(p, round ? "(" : "; ");
    text(p, s);
    text(p, value);
    text(p, round ? ")" : "");
    text(p, "\n");
}

/* ---- words -------------------------------------------------------------------------------- */

static void put(btg_program *p, const char *letter, int64_t scaled, int decimals) {
    text(p, " ");
    text(p, letter);
    if (is(p, BTG_CONTROL_HEIDENHAIN) && scaled >= 0) text(p, "+");
    number(p, scaled, decimals, 1);
}

/* True: the word differs from the one written last. */
static bool changed(btg_program *p, int i, int64_t scaled) {
    if (p->known[i] && p->last[i] == scaled) return false;
    p->known[i] = true;
    p->last[i] = scaled;
    return true;
}

/* A stop as numbers: X Y Z, then both angles or the vector. */
typedef struct words {
    int64_t value[6];
    int count;
} words;

static words words_of(const btg_program *p, const btg_stop *s) {
    const btg_machine_def *d = &p->machine.def;
    words w = {.count = d->vectors ? 6 : 5};
    btg_vec3 at = s->tip;
    if (!d->tcp) {
        /* Joints from the work offset, for a control that adds the tool's length in Z. */
        at = vec_sub(btg_machine_linear(&p->machine, s->tip, s->angle), d->part_origin);
        at.z -= d->tool_length_mm;
    }
    for (int i = 0; i < 3; i++)
        w.value[i] = btg_number_scaled(vec_at(at, i), p->decimals_mm);
    for (int i = 3; i < w.count; i++) {
        w.value[i] = d->vectors ? btg_number_scaled(vec_at(s->axis, i - 3), VECTOR_DECIMALS)
                                : btg_number_scaled(DEGREES(s->angle[i - 3]), p->decimals_deg);
    }
    return w;
}

static bool any_change(const btg_program *p, const words *w) {
    for (int i = 0; i < w->count; i++) {
        if (!p->known[i] || p->last[i] != w->value[i]) return true;
    }
    return false;
}

static void put_linear(btg_program *p, const words *w) {
    for (int i = 0; i < 3; i++) {
        const char letter[2] = {(char)('X' + i), '\0'};
        if (changed(p, i, w->value[i])) put(p, letter, w->value[i], p->decimals_mm);
    }
}

static void put_angles(btg_program *p, const words *w) {
    for (int i = 0; i < 2; i++) {
        const char letter[2] = {p->machine.def.rotary[i].letter, '\0'};
        if (changed(p, 3 + i, w->value[3 + i])) {
            put(p, letter, w->value[3 + i], p->decimals_deg);
        }
    }
}

/* A vector's three words belong together. */
static void put_vector(btg_program *p, const words *w) {
    static const char *const fanuc[3] = {"I", "J", "K"}, *const siemens[3] = {"A3=", "B3=", "C3="};
    bool any = false;
    for (int i = 3; i < 6; i++)
        any = changed(p, i, w->value[i]) || any;
    for (int i = 0; i < 3 && any; i++) {
        put(p, is(p, BTG_CONTROL_FANUC) ? fanuc[i] : siemens[i], w->value[3 + i], VECTOR_DECIMALS);
    }
}

static void put_words(btg_program *p, const words *w) {
    put_linear(p, w);
    if (p->machine.def.vectors) {
        put_vector(p, w);
    } else {
        put_angles(p, w);
    }
}

/* The word that makes a line a motion. */
static void put_motion(btg_program *p, int motion) {
    if (is(p, BTG_CONTROL_HEIDENHAIN)) {
        text(p, "L");
        return;
    }
    /* Lines never begin with a blank. */
    text(p, motion == 0 ? "G0" : "G1");
    p->motion = motion;
}

/* ---- feeds -------------------------------------------------------------------------------- */

/* Rounded down, with at least five digits. */
static void put_feed(btg_program *p, const char *letter, double feed) {
    int decimals = 1;
    double scale = 10;
    for (; decimals < 8 && feed * scale < FEED_DIGITS; decimals++)
        scale *= 10;
    int64_t scaled = (int64_t)floor(feed * scale * (1 + 1e-12));
    text(p, " ");
    text(p, letter);
    number(p, scaled > 0 ? scaled : 1, decimals, 1);
}

/* mm per minute of the tip; where the tip stands still, degrees. */
static void put_rate(btg_program *p, double seconds, double length_mm, double turn_rad) {
    double way = length_mm > 1e-6 ? length_mm : DEGREES(turn_rad);
    double feed = fmax(way * 60 / seconds, FEED_LEAST);
    if (p->last_feed <= feed * (1 + 1e-9) && p->last_feed * FEED_RISE >= feed) return;
    p->last_feed = feed;
    put_feed(p, "F", feed);
}

/* The way as it is written: of short moves rounding changes the length, and with it the time that a
 * feed stands for. */
static double written(const btg_program *p, const words *w, int from, int to, int decimals) {
    double sum = 0, unit = pow(10, -decimals);
    for (int i = from; i < to; i++) {
        double way = (double)(w->value[i] - p->last[i]) * unit;
        sum += way * way;
    }
    return sqrt(sum);
}

static void trace(const btg_program *p, const btg_stop *stop, double seconds) {
    if (!p->def.trace) return;
    btg_vec3 linear = btg_machine_linear(&p->machine, stop->tip, stop->angle);
    const btg_joints joints = {.linear_mm = {linear.x, linear.y, linear.z},
                               .rotary_rad = {stop->angle[0], stop->angle[1]}};
    p->def.trace(&joints, seconds, p->def.user);
}

void btg_gcode_cut(btg_program *p, const btg_stop *stop, double seconds, double length_mm,
                   double turn_rad) {
    words w = words_of(p, stop);
    if (!any_change(p, &w) || !(seconds > 0)) return;
    if (p->machine.def.tcp && p->known[0] && p->known[1] && p->known[2])
        length_mm = written(p, &w, 0, 3, p->decimals_mm);
    if (w.count == 5 && p->known[3] && p->known[4])
        turn_rad = written(p, &w, 3, 5, p->decimals_deg) * (BTG_PI / 180);
    begin_line(p);
    put_motion(p, 1);
    put_words(p, &w);
    if (!p->machine.def.inverse_time) {
        put_rate(p, seconds, length_mm, turn_rad);
    } else if (is(p, BTG_CONTROL_HEIDENHAIN)) {
        put_feed(p, "FT", fmax(seconds, FEED_LEAST));
    } else {
        put_feed(p, "F", fmax(60 / seconds, FEED_LEAST));
    }
    end_line(p);
    p->info.blocks++;
    trace(p, stop, seconds);
}

void btg_gcode_rapid(btg_program *p, const btg_stop *stop) {
    words w = words_of(p, stop);
    if (!any_change(p, &w)) return;
    begin_line(p);
    put_motion(p, 0);
    put_words(p, &w);
    if (is(p, BTG_CONTROL_HEIDENHAIN)) text(p, " FMAX");
    end_line(p);
    p->info.blocks++;
    trace(p, stop, 0);
}

/* ---- beginning and end -------------------------------------------------------------------- */

/* The spindle to retract_z_mm, in machine coordinates. */
static void put_retract(btg_program *p) {
    static const char *const before[4] = {"G53 G0 Z", "G53 G0 Z", "SUPA G0 Z", "L Z"};
    static const char *const after[4] = {"", "", " D0", " R0 FMAX M91"};
    double z = p->machine.def.retract_z_mm;
    p->known[2] = false;
    if (isnan(z)) return;
    begin_line(p);
    text(p, before[p->machine.def.control]);
    if (is(p, BTG_CONTROL_HEIDENHAIN) && z >= 0) text(p, "+");
    number(p, btg_number_scaled(z, p->decimals_mm), p->decimals_mm, 1);
    text(p, after[p->machine.def.control]);
    end_line(p);
    p->motion = 0;
}

/* Tool and spindle. */
static void put_tool(btg_program *p) {
    int64_t rpm = btg_number_scaled(p->def.spindle_rpm, 0);
    bool heidenhain = is(p, BTG_CONTROL_HEIDENHAIN);
    begin_line(p);
    text(p, heidenhain ? "TOOL CALL " : "T");
    whole(p, p->def.tool_number);
    text(p, heidenhain ? " Z" : is(p, BTG_CONTROL_SIEMENS) ? " D1 M6" : " M6");
    if (rpm > 0 && heidenhain) {
        text(p, " S");
        number(p, rpm, 0, 0);
    }
    end_line(p);
    if (rpm <= 0) return;
    begin_line(p);
    if (!heidenhain) {
        text(p, "S");
        number(p, rpm, 0, 0);
        text(p, " ");
    }
    text(p, "M3");
    end_line(p);
}

static void put_name(btg_program *p, const char *before) {
    begin_line(p);
    text(p, before);
    text(p, p->name);
    text(p, " MM");
    end_line(p);
}

/* "G64 P0.002 Q0": the path may be rounded by the tolerance, no points left out. */
static void put_blending(btg_program *p) {
    begin_line(p);
    text(p, "G64 P");
    number(p, btg_number_scaled(p->def.tolerance_mm, BTG_DECIMALS_MAX), BTG_DECIMALS_MAX, 1);
    text(p, " Q0.0");
    end_line(p);
}

void btg_gcode_begin(btg_program *p) {
    if (is(p, BTG_CONTROL_LINUXCNC) || is(p, BTG_CONTROL_FANUC)) put_percent(p);
    if (is(p, BTG_CONTROL_FANUC)) line(p, "O0001");
    make_name(p, p->def.name && p->def.name[0] ? p->def.name : "BITANGENT");
    if (is(p, BTG_CONTROL_HEIDENHAIN)) put_name(p, "BEGIN PGM ");
    comment(p, "PART ", p->name);
    comment(p, "BITANGENT ", btg_version());
    switch (p->machine.def.control) {
    case BTG_CONTROL_LINUXCNC:
        line(p, "G21 G90 G17 G40 G49 G80 G94");
        put_blending(p);
        break;
    case BTG_CONTROL_FANUC:
        line(p, "G21 G90 G17 G40 G49 G80 G94");
        break;
    case BTG_CONTROL_SIEMENS:
        line(p, "G17 G40 G710 G90 G94 G64");
        break;
    case BTG_CONTROL_HEIDENHAIN:
        break;
    }
    put_tool(p);
}

/* Work offset and tool length, with the tip under control where that is meant. */
static void put_offsets(btg_program *p) {
    const btg_machine_def *d = &p->machine.def;
    switch (d->control) {
    case BTG_CONTROL_FANUC:
    case BTG_CONTROL_LINUXCNC:
        begin_line(p);
        text(p, !d->tcp || is(p, BTG_CONTROL_LINUXCNC) ? "G43 H"
                : d->vectors                           ? "G43.5 H"
                                                       : "G43.4 H");
        whole(p, p->def.tool_number);
        end_line(p);
        break;
    case BTG_CONTROL_SIEMENS:
        if (d->tcp) line(p, "TRAORI");
        if (d->tcp) line(p, "ORIWKS");
        if (d->tcp) line(p, d->vectors ? "ORIVECT" : "ORIAXES");
        line(p, "G54 D1");
        break;
    case BTG_CONTROL_HEIDENHAIN:
        if (d->tcp) line(p, "M128");
        break;
    }
}

/* The rotary joints as angles, also where the path is written in vectors. */
static void put_turn(btg_program *p, const btg_stop *stop) {
    begin_line(p);
    put_motion(p, 0);
    for (int i = 0; i < 2; i++) {
        const char letter[2] = {p->machine.def.rotary[i].letter, '\0'};
        int64_t scaled = btg_number_scaled(DEGREES(stop->angle[i]), p->decimals_deg);
        put(p, letter, scaled, p->decimals_deg);
        if (!p->machine.def.vectors) changed(p, 3 + i, scaled);
    }
    if (is(p, BTG_CONTROL_HEIDENHAIN)) text(p, " R0 FMAX");
    end_line(p);
    p->info.blocks++;
}

void btg_gcode_first(btg_program *p, const btg_stop *stop) {
    words w = words_of(p, stop);
    bool early = is(p, BTG_CONTROL_LINUXCNC);
    if (early) put_offsets(p);
    if (!is(p, BTG_CONTROL_HEIDENHAIN)) line(p, is(p, BTG_CONTROL_SIEMENS) ? "G54 D1" : "G54");
    if (early && p->machine.def.inverse_time) line(p, "G93");
    put_retract(p);
    if (!(early && p->machine.def.tcp)) put_turn(p, stop);
    if (!early) put_offsets(p);
    if (!early && p->machine.def.inverse_time && !is(p, BTG_CONTROL_HEIDENHAIN)) line(p, "G93");
    words flat = w;
    flat.value[2] = p->last[2];
    p->known[2] = true;
    begin_line(p);
    put_motion(p, 0);
    put_words(p, &flat);
    if (is(p, BTG_CONTROL_HEIDENHAIN)) text(p, " R0 FMAX");
    end_line(p);
    p->known[2] = false;
    p->info.blocks++;
    btg_gcode_rapid(p, stop);
}

/* So that a reader sees whether lines are left out. `left`: blocks after this one. */
static void put_count(btg_program *p, unsigned left) {
    char counts[2 * BTG_NUMBER_SIZE + 16];
    char *end = btg_number_text(counts, (int64_t)p->info.blocks, 0, 0);
    memcpy(end, " OF ", 4);
    end = btg_number_text(end + 4, (int64_t)(p->lines + left), 0, 0);
    memcpy(end, " BLOCKS", 8);
    comment(p, "MOVES ", counts);
}

/* Blocks that end the program. */
static unsigned blocks_at_end(const btg_program *p) {
    const btg_machine_def *d = &p->machine.def;
    unsigned spindle = p->def.spindle_rpm > 0;
    unsigned inverse = d->inverse_time && !is(p, BTG_CONTROL_HEIDENHAIN);
    static const unsigned fixed[] = {[BTG_CONTROL_LINUXCNC] = 2,
                                     [BTG_CONTROL_FANUC] = 3,
                                     [BTG_CONTROL_SIEMENS] = 2,
                                     [BTG_CONTROL_HEIDENHAIN] = 3};
    bool off = d->tcp && (is(p, BTG_CONTROL_SIEMENS) || is(p, BTG_CONTROL_HEIDENHAIN));
    return fixed[d->control] + spindle + inverse + off;
}

void btg_gcode_end(btg_program *p) {
    const btg_machine_def *d = &p->machine.def;
    put_count(p, blocks_at_end(p));
    if (p->def.spindle_rpm > 0) line(p, "M5");
    if (p->machine.def.inverse_time && !is(p, BTG_CONTROL_HEIDENHAIN)) line(p, "G94");
    switch (d->control) {
    case BTG_CONTROL_LINUXCNC:
        put_retract(p);
        line(p, "M2");
        put_percent(p);
        break;
    case BTG_CONTROL_FANUC:
        line(p, "G49");
        put_retract(p);
        line(p, "M30");
        put_percent(p);
        break;
    case BTG_CONTROL_SIEMENS:
        if (d->tcp) line(p, "TRAFOOF");
        put_retract(p);
        line(p, "M30");
        break;
    case BTG_CONTROL_HEIDENHAIN:
        if (d->tcp) line(p, "M129");
        put_retract(p);
        line(p, "M30");
        put_name(p, "END PGM ");
        break;
    }
}
