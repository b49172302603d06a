/* What each option of `bitangent path` takes. */
#include "app/app.h"
#include "app/number.h"
#include "app/options.h"
#include "bitangent/backend.h"
#include "core/vec.h"
#include "io/picture.h"
#include "methods/method.h"

#include <string.h>
#include <strings.h>

static bool get_number(const char *name, const char *value, double *number) {
    if (number_parse(value, strlen(value), number)) return true;
    return app_refuse(name, "'%.100s' is not a number; give one like 2 or 0.5", value);
}

static bool get_positive(const char *name, const char *value, double *number) {
    double x;
    if (!get_number(name, value, &x)) return false;
    if (x <= 0) return app_refuse(name, "'%.100s' is not above 0", value);
    *number = x;
    return true;
}

/* ---- files -------------------------------------------------------------------------------- */

static bool find_kind(const char *word, size_t size, output_kind *kind) {
    static const char *const known[] = {"csv", "json", "cl", "png", "ngc", "glb", "html"};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        if (strlen(known[i]) != size || strncasecmp(word, known[i], size) != 0) continue;
        *kind = (output_kind)i;
        return true;
    }
    return false;
}

/* FILE with a known ending, or KIND:FILE. */
static bool set_output(path_options *o, const char *name, const char *value) {
    output_choice choice = {.path = value};
    const char *colon = strchr(value, ':');
    const char *slash = strrchr(value, '/');
    const char *dot = strrchr(slash ? slash : value, '.');
    if (o->output_count == BTG_OUTPUT_MAX) {
        return app_refuse(name, "more than %d files; give fewer", BTG_OUTPUT_MAX);
    }
    if (colon && find_kind(value, (size_t)(colon - value), &choice.kind)) {
        choice.path = colon + 1;
        if (choice.path[0] == '\0') return app_refuse(name, "no file after '%.100s'", value);
    } else if (!dot || !find_kind(dot + 1, strlen(dot + 1), &choice.kind)) {
        return app_refuse(
            name, "'%.200s' has no known ending; give .csv, .json, .cl, .png, .glb, .html or .ngc",
            value);
    }
    if (choice.kind == OUTPUT_PNG && !btg_picture_available()) {
        return app_refuse(name,
                          "'%.200s': this build draws no pictures; install libcairo2-dev and "
                          "build again",
                          value);
    }
    for (int i = 0; i < o->output_count; i++) {
        if (strcmp(o->outputs[i].path, choice.path) == 0) {
            return app_refuse(name, "'%.200s' is given twice", choice.path);
        }
    }
    o->outputs[o->output_count++] = choice;
    return true;
}

/* ---- tool --------------------------------------------------------------------------------- */

static bool check_tool(const path_options *o, const char *name) {
    btg_tool tool;
    btg_message message;
    if (btg_tool_init(&o->tool, &tool, &message) == BTG_OK) return true;
    return app_refuse(name, "%s", message.text);
}

static bool set_tool(path_options *o, const char *name, const char *value) {
    char numbers[128];
    double r[2];
    const char *first = strchr(value, ',');
    const char *second = first ? strchr(first + 1, ',') : NULL;
    size_t size = second ? (size_t)(second - value) : strlen(value);
    bool fits = size < sizeof numbers;
    if (fits) {
        memcpy(numbers, value, size);
        numbers[size] = '\0';
    }
    if (!fits || number_parse_list(numbers, r, 2) != 2) {
        return app_refuse(name, "'%.100s'; give RO,RI or RO,RI,toroidal|bullnose in mm", value);
    }
    const char *profile = second ? second + 1 : "toroidal";
    if (strcmp(profile, "toroidal") != 0 && strcmp(profile, "bullnose") != 0) {
        return app_refuse(name, "unknown profile '%.100s'; give toroidal or bullnose", profile);
    }
    o->tool.profile = profile[0] == 't' ? BTG_PROFILE_TOROIDAL : BTG_PROFILE_BULLNOSE;
    o->tool.major_radius_mm = r[0];
    o->tool.minor_radius_mm = r[1];
    return check_tool(o, name);
}

static bool get_cylinder(const char *name, const char *value, btg_cylinder *cylinder) {
    double x[3];
    if (number_parse_list(value, x, 3) != 3) {
        return app_refuse(name, "'%.100s'; give RADIUS,FROM,TO, in mm over the torus centre",
                          value);
    }
    if (x[0] <= 0) return app_refuse(name, "the radius in '%.100s' is not above 0", value);
    *cylinder = (btg_cylinder){x[0], x[1], x[2]};
    return true;
}

static bool set_shank(path_options *o, const char *name, const char *value) {
    return get_cylinder(name, value, &o->tool.shank) && check_tool(o, name);
}

static bool set_holder(path_options *o, const char *name, const char *value) {
    if (o->tool.holder_count == BTG_HOLDER_MAX) {
        return app_refuse(name, "more than %d cylinders; give fewer", BTG_HOLDER_MAX);
    }
    if (!get_cylinder(name, value, &o->tool.holder[o->tool.holder_count])) return false;
    o->tool.holder_count++;
    return check_tool(o, name);
}

/* ---- footprint ---------------------------------------------------------------------------- */

static bool set_side_step(path_options *o, const char *name, const char *value) {
    o->side_of_scallop = strcmp(value, "scallop") == 0;
    return o->side_of_scallop || get_positive(name, value, &o->footprint.side_step_mm);
}

static bool set_forward_step(path_options *o, const char *name, const char *value) {
    return get_positive(name, value, &o->footprint.forward_step_mm);
}

static bool set_overrun(path_options *o, const char *name, const char *value) {
    if (!get_number(name, value, &o->overrun_mm)) return false;
    if (o->overrun_mm >= 0 && o->overrun_mm <= BTG_LENGTH_MAX) return true;
    return app_refuse(name, "'%s'; give 0 to 1e6 mm", value);
}

static bool set_footprint(path_options *o, const char *name, const char *value) {
    o->points = NULL;
    o->contour = strcmp(value, "contour") == 0;
    if (o->contour || strcmp(value, "parallel") == 0) {
        o->footprint.kind = BTG_FOOTPRINT_PARALLEL;
    } else if (strcmp(value, "zigzag") == 0) {
        o->footprint.kind = BTG_FOOTPRINT_ZIGZAG;
    } else if (strcmp(value, "one-way") == 0) {
        o->footprint.kind = BTG_FOOTPRINT_ONE_WAY;
    } else if (strncmp(value, "one-way:", 8) == 0) {
        o->footprint.kind = BTG_FOOTPRINT_ONE_WAY;
        if (!get_positive(name, value + 8, &o->lift_mm)) return false;
        if (o->lift_mm > BTG_LENGTH_MAX) return app_refuse(name, "a lift of more than 1e6 mm");
    } else if (strncmp(value, "points:", 7) == 0 && value[7] != '\0') {
        o->points = value + 7;
    } else {
        return app_refuse(
            name,
            "unknown '%.100s'; give parallel, zigzag, one-way, one-way:LIFT, contour or "
            "points:FILE",
            value);
    }
    return true;
}

/* ---- solving ------------------------------------------------------------------------------ */

static bool set_method(path_options *o, const char *name, const char *value) {
    btg_method_info info;
    char names[256] = "";
    o->method = value;
    if (btg_method_find(value, &info)) return true;
    for (size_t i = 0; i < btg_method_count(); i++) {
        size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, "%s%s", i > 0 ? ", " : "",
                 btg_method_get_info(i).name);
    }
    return app_refuse(name, "unknown '%.100s'; give one of %s", value, names);
}

static bool set_ray_spacing(path_options *o, const char *name, const char *value) {
    if (!get_positive(name, value, &o->ray_spacing_mm)) return false;
    if (o->ray_spacing_mm <= BTG_LENGTH_MAX) return true;
    return app_refuse(name, "'%s'; give at most 1e6 mm", value);
}

static bool set_levels(path_options *o, const char *name, const char *value) {
    if (strcmp(value, "1") != 0 && strcmp(value, "2") != 0)
        return app_refuse(name, "'%.100s'; give 1 or 2", value);
    o->levels = value[0] - '0';
    return true;
}

static bool set_window(path_options *o, const char *name, const char *value) {
    if (number_parse_count(value, &o->window) && o->window >= 8 && o->window <= 4096) return true;
    return app_refuse(name, "'%.100s'; give a whole number from 8 to 4096", value);
}

static bool set_backend(path_options *o, const char *name, const char *value) {
    char names[256] = "auto";
    o->backend = value;
    if (strcmp(value, "auto") == 0) return true;
    size_t length = strcspn(value, ",");
    bool any = strcmp(value + length, ",auto") == 0;
    if (value[length] != '\0' && !any)
        return app_refuse(name, "'%.100s'; give a name, auto, or NAME,auto", value);
    for (size_t i = 0; i < btg_backend_count(); i++) {
        btg_backend_info info;
        if (btg_backend_get_info(i, &info) != BTG_OK) continue;
        size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, ", %s", info.name);
        if (strncmp(value, info.name, length) != 0 || info.name[length] != '\0') continue;
        if (any) return true;
        if (info.state != BTG_BACKEND_NOT_BUILT) return true;
        return app_refuse(name, "'%s' is not built into this version; see 'bitangent info'", value);
    }
    return app_refuse(name, "unknown '%.100s'; give one of %s", value, names);
}

/* `fixed:DEG`, -360 to 360. */
static bool set_fixed(path_options *o, const char *name, const char *degrees) {
    if (!get_number(name, degrees, &o->spin_deg)) return false;
    if (fabs(o->spin_deg) > 360)
        return app_refuse(name, "more than a whole turn; give -360 to 360");
    o->solver.spin = BTG_SPIN_FIXED;
    o->solver.spin_rad = o->spin_deg * (BTG_PI / 180);
    return true;
}

static bool set_gap(path_options *o, const char *name, const char *mm) {
    if (!get_positive(name, mm, &o->solver.gap_mm)) return false;
    if (o->solver.gap_mm > BTG_LENGTH_MAX) return app_refuse(name, "a gap of more than 1e6 mm");
    o->solver.spin = BTG_SPIN_GAP;
    return true;
}

static bool set_spin(path_options *o, const char *name, const char *value) {
    if (strncmp(value, "fixed:", 6) == 0) return set_fixed(o, name, value + 6);
    if (strncmp(value, "gap:", 4) == 0) return set_gap(o, name, value + 4);
    if (strcmp(value, "none") == 0) {
        o->solver.spin = BTG_SPIN_NONE;
    } else if (strcmp(value, "across") == 0) {
        o->solver.spin = BTG_SPIN_ACROSS;
    } else if (strcmp(value, "widest") == 0) {
        o->solver.spin = BTG_SPIN_WIDEST;
    } else {
        return app_refuse(name, "unknown '%.100s'; give none, fixed:DEG, gap:MM, across or widest",
                          value);
    }
    return true;
}

static bool set_scallop(path_options *o, const char *name, const char *value) {
    double mm = 0;
    if (!get_positive(name, value, &mm)) return false;
    if (mm > 100) return app_refuse(name, "'%s'; give at most 100 mm", value);
    o->solver.scallop_mm = mm;
    return true;
}

static bool set_feed_direction(path_options *o, const char *name, const char *value) {
    if (!get_number(name, value, &o->feed_deg)) return false;
    if (fabs(o->feed_deg) > 360)
        return app_refuse(name, "more than a whole turn; give -360 to 360");
    return true;
}

static bool set_max_tilt(path_options *o, const char *name, const char *value) {
    double degrees;
    o->machine_tilt = strcmp(value, "machine") == 0;
    if (o->machine_tilt) return true;
    if (!get_number(name, value, &degrees)) return false;
    if (!(degrees >= 0 && degrees <= 90)) return app_refuse(name, "'%s'; give 0 to 90", value);
    o->max_tilt_deg = degrees;
    o->solver.max_tilt_rad = fmin(degrees * (BTG_PI / 180), BTG_PI / 2);
    return true;
}

static bool set_tolerance(path_options *o, const char *name, const char *value) {
    double mm;
    if (!get_number(name, value, &mm)) return false;
    if (!(mm >= 1e-9 && mm <= 1)) return app_refuse(name, "'%s'; give 1e-9 to 1 mm", value);
    o->solver.tolerance_mm = mm;
    return true;
}

static bool set_node_budget(path_options *o, const char *name, const char *value) {
    uint32_t n;
    if (!number_parse_count(value, &n) || n < 1) {
        return app_refuse(name, "'%.100s'; give a whole number from 1 to 999999999", value);
    }
    o->solver.node_budget = n;
    return true;
}

static bool set_threads(path_options *o, const char *name, const char *value) {
    uint32_t n;
    if (!number_parse_count(value, &n) || n < 1 || n > 1024) {
        return app_refuse(name, "'%.100s'; give a whole number from 1 to 1024", value);
    }
    o->threads = n;
    return true;
}

/* ---- the rest ----------------------------------------------------------------------------- */

static bool set_feed(path_options *o, const char *name, const char *value) {
    if (!get_positive(name, value, &o->feed_mm_per_min)) return false;
    if (o->feed_mm_per_min >= 1e-3 && o->feed_mm_per_min <= 1e6) return true;
    return app_refuse(name, "'%s'; give 0.001 to 1e6 mm per minute", value);
}

static bool set_machine(path_options *o, const char *name, const char *value) {
    if (value[0] == '\0') return app_refuse(name, "give a machine's name or file");
    o->machine = value;
    return true;
}

static bool set_tool_length(path_options *o, const char *name, const char *value) {
    if (!get_positive(name, value, &o->tool_length_mm)) return false;
    if (o->tool_length_mm <= BTG_LENGTH_MAX) return true;
    return app_refuse(name, "'%s'; give at most 1e6 mm", value);
}

static bool set_spindle(path_options *o, const char *name, const char *value) {
    double rpm;
    if (!get_number(name, value, &rpm)) return false;
    if (!(rpm >= 0 && rpm <= 1e6)) return app_refuse(name, "'%s'; give 0 to 1e6", value);
    o->spindle_rpm = rpm;
    return true;
}

static bool set_motion_tolerance(path_options *o, const char *name, const char *value) {
    double mm;
    if (!get_number(name, value, &mm)) return false;
    if (!(mm >= 1e-6 && mm <= 1)) return app_refuse(name, "'%s'; give 1e-6 to 1 mm", value);
    o->motion_tolerance_mm = mm;
    return true;
}

static bool set_chord_tolerance(path_options *o, const char *name, const char *value) {
    double mm;
    if (!get_number(name, value, &mm)) return false;
    if (!(mm >= 1e-6 && mm <= 1)) return app_refuse(name, "'%s'; give 1e-6 to 1 mm", value);
    o->chord_mm = mm;
    return true;
}

static bool set_max_axis_change(path_options *o, const char *name, const char *value) {
    if (!get_positive(name, value, &o->max_axis_change_deg)) return false;
    if (o->max_axis_change_deg <= 1e6) return true;
    return app_refuse(name, "'%s'; give at most 1e6 degrees per mm", value);
}

static bool set_tool_number(path_options *o, const char *name, const char *value) {
    if (number_parse_count(value, &o->tool_number) && o->tool_number <= 99999999) return true;
    return app_refuse(name, "'%.100s'; give a whole number of up to 8 digits", value);
}

static bool set_unit(path_options *o, const char *name, const char *value) {
    if (strcmp(value, "m") != 0 && strcmp(value, "mm") != 0) {
        return app_refuse(name, "unknown '%.100s'; give m or mm", value);
    }
    o->gltf.unit = value[1] == 'm' ? BTG_GLTF_MILLIMETRE : BTG_GLTF_METRE;
    return true;
}

static bool set_up(path_options *o, const char *name, const char *value) {
    if (strcmp(value, "y") != 0 && strcmp(value, "z") != 0) {
        return app_refuse(name, "unknown '%.100s'; give y or z", value);
    }
    o->gltf.up = value[0] == 'z' ? BTG_GLTF_UP_Z : BTG_GLTF_UP_Y;
    return true;
}

static bool set_use_mesh(path_options *o, const char *name, const char *value) {
    (void)name, (void)value;
    o->gltf.use_mesh = 1;
    return true;
}

static bool set_gl_context(path_options *o, const char *name, const char *value) {
    o->gl_context = value;
    if (strcmp(value, "auto") == 0 || strcmp(value, "osmesa") == 0 || strcmp(value, "egl") == 0)
        return true;
    return app_refuse(name, "unknown '%.100s'; give one of auto, osmesa, egl", value);
}

static bool set_raw(path_options *o, const char *name, const char *value) {
    (void)name, (void)value;
    o->raw = true;
    return true;
}

static bool set_json(path_options *o, const char *name, const char *value) {
    (void)name, (void)value;
    o->json = true;
    return true;
}

static bool set_quiet(path_options *o, const char *name, const char *value) {
    (void)name, (void)value;
    o->quiet = true;
    return true;
}

static bool set_help(path_options *o, const char *name, const char *value) {
    (void)name, (void)value;
    o->help = true;
    return true;
}

const option path_option_list[] = {
    {"-o", set_output, false},
    {"--output", set_output, false},
    {"--tool", set_tool, false},
    {"--shank", set_shank, false},
    {"--holder", set_holder, false},
    {"--side-step", set_side_step, false},
    {"--forward-step", set_forward_step, false},
    {"--footprint", set_footprint, false},
    {"--overrun", set_overrun, false},
    {"--method", set_method, false},
    {"--ray-spacing", set_ray_spacing, false},
    {"--backend", set_backend, false},
    {"--spin", set_spin, false},
    {"--scallop", set_scallop, false},
    {"--feed-direction", set_feed_direction, false},
    {"--max-tilt", set_max_tilt, false},
    {"--tolerance", set_tolerance, false},
    {"--node-budget", set_node_budget, false},
    {"--threads", set_threads, false},
    {"--feed", set_feed, false},
    {"--machine", set_machine, false},
    {"--tool-length", set_tool_length, false},
    {"--tool-number", set_tool_number, false},
    {"--spindle", set_spindle, false},
    {"--motion-tolerance", set_motion_tolerance, false},
    {"--chord-tolerance", set_chord_tolerance, false},
    {"--max-axis-change", set_max_axis_change, false},
    {"--gltf-unit", set_unit, false},
    {"--up", set_up, false},
    {"--use-mesh", set_use_mesh, true},
    {"--raw", set_raw, true},
    {"--gl-context", set_gl_context, false},
    {"--json", set_json, true},
    {"--quiet", set_quiet, true},
    {"--help", set_help, true},
    {"-h", set_help, true},
    {"--levels", set_levels, false},
    {"--window", set_window, false},
};
const size_t path_option_count = sizeof path_option_list / sizeof path_option_list[0];
