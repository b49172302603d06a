/* Bounds to second order, four pieces of a patch at a time.
 *
 * Of a torus or a solid's round corner the distance at a step x from a point is, with n the
 * gradient, m the meridian's and t the ring's tangent there, r the point's distance from the axis
 * and D that from the circle, about
 *
 *     D + n.x + (m.x)^2 / (2 D) + n_r (t.x)^2 / (2 r).
 *
 * Put together with the piece's own second derivatives this is a quadratic form in the piece's two
 * parameters, whose least over the square is closed form: where the piece comes nearest.
 *
 * From below: a step aside t turns the radius out by tau = t^2 / (2 r), r within the piece's reach,
 * and the distance is at least D + n.x + n_r tau + c (m.x - n_z tau)^2 / 2, c the least of 1 / D.
 * Measured from mu, the meridian's part of the way to the nearest place, that square is at least
 *
 *     (m.x)^2 - 2 mu n_z tau - SHARE (m.x - mu)^2 - (1 / SHARE - 1) (n_z tau)^2,
 *
 * a quadratic form once more, that loses next to nothing near that place. Third derivatives and
 * products of bends come off as a constant. Where the piece reaches over the ring's top or a
 * solid's rim the distance is still convex across the meridian: c = 0 there. */
#include "core/block.h"

#if defined(__GNUC__)
#define ALWAYS_INLINE inline __attribute__((always_inline))
#else
#define ALWAYS_INLINE inline
#endif

/* Of the meridian's bend, away from the nearest place, spent on what turns with it. */
#define SHARE 0.7

/* Sides whose ratio is more than this are cut by four along the longer one. */
#define LONG_SIDE 2.8

/* The next float up: bounds must not shrink. */
static float round_up(double x) {
    return (float)(x * (1 + 1e-7)) + 1e-37f;
}

void btg_piece_root(const btg_part *part, uint32_t item, btg_piece *piece) {
    const btg_patch *patch = &part->patches[item];
    *piece = (btg_piece){0.5, 0.5, 0.5, 0.5, {0}, item, patch->quarter, (btg_cut)patch->cut};
    for (int k = 0; k < 4; k++)
        piece->third[k] = round_up(0.125 * patch->third[k]); /* cubes of half sides */
}

/* By how much halving shrinks third derivatives, by cut. */
static const float third_scale[3][4] = {{0.125f, 0.125f, 0.125f, 0.125f},
                                        {1.0f / 64, 1.0f / 16, 0.25f, 1},
                                        {1, 0.25f, 1.0f / 16, 1.0f / 64}};

/* Bounds of the four pieces' third derivatives, in units of their half sides. */
typedef struct thirds {
    lanes uuu, uuv, uvv, vvv;
} thirds;

static ALWAYS_INLINE lanes widened(const float from[4]) {
    double wide[4];
    for (int k = 0; k < 4; k++)
        wide[k] = (double)from[k];
    return lanes_load(wide);
}

static ALWAYS_INLINE thirds thirds_of(const btg_part *part, const btg_piece *piece) {
    if (piece->quarters) {
        const btg_quarters *q = &part->quarters[piece->quarters];
        return (thirds){widened(q->third[0]), widened(q->third[1]), widened(q->third[2]),
                        widened(q->third[3])};
    }
    const float *scale = third_scale[piece->cut], *t = piece->third;
    return (thirds){lanes_all((double)(scale[0] * t[0])), lanes_all((double)(scale[1] * t[1])),
                    lanes_all((double)(scale[2] * t[2])), lanes_all((double)(scale[3] * t[3]))};
}

/* Parameters of the quarters. */
static void place_quarters(const btg_piece *piece, btg_block *block) {
    static const double side[3][2][4] = {{{-0.5, 0.5, -0.5, 0.5}, {-0.5, -0.5, 0.5, 0.5}},
                                         {{-0.75, -0.25, 0.25, 0.75}, {0, 0, 0, 0}},
                                         {{0, 0, 0, 0}, {-0.75, -0.25, 0.25, 0.75}}};
    static const double half[3][2] = {{0.5, 0.5}, {0.25, 1}, {1, 0.25}};
    const double *su = side[piece->cut][0], *sv = side[piece->cut][1];
    lanes u = lanes_mad(lanes_all(piece->u), lanes_load(su), lanes_all(piece->hu));
    lanes v = lanes_mad(lanes_all(piece->v), lanes_load(sv), lanes_all(piece->hv));
    lanes_store(block->u, u);
    lanes_store(block->v, v);
    block->hu = half[piece->cut][0] * piece->hu;
    block->hv = half[piece->cut][1] * piece->hv;
}

static ALWAYS_INLINE lanes length(lanes3 a) {
    return lanes_sqrt(lanes3_dot(a, a));
}

static btg_cut cut_of(double u, double v) {
    if (u > LONG_SIDE * v) return BTG_CUT_U;
    return v > LONG_SIDE * u ? BTG_CUT_V : BTG_CUT_BOTH;
}

btg_cut btg_piece_cut(const btg_part *part, const btg_piece *piece) {
    btg_surface_point s;
    btg_patch_evaluate(&part->patches[piece->item], piece->u, piece->v, &s);
    double hu = piece->hu, hv = piece->hv;
    return cut_of(hu * (vec_norm(s.su) + 0.5 * hu * vec_norm(s.suu)),
                  hv * (vec_norm(s.sv) + 0.5 * hv * vec_norm(s.svv)));
}

void btg_block_quarter(const btg_part *part, const btg_block *block, int k, btg_piece *piece) {
    const btg_piece *whole = &block->whole;
    piece->u = block->u[k];
    piece->v = block->v[k];
    piece->hu = block->hu;
    piece->hv = block->hv;
    piece->item = whole->item;
    piece->quarters = 0;
    if (whole->quarters) {
        const btg_quarters *stored = &part->quarters[whole->quarters];
        for (int i = 0; i < 4; i++)
            piece->third[i] = stored->third[i][k];
        piece->quarters = stored->child[k];
        piece->cut = (btg_cut)stored->cut[k];
    } else {
        for (int i = 0; i < 4; i++)
            piece->third[i] = third_scale[whole->cut][i] * whole->third[i];
    }
    if (!piece->quarters) piece->cut = cut_of(block->side_u[k], block->side_v[k]);
}

static ALWAYS_INLINE lanes3 scale(lanes3_memory *v, lanes by) {
    lanes3 scaled = lanes3_scale(lanes3_load(v), by);
    lanes3_store(v, scaled);
    return scaled;
}

void btg_block_make(const btg_part *part, const btg_piece *piece, btg_block *block) {
    const btg_patch *patch = &part->patches[piece->item];
    block->whole = *piece;
    place_quarters(piece, block);
    btg_patch_evaluate_four(patch, block->u, block->v, &block->at);
    lanes hu = lanes_all(block->hu), hv = lanes_all(block->hv);
    lanes uu = length(scale(&block->at.suu, lanes_mul(hu, hu)));
    lanes uv = length(scale(&block->at.suv, lanes_mul(hu, hv)));
    lanes vv = length(scale(&block->at.svv, lanes_mul(hv, hv)));
    lanes3 a = scale(&block->at.su, hu), b = scale(&block->at.sv, hv);
    lanes over = lanes_all(1 + 1e-12), half = lanes_all(0.5);
    thirds t = thirds_of(part, piece);
    lanes sixth = lanes_all((1 + 1e-12) / 6);
    lanes third_u = lanes_mad(t.uuu, lanes_all(3), t.uuv);
    lanes third_v = lanes_mad(t.vvv, lanes_all(3), t.uvv);
    third_u = lanes_mul(third_u, sixth);
    third_v = lanes_mul(third_v, sixth);
    lanes error = lanes_add(lanes_add(third_u, third_v), lanes_all(patch->rounding));
    lanes bend = lanes_mad(error, half, lanes_add(uu, vv));
    bend = lanes_mul(lanes_add(bend, uv), over);
    lanes aa = lanes3_dot(a, a), bb = lanes3_dot(b, b), ab = lanes_abs(lanes3_dot(a, b));
    lanes diagonal = lanes_sqrt(lanes_add(lanes_add(aa, bb), lanes_add(ab, ab)));
    lanes_store(block->side_u, lanes_mad(lanes_add(lanes_sqrt(aa), third_u), half, uu));
    lanes_store(block->side_v, lanes_mad(lanes_add(lanes_sqrt(bb), third_v), half, vv));
    lanes_store(block->error, error);
    lanes_store(block->bend, bend);
    lanes_store(block->radius, lanes_mad(bend, diagonal, over));
}

static void widen(const float from[3][4], lanes3_memory *to) {
    for (int k = 0; k < 4; k++) {
        for (int c = 0; c < 3; c++)
            to->at[c][k] = (double)from[c][k];
    }
}

void btg_block_of_node(const btg_node *node, btg_block *block) {
    widen(node->centre, &block->at.s);
    widen(node->a, &block->at.su);
    widen(node->b, &block->at.sv);
    widen(node->uu, &block->at.suu);
    widen(node->uv, &block->at.suv);
    widen(node->vv, &block->at.svv);
    for (int k = 0; k < 4; k++) {
        block->error[k] = (double)node->error[k];
        block->bend[k] = (double)node->bend[k];
        block->radius[k] = (double)node->radius[k];
    }
}

static void set_lane(lanes3_memory *to, int k, btg_vec3 v) {
    to->at[0][k] = v.x;
    to->at[1][k] = v.y;
    to->at[2][k] = v.z;
}

void btg_block_of_triangles(const btg_part *part, const uint32_t *triangles, uint32_t count,
                            btg_block *block) {
    memset(&block->at.suu, 0, sizeof block->at.suu);
    memset(&block->at.suv, 0, sizeof block->at.suv);
    memset(&block->at.svv, 0, sizeof block->at.svv);
    for (uint32_t k = 0; k < 4; k++) {
        btg_vec3 c[3];
        btg_triangle_corners(part, triangles[k < count ? k : 0], c);
        btg_vec3 a = vec_scale(vec_sub(c[1], c[0]), 0.5), b = vec_scale(vec_sub(c[2], c[0]), 0.5);
        double rounding = 1e-14 * part->scale;
        double p = vec_norm(vec_add(a, b)), m = vec_norm(vec_sub(a, b));
        set_lane(&block->at.s, (int)k, vec_scale(vec_add(c[1], c[2]), 0.5));
        set_lane(&block->at.su, (int)k, a);
        set_lane(&block->at.sv, (int)k, b);
        block->error[k] = block->bend[k] = rounding;
        block->radius[k] = max2(p, m) + rounding;
    }
}

/* ---- bounds ------------------------------------------------------------------------------- */

/* a s + b t + (uu s^2 + 2 uv s t + vv t^2) / 2. */
typedef struct quadratic {
    lanes a, b, uu, uv, vv;
} quadratic;

typedef struct minimum {
    lanes value, s, t;
} minimum;

static ALWAYS_INLINE minimum better(minimum m, lanes value, lanes s, lanes t) {
    return (minimum){lanes_min(value, m.value), lanes_if_less(value, m.value, s, m.s),
                     lanes_if_less(value, m.value, t, m.t)};
}

/* Where g t + h t^2 / 2 is least on |t| <= 1; inverse: 1 / h where h > 0. */
static ALWAYS_INLINE lanes least_on_side(lanes g, lanes h, lanes inverse) {
    lanes one = lanes_all(1), minus = lanes_all(-1), zero = lanes_all(0);
    lanes inside = lanes_max(minus, lanes_min(one, lanes_mul(lanes_sub(zero, g), inverse)));
    return lanes_if_less(zero, h, inside, lanes_if_less(zero, g, minus, one));
}

/* The least over the square: on one of its sides, or inside where the form is convex. */
static ALWAYS_INLINE minimum least_in_square(const quadratic *q) {
    lanes half = lanes_all(0.5), zero = lanes_all(0), one = lanes_all(1), minus = lanes_all(-1);
    lanes iu = lanes_div(one, lanes_if_less(zero, q->uu, q->uu, one));
    lanes iv = lanes_div(one, lanes_if_less(zero, q->vv, q->vv, one));
    lanes huu = lanes_mul(half, q->uu), hvv = lanes_mul(half, q->vv);
    lanes g, x;
    minimum m;
    g = lanes_add(q->b, q->uv);
    x = least_on_side(g, q->vv, iv);
    m = (minimum){lanes_add(lanes_add(q->a, huu), lanes_mul(lanes_mad(g, hvv, x), x)), one, x};
    g = lanes_sub(q->b, q->uv);
    x = least_on_side(g, q->vv, iv);
    m = better(m, lanes_add(lanes_sub(huu, q->a), lanes_mul(lanes_mad(g, hvv, x), x)), minus, x);
    g = lanes_add(q->a, q->uv);
    x = least_on_side(g, q->uu, iu);
    m = better(m, lanes_add(lanes_add(q->b, hvv), lanes_mul(lanes_mad(g, huu, x), x)), x, one);
    g = lanes_sub(q->a, q->uv);
    x = least_on_side(g, q->uu, iu);
    m = better(m, lanes_add(lanes_sub(hvv, q->b), lanes_mul(lanes_mad(g, huu, x), x)), x, minus);
    lanes det = lanes_sub(lanes_mul(q->uu, q->vv), lanes_mul(q->uv, q->uv));
    lanes inverse = lanes_div(one, lanes_if_less(zero, det, det, one));
    lanes s = lanes_mul(lanes_sub(lanes_mul(q->uv, q->b), lanes_mul(q->vv, q->a)), inverse);
    lanes t = lanes_mul(lanes_sub(lanes_mul(q->uv, q->a), lanes_mul(q->uu, q->b)), inverse);
    lanes value = lanes_mul(half, lanes_mad(lanes_mul(q->a, s), q->b, t));
    /* not inside: worse than any */
    lanes out = lanes_max(lanes_abs(s), lanes_abs(t)), never = lanes_all(INFINITY);
    value = lanes_if_less(one, out, never, value);
    value = lanes_if_less(zero, lanes_min(det, q->uu), value, never);
    return better(m, value, s, t);
}

/* The point's place in the tool's frame, and the gradient there. */
typedef struct place {
    lanes3 radial, ring; /* unit, away from the axis and along the ring */
    lanes r, height, far;
    lanes n_r, n_z; /* gradient: along radial and axis */
} place;

static ALWAYS_INLINE lanes dot_one(lanes3 a, btg_vec3 b) {
    return lanes_mad(lanes_mad(lanes_mul(a.x, lanes_all(b.x)), a.y, lanes_all(b.y)), a.z,
                     lanes_all(b.z));
}

static ALWAYS_INLINE place place_of(const btg_block *block, const btg_tool_element *e,
                                    const btg_placement *at) {
    lanes3 c = lanes3_load(&block->at.s);
    lanes3 d = {lanes_sub(c.x, lanes_all(at->centre.x)), lanes_sub(c.y, lanes_all(at->centre.y)),
                lanes_sub(c.z, lanes_all(at->centre.z))};
    lanes x = lanes_all(at->axis.x), y = lanes_all(at->axis.y), z = lanes_all(at->axis.z);
    place p;
    p.height = dot_one(d, at->axis);
    lanes3 radial = {lanes_sub(d.x, lanes_mul(p.height, x)), lanes_sub(d.y, lanes_mul(p.height, y)),
                     lanes_sub(d.z, lanes_mul(p.height, z))};
    p.r = lanes_max(length(radial), lanes_all(1e-300));
    lanes inverse = lanes_div(lanes_all(1), p.r);
    p.radial = (lanes3){lanes_mul(radial.x, inverse), lanes_mul(radial.y, inverse),
                        lanes_mul(radial.z, inverse)};
    p.ring = (lanes3){lanes_sub(lanes_mul(y, p.radial.z), lanes_mul(z, p.radial.y)),
                      lanes_sub(lanes_mul(z, p.radial.x), lanes_mul(x, p.radial.z)),
                      lanes_sub(lanes_mul(x, p.radial.y), lanes_mul(y, p.radial.x))};
    lanes out = lanes_sub(p.r, lanes_all(e->ring_radius_mm));
    if (!e->hollow) out = lanes_max(out, lanes_all(0));
    lanes down = lanes_min(p.height, lanes_all(0));
    p.far = lanes_sqrt(lanes_mad(lanes_mul(out, out), down, down));
    lanes over = lanes_div(lanes_all(1), lanes_max(p.far, lanes_all(1e-300)));
    p.n_r = lanes_mul(out, over);
    p.n_z = lanes_mul(down, over);
    return p;
}

/* By the piece's extent in radius and height: under the hollow, near the axis, where the ring bends
 * most, nothing else is any use. */
static ALWAYS_INLINE lanes bound_by_extent(const place *p, const btg_tool_element *e, lanes radius,
                                           lanes up) {
    lanes zero = lanes_all(0), ring = lanes_all(e->ring_radius_mm);
    lanes out = lanes_max(zero, lanes_sub(lanes_sub(p->r, radius), ring));
    if (e->hollow) out = lanes_max(out, lanes_sub(lanes_sub(ring, p->r), radius));
    lanes down = lanes_max(zero, lanes_sub(zero, lanes_add(p->height, up)));
    lanes far = lanes_sqrt(lanes_mad(lanes_mul(out, out), down, down));
    return lanes_sub(far, lanes_all(e->corner_radius_mm));
}

static ALWAYS_INLINE lanes sum_abs(lanes a, lanes b) {
    return lanes_add(lanes_abs(a), lanes_abs(b));
}

/* How far a tangential part of the pieces' second derivatives leads. */
static ALWAYS_INLINE lanes bend_along(const btg_block *block, lanes3 d) {
    lanes uu = lanes_abs(lanes3_dot(d, lanes3_load(&block->at.suu)));
    lanes uv = lanes_abs(lanes3_dot(d, lanes3_load(&block->at.suv)));
    lanes vv = lanes_abs(lanes3_dot(d, lanes3_load(&block->at.svv)));
    lanes sum = lanes_mad(uv, lanes_all(0.5), lanes_add(uu, vv));
    return lanes_add(sum, lanes_load(block->error));
}

/* The pieces in the frame at their centres: first derivatives along n, m and t, the second along n,
 * and how far the pieces reach. */
typedef struct frame {
    lanes na, nb, ma, mb, ta, tb, nuu, nuv, nvv;
    lanes linear_m, bend_m, bend_t; /* along m: first order, second order; along t: second */
    lanes reach_n, reach_m, reach_t, reach_r, reach_up;
} frame;

static ALWAYS_INLINE lanes3 in_meridian(const place *p, btg_vec3 axis, lanes along_r,
                                        lanes along_z) {
    return (lanes3){lanes_mad(lanes_mul(along_r, p->radial.x), along_z, lanes_all(axis.x)),
                    lanes_mad(lanes_mul(along_r, p->radial.y), along_z, lanes_all(axis.y)),
                    lanes_mad(lanes_mul(along_r, p->radial.z), along_z, lanes_all(axis.z))};
}

static ALWAYS_INLINE frame frame_of(const btg_block *block, const btg_placement *at,
                                    const place *p) {
    lanes3 a = lanes3_load(&block->at.su), b = lanes3_load(&block->at.sv);
    lanes3 n = in_meridian(p, at->axis, p->n_r, p->n_z);
    lanes3 m = in_meridian(p, at->axis, lanes_sub(lanes_all(0), p->n_z), p->n_r);
    lanes bend = lanes_load(block->bend);
    frame f;
    f.na = lanes3_dot(n, a);
    f.nb = lanes3_dot(n, b);
    f.ma = lanes3_dot(m, a);
    f.mb = lanes3_dot(m, b);
    f.ta = lanes3_dot(p->ring, a);
    f.tb = lanes3_dot(p->ring, b);
    f.nuu = lanes3_dot(n, lanes3_load(&block->at.suu));
    f.nuv = lanes3_dot(n, lanes3_load(&block->at.suv));
    f.nvv = lanes3_dot(n, lanes3_load(&block->at.svv));
    f.linear_m = sum_abs(f.ma, f.mb);
    f.bend_m = bend_along(block, m);
    f.bend_t = bend_along(block, p->ring);
    f.reach_n = lanes_add(sum_abs(f.na, f.nb), bend);
    f.reach_m = lanes_add(f.linear_m, f.bend_m);
    f.reach_t = lanes_add(sum_abs(f.ta, f.tb), f.bend_t);
    f.reach_r = lanes_add(sum_abs(lanes3_dot(a, p->radial), lanes3_dot(b, p->radial)), bend);
    f.reach_up = lanes_add(sum_abs(dot_one(a, at->axis), dot_one(b, at->axis)), bend);
    return f;
}

/* The form with bends c across and k along the ring, and n times a weight. */
static ALWAYS_INLINE quadratic form_of(const frame *f, lanes c, lanes k, lanes weight) {
    lanes cma = lanes_mul(c, f->ma), cmb = lanes_mul(c, f->mb);
    lanes kta = lanes_mul(k, f->ta), ktb = lanes_mul(k, f->tb);
    lanes uu = lanes_mad(lanes_mul(cma, f->ma), kta, f->ta);
    lanes uv = lanes_mad(lanes_mul(cma, f->mb), kta, f->tb);
    lanes vv = lanes_mad(lanes_mul(cmb, f->mb), ktb, f->tb);
    return (quadratic){lanes_mul(f->na, weight), lanes_mul(f->nb, weight),
                       lanes_mad(uu, f->nuu, weight), lanes_mad(uv, f->nuv, weight),
                       lanes_mad(vv, f->nvv, weight)};
}

/* The bend across the ring that holds all over the pieces, and what is paid for it. */
typedef struct across {
    lanes c, paid;
} across;

/* On the circle's distance A = D + x_n the square x_m^2 weighs G = 1 / (2 A + m^2 / (2 A)) at
 * least, m the most of x_m. G is convex: at least c / 2 - c^2 / 2 x_n, c / 2 its value at D. The
 * second part counts where x_n > 0 only, and there by m^2 at most: paid, a part of x_n + n, n the
 * most of x_n. Where G is not convex that far, its least. */
static ALWAYS_INLINE across bend_across(const place *p, lanes far_m, lanes far_n) {
    lanes zero = lanes_all(0), one = lanes_all(1), m2 = lanes_mul(far_m, far_m);
    lanes far = lanes_max(p->far, lanes_all(1e-300)), quarter = lanes_all(0.25);
    lanes share = lanes_div(m2, far);
    lanes least = lanes_mad(lanes_add(far, far_n), lanes_all(0.5), share);
    lanes here = lanes_mad(far, quarter, share);
    lanes convex = lanes_sub(lanes_sub(far, far_n), lanes_mul(lanes_all(0.87), far_m));
    lanes c = lanes_div(one, lanes_if_less(zero, convex, here, least));
    lanes paid = lanes_mul(quarter, lanes_mul(lanes_mul(c, c), m2));
    return (across){c, lanes_if_less(zero, convex, paid, zero)};
}

/* The form from below; *off comes off its least. */
static ALWAYS_INLINE quadratic lower_form(const btg_tool_element *e, const place *p, const frame *f,
                                          lanes error, const minimum *nearest, lanes *off) {
    lanes zero = lanes_all(0), half = lanes_all(0.5), one = lanes_all(1);
    lanes steep = lanes_abs(p->n_z);
    lanes inner = lanes_sub(p->r, f->reach_r), aside2 = lanes_mul(f->reach_t, f->reach_t);
    lanes outer = lanes_add(lanes_add(p->r, f->reach_r), lanes_mul(aside2, lanes_div(half, p->r)));
    lanes safe = lanes_max(inner, lanes_mul(p->r, lanes_all(0.05)));
    lanes inner1 = lanes_div(one, safe), turn = lanes_mul(half, lanes_mul(aside2, inner1));

    lanes far_m = lanes_mad(f->reach_m, steep, turn);
    lanes far_n = lanes_mad(f->reach_n, lanes_abs(p->n_r), turn);
    across x = bend_across(p, far_m, far_n);
    lanes c = x.c;
    c = lanes_if_less(zero, lanes_add(p->height, f->reach_up), zero, c);
    c = lanes_if_less(inner, safe, zero, c);
    if (!e->hollow) c = lanes_if_less(inner, lanes_all(e->ring_radius_mm), zero, c);

    lanes paid = lanes_if_less(zero, c, x.paid, zero), weight = lanes_sub(one, paid);
    lanes mu = lanes_mad(lanes_mul(f->ma, nearest->s), f->mb, nearest->t);
    lanes slope = lanes_mad(lanes_mul(p->n_r, weight), lanes_mul(c, steep), mu); /* in tau */
    lanes k = lanes_if_less(slope, zero, lanes_mul(slope, inner1), lanes_div(slope, outer));
    lanes spent = lanes_mul(lanes_mul(c, steep), lanes_mul(steep, lanes_mul(turn, inner1)));
    k = lanes_sub(k, lanes_mul(lanes_all(0.5 * (1 / SHARE - 1)), spent));

    /* - SHARE c (m.x - mu)^2 / 2 */
    quadratic q = form_of(f, lanes_mul(c, lanes_all(1 - SHARE)), k, weight);
    lanes pull = lanes_mul(lanes_mul(lanes_all(SHARE), c), mu);
    q.a = lanes_mad(q.a, pull, f->ma);
    q.b = lanes_mad(q.b, pull, f->mb);
    lanes constant = lanes_mad(lanes_mul(half, lanes_mul(pull, mu)), paid, far_n);
    lanes m_off = lanes_mul(c, lanes_mad(f->linear_m, lanes_all(SHARE), lanes_abs(mu)));
    lanes products = lanes_mul(m_off, f->bend_m);
    products = lanes_mad(products, lanes_mul(lanes_abs(k), f->reach_t), f->bend_t);
    *off = lanes_add(lanes_add(error, products), constant);
    /* under the hollow and over the axis the form means nothing */
    if (e->hollow) {
        lanes nothing = lanes_if_less(p->n_r, zero, lanes_all(INFINITY), *off);
        *off = lanes_if_less(inner, safe, nothing, *off);
    }
    return q;
}

void btg_block_bounds(const btg_block *block, const btg_tool_element *e, const btg_placement *at,
                      double enough, btg_block_bound *bound) {
    place p = place_of(block, e, at);
    lanes distance = lanes_sub(p.far, lanes_all(e->corner_radius_mm));
    lanes radius = lanes_load(block->radius), ball = lanes_sub(distance, radius);
    lanes_store(bound->distance, distance);
    lanes_store(bound->height, p.height);
    lanes_store(bound->low, ball);
    if (bound->low[0] >= enough && bound->low[1] >= enough && bound->low[2] >= enough &&
        bound->low[3] >= enough) {
        lanes_store(bound->form, ball);
        lanes_store(bound->least, distance);
        lanes_store(bound->top, lanes_add(p.height, radius));
        lanes_store(bound->s, lanes_all(0));
        lanes_store(bound->t, lanes_all(0));
        return;
    }
    frame f = frame_of(block, at, &p);
    quadratic about = form_of(&f, lanes_div(p.n_z, lanes_min(p.height, lanes_all(-1e-300))),
                              lanes_div(p.n_r, p.r), lanes_all(1));
    minimum nearest = least_in_square(&about);
    lanes off;
    quadratic q = lower_form(e, &p, &f, lanes_load(block->error), &nearest, &off);
    minimum least = least_in_square(&q);
    lanes low = lanes_add(distance, lanes_sub(least.value, off));
    lanes_store(bound->form, low);
    low = lanes_max(low, bound_by_extent(&p, e, radius, f.reach_up));
    lanes_store(bound->low, lanes_max(low, ball));
    lanes_store(bound->top, lanes_add(p.height, lanes_min(radius, f.reach_up)));
    lanes_store(bound->least, lanes_add(distance, nearest.value));
    lanes_store(bound->s, nearest.s);
    lanes_store(bound->t, nearest.t);
}

btg_vec3 btg_block_normal(const btg_block *block, int k, const btg_tool_element *e,
                          const btg_placement *at) {
    btg_vec3 d = vec_sub(btg_block_vector(&block->at.s, k), at->centre);
    double height = vec_dot(d, at->axis);
    btg_vec3 radial = vec_mad(d, at->axis, -height);
    double r = max2(vec_norm(radial), 1e-300), out = r - e->ring_radius_mm;
    if (!e->hollow) out = max2(out, 0);
    double down = min2(height, 0), far = max2(norm2(out, down), 1e-300);
    return vec_mad(vec_scale(radial, out / (far * r)), at->axis, down / far);
}
