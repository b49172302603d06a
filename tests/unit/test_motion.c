/* The motion between positions, without DROP: how deep the moving tool is in the part is sought by
 * dense samples of part and motion with btg_tool_distance alone; over a ridge it has a closed
 * form. */
#include "bitangent/motion.h"
#include "check.h"
#include "core/motion.h"
#include "core/part.h"
#include "hard_parts.h"

#include <stdlib.h>

#define SIZE      60.0
#define ROUNDS    60
#define POINTS    14 /* of a pass */
#define GRID      40 /* samples of a patch or of a mesh's side, either way */
#define MOMENTS   24 /* of a move */
#define TOLERANCE 0.005
#define STOPS_MAX 20000
/* Of distances that are taken here, mm. */
#define ROUNDING 1e-9

typedef struct pass {
    btg_part *part;
    btg_tool tool;
    btg_backend *backend;
    btg_position given[POINTS];
    size_t sample_count;
    btg_vec3 *sample;
    btg_motion_stop *stop;
    size_t stop_count;
    btg_motion_info info;
} pass;

static long deep_before, inserted, hops, retracts, leant, solved;

/* ---- set-up ------------------------------------------------------------------------------- */

static void sample_item(pass *s, uint32_t item, int side) {
    btg_part_info info;
    btg_part_get_info(s->part, &info);
    for (int i = 0; i <= side; i++)
        for (int k = 0; k <= side; k++) {
            btg_place at = {item, (double)i / side, (double)k / side};
            if (item >= info.patch_count && i + k > side) continue;
            btg_surface_point p;
            CHECK(btg_part_evaluate(s->part, at, &p) == BTG_OK);
            s->sample[s->sample_count++] = p.s;
        }
}

static void sample_part(pass *s) {
    btg_part_info info;
    btg_part_get_info(s->part, &info);
    size_t items = info.patch_count + info.triangle_count;
    s->sample = malloc(sizeof *s->sample * (GRID + 1) * (GRID + 1) * items);
    for (size_t i = 0; i < items; i++)
        sample_item(s, (uint32_t)i, i < info.patch_count ? GRID : 5);
}

static void open_backend(pass *s) {
    btg_backend_def def = btg_backend_def_default();
    btg_solver_def solver = btg_solver_def_default();
    solver.node_budget = 100000;
    def.name = "cpu";
    def.threads = 1;
    CHECK(btg_backend_open(&def, s->part, &s->tool, &solver, &s->backend, NULL) == BTG_OK);
}

static pass make_pass(const model *m, int tool) {
    pass s = {.tool = hard_tool(tool), .part = model_part(m)};
    s.stop = malloc(sizeof *s.stop * STOPS_MAX);
    sample_part(&s);
    open_backend(&s);
    return s;
}

static void end_pass(pass *s) {
    btg_backend_close(s->backend);
    btg_part_destroy(s->part);
    free(s->sample);
    free(s->stop);
}

static void solve(pass *s, double x, double y, double dx, double dy) {
    double feet[2 * POINTS];
    for (int i = 0; i < POINTS; i++) {
        feet[2 * i] = x + i * dx;
        feet[2 * i + 1] = y + i * dy;
    }
    CHECK(btg_backend_positions(s->backend, feet, POINTS, s->given, NULL) == BTG_OK);
}

static void keep(const btg_motion_stop *stop, void *user) {
    pass *s = user;
    CHECK(s->stop_count < STOPS_MAX);
    if (s->stop_count < STOPS_MAX) s->stop[s->stop_count++] = *stop;
}

static void run(pass *s, double tolerance, double turn, int count) {
    btg_motion_def def = btg_motion_def_default();
    btg_part_info info;
    btg_part_get_info(s->part, &info);
    def.tolerance_mm = tolerance;
    def.turn_rad_per_mm = turn;
    def.clear_z_mm = info.box_max.z + 20;
    def.give = keep;
    def.user = s;
    btg_motion *moved = NULL;
    CHECK(btg_motion_create(&def, s->backend, &s->tool, &moved, NULL) == BTG_OK);
    s->stop_count = 0;
    for (int i = 0; i < count; i++)
        CHECK(btg_motion_add(moved, &s->given[i], 1) == BTG_OK);
    CHECK(btg_motion_end(moved, &s->info) == BTG_OK);
    btg_motion_destroy(moved);
}

/* ---- what is measured --------------------------------------------------------------------- */

static double depth_at(const pass *s, const btg_motion_pose *pose) {
    double ri = s->tool.def.minor_radius_mm, deep = 0;
    btg_vec3 centre = vec_mad(pose->tip, pose->axis, ri);
    double reach = s->tool.def.major_radius_mm + ri;
    for (size_t i = 0; i < s->sample_count; i++) {
        btg_vec3 arm = vec_sub(s->sample[i], centre);
        if (vec_norm2(arm) > reach * reach) continue;
        double d = btg_tool_distance(&s->tool, centre, pose->axis, s->sample[i]);
        if (-d > deep) deep = -d;
    }
    return deep;
}

static double depth_between(const pass *s, const btg_position *a, const btg_position *b) {
    btg_motion_pose from = {a->tip, a->axis}, to = {b->tip, b->axis};
    double deep = 0;
    for (int i = 0; i <= MOMENTS; i++)
        for (int chord = 0; chord < 2; chord++) {
            btg_motion_pose pose = btg_motion_at(&from, &to, (double)i / MOMENTS, chord);
            deep = fmax(deep, depth_at(s, &pose));
        }
    return deep;
}

static bool touches(const btg_position *p) {
    return p->status >= 0 && p->status != BTG_NO_CONTACT;
}

/* Deepest in the part as the positions are. */
static double depth_of_given(const pass *s) {
    double deep = 0;
    for (int i = 1; i < POINTS; i++)
        if (touches(&s->given[i - 1]) && touches(&s->given[i]))
            deep = fmax(deep, depth_between(s, &s->given[i - 1], &s->given[i]));
    return deep;
}

static bool same(const btg_position *a, const btg_position *b) {
    return a->status == b->status && a->foot_y_mm == b->foot_y_mm &&
           (!touches(a) || (a->tip.x == b->tip.x && a->tip.z == b->tip.z &&
                            a->axis.x == b->axis.x && a->tilt_rad == b->tilt_rad));
}

/* What was added comes out in order, as it was, and in between the tool stays out of the part. */
static void check_stops(const pass *s, double tolerance) {
    uint64_t next = 0;
    for (size_t i = 0; i < s->stop_count; i++) {
        const btg_motion_stop *stop = &s->stop[i];
        if (stop->kind == BTG_MOTION_GIVEN) {
            CHECK(stop->index == next && same(&stop->position, &s->given[next]));
            next++;
        } else {
            CHECK(stop->index + 1 == next);
        }
        if (!stop->link) continue;
        double deep = depth_between(s, &s->stop[i - 1].position, &stop->position);
        CHECK_NEAR(fmax(deep, tolerance), tolerance, ROUNDING);
        CHECK(deep <= s->info.bound_mm + ROUNDING);
    }
    CHECK(next == POINTS);
    CHECK(s->info.bound_mm <= tolerance);
}

/* ---- any part ----------------------------------------------------------------------------- */

static void test_any(void) {
    for (int round = 0; round < hard_rounds(ROUNDS); round++) {
        rng r = rng_of(1, "motion", (uint64_t)round);
        model m = {0};
        if (round % 3 == 2)
            hard_add_mesh(&m, &r, round % 2 ? HARD_TERRAIN : HARD_RIDGE, SIZE);
        else
            hard_add_patch(&m, &r, (hard_patch)rng_pick(&r, HARD_RIPPLES), SIZE);
        pass s = make_pass(&m, rng_pick(&r, HARD_CUTTERS));
        double y = rng_range(&r, -5, 30), angle = rng_range(&r, -0.3, 0.3);
        double x = rng_range(&r, 5, SIZE - 5);
        solve(&s, x, y, 2.5 * sin(angle), 2.5 * cos(angle));
        if (depth_of_given(&s) > TOLERANCE) deep_before++;
        run(&s, TOLERANCE, 0, POINTS);
        check_stops(&s, TOLERANCE);
        inserted += (long)s.info.inserted;
        hops += (long)s.info.hops;
        retracts += (long)s.info.retracts;
        end_pass(&s);
        model_free(&m);
    }
    CHECK(deep_before >= hard_rounds(ROUNDS) / 4);
    CHECK(inserted > 0);
}

/* ---- a wall ------------------------------------------------------------------------------- */

static void add_floor(model *m, double x, double z) {
    for (int i = 0; i < 8; i++)
        for (int k = 0; k < 8; k++) {
            double x0 = x + 4 * i, y0 = 4 * k;
            model_triangle(m, vec(x0, y0, z), vec(x0 + 4, y0, z), vec(x0, y0 + 4, z));
            model_triangle(m, vec(x0 + 4, y0, z), vec(x0 + 4, y0 + 4, z), vec(x0, y0 + 4, z));
        }
}

/* The tool falls off the upper floor's edge: no position lies between above and below. */
static void test_wall(void) {
    for (int tool = 0; tool < HARD_CUTTERS; tool++) {
        model m = {0};
        add_floor(&m, 0, 20);
        add_floor(&m, 32, -10);
        pass s = make_pass(&m, tool);
        solve(&s, 24, 16, 2.2, 0.1);
        CHECK(depth_of_given(&s) > 0.1);
        run(&s, TOLERANCE, 0, POINTS);
        check_stops(&s, TOLERANCE);
        CHECK(s.info.hops > 0 && s.info.retracts == 0);
        hops += (long)s.info.hops;
        end_pass(&s);
        model_free(&m);
    }
}

/* ---- a ridge under a ball ----------------------------------------------------------------- */

/* The ball's centre goes around the ridge on an arc of its radius: each move is a chord of it. */
static void test_ridge(void) {
    const double radius = 6, from = 4;
    model m = {0};
    for (int side = -1; side <= 1; side += 2) {
        btg_vec3 a = vec(0, -30, 0), b = vec(0, 30, 0), c = vec(side * 30, -30, -30),
                 d = vec(side * 30, 30, -30);
        model_triangle(&m, a, b, c);
        model_triangle(&m, b, c, d);
    }
    pass s = make_pass(&m, 4);
    for (double tolerance = 0.5; tolerance > 1e-4; tolerance /= 3) {
        solve(&s, -from, 0, 2 * from / (POINTS - 1), 0);
        btg_position last = s.given[POINTS - 1];
        s.given[1] = last;
        run(&s, tolerance, 0, 2);
        double deepest = 0;
        for (size_t i = 1; i < s.stop_count; i++) {
            double half =
                0.5 * vec_norm(vec_sub(s.stop[i].position.tip, s.stop[i - 1].position.tip));
            deepest = fmax(deepest, radius - sqrt(radius * radius - half * half));
        }
        CHECK(s.stop_count >= 2 && deepest <= tolerance && deepest <= s.info.bound_mm);
        /* Half of the tolerance is kept for what moments miss, and halving is coarse by a factor
         * of two in length: four in depth. */
        CHECK(deepest >= tolerance / 8 || tolerance > 0.4);
        double fewest = 2 * asin(from / radius) / (2 * acos(1 - tolerance / radius));
        CHECK(s.info.inserted + 1 >= fewest && s.info.inserted <= 4 * fewest + 1);
        CHECK(s.info.hops == 0 && s.info.retracts == 0);
    }
    end_pass(&s);
    model_free(&m);
}

/* ---- moments ------------------------------------------------------------------------------ */

/* No point of the moving cutter's ring is farther from the straight way between two moments, and
 * no ball about it farther from both, than the plan says. */
static void test_moments(void) {
    rng r = rng_of(1, "moments", 0);
    for (int round = 0; round < hard_rounds(400); round++) {
        btg_tool tool = hard_tool(rng_pick(&r, HARD_CUTTERS));
        double ro = tool.def.major_radius_mm, ri = tool.def.minor_radius_mm;
        btg_motion_pose a = {vec(0, 0, 0), hard_unit(&r)}, b = a;
        double turn = rng_range(&r, 0, 1.5) * rng_range(&r, 0, 1), way = rng_range(&r, 0, 3);
        btg_vec3 side = vec_unit(vec_cross(a.axis, hard_unit(&r)));
        b.axis = vec_add(vec_scale(a.axis, cos(turn)), vec_scale(side, sin(turn)));
        b.tip = vec_scale(hard_unit(&r), way);
        double error = pow(10, rng_range(&r, -4, -1));
        btg_motion_plan plan = btg_motion_steps(&tool, &a, &b, error, 100000);
        CHECK(plan.steps > 0);
        for (int k = 0; k < 40; k++) {
            int step = rng_pick(&r, (int)plan.steps), chord = rng_pick(&r, 2);
            double t = (step + rng_range(&r, 0, 1)) / plan.steps, angle = rng_range(&r, 0, 7);
            btg_vec3 ring[3];
            for (int i = 0; i < 3; i++) {
                double at = i == 2 ? t : (double)(step + i) / plan.steps;
                bool even = !plan.both && i < 2;
                btg_motion_pose p = btg_motion_at(&a, &b, at, chord && !even);
                btg_vec3 u = vec_unit(vec_cross(vec_cross(a.axis, side), p.axis));
                btg_vec3 v = vec_cross(p.axis, u);
                btg_vec3 arm =
                    vec_add(vec_scale(u, ro * cos(angle)), vec_scale(v, ro * sin(angle)));
                ring[i] = vec_add(vec_mad(p.tip, p.axis, ri), arm);
            }
            /* A point of the ball at t, at its deepest between the two. */
            btg_vec3 n = hard_unit(&r), point = vec_mad(ring[2], n, ri);
            double missed =
                fmin(vec_norm(vec_sub(point, ring[0])), vec_norm(vec_sub(point, ring[1])));
            CHECK(missed - ri <= error + ROUNDING);
        }
    }
}

/* ---- axes --------------------------------------------------------------------------------- */

static double angle_between(btg_vec3 a, btg_vec3 b) {
    return atan2(vec_norm(vec_cross(a, b)), vec_dot(a, b));
}

static void check_turns(const pass *s, double turn) {
    for (size_t i = 0; i < s->stop_count; i++) {
        const btg_motion_stop *b = &s->stop[i];
        const btg_position *p = &b->position, *q = i > 0 ? &s->stop[i - 1].position : p;
        bool hop = b->kind == BTG_MOTION_HOP || (i > 0 && b[-1].kind == BTG_MOTION_HOP);
        if (b->link && !hop) {
            double way = hypot(p->foot_x_mm - q->foot_x_mm, p->foot_y_mm - q->foot_y_mm);
            CHECK(angle_between(p->axis, q->axis) <= turn * way + 1e-9);
            double deep = depth_between(s, q, p);
            CHECK(deep <= TOLERANCE + ROUNDING);
        }
        if (b->kind != BTG_MOTION_GIVEN || !touches(p)) continue;
        const btg_position *g = &s->given[b->index];
        CHECK(p->tilt_rad <= g->tilt_rad + 1e-12);
        CHECK_NEAR(angle_between(p->axis, vec(0, 0, 1)), p->tilt_rad, 1e-7);
        btg_vec3 centre = vec_mad(p->tip, p->axis, s->tool.def.minor_radius_mm);
        if (p->p.point.x == p->p.point.x)
            CHECK_NEAR(btg_tool_distance(&s->tool, centre, p->axis, p->p.point), 0, 1e-6);
        if (p->tilt_rad == g->tilt_rad) continue;
        CHECK(p->status == BTG_SINGLE_CONTACT && isnan(p->q.point.x));
    }
}

static void test_turns(void) {
    for (int round = 0; round < hard_rounds(20); round++) {
        rng r = rng_of(1, "turns", (uint64_t)round);
        model m = {0};
        if (round % 2)
            hard_add_mesh(&m, &r, HARD_TERRAIN, SIZE);
        else
            hard_add_patch(&m, &r, HARD_SMOOTH, SIZE);
        pass s = make_pass(&m, rng_pick(&r, 4));
        double turn = rng_range(&r, 0.2, 4) * (BTG_PI / 180);
        double x = rng_range(&r, 0, SIZE);
        solve(&s, x, rng_range(&r, -8, 30), 0, 2);
        run(&s, TOLERANCE, turn, POINTS);
        check_turns(&s, turn);
        leant += (long)s.info.leant;
        solved += (long)s.info.given;
        /* No bound: as solved. */
        run(&s, 0, 1e5, POINTS);
        CHECK(s.info.leant == 0 && s.stop_count == POINTS && isnan(s.info.bound_mm));
        end_pass(&s);
        model_free(&m);
    }
    CHECK(leant > solved / 20 && leant < 20 * solved);
}

/* ---- refusals ----------------------------------------------------------------------------- */

static void test_refusals(void) {
    model m = {0};
    model_paper(&m, 0);
    pass s = make_pass(&m, 0);
    btg_motion *moved = NULL;
    btg_message message;
    for (int k = 0; k < 6; k++) {
        btg_motion_def def = btg_motion_def_default();
        def.clear_z_mm = 100;
        def.give = keep;
        if (k == 0) def.give = NULL;
        if (k == 1) def.tolerance_mm = NAN;
        if (k == 2) def.tolerance_mm = 2;
        if (k == 3) def.clear_z_mm = NAN;
        if (k == 4) def.turn_rad_per_mm = -1;
        if (k == 5) def.closest_mm = 0;
        CHECK(btg_motion_create(&def, s.backend, &s.tool, &moved, &message) == BTG_ERROR_ARGUMENT);
    }
    CHECK(moved == NULL);
    btg_motion_destroy(NULL);
    end_pass(&s);
    model_free(&m);
}

int main(void) {
    test_any();
    test_wall();
    test_ridge();
    test_moments();
    test_turns();
    test_refusals();
    printf("%ld passes cut the part before; %ld inserted, %ld hops, %ld retracts; %ld of %ld lean "
           "less\n",
           deep_before, inserted, hops, retracts, leant, solved);
    return check_result();
}
