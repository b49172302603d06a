/* TILT close to P. The value there depends on the direction from P, and its limit has a closed
 * form for each sheet of the part that meets P (ray.h); rays start outside a small clearance. */
#include "core/search.h"

/* P is on an edge that comes this close, in clearances: it then lies all inside the clearance. */
#define ON_EDGE 0.01
/* Cells this small, in insert's sizes, are near enough to P to find their sheet's nearest point. */
#define SHEET_REACH 0.03
/* Places along the ridge, in insert's sizes: the first tells the slope of the value out of P. */
static const double ridge_steps[] = {0.02, 0.06, 0.18};
/* A rise that matters, rad. At a distance t from P it takes t^2 / 2 of it, over the tool's radius,
 * off the clearance: nearer than where that is the walk's the walk does not see it. */
#define RISE_SEEN 1e-6
/* There the value rises at most that many times what its slope at P makes of it. */
#define RISE_MOST 2

static void offer_limit(btg_search *search, double value) {
    btg_search_offer(search, value, search->p_place, search->query.p, 0, true);
}

/* The limit of an item at its own place nearest to P. */
static BTG_APART void offer_sheet(btg_search *search, btg_place place) {
    btg_surface_point *s = &search->here;
    btg_part_point(search->part, place, s);
    if (search->sheet_count < BTG_SHEETS_MAX)
        search->sheet[search->sheet_count++] =
            (btg_sheet){.place = place, .speed_u = vec_norm(s->su), .speed_v = vec_norm(s->sv)};
    double near = ON_EDGE * sqrt(search->query.p_clearance2);
    double tu = near / (vec_norm(s->su) + near), tv = near / (vec_norm(s->sv) + near);
    bool triangle = place.item >= search->part->patch_count;
    bool edge_u = place.u < tu || (!triangle && place.u > 1 - tu);
    bool edge_v = place.v < tv || (!triangle && place.v > 1 - tv);
    double value;
    if (btg_ray_osculating(&search->query, s, edge_u, edge_v, &value)) offer_limit(search, value);
    if (triangle && place.u + place.v > 1 - min2(tu, tv)) {
        btg_surface_point *side = &search->there;
        *side = (btg_surface_point){.s = s->s, .su = vec_sub(s->su, s->sv)};
        if (btg_ray_osculating(&search->query, side, false, true, &value))
            offer_limit(search, value);
    }
}

/* The part of a step from x that stays within 0..1. */
static double part_inside(double x, double step) {
    double room = step > 0 ? 1 - x : x, way = fabs(step);
    return way > room ? room / way : 1;
}

/* The direction of a sheet's limit at P, in its parameters for 1 mm. */
typedef struct ridge {
    double u, v;
    double near_u, near_v; /* an edge so near P may have the top on it */
    double side;           /* 1 or -1: uphill */
} ridge;

/* The place a step along the ridge from P, in mm, or as far as the patch goes, and its value. The
 * step's length; 0 where there is none or no ray meets the tool. */
static BTG_APART double along_ridge(btg_search *search, btg_place p, const ridge *r, double step,
                                    btg_place *at, double *value) {
    btg_surface_point *s = &search->here;
    btg_ray_hit hit;
    double inside = min2(part_inside(p.u, step * r->u), part_inside(p.v, step * r->v));
    *at = (btg_place){p.item, p.u + inside * step * r->u, p.v + inside * step * r->v};
    at->u = min2(max2(at->u, 0), 1);
    at->v = min2(max2(at->v, 0), 1);
    if (!(inside > 0)) return 0;
    btg_part_point(search->part, *at, s);
    if (!btg_ray_cast(&search->query, s->s, &hit)) return 0;
    *value = hit.value;
    return inside * fabs(step);
}

/* Where the patch ends near P the top may be on its edge, aside of the ridge: from where that meets
 * the edge, or would behind the next one. */
static void climb_edges(btg_search *search, btg_place from, const ridge *r) {
    for (int i = 0; i < 2; i++) {
        double u = i - from.u, v = i - from.v;
        if (fabs(u) < r->near_u && r->u != 0) {
            double aside = from.v + u / r->u * r->v;
            btg_search_polish(search, (btg_place){from.item, i, min2(max2(aside, 0), 1)});
        }
        if (fabs(v) < r->near_v && r->v != 0) {
            double aside = from.u + v / r->v * r->u;
            btg_search_polish(search, (btg_place){from.item, min2(max2(aside, 0), 1), i});
        }
    }
}

/* The ridge out of P; false: there is none, or nothing on it that can beat the best. The value's
 * slope there has opposite signs on both sides: one of them leads uphill. */
static BTG_APART bool find_ridge(btg_search *search, btg_place from, ridge *r) {
    double way[2], limit, low = 0, high = 0;
    btg_place at;
    btg_surface_point *p = &search->here;
    btg_part_point(search->part, from, p);
    if (!btg_ray_ridge(&search->query, p, way, &limit)) return false;
    double t = ridge_steps[0] * btg_ray_insert_size(search->query.tool);
    *r = (ridge){way[0], way[1], t / vec_norm(p->su), t / vec_norm(p->sv), 0};
    double left = along_ridge(search, from, r, -t, &at, &low);
    double right = along_ridge(search, from, r, t, &at, &high);
    double slope = 0;
    if (!(left > 0 || right > 0)) return false;
    if (left > 0) slope += (limit - low) / left;
    if (right > 0) slope += (high - limit) / right;
    if (left > 0 && right > 0) slope *= 0.5;
    r->side = slope > 0 ? 1 : -1;
    const btg_tool_element *e = &search->query.tool->element[0];
    double radius = e->ring_radius_mm + e->corner_radius_mm;
    double unseen = sqrt(2 * radius * search->tolerance / RISE_SEEN) + t;
    return !(search->value > limit + RISE_MOST * fabs(slope) * unseen);
}

/* The best of a few places up the ridge; false: none. */
static BTG_APART bool best_on_ridge(btg_search *search, btg_place from, const ridge *r,
                                    btg_place *best) {
    double size = btg_ray_insert_size(search->query.tool), most = -INFINITY;
    for (size_t i = 0; i < sizeof ridge_steps / sizeof *ridge_steps; i++) {
        btg_place at;
        double value, step = ridge_steps[i] * size;
        double way = along_ridge(search, from, r, r->side * step, &at, &value);
        if (!(way > 0 && value > most)) break;
        most = value;
        *best = at;
        if (way < step) break; /* there the patch ends */
    }
    return most > -INFINITY;
}

/* The best is a top next to P already: a smooth sheet has one there. */
static bool is_top_next_to_p(const btg_search *search, btg_place from) {
    double most = ridge_steps[2] * btg_ray_insert_size(search->query.tool);
    return search->settled && !search->osculating && search->place.item == from.item &&
           vec_norm2(vec_sub(search->point, search->query.p)) < most * most;
}

/* Where the tilt is nearly osculating the value rises from P along the direction of its limit, the
 * ridge, by less than the walk's clearance shows. */
static void climb_ridge(btg_search *search, btg_place from) {
    ridge r;
    btg_place best;
    if (btg_is_triangle(search->part, from.item) || !find_ridge(search, from, &r)) return;
    climb_edges(search, from, &r);
    if (is_top_next_to_p(search, from)) return;
    if (best_on_ridge(search, from, &r, &best)) btg_search_polish(search, best);
}

void btg_search_climb_ridges(btg_search *search) {
    for (uint32_t i = 0; i < search->sheet_count; i++)
        climb_ridge(search, search->sheet[i].place);
}

void btg_search_near_p(btg_search *search) {
    double value;
    if (btg_ray_tool_limit(&search->query, &value)) offer_limit(search, value);
    offer_sheet(search, search->p_place);
}

static btg_place hold(const btg_search *search, btg_place at) {
    at.u = min2(max2(at.u, 0), 1);
    at.v = min2(max2(at.v, 0), 1);
    if (at.item >= search->part->patch_count && at.u + at.v > 1) {
        double over = 0.5 * (at.u + at.v - 1);
        at.u = min2(max2(at.u - over, 0), 1);
        at.v = 1 - at.u;
    }
    return at;
}

/* Nearest place to P on the item, from one close by: Gauss and Newton, side by side. */
static BTG_APART double nearest_to_p(btg_search *search, btg_place *at) {
    btg_surface_point *s = &search->here;
    for (int i = 0; i < 20; i++) {
        btg_part_point(search->part, *at, s);
        btg_vec3 d = vec_sub(search->query.p, s->s);
        double uu = vec_norm2(s->su), vv = vec_norm2(s->sv), uv = vec_dot(s->su, s->sv);
        double gu = vec_dot(d, s->su), gv = vec_dot(d, s->sv), det = uu * vv - uv * uv;
        btg_place next = *at;
        if (det > 1e-12 * uu * vv) {
            next.u += (vv * gu - uv * gv) / det;
            next.v += (uu * gv - uv * gu) / det;
        } else {
            if (uu > 0) next.u += 0.5 * gu / uu;
            if (vv > 0) next.v += 0.5 * gv / vv;
        }
        next = hold(search, next);
        /* once held by a side, the rest of the way is along it */
        if ((next.u == 0 || next.u == 1) && vv > 0)
            next.v = at->v + (gv - uv * (next.u - at->u)) / vv;
        else if ((next.v == 0 || next.v == 1) && uu > 0)
            next.u = at->u + (gu - uv * (next.v - at->v)) / uu;
        next = hold(search, next);
        bool still = fabs(next.u - at->u) + fabs(next.v - at->v) < 1e-15;
        *at = next;
        if (still) break;
    }
    btg_part_point(search->part, *at, s);
    return vec_norm(vec_sub(search->query.p, s->s));
}

unsigned btg_search_reaching_p(const btg_search *search) {
    unsigned near = btg_block_near(&search->block, search->query.p, search->sheet_gap);
    double most = SHEET_REACH * btg_ray_insert_size(search->query.tool);
    return near ? near & btg_block_small(&search->block, most) : 0;
}

void btg_search_sheet_at_p(btg_search *search, const btg_region *region) {
    for (uint32_t i = 0; i < search->sheet_count; i++)
        if (search->sheet[i].place.item == region->cell.item) return;
    btg_place at = btg_cell_place(&region->cell);
    if (nearest_to_p(search, &at) > search->sheet_gap) return;
    offer_sheet(search, at);
}
