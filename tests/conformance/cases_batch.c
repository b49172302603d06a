/* Batches: the same bits alone or among others, in any order, by any number of threads. */
#include "conformance.h"
#include "shapes.h"

static void make(fixture *f, rng *r, size_t count) {
    model_surface s = model_bezier(&f->model, 3, 3, false);
    for (int k = 0; k < 16; k++)
        shape_put(&s, k, vec(20 * (k / 4), 20 * (k % 4), rng_range(r, -8, 8)));
    fixture_part(f);
    while (f->count < count)
        fixture_foot(f, rng_range(r, 0, 60), rng_range(r, 0, 60), unknown);
}

static void none(fixture *f, rng *r, int round) {
    (void)round;
    make(f, r, 0);
}

static void odd(fixture *f, rng *r, int round) {
    make(f, r, round == 0 ? 1 : 67);
}

static void block(fixture *f, rng *r, int round) {
    (void)round;
    f->large = 10000;
    make(f, r, 257);
}

static const test_case cases[] = {
    {"batch-none-drop", BTG_OP_DROP, TOLERANCE_EXACT, CHECK_BATCH, 1, "no query at all", none},
    {"batch-none-tilt", BTG_OP_TILT, TOLERANCE_EXACT, CHECK_BATCH, 1, "no query at all", none},
    {"batch-odd-drop", BTG_OP_DROP, TOLERANCE_EXACT, CHECK_BATCH, 2, "1 and 67 queries", odd},
    {"batch-odd-tilt", BTG_OP_TILT, TOLERANCE_EXACT, CHECK_BATCH, 2, "1 and 67 queries", odd},
    {"batch-large-drop", BTG_OP_DROP, TOLERANCE_EXACT, CHECK_BATCH, 1,
     "10,000 queries, more than a block", block},
    {"batch-large-tilt", BTG_OP_TILT, TOLERANCE_EXACT, CHECK_BATCH, 1,
     "10,000 queries, more than a block", block},
};

const case_list cases_batch = {cases, sizeof cases / sizeof *cases};
