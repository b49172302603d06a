/* One drop and one tilt: the search set up, run, and its answer told. */
#include "core/run.h"
#include "core/search.h"

#include <stddef.h>
#include <string.h>

/* The search's clearance is this part of the tolerance asked: what it leaves unexplored then
 * changes the answer by far less than the tolerance. */
#define SEARCH_SHARE 1e-4
/* What is so near P that the limits there speak for it may be this part of the tolerance asked
 * deep. */
#define P_SHARE 0.5
/* A sheet passes through P when it comes this close, part of the clearance about P. */
#define SHEET_GAP 0.1
/* Clearances below this part of the part's size are rounding. */
#define CLEARANCE_ROUNDING 1e-13

static btg_search *open_search(const btg_part *part, const btg_solver_def *solver,
                               void *workspace) {
    uintptr_t align = _Alignof(btg_search), at = (uintptr_t)workspace;
    btg_search *search = (btg_search *)((char *)workspace + (align - at % align) % align);
    memset(search, 0, offsetof(btg_search, tail_room)); /* what follows is room */
    search->part = part;
    search->top = 0;
    search->stack = (btg_entry *)(search + 1);
    search->stack_size = btg_search_stack_size(part);
    search->budget = solver->node_budget;
    search->rounding = CLEARANCE_ROUNDING * part->scale;
    search->tolerance = max2(SEARCH_SHARE * solver->tolerance_mm, search->rounding);
    return search;
}

/* ---- contacts ----------------------------------------------------------------------------- */

/* Normal where a sharp rim touches: the part's own where it has one. */
static btg_vec3 rim_normal(const btg_search *search, btg_vec3 tool_normal) {
    btg_surface_point s;
    btg_part_point(search->part, search->place, &s);
    btg_vec3 n = vec_unit(vec_cross(s.su, s.sv));
    const double edge = 1e-9;
    btg_place p = search->place;
    bool inside = p.u > edge && p.v > edge && p.u < 1 - edge && p.v < 1 - edge;
    if (p.item >= search->part->patch_count && p.u + p.v > 1 - edge) inside = false;
    if (!inside || vec_norm2(n) == 0) return tool_normal;
    return vec_dot(n, search->at.axis) < 0 ? vec_scale(n, -1) : n;
}

/* Rounding of all the bounds, part of the part's size. */
#define BOUND_ROUNDING 1e-12

/* What the search has proven, rounded outward; `at_p`: of what it left to the limits at P. */
static double proven_bound(const btg_search *search, double at_p) {
    return (max2(search->deepest, at_p) + BOUND_ROUNDING * search->part->scale) * (1 + 1e-12);
}

static btg_contact contact_of(const btg_search *search) {
    const btg_tool_element *e = &search->query.tool->element[search->element];
    btg_ray_distance d = btg_ray_tool_distance(e, search->at, search->point);
    btg_contact c = {search->place, search->point, vec_scale(d.normal, -1)};
    if (e->corner_radius_mm > 0) return c;
    btg_vec3 arm = vec_sub(search->point, search->at.centre);
    double height = vec_dot(arm, search->at.axis);
    double r = vec_norm(vec_mad(arm, search->at.axis, -height));
    double near_rim = 1e-6 * e->ring_radius_mm;
    bool rim = fabs(r - e->ring_radius_mm) < near_rim && fabs(height - e->from_mm) < near_rim;
    if (rim) c.normal = rim_normal(search, c.normal);
    return c;
}

/* ---- the two questions ---- */

/* Set-up and answer stand apart from the walk, so that it does not have their frames above it. */
static BTG_APART btg_search *begin_drop(const btg_part *part, const btg_tool *tool,
                                        const btg_solver_def *solver, const btg_drop_query *query,
                                        void *workspace) {
    btg_search *search = open_search(part, solver, workspace);
    search->query = btg_ray_query_drop(tool, query);
    search->value = -INFINITY;
    search->has_start = query->has_start;
    search->start = query->start;
    return search;
}

static BTG_APART btg_status end_drop(const btg_search *search, btg_drop_result *result) {
    btg_drop_result r = {.status = BTG_NO_CONTACT, .nodes = search->nodes};
    r.bound_mm = proven_bound(search, 0);
    if (search->spent) {
        r.status = search->bound > -INFINITY ? BTG_BUDGET : BTG_NO_CONTACT;
        r.height_mm = search->bound;
    } else if (search->found) {
        r.status = BTG_OK;
        r.height_mm = search->value;
        r.contact = contact_of(search);
        r.element = search->element;
    }
    *result = r;
    return r.status;
}

static btg_status drop(const btg_part *part, const btg_tool *tool, const btg_solver_def *solver,
                       const btg_drop_query *query, void *workspace, btg_drop_result *result) {
    btg_search *search = begin_drop(part, tool, solver, query, workspace);
    btg_search_run(search);
    return end_drop(search, result);
}

/* The start pose cuts deeper than the search's clearance explains. */
static bool start_gouges(const btg_search *search) {
    if (search->gouges) return true;
    return !search->osculating && search->value > 0 &&
           btg_search_start_gouges(search, search->point, search->element);
}

/* The clearance about P, where only limits speak: as wide as rays need it, and with a round corner
 * no wider than what the tool's turn about P can make of it (basin.c). */
static void clear_about_p(btg_search *search, double tolerance) {
    double deep = P_SHARE * tolerance, corner = search->query.tool->element[0].corner_radius_mm;
    btg_ray_query *q = &search->query;
    search->near_p2 = q->p_clearance2;
    if (corner > 0) q->p_clearance2 = min2(q->p_clearance2, corner * deep);
    search->left_p2 = q->p_clearance2;
    search->deep_at_p = deep;
    search->sheet_gap = min2(SHEET_GAP * sqrt(q->p_clearance2), tolerance);
}

static BTG_APART btg_search *begin_tilt(const btg_part *part, const btg_tool *tool,
                                        const btg_solver_def *solver, const btg_tilt_query *query,
                                        void *workspace) {
    btg_search *search = open_search(part, solver, workspace);
    search->query = btg_ray_query_tilt(tool, query);
    clear_about_p(search, solver->tolerance_mm);
    search->value = -query->max_tilt_rad;
    search->gouge = max2(solver->tolerance_mm, 1e-9 * search->part->scale);
    search->touch = max2(2 * search->tolerance, 1e-9 * search->part->scale);
    search->p_place = query->p.place;
    search->has_start = query->has_start;
    search->start = query->start;
    return search;
}

static BTG_APART btg_status end_tilt(btg_search *search, const btg_tilt_query *query,
                                     btg_tilt_result *result) {
    if (start_gouges(search)) return BTG_ERROR_GOUGE;
    btg_tilt_result r = {.status = BTG_SINGLE_CONTACT, .nodes = search->nodes};
    r.tilt_rad = query->max_tilt_rad;
    /* What is at P was clear of the start pose, but for what a drop leaves. */
    bool turned = (search->spent ? search->bound : search->value) < 0;
    double begun = BTG_BEGUN * search->tolerance;
    r.bound_mm = proven_bound(search, turned ? btg_search_deep_at_p(search) : begun);
    if (search->spent) {
        r.status = BTG_BUDGET;
        r.tilt_rad = search->bound < 0 ? -search->bound : 0;
    } else if (search->found) {
        r.status = search->osculating ? BTG_OSCULATING : BTG_OK;
        r.tilt_rad = search->value < 0 ? -search->value : 0;
        r.contact = search->osculating ? query->p : contact_of(search);
        r.element = search->element;
    }
    *result = r;
    return r.status;
}

static btg_status tilt(const btg_part *part, const btg_tool *tool, const btg_solver_def *solver,
                       const btg_tilt_query *query, void *workspace, btg_tilt_result *result) {
    btg_search *search = begin_tilt(part, tool, solver, query, workspace);
    btg_search_run(search);
    return end_tilt(search, query, result);
}

/* As tilt, but nothing is proven: bound_mm is infinite. */
static btg_status tilt_near(const btg_part *part, const btg_tool *tool,
                            const btg_solver_def *solver, const btg_tilt_query *query,
                            void *workspace, btg_tilt_result *result) {
    btg_search *search = begin_tilt(part, tool, solver, query, workspace);
    btg_search_run_near(search);
    return end_tilt(search, query, result);
}

/* Each build of the run phase has one of these (variant.h). */
#ifndef BTG_RUN_THIS
#define BTG_RUN_THIS     btg_run_baseline
#define BTG_VARIANT_NAME "baseline"
#endif

const btg_run BTG_RUN_THIS = {BTG_VARIANT_NAME, drop, tilt, tilt_near};
