/* `bitangent bench --papers`: the papers' tables and figures made again on this machine. What its
 * files share: papers.c runs all, papers_vcrf.c, papers_gpu.c, papers_dst.c and papers_spin.c make
 * the tables of the circular-rays paper, of the GPU paper, of the drop-spin-tilt paper, and those
 * beyond them; papers_report.c writes all of it down. */
#ifndef BTG_APP_PAPERS_H
#define BTG_APP_PAPERS_H

#include "app/bench.h"
#include "io/chart.h"
#include "methods/method.h"

#define PAPERS_SURFACES 3 /* convex, concave, saddle: bench_subject_paper */
extern const char *const papers_surface[PAPERS_SURFACES];

/* One figure. NaN: there is none. */
typedef struct papers_row {
    const char *table; /* static storage: rows of one table follow each other */
    char item[64], quantity[64];
    const char *unit;
    double value, paper;
    double exact[2]; /* the same of both methods compared, each against the exact solver */
} papers_row;

/* Why a table differs from the paper's, or what is to be known about it. */
typedef struct papers_note {
    const char *table;
    char text[400];
} papers_note;

typedef struct papers {
    const bench_options *options;
    btg_tool tool;
    btg_solver_def solver;
    btg_part *part[PAPERS_SURFACES];
    papers_row *rows;
    size_t row_count, row_capacity;
    papers_note *notes;
    size_t note_count, note_capacity;
    bool quick;
    bool shown; /* someone watches stderr */
    bool short_of_memory;
    double seconds; /* all of it */
    btg_message message;
} papers;

/* ---- for the tables ----------------------------------------------------------------------- */

papers_row *papers_add(papers *p, const char *table, const char *unit, double value, double paper);
void papers_name(papers_row *row, const char *item, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 3, 4)))
#endif
    ;
void papers_note_add(papers *p, const char *table, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 3, 4)))
#endif
    ;
/* Says what goes on, where someone watches. */
void papers_show(const papers *p, const char *what);
/* Writes a chart as PNG and as SVG into the folder of --pictures, where one is given. */
btg_status papers_chart(papers *p, const char *name, const char *title,
                        const btg_chart_panel *panels, size_t count, size_t columns);

/* Points of the papers' footprint, 10 passes of 76, every `stride`-th; the caller frees them. */
double *papers_footprint(size_t stride, size_t *count);

/* Positions by a method on one thread. `counts` may be NULL. ERROR_ and a message in p. */
btg_status papers_solve(papers *p, int surface, const btg_method_def *def,
                        const btg_solver_def *solver, const double *xy, size_t count,
                        btg_position *out, double *seconds, btg_method_counts *counts);
btg_method_def papers_method(const char *name);

/* The contacts' distance; NaN without a second one. */
double papers_gap(const btg_position *position);

btg_status papers_vcrf(papers *p); /* tables 2 to 5, figure 10 */
btg_status papers_gpu(papers *p);  /* table 1, figures 6, 8, 9 */
btg_status papers_raw(papers *p);  /* osmesa's depth images before the polish; it must be ready */
btg_status papers_dst(papers *p);  /* seeds, iterations, spread of second contacts */
btg_status papers_spin(papers *p); /* spin policies: strip, scallop, passes */

/* Text, CSV, JSON. Returns an exit code. */
int papers_report(const papers *p, btg_output *csv);

/* All of it. Returns an exit code. */
int papers_run(const bench_options *options, btg_output *csv);

#endif
