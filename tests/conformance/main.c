/* conformance [test|perf|support|list] [filters]: see usage(). */
#include "conformance.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

const char *data_directory = "tests/data";

static const case_list *const lists[] = {&cases_papers, &cases_plane,  &cases_round,
                                         &cases_edge,   &cases_random, &cases_batch};

typedef struct options {
    const char *mode, *backend, *op, *filter;
    uint64_t seed;
    int round;    /* -1: all */
    double share; /* of the rounds */
    bool all_ready;
} options;

typedef struct totals {
    size_t passed, failed, skipped;
} totals;

static int usage(void) {
    fprintf(stderr,
            "usage: conformance [test|perf|support|list] [--backend NAME,...] [--op drop|tilt]\n"
            "                   [--case PREFIX] [--round N] [--seed N] [--quick] [--data DIR]\n"
            "test     holds every back end that is ready to what is known (default)\n"
            "perf     the same on the papers' parts, with positions a second\n"
            "support  which back ends are there, and the tolerances\n"
            "list     the cases\n"
            "--quick, or BTG_TEST_QUICK=1: a fifth of the rounds\n"
            "exit code: 0 passed, 1 failed, 2 usage, 77 nothing ran\n");
    return 2;
}

static bool parse(int argc, char **argv, options *o) {
    const char *quick = getenv("BTG_TEST_QUICK");
    *o = (options){.mode = "test", .seed = 1, .round = -1, .share = 1};
    if (quick && *quick && *quick != '0') o->share = 0.2;
    for (int i = 1; i < argc; i++) {
        const char *a = argv[i], *value = i + 1 < argc ? argv[i + 1] : NULL;
        if (a[0] != '-') {
            o->mode = a;
            continue;
        }
        if (strcmp(a, "--quick") == 0) {
            o->share = 0.2;
            continue;
        }
        if (!value) return false;
        i++;
        if (strcmp(a, "--backend") == 0)
            o->backend = value;
        else if (strcmp(a, "--op") == 0)
            o->op = value;
        else if (strcmp(a, "--case") == 0)
            o->filter = value;
        else if (strcmp(a, "--round") == 0)
            o->round = atoi(value);
        else if (strcmp(a, "--seed") == 0)
            o->seed = strtoull(value, NULL, 0);
        else if (strcmp(a, "--data") == 0)
            data_directory = value;
        else
            return false;
    }
    return true;
}

static const char *op_name(btg_op op) {
    return op == BTG_OP_DROP ? "drop" : "tilt";
}

static bool wanted(const options *o, const test_case *t) {
    if (o->op && strcmp(o->op, op_name(t->op)) != 0) return false;
    return !o->filter || strncmp(t->name, o->filter, strlen(o->filter)) == 0;
}

/* ---- test --------------------------------------------------------------------------------- */

#define BACKENDS_MAX 16

typedef struct runner {
    const options *o;
    size_t backends;
    btg_backend_info info[BACKENDS_MAX];
    tally tally[BACKENDS_MAX];
    bool ran[BACKENDS_MAX];
} runner;

/* `name` is in the list that --backend gave; without one all are. */
static bool is_asked_for(const options *o, const char *name) {
    size_t length = strlen(name);
    if (!o->backend) return true;
    for (const char *at = o->backend; (at = strstr(at, name)); at += length)
        if ((at == o->backend || at[-1] == ',') && (at[length] == 0 || at[length] == ','))
            return true;
    return false;
}

static answer *answers_of(const fixture *f, const char *backend) {
    answer *a = calloc(f->count + 1, sizeof *a);
    if (a && fixture_run(f, backend, 0, a)) return a;
    free(a);
    return NULL;
}

static void run_backend(runner *run, size_t b, check_context *c, rng r) {
    c->backend = run->info[b].name;
    c->tally = &run->tally[b];
    answer *answers = answers_of(c->f, c->backend);
    run->ran[b] = true;
    if (!answers) {
        printf("  FAIL %s on %s: refused\n", c->test->name, c->backend);
        c->tally->failed++;
        return;
    }
    check_answers(c, answers);
    if (c->test->checks & CHECK_MOVED) check_moved(c, answers, &r);
    if (c->test->checks & CHECK_BATCH) check_batch(c, answers);
    free(answers);
}

/* The reference is not held to itself. */
static bool applies(const runner *run, const test_case *t, size_t b) {
    const btg_backend_info *info = &run->info[b];
    if (info->state != BTG_BACKEND_READY) return false;
    if (!is_asked_for(run->o, info->name)) return false;
    return t->checks != CHECK_REFERENCE || strcmp(info->name, "reference") != 0;
}

static void run_round(runner *run, const test_case *t, int round) {
    rng r = rng_of(run->o->seed, t->name, (uint64_t)round);
    fixture f;
    fixture_init(&f, t->op);
    t->make(&f, &r, round);
    check_context c = {.test = t, .f = &f, .seed = run->o->seed, .round = round};
    answer *reference = t->checks & CHECK_REFERENCE ? answers_of(&f, "reference") : NULL;
    cloud *samples = t->checks & (CHECK_CLEAR | CHECK_TIGHT) ? cloud_make(&f) : NULL;
    c.reference = reference;
    c.samples = samples;
    for (size_t b = 0; b < run->backends; b++)
        if (applies(run, t, b)) run_backend(run, b, &c, r);
    cloud_free(samples);
    free(reference);
    fixture_free(&f);
}

static void report(runner *run, const test_case *t, totals *sum) {
    for (size_t b = 0; b < run->backends; b++) {
        const btg_backend_info *info = &run->info[b];
        if (!is_asked_for(run->o, info->name)) continue;
        if (!run->ran[b]) { /* not ready, or the reference, which is not held to itself */
            sum->skipped++;
            continue;
        }
        const tally *n = &run->tally[b];
        *(n->failed ? &sum->failed : &sum->passed) += 1;
        printf("%s  %-10s %s: deep %.2g, shallow %.2g of the limit", n->failed ? "FAIL" : "ok  ",
               info->name, t->name, n->worst_deep, n->worst_shallow);
        if (n->cut_short) printf(", %zu cut short", n->cut_short);
        printf("\n");
    }
    fflush(stdout);
}

static void run_case(runner *run, const test_case *t, totals *sum) {
    memset(run->tally, 0, sizeof run->tally);
    memset(run->ran, 0, sizeof run->ran);
    int rounds = (int)ceil(t->rounds * run->o->share);
    bool any = false;
    for (size_t b = 0; b < run->backends; b++)
        any |= applies(run, t, b);
    for (int i = 0; any && i < rounds; i++)
        if (run->o->round < 0) run_round(run, t, i);
    if (any && run->o->round >= 0) run_round(run, t, run->o->round);
    report(run, t, sum);
}

static int test(const options *o) {
    runner run = {.o = o, .backends = btg_backend_count()};
    totals sum = {0};
    if (run.backends > BACKENDS_MAX) run.backends = BACKENDS_MAX;
    for (size_t b = 0; b < run.backends; b++)
        btg_backend_get_info(b, &run.info[b]);
    printf("seed %llu\n", (unsigned long long)o->seed);
    for (size_t b = 0; b < run.backends; b++)
        if (run.info[b].state != BTG_BACKEND_READY)
            printf("skip  %s: %s\n", run.info[b].name, btg_backend_state_name(run.info[b].state));
    for (size_t i = 0; i < sizeof lists / sizeof *lists; i++)
        for (size_t k = 0; k < lists[i]->count; k++)
            if (wanted(o, &lists[i]->cases[k])) run_case(&run, &lists[i]->cases[k], &sum);
    printf("%zu passed, %zu failed, %zu skipped\n", sum.passed, sum.failed, sum.skipped);
    return sum.failed ? 1 : sum.passed ? 0 : 77;
}

/* ---- the other modes ---------------------------------------------------------------------- */

static double now(void) {
    struct timespec t;
    timespec_get(&t, TIME_UTC);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int by_value(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Five times the whole batch; checked before it is timed. */
static bool perf_case(const options *o, const test_case *t, const char *backend) {
    enum { TIMES = 5 };
    double rate[TIMES];
    rng r = rng_of(o->seed, t->name, 0);
    fixture f;
    fixture_init(&f, t->op);
    t->make(&f, &r, 0);
    tally n = {0};
    check_context c = {.test = t, .f = &f, .backend = backend, .seed = o->seed, .tally = &n};
    answer *answers = calloc(f.count + 1, sizeof *answers);
    for (int i = 0; i < TIMES; i++) {
        double start = now();
        if (!fixture_run(&f, backend, 0, answers)) n.failed++;
        rate[i] = (double)f.count / (now() - start);
        if (i == 0) check_answers(&c, answers);
    }
    qsort(rate, TIMES, sizeof *rate, by_value);
    printf("%s  %-10s %-28s %12.0f /s least %12.0f /s median\n", n.failed ? "FAIL" : "ok  ",
           backend, t->name, rate[0], rate[TIMES / 2]);
    fflush(stdout);
    free(answers);
    fixture_free(&f);
    return n.failed == 0;
}

static int perf(const options *o) {
    totals sum = {0};
    for (size_t b = 0; b < btg_backend_count(); b++) {
        btg_backend_info info;
        btg_backend_get_info(b, &info);
        if (!is_asked_for(o, info.name)) continue;
        for (size_t k = 0; k < cases_papers.count; k++) {
            const test_case *t = &cases_papers.cases[k];
            if (!wanted(o, t)) continue;
            if (info.state != BTG_BACKEND_READY)
                sum.skipped++;
            else if (perf_case(o, t, info.name))
                sum.passed++;
            else
                sum.failed++;
        }
    }
    printf("%zu passed, %zu failed, %zu skipped\n", sum.passed, sum.failed, sum.skipped);
    return sum.failed ? 1 : 0;
}

static int support(void) {
    for (size_t b = 0; b < btg_backend_count(); b++) {
        btg_backend_info info;
        btg_backend_get_info(b, &info);
        printf("%-10s %-10s drop tilt  %s\n", info.name, btg_backend_state_name(info.state),
               info.device);
    }
    tolerance_print();
    return 0;
}

static int list(const options *o) {
    for (size_t i = 0; i < sizeof lists / sizeof *lists; i++)
        for (size_t k = 0; k < lists[i]->count; k++) {
            const test_case *t = &lists[i]->cases[k];
            if (wanted(o, t))
                printf("%-28s %s %-10s %s\n", t->name, op_name(t->op), tolerance_name(t->tolerance),
                       t->reason);
        }
    return 0;
}

int main(int argc, char **argv) {
    options o;
    if (!parse(argc, argv, &o)) return usage();
    if (strcmp(o.mode, "test") == 0) return test(&o);
    if (strcmp(o.mode, "perf") == 0) return perf(&o);
    if (strcmp(o.mode, "support") == 0) return support();
    if (strcmp(o.mode, "list") == 0) return list(&o);
    return usage();
}
