/* Repeated runs of one piece of work, and what a list of times says. */
#define _GNU_SOURCE
#include "app/app.h"
#include "app/bench.h"

#include <math.h>
#include <stdlib.h>
#include <time.h>

#define RUNS_MAX 64
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

btg_status bench_time(bench_job job, void *user, double slice, int runs, bench_rate *rate) {
    double seconds[RUNS_MAX];
    bench_rate r = {.runs = runs < RUNS_MAX ? runs : RUNS_MAX};
    btg_status status = warm_up(job, user, slice, &r.count);
    double worked = processor_seconds(), all = 0;
    for (int i = 0; i < r.runs && status >= 0; i++) {
        double begin = app_seconds();
        status = job(user, r.count);
        seconds[i] = app_seconds() - begin;
        all += seconds[i];
    }
    if (status < 0) return status;
    r.processors = (processor_seconds() - worked) / all;
    qsort(seconds, (size_t)r.runs, sizeof *seconds, ascending);
    r.seconds = seconds[r.runs / 2];
    r.min = (double)r.count / seconds[r.runs - 1];
    r.median = (double)r.count / r.seconds;
    r.max = (double)r.count / seconds[0];
    *rate = r;
    return BTG_OK;
}

bench_quantiles bench_quantiles_of(double *values, size_t count) {
    if (count == 0) return (bench_quantiles){NAN, NAN, NAN, NAN};
    qsort(values, count, sizeof *values, ascending);
    double last = (double)(count - 1);
    return (bench_quantiles){values[(size_t)(0.5 * last)], values[(size_t)ceil(0.99 * last)],
                             values[(size_t)ceil(0.999 * last)], values[count - 1]};
}
