/* What `bitangent bench --speed` measures. Every piece of work is checked first; one that answers
 * wrongly gets no figure. */
#define _GNU_SOURCE
#include "app/app.h"
#include "app/bench.h"
#include "bitangent/backend.h"
#include "core/part.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

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
/* Positions of a batch for threads, and the uneven pieces it is cut into to see that they do not
 * show. */
#define BATCH 4096
#define PIECE 97
/* Steps of a path, mm: as fine as a controller's. */
#define PATH_STEP 0.1
#define PATH_MAX  4096

const char *const bench_measure_name[BENCH_MEASURES] = {
    "speed", "latency", "triangles", "degree", "threads", "tolerance", "path"};

typedef struct bench {
    const bench_options *options;
    btg_tool tool;
    btg_solver_def solver;
    bench_rows *rows;
    bool wrong, shown;
    btg_message message;
} bench;

/* The work of one measurement. */
typedef struct work {
    const bench_subject *subject;
    const btg_tool *tool;
    const btg_solver_def *solver;
    void *workspace;
    size_t workspace_size;
    uint64_t nodes;
} work;

double bench_slice(const bench_options *options) {
    return options->seconds / SLICES;
}

int bench_runs(const bench_options *options) {
    return options->quick ? 3 : RUNS;
}

/* ---- rows ---------------------------------------------------------------------------------- */

static void show(bench *b, const bench_subject *s, bench_measure measure) {
    if (!b->shown) return;
    fprintf(stderr, "\rbench: %s, %s\033[K", bench_measure_name[measure], s->name);
    fflush(stderr);
}

static void complain(bench *b, const bench_row *row) {
    if (b->shown) fprintf(stderr, "\r\033[K");
    b->wrong = true;
    app_complain(APP_FAILED,
                 "bench: %s, %s of %s: wrong by %.3g mm, %.3g allowed; no figure, see 'tools/test'",
                 bench_measure_name[row->measure], row->operation, row->surface, row->max_error_mm,
                 row->limit_mm);
}

static bench_row row_of(const bench_subject *s, bench_measure measure, const char *operation,
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
                     .rate = {0, 0, NAN, NAN, NAN, NAN},
                     .latency_us = {NAN, NAN, NAN, NAN},
                     .latency_nodes = {NAN, NAN, NAN, NAN},
                     .nodes = NAN,
                     .ratio = NAN,
                     .build_triangles_per_second = NAN,
                     .bytes_per_triangle = NAN};
    snprintf(row.surface, sizeof row.surface, "%s", s->name);
    row.ok = error_mm <= row.limit_mm;
    return row;
}

static btg_status keep(bench *b, const bench_row *row) {
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

static btg_status work_begin(bench *b, const bench_subject *s, const btg_solver_def *solver,
                             work *w) {
    *w = (work){.subject = s, .tool = &b->tool, .solver = solver};
    w->workspace_size = btg_workspace_size(s->part);
    w->workspace = malloc(w->workspace_size);
    if (w->workspace) return BTG_OK;
    return btg_fail(&b->message, BTG_ERROR_MEMORY, "bench: out of memory");
}

static btg_status drop_at(work *w, const double *xy, btg_drop_query *query, btg_drop_result *drop) {
    *query = btg_position_drop_query(xy[0], xy[1]);
    return btg_drop(w->subject->part, w->tool, w->solver, query, w->workspace, w->workspace_size,
                    drop);
}

static btg_status do_drops(void *user, size_t count) {
    work *w = user;
    w->nodes = 0;
    for (size_t i = 0; i < count; i++) {
        btg_drop_query query;
        btg_drop_result drop;
        const double *xy = w->subject->feet + 2 * (i % w->subject->foot_count);
        btg_status status = drop_at(w, xy, &query, &drop);
        if (status < 0) return status;
        w->nodes += drop.nodes;
    }
    return BTG_OK;
}

static btg_status do_positions(void *user, size_t count) {
    work *w = user;
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
static btg_status halves(work *w, const double *xy, uint32_t nodes[2], double seconds[3]) {
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

static btg_status mean_nodes(work *w, double *drop, double *both) {
    double sum[2] = {0, 0};
    size_t n = w->subject->foot_count < 128 ? w->subject->foot_count : 128;
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

static btg_status check(bench *b, bench_subject *s, const btg_solver_def *solver) {
    if (s->checked_to_mm == solver->tolerance_mm) return BTG_OK;
    size_t n = b->options->quick || s->mesh.triangle_count > MANY_TRIANGLES ? CHECKED_FEW : CHECKED;
    s->checked_to_mm = solver->tolerance_mm;
    return bench_check(s, &b->tool, solver, n, &s->error, &b->message);
}

static btg_status timed(bench *b, bench_job job, void *user, bench_row *row) {
    if (!row->ok) return BTG_OK;
    btg_status status =
        bench_time(job, user, bench_slice(b->options), bench_runs(b->options), &row->rate);
    if (status < 0)
        btg_fail(&b->message, status, "bench: %s: no answer (%s)", row->surface,
                 btg_status_name(status));
    return status;
}

/* Two rows: drops, and whole positions. */
static btg_status drops_and_positions(bench *b, bench_subject *s, bench_measure measure,
                                      const btg_solver_def *solver, bool drops_only) {
    work w;
    show(b, s, measure);
    btg_status status = check(b, s, solver);
    if (status == BTG_OK) status = work_begin(b, s, solver, &w);
    if (status != BTG_OK) return status;
    bench_row drops = row_of(s, measure, "drop", solver, s->error.drop_mm);
    bench_row positions = row_of(s, measure, "position", solver, s->error.position_mm);
    btg_part_info info;
    btg_part_get_info(s->part, &info);
    if (measure == BENCH_TRIANGLES) {
        drops.build_triangles_per_second = (double)info.triangle_count / s->build_seconds;
        drops.bytes_per_triangle = (double)info.memory_bytes / (double)info.triangle_count;
    }
    status = timed(b, do_drops, &w, &drops);
    if (status >= 0 && !drops_only) status = timed(b, do_positions, &w, &positions);
    if (status >= 0) status = mean_nodes(&w, &drops.nodes, &positions.nodes);
    if (status >= 0) status = keep(b, &drops);
    if (status >= 0 && !drops_only) status = keep(b, &positions);
    free(w.workspace);
    return status < 0 ? status : BTG_OK;
}

/* ---- latency ------------------------------------------------------------------------------- */

typedef struct samples {
    size_t count;
    double *values[4]; /* us and nodes of drops, us and nodes of whole positions */
} samples;

static btg_status sample(bench *b, work *w, samples *all) {
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
        bench_row row = row_of(s, BENCH_LATENCY, operation[i], &b->solver, worst);
        if (row.ok) {
            double seconds = 0;
            for (size_t k = 0; k < all->count; k++)
                seconds += 1e-6 * all->values[2 * i][k];
            double rate = (double)all->count / seconds;
            row.rate = (bench_rate){1, all->count, seconds, rate, rate, rate};
            row.latency_positions = all->count;
            row.latency_us = bench_quantiles_of(all->values[2 * i], all->count);
            row.latency_nodes = bench_quantiles_of(all->values[2 * i + 1], all->count);
        }
        btg_status status = keep(b, &row);
        if (status < 0) return status;
    }
    return BTG_OK;
}

static btg_status latency(bench *b, bench_subject *s) {
    work w;
    samples all = {0};
    show(b, s, BENCH_LATENCY);
    btg_status status = check(b, s, &b->solver);
    if (status == BTG_OK) status = work_begin(b, s, &b->solver, &w);
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

/* ---- threads ------------------------------------------------------------------------------- */

typedef struct batch {
    btg_backend *backend;
    double *xy;
    btg_position *positions;
} batch;

static btg_status do_batch(void *user, size_t count) {
    batch *x = user;
    for (size_t done = 0; done < count; done += BATCH) {
        size_t n = count - done < BATCH ? count - done : BATCH;
        btg_status status = btg_backend_positions(x->backend, x->xy, n, x->positions, NULL);
        if (status < 0) return status;
    }
    return BTG_OK;
}

static btg_status open_threads(bench *b, const bench_subject *s, uint32_t threads, batch *x) {
    btg_backend_def def = btg_backend_def_default();
    def.name = "cpu";
    def.threads = threads;
    return btg_backend_open(&def, s->part, &b->tool, &b->solver, &x->backend, &b->message);
}

/* Whether the batch, cut into pieces of 1 to `most`, has the bits of `expected`. */
static btg_status same_bits(batch *x, size_t count, size_t most, const btg_position *expected,
                            bool *same) {
    for (size_t i = 0; i < count;) {
        size_t n = most < count ? 1 + i % most : count;
        if (n > count - i) n = count - i;
        btg_status status =
            btg_backend_positions(x->backend, x->xy + 2 * i, n, x->positions + i, NULL);
        if (status < 0) return status;
        i += n;
    }
    for (size_t i = 0; i < count; i++)
        *same = *same && bench_identical(&x->positions[i], &expected[i]);
    return BTG_OK;
}

/* One row: a number of threads. `expected`: the answers of one. */
static btg_status threads_row(bench *b, const bench_subject *s, uint32_t threads, double error_mm,
                              batch *x, btg_position *expected, double *one) {
    btg_status status = open_threads(b, s, threads, x);
    if (status != BTG_OK) return status;
    size_t count = b->options->quick ? BATCH / 16 : BATCH;
    if (threads == 1) status = btg_backend_positions(x->backend, x->xy, count, expected, NULL);
    bool same = true;
    if (status >= 0) status = same_bits(x, count, count, expected, &same);
    if (status >= 0) status = same_bits(x, count, PIECE, expected, &same);
    bench_row row = row_of(s, BENCH_THREADS, "position", &b->solver, same ? error_mm : INFINITY);
    row.threads = btg_backend_threads(x->backend);
    if (status >= 0) status = timed(b, do_batch, x, &row);
    if (threads == 1) *one = row.rate.median;
    row.ratio = row.rate.median / *one;
    btg_backend_close(x->backend);
    return status < 0 ? status : keep(b, &row);
}

static btg_status threads(bench *b, bench_subject *s) {
    show(b, s, BENCH_THREADS);
    btg_status status = check(b, s, &b->solver);
    if (status != BTG_OK) return status;
    batch x = {.xy = malloc(2 * BATCH * sizeof *x.xy),
               .positions = malloc(BATCH * sizeof *x.positions)};
    btg_position *expected = malloc(BATCH * sizeof *expected);
    if (!x.xy || !x.positions || !expected)
        status = btg_fail(&b->message, BTG_ERROR_MEMORY, "bench: out of memory");
    for (size_t i = 0; i < BATCH && status == BTG_OK; i++)
        memcpy(x.xy + 2 * i, s->feet + 2 * (i % s->foot_count), 2 * sizeof *x.xy);
    double one = NAN;
    for (uint32_t n = 1; n <= 2 && status == BTG_OK; n++)
        status = threads_row(b, s, n, s->error.position_mm, &x, expected, &one);
    free(x.xy);
    free(x.positions);
    free(expected);
    return status;
}

/* ---- paths --------------------------------------------------------------------------------- */

typedef struct walk {
    work work;
    size_t count; /* of steps, there and back again and again */
    bool follow;
    double x, y0, step; /* along y */
    btg_position last;
} walk;

static btg_status do_steps(void *user, size_t count) {
    walk *k = user;
    work *w = &k->work;
    btg_position here = {.status = BTG_NO_CONTACT};
    here.p.point = here.q.point = vec_nan();
    for (size_t i = 0; i < count; i++) {
        size_t j = i % (2 * k->count);
        double y = k->y0 + k->step * (double)(j < k->count ? j : 2 * k->count - j);
        btg_position last = here;
        btg_status status = btg_position_follow(w->subject->part, w->tool, w->solver, k->x, y,
                                                k->follow && i > 0 ? &last : NULL, w->workspace,
                                                w->workspace_size, &here);
        if (status < 0) return status;
    }
    k->last = here;
    return BTG_OK;
}

/* The greatest difference of both ways along the path. */
static btg_status path_error(walk *k, double *error_mm) {
    btg_position last, followed, cold;
    work *w = &k->work;
    for (size_t i = 0; i < k->count; i++) {
        double y = k->y0 + k->step * (double)i;
        btg_status status =
            btg_position_follow(w->subject->part, w->tool, w->solver, k->x, y, i > 0 ? &last : NULL,
                                w->workspace, w->workspace_size, &followed);
        if (status >= 0)
            status = btg_position_solve(w->subject->part, w->tool, w->solver, k->x, y, w->workspace,
                                        w->workspace_size, &cold);
        if (status < 0) return status;
        *error_mm = fmax(*error_mm, bench_difference(w->tool, w->solver, &followed, &cold));
        last = followed;
    }
    return BTG_OK;
}

static btg_status path(bench *b, bench_subject *s) {
    static const char *const operation[2] = {"position", "follow"};
    walk k = {0};
    btg_part_info info;
    show(b, s, BENCH_PATH);
    btg_status status = check(b, s, &b->solver);
    if (status == BTG_OK) status = work_begin(b, s, &b->solver, &k.work);
    if (status != BTG_OK) return status;
    btg_part_get_info(s->part, &info);
    double length = info.box_max.y - info.box_min.y;
    k.x = info.box_min.x + 0.4 * (info.box_max.x - info.box_min.x);
    k.y0 = info.box_min.y;
    k.count = length / PATH_STEP < PATH_MAX ? (size_t)(length / PATH_STEP) + 1 : PATH_MAX;
    k.step = length / (double)k.count;
    double error_mm = s->error.position_mm;
    status = path_error(&k, &error_mm);
    double cold = NAN;
    for (int i = 0; i < 2 && status >= 0; i++) {
        bench_row row = row_of(s, BENCH_PATH, operation[i], &b->solver, error_mm);
        row.limit_mm += b->solver.tolerance_mm; /* two answers, each as good as asked */
        row.ok = row.max_error_mm <= row.limit_mm;
        k.follow = i == 1;
        status = timed(b, do_steps, &k, &row);
        if (i == 0) cold = row.rate.median;
        row.ratio = row.rate.median / cold;
        if (status >= 0) status = keep(b, &row);
    }
    free(k.work.workspace);
    return status < 0 ? status : BTG_OK;
}

/* ---- the standard work --------------------------------------------------------------------- */

static btg_status tolerances(bench *b, bench_subject *s) {
    static const double mm[3] = {1e-3, 1e-6, 1e-9};
    btg_status status = BTG_OK;
    for (int i = 0; i < 3 && status == BTG_OK; i++) {
        btg_solver_def solver = b->solver;
        solver.tolerance_mm = mm[i];
        status = drops_and_positions(b, s, BENCH_TOLERANCE, &solver, false);
    }
    return status;
}

/* What fits any part. `all`: also what one part is enough for. */
static btg_status measure(bench *b, bench_subject *s, bool all) {
    const bool *wanted = b->options->measure;
    btg_status status = bench_subject_feet(s, &b->options->path, &b->tool, &b->message);
    if (wanted[BENCH_SPEED] && status == BTG_OK)
        status = drops_and_positions(b, s, BENCH_SPEED, &b->solver, false);
    if (wanted[BENCH_LATENCY] && status == BTG_OK) status = latency(b, s);
    if (wanted[BENCH_THREADS] && all && status == BTG_OK) status = threads(b, s);
    if (wanted[BENCH_TOLERANCE] && all && status == BTG_OK) status = tolerances(b, s);
    if (wanted[BENCH_PATH] && all && status == BTG_OK) status = path(b, s);
    return status;
}

static btg_status papers(bench *b) {
    static const int side[3] = {0, 100, 400};
    const bool *wanted = b->options->measure;
    bool single = wanted[BENCH_THREADS] || wanted[BENCH_TOLERANCE] || wanted[BENCH_PATH];
    if (!wanted[BENCH_SPEED] && !wanted[BENCH_LATENCY] && !single) return BTG_OK;
    for (int i = 0; i < 9; i++) {
        int surface = i % 3, squares = side[i / 3];
        /* In haste: the saddle, exact and as few triangles. */
        if (b->options->quick && (surface != 2 || squares > 100)) continue;
        bench_subject s;
        btg_status status = squares > 0 ? bench_subject_mesh(&s, surface, squares, &b->message)
                                        : bench_subject_paper(&s, surface, &b->message);
        if (status != BTG_OK) return status;
        status = measure(b, &s, surface == 2 && squares == 0);
        bench_subject_free(&s);
        if (status != BTG_OK) return status;
    }
    return BTG_OK;
}

static btg_status triangles(bench *b) {
    static const int side[4] = {71, 224, 708, 1000};
    for (int i = 0; i < (b->options->quick ? 2 : 4); i++) {
        bench_subject s;
        btg_status status = bench_subject_mesh(&s, 2, side[i], &b->message);
        if (status != BTG_OK) return status;
        status = bench_subject_feet(&s, &b->options->path, &b->tool, &b->message);
        if (status == BTG_OK)
            status = drops_and_positions(b, &s, BENCH_TRIANGLES, &b->solver, true);
        bench_subject_free(&s);
        if (status != BTG_OK) return status;
    }
    return BTG_OK;
}

static btg_status degrees(bench *b) {
    for (int degree = 2; degree <= BTG_DEGREE_MAX; degree++) {
        if (b->options->quick && degree != 2 && degree != BTG_DEGREE_MAX) continue;
        bench_subject s;
        btg_status status = bench_subject_degree(&s, degree, &b->message);
        if (status != BTG_OK) return status;
        status = bench_subject_feet(&s, &b->options->path, &b->tool, &b->message);
        if (status == BTG_OK) status = drops_and_positions(b, &s, BENCH_DEGREE, &b->solver, false);
        bench_subject_free(&s);
        if (status != BTG_OK) return status;
    }
    return BTG_OK;
}

static btg_status standard(bench *b) {
    btg_status status = papers(b);
    if (b->options->measure[BENCH_TRIANGLES] && status == BTG_OK) status = triangles(b);
    if (b->options->measure[BENCH_DEGREE] && status == BTG_OK) status = degrees(b);
    return status;
}

static btg_status files(bench *b) {
    const bench_options *o = b->options;
    for (int i = 0; i < o->part_count; i++) {
        bench_subject s;
        btg_status status = bench_subject_load(&s, o->parts[i], &o->path, &b->message);
        if (status != BTG_OK) return status;
        status = measure(b, &s, true);
        bench_subject_free(&s);
        if (status != BTG_OK) return status;
    }
    return BTG_OK;
}

int bench_speed(const bench_options *options, bench_rows *rows) {
    bench b = {.options = options, .rows = rows, .solver = options->path.solver};
    b.shown = !options->path.quiet && isatty(STDERR_FILENO);
    btg_status status = btg_tool_init(&options->path.tool, &b.tool, &b.message);
    if (status == BTG_OK) status = options->part_count > 0 ? files(&b) : standard(&b);
    if (b.shown) fprintf(stderr, "\r\033[K");
    if (status != BTG_OK) return app_complain(app_code(status), "%s", b.message.text);
    return b.wrong ? APP_FAILED : APP_DONE;
}
