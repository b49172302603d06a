/* Spheres, cylinders, cones and tori as rational patches: all answers by hand.
 *
 * The tool is the set of points within Ri of its major circle (of its disc, when closed). It
 * touches a sphere of radius R about C where that circle comes within R + Ri of C, so the answers
 * are distances of a circle to a point, a line or another circle. */
#include "conformance.h"
#include "shapes.h"

#include <stddef.h>

#define ALPHA 1.3 /* polar angle of a cap's rim */

typedef struct cutter {
    double ro, ri;
    bool closed;
} cutter;

static cutter cutter_of(const fixture *f) {
    const btg_tool_def *d = &f->tool.def;
    return (cutter){d->major_radius_mm, d->minor_radius_mm, d->profile == BTG_PROFILE_BULLNOSE};
}

static want leaning(double value, double lever) {
    want w = known(value);
    w.lever = lever;
    return w;
}

static void add_cap(fixture *f, btg_vec3 centre, double radius, double sign) {
    const double profile[3][3] = {{0, sign * radius, 1},
                                  {radius * tan(ALPHA / 2), sign * radius, cos(ALPHA / 2)},
                                  {radius * sin(ALPHA), sign * radius * cos(ALPHA), 1}};
    model_revolve(&f->model, centre, profile, 3);
}

static void ask_around(fixture *f, rng *r, btg_vec3 centre, double e, want w) {
    double angle = rng_range(r, -BTG_PI, BTG_PI);
    fixture_foot(f, centre.x + e * cos(angle), centre.y + e * sin(angle), w);
}

static btg_vec3 random_centre(rng *r) {
    return vec(rng_range(r, -50, 50), rng_range(r, -50, 50), rng_range(r, -50, 50));
}

/* Drop at distance e: Tc_z = C_z + sqrt((R + Ri)^2 - gap^2), gap = | e - Ro | (0 over the disc).
 * Tilt: the circle stays outside the sphere of radius R + Ri about C, on which O1 lies, exactly
 * while sin(lambda) >= -Ro / (R + Ri), and then lies in it as a whole; at the drop
 * sin(lambda) = (e - Ro) / (R + Ri). A disc ends the tilt at lambda = 0 before. */
static void sphere(fixture *f, rng *r, int round) {
    shape_tool(f, round);
    cutter t = cutter_of(f);
    double radius = rng_range(r, 30, 80), all = radius + t.ri;
    btg_vec3 c = random_centre(r);
    add_cap(f, c, radius, 1);
    fixture_part(f);
    for (int i = 0; i < 8; i++) {
        double e = rng_range(r, 0, 0.5 * radius), gap = shape_gap(f, e);
        double z = sqrt(all * all - gap * gap);
        want w = leaning(c.z + z, z / all);
        if (f->op == BTG_OP_TILT)
            w = leaning(asin((e - t.ro) / all) + (t.closed ? 0 : asin(t.ro / all)), t.ro);
        ask_around(f, r, c, e, w);
    }
}

/* Inside: Tc_z = C_z - sqrt((R - Ri)^2 - (Ro + e)^2); sin(lambda) from (Ro + e) / (R - Ri) at the
 * drop down to Ro / (R - Ri). */
static void bowl(fixture *f, rng *r, int round) {
    shape_tool(f, round);
    cutter t = cutter_of(f);
    double radius = rng_range(r, 3, 6) * (t.ro + t.ri), all = radius - t.ri;
    btg_vec3 c = random_centre(r);
    add_cap(f, c, radius, -1);
    fixture_part(f);
    for (int i = 0; i < 8; i++) {
        double e = rng_range(r, 0.01, 0.2) * radius;
        double z = sqrt(all * all - (t.ro + e) * (t.ro + e));
        want w = leaning(c.z - z, z / all);
        if (f->op == BTG_OP_TILT) w = leaning(asin((t.ro + e) / all) - asin(t.ro / all), t.ro);
        ask_around(f, r, c, e, w);
    }
}

/* A half pipe along x through the origin, sign 1: a ridge, -1: a trough. */
static void add_pipe(fixture *f, double radius, double sign, const motion *t) {
    model_surface s = model_bezier(&f->model, 2, 1, true);
    double w = cos(ALPHA), high = sign * radius;
    for (int j = 0; j < 2; j++) {
        double x = j ? 120 : -120;
        shape_put(&s, j, vec(x, -radius * sin(ALPHA), high * w));
        shape_put(&s, 2 + j, vec(x, 0, high / w));
        shape_put(&s, 4 + j, vec(x, radius * sin(ALPHA), high * w));
        s.weights[2 + j] = w;
    }
    model_move(&f->model, t);
    fixture_part(f);
}

/* Ridge: the circle crosses the crest while e <= Ro; beyond, its nearest point is e - Ro away.
 * There it tilts until the axis is the normal: along the ridge nothing bends. */
static void ridge(fixture *f, rng *r, int round) {
    shape_tool(f, round);
    cutter t = cutter_of(f);
    double radius = rng_range(r, 30, 60), all = radius + t.ri;
    motion m = {.angle = rng_range(r, -BTG_PI, BTG_PI), .scale = 1, .shift = random_centre(r)};
    add_pipe(f, radius, 1, &m);
    for (int i = 0; i < 8; i++) {
        double e = t.ro * (f->op == BTG_OP_TILT ? 1 : 0) + rng_range(r, 0.1, 20);
        double gap = fmax(0, e - t.ro), z = sqrt(all * all - gap * gap);
        want w = leaning(m.shift.z + z, z / all);
        if (f->op == BTG_OP_TILT) w = leaning(asin(gap / all), t.ro);
        btg_vec3 foot = motion_point(&m, vec(rng_range(r, -40, 40), i % 2 ? e : -e, 0));
        fixture_foot(f, foot.x, foot.y, w);
    }
}

/* Trough: as in the bowl; the far end of the circle meets the other side. */
static void trough(fixture *f, rng *r, int round) {
    shape_tool(f, round);
    cutter t = cutter_of(f);
    double radius = rng_range(r, 3, 6) * (t.ro + t.ri), all = radius - t.ri;
    motion m = {.angle = rng_range(r, -BTG_PI, BTG_PI), .scale = 1, .shift = random_centre(r)};
    add_pipe(f, radius, -1, &m);
    for (int i = 0; i < 8; i++) {
        double e = rng_range(r, 0.01, 0.2) * radius;
        double z = sqrt(all * all - (t.ro + e) * (t.ro + e));
        want w = leaning(m.shift.z - z, z / all);
        if (f->op == BTG_OP_TILT) w = leaning(asin((t.ro + e) / all) - asin(t.ro / all), t.ro);
        btg_vec3 foot = motion_point(&m, vec(rng_range(r, -40, 40), i % 2 ? e : -e, 0));
        fixture_foot(f, foot.x, foot.y, w);
    }
}

/* Cone of slope phi, moved outward by Ri: a cone again, and a ball about the apex for
 * gap < Ri sin(phi). */
static void cone(fixture *f, rng *r, int round) {
    shape_tool(f, round);
    cutter t = cutter_of(f);
    double phi = rng_range(r, 0.2, 1.2);
    btg_vec3 c = random_centre(r);
    const double profile[2][3] = {{0, 0, 1}, {90, -90 * tan(phi), 1}};
    model_revolve(&f->model, c, profile, 2);
    fixture_part(f);
    for (int i = 0; i < 8; i++) {
        double e = rng_range(r, 0, 30), gap = shape_gap(f, e);
        want w = leaning(c.z + t.ri / cos(phi) - tan(phi) * gap, cos(phi));
        if (gap < t.ri * sin(phi)) {
            double z = sqrt(t.ri * t.ri - gap * gap);
            w = leaning(c.z + z, z / t.ri);
        }
        ask_around(f, r, c, e, w);
    }
}

/* Ring of radii A, B: two level circles, of radii A and Ro, e apart, cross or come this close. */
static void torus(fixture *f, rng *r, int round) {
    shape_tool(f, round);
    cutter t = cutter_of(f);
    double a = rng_range(r, 15, 30), b = rng_range(r, 4, 10), all = b + t.ri;
    const double k = sqrt(0.5);
    btg_vec3 c = random_centre(r);
    const double inner[3][3] = {{a - b, 0, 1}, {a - b, b, k}, {a, b, 1}};
    const double outer[3][3] = {{a, b, 1}, {a + b, b, k}, {a + b, 0, 1}};
    model_revolve(&f->model, c, inner, 3);
    model_revolve(&f->model, c, outer, 3);
    fixture_part(f);
    for (int i = 0; i < 12; i++) {
        double e = rng_range(r, 0, a + t.ro + all);
        double gap = fmax(0, fmax(e - a - t.ro, a - t.ro - e));
        if (!t.closed) gap = fmax(gap, t.ro - a - e);
        if (gap > 0.95 * all) continue;
        double z = sqrt(all * all - gap * gap);
        ask_around(f, r, c, e, leaning(c.z + z, z / all));
    }
}

#define CHECKS (CHECK_VALUE | CHECK_CLEAR | CHECK_TOUCH | CHECK_TIGHT)
#define ROUNDS SHAPE_TOOLS

static const test_case cases[] = {
    {"round-sphere-drop", BTG_OP_DROP, TOLERANCE_F64, CHECKS, ROUNDS, "collapsed edge at the pole",
     sphere},
    {"round-bowl-drop", BTG_OP_DROP, TOLERANCE_F64, CHECKS, ROUNDS, "contact at the far side",
     bowl},
    {"round-ridge-drop", BTG_OP_DROP, TOLERANCE_F64, CHECKS, ROUNDS, "two equal contacts", ridge},
    {"round-trough-drop", BTG_OP_DROP, TOLERANCE_F64, CHECKS, ROUNDS, "one straight direction",
     trough},
    {"round-cone-drop", BTG_OP_DROP, TOLERANCE_F64, CHECKS, ROUNDS, "apex and sides", cone},
    {"round-torus-drop", BTG_OP_DROP, TOLERANCE_F64, CHECKS, ROUNDS, "circle on circle", torus},
    {"round-sphere-tilt", BTG_OP_TILT, TOLERANCE_F64, CHECKS, ROUNDS, "the whole ring at once",
     sphere},
    {"round-bowl-tilt", BTG_OP_TILT, TOLERANCE_F64, CHECKS, ROUNDS, "the whole ring at once", bowl},
    {"round-ridge-tilt", BTG_OP_TILT, TOLERANCE_F64, CHECKS, ROUNDS, "osculating: lambda = 0",
     ridge},
    {"round-trough-tilt", BTG_OP_TILT, TOLERANCE_F64, CHECKS, ROUNDS, "the far end of the ring",
     trough},
};

const case_list cases_round = {cases, sizeof cases / sizeof *cases};
