/* What `bitangent bench --speed` measures. Every piece of work is checked first; one that answers
 * wrongly gets no figure. */
#define _GNU_SOURCE
#include "app/app.h"
#include "app/bench_measure.h"
#include "core/part.h"

#include <unistd.h>

const char *const bench_measure_name[BENCH_MEASURES] = {
    "speed", "latency", "triangles", "degree", "threads", "tolerance", "path", "spin", "backends"};

/* ---- the standard work --------------------------------------------------------------------- */

static btg_status tolerances(bench *b, bench_subject *s) {
    static const double mm[3] = {1e-3, 1e-6, 1e-9};
    btg_status status = BTG_OK;
    for (int i = 0; i < 3 && status == BTG_OK; i++) {
        btg_solver_def solver = b->solver;
        solver.tolerance_mm = mm[i];
        status = bench_measure_rates(b, s, BENCH_TOLERANCE, &solver, false);
    }
    return status;
}

/* What fits any part. `all`: also what one part is enough for. */
static btg_status measure_all(bench *b, bench_subject *s, bool all) {
    const bool *wanted = b->options->measure;
    btg_status status = bench_subject_feet(s, &b->options->path, &b->tool, &b->message);
    if (wanted[BENCH_SPEED] && status == BTG_OK)
        status = bench_measure_rates(b, s, BENCH_SPEED, &b->solver, false);
    if (wanted[BENCH_LATENCY] && status == BTG_OK) status = bench_measure_latency(b, s);
    if (wanted[BENCH_THREADS] && all && status == BTG_OK) status = bench_measure_threads(b, s);
    if (wanted[BENCH_TOLERANCE] && all && status == BTG_OK) status = tolerances(b, s);
    if (wanted[BENCH_PATH] && all && status == BTG_OK) status = bench_measure_path(b, s);
    if (wanted[BENCH_SPIN] && all && status == BTG_OK) status = bench_measure_spin(b, s);
    if (wanted[BENCH_BACKENDS] && all && status == BTG_OK) status = bench_measure_backends(b, s);
    return status;
}

static btg_status papers(bench *b) {
    static const int side[3] = {0, 100, 400};
    const bool *wanted = b->options->measure;
    bool single = wanted[BENCH_THREADS] || wanted[BENCH_TOLERANCE] || wanted[BENCH_PATH] ||
                  wanted[BENCH_SPIN];
    if (!wanted[BENCH_SPEED] && !wanted[BENCH_LATENCY] && !single) return BTG_OK;
    for (int i = 0; i < 9; i++) {
        int surface = i % 3, squares = side[i / 3];
        /* In haste: the saddle, exact and as few triangles. */
        if (b->options->quick && (surface != 2 || squares > 100)) continue;
        bench_subject s;
        btg_status status = squares > 0 ? bench_subject_mesh(&s, surface, squares, &b->message)
                                        : bench_subject_paper(&s, surface, &b->message);
        if (status != BTG_OK) return status;
        status = measure_all(b, &s, surface == 2 && squares == 0);
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
            status = bench_measure_rates(b, &s, BENCH_TRIANGLES, &b->solver, true);
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
        if (status == BTG_OK) status = bench_measure_rates(b, &s, BENCH_DEGREE, &b->solver, false);
        bench_subject_free(&s);
        if (status != BTG_OK) return status;
    }
    return BTG_OK;
}

/* On the surface that the papers' own times are of. */
static btg_status backends(bench *b) {
    bench_subject s;
    btg_status status = bench_subject_paper(&s, 1, &b->message);
    if (status != BTG_OK) return status;
    status = bench_subject_feet(&s, &b->options->path, &b->tool, &b->message);
    if (status == BTG_OK) status = bench_measure_backends(b, &s);
    bench_subject_free(&s);
    return status;
}

static btg_status standard(bench *b) {
    btg_status status = papers(b);
    if (b->options->measure[BENCH_BACKENDS] && status == BTG_OK) status = backends(b);
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
        status = measure_all(b, &s, true);
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
