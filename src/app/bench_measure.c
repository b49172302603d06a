/* Rates and latencies of one part. */
#define _GNU_SOURCE
#include "app/bench_measure.h"
#include "app/app.h"
#include "core/part.h"

#include <stdlib.h>

/* Positions checked before a measurement. */
#define CHECKED        12
#define CHECKED_FEW    4 /* in haste, or where each takes long: */
#define MANY_TRIANGLES 500000
/* What the independent answers themselves are good to, mm. */
#define CHECK_ERROR_MM 2e-9
/* Runs of all measurements together with their warm-ups are about so many; latencies and checks
 * take the rest of the time. */
#define SLICES 520
#define RUNS   5
/* Part of the whole time for the latencies of one part. */
#define LATENCY_SHARE 0.025
#define LATENCY_MAX   1000000
/* Positions that the mean number of nodes is taken from. */
#define NODES_OF 128

double bench_slice(const bench_options *options) {
    return options->seconds / SLICES;
}

int bench_runs(const bench_options *options) {
    return options->quick ? 3 : RUNS;
}

/* ---- rows ---------------------------------------------------------------------------------- */

void bench_show(bench *b, const bench_subject *s, bench_measure measure) {
    if (!b->shown) return;
    fprintf(stderr, "\rbench: %s, %s\033[K", bench_measure_name[measure], s->name);
    fflush(stderr);
}

static void complain(bench *b, const bench_row *row) {
    if (b->shown) fprintf(stderr, "\r\033[K");
    b->wrong = true;
    app_complain(APP_FAILED, "bench: %s, %s on %s: off by %.3g mm, %.3g allowed; no figure",
                 bench_measure_name[row->measure], row->operation, row->surface, row->max_error_mm,
                 row->limit_mm);
}

bench_device bench_device_none(void) {
    const bench_deviation none = {NAN, NAN, NAN};
    return (bench_device){NAN, NAN, NAN, NAN, NAN, NAN, NAN, none, none};
}

bench_row bench_row_of(const bench_subject *s, bench_measure measure, const char *operation,
                       const btg_solver_def *solver, double error_mm) {
    bench_row row = {.measure = measure,
                     .operation = operation,
                     .backend = "cpu",
                     .method = "vcrf",
                     .threads = 1,
                     .tolerance_mm = solver->tolerance_mm,
                     .degree = s->degree,
                     .triangles = s->mesh.triangle_count,
                     .max_error_mm = error_mm,
                     .limit_mm = solver->tolerance_mm + CHECK_ERROR_MM,
                     .rate = {0, 0, NAN, NAN, NAN, NAN, NAN},
                     .latency_us = {NAN, NAN, NAN, NAN},
                     .latency_nodes = {NAN, NAN, NAN, NAN},
                     .nodes = NAN,
                     .ratio = NAN,
                     .build_triangles_per_second = NAN,
                     .bytes_per_triangle = NAN,
                     .device = bench_device_none()};
    snprintf(row.surface, sizeof row.surface, "%s", s->name);
    row.ok = error_mm <= row.limit_mm;
    return row;
}

btg_status bench_row_keep(bench *b, const bench_row *row) {
    bench_rows *r = b->rows;
    if (r->count == r->capacity) {
        size_t capacity = r->capacity > 0 ? 2 * r->capacity : 64;
        bench_row *list = realloc(r->list, capacity * sizeof *list);
        if (!list) return btg_fail(&b->message, BTG_ERROR_MEMORY, "bench: out of memory");
        r->list = list;
        r->capacity = capacity;
    }
    r->list[r->count++] = *row;
    if (!row->ok) complain(b, row);
    return BTG_OK;
}

/* ---- work ---------------------------------------------------------------------------------- */

btg_status bench_work_begin(bench *b, const bench_subject *s, const btg_solver_def *solver,
                            bench_work *w) {
    *w = (bench_work){.subject = s, .tool = &b->tool, .solver = solver};
    w->workspace_size = btg_position_workspace_size(s->part);
    w->workspace = malloc(w->workspace_size);
    if (w->workspace) return BTG_OK;
    return btg_fail(&b->message, BTG_ERROR_MEMORY, "bench: out of memory");
}

static btg_status drop_at(bench_work *w, const double *xy, btg_drop_query *query,
                          btg_drop_result *drop) {
    *query = btg_position_drop_query(xy[0], xy[1]);
    return btg_drop(w->subject->part, w->tool, w->solver, query, w->workspace, w->workspace_size,
                    drop);
}

static btg_status do_drops(void *user, size_t count) {
    bench_work *w = user;
    for (size_t i = 0; i < count; i++) {
        btg_drop_query query;
        btg_drop_result drop;
        const double *xy = w->subject->feet + 2 * (i % w->subject->foot_count);
        btg_status status = drop_at(w, xy, &query, &drop);
        if (status < 0) return status;
    }
    return BTG_OK;
}

static btg_status do_positions(void *user, size_t count) {
    bench_work *w = user;
    for (size_t i = 0; i < count; i++) {
        btg_position position;
        const double *xy = w->subject->feet + 2 * (i % w->subject->foot_count);
        btg_status status = btg_position_solve(w->subject->part, w->tool, w->solver, xy[0], xy[1],
                                               w->workspace, w->workspace_size, &position);
        if (status < 0) return status;
    }
    return BTG_OK;
}

/* A position in its two halves, with their nodes and, where `seconds` is not NULL, the moments
 * before, between and after. */
static btg_status halves(bench_work *w, const double *xy, uint32_t nodes[2], double seconds[3]) {
    btg_drop_query query;
    btg_drop_result drop;
    btg_tilt_query frame;
    btg_tilt_result tilt = {.nodes = 0};
    if (seconds) seconds[0] = app_seconds();
    btg_status status = drop_at(w, xy, &query, &drop);
    if (seconds) seconds[1] = app_seconds();
    if (status < 0) return status;
    status = btg_position_tilt_query(w->tool, w->solver, &query, &drop, &frame);
    bool tilts = status == BTG_OK;
    if (tilts) {
        status = btg_tilt(w->subject->part, w->tool, w->solver, &frame, w->workspace,
                          w->workspace_size, &tilt);
        if (status < 0 && status != BTG_ERROR_GOUGE) return status;
        tilts = status >= 0;
    }
    btg_position position;
    status = btg_position_assemble(w->tool, w->solver, xy[0], xy[1], &query, &drop,
                                   tilts ? &frame : NULL, tilts ? &tilt : NULL, &position);
    if (seconds) seconds[2] = app_seconds();
    nodes[0] = drop.nodes;
    nodes[1] = tilt.nodes;
    return status;
}

static btg_status mean_nodes(bench_work *w, double *drop, double *both) {
    double sum[2] = {0, 0};
    size_t n = w->subject->foot_count < NODES_OF ? w->subject->foot_count : NODES_OF;
    for (size_t i = 0; i < n; i++) {
        uint32_t nodes[2];
        btg_status status = halves(w, w->subject->feet + 2 * i, nodes, NULL);
        if (status < 0) return status;
        sum[0] += nodes[0];
        sum[1] += nodes[1];
    }
    *drop = sum[0] / (double)n;
    *both = (sum[0] + sum[1]) / (double)n;
    return BTG_OK;
}

btg_status bench_check_once(bench *b, bench_subject *s, const btg_solver_def *solver) {
    if (s->checked_to_mm == solver->tolerance_mm) return BTG_OK;
    size_t n = b->options->quick || s->mesh.triangle_count > MANY_TRIANGLES ? CHECKED_FEW : CHECKED;
    s->checked_to_mm = solver->tolerance_mm;
    return bench_check(s, &b->tool, solver, n, &s->error, &b->message);
}

btg_status bench_row_time(bench *b, bench_job job, void *user, double slices, bench_row *row) {
    if (!row->ok) return BTG_OK;
    btg_status status =
        bench_time(job, user, slices * bench_slice(b->options), bench_runs(b->options), &row->rate);
    if (status < 0)
        btg_fail(&b->message, status, "bench: %s: no answer (%s)", row->surface,
                 btg_status_name(status));
    return status;
}

/* Two rows: drops, and whole positions. */
btg_status bench_measure_rates(bench *b, bench_subject *s, bench_measure measure,
                               const btg_solver_def *solver, bool drops_only) {
    bench_work w;
    bench_show(b, s, measure);
    btg_status status = bench_check_once(b, s, solver);
    if (status == BTG_OK) status = bench_work_begin(b, s, solver, &w);
    if (status != BTG_OK) return status;
    bench_row drops = bench_row_of(s, measure, "drop", solver, s->error.drop_mm);
    bench_row positions = bench_row_of(s, measure, "position", solver, s->error.position_mm);
    btg_part_info info;
    btg_part_get_info(s->part, &info);
    if (measure == BENCH_TRIANGLES) {
        drops.build_triangles_per_second = (double)info.triangle_count / s->build_seconds;
        drops.bytes_per_triangle = (double)info.memory_bytes / (double)info.triangle_count;
    }
    status = bench_row_time(b, do_drops, &w, 1, &drops);
    if (status >= 0 && !drops_only) status = bench_row_time(b, do_positions, &w, 1, &positions);
    if (status >= 0) status = mean_nodes(&w, &drops.nodes, &positions.nodes);
    if (status >= 0) status = bench_row_keep(b, &drops);
    if (status >= 0 && !drops_only) status = bench_row_keep(b, &positions);
    free(w.workspace);
    return status < 0 ? status : BTG_OK;
}

/* ---- latency ------------------------------------------------------------------------------- */

typedef struct samples {
    size_t count;
    double *values[4]; /* us and nodes of drops, us and nodes of whole positions */
} samples;

static btg_status sample(bench *b, bench_work *w, samples *all) {
    btg_part_info info;
    btg_part_get_info(w->subject->part, &info);
    double end = app_seconds() + LATENCY_SHARE * b->options->seconds;
    for (size_t i = 0; all->count < LATENCY_MAX && app_seconds() < end; i++) {
        double xy[2], seconds[3];
        uint32_t nodes[2];
        bench_spread(&info, i, xy);
        btg_status status = halves(w, xy, nodes, seconds);
        if (status < 0) return status;
        all->values[0][all->count] = 1e6 * (seconds[1] - seconds[0]);
        all->values[1][all->count] = nodes[0];
        all->values[2][all->count] = 1e6 * (seconds[2] - seconds[0]);
        all->values[3][all->count] = nodes[0] + nodes[1];
        all->count++;
    }
    return BTG_OK;
}

static btg_status keep_latency(bench *b, const bench_subject *s, samples *all) {
    static const char *const operation[2] = {"drop", "position"};
    for (int i = 0; i < 2; i++) {
        double worst = i == 0 ? s->error.drop_mm : s->error.position_mm;
        bench_row row = bench_row_of(s, BENCH_LATENCY, operation[i], &b->solver, worst);
        if (row.ok) {
            double seconds = 0;
            for (size_t k = 0; k < all->count; k++)
                seconds += 1e-6 * all->values[2 * i][k];
            double rate = (double)all->count / seconds;
            row.rate = (bench_rate){1, all->count, seconds, rate, rate, rate, NAN};
            row.latency_positions = all->count;
            row.latency_us = bench_quantiles_of(all->values[2 * i], all->count);
            row.latency_nodes = bench_quantiles_of(all->values[2 * i + 1], all->count);
        }
        btg_status status = bench_row_keep(b, &row);
        if (status < 0) return status;
    }
    return BTG_OK;
}

btg_status bench_measure_latency(bench *b, bench_subject *s) {
    bench_work w;
    samples all = {0};
    bench_show(b, s, BENCH_LATENCY);
    btg_status status = bench_check_once(b, s, &b->solver);
    if (status == BTG_OK) status = bench_work_begin(b, s, &b->solver, &w);
    if (status != BTG_OK) return status;
    for (int i = 0; i < 4; i++) {
        all.values[i] = malloc(LATENCY_MAX * sizeof *all.values[i]);
        if (!all.values[i]) status = BTG_ERROR_MEMORY;
    }
    if (status == BTG_OK) status = do_positions(&w, 64); /* warm */
    if (status >= 0) status = sample(b, &w, &all);
    if (status < 0) {
        btg_fail(&b->message, status, "bench: %s: no answer (%s)", s->name,
                 btg_status_name(status));
    } else {
        status = keep_latency(b, s, &all);
    }
    for (int i = 0; i < 4; i++)
        free(all.values[i]);
    free(w.workspace);
    return status;
}
