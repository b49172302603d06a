#include "post/internal.h"

#include <stdio.h>
#include <string.h>

#define APT_DEF_VERSION 1

/* A record's line ends before column 72. */
#define LINE_MAX_CHARS 71
/* Height of a cutter without shank and holder: a usual tool; readers use it for pictures only. */
#define CUTTER_HEIGHT_MM 100.0

#define TIP_DECIMALS  6
#define AXIS_DECIMALS 9

btg_apt_def btg_apt_def_default(void) {
    btg_apt_def def;
    memset(&def, 0, sizeof def);
    def.version = APT_DEF_VERSION;
    def.feed_mm_per_min = 1000.0;
    def.clear_z_mm = NAN;
    return def;
}

double btg_post_lift_z(const btg_tool *tool, btg_vec3 axis, double clear_z_mm) {
    double up = axis.z, across = hypot(axis.x, axis.y);
    double lowest = INFINITY;
    for (uint32_t i = 0; i < tool->element_count; i++) {
        const btg_tool_element *e = &tool->element[i];
        double end = up < 0 && isfinite(e->to_mm) ? e->to_mm : e->from_mm;
        double z = end * up - e->ring_radius_mm * across - e->corner_radius_mm;
        if (z < lowest) lowest = z;
    }
    return clear_z_mm - lowest - tool->def.minor_radius_mm * up;
}

/* ---- records ------------------------------------------------------------------------------ */

/* One record: words joined by commas, continued by $ where a line is full. */
typedef struct record {
    char text[512];
    size_t size, column;
} record;

static void append(record *r, const char *text, size_t size) {
    if (size > sizeof r->text - r->size) size = sizeof r->text - r->size;
    memcpy(r->text + r->size, text, size);
    r->size += size;
    r->column += size;
}

static void word(record *r, const char *text, bool comma) {
    size_t size = strlen(text);
    size_t tail = comma ? 2 : 0; /* `,$` */
    if (r->column + size + tail > LINE_MAX_CHARS) {
        append(r, "$\n", 2);
        r->column = 0;
    }
    append(r, text, size);
    if (comma) append(r, ",", 1);
}

static void number(record *r, double value, int decimals, bool comma) {
    char text[BTG_NUMBER_SIZE + 1];
    *btg_number_text(text, btg_number_scaled(value, decimals), decimals, decimals) = '\0';
    word(r, text, comma);
}

static record start(const char *text) {
    record r;
    r.size = r.column = 0;
    append(&r, text, strlen(text));
    return r;
}

static btg_status put(const btg_apt *apt, record *r) {
    append(r, "\n", 1);
    return apt->def.write(r->text, r->size, apt->def.user);
}

static btg_status put_text(const btg_apt *apt, const char *text) {
    record r = start(text);
    return put(apt, &r);
}

static btg_status put_goto(btg_apt *apt, btg_vec3 tip, btg_vec3 axis) {
    record r = start("GOTO/");
    number(&r, tip.x, TIP_DECIMALS, true);
    number(&r, tip.y, TIP_DECIMALS, true);
    number(&r, tip.z, TIP_DECIMALS, true);
    number(&r, axis.x, AXIS_DECIMALS, true);
    number(&r, axis.y, AXIS_DECIMALS, true);
    number(&r, axis.z, AXIS_DECIMALS, false);
    apt->tip = tip;
    apt->axis = axis;
    apt->placed = 1;
    apt->moves++;
    return put(apt, &r);
}

static btg_status put_rapid(btg_apt *apt, btg_vec3 tip, btg_vec3 axis) {
    btg_status status = put_text(apt, "RAPID");
    return status == BTG_OK ? put_goto(apt, tip, axis) : status;
}

/* ---- the program -------------------------------------------------------------------------- */

static btg_status put_part_name(const btg_apt *apt) {
    record r = start("PARTNO ");
    const char *name = apt->def.part_name ? apt->def.part_name : "BITANGENT";
    for (; *name && r.column < LINE_MAX_CHARS; name++) {
        char c = *name;
        bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                     (c != '\0' && strchr("-_.+()", c));
        append(&r, plain ? &c : " ", 1);
    }
    return put(apt, &r);
}

static btg_status put_cutter(const btg_apt *apt) {
    const btg_tool_def *d = &apt->tool.def;
    double height = 0;
    for (uint32_t i = 1; i < apt->tool.element_count; i++) {
        height = fmax(height, apt->tool.element[i].to_mm + d->minor_radius_mm);
    }
    if (height == 0) height = CUTTER_HEIGHT_MM;
    record r = start("CUTTER/");
    const double value[7] = {2 * (d->major_radius_mm + d->minor_radius_mm),
                             d->minor_radius_mm,
                             d->major_radius_mm,
                             d->minor_radius_mm,
                             0,
                             0,
                             height};
    for (int i = 0; i < 7; i++)
        number(&r, value[i], TIP_DECIMALS, i < 6);
    return put(apt, &r);
}

static btg_status put_feed(const btg_apt *apt) {
    record r = start("FEDRAT/");
    number(&r, apt->def.feed_mm_per_min, TIP_DECIMALS, true);
    word(&r, "MMPM", false);
    return put(apt, &r);
}

static btg_status check(const btg_apt_def *def, btg_message *message) {
    if (def->version != APT_DEF_VERSION) {
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "APT: unknown version; start from btg_apt_def_default()");
    }
    if (!def->write) return btg_fail(message, BTG_ERROR_ARGUMENT, "APT: no function to write with");
    if (!(def->feed_mm_per_min > 0 && def->feed_mm_per_min <= BTG_NUMBER_MAX)) {
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "APT: the feed is %g mm per minute; give a positive number",
                        def->feed_mm_per_min);
    }
    if (!(fabs(def->clear_z_mm) <= BTG_NUMBER_MAX)) {
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "APT: the height to retract to is %g mm; give a height over the part",
                        def->clear_z_mm);
    }
    return BTG_OK;
}

btg_status btg_apt_begin(btg_apt *apt, const btg_apt_def *def, const btg_tool *tool,
                         btg_message *message) {
    if (!apt || !def || !tool) {
        return btg_fail(message, BTG_ERROR_ARGUMENT, "APT: an argument is NULL");
    }
    btg_status status = check(def, message);
    if (status != BTG_OK) return status;
    *apt = (btg_apt){.def = *def, .tool = *tool, .broken = 1};
    status = put_part_name(apt);
    if (status == BTG_OK) status = put_text(apt, "UNITS/MM");
    if (status == BTG_OK) status = put_text(apt, "MULTAX/ON");
    if (status == BTG_OK) status = put_cutter(apt);
    if (status == BTG_OK) status = put_feed(apt);
    if (status != BTG_OK) return btg_fail(message, status, "APT: cannot write");
    return BTG_OK;
}

/* Never below where the tool stands. */
static double lift_z(const btg_apt *apt, btg_vec3 tip, btg_vec3 axis) {
    return fmax(tip.z, btg_post_lift_z(&apt->tool, axis, apt->def.clear_z_mm));
}

/* Up, across and down. Across at the higher of both ends: an axis between the two leans no more
 * than the one of them that leans most, so the tool stays clear all the way. */
static btg_status travel(btg_apt *apt, btg_vec3 tip, btg_vec3 axis) {
    double z = lift_z(apt, tip, axis);
    btg_status status = BTG_OK;
    if (apt->placed) {
        z = fmax(z, lift_z(apt, apt->tip, apt->axis));
        status = put_rapid(apt, vec(apt->tip.x, apt->tip.y, z), apt->axis);
    }
    if (status == BTG_OK) status = put_rapid(apt, vec(tip.x, tip.y, z), axis);
    return status;
}

static bool writable(btg_vec3 a) {
    return fabs(a.x) <= BTG_NUMBER_MAX && fabs(a.y) <= BTG_NUMBER_MAX &&
           fabs(a.z) <= BTG_NUMBER_MAX;
}

btg_status btg_apt_add(btg_apt *apt, const btg_position *position, int link) {
    if (!apt || !position) return BTG_ERROR_ARGUMENT;
    if (position->status < 0 || position->status == BTG_NO_CONTACT) {
        apt->broken = 1;
        return BTG_OK;
    }
    if (!writable(position->tip) || !writable(position->axis)) return BTG_ERROR_ARGUMENT;
    btg_status status = BTG_OK;
    if (!link || apt->broken) status = travel(apt, position->tip, position->axis);
    apt->broken = 0;
    return status == BTG_OK ? put_goto(apt, position->tip, position->axis) : status;
}

static btg_status put_count(const btg_apt *apt) {
    char text[40];
    snprintf(text, sizeof text, "PPRINT MOVES %lu", apt->moves);
    return put_text(apt, text);
}

btg_status btg_apt_end(btg_apt *apt) {
    if (!apt) return BTG_ERROR_ARGUMENT;
    btg_status status = BTG_OK;
    if (apt->placed) {
        double z = lift_z(apt, apt->tip, apt->axis);
        status = put_rapid(apt, vec(apt->tip.x, apt->tip.y, z), apt->axis);
    }
    if (status == BTG_OK) status = put_count(apt);
    return status == BTG_OK ? put_text(apt, "FINI") : status;
}
