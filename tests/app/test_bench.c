/* The answers that `bitangent bench` holds the solver against: on shapes whose drop is known by
 * hand, and on positions made wrong on purpose. */
#include "app/bench.h"
#include "check.h"
#include "core/vec.h"

#include <stdlib.h>
#include <string.h>

#define MAJOR 6.7
#define MINOR 6.0

static btg_tool tool_of(double major, double minor, btg_profile profile) {
    btg_tool_def def = btg_tool_def_default();
    def.major_radius_mm = major;
    def.minor_radius_mm = minor;
    def.profile = profile;
    btg_tool tool;
    CHECK(btg_tool_init(&def, &tool, NULL) == BTG_OK);
    return tool;
}

static double drop(double *positions, uint32_t *indices, size_t triangles, const btg_tool *tool,
                   double x, double y) {
    bench_mesh mesh = {positions, indices, 3 * triangles, triangles};
    return bench_brute_drop(&mesh, tool, vec(x, y, 0), vec(0, 0, 1), NULL);
}

static bool close_to(double a, double b) {
    return fabs(a - b) < 1e-12;
}

/* A large triangle z = slope * x + 3. */
static void test_plane(void) {
    const double slopes[3] = {0, 0.5, -2};
    const btg_profile profiles[2] = {BTG_PROFILE_TOROIDAL, BTG_PROFILE_BULLNOSE};
    uint32_t indices[3] = {0, 1, 2};
    for (int i = 0; i < 6; i++) {
        btg_tool tool = tool_of(MAJOR, MINOR, profiles[i % 2]);
        double k = slopes[i / 2], x = 2, y = -1;
        double corners[9] = {-100, -100, 3 - 100 * k, 100, -100, 3 + 100 * k, 0, 200, 3};
        double expected = 3 + k * x + MAJOR * fabs(k) + MINOR * sqrt(1 + k * k);
        CHECK(close_to(drop(corners, indices, 1, &tool, x, y), expected));
    }
}

/* A small triangle under the ring is a point; a thin one is an edge. */
static void test_points_and_edges(void) {
    uint32_t indices[3] = {0, 1, 2};
    btg_tool tool = tool_of(MAJOR, MINOR, BTG_PROFILE_TOROIDAL);
    double spike[9] = {0, 0, 5, 1e-9, 0, 4, 0, 1e-9, 4};
    CHECK(close_to(drop(spike, indices, 1, &tool, 8, 0), 5 + sqrt(36 - 1.3 * 1.3)));
    CHECK(drop(spike, indices, 1, &tool, 0.5, 0) == -INFINITY); /* in the hollow middle */
    CHECK(drop(spike, indices, 1, &tool, 13, 0) == -INFINITY);  /* beside the tool */
    btg_tool solid = tool_of(MAJOR, MINOR, BTG_PROFILE_BULLNOSE);
    CHECK(close_to(drop(spike, indices, 1, &solid, 0.5, 0), 5 + MINOR));
    /* A level edge along y, 9 mm from the axis: nearest to the ring abeam. */
    double ridge[9] = {9, -50, 1, 9, 50, 1, 9, 0, -40};
    CHECK(close_to(drop(ridge, indices, 1, &tool, 0, 3), 1 + sqrt(36 - 2.3 * 2.3)));
    /* One through the axis, sloping: it rests where plane and ring share a slope. */
    double slope[9] = {-50, 0, -25, 50, 0, 25, 0, 0, -90};
    double expected = 0.5 * MAJOR + MINOR * sqrt(1.25);
    CHECK(close_to(drop(slope, indices, 1, &tool, 0, 0), expected));
}

/* The same along another axis. */
static void test_axis(void) {
    btg_tool tool = tool_of(MAJOR, MINOR, BTG_PROFILE_TOROIDAL);
    double corners[9] = {7, -100, -100, 7, 100, -100, 7, 0, 200};
    uint32_t indices[3] = {0, 1, 2};
    bench_mesh mesh = {corners, indices, 3, 1};
    btg_vec3 contact;
    double height = bench_brute_drop(&mesh, &tool, vec(1, 2, 3), vec(1, 0, 0), &contact);
    CHECK(close_to(height, 6 + MINOR));
    CHECK(close_to(contact.x, 7));
}

/* ---- positions made wrong ------------------------------------------------------------------ */

#define SIDE 24

static void make_dish(bench_mesh *mesh) {
    static double positions[3 * (SIDE + 1) * (SIDE + 1)];
    static uint32_t indices[6 * SIDE * SIDE];
    size_t t = 0;
    for (int i = 0; i <= SIDE; i++) {
        for (int j = 0; j <= SIDE; j++) {
            double x = 3.0 * i, y = 3.0 * j;
            double *p = positions + 3 * (i * (SIDE + 1) + j);
            p[0] = x, p[1] = y, p[2] = 0.01 * (x - 30) * (x - 30) + 0.006 * (y - 40) * (y - 40);
        }
    }
    for (uint32_t i = 0; i < SIDE * SIDE; i++) {
        uint32_t a = i / SIDE * (SIDE + 1) + i % SIDE, b = a + SIDE + 1;
        const uint32_t corners[6] = {a, b, b + 1, a, b + 1, a + 1};
        memcpy(indices + t, corners, sizeof corners);
        t += 6;
    }
    *mesh = (bench_mesh){positions, indices, (SIDE + 1) * (SIDE + 1), 2 * SIDE * SIDE};
}

typedef struct world {
    bench_mesh mesh;
    btg_part *part;
    btg_tool tool;
    btg_solver_def solver;
    btg_position position;
} world;

static world make_world(double x, double y) {
    world w = {.tool = tool_of(MAJOR, MINOR, BTG_PROFILE_TOROIDAL)};
    make_dish(&w.mesh);
    btg_mesh_def mesh = {w.mesh.positions, w.mesh.vertex_count, w.mesh.indices,
                         w.mesh.triangle_count};
    btg_part_def def = btg_part_def_default();
    def.meshes = &mesh;
    def.mesh_count = 1;
    CHECK(btg_part_create(&def, &w.part, NULL) == BTG_OK);
    w.solver = btg_solver_def_default();
    w.solver.tolerance_mm = 1e-6;
    size_t size = btg_workspace_size(w.part);
    void *workspace = malloc(size);
    CHECK(btg_position_solve(w.part, &w.tool, &w.solver, x, y, workspace, size, &w.position) >= 0);
    free(workspace);
    return w;
}

static double error_of(const world *w, const btg_position *p) {
    return bench_brute_error(&w->mesh, &w->tool, &w->solver, p).position_mm;
}

/* The whole tool turned by `turn` more about the pseudo-insert. */
static btg_position turned(const world *w, double turn) {
    btg_position p = w->position;
    btg_vec3 centre = vec(p.foot_x_mm, p.foot_y_mm, p.drop_z_mm);
    btg_vec3 v = vec_sub(centre, p.p.point), z = vec(0, 0, 1);
    v.z = 0;
    v = vec_unit(v);
    btg_vec3 o1 = vec_mad(centre, v, -MAJOR);
    p.tilt_rad += turn;
    double c = cos(p.tilt_rad), s = sin(p.tilt_rad);
    p.axis = vec_add(vec_scale(z, c), vec_scale(v, s));
    centre = vec_mad(o1, vec_sub(vec_scale(v, c), vec_scale(z, s)), MAJOR);
    p.tip = vec_mad(centre, p.axis, -MINOR);
    return p;
}

static void test_wrong(void) {
    for (int i = 0; i < 4; i++) {
        world w = make_world(20 + 11 * i, 30 + 7 * i);
        btg_position p = w.position;
        CHECK(p.status == BTG_OK || p.status == BTG_OSCULATING);
        CHECK(error_of(&w, &p) < 1e-6);
        p = turned(&w, 0);
        CHECK(error_of(&w, &p) < 1e-6);
        p = turned(&w, 1e-2); /* gouges */
        CHECK(error_of(&w, &p) > 1e-5);
        p = turned(&w, -1e-2); /* stops early */
        CHECK(error_of(&w, &p) > 1e-5);
        p = w.position;
        p.drop_z_mm += 1e-5;
        CHECK(error_of(&w, &p) > 0.9e-5);
        p = w.position;
        p.drop_z_mm -= 1e-5;
        CHECK(error_of(&w, &p) > 0.9e-5);
        p = w.position;
        p.tip.x += 1e-5;
        CHECK(error_of(&w, &p) > 0.9e-5);
        p = w.position;
        p.axis.y = NAN;
        CHECK(error_of(&w, &p) == INFINITY);
        p = w.position;
        p.drop_z_mm = NAN;
        CHECK(!(error_of(&w, &p) < 1));
        p = w.position;
        p.status = BTG_NO_CONTACT;
        CHECK(error_of(&w, &p) == INFINITY);
        p.status = BTG_SINGLE_CONTACT;
        p.tip = vec(p.foot_x_mm, p.foot_y_mm, p.drop_z_mm - MINOR);
        p.axis = vec(0, 0, 1);
        CHECK(error_of(&w, &p) > 1e-2); /* it could have tilted */
        btg_part_destroy(w.part);
    }
}

static void test_difference(void) {
    world w = make_world(30, 30);
    btg_position p = w.position, q = w.position;
    CHECK(bench_difference(&w.tool, &w.solver, &p, &q) == 0);
    CHECK(bench_identical(&p, &q));
    q.q.place.u = nextafter(q.q.place.u, 2);
    CHECK(!bench_identical(&p, &q));
    q = p;
    q.drop_z_mm += 1e-5;
    CHECK(bench_difference(&w.tool, &w.solver, &p, &q) > 0.9e-5);
    q = p;
    q.tilt_rad += 1e-3;
    CHECK(bench_difference(&w.tool, &w.solver, &p, &q) > 1e-5);
    q.tilt_rad = NAN;
    CHECK(bench_difference(&w.tool, &w.solver, &p, &q) == INFINITY);
    q.status = BTG_NO_CONTACT;
    CHECK(bench_difference(&w.tool, &w.solver, &p, &q) == INFINITY);
    btg_part_destroy(w.part);
}

/* ---- numbers ------------------------------------------------------------------------------- */

static btg_status count_units(void *user, size_t count) {
    *(size_t *)user += count;
    return *(size_t *)user > 100000000 ? BTG_ERROR_MEMORY : BTG_OK;
}

static void test_time(void) {
    double values[1001];
    for (int i = 0; i <= 1000; i++)
        values[i] = (i * 617) % 1001;
    bench_quantiles q = bench_quantiles_of(values, 1001);
    CHECK(q.p50 == 500 && q.p99 == 990 && q.p999 == 999 && q.max == 1000);
    double one = 3;
    q = bench_quantiles_of(&one, 1);
    CHECK(q.p50 == 3 && q.max == 3);
    CHECK(isnan(bench_quantiles_of(NULL, 0).max));
    size_t done = 100000001;
    bench_rate rate;
    CHECK(bench_time(count_units, &done, 1e-6, 3, &rate) == BTG_ERROR_MEMORY);
    done = 0;
    CHECK(bench_time(count_units, &done, 1e-7, 3, &rate) == BTG_OK);
    CHECK(rate.processors >= 0);
    CHECK(rate.runs == 3 && rate.count > 0 && done > 3 * rate.count);
    CHECK(rate.min <= rate.median && rate.median <= rate.max && rate.seconds > 0);
}

int main(void) {
    test_plane();
    test_points_and_edges();
    test_axis();
    test_wrong();
    test_difference();
    test_time();
    return check_result();
}
