/* The ring: no point of what it says to cover (core/ring.c) is deeper in the tool than half of the
 * clearance. Tools stand as tilts leave them, or further over, into the part; what is said to be
 * the second contact is it most often. */
#include "check.h"
#include "core/search.h"
#include "hard_parts.h"

#include <stdlib.h>

#define ROUNDS  1500
#define PLACES  6 /* of a part */
#define NEAR    200
#define ROUND   300
#define SPREAD  100
#define SIZE    60.0
#define CUTTERS 3 /* of hard_tool's, the first ones: hollow */
/* Part of the clearance that is spent. */
#define SHARE 0.5
/* Rounding of the test's own points, mm. */
#define ROUNDING 1e-12

/* Rings are long: they are clear of gentle surfaces at most. */
static void add_gentle(model *m, rng *r) {
    bool rational = rng_pick(r, 4) == 0;
    int nu = 2 + rng_pick(r, 4), nv = 2 + rng_pick(r, 4);
    model_surface s = model_bezier(m, nu, nv, rational);
    double height = pow(10, rng_range(r, -1, 1)), bow = rng_range(r, -8, 12);
    for (int i = 0; i <= nu; i++)
        for (int k = 0; k <= nv; k++) {
            int at = i * (nv + 1) + k;
            double u = (double)i / nu, v = (double)k / nv, *p = s.points + 3 * at;
            p[0] = SIZE * u;
            p[1] = SIZE * v;
            p[2] = bow * (u * (1 - u) + v * (1 - v)) + height * rng_range(r, -1, 1);
            if (rational) s.weights[at] = rng_range(r, 0.8, 1.25);
        }
}

static long rings, closed, none, points, sunk, least, sharp;
static double deepest, sharpest; /* part of what is said */

static btg_search search;

/* Said to be clear: by the ring's own words, one point at a time. */
static bool covered(const btg_ring *ring, btg_place at, btg_vec3 point) {
    btg_vec3 d = vec_sub(point, search.at.centre);
    double x = vec_dot(d, ring->x), y = vec_dot(d, ring->y), z = vec_dot(d, search.at.axis);
    if (z >= 0 || hypot(hypot(x, y) - ring->radius, z - ring->height) >= ring->wide) return false;
    if (fabs(at.u - ring->u) >= ring->half_u || fabs(at.v - ring->v) >= ring->half_v) return false;
    for (uint32_t k = 0; k < ring->open; k++) {
        const btg_wedge *w = &ring->wedge[k];
        if (x * w->low[0] + y * w->low[1] <= 0 && x * w->high[0] + y * w->high[1] <= 0)
            return false;
    }
    return true;
}

static bool inside(btg_place at) {
    return at.u >= 0 && at.u <= 1 && at.v >= 0 && at.v <= 1;
}

static double depth_at(btg_place at, btg_surface_point *s) {
    btg_part_point(search.part, at, s);
    return -btg_ray_tool_distance(&search.query.tool->element[0], search.at, s->s).distance;
}

static void check_point(btg_place at) {
    btg_surface_point s;
    if (!inside(at)) return;
    double depth = depth_at(at, &s), said = SHARE * search.tolerance;
    if (!covered(&search.ring, at, s.s)) return;
    points++;
    deepest = max2(deepest, depth / said);
    if (!(depth <= said + ROUNDING)) fprintf(stderr, "%g deep, said %g\n", depth, said);
    CHECK(depth <= said + ROUNDING);
}

/* About a contact, at all scales. */
static void check_about(btg_place about, rng *r) {
    btg_surface_point s;
    btg_part_point(search.part, about, &s);
    for (int i = 0; i < NEAR; i++) {
        double way = pow(10, rng_range(r, -3, 1)), turn = rng_range(r, 0, 2 * BTG_PI);
        check_point((btg_place){about.item, about.u + way * cos(turn) / vec_norm(s.su),
                                about.v + way * sin(turn) / vec_norm(s.sv)});
    }
}

/* A place along the ring, most often close to it: as in the plane that touches the part at P. */
static btg_place along(rng *r) {
    const btg_ring *ring = &search.ring;
    btg_surface_point s;
    btg_part_point(search.part, search.p_place, &s);
    double tu = vec_dot(s.su, ring->y), tv = vec_dot(s.sv, ring->y);
    double xu = vec_dot(s.su, ring->x), xv = vec_dot(s.sv, ring->x), det = tu * xv - tv * xu;
    double p = vec_dot(vec_sub(search.query.p, search.at.centre), ring->x);
    double turn = rng_range(r, 0, 2 * BTG_PI), off = rng_range(r, -1, 1);
    double way = p + 4 * off * off * off, t = way * sin(turn), x = way * cos(turn) - p;
    return (btg_place){search.p_place.item, search.p_place.u + (xv * t - tv * x) / det,
                       search.p_place.v + (tu * x - xu * t) / det};
}

/* The deepest of some places along the ring, and of ever nearer ones about it. */
static double deepest_place(btg_place *best, rng *r) {
    btg_surface_point s;
    double most = -INFINITY;
    for (int i = 0; i < ROUND; i++) {
        btg_place at = along(r);
        double depth = inside(at) ? depth_at(at, &s) : -INFINITY;
        if (depth > most) {
            most = depth;
            *best = at;
        }
    }
    for (double step = 0.03; step > 1e-5; step *= 0.9) {
        btg_place at = *best;
        at.u += step * rng_range(r, -1, 1);
        at.v += step * rng_range(r, -1, 1);
        double depth = inside(at) ? depth_at(at, &s) : -INFINITY;
        if (depth > most) {
            most = depth;
            *best = at;
        }
    }
    return most;
}

static bool covers(btg_place at) {
    btg_surface_point s;
    depth_at(at, &s);
    btg_ring_make(&search);
    return search.ring.stands && covered(&search.ring, at, s.s);
}

/* The least clearance with which the ring covers the deepest place there is is half of what that
 * says. */
static void check_least(rng *r) {
    btg_place at = search.p_place;
    double own = search.tolerance, depth = deepest_place(&at, r), low = 1e-12, high = 1;
    search.tolerance = high;
    if (!(depth > 1e-9) || !covers(at)) {
        search.tolerance = own;
        return;
    }
    while (high > low * (1 + 1e-6)) {
        search.tolerance = sqrt(low * high);
        *(covers(at) ? &high : &low) = search.tolerance;
    }
    least++;
    sharp += depth > 0.5 * SHARE * high;
    sharpest = max2(sharpest, depth / (SHARE * high));
    if (!(depth <= SHARE * high + ROUNDING))
        fprintf(stderr, "%g deep, covered for a clearance of %g\n", depth, high);
    CHECK(depth <= SHARE * high + ROUNDING);
    search.tolerance = own;
}

static void check_ring(rng *r) {
    const btg_ring *ring = &search.ring;
    btg_ring_make(&search);
    if (!ring->stands) {
        none++;
        return;
    }
    rings++;
    closed += ring->closed;
    check_about(search.p_place, r);
    check_about(search.place, r);
    for (int i = 0; i < ROUND; i++)
        check_point(along(r));
    for (int i = 0; i < SPREAD; i++)
        check_point((btg_place){ring->item, ring->u + ring->half_u * rng_range(r, -1, 1),
                                ring->v + ring->half_v * rng_range(r, -1, 1)});
}

/* The tool as a tilt leaves it; then further over. */
static void check_place(const btg_part *part, const btg_tool *tool, void *workspace, rng *r) {
    btg_solver_def solver = btg_solver_def_default();
    btg_drop_query query = btg_position_drop_query(rng_range(r, 0, SIZE), rng_range(r, 0, SIZE));
    btg_drop_result first;
    btg_tilt_query f;
    btg_tilt_result t;
    size_t size = btg_workspace_size(part);
    solver.tolerance_mm = pow(10, rng_range(r, -7, -3));
    solver.node_budget = 4000;
    if (btg_drop(part, tool, &solver, &query, workspace, size, &first) != BTG_OK) return;
    if (btg_position_tilt_query(tool, &solver, &query, &first, &f) != BTG_OK) return;
    if (btg_tilt(part, tool, &solver, &f, workspace, size, &t) != BTG_OK) return;
    if (f.p.place.item >= part->patch_count) return;
    search = (btg_search){.part = part, .query = btg_ray_query_tilt(tool, &f), .found = true};
    search.tolerance = pow(10, rng_range(r, -8, -4));
    search.p_place = f.p.place;
    search.place = t.contact.place;
    search.element = t.element;
    search.at = btg_ray_place(&search.query, -t.tilt_rad);
    check_ring(r);
    for (int i = 0; i < 2; i++) {
        search.at = btg_ray_place(&search.query, -t.tilt_rad - pow(10, rng_range(r, -9, -1)));
        if (i > 0) search.place.u = rng_range(r, 0, 1);
        sunk++;
        check_ring(r);
        check_least(r);
    }
}

/* ---- a fold ------------------------------------------------------------------------------- */

/* Bernstein coefficients of degree 4 of a polynomial in u - 1/2. */
static void bernstein(const double power[5], double out[5]) {
    static const double choose[5][5] = {{1}, {1, 1}, {1, 2, 1}, {1, 3, 3, 1}, {1, 4, 6, 4, 1}};
    double at_u[5] = {0};
    for (int k = 0; k < 5; k++)
        for (int i = 0; i <= k; i++)
            at_u[i] += power[k] * choose[k][i] * pow(-0.5, k - i);
    for (int i = 0; i < 5; i++) {
        out[i] = 0;
        for (int k = 0; k <= i; k++)
            out[i] += choose[i][k] / choose[4][k] * at_u[k];
    }
}

/* x = -260 (u - 1/2)^2, y = 60 (v - 1/2), z = (x + 40)^2 / 120 - y^2 / 120 - gap (u - 1/2): two
 * sheets one on top of the other, next to each other, of one patch. */
static void add_fold(model *m, double gap) {
    const double bend = 260, middle = -40, radius = 60, width = 60;
    const double in_x[5] = {0, 0, -bend, 0, 0};
    const double in_z[5] = {middle * middle / (2 * radius), -gap, bend * middle / radius, 0,
                            bend * bend / (2 * radius)};
    double x[5], z[5], sag = width * width / (8 * radius);
    bernstein(in_x, x);
    bernstein(in_z, z);
    model_surface s = model_bezier(m, 4, 2, false);
    for (int i = 0; i < 5; i++)
        for (int k = 0; k < 3; k++) {
            double *p = s.points + 3 * (3 * i + k);
            p[0] = x[i];
            p[1] = width * (k - 1) * 0.5;
            p[2] = z[i] + (k == 1 ? sag : -sag);
        }
}

/* P is on the higher sheet, the way uphill begins on the other: what is proven of that says nothing
 * of this one. */
static void check_fold(double gap) {
    model m = {0};
    add_fold(&m, gap);
    btg_part *part = model_part(&m);
    btg_tool tool = hard_tool(2);
    btg_solver_def solver = btg_solver_def_default();
    size_t size = btg_workspace_size(part);
    void *workspace = malloc(size);
    if (!part || !workspace) exit(2);
    double x = -40 + 10 + 3 * 0.17, back = 0.1, c = cos(back), sine = sin(back);
    btg_place place = {0, 0.5 - sqrt(-x / 260), 0.5};
    btg_surface_point s;
    btg_part_point(part, place, &s);
    btg_vec3 n = vec_unit(vec_cross(s.su, s.sv));
    if (n.z < 0) n = vec_scale(n, -1);
    btg_tilt_query f = {.v = vec(-c, 0, sine), .w = vec(sine, 0, c), .max_tilt_rad = 0.7};
    f.u = vec_cross(f.v, f.w);
    f.o1 = vec_mad(s.s, n, 3);
    f.p = (btg_contact){place, s.s, n};
    f.has_start = 1;
    f.start = (btg_place){0, 0.5 + sqrt((10.5 + 40) / 260), 0.5};
    btg_tilt_result t;
    btg_status status = btg_tilt(part, &tool, &solver, &f, workspace, size, &t);
    CHECK(status == BTG_OK);
    search = (btg_search){.part = part, .query = btg_ray_query_tilt(&tool, &f)};
    search.at = btg_ray_place(&search.query, -t.tilt_rad);
    double most = -INFINITY;
    for (int i = 0; i <= 1000; i++)
        for (int k = 0; k <= 100; k++)
            most = max2(most, depth_at((btg_place){0, i / 1000.0, 0.4 + k / 500.0}, &s));
    if (!(most <= t.bound_mm + ROUNDING))
        fprintf(stderr, "fold: %g deep, bound %g\n", most, t.bound_mm);
    CHECK(most <= t.bound_mm + ROUNDING);
    free(workspace);
    btg_part_destroy(part);
    model_free(&m);
}

int main(void) {
    rng r = {20261122};
    for (double gap = 1e-4; gap < 0.1; gap *= 1.5)
        check_fold(gap);
    for (int round = hard_rounds(ROUNDS); round > 0; round--) {
        model m = {0};
        if (round % 4)
            add_gentle(&m, &r);
        else
            hard_add_patch(&m, &r, (hard_patch)(round / 4 % HARD_PATCHES), SIZE);
        btg_part *part = model_part(&m);
        void *workspace = malloc(btg_workspace_size(part));
        for (int i = 0; i < PLACES && workspace; i++) {
            btg_tool tool = hard_tool((round + i) % CUTTERS);
            check_place(part, &tool, workspace, &r);
        }
        free(workspace);
        btg_part_destroy(part);
        model_free(&m);
    }
    fprintf(stderr,
            "%ld rings, %ld closed, %ld without; %ld points, the deepest %.3g of what is said\n",
            rings, closed, none, points, deepest);
    fprintf(stderr,
            "tools further over %ld: %ld covered at last, %ld of them half as deep as said, %.6g\n",
            sunk, least, sharp, sharpest);
    CHECK(rings > hard_rounds(ROUNDS) && closed > rings / 10 && none > rings / 10);
    return check_result();
}
