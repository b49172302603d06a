/* How the measures of bench_speed.c are taken. Internal to `bitangent bench`. */
#ifndef BTG_APP_BENCH_MEASURE_H
#define BTG_APP_BENCH_MEASURE_H

#include "app/bench.h"

typedef struct bench {
    const bench_options *options;
    btg_tool tool;
    btg_solver_def solver;
    bench_rows *rows;
    bool wrong; /* an answer was */
    bool shown; /* someone watches stderr */
    btg_message message;
} bench;

/* The work of one measurement: places of the subject, again and again. */
typedef struct bench_work {
    const bench_subject *subject;
    const btg_tool *tool;
    const btg_solver_def *solver;
    void *workspace; /* the caller frees it */
    size_t workspace_size;
} bench_work;

/* Errors are in bench->message; an answer that is wrong is none, but a row that says so. */

/* Two rows, drops and whole positions, or one. */
btg_status bench_measure_rates(bench *b, bench_subject *s, bench_measure measure,
                               const btg_solver_def *solver, bool drops_only);
btg_status bench_measure_latency(bench *b, bench_subject *s);
btg_status bench_measure_threads(bench *b, bench_subject *s);
btg_status bench_measure_path(bench *b, bench_subject *s);
btg_status bench_measure_spin(bench *b, bench_subject *s);
/* Two rows a back end that is ready; the others, and why, are in rows->left_out. */
btg_status bench_measure_backends(bench *b, bench_subject *s);

/* ---- for the measures ---------------------------------------------------------------------- */

/* Says what goes on, where someone watches. */
void bench_show(bench *b, const bench_subject *s, bench_measure measure);
btg_status bench_check_once(bench *b, bench_subject *s, const btg_solver_def *solver);
/* Without figures; `ok` when the error is within the tolerance. */
bench_row bench_row_of(const bench_subject *s, bench_measure measure, const char *operation,
                       const btg_solver_def *solver, double error_mm);
btg_status bench_row_keep(bench *b, const bench_row *row);
btg_status bench_work_begin(bench *b, const bench_subject *s, const btg_solver_def *solver,
                            bench_work *work);
/* Fills row->rate from runs of so many usual lengths, unless the row is wrong. */
btg_status bench_row_time(bench *b, bench_job job, void *user, double slices, bench_row *row);

#endif
