/* Bounds to second order, a block of pieces at a time.
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

/* Of the meridian's bend, away from the nearest place, spent on what turns with it. */
#define SHARE 0.7

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

/* What is divided by is this at the least, so that products of three do not vanish. */
#define SMALLEST 1e-90

/* Inverses of positive numbers: divisions are slow. */
static ALWAYS_INLINE void invert_two(lanes a, lanes b, lanes *ia, lanes *ib) {
    lanes inverse = lanes_div(lanes_all(1), lanes_mul(a, b));
    *ia = lanes_mul(b, inverse);
    *ib = lanes_mul(a, inverse);
}

static ALWAYS_INLINE void invert_three(lanes a, lanes b, lanes c, lanes *ia, lanes *ib, lanes *ic) {
    lanes ab = lanes_mul(a, b), inverse = lanes_div(lanes_all(1), lanes_mul(ab, c));
    lanes iab = lanes_mul(c, inverse);
    *ic = lanes_mul(ab, inverse);
    *ia = lanes_mul(b, iab);
    *ib = lanes_mul(a, iab);
}

/* 1 where it is not positive. */
static ALWAYS_INLINE lanes divisor(lanes a) {
    lanes held = lanes_max(a, lanes_all(SMALLEST));
    return lanes_if_less(lanes_all(0), a, held, lanes_all(1));
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
    lanes det = lanes_sub(lanes_mul(q->uu, q->vv), lanes_mul(q->uv, q->uv)), iu, iv, inverse;
    invert_three(divisor(q->uu), divisor(q->vv), divisor(det), &iu, &iv, &inverse);
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
    lanes s = lanes_mul(lanes_sub(lanes_mul(q->uv, q->b), lanes_mul(q->vv, q->a)), inverse);
    lanes t = lanes_mul(lanes_sub(lanes_mul(q->uv, q->a), lanes_mul(q->uu, q->b)), inverse);
    lanes value = lanes_mul(half, lanes_mad(lanes_mul(q->a, s), q->b, t));
    /* not inside: worse than any */
    lanes out = lanes_max(lanes_abs(s), lanes_abs(t)), never = lanes_all(INFINITY);
    value = lanes_if_less(one, out, never, value);
    value = lanes_if_less(zero, lanes_min(det, q->uu), value, never);
    return better(m, value, s, t);
}

/* The least over the half of the square where s + t <= 0. */
static ALWAYS_INLINE minimum least_in_triangle(const quadratic *q) {
    lanes half = lanes_all(0.5), zero = lanes_all(0), one = lanes_all(1), minus = lanes_all(-1);
    lanes huu = lanes_mul(half, q->uu), hvv = lanes_mul(half, q->vv);
    lanes det = lanes_sub(lanes_mul(q->uu, q->vv), lanes_mul(q->uv, q->uv)), iu, iv, inverse;
    invert_three(divisor(q->uu), divisor(q->vv), divisor(det), &iu, &iv, &inverse);
    lanes g = lanes_sub(q->b, q->uv), x = least_on_side(g, q->vv, iv);
    minimum m = {lanes_add(lanes_sub(huu, q->a), lanes_mul(lanes_mad(g, hvv, x), x)), minus, x};
    g = lanes_sub(q->a, q->uv);
    x = least_on_side(g, q->uu, iu);
    m = better(m, lanes_add(lanes_sub(hvv, q->b), lanes_mul(lanes_mad(g, huu, x), x)), x, minus);
    lanes bend = lanes_add(lanes_sub(q->uu, lanes_add(q->uv, q->uv)), q->vv);
    g = lanes_sub(q->a, q->b);
    x = least_on_side(g, bend, lanes_div(one, divisor(bend)));
    m = better(m, lanes_mul(lanes_mad(g, lanes_mul(half, bend), x), x), x, lanes_sub(zero, x));
    lanes s = lanes_mul(lanes_sub(lanes_mul(q->uv, q->b), lanes_mul(q->vv, q->a)), inverse);
    lanes t = lanes_mul(lanes_sub(lanes_mul(q->uv, q->a), lanes_mul(q->uu, q->b)), inverse);
    lanes value = lanes_mul(half, lanes_mad(lanes_mul(q->a, s), q->b, t));
    lanes never = lanes_all(INFINITY), low = lanes_min(s, t), high = lanes_add(s, t);
    value = lanes_if_less(low, minus, never, value);
    value = lanes_if_less(zero, high, never, value);
    value = lanes_if_less(zero, lanes_min(det, q->uu), value, never);
    return better(m, value, s, t);
}

/* Near where the form is least over the square: from where it would be least without sides, or the
 * corner down the slope, held by one side, then along the other. */
static ALWAYS_INLINE void near_least(const quadratic *q, lanes *s, lanes *t) {
    lanes zero = lanes_all(0), one = lanes_all(1), minus = lanes_all(-1);
    lanes det = lanes_sub(lanes_mul(q->uu, q->vv), lanes_mul(q->uv, q->uv)), iu, iv, inverse;
    lanes convex = lanes_min(det, q->uu);
    invert_three(divisor(q->uu), divisor(q->vv), divisor(det), &iu, &iv, &inverse);
    lanes first = lanes_mul(lanes_sub(lanes_mul(q->uv, q->b), lanes_mul(q->vv, q->a)), inverse);
    first = lanes_if_less(zero, convex, first, lanes_if_less(zero, q->a, minus, one));
    first = lanes_max(minus, lanes_min(one, first));
    *t = least_on_side(lanes_mad(q->b, q->uv, first), q->vv, iv);
    *s = least_on_side(lanes_mad(q->a, q->uv, *t), q->uu, iu);
}

/* A place beyond s + t = 0 becomes the least along it. */
static ALWAYS_INLINE void into_triangle(const quadratic *q, lanes *s, lanes *t) {
    lanes bend = lanes_add(lanes_sub(q->uu, lanes_add(q->uv, q->uv)), q->vv), zero = lanes_all(0);
    lanes x = least_on_side(lanes_sub(q->a, q->b), bend, lanes_div(lanes_all(1), divisor(bend)));
    lanes beyond = lanes_add(*s, *t);
    *s = lanes_if_less(zero, beyond, x, *s);
    *t = lanes_if_less(zero, beyond, lanes_sub(zero, x), *t);
}

static ALWAYS_INLINE lanes value_at(const quadratic *q, lanes s, lanes t) {
    lanes half = lanes_all(0.5);
    lanes along_s = lanes_mad(lanes_mad(q->a, lanes_mul(half, q->uu), s), q->uv, t);
    return lanes_mad(lanes_mul(along_s, s), lanes_mad(q->b, lanes_mul(half, q->vv), t), t);
}

/* The point's place in the tool's frame, and the gradient there. */
typedef struct place {
    lanes3 radial, ring; /* unit, away from the axis and along the ring */
    lanes r, height, far, inverse_r, inverse_far;
    lanes n_r, n_z; /* gradient: along radial and axis */
} place;

static ALWAYS_INLINE place place_of(lanes3 c, const btg_tool_element *e, const btg_placement *at) {
    lanes3 d = {lanes_sub(c.x, lanes_all(at->centre.x)), lanes_sub(c.y, lanes_all(at->centre.y)),
                lanes_sub(c.z, lanes_all(at->centre.z))};
    lanes x = lanes_all(at->axis.x), y = lanes_all(at->axis.y), z = lanes_all(at->axis.z);
    place p;
    p.height = btg_block_dot(d, at->axis);
    lanes3 radial = {lanes_sub(d.x, lanes_mul(p.height, x)), lanes_sub(d.y, lanes_mul(p.height, y)),
                     lanes_sub(d.z, lanes_mul(p.height, z))};
    p.r = lanes_max(lanes_sqrt(lanes3_norm2(radial)), lanes_all(1e-30));
    lanes inverse = p.inverse_r = lanes_div(lanes_all(1), p.r);
    p.radial = (lanes3){lanes_mul(radial.x, inverse), lanes_mul(radial.y, inverse),
                        lanes_mul(radial.z, inverse)};
    p.ring = (lanes3){lanes_sub(lanes_mul(y, p.radial.z), lanes_mul(z, p.radial.y)),
                      lanes_sub(lanes_mul(z, p.radial.x), lanes_mul(x, p.radial.z)),
                      lanes_sub(lanes_mul(x, p.radial.y), lanes_mul(y, p.radial.x))};
    lanes out = lanes_sub(p.r, lanes_all(e->ring_radius_mm));
    if (!e->hollow) out = lanes_max(out, lanes_all(0));
    lanes down = lanes_min(p.height, lanes_all(0));
    p.far = lanes_sqrt(lanes_mad(lanes_mul(out, out), down, down));
    lanes over = p.inverse_far = lanes_div(lanes_all(1), lanes_max(p.far, lanes_all(1e-30)));
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

/* How far the pieces reach along the axis. */
static ALWAYS_INLINE lanes reach_up(const btg_block *block, int i, btg_vec3 axis) {
    lanes3 a = lanes3_load(&block->at.su, i), b = lanes3_load(&block->at.sv, i);
    return lanes_add(sum_abs(btg_block_dot(a, axis), btg_block_dot(b, axis)),
                     lanes_load(block->bend + i));
}

/* The pieces in the frame at their centres: first derivatives along n, m and t, the second along n,
 * and how far the pieces reach. */
typedef struct frame {
    lanes na, nb, ma, mb, ta, tb, nuu, nuv, nvv;
    lanes linear_m, bend_m, bend_t; /* along m: first order, second order; along t: second */
    lanes reach_n, reach_m, reach_t, reach_r;
} frame;

/* A vector away from the tool's axis, along its ring and along its axis. */
typedef struct local {
    lanes r, t, z;
} local;

static ALWAYS_INLINE local local_of(const lanes3_memory *v, int i, const place *p, btg_vec3 axis) {
    lanes3 x = lanes3_load(v, i);
    return (local){lanes3_dot(p->radial, x), lanes3_dot(p->ring, x), btg_block_dot(x, axis)};
}

static ALWAYS_INLINE lanes along_n(const place *p, const local *x) {
    return lanes_mad(lanes_mul(p->n_r, x->r), p->n_z, x->z);
}

static ALWAYS_INLINE lanes along_m(const place *p, const local *x) {
    return lanes_sub(lanes_mul(p->n_r, x->z), lanes_mul(p->n_z, x->r));
}

/* How far a tangential part of the second derivatives leads. */
static ALWAYS_INLINE lanes bend_along(lanes uu, lanes uv, lanes vv, lanes error) {
    lanes sum = lanes_add(lanes_abs(uu), lanes_abs(vv));
    return lanes_add(lanes_mad(lanes_abs(uv), lanes_all(0.5), sum), error);
}

static ALWAYS_INLINE frame frame_of(const btg_block *block, int i, const btg_placement *at,
                                    const place *p) {
    local a = local_of(&block->at.su, i, p, at->axis), b = local_of(&block->at.sv, i, p, at->axis);
    local uu = local_of(&block->at.suu, i, p, at->axis);
    local uv = local_of(&block->at.suv, i, p, at->axis);
    local vv = local_of(&block->at.svv, i, p, at->axis);
    lanes bend = lanes_load(block->bend + i), error = lanes_load(block->error + i);
    frame f = {.na = along_n(p, &a), .nb = along_n(p, &b), .ma = along_m(p, &a)};
    f.mb = along_m(p, &b);
    f.ta = a.t;
    f.tb = b.t;
    f.nuu = along_n(p, &uu);
    f.nuv = along_n(p, &uv);
    f.nvv = along_n(p, &vv);
    f.linear_m = sum_abs(f.ma, f.mb);
    f.bend_m = bend_along(along_m(p, &uu), along_m(p, &uv), along_m(p, &vv), error);
    f.bend_t = bend_along(uu.t, uv.t, vv.t, error);
    f.reach_n = lanes_add(sum_abs(f.na, f.nb), bend);
    f.reach_m = lanes_add(f.linear_m, f.bend_m);
    f.reach_t = lanes_add(sum_abs(f.ta, f.tb), f.bend_t);
    f.reach_r = lanes_add(sum_abs(a.r, b.r), bend);
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
 * least, m the most of x_m. G is convex: at least c / 2 - c^2 / 2 (x_n - X), c / 2 its value at
 * D + X, X that of the nearest place. The second part counts where x_n > X only, and there by m^2
 * at most: on |x_n| <= n by the chord of that, paid, a part of x_n + n. Its least over all of
 * that, and nothing paid, is another bound: better where the nearest place is near the middle of
 * the meridian, and the only one where G is not convex that far. */
static ALWAYS_INLINE across bend_across(const place *p, lanes far_m, lanes far_n, lanes x_n,
                                        lanes mu) {
    lanes zero = lanes_all(0), half = lanes_all(0.5), quarter = lanes_all(0.25);
    lanes tiny = lanes_all(1e-30), m2 = lanes_mul(far_m, far_m), far = lanes_max(p->far, tiny);
    lanes low = lanes_max(lanes_sub(far, far_n), tiny), here = lanes_max(lanes_add(far, x_n), low);
    lanes all = lanes_mad(lanes_mul(far, lanes_add(far, far_n)), half, m2);
    lanes at = lanes_mad(lanes_mul(here, here), quarter, m2), least, c, chord;
    invert_three(at, all, lanes_max(far_n, tiny), &c, &least, &chord);
    c = lanes_mul(here, c);
    least = lanes_mul(far, least);
    chord = lanes_mul(lanes_sub(far_n, x_n), chord); /* twice its slope */
    lanes paid = lanes_mul(lanes_mul(quarter, chord), lanes_mul(lanes_mul(c, c), m2));
    lanes loss = lanes_mul(paid, lanes_add(far_n, x_n));
    lanes other = lanes_mul(half, lanes_mul(lanes_sub(c, least), lanes_mul(mu, mu)));
    lanes convex = lanes_sub(low, lanes_mul(lanes_all(0.87), far_m));
    other = lanes_if_less(zero, convex, other, lanes_all(-INFINITY));
    return (across){lanes_if_less(loss, other, c, least), lanes_if_less(loss, other, paid, zero)};
}

/* The form from below; *off comes off its least. */
static ALWAYS_INLINE quadratic lower_form(const btg_tool_element *e, const place *p, const frame *f,
                                          lanes up, lanes error, lanes x_n, lanes mu, lanes *off) {
    lanes zero = lanes_all(0), half = lanes_all(0.5), one = lanes_all(1);
    lanes steep = lanes_abs(p->n_z);
    lanes inner = lanes_sub(p->r, f->reach_r), aside2 = lanes_mul(f->reach_t, f->reach_t);
    lanes outer = lanes_add(p->r, f->reach_r), inner1, outer1;
    outer = lanes_mad(outer, aside2, lanes_mul(half, p->inverse_r));
    lanes safe = lanes_max(inner, lanes_mul(p->r, lanes_all(0.05)));
    invert_two(safe, outer, &inner1, &outer1);
    lanes turn = lanes_mul(half, lanes_mul(aside2, inner1));

    lanes far_m = lanes_mad(f->reach_m, steep, turn);
    lanes far_n = lanes_mad(f->reach_n, lanes_abs(p->n_r), turn);
    x_n = lanes_max(lanes_sub(zero, far_n), lanes_min(far_n, x_n));
    across x = bend_across(p, far_m, far_n, x_n, mu);
    lanes c = x.c;
    c = lanes_if_less(zero, lanes_add(p->height, up), zero, c);
    c = lanes_if_less(inner, safe, zero, c);
    if (!e->hollow) c = lanes_if_less(inner, lanes_all(e->ring_radius_mm), zero, c);

    lanes paid = lanes_if_less(zero, c, x.paid, zero), weight = lanes_sub(one, paid);
    lanes slope = lanes_mad(lanes_mul(p->n_r, weight), lanes_mul(c, steep), mu); /* in tau */
    lanes k = lanes_if_less(slope, zero, lanes_mul(slope, inner1), lanes_mul(slope, outer1));
    lanes spent = lanes_mul(lanes_mul(c, steep), lanes_mul(steep, lanes_mul(turn, inner1)));
    k = lanes_sub(k, lanes_mul(lanes_all(0.5 * (1 / SHARE - 1)), spent));

    /* - SHARE c (m.x - mu)^2 / 2 */
    lanes left = lanes_mul(c, lanes_all(1 - SHARE));
    quadratic q = form_of(f, left, k, weight);
    lanes pull = lanes_mul(lanes_mul(lanes_all(SHARE), c), mu);
    q.a = lanes_mad(q.a, pull, f->ma);
    q.b = lanes_mad(q.b, pull, f->mb);
    lanes constant = lanes_mad(lanes_mul(half, lanes_mul(pull, mu)), paid, far_n);
    lanes m_off = lanes_mad(lanes_abs(pull), left, f->linear_m);
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

/* ---- stages ------------------------------------------------------------------------------- */

/* What one stage leaves to the next, of as many pieces as there are lanes. Each stage is done with
 * all of the block before the next begins: what it computes of one lot does not wait for the lot
 * before, and little of it has to be kept in registers. */
typedef struct stage {
    place p;
    lanes up;
    frame f;
    quadratic about, form; /* the distance about the centre; from below */
    lanes mu, x_n, off;
} stage;

_Static_assert(sizeof(stage) * (BTG_BLOCK / BTG_LANES) <= sizeof(btg_block_room),
               "the stages need more room");

static ALWAYS_INLINE stage *stage_of(btg_block_bound *bound, uint32_t i) {
    return (stage *)(void *)&bound->room + i / BTG_LANES;
}

/* Where the centres are, and what the balls say. Bits: the first of each lot that has a ball nearer
 * than enough. */
static BTG_APART unsigned place_centres(const btg_block *block, const btg_tool_element *e,
                                        const btg_placement *at, double enough,
                                        btg_block_bound *bound) {
    unsigned near = 0;
    for (uint32_t i = 0; i < block->count; i += BTG_LANES) {
        stage *s = stage_of(bound, i);
        s->p = place_of(lanes3_load(&block->at.s, (int)i), e, at);
        lanes distance = lanes_sub(s->p.far, lanes_all(e->corner_radius_mm));
        lanes radius = lanes_load(block->radius + i), ball = lanes_sub(distance, radius);
        s->up = reach_up(block, (int)i, at->axis);
        lanes top = lanes_add(s->p.height, lanes_min(radius, s->up)), zero = lanes_all(0);
        lanes_store(bound->distance + i, distance);
        lanes_store(bound->height + i, s->p.height);
        lanes_store(bound->top + i, top);
        lanes_store(bound->low + i, ball);
        lanes_store(bound->form + i, ball);
        lanes_store(bound->least + i, distance);
        lanes_store(bound->s + i, zero);
        lanes_store(bound->t + i, zero);
        bound->high |= lanes_less(zero, top) << i;
        near |= (unsigned)(lanes_less(ball, lanes_all(enough)) != 0) << i;
    }
    return near;
}

/* The pieces in the frames of their centres: apart where registers are few. */
#define FRAMES_APART (BTG_LANES == 4)

static BTG_APART void set_frames(const btg_block *block, unsigned lots, const btg_placement *at,
                                 btg_block_bound *bound) {
    for (; lots; lots &= lots - 1) {
        int i = btg_lowest_bit(lots);
        stage *s = stage_of(bound, (uint32_t)i);
        s->f = frame_of(block, i, at, &s->p);
    }
}

/* The distance about the centres, and near which places it is least. */
static ALWAYS_INLINE void expand(const btg_block *block, unsigned lots, bool triangles,
                                 const btg_placement *at, btg_block_bound *bound) {
    for (; lots; lots &= lots - 1) {
        int i = btg_lowest_bit(lots);
        stage *st = stage_of(bound, (uint32_t)i);
        const place *p = &st->p;
        frame f = FRAMES_APART ? st->f : frame_of(block, i, at, p);
        lanes zero = lanes_all(0), bend = lanes_if_less(p->height, zero, p->inverse_far, zero);
        quadratic about = form_of(&f, bend, lanes_mul(p->n_r, p->inverse_r), lanes_all(1));
        lanes s, t;
        near_least(&about, &s, &t);
        if (triangles) into_triangle(&about, &s, &t);
        st->mu = lanes_mad(lanes_mul(f.ma, s), f.mb, t);
        st->x_n = lanes_mad(lanes_mul(f.na, s), f.nb, t);
        if (!FRAMES_APART) st->f = f;
        st->about = about;
    }
}

static BTG_APART void expand_sheets(const btg_block *block, unsigned lots, const btg_placement *at,
                                    btg_block_bound *bound) {
    expand(block, lots, false, at, bound);
}

static BTG_APART void expand_triangles(const btg_block *block, unsigned lots,
                                       const btg_placement *at, btg_block_bound *bound) {
    expand(block, lots, true, at, bound);
}

static BTG_APART void bound_from_below(const btg_block *block, const btg_tool_element *e,
                                       unsigned lots, btg_block_bound *bound) {
    for (; lots; lots &= lots - 1) {
        int i = btg_lowest_bit(lots);
        stage *s = stage_of(bound, (uint32_t)i);
        lanes error = lanes_load(block->error + i);
        s->form = lower_form(e, &s->p, &s->f, s->up, error, s->x_n, s->mu, &s->off);
    }
}

static ALWAYS_INLINE void take_least(const btg_block *block, const btg_tool_element *e,
                                     unsigned lots, bool triangles, double enough,
                                     btg_block_bound *bound) {
    lanes limit = lanes_all(enough);
    for (; lots; lots &= lots - 1) {
        int i = btg_lowest_bit(lots);
        const stage *s = stage_of(bound, (uint32_t)i);
        minimum least = triangles ? least_in_triangle(&s->form) : least_in_square(&s->form);
        lanes distance = lanes_load(bound->distance + i), ball = lanes_load(bound->low + i);
        lanes form = lanes_add(distance, lanes_sub(least.value, s->off));
        lanes extent = bound_by_extent(&s->p, e, lanes_load(block->radius + i), s->up);
        lanes low = lanes_max(lanes_max(form, extent), ball);
        lanes_store(bound->form + i, form);
        lanes_store(bound->low + i, low);
        lanes_store(bound->least + i, lanes_add(distance, value_at(&s->about, least.s, least.t)));
        lanes_store(bound->s + i, least.s);
        lanes_store(bound->t + i, least.t);
        bound->deep |= lanes_less(low, limit) << i;
        if (triangles) continue;
        lanes without = lanes_add(form, lanes_load(block->error + i));
        bound->tail |= (lanes_less(form, limit) & ~lanes_less(without, limit)) << i;
    }
}

static BTG_APART void take_least_of_sheets(const btg_block *block, const btg_tool_element *e,
                                           unsigned lots, double enough, btg_block_bound *bound) {
    take_least(block, e, lots, false, enough, bound);
}

static BTG_APART void take_least_of_triangles(const btg_block *block, const btg_tool_element *e,
                                              unsigned lots, double enough,
                                              btg_block_bound *bound) {
    take_least(block, e, lots, true, enough, bound);
}

/* Steps to a corner of a triangle: along n, the ring and the radius. */
typedef struct corner {
    lanes n, t, r;
} corner;

static ALWAYS_INLINE corner corner_of(const place *p, const local *a, const local *b, lanes s,
                                      lanes t) {
    local x = {lanes_mad(lanes_mul(a->r, s), b->r, t), lanes_mad(lanes_mul(a->t, s), b->t, t),
               lanes_mad(lanes_mul(a->z, s), b->z, t)};
    return (corner){along_n(p, &x), x.t, x.r};
}

static ALWAYS_INLINE lanes at_corner(const corner *c, lanes k) {
    return lanes_mad(c->n, lanes_mul(k, c->t), c->t);
}

/* Triangles once more, from the place where they come nearest: a plane that touches the distance
 * there bounds it, but for the ring's bend where that is hollow: n_r tau (see above). Both are
 * concave, so the least is at a corner. */
static ALWAYS_INLINE void corners_from(const btg_block *block, int i, const btg_tool_element *e,
                                       const btg_placement *at, double enough,
                                       btg_block_bound *bound) {
    lanes s = lanes_load(bound->s + i), t = lanes_load(bound->t + i), zero = lanes_all(0);
    lanes one = lanes_all(1), minus = lanes_all(-1);
    lanes3 c = lanes3_load(&block->at.s, i), u = lanes3_load(&block->at.su, i);
    lanes3 v = lanes3_load(&block->at.sv, i);
    c = (lanes3){lanes_mad(lanes_mad(c.x, u.x, s), v.x, t),
                 lanes_mad(lanes_mad(c.y, u.y, s), v.y, t),
                 lanes_mad(lanes_mad(c.z, u.z, s), v.z, t)};
    place p = place_of(c, e, at);
    local a = local_of(&block->at.su, i, &p, at->axis),
          b = local_of(&block->at.sv, i, &p, at->axis);
    lanes back_s = lanes_sub(minus, s), back_t = lanes_sub(minus, t);
    corner c0 = corner_of(&p, &a, &b, back_s, back_t);
    corner c1 = corner_of(&p, &a, &b, lanes_sub(one, s), back_t);
    corner c2 = corner_of(&p, &a, &b, back_s, lanes_sub(one, t));
    lanes inner = lanes_add(p.r, lanes_min(c0.r, lanes_min(c1.r, c2.r)));
    lanes safe = lanes_max(inner, lanes_mul(p.r, lanes_all(0.05)));
    lanes k = lanes_div(lanes_mul(lanes_all(0.5), lanes_min(p.n_r, zero)), safe);
    lanes least = lanes_min(at_corner(&c0, k), lanes_min(at_corner(&c1, k), at_corner(&c2, k)));
    lanes low = lanes_add(lanes_sub(p.far, lanes_all(e->corner_radius_mm)), least);
    low = lanes_sub(low, lanes_load(block->error + i));
    low = lanes_if_less(inner, safe, lanes_all(-INFINITY), low);
    low = lanes_max(low, lanes_load(bound->low + i));
    lanes_store(bound->low + i, low);
    unsigned all = (1u << BTG_LANES) - 1;
    bound->deep = (bound->deep & ~(all << i)) | lanes_less(low, lanes_all(enough)) << i;
}

static BTG_APART void look_at_corners(const btg_block *block, const btg_tool_element *e,
                                      const btg_placement *at, unsigned lots, double enough,
                                      btg_block_bound *bound) {
    for (; lots; lots &= lots - 1) {
        int i = btg_lowest_bit(lots);
        if (bound->deep >> i) corners_from(block, i, e, at, enough, bound);
    }
}

void btg_block_bounds(const btg_block *block, const btg_tool_element *e, const btg_placement *at,
                      double enough, btg_block_bound *bound) {
    bound->deep = bound->high = bound->tail = 0;
    unsigned lots = place_centres(block, e, at, enough, bound);
    if (FRAMES_APART) set_frames(block, lots, at, bound);
    if (block->triangles)
        expand_triangles(block, lots, at, bound);
    else
        expand_sheets(block, lots, at, bound);
    bound_from_below(block, e, lots, bound);
    if (block->triangles) {
        take_least_of_triangles(block, e, lots, enough, bound);
        look_at_corners(block, e, at, lots, enough, bound);
    } else {
        take_least_of_sheets(block, e, lots, enough, bound);
    }
    bound->deep &= btg_block_bits(block);
    bound->high &= btg_block_bits(block);
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
