/* Basins: no point of a contact's neighbourhood, as far as it is said to reach (core/basin.c), is
 * deeper in the tool than that says. The tool is laid onto random surfaces any way round, as near
 * to osculating as may be: where it gouges there is no basin. */
#include "check.h"
#include "core/search.h"
#include "hard_parts.h"

#include <stdlib.h>

#define ROUNDS   400
#define CONTACTS 12 /* of a part */
#define SAMPLES  300
#define SIZE     60.0
/* Rounding of the test's own points, mm. */
#define ROUNDING 1e-12

static long basins, none, points;
static double closest; /* depth, part of what is said */
static double widest;

/* Parameters of a step x along the surface. */
static void parameters_of(const btg_surface_point *s, btg_vec3 x, double p[2]) {
    double uu = vec_norm2(s->su), uv = vec_dot(s->su, s->sv), vv = vec_norm2(s->sv);
    double u = vec_dot(s->su, x), v = vec_dot(s->sv, x), det = uu * vv - uv * uv;
    p[0] = (vv * u - uv * v) / det;
    p[1] = (uu * v - uv * u) / det;
}

/* The surface's second form towards g. */
static double second_form(const btg_surface_point *s, btg_vec3 g, const double x[2],
                          const double y[2]) {
    double uu = vec_dot(g, s->suu), uv = vec_dot(g, s->suv), vv = vec_dot(g, s->svv);
    return uu * x[0] * y[0] + uv * (x[0] * y[1] + x[1] * y[0]) + vv * x[1] * y[1];
}

/* How much of the gradient leads away from the axis, so that the ring along t leaves the surface
 * with no more than some curvature. */
static double slant(const btg_tool_element *e, const btg_surface_point *s, btg_vec3 g, btg_vec3 t,
                    rng *r) {
    double along[2], across[2], ri = e->corner_radius_mm;
    parameters_of(s, t, along);
    parameters_of(s, vec_cross(g, t), across);
    double mixed = second_form(s, g, along, across);
    double k = mixed * mixed / (second_form(s, g, across, across) + 1 / ri);
    k += pow(10, rng_range(r, -6, -1)) - second_form(s, g, along, along);
    double n_r = k * e->ring_radius_mm / (1 - k * ri);
    bool can = fabs(n_r) < 1 && (n_r >= 0 || (e->hollow && e->ring_radius_mm + ri * n_r > 0));
    return can ? n_r : rng_range(r, e->hollow ? -1 : 0, 1);
}

/* The tool touches the surface from one of its sides, most often next to osculating. */
static btg_placement lay(const btg_tool_element *e, const btg_surface_point *s, rng *r) {
    btg_vec3 g = vec_unit(vec_cross(s->su, s->sv));
    if (rng_range(r, 0, 1) < 0.5) g = vec_scale(g, -1);
    btg_vec3 t = vec_unit(vec_cross(hard_unit(r), g)), m = vec_cross(g, t);
    double n_r = slant(e, s, g, t, r), n_z = -sqrt(1 - n_r * n_r);
    btg_vec3 radial = vec_mad(vec_scale(g, n_r), m, -n_z),
             axis = vec_mad(vec_scale(g, n_z), m, n_r);
    btg_vec3 ring = vec_mad(s->s, g, -e->corner_radius_mm);
    return (btg_placement){vec_mad(ring, radial, -e->ring_radius_mm), axis, false};
}

/* Both ends of a parameter stand for themselves now and then. */
static double parameter(rng *r) {
    double t = rng_range(r, -0.1, 1.1);
    return t < 0 ? 0 : t > 1 ? 1 : t;
}

static void check_points(const btg_search *search, const btg_tool_element *e, const btg_basin *b,
                         rng *r) {
    for (int i = 0; i < SAMPLES; i++) {
        double turn = rng_range(r, 0, 2 * BTG_PI), reach = b->reach;
        if (i % 2) reach *= sqrt(rng_range(r, 0, 1));
        btg_place at = {b->place.item, b->place.u + reach * cos(turn) / b->speed_u,
                        b->place.v + reach * sin(turn) / b->speed_v};
        if (at.u < 0 || at.u > 1 || at.v < 0 || at.v > 1) continue;
        btg_surface_point s;
        btg_part_point(search->part, at, &s);
        double depth = -btg_ray_tool_distance(e, search->at, s.s).distance;
        points++;
        closest = max2(closest, depth / b->deep);
        if (!(depth <= b->deep + ROUNDING))
            fprintf(stderr, "reach %g: %g deep, said %g, ring %g corner %g hollow %d\n", b->reach,
                    depth, b->deep, e->ring_radius_mm, e->corner_radius_mm, e->hollow);
        CHECK(depth <= b->deep + ROUNDING);
    }
}

static void check_contact(const btg_part *part, const btg_tool *tool, rng *r) {
    static btg_search search;
    const btg_tool_element *e = &tool->element[0];
    uint32_t item = (uint32_t)rng_range(r, 0, part->patch_count - 1e-9);
    btg_place place = {item, 0, 0};
    place.u = parameter(r);
    place.v = parameter(r);
    btg_surface_point s;
    btg_part_point(part, place, &s);
    if (!(vec_norm(vec_cross(s.su, s.sv)) > 1e-6)) return;
    btg_drop_query query = btg_position_drop_query(0, 0);
    search = (btg_search){.part = part, .query = btg_ray_query_drop(tool, &query)};
    search.tolerance = pow(10, rng_range(r, -7, -3));
    search.at = lay(e, &s, r);
    if (fabs(btg_ray_tool_distance(e, search.at, s.s).distance) > 1e-9) return; /* over the axis */
    btg_basin b;
    btg_basin_make(&search, place, 0, &b);
    if (!(b.reach > 0)) {
        none++;
        return;
    }
    basins++;
    widest = max2(widest, b.reach);
    CHECK(b.deep >= 0 && b.deep <= search.tolerance);
    check_points(&search, e, &b, r);
}

int main(void) {
    rng r = {20260614};
    for (int round = hard_rounds(ROUNDS); round > 0; round--) {
        model m = {0};
        hard_patch kind = (hard_patch)(round % 3 ? HARD_SMOOTH : round / 3 % HARD_PATCHES);
        hard_add_patch(&m, &r, kind, SIZE);
        btg_part *part = model_part(&m);
        for (int i = 0; i < CONTACTS; i++) {
            btg_tool tool = hard_tool((round + i) % HARD_CUTTERS);
            check_contact(part, &tool, &r);
        }
        btg_part_destroy(part);
        model_free(&m);
    }
    fprintf(stderr,
            "%ld basins, %ld contacts without, %ld points; the deepest %.3g of what is said; reach "
            "%.3g at the most\n",
            basins, none, points, closest, widest);
    CHECK(basins > 5 * hard_rounds(ROUNDS) / 4 && none > basins / 10);
    return check_result();
}
