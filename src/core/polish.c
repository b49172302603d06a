/* Newton's way uphill on one item.
 *
 * Place the tool at the value of the point at hand: the point then lies on the tool. Where the
 * part goes deeper nearby, the value is larger; so one Newton step for the minimum of the distance
 * along the part is a step towards the maximum of the value. Both vanish together at the contact,
 * and since the value is stationary there the steps converge quadratically. */
#include "core/search.h"

#define STEPS_MAX  24
#define HALVES_MAX 10
/* Steps shorter than this part of the part's size move the value by less than its rounding. */
#define STEP_MIN 1e-13
/* From so near the next step is one of those. */
#define STEP_NEAR 1e-9

/* Gradient and Hessian of the distance along the item's parameters. */
typedef struct model {
    double gu, gv, huu, huv, hvv;
    double uu, vv; /* squared speeds: the scale of a step */
} model;

static model distance_model(const btg_search *search, const btg_surface_point *s,
                            const btg_ray_distance *d) {
    model m = {vec_dot(d->normal, s->su),
               vec_dot(d->normal, s->sv),
               vec_dot(d->normal, s->suu),
               vec_dot(d->normal, s->suv),
               vec_dot(d->normal, s->svv),
               vec_norm2(s->su),
               vec_norm2(s->sv)};
    double ru = vec_dot(d->ring_tangent, s->su), rv = vec_dot(d->ring_tangent, s->sv);
    double mu = vec_dot(d->meridian_tangent, s->su), mv = vec_dot(d->meridian_tangent, s->sv);
    m.huu += d->ring_curvature * ru * ru + d->meridian_curvature * mu * mu;
    m.huv += d->ring_curvature * ru * rv + d->meridian_curvature * mu * mv;
    m.hvv += d->ring_curvature * rv * rv + d->meridian_curvature * mv * mv;
    if (search->query.op == BTG_OP_TILT) {
        /* At P the distance and its gradient vanish at every tilt. What tells the value there is
         * distance / |S - P|^2: the Hessian of that, at distance 0. */
        btg_vec3 p = vec_sub(s->s, search->query.p);
        double k = 2 / vec_norm2(p), pu = k * vec_dot(p, s->su), pv = k * vec_dot(p, s->sv);
        m.huu -= 2 * m.gu * pu;
        m.huv -= m.gu * pv + m.gv * pu;
        m.hvv -= 2 * m.gv * pv;
    }
    return m;
}

/* Newton step of the free parameters; where the model is not convex it is bent until it is, and
 * the answer is false: no true Newton step. */
static bool newton_step(const model *m, bool free_u, bool free_v, double *du, double *dv) {
    *du = *dv = 0;
    double uu = m->uu > 0 ? m->uu : 1, vv = m->vv > 0 ? m->vv : 1;
    if (free_u && free_v) {
        /* in unit speeds */
        double scale = sqrt(uu * vv), a = m->huu / uu, b = m->huv / scale, c = m->hvv / vv;
        double mean = 0.5 * (a + c), spread = norm2(0.5 * (a - c), b);
        double least = mean - spread, most = max2(fabs(mean + spread), fabs(least));
        double lift = least < 1e-9 * most ? 1e-3 * most - least : 0;
        a += lift;
        c += lift;
        double det = a * c - b * b, gu = m->gu / sqrt(uu), gv = m->gv / sqrt(vv);
        if (!(det > 0)) return false;
        *du = (b * gv - c * gu) / det / sqrt(uu);
        *dv = (b * gu - a * gv) / det / sqrt(vv);
        return lift == 0;
    }
    double h = free_u ? m->huu : m->hvv;
    if (free_u && h != 0) *du = -m->gu / fabs(h);
    if (free_v && h != 0) *dv = -m->gv / fabs(h);
    return h > 0;
}

/* Moves a place by a step, held inside the item's domain. */
static btg_place move(const btg_search *search, btg_place from, double du, double dv) {
    btg_place to = {from.item, from.u + du, from.v + dv};
    to.u = to.u < 0 ? 0 : (to.u > 1 ? 1 : to.u);
    to.v = to.v < 0 ? 0 : (to.v > 1 ? 1 : to.v);
    if (from.item >= search->part->patch_count && to.u + to.v > 1) {
        double over = 0.5 * (to.u + to.v - 1); /* nearest point of the third side */
        to.u -= over;
        to.v -= over;
        if (to.u < 0) to = (btg_place){from.item, 0, 1};
        if (to.v < 0) to = (btg_place){from.item, 1, 0};
    }
    return to;
}

/* On the third side of a triangle with the way out barred: one parameter along it is left. */
static bool on_third_side(const model *m, btg_place at) {
    return at.u + at.v >= 1 && m->gu + m->gv < 0;
}

static bool third_side_step(const model *m, double *du, double *dv) {
    double g = m->gu - m->gv, h = m->huu - 2 * m->huv + m->hvv;
    *du = h != 0 ? -g / fabs(h) : 0;
    *dv = -*du;
    return h > 0;
}

static bool step_from(const btg_search *search, const model *m, btg_place at, double *du,
                      double *dv) {
    bool free_u = !(at.u <= 0 && m->gu > 0) && !(at.u >= 1 && m->gu < 0);
    bool free_v = !(at.v <= 0 && m->gv > 0) && !(at.v >= 1 && m->gv < 0);
    bool triangle = at.item >= search->part->patch_count;
    if (triangle && free_u && free_v && on_third_side(m, at)) return third_side_step(m, du, dv);
    bool newton = newton_step(m, free_u, free_v, du, dv);
    if (!free_u || !free_v) return newton;
    /* A step out through one side goes along that side. */
    bool out_u = (at.u <= 0 && *du < 0) || (at.u >= 1 && *du > 0);
    bool out_v = (at.v <= 0 && *dv < 0) || (at.v >= 1 && *dv > 0);
    return out_u != out_v ? newton_step(m, !out_u, !out_v, du, dv) : newton;
}

/* The value at a place; false when the tool never meets it. */
static bool look(const btg_search *search, btg_place place, btg_surface_point *s,
                 btg_ray_hit *hit) {
    btg_part_point(search->part, place, s);
    return btg_ray_cast(&search->query, s->s, hit);
}

void btg_search_polish(btg_search *search, btg_place from) {
    btg_place at = from;
    btg_surface_point *s = &search->here, *t = &search->there;
    btg_ray_hit hit;
    if (!look(search, at, s, &hit)) return;
    double shortest = STEP_MIN * search->part->scale, near = STEP_NEAR * search->part->scale;
    double rounding = search->query.op == BTG_OP_DROP ? 4e-15 * search->part->scale : 1e-14;
    double last = INFINITY; /* length of the step before */
    bool settled = false;
    for (int step = 0; step < STEPS_MAX; step++) {
        btg_placement tool = btg_ray_place(&search->query, hit.value);
        const btg_tool_element *e = &search->query.tool->element[hit.element];
        btg_ray_distance d = btg_ray_tool_distance(e, tool, s->s);
        model m = distance_model(search, s, &d);
        double du, dv;
        bool newton = step_from(search, &m, at, &du, &dv), better = false;
        for (int half = 0; half < HALVES_MAX && !better; half++, du *= 0.5, dv *= 0.5) {
            btg_place next = move(search, at, du, dv);
            btg_ray_hit other;
            double pu = next.u - at.u, pv = next.v - at.v;
            double length = sqrt(pu * pu * m.uu) + sqrt(pv * pv * m.vv);
            if (length < shortest) {
                settled = newton;
                break;
            }
            if (!look(search, next, t, &other)) continue;
            /* The value is flat on top: its last digits say nothing when a step still halves the
             * distance to the contact. */
            bool closing =
                newton && half == 0 && length < 0.5 * last && other.value > hit.value - rounding;
            if (!closing && fabs(other.value - hit.value) <= rounding) {
                settled = newton && length < near;
                break;
            }
            if (!closing && other.value < hit.value) continue;
            last = length;
            at = next;
            btg_surface_point *swap = s;
            s = t;
            t = swap;
            hit = other;
            better = true;
        }
        if (!better) break;
    }
    if (btg_search_offer(search, hit.value, at, s->s, hit.element, false))
        search->settled = settled;
    if (search->query.tool->element[hit.element].corner_radius_mm == 0)
        btg_search_polish_rim(search, at, hit.element);
}
