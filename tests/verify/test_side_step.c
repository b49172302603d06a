/* The side step of a scallop height against the cusps that a ball leaves on a plane: at x from the
 * middle of its pass R - sqrt(R^2 - x^2) is left, so that 99 % of the plane has h at most where
 * 0.99 step / 2 = sqrt(R^2 - (R - h)^2). */
#include "bitangent/verify.h"
#include "core/vec.h"
#include "unit/check.h"

#include <stdlib.h>

#define RADIUS 5.0
#define SIDE   40.0
/* The search's own 2 %, and that of its cells. */
#define STEP_ROOM 0.035

static long calls;

/* A ball that touches the plane z = 0 everywhere. */
static btg_status on_plane(const double *xy, size_t count, btg_position *positions, void *user) {
    calls++;
    for (size_t i = 0; i < count; i++)
        positions[i] =
            (btg_position){.tip = vec(xy[2 * i], xy[2 * i + 1], 0), .axis = vec(0, 0, 1)};
    return *(btg_status *)user;
}

static btg_status find(double scallop, double share, btg_status answer, double *step,
                       btg_message *message) {
    const double points[12] = {0, 0, 0, 0, SIDE, 0, SIDE, 0, 0, SIDE, SIDE, 0};
    btg_surface_def s = {1, 1, 2, 2, points, NULL, NULL, NULL};
    btg_part_def part_def = btg_part_def_default();
    part_def.surfaces = &s;
    part_def.surface_count = 1;
    btg_part *part = NULL;
    CHECK(btg_part_create(&part_def, &part, NULL) == BTG_OK);
    btg_tool_def tool_def = btg_tool_def_default();
    btg_tool tool;
    tool_def.major_radius_mm = 0;
    tool_def.minor_radius_mm = RADIUS;
    CHECK(btg_tool_init(&tool_def, &tool, NULL) == BTG_OK);
    btg_side_step_def def = btg_side_step_def_default();
    def.footprint.x_max_mm = def.footprint.y_max_mm = SIDE;
    def.scallop_mm = scallop;
    def.share = share;
    def.threads = 2;
    def.solve = on_plane;
    def.user = &answer;
    btg_status status = btg_side_step(&def, part, &tool, step, message);
    btg_part_destroy(part);
    return status;
}

int main(void) {
    const double scallops[3] = {0.1, 0.3, 1};
    btg_message message;
    double step = -1;
    const int rounds = getenv("BTG_TEST_QUICK") ? 1 : 3;
    for (int i = 0; i < rounds; i++) {
        double h = scallops[i], rest = RADIUS - h;
        double want = 2 * sqrt(RADIUS * RADIUS - rest * rest) / 0.99;
        CHECK(find(h, 0.99, BTG_OK, &step, &message) == BTG_OK);
        CHECK_NEAR(step / want, 1, STEP_ROOM);
        CHECK(find(h, 0.5, BTG_OK, &step, &message) == BTG_OK);
        CHECK_NEAR(step / fmin(want * 0.99 / 0.5, 2 * RADIUS), 1, STEP_ROOM);
    }
    step = -1;
    CHECK(find(1e-3, 0.99, BTG_OK, &step, &message) == BTG_ERROR_ARGUMENT);
    CHECK(find(1e-4, 0.99, BTG_OK, &step, &message) == BTG_ERROR_ARGUMENT);
    CHECK(find(NAN, 0.99, BTG_OK, &step, &message) == BTG_ERROR_ARGUMENT);
    CHECK(find(0.1, 0, BTG_OK, &step, &message) == BTG_ERROR_ARGUMENT);
    calls = 0;
    CHECK(find(0.1, 0.99, BTG_ERROR_DEVICE, &step, &message) == BTG_ERROR_DEVICE && calls == 1);
    CHECK(step == -1);
    return check_result();
}
