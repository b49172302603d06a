/* The report's table of back ends: what each makes of the same positions, and how fast. */
#include "app/app.h"
#include "app/bench.h"
#include "app/report.h"
#include "core/part.h"

#include <stdlib.h>
#include <string.h>

#define SAMPLE_MAX 512
#define SAMPLE_MIN 8
#define SECONDS    0.25 /* that one back end may take, about */

typedef struct trial {
    size_t count; /* of positions */
    double seconds;
    double difference_mm;
    btg_position positions[SAMPLE_MAX];
} trial;

/* Places of the path, evenly spread; a prefix of them is spread too. */
static size_t choose(const btg_scene *scene, double *xy) {
    size_t count = scene->count < SAMPLE_MAX ? scene->count : SAMPLE_MAX;
    double at = 0;
    for (size_t i = 0; i < count; i++) {
        at += 0.6180339887498949;
        size_t k =
            scene->count < SAMPLE_MAX ? i : (size_t)((at - floor(at)) * (double)scene->count);
        memcpy(xy + 2 * i, scene->stops[k].foot_mm, 2 * sizeof *xy);
    }
    return count;
}

/* A few first, which also warms up, then as many as the time allows. */
static btg_status solve(btg_backend *backend, const double *xy, size_t count, trial *t) {
    size_t few = count < SAMPLE_MIN ? count : SAMPLE_MIN;
    double begin = app_seconds();
    btg_status status = btg_backend_positions(backend, xy, few, t->positions, NULL);
    double each = (app_seconds() - begin) / (double)few;
    t->count = each * (double)count > SECONDS ? (size_t)(SECONDS / each) : count;
    if (t->count < few) t->count = few;
    if (status < 0) return status;
    begin = app_seconds();
    status = btg_backend_positions(backend, xy, t->count, t->positions, NULL);
    t->seconds = app_seconds() - begin;
    return status < 0 ? status : BTG_OK;
}

static btg_status try_one(const report *r, const char *name, const double *xy, size_t count,
                          trial *t, btg_message *why) {
    const path_options *o = r->summary->options;
    btg_backend_def def = btg_backend_def_default();
    btg_solver_def solver = o->solver;
    solver.feed_x = cos(o->feed_deg * (BTG_PI / 180));
    solver.feed_y = sin(o->feed_deg * (BTG_PI / 180));
    btg_backend *backend = NULL;
    def.name = name;
    def.threads = o->threads;
    btg_status status = btg_backend_open(&def, r->part, r->tool, &solver, &backend, why);
    if (status != BTG_OK) return status;
    status = solve(backend, xy, count, t);
    btg_backend_close(backend);
    return status == BTG_OK ? status : btg_fail(why, status, "%s", btg_status_name(status));
}

static void compare(const report *r, trial *t, const trial *other) {
    size_t both = t->count < other->count ? t->count : other->count;
    for (size_t i = 0; i < both; i++) {
        double d = bench_difference(r->tool, &r->summary->options->solver, &t->positions[i],
                                    &other->positions[i]);
        if (!(d <= t->difference_mm)) t->difference_mm = d;
    }
}

btg_status report_backends(const report *r, btg_json *json, btg_message *message) {
    double xy[2 * SAMPLE_MAX];
    size_t count = choose(r->scene, xy);
    trial *first = calloc(2, sizeof *first), *t = first + 1;
    if (!first) return btg_fail(message, BTG_ERROR_MEMORY, "report: out of memory");
    btg_json_open(json, "backends", '[');
    for (size_t i = 0; i < btg_backend_count(); i++) {
        btg_backend_info info;
        btg_message why;
        if (btg_backend_get_info(i, &info) != BTG_OK) continue;
        btg_json_open(json, NULL, '{');
        btg_json_string(json, "name", info.name);
        btg_json_string(json, "state", btg_backend_state_name(info.state));
        btg_json_string(json, "device", info.device);
        btg_json_bool(json, "used", strcmp(info.name, r->summary->backend) == 0);
        memset(t, 0, sizeof *t);
        if (info.state == BTG_BACKEND_READY) {
            if (try_one(r, info.name, xy, count, t, &why) == BTG_OK) {
                compare(r, t, first->count > 0 ? first : t);
                btg_json_count(json, "positions", t->count);
                btg_json_number(json, "seconds", t->seconds);
                btg_json_number(json, "difference_mm", first->count > 0 ? t->difference_mm : NAN);
                if (first->count == 0) *first = *t;
            } else {
                btg_json_string(json, "failed", why.text);
            }
        }
        btg_json_close(json, '}');
    }
    btg_json_close(json, ']');
    free(first);
    return BTG_OK;
}
