/* Drop, spin and tilt by Newton's method against the closed-form spin, on random surfaces of
 * bidegree 2 to 5, as the drop-spin-tilt paper has them: the same positions. The two share no step
 * of the way: the one solves the paper's equations from random seeds, the other searches the part
 * for the largest angle of a closed form. */
#include "check.h"
#include "methods/method.h"

#include "../conformance/model.h"
#include "../conformance/rng.h"

#include <stdlib.h>
#include <string.h>

#define DEGREE (BTG_PI / 180)
#define SIDE   150.0
#define FEET   40

#define SAME_MM      1e-5
#define SAME_DEGREES 1e-4

typedef struct tally {
    int compared, same;
} tally;

/* Hills low enough for the tool to fit in; `warp`: x and y of the net off their even places. */
static btg_part *make_part(rng *r, int degree, double warp) {
    model m = {0};
    model_surface net = model_bezier(&m, degree, degree, false);
    for (int i = 0; i <= degree; i++)
        for (int j = 0; j <= degree; j++) {
            double *p = &net.points[3 * (i * (degree + 1) + j)];
            p[0] = SIDE * i / degree + rng_range(r, -warp, warp);
            p[1] = SIDE * j / degree + rng_range(r, -warp, warp);
            p[2] = rng_range(r, 0, 25);
        }
    btg_part *part = model_part(&m);
    model_free(&m);
    return part;
}

static btg_method_counts solve(const btg_part *part, const btg_tool *tool,
                               const btg_solver_def *solver, const char *name, const double *xy,
                               btg_position *out) {
    btg_method_def def = btg_method_def_default();
    btg_message message;
    btg_method *m = NULL;
    def.name = name;
    CHECK(btg_method_open(&def, part, tool, solver, &m, &message) == BTG_OK);
    CHECK(btg_backend_positions(btg_method_front(m), xy, FEET, out, NULL) == BTG_OK);
    btg_method_counts counts = btg_method_get_counts(m);
    btg_method_close(m);
    return counts;
}

static bool inside(const btg_contact *c) {
    return c->place.u > 0 && c->place.u < 1 && c->place.v > 0 && c->place.v < 1;
}

/* Contacts on the part's edge are beyond the paper's equations, and a search of ours that ends
 * early is no answer to compare with. */
static bool comparable(const btg_position *exact) {
    if (exact->status == BTG_OSCULATING) return inside(&exact->p);
    return exact->status == BTG_OK && inside(&exact->p) && inside(&exact->q);
}

static void compare(const btg_position *exact, const btg_position *newton, tally *t) {
    for (int i = 0; i < FEET; i++) {
        const btg_position *a = &exact[i], *b = &newton[i];
        if (!comparable(a)) continue;
        t->compared++;
        CHECK(b->status != BTG_NO_CONTACT);
        CHECK_NEAR(b->drop_z_mm, a->drop_z_mm, 1e-3);
        bool same = fabs(a->tilt_rad - b->tilt_rad) <= SAME_DEGREES * DEGREE &&
                    vec_norm(vec_sub(a->tip, b->tip)) <= SAME_MM;
        t->same += same;
    }
}

static void test_degree(rng *r, int degree, double warp, const char *name, double spin) {
    btg_tool_def def = btg_tool_def_default();
    btg_solver_def solver = btg_solver_def_default();
    btg_position exact[FEET], newton[FEET];
    double xy[2 * FEET];
    btg_tool tool;
    tally t = {0};
    CHECK(btg_tool_init(&def, &tool, NULL) == BTG_OK);
    solver.tolerance_mm = 1e-7;
    if (spin != 0) solver.spin = BTG_SPIN_FIXED;
    solver.spin_rad = spin;
    btg_part *part = make_part(r, degree, warp);
    for (int i = 0; i < 2 * FEET; i++)
        xy[i] = rng_range(r, 20, SIDE - 20);
    solve(part, &tool, &solver, "vcrf", xy, exact);
    btg_method_counts c = solve(part, &tool, &solver, name, xy, newton);
    compare(exact, newton, &t);
    double tilts = (double)(c.tilts - c.tilts_given_up);
    printf("%-6s bidegree %d, spin %4.0f: %d of %d the same; a tilt takes %.1f seeds, %.1f "
           "iterations; %d given up\n",
           name, degree, spin / DEGREE, t.same, t.compared, (double)c.tilt_seeds / tilts,
           (double)c.tilt_iterations / tilts, (int)c.tilts_given_up);
    CHECK(c.drops == FEET && c.drop_seeds >= FEET && c.drop_iterations > FEET);
    CHECK(c.tilt_seeds >= c.tilts - c.tilts_given_up && c.tilt_iterations > c.tilt_seeds);
    CHECK(c.tilt_last_iterations > 0 && c.tilt_last_iterations <= c.tilt_iterations);
    CHECK(t.compared >= FEET * 7 / 10);
    /* What is left is a root that cuts less than the gouge grid shows. */
    CHECK(t.same >= t.compared - 1);
    btg_part_destroy(part);
}

/* `direct` reads u and v off x and y, and says where it cannot. */
static void test_refusal(rng *r) {
    btg_tool_def tool_def = btg_tool_def_default();
    btg_method_def def = btg_method_def_default();
    btg_solver_def solver = btg_solver_def_default();
    btg_message message = {""};
    btg_method *m = NULL;
    btg_tool tool;
    btg_part *part = make_part(r, 3, 5);
    def.name = "direct";
    CHECK(btg_tool_init(&tool_def, &tool, NULL) == BTG_OK);
    CHECK(btg_method_open(&def, part, &tool, &solver, &m, &message) == BTG_ERROR_UNSUPPORTED);
    CHECK(!m && strstr(message.text, "linear"));
    btg_part_destroy(part);
}

int main(void) {
    rng r = rng_of(7, "newton", 0);
    for (int degree = 2; degree <= 5; degree++) {
        test_degree(&r, degree, 0, "dst", 0);
        test_degree(&r, degree, 0, "dst", 40 * DEGREE);
        test_degree(&r, degree, 0, "direct", 0);
    }
    test_degree(&r, 3, 5, "dst", -70 * DEGREE);
    test_refusal(&r);
    return check_result();
}
