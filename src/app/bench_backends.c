/* `bitangent bench --backends`: all of them on the same work. */
#include "app/app.h"
#include "app/bench_measure.h"
#include "app/feet.h"
#include "bitangent/backend.h"
#include "core/part.h"

#include <stdlib.h>
#include <string.h>

/* Positions of the large batch, for back ends that are quick enough; in haste. */
#define LARGE       100000
#define LARGE_QUICK 1000
/* Of the papers' batch, in haste: every so manieth. */
#define PAPER_STRIDE_QUICK 8
/* What the answers are compared with is solved to this. */
#define TRUTH_MM 1e-9
/* Part of the whole time for the large batches together. */
#define LARGE_SHARE 0.7
#define DEG         (180 / BTG_PI)

/* One list of places, and the truth over them. */
typedef struct places {
    double *xy;
    size_t count;
    btg_position *truth; /* NULL: answers are not compared */
} places;

typedef struct field {
    bench *b;
    bench_subject *subject;
    places paper, large;
    btg_position *positions; /* as many as the longer list has */
    size_t ready;            /* back ends */
} field;

/* ---- memory, as it is asked for ------------------------------------------------------------ */

#define HEADER 16 /* keeps what follows aligned */

static void *count_allocate(size_t size, void *user) {
    size_t *held = user, *block = malloc(size + HEADER);
    if (!block) return NULL;
    *block = size;
    *held += size;
    return (char *)block + HEADER;
}

static void count_release(void *memory, void *user) {
    size_t *held = user, *block = (size_t *)((char *)memory - HEADER);
    *held -= *block;
    free(block);
}

/* ---- places -------------------------------------------------------------------------------- */

static btg_status no_memory(bench *b) {
    return btg_fail(&b->message, BTG_ERROR_MEMORY, "bench: out of memory");
}

/* The footprint of `bitangent path`, without lifts. */
static btg_status paper_places(field *f, const btg_part *part) {
    bench *b = f->b;
    feet all;
    btg_status status = feet_open(&all, &b->options->path, part, &b->message);
    if (status != BTG_OK) return status;
    size_t stride = b->options->quick ? PAPER_STRIDE_QUICK : 1;
    f->paper.xy = malloc((all.total + 1) * 2 * sizeof *f->paper.xy);
    for (size_t i = 0; f->paper.xy && i < all.total; i += stride) {
        btg_footprint_point p = feet_at(&all, i);
        if (p.lift) continue;
        f->paper.xy[2 * f->paper.count] = p.x_mm;
        f->paper.xy[2 * f->paper.count++ + 1] = p.y_mm;
    }
    feet_close(&all);
    return f->paper.xy ? BTG_OK : no_memory(b);
}

static btg_status large_places(field *f, const btg_part_info *info) {
    f->large.count = f->b->options->quick ? LARGE_QUICK : LARGE;
    f->large.xy = malloc(f->large.count * 2 * sizeof *f->large.xy);
    if (!f->large.xy) return no_memory(f->b);
    for (size_t i = 0; i < f->large.count; i++)
        bench_spread(info, i, f->large.xy + 2 * i);
    return BTG_OK;
}

static btg_status solve(field *f, const char *name, double tolerance_mm, bool raw, const places *p,
                        btg_position *positions) {
    bench *b = f->b;
    btg_backend *backend = NULL;
    btg_backend_def def = btg_backend_def_default();
    btg_solver_def solver = b->solver;
    def.name = name;
    def.raw = raw;
    solver.tolerance_mm = tolerance_mm;
    btg_status status =
        btg_backend_open(&def, f->subject->part, &b->tool, &solver, &backend, &b->message);
    if (status != BTG_OK) return status;
    status = btg_backend_positions(backend, p->xy, p->count, positions, NULL);
    if (status < 0)
        btg_fail(&b->message, status, "bench: %s: no answer (%s)", name, btg_status_name(status));
    btg_backend_close(backend);
    return status;
}

/* The cpu's answers to a finer tolerance, themselves held against another method's first. */
static btg_status find_truth(field *f) {
    bench *b = f->b;
    btg_status status = bench_check_once(b, f->subject, &b->solver);
    if (status != BTG_OK) return status;
    f->paper.truth = malloc((f->paper.count + 1) * sizeof *f->paper.truth);
    if (!f->paper.truth) return no_memory(b);
    return solve(f, "cpu", TRUTH_MM, false, &f->paper, f->paper.truth);
}

static btg_status begin(field *f) {
    btg_part_info info;
    btg_part_get_info(f->subject->part, &info);
    btg_status status = paper_places(f, f->subject->part);
    if (status == BTG_OK) status = large_places(f, &info);
    if (status == BTG_OK) status = find_truth(f);
    size_t most = f->paper.count > f->large.count ? f->paper.count : f->large.count;
    if (status >= 0) f->positions = malloc((most + 1) * sizeof *f->positions);
    if (status >= 0 && !f->positions) return no_memory(f->b);
    return status;
}

/* ---- errors -------------------------------------------------------------------------------- */

static double greater(double a, double b) {
    return b <= a ? a : b; /* NaN stays */
}

static bench_deviation deviation(const field *f, const btg_position *positions) {
    const bench *b = f->b;
    bench_deviation d = {0, 0, 0};
    for (size_t i = 0; i < f->paper.count; i++) {
        const btg_position *a = &positions[i], *t = &f->paper.truth[i];
        d.whole_mm = greater(d.whole_mm, bench_difference(&b->tool, &b->solver, a, t));
        if (t->status == BTG_NO_CONTACT || a->status == BTG_NO_CONTACT) continue;
        d.drop_mm = greater(d.drop_mm, fabs(a->drop_z_mm - t->drop_z_mm));
        bool both = a->status != BTG_SINGLE_CONTACT && t->status != BTG_SINGLE_CONTACT;
        if (both) d.tilt_deg = greater(d.tilt_deg, DEG * fabs(a->tilt_rad - t->tilt_rad));
    }
    return d;
}

/* ---- one back end -------------------------------------------------------------------------- */

typedef struct lap {
    btg_backend *backend;
    const places *places;
    btg_position *positions;
} lap;

/* The whole list, `count` times. */
static btg_status run_list(void *user, size_t count) {
    lap *x = user;
    btg_status status = BTG_OK;
    for (size_t i = 0; i < count && status >= 0; i++)
        status =
            btg_backend_positions(x->backend, x->places->xy, x->places->count, x->positions, NULL);
    return status;
}

/* `share`: of the run that is told in all of them. */
static void split_times(const btg_backend *backend, const btg_backend_times *before, double share,
                        bench_device *d) {
    btg_backend_times now;
    btg_backend_get_times(backend, &now);
    d->device_bytes = now.device_bytes > 0 ? (double)now.device_bytes : NAN;
    if (!(now.device_s > 0)) return;
    d->upload_s = share * (now.upload_s - before->upload_s);
    d->device_s = share * (now.device_s - before->device_s);
    d->readback_s = share * (now.readback_s - before->readback_s);
    d->polish_s = share * (now.polish_s - before->polish_s);
}

/* One list, timed after a warm-up; the row is per list. */
static btg_status time_list(field *f, btg_backend *backend, const places *p, int runs,
                            bench_row *row) {
    lap x = {backend, p, f->positions};
    double seconds[BENCH_RUNS_MAX], all = 0;
    btg_backend_times before;
    btg_backend_get_times(backend, &before);
    for (int i = 0; i < runs; i++) {
        double start = app_seconds();
        btg_status status = run_list(&x, 1);
        seconds[i] = app_seconds() - start;
        all += seconds[i];
        if (status < 0) return status;
        /* The slow ones once. */
        if (all > f->b->options->seconds / 10) runs = i + 1;
    }
    row->rate = bench_rate_of(seconds, runs, p->count);
    split_times(backend, &before, row->rate.seconds / all, &row->device);
    return BTG_OK;
}

static size_t large_count(const field *f, double rate) {
    double fitting = rate * LARGE_SHARE * f->b->options->seconds / (double)f->ready;
    if (!(fitting < (double)f->large.count)) return f->large.count;
    return fitting < 1 ? 1 : (size_t)fitting;
}

static bench_row row_for(const field *f, const btg_backend *backend, const char *operation,
                         double error_mm) {
    const bench *b = f->b;
    bench_row row = bench_row_of(f->subject, BENCH_BACKENDS, operation, &b->solver, error_mm);
    row.threads = btg_backend_threads(backend);
    row.backend = btg_backend_name(backend);
    return row;
}

/* Two rows: the papers' batch with its errors, the large one. */
static btg_status both_lists(field *f, btg_backend *backend, bench_device device) {
    bench *b = f->b;
    lap warm = {backend, &f->paper, f->positions};
    btg_status status = run_list(&warm, 1);
    if (status < 0) return status;
    device.polished = deviation(f, f->positions);
    /* And of the truth itself. */
    double error_mm = greater(device.polished.whole_mm, f->subject->error.position_mm);
    bench_row row = row_for(f, backend, "position", error_mm);
    row.limit_mm += TRUTH_MM;
    row.ok = row.max_error_mm <= row.limit_mm;
    row.device = device;
    status = row.ok ? time_list(f, backend, &f->paper, bench_runs(b->options), &row) : BTG_OK;
    if (status >= 0) status = bench_row_keep(b, &row);
    if (status < 0 || !row.ok) return status;
    places large = f->large;
    large.count = large_count(f, row.rate.median);
    bench_row many = row_for(f, backend, "many", row.max_error_mm);
    many.limit_mm = row.limit_mm;
    many.ok = true;
    many.device = bench_device_none();
    status = time_list(f, backend, &large, 1, &many);
    return status < 0 ? status : bench_row_keep(b, &many);
}

static bool is_device(const char *name) {
    return strcmp(name, "cpu") != 0 && strcmp(name, "reference") != 0;
}

static btg_status one(field *f, const char *name) {
    bench *b = f->b;
    bench_device device = bench_device_none();
    if (is_device(name)) {
        btg_status status = solve(f, name, b->solver.tolerance_mm, true, &f->paper, f->positions);
        if (status < 0) return status;
        device.raw = deviation(f, f->positions);
    }
    size_t held = 0;
    btg_backend *backend = NULL;
    btg_backend_def def = btg_backend_def_default();
    def.name = name;
    def.allocator = (btg_allocator){count_allocate, count_release, &held};
    double start = app_seconds();
    btg_status status =
        btg_backend_open(&def, f->subject->part, &b->tool, &b->solver, &backend, &b->message);
    if (status != BTG_OK) return status;
    device.open_s = app_seconds() - start;
    device.host_bytes = (double)held;
    status = both_lists(f, backend, device);
    if (status < 0)
        btg_fail(&b->message, status, "bench: %s: no answer (%s)", name, btg_status_name(status));
    btg_backend_close(backend);
    return status;
}

/* ---- all ----------------------------------------------------------------------------------- */

static void leave_out(bench *b, const char *name, const char *why) {
    bench_rows *r = b->rows;
    if (r->left_out_count == BENCH_LEFT_OUT_MAX) return;
    bench_left_out *l = &r->left_out[r->left_out_count++];
    snprintf(l->backend, sizeof l->backend, "%s", name);
    snprintf(l->why, sizeof l->why, "%.*s", (int)sizeof l->why - 1, why);
}

btg_status bench_measure_backends(bench *b, bench_subject *s) {
    field f = {.b = b, .subject = s};
    btg_backend_info info[BENCH_LEFT_OUT_MAX];
    size_t count =
        btg_backend_count() < BENCH_LEFT_OUT_MAX ? btg_backend_count() : BENCH_LEFT_OUT_MAX;
    bench_show(b, s, BENCH_BACKENDS);
    b->rows->left_out_count = 0;
    for (size_t i = 0; i < count; i++) {
        btg_backend_get_info(i, &info[i]);
        if (info[i].state == BTG_BACKEND_READY)
            f.ready++;
        else if (info[i].state == BTG_BACKEND_NO_DEVICE)
            leave_out(b, info[i].name, info[i].device);
        else
            leave_out(b, info[i].name, "not built into this version");
    }
    btg_status status = begin(&f);
    for (size_t i = 0; i < count && status >= 0; i++) {
        if (info[i].state != BTG_BACKEND_READY) continue;
        status = one(&f, info[i].name);
        if (status >= 0 || status == BTG_ERROR_MEMORY) continue;
        /* One that cannot do this work says so, and the others go on. */
        leave_out(b, info[i].name, b->message.text);
        status = BTG_OK;
    }
    free(f.paper.xy);
    free(f.paper.truth);
    free(f.large.xy);
    free(f.positions);
    return status < 0 ? status : BTG_OK;
}
