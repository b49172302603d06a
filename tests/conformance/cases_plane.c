/* Planes: all answers by hand.
 *
 * On a plane of slope phi the tube's centre circle stays minor radius away: its lowest point
 * toward the slope is major * tan(phi) uphill, so  Tc_z = z(foot) + Ro tan(phi) + Ri / cos(phi).
 * The tool then tilts until its axis is the plane's normal, beta = phi, where the whole ring
 * touches at once. */
#include "conformance.h"
#include "shapes.h"

#define HALF 90.0

typedef struct plane {
    double slope, turn, height;
} plane;

static plane random_plane(rng *r, double steepest) {
    return (plane){rng_range(r, 0.01, steepest), rng_range(r, -BTG_PI, BTG_PI),
                   rng_range(r, -20, 20)};
}

static btg_vec3 on_plane(const plane *p, double x, double y) {
    double up = x * cos(p->turn) + y * sin(p->turn);
    return vec(x, y, p->height + tan(p->slope) * up);
}

static void add_quad(fixture *f, const plane *p) {
    model_quad(&f->model, on_plane(p, -HALF, -HALF), on_plane(p, -HALF, HALF),
               on_plane(p, HALF, -HALF), on_plane(p, HALF, HALF));
}

static void add_triangles(fixture *f, const plane *p) {
    btg_vec3 a = on_plane(p, -HALF, -HALF), b = on_plane(p, -HALF, HALF);
    btg_vec3 c = on_plane(p, HALF, -HALF), d = on_plane(p, HALF, HALF);
    model_triangle(&f->model, a, b, c);
    model_triangle(&f->model, b, d, c);
}

/* The same plane with parameters that run unevenly. */
static void add_patch(fixture *f, const plane *p, rng *r) {
    int n = 2 + rng_pick(r, 4), m = 2 + rng_pick(r, 4);
    model_surface s = model_bezier(&f->model, n, m, true);
    for (int i = 0; i <= n; i++)
        for (int j = 0; j <= m; j++) {
            double x = -HALF + 2 * HALF * i / n, y = -HALF + 2 * HALF * j / m;
            if (i > 0 && i < n) x += rng_range(r, -0.3, 0.3) * HALF / n;
            if (j > 0 && j < m) y += rng_range(r, -0.3, 0.3) * HALF / m;
            shape_put(&s, i * (m + 1) + j, on_plane(p, x, y));
            s.weights[i * (m + 1) + j] = rng_range(r, 0.5, 2);
        }
}

static void ask(fixture *f, rng *r, const plane *p) {
    fixture_part(f);
    double ro = f->tool.def.major_radius_mm, ri = f->tool.def.minor_radius_mm;
    for (int i = 0; i < 8; i++) {
        double x = rng_range(r, -30, 30), y = rng_range(r, -30, 30);
        double up = ro * tan(p->slope) + ri / cos(p->slope);
        want w = known(on_plane(p, x, y).z + up);
        w.lever = cos(p->slope);
        if (f->op == BTG_OP_TILT) {
            w = known(p->slope);
            w.lever = ro;
            if (p->slope > f->solver.max_tilt_rad) w = known_status(BTG_SINGLE_CONTACT);
        }
        fixture_foot(f, x, y, w);
    }
}

static void level(fixture *f, rng *r, int round) {
    plane p = {0, 0, rng_range(r, -20, 20)};
    shape_tool(f, round);
    if (round % 2)
        add_quad(f, &p);
    else
        add_triangles(f, &p);
    fixture_part(f);
    for (int i = 0; i < 8; i++)
        fixture_foot(f, rng_range(r, -30, 30), rng_range(r, -30, 30),
                     known(p.height + f->tool.def.minor_radius_mm));
}

static void quad(fixture *f, rng *r, int round) {
    plane p = random_plane(r, 1.0);
    shape_tool(f, round);
    add_quad(f, &p);
    ask(f, r, &p);
}

static void triangles(fixture *f, rng *r, int round) {
    plane p = random_plane(r, 1.0);
    shape_tool(f, round);
    add_triangles(f, &p);
    ask(f, r, &p);
}

static void patch(fixture *f, rng *r, int round) {
    plane p = random_plane(r, 1.0);
    shape_tool(f, round);
    add_patch(f, &p, r);
    ask(f, r, &p);
}

/* ---- a groove of two planes, z = tan(phi) |y| ---------------------------------------------- */

/* Drop: the nearer wall, as above, with z(foot) = tan(phi) |e|.
 *
 * Tilt: in the plane across, the section of the major circle is a rod of length 2 Ro between the
 * walls moved inward by Ri, whose lines meet at V under the angle pi - 2 phi. Its end O1 stays at
 * s = (|e| + Ro) / cos(phi) from V; the other end meets the other wall where the law of sines
 * gives the angle at O1, which is the inclination:
 *     lambda = 2 phi - asin(s sin(2 phi) / (2 Ro)),   lambda_drop = phi.
 * For s > 2 Ro the rod lies down on its own wall first: lambda = 0. */
static void groove_want(fixture *f, double phi, double e, want *w) {
    double ro = f->tool.def.major_radius_mm, ri = f->tool.def.minor_radius_mm;
    *w = known(tan(phi) * (e + ro) + ri / cos(phi));
    w->lever = cos(phi);
    if (f->op == BTG_OP_DROP) return;
    double s = (e + ro) / cos(phi);
    double lambda = s > 2 * ro ? 0 : 2 * phi - asin(s * sin(2 * phi) / (2 * ro));
    *w = known(phi - lambda);
    w->lever = ro;
}

static void groove_of(fixture *f, rng *r, int round, bool middle) {
    shape_tool(f, round);
    double phi = rng_range(r, 0.1, 0.7), z = HALF * tan(phi);
    motion t = {.angle = rng_range(r, -BTG_PI, BTG_PI), .scale = 1};
    for (int side = -1; side <= 1; side += 2) {
        btg_vec3 a = vec(-HALF, 0, 0), b = vec(HALF, 0, 0);
        btg_vec3 c = vec(-HALF, side * HALF, z), d = vec(HALF, side * HALF, z);
        if (round % 2) {
            model_quad(&f->model, a, b, c, d);
        } else {
            model_triangle(&f->model, a, b, c);
            model_triangle(&f->model, b, d, c);
        }
    }
    model_move(&f->model, &t);
    fixture_part(f);
    double ro = f->tool.def.major_radius_mm;
    for (int i = 0; i < 8; i++) {
        double e = middle ? 0 : rng_range(r, 0.02, 1.5) * ro, x = rng_range(r, -30, 30);
        want w;
        groove_want(f, phi, e, &w);
        btg_vec3 foot = motion_point(&t, vec(x, i % 2 ? e : -e, 0));
        fixture_foot(f, foot.x, foot.y, w);
    }
}

static void groove(fixture *f, rng *r, int round) {
    groove_of(f, r, round, false);
}

static void groove_middle(fixture *f, rng *r, int round) {
    groove_of(f, r, round, true);
}

#define CHECKS (CHECK_VALUE | CHECK_CLEAR | CHECK_TOUCH | CHECK_TIGHT)
#define ROUNDS SHAPE_TOOLS

static const test_case cases[] = {
    {"plane-level-drop", BTG_OP_DROP, TOLERANCE_F64, CHECKS, ROUNDS, "every point is a contact",
     level},
    {"plane-quad-drop", BTG_OP_DROP, TOLERANCE_F64, CHECKS, ROUNDS, "bilinear patch", quad},
    {"plane-triangles-drop", BTG_OP_DROP, TOLERANCE_F64, CHECKS, ROUNDS, "two triangles",
     triangles},
    {"plane-patch-drop", BTG_OP_DROP, TOLERANCE_F64, CHECKS, ROUNDS,
     "rational patch, uneven parameters", patch},
    {"plane-quad-tilt", BTG_OP_TILT, TOLERANCE_F64, CHECKS, ROUNDS, "axis becomes the normal",
     quad},
    {"plane-triangles-tilt", BTG_OP_TILT, TOLERANCE_F64, CHECKS, ROUNDS,
     "axis becomes the normal, across a shared edge", triangles},
    {"plane-patch-tilt", BTG_OP_TILT, TOLERANCE_F64, CHECKS, ROUNDS, "axis becomes the normal",
     patch},
    {"plane-groove-drop", BTG_OP_DROP, TOLERANCE_F64, CHECKS, ROUNDS, "crease that is not touched",
     groove},
    {"plane-groove-tilt", BTG_OP_TILT, TOLERANCE_F64, CHECKS, ROUNDS, "law of sines", groove},
    {"plane-groove-middle-drop", BTG_OP_DROP, TOLERANCE_F64, CHECKS, ROUNDS, "two equal contacts",
     groove_middle},
    {"plane-groove-middle-tilt", BTG_OP_TILT, TOLERANCE_F64, CHECKS, ROUNDS,
     "both contacts at the drop: no tilt", groove_middle},
};

const case_list cases_plane = {cases, sizeof cases / sizeof *cases};
