/* When a region of the part is clear of the tool: bounds of the distance to second order.
 *
 * The tool is placed at the best value so far. A region is a plane figure plus an error; where an
 * element is convex its distance is convex too, so the tangent plane of the distance at the
 * region's centre bounds it from below, and so does any other plane that has the element behind
 * it. A hollow torus is convex but for its inner side, whose bend about the axis is subtracted.
 *
 * TILT asks for more: the tool must not have passed through the region on its way. Points enter
 * the cutter from below its equator only (ray.c: at -theta_t), so a region below the equator at
 * the end was met exactly if it is inside there. Others are bounded by the ball around them, in
 * closed form; shank and holder also by a plane that the region approaches without a turn back. */
#include "core/search.h"

/* Cells below this part of the tool's radius are worth their Taylor polynomial: the third-order
 * error of larger ones outweighs what it wins. */
#define SECOND_ORDER_BELOW 0.2

double btg_region_reach(const btg_search *search, const btg_region *region, btg_vec3 n) {
    if (region->node == BTG_REGION_CELL) return btg_cell_reach(search->part, &region->cell, n);
    const float *h = search->part->nodes[region->node].half;
    return fabs(n.x) * (double)h[0] + fabs(n.y) * (double)h[1] + fabs(n.z) * (double)h[2];
}

/* How much nearer than the tangent plane says a hollow torus can be: its inner side bends towards
 * points that stand aside from the centre's half-plane. */
static double hollow_bend(const btg_search *search, const btg_region *region,
                          const btg_tool_element *e, const btg_ray_distance *d) {
    btg_vec3 radial = vec_cross(d->ring_tangent, search->at.axis);
    double r = vec_dot(vec_sub(region->cell.centre, search->at.centre), radial);
    double low = r - btg_region_reach(search, region, vec_scale(radial, -1));
    if (low >= e->ring_radius_mm) return 0;
    if (low < 0) low = 0;
    double aside = btg_region_reach(search, region, d->ring_tangent);
    double other = btg_region_reach(search, region, vec_scale(d->ring_tangent, -1));
    if (other > aside) aside = other;
    double outward = sqrt(low * low + aside * aside) - low;
    double nearest = d->distance + e->corner_radius_mm - region->radius; /* to the ring */
    double slope = e->ring_radius_mm - low;
    return slope < nearest ? outward * slope / nearest : outward;
}

/* Distance from the element to a plane with unit normal n through the region's centre, n pointing
 * from tool to region; -INFINITY when the element reaches up for ever on that side. */
static double plane_distance(const btg_search *search, const btg_tool_element *e, btg_vec3 centre,
                             btg_vec3 n) {
    double along = vec_dot(n, search->at.axis);
    if (search->at.swept && along > 0) return -INFINITY;
    double across2 = 1 - along * along;
    double support = e->ring_radius_mm * (across2 > 0 ? sqrt(across2) : 0) + e->corner_radius_mm +
                     along * e->from_mm;
    return vec_dot(n, vec_sub(centre, search->at.centre)) - support;
}

/* The plane of the region itself: exact for plane figures, so the best close to a contact. */
static bool clear_by_own_plane(const btg_search *search, const btg_region *region,
                               const btg_tool_element *e, const btg_ray_distance *d) {
    btg_vec3 n = vec_cross(region->cell.a, region->cell.b);
    double length = vec_norm(n);
    if (!(length > 0)) return false;
    n = vec_scale(n, (vec_dot(n, d->normal) < 0 ? -1 : 1) / length);
    double plane = plane_distance(search, e, region->cell.centre, n);
    return plane - btg_region_reach(search, region, vec_scale(n, -1)) >= -search->tolerance;
}

/* The region does not reach into the element as placed. */
static bool clear_as_placed(const btg_search *search, const btg_region *region,
                            uint32_t element) {
    const btg_tool_element *e = &search->query.tool->element[element];
    for (int i = 0; i < 2; i++)
        if (search->basin[i].element == element &&
            btg_basin_covers(search, &search->basin[i], region))
            return true;
    btg_ray_distance d = btg_ray_tool_distance(e, search->at, region->cell.centre);
    if (d.distance - region->radius >= -search->tolerance) return true;
    if (d.distance < -search->tolerance) return false;
    double low = d.distance - btg_region_reach(search, region, vec_scale(d.normal, -1));
    if (low >= -search->tolerance) {
        if (!e->hollow) return true;
        if (low - hollow_bend(search, region, e, &d) >= -search->tolerance) return true;
    }
    if (region->node != BTG_REGION_CELL) return false;
    if (clear_by_own_plane(search, region, e, &d)) return true;
    return region->radius < SECOND_ORDER_BELOW * (e->ring_radius_mm + e->corner_radius_mm) &&
           btg_cell_clear_to_second_order(search, region, e);
}

static bool clear_by_ball(const btg_search *search, const btg_region *region, uint32_t element) {
    double value;
    return !btg_ray_ball_value(&search->query, element, region->cell.centre, region->radius,
                               &value) ||
           value <= search->value;
}

/* TILT, the cutter. */
static bool clear_of_cutter(const btg_search *search, const btg_region *region) {
    const btg_ray_query *q = &search->query;
    btg_vec3 c = region->cell.centre;
    double height = vec_dot(vec_sub(c, search->at.centre), search->at.axis);
    if (height + region->radius <= 0)
        return clear_as_placed(search, region, 0);
    /* Above the equator before and after: on the way from one to the other as well. */
    if (height > region->radius && vec_dot(vec_sub(c, q->o), q->w) > region->radius) return true;
    return clear_by_ball(search, region, 0);
}

/* TILT, shank and holder: behind a plane at both ends of the turn, with no turn back between. */
static bool clear_of_cylinder(const btg_search *search, const btg_region *region,
                              uint32_t element) {
    if (clear_by_ball(search, region, element)) return true;
    const btg_ray_query *q = &search->query;
    const btg_tool_element *e = &q->tool->element[element];
    btg_vec3 c = region->cell.centre;
    btg_ray_distance d = btg_ray_tool_distance(e, search->at, c);
    btg_vec3 n = d.normal;
    if (d.distance - btg_region_reach(search, region, vec_scale(n, -1)) < -search->tolerance)
        return false;
    btg_placement start = btg_ray_place(q, 0);
    double s = sin(search->value), k = cos(search->value);
    double nv = vec_dot(n, vec_add(vec_scale(q->v, k), vec_scale(q->w, s)));
    double nw = vec_dot(n, search->at.axis);
    btg_vec3 n0 = vec_mad(vec_mad(vec_scale(q->v, nv), q->w, nw), q->u, vec_dot(n, q->u));
    double offset = vec_dot(n, vec_sub(c, search->at.centre)) - d.distance;
    double before = vec_dot(n0, vec_sub(c, start.centre)) - offset;
    if (before - btg_region_reach(search, region, vec_scale(n0, -1)) < -search->tolerance)
        return false;
    btg_vec3 arm = vec_sub(c, q->o), g1 = vec_cross(n, q->u), g0 = vec_cross(n0, q->u);
    if (vec_dot(g1, arm) + btg_region_reach(search, region, g1) <= 0) return true;
    return vec_dot(g0, arm) - btg_region_reach(search, region, vec_scale(g0, -1)) >= 0;
}

/* DROP before anything was found: can any element's shadow reach the region? */
static bool outside_shadow(const btg_search *search, const btg_region *region) {
    btg_vec3 d = vec_sub(region->cell.centre, search->query.o), w = search->query.w;
    double r = vec_norm(vec_mad(d, w, -vec_dot(d, w)));
    const btg_tool *tool = search->query.tool;
    for (uint32_t i = 0; i < tool->element_count; i++) {
        const btg_tool_element *e = &tool->element[i];
        double x = r - e->ring_radius_mm;
        if (x < 0) x = e->hollow ? -x : 0;
        if (x - region->radius <= e->corner_radius_mm) return false;
    }
    return true;
}

bool btg_search_clear(const btg_search *search, const btg_region *region) {
    const btg_ray_query *q = &search->query;
    if (q->op == BTG_OP_DROP) {
        if (!search->found) return outside_shadow(search, region);
        for (uint32_t i = 0; i < q->tool->element_count; i++)
            if (!clear_as_placed(search, region, i)) return false;
        return true;
    }
    double from_p = vec_norm(vec_sub(region->cell.centre, q->p)) + region->radius;
    if (from_p * from_p < q->p_clearance2) return true; /* the limits at P speak for it */
    if (!clear_of_cutter(search, region)) return false;
    for (uint32_t i = 1; i < q->tool->element_count; i++)
        if (!clear_of_cylinder(search, region, i)) return false;
    return true;
}
