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
#define SECOND_ORDER_BELOW 0.08
/* Steps to the nearest place of a triangle: each doubles the digits. */
#define TRIANGLE_STEPS 4

/* How far the region reaches from a point along unit n. */
static double reach_from(const btg_region *region, btg_vec3 point, btg_vec3 n) {
    return btg_cell_reach(&region->cell, n) + vec_dot(n, vec_sub(region->cell.centre, point));
}

/* How much nearer than the tangent plane at a point says a hollow torus can be. As a function of
 * radius and height the distance is convex. On the inner side, where it falls with the radius, what
 * is left is that the radius grows by more than the way along the point's own: by
 * sqrt(x^2 + t^2) - x, x the place along that way and t aside of it. */
static double hollow_bend(const btg_search *search, const btg_region *region,
                          const btg_ray_distance *d, btg_vec3 point) {
    btg_vec3 radial = vec_cross(d->ring_tangent, search->at.axis);
    double slope = vec_dot(d->normal, radial);
    if (slope >= 0) return 0;
    double r = vec_dot(vec_sub(point, search->at.centre), radial);
    double low = r - reach_from(region, point, vec_scale(radial, -1));
    double aside = max2(reach_from(region, point, d->ring_tangent),
                        reach_from(region, point, vec_scale(d->ring_tangent, -1)));
    return -slope * (norm2(low, aside) - low);
}

/* The bound by the plane that touches the distance at a point of the region's own plane figure. */
static double bound_by_plane(const btg_search *search, const btg_region *region,
                             const btg_tool_element *e, const btg_ray_distance *d, btg_vec3 point) {
    double low = d->distance - reach_from(region, point, vec_scale(d->normal, -1));
    if (low < -search->tolerance || !e->hollow) return low;
    return low - hollow_bend(search, region, d, point);
}

/* Under the hollow: the bound by the region's extent in radius and height. Near the axis, where the
 * ring bends most, nothing else is any use. */
static double bound_by_extent(const btg_search *search, const btg_region *region,
                              const btg_tool_element *e) {
    btg_vec3 arm = vec_sub(region->cell.centre, search->at.centre), axis = search->at.axis;
    double height = vec_dot(arm, axis), r = vec_norm(vec_mad(arm, axis, -height));
    double in = e->ring_radius_mm - r - region->radius;
    double low = -(height + btg_cell_reach(&region->cell, axis));
    if (in < 0) in = 0;
    if (low < 0) low = 0;
    return sqrt(in * in + low * low) - e->corner_radius_mm;
}

/* The least of 1/2 h t^2 + g t over |t| <= 1. */
static double least_place(double g, double h) {
    if (h > fabs(g)) return -g / h;
    return g > 0 ? -1 : (g < 0 ? 1 : 0);
}

/* g p + 1/2 p H p on a plane figure, p = (s, t) from its centre. */
typedef struct figure_form {
    double ga, gb, haa, hab, hbb;
} figure_form;

typedef struct figure_place {
    double s, t;
} figure_place;

static double form_at(const figure_form *f, double s, double t) {
    return (f->ga + 0.5 * f->haa * s + f->hab * t) * s + (f->gb + 0.5 * f->hbb * t) * t;
}

/* The distance to second order about a place on the figure, its meridian's and ring's bends never
 * hollow. */
static figure_form form_about(const btg_cell *cell, const btg_ray_distance *d, figure_place at) {
    double ra = vec_dot(d->ring_tangent, cell->a), rb = vec_dot(d->ring_tangent, cell->b);
    double ma = vec_dot(d->meridian_tangent, cell->a), mb = vec_dot(d->meridian_tangent, cell->b);
    double kr = d->ring_curvature > 0 ? d->ring_curvature : 0, km = d->meridian_curvature;
    figure_form f = {vec_dot(d->normal, cell->a), vec_dot(d->normal, cell->b),
                     kr * ra * ra + km * ma * ma, kr * ra * rb + km * ma * mb,
                     kr * rb * rb + km * mb * mb};
    f.ga -= f.haa * at.s + f.hab * at.t;
    f.gb -= f.hab * at.s + f.hbb * at.t;
    return f;
}

static bool whole_least(const figure_form *f, figure_place *at) {
    double det = f->haa * f->hbb - f->hab * f->hab;
    if (!(det > 1e-12 * f->haa * f->hbb)) return false;
    at->s = (f->hab * f->gb - f->hbb * f->ga) / det;
    at->t = (f->hab * f->ga - f->haa * f->gb) / det;
    return true;
}

/* Where the form is least on the square |s|, |t| <= 1, or near that. */
static figure_place least_in_piece(const figure_form *f) {
    figure_place p;
    if (!whole_least(f, &p)) {
        p.s = least_place(f->ga, f->haa);
        p.t = least_place(f->gb + f->hab * p.s, f->hbb);
    }
    if (fabs(p.s) > 1) {
        p.s = p.s > 0 ? 1 : -1;
        p.t = least_place(f->gb + f->hab * p.s, f->hbb);
    } else if (fabs(p.t) > 1) {
        p.t = p.t > 0 ? 1 : -1;
        p.s = least_place(f->ga + f->hab * p.t, f->haa);
    }
    return p;
}

/* The least of g x + h x^2 / 2 over -1/3 <= x <= 2/3. */
static double least_on_edge(double g, double h) {
    const double low = -1.0 / 3, high = 2.0 / 3;
    if (h > 0) return min2(max2(-g / h, low), high);
    return g > 0 ? low : high;
}

/* On the triangle s, t >= -1/3, s + t <= 1/3: inside, or on one of three edges. */
static figure_place least_in_triangle(const figure_form *f) {
    const double third = 1.0 / 3;
    figure_place p, best = {0, 0};
    if (whole_least(f, &p) && p.s >= -third && p.t >= -third && p.s + p.t <= third) return p;
    double least = INFINITY;
    for (int edge = 0; edge < 3; edge++) {
        if (edge == 0)
            p = (figure_place){-third, least_on_edge(f->gb - third * f->hab, f->hbb)};
        else if (edge == 1)
            p = (figure_place){least_on_edge(f->ga - third * f->hab, f->haa), -third};
        else
            p.s = least_on_edge(f->ga - f->gb + third * (f->hab - f->hbb),
                                f->haa - 2 * f->hab + f->hbb);
        if (edge == 2) p.t = third - p.s;
        double value = form_at(f, p.s, p.t);
        if (value >= least) continue;
        least = value;
        best = p;
    }
    return best;
}

/* The plane of the cell itself: its normal from the tool outward, and its distance from all of the
 * element. At a sharp rim the distance has no curvature to look ahead by, but the cell's plane
 * leans against the rim; `along_rim`: turned until it holds the rim's tangent nearest to the cell,
 * for the rim falls off from that while it may cut into the plane of a cell that bends away.
 * False: no such plane. */
static BTG_APART bool own_plane(const btg_search *search, const btg_region *region,
                                const btg_tool_element *e, const btg_ray_distance *d,
                                bool along_rim, btg_vec3 *normal, double *distance) {
    btg_vec3 n = vec_cross(region->cell.a, region->cell.b), c = region->cell.centre;
    if (along_rim) n = vec_mad(n, d->ring_tangent, -vec_dot(n, d->ring_tangent));
    double length = vec_norm(n);
    if (!(length > 0)) return false;
    /* From outside a rim any side may be the right one: the one the tool is below. */
    double side = vec_dot(n, search->at.axis);
    if (side == 0) side = -vec_dot(n, d->normal);
    n = vec_scale(n, (side > 0 ? -1 : 1) / length);
    double along = vec_dot(n, search->at.axis), across2 = 1 - along * along;
    double support = e->ring_radius_mm * (across2 > 0 ? sqrt(across2) : 0) + e->corner_radius_mm +
                     along * e->from_mm;
    *normal = n;
    *distance = vec_dot(n, vec_sub(c, search->at.centre)) - support;
    return true;
}

/* The plane of the cell, or the same along the rim, has it in front of the element as placed. */
static bool clear_by_own_plane(const btg_search *search, const btg_region *region,
                               const btg_tool_element *e, const btg_ray_distance *d) {
    for (int along_rim = 0; along_rim < 2; along_rim++) {
        btg_vec3 n;
        double plane;
        if (own_plane(search, region, e, d, along_rim, &n, &plane) &&
            plane - btg_cell_reach(&region->cell, vec_scale(n, -1)) >= -search->tolerance)
            return true;
    }
    return false;
}

typedef enum verdict { CLEAR, NOT_CLEAR, NOT_KNOWN } verdict;

/* By planes at the centre; leaves the distance there in search->near. */
static BTG_APART verdict bound_at_centre(btg_search *search, const btg_region *region,
                                         const btg_tool_element *e) {
    btg_ray_distance *d = &search->near;
    btg_ray_measure(e, &search->at, region->cell.centre, d);
    if (d->distance - region->radius >= -search->tolerance) return CLEAR;
    if (d->distance < -search->tolerance) return NOT_CLEAR;
    double low = bound_by_plane(search, region, e, d, region->cell.centre);
    if (low >= -search->tolerance) return CLEAR;
    if (e->hollow && bound_by_extent(search, region, e) >= -search->tolerance) return CLEAR;
    if (e->corner_radius_mm > 0) return NOT_KNOWN;
    return clear_by_own_plane(search, region, e, d) ? CLEAR : NOT_CLEAR;
}

/* Newton's way to the place where the tool is nearest: the tangent plane there leaves nothing of
 * the bound's error but the figure's own. Begins with search->near. */
static BTG_APART verdict bound_at_nearest(btg_search *search, const btg_region *region,
                                          const btg_tool_element *e) {
    btg_ray_distance *near = &search->near;
    figure_place at = {0, 0};
    for (int step = region->cell.triangle ? TRIANGLE_STEPS : 1; step > 0; step--) {
        figure_form f = form_about(&region->cell, near, at);
        at = region->cell.triangle ? least_in_triangle(&f) : least_in_piece(&f);
        btg_vec3 nearest =
            vec_mad(vec_mad(region->cell.centre, region->cell.a, at.s), region->cell.b, at.t);
        btg_ray_measure(e, &search->at, nearest, near);
        double low = bound_by_plane(search, region, e, near, nearest);
        if (low >= -search->tolerance) return CLEAR;
        if (near->distance < -search->tolerance) return NOT_CLEAR;
    }
    bool worth = region->cell.item != BTG_CELL_MANY &&
                 region->radius < SECOND_ORDER_BELOW * (e->ring_radius_mm + e->corner_radius_mm) &&
                 near->distance >= -region->cell.bend;
    return worth ? NOT_KNOWN : NOT_CLEAR;
}

/* The region does not reach into the element as placed. */
static bool clear_as_placed(btg_search *search, const btg_region *region, uint32_t element) {
    const btg_tool_element *e = &search->query.tool->element[element];
    if (btg_basins_cover(search, region, element)) return true;
    verdict by_planes = bound_at_centre(search, region, e);
    if (by_planes == NOT_KNOWN) by_planes = bound_at_nearest(search, region, e);
    if (by_planes != NOT_KNOWN) return by_planes == CLEAR;
    return btg_cell_clear_to_second_order(search, region, e);
}

static BTG_APART bool clear_by_ball(const btg_search *search, const btg_region *region,
                                    uint32_t element) {
    double value;
    return !btg_ray_ball_value(&search->query, element, region->cell.centre, region->radius,
                               &value) ||
           value <= search->value;
}

/* TILT: in front of a plane, with a convex element behind it, at both ends of the turn, and no turn
 * back between. The plane has the unit normal n, from the tool outward, and stands `distance` off
 * the region's centre. */
static BTG_APART bool clear_by_turning_plane(const btg_search *search, const btg_region *region,
                                             btg_vec3 n, double distance) {
    if (distance - btg_cell_reach(&region->cell, vec_scale(n, -1)) < -search->tolerance)
        return false;
    const btg_ray_query *q = &search->query;
    btg_placement start = btg_ray_place(q, 0);
    btg_vec3 c = region->cell.centre;
    double s = sin(search->value), k = cos(search->value);
    double nv = vec_dot(n, vec_add(vec_scale(q->v, k), vec_scale(q->w, s)));
    double nw = vec_dot(n, search->at.axis);
    btg_vec3 n0 = vec_mad(vec_mad(vec_scale(q->v, nv), q->w, nw), q->u, vec_dot(n, q->u));
    double offset = vec_dot(n, vec_sub(c, search->at.centre)) - distance;
    double before = vec_dot(n0, vec_sub(c, start.centre)) - offset;
    if (before - btg_cell_reach(&region->cell, vec_scale(n0, -1)) < -search->tolerance)
        return false;
    btg_vec3 arm = vec_sub(c, q->o), g1 = vec_cross(n, q->u), g0 = vec_cross(n0, q->u);
    if (vec_dot(g1, arm) + btg_cell_reach(&region->cell, g1) <= 0) return true;
    return vec_dot(g0, arm) - btg_cell_reach(&region->cell, vec_scale(g0, -1)) >= 0;
}

/* The plane that touches the element as it starts, turned with it. */
static BTG_APART void start_plane(const btg_search *search, const btg_region *region,
                                  const btg_tool_element *e, btg_vec3 *n, double *distance) {
    const btg_ray_query *q = &search->query;
    btg_placement start = btg_ray_place(q, 0);
    btg_vec3 c = region->cell.centre;
    btg_ray_distance d;
    btg_ray_measure(e, &start, c, &d);
    double offset = vec_dot(d.normal, vec_sub(c, start.centre)) - d.distance;
    double s = sin(search->value), k = cos(search->value);
    btg_vec3 v = vec_add(vec_scale(q->v, k), vec_scale(q->w, s));
    *n = vec_mad(vec_scale(v, vec_dot(d.normal, q->v)), q->u, vec_dot(d.normal, q->u));
    *n = vec_mad(*n, search->at.axis, vec_dot(d.normal, q->w));
    *distance = vec_dot(*n, vec_sub(c, search->at.centre)) - offset;
}

/* The tool may begin right beside the part, laid over onto it, and lift from there. */
static bool clear_by_start_plane(const btg_search *search, const btg_region *region,
                                 const btg_tool_element *e) {
    btg_vec3 n;
    double distance;
    start_plane(search, region, e, &n, &distance);
    return clear_by_turning_plane(search, region, n, distance);
}

static BTG_APART bool clear_by_end_plane(btg_search *search, const btg_region *region,
                                         const btg_tool_element *e) {
    btg_ray_distance *d = &search->near;
    btg_ray_measure(e, &search->at, region->cell.centre, d);
    return clear_by_turning_plane(search, region, d->normal, d->distance);
}

/* The cell's own plane, or the same along the rim. */
static BTG_APART bool clear_by_own_turning_plane(const btg_search *search, const btg_region *region,
                                                 const btg_tool_element *e) {
    for (int along_rim = 0; along_rim < 2; along_rim++) {
        btg_vec3 n;
        double plane;
        if (own_plane(search, region, e, &search->near, along_rim, &n, &plane) &&
            clear_by_turning_plane(search, region, n, plane))
            return true;
    }
    return false;
}

static bool clear_by_turn(btg_search *search, const btg_region *region, uint32_t element) {
    const btg_tool_element *e = &search->query.tool->element[element];
    return clear_by_end_plane(search, region, e) || clear_by_start_plane(search, region, e) ||
           clear_by_own_turning_plane(search, region, e);
}

/* TILT, the cutter: a plane that stands still has all of the turn behind it. The round disc reaches
 * Ro (x + sqrt(x^2 + (n u)^2)) + Ri in front of o1, x = n v, which grows with x; x is a sine of the
 * turn. */
static bool clear_by_still_plane(const btg_search *search, const btg_region *region, btg_vec3 n) {
    const btg_ray_query *q = &search->query;
    const btg_tool_element *e = &q->tool->element[0];
    double nv = vec_dot(n, q->v), nw = vec_dot(n, q->w), nu = vec_dot(n, q->u);
    double s = sin(search->value), k = cos(search->value); /* value = - turn */
    double most = max2(nv, nv * k + nw * s);
    bool rises = -nw > 0, falls = nv * s - nw * k < 0;
    if (rises && falls) most = norm2(nv, nw);
    double reach = e->ring_radius_mm * (most + norm2(most, nu)) + e->corner_radius_mm;
    double near = vec_dot(n, vec_sub(region->cell.centre, q->o));
    return near - btg_cell_reach(&region->cell, vec_scale(n, -1)) - reach >= -search->tolerance;
}

/* By those planes. */
static BTG_APART bool clear_by_still_planes(btg_search *search, const btg_region *region) {
    const btg_tool_element *e = &search->query.tool->element[0];
    btg_ray_distance *d = &search->near;
    btg_ray_measure(e, &search->at, region->cell.centre, d);
    for (int along_rim = 0; along_rim < 2; along_rim++) {
        btg_vec3 n;
        double plane;
        if (own_plane(search, region, e, d, along_rim, &n, &plane) &&
            clear_by_still_plane(search, region, n))
            return true;
    }
    return false;
}

/* TILT, the cutter. */
static bool clear_of_cutter(btg_search *search, const btg_region *region) {
    const btg_ray_query *q = &search->query;
    btg_vec3 c = region->cell.centre;
    double height = vec_dot(vec_sub(c, search->at.centre), search->at.axis);
    if (height + region->radius <= 0) return clear_as_placed(search, region, 0);
    /* Above the equator before and after: on the way from one to the other as well. */
    if (height > region->radius && vec_dot(vec_sub(c, q->o), q->w) > region->radius) return true;
    if (clear_by_ball(search, region, 0) || clear_by_still_planes(search, region)) return true;
    return !q->tool->element[0].hollow && clear_by_turn(search, region, 0);
}

/* DROP before anything was found: no element's shadow, from number `first` on, reaches the ball
 * about the region. */
static bool outside_shadow(const btg_search *search, const btg_region *region, uint32_t first) {
    btg_vec3 d = vec_sub(region->cell.centre, search->query.o), w = search->query.w;
    double r = vec_norm(vec_mad(d, w, -vec_dot(d, w)));
    const btg_tool *tool = search->query.tool;
    for (uint32_t i = first; i < tool->element_count; i++) {
        const btg_tool_element *e = &tool->element[i];
        double x = r - e->ring_radius_mm;
        if (x < 0) x = e->hollow ? -x : 0;
        if (x - region->radius <= e->corner_radius_mm) return false;
    }
    return true;
}

/* No point of the region comes near enough to the insert's axis for the element to reach it on any
 * turn. */
static bool out_of_reach(const btg_ray_query *q, const btg_region *region, uint32_t element) {
    btg_vec3 d = vec_sub(region->cell.centre, q->o);
    const btg_tool_element *cutter = &q->tool->element[0], *e = &q->tool->element[element];
    double reach = 2 * cutter->ring_radius_mm + cutter->corner_radius_mm;
    if (element == 0) return vec_norm(d) - region->radius > reach;
    double v = vec_dot(d, q->v), w = vec_dot(d, q->w);
    return sqrt(v * v + w * w) + region->radius < e->from_mm;
}

/* TILT, shank and holder. */
static bool clear_of_the_rest(btg_search *search, const btg_region *region) {
    const btg_ray_query *q = &search->query;
    for (uint32_t i = 1; i < q->tool->element_count; i++)
        if (!out_of_reach(q, region, i) && !clear_by_ball(search, region, i) &&
            !clear_by_turn(search, region, i))
            return false;
    return true;
}

bool btg_search_clear(btg_search *search, const btg_region *region) {
    const btg_ray_query *q = &search->query;
    if (q->op == BTG_OP_DROP) {
        if (!search->found)
            return outside_shadow(search, region, 1) &&
                   (outside_shadow(search, region, 0) || clear_as_placed(search, region, 0));
        for (uint32_t i = 0; i < q->tool->element_count; i++)
            if (!clear_as_placed(search, region, i)) return false;
        return true;
    }
    return (btg_search_left_to_p(search, region, false) || clear_of_cutter(search, region)) &&
           clear_of_the_rest(search, region);
}

/* Clear but for its third-order error, and that is less along the one direction that counts. */
static BTG_APART bool clear_by_tail(btg_search *search, const btg_block_bound *bound, int k) {
    const btg_block *block = &search->block;
    uint32_t item = block->item[k];
    double without = bound->form[k] + block->error[k];
    btg_vec3 n = btg_block_normal(block, k, &search->query.tool->element[0], &search->at);
    btg_taylor taylor = {vec_dot(n, btg_block_vector(&block->at.su, k)),
                         vec_dot(n, btg_block_vector(&block->at.sv, k)),
                         vec_dot(n, btg_block_vector(&block->at.suu, k)),
                         vec_dot(n, btg_block_vector(&block->at.suv, k)),
                         vec_dot(n, btg_block_vector(&block->at.svv, k))};
    double tail = btg_patch_tail(&search->part->patches[item], n, block->u[k], block->v[k],
                                 block->hu[k], block->hv[k], &taylor, &search->tail_room);
    return without - tail >= -search->tolerance;
}

const btg_region *btg_search_region(btg_search *search, int k, bool pieces) {
    const btg_block *block = &search->block;
    btg_region *region = &search->region;
    region->radius = block->radius[k];
    if (pieces && block->triangles) {
        btg_piece piece;
        btg_block_quarter(search->part, block, k, &piece);
        btg_cell_of_triangle(search->part, &piece, &region->cell);
        region->radius = btg_cell_radius(&region->cell);
    } else if (pieces) {
        btg_cell_of_block(block, k, &region->cell);
    } else {
        btg_cell_of_child(block, k, &region->cell);
    }
    return region;
}

/* TILT, the cutter: as clear_of_cutter, of a piece that reaches above the equator. */
static BTG_APART bool high_piece_clear(btg_search *search, const btg_block_bound *bound, int k,
                                       bool pieces) {
    const btg_ray_query *q = &search->query;
    const btg_region *region = btg_search_region(search, k, pieces);
    double start = vec_dot(vec_sub(region->cell.centre, q->o), q->w);
    if (bound->height[k] > region->radius && start > region->radius) return true;
    if (out_of_reach(q, region, 0) || clear_by_ball(search, region, 0)) return true;
    return !q->tool->element[0].hollow && clear_by_turn(search, region, 0);
}

/* The elements but the cutter. */
static BTG_APART bool piece_clear_of_the_rest(btg_search *search, int k, bool pieces) {
    const btg_region *region = btg_search_region(search, k, pieces);
    if (search->query.op == BTG_OP_TILT) return clear_of_the_rest(search, region);
    if (!search->found) return outside_shadow(search, region, 1);
    for (uint32_t i = 1; i < search->query.tool->element_count; i++)
        if (!clear_as_placed(search, region, i)) return false;
    return true;
}

/* TILT: bits of the pieces that are so near P that the limits there speak for them. */
static unsigned pieces_left_to_p(btg_search *search, unsigned bits, bool pieces) {
    const btg_block *block = &search->block;
    unsigned within = 0;
    for (bits &= btg_block_small(block, sqrt(search->left_p2)); bits; bits &= bits - 1) {
        int k = btg_lowest_bit(bits);
        const btg_region *region = btg_search_region(search, k, pieces);
        if (btg_search_left_to_p(search, region, false)) within |= 1u << k;
    }
    return within;
}

/* A sharp cutter: one by one. */
static BTG_APART unsigned left_one_by_one(btg_search *search, unsigned bits, bool pieces) {
    unsigned left = bits;
    for (; bits; bits &= bits - 1) {
        int k = btg_lowest_bit(bits);
        const btg_region *region = btg_search_region(search, k, pieces);
        if (btg_search_clear(search, region)) left &= ~(1u << k);
    }
    return left;
}

/* Of quarters, those that the ring or a basin covers. */
static unsigned near_contacts(btg_search *search, unsigned bits) {
    unsigned covered = btg_ring_covering(search, bits);
    bool closed = !search->ring.stale && search->ring.closed;
    bits &= ~covered;
    return bits && !closed ? covered | btg_basins_covering(search, bits) : covered;
}

unsigned btg_search_left(btg_search *search, const btg_block_bound *bound, unsigned bits,
                         bool pieces) {
    if (!bound) return left_one_by_one(search, bits, pieces);
    bool one = search->query.tool->element_count == 1, tilt = search->query.op == BTG_OP_TILT;
    unsigned high = tilt ? bound->high : 0, left = one ? bits & (bound->deep | high) : bits;
    unsigned at_p = tilt ? pieces_left_to_p(search, left, pieces) : 0;
    unsigned deep = left & bound->deep & ~high & ~at_p;
    high &= ~at_p;
    if (deep && pieces && (tilt || search->found)) deep &= ~near_contacts(search, deep);
    unsigned clear = left & ~high & ~deep, tail = pieces ? deep & bound->tail : 0;
    for (unsigned rest = left & (high | tail); rest; rest &= rest - 1) {
        int k = btg_lowest_bit(rest);
        bool by = high >> k & 1 ? high_piece_clear(search, bound, k, pieces)
                                : clear_by_tail(search, bound, k);
        clear |= (unsigned)by << k;
    }
    for (unsigned rest = one ? 0 : clear; rest; rest &= rest - 1) {
        int k = btg_lowest_bit(rest);
        if (!piece_clear_of_the_rest(search, k, pieces)) clear &= ~(1u << k);
    }
    return left & ~clear;
}
