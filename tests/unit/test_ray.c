/* Rays in closed form against the tool itself: marching, signs on both sides, limits. */
#include "check.h"
#include "core/ray.h"

#include "../conformance/rng.h"

#include <string.h>

static const struct {
    double major, minor;
    btg_profile profile;
    int cylinders;
} kinds[] = {
    {6.7, 6, BTG_PROFILE_TOROIDAL, 0}, {2, 5, BTG_PROFILE_TOROIDAL, 0},
    {10, 3, BTG_PROFILE_TOROIDAL, 2},  {0, 6, BTG_PROFILE_TOROIDAL, 1},
    {6.7, 6, BTG_PROFILE_BULLNOSE, 0}, {8, 1, BTG_PROFILE_BULLNOSE, 2},
};
#define KINDS (int)(sizeof kinds / sizeof *kinds)

static btg_tool make_tool(int kind) {
    btg_tool_def def = btg_tool_def_default();
    def.major_radius_mm = kinds[kind].major;
    def.minor_radius_mm = kinds[kind].minor;
    def.profile = kinds[kind].profile;
    double outer = def.major_radius_mm + def.minor_radius_mm;
    if (kinds[kind].cylinders > 0) def.shank = (btg_cylinder){0.8 * outer, 3, 30};
    if (kinds[kind].cylinders > 1) {
        def.holder_count = 1;
        def.holder[0] = (btg_cylinder){1.5 * outer, 12, 50};
    }
    btg_tool tool;
    CHECK(btg_tool_init(&def, &tool, NULL) == BTG_OK);
    return tool;
}

/* Signed distance to the tool, by its definition. */
static double distance(const btg_tool *tool, btg_vec3 centre, btg_vec3 axis, btg_vec3 s) {
    btg_vec3 d = vec_sub(s, centre);
    double z = vec_dot(d, axis), r = vec_norm(vec_mad(d, axis, -z));
    double across = r - tool->def.major_radius_mm;
    double least = hypot(across, z) - tool->def.minor_radius_mm;
    if (tool->def.profile == BTG_PROFILE_BULLNOSE && across < 0)
        least = fabs(z) - tool->def.minor_radius_mm;
    for (int i = -1; i < (int)tool->def.holder_count; i++) {
        btg_cylinder c = i < 0 ? tool->def.shank : tool->def.holder[i];
        if (c.radius_mm == 0) continue;
        double x = r - c.radius_mm, y = fmax(c.from_mm - z, z - c.to_mm);
        least = fmin(least, x > 0 && y > 0 ? hypot(x, y) : fmax(x, y));
    }
    return least;
}

static btg_vec3 random_unit(rng *r) {
    for (;;) {
        btg_vec3 a = vec(rng_range(r, -1, 1), rng_range(r, -1, 1), rng_range(r, -1, 1));
        double n = vec_norm(a);
        if (n > 0.1 && n < 1) return vec_scale(a, 1 / n);
    }
}

/* ---- DROP --------------------------------------------------------------------------------- */

static void check_vertical(rng *r, int kind) {
    btg_tool tool = make_tool(kind);
    btg_drop_query query = {.origin =
                                vec(rng_range(r, -9, 9), rng_range(r, -9, 9), rng_range(r, -9, 9)),
                            .axis = random_unit(r)};
    btg_ray_query q = btg_ray_query_drop(&tool, &query);
    btg_vec3 side = vec_perpendicular(query.axis);
    btg_vec3 s = vec_mad(query.origin, side, rng_range(r, -30, 30));
    s = vec_mad(s, vec_cross(query.axis, side), rng_range(r, -12, 12));
    s = vec_mad(s, query.axis, rng_range(r, -20, 20));
    double height = vec_dot(vec_sub(s, query.origin), query.axis);
    btg_ray_hit hit;
    bool met = btg_ray_cast(&q, s, &hit);
    double from = height + 30, to = met ? hit.value + 1e-7 : height - 60;
    for (int i = 0; i <= 2000; i++) {
        double h = from + (to - from) * i / 2000;
        CHECK(distance(&tool, vec_mad(query.origin, query.axis, h), query.axis, s) > 0);
    }
    if (!met) return;
    btg_vec3 at = vec_mad(query.origin, query.axis, hit.value);
    CHECK_NEAR(distance(&tool, at, query.axis, s), 0, 1e-9);
    at = vec_mad(at, query.axis, -1e-6);
    CHECK(distance(&tool, at, query.axis, s) < 0);
}

/* ---- TILT --------------------------------------------------------------------------------- */

static btg_tilt_query random_frame(rng *r, const btg_tool *tool) {
    btg_tilt_query t;
    memset(&t, 0, sizeof t);
    t.w = random_unit(r);
    t.v = vec_perpendicular(t.w);
    t.u = vec_cross(t.v, t.w);
    t.o1 = vec(rng_range(r, -9, 9), rng_range(r, -9, 9), rng_range(r, -9, 9));
    double lean = rng_range(r, 0, 1.2);
    t.p.normal = vec_add(vec_scale(t.w, cos(lean)), vec_scale(t.v, sin(lean)));
    t.p.point = vec_mad(t.o1, t.p.normal, -tool->def.minor_radius_mm);
    t.max_tilt_rad = BTG_PI / 2;
    return t;
}

static double turned_distance(const btg_tool *tool, const btg_tilt_query *t, double beta,
                              btg_vec3 s) {
    btg_vec3 v = vec_mad(vec_scale(t->v, cos(beta)), t->w, -sin(beta));
    btg_vec3 w = vec_mad(vec_scale(t->w, cos(beta)), t->v, sin(beta));
    return distance(tool, vec_mad(t->o1, v, tool->def.major_radius_mm), w, s);
}

static void check_circular(rng *r, int kind) {
    btg_tool tool = make_tool(kind);
    btg_tilt_query query = random_frame(r, &tool);
    btg_ray_query q = btg_ray_query_tilt(&tool, &query);
    double reach = 2 * tool.def.major_radius_mm + tool.def.minor_radius_mm + 8;
    btg_vec3 s = vec_mad(query.o1, query.u, rng_range(r, -1, 1) * reach);
    s = vec_mad(s, query.v, rng_range(r, -0.6, 1.2) * reach);
    s = vec_mad(s, query.w, rng_range(r, -2, 0.3) * reach);
    if (!(turned_distance(&tool, &query, 0, s) > 1e-3)) return;
    btg_ray_hit hit;
    bool met = btg_ray_cast(&q, s, &hit) && hit.value > -2.5;
    double to = met ? -hit.value - 1e-7 : 2.5;
    CHECK(!met || hit.value < 0);
    for (int i = 0; i <= 2000; i++)
        CHECK(turned_distance(&tool, &query, to * i / 2000, s) > 0);
    if (!met) return;
    CHECK_NEAR(turned_distance(&tool, &query, -hit.value, s), 0, 1e-9);
    btg_placement place = btg_ray_place(&q, hit.value);
    CHECK_NEAR(distance(&tool, place.centre, place.axis, s), 0, 1e-9);
    CHECK_NEAR(btg_tool_distance(&tool, place.centre, place.axis, s), 0, 1e-9);
}

/* Points just inside the start pose have a small positive value: that far to turn back. */
static void check_inside(rng *r) {
    btg_tool tool = make_tool(0);
    btg_tilt_query query = random_frame(r, &tool);
    btg_ray_query q = btg_ray_query_tilt(&tool, &query);
    double around = rng_range(r, 0.5, 2 * BTG_PI - 0.5), theta = rng_range(r, -2.5, -0.6);
    double ring = 6.7 + (6 - 1e-4) * cos(theta);
    btg_vec3 centre = vec_mad(query.o1, query.v, 6.7);
    btg_vec3 s = vec_mad(centre, query.v, -ring * cos(around));
    s = vec_mad(s, query.u, ring * sin(around));
    s = vec_mad(s, query.w, (6 - 1e-4) * sin(theta));
    btg_ray_hit hit;
    if (turned_distance(&tool, &query, 0, s) > -9e-5) return;
    CHECK(btg_ray_cast(&q, s, &hit) && hit.value > 0);
    if (hit.value < 1) CHECK_NEAR(turned_distance(&tool, &query, -hit.value, s), 0, 1e-9);
}

/* ---- limits at P -------------------------------------------------------------------------- */

/* A point at distance t of P in direction phi of the sheet. */
static btg_vec3 sheet_point(const btg_surface_point *f, btg_vec3 p, double a, double b) {
    btg_vec3 s = vec_mad(vec_mad(p, f->su, a), f->sv, b);
    s = vec_mad(vec_mad(s, f->suu, 0.5 * a * a), f->svv, 0.5 * b * b);
    return vec_mad(s, f->suv, a * b);
}

static btg_vec3 tangent(rng *r, const btg_ray_query *q) {
    btg_vec3 y = vec_cross(q->u, q->n);
    double a = rng_range(r, -1, 1), b = rng_range(r, -1, 1); /* in this order everywhere */
    return vec_add(vec_scale(q->u, a), vec_scale(y, b));
}

static btg_vec3 bend(rng *r, const btg_ray_query *q) {
    btg_vec3 along = vec_scale(tangent(r, q), 0.1);
    return vec_mad(along, q->n, rng_range(r, -0.1, 0.12));
}

/* 2e-3 mm from P, mm: a fifth of what a plane is. Nearer to no contact at all the value bends too
 * much to be carried on to P from there. */
#define CLEAR_OF_SPHERE 7e-8

/* The value at small distances, carried on to distance 0. */
static double near_value(btg_ray_query q, const btg_surface_point *f, double a, double b) {
    double value[2];
    q.p_clearance2 = 0;
    for (int i = 0; i < 2; i++) {
        double t = i ? 1e-3 : 2e-3;
        btg_ray_hit hit;
        if (!btg_ray_cast(&q, sheet_point(f, q.p, a * t, b * t), &hit)) return -INFINITY;
        value[i] = hit.value;
    }
    return 2 * value[1] - value[0];
}

static void check_osculating_face(rng *r) {
    btg_tool tool = make_tool(rng_pick(r, 3));
    btg_tilt_query query = random_frame(r, &tool);
    btg_ray_query q = btg_ray_query_tilt(&tool, &query);
    btg_surface_point f = {.su = tangent(r, &q), .sv = tangent(r, &q)};
    if (vec_norm(vec_cross(f.su, f.sv)) < 0.3) return;
    f.suu = bend(r, &q);
    f.suv = bend(r, &q);
    f.svv = bend(r, &q);
    double best = -INFINITY, value;
    for (int i = 0; i < 4000; i++) {
        double phi = BTG_PI * i / 4000;
        /* outside the insert's sphere only: else P is no contact */
        btg_vec3 s = sheet_point(&f, q.p, 2e-3 * cos(phi), 2e-3 * sin(phi));
        btg_vec3 away = vec_sub(s, q.o);
        if (vec_norm(away) < tool.def.minor_radius_mm + CLEAR_OF_SPHERE) return;
        best = fmax(best, near_value(q, &f, cos(phi), sin(phi)));
    }
    bool found = btg_ray_osculating(&q, &f, false, false, &value);
    if (!found) {
        CHECK(!(best > -1.5));
        return;
    }
    /* the limit is an arc sine: at its end a direction off by 4e-4 shows as its square root */
    if (fabs(sin(value + q.inclination)) > 0.98) return;
    if (best > -1.5 || value > -1.5) CHECK_NEAR(value, best, 2e-4);
}

static void check_osculating_edge(rng *r) {
    btg_tool tool = make_tool(rng_pick(r, 3));
    btg_tilt_query query = random_frame(r, &tool);
    btg_ray_query q = btg_ray_query_tilt(&tool, &query);
    btg_surface_point f = {.su = tangent(r, &q), .sv = vec_scale(q.n, -1), .suu = bend(r, &q)};
    f.sv = vec_add(f.sv, tangent(r, &q));
    if (vec_norm(f.su) < 0.3) return;
    btg_vec3 s = sheet_point(&f, q.p, 2e-3, 0);
    if (vec_norm(vec_sub(s, q.o)) < tool.def.minor_radius_mm + CLEAR_OF_SPHERE) return;
    double best = fmax(near_value(q, &f, 1, 0), near_value(q, &f, -1, 0)), value;
    bool found = btg_ray_osculating(&q, &f, false, true, &value);
    if (!found)
        CHECK(!(best > -1.5));
    else if (best > -1.5 || value > -1.5)
        CHECK_NEAR(value, best, 2e-4);
    CHECK(!btg_ray_osculating(&q, &f, false, false, &value));
}

/* ---- distance ----------------------------------------------------------------------------- */

static void check_distance(rng *r, int kind) {
    btg_tool tool = make_tool(kind);
    btg_placement at = {vec(1, 2, 3), random_unit(r), false};
    btg_vec3 s = vec_mad(at.centre, random_unit(r), rng_range(r, 1, 40));
    CHECK_NEAR(btg_tool_distance(&tool, at.centre, at.axis, s),
               distance(&tool, at.centre, at.axis, s), 1e-12);
    const btg_tool_element *e = &tool.element[0];
    btg_vec3 d = vec_sub(s, at.centre);
    double z = vec_dot(d, at.axis), across = vec_norm(vec_mad(d, at.axis, -z)) - e->ring_radius_mm;
    if (z > -0.2 || fabs(across) < 0.2) return;
    btg_ray_distance got = btg_ray_tool_distance(e, at, s);
    CHECK_NEAR(vec_norm(got.normal), 1, 1e-12);
    const btg_vec3 along[3] = {got.normal, got.ring_tangent, got.meridian_tangent};
    const double slope[3] = {1, 0, 0};
    const double bending[3] = {0, got.ring_curvature, got.meridian_curvature};
    const double h = 1e-3;
    for (int i = 0; i < 3; i++) {
        double high = btg_ray_tool_distance(e, at, vec_mad(s, along[i], h)).distance;
        double low = btg_ray_tool_distance(e, at, vec_mad(s, along[i], -h)).distance;
        CHECK_NEAR((high - low) / (2 * h), slope[i], 1e-5);
        /* the difference leaves h^2 / 12 of the fourth derivative, 3 k^3 for a circle, and rounding
         */
        double limit = 1e-7 + h * h * pow(fabs(bending[i]), 3);
        CHECK_NEAR((high - 2 * got.distance + low) / (h * h), bending[i], fmax(limit, 1e-5));
    }
}

int main(void) {
    rng r = {5};
    for (int i = 0; i < 6000; i++) {
        check_vertical(&r, i % KINDS);
        check_circular(&r, i % KINDS);
        check_inside(&r);
        check_distance(&r, i % KINDS);
    }
    for (int i = 0; i < 400; i++) {
        check_osculating_face(&r);
        check_osculating_edge(&r);
    }
    return check_result();
}
