/* The proven bound: no point of the part is deeper in the placed tool than the answer says. */
#include "check.h"
#include "hard_depth.h"
#include "hard_parts.h"

#include <stdlib.h>

#define ROUNDS 300
#define PLACES 6
#define SIZE   60.0
#define BUDGET 4000 /* enough for all but a few */
/* Rounding of the check itself, mm. */
#define ROUNDING 1e-12

typedef struct setting {
    btg_part *part;
    btg_tool tool;
    btg_solver_def solver;
    void *workspace;
    size_t size;
    hard_field field;
} setting;

typedef struct pose {
    btg_vec3 centre, axis;
    const char *of;
} pose;

static long poses, tilted, spent, short_of, followed, elsewhere;
static double closest_to_bound; /* depth, part of the bound */
static double most_above;       /* bound, part of the tolerance */

static void check_bound(const setting *s, const pose *p, double bound, const btg_contact *touch) {
    hard_pose placed = {&s->tool, p->centre, p->axis};
    if (touch)
        CHECK_NEAR(hard_distance(&s->field, &placed, touch->place), 0, s->solver.tolerance_mm);
    double depth = -hard_least_distance(&s->field, &placed, touch ? &touch->place : NULL);
    poses++;
    CHECK(isfinite(bound) && bound >= 0);
    CHECK(bound <= s->solver.tolerance_mm + 1.1e-12 * s->part->scale);
    most_above = max2(most_above, bound / s->solver.tolerance_mm);
    if (!(depth <= bound + ROUNDING))
        fprintf(stderr,
                "%s: %.6g deep, bound %.6g, tolerance %g, budget %u\n  tool %g %g profile %d, "
                "centre %a %a %a, axis %a %a %a\n",
                p->of, depth, bound, s->solver.tolerance_mm, s->solver.node_budget,
                s->tool.def.major_radius_mm, s->tool.def.minor_radius_mm, (int)s->tool.def.profile,
                p->centre.x, p->centre.y, p->centre.z, p->axis.x, p->axis.y, p->axis.z);
    CHECK(depth <= bound + ROUNDING);
    closest_to_bound = max2(closest_to_bound, depth / bound);
}

/* ---- the two questions -------------------------------------------------------------------- */

static void check_tilt(const setting *s, const btg_drop_query *query,
                       const btg_drop_result *first) {
    btg_tilt_query f;
    btg_tilt_result r;
    if (btg_position_tilt_query(&s->tool, &s->solver, query, first, &f) != BTG_OK) return;
    btg_status status = btg_tilt(s->part, &s->tool, &s->solver, &f, s->workspace, s->size, &r);
    CHECK(status >= 0 || status == BTG_ERROR_GOUGE);
    if (status < 0) return;
    bool two = status == BTG_OK;
    tilted += two;
    spent += status == BTG_BUDGET;
    short_of += status == BTG_BUDGET && s->solver.node_budget == BUDGET;
    double c = cos(r.tilt_rad), sine = sin(r.tilt_rad);
    btg_vec3 v = vec_mad(vec_scale(f.v, c), f.w, -sine);
    pose p = {vec_mad(f.o1, v, s->tool.def.major_radius_mm), vec_mad(vec_scale(f.w, c), f.v, sine),
              btg_status_name(status)};
    check_bound(s, &p, r.bound_mm, two ? &r.contact : NULL);
}

static void check_place(setting *s, double x, double y) {
    static const uint32_t budget[] = {BUDGET, 1, 10, 100};
    btg_drop_query query = btg_position_drop_query(x, y);
    btg_drop_result first = {0}, r;
    for (int i = 0; i < 4; i++) {
        s->solver.node_budget = budget[i];
        btg_status status =
            btg_drop(s->part, &s->tool, &s->solver, &query, s->workspace, s->size, &r);
        CHECK(status == BTG_OK || status == BTG_NO_CONTACT || status == BTG_BUDGET);
        short_of += status == BTG_BUDGET && i == 0;
        if (i == 0) first = r;
        CHECK(first.status != BTG_NO_CONTACT || status != BTG_OK);
        CHECK(first.status != BTG_OK || status != BTG_NO_CONTACT);
        if (status == BTG_NO_CONTACT) continue;
        bool both = first.status == BTG_OK && status == BTG_BUDGET;
        CHECK(!both || r.height_mm >= first.height_mm - s->solver.tolerance_mm);
        spent += status == BTG_BUDGET;
        pose p = {vec(x, y, r.height_mm), query.axis, "drop"};
        check_bound(s, &p, r.bound_mm, status == BTG_OK ? &r.contact : NULL);
        if (first.status == BTG_OK) check_tilt(s, &query, &first);
    }
    s->solver.node_budget = BUDGET;
}

/* ---- followed ----------------------------------------------------------------------------- */

static btg_position solve(const setting *s, double x, double y, const btg_position *neighbour) {
    btg_position p = {0};
    CHECK(btg_position_follow(s->part, &s->tool, &s->solver, x, y, neighbour, s->workspace, s->size,
                              &p) >= 0);
    return p;
}

static void check_same(const setting *s, const btg_position *want, const btg_position *got) {
    bool none = want->status == BTG_NO_CONTACT;
    CHECK((got->status == BTG_NO_CONTACT) == none);
    if (none) return;
    followed++;
    pose p = {vec_mad(got->tip, got->axis, s->tool.element[0].corner_radius_mm), got->axis,
              "followed"};
    check_bound(s, &p, got->bound_mm, NULL);
    if (got->status == BTG_BUDGET || want->status == BTG_BUDGET) return;
    CHECK_NEAR(got->drop_z_mm, want->drop_z_mm, s->solver.tolerance_mm);
    /* Of two equal contacts either may be P, and then the tilt is another. */
    double p_apart = vec_norm(vec_sub(got->p.point, want->p.point));
    if (p_apart > 1e-6) {
        elsewhere++;
        return;
    }
    /* Close to P a clearance is many degrees: what is the same is that Q touches. */
    if (want->status != BTG_OK || got->status != BTG_OK) return;
    double off = btg_tool_distance(&s->tool, p.centre, p.axis, want->q.point);
    CHECK_NEAR(off, 0, s->solver.tolerance_mm + p_apart);
}

static void check_follow(const setting *s, rng *r, double x, double y) {
    btg_position want = solve(s, x, y, NULL);
    double far_x = rng_range(r, 0, SIZE), far_y = rng_range(r, 0, SIZE);
    btg_position from[3] = {solve(s, x + 0.4, y - 0.3, NULL), solve(s, far_x, far_y, NULL), want};
    uint32_t items = s->part->patch_count + s->part->triangle_count;
    from[2].p.place.item = (uint32_t)rng_pick(r, (int)items);
    from[2].q.place.item = (uint32_t)rng_pick(r, (int)items);
    from[2].p.place.u = from[2].p.place.v = from[2].q.place.u = from[2].q.place.v = 0.25;
    for (int i = 0; i < 3; i++) {
        btg_position got = solve(s, x, y, &from[i]);
        check_same(s, &want, &got);
    }
}

static void make_part(setting *s, rng *r, int round) {
    model m = {0};
    if (round % 3 != 2) hard_add_patch(&m, r, (hard_patch)(round % HARD_PATCHES), SIZE);
    if (round % 3 > 0) hard_add_mesh(&m, r, (hard_mesh)(round % HARD_MESHES), SIZE);
    s->part = model_part(&m);
    model_free(&m);
    s->size = btg_workspace_size(s->part);
    s->workspace = malloc(s->size);
    s->field = hard_field_make(s->part);
}

int main(void) {
    int rounds = hard_rounds(ROUNDS);
    for (int i = 0; i < rounds; i++) {
        rng r = rng_of(4, "bound", (uint64_t)i);
        setting s = {.solver = btg_solver_def_default()};
        s.solver.node_budget = BUDGET;
        make_part(&s, &r, i);
        for (int k = 0; k < PLACES; k++) {
            s.tool = hard_tool(rng_pick(&r, HARD_TOOLS));
            s.solver.tolerance_mm = k % 2 ? 1e-6 : 1e-3;
            /* the middle: two equal contacts on the ridges */
            double x = k == 0 ? 0.5 * SIZE : rng_range(&r, 0, SIZE), y = rng_range(&r, 0, SIZE);
            check_place(&s, x, y);
            check_follow(&s, &r, x, y);
        }
        hard_field_free(&s.field);
        free(s.workspace);
        btg_part_destroy(s.part);
    }
    printf("%ld poses (%ld tilted to Q, %ld out of budget, %ld followed, %ld of them to another "
           "P); depth at most %.3g of the bound\n",
           poses, tilted, spent, followed, elsewhere, closest_to_bound);
    printf("%ld answers short of %d nodes\n", short_of, BUDGET);
    printf("bounds of at most %.3g of the tolerance\n", most_above);
    return check_result();
}
