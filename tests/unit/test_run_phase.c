/* The run phase never allocates; set-up allocates through the caller's allocator alone. The
 * linker sends every malloc of the library here (see meson.build). */
#include "check.h"
#include "bitangent/bitangent.h"

#include "../conformance/model.h"
#include "../conformance/rng.h"

#include <stdlib.h>
#include <string.h>

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *memory, size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *memory, size_t size);

static long calls;

void *__wrap_malloc(size_t size) {
    calls++;
    return __real_malloc(size);
}

void *__wrap_calloc(size_t count, size_t size) {
    calls++;
    return __real_calloc(count, size);
}

void *__wrap_realloc(void *memory, size_t size) {
    calls++;
    return __real_realloc(memory, size);
}

static void *arena_allocate(size_t size, void *user) {
    (void)user;
    return __real_malloc(size);
}

static void arena_release(void *memory, void *user) {
    (void)user;
    free(memory);
}

static btg_part *make_part(rng *r) {
    double points[48];
    for (int i = 0; i < 16; i++) {
        points[3 * i] = 20 * (i / 4);
        points[3 * i + 1] = 20 * (i % 4);
        points[3 * i + 2] = rng_range(r, -8, 8);
    }
    const double corners[9] = {-20, 10, 5, 0, 10, 6, -10, 30, 4};
    const uint32_t index[3] = {0, 1, 2};
    btg_surface_def surface = {3, 3, 4, 4, points, NULL, NULL, NULL};
    btg_mesh_def mesh = {corners, 3, index, 1};
    btg_part_def def = btg_part_def_default();
    def.surfaces = &surface;
    def.surface_count = 1;
    def.meshes = &mesh;
    def.mesh_count = 1;
    def.allocator = (btg_allocator){arena_allocate, arena_release, NULL};
    btg_part *part = NULL;
    calls = 0;
    CHECK(btg_part_create(&def, &part, NULL) == BTG_OK);
    CHECK(calls == 0);
    return part;
}

static void check_positions(rng *r, const btg_part *part, btg_profile profile) {
    btg_tool_def def = btg_tool_def_default();
    def.profile = profile;
    def.shank = (btg_cylinder){10, 5, 50};
    btg_tool tool;
    CHECK(btg_tool_init(&def, &tool, NULL) == BTG_OK);
    btg_solver_def solver = btg_solver_def_default();
    size_t size = btg_position_workspace_size(part);
    char *workspace = malloc(size + 64);
    memset(workspace + size, 0x5a, 64);
    calls = 0;
    int count = getenv("BTG_TEST_QUICK") ? 24 : 60;
    for (int i = 0; i < count; i++) {
        btg_position p;
        solver.spin = (btg_spin)(i % 8 < 5 ? i % 8 : 0);
        solver.spin_rad = rng_range(r, -3, 3);
        solver.gap_mm = rng_range(r, 1, 9);
        btg_status status = btg_position_solve(part, &tool, &solver, rng_range(r, -25, 70),
                                               rng_range(r, -10, 70), workspace, size, &p);
        CHECK(status >= 0 && status == p.status);
    }
    CHECK(calls == 0);
    solver.spin = BTG_SPIN_GAP;
    for (int i = 0; i < 64; i++)
        CHECK(workspace[size + (size_t)i] == 0x5a);
    btg_position p;
    CHECK(btg_position_solve(part, &tool, &solver, 1, 1, workspace, size - 1, &p) ==
          BTG_ERROR_ARGUMENT);
    CHECK(btg_position_solve(part, &tool, &solver, NAN, 1, workspace, size, &p) ==
          BTG_ERROR_ARGUMENT);
    CHECK(btg_position_solve(NULL, &tool, &solver, 1, 1, workspace, size, &p) ==
          BTG_ERROR_ARGUMENT);
    free(workspace);
}

int main(void) {
    rng r = {7};
    void *volatile seen = malloc(1); /* the wrapping works */
    CHECK(calls == 1);
    free(seen);
    btg_part *part = make_part(&r);
    if (part) {
        check_positions(&r, part, BTG_PROFILE_TOROIDAL);
        check_positions(&r, part, BTG_PROFILE_BULLNOSE);
    }
    btg_part_destroy(part);
    return check_result();
}
