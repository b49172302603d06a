/* Contacts on a sharp rim: flat end mills, and the lower edge of shank and holder.
 *
 * The distance to a sharp rim has no curvature to follow, so the polish slides down to the rim and
 * stops anywhere on it. There two equations tell the contact: the point lies on the rim, r = R, and
 * the rim's tangent lies in the part's tangent plane. Newton's method solves them; on an edge of
 * the part the first one alone, along the edge. */
#include "core/search.h"

#define STEPS_MAX 12
/* Step of the central differences, part of the parameters' range: error and rounding balance. */
#define DIFFERENCE 1e-6
/* On the rim, part of its radius. */
#define ON_RIM 1e-3

/* How far outside the rim a place is, and the slope of the rim's tangent against the part. */
typedef struct rim_gap {
    double outside, slope;
} rim_gap;

/* Distance from the axis of the tool that meets the point, and its ring tangent there. */
static double rim_radius(const btg_ray_query *q, btg_vec3 s, btg_vec3 *tangent) {
    btg_vec3 d = vec_sub(s, q->o);
    if (q->op == BTG_OP_DROP) {
        btg_vec3 radial = vec_mad(d, q->w, -vec_dot(d, q->w));
        *tangent = vec_cross(q->w, vec_unit(radial));
        return vec_norm(radial);
    }
    /* the point turned up to the disc: (su, R) in its plane, the turned v axis for R */
    double su = vec_dot(d, q->u), sv = vec_dot(d, q->v), sw = vec_dot(d, q->w);
    double turned = sqrt(sv * sv + sw * sw), x = turned - q->tool->element[0].ring_radius_mm;
    btg_vec3 v = vec_unit(vec_add(vec_scale(q->v, sv), vec_scale(q->w, sw)));
    *tangent = vec_unit(vec_sub(vec_scale(v, su), vec_scale(q->u, x)));
    return sqrt(su * su + x * x);
}

static BTG_APART rim_gap gap_at(btg_search *search, double radius, btg_place at) {
    btg_surface_point *s = &search->here;
    btg_vec3 tangent;
    btg_part_point(search->part, at, s);
    rim_gap gap = {rim_radius(&search->query, s->s, &tangent) - radius, 0};
    gap.slope = vec_dot(tangent, vec_cross(s->su, s->sv));
    return gap;
}

static BTG_APART rim_gap difference(btg_search *search, double radius, btg_place at, double du,
                                    double dv) {
    btg_place a = {at.item, at.u - du, at.v - dv}, b = {at.item, at.u + du, at.v + dv};
    rim_gap low = gap_at(search, radius, a), high = gap_at(search, radius, b);
    double k = 0.5 / DIFFERENCE;
    return (rim_gap){(high.outside - low.outside) * k, (high.slope - low.slope) * k};
}

static bool in_domain(const btg_search *search, btg_place p) {
    bool box = p.u >= 0 && p.v >= 0 && p.u <= 1 && p.v <= 1;
    return box && (p.item < search->part->patch_count || p.u + p.v <= 1);
}

/* Newton along du, dv alone: r = R. */
static BTG_APART bool along_edge(btg_search *search, double radius, double du, double dv,
                                 btg_place *at) {
    for (int i = 0; i < STEPS_MAX; i++) {
        rim_gap g = gap_at(search, radius, *at);
        double d = difference(search, radius, *at, du * DIFFERENCE, dv * DIFFERENCE).outside;
        if (!(d != 0)) return false;
        double step = -g.outside / d;
        if (!(fabs(step) < 0.5)) return false;
        *at = (btg_place){at->item, at->u + du * step, at->v + dv * step};
        if (fabs(step) < 1e-15) break;
    }
    return in_domain(search, *at);
}

/* Newton in both parameters: r = R, and the tangents agree. */
static BTG_APART bool inside_face(btg_search *search, double radius, btg_place *at) {
    for (int i = 0; i < STEPS_MAX; i++) {
        rim_gap g = gap_at(search, radius, *at);
        rim_gap u = difference(search, radius, *at, DIFFERENCE, 0);
        rim_gap v = difference(search, radius, *at, 0, DIFFERENCE);
        double det = u.outside * v.slope - v.outside * u.slope;
        if (!(det != 0)) return false;
        double du = -(g.outside * v.slope - v.outside * g.slope) / det;
        double dv = -(u.outside * g.slope - g.outside * u.slope) / det;
        if (!(fabs(du) < 0.5 && fabs(dv) < 0.5)) return false;
        *at = (btg_place){at->item, at->u + du, at->v + dv};
        if (fabs(du) + fabs(dv) < 1e-15) break;
    }
    return in_domain(search, *at);
}

static BTG_APART void offer_place(btg_search *search, btg_place at) {
    const btg_surface_point *s = &search->here;
    btg_ray_hit hit;
    btg_part_point(search->part, at, &search->here);
    if (btg_ray_cast(&search->query, s->s, &hit))
        btg_search_offer(search, hit.value, at, s->s, hit.element, false);
}

/* From the place's neighbour on a side of the domain, along that side. */
static void try_side(btg_search *search, double radius, btg_place start, double du, double dv) {
    if (along_edge(search, radius, du, dv, &start)) offer_place(search, start);
}

void btg_search_polish_rim(btg_search *search, btg_place from, uint32_t element) {
    double radius = search->query.tool->element[element].ring_radius_mm;
    if (search->query.op == BTG_OP_TILT && element > 0) return;
    if (fabs(gap_at(search, radius, from).outside) > ON_RIM * radius) return;
    btg_place at = from;
    if (inside_face(search, radius, &at)) offer_place(search, at);
    bool triangle = from.item >= search->part->patch_count;
    double side_u = !triangle && from.u > 0.5 ? 1 : 0, side_v = !triangle && from.v > 0.5 ? 1 : 0;
    try_side(search, radius, (btg_place){from.item, side_u, from.v}, 0, 1);
    try_side(search, radius, (btg_place){from.item, from.u, side_v}, 1, 0);
    if (!triangle) return;
    double over = 0.5 * (1 - from.u - from.v); /* the third side */
    try_side(search, radius, (btg_place){from.item, from.u + over, from.v + over}, 1, -1);
}
