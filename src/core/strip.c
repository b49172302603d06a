/* The strip that a placed tool machines, as geometry has it at one instant: cut the part by planes
 * along the feed. Where a plane, at station s across the feed, comes as close as c(s) to the tool,
 * material of that thickness stays once the tool has passed, as long as tool and part stay to each
 * other as they are. c is 0 at both contacts; the strip is where c <= scallop.
 *
 * c(s) is followed from a contact outward by Newton's method for the least distance in the plane:
 * step (du, dv) with a . S(u, v) = s, and L, the second derivatives of distance - slope * station,
 * positive along the plane. Slope and bend of c then say how far the scallop is. */
#include "core/strip.h"

/* The longest step, part of the cutter's radius, so that no bump between contacts is leapt over. */
#define STEP 0.15
/* Steps of a walk at the most: twice across the tool, and then some to meet the scallop. */
#define STEPS_MAX 64
/* Where the clearance is the scallop to that part of it, its slope and bend tell the end. */
#define END 0.05
/* Or where steps are that short, part of the cutter's radius. */
#define LEAST 2e-5

/* Newton's steps onto a plane; arrived that close to it, for any plane nearby will do, and to the
 * least distance in it (parts of the longest step: what is off then changes the distance by its
 * square). */
#define CORRECTIONS 5
#define ARRIVED     0.02
#define OFF         0.12

/* A crest is known to that part of it; this near the scallop it does not tell whether there is a
 * gap. */
#define CREST      0.02
#define CREST_NEAR 0.05
/* Contacts so close to each other, part of the cutter's radius, may stand in two valleys that cross
 * between them: what is outward of one is then nearer to the tool in the other's. */
#define CLOSE 0.1

/* A place of the walk and c there, with the derivatives that lead on. */
typedef struct stand {
    btg_place place;
    double station, clearance;
    double slope, bend;      /* c' and c'' */
    double step_u, step_v;   /* along the walk, a unit of station */
    double stretch;          /* its length on the part */
    double right_u, right_v; /* correction back to the least distance in the plane */
    double off;              /* its length */
} stand;

/* ---- the patches of one surface stand side by side ---------------------------------------- */

/* First patch after `item` (step 1) or before it (step -1) that is not in its column, and of the
 * same surface; UINT32_MAX: none. Columns run along v. */
static uint32_t column_end(const btg_part *part, uint32_t item, int step) {
    const btg_patch *here = &part->patches[item];
    for (uint32_t i = item;; i += (uint32_t)step) {
        const btg_patch *p = &part->patches[i];
        if (p->surface != here->surface) return UINT32_MAX;
        if (p->domain_u[0] != here->domain_u[0]) return i;
        if (step > 0 ? i + 1 >= part->patch_count : i == 0) return UINT32_MAX;
    }
}

/* The patch of the next or last column at the same height. */
static uint32_t beside(const btg_part *part, uint32_t item, int step) {
    double low = part->patches[item].domain_v[0];
    uint32_t i = column_end(part, item, step);
    if (i == UINT32_MAX) return i;
    double column = part->patches[i].domain_u[0];
    for (;; i += (uint32_t)step) {
        const btg_patch *p = &part->patches[i];
        if (p->domain_u[0] != column) return UINT32_MAX;
        if (p->domain_v[0] == low) return i;
        if (step > 0 ? i + 1 >= part->patch_count : i == 0) return UINT32_MAX;
    }
}

static uint32_t above(const btg_part *part, uint32_t item, int step) {
    uint32_t i = item + (uint32_t)step;
    if (step < 0 ? item == 0 : i >= part->patch_count) return UINT32_MAX;
    const btg_patch *here = &part->patches[item], *p = &part->patches[i];
    return p->surface == here->surface && p->domain_u[0] == here->domain_u[0] ? i : UINT32_MAX;
}

/* Over one side of the patch onto its neighbour; false: there is none, and the place is put on the
 * side. `t`, `domain`: the coordinate that left, and its piece of the surface's domain. */
static bool cross_side(const btg_part *part, btg_place *place, bool along_u) {
    double *t = along_u ? &place->u : &place->v;
    if (*t >= 0 && *t <= 1) return true;
    int step = *t > 1 ? 1 : -1;
    uint32_t next = along_u ? beside(part, place->item, step) : above(part, place->item, step);
    if (next == UINT32_MAX) {
        *t = step > 0 ? 1 : 0;
        return false;
    }
    const btg_patch *a = &part->patches[place->item], *b = &part->patches[next];
    const double *da = along_u ? a->domain_u : a->domain_v;
    const double *db = along_u ? b->domain_u : b->domain_v;
    double at = da[0] + *t * (da[1] - da[0]);
    *t = fmin(fmax((at - db[0]) / (db[1] - db[0]), 0), 1);
    place->item = next;
    return true;
}

/* ---- one stand ---------------------------------------------------------------------------- */

/* What limits the parameters at a place: 1 on a side of the whole surface that the step leaves. */
typedef struct held {
    bool u, v;
} held;

/* Second derivative of the distance along two directions of the part. */
static double bend_of(const btg_ray_distance *d, btg_vec3 x, btg_vec3 y) {
    return d->ring_curvature * vec_dot(x, d->ring_tangent) * vec_dot(y, d->ring_tangent) +
           d->meridian_curvature * vec_dot(x, d->meridian_tangent) *
               vec_dot(y, d->meridian_tangent);
}

/* From the point at the place. */
static BTG_APART bool look_from(const btg_strip_query *q, stand *at, double slope, held hold,
                                const btg_surface_point *point) {
    btg_ray_distance d;
    btg_ray_measure(&q->tool->element[0], &q->pose, point->s, &d);
    double au = vec_dot(q->across, point->su), av = vec_dot(q->across, point->sv);
    double gu = vec_dot(d.normal, point->su), gv = vec_dot(d.normal, point->sv);
    btg_vec3 bent = vec_mad(d.normal, q->across, -slope);
    double uu = bend_of(&d, point->su, point->su) + vec_dot(bent, point->suu);
    double uv = bend_of(&d, point->su, point->sv) + vec_dot(bent, point->suv);
    double vv = bend_of(&d, point->sv, point->sv) + vec_dot(bent, point->svv);
    double pu, pv, size = au * au + av * av; /* a unit of station */
    at->station = vec_dot(q->across, point->s);
    at->clearance = d.distance;
    at->right_u = at->right_v = at->off = 0;
    if (hold.u || hold.v) {
        double along = hold.u ? av : au;
        if (fabs(along) <= 1e-9 * sqrt(vec_norm2(hold.u ? point->sv : point->su)) ||
            (hold.u && hold.v))
            return false;
        pu = hold.u ? 0 : 1 / along;
        pv = hold.u ? 1 / along : 0;
    } else {
        double least = 1e-12 * (vec_norm2(point->su) + vec_norm2(point->sv));
        double tu = -av, tv = au;
        double across = tu * tu * uu + 2 * tu * tv * uv + tv * tv * vv;
        if (!(size > least) || !(across > 0)) return false;
        pu = au / size, pv = av / size;
        double k = -(tu * (uu * pu + uv * pv) + tv * (uv * pu + vv * pv)) / across;
        pu += k * tu, pv += k * tv;
        k = -(tu * gu + tv * gv) / across;
        at->right_u = k * tu, at->right_v = k * tv;
        at->off =
            vec_norm(vec_add(vec_scale(point->su, at->right_u), vec_scale(point->sv, at->right_v)));
        at->clearance += 0.5 * k * (tu * gu + tv * gv);
    }
    at->stretch = vec_norm(vec_add(vec_scale(point->su, pu), vec_scale(point->sv, pv)));
    at->step_u = pu;
    at->step_v = pv;
    at->slope = gu * pu + gv * pv;
    at->bend = pu * pu * uu + 2 * pu * pv * uv + pv * pv * vv;
    return true;
}

/* False where the walk ends: distance not convex along the plane, or the plane not crossed. */
static BTG_APART bool look(const btg_strip_query *q, stand *at, double slope, held hold) {
    btg_surface_point point;
    btg_part_point(q->part, at->place, &point);
    return look_from(q, at, slope, hold, &point);
}

/* Moves `at` to a station or just beside it; false: not so far, or the walk ends here. */
static BTG_APART bool move(const btg_strip_query *q, stand *at, double station, double longest) {
    held hold = {false, false};
    for (int i = 0; i < CORRECTIONS; i++) {
        double way = station - at->station;
        if (at->off + fabs(way) * at->stretch > 2 * longest) return false;
        btg_place to = at->place;
        to.u += at->step_u * way + at->right_u;
        to.v += at->step_v * way + at->right_v;
        if (to.item < q->part->patch_count) {
            hold.u = !cross_side(q->part, &to, true);
            hold.v = !cross_side(q->part, &to, false);
        }
        double slope = at->slope + at->bend * way;
        at->place = to;
        if (!look(q, at, slope, hold)) return false;
        bool there = fabs(at->station - station) < ARRIVED * longest;
        if (there && at->off < OFF * longest) return at->clearance > -q->scallop_mm;
    }
    return false;
}

/* How far from a stand the quadratic of c reaches the scallop; INFINITY: never. */
static double reach(const stand *at, double side, double scallop) {
    double rest = scallop - at->clearance, slope = side * at->slope;
    double root = slope * slope + 2 * at->bend * rest;
    if (root < 0) return INFINITY;
    root = sqrt(root);
    if (slope + root <= 0) return INFINITY;
    return 2 * rest / (slope + root); /* the nearer one, without cancellation */
}

/* The end of the strip to one side (+1 or -1) of a contact; false: the scallop is not reached
 * before it, the way ends there. */
static BTG_APART bool walk(const btg_strip_query *q, const stand *contact, double side,
                           double *end) {
    const btg_tool_element *e = &q->tool->element[0];
    double size = e->ring_radius_mm + e->corner_radius_mm, longest = STEP * size;
    double inside = contact->station, outside = inside + side * 2 * size;
    stand at = *contact;
    bool bracketed = false, halve = false; /* the end is before `outside` */
    for (int i = 0; i < STEPS_MAX && side * (outside - inside) > LEAST * size; i++) {
        double way = fmin(reach(&at, side, q->scallop_mm), longest / at.stretch);
        double to = at.station + side * way;
        if (halve || side * (to - inside) <= 0 || (bracketed && side * (outside - to) <= 0))
            to = 0.5 * (inside + outside);
        stand next = at;
        halve = !move(q, &next, to, longest);
        if (!halve && fabs(next.clearance - q->scallop_mm) <= END * q->scallop_mm) {
            way = reach(&next, side, q->scallop_mm);
            *end = next.station + side * way;
            if (fabs(way) * next.stretch <= longest) return true;
        }
        if (!halve) at = next;
        if (!halve && at.clearance <= q->scallop_mm) {
            inside = at.station;
        } else {
            outside = halve ? to : at.station;
            bracketed = true;
        }
    }
    *end = inside;
    return false;
}

/* The greatest clearance on the way from one contact to the station of the other; NaN: the way
 * is not open. */
static BTG_APART double crest(const btg_strip_query *q, const stand *contact, double to) {
    const btg_tool_element *e = &q->tool->element[0];
    double longest = STEP * (e->ring_radius_mm + e->corner_radius_mm);
    double side = to < contact->station ? -1 : 1;
    stand at = *contact;
    double way = INFINITY, left = INFINITY; /* of the last step; what the crest is higher */
    for (int i = 0; i < STEPS_MAX && left > CREST * at.clearance; i++) {
        double rest = side * (to - at.station), most = longest / at.stretch;
        /* nearly a parabola on a parabola: the middle is a good first guess */
        double next = i == 0 ? fmin(most, 0.5 * rest) : most;
        if (at.bend < 0)
            next = fmax(fmin(next, side * at.slope / -at.bend), -most);
        else if (side * at.slope < 0) /* over it */
            next = -0.5 * fabs(way);
        way = next;
        if (way >= rest || side * (at.station - contact->station) + way <= 0) break;
        if (!move(q, &at, at.station + side * way, longest)) return NAN;
        left = at.bend < 0 ? 0.5 * at.slope * at.slope / -at.bend : INFINITY;
    }
    return at.clearance + (left <= CREST * at.clearance ? left : 0);
}

static BTG_APART bool stand_at(const btg_strip_query *query, const btg_contact *contact,
                               stand *at) {
    *at = (stand){.place = contact->place};
    bool stands = look(query, at, 0, (held){false, false});
    at->station = vec_dot(query->across, contact->point);
    at->right_u = at->right_v = at->off = at->slope = 0;
    return stands;
}

/* The strip is known to be one, and to be followed outward from either contact. */
static bool joined(const btg_strip_query *q, const btg_strip *strip) {
    const btg_tool_element *e = &q->tool->element[0];
    if (strip->apart_mm < CLOSE * (e->ring_radius_mm + e->corner_radius_mm)) return false;
    return strip->crest_mm >= 0 && strip->crest_mm <= (1 - CREST_NEAR) * q->scallop_mm;
}

btg_strip btg_strip_measure(const btg_strip_query *query, const btg_contact *p,
                            const btg_contact *q) {
    stand at[2];
    btg_strip strip = {.crest_mm = NAN};
    bool has_a = stand_at(query, p, &at[0]), has_b = q && stand_at(query, q, &at[1]);
    double from, to;
    if (!has_a || !has_b) {
        if (!has_a && !has_b) return strip;
        walk(query, &at[has_b], -1, &from);
        walk(query, &at[has_b], 1, &to);
        strip.width_mm = to - from;
        return strip;
    }
    bool turned = at[0].station > at[1].station;
    const stand *a = &at[turned], *b = &at[!turned];
    strip.apart_mm = b->station - a->station;
    double gap = 0;
    strip.crest_mm = crest(query, a, b->station);
    bool ends = walk(query, a, -1, &from);
    ends = walk(query, b, 1, &to) && ends;
    if (!ends || !joined(query, &strip)) {
        double to_a, from_b;
        walk(query, a, 1, &to_a);
        walk(query, b, -1, &from_b);
        from = fmin(from, from_b);
        to = fmax(to, to_a);
        gap = fmax(from_b - to_a, 0);
    }
    strip.width_mm = to - from - gap;
    strip.span_mm = to - from;
    return strip;
}
