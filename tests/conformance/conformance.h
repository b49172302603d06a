/* One harness over all back ends and the two ops: DROP and TILT.
 *
 * A case makes fixtures: a part, a tool, queries, and what is known about the answers. It never
 * knows which back end answers. The harness runs every back end that is ready on it and checks.
 *
 * Errors are signed. Too deep: the tool stands lower, or is tilted further, than the part allows
 * (it gouges). Too shallow: it leaves material it need not. */
#ifndef BTG_TESTS_CONFORMANCE_H
#define BTG_TESTS_CONFORMANCE_H

#include "bitangent/backend.h"
#include "core/ray.h"
#include "model.h"
#include "rng.h"

/* ---- tolerances (tolerance.c) ------------------------------------------------------------- */

typedef enum tolerance_class {
    TOLERANCE_EXACT,
    TOLERANCE_F64,
    TOLERANCE_F32,
    TOLERANCE_RASTER,
    TOLERANCE_OSCULATING,
    TOLERANCE_COUNT
} tolerance_class;

typedef struct limits {
    double deep, shallow; /* mm for DROP, radians for TILT */
} limits;

typedef struct fixture fixture;

/* Limits of a value. `lever`: mm of clearance one unit of it makes at the contact. */
limits tolerance_limits(tolerance_class tolerance, const fixture *f, double lever);
/* The clearance behind them, mm. */
double tolerance_clearance(tolerance_class tolerance, const fixture *f);
const char *tolerance_name(tolerance_class tolerance);
void tolerance_print(void);

/* ---- fixtures (fixture.c) ----------------------------------------------------------------- */

/* An answer of either op. */
typedef struct answer {
    btg_status status;
    double value; /* height or tilt */
    btg_contact contact;
    uint32_t element;
} answer;

/* What is known beforehand. */
typedef struct want {
    bool known;
    btg_status status;
    double value;
    double lever;
    bool at_most; /* the value is an upper bound of the tilt */
} want;

struct fixture {
    model model;
    btg_part *part;
    btg_tool tool;
    btg_solver_def solver;
    btg_op op;
    size_t count, capacity;
    btg_drop_query *drops;
    btg_tilt_query *tilts;
    want *wants;
    size_t large; /* > 0: the batch check also runs the queries over and over, that many */
    btg_backend *reference; /* drops that TILT queries start from */
};

/* Default solver, no part yet. */
void fixture_init(fixture *f, btg_op op);
void fixture_free(fixture *f);
void fixture_tool(fixture *f, double major, double minor, btg_profile profile);
void fixture_cylinder(fixture *f, double radius, double from, double to); /* shank, then holder */
/* Makes the part; the model is complete. */
void fixture_part(fixture *f);
void fixture_drop(fixture *f, btg_drop_query query, want w);
/* Over a footprint point. DROP: that query. TILT: the query after the drop there, which the
 * reference answers; left out when that first contact leaves no tilt. */
void fixture_foot(fixture *f, double x, double y, want w);

static const want unknown = {0};
/* A status of BTG_OK stands for BTG_OSCULATING too. */
want known(double value);
want known_status(btg_status status);

/* Answers of a back end by name; false: it refused (message printed). */
bool fixture_run(const fixture *f, const char *backend, uint32_t threads, answer *answers);
/* The placed tool at a value of query i. */
btg_placement fixture_place(const fixture *f, size_t i, double value);
double fixture_size(const fixture *f);  /* of the cutter, mm */
double fixture_scale(const fixture *f); /* largest coordinate, mm */

/* ---- clearance (clearance.c), independent of rays and search ------------------------------- */

typedef struct cloud cloud;
cloud *cloud_make(const fixture *f);
void cloud_free(cloud *c);
/* The least signed distance of the part to the placed tool, by dense samples, each of the least
 * ones followed to its own minimum. */
double cloud_clearance(const cloud *c, const fixture *f, btg_placement tool,
                       const btg_vec3 *hint); /* a point of the part to try, or NULL */
/* Signed distance of a point, straight from the definition of the tool. */
double tool_clearance(const btg_tool *tool, btg_placement placement, btg_vec3 s);

/* ---- cases -------------------------------------------------------------------------------- */

typedef enum check {
    CHECK_VALUE = 1,     /* the wants of the case */
    CHECK_REFERENCE = 2, /* the value of the reference back end */
    CHECK_CLEAR = 4,     /* no part point deeper in the placed tool */
    CHECK_TOUCH = 8,     /* the contact is a point of the part and touches, tangent */
    CHECK_TIGHT = 16,    /* a little further the tool cuts the part */
    CHECK_MOVED = 32,    /* rigid motion, mirror and scale carry through */
    CHECK_BATCH = 64,    /* the same bits alone, in any order, by any number of threads */
    CHECK_RANDOM = 62    /* all that needs no answer beforehand, but for batches */
} check;

typedef struct test_case {
    const char *name;
    btg_op op;
    tolerance_class tolerance;
    unsigned checks;
    int rounds;
    const char *reason;
    void (*make)(fixture *f, rng *r, int round);
} test_case;

typedef struct case_list {
    const test_case *cases;
    size_t count;
} case_list;

extern const case_list cases_papers, cases_plane, cases_round, cases_edge, cases_random,
    cases_batch;

/* Where the data files are: argument --data. */
extern const char *data_directory;

/* ---- checks (check.c) --------------------------------------------------------------------- */

/* Counts for one case and back end. */
typedef struct tally {
    size_t failed;                    /* checks */
    size_t cut_short;                 /* answers with BTG_BUDGET: safe, not closest */
    double worst_deep, worst_shallow; /* as parts of the limit */
} tally;

typedef struct check_context {
    const test_case *test;
    const fixture *f;
    const char *backend;
    uint64_t seed;
    int round;
    const answer *reference; /* NULL: not asked for */
    const cloud *samples;
    tally *tally;
} check_context;

void check_answers(const check_context *c, const answer *answers);
void check_moved(const check_context *c, const answer *answers, rng *r);
void check_batch(const check_context *c, const answer *answers);

#endif
