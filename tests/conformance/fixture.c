#include "conformance.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void fixture_init(fixture *f, btg_op op) {
    memset(f, 0, sizeof *f);
    f->op = op;
    f->solver = btg_solver_def_default();
    fixture_tool(f, 6.7, 6, BTG_PROFILE_TOROIDAL);
}

void fixture_free(fixture *f) {
    btg_backend_close(f->reference);
    btg_part_destroy(f->part);
    model_free(&f->model);
    free(f->drops);
    free(f->tilts);
    free(f->wants);
}

static void make_tool(fixture *f, const btg_tool_def *def) {
    btg_message message;
    btg_tool tool;
    if (btg_tool_init(def, &tool, &message) != BTG_OK) {
        fprintf(stderr, "fixture: %s\n", message.text);
        exit(2);
    }
    f->tool = tool;
}

void fixture_tool(fixture *f, double major, double minor, btg_profile profile) {
    btg_tool_def def = btg_tool_def_default();
    def.major_radius_mm = major;
    def.minor_radius_mm = minor;
    def.profile = profile;
    make_tool(f, &def);
}

void fixture_cylinder(fixture *f, double radius, double from, double to) {
    btg_tool_def def = f->tool.def;
    btg_cylinder c = {radius, from, to};
    if (def.shank.radius_mm == 0)
        def.shank = c;
    else
        def.holder[def.holder_count++] = c;
    make_tool(f, &def);
}

void fixture_part(fixture *f) {
    f->part = model_part(&f->model);
}

static void grow(fixture *f) {
    if (f->count < f->capacity) return;
    f->capacity = 2 * f->capacity + 16;
    f->drops = realloc(f->drops, f->capacity * sizeof *f->drops);
    f->tilts = realloc(f->tilts, f->capacity * sizeof *f->tilts);
    f->wants = realloc(f->wants, f->capacity * sizeof *f->wants);
    if (!f->drops || !f->tilts || !f->wants) abort();
}

void fixture_drop(fixture *f, btg_drop_query query, want w) {
    grow(f);
    f->drops[f->count] = query;
    f->wants[f->count++] = w;
}

static btg_backend *open_backend(const fixture *f, const char *name, uint32_t threads) {
    btg_backend_def def = btg_backend_def_default();
    def.name = name;
    def.threads = threads;
    btg_backend *b = NULL;
    btg_message message;
    if (btg_backend_open(&def, f->part, &f->tool, &f->solver, &b, &message) == BTG_OK) return b;
    printf("    %s: %s\n", name, message.text);
    return NULL;
}

static btg_drop_result reference_drop(fixture *f, const btg_drop_query *query) {
    if (!f->reference) f->reference = open_backend(f, "reference", 1);
    btg_drop_result result = {.status = BTG_NO_CONTACT};
    if (!f->reference || btg_backend_drop(f->reference, query, 1, &result, NULL) != BTG_OK) abort();
    return result;
}

void fixture_foot(fixture *f, double x, double y, want w) {
    btg_drop_query query = btg_position_drop_query(x, y);
    if (f->op == BTG_OP_DROP) {
        fixture_drop(f, query, w);
        return;
    }
    btg_drop_result drop = reference_drop(f, &query);
    btg_tilt_query tilt;
    if (btg_position_tilt_query(&f->tool, &f->solver, &query, &drop, &tilt) != BTG_OK) return;
    grow(f);
    f->tilts[f->count] = tilt;
    f->wants[f->count++] = w;
}

want known(double value) {
    return (want){true, BTG_OK, value, 1, false};
}

want known_status(btg_status status) {
    return (want){true, status, 0, 1, false};
}

static bool run_drop(const fixture *f, btg_backend *b, answer *answers) {
    btg_drop_result *r = calloc(f->count + 1, sizeof *r);
    btg_status status = btg_backend_drop(b, f->drops, f->count, r, NULL);
    for (size_t i = 0; i < f->count; i++)
        answers[i] = (answer){r[i].status, r[i].height_mm, r[i].contact, r[i].element};
    free(r);
    return status == BTG_OK;
}

static bool run_tilt(const fixture *f, btg_backend *b, answer *answers) {
    btg_tilt_result *r = calloc(f->count + 1, sizeof *r);
    btg_status status = btg_backend_tilt(b, f->tilts, f->count, r, NULL);
    for (size_t i = 0; i < f->count; i++)
        answers[i] = (answer){r[i].status, r[i].tilt_rad, r[i].contact, r[i].element};
    free(r);
    return status == BTG_OK;
}

bool fixture_run(const fixture *f, const char *backend, uint32_t threads, answer *answers) {
    btg_backend *b = open_backend(f, backend, threads);
    if (!b) return false;
    bool done = f->op == BTG_OP_DROP ? run_drop(f, b, answers) : run_tilt(f, b, answers);
    btg_backend_close(b);
    return done;
}

btg_placement fixture_place(const fixture *f, size_t i, double value) {
    if (f->op == BTG_OP_DROP) {
        const btg_drop_query *q = &f->drops[i];
        return (btg_placement){vec_mad(q->origin, q->axis, value), q->axis, true};
    }
    const btg_tilt_query *q = &f->tilts[i];
    double c = cos(value), s = sin(value);
    btg_vec3 v = vec_mad(vec_scale(q->v, c), q->w, -s), w = vec_mad(vec_scale(q->w, c), q->v, s);
    return (btg_placement){vec_mad(q->o1, v, f->tool.def.major_radius_mm), w, false};
}

double fixture_size(const fixture *f) {
    return fmax(f->tool.def.minor_radius_mm, f->tool.def.major_radius_mm / 2);
}

double fixture_scale(const fixture *f) {
    btg_part_info info;
    btg_part_get_info(f->part, &info);
    btg_vec3 a = info.box_min, b = info.box_max;
    double x = fmax(fabs(a.x), fabs(b.x)), y = fmax(fabs(a.y), fabs(b.y));
    return fmax(fmax(x, y), fmax(fabs(a.z), fabs(b.z)));
}
