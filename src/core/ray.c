/* Vertical and circular rays against a cutter, in closed form.
 *
 * The idea is that of M. Singh, S. Bedi, S. Mann, "Tool Positioning in Five Axis Machining on a
 * Tensor Product Surface using Circular Rays", section 4. Its equation 13 prints a quadratic whose
 * v^2 terms in fact cancel: with d = |S - O1|^2 - Ri^2 the circle of radius R = sqrt(sv^2 + sw^2)
 * about the insert's axis meets the torus at the single v
 *
 *     Tv = Ro + d / (4 Ro) - Ro su^2 / d,        w = -+ sqrt(R^2 - Tv^2),
 *
 * and is inside where v > Tv. Flat, shank and holder are plane figures in the circle's plane:
 * a rectangle that the circle enters from below or through its far side. */
#include "core/ray.h"

/* Radius about P, in minor (or, for sharp tools, major) radii, inside which d and su^2 have lost
 * half their digits. The value is smooth along any ray from P, so over so short a way it lies
 * within 1e-7 rad of the larger of its two ends: the osculating limit and the value out there. */
#define BTG_P_CLEARANCE 1e-3

/* A point that deep inside the start pose (in radii) is a gouge, not the rounding of a contact. */
#define BTG_INSIDE 1e-9

/* A sharp rim is that wide (part of its radius), so that the point on it is met. */
#define SHARP_RIM 1e-12

btg_ray_query btg_ray_query_drop(const btg_tool *tool, const btg_drop_query *query) {
    btg_ray_query q = {.op = BTG_OP_DROP, .tool = tool, .w = query->axis, .o = query->origin};
    q.u = vec_perpendicular(query->axis);
    q.v = vec_cross(q.w, q.u);
    return q;
}

double btg_ray_insert_size(const btg_tool *tool) {
    const btg_tool_element *cutter = &tool->element[0];
    return cutter->corner_radius_mm > 0 ? cutter->corner_radius_mm : cutter->ring_radius_mm;
}

btg_ray_query btg_ray_query_tilt(const btg_tool *tool, const btg_tilt_query *query) {
    double clearance = BTG_P_CLEARANCE * btg_ray_insert_size(tool);
    btg_ray_query q = {.op = BTG_OP_TILT, .tool = tool, .o = query->o1};
    q.u = query->u;
    q.v = query->v;
    q.w = query->w;
    q.p = query->p.point;
    q.n = query->p.normal;
    q.inclination = atan2(vec_dot(q.n, q.v), vec_dot(q.n, q.w));
    q.p_clearance2 = clearance * clearance;
    return q;
}

/* Half the torus tube below height 0 at distance r from the axis; false where there is none. */
static bool profile_depth(const btg_tool_element *e, double r, double *depth) {
    double x = r - e->ring_radius_mm;
    if (!e->hollow && x < 0) x = 0;
    double inner2 = (e->corner_radius_mm - x) * (e->corner_radius_mm + x);
    if (e->corner_radius_mm == 0 && x <= SHARP_RIM * e->ring_radius_mm) inner2 = 0;
    if (inner2 < 0) return false;
    *depth = sqrt(inner2) - e->from_mm;
    return true;
}

static BTG_APART bool cast_vertical(const btg_ray_query *q, btg_vec3 s, btg_ray_hit *hit) {
    btg_vec3 d = vec_sub(s, q->o);
    double height = vec_dot(d, q->w);
    double r = vec_norm(vec_mad(d, q->w, -height));
    bool found = false;
    for (uint32_t i = 0; i < q->tool->element_count; i++) {
        double depth;
        if (!profile_depth(&q->tool->element[i], r, &depth)) continue;
        if (found && height + depth <= hit->value) continue;
        const btg_tool_element *e = &q->tool->element[i];
        bool round = i == 0 && e->corner_radius_mm > 0 && (e->hollow || r > e->ring_radius_mm);
        *hit = (btg_ray_hit){.value = height + depth, .element = i, .round = round};
        found = true;
    }
    return found;
}

/* Where a point stands in the frame of a TILT query. */
typedef struct circle {
    double su, sv, sw, radius; /* radius about the u axis */
    double d;                  /* power with respect to the insert's sphere */
} circle;

/* Turn from the point to a place (tv, tw) of its own circle: -pi .. pi. */
static double turn(const circle *c, double tv, double tw) {
    return atan2(c->sv * tw - c->sw * tv, c->sv * tv + c->sw * tw);
}

/* The point's place once turned, in the circle's plane. */
typedef struct turned {
    double v, w;
} turned;

static bool cast_torus(const btg_tool_element *e, const circle *c, double *value, turned *to) {
    double ro = e->ring_radius_mm, ri = e->corner_radius_mm;
    if (ro <= 0 || ri <= 0) return false; /* no tube: rounding alone would meet the ring */
    if (c->d <= 0) {                      /* in the insert's sphere: inside the torus at any tilt */
        *value = BTG_PI;
        return c->d < -BTG_INSIDE * ri * ri;
    }
    double tv = ro + c->d / (4 * ro) - ro * c->su * c->su / c->d;
    if (!(tv <= c->radius)) return false;
    if (tv < -c->radius) tv = -c->radius;
    double tw = sqrt((c->radius - tv) * (c->radius + tv)), beta = turn(c, tv, -tw);
    *to = (turned){tv, -tw};
    /* From below the equator the entry is less than half a turn away, ahead or, inside, behind.
     * From above it is behind when inside, and else once round. */
    if (c->sw > 0) {
        bool inside = turn(c, tv, tw) > BTG_INSIDE; /* the way out is still ahead */
        if (inside && beta > 0) beta -= 2 * BTG_PI;
        if (!inside && beta < 0) beta += 2 * BTG_PI;
    }
    *value = -beta;
    return true;
}

/* The disc of radius ro about v = ro at height w = -ri, entered from below. */
static bool cast_flat(const btg_tool_element *e, const circle *c, double *value) {
    double ro = e->ring_radius_mm, ri = e->corner_radius_mm;
    if (c->radius < ri) return false;
    double tv = sqrt((c->radius - ri) * (c->radius + ri));
    if (c->su * c->su + (tv - ro) * (tv - ro) > ro * ro * (1 + 2 * SHARP_RIM)) return false;
    double beta = turn(c, tv, -ri);
    if (c->sw > 0 && beta < 0) beta += 2 * BTG_PI;
    *value = -beta;
    return true;
}

/* Turn to an entry above the equator: behind when inside, else ahead, once round if need be. */
static double entry(const circle *c, double tv, double tw, bool inside) {
    double beta = turn(c, tv, tw);
    return beta < 0 && !inside ? beta + 2 * BTG_PI : beta;
}

/* A cylinder of shank or holder: in the circle's plane the rectangle |v - major| <= c,
 * from <= w <= to, entered from below or through the far side. */
static bool cast_cylinder(const btg_tool_element *e, double major, const circle *c, double *value) {
    double c2 = e->ring_radius_mm * e->ring_radius_mm - c->su * c->su;
    if (c2 < 0) return false;
    double half = sqrt(c2), near_v = major - half, far_v = major + half;
    double slack =
        BTG_INSIDE * e->ring_radius_mm; /* a point on the wall is met here, not once round */
    bool inside = c->sv > near_v - slack && c->sv < far_v + slack && c->sw > e->from_mm - slack &&
                  c->sw < e->to_mm + slack;
    bool found = false;
    double r2 = c->radius * c->radius;
    if (r2 >= e->from_mm * e->from_mm) {
        double tv = sqrt(r2 - e->from_mm * e->from_mm);
        if (tv >= near_v && tv <= far_v) {
            *value = -entry(c, tv, e->from_mm, inside);
            found = true;
        }
    }
    if (r2 >= far_v * far_v) {
        double tw = sqrt(r2 - far_v * far_v);
        if (tw >= e->from_mm && tw <= e->to_mm) {
            double side = -entry(c, far_v, tw, inside);
            if (!found || side > *value) *value = side;
            found = true;
        }
    }
    return found;
}

static BTG_APART bool cast_circular(const btg_ray_query *q, btg_vec3 s, btg_ray_hit *hit) {
    btg_vec3 d = vec_sub(s, q->o), dp = vec_sub(s, q->p);
    double dp2 = vec_norm2(dp);
    circle c = {.su = vec_dot(d, q->u), .sv = vec_dot(d, q->v), .sw = vec_dot(d, q->w)};
    c.radius = sqrt(c.sv * c.sv + c.sw * c.sw);
    /* d from P, not from O1: near P the difference of two squares would lose all digits. */
    c.d = dp2 - 2 * q->tool->element[0].corner_radius_mm * vec_dot(dp, q->n);
    double major = q->tool->element[0].ring_radius_mm;
    /* What leaves P's tangent plane as steeply as that stands as far from the insert's sphere as
     * the points of the clearance's rim do. */
    bool ill_posed = dp2 < q->p_clearance2 && c.d < q->p_clearance2;
    bool found = false;
    for (uint32_t i = ill_posed; i < q->tool->element_count; i++) {
        const btg_tool_element *e = &q->tool->element[i];
        double value, flat;
        turned to = {0, 0};
        bool met, round = false;
        if (i == 0) {
            met = round = cast_torus(e, &c, &value, &to);
            if (c.d <= 0) round = false;
            if (!e->hollow && cast_flat(e, &c, &flat) && (!met || flat > value)) {
                value = flat;
                met = true;
                round = false;
            }
        } else {
            met = cast_cylinder(e, major, &c, &value);
        }
        if (!met || (found && value <= hit->value)) continue;
        *hit = (btg_ray_hit){value, i, round, to.v, to.w};
        found = true;
    }
    return found;
}

bool btg_ray_ball_value(const btg_ray_query *q, uint32_t element, btg_vec3 s, double radius,
                        double *value) {
    btg_tool_element e = q->tool->element[element];
    btg_vec3 d = vec_sub(s, q->o);
    if (q->op == BTG_OP_DROP) {
        double height = vec_dot(d, q->w), depth;
        e.corner_radius_mm += radius;
        if (!profile_depth(&e, vec_norm(vec_mad(d, q->w, -height)), &depth)) return false;
        *value = height + depth;
        return true;
    }
    circle c = {.su = vec_dot(d, q->u), .sv = vec_dot(d, q->v), .sw = vec_dot(d, q->w)};
    c.radius = sqrt(c.sv * c.sv + c.sw * c.sw);
    if (element > 0) {
        e.ring_radius_mm += radius;
        e.from_mm -= radius;
        e.to_mm += radius;
        return cast_cylinder(&e, q->tool->element[0].ring_radius_mm, &c, value);
    }
    e.corner_radius_mm += radius;
    c.d = c.su * c.su + c.radius * c.radius - e.corner_radius_mm * e.corner_radius_mm;
    if (c.d <= 0) { /* the ball reaches the insert's sphere: it may be met at once */
        *value = INFINITY;
        return true;
    }
    double flat;
    turned to;
    bool met = cast_torus(&e, &c, value, &to);
    if (!e.hollow && cast_flat(&e, &c, &flat)) {
        if (!met || flat > *value) *value = flat;
        met = true;
    }
    return met;
}

bool btg_ray_cast(const btg_ray_query *query, btg_vec3 s, btg_ray_hit *hit) {
    return query->op == BTG_OP_DROP ? cast_vertical(query, s, hit) : cast_circular(query, s, hit);
}

btg_placement btg_ray_place(const btg_ray_query *q, double value) {
    if (q->op == BTG_OP_DROP) return (btg_placement){vec_mad(q->o, q->w, value), q->w, true};
    double c = cos(value), s = sin(value); /* value = -beta */
    btg_vec3 v = vec_add(vec_scale(q->v, c), vec_scale(q->w, s));
    btg_vec3 w = vec_sub(vec_scale(q->w, c), vec_scale(q->v, s));
    return (btg_placement){vec_mad(q->o, v, q->tool->element[0].ring_radius_mm), w, false};
}

/* ---- limits at P -------------------------------------------------------------------------- */

/* lambda_min = -asin(q), as a value of this query; false when q > 1: no limit. */
static bool limit_value(const btg_ray_query *query, double q, double *value) {
    if (!(q <= 1)) return false;
    *value = -asin(q < -1 ? -1 : q) - query->inclination;
    return true;
}

/* Along an edge with tangent t and second derivative tt: the sheet is this curve alone. */
static bool osculating_edge(const btg_ray_query *query, btg_vec3 t, btg_vec3 tt, double *value) {
    double ro = query->tool->element[0].ring_radius_mm;
    double ri = query->tool->element[0].corner_radius_mm;
    btg_vec3 away = vec_scale(query->n, -1), y = vec_cross(query->u, away);
    double t2 = vec_norm2(t), first = vec_dot(t, away), along = vec_dot(t, y);
    if (t2 == 0 || first * first > 1e-12 * t2) return false; /* leaves P at first order */
    double d = t2 + ri * vec_dot(tt, away);
    if (!(d > 0)) return false;
    if (ri == 0 && along * along > 1e-12 * t2) return false;
    double spread = ri > 0 ? along * along / ri : 0;
    return limit_value(query, ro * (spread + vec_dot(tt, away)) / d, value);
}

/* A slope below 1e-6 departs less than the curvature does within the clearance about P. */
static bool tangent_to_tool(const btg_ray_query *query, const btg_surface_point *f) {
    double uu = vec_norm2(f->su), vv = vec_norm2(f->sv);
    btg_vec3 normal = vec_cross(f->su, f->sv), slope = vec_cross(normal, query->n);
    bool regular = vec_norm2(normal) > 1e-20 * uu * vv && uu > 0 && vv > 0;
    return regular && vec_norm2(slope) <= 1e-12 * vec_norm2(normal);
}

/* A sheet tangent to the tool at P: 1/2 (a x^2 + 2 b x y + c y^2) away from the tool, x along u,
 * y along the insert; and the parameters of unit steps along x and y. */
typedef struct sheet {
    double a, b, c;
    double x[2], y[2];
} sheet;

static sheet sheet_at(const btg_ray_query *query, const btg_surface_point *f) {
    btg_vec3 away = vec_scale(query->n, -1), y = vec_cross(query->u, away);
    double xu = vec_dot(f->su, query->u), xv = vec_dot(f->sv, query->u);
    double yu = vec_dot(f->su, y), yv = vec_dot(f->sv, y);
    double det = xu * yv - xv * yu;
    double l = vec_dot(f->suu, away), m = vec_dot(f->suv, away), n = vec_dot(f->svv, away);
    sheet s = {.x = {yv / det, -yu / det}, .y = {-xv / det, xu / det}};
    s.a = l * s.x[0] * s.x[0] + 2 * m * s.x[0] * s.x[1] + n * s.x[1] * s.x[1];
    s.b = l * s.x[0] * s.y[0] + m * (s.x[0] * s.y[1] + s.y[0] * s.x[1]) + n * s.x[1] * s.y[1];
    s.c = l * s.y[0] * s.y[0] + 2 * m * s.y[0] * s.y[1] + n * s.y[1] * s.y[1];
    return s;
}

static bool osculating_face(const btg_ray_query *query, const btg_surface_point *f, double *value) {
    double ro = query->tool->element[0].ring_radius_mm;
    double ri = query->tool->element[0].corner_radius_mm;
    sheet s = sheet_at(query, f);
    double cy = 1 + ri * s.c, twist = 0;
    if (cy > 1e-12)
        twist = ri * s.b * s.b / cy;
    else if (s.b != 0)
        return limit_value(query, -1, value);
    double m = 1 + ri * (s.a - twist);
    if (!(m > 0)) return limit_value(query, -1, value);
    return limit_value(query, ro * (s.a - twist) / m, value);
}

bool btg_ray_ridge(const btg_ray_query *query, const btg_surface_point *f, double ridge[2],
                   double *limit) {
    double ri = query->tool->element[0].corner_radius_mm;
    if (!tangent_to_tool(query, f) || !(ri > 0) || !osculating_face(query, f, limit)) return false;
    sheet s = sheet_at(query, f);
    double cy = 1 + ri * s.c, y = cy > 1e-6 ? -ri * s.b / cy : 0, k = 1 / sqrt(1 + y * y);
    ridge[0] = k * (s.x[0] + y * s.y[0]);
    ridge[1] = k * (s.x[1] + y * s.y[1]);
    return isfinite(ridge[0]) && isfinite(ridge[1]);
}

bool btg_ray_osculating(const btg_ray_query *query, const btg_surface_point *f, bool edge_u,
                        bool edge_v, double *value) {
    if (tangent_to_tool(query, f)) return osculating_face(query, f, value);
    double other;
    bool found = edge_u && osculating_edge(query, f->sv, f->svv, value);
    if (edge_v && osculating_edge(query, f->su, f->suu, &other)) {
        if (!found || other > *value) *value = other;
        found = true;
    }
    return found;
}

bool btg_ray_tool_limit(const btg_ray_query *query, double *value) {
    const btg_tool_element *e = &query->tool->element[0];
    if (!e->hollow) return limit_value(query, 0, value);
    if (e->ring_radius_mm < e->corner_radius_mm)
        return limit_value(query, e->ring_radius_mm / e->corner_radius_mm, value);
    return false;
}

/* ---- distance ------------------------------------------------------------------------------ */

/* A point in an element's half plane: x, z from the nearest point of what the corner rounds. */
typedef struct profile {
    btg_vec3 radial; /* away from the axis, r long */
    double r, height, x, z;
} profile;

static inline profile profile_of(const btg_tool_element *e, const btg_placement *at, btg_vec3 s) {
    btg_vec3 d = vec_sub(s, at->centre);
    profile p = {.height = vec_dot(d, at->axis)};
    p.radial = vec_mad(d, at->axis, -p.height);
    p.r = vec_norm(p.radial);
    p.x = p.r - e->ring_radius_mm;
    p.z = p.height - e->from_mm;
    if (!e->hollow && p.x < 0) p.x = 0;
    if (p.z > 0) p.z = !at->swept && p.height > e->to_mm ? p.height - e->to_mm : 0;
    return p;
}

/* Apart: few points are inside. */
static BTG_APART double gap_inside(const btg_tool_element *e, const btg_placement *at, btg_vec3 s) {
    btg_ray_distance d;
    btg_ray_measure(e, at, s, &d);
    return d.distance;
}

double btg_ray_tool_gap(const btg_tool_element *e, const btg_placement *at, btg_vec3 s) {
    profile p = profile_of(e, at, s);
    double far2 = p.x * p.x + p.z * p.z;
    if (far2 > 0) return sqrt(far2) - e->corner_radius_mm;
    return gap_inside(e, at, s);
}

void btg_ray_measure(const btg_tool_element *e, const btg_placement *at, btg_vec3 s,
                     btg_ray_distance *out) {
    profile p = profile_of(e, at, s);
    double r = p.r, x = p.x, z = p.z, far = sqrt(x * x + z * z);
    btg_vec3 radial = r > 0 ? vec_scale(p.radial, 1 / r) : vec_perpendicular(at->axis);
    out->distance = far - e->corner_radius_mm;
    if (far > 0) {
        out->normal = vec_add(vec_scale(radial, x / far), vec_scale(at->axis, z / far));
    } else { /* inside: the nearer way out, down or sideways */
        double side = e->ring_radius_mm - r, down = p.height - e->from_mm;
        if (e->hollow) side = down = 0;
        out->distance -= side < down ? side : down;
        out->normal = side < down ? radial : vec_scale(at->axis, -1);
        x = side < down ? 1 : 0;
        far = 1;
    }
    out->ring_tangent = vec_cross(at->axis, radial);
    out->meridian_tangent = vec_cross(out->normal, out->ring_tangent);
    out->ring_curvature = r > 0 ? x / far / r : 0;
    out->meridian_curvature = z != 0 && (e->hollow || x > 0) ? 1 / far : 0;
}

/* On the round corner, all of it is known from the ray: no angle, and no root but the one. */
static void touch_round(const btg_ray_query *q, btg_vec3 s, const btg_placement *at,
                        btg_ray_distance *out) {
    const btg_tool_element *e = &q->tool->element[0];
    btg_vec3 d = vec_sub(s, at->centre);
    double z = vec_dot(d, at->axis);
    btg_vec3 radial = vec_mad(d, at->axis, -z);
    double r = vec_norm(radial), r1 = 1 / r, x = r - e->ring_radius_mm;
    double over = 1 / e->corner_radius_mm, nr = x * over, nz = z * over;
    radial = vec_scale(radial, r1);
    out->distance = 0;
    out->ring_curvature = nr * r1;
    out->meridian_curvature = z != 0 ? over : 0;
    out->normal = vec_add(vec_scale(radial, nr), vec_scale(at->axis, nz));
    out->ring_tangent = vec_cross(at->axis, radial);
    out->meridian_tangent = vec_cross(out->normal, out->ring_tangent);
}

void btg_ray_touch(const btg_ray_query *q, btg_vec3 s, const btg_ray_hit *hit, btg_placement *at,
                   btg_ray_distance *distance) {
    btg_vec3 d = vec_sub(s, q->o);
    double ro = q->tool->element[0].ring_radius_mm, sv = vec_dot(d, q->v), sw = vec_dot(d, q->w);
    double r2 = sv * sv + sw * sw;
    bool tilt = q->op == BTG_OP_TILT;
    if (!hit->round || (tilt && !(r2 > 0))) {
        *at = btg_ray_place(q, hit->value);
        btg_ray_measure(&q->tool->element[hit->element], at, s, distance);
        return;
    }
    if (!tilt) {
        *at = (btg_placement){vec_mad(q->o, q->w, hit->value), q->w, true};
        touch_round(q, s, at, distance);
        return;
    }
    double over = 1 / r2, cosine = (sv * hit->tv + sw * hit->tw) * over;
    double sine = (sw * hit->tv - sv * hit->tw) * over;
    btg_vec3 v = vec_add(vec_scale(q->v, cosine), vec_scale(q->w, sine));
    btg_vec3 w = vec_sub(vec_scale(q->w, cosine), vec_scale(q->v, sine));
    *at = (btg_placement){vec_mad(q->o, v, ro), w, false};
    touch_round(q, s, at, distance);
}
