/* Random parts of all kinds: each back end against the reference, and against what holds for
 * every right answer. Every third part is far from the origin. */
#include "conformance.h"
#include "shapes.h"

/* Footprint of a part, and the heights over it. */
#define SPAN 60.0

static void random_tool(fixture *f, rng *r) {
    shape_tool(f, f->op == BTG_OP_TILT ? rng_pick(r, SHAPE_RING_TOOLS) : rng_pick(r, SHAPE_TOOLS));
    if (rng_pick(r, 3) > 0) return;
    double outer = f->tool.def.major_radius_mm + f->tool.def.minor_radius_mm;
    fixture_cylinder(f, 0.9 * outer, rng_range(r, 2, 6), 40);
    fixture_cylinder(f, rng_range(r, 1.2, 2) * outer, rng_range(r, 15, 30), 80);
}

static motion place_part(rng *r, int round) {
    motion m = {.angle = rng_range(r, -BTG_PI, BTG_PI), .scale = 1};
    double far = round % 3 == 2 ? 1e5 : 100;
    m.shift = vec(rng_range(r, -far, far), rng_range(r, -far, far), rng_range(r, -far, far));
    return m;
}

static void finish(fixture *f, rng *r, int round, int feet) {
    motion m = place_part(r, round);
    model_move(&f->model, &m);
    fixture_part(f);
    for (int i = 0; i < feet; i++) {
        btg_vec3 foot = vec(rng_range(r, -0.5, 0.5) * SPAN, rng_range(r, -0.5, 0.5) * SPAN, 0);
        foot = motion_point(&m, foot);
        fixture_foot(f, foot.x, foot.y, unknown);
    }
}

#define FEET 8

/* Points of a net over the footprint, skewed and bumpy. */
static btg_vec3 net_point(rng *r, double s, double t, double bump) {
    double jitter = 0.06 * SPAN;
    return vec((s - 0.5) * SPAN + rng_range(r, -jitter, jitter),
               (t - 0.5) * SPAN + rng_range(r, -jitter, jitter), rng_range(r, -bump, bump));
}

static void fill(model_surface *s, rng *r, int nu, int nv, double bump) {
    double slope_x = rng_range(r, -15, 15), slope_y = rng_range(r, -15, 15);
    for (int i = 0; i < nu; i++)
        for (int j = 0; j < nv; j++) {
            double a = (double)i / (nu - 1), b = (double)j / (nv - 1);
            btg_vec3 p = net_point(r, a, b, bump);
            p.z += slope_x * a + slope_y * b;
            shape_put(s, i * nv + j, p);
            if (s->weights) s->weights[i * nv + j] = exp(rng_range(r, -1, 1));
        }
}

static void bicubic(fixture *f, rng *r, int round) {
    random_tool(f, r);
    model_surface s = model_bezier(&f->model, 3, 3, false);
    fill(&s, r, 4, 4, rng_range(r, 1, 25));
    finish(f, r, round, FEET);
}

static void degrees(fixture *f, rng *r, int round) {
    random_tool(f, r);
    int n = 1 + round % 9, m = round == 0 ? 5 : 1 + rng_pick(r, 9);
    if (round == 1) n = 5;
    model_surface s = model_bezier(&f->model, n, m, false);
    fill(&s, r, n + 1, m + 1, 15);
    finish(f, r, round, FEET);
}

static void uneven(double *knots, rng *r, int degree, int count) {
    double at = rng_range(r, -3, 3);
    int run = degree; /* more would tear the surface */
    for (int i = degree; i <= count; i++) {
        bool repeated = i > degree + 1 && i < count && run < degree && rng_pick(r, 4) == 0;
        run = repeated ? run + 1 : 1;
        if (i > degree && !repeated) at += exp(rng_range(r, -2, 2));
        knots[i] = at;
    }
    for (int i = 0; i < degree; i++) {
        knots[i] = knots[degree];
        knots[count + 1 + i] = knots[count];
    }
}

static void spline(fixture *f, rng *r, int round) {
    random_tool(f, r);
    int n = 1 + rng_pick(r, 4), m = 1 + rng_pick(r, 4);
    int cu = n + 1 + rng_pick(r, 5), cv = m + 1 + rng_pick(r, 5);
    model_surface s = model_spline(&f->model, n, m, cu, cv, round % 2);
    uneven(s.knots_u, r, n, cu);
    uneven(s.knots_v, r, m, cv);
    fill(&s, r, cu, cv, 12);
    finish(f, r, round, FEET);
}

static void rational(fixture *f, rng *r, int round) {
    random_tool(f, r);
    int n = 2 + rng_pick(r, 3), m = 2 + rng_pick(r, 3);
    model_surface s = model_bezier(&f->model, n, m, true);
    fill(&s, r, n + 1, m + 1, 15);
    finish(f, r, round, FEET);
}

/* Patches with common corner points and creases between them. */
static void creases(fixture *f, rng *r, int round) {
    enum { SIDE = 3, DEGREE = 2, POINTS = SIDE * DEGREE + 1 };
    btg_vec3 net[POINTS][POINTS];
    random_tool(f, r);
    for (int i = 0; i < POINTS; i++)
        for (int j = 0; j < POINTS; j++)
            net[i][j] = net_point(r, i / (POINTS - 1.0), j / (POINTS - 1.0), 8);
    for (int a = 0; a < SIDE; a++)
        for (int b = 0; b < SIDE; b++) {
            model_surface s = model_bezier(&f->model, DEGREE, DEGREE, false);
            for (int k = 0; k < 9; k++)
                shape_put(&s, k, net[a * DEGREE + k / 3][b * DEGREE + k % 3]);
        }
    finish(f, r, round, FEET);
}

static void terrain(fixture *f, rng *r, int round) {
    enum { SIDE = 12 };
    btg_vec3 p[SIDE + 1][SIDE + 1];
    random_tool(f, r);
    double bump = rng_range(r, 0.5, 8);
    for (int i = 0; i <= SIDE; i++)
        for (int j = 0; j <= SIDE; j++) {
            double x = (double)i / SIDE - 0.5, y = (double)j / SIDE - 0.5;
            double wave = 10 * sin(5 * x) * cos(4 * y) + rng_range(r, -bump, bump);
            p[i][j] = vec(x * SPAN, y * SPAN, wave);
        }
    for (int i = 0; i < SIDE; i++)
        for (int j = 0; j < SIDE; j++) {
            model_triangle(&f->model, p[i][j], p[i + 1][j], p[i][j + 1]);
            model_triangle(&f->model, p[i + 1][j], p[i + 1][j + 1], p[i][j + 1]);
        }
    finish(f, r, round, FEET);
}

static btg_vec3 anywhere(rng *r) {
    return vec(rng_range(r, -0.6, 0.6) * SPAN, rng_range(r, -0.6, 0.6) * SPAN,
               rng_range(r, -15, 15));
}

/* Through each other, with slivers, doubles and triangles without area. */
static void soup(fixture *f, rng *r, int round) {
    random_tool(f, r);
    for (int i = 0; i < 40; i++) {
        btg_vec3 a = anywhere(r), b = anywhere(r), c = anywhere(r);
        if (i % 8 == 1) c = vec_mad(a, vec_sub(b, a), rng_range(r, 0, 1));
        if (i % 8 == 2) c = b;
        if (i % 8 == 3) b = vec_mad(a, vec_sub(b, a), 1e-6);
        if (i % 8 == 4) b.z = c.z = a.z;
        if (i % 8 == 5) b.x = c.x = a.x;
        model_triangle(&f->model, a, b, c);
        if (i % 8 == 6) model_triangle(&f->model, c, b, a);
    }
    finish(f, r, round, FEET);
}

/* Sides drawn together to points, sides folded on each other. */
static void degenerate(fixture *f, rng *r, int round) {
    random_tool(f, r);
    model_surface s = model_bezier(&f->model, 3, 3, round % 2);
    fill(&s, r, 4, 4, 12);
    for (int k = 1; k < 4; k++) {
        int to = round % 3 == 0 ? k : 4 * k, from = round % 3 == 2 ? 4 * k + 1 : 0;
        for (int x = 0; x < 3; x++)
            s.points[3 * to + x] = s.points[3 * from + x];
    }
    btg_vec3 a = anywhere(r);
    model_quad(&f->model, a, a, a, a);
    finish(f, r, round, FEET);
}

#define CASE(name, op, rounds, reason, make)                                                       \
    { name, op, TOLERANCE_F64, CHECK_RANDOM, rounds, reason, make }

static const test_case cases[] = {
    CASE("random-drop-bicubic", BTG_OP_DROP, 12, "skewed and bumpy", bicubic),
    CASE("random-drop-degrees", BTG_OP_DROP, 12, "degrees 1 to 9, unequal", degrees),
    CASE("random-drop-spline", BTG_OP_DROP, 12, "uneven and repeated knots", spline),
    CASE("random-drop-rational", BTG_OP_DROP, 12, "uneven weights", rational),
    CASE("random-drop-creases", BTG_OP_DROP, 9, "nine patches, sharp creases", creases),
    CASE("random-drop-terrain", BTG_OP_DROP, 9, "mesh", terrain),
    CASE("random-drop-soup", BTG_OP_DROP, 9, "triangles through each other", soup),
    CASE("random-drop-degenerate", BTG_OP_DROP, 12, "collapsed edges", degenerate),
    CASE("random-tilt-bicubic", BTG_OP_TILT, 12, "skewed and bumpy", bicubic),
    CASE("random-tilt-degrees", BTG_OP_TILT, 12, "degrees 1 to 9, unequal", degrees),
    CASE("random-tilt-spline", BTG_OP_TILT, 12, "uneven and repeated knots", spline),
    CASE("random-tilt-rational", BTG_OP_TILT, 12, "uneven weights", rational),
    CASE("random-tilt-creases", BTG_OP_TILT, 9, "nine patches, sharp creases", creases),
    CASE("random-tilt-terrain", BTG_OP_TILT, 9, "mesh", terrain),
    CASE("random-tilt-soup", BTG_OP_TILT, 9, "triangles through each other", soup),
    CASE("random-tilt-degenerate", BTG_OP_TILT, 12, "collapsed edges", degenerate),
};

const case_list cases_random = {cases, sizeof cases / sizeof *cases};
