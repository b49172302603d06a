/* What bounds the distance within a wedge of the ring (core/ring.c), next to the distance itself at
 * points of the wedge: on bent, twisted and skewed patches, some of them rational, about tools laid
 * anywhere next to them. */
#include "check.h"
#include "core/ring.c"
#include "hard_parts.h"

#define ROUNDS  2000
#define WAYS    12 /* of laying a tool, on each patch */
#define SAMPLES 400
#define SIZE    40.0
/* Rounding of V, mm. */
#define ROUNDING 1e-10
/* The bound is next to V where it is lower by this part of its terms. */
#define CLOSE 0.02

static btg_search search;
static ring_room room;
static long bounds, close_ones;

static double power(rng *r, double low, double high) {
    return pow(10, rng_range(r, low, high));
}

static void add_patch(model *m, rng *r) {
    bool rational = rng_pick(r, 3) == 0;
    int nu = 2 + rng_pick(r, 3), nv = 2 + rng_pick(r, 3);
    model_surface s = model_bezier(m, nu, nv, rational);
    double height = power(r, -1, 1.2), aside = rng_pick(r, 2) ? power(r, -1, 0.8) : 0;
    double twist = rng_range(r, -15, 15), bow = rng_range(r, -12, 14);
    for (int i = 0; i <= nu; i++)
        for (int k = 0; k <= nv; k++) {
            int at = i * (nv + 1) + k;
            double u = (double)i / nu, v = (double)k / nv, *p = s.points + 3 * at;
            p[0] = SIZE * u + aside * rng_range(r, -1, 1);
            p[1] = SIZE * v + aside * rng_range(r, -1, 1);
            p[2] = bow * (u * (1 - u) + v * (1 - v)) + 4 * twist * (u - 0.5) * (v - 0.5) +
                   height * rng_range(r, -1, 1);
            if (rational) s.weights[at] = power(r, -0.4, 0.4);
        }
}

/* The ring stands some way over the surface, its axis slanted. */
static void lay(const btg_tool_element *e, const btg_surface_point *s, rng *r) {
    btg_vec3 n = vec_unit(vec_cross(s->su, s->sv)), a = vec_perpendicular(n), b = vec_cross(n, a);
    double turn = rng_range(r, 0, 2 * BTG_PI),
           lean = rng_range(r, -1, 1) * (rng_pick(r, 2) ? 0.4 : 1.2);
    double far = e->corner_radius_mm * rng_range(r, 0.5, 1.5), angle = lean - BTG_PI / 2;
    btg_vec3 t = vec_add(vec_scale(a, cos(turn)), vec_scale(b, sin(turn)));
    btg_vec3 axis = vec_add(vec_scale(n, -sin(angle)), vec_scale(t, cos(angle)));
    btg_vec3 radial = vec_add(vec_scale(n, -cos(angle)), vec_scale(t, -sin(angle)));
    btg_vec3 ring = vec_mad(s->s, axis, -far * sin(angle));
    btg_vec3 centre = vec_mad(ring, radial, -(e->ring_radius_mm + far * cos(angle)));
    if (rng_pick(r, 2)) axis = vec_unit(vec_mad(axis, hard_unit(r), power(r, -4, -0.5)));
    search.at = (btg_placement){centre, axis, false};
}

/* The wedge's bound of V at t0, and what its terms add up to. */
static double bound_at(double t0, double *terms) {
    double t = fabs(t0), off = room.row[OFF][0], g = room.row[SLOPE_T][0] * t0;
    double k = 0.5 * room.row[BEND_T][0] * t * t, cubic = room.row[CUBIC][0] * t * t * t;
    double fourth = room.row[FOURTH][0] * t * t * t * t;
    *terms = fabs(off) + fabs(g) + fabs(k) + cubic + fourth + 1e-9;
    return -off + g + k - cubic - fourth;
}

/* Of a place in the wedge: how much V is above its bound, part of that's terms; else infinite. */
static double check_place(btg_place at, const btg_tool_element *e, double wide) {
    const btg_ring *ring = &search.ring;
    if (!(at.u >= 0 && at.u <= 1 && at.v >= 0 && at.v <= 1)) return INFINITY;
    if (fabs(at.u - ring->u) >= ring->half_u || fabs(at.v - ring->v) >= ring->half_v)
        return INFINITY;
    btg_surface_point s;
    btg_part_point(search.part, at, &s);
    btg_vec3 d = vec_sub(s.s, search.at.centre);
    double x = vec_dot(d, ring->x), y = vec_dot(d, ring->y), z = vec_dot(d, search.at.axis);
    double c = room.row[COSINE][0], sine = room.row[SINE][0], r0 = room.row[RADIUS][0];
    double far = room.row[FAR][0], r = hypot(x, y), turn = (y * c - x * sine) / r, terms;
    bool before = x * c + y * sine > 0;
    if (!before || fabs(turn) > room.row[HALF][0] || fabs(r - r0) > wide) return INFINITY;
    double out = r - e->ring_radius_mm, v = (out * out + z * z - far * far) / (2 * far);
    double bound = bound_at(r0 * turn, &terms);
    if (!(v >= bound - ROUNDING)) fprintf(stderr, "V %g, bound %g\n", v, bound);
    CHECK(v >= bound - ROUNDING);
    return (v - bound) / terms;
}

static void check_wedge(const btg_tool *tool, btg_place p, rng *r) {
    const btg_tool_element *e = &tool->element[0];
    btg_ring *ring = &search.ring;
    btg_surface_point s;
    btg_part_point(search.part, p, &s);
    if (!(vec_norm(vec_cross(s.su, s.sv)) > 1e-9)) return;
    search.query = (btg_ray_query){.op = BTG_OP_TILT, .tool = tool, .p = s.s};
    search.p_place = p;
    lay(e, &s, r);
    if (!turn_to_p(&search)) return;
    for (int k = 0; k < 8; k++) {
        room.row[U][k] = p.u;
        room.row[V][k] = p.v;
    }
    expand_feet(&search, &room, 4);
    double size = power(r, -2, 0.3) * SIZE / 2;
    double wide = power(r, -2, 0) * min2(e->ring_radius_mm, e->corner_radius_mm);
    ring->half_u = size / vec_norm(s.su);
    ring->half_v = size / vec_norm(s.sv) * power(r, -0.5, 0.5);
    ring->u = p.u + ring->half_u * rng_range(r, -1, 1);
    ring->v = p.v + ring->half_v * rng_range(r, -1, 1);
    for (int k = 0; k < 8; k++)
        room.row[HALF][k] = k ? room.row[HALF][0] : power(r, -2, -0.31);
    bound_wedges(&room, 4, ring, wide);
    if (!(holds(&room, 0, ring) & 1)) return;
    bounds++;
    double least = INFINITY;
    btg_place best = p;
    for (int i = 0; i < SAMPLES; i++) {
        btg_place at = {p.item, ring->u + ring->half_u * rng_range(r, -1, 1),
                        ring->v + ring->half_v * rng_range(r, -1, 1)};
        double step = power(r, -3, 0);
        if (i > SAMPLES / 8 && i % 4) { /* about where the bound has been nearest */
            at.u = best.u + step * ring->half_u * rng_range(r, -1, 1);
            at.v = best.v + step * ring->half_v * rng_range(r, -1, 1);
        }
        double own = check_place(at, e, wide);
        if (own < least) {
            least = own;
            best = at;
        }
    }
    close_ones += least < CLOSE;
}

int main(void) {
    rng r = {20261123};
    for (int round = hard_rounds(ROUNDS); round > 0; round--) {
        model m = {0};
        add_patch(&m, &r);
        btg_part *part = model_part(&m);
        search = (btg_search){.part = part};
        for (int i = 0; i < WAYS; i++) {
            btg_tool_def def = btg_tool_def_default();
            btg_tool tool;
            def.major_radius_mm = power(&r, 0, 1.4);
            def.minor_radius_mm = power(&r, -0.3, 1.2);
            CHECK(btg_tool_init(&def, &tool, NULL) == BTG_OK);
            btg_place p = {0, 0, 0};
            p.u = rng_range(&r, 0, 1);
            p.v = rng_range(&r, 0, 1);
            check_wedge(&tool, p, &r);
        }
        btg_part_destroy(part);
        model_free(&m);
    }
    fprintf(stderr, "%ld bounds, %ld of them next to V\n", bounds, close_ones);
    CHECK(bounds > hard_rounds(ROUNDS) && close_ones > bounds / 4);
    return check_result();
}
