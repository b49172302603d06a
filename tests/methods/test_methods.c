/* Every method on the papers' three surfaces against the exact solver: how far the first contact's
 * height, the contacts and the tilt may be off says what a method's own sampling allows. */
#include "check.h"
#include "methods/method.h"

#include "../conformance/model.h"

#include <stdlib.h>
#include <string.h>

#define DEGREE (BTG_PI / 180)
/* Positions of a surface, inside it: no tool reaches over the edges. */
#define SIDE 4
#define FEET (SIDE * SIDE)

/* `tilt_degrees` holds where the contacts are farther apart than APART; elsewhere the tilt is
 * ill-posed for all that sample. Every method but one may only lean less than the exact solver
 * does, up to `more` degrees. */
#define APART 4.0

typedef struct expected {
    const char *name;
    double height_mm, p_mm, tilt_degrees, more_degrees;
} expected;

static const expected list[] = {
    {"vcrf", 1e-9, 1e-6, 1e-6, 1e-6},
    /* rays 0.004 mm apart on the second level */
    {"vcrf-grid", 1e-5, 0.05, 1, 0.05},
    /* heights are the same to 1e-6 mm, contacts at least 4 mm apart */
    {"depth", 1e-9, 1e-6, 0.01, 0.01},
    /* Newton ends at 1e-9 mm; a root that cuts less than its gouge grid shows leans too far */
    {"dst", 1e-8, 1e-6, 0.05, 0.05},
    {"direct", 1e-8, 1e-6, 0.05, 0.05},
    {"drd", 1e-9, 1e-3, 0.01, 0.01},
    {"bisection", 1e-9, 1e-3, 0.01, 0.01},
    {"sr", 1e-5, 0.05, 1, 0.02},
};

typedef struct stage {
    btg_part *part;
    btg_tool tool;
    btg_solver_def solver;
    double xy[2 * FEET];
    btg_position exact[FEET];
} stage;

static void place_feet(stage *s) {
    for (int i = 0; i < FEET; i++) {
        s->xy[2 * i] = 30.5 + 90.0 * (i / SIDE) / (SIDE - 1);
        s->xy[2 * i + 1] = 31 + 88.0 * (i % SIDE) / (SIDE - 1);
    }
}

static btg_method *open(const stage *s, const char *name) {
    btg_method_def def = btg_method_def_default();
    btg_message message = {""};
    btg_method *m = NULL;
    def.name = name;
    if (btg_method_open(&def, s->part, &s->tool, &s->solver, &m, &message) != BTG_OK)
        printf("%s: %s\n", name, message.text);
    CHECK(m != NULL);
    return m;
}

static void solve(const stage *s, const char *name, btg_position *out) {
    btg_method *m = open(s, name);
    CHECK(btg_backend_positions(btg_method_front(m), s->xy, FEET, out, NULL) == BTG_OK);
    btg_method_close(m);
}

static double apart(btg_vec3 a, btg_vec3 b) {
    return vec_norm(vec_sub(a, b));
}

static void compare(const stage *s, const expected *e) {
    btg_position got[FEET];
    int tilted = 0;
    double height = 0, p = 0, tilt = 0, more = -INFINITY;
    solve(s, e->name, got);
    for (int i = 0; i < FEET; i++) {
        const btg_position *a = &s->exact[i], *b = &got[i];
        CHECK(b->status == BTG_OK || b->status == BTG_OSCULATING);
        height = fmax(height, fabs(a->drop_z_mm - b->drop_z_mm));
        p = fmax(p, apart(a->p.point, b->p.point));
        more = fmax(more, (b->tilt_rad - a->tilt_rad) / DEGREE);
        if (a->status != BTG_OK || apart(a->p.point, a->q.point) < APART) continue;
        tilt = fmax(tilt, fabs(a->tilt_rad - b->tilt_rad) / DEGREE);
        tilted++;
    }
    printf("  %-10s height %.1e mm, P %.1e mm, tilt %.1e, more %.1e degrees\n", e->name, height, p,
           tilt, more);
    CHECK(tilted > FEET / 4);
    CHECK(height <= e->height_mm && e->height_mm <= 1e-3);
    CHECK(p <= e->p_mm);
    CHECK(tilt <= e->tilt_degrees);
    CHECK(more <= e->more_degrees);
}

static void test_paper(int surface) {
    stage s = {.solver = btg_solver_def_default()};
    btg_tool_def def = btg_tool_def_default();
    model m = {0};
    CHECK(btg_tool_init(&def, &s.tool, NULL) == BTG_OK);
    s.solver.tolerance_mm = 1e-6;
    model_paper(&m, surface);
    s.part = model_part(&m);
    model_free(&m);
    place_feet(&s);
    solve(&s, "vcrf", s.exact);
    printf("%s\n", model_paper_name[surface]);
    for (size_t i = 0; i < sizeof list / sizeof *list; i++)
        compare(&s, &list[i]);
    btg_part_destroy(s.part);
}

/* No method is without its line above. */
static void test_complete(void) {
    for (size_t i = 0; i < btg_method_count(); i++) {
        btg_method_info info = btg_method_get_info(i), again;
        size_t k = 0;
        while (k < sizeof list / sizeof *list && strcmp(list[k].name, info.name) != 0)
            k++;
        CHECK(k < sizeof list / sizeof *list);
        CHECK(btg_method_find(info.name, &again) && again.summary == info.summary);
    }
    btg_method_info info;
    CHECK(!btg_method_find("magic", &info));
}

static btg_part *triangle_part(void) {
    model m = {0};
    model_triangle(&m, vec(0, 0, 0), vec(100, 0, 1), vec(0, 100, 2));
    btg_part *part = model_part(&m);
    model_free(&m);
    return part;
}

static void refuse(const stage *s, btg_method_def def, btg_status why, const char *say) {
    btg_message message = {""};
    btg_method *m = NULL;
    CHECK(btg_method_open(&def, s->part, &s->tool, &s->solver, &m, &message) == why);
    CHECK(!m && strstr(message.text, say));
}

static void test_refusals(void) {
    stage s = {.part = triangle_part(), .solver = btg_solver_def_default()};
    btg_tool_def tool = btg_tool_def_default();
    CHECK(btg_tool_init(&tool, &s.tool, NULL) == BTG_OK);
    btg_method_def def = btg_method_def_default();
    def.name = "magic";
    refuse(&s, def, BTG_ERROR_ARGUMENT, "unknown");
    def.name = "vcrf-grid";
    def.ray_spacing_mm = 1e-3;
    refuse(&s, def, BTG_ERROR_UNSUPPORTED, "--ray-spacing");
    def.ray_spacing_mm = 0;
    refuse(&s, def, BTG_ERROR_ARGUMENT, "spacing");
    def = btg_method_def_default();
    def.levels = 3;
    refuse(&s, def, BTG_ERROR_ARGUMENT, "levels");
    def = btg_method_def_default();
    def.name = "sr";
    def.backend.name = "cpu";
    refuse(&s, def, BTG_ERROR_ARGUMENT, "--backend");
    def.backend.name = "auto";
    s.solver.spin = BTG_SPIN_ACROSS;
    refuse(&s, def, BTG_ERROR_UNSUPPORTED, "--spin");
    s.solver.spin = BTG_SPIN_NONE;
    static const char *const surfaces_only[] = {"dst", "drd", "direct", "bisection"};
    for (int i = 0; i < 4; i++) {
        def.name = surfaces_only[i];
        refuse(&s, def, BTG_ERROR_UNSUPPORTED, "triangles");
    }
    btg_part_destroy(s.part);
    model m = {0};
    model_paper(&m, 0);
    s.part = model_part(&m);
    model_free(&m);
    tool.profile = BTG_PROFILE_BULLNOSE;
    CHECK(btg_tool_init(&tool, &s.tool, NULL) == BTG_OK);
    refuse(&s, def, BTG_ERROR_UNSUPPORTED, "toroidal");
    btg_part_destroy(s.part);
}

/* Triangles have rays too: a plane that leans, where the drop is closed form. */
static void test_plane(void) {
    stage s = {.part = triangle_part(), .solver = btg_solver_def_default()};
    btg_tool_def tool = btg_tool_def_default();
    CHECK(btg_tool_init(&tool, &s.tool, NULL) == BTG_OK);
    const double xy[2] = {30, 30};
    btg_vec3 n = vec_unit(vec(-0.01, -0.02, 1));
    double plane = 0.01 * 30 + 0.02 * 30;
    double want = plane + (6 + 6.7 * hypot(n.x, n.y)) / n.z;
    for (size_t i = 0; i < btg_method_count(); i++) {
        btg_method_def def = btg_method_def_default();
        btg_message message;
        btg_method *m;
        btg_position p;
        def.name = btg_method_get_info(i).name;
        btg_status status = btg_method_open(&def, s.part, &s.tool, &s.solver, &m, &message);
        if (status == BTG_ERROR_UNSUPPORTED) continue;
        CHECK(status == BTG_OK);
        CHECK(btg_backend_positions(btg_method_front(m), xy, 1, &p, NULL) == BTG_OK);
        CHECK_NEAR(p.drop_z_mm, want, 1e-4);
        btg_method_close(m);
    }
    btg_part_destroy(s.part);
}

int main(void) {
    test_complete();
    test_refusals();
    test_plane();
    for (int i = 0; i < MODEL_PAPERS; i++)
        test_paper(i);
    return check_result();
}
