/* Second-order proofs that the part is clear of the tool.
 *
 * Along a straight line in an item's parameters the distance phi to the tool has a Taylor
 * polynomial of order two, and a third derivative bounded by K: so phi is at least the polynomial
 * less K |p|^3 / 6. At a contact phi and its slope into the part vanish or grow, and where the
 * Hessian is positive the contact's whole neighbourhood, its basin, is clear: a few surface points
 * prove what tangent planes would need thousands of small cells for. The same polynomial bounds
 * the distance over a single cell in the long flat valleys where no basin is wide.
 *
 * Two functions stand for the distance. To a ring with a round corner: distance to a circle, less
 * the corner radius; its derivatives along unit steps are at most 1, 1/D + 1/r and
 * 1.2/D^2 + 3/(D r) + 1.2/r^2 (D: to the circle, r: to the axis). To anything convex: the tangent
 * plane at the nearest point, which lies behind it everywhere. */
#include "core/search.h"

/* A direction in the item's parameters is measured by the speeds at the point of expansion. */
typedef struct expansion {
    double distance;
    double gu, gv, huu, huv, hvv; /* per unit of speed-scaled parameter */
    double speed_u, speed_v;
    double m1, m2, m3; /* |S'|, |S''| there and |S'''| anywhere, for unit steps */
    bool curved;       /* to the ring; else to the plane */
    double ring_distance, axis_distance; /* D and r at the point */
    double height;                       /* above the equator: must stay below 0 when curved */
    double beyond_flat;                  /* r - ring radius: must stay above 0 on solid tools */
} expansion;

static double mix2(double uu, double uv, double vv) {
    /* the largest uu a^2 + 2 uv a b + vv b^2 with a^2 + b^2 = 1 */
    return 0.5 * (uu + vv) + hypot(0.5 * (uu - vv), uv);
}

static bool third_bounds(const btg_part *part, uint32_t item, const btg_surface_point *s,
                         expansion *x) {
    x->speed_u = vec_norm(s->su);
    x->speed_v = vec_norm(s->sv);
    if (!(x->speed_u > 0 && x->speed_v > 0)) return false;
    double iu = 1 / x->speed_u, iv = 1 / x->speed_v;
    double uv = fabs(vec_dot(s->su, s->sv)) * iu * iv;
    x->m1 = sqrt(1 + uv); /* |a Su/|Su| + b Sv/|Sv||, a^2 + b^2 = 1 */
    x->m2 = mix2(vec_norm(s->suu) * iu * iu, vec_norm(s->suv) * iu * iv,
                 vec_norm(s->svv) * iv * iv);
    x->m3 = 0;
    if (item < part->patch_count) {
        const double *t = part->patches[item].third;
        /* a^3, 3 a^2 b, 3 a b^2, b^3 are at most 1, 1.16, 1.16, 1 on the unit circle */
        x->m3 = t[0] * iu * iu * iu + 1.16 * t[1] * iu * iu * iv + 1.16 * t[2] * iu * iv * iv +
                t[3] * iv * iv * iv;
    }
    return true;
}

static void second_order(const btg_surface_point *s, const btg_ray_distance *d, expansion *x) {
    double iu = 1 / x->speed_u, iv = 1 / x->speed_v;
    x->distance = d->distance;
    x->gu = vec_dot(d->normal, s->su) * iu;
    x->gv = vec_dot(d->normal, s->sv) * iv;
    x->huu = vec_dot(d->normal, s->suu);
    x->huv = vec_dot(d->normal, s->suv);
    x->hvv = vec_dot(d->normal, s->svv);
    if (x->curved) {
        double ru = vec_dot(d->ring_tangent, s->su), rv = vec_dot(d->ring_tangent, s->sv);
        double mu = vec_dot(d->meridian_tangent, s->su);
        double mv = vec_dot(d->meridian_tangent, s->sv);
        x->huu += d->ring_curvature * ru * ru + d->meridian_curvature * mu * mu;
        x->huv += d->ring_curvature * ru * rv + d->meridian_curvature * mu * mv;
        x->hvv += d->ring_curvature * rv * rv + d->meridian_curvature * mv * mv;
    }
    x->huu *= iu * iu;
    x->huv *= iu * iv;
    x->hvv *= iv * iv;
}

/* Expands the distance to an element about a point of an item; false: nothing smooth there. */
static bool expand(const btg_search *search, const btg_tool_element *e, uint32_t item,
                   const btg_surface_point *s, expansion *x) {
    btg_ray_distance d = btg_ray_tool_distance(e, search->at, s->s);
    if (!third_bounds(search->part, item, s, x)) return false;
    btg_vec3 arm = vec_sub(s->s, search->at.centre);
    double height = vec_dot(arm, search->at.axis);
    x->axis_distance = vec_norm(vec_mad(arm, search->at.axis, -height));
    x->height = height - e->from_mm;
    x->beyond_flat = e->hollow ? INFINITY : x->axis_distance - e->ring_radius_mm;
    x->ring_distance = d.distance + e->corner_radius_mm;
    x->curved = e->corner_radius_mm > 0 && d.meridian_curvature > 0;
    if (!x->curved && e->hollow) return false;
    second_order(s, &d, x);
    return true;
}

/* Bound of the third derivative for steps up to `reach`, the circle no nearer than ring_low;
 * INFINITY where the expansion does not hold that far. */
static double third_derivative(const expansion *x, double reach, double ring_low) {
    double m2 = x->m2 + x->m3 * reach, m1 = x->m1 + m2 * reach;
    if (!x->curved) return x->m3;
    double way = m1 * reach, r = x->axis_distance - way;
    if (x->height + way > 0 || x->beyond_flat - way < 0) return INFINITY;
    if (!(ring_low > 0) || r < 0.25 * x->axis_distance) return INFINITY;
    double i = 1 / ring_low, k = 1 / r;
    return (1.2 * i * i + 3 * i * k + 1.2 * k * k) * m1 * m1 * m1 + 3 * (i + k) * m1 * m2 + x->m3;
}

/* ---- basins ------------------------------------------------------------------------------- */

static double least_eigenvalue(double a, double b, double c) {
    return 0.5 * (a + c) - hypot(0.5 * (a - c), b);
}

/* Clear for all steps up to `reach` into the item: slopes into it (at its edges) are turned into
 * curvature, g t >= (g / reach) t^2. */
static bool basin_holds(const expansion *x, double reach, double slope_u, double slope_v) {
    /* Where phi >= 0 the circle is at least a corner radius away; a first point with phi < 0
     * would have to be reached through such points. */
    double third = third_derivative(x, reach, x->ring_distance);
    if (!(third < INFINITY)) return false;
    double least = least_eigenvalue(x->huu + 2 * slope_u / reach, x->huv,
                                    x->hvv + 2 * slope_v / reach);
    return least >= third * reach / 3;
}

btg_basin btg_basin_make(const btg_search *search, btg_place place, uint32_t element) {
    btg_basin basin = {.place = place, .element = element};
    const btg_tool_element *e = &search->query.tool->element[element];
    btg_surface_point s;
    btg_part_point(search->part, place, &s);
    expansion x;
    if (!expand(search, e, place.item, &s, &x)) return basin;
    bool triangle = place.item >= search->part->patch_count;
    bool edge_u = place.u <= 0 || place.u >= 1, edge_v = place.v <= 0 || place.v >= 1;
    double slope_u = edge_u ? (place.u <= 0 ? x.gu : -x.gu) : 0;
    double slope_v = edge_v ? (place.v <= 0 ? x.gv : -x.gv) : 0;
    /* Elsewhere the slope must be nothing but rounding; what is left of it times any reach here
     * stays far below the search's clearance. */
    const double flat = 1e-9;
    if ((!edge_u && fabs(x.gu) > flat) || (!edge_v && fabs(x.gv) > flat)) return basin;
    if (slope_u < -flat || slope_v < -flat) return basin;
    if (triangle && place.u + place.v >= 1) return basin;
    slope_u = fmax(slope_u, 0);
    slope_v = fmax(slope_v, 0);
    basin.speed_u = x.speed_u;
    basin.speed_v = x.speed_v;
    double reach = search->part->scale;
    for (int i = 0; i < BTG_BASIN_HALVINGS && basin.reach == 0; i++, reach *= 0.7)
        if (basin_holds(&x, reach, slope_u, slope_v)) basin.reach = reach;
    return basin;
}

bool btg_basin_covers(const btg_search *search, const btg_basin *basin,
                      const btg_region *region) {
    const btg_cell *cell = &region->cell;
    if (region->node != BTG_REGION_CELL || cell->item != basin->place.item) return false;
    if (!(basin->reach > 0)) return false;
    double low_u = cell->u - cell->hu, low_v = cell->v - cell->hv;
    double high_u = cell->u + cell->hu, high_v = cell->v + cell->hv;
    if (btg_cell_is_triangle(search->part, cell)) {
        low_u = fmin(cell->u, high_u);
        low_v = fmin(cell->v, high_v);
        high_u = low_u + fabs(cell->hu);
        high_v = low_v + fabs(cell->hv);
    }
    double du = fmax(basin->place.u - low_u, high_u - basin->place.u) * basin->speed_u;
    double dv = fmax(basin->place.v - low_v, high_v - basin->place.v) * basin->speed_v;
    return du * du + dv * dv <= basin->reach * basin->reach;
}

/* ---- cells -------------------------------------------------------------------------------- */

/* The least of g t + h t^2 / 2 for |t| <= a. */
static double least_on_line(double g, double h, double a) {
    double ends = 0.5 * h * a * a - fabs(g) * a;
    if (h > 0 && fabs(g) < h * a) return -0.5 * g * g / h;
    return ends < 0 ? ends : 0;
}

/* The least of the polynomial over |pu| <= a, |pv| <= b: inside, or on one of four sides. */
static double least_on_box(const expansion *x, double a, double b) {
    double least = 0;
    for (int side = -1; side <= 1; side += 2) {
        double u = side * a, v = side * b;
        double on_u = x->gu * u + 0.5 * x->huu * u * u +
                      least_on_line(x->gv + x->huv * u, x->hvv, b);
        double on_v = x->gv * v + 0.5 * x->hvv * v * v +
                      least_on_line(x->gu + x->huv * v, x->huu, a);
        least = fmin(least, fmin(on_u, on_v));
    }
    double det = x->huu * x->hvv - x->huv * x->huv;
    if (x->huu > 0 && det > 0) {
        double u = (x->huv * x->gv - x->hvv * x->gu) / det;
        double v = (x->huv * x->gu - x->huu * x->gv) / det;
        if (fabs(u) <= a && fabs(v) <= b) least = fmin(least, 0.5 * (x->gu * u + x->gv * v));
    }
    return least;
}

bool btg_cell_clear_to_second_order(const btg_search *search, const btg_region *region,
                                    const btg_tool_element *e) {
    const btg_cell *cell = &region->cell;
    btg_place place = btg_cell_place(search->part, cell);
    btg_surface_point s;
    btg_part_point(search->part, place, &s);
    expansion x;
    if (!expand(search, e, cell->item, &s, &x)) return false;
    /* a triangle's box about its centroid */
    double wide = btg_cell_is_triangle(search->part, cell) ? 2.0 / 3 : 1;
    double a = fabs(cell->hu) * wide * x.speed_u, b = fabs(cell->hv) * wide * x.speed_v;
    double reach = sqrt(a * a + b * b);
    double low = x.ring_distance - region->radius;
    double third = third_derivative(&x, reach, low);
    if (!(third < INFINITY)) return false;
    double bound = x.distance + least_on_box(&x, a, b) - third * reach * reach * reach / 6;
    return bound >= -search->tolerance;
}
