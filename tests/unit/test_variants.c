/* All builds of the run phase give the same bits: for any processor, in plain C, and for AVX2 and
 * AVX-512 where they were built and are there. */
#include "check.h"
#include "core/part.h"
#include "core/run.h"
#include "hard_parts.h"

#include <stdlib.h>
#include <string.h>

#define ROUNDS 240
#define PLACES 6

extern const btg_run btg_run_plain; /* of this test alone (meson.build) */

static long answers, with_contact;

/* One field of two results: bits, so that NaN equals NaN and 0 is not -0. */
#define SAME(field) same(&one.field, &two.field, sizeof one.field, #field, name)

static void same(const void *one, const void *two, size_t size, const char *field,
                 const char *name) {
    if (memcmp(one, two, size) == 0) return;
    double a, b;
    memcpy(&a, one, sizeof a < size ? sizeof a : size);
    memcpy(&b, two, sizeof b < size ? sizeof b : size);
    if (check_failures < 20 && size == sizeof a)
        fprintf(stderr, "%s is %a, baseline %a\n", field, b, a);
    else if (check_failures < 20)
        fprintf(stderr, "%s differs\n", field);
    check_that(0, name, 0, field);
}

static void same_contact(btg_contact one, btg_contact two, const char *name) {
    SAME(place.item);
    SAME(place.u);
    SAME(place.v);
    SAME(point);
    SAME(normal);
}

static void same_drop(btg_drop_result one, btg_drop_result two, const char *name) {
    SAME(status);
    SAME(height_mm);
    SAME(bound_mm);
    SAME(element);
    SAME(nodes);
    same_contact(one.contact, two.contact, name);
}

static void same_tilt(btg_tilt_result one, btg_tilt_result two, const char *name) {
    SAME(status);
    SAME(tilt_rad);
    SAME(bound_mm);
    SAME(element);
    SAME(nodes);
    same_contact(one.contact, two.contact, name);
}

typedef struct setting {
    const btg_part *part;
    btg_tool tool;
    btg_solver_def solver;
    void *workspace;
    const btg_run *other[3];
    int other_count;
} setting;

static btg_status drop(const setting *s, const btg_run *run, const btg_drop_query *query,
                       btg_drop_result *result) {
    memset(result, 0, sizeof *result);
    return run->drop(s->part, &s->tool, &s->solver, query, s->workspace, result);
}

static btg_status tilt(const setting *s, const btg_run *run, const btg_tilt_query *query,
                       btg_tilt_result *result) {
    memset(result, 0, sizeof *result);
    return run->tilt(s->part, &s->tool, &s->solver, query, s->workspace, result);
}

static btg_place random_place(const btg_part *part, rng *r) {
    btg_place at = {0};
    at.item = (uint32_t)rng_pick(r, (int)(part->patch_count + part->triangle_count));
    at.u = rng_range(r, 0, 1);
    at.v = rng_range(r, 0, at.item < part->patch_count ? 1 : 1 - at.u);
    return at;
}

static void check_tilt(const setting *s, const btg_drop_query *dropped,
                       const btg_drop_result *first, rng *r) {
    btg_tilt_query query;
    btg_status status = btg_position_tilt_query(&s->tool, &s->solver, dropped, first, &query);
    for (int start = 0; start < 2 && status == BTG_OK; start++) {
        query.has_start = start;
        query.start = random_place(s->part, r);
        btg_tilt_result one, two;
        btg_status want = tilt(s, &btg_run_baseline, &query, &one);
        answers++;
        with_contact += one.status == BTG_OK;
        for (int i = 0; i < s->other_count; i++) {
            CHECK(tilt(s, s->other[i], &query, &two) == want);
            same_tilt(one, two, s->other[i]->name);
        }
    }
}

static void check_drop(const setting *s, rng *r) {
    btg_part_info info;
    btg_part_get_info(s->part, &info);
    double x = rng_range(r, info.box_min.x - 5, info.box_max.x + 5);
    double y = rng_range(r, info.box_min.y - 5, info.box_max.y + 5);
    btg_drop_query query = btg_position_drop_query(x, y);
    btg_drop_result plain_start = {0};
    for (int start = 0; start < 2; start++) {
        query.has_start = start;
        query.start = random_place(s->part, r);
        btg_drop_result one, two;
        btg_status want = drop(s, &btg_run_baseline, &query, &one);
        answers++;
        for (int i = 0; i < s->other_count; i++) {
            CHECK(drop(s, s->other[i], &query, &two) == want);
            same_drop(one, two, s->other[i]->name);
        }
        if (start == 0) plain_start = one;
    }
    if (plain_start.status == BTG_OK) check_tilt(s, &query, &plain_start, r);
}

static void check_part(setting *s, rng *r, int round) {
    model m = {0};
    if (round % 3 != 2)
        for (int i = 0; i < 3; i++)
            hard_add_patch(&m, r, (hard_patch)((round + i) % HARD_PATCHES), 60);
    if (round % 3 > 0) hard_add_mesh(&m, r, (hard_mesh)(round / 3 % HARD_MESHES), 60);
    btg_part *part = model_part(&m);
    model_free(&m);
    s->part = part;
    s->workspace = malloc(btg_workspace_size(part));
    for (int i = 0; i < PLACES; i++) {
        s->tool = hard_tool(rng_pick(r, HARD_TOOLS));
        s->solver = btg_solver_def_default();
        s->solver.tolerance_mm = i % 2 ? 1e-9 : 1e-3;
        s->solver.node_budget = rng_pick(r, 4) ? 20000 : 40;
        check_drop(s, r);
    }
    free(s->workspace);
    btg_part_destroy(part);
}

#if defined(BTG_HAVE_AVX2) || defined(BTG_HAVE_AVX512)
static void add_build(setting *s, const btg_run *run, int here) {
    if (here)
        s->other[s->other_count++] = run;
    else
        printf("%s: built, but this processor has none; skipped\n", run->name);
}
#endif

int main(void) {
    setting s = {.other = {&btg_run_plain}, .other_count = 1};
    CHECK(strcmp(btg_run_plain.name, "plain") == 0 && btg_run_plain.drop != btg_run_baseline.drop);
#ifdef BTG_HAVE_AVX2
    add_build(&s, &btg_run_avx2, __builtin_cpu_supports("avx2"));
#endif
#ifdef BTG_HAVE_AVX512
    add_build(&s, &btg_run_avx512,
              __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq"));
#endif
    int rounds = hard_rounds(ROUNDS);
    for (int i = 0; i < rounds; i++) {
        rng r = rng_of(3, "variants", (uint64_t)i);
        check_part(&s, &r, i);
    }
    printf("%ld answers, %ld of them second contacts, from %d other builds\n", answers,
           with_contact, s.other_count);
    CHECK(answers > 0 && with_contact > 0);
    return check_result();
}
