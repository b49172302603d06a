/* Verification against closed forms: the height under a leaning cutter, scallops and gouges of
 * known passes on planes, and what must not depend on threads, cells or the path's length. */
#include "unit/check.h"
#include "verify/internal.h"

#include <stdlib.h>
#include <string.h>

/* ---- parts, tools, paths ------------------------------------------------------------------ */

/* z = slope x over [0, 20] x [0, 20]. */
static btg_part *plane(double slope) {
    const double points[12] = {0, 0, 0, 0, 20, 0, 20, 0, 20 * slope, 20, 20, 20 * slope};
    btg_surface_def s = {1, 1, 2, 2, points, NULL, NULL, NULL};
    btg_part_def def = btg_part_def_default();
    def.surfaces = &s;
    def.surface_count = 1;
    btg_part *part = NULL;
    CHECK(btg_part_create(&def, &part, NULL) == BTG_OK);
    return part;
}

static btg_tool tool_of(double major, double minor, btg_profile profile) {
    btg_tool_def def = btg_tool_def_default();
    btg_tool tool;
    def.major_radius_mm = major;
    def.minor_radius_mm = minor;
    def.profile = profile;
    CHECK(btg_tool_init(&def, &tool, NULL) == BTG_OK);
    return tool;
}

typedef struct check {
    const btg_part *part;
    btg_tool tool;
    btg_verify_def def;
    btg_verify *verify;
    uint64_t line;
} check;

static check begin(const btg_part *part, btg_tool tool, double cell) {
    check c = {part, tool, btg_verify_def_default(), NULL, 0};
    c.def.cell_mm = cell;
    return c;
}

static void to(check *c, double x, double y, double z, btg_vec3 axis, int link) {
    if (!c->verify)
        CHECK(btg_verify_create(&c->def, c->part, &c->tool, &c->verify, NULL) == BTG_OK);
    btg_verify_pose pose = {.tip = vec(x, y, z), .axis = axis, .link = link, .line = ++c->line};
    CHECK(btg_verify_add(c->verify, &pose) == BTG_OK);
}

static btg_verify_result end(check *c) {
    btg_verify_result r;
    CHECK(btg_verify_end(c->verify, &r) == BTG_OK);
    return r;
}

static bool near(double a, double b, double room) {
    if (fabs(a - b) <= room) return true;
    fprintf(stderr, "%.12g is not %.12g (to %g)\n", a, b, room);
    return false;
}

static const btg_vec3 up = {0, 0, 1};

/* ---- under a leaning cutter --------------------------------------------------------------- */

static double uniform(uint64_t *seed) {
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return (double)(*seed >> 11) * 0x1p-53;
}

static void test_under_of(btg_tool tool, double lean_max, uint64_t seed) {
    btg_cutter cutter = {tool.def.major_radius_mm, tool.def.minor_radius_mm,
                         tool.element[0].hollow != 0};
    double size = cutter.major + cutter.minor;
    int hits = 0;
    for (int i = 0; i < 400; i++) {
        double lean = lean_max * uniform(&seed), turn = 6.3 * uniform(&seed);
        btg_vec3 axis = vec(sin(lean) * cos(turn), sin(lean) * sin(turn), cos(lean));
        double x = size * (2 * uniform(&seed) - 1), y = size * (2 * uniform(&seed) - 1), z;
        bool hit = btg_cutter_under(&cutter, axis, x, y, &z);
        hits += hit;
        btg_vec3 none = vec(0, 0, 0);
        if (hit) CHECK(near(btg_tool_distance(&tool, none, axis, vec(x, y, z)), 0, 1e-9));
        /* Nothing of the cutter below, or anywhere on the line. */
        double top = hit ? z - 1e-7 : size, least = INFINITY;
        for (int k = 0; k <= 500; k++)
            least = fmin(least, btg_tool_distance(&tool, none, axis,
                                                  vec(x, y, -size + (top + size) * k / 500)));
        CHECK(least > -1e-9);
        double again;
        if (hit && btg_cutter_under_near(&cutter, axis, x, y, z + 1e-3, &again) &&
            cutter.major * axis.z > cutter.minor)
            CHECK(near(again, z, 1e-9));
    }
    CHECK(hits > 100);
}

static void test_under(void) {
    test_under_of(tool_of(6.7, 6, BTG_PROFILE_TOROIDAL), 0.4, 1);
    test_under_of(tool_of(10, 3, BTG_PROFILE_TOROIDAL), 1.3, 2);
    test_under_of(tool_of(10, 3, BTG_PROFILE_BULLNOSE), 1.3, 3);
    test_under_of(tool_of(0, 5, BTG_PROFILE_TOROIDAL), 1.3, 4);
    test_under_of(tool_of(2, 5, BTG_PROFILE_TOROIDAL), 1.3, 5);
    test_under_of(tool_of(8, 0, BTG_PROFILE_BULLNOSE), 0.3, 6);
}

/* ---- planes ------------------------------------------------------------------------------- */

/* Passes of a ball along y, `side` apart: R - sqrt(R^2 - (side/2)^2) is left between them. */
static void test_scallop(void) {
    btg_part *part = plane(0);
    double side = 2, radius = 5;
    check c = begin(part, tool_of(0, radius, BTG_PROFILE_TOROIDAL), 0.1);
    c.def.scallop_mm = 0.02;
    for (int pass = 0; pass <= 10; pass++) {
        /* Over the middle of a cell, so that the middle between two passes is one too. */
        to(&c, 0.05 + side * pass, -5, 0, up, 0);
        to(&c, 0.05 + side * pass, 25, 0, up, 1);
    }
    btg_verify_result r = end(&c);
    double h = radius - sqrt(radius * radius - side * side / 4);
    CHECK(near(r.max_scallop_mm, h, 0.001) && r.max_scallop_mm >= h - 1e-12);
    CHECK(near(fmod(r.scallop.at.x, side), 1.05, 1e-9));
    CHECK(r.max_gouge_mm < 1e-12 && r.gouge_area_mm2 == 0 && r.uncut_mm2 == 0);
    CHECK(r.position_bound_mm <= 1e-4 && r.motion_bound_mm <= 1e-4 + 0.001);
    /* Half of the cells lie below h_50 = R - sqrt(R^2 - (side/4)^2). */
    CHECK(near(r.percentile_mm[0], radius - sqrt(radius * radius - side * side / 16), 0.006));
    double strip = 2 * sqrt(radius * radius - (radius - 0.02) * (radius - 0.02));
    CHECK(near(r.strip_width_mm, strip * 10 * 20 / (11 * 30), 0.1));
    /* A block 5 mm high, less the scallops' mean height, s^2 / (24 R) to first order. */
    CHECK(near(r.removed_mm3, 400 * (5 - side * side / (24 * radius)), 1));
    btg_verify_destroy(c.verify);
    btg_part_destroy(part);
}

/* Along a plane in one long move: what lies between is cut too, to the sweep's error. */
static void test_sweep(void) {
    btg_part *part = plane(0);
    for (int fine = 0; fine < 2; fine++) {
        check c = begin(part, tool_of(0, 5, BTG_PROFILE_TOROIDAL), 0.1);
        c.def.sweep_error_mm = fine ? 1e-5 : 1e-2;
        to(&c, 10.05, -5, 0, up, 0);
        to(&c, 10.05, 25, 0, up, 1);
        end(&c);
        btg_verify_map map = btg_verify_get_map(c.verify);
        double most = 0;
        for (size_t j = 0; j < map.height; j++)
            most = fmax(most, btg_verify_deviation(&map, j * map.width + 100));
        CHECK(most <= c.def.sweep_error_mm && most > 0);
        btg_verify_destroy(c.verify);
    }
    btg_part_destroy(part);
}

static void test_gouge(void) {
    btg_part *part = plane(0);
    check c = begin(part, tool_of(0, 5, BTG_PROFILE_TOROIDAL), 0.1);
    for (int i = 0; i <= 20; i++)
        to(&c, 10.05, i + 0.05, i == 7 ? -0.05 : 0, up, i > 0);
    btg_verify_result r = end(&c);
    CHECK(near(r.max_gouge_mm, 0.05, 1e-9));
    CHECK(r.gouge.position == 8 && r.gouge.line == 8);
    CHECK(near(r.gouge.at.x, 10.05, 1e-9) && near(r.gouge.at.y, 7.05, 1e-9) && r.gouge.at.z == 0);
    CHECK(near(r.position_bound_mm, 0.05, 2e-4) && r.position_bound_mm >= 0.05 - 1e-12);
    CHECK(r.motion_bound_mm >= r.max_gouge_mm && r.bound.position == 8);
    /* Deeper than 0.01 mm: circles of sqrt(2 R (d - 0.01)) along the ramps of 1 mm each. */
    CHECK(r.gouge_area_mm2 > 1 && r.gouge_area_mm2 < 3);
    btg_verify_destroy(c.verify);
    btg_part_destroy(part);
}

/* On a slope the vertical depth is not the depth. */
static void test_slope(void) {
    btg_part *part = plane(1);
    double k = sqrt(0.5), depth = 0.05;
    check c = begin(part, tool_of(0, 5, BTG_PROFILE_TOROIDAL), 0.02);
    c.def.prove = 0;
    /* The ball's centre at 5 mm less the depth over (10, y). */
    double x = 10 - (5 - depth) * k, z = 10 + (5 - depth) * k - 5;
    to(&c, x, 8, z, up, 0);
    to(&c, x, 12, z, up, 1);
    btg_verify_result r = end(&c);
    CHECK(near(r.max_gouge_mm, depth, 2e-5) && r.max_gouge_mm <= depth);
    CHECK(near(r.gouge.at.x, 10, 0.05) && isnan(r.position_bound_mm));
    btg_verify_map map = btg_verify_get_map(c.verify);
    double least = 0;
    for (size_t i = 0; i < (size_t)map.width * map.height; i++)
        least = fmin(least, btg_verify_deviation(&map, i));
    CHECK(near(-least, r.max_gouge_mm, 1e-12));
    btg_verify_destroy(c.verify);
    btg_part_destroy(part);
}

/* A ring that leans forward by `lean`, moved straight on: seen along its way it is half an ellipse,
 * and what it leaves is the curve at the minor radius from it. */
static void test_leaning(btg_profile profile) {
    btg_part *part = plane(0);
    double major = 6, minor = 4, lean = 0.35, low = major * sin(lean) + minor;
    btg_vec3 axis = vec(0, sin(lean), cos(lean));
    check c = begin(part, tool_of(major, minor, profile), 0.1);
    c.def.sweep_error_mm = 1e-4;
    for (int i = 0; i < 2; i++) {
        btg_vec3 tip = vec_mad(vec(10.05, i ? 40 : -20, low), axis, -minor);
        to(&c, tip.x, tip.y, tip.z, axis, i);
    }
    btg_verify_result r = end(&c);
    CHECK(r.max_gouge_mm < 1e-9);
    btg_verify_map map = btg_verify_get_map(c.verify);
    for (size_t i = 70; i <= 130; i++) {
        double x = (double)i * 0.1 - 10, a = -1.57, b = 1.57, height = 0;
        for (int k = 0; k < 100; k++) {
            /* Ellipse at t, and its normal's foot at distance `minor`. */
            double t = 0.5 * (a + b), nx = sin(lean) * sin(t), nz = -cos(t), n = hypot(nx, nz);
            double at = major * sin(t) + minor * nx / n;
            height = low - major * sin(lean) * cos(t) + minor * nz / n;
            if (at < x)
                a = t;
            else
                b = t;
        }
        CHECK(near(btg_verify_deviation(&map, 100 * map.width + i), height, 1.1e-4));
    }
    btg_verify_destroy(c.verify);
    btg_part_destroy(part);
}

/* The axis turns by half a radian while the tip moves on: what steps for a coarse error miss of
 * fine ones is within that error, taken along the normal of the cut surface. */
static void test_turning(void) {
    btg_part *part = plane(0);
    double *stock[2];
    size_t size = 0;
    for (int fine = 0; fine < 2; fine++) {
        check c = begin(part, tool_of(6, 3, BTG_PROFILE_TOROIDAL), 0.1);
        c.def.sweep_error_mm = fine ? 1e-5 : 0.05;
        c.def.prove = 0;
        to(&c, 8, 8, 1.5, vec(0, sin(0.1), cos(0.1)), 0);
        to(&c, 11, 13, 2, vec(sin(0.5), 0, cos(0.5)), 1);
        CHECK(end(&c).steps > 4);
        btg_verify_map map = btg_verify_get_map(c.verify);
        size = (size_t)map.width * map.height;
        stock[fine] = malloc(size * sizeof(double));
        memcpy(stock[fine], map.stock_z_mm, size * sizeof(double));
        btg_verify_destroy(c.verify);
    }
    double most = 0;
    for (size_t i = 201; i < size; i++) {
        double dx = (stock[1][i] - stock[1][i - 1]) / 0.1,
               dy = (stock[1][i] - stock[1][i - 200]) / 0.1;
        if (stock[1][i] >= 5 || hypot(dx, dy) > 2) continue; /* uncut, or the rim's wall */
        most = fmax(most, fabs(stock[0][i] - stock[1][i]) / sqrt(1 + dx * dx + dy * dy));
    }
    CHECK(most > 1e-3 && most < 0.05 + 1e-5);
    free(stock[0]);
    free(stock[1]);
    btg_part_destroy(part);
}

static void test_collision(void) {
    btg_part *part = plane(0);
    for (int wide = 0; wide < 2; wide++) {
        btg_tool_def def = btg_tool_def_default();
        btg_tool tool;
        def.major_radius_mm = 0;
        def.minor_radius_mm = 2;
        def.holder_count = 1;
        def.holder[0] = (btg_cylinder){wide ? 12 : 3, 4, 30};
        CHECK(btg_tool_init(&def, &tool, NULL) == BTG_OK);
        check c = begin(part, tool, 0.5);
        double lean = 0.5;
        btg_vec3 centre = vec(6, 10, 2), axis = vec(sin(lean), 0, cos(lean));
        for (int i = 0; i < 3; i++) {
            btg_vec3 a = i == 1 ? axis : up, tip = vec_mad(centre, a, -2);
            to(&c, tip.x, tip.y, tip.z, a, 0);
        }
        btg_verify_result r = end(&c);
        CHECK(r.collisions == (wide ? 1 : 0));
        CHECK(r.position_bound_mm < 2e-4);
        /* The holder's rim stands 12 sin(lean) below its axis' point at 4 mm. */
        double depth = 12 * sin(lean) - 4 * cos(lean) - 2;
        if (wide) CHECK(near(r.collision_mm, depth / cos(lean), 1e-3) && r.collision.position == 2);
        btg_verify_destroy(c.verify);
    }
    btg_part_destroy(part);
}

/* ---- what must not matter ----------------------------------------------------------------- */

static size_t allocations;

static void *count_allocate(size_t size, void *user) {
    (void)user;
    allocations++;
    return malloc(size);
}

static void count_release(void *memory, void *user) {
    (void)user;
    free(memory);
}

static void test_threads(void) {
    btg_part *part = plane(0.3);
    btg_verify_result r[2];
    double *stock[2];
    size_t size = 0;
    for (int i = 0; i < 2; i++) {
        check c = begin(part, tool_of(6.7, 6, BTG_PROFILE_TOROIDAL), 0.05);
        c.def.threads = i ? 5 : 1;
        for (int k = 0; k < 60; k++) {
            double lean = 0.3 * sin(0.3 * k);
            to(&c, 0.33 * k, 10 + 5 * cos(k), 4, vec(sin(lean), 0, cos(lean)), k % 7 > 0);
        }
        r[i] = end(&c);
        btg_verify_map map = btg_verify_get_map(c.verify);
        size = (size_t)map.width * map.height * sizeof(double);
        stock[i] = malloc(size);
        memcpy(stock[i], map.stock_z_mm, size);
        btg_verify_destroy(c.verify);
    }
    CHECK(memcmp(stock[0], stock[1], size) == 0);
    CHECK(r[0].max_gouge_mm == r[1].max_gouge_mm && r[0].gouge.at.y == r[1].gouge.at.y);
    CHECK(r[0].motion_bound_mm == r[1].motion_bound_mm && r[0].max_gouge_mm > 0.1);
    free(stock[0]);
    free(stock[1]);
    btg_part_destroy(part);
}

static void test_memory(void) {
    btg_part *part = plane(0);
    check c = begin(part, tool_of(0, 1, BTG_PROFILE_TOROIDAL), 1);
    c.def.allocator = (btg_allocator){count_allocate, count_release, NULL};
    c.def.prove = 0;
    to(&c, 0, 0, 0, up, 0);
    size_t before = allocations;
    for (int i = 1; i < 50000; i++)
        to(&c, i % 20, i * 4e-4, 0, up, 0);
    CHECK(allocations == before && before > 0);
    CHECK(end(&c).positions == 50000);
    btg_verify_destroy(c.verify);
    btg_part_destroy(part);
}

static void test_refusals(void) {
    btg_part *part = plane(0);
    btg_tool tool = tool_of(0, 1, BTG_PROFILE_TOROIDAL);
    btg_verify *v = NULL;
    const double wrong[4] = {-1, NAN, INFINITY, 1e-4};
    for (int i = 0; i < 4; i++) {
        btg_message message = {""};
        btg_verify_def def = btg_verify_def_default();
        def.cell_mm = wrong[i];
        CHECK(btg_verify_create(&def, part, &tool, &v, &message) == BTG_ERROR_ARGUMENT);
        CHECK(message.text[0] && !v);
    }
    check c = begin(part, tool, 1);
    to(&c, 0, 0, 0, up, 0);
    const btg_verify_pose bad[4] = {{.tip = {NAN, 0, 0}, .axis = {0, 0, 1}},
                                    {.axis = {0, 0, 0.9}},
                                    {.axis = {1, 0, 0}},
                                    {.axis = {0, 0, -1}}};
    for (int i = 0; i < 4; i++)
        CHECK(btg_verify_add(c.verify, &bad[i]) == BTG_ERROR_ARGUMENT);
    CHECK(end(&c).positions == 1);
    btg_verify_destroy(c.verify);
    btg_verify_destroy(NULL);
    btg_part_destroy(part);
}

int main(void) {
    test_under();
    test_scallop();
    test_sweep();
    test_gouge();
    test_slope();
    test_leaning(BTG_PROFILE_TOROIDAL);
    test_leaning(BTG_PROFILE_BULLNOSE);
    test_turning();
    test_collision();
    test_threads();
    test_memory();
    test_refusals();
    return check_result();
}
