#include "device_checks.h"
#include "check.h"
#include "core/part.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#define SIDE  21
#define COUNT (SIDE * SIDE)

static const char *name; /* of the back end */
static btg_tool tool;
static btg_solver_def solver;
static btg_part *part;

/* A rational patch over half of the ground, two triangles over the other: 100 mm square. */
static btg_part *make_part(void) {
    static const double height[9] = {10, 4, 9, 3, 14, 2, 8, 5, 11};
    static const double weights[9] = {1, 0.8, 1, 1.2, 1, 0.9, 1, 1.1, 1};
    static const double corners[12] = {50, 0, 6, 100, 0, 9, 100, 100, 4, 50, 100, 8};
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    double points[27];
    for (int i = 0; i < 9; i++) {
        points[3 * i] = 25 * (i / 3);
        points[3 * i + 1] = 50 * (i % 3);
        points[3 * i + 2] = height[i];
    }
    btg_surface_def surface = {.degree_u = 2,
                               .degree_v = 2,
                               .count_u = 3,
                               .count_v = 3,
                               .control_points = points,
                               .weights = weights};
    btg_mesh_def mesh = {corners, 4, indices, 2};
    btg_part_def def = btg_part_def_default();
    def.surfaces = &surface;
    def.surface_count = 1;
    def.meshes = &mesh;
    def.mesh_count = 1;
    btg_part *made = NULL;
    CHECK(btg_part_create(&def, &made, NULL) == BTG_OK);
    if (!made) exit(1);
    return made;
}

static void foot_of(size_t i, double foot[2]) {
    i %= COUNT;
    foot[0] = -20 + 7.1 * (double)(i / SIDE);
    foot[1] = -20 + 7.3 * (double)(i % SIDE);
}

/* ---- batches ------------------------------------------------------------------------------ */

/* Both questions; answers are the cpu's. */
static void ask_all(void *state, size_t count) {
    btg_drop_query *drops = calloc(count, sizeof *drops);
    btg_drop_result *results = calloc(count, sizeof *results);
    btg_tilt_query *tilts = calloc(count, sizeof *tilts);
    btg_tilt_result *tilted = calloc(count, sizeof *tilted);
    size_t size = btg_workspace_size(part), asked = 0;
    void *workspace = malloc(size);
    CHECK(drops && results && tilts && tilted && workspace);
    for (size_t i = 0; i < count; i++) {
        double foot[2];
        foot_of(i, foot);
        drops[i] = btg_position_drop_query(foot[0], foot[1]);
    }
    CHECK(btg_batch_drop(state, drops, count, results) == BTG_OK);
    for (size_t i = 0; i < count; i++) {
        btg_drop_result r;
        btg_drop(part, &tool, &solver, &drops[i], workspace, size, &r);
        CHECK(r.status == results[i].status);
        CHECK(fabs(r.height_mm - results[i].height_mm) < 1e-6);
        if (btg_position_tilt_query(&tool, &solver, &drops[i], &results[i], &tilts[asked]) ==
            BTG_OK)
            asked++;
    }
    CHECK(asked > 0 || count < SIDE);
    if (asked > 0) CHECK(btg_batch_tilt(state, tilts, asked, tilted) == BTG_OK);
    for (size_t i = 0; i < asked; i++) {
        btg_tilt_result r;
        btg_tilt(part, &tool, &solver, &tilts[i], workspace, size, &r);
        CHECK(fabs(r.tilt_rad - tilted[i].tilt_rad) < 1e-4 * BTG_PI / 180);
    }
    free(workspace);
    free(tilted);
    free(tilts);
    free(results);
    free(drops);
}

void device_check_batches(void *state) {
    const size_t sizes[] = {1, 2, DEVICE_DISPATCH, DEVICE_DISPATCH + 1, COUNT};
    for (int i = 0; i < 5; i++)
        ask_all(state, sizes[i]);
}

/* ---- threads ------------------------------------------------------------------------------ */

static btg_backend *open_named(const char *which, int raw) {
    btg_backend_def def = btg_backend_def_default();
    btg_message message = {""};
    btg_backend *backend = NULL;
    def.name = which;
    def.raw = raw;
    if (btg_backend_open(&def, part, &tool, &solver, &backend, &message) != BTG_OK)
        fprintf(stderr, "%s\n", message.text);
    CHECK(backend != NULL);
    if (!backend) exit(1);
    return backend;
}

static void solve(const char *which, int raw, btg_position *positions) {
    btg_backend *backend = open_named(which, raw);
    double feet[2 * COUNT];
    for (size_t i = 0; i < COUNT; i++)
        foot_of(i, &feet[2 * i]);
    CHECK(btg_backend_positions(backend, feet, COUNT, positions, NULL) == BTG_OK);
    btg_backend_close(backend);
}

static void *work(void *positions) {
    solve(name, 0, positions);
    return NULL;
}

/* Four at once, each with a device of its own: the same bits. */
static void test_threads(void) {
    static btg_position positions[4][COUNT];
    pthread_t threads[4];
    for (int i = 0; i < 4; i++)
        CHECK(pthread_create(&threads[i], NULL, work, positions[i]) == 0);
    for (int i = 0; i < 4; i++)
        pthread_join(threads[i], NULL);
    for (int i = 1; i < 4; i++)
        for (size_t k = 0; k < COUNT; k++) {
            const btg_position *a = &positions[0][k], *b = &positions[i][k];
            CHECK(a->status == b->status);
            CHECK(memcmp(&a->drop_z_mm, &b->drop_z_mm, sizeof a->drop_z_mm) == 0);
            CHECK(memcmp(&a->tilt_rad, &b->tilt_rad, sizeof a->tilt_rad) == 0);
        }
}

/* ---- raw ---------------------------------------------------------------------------------- */

/* Samples stand a tenth of the tool's radius apart: of two peaks the lower may be followed where
 * they differ by less than a sample can miss, pitch^2 / (4 minor radius). */
#define RAW_WORST_MM 0.07
/* Near P single precision knows little of a tilt: few are off by more than the papers' own errors,
 * which reach 1.48 degrees. */
#define RAW_TILT_RAD (1.5 * BTG_PI / 180)

/* What the device finds by itself: all but a few heights that near, nothing claimed as proven. */
static void test_raw(double near_mm) {
    size_t off = 0, tilts_off = 0;
    static btg_position raw[COUNT], proven[COUNT];
    solve(name, 1, raw);
    solve("cpu", 0, proven);
    for (size_t i = 0; i < COUNT; i++) {
        CHECK((raw[i].status == BTG_NO_CONTACT) == (proven[i].status == BTG_NO_CONTACT));
        if (proven[i].status == BTG_NO_CONTACT) continue;
        double error = fabs(raw[i].drop_z_mm - proven[i].drop_z_mm);
        CHECK(error < RAW_WORST_MM);
        if (error > near_mm) off++;
        if (fabs(raw[i].tilt_rad - proven[i].tilt_rad) > RAW_TILT_RAD) tilts_off++;
        CHECK(isnan(raw[i].bound_mm));
        CHECK(!isnan(proven[i].bound_mm));
    }
    CHECK(off < COUNT / 50);
    CHECK(tilts_off < COUNT / 50);
}

static void test_times(void) {
    btg_backend_times times;
    double feet[2] = {40, 50};
    btg_position p;
    btg_backend *backend = open_named(name, 0);
    btg_backend_get_times(backend, &times);
    CHECK(times.device_s == 0 && times.polish_s == 0);
    CHECK(btg_backend_positions(backend, feet, 1, &p, NULL) == BTG_OK);
    btg_backend_get_times(backend, &times);
    CHECK(times.device_s > 0 && times.polish_s > 0 && times.device_bytes > 0);
    btg_backend_close(backend);
    backend = open_named("cpu", 0);
    CHECK(btg_backend_positions(backend, feet, 1, &p, NULL) == BTG_OK);
    btg_backend_get_times(backend, &times);
    CHECK(times.device_s == 0);
    btg_backend_close(backend);
}

btg_backend_setup device_checks_begin(const char *backend) {
    btg_tool_def tool_def = btg_tool_def_default();
    tool_def.shank = (btg_cylinder){10, 25, 60};
    CHECK(btg_tool_init(&tool_def, &tool, NULL) == BTG_OK);
    solver = btg_solver_def_default();
    part = make_part();
    name = backend;
    return (btg_backend_setup){
        .part = part, .tool = tool, .solver = solver, .threads = 2, .levels = 2, .window = 50};
}

void device_check_threads_raw_times(double near_mm) {
    test_threads();
    test_raw(near_mm);
    test_times();
}

int device_checks_end(int result) {
    btg_part_destroy(part);
    return check_failures > 0 ? check_result() : result;
}
