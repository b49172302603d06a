/* Newton's step towards the largest value on one item.
 *
 * The tool placed at the value V of the point at hand touches it. Where the tool moves with the
 * value by a field X (DROP: the axis; TILT: about the insert), its distance D from the item's
 * points vanishes all along V(u, v), which differentiated twice gives V's own gradient and Hessian,
 * up to the factor -1 / D_V:
 *
 *     D_i,    D_ij + D_iV V_j + D_jV V_i + D_VV V_i V_j,      V_i = -D_i / D_V,
 *     D_V = -n X,    D_iV = -(H S_i) X - n (dX S_i),    D_VV = X H X + n (dX X),
 *
 * n and H the distance's gradient and Hessian in space.
 *
 * The value's ridges run along the tool's ring. A straight step falls off them, so longer ones are
 * taken in the tool's own polar coordinates, whose second derivatives weigh the gradient. */
#include "core/step.h"

/* A step at the most: along the ring, in radii; else, part of the tool's radius. */
#define ALONG_MAX 1.0
#define STEP_MAX  0.6
/* Along the ring, in radii: a shorter step is straight. */
#define STRAIGHT 0.03
/* A triangle's side is as wide as that, in its parameters. */
#define ON_SIDE 1e-14
/* An item that stands steeper in the tool's frame has no polar coordinates (sine). */
#define STEEP 0.1

/* Gradient and Hessian along the item's parameters, of -V up to a positive factor. */
typedef struct model {
    double gu, gv, huu, huv, hvv;
    double uu, vv;   /* squared speeds: the scale of a step */
    double by_value; /* how fast the distance falls with the value, mm a unit */
} model;

/* What the tool's motion adds, s the point's derivatives along ring and meridian. */
static void add_motion(const btg_ray_query *q, const btg_surface_point *s,
                       const btg_ray_distance *d, const double ring[2], const double meridian[2],
                       model *m) {
    bool tilt = q->op == BTG_OP_TILT;
    btg_vec3 x = tilt ? vec_cross(q->u, vec_sub(s->s, q->o)) : q->w;
    double by_value = m->by_value = -vec_dot(d->normal, x);
    if (!(by_value > 0)) return;
    double t = vec_dot(d->ring_tangent, x), k = vec_dot(d->meridian_tangent, x);
    double xr = d->ring_curvature * t, xm = d->meridian_curvature * k;
    double u = -(xr * ring[0] + xm * meridian[0]), v = -(xr * ring[1] + xm * meridian[1]);
    double twice = xr * t + xm * k;
    if (tilt) {
        btg_vec3 turned = vec_cross(d->normal, q->u); /* n (u x a) = (n x u) a */
        u -= vec_dot(turned, s->su);
        v -= vec_dot(turned, s->sv);
        twice += vec_dot(turned, x);
    }
    double vu = -m->gu / by_value, vv = -m->gv / by_value;
    m->huu += (2 * u + twice * vu) * vu;
    m->huv += u * vv + v * vu + twice * vu * vv;
    m->hvv += (2 * v + twice * vv) * vv;
}

static BTG_APART void set_model(const btg_search *search, const btg_surface_point *s,
                                const btg_ray_distance *d, model *m) {
    *m = (model){.gu = vec_dot(d->normal, s->su),
                 .gv = vec_dot(d->normal, s->sv),
                 .huu = vec_dot(d->normal, s->suu),
                 .huv = vec_dot(d->normal, s->suv),
                 .hvv = vec_dot(d->normal, s->svv),
                 .uu = vec_norm2(s->su),
                 .vv = vec_norm2(s->sv)};
    double ring[2] = {vec_dot(d->ring_tangent, s->su), vec_dot(d->ring_tangent, s->sv)};
    double meridian[2] = {vec_dot(d->meridian_tangent, s->su), vec_dot(d->meridian_tangent, s->sv)};
    double kr = d->ring_curvature, km = d->meridian_curvature;
    m->huu += kr * ring[0] * ring[0] + km * meridian[0] * meridian[0];
    m->huv += kr * ring[0] * ring[1] + km * meridian[0] * meridian[1];
    m->hvv += kr * ring[1] * ring[1] + km * meridian[1] * meridian[1];
    add_motion(&search->query, s, d, ring, meridian, m);
}

/* Newton step of the free parameters; where the model is not convex it is bent until it is, and
 * the answer is false: no true Newton step. */
static bool newton_step(const model *m, bool free_u, bool free_v, double *du, double *dv) {
    *du = *dv = 0;
    double uu = m->uu > 0 ? m->uu : 1, vv = m->vv > 0 ? m->vv : 1;
    if (free_u && free_v) {
        /* convex by more than rounding, in unit speeds */
        double det = m->huu * m->hvv - m->huv * m->huv, trace = m->huu * vv + m->hvv * uu;
        if (trace > 0 && det * uu * vv > 2e-9 * trace * trace) {
            double inverse = 1 / det;
            *du = (m->huv * m->gv - m->hvv * m->gu) * inverse;
            *dv = (m->huv * m->gu - m->huu * m->gv) * inverse;
            return true;
        }
        /* in unit speeds */
        double scale = sqrt(uu * vv), a = m->huu / uu, b = m->huv / scale, c = m->hvv / vv;
        double mean = 0.5 * (a + c), spread = norm2(0.5 * (a - c), b);
        double least = mean - spread, most = max2(fabs(mean + spread), fabs(least));
        double lift = least < 1e-9 * most ? 1e-3 * most - least : 0;
        a += lift;
        c += lift;
        det = a * c - b * b;
        double gu = m->gu / sqrt(uu), gv = m->gv / sqrt(vv);
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

static bool on_third_side(btg_place at) {
    return at.u + at.v >= 1 - ON_SIDE;
}

/* Along the third side of a triangle; no further than its corners. */
static bool third_side_step(const model *m, btg_place at, double *du, double *dv) {
    double g = m->gu - m->gv, h = m->huu - 2 * m->huv + m->hvv;
    *du = h != 0 ? -g / fabs(h) : 0;
    *dv = -*du;
    bool held = (at.u <= 0 && *du < 0) || (at.v <= 0 && *dv < 0);
    if (held) *du = *dv = 0;
    return held || h > 0;
}

static BTG_APART bool step_from(const btg_search *search, const model *m, btg_place at, double *du,
                                double *dv) {
    bool free_u = !(at.u <= 0 && m->gu > 0) && !(at.u >= 1 && m->gu < 0);
    bool free_v = !(at.v <= 0 && m->gv > 0) && !(at.v >= 1 && m->gv < 0);
    bool third = btg_is_triangle(search->part, at.item) && on_third_side(at);
    *du = *dv = 0;
    if (!free_u && !free_v) return true; /* held by a corner */
    if (third && free_u && free_v && m->gu + m->gv < 0) return third_side_step(m, at, du, dv);
    bool newton = newton_step(m, free_u, free_v, du, dv);
    if (third && *du + *dv > 0) return third_side_step(m, at, du, dv);
    if (!free_u || !free_v) return newton;
    /* A step out through one side goes along that side. */
    bool out_u = (at.u <= 0 && *du < 0) || (at.u >= 1 && *du > 0);
    bool out_v = (at.v <= 0 && *dv < 0) || (at.v >= 1 && *dv > 0);
    return out_u != out_v ? newton_step(m, !out_u, !out_v, du, dv) : newton;
}

/* Where a part of the step leads, held by nothing. */
static btg_place step_end(btg_place from, const btg_step *step, double part) {
    double du = part * step->du, dv = part * step->dv;
    if (step->round) {
        /* about that turn, by the tangent of its half */
        double half = 0.5 * part * step->along / step->r, r = step->r + part * step->out;
        double scale = r / (1 + half * half);
        double along = 2 * half * scale, out = (1 - half * half) * scale - step->r;
        du = along * step->along_uv[0] + out * step->out_uv[0];
        dv = along * step->along_uv[1] + out * step->out_uv[1];
    }
    return (btg_place){from.item, from.u + du, from.v + dv};
}

/* Onto a triangle's sides where next to them. */
static btg_place into_triangle(btg_place to) {
    to.u = to.u < ON_SIDE ? 0 : to.u;
    to.v = to.v < ON_SIDE ? 0 : to.v;
    if (!on_third_side(to)) return to;
    double over = 0.5 * (to.u + to.v - 1); /* nearest point of the third side */
    to.u -= over;
    to.v -= over;
    if (to.u < ON_SIDE) to = (btg_place){to.item, 0, 1};
    if (to.v < ON_SIDE) to = (btg_place){to.item, 1, 0};
    return to;
}

btg_place btg_step_move(const btg_search *search, btg_place from, const btg_step *step,
                        double part) {
    btg_place to = step_end(from, step, part);
    to.u = to.u < 0 ? 0 : (to.u > 1 ? 1 : to.u);
    to.v = to.v < 0 ? 0 : (to.v > 1 ? 1 : to.v);
    return btg_is_triangle(search->part, from.item) ? into_triangle(to) : to;
}

/* A straight step out of a triangle ends on the side that it meets first. */
static void stop_at_side(btg_place at, btg_step *step) {
    double du = step->du, dv = step->dv, part = 1;
    if (du < 0) part = min2(part, -at.u / du);
    if (dv < 0) part = min2(part, -at.v / dv);
    if (du + dv > 0) part = min2(part, max2(1 - at.u - at.v, 0) / (du + dv));
    if (part == 1) return;
    step->newton = false;
    step->du *= part;
    step->dv *= part;
}

static bool outside_triangle(btg_place at) {
    return at.u < 0 || at.v < 0 || at.u + at.v > 1;
}

/* How far the tool's size lets a step go. */
static double step_max(const btg_search *search) {
    const btg_tool_element *e = &search->query.tool->element[0];
    return STEP_MAX * (e->ring_radius_mm + e->corner_radius_mm);
}

/* The same in polar coordinates; false: the straight step is as good. */
static BTG_APART bool step_round(const btg_search *search, const btg_surface_point *s,
                                 const btg_placement *tool, const btg_ray_distance *d,
                                 const model *m, btg_step *step) {
    btg_vec3 out = vec_cross(d->ring_tangent, tool->axis);
    double tu = vec_dot(d->ring_tangent, s->su), tv = vec_dot(d->ring_tangent, s->sv);
    double ou = vec_dot(out, s->su), ov = vec_dot(out, s->sv), det = tu * ov - tv * ou;
    double r = vec_dot(out, vec_sub(s->s, tool->centre));
    if (!(det * det > STEEP * STEEP * m->uu * m->vv) || !(r > 0)) return false;
    double inverse = 1 / det;
    double a[2] = {ov * inverse, -ou * inverse}, o[2] = {-tv * inverse, tu * inverse};
    model polar = {.uu = 1, .vv = 1};
    polar.gu = m->gu * a[0] + m->gv * a[1];
    polar.gv = m->gu * o[0] + m->gv * o[1];
    double hu = m->huu * a[0] + m->huv * a[1], hv = m->huv * a[0] + m->hvv * a[1];
    polar.huu = hu * a[0] + hv * a[1] - polar.gv / r;
    polar.huv = hu * o[0] + hv * o[1] + polar.gu / r;
    polar.hvv = (m->huu * o[0] + 2 * m->huv * o[1]) * o[0] + m->hvv * o[1] * o[1];
    double along, outward;
    bool newton = newton_step(&polar, true, true, &along, &outward);
    if (!(fabs(along) > STRAIGHT * r)) return false;
    double over =
        max2(fabs(along) / (ALONG_MAX * r), fabs(outward) / min2(step_max(search), 0.5 * r));
    double cut = over > 1 ? 1 / over : 1;
    step->newton = newton && over <= 1;
    step->round = true;
    step->r = r;
    step->along = cut * along;
    step->out = cut * outward;
    for (int i = 0; i < 2; i++) {
        step->along_uv[i] = a[i];
        step->out_uv[i] = o[i];
    }
    return true;
}

void btg_step_make(const btg_search *search, btg_place at, const btg_surface_point *point,
                   const btg_placement *tool, const btg_ray_distance *distance, btg_step *step) {
    model m;
    set_model(search, point, distance, &m);
    step->by_value = m.by_value;
    step->round = false;
    step->speed_u = sqrt(m.uu);
    step->speed_v = sqrt(m.vv);
    step->newton = step_from(search, &m, at, &step->du, &step->dv);
    double length = norm2(step->du * step->speed_u, step->dv * step->speed_v);
    bool long_way = length > STRAIGHT * step_max(search), newton = step->newton;
    bool inside = at.u > 0 && at.u < 1 && at.v > 0 && at.v < 1;
    bool triangle = btg_is_triangle(search->part, at.item);
    if (long_way && inside && step_round(search, point, tool, distance, &m, step)) {
        if (!triangle || !outside_triangle(step_end(at, step, 1))) return;
        step->round = false;
        step->newton = newton;
    }
    if (length > step_max(search)) {
        step->du *= step_max(search) / length;
        step->dv *= step_max(search) / length;
        step->newton = false;
    }
    if (triangle) stop_at_side(at, step);
}
