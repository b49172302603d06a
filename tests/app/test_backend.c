/* The front of the back ends: what it refuses, and that neither threads nor batches show. */
#include "bitangent/backend.h"
#include "check.h"
#include "core/vec.h"

#include <stdlib.h>
#include <string.h>

#define SIDE  17 /* odd, and no multiple of any number of threads */
#define COUNT (SIDE * SIDE)

typedef struct answers {
    btg_drop_result drops[COUNT];
    btg_tilt_query tilt_queries[COUNT];
    btg_tilt_result tilts[COUNT];
    size_t tilt_count;
    btg_position positions[COUNT];
} answers;

static btg_tool tool;
static btg_solver_def solver;

/* The saddle of the VCRF paper, 150 mm square. */
static btg_part *make_part(void) {
    static const double height[16] = {80,  65,  90, 85,  80, 85,  90,  95,
                                      100, 105, 95, 100, 90, 100, 100, 85};
    double points[48];
    for (int i = 0; i < 16; i++) {
        points[3 * i] = 50 * (i / 4);
        points[3 * i + 1] = 50 * (i % 4);
        points[3 * i + 2] = height[i];
    }
    btg_surface_def surface = {
        .degree_u = 3, .degree_v = 3, .count_u = 4, .count_v = 4, .control_points = points};
    btg_part_def def = btg_part_def_default();
    def.surfaces = &surface;
    def.surface_count = 1;
    btg_part *part = NULL;
    btg_message message = {""};
    CHECK(btg_part_create(&def, &part, &message) == BTG_OK);
    if (!part) exit(1);
    return part;
}

static btg_backend *make(const btg_part *part, const char *name, uint32_t threads) {
    btg_backend_def def = btg_backend_def_default();
    btg_backend *backend = NULL;
    btg_message message = {""};
    def.name = name;
    def.threads = threads;
    CHECK(btg_backend_open(&def, part, &tool, &solver, &backend, &message) == BTG_OK);
    if (!backend) exit(1);
    return backend;
}

/* Some of the footprint lies off the part. */
static void foot_of(int i, double *foot) {
    foot[0] = -30 + 12.3 * (i / SIDE);
    foot[1] = -20 + 11.7 * (i % SIDE);
}

static void solve(btg_backend *backend, answers *a) {
    btg_drop_query drop_queries[COUNT];
    double feet[2 * COUNT];
    for (int i = 0; i < COUNT; i++) {
        foot_of(i, &feet[2 * i]);
        drop_queries[i] = btg_position_drop_query(feet[2 * i], feet[2 * i + 1]);
    }
    CHECK(btg_backend_drop(backend, drop_queries, COUNT, a->drops, NULL) == BTG_OK);
    a->tilt_count = 0;
    for (int i = 0; i < COUNT; i++) {
        btg_tilt_query *next = &a->tilt_queries[a->tilt_count];
        if (btg_position_tilt_query(&tool, &solver, &drop_queries[i], &a->drops[i], next) == BTG_OK)
            a->tilt_count++;
    }
    CHECK(a->tilt_count > COUNT / 2);
    CHECK(btg_backend_tilt(backend, a->tilt_queries, a->tilt_count, a->tilts, NULL) == BTG_OK);
    CHECK(btg_backend_positions(backend, feet, COUNT, a->positions, NULL) == BTG_OK);
}

/* Bit for bit, NaN included; the gaps of the structs do not count. */
static bool same(double a, double b) {
    return memcmp(&a, &b, sizeof a) == 0 || (isnan(a) && isnan(b));
}

static bool same_vec(btg_vec3 a, btg_vec3 b) {
    return same(a.x, b.x) && same(a.y, b.y) && same(a.z, b.z);
}

static bool same_contact(const btg_contact *a, const btg_contact *b) {
    return a->place.item == b->place.item && same(a->place.u, b->place.u) &&
           same(a->place.v, b->place.v) && same_vec(a->point, b->point) &&
           same_vec(a->normal, b->normal);
}

static bool same_drop(const btg_drop_result *a, const btg_drop_result *b) {
    return a->status == b->status && same(a->height_mm, b->height_mm) &&
           same_contact(&a->contact, &b->contact) && a->element == b->element &&
           a->nodes == b->nodes;
}

static bool same_tilt(const btg_tilt_result *a, const btg_tilt_result *b) {
    return a->status == b->status && same(a->tilt_rad, b->tilt_rad) &&
           same_contact(&a->contact, &b->contact) && a->element == b->element &&
           a->nodes == b->nodes;
}

static bool same_position(const btg_position *a, const btg_position *b) {
    return a->status == b->status && same_vec(a->tip, b->tip) && same_vec(a->axis, b->axis) &&
           same_contact(&a->p, &b->p) && same_contact(&a->q, &b->q) &&
           same(a->foot_x_mm, b->foot_x_mm) && same(a->foot_y_mm, b->foot_y_mm) &&
           same(a->drop_z_mm, b->drop_z_mm) && same(a->tilt_rad, b->tilt_rad) &&
           same(a->spin_rad, b->spin_rad) && same(a->inclination_rad, b->inclination_rad) &&
           a->spin_met == b->spin_met;
}

static void compare(const answers *a, const answers *b) {
    CHECK(a->tilt_count == b->tilt_count);
    for (int i = 0; i < COUNT; i++)
        CHECK(same_drop(&a->drops[i], &b->drops[i]));
    for (size_t i = 0; i < a->tilt_count; i++)
        CHECK(same_tilt(&a->tilts[i], &b->tilts[i]));
    for (int i = 0; i < COUNT; i++)
        CHECK(same_position(&a->positions[i], &b->positions[i]));
}

static void test_threads(const btg_part *part, answers *first) {
    const uint32_t threads[] = {1, 2, 7, 33};
    answers *next = malloc(sizeof *next);
    CHECK(next != NULL);
    for (int i = 0; i < 4; i++) {
        btg_backend *backend = make(part, "cpu", threads[i]);
        CHECK(btg_backend_threads(backend) == threads[i]);
        CHECK(strcmp(btg_backend_name(backend), "cpu") == 0);
        solve(backend, i == 0 ? first : next);
        if (i > 0) compare(first, next);
        btg_backend_close(backend);
    }
    free(next);
}

/* The batch gives what one call a position gives. */
static void test_alone(const btg_part *part, const answers *batch) {
    size_t size = btg_workspace_size(part);
    void *workspace = malloc(size);
    CHECK(workspace != NULL);
    for (int i = 0; i < COUNT; i++) {
        double foot[2];
        btg_position p;
        foot_of(i, foot);
        CHECK(btg_position_solve(part, &tool, &solver, foot[0], foot[1], workspace, size, &p) >= 0);
        CHECK(same_position(&p, &batch->positions[i]));
    }
    free(workspace);
}

/* Rounds of batches give what one call a position gives, for spins that are searched for too. */
static void test_spins(const btg_part *part) {
    enum { FEET = 60 };
    const btg_solver_def plain = solver;
    size_t size = btg_position_workspace_size(part);
    void *workspace = malloc(size);
    CHECK(workspace != NULL);
    for (int spin = BTG_SPIN_FIXED; spin <= BTG_SPIN_WIDEST; spin++) {
        double feet[2 * FEET];
        btg_position p, batch[FEET];
        solver.spin = (btg_spin)spin;
        solver.spin_rad = 0.7;
        solver.gap_mm = 4;
        solver.feed_x = 1;
        int met = 0;
        for (int i = 0; i < FEET; i++)
            foot_of(COUNT * i / FEET, &feet[2 * i]);
        for (uint32_t threads = 1; threads < 4; threads += 2) {
            btg_backend *backend = make(part, "cpu", threads);
            CHECK(btg_backend_positions(backend, feet, FEET, batch, NULL) == BTG_OK);
            btg_backend_close(backend);
            for (int i = 0; i < FEET; i++) {
                CHECK(btg_position_solve(part, &tool, &solver, feet[2 * i], feet[2 * i + 1],
                                         workspace, size, &p) >= 0);
                CHECK(same_position(&p, &batch[i]));
                met += p.spin_met;
            }
        }
        CHECK(met > 0);
    }
    free(workspace);
    solver = plain;
}

static void test_sizes(const btg_part *part, const answers *all) {
    const size_t sizes[] = {0, 1, 2, 15, 16, 17, 33, 255};
    btg_backend *backend = make(part, "auto", 3);
    for (int k = 0; k < 8; k++) {
        double feet[2 * COUNT];
        btg_position p[COUNT];
        for (int i = 0; i < COUNT; i++)
            foot_of(i, &feet[2 * i]);
        memset(p, 0x5a, sizeof p);
        CHECK(btg_backend_positions(backend, feet, sizes[k], p, NULL) == BTG_OK);
        for (size_t i = 0; i < sizes[k]; i++)
            CHECK(same_position(&p[i], &all->positions[i]));
        const unsigned char *byte = (const unsigned char *)&p[sizes[k]];
        CHECK(*byte == 0x5a);
    }
    CHECK(btg_backend_drop(backend, NULL, 0, NULL, NULL) == BTG_OK);
    CHECK(btg_backend_tilt(backend, NULL, 0, NULL, NULL) == BTG_OK);
    CHECK(btg_backend_positions(backend, NULL, 0, NULL, NULL) == BTG_OK);
    btg_backend_close(backend);
}

/* ---- refusals ----------------------------------------------------------------------------- */

static void test_bad_drops(const btg_part *part) {
    btg_backend *backend = make(part, NULL, 2);
    btg_drop_query q[9];
    btg_drop_result r[9];
    const btg_drop_query bad[] = {{.origin = {NAN, 0, 0}, .axis = {0, 0, 1}},
                                  {.origin = {0, 0, 1e30}, .axis = {0, 0, 1}},
                                  {.origin = {0, 0, 0}, .axis = {0, 0, 1.001}},
                                  {.origin = {0, 0, 0}, .axis = {0, NAN, 1}}};
    for (int k = 0; k < 4; k++) {
        size_t index = 77;
        for (int i = 0; i < 9; i++)
            q[i] = btg_position_drop_query(i, i);
        q[5] = q[7] = bad[k];
        memset(r, 0x5a, sizeof r);
        CHECK(btg_backend_drop(backend, q, 9, r, &index) == BTG_ERROR_ARGUMENT);
        CHECK(index == 5);
        CHECK(*(const unsigned char *)r == 0x5a);
        CHECK(btg_backend_drop(backend, q, 9, r, NULL) == BTG_ERROR_ARGUMENT);
    }
    double feet[6] = {0, 0, 1, 1, 2, INFINITY};
    btg_position p[3];
    size_t index = 77;
    CHECK(btg_backend_positions(backend, feet, 3, p, &index) == BTG_ERROR_ARGUMENT);
    CHECK(index == 2);
    btg_backend_close(backend);
}

static void test_bad_tilts(const btg_part *part, const answers *a) {
    btg_backend *backend = make(part, NULL, 2);
    for (int k = 0; k < 8; k++) {
        btg_tilt_query q[3] = {a->tilt_queries[0], a->tilt_queries[1], a->tilt_queries[2]};
        btg_tilt_result r[3];
        size_t index = 77;
        if (k == 0) q[1].u = vec_scale(q[1].u, 1.1);
        if (k == 1) q[1].u = q[1].v;
        if (k == 2) q[1].o1.y = NAN;
        if (k == 3) q[1].p.normal = vec(0, 0, 0);
        if (k == 4) q[1].p.place.item = 1;
        if (k == 5) q[1].p.place.u = 1.5;
        if (k == 6) q[1].max_tilt_rad = -0.1;
        if (k == 7) q[1].max_tilt_rad = NAN;
        CHECK(btg_backend_tilt(backend, q, 3, r, &index) == BTG_ERROR_ARGUMENT);
        CHECK(index == 1);
    }
    btg_backend_close(backend);
}

static void cannot_open(const btg_part *part, const char *name, const btg_solver_def *s,
                        btg_status expected, const char *word) {
    btg_backend_def def = btg_backend_def_default();
    btg_backend *backend = NULL;
    btg_message message = {""};
    def.name = name;
    CHECK(btg_backend_open(&def, part, &tool, s, &backend, &message) == expected);
    CHECK(backend == NULL);
    CHECK(strstr(message.text, word) != NULL);
}

static void test_opening(const btg_part *part) {
    cannot_open(part, "abacus", &solver, BTG_ERROR_ARGUMENT, "auto, cpu, reference");
    for (size_t i = 0; i < btg_backend_count(); i++) {
        btg_backend_info info;
        CHECK(btg_backend_get_info(i, &info) == BTG_OK);
        if (info.state == BTG_BACKEND_NOT_BUILT) {
            cannot_open(part, info.name, &solver, BTG_ERROR_NOT_BUILT, "not built");
        } else if (info.state == BTG_BACKEND_NO_DEVICE) {
            cannot_open(part, info.name, &solver, BTG_ERROR_NO_DEVICE, "no device");
        }
    }
    btg_backend_info info;
    CHECK(btg_backend_get_info(btg_backend_count(), &info) == BTG_ERROR_ARGUMENT);
    btg_solver_def bad = solver;
    bad.tolerance_mm = 0;
    cannot_open(part, "cpu", &bad, BTG_ERROR_ARGUMENT, "tolerance");
    bad = solver;
    bad.max_tilt_rad = 2;
    cannot_open(part, "cpu", &bad, BTG_ERROR_ARGUMENT, "tilt");
    bad = solver;
    bad.node_budget = 0;
    cannot_open(part, "cpu", &bad, BTG_ERROR_ARGUMENT, "budget");
    bad = solver;
    bad.spin_rad = NAN;
    cannot_open(part, "cpu", &bad, BTG_ERROR_ARGUMENT, "spin");
    bad = solver;
    bad.spin = BTG_SPIN_GAP;
    cannot_open(part, "cpu", &bad, BTG_ERROR_ARGUMENT, "gap");
    bad = solver;
    bad.feed_y = NAN;
    cannot_open(part, "cpu", &bad, BTG_ERROR_ARGUMENT, "feed");
    bad = solver;
    bad.scallop_mm = -1;
    cannot_open(part, "cpu", &bad, BTG_ERROR_ARGUMENT, "scallop");
    cannot_open(NULL, "cpu", &solver, BTG_ERROR_ARGUMENT, "NULL");
    btg_backend_close(NULL);
}

/* ---- memory ------------------------------------------------------------------------------- */

typedef struct budget {
    int left, held;
} budget;

static void *take(size_t size, void *user) {
    budget *b = user;
    if (b->left == 0) return NULL;
    b->left--;
    b->held++;
    return malloc(size);
}

static void give_back(void *memory, void *user) {
    budget *b = user;
    b->held--;
    free(memory);
}

/* Wherever memory ends, opening fails cleanly, or the back end runs with fewer threads. */
static void test_memory(const btg_part *part, const answers *all) {
    bool fewer = false;
    for (int n = 0;; n++) {
        budget b = {.left = n};
        btg_backend_def def = btg_backend_def_default();
        def.name = "cpu";
        def.threads = 4;
        def.allocator = (btg_allocator){take, give_back, &b};
        btg_backend *backend = NULL;
        btg_status status = btg_backend_open(&def, part, &tool, &solver, &backend, NULL);
        CHECK(status == BTG_OK || status == BTG_ERROR_MEMORY);
        uint32_t threads = 0;
        if (status == BTG_OK) {
            double foot[2];
            btg_position p;
            foot_of(40, foot);
            CHECK(btg_backend_positions(backend, foot, 1, &p, NULL) == BTG_OK);
            CHECK(same_position(&p, &all->positions[40]));
            threads = btg_backend_threads(backend);
            if (threads < 4) fewer = true;
            btg_backend_close(backend);
        }
        CHECK(b.held == 0);
        if (threads == 4 || n > 100) break;
    }
    CHECK(fewer);
}

int main(void) {
    btg_tool_def def = btg_tool_def_default();
    CHECK(btg_tool_init(&def, &tool, NULL) == BTG_OK);
    solver = btg_solver_def_default();
    btg_part *part = make_part();
    answers *all = malloc(sizeof *all);
    if (!all) return 1;
    test_threads(part, all);
    test_alone(part, all);
    test_spins(part);
    test_sizes(part, all);
    test_bad_drops(part);
    test_bad_tilts(part, all);
    test_opening(part);
    test_memory(part, all);
    solver.spin = BTG_SPIN_GAP;
    solver.gap_mm = 4;
    btg_backend *backend = make(part, "cpu", 1);
    solve(backend, all);
    btg_backend_close(backend);
    test_memory(part, all);
    free(all);
    btg_part_destroy(part);
    return check_result();
}
