#include "app/options.h"
#include "app/app.h"
#include "methods/method.h"

#include <math.h>
#include <string.h>

void options_default(path_options *o) {
    memset(o, 0, sizeof *o);
    o->tool = btg_tool_def_default();
    o->footprint = btg_footprint_def_default();
    o->lift_mm = 20.0;
    o->feed_mm_per_min = 1000.0;
    o->tool_length_mm = NAN;
    o->spindle_rpm = 3000.0;
    o->motion_tolerance_mm = 0.002;
    o->tool_number = 1;
    o->method = "vcrf";
    o->ray_spacing_mm = btg_method_def_default().ray_spacing_mm;
    o->levels = btg_method_def_default().levels;
    o->backend = "auto";
    o->solver = btg_solver_def_default();
    o->solver.scallop_mm = 0.01;
    o->feed_deg = 90.0;
    o->max_tilt_deg = 45.0;
    o->gltf = btg_gltf_def_default();
}

static const option *find(const char *word, size_t size) {
    for (size_t i = 0; i < path_option_count; i++) {
        const char *name = path_option_list[i].name;
        if (strlen(name) == size && strncmp(word, name, size) == 0) return &path_option_list[i];
    }
    return NULL;
}

static bool take_part(path_options *o, const char *word) {
    if (word[0] == '\0') return app_refuse("path", "the part's name is empty");
    if (o->part) {
        return app_refuse("path", "two parts, '%.200s' and '%.200s'; give one", o->part, word);
    }
    o->part = word;
    return true;
}

/* words[*i] is an option; its value may be the word after it, or follow a `=`. */
static bool take_option(path_options *o, int count, char **words, int *i) {
    char *word = words[*i];
    const char *equals = strncmp(word, "--", 2) == 0 ? strchr(word, '=') : NULL;
    size_t size = equals ? (size_t)(equals - word) : strlen(word);
    const option *found = find(word, size);
    if (!found) {
        return app_refuse("path", "unknown option '%.200s'; see 'bitangent help path'", word);
    }
    if (found->flag) {
        if (equals) return app_refuse(found->name, "takes no value");
        return found->set(o, found->name, NULL);
    }
    const char *value = equals ? equals + 1 : NULL;
    if (!value) {
        if (*i + 1 >= count) {
            return app_refuse(found->name, "needs a value; see 'bitangent help path'");
        }
        value = words[++*i];
    }
    return found->set(o, found->name, value);
}

static bool check_machine(const path_options *o) {
    for (int i = 0; i < o->output_count; i++) {
        if (o->outputs[i].kind != OUTPUT_NGC || o->machine) continue;
        return app_refuse("-o", "'%.200s' is a program for a machine; say which with --machine",
                          o->outputs[i].path);
    }
    return true;
}

static bool check_tilt(const path_options *o) {
    if (!o->machine_tilt || o->machine) return true;
    return app_refuse("--max-tilt", "'machine' is that of --machine; say which");
}

/* What the motion between positions is made of. */
static bool check_motion(const path_options *o) {
    bool proven = strcmp(o->method, "vcrf") == 0 && !o->raw;
    if (o->chord_mm > 0 && !proven)
        return app_refuse("--chord-tolerance",
                          "wants positions that are proven; drop --raw and --method");
    if (o->max_axis_change_deg > 0 && o->solver.spin != BTG_SPIN_NONE)
        return app_refuse("--max-axis-change", "is for tools without spin; drop --spin");
    return true;
}

bool options_parse(int count, char **words, path_options *options) {
    bool only_parts = false;
    options_default(options);
    for (int i = 0; i < count && !options->help; i++) {
        const char *word = words[i];
        bool taken;
        if (!only_parts && strcmp(word, "--") == 0) {
            only_parts = true;
            continue;
        }
        if (!only_parts && word[0] == '-' && word[1] != '\0') {
            taken = take_option(options, count, words, &i);
        } else {
            taken = take_part(options, word);
        }
        if (!taken) return false;
    }
    if (options->help) return true;
    if (options->part)
        return check_machine(options) && check_tilt(options) && check_motion(options);
    return app_refuse("path", "no part; give a glTF file, see 'bitangent help path'");
}

/* ---- options lent to other commands ------------------------------------------------------- */

static bool named(const char *name, const char *word, size_t size) {
    return strlen(name) == size && strncmp(word, name, size) == 0;
}

static const option *borrow(bool (*lent)(const char *name), const char *word, size_t size) {
    for (size_t k = 0; k < path_option_count; k++) {
        const option *o = &path_option_list[k];
        if (named(o->name, word, size)) return lent(o->name) ? o : NULL;
    }
    return NULL;
}

bool options_word(const char *command, const char *(*own_name)(size_t number),
                  bool (*lent)(const char *name), int count, char **words, int *i,
                  option_word *out) {
    const char *word = words[*i];
    const char *equals = strncmp(word, "--", 2) == 0 ? strchr(word, '=') : NULL;
    size_t size = equals ? (size_t)(equals - word) : strlen(word), k = 0;
    const option *path = borrow(lent, word, size);
    while (own_name(k) && !named(own_name(k), word, size))
        k++;
    if (!path && !own_name(k))
        return app_refuse(command, "unknown option '%.200s'; see 'bitangent help %s'", word,
                          command);
    *out = (option_word){path, k, path ? path->name : own_name(k), equals ? equals + 1 : NULL};
    if (path && path->flag) return !equals || app_refuse(out->name, "takes no value");
    if (out->value) return true;
    if (*i + 1 >= count)
        return app_refuse(out->name, "needs a value; see 'bitangent help %s'", command);
    out->value = words[++*i];
    return true;
}

bool options_part_and_path(const char *command, const char *word, path_options *options,
                           const char **track) {
    if (word[0] == '\0') return app_refuse(command, "a file's name is empty");
    if (!options->part) {
        options->part = word;
        return true;
    }
    if (*track) return app_refuse(command, "a third file, '%.200s'; give a part and a path", word);
    *track = word;
    return true;
}
