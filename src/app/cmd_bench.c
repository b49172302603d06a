/* `bitangent bench`: the command line, and who does the work. */
#include "app/app.h"
#include "app/bench.h"
#include "app/number.h"
#include "app/papers.h"
#include "io/picture.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define SECONDS       50.0
#define SECONDS_QUICK 3.0
#define SECONDS_MIN   0.1
#define SECONDS_MAX   86400.0
/* Degrees; the greatest tilt on the papers' surfaces is 17. */
#define PAPERS_TILT 20
/* What the papers' accuracy is compared at: finer than any machine. */
#define TOLERANCE_MM 1e-6

/* Options of `bitangent path` that mean the same here. */
static const char *const borrowed[] = {
    "--tool",     "--tolerance", "--max-tilt", "--node-budget", "--gltf-unit", "--up",
    "--use-mesh", "--json",      "--quiet",    "--help",        "-h",
};

static bool set_only(bench_options *o, const char *name, const char *value) {
    memset(o->measure, 0, sizeof o->measure);
    o->chosen = true;
    for (const char *word = value;; word++) {
        size_t size = strcspn(word, ",");
        int m = 0;
        while (m < BENCH_MEASURES && (strlen(bench_measure_name[m]) != size ||
                                      strncmp(word, bench_measure_name[m], size) != 0))
            m++;
        if (m == BENCH_MEASURES)
            return app_refuse(name, "unknown measure in '%.100s'; see 'bitangent help bench'",
                              value);
        o->measure[m] = true;
        word += size;
        if (*word == '\0') return true;
    }
}

static bool set_seconds(bench_options *o, const char *name, const char *value) {
    double x;
    if (!number_parse(value, strlen(value), &x) || x < SECONDS_MIN || x > SECONDS_MAX)
        return app_refuse(name, "'%.100s'; give 0.1 to 86400 s", value);
    o->seconds = x;
    return true;
}

static bool set_points(bench_options *o, const char *name, const char *value) {
    (void)name;
    o->path.points = value;
    return true;
}

static bool set_csv(bench_options *o, const char *name, const char *value) {
    if (value[0] == '\0') return app_refuse(name, "the file's name is empty");
    o->csv = value;
    return true;
}

static bool set_commit(bench_options *o, const char *name, const char *value) {
    (void)name;
    o->commit = value;
    return true;
}

static bool set_quick(bench_options *o, const char *name, const char *value) {
    (void)name, (void)value;
    o->quick = true;
    return true;
}

static bool set_speed(bench_options *o, const char *name, const char *value) {
    (void)name, (void)value;
    for (int m = 0; m < BENCH_MEASURES; m++)
        o->measure[m] = o->measure[m] || m != BENCH_BACKENDS;
    o->chosen = true;
    return true;
}

static bool set_backends(bench_options *o, const char *name, const char *value) {
    (void)name, (void)value;
    o->measure[BENCH_BACKENDS] = o->chosen = true;
    return true;
}

static bool set_png(bench_options *o, const char *name, const char *value) {
    size_t size = strlen(value);
    if (size <= 4 || strcmp(value + size - 4, ".png") != 0)
        return app_refuse(name, "'%.100s'; a file that ends in .png", value);
    if (!btg_picture_available())
        return app_refuse(name, "this build draws no pictures; install libcairo2-dev and build "
                                "again");
    o->png = value;
    return true;
}

static bool set_papers(bench_options *o, const char *name, const char *value) {
    (void)name, (void)value;
    o->papers = true;
    return true;
}

static bool set_pictures(bench_options *o, const char *name, const char *value) {
    struct stat at;
    if (!btg_picture_available())
        return app_refuse(name, "this build draws no pictures; install libcairo2-dev and build "
                                "again");
    if (stat(value, &at) != 0 || !S_ISDIR(at.st_mode))
        return app_refuse(name, "'%.200s' is no folder; make it first", value);
    o->pictures = value;
    return true;
}

static const struct {
    const char *name;
    bool (*set)(bench_options *o, const char *name, const char *value);
    bool flag;
} own[] = {
    {"--speed", set_speed, true},    {"--quick", set_quick, true},
    {"--only", set_only, false},     {"--seconds", set_seconds, false},
    {"--points", set_points, false}, {"--csv", set_csv, false},
    {"--commit", set_commit, false}, {"--backends", set_backends, true},
    {"--output", set_png, false},    {"-o", set_png, false},
    {"--papers", set_papers, true},  {"--pictures", set_pictures, false},
};

typedef struct words {
    int count, next;
    char **list;
} words;

/* The value of an option: after its `=`, or the next word; NULL for a flag. */
static bool take_value(words *w, const char *name, const char *equals, bool flag,
                       const char **value) {
    *value = NULL;
    if (flag) return !equals || app_refuse(name, "takes no value");
    *value = equals ? equals + 1 : w->next < w->count ? w->list[w->next++] : NULL;
    return *value || app_refuse(name, "needs a value; see 'bitangent help bench'");
}

static bool named(const char *name, const char *word, size_t size) {
    return strlen(name) == size && strncmp(word, name, size) == 0;
}

static const option *find_borrowed(const char *word, size_t size) {
    bool known = false;
    for (size_t i = 0; i < sizeof borrowed / sizeof *borrowed; i++)
        known = known || named(borrowed[i], word, size);
    for (size_t i = 0; i < path_option_count && known; i++)
        if (named(path_option_list[i].name, word, size)) return &path_option_list[i];
    return NULL;
}

static bool take_option(bench_options *o, words *w, const char *word) {
    const char *value, *equals = strncmp(word, "--", 2) == 0 ? strchr(word, '=') : NULL;
    size_t size = equals ? (size_t)(equals - word) : strlen(word);
    for (size_t i = 0; i < sizeof own / sizeof *own; i++) {
        if (!named(own[i].name, word, size)) continue;
        return take_value(w, own[i].name, equals, own[i].flag, &value) &&
               own[i].set(o, own[i].name, value);
    }
    const option *x = find_borrowed(word, size);
    if (x)
        return take_value(w, x->name, equals, x->flag, &value) && x->set(&o->path, x->name, value);
    return app_refuse("bench", "unknown option '%.200s'; see 'bitangent help bench'", word);
}

static bool take_part(bench_options *o, const char *word) {
    if (word[0] == '\0') return app_refuse("bench", "the part's name is empty");
    if (o->part_count == BENCH_PARTS_MAX)
        return app_refuse("bench", "more than %d parts; give fewer", BENCH_PARTS_MAX);
    o->parts[o->part_count++] = word;
    return true;
}

/* What stands against what. */
static bool agree(const bench_options *o) {
    bool standard_only = o->measure[BENCH_TRIANGLES] || o->measure[BENCH_DEGREE];
    bool others = false;
    for (int m = 0; m < BENCH_MEASURES; m++)
        others = others || (o->measure[m] && m != BENCH_TRIANGLES && m != BENCH_DEGREE);
    if (o->papers && (o->part_count > 0 || o->chosen || o->png))
        return app_refuse("--papers", "stands alone: no PART, no other measure, no -o; pictures go "
                                      "to --pictures FOLDER");
    if (o->path.machine_tilt)
        return app_refuse("--max-tilt", "'machine'; bench knows no machine, give degrees");
    if (o->papers && o->path.max_tilt_deg < PAPERS_TILT)
        return app_refuse("--max-tilt", "the papers compare second contacts, which tilts up to 17 "
                                        "degrees reach; give 20 or more with --papers");
    if (o->pictures && !o->papers)
        return app_refuse("--pictures", "draws the papers' figures; give --papers");
    if (o->part_count > 0 && standard_only && !others)
        return app_refuse("--only", "triangles and degree are measured without a part");
    if (o->png && !o->measure[BENCH_BACKENDS])
        return app_refuse("--output", "the picture is of the back ends; add --backends");
    if (o->part_count > 1 && o->png)
        return app_refuse("--output", "the picture is of one part; give one");
    if (o->part_count == 0 && o->path.points)
        return app_refuse("--points", "the points belong to a part; give one");
    if (o->csv && strcmp(o->csv, "-") == 0 && o->path.json)
        return app_refuse("--csv", "the standard output takes --json already; give a file");
    return true;
}

static bool parse(bench_options *o, int count, char **list) {
    words w = {count, 0, list};
    bool only_parts = false;
    while (w.next < count && !o->path.help) {
        const char *word = list[w.next++];
        if (!only_parts && strcmp(word, "--") == 0) {
            only_parts = true;
        } else if (!only_parts && word[0] == '-' && word[1] != '\0') {
            if (!take_option(o, &w, word)) return false;
        } else if (!take_part(o, word)) {
            return false;
        }
    }
    for (int m = 0; m < BENCH_BACKENDS && !o->chosen; m++)
        o->measure[m] = true;
    if (o->seconds == 0) o->seconds = o->quick ? SECONDS_QUICK : SECONDS;
    return o->path.help || agree(o);
}

int app_bench(int count, char **list) {
    bench_options o = {.commit = ""};
    bench_rows rows = {0};
    options_default(&o.path);
    o.path.solver.tolerance_mm = TOLERANCE_MM;
    if (!parse(&o, count, list)) return APP_UNUSABLE;
    if (o.path.help) return app_help("bench");
    btg_output csv = {0}, png = {0};
    btg_message message;
    /* Opened first: a file that cannot be written shows before the work. */
    if (o.csv && btg_output_open(&csv, o.csv, &message) != BTG_OK)
        return app_complain(APP_FAILED, "%s", message.text);
    if (o.png && btg_output_open(&png, o.png, &message) != BTG_OK) {
        btg_output_discard(&csv);
        return app_complain(APP_FAILED, "%s", message.text);
    }
    if (o.papers) {
        int code = papers_run(&o, &csv);
        btg_output_discard(&csv);
        return code;
    }
    int code = bench_speed(&o, &rows);
    /* Wrong answers are part of the report. */
    if (code != APP_UNUSABLE && rows.count > 0) {
        int reported = bench_report(&o, &rows, &csv, &png);
        if (code == APP_DONE) code = reported;
    }
    btg_output_discard(&csv);
    btg_output_discard(&png);
    free(rows.list);
    return code;
}
