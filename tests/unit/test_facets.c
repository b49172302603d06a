/* Facets against paraboloids whose heights, slopes and area are closed form, and what holds of
 * them on any part. */
#include "check.h"
#include "core/facets.h"

#include "hard_parts.h"

#include <math.h>

#define SIDE   60.0
#define RADIUS 80.0

/* z = (x^2 + sign y^2) / (2 RADIUS) over 0 .. SIDE in both, as a biquadratic patch. */
static void paraboloid(double sign, double points[27]) {
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            double *p = points + 3 * (3 * i + k);
            double xx = i < 2 ? 0 : SIDE * SIDE, yy = k < 2 ? 0 : SIDE * SIDE;
            p[0] = SIDE * i / 2;
            p[1] = SIDE * k / 2;
            p[2] = (xx + sign * yy) / (2 * RADIUS);
        }
}

static btg_part *paraboloid_part(double sign) {
    double points[27];
    paraboloid(sign, points);
    btg_surface_def surface = {2, 2, 3, 3, points, NULL, NULL, NULL};
    btg_part_def def = btg_part_def_default();
    def.surfaces = &surface;
    def.surface_count = 1;
    btg_part *part = NULL;
    CHECK(btg_part_create(&def, &part, NULL) == BTG_OK);
    return part;
}

static double height(btg_vec3 p, double sign) {
    return (p.x * p.x + sign * p.y * p.y) / (2 * RADIUS);
}

/* Heights, normals, and the area seen from above. */
static void check_paraboloid(double sign, double chord) {
    btg_part *part = paraboloid_part(sign);
    btg_facets f;
    btg_facets_def def = {.chord_mm = chord};
    CHECK(btg_facets_make(part, &def, &f, NULL) == BTG_OK);
    double farthest = 0, area = 0;
    for (size_t i = 0; i < f.vertex_count; i++) {
        btg_vec3 p = f.points[i], n = f.normals[i];
        btg_vec3 want = vec_unit(vec(-p.x / RADIUS, -sign * p.y / RADIUS, 1));
        CHECK_NEAR(p.z, height(p, sign), 1e-11);
        CHECK_NEAR(fabs(vec_dot(n, want)), 1, 1e-12);
    }
    for (size_t t = 0; t < f.triangle_count; t++) {
        btg_vec3 a = f.points[f.triangles[t][0]], b = f.points[f.triangles[t][1]];
        btg_vec3 c = f.points[f.triangles[t][2]], n = vec_cross(vec_sub(b, a), vec_sub(c, a));
        const double weight[4][3] = {
            {1.0 / 3, 1.0 / 3, 1.0 / 3}, {0.5, 0.5, 0}, {0, 0.5, 0.5}, {0.5, 0, 0.5}};
        area += 0.5 * n.z;
        for (int k = 0; k < 4; k++) {
            btg_vec3 p = vec_scale(a, weight[k][0]);
            p = vec_mad(vec_mad(p, b, weight[k][1]), c, weight[k][2]);
            farthest = fmax(farthest, fabs(p.z - height(p, sign)));
        }
    }
    CHECK_NEAR(fabs(area), SIDE * SIDE, 1e-8);
    CHECK(farthest <= chord);
    /* Not finer than the chord asks for by more than its shares: a half in each direction. */
    if (f.triangle_count > 2 * 4 * 4) CHECK(farthest >= 0.1 * chord);
    btg_facets_free(&f);
    btg_part_destroy(part);
}

/* Normals are unit and vertices exist, whatever the part. */
static void check_sound(const btg_part *part, size_t least) {
    btg_part_info info;
    btg_facets f;
    btg_facets_def def = {.chord_mm = 0.05};
    btg_part_get_info(part, &info);
    CHECK(btg_facets_make(part, &def, &f, NULL) == BTG_OK);
    CHECK(f.triangle_count >= least);
    double slack = 1e-5 * (info.box_max.x - info.box_min.x + 1);
    for (size_t i = 0; i < f.vertex_count; i++) {
        btg_vec3 p = f.points[i];
        CHECK_NEAR(vec_norm(f.normals[i]), 1, 1e-12);
        CHECK(p.x >= info.box_min.x - slack && p.x <= info.box_max.x + slack);
        CHECK(p.z >= info.box_min.z - slack && p.z <= info.box_max.z + slack);
    }
    for (size_t t = 0; t < f.triangle_count; t++)
        for (int k = 0; k < 3; k++)
            CHECK(f.triangles[t][k] < f.vertex_count);
    btg_facets_free(&f);
}

static void test_any_part(void) {
    rng r = {7};
    for (int kind = 0; kind < HARD_PATCHES; kind++) {
        model m = {0};
        hard_add_patch(&m, &r, (hard_patch)kind, 40);
        btg_part *part = model_part(&m);
        check_sound(part, 2);
        btg_part_destroy(part);
        model_free(&m);
    }
    for (int kind = 0; kind < HARD_MESHES; kind++) {
        model m = {0};
        hard_add_mesh(&m, &r, (hard_mesh)kind, 40);
        btg_part *part = model_part(&m);
        btg_part_info info;
        btg_part_get_info(part, &info);
        check_sound(part, info.triangle_count);
        btg_part_destroy(part);
        model_free(&m);
    }
}

static void test_refusals(const btg_part *part) {
    static const double chords[] = {0, -1, NAN, INFINITY};
    btg_facets f = {.vertex_count = 77};
    btg_message message;
    for (int i = 0; i < 4; i++) {
        btg_facets_def def = {.chord_mm = chords[i]};
        CHECK(btg_facets_make(part, &def, &f, &message) == BTG_ERROR_ARGUMENT);
    }
    btg_facets_def def = {.chord_mm = 0.001, .triangles_max = 100};
    CHECK(btg_facets_make(part, &def, &f, &message) == BTG_ERROR_MEMORY);
    CHECK(f.vertex_count == 77);
}

int main(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        check_paraboloid(sign, 0.5);
        check_paraboloid(sign, 0.02);
        check_paraboloid(sign, 0.003);
    }
    test_any_part();
    btg_part *part = paraboloid_part(1);
    test_refusals(part);
    btg_part_destroy(part);
    return check_result();
}
