/* `bitangent bench`: what its files share. cmd_bench.c reads the command line, bench_speed.c says
 * what is measured, bench_measure.c and bench_batch.c measure it, bench_time.c with the clock,
 * bench_work.c makes the parts, bench_check.c and bench_brute.c hold answers against independent
 * ones, bench_report.c writes all of it down. */
#ifndef BTG_APP_BENCH_H
#define BTG_APP_BENCH_H

#include "app/options.h"

#define BENCH_PARTS_MAX 16
#define BENCH_NAME_SIZE 64

typedef enum bench_measure {
    BENCH_SPEED,     /* drops and positions a second, one thread */
    BENCH_LATENCY,   /* of single drops and positions at random places */
    BENCH_TRIANGLES, /* drops a second and set-up against the number of triangles */
    BENCH_DEGREE,    /* against the degree of the surface */
    BENCH_THREADS,   /* against the number of threads */
    BENCH_TOLERANCE, /* against the tolerance asked */
    BENCH_PATH,      /* each position from its neighbour, against each from nothing */
    BENCH_SPIN,      /* the same where the spin is searched for */
    BENCH_BACKENDS,  /* all back ends on the same two batches: only where asked for */
    BENCH_MEASURES
} bench_measure;

extern const char *const bench_measure_name[BENCH_MEASURES];

typedef struct bench_options {
    path_options path; /* tool, solver, how glTF is read: options of `bitangent path` */
    const char *parts[BENCH_PARTS_MAX];
    int part_count; /* 0: the program's own standard work */
    bool measure[BENCH_MEASURES];
    bool chosen; /* by --only, --speed or --backends; else all but the back ends */
    bool quick;
    double seconds;       /* about how long all of it may take */
    const char *csv;      /* NULL: none */
    const char *png;      /* picture of the back ends; NULL: none */
    const char *commit;   /* a column of the CSV */
    bool papers;          /* the papers' tables instead (papers.h) */
    const char *pictures; /* folder of their charts; NULL: none */
} bench_options;

typedef struct bench_error {
    double drop_mm;     /* greatest error of a drop's height */
    double position_mm; /* and of a whole position */
} bench_error;

/* ---- what is worked on --------------------------------------------------------------------- */

/* Triangles as given to btg_part_create: for answers without the library. */
typedef struct bench_mesh {
    double *positions;
    uint32_t *indices;
    size_t vertex_count, triangle_count;
} bench_mesh;

typedef struct bench_subject {
    char name[BENCH_NAME_SIZE];
    btg_part *part;
    bench_mesh mesh; /* triangle_count 0: the part has surfaces */
    int degree;      /* 0: triangles, or mixed */
    double build_seconds;
    double *feet; /* x, y pairs, all of them over the part */
    size_t foot_count;
    bench_error error;    /* of the last check, */
    double checked_to_mm; /* at this tolerance; 0: not checked yet */
} bench_subject;

/* One of the papers' surfaces: 0 convex, 1 concave, 2 saddle. */
btg_status bench_subject_paper(bench_subject *subject, int surface, btg_message *message);
/* The same as side x side squares of two triangles each, corners on the surface. */
btg_status bench_subject_mesh(bench_subject *subject, int surface, int side, btg_message *message);
/* A Bezier patch of that degree in both directions, hills and hollows in its control points. */
btg_status bench_subject_degree(bench_subject *subject, int degree, btg_message *message);
btg_status bench_subject_load(bench_subject *subject, const char *file, const path_options *options,
                              btg_message *message);
/* Places for the tool, from a file of points or spread evenly; those without a contact are left
 * out. ERROR_ARGUMENT when none is left. */
btg_status bench_subject_feet(bench_subject *subject, const path_options *options,
                              const btg_tool *tool, btg_message *message);
void bench_subject_free(bench_subject *subject); /* a zeroed one is fine */

/* The i-th of a sequence that fills the rectangle evenly from any beginning to any end. */
void bench_spread(const btg_part_info *info, size_t i, double xy[2]);

/* ---- independent answers ------------------------------------------------------------------- */

/* The height of the torus centre along unit `axis` from `origin` at which the cutter rests on the
 * triangles, -INFINITY when it meets none; *contact: where (may be NULL). Looks at every triangle,
 * and knows neither the library's search nor its rays. */
double bench_brute_drop(const bench_mesh *mesh, const btg_tool *tool, btg_vec3 origin,
                        btg_vec3 axis, btg_vec3 *contact);
/* Error of a position's drop height, and greatest error of all of it: gouges, and a tilt that
 * ends too early as the clearance it leaves. */
bench_error bench_brute_error(const bench_mesh *mesh, const btg_tool *tool,
                              const btg_solver_def *solver, const btg_position *position);

/* Positions over the first places of the subject against other answers: triangles against
 * bench_brute_error, surfaces against the `reference` back end. */
btg_status bench_check(const bench_subject *subject, const btg_tool *tool,
                       const btg_solver_def *solver, size_t count, bench_error *error,
                       btg_message *message);
/* How far apart two positions over one place are, as clearance in mm. */
double bench_difference(const btg_tool *tool, const btg_solver_def *solver, const btg_position *a,
                        const btg_position *b);
/* Every number of both has the same bits. */
bool bench_identical(const btg_position *a, const btg_position *b);

/* ---- time ---------------------------------------------------------------------------------- */

/* Does `count` units of work; < 0 ends the measurement. */
typedef btg_status (*bench_job)(void *user, size_t count);

typedef struct bench_rate {
    int runs;
    size_t count;            /* units in a run */
    double seconds;          /* of the median run */
    double min, median, max; /* units a second */
    double processors;       /* that worked at it, of those it could use; less: others were busy */
} bench_rate;

/* Warms up, then `runs` runs of about `slice` seconds, all of the same work. */
btg_status bench_time(bench_job job, void *user, double slice, int runs, bench_rate *rate);

typedef struct bench_quantiles {
    double p50, p99, p999, max;
} bench_quantiles;

#define BENCH_RUNS_MAX 64
/* Sorts the seconds of runs, `count` units each; processors are not known. */
bench_rate bench_rate_of(double *seconds, int runs, size_t count);

/* Sorts the values. */
bench_quantiles bench_quantiles_of(double *values, size_t count);

/* ---- results ------------------------------------------------------------------------------- */

/* The greatest differences from the truth over a batch. */
typedef struct bench_deviation {
    double drop_mm, tilt_deg;
    double whole_mm; /* of all of a position, as clearance */
} bench_deviation;

/* What is told of a back end; NaN where it has no such. Seconds are of one run. */
typedef struct bench_device {
    double upload_s, device_s, readback_s, polish_s;
    double open_s;
    double host_bytes, device_bytes;
    bench_deviation raw, polished; /* raw: as a device finds it, in single precision */
} bench_device;

bench_device bench_device_none(void);

/* One result. Numbers that a measure does not have are NaN, counts 0, texts "". */
typedef struct bench_row {
    bench_measure measure;
    char surface[BENCH_NAME_SIZE];
    /* "drop", "position", "follow": a position from its neighbour, "many": a large batch of them;
     * "gap", "gap-follow" and so on: positions whose spin is searched for */
    const char *operation;
    const char *backend, *method;
    uint32_t threads;
    double tolerance_mm;
    int degree;
    size_t triangles;
    bench_rate rate;
    double max_error_mm, limit_mm;
    bool ok; /* false: the answer is wrong, and there are no figures */
    size_t latency_positions;
    bench_quantiles latency_us, latency_nodes;
    double nodes; /* mean of one operation */
    double ratio; /* to the row of the same surface that it stands against */
    double build_triangles_per_second, bytes_per_triangle;
    bench_device device;
} bench_row;

#define BENCH_LEFT_OUT_MAX 16

/* A back end that is not in the table. */
typedef struct bench_left_out {
    char backend[16], why[256];
} bench_left_out;

typedef struct bench_rows {
    bench_row *list;
    size_t count, capacity;
    bench_left_out left_out[BENCH_LEFT_OUT_MAX];
    size_t left_out_count;
} bench_rows;

#define BENCH_MACHINE_SIZE 128

/* "AMD EPYC, 2 cores"; the kind of processor where the system does not tell its name. */
void bench_name_machine(char *name, size_t size);

/* Fills `rows`, which the caller frees, complains about wrong answers on stderr. Returns an exit
 * code. */
int bench_speed(const bench_options *options, bench_rows *rows);

/* The length of a run, s, and how many there are. */
double bench_slice(const bench_options *options);
int bench_runs(const bench_options *options);

/* `csv` and `png` are open where there is one to write. Returns an exit code. */
int bench_report(const bench_options *options, const bench_rows *rows, btg_output *csv,
                 btg_output *png);

#endif
