/* Edges, vertices, borders and degenerate pieces: heights by hand.
 *
 * A sharp edge or a tip at height c, gap away from the tool's ring, carries the tool at
 * Tc_z = c + sqrt(Ri^2 - gap^2). A roof of slope phi moved outward by Ri is round about its crest
 * while gap < Ri sin(phi), and a roof again beyond. */
#include "conformance.h"
#include "shapes.h"

#define HALF 90.0

static want round_want(const fixture *f, double c, double gap) {
    double ri = f->tool.def.minor_radius_mm;
    if (gap > ri) return known_status(BTG_NO_CONTACT);
    want w = known(c + sqrt((ri - gap) * (ri + gap)));
    w.lever = ri > 0 ? (w.value - c) / ri : 1;
    return w;
}

/* A distance from the axis where the ring is met; for a sharp one, inside of it. */
static double under_ring(const fixture *f, rng *r) {
    double ro = f->tool.def.major_radius_mm, ri = f->tool.def.minor_radius_mm;
    return ri > 0 ? fabs(ro + rng_range(r, -0.9, 0.9) * ri) : rng_range(r, 0, 0.9) * ro;
}

static motion random_turn(rng *r) {
    motion m = {.angle = rng_range(r, -BTG_PI, BTG_PI), .scale = 1};
    m.shift = vec(rng_range(r, -50, 50), rng_range(r, -50, 50), rng_range(r, -50, 50));
    return m;
}

/* Axis-parallel every third time. */
static motion square_turn(rng *r, int round) {
    motion m = random_turn(r);
    if (round % 3 == 0) m.angle = 0;
    return m;
}

static void rectangle(fixture *f, bool patch, btg_vec3 a, btg_vec3 b, btg_vec3 c, btg_vec3 d) {
    if (patch) {
        model_quad(&f->model, a, b, c, d);
    } else {
        model_triangle(&f->model, a, b, c);
        model_triangle(&f->model, b, d, c);
    }
}

/* A ring no larger than the gap's line never meets it: then e < Ro means crossing. */
static double line_gap(const fixture *f, double e) {
    double gap = e - f->tool.def.major_radius_mm;
    return gap > 0 ? gap : 0;
}

static void finish(fixture *f, const motion *m) {
    model_move(&f->model, m);
    fixture_part(f);
}

static void ask(fixture *f, const motion *m, double x, double y, want w) {
    btg_vec3 foot = motion_point(m, vec(x, y, 0));
    w.value += m->shift.z;
    fixture_foot(f, foot.x, foot.y, w);
}

static void roof(fixture *f, rng *r, int round) {
    shape_tool(f, round);
    motion m = square_turn(r, round);
    double phi = rng_range(r, 0.1, 1.2), low = -HALF * tan(phi), ri = f->tool.def.minor_radius_mm;
    for (int side = -1; side <= 1; side += 2)
        rectangle(f, round & 8, vec(-HALF, 0, 0), vec(HALF, 0, 0), vec(-HALF, side * HALF, low),
                  vec(HALF, side * HALF, low));
    finish(f, &m);
    for (int i = 0; i < 8; i++) {
        double e = rng_range(r, 0, 25), gap = line_gap(f, e);
        want w = round_want(f, 0, gap);
        if (gap >= ri * sin(phi)) {
            w = known(ri / cos(phi) - tan(phi) * gap);
            w.lever = cos(phi);
        }
        ask(f, &m, rng_range(r, -20, 20), i % 2 ? e : -e, w);
    }
}

/* The border of a level plane, and its corner. */
static void border(fixture *f, rng *r, int round) {
    shape_tool(f, round);
    motion m = square_turn(r, round);
    rectangle(f, round & 8, vec(-HALF, -HALF, 0), vec(-HALF, 0, 0), vec(0, -HALF, 0), vec(0, 0, 0));
    finish(f, &m);
    double reach = 1.2 * (f->tool.def.major_radius_mm + f->tool.def.minor_radius_mm);
    for (int i = 0; i < 4; i++) {
        double e = rng_range(r, 0.01, 1) * reach, angle = rng_range(r, 0, BTG_PI / 2);
        ask(f, &m, e, -HALF / 2, round_want(f, 0, line_gap(f, e)));
        ask(f, &m, e * cos(angle), e * sin(angle), round_want(f, 0, line_gap(f, e)));
    }
}

/* A vertical face beside the tool: only its upper edge may be met. */
static void wall(fixture *f, rng *r, int round) {
    shape_tool(f, round);
    motion m = square_turn(r, round);
    rectangle(f, round & 8, vec(0, -HALF, 0), vec(0, HALF, 0), vec(0, -HALF, -HALF),
              vec(0, HALF, -HALF));
    finish(f, &m);
    double reach = 1.2 * (f->tool.def.major_radius_mm + f->tool.def.minor_radius_mm);
    for (int i = 0; i < 8; i++) {
        double e = rng_range(r, -1, 1) * reach;
        ask(f, &m, e, rng_range(r, -20, 20), round_want(f, 0, line_gap(f, fabs(e))));
    }
}

/* Triangles and patches without area are the edges and points they are. */
static void flat_pieces(fixture *f, rng *r, int round) {
    shape_tool(f, round);
    motion m = square_turn(r, round);
    btg_vec3 a = vec(0, -HALF, 0), b = vec(0, HALF, 0), c = vec(0, rng_range(r, -9, 9), 0);
    btg_vec3 tip = vec(40, 0, 0);
    switch (round % 4) {
    case 0:
        model_triangle(&f->model, a, b, c);
        break;
    case 1:
        model_triangle(&f->model, a, b, b);
        break;
    case 2:
        model_quad(&f->model, a, b, a, b);
        break;
    default:
        model_quad(&f->model, a, a, b, b);
        break;
    }
    model_triangle(&f->model, tip, tip, tip);
    finish(f, &m);
    double reach = 1.2 * (f->tool.def.major_radius_mm + f->tool.def.minor_radius_mm);
    for (int i = 0; i < 4; i++) {
        double e = rng_range(r, -1, 1) * reach;
        ask(f, &m, e, rng_range(r, -20, 20), round_want(f, 0, line_gap(f, fabs(e))));
        double d = under_ring(f, r);
        ask(f, &m, 40 + d, 0, round_want(f, 0, shape_gap(f, d)));
    }
}

/* A tip under the ring; under shank and holder when it stands farther out. */
static void tip(fixture *f, rng *r, int round) {
    shape_tool(f, round);
    double outer = f->tool.def.major_radius_mm + f->tool.def.minor_radius_mm,
           holder = rng_range(r, 5, 20);
    fixture_cylinder(f, outer, 2, 30);
    fixture_cylinder(f, outer + 10, holder, 60);
    motion m = random_turn(r);
    model_triangle(&f->model, vec(0, 0, 0), vec(0.01, 0, -900), vec(0, 0.01, -900));
    finish(f, &m);
    for (int i = 0; i < 8; i++) {
        double angle = rng_range(r, -BTG_PI, BTG_PI), e = rng_range(r, 0, 1.2) * (outer + 10);
        double ring = under_ring(f, r);
        if (i % 2) e = ring;
        want w = round_want(f, 0, shape_gap(f, e));
        double least = e <= outer ? -2 : e <= outer + 10 ? -holder : -INFINITY;
        if (w.status != BTG_OK || w.value < least) {
            w = known(least);
            if (least == -INFINITY) w = known_status(BTG_NO_CONTACT);
        }
        ask(f, &m, e * cos(angle), e * sin(angle), w);
    }
}

#define CHECKS (CHECK_VALUE | CHECK_CLEAR | CHECK_TOUCH)
#define ROUNDS (2 * SHAPE_TOOLS)

static const test_case cases[] = {
    {"edge-roof-drop", BTG_OP_DROP, TOLERANCE_F64, CHECKS, ROUNDS, "crest and sides", roof},
    {"edge-border-drop", BTG_OP_DROP, TOLERANCE_F64, CHECKS, ROUNDS, "edge and corner of a part",
     border},
    {"edge-wall-drop", BTG_OP_DROP, TOLERANCE_F64, CHECKS, ROUNDS, "vertical faces", wall},
    {"edge-flat-pieces-drop", BTG_OP_DROP, TOLERANCE_F64, CHECKS, ROUNDS,
     "triangles and patches without area", flat_pieces},
    {"edge-tip-drop", BTG_OP_DROP, TOLERANCE_F64, CHECKS, ROUNDS, "vertex under ring and holder",
     tip},
};

const case_list cases_edge = {cases, sizeof cases / sizeof *cases};
