#include "app/app.h"
#include "app/number.h"
#include "app/verify.h"
#include "core/vec.h"
#include "io/picture.h"

#include <string.h>
#include <strings.h>

/* Options of `bitangent path` that mean the same here. */
static const char *const borrowed[] = {
    "--tool", "--shank",    "--holder", "--machine", "--tool-length", "--threads", "--gltf-unit",
    "--up",   "--use-mesh", "--json",   "--quiet",   "--help",        "-h"};

static bool set_length(const char *name, const char *value, double least, double *mm) {
    double x;
    if (!number_parse(value, strlen(value), &x))
        return app_refuse(name, "'%.100s' is not a number; give one like 0.1", value);
    if (!(x >= least && x <= BTG_LENGTH_MAX))
        return app_refuse(name, "'%.100s'; give %g to 1e6 mm", value, least);
    *mm = x;
    return true;
}

static bool set_grid(verify_options *o, const char *name, const char *value) {
    return set_length(name, value, 1e-4, &o->def.cell_mm);
}

static bool set_max_gouge(verify_options *o, const char *name, const char *value) {
    if (!set_length(name, value, 0, &o->max_gouge_mm)) return false;
    o->def.gouge_mm = o->max_gouge_mm;
    return true;
}

static bool set_max_scallop(verify_options *o, const char *name, const char *value) {
    if (!set_length(name, value, 0, &o->max_scallop_mm)) return false;
    o->def.scallop_mm = o->max_scallop_mm;
    return true;
}

static bool set_sweep_error(verify_options *o, const char *name, const char *value) {
    return set_length(name, value, 1e-6, &o->def.sweep_error_mm);
}

static bool set_stock(verify_options *o, const char *name, const char *value) {
    return set_length(name, value, 0, &o->def.stock_mm);
}

static bool set_links(verify_options *o, const char *name, const char *value) {
    if (strcmp(value, "pass") != 0 && strcmp(value, "all") != 0)
        return app_refuse(name, "unknown '%.100s'; give pass or all", value);
    o->track_def.link_all = value[0] == 'a';
    return true;
}

static bool find_kind(const char *word, size_t size, verify_kind *kind) {
    static const char *const known[] = {"csv", "png", "glb"};
    for (int i = 0; i < 3; i++) {
        if (strlen(known[i]) != size || strncasecmp(word, known[i], size) != 0) continue;
        *kind = (verify_kind)i;
        return true;
    }
    return false;
}

static bool set_output(verify_options *o, const char *name, const char *value) {
    verify_output choice = {.path = value};
    const char *colon = strchr(value, ':'), *slash = strrchr(value, '/');
    const char *dot = strrchr(slash ? slash : value, '.');
    if (o->output_count == BTG_OUTPUT_MAX)
        return app_refuse(name, "more than %d files; give fewer", BTG_OUTPUT_MAX);
    if (colon && find_kind(value, (size_t)(colon - value), &choice.kind))
        choice.path = colon + 1;
    else if (!dot || !find_kind(dot + 1, strlen(dot + 1), &choice.kind))
        return app_refuse(name, "'%.200s' has no known ending; give .csv, .png or .glb", value);
    if (choice.path[0] == '\0') return app_refuse(name, "no file after '%.100s'", value);
    if (choice.kind == VERIFY_PNG && !btg_picture_available())
        return app_refuse(name,
                          "'%.200s': this build draws no pictures; install libcairo2-dev and "
                          "build again",
                          value);
    for (int i = 0; i < o->output_count; i++)
        if (strcmp(o->outputs[i].path, choice.path) == 0)
            return app_refuse(name, "'%.200s' is given twice", choice.path);
    o->outputs[o->output_count++] = choice;
    return true;
}

static const struct {
    const char *name;
    bool (*set)(verify_options *o, const char *name, const char *value);
} own[] = {
    {"-o", set_output},
    {"--output", set_output},
    {"--grid", set_grid},
    {"--max-gouge", set_max_gouge},
    {"--max-scallop", set_max_scallop},
    {"--sweep-error", set_sweep_error},
    {"--stock", set_stock},
    {"--links", set_links},
};

static const char *own_name(size_t number) {
    return number < sizeof own / sizeof *own ? own[number].name : NULL;
}

static bool lent(const char *name) {
    for (size_t i = 0; i < sizeof borrowed / sizeof *borrowed; i++)
        if (strcmp(borrowed[i], name) == 0) return true;
    return false;
}

static bool take_option(verify_options *o, int count, char **words, int *i) {
    option_word w;
    if (!options_word("verify", own_name, lent, count, words, i, &w)) return false;
    if (!w.path) return own[w.own].set(o, w.name, w.value);
    if (strcmp(w.name, "--tool") == 0) o->tool_given = true;
    return w.path->set(&o->path, w.name, w.value);
}

bool verify_options_parse(int count, char **words, verify_options *o) {
    memset(o, 0, sizeof *o);
    options_default(&o->path);
    o->def = btg_verify_def_default();
    o->max_gouge_mm = o->max_scallop_mm = INFINITY;
    bool only_files = false;
    for (int i = 0; i < count && !o->path.help; i++) {
        const char *word = words[i];
        if (!only_files && strcmp(word, "--") == 0) {
            only_files = true;
            continue;
        }
        bool dash = !only_files && word[0] == '-' && word[1] != '\0';
        if (!(dash ? take_option(o, count, words, &i)
                   : options_part_and_path("verify", word, &o->path, &o->track)))
            return false;
    }
    o->def.threads = o->path.threads;
    if (o->path.help || o->track) return true;
    return app_refuse("verify", "no %s; give a part and its path, see 'bitangent help verify'",
                      o->path.part ? "path" : "part");
}
