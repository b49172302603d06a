/* Second-order proofs that the part is clear of the tool.
 *
 * About a point of an item, as a function of the item's parameters p, the distance to the tool is
 * bounded from below by a polynomial,
 *
 *     distance + g p + 1/2 p H p - cubic |p|^3        for |p| up to some reach.
 *
 * At a contact distance is 0 and g leads out of the item or vanishes; where H is positive the
 * contact's whole neighbourhood, its basin, is clear: one surface point proves what tangent planes
 * would need thousands of small cells for. The same polynomial bounds single cells in the long
 * flat valleys where no basin is wide.
 *
 * To a convex element the distance is at least that to its tangent plane at the nearest point: then
 * g and H are those of the surface alone. To a ring with a round corner more is known. With steps
 * x_n, x_m along the distance's gradient and along the meridian, and t along the ring, a point is
 * r = sqrt(r1^2 + t^2) off the axis, r1 = r0 + n_r x_n - n_z x_m, and the square of its distance D
 * from the circle, (D0 + x_n)^2 + x_m^2 + t^2 - 2 Ro (r - r1), is at least
 *
 *     (D0 + x_n)^2 + x_m^2 + (1 - Ro / r1) t^2 + (1 - t^2 / (2 r1^2)) Ro t^4 / (4 r1^3).
 *
 * About r0, 1 / r1 makes of this a product x_m t^2, which is paid for with a share of x_m^2 and,
 * for the rest, with next to all of t^4. So the tool adds no cubic term of its own: what is left of
 * that comes from the surface's third derivatives and from its bend sideways. What is bounded by
 * the polynomial is V = (D^2 - D0^2) / (2 D0), D0 + V - V^2 / D0 <= D for V from -D0 / 4 to 0. */
#include "core/search.h"

/* Parameters are measured by the speeds at the point of expansion. */
typedef struct expansion {
    double distance;
    double gu, gv;         /* slopes of the distance */
    double nuu, nuv, nvv;  /* second derivatives along the normal */
    double mu, mv, bu, bv; /* derivatives along the meridian and along the ring */
    double speed_u, speed_v;
    double m1, m2, m3;     /* first and second derivatives here, third anywhere: longest */
    double bend_m, bend_b; /* second derivatives along meridian and ring: largest */
    bool curved, solid;    /* to the ring, else to the plane; the ring is a solid's corner */
    double ring_distance, axis_distance, height, ring_radius; /* D0, r0, z0, Ro */
    double out, up;                                           /* n_r, n_z */
} expansion;

/* The quadratic and cubic part of the bound. */
typedef struct lower_bound {
    double huu, huv, hvv, cubic;
} lower_bound;

/* The largest uu a^2 + 2 uv a b + vv b^2 with a^2 + b^2 = 1. */
static double mix2(double uu, double uv, double vv) {
    return 0.5 * (uu + vv) + norm2(0.5 * (uu - vv), uv);
}

static void surface_bounds(const btg_part *part, uint32_t item, const btg_surface_point *s,
                           expansion *x) {
    double iu = 1 / x->speed_u, iv = 1 / x->speed_v;
    x->m1 = sqrt(1 + fabs(vec_dot(s->su, s->sv)) * iu * iv);
    x->m2 =
        mix2(vec_norm(s->suu) * iu * iu, vec_norm(s->suv) * iu * iv, vec_norm(s->svv) * iv * iv);
    x->m3 = 0;
    if (item < part->patch_count) {
        const double *t = part->patches[item].third;
        /* a^3, 3 a^2 b, 3 a b^2, b^3 are at most 1, 1.16, 1.16, 1 on the unit circle */
        x->m3 = t[0] * iu * iu * iu + 1.16 * t[1] * iu * iu * iv + 1.16 * t[2] * iu * iv * iv +
                t[3] * iv * iv * iv;
    }
}

static double bend_along(const btg_surface_point *s, btg_vec3 direction, const expansion *x) {
    double iu = 1 / x->speed_u, iv = 1 / x->speed_v;
    return mix2(fabs(vec_dot(direction, s->suu)) * iu * iu,
                fabs(vec_dot(direction, s->suv)) * iu * iv,
                fabs(vec_dot(direction, s->svv)) * iv * iv);
}

/* From the distance at the point. */
static BTG_APART bool expand_from(const btg_search *search, const btg_tool_element *e,
                                  uint32_t item, const btg_surface_point *s,
                                  const btg_ray_distance *d, expansion *x) {
    x->speed_u = vec_norm(s->su);
    x->speed_v = vec_norm(s->sv);
    if (!(x->speed_u > 0 && x->speed_v > 0)) return false;
    x->curved = e->corner_radius_mm > 0 && d->meridian_curvature > 0;
    x->solid = !e->hollow;
    if (!x->curved && e->hollow) return false;
    surface_bounds(search->part, item, s, x);
    double iu = 1 / x->speed_u, iv = 1 / x->speed_v;
    x->distance = d->distance;
    x->gu = vec_dot(d->normal, s->su) * iu;
    x->gv = vec_dot(d->normal, s->sv) * iv;
    x->nuu = vec_dot(d->normal, s->suu) * iu * iu;
    x->nuv = vec_dot(d->normal, s->suv) * iu * iv;
    x->nvv = vec_dot(d->normal, s->svv) * iv * iv;
    if (!x->curved) return true;
    x->mu = vec_dot(d->meridian_tangent, s->su) * iu;
    x->mv = vec_dot(d->meridian_tangent, s->sv) * iv;
    x->bu = vec_dot(d->ring_tangent, s->su) * iu;
    x->bv = vec_dot(d->ring_tangent, s->sv) * iv;
    x->bend_m = bend_along(s, d->meridian_tangent, x);
    x->bend_b = bend_along(s, d->ring_tangent, x);
    btg_vec3 arm = vec_sub(s->s, search->at.centre);
    double height = vec_dot(arm, search->at.axis);
    x->axis_distance = vec_norm(vec_mad(arm, search->at.axis, -height));
    x->height = height - e->from_mm;
    x->ring_radius = e->ring_radius_mm;
    x->ring_distance = d->distance + e->corner_radius_mm;
    x->out = (x->axis_distance - x->ring_radius) / x->ring_distance;
    x->up = x->height / x->ring_distance;
    return true;
}

/* Expands the distance to an element, or to the plane given instead of it, about a point of an
 * item; false: nothing smooth there. */
static BTG_APART bool expand(const btg_search *search, const btg_tool_element *e, uint32_t item,
                             const btg_surface_point *s, const btg_ray_distance *plane,
                             expansion *x) {
    if (plane) return expand_from(search, e, item, s, plane, x);
    btg_ray_distance d;
    btg_ray_measure(e, &search->at, s->s, &d);
    return expand_from(search, e, item, s, &d, x);
}

/* How far steps of up to `u` and `v` lead: |p| at most `reach`. */
typedef struct span {
    double u, v, reach;
} span;

/* The largest |a u + b v| within the span. */
static double most(const span *p, double a, double b) {
    return min2(fabs(a) * p->u + fabs(b) * p->v, sqrt(a * a + b * b) * p->reach);
}

/* The ring's part of the bound (see above), a share of x_m^2 spent; false where it does not hold
 * that far. */
static bool add_ring(const expansion *x, const span *p, double share, lower_bound *out) {
    double bow = 0.5 * p->reach * p->reach, third = x->m3 * p->reach;
    double bend_m = x->bend_m + third, bend_b = x->bend_b + third, second = x->m2 + third;
    double along = most(p, x->gu, x->gv) + bow * second;
    double across = most(p, x->mu, x->mv) + bow * bend_m;
    double aside = most(p, x->bu, x->bv) + bow * bend_b;
    double n_r = fabs(x->out), n_z = fabs(x->up), over = 1 / x->ring_distance;
    double r = x->axis_distance - n_r * along - n_z * across; /* the least r1 */
    if (x->height + n_z * along + n_r * across > 0 || !(r > 0.25 * x->axis_distance)) return false;
    if (x->solid && r < x->ring_radius) return false;
    double b = x->ring_radius / (x->axis_distance * x->axis_distance), bz = b * n_z;
    double aside2 = aside * aside, r0 = x->axis_distance, off = n_r * along;
    /* t^4: its own part about r0, what of it goes with x_m, what pays for the product x_m t^2 */
    double bow4 = 0.25 * x->ring_radius / (r0 * r0 * r0), turn = 3 * bow4 / r0;
    double spare = 0.25 * (1 - share), left = 1 - share - spare - 1.1 * bz * n_z * aside2 / r;
    if (left < 0) return false;
    double t4 = bow4 - 0.125 * x->ring_radius * aside2 / (r * r * r * r * r) - turn * off -
                0.25 * (turn * n_z * aside2) * (turn * n_z * aside2) / spare;
    t4 -= 0.25 * bz * bz / share;
    double k = 1 - x->ring_radius / r0 - b * off * (1 + 11 * off / r) + aside2 * min2(t4, 0);
    left *= over;
    k *= over;
    out->huu += left * x->mu * x->mu + k * x->bu * x->bu + over * x->gu * x->gu;
    out->huv += left * x->mu * x->mv + k * x->bu * x->bv + over * x->gu * x->gv;
    out->hvv += left * x->mv * x->mv + k * x->bv * x->bv + over * x->gv * x->gv;
    out->cubic += 0.5 * over * norm2(x->gu, x->gv) * second + 0.5 * left * x->m1 * bend_m +
                  0.5 * fabs(k) * (x->m1 * bend_b + 0.25 * bend_b * bend_b * p->reach);
    return true;
}

/* The least distance where V, the polynomial's part of the bound, is at least that. */
static double distance_from(const expansion *x, double v) {
    if (!x->curved) return x->distance + v;
    if (v < -0.25 * x->ring_distance) return -INFINITY;
    return v < 0 ? x->distance + v - v * v / x->ring_distance : x->distance;
}

static bool bound_within(const expansion *x, const span *p, double share, lower_bound *out) {
    *out = (lower_bound){x->nuu, x->nuv, x->nvv, x->m3 / 6};
    return !x->curved || add_ring(x, p, share, out);
}

/* A cell in speed-scaled parameters about a point of expansion. */
typedef struct frame_box {
    double low_u, high_u, low_v, high_v;
} frame_box;

/* The cell's box about a place, a triangle's about all of it. */
static frame_box box_about(const btg_cell *cell, btg_place place, double speed_u, double speed_v) {
    double low_u = cell->u - cell->hu, high_u = cell->u + cell->hu;
    double low_v = cell->v - cell->hv, high_v = cell->v + cell->hv;
    if (cell->triangle) {
        low_u = min2(cell->u, high_u);
        low_v = min2(cell->v, high_v);
        high_u = low_u + fabs(cell->hu);
        high_v = low_v + fabs(cell->hv);
    }
    return (frame_box){(low_u - place.u) * speed_u, (high_u - place.u) * speed_u,
                       (low_v - place.v) * speed_v, (high_v - place.v) * speed_v};
}

/* ---- basins ------------------------------------------------------------------------------- */

/* How deep a basin may be, part of the clearance: a polish leaves slopes. */
#define BASIN_SHARE 0.25
/* Reaches that are tried: from the tool's size down to this part of it, by steps from the least to
 * the most; what is left of the curvature falls with the square. */
#define REACH_MIN   4e-6
#define REACH_SAFE  0.97
#define REACH_LEAST 0.4
#define REACH_MOST  0.9
/* Shares of x_m^2 spent. */
#define LESS_SHARE 0.6
#define MORE_SHARE 0.9

/* Slopes at a contact: into the item at its edges, not below 0, and what is left of the others. */
typedef struct basin_slopes {
    double u, v, left;
} basin_slopes;

/* Not negative: clear for all steps up to `reach` into the item, but for what the slopes that are
 * left make of it, `deep` at most: slopes into it are turned into curvature, g t >= (g / reach)
 * t^2, and above k t^2 the others lead down by g^2 / (4 k) at the most. What k is above that. */
static BTG_APART double margin(const expansion *x, double reach, double share,
                               const basin_slopes *slope, double deep) {
    lower_bound b;
    if (!bound_within(x, &(span){reach, reach, reach}, share, &b)) return -INFINITY;
    double uu = b.huu + 2 * slope->u / reach, vv = b.hvv + 2 * slope->v / reach;
    double least = 0.5 * (uu + vv) - norm2(0.5 * (uu - vv), b.huv);
    double k = 0.5 * least - b.cubic * reach, g = slope->left;
    return g * reach <= deep ? k : k - g * g / (4 * deep);
}

static double widest_basin(const btg_tool_element *e) {
    return 0.5 * (e->ring_radius_mm + e->corner_radius_mm);
}

/* About where the share of x_m^2 uses up the curvature at the contact: a reach to start from. */
static double likely_reach(const expansion *x) {
    double c = 1 / x->ring_distance, k = x->out / x->axis_distance;
    double uu = x->nuu + c * x->mu * x->mu + k * x->bu * x->bu;
    double uv = x->nuv + c * x->mu * x->mv + k * x->bu * x->bv;
    double vv = x->nvv + c * x->mv * x->mv + k * x->bv * x->bv;
    double least = 0.5 * (uu + vv) - norm2(0.5 * (uu - vv), uv);
    double b = x->ring_radius * fabs(x->up) / (x->axis_distance * x->axis_distance);
    return least > 0 ? 6 * sqrt(least * x->ring_distance) / b : INFINITY;
}

/* The widest reach that holds; 0: none does. */
static BTG_APART double widest_reach(const btg_search *search, const btg_tool_element *e,
                                     const expansion *x, const basin_slopes *slope, double deep) {
    double reach = min2(search->part->scale, widest_basin(e));
    if (x->curved) reach = min2(reach, likely_reach(x));
    double least = REACH_MIN * reach, k0 = margin(x, least, LESS_SHARE, slope, deep);
    if (!(k0 >= 0)) return 0;
    while (reach > least) {
        double k = margin(x, reach, MORE_SHARE, slope, deep);
        if (k < 0) k = max2(k, margin(x, reach, LESS_SHARE, slope, deep));
        if (k >= 0) break;
        reach *= min2(max2(REACH_SAFE * sqrt(k0 / (k0 - k)), REACH_LEAST), REACH_MOST);
    }
    return max2(reach, least);
}

void btg_basin_make(btg_search *search, btg_place place, uint32_t element, btg_basin *basin) {
    *basin = (btg_basin){.place = place, .element = element};
    const btg_tool_element *e = &search->query.tool->element[element];
    btg_surface_point *s = &search->here;
    btg_part_point(search->part, place, s);
    expansion x;
    if (!expand(search, e, place.item, s, NULL, &x)) return;
    bool triangle = place.item >= search->part->patch_count;
    bool edge_u = place.u <= 0 || place.u >= 1, edge_v = place.v <= 0 || place.v >= 1;
    double slope_u = edge_u ? (place.u <= 0 ? x.gu : -x.gu) : 0;
    double slope_v = edge_v ? (place.v <= 0 ? x.gv : -x.gv) : 0;
    /* Elsewhere the slope must be nothing but rounding. */
    const double flat = 1e-9;
    if ((!edge_u && fabs(x.gu) > flat) || (!edge_v && fabs(x.gv) > flat)) return;
    if (slope_u < -flat || slope_v < -flat) return;
    if (triangle && place.u + place.v >= 1) return;
    basin_slopes slope = {
        max2(slope_u, 0), max2(slope_v, 0),
        norm2(edge_u ? min2(slope_u, 0) : x.gu, edge_v ? min2(slope_v, 0) : x.gv)};
    double deep = BASIN_SHARE * search->tolerance;
    basin->speed_u = x.speed_u;
    basin->speed_v = x.speed_v;
    basin->reach = widest_reach(search, e, &x, &slope, deep);
    basin->deep = max2(-distance_from(&x, -deep), 0);
}

static bool covers(const btg_basin *basin, const btg_region *region) {
    const btg_cell *cell = &region->cell;
    if (cell->item != basin->place.item) return false;
    if (!(basin->reach > 0)) return false;
    frame_box b = box_about(cell, basin->place, basin->speed_u, basin->speed_v);
    double du = max2(-b.low_u, b.high_u), dv = max2(-b.low_v, b.high_v);
    return du * du + dv * dv <= basin->reach * basin->reach;
}

/* Basins stand about the contacts of the tool as placed: made anew when that moves. */
static void renew(btg_search *search) {
    search->basin_stale = false;
    search->basin[0].reach = search->basin[1].reach = 0;
    if (search->found && !search->osculating)
        btg_basin_make(search, search->place, search->element, &search->basin[0]);
    if (search->query.op == BTG_OP_TILT)
        btg_basin_make(search, search->p_place, 0, &search->basin[1]);
}

bool btg_basins_cover(btg_search *search, const btg_region *region, uint32_t element) {
    if (region->cell.item == BTG_CELL_MANY) return false;
    if (region->radius > widest_basin(&search->query.tool->element[element])) return false;
    if (search->basin_stale) renew(search);
    for (int i = 0; i < 2; i++)
        if (search->basin[i].element == element && covers(&search->basin[i], region)) {
            search->deepest = max2(search->deepest, search->basin[i].deep);
            return true;
        }
    return false;
}

unsigned btg_basins_covering(btg_search *search, unsigned bits) {
    const btg_block *block = &search->block;
    double widest = widest_basin(&search->query.tool->element[0]);
    unsigned small = bits & btg_block_small(block, widest), covered = 0;
    if (!small) return 0;
    if (search->basin_stale) renew(search);
    for (int i = 0; i < 2; i++) {
        const btg_basin *b = &search->basin[i];
        if (b->element != 0 || !(b->reach > 0)) continue;
        unsigned own = small & btg_block_about(block, b->place, b->speed_u, b->speed_v, b->reach);
        if (own) search->deepest = max2(search->deepest, b->deep);
        covered |= own;
    }
    return covered;
}

/* ---- about P ------------------------------------------------------------------------------ */

/* No point within `way` of P that is clear of the tool as it stood first is deeper in it as placed.
 *
 * Such a point is outside the insert's sphere, which does not move: along P's normal it comes no
 * nearer than way^2 / (2 Ri). A convex tool stays behind the plane at P. On the inner side of a
 * hollow one the ring's own bend brings it in front by no more than that over the way. The start
 * pose itself may be as deep as a drop is. */
static double deep_within(const btg_search *search, double way) {
    const btg_tool_element *e = &search->query.tool->element[0];
    double ro = e->ring_radius_mm, ri = e->corner_radius_mm, begun = BTG_BEGUN * search->tolerance;
    if (!(ri > 2 * way)) return way + begun;
    double bend = 1 / ri;
    if (e->hollow) {
        btg_vec3 arm = vec_sub(search->query.p, search->at.centre), axis = search->at.axis;
        double r = vec_norm(vec_mad(arm, axis, -vec_dot(arm, axis))) - way;
        if (r <= 0) return way + begun;
        if (r < ro) bend += (ro - r) / ((ri - way) * r);
    }
    return min2(way, 0.5 * bend * way * way) + begun;
}

/* Furthest step within a region from a sheet's place at P. */
static double step_within(const btg_sheet *sheet, const btg_cell *cell) {
    frame_box b = box_about(cell, sheet->place, sheet->speed_u, sheet->speed_v);
    return norm2(max2(-b.low_u, b.high_u), max2(-b.low_v, b.high_v));
}

bool btg_search_left_to_p(btg_search *search, const btg_region *region, bool at_the_end) {
    double way = vec_norm(vec_sub(region->cell.centre, search->query.p)) + region->radius;
    if (way * way >= search->left_p2) return false;
    btg_sheet *sheet = NULL;
    for (uint32_t i = 0; i < search->sheet_count && !sheet; i++)
        if (search->sheet[i].place.item == region->cell.item) sheet = &search->sheet[i];
    bool close = sheet ? sheet->close : search->other_close;
    if (close && !at_the_end && deep_within(search, way) > search->deep_at_p) return false;
    if (!sheet) {
        search->other_way = max2(search->other_way, way);
        return true;
    }
    sheet->reach = max2(sheet->reach, step_within(sheet, &region->cell));
    sheet->way = max2(sheet->way, way);
    return true;
}

/* How far the slopes at a place of a triangle lead down into it within reach. A step is made of
 * steps towards two of the corners; the sine between these tells how long they may be. */
static double slopes_down_triangle(const expansion *x, btg_place at, double reach) {
    const double weight[3] = {1 - at.u - at.v, at.u, at.v};
    double u[3], v[3], down[3], most = 0, edge = 1e-14;
    for (int k = 0; k < 3; k++) {
        u[k] = ((k == 1) - at.u) * x->speed_u;
        v[k] = ((k == 2) - at.v) * x->speed_v;
        double way = norm2(u[k], v[k]);
        if (way > 0) u[k] /= way, v[k] /= way;
        down[k] = max2(-(x->gu * u[k] + x->gv * v[k]), 0);
    }
    for (int k = 0; k < 3; k++) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        if (weight[k] <= edge || !(down[i] + down[j] > 0)) continue; /* nothing between them */
        double sine = fabs(u[i] * v[j] - u[j] * v[i]);
        most = max2(most, sine > 0 ? (down[i] + down[j]) / sine : INFINITY);
    }
    return min2(most, norm2(x->gu, x->gv)) * reach;
}

/* How far the slopes at a place lead down into the item within reach; slopes up at a patch's edges
 * are turned into curvature, as for basins. */
static double slopes_down(const btg_search *search, const expansion *x, btg_place at, double reach,
                          double *uu, double *vv) {
    if (btg_is_triangle(search->part, at.item)) return slopes_down_triangle(x, at, reach);
    double down_u = at.u <= 0 ? max2(-x->gu, 0) : (at.u >= 1 ? max2(x->gu, 0) : fabs(x->gu));
    double down_v = at.v <= 0 ? max2(-x->gv, 0) : (at.v >= 1 ? max2(x->gv, 0) : fabs(x->gv));
    *uu = at.u <= 0 || at.u >= 1 ? 2 * max2(fabs(x->gu) - down_u, 0) / reach : 0;
    *vv = at.v <= 0 || at.v >= 1 ? 2 * max2(fabs(x->gv) - down_v, 0) / reach : 0;
    return (down_u + down_v) * reach;
}

/* How deep one item at P can be in the tool within reach: by the lower bound of the distance, at
 * several shares, for so close by next to nothing need be spent. */
static BTG_APART double depth_of(const btg_search *search, const expansion *x, btg_place at,
                                 double reach) {
    static const double share[] = {1e-4, 1e-2, 0.4};
    double uu = 0, vv = 0, best = INFINITY, down = slopes_down(search, x, at, reach, &uu, &vv);
    for (int i = 0; i < 3; i++) {
        lower_bound b;
        if (!bound_within(x, &(span){reach, reach, reach}, share[i], &b)) continue;
        b.huu += uu;
        b.hvv += vv;
        double least = 0.5 * (b.huu + b.hvv) - norm2(0.5 * (b.huu - b.hvv), b.huv);
        best = min2(best, max2(-0.5 * least * reach * reach, 0) + b.cubic * reach * reach * reach);
    }
    return max2(-distance_from(x, -down - best), 0);
}

static BTG_APART double deep_by(const btg_search *search, btg_place at, const btg_surface_point *s,
                                const btg_ray_distance *plane, double reach) {
    const btg_tool_element *e = &search->query.tool->element[0];
    expansion x;
    return expand(search, e, at.item, s, plane, &x) ? depth_of(search, &x, at, reach) : INFINITY;
}

/* P is on a sharp rim: the tool stays behind every plane through P that leans between its bottom
 * and its wall, and one of them may have the item in front. */
static BTG_APART double deep_by_planes(const btg_search *search, btg_place at,
                                       const btg_surface_point *s, double reach) {
    btg_vec3 w = search->at.axis, v = vec_unit(vec_sub(search->at.centre, search->query.p));
    btg_vec3 face = vec_cross(s->su, s->sv), n = search->query.n;
    double along = vec_dot(face, w) < 0 ? -1 : 1, best = INFINITY;
    const double lean[4][2] = {{1, 0},
                               {0, 1},
                               {vec_dot(n, w), vec_dot(n, v)},
                               {along * vec_dot(face, w), along * vec_dot(face, v)}};
    for (int i = 0; i < 4; i++) {
        double c = max2(lean[i][0], 0), k = max2(lean[i][1], 0), length = norm2(c, k);
        if (!(length > 0)) continue;
        btg_vec3 out = vec_scale(vec_add(vec_scale(w, c), vec_scale(v, k)), -1 / length);
        btg_ray_distance d = {.distance = vec_dot(out, vec_sub(s->s, search->query.p)),
                              .normal = out};
        best = min2(best, deep_by(search, at, s, &d, reach));
    }
    return best;
}

static double deep_of_sheet(btg_search *search, btg_place at, double reach) {
    const btg_tool_element *e = &search->query.tool->element[0];
    const btg_surface_point *s = &search->here;
    btg_part_point(search->part, at, &search->here);
    if (e->corner_radius_mm == 0) return deep_by_planes(search, at, s, reach);
    return deep_by(search, at, s, NULL, reach);
}

/* What was left of a sheet is at most that deep. */
static BTG_APART double deep_at_sheet(btg_search *search, const btg_sheet *sheet) {
    if (!(sheet->way > 0)) return 0;
    double most = deep_within(search, sheet->way);
    return min2(most, deep_of_sheet(search, sheet->place, sheet->reach));
}

double btg_search_deep_at_p(btg_search *search) {
    double deep = search->other_way > 0 ? deep_within(search, search->other_way) : 0;
    for (uint32_t i = 0; i < search->sheet_count; i++)
        deep = max2(deep, deep_at_sheet(search, &search->sheet[i]));
    return deep;
}

bool btg_search_come_close_to_p(btg_search *search) {
    double enough = search->deep_at_p;
    if (search->other_close) return false; /* once is enough */
    search->other_close = search->other_way > 0 && deep_within(search, search->other_way) > enough;
    bool any = search->other_close;
    for (uint32_t i = 0; i < search->sheet_count; i++) {
        btg_sheet *sheet = &search->sheet[i];
        sheet->close = deep_at_sheet(search, sheet) > enough;
        any = any || sheet->close;
    }
    if (!any) return false;
    search->other_close = true;
    search->other_way = 0;
    for (uint32_t i = 0; i < search->sheet_count; i++)
        search->sheet[i].reach = search->sheet[i].way = 0;
    /* What is deeper than rounding shows (search.c): rays may start wherever it counts. */
    search->query.p_clearance2 = min2(search->query.p_clearance2, enough * enough);
    return true;
}

/* ---- cells -------------------------------------------------------------------------------- */

static double clamp(double x, double low, double high) {
    return x < low ? low : (x > high ? high : x);
}

/* Where g t + h t^2 / 2 is least on low <= t <= high. */
static double least_on_line(double g, double h, double low, double high) {
    if (h > 0) return clamp(-g / h, low, high);
    double at_low = (g + 0.5 * h * low) * low, at_high = (g + 0.5 * h * high) * high;
    return at_low < at_high ? low : high;
}

static double polynomial(const expansion *x, const lower_bound *h, double u, double v) {
    return (x->gu + 0.5 * h->huu * u + h->huv * v) * u + (x->gv + 0.5 * h->hvv * v) * v;
}

/* Where g p + 1/2 p H p is least in the box: inside, or on one of four sides. Returns the least. */
static double least_in_box(const expansion *x, const lower_bound *h, const frame_box *b,
                           double *at_u, double *at_v) {
    double u[5], v[5], best = INFINITY;
    double det = h->huu * h->hvv - h->huv * h->huv;
    bool inside = h->huu > 0 && det > 0;
    u[4] = inside ? (h->huv * x->gv - h->hvv * x->gu) / det : 0;
    v[4] = inside ? (h->huv * x->gu - h->huu * x->gv) / det : 0;
    inside =
        inside && u[4] >= b->low_u && u[4] <= b->high_u && v[4] >= b->low_v && v[4] <= b->high_v;
    u[0] = b->low_u;
    u[1] = b->high_u;
    v[2] = b->low_v;
    v[3] = b->high_v;
    for (int i = 0; i < 2; i++)
        v[i] = least_on_line(x->gv + h->huv * u[i], h->hvv, b->low_v, b->high_v);
    for (int i = 2; i < 4; i++)
        u[i] = least_on_line(x->gu + h->huv * v[i], h->huu, b->low_u, b->high_u);
    for (int i = inside ? 4 : 0; i < (inside ? 5 : 4); i++) {
        double value = polynomial(x, h, u[i], v[i]);
        if (!(value < best)) continue;
        best = value;
        *at_u = u[i];
        *at_v = v[i];
    }
    return best;
}

/* The bound over a cell from an expansion at one of its places; and that place moved to where it
 * would be best expanded: the nearest point by the Taylor polynomial. */
static BTG_APART bool clear_from(const btg_search *search, const expansion *x, const btg_cell *cell,
                                 btg_place *place) {
    frame_box b = box_about(cell, *place, x->speed_u, x->speed_v);
    span p = {max2(-b.low_u, b.high_u), max2(-b.low_v, b.high_v), 0};
    p.reach = sqrt(p.u * p.u + p.v * p.v);
    lower_bound h;
    double u, v;
    if (bound_within(x, &p, 0.5, &h)) {
        double error = h.cubic * p.reach * p.reach * p.reach;
        double least = least_in_box(x, &h, &b, &u, &v) - error;
        if (distance_from(x, least) >= -search->tolerance) return true;
    }
    lower_bound taylor = {x->nuu, x->nuv, x->nvv, 0};
    if (x->curved) {
        double c = 1 / x->ring_distance, k = x->out / x->axis_distance;
        taylor.huu += c * x->mu * x->mu + k * x->bu * x->bu;
        taylor.huv += c * x->mu * x->mv + k * x->bu * x->bv;
        taylor.hvv += c * x->mv * x->mv + k * x->bv * x->bv;
    }
    least_in_box(x, &taylor, &b, &u, &v);
    place->u += u / x->speed_u;
    place->v += v / x->speed_v;
    return false;
}

bool btg_cell_clear_to_second_order(btg_search *search, const btg_region *region,
                                    const btg_tool_element *e) {
    const btg_part *part = search->part;
    btg_place place = btg_cell_place(&region->cell);
    for (int i = 0; i < 2; i++) {
        btg_surface_point *s = &search->here;
        expansion x;
        btg_part_point(part, place, s);
        if (!expand(search, e, place.item, s, NULL, &x)) return false;
        if (x.distance < -search->tolerance) return false;
        if (clear_from(search, &x, &region->cell, &place)) return true;
    }
    return false;
}
