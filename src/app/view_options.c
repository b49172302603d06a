#include "app/view_options.h"
#include "app/app.h"
#include "app/number.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* Options of `bitangent path` that say nothing of a view: its outputs. */
static const char *const foreign[] = {"-o",        "--output",          "--feed", "--tool-number",
                                      "--spindle", "--motion-tolerance"};

static bool set_screenshot(view_options *o, const char *name, const char *value) {
    size_t size = strlen(value);
    if (size < 5 || strcasecmp(value + size - 4, ".png") != 0)
        return app_refuse(name, "'%.200s'; give a file that ends in .png", value);
    o->screenshot = value;
    return true;
}

static bool set_size(view_options *o, const char *name, const char *value) {
    char *end;
    long width = strtol(value, &end, 10), height = 0;
    if (*end == 'x' && end[1] >= '0' && end[1] <= '9') height = strtol(end + 1, &end, 10);
    bool fits = *end == '\0' && width >= VIEW_SIDE_MIN && width <= VIEW_SIDE_MAX &&
                height >= VIEW_SIDE_MIN && height <= VIEW_SIDE_MAX;
    if (!fits)
        return app_refuse(name, "'%.100s'; give WIDTHxHEIGHT in pixels, %d to %d each", value,
                          VIEW_SIDE_MIN, VIEW_SIDE_MAX);
    o->width = (int)width, o->height = (int)height;
    return true;
}

static bool set_position(view_options *o, const char *name, const char *value) {
    uint32_t n;
    if (!number_parse_count(value, &n) || n < 1)
        return app_refuse(name, "'%.100s'; give a whole number from 1", value);
    o->position = n;
    return true;
}

static bool set_view_from(view_options *o, const char *name, const char *value) {
    (void)name;
    o->view_from = value;
    return true;
}

static bool set_look_at(view_options *o, const char *name, const char *value) {
    if (strcmp(value, "tool") != 0 && strcmp(value, "part") != 0)
        return app_refuse(name, "unknown '%.100s'; give tool or part", value);
    o->look_at_part = value[0] == 'p';
    return true;
}

static bool set_keys(view_options *o, const char *name, const char *value) {
    for (const char *s = value;; s++) {
        size_t size = strcspn(s, ",");
        if (size == 0 || size >= sizeof o->keys[0])
            return app_refuse(name, "'%.100s'; give keys like space,right,n", value);
        if (o->key_count == VIEW_KEYS_MAX)
            return app_refuse(name, "more than %d keys; give fewer", VIEW_KEYS_MAX);
        memcpy(o->keys[o->key_count], s, size);
        o->keys[o->key_count++][size] = '\0';
        s += size;
        if (*s == '\0') return true;
    }
}

static const struct {
    const char *name;
    bool (*set)(view_options *o, const char *name, const char *value);
} own[] = {
    {"--screenshot", set_screenshot}, {"--size", set_size},       {"--position", set_position},
    {"--view-from", set_view_from},   {"--look-at", set_look_at}, {"--keys", set_keys},
};

static const char *own_name(size_t number) {
    return number < sizeof own / sizeof *own ? own[number].name : NULL;
}

static bool lent(const char *name) {
    for (size_t i = 0; i < sizeof foreign / sizeof *foreign; i++)
        if (strcmp(foreign[i], name) == 0) return false;
    return true;
}

static bool take_option(view_options *o, int count, char **words, int *i) {
    option_word w;
    if (!options_word("view", own_name, lent, count, words, i, &w)) return false;
    if (!w.path) return own[w.own].set(o, w.name, w.value);
    if (strcmp(w.name, "--tool") == 0) o->tool_given = true;
    return w.path->set(&o->path, w.name, w.value);
}

bool view_options_parse(int count, char **words, view_options *o) {
    memset(o, 0, sizeof *o);
    options_default(&o->path);
    o->width = 1280, o->height = 800;
    bool only_files = false;
    for (int i = 0; i < count && !o->path.help; i++) {
        const char *word = words[i];
        if (!only_files && strcmp(word, "--") == 0) {
            only_files = true;
            continue;
        }
        bool dash = !only_files && word[0] == '-' && word[1] != '\0';
        if (!(dash ? take_option(o, count, words, &i)
                   : options_part_and_path("view", word, &o->path, &o->track)))
            return false;
    }
    if (o->path.help || o->path.part) return true;
    return app_refuse("view", "no part; give a glTF file, see 'bitangent help view'");
}
