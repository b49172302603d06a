/* Drop-spin-tilt on random Bezier surfaces of bidegree 2 to 5, as the DST paper does it: S. K.
 * Sharma, R. K. Duvedi, S. Bedi, S. Mann, "Numerical implementation of drop spin and tilt method
 * for five-axis tool positioning for tensor product surfaces". Every position is held to what is
 * true of it by definition; what a policy calls met is measured from P and Q alone; the strip, and
 * the widest one, against dense samples. */
#include "check.h"
#include "bitangent/bitangent.h"

#include "../conformance/model.h"
#include "../conformance/rng.h"

#include <stdlib.h>

#define DEGREE (BTG_PI / 180)
#define SIDE   150.0
#define ROUNDS 40
/* Samples of the whole surface, either way; and spins around a turn. */
#define GRID  240
#define SPINS 72

typedef struct setting {
    btg_part *part;
    btg_tool tool;
    btg_solver_def solver;
    double x, y, feed;
    void *workspace;
    size_t size;
    btg_vec3 *sample;
} setting;

static void make_surface(setting *s, rng *r, int degree) {
    model m = {0};
    model_surface net = model_bezier(&m, degree, degree, false);
    for (int i = 0; i <= degree; i++)
        for (int j = 0; j <= degree; j++) {
            double *p = &net.points[3 * (i * (degree + 1) + j)];
            p[0] = SIDE * i / degree;
            p[1] = SIDE * j / degree;
            p[2] = rng_range(r, 0, 40);
        }
    s->part = model_part(&m);
    model_free(&m);
    s->size = btg_position_workspace_size(s->part);
    s->workspace = malloc(s->size);
    s->sample = malloc(sizeof *s->sample * (GRID + 1) * (GRID + 1));
    for (int i = 0; i <= GRID; i++)
        for (int j = 0; j <= GRID; j++) {
            btg_surface_point p;
            btg_place at = {0, (double)i / GRID, (double)j / GRID};
            CHECK(btg_part_evaluate(s->part, at, &p) == BTG_OK);
            s->sample[i * (GRID + 1) + j] = p.s;
        }
}

static setting make_setting(rng *r, int round) {
    setting s = {.solver = btg_solver_def_default()};
    btg_tool_def def = btg_tool_def_default();
    if (round % 8 == 7) def.profile = BTG_PROFILE_BULLNOSE;
    CHECK(btg_tool_init(&def, &s.tool, NULL) == BTG_OK);
    make_surface(&s, r, 2 + round % 4);
    s.x = rng_range(r, 10, SIDE - 10);
    s.y = rng_range(r, 10, SIDE - 10);
    s.feed = rng_range(r, 0, 2 * BTG_PI);
    s.solver.gap_mm = rng_range(r, 1, 12);
    s.solver.feed_x = cos(s.feed);
    s.solver.feed_y = sin(s.feed);
    return s;
}

static void end_setting(setting *s) {
    free(s->sample);
    free(s->workspace);
    btg_part_destroy(s->part);
}

/* ---- one position ------------------------------------------------------------------------- */

static btg_vec3 centre_of(const setting *s, const btg_position *p) {
    return vec_mad(p->tip, p->axis, s->tool.def.minor_radius_mm);
}

static void check_contact(const setting *s, const btg_position *p, const btg_contact *c) {
    btg_surface_point f;
    CHECK(btg_part_evaluate(s->part, c->place, &f) == BTG_OK);
    CHECK_NEAR(vec_norm(vec_sub(f.s, c->point)), 0, 1e-9);
    CHECK_NEAR(btg_tool_distance(&s->tool, centre_of(s, p), p->axis, c->point), 0, 1e-6);
    bool inside = c->place.u > 0 && c->place.u < 1 && c->place.v > 0 && c->place.v < 1;
    btg_vec3 n = vec_unit(vec_cross(f.su, f.sv));
    if (inside) CHECK_NEAR(vec_norm(vec_cross(n, c->normal)), 0, 1e-4);
}

/* Nothing of the surface in the tool. */
static void check_clear(const setting *s, const btg_position *p) {
    btg_vec3 centre = centre_of(s, p);
    double least = INFINITY;
    for (int i = 0; i < (GRID + 1) * (GRID + 1); i++)
        least = fmin(least, btg_tool_distance(&s->tool, centre, p->axis, s->sample[i]));
    CHECK(least > -1e-6);
}

static btg_status solve(const setting *s, btg_position *p) {
    btg_status status =
        btg_position_solve(s->part, &s->tool, &s->solver, s->x, s->y, s->workspace, s->size, p);
    CHECK(status >= 0 && status == p->status);
    CHECK(status != BTG_NO_CONTACT && status != BTG_BUDGET);
    check_contact(s, p, &p->p);
    if (status == BTG_OK || status == BTG_OSCULATING) check_contact(s, p, &p->q);
    check_clear(s, p);
    return status;
}

/* The spin a position says it has leads to it again. */
static void check_spin(setting s, const btg_position *p) {
    btg_position again;
    if (p->spin_rad == 0) return;
    s.solver.spin = BTG_SPIN_FIXED;
    s.solver.spin_rad = p->spin_rad;
    solve(&s, &again);
    CHECK(again.status == p->status);
    CHECK_NEAR(vec_norm(vec_sub(again.tip, p->tip)), 0, 1e-9);
}

static btg_vec3 pq(const btg_position *p) {
    return vec_sub(p->q.point, p->p.point);
}

static double gap_of(const btg_position *p) {
    return p->status == BTG_OK ? vec_norm(pq(p)) : 0;
}

/* Degrees off a right angle, NaN without Q. */
static double off_across(const setting *s, const btg_position *p) {
    if (p->status != BTG_OK) return NAN;
    btg_vec3 d = vec_unit(pq(p));
    return asin(d.x * cos(s->feed) + d.y * sin(s->feed)) / DEGREE;
}

static double strip_of(const setting *s, const btg_position *p) {
    double width = NAN;
    CHECK(btg_position_strip(s->part, &s->tool, &s->solver, p, &width) == BTG_OK);
    return width;
}

/* ---- policies ----------------------------------------------------------------------------- */

typedef struct tally {
    int gap, across, across_could, near, other, widest, solved;
    double strip_gain;
} tally;

/* What spins around the turn give: the widest strip, the smallest angle off. */
typedef struct around {
    double strip, off, gap_min, gap_max;
} around;

static around look_around(setting s) {
    around best = {0, INFINITY, INFINITY, 0};
    s.solver.spin = BTG_SPIN_FIXED;
    for (int k = 0; k < SPINS; k++) {
        btg_position p;
        s.solver.spin_rad = 2 * BTG_PI * k / SPINS;
        if (k % 9 == 0)
            solve(&s, &p);
        else
            btg_position_solve(s.part, &s.tool, &s.solver, s.x, s.y, s.workspace, s.size, &p);
        if (p.status != BTG_OK && p.status != BTG_OSCULATING) continue;
        CHECK(p.spin_met);
        best.strip = fmax(best.strip, strip_of(&s, &p));
        best.off = fmin(best.off, fabs(off_across(&s, &p)));
        best.gap_min = fmin(best.gap_min, gap_of(&p));
        best.gap_max = fmax(best.gap_max, gap_of(&p));
    }
    return best;
}

static double turn(const btg_position *a, const btg_position *b) {
    return fabs(remainder(a->spin_rad - b->spin_rad, 2 * BTG_PI));
}

static void test_gap(setting s, const around *all, tally *t) {
    btg_position p, next;
    s.solver.spin = BTG_SPIN_GAP;
    solve(&s, &p);
    double off = fabs(gap_of(&p) - s.solver.gap_mm);
    CHECK((off <= 1e-4) == (p.spin_met == 1));
    t->gap += p.spin_met;
    check_spin(s, &p);
    /* too much for every spin: the nearest is the largest there is */
    setting far = s;
    far.solver.gap_mm = 40;
    solve(&far, &next);
    CHECK(!next.spin_met);
    CHECK(gap_of(&next) > 0.97 * all->gap_max);
    /* the next position of a path stays near this one's spin */
    if (!p.spin_met) return;
    CHECK(btg_position_follow(s.part, &s.tool, &s.solver, s.x + 0.1, s.y, &p, s.workspace, s.size,
                              &next) >= 0);
    CHECK(fabs(gap_of(&next) - s.solver.gap_mm) <= 1e-4 || !next.spin_met);
    t->near += next.spin_met && turn(&next, &p) < 0.2;
    /* and that of a path on the other side, there */
    s.solver.spin = BTG_SPIN_FIXED;
    s.solver.spin_rad = p.spin_rad + BTG_PI;
    if (solve(&s, &p) != BTG_OK) return;
    s.solver.spin = BTG_SPIN_GAP;
    CHECK(btg_position_follow(s.part, &s.tool, &s.solver, s.x, s.y, &p, s.workspace, s.size,
                              &next) >= 0);
    t->other += next.spin_met && turn(&next, &p) < BTG_PI / 2;
}

static void test_across(setting s, const around *all, tally *t) {
    btg_position p;
    s.solver.spin = BTG_SPIN_ACROSS;
    solve(&s, &p);
    double off = fabs(off_across(&s, &p));
    if (p.spin_met) CHECK(off <= 1e-3);
    t->across += p.spin_met;
    t->across_could += p.spin_met || off <= all->off + 3;
}

static void test_widest(setting s, const around *all, tally *t) {
    btg_position p, none;
    solve(&s, &none); /* without spin */
    s.solver.spin = BTG_SPIN_WIDEST;
    solve(&s, &p);
    double width = strip_of(&s, &p);
    CHECK(p.spin_met && width > 0);
    CHECK(width >= strip_of(&s, &none));
    check_spin(s, &p);
    t->widest += width >= 0.99 * all->strip;
    t->strip_gain += width / all->strip;
}

static void test_policies(rng *r) {
    tally t = {0};
    for (int round = 0; round < ROUNDS; round++) {
        setting s = make_setting(r, round);
        btg_position none;
        if (solve(&s, &none) == BTG_OK) {
            around all = look_around(s);
            test_gap(s, &all, &t);
            test_across(s, &all, &t);
            test_widest(s, &all, &t);
            t.solved++;
        }
        end_setting(&s);
    }
    printf("%d positions: gap met %d, next one near %d, and on the other side %d; across met %d, "
           "met or nearest %d; "
           "widest within 1 %% of %d spins %d, %.4f of theirs in the mean\n",
           t.solved, t.gap, t.near, t.other, t.across, t.across_could, SPINS, t.widest,
           t.strip_gain / t.solved);
    CHECK(t.solved >= ROUNDS * 9 / 10);
    CHECK(t.gap >= t.solved * 9 / 10 && t.near >= t.gap * 9 / 10 && t.other >= t.gap * 8 / 10);
    CHECK(t.across >= 1 && t.across_could >= t.solved * 8 / 10);
    CHECK(t.widest >= t.solved * 7 / 10 && t.strip_gain >= 0.985 * t.solved);
}

/* ---- wide shanks -------------------------------------------------------------------------- */

/* A spun tool begins laid over: a wide shank then cuts deep into the part, and where that cut ends
 * the value jumps, so that a walk along it never came to an end; and the start pose was taken for
 * free, because its value is greatest where it is next to nothing deep. Such a tool stays as
 * dropped. */
static void test_shank(void) {
    rng r = {3};
    int unspun = 0, spun = 0;
    for (int round = 0; round < ROUNDS; round++) {
        setting s = make_setting(&r, round);
        btg_tool_def def = s.tool.def;
        def.shank = (btg_cylinder){12, 4, 80};
        CHECK(btg_tool_init(&def, &s.tool, NULL) == BTG_OK);
        s.solver.node_budget = 20000;
        s.solver.spin = (btg_spin)(BTG_SPIN_FIXED + round / 2 % 4);
        s.solver.spin_rad = rng_range(&r, -BTG_PI, BTG_PI);
        btg_position p;
        if (solve(&s, &p) != BTG_SINGLE_CONTACT) unspun += p.spin_rad == 0, spun += p.spin_rad != 0;
        for (s.solver.node_budget = 200; s.solver.node_budget > 10; s.solver.node_budget /= 2) {
            CHECK(btg_position_solve(s.part, &s.tool, &s.solver, s.x, s.y, s.workspace, s.size,
                                     &p) >= 0);
            check_clear(&s, &p);
        }
        end_setting(&s);
    }
    printf("wide shank: %d positions spun, %d as dropped\n", spun, unspun);
    CHECK(spun >= ROUNDS / 2 && unspun >= 1);
}

/* ---- the strip ---------------------------------------------------------------------------- */

#define BINS    600
#define BIN_MM  0.1
#define SAMPLES 1200
#define WINDOW  0.12

/* Bins at the scallop or closer, outward from one; counted once. */
static int spread(double *least, int from, double scallop) {
    int count = 0;
    for (int i = from; i < BINS && least[i] <= scallop; i++, count++)
        if (i != from) least[i] = INFINITY;
    for (int i = from - 1; i >= 0 && least[i] <= scallop; i--, count++)
        least[i] = INFINITY;
    if (count > 0) least[from] = INFINITY;
    return count;
}

static int bin_of(const setting *s, btg_vec3 from, btg_vec3 point) {
    btg_vec3 d = vec_sub(point, from);
    return (int)floor((d.x * sin(s->feed) - d.y * cos(s->feed)) / BIN_MM) + BINS / 2;
}

static double sampled_strip(const setting *s, const btg_position *p, double scallop) {
    static double least[BINS];
    btg_vec3 centre = centre_of(s, p), from = p->p.point;
    for (int i = 0; i < BINS; i++)
        least[i] = INFINITY;
    for (int i = 0; i <= SAMPLES; i++)
        for (int j = 0; j <= SAMPLES; j++) {
            btg_place at = {0, p->p.place.u + WINDOW * (2.0 * i / SAMPLES - 1),
                            p->p.place.v + WINDOW * (2.0 * j / SAMPLES - 1)};
            btg_surface_point f;
            if (btg_part_evaluate(s->part, at, &f) != BTG_OK) continue;
            int bin = bin_of(s, from, f.s);
            if (bin < 0 || bin >= BINS) continue;
            least[bin] = fmin(least[bin], btg_tool_distance(&s->tool, centre, p->axis, f.s));
        }
    int count = spread(least, BINS / 2, scallop);
    if (p->status == BTG_OK) count += spread(least, bin_of(s, from, p->q.point), scallop);
    return count * BIN_MM;
}

static void test_strip(rng *r) {
    for (int round = 0; round < 16; round++) {
        setting s = make_setting(r, round);
        btg_position p;
        s.solver.spin = BTG_SPIN_FIXED;
        s.solver.spin_rad = rng_range(r, -3, 3);
        double scallop = round % 2 ? 0.05 : 0.01;
        s.solver.scallop_mm = round % 4 ? scallop : 0; /* 0: the default */
        if (round % 4 == 0) scallop = 0.01;
        s.x = 20 + 0.7 * s.x; /* the samples reach around the strip */
        s.y = 20 + 0.7 * s.y;
        if (solve(&s, &p) == BTG_OK) {
            double width = strip_of(&s, &p);
            CHECK_NEAR(width, sampled_strip(&s, &p, scallop), 0.02 * width + 2.5 * BIN_MM);
        }
        end_setting(&s);
    }
}

/* A B-spline in many patches has the strip of the one patch it was cut from. */
static void test_patches(rng *r) {
    double points[27], cut[75];
    const double knots[8] = {0, 0, 0, 0.35, 0.6, 1, 1, 1},
                 blossom[5][2] = {{0, 0}, {0, 0.35}, {0.35, 0.6}, {0.6, 1}, {1, 1}};
    for (int i = 0; i < 9; i++) {
        points[3 * i] = 40 * (i / 3);
        points[3 * i + 1] = 40 * (i % 3);
        points[3 * i + 2] = rng_range(r, 0, 8);
    }
    for (int i = 0; i < 5; i++)
        for (int j = 0; j < 5; j++)
            for (int x = 0; x < 3; x++) {
                double value = 0;
                for (int k = 0; k < 9; k++) {
                    double a = blossom[i][0], b = blossom[i][1], c = blossom[j][0],
                           d = blossom[j][1];
                    double u[3] = {(1 - a) * (1 - b), a + b - 2 * a * b, a * b};
                    double v[3] = {(1 - c) * (1 - d), c + d - 2 * c * d, c * d};
                    value += u[k / 3] * v[k % 3] * points[3 * k + x];
                }
                cut[3 * (5 * i + j) + x] = value;
            }
    const btg_surface_def whole = {2, 2, 3, 3, points, NULL, NULL, NULL};
    const btg_surface_def pieces = {2, 2, 5, 5, cut, NULL, knots, knots};
    btg_tool_def def = btg_tool_def_default();
    btg_tool tool;
    CHECK(btg_tool_init(&def, &tool, NULL) == BTG_OK);
    double width[2][25];
    for (int k = 0; k < 2; k++) {
        btg_part_def part_def = btg_part_def_default();
        part_def.surfaces = k ? &pieces : &whole;
        part_def.surface_count = 1;
        setting s = {.tool = tool, .solver = btg_solver_def_default()};
        CHECK(btg_part_create(&part_def, &s.part, NULL) == BTG_OK);
        s.size = btg_position_workspace_size(s.part);
        s.workspace = malloc(s.size);
        for (int i = 0; i < 25; i++) {
            btg_position p;
            s.solver.feed_x = i % 2;
            s.solver.feed_y = 0.7;
            s.solver.scallop_mm = 0.05;
            btg_position_solve(s.part, &tool, &s.solver, 12 + 14 * (i / 5), 12 + 14 * (i % 5),
                               s.workspace, s.size, &p);
            width[k][i] = strip_of(&s, &p);
        }
        free(s.workspace);
        btg_part_destroy(s.part);
    }
    for (int i = 0; i < 25; i++)
        CHECK_NEAR(width[1][i], width[0][i], 2e-3 * width[0][i] + 1e-3);
}

/* No feed is one along +y; a feed has a direction, but no length and no sense. */
static void test_feed(rng *r) {
    setting s = make_setting(r, 2);
    const double feed[5][2] = {{0, 0}, {0, 1}, {0, 7}, {0, -1}, {1, 0}};
    double width[5];
    btg_position p;
    solve(&s, &p);
    for (int i = 0; i < 5; i++) {
        s.solver.feed_x = feed[i][0];
        s.solver.feed_y = feed[i][1];
        width[i] = strip_of(&s, &p);
    }
    for (int i = 1; i < 4; i++)
        CHECK_NEAR(width[i], width[0], 1e-6);
    CHECK(fabs(width[4] - width[0]) > 0.01);
    end_setting(&s);
}

/* ---- what is refused ---------------------------------------------------------------------- */

static void test_refusals(rng *r) {
    setting s = make_setting(r, 1);
    btg_position p;
    for (int k = 0; k < 7; k++) {
        btg_solver_def bad = s.solver;
        bad.spin = BTG_SPIN_GAP;
        if (k == 0) bad.gap_mm = 0;
        if (k == 1) bad.gap_mm = NAN;
        if (k == 2) bad.feed_x = INFINITY;
        if (k == 3) bad.scallop_mm = -1;
        if (k == 4) bad.scallop_mm = NAN;
        if (k == 5) bad.spin = (btg_spin)5;
        size_t size = k == 6 ? s.size - 1 : s.size;
        CHECK(btg_position_solve(s.part, &s.tool, &bad, s.x, s.y, s.workspace, size, &p) ==
              BTG_ERROR_ARGUMENT);
    }
    double width;
    solve(&s, &p);
    p.p.place.item = 99;
    CHECK(btg_position_strip(s.part, &s.tool, &s.solver, &p, &width) == BTG_ERROR_ARGUMENT);
    CHECK(btg_position_strip(s.part, &s.tool, &s.solver, NULL, &width) == BTG_ERROR_ARGUMENT);
    s.x = -500; /* nothing there */
    s.solver.spin = BTG_SPIN_WIDEST;
    CHECK(btg_position_solve(s.part, &s.tool, &s.solver, s.x, s.y, s.workspace, s.size, &p) ==
          BTG_NO_CONTACT);
    CHECK(btg_position_strip(s.part, &s.tool, &s.solver, &p, &width) == BTG_OK && width == 0);
    end_setting(&s);
}

int main(void) {
    rng r = {11};
    test_policies(&r);
    test_shank();
    test_strip(&r);
    test_patches(&r);
    test_feed(&r);
    test_refusals(&r);
    return check_result();
}
