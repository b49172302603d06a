/* Repeated runs of one piece of work, and what a list of times says. */
#define _GNU_SOURCE
#include "app/app.h"
#include "app/bench.h"

#include <math.h>
#include <stdlib.h>
#include <time.h>

/* Units in a run that are fewer are not doubled past this. */
#define COUNT_MAX ((size_t)1 << 40)

static double processor_seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Warms caches, branch predictors and clock rates up, and finds how many units fill a run. */
static btg_status warm_up(bench_job job, void *user, double slice, size_t *count) {
    btg_status status;
    for (size_t n = 1;; n *= 2) {
        double begin = app_seconds();
        status = job(user, n);
        double seconds = app_seconds() - begin;
        if (status < 0) return status;
        if (seconds < slice / 4 && n < COUNT_MAX) continue;
        double fitting = (double)n * slice / fmax(seconds, 1e-9);
        *count = fitting < 1 ? 1 : (size_t)fitting;
        return BTG_OK;
    }
}

bench_rate bench_rate_of(double *seconds, int runs, size_t count) {
    qsort(seconds, (size_t)runs, sizeof *seconds, ascending);
    bench_rate r = {.runs = runs, .count = count, .processors = NAN};
    r.seconds = seconds[runs / 2];
    r.min = (double)count / seconds[runs - 1];
    r.median = (double)count / r.seconds;
    r.max = (double)count / seconds[0];
    return r;
}

btg_status bench_time(bench_job job, void *user, double slice, int runs, bench_rate *rate) {
    double seconds[BENCH_RUNS_MAX];
    size_t units = 0;
    if (runs > BENCH_RUNS_MAX) runs = BENCH_RUNS_MAX;
    btg_status status = warm_up(job, user, slice, &units);
    double worked = processor_seconds(), all = 0;
    for (int i = 0; i < runs && status >= 0; i++) {
        double begin = app_seconds();
        status = job(user, units);
        seconds[i] = app_seconds() - begin;
        all += seconds[i];
    }
    if (status < 0) return status;
    *rate = bench_rate_of(seconds, runs, units);
    rate->processors = (processor_seconds() - worked) / all;
    return BTG_OK;
}

bench_quantiles bench_quantiles_of(double *values, size_t count) {
    if (count == 0) return (bench_quantiles){NAN, NAN, NAN, NAN};
    qsort(values, count, sizeof *values, ascending);
    double last = (double)(count - 1);
    return (bench_quantiles){values[(size_t)(0.5 * last)], values[(size_t)ceil(0.99 * last)],
                             values[(size_t)ceil(0.999 * last)], values[count - 1]};
}
