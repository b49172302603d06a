/* Many positions at once: by several threads, and along a path. */
#include "app/bench_measure.h"
#include "bitangent/backend.h"
#include "core/part.h"

#include <stdlib.h>
#include <string.h>

/* Positions of a batch for threads, and the uneven pieces it is cut into to see that they do not
 * show. */
#define BATCH 4096
#define PIECE 97
/* Runs of several threads are so much longer: they must be worth the threads' start. */
#define BATCH_SLICES 4
/* Steps of a path, mm: as fine as a controller's. */
#define PATH_STEP 0.1
#define PATH_MAX  4096

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
    bench_row row =
        bench_row_of(s, BENCH_THREADS, "position", &b->solver, same ? error_mm : INFINITY);
    row.threads = btg_backend_threads(x->backend);
    if (status >= 0) status = bench_row_time(b, do_batch, x, BATCH_SLICES, &row);
    if (threads == 1) *one = row.rate.median;
    row.ratio = row.rate.median / *one;
    btg_backend_close(x->backend);
    return status < 0 ? status : bench_row_keep(b, &row);
}

btg_status bench_measure_threads(bench *b, bench_subject *s) {
    bench_show(b, s, BENCH_THREADS);
    btg_status status = bench_check_once(b, s, &b->solver);
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
    bench_work work;
    size_t count; /* of steps, there and back again and again */
    bool follow;
    double x, y0, step; /* along y */
    btg_position last;
} walk;

static btg_status do_steps(void *user, size_t count) {
    walk *k = user;
    bench_work *w = &k->work;
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
    bench_work *w = &k->work;
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

static btg_status begin_walk(bench *b, bench_subject *s, const btg_solver_def *solver, walk *k) {
    btg_part_info info;
    *k = (walk){.follow = false};
    btg_status status = bench_work_begin(b, s, solver, &k->work);
    if (status != BTG_OK) return status;
    btg_part_get_info(s->part, &info);
    double length = info.box_max.y - info.box_min.y;
    k->x = info.box_min.x + 0.4 * (info.box_max.x - info.box_min.x);
    k->y0 = info.box_min.y;
    k->count = length / PATH_STEP < PATH_MAX ? (size_t)(length / PATH_STEP) + 1 : PATH_MAX;
    k->step = length / (double)k->count;
    return BTG_OK;
}

/* Two rows: each position alone, and from its neighbour. */
static btg_status keep_walk(bench *b, bench_subject *s, bench_measure measure,
                            const char *const operation[2], double error_mm, walk *k) {
    double cold = NAN;
    btg_status status = BTG_OK;
    for (int i = 0; i < 2 && status >= 0; i++) {
        bench_row row = bench_row_of(s, measure, operation[i], k->work.solver, error_mm);
        row.limit_mm += b->solver.tolerance_mm; /* two answers, each as good as asked */
        row.ok = row.max_error_mm <= row.limit_mm;
        k->follow = i == 1;
        status = bench_row_time(b, do_steps, k, 1, &row);
        if (i == 0) cold = row.rate.median;
        row.ratio = row.rate.median / cold;
        if (status >= 0) status = bench_row_keep(b, &row);
    }
    return status;
}

btg_status bench_measure_path(bench *b, bench_subject *s) {
    static const char *const operation[2] = {"position", "follow"};
    walk k;
    bench_show(b, s, BENCH_PATH);
    btg_status status = bench_check_once(b, s, &b->solver);
    if (status == BTG_OK) status = begin_walk(b, s, &b->solver, &k);
    if (status != BTG_OK) return status;
    double error_mm = s->error.position_mm;
    status = path_error(&k, &error_mm);
    if (status >= 0) status = keep_walk(b, s, BENCH_PATH, operation, error_mm, &k);
    free(k.work.workspace);
    return status < 0 ? status : BTG_OK;
}

/* ---- spins --------------------------------------------------------------------------------- */

#define SPINS_CHECKED 3
#define GAP_MM        4

/* The tilt of a spin that was found, against the reference's at that spin. */
static btg_status spin_error(bench *b, const walk *k, double *error_mm) {
    const bench_work *w = &k->work;
    for (size_t i = 0; i < SPINS_CHECKED; i++) {
        double xy[2] = {k->x, k->y0 + k->step * (double)((2 * i + 1) * k->count / 6)};
        btg_position found, other;
        btg_status status = btg_position_follow(w->subject->part, w->tool, w->solver, xy[0], xy[1],
                                                NULL, w->workspace, w->workspace_size, &found);
        if (status < 0) return status;
        btg_solver_def fixed = *w->solver;
        fixed.spin = BTG_SPIN_FIXED;
        fixed.spin_rad = found.spin_rad;
        btg_backend *backend = NULL;
        btg_backend_def def = btg_backend_def_default();
        def.name = "reference";
        status = btg_backend_open(&def, w->subject->part, w->tool, &fixed, &backend, &b->message);
        if (status != BTG_OK) return status;
        status = btg_backend_positions(backend, xy, 1, &other, NULL);
        btg_backend_close(backend);
        if (status < 0) return status;
        *error_mm = fmax(*error_mm, bench_difference(w->tool, w->solver, &found, &other));
    }
    return BTG_OK;
}

btg_status bench_measure_spin(bench *b, bench_subject *s) {
    static const struct {
        btg_spin spin;
        const char *operation[2];
    } policy[3] = {{BTG_SPIN_GAP, {"gap", "gap-follow"}},
                   {BTG_SPIN_ACROSS, {"across", "across-follow"}},
                   {BTG_SPIN_WIDEST, {"widest", "widest-follow"}}};
    bench_show(b, s, BENCH_SPIN);
    btg_status status = BTG_OK;
    for (int i = 0; i < 3 && status >= 0; i++) {
        btg_solver_def solver = b->solver;
        solver.spin = policy[i].spin;
        solver.gap_mm = GAP_MM;
        walk k;
        double error_mm = 0;
        status = begin_walk(b, s, &solver, &k);
        if (status != BTG_OK) return status;
        status = spin_error(b, &k, &error_mm);
        if (status >= 0) status = keep_walk(b, s, BENCH_SPIN, policy[i].operation, error_mm, &k);
        free(k.work.workspace);
    }
    if (status < 0 && !b->message.text[0])
        btg_fail(&b->message, status, "bench: %s: no answer (%s)", s->name,
                 btg_status_name(status));
    return status < 0 ? status : BTG_OK;
}
