/* A proof all along the tool's ring.
 *
 * A tilted tool that touches twice lies along the part with all of its ring: between the contacts
 * it is clear by hundredths of a millimetre, in a valley as long as the ring, which bends with it.
 * Pieces of the part see little of such a valley at a time. Here wedges about the tool's axis are
 * looked at instead, each from one foot, a point of the part under the ring, with all of the
 * wedge's width at once. What lies in wedges that are proven clear need not be cut any more.
 *
 * In radius r and height z the tool is a circle, wherever it is met: D^2 = (r - Ro)^2 + z^2. At a
 * foot (r0, z0) let D0 be the distance from the circle, n its gradient; t and x steps along the
 * ring and along the radius there; y = r - r0, psi the angle from the foot, tau = r (1 - cos psi),
 * so that x = y - tau and t = r sin psi. Then
 *
 *     V = (D^2 - D0^2) / (2 D0) >= n_r y + n_z (z - z0) + y^2 / (2 D0),
 *
 * where only a square has been dropped. The part is a sheet z(t, x) over the ring's plane, with
 * slopes s_t and s_x and second derivatives h, known up to a bound of third order (below):
 *
 *     V >= g_t t + g_y y + c tau + 1/2 (k_tt t^2 + 2 k_tx t x + k_xx x^2) + y^2 / (2 D0) - error,
 *     g_t = n_z s_t,  g_y = n_r + n_z s_x,  c = n_r - g_y,  k = n_z h.
 *
 * With t0 = r0 sin psi and tau0 = r0 (1 - cos psi), t and tau are (1 + y / r0) t0 and
 * (1 + y / r0) tau0. So V is a polynomial in y whose coefficients depend on t0 alone; over all y it
 * is at least its constant part less the square of the linear one, over twice the curvature.
 *
 * That is of points whose parameters are next to the foot's. Others there are none: within the box
 * of parameters that the ring is about, points differ in the ring's plane by at least so much for
 * every mm of parameters. */
#include "core/search.h"

/* Wedges of both arcs between two contacts; of one of them at the least. */
#define WEDGES    24
#define ARC_LEAST 8
/* How far from the ring, part of its radius and of its distance to the part. */
#define WIDE 0.95
/* A contact's own wedge at the most; its half where it is not proven: sines. */
#define CONTACT_MOST 0.1
#define CONTACT_OPEN 0.02
/* Of the angle between P and its foot at the most; wedges reach further than that. */
#define P_SINE 1e-9
/* Sine of any wedge's half at the most. */
#define SINE_MOST 0.5
/* A wedge's foot may be that far from the middle of all, part of the width. */
#define AWAY_MOST 0.4
/* (a + b)^2 is at most s a^2 + s / (s - 1) b^2: that s at the least. */
#define SPLIT_LEAST 1.001
/* Part of the clearance that is spent. */
#define RING_SHARE 0.5
/* Shorter ways from P, in radii, tell less of the turn that clears them. */
#define START_WAY 0.3
/* Parameters about the ring, part of its size by the slopes at P. */
#define BOX_MORE 1.15
/* The sheet's slopes in the ring's plane, part of their speeds, at the least. */
#define SLOPE_LEAST 0.1

/* What stands side by side of all feet; first their points and derivatives (btg_surface_block),
 * turned in place to steps along t, x and z. */
enum ring_row {
    S,
    SU = 3,
    SV = 6,
    SUU = 9,
    SUV = 12,
    SVV = 15,
    U = 18, /* parameters */
    V,
    COSINE, /* direction from the axis, P's is (1, 0) */
    SINE,
    RADIUS, /* r0 */
    HEIGHT, /* z0 */
    FAR,    /* D0 */
    G_T,
    G_Y,
    C,
    K_TT,
    K_TX,
    K_XX,
    SLOPE, /* least |step in the ring's plane| of a step of 1 mm in parameters at the foot */
    HESSE, /* second derivatives off the tangent plane, per mm of parameters: largest */
    BEND,  /* second derivatives */
    THIRD, /* third derivatives, anywhere */
    LEAN,  /* 1 / cosine of the sheet's slope */
    SPEED_U,
    SPEED_V,
    SINE_OF, /* of contacts: of their wedges' halves */
    LOW_C,   /* directions of a wedge's sides */
    LOW_S,
    HIGH_C,
    HIGH_S,
    ROWS,
    /* until the next ones need the room: parameters of steps along t and x, slopes along them */
    U_T = S,
    V_T,
    U_X,
    V_X = K_XX,
    S_T = K_TT,
    S_X = K_TX,
    /* at last: of a wedge's half angle, and what bounds V there */
    HALF = S,
    ERROR,
    NEAR, /* all that is near in the ring's plane is near in parameters, if that is large enough */
    CURVE,
    OFF,
    SLOPE_T,
    BEND_T,
    CUBIC,
    FOURTH
};

/* The bounds' own room, between two uses. */
typedef union ring_room {
    btg_surface_block at;
    double row[ROWS][BTG_BLOCK];
} ring_room;

_Static_assert(sizeof(ring_room) <= sizeof(btg_block_room), "the ring needs more room");
_Static_assert(sizeof(btg_surface_block) == U * BTG_BLOCK * sizeof(double), "rows of derivatives");
_Static_assert(WEDGES <= BTG_BLOCK && WEDGES % 8 == 0, "wedges stand side by side");

static ALWAYS_INLINE ring_room *room_of(btg_search *search) {
    return (ring_room *)(void *)&search->bounds.room;
}

static ALWAYS_INLINE lanes get(const ring_room *room, int row, uint32_t i) {
    return lanes_load(room->row[row] + i);
}

static ALWAYS_INLINE void set(ring_room *room, int row, uint32_t i, lanes a) {
    lanes_store(room->row[row] + i, a);
}

/* ---- feet --------------------------------------------------------------------------------- */

static ALWAYS_INLINE lanes3 get3(const ring_room *room, int row, uint32_t i) {
    return (lanes3){get(room, row, i), get(room, row + 1, i), get(room, row + 2, i)};
}

/* Where feet are to the ring. */
static BTG_APART void place_feet(ring_room *room, uint32_t feet, const btg_ring *ring,
                                 const btg_placement *at, double ro) {
    for (uint32_t i = 0; i < feet; i += BTG_LANES) {
        lanes3 s = get3(room, S, i);
        s = (lanes3){lanes_sub(s.x, lanes_all(at->centre.x)),
                     lanes_sub(s.y, lanes_all(at->centre.y)),
                     lanes_sub(s.z, lanes_all(at->centre.z))};
        lanes x = btg_block_dot(s, ring->x), y = btg_block_dot(s, ring->y),
              z = btg_block_dot(s, at->axis);
        lanes r = lanes_sqrt(lanes_mad(lanes_mul(x, x), y, y)), out = lanes_sub(r, lanes_all(ro));
        lanes by_r = lanes_div(lanes_all(1), r);
        set(room, COSINE, i, lanes_mul(x, by_r));
        set(room, SINE, i, lanes_mul(y, by_r));
        set(room, RADIUS, i, r);
        set(room, HEIGHT, i, z);
        set(room, FAR, i, lanes_sqrt(lanes_mad(lanes_mul(z, z), out, out)));
    }
}

/* Vectors of the part along the foot's ring, radius and axis: those of rows up to `end`. */
static BTG_APART void turn_rows(ring_room *room, uint32_t feet, const btg_ring *ring, btg_vec3 axis,
                                int end) {
    for (uint32_t i = 0; i < feet; i += BTG_LANES) {
        lanes c = get(room, COSINE, i), s = get(room, SINE, i);
        for (int row = SU; row < end; row += 3) {
            lanes3 a = get3(room, row, i);
            lanes p = btg_block_dot(a, ring->x), q = btg_block_dot(a, ring->y);
            set(room, row, i, lanes_sub(lanes_mul(q, c), lanes_mul(p, s)));
            set(room, row + 1, i, lanes_mad(lanes_mul(p, c), q, s));
            set(room, row + 2, i, btg_block_dot(a, axis));
        }
    }
}

/* The part's sheet at feet as a height over the ring's plane, and V's gradient. */
static BTG_APART void set_slopes(ring_room *room, uint32_t feet, double ro) {
    for (uint32_t i = 0; i < feet; i += BTG_LANES) {
        lanes3 u = get3(room, SU, i), v = get3(room, SV, i); /* t, x, z each */
        lanes one = lanes_all(1), zero = lanes_all(0);
        lanes over = lanes_div(one, lanes_sub(lanes_mul(u.x, v.y), lanes_mul(v.x, u.y)));
        lanes ut = lanes_mul(v.y, over), vt = lanes_sub(zero, lanes_mul(u.y, over));
        lanes ux = lanes_sub(zero, lanes_mul(v.x, over)), vx = lanes_mul(u.x, over);
        lanes st = lanes_mad(lanes_mul(u.z, ut), v.z, vt);
        lanes sx = lanes_mad(lanes_mul(u.z, ux), v.z, vx);
        set(room, U_T, i, ut);
        set(room, V_T, i, vt);
        set(room, U_X, i, ux);
        set(room, V_X, i, vx);
        set(room, S_T, i, st);
        set(room, S_X, i, sx);
        set(room, LEAN, i, lanes_sqrt(lanes_mad(lanes_mad(one, st, st), sx, sx)));
        lanes by_far = lanes_div(one, get(room, FAR, i));
        lanes nr = lanes_mul(lanes_sub(get(room, RADIUS, i), lanes_all(ro)), by_far);
        lanes nz = lanes_mul(get(room, HEIGHT, i), by_far), gy = lanes_mad(nr, nz, sx);
        set(room, G_T, i, lanes_mul(nz, st));
        set(room, G_Y, i, gy);
        set(room, C, i, lanes_sub(nr, gy));
    }
}

static ALWAYS_INLINE lanes length(const ring_room *room, int row, uint32_t i) {
    return lanes_sqrt(lanes3_norm2(get3(room, row, i)));
}

/* Speeds, and the smaller singular value of the slopes in the ring's plane by them. */
static BTG_APART void set_speeds(ring_room *room, uint32_t feet) {
    for (uint32_t i = 0; i < feet; i += BTG_LANES) {
        lanes half = lanes_all(0.5), speed_u = length(room, SU, i), speed_v = length(room, SV, i);
        set(room, SPEED_U, i, speed_u);
        set(room, SPEED_V, i, speed_v);
        lanes over = lanes_div(lanes_all(1), lanes_mul(speed_u, speed_v));
        lanes iu = lanes_mul(over, speed_v), iv = lanes_mul(over, speed_u);
        lanes ut = lanes_mul(get(room, SU, i), iu), ux = lanes_mul(get(room, SU + 1, i), iu);
        lanes vt = lanes_mul(get(room, SV, i), iv), vx = lanes_mul(get(room, SV + 1, i), iv);
        lanes aa = lanes_mad(lanes_mul(ut, ut), ux, ux), bb = lanes_mad(lanes_mul(vt, vt), vx, vx);
        lanes ab = lanes_mad(lanes_mul(ut, vt), ux, vx);
        lanes apart = lanes_mul(half, lanes_sub(aa, bb));
        lanes spread = lanes_sqrt(lanes_mad(lanes_mul(apart, apart), ab, ab));
        lanes least = lanes_sub(lanes_mul(half, lanes_add(aa, bb)), spread);
        set(room, SLOPE, i, lanes_sqrt(lanes_max(least, lanes_all(0))));
    }
}

/* A quadratic form along two directions of parameters. */
static ALWAYS_INLINE lanes second(lanes3 h, lanes au, lanes av, lanes bu, lanes bv) {
    lanes u = lanes_mad(lanes_mul(h.x, bu), h.y, bv), v = lanes_mad(lanes_mul(h.y, bu), h.z, bv);
    return lanes_mad(lanes_mul(u, au), v, av);
}

/* At least the largest uu a^2 + 2 uv a b + vv b^2 with a^2 + b^2 = 1, per mm of parameters. */
static ALWAYS_INLINE lanes largest(const ring_room *room, uint32_t i, lanes3 h) {
    lanes su = get(room, SPEED_U, i), sv = get(room, SPEED_V, i);
    lanes uu = lanes_div(lanes_abs(h.x), lanes_mul(su, su));
    lanes vv = lanes_div(lanes_abs(h.z), lanes_mul(sv, sv));
    return lanes_add(lanes_max(uu, vv), lanes_div(lanes_abs(h.y), lanes_mul(su, sv)));
}

/* Off the tangent plane: along z - s_t t - s_x x. */
static ALWAYS_INLINE lanes off_plane(const ring_room *room, int row, uint32_t i) {
    lanes3 a = get3(room, row, i);
    lanes below = lanes_mad(lanes_mul(get(room, S_T, i), a.x), get(room, S_X, i), a.y);
    return lanes_sub(a.z, below);
}

/* V's second derivatives. */
static BTG_APART void set_hessians(ring_room *room, uint32_t feet) {
    for (uint32_t i = 0; i < feet; i += BTG_LANES) {
        lanes3 h = {off_plane(room, SUU, i), off_plane(room, SUV, i), off_plane(room, SVV, i)};
        lanes3 bend = {length(room, SUU, i), length(room, SUV, i), length(room, SVV, i)};
        set(room, HESSE, i, largest(room, i, h));
        set(room, BEND, i, largest(room, i, bend));
        lanes nz = lanes_div(get(room, HEIGHT, i), get(room, FAR, i));
        lanes ut = get(room, U_T, i), vt = get(room, V_T, i), ux = get(room, U_X, i);
        lanes vx = get(room, V_X, i);
        set(room, K_TT, i, lanes_mul(nz, second(h, ut, vt, ut, vt)));
        set(room, K_TX, i, lanes_mul(nz, second(h, ut, vt, ux, vx)));
        set(room, K_XX, i, lanes_mul(nz, second(h, ux, vx, ux, vx)));
    }
}

/* Third derivatives per mm of parameters; a^2 b is at most 0.385 on the unit circle, and comes
 * three times. */
static BTG_APART void set_thirds(ring_room *room, uint32_t feet, const double third[4]) {
    for (uint32_t i = 0; i < feet; i += BTG_LANES) {
        lanes one = lanes_all(1), iu = lanes_div(one, get(room, SPEED_U, i));
        lanes iv = lanes_div(one, get(room, SPEED_V, i));
        lanes u = lanes_mad(lanes_mul(lanes_all(third[0]), iu), lanes_all(1.16 * third[1]), iv);
        lanes v = lanes_mad(lanes_mul(lanes_all(third[3]), iv), lanes_all(1.16 * third[2]), iu);
        u = lanes_mul(u, lanes_mul(iu, iu));
        set(room, THIRD, i, lanes_mad(u, v, lanes_mul(iv, iv)));
    }
}

static void evaluate_feet(const btg_part *part, uint32_t item, uint32_t feet, ring_room *room) {
    const btg_patch *patch[BTG_PIECES];
    for (uint32_t four = 0; four < (feet + 3) / 4; four++)
        patch[four] = &part->patches[item];
    btg_patch_evaluate_block(patch, (int)(feet + 3) / 4, room->row[U], room->row[V], &room->at);
}

/* All that has to be known of feet. */
static void expand_feet(btg_search *search, ring_room *room, uint32_t feet) {
    const btg_patch *patch = &search->part->patches[search->p_place.item];
    double ro = search->query.tool->element[0].ring_radius_mm;
    evaluate_feet(search->part, search->p_place.item, feet, room);
    place_feet(room, feet, &search->ring, &search->at, ro);
    turn_rows(room, feet, &search->ring, search->at.axis, U);
    set_slopes(room, feet, ro);
    set_speeds(room, feet);
    set_hessians(room, feet);
    set_thirds(room, feet, patch->third);
}

/* ---- the bound ---------------------------------------------------------------------------- */

/* Within a wedge of half angle's sine HALF, `wide` to both sides of its foot, V is at least
 *
 *     -OFF + SLOPE_T t0 + BEND_T t0^2 / 2 - CUBIC |t0|^3 - FOURTH t0^4,
 *
 * where NEAR and CURVE are large enough. */

/* The ERROR of third order per cube of the way in the ring's plane: of the sheet's height over its
 * tangent plane, and of its Hessian's argument, as parameters are not quite linear in t and x. */
static BTG_APART void set_errors(ring_room *room, uint32_t feet, const btg_ring *ring,
                                 double wide) {
    for (uint32_t i = 0; i < feet; i += BTG_LANES) {
        lanes one = lanes_all(1), half = lanes_all(0.5), least = lanes_all(SLOPE_LEAST);
        /* the longest way */
        lanes sine = get(room, HALF, i), cosine = lanes_mul(sine, sine);
        cosine = lanes_sqrt(lanes_max(lanes_sub(one, cosine), lanes_all(0)));
        lanes fs = lanes_div(sine, lanes_add(one, cosine)), w = lanes_all(wide);
        lanes t = lanes_mul(lanes_add(get(room, RADIUS, i), w), sine), x = lanes_mad(w, fs, t);
        lanes way = lanes_sqrt(lanes_mad(lanes_mul(t, t), x, x));
        lanes bend = get(room, BEND, i), third = get(room, THIRD, i), own = get(room, SLOPE, i);
        lanes sixth = lanes_mul(third, lanes_all(1.0 / 6));
        lanes wu = lanes_mul(lanes_all(2 * ring->half_u), get(room, SPEED_U, i));
        lanes wv = lanes_mul(lanes_all(2 * ring->half_v), get(room, SPEED_V, i));
        lanes span = lanes_sqrt(lanes_mad(lanes_mul(wu, wu), wv, wv));
        /* first wherever in the box, then as near as that tells */
        lanes all = lanes_mad(lanes_mul(half, bend), sixth, span);
        lanes first = lanes_sub(own, lanes_mul(all, span));
        lanes near = lanes_min(span, lanes_div(way, lanes_max(first, least)));
        set(room, NEAR, i, first);
        all = lanes_mad(lanes_mul(half, bend), sixth, near);
        lanes over = lanes_div(one, lanes_max(lanes_sub(own, lanes_mul(all, near)), least));
        bend = lanes_mad(bend, lanes_mul(third, lanes_all(1.0 / 3)), near);
        lanes askew = lanes_mul(lanes_mul(half, get(room, HESSE, i)), lanes_mul(bend, over));
        lanes over3 = lanes_mul(over, lanes_mul(over, over));
        set(room, ERROR, i, lanes_mul(over3, lanes_mad(askew, get(room, LEAN, i), sixth)));
    }
}

/* V's curvature across, and the cubic part along. By
 *     (t^2 + x^2)^(3/2) <= 5^(1/2) / 2 |t|^3 + 5^(1/2) |x|^3,
 * |t| <= |t0| + sine |y| and |x| <= (1 + f sine^2) |y| + f sine |t0|, tau0 being f t0^2 / r0, and
 * cubes of sums split the same way. */
static BTG_APART void set_curves(ring_room *room, uint32_t feet, double wide) {
    for (uint32_t i = 0; i < feet; i += BTG_LANES) {
        lanes one = lanes_all(1), zero = lanes_all(0), two = lanes_all(2), half = lanes_all(0.5);
        lanes sine = get(room, HALF, i), cosine = lanes_mul(sine, sine);
        cosine = lanes_sqrt(lanes_max(lanes_sub(one, cosine), zero));
        lanes f = lanes_div(one, lanes_add(one, cosine)), fs = lanes_mul(f, sine);
        lanes s2 = lanes_add(two, sine), fs3 = lanes_mul(fs, lanes_mul(fs, fs));
        s2 = lanes_mul(s2, s2);
        lanes of_t = lanes_mad(lanes_mul(s2, lanes_all(1.1181 / 4)), fs3, lanes_all(2.2361 * 9));
        lanes more = lanes_mad(one, fs, sine);
        lanes of_y = lanes_mul(s2, lanes_mul(sine, lanes_all(1.1181)));
        of_y = lanes_mad(of_y, lanes_mul(more, more), lanes_mul(more, lanes_all(2.2361 * 2.25)));
        lanes error = get(room, ERROR, i), atx = lanes_abs(get(room, K_TX, i));
        lanes hollow = lanes_max(lanes_sub(zero, get(room, K_XX, i)), zero);
        lanes lost = lanes_mad(lanes_mul(lanes_mul(two, atx), sine), lanes_abs(get(room, K_TT, i)),
                               lanes_mul(sine, sine));
        lost = lanes_mad(lost, lanes_mul(two, error), lanes_mul(of_y, lanes_all(wide)));
        lanes curve = lanes_div(one, get(room, FAR, i));
        set(room, CURVE, i, lanes_sub(lanes_sub(curve, hollow), lost));
        lanes by_r = lanes_div(one, get(room, RADIUS, i));
        lanes cubic = lanes_mad(lanes_mul(lanes_mul(atx, f), by_r), error, of_t);
        cubic = lanes_mad(cubic, lanes_mul(half, hollow), lanes_mul(lanes_mul(f, fs), by_r));
        set(room, CUBIC, i, cubic);
    }
}

/* The rest along: of the square (g_y + line t0 + square t0^2)^2 / (2 curve) the last by itself. */
static BTG_APART void set_parabolas(ring_room *room, uint32_t feet) {
    for (uint32_t i = 0; i < feet; i += BTG_LANES) {
        lanes one = lanes_all(1), zero = lanes_all(0), two = lanes_all(2), half = lanes_all(0.5);
        lanes sine = get(room, HALF, i), cosine = lanes_mul(sine, sine), tiny = lanes_all(1e-30);
        cosine = lanes_sqrt(lanes_max(lanes_sub(one, cosine), zero));
        lanes f = lanes_div(one, lanes_add(one, cosine)), r = get(room, RADIUS, i);
        lanes by_r = lanes_div(one, r), tx = get(room, K_TX, i), c = get(room, C, i);
        lanes line = lanes_mad(tx, get(room, G_T, i), by_r), gy = get(room, G_Y, i);
        lanes square = lanes_mul(lanes_abs(c), by_r);
        square = lanes_add(square, lanes_abs(get(room, K_XX, i)));
        square = lanes_mul(f, lanes_mad(square, lanes_mul(two, lanes_abs(tx)), sine));
        square = lanes_mul(by_r, lanes_add(lanes_abs(get(room, K_TT, i)), square));
        /* the best way to split it at the wedge's side */
        lanes t0 = lanes_mul(sine, r), last = lanes_mul(square, lanes_mul(t0, t0));
        lanes rest = lanes_mad(lanes_abs(gy), lanes_abs(line), t0), both = lanes_add(rest, last);
        lanes share = lanes_min(lanes_div(both, lanes_max(rest, tiny)), two);
        share = lanes_max(share, lanes_all(SPLIT_LEAST));
        lanes most = lanes_div(share, lanes_max(get(room, CURVE, i), tiny));
        lanes pull = lanes_mul(most, gy);
        set(room, OFF, i, lanes_mul(lanes_mul(half, pull), gy));
        set(room, SLOPE_T, i, lanes_sub(get(room, G_T, i), lanes_mul(pull, line)));
        lanes fourth = lanes_div(lanes_mul(half, most), lanes_sub(share, one));
        set(room, FOURTH, i, lanes_mul(fourth, lanes_mul(square, square)));
        lanes down = lanes_if_less(c, zero, lanes_mul(two, f), one);
        lanes k = lanes_mad(get(room, K_TT, i), lanes_mul(c, by_r), down);
        set(room, BEND_T, i, lanes_sub(k, lanes_mul(most, lanes_mul(line, line))));
    }
}

static void bound_wedges(ring_room *room, uint32_t feet, const btg_ring *ring, double wide) {
    set_errors(room, feet, ring, wide);
    set_curves(room, feet, wide);
    set_parabolas(room, feet);
}

/* Bits: the bound holds; of the whole box, so that the foot must be in it. */
static ALWAYS_INLINE unsigned holds(const ring_room *room, uint32_t i, const btg_ring *ring) {
    lanes zero = lanes_all(0);
    lanes u = lanes_abs(lanes_sub(get(room, U, i), lanes_all(ring->u)));
    lanes v = lanes_abs(lanes_sub(get(room, V, i), lanes_all(ring->v)));
    return lanes_less(u, lanes_all(ring->half_u)) & lanes_less(v, lanes_all(ring->half_v)) &
           lanes_less(lanes_all(SLOPE_LEAST), get(room, NEAR, i)) &
           lanes_less(zero, get(room, CURVE, i)) &
           lanes_less(get(room, HALF, i), lanes_all(SINE_MOST)) &
           lanes_less(get(room, HEIGHT, i), zero);
}

/* Bits: with that V the part is no deeper in the tool than it may be. */
static ALWAYS_INLINE unsigned clear_at(const ring_room *room, uint32_t i, lanes v, double corner,
                                       double deep) {
    lanes far = get(room, FAR, i), least = lanes_all(corner - deep);
    lanes gap = lanes_mul(lanes_sub(far, least), lanes_add(far, least));
    gap = lanes_mad(gap, lanes_mul(lanes_all(2), far), v); /* D^2 less the least it may be */
    return lanes_less(lanes_all(0), gap);
}

/* ---- contacts ----------------------------------------------------------------------------- */

/* A contact's wedge is as wide as the curvature along the ring pays for the rest: there V is at
 * least -slope + t0^2 (k - CUBIC |t0| - FOURTH t0^2), k half of BEND_T. Its half's sine. */
static BTG_APART void prove_contacts(ring_room *room, const btg_ring *ring, double wide,
                                     double corner, double deep) {
    const uint32_t i = 0;
    lanes most = lanes_all(CONTACT_MOST), r = get(room, RADIUS, i), two = lanes_all(2);
    set(room, HALF, i, most);
    bound_wedges(room, 4, ring, wide);
    lanes k = lanes_mul(lanes_all(0.5), get(room, BEND_T, i)), cubic = get(room, CUBIC, i);
    lanes root = lanes_mul(lanes_mul(lanes_all(4), k), get(room, FOURTH, i));
    root = lanes_sqrt(lanes_max(lanes_mad(root, cubic, cubic), lanes_all(0)));
    lanes t = lanes_div(lanes_mul(two, k), lanes_add(cubic, root));
    t = lanes_min(lanes_mul(most, r), t);
    lanes slope = lanes_mad(get(room, OFF, i), lanes_abs(get(room, SLOPE_T, i)), t);
    unsigned clear = holds(room, i, ring) & lanes_less(lanes_all(0), k);
    clear &= clear_at(room, i, lanes_sub(lanes_all(0), slope), corner, deep);
    set(room, SINE_OF, i, lanes_div(t, r));
    for (unsigned c = 0; c < 2; c++)
        if (!(clear >> c & 1)) room->row[SINE_OF][c] = 0;
}

static void set_contact(const ring_room *room, int k, btg_ring_contact *c) {
    double sine = room->row[SINE_OF][k];
    c->cosine = room->row[COSINE][k];
    c->sine = room->row[SINE][k];
    c->radius = room->row[RADIUS][k];
    c->height = room->row[HEIGHT][k];
    c->proven = sine > CONTACT_OPEN;
    c->half = c->proven ? asin(sine) * (1 - 1e-6) : CONTACT_OPEN;
}

/* ---- wedges ------------------------------------------------------------------------------- */

/* Angles of an arc's sides, `count` wedges: next to contacts narrow, as gaps grow there. */
static BTG_APART void cut_arc(double from, double to, double half_from, double half_to, int count,
                              double *low, double *high) {
    double middle = 0.5 * (to - from);
    int half = count / 2, other = count - half;
    double first = cbrt(half_from), step = (cbrt(half_from + middle) - first) / half;
    double last = cbrt(half_to), back = (cbrt(half_to + middle) - last) / other;
    for (int k = 0; k < count; k++) {
        double way = first + k * step, rest = last + (count - k) * back;
        low[k] =
            k < half ? from + (way * way * way - half_from) : to - (rest * rest * rest - half_to);
        if (k > 0) high[k - 1] = low[k];
    }
    low[0] = from;
    high[count - 1] = to;
}

/* Unit vectors instead of angles from 0 to 2 pi, in rows from that of cosines on: by series of an
 * eighth of the angle to pi. */
static BTG_APART void set_directions(ring_room *room, int cosine) {
    for (uint32_t i = 0; i < WEDGES; i += BTG_LANES) {
        lanes one = lanes_all(1);
        lanes x = lanes_mul(lanes_sub(get(room, cosine, i), lanes_all(BTG_PI)), lanes_all(0.125));
        lanes q = lanes_mul(x, x), s = lanes_all(1.0 / 362880), c = lanes_all(1.0 / 40320);
        s = lanes_mad(lanes_all(-1.0 / 5040), q, s);
        s = lanes_mad(lanes_all(1.0 / 120), q, s);
        s = lanes_mad(lanes_all(-1.0 / 6), q, s);
        s = lanes_mul(x, lanes_mad(one, q, s));
        c = lanes_mad(lanes_all(-1.0 / 720), q, c);
        c = lanes_mad(lanes_all(1.0 / 24), q, c);
        c = lanes_mad(lanes_all(-0.5), q, c);
        c = lanes_mad(one, q, c);
        for (int k = 0; k < 3; k++) {
            lanes twice = lanes_add(s, s);
            s = lanes_mul(twice, c);
            c = lanes_sub(lanes_mul(lanes_add(c, c), c), one);
        }
        /* once more to length 1, by Newton's step; and pi back */
        lanes long2 = lanes_mad(lanes_mul(c, c), s, s);
        lanes scale = lanes_mul(lanes_all(-0.5), lanes_sub(lanes_all(3), long2));
        set(room, cosine, i, lanes_mul(c, scale));
        set(room, cosine + 1, i, lanes_mul(s, scale));
    }
}

/* Sides of all wedges, and where their feet should be about: as in the plane that touches the part
 * at P. */
static BTG_APART void set_wedges(ring_room *room, btg_place p, const double step[4],
                                 double radius_p, double radius_q) {
    set_directions(room, LOW_C);
    set_directions(room, HIGH_C);
    for (uint32_t i = 0; i < WEDGES; i += BTG_LANES) {
        lanes half = lanes_all(0.5);
        lanes c = lanes_mul(half, lanes_add(get(room, LOW_C, i), get(room, HIGH_C, i)));
        lanes s = lanes_mul(half, lanes_add(get(room, LOW_S, i), get(room, HIGH_S, i)));
        lanes mean = lanes_all(0.5 * (radius_p + radius_q));
        lanes r = lanes_mad(mean, lanes_all(0.5 * (radius_p - radius_q)), c);
        lanes x = lanes_sub(lanes_mul(r, c), lanes_all(radius_p)), t = lanes_mul(r, s);
        lanes u = lanes_mad(lanes_all(p.u), lanes_all(step[0]), t);
        lanes v = lanes_mad(lanes_all(p.v), lanes_all(step[1]), t);
        set(room, U, i, lanes_mad(u, lanes_all(step[2]), x));
        set(room, V, i, lanes_mad(v, lanes_all(step[3]), x));
    }
}

/* Moves feet to the middle of their wedges and under the ring, where g_y is 0; not off the patch.
 */
static BTG_APART void move_feet(ring_room *room) {
    for (uint32_t i = 0; i < WEDGES; i += BTG_LANES) {
        lanes half = lanes_all(0.5), zero = lanes_all(0), one = lanes_all(1);
        lanes mc = lanes_mul(half, lanes_add(get(room, LOW_C, i), get(room, HIGH_C, i)));
        lanes ms = lanes_mul(half, lanes_add(get(room, LOW_S, i), get(room, HIGH_S, i)));
        lanes t = lanes_mul(ms, get(room, COSINE, i));
        t = lanes_mul(lanes_sub(t, lanes_mul(mc, get(room, SINE, i))), get(room, RADIUS, i));
        lanes x = lanes_sub(zero, lanes_mul(get(room, G_Y, i), get(room, FAR, i)));
        lanes u = lanes_mad(get(room, U, i), get(room, U_T, i), t);
        lanes v = lanes_mad(get(room, V, i), get(room, V_T, i), t);
        u = lanes_mad(u, get(room, U_X, i), x);
        v = lanes_mad(v, get(room, V_X, i), x);
        set(room, U, i, lanes_max(zero, lanes_min(one, u)));
        set(room, V, i, lanes_max(zero, lanes_min(one, v)));
    }
}

/* Bits: the foot is not far from the middle of all. */
static ALWAYS_INLINE unsigned near_middle(const ring_room *room, uint32_t i, const btg_ring *ring,
                                          double wide) {
    lanes dr = lanes_sub(get(room, RADIUS, i), lanes_all(ring->radius));
    lanes dz = lanes_sub(get(room, HEIGHT, i), lanes_all(ring->height));
    lanes away2 = lanes_mad(lanes_mul(dr, dr), dz, dz), most = lanes_all(AWAY_MOST * wide);
    return lanes_less(away2, lanes_mul(most, most));
}

/* HALF of all wedges; bits: their sides are less than a right angle from the foot. */
static BTG_APART unsigned set_halves(ring_room *room) {
    unsigned bits = 0;
    for (uint32_t i = 0; i < WEDGES; i += BTG_LANES) {
        lanes c = get(room, COSINE, i), s = get(room, SINE, i), zero = lanes_all(0);
        lanes lc = get(room, LOW_C, i), ls = get(room, LOW_S, i);
        lanes hc = get(room, HIGH_C, i), hs = get(room, HIGH_S, i);
        lanes low = lanes_sub(lanes_mul(c, ls), lanes_mul(s, lc));
        lanes high = lanes_sub(lanes_mul(c, hs), lanes_mul(s, hc));
        lanes sine = lanes_max(lanes_abs(low), lanes_abs(high));
        set(room, HALF, i, lanes_mad(lanes_all(1e-9), sine, lanes_all(1 + 1e-9)));
        unsigned before = lanes_less(zero, lanes_mad(lanes_mul(c, lc), s, ls));
        bits |= (before & lanes_less(zero, lanes_mad(lanes_mul(c, hc), s, hs))) << i;
    }
    return bits;
}

/* Bits of the wedges that are clear. */
static BTG_APART unsigned prove_wedges(ring_room *room, const btg_ring *ring, double wide,
                                       double corner, double deep) {
    unsigned clear = 0;
    for (uint32_t i = 0; i < WEDGES; i += BTG_LANES) {
        lanes t = lanes_mul(get(room, HALF, i), get(room, RADIUS, i)), half = lanes_all(0.5);
        lanes g = lanes_abs(get(room, SLOPE_T, i)), k = get(room, BEND_T, i);
        /* the least of a parabola, from -t to t */
        lanes end = lanes_mul(t, lanes_sub(lanes_mul(lanes_mul(half, k), t), g));
        lanes bottom = lanes_div(lanes_mul(lanes_mul(half, g), g), lanes_max(k, lanes_all(1e-30)));
        lanes v = lanes_if_less(g, lanes_mul(k, t), lanes_sub(lanes_all(0), bottom), end);
        lanes rest = lanes_mad(get(room, CUBIC, i), get(room, FOURTH, i), t);
        v = lanes_sub(v, lanes_mul(lanes_mul(t, lanes_mul(t, t)), rest));
        v = lanes_sub(v, get(room, OFF, i));
        unsigned valid = holds(room, i, ring) & near_middle(room, i, ring, wide);
        clear |= (valid & clear_at(room, i, v, corner, deep)) << i;
    }
    return clear;
}

/* ---- the ring ----------------------------------------------------------------------------- */

static void add_open(btg_ring *ring, double low_c, double low_s, double high_c, double high_s) {
    if (ring->open < BTG_RING_OPEN)
        ring->wedge[ring->open] = (btg_wedge){{low_s, -low_c}, {-high_s, high_c}};
    ring->open++;
}

static BTG_APART void add_contact(btg_ring *ring, const btg_ring_contact *c) {
    if (c->proven) return;
    double half = c->half * (1 + 1e-6), k = cos(half), s = sin(half);
    add_open(ring, c->cosine * k + c->sine * s, c->sine * k - c->cosine * s,
             c->cosine * k - c->sine * s, c->sine * k + c->cosine * s);
}

/* Parameters of all that the ring may be about, if the part is flat. */
static void set_box(btg_ring *ring, btg_place p, double radius, double way) {
    const double *step = ring->step;
    ring->item = p.item;
    ring->u = p.u - step[2] * radius;
    ring->v = p.v - step[3] * radius;
    ring->half_u = BOX_MORE * way * norm2(step[0], step[2]);
    ring->half_v = BOX_MORE * way * norm2(step[1], step[3]);
}

/* Q, where the tool touches the patch of P there. */
static bool has_q(const btg_search *search) {
    return search->found && !search->osculating && search->element == 0 &&
           search->place.item == search->p_place.item;
}

/* The feet at P and, second, at Q. */
static BTG_APART void expand_contacts(btg_search *search, ring_room *room) {
    btg_place q = has_q(search) ? search->place : search->p_place;
    for (int k = 0; k < 8; k++) {
        room->row[U][k] = k > 0 ? q.u : search->p_place.u;
        room->row[V][k] = k > 0 ? q.v : search->p_place.v;
    }
    expand_feet(search, room, 4);
}

/* Wedges whose feet the patch may have. */
static int feet_inside(const ring_room *room) {
    int inside = 0;
    for (int k = 0; k < WEDGES; k++)
        inside += room->row[U][k] >= 0 && room->row[U][k] <= 1 && room->row[V][k] >= 0 &&
                  room->row[V][k] <= 1;
    return inside;
}

/* What of the width is left for all when the feet are not at one place in radius and height. */
static BTG_APART void narrow(btg_ring *ring, const ring_room *room, unsigned feet, double wide) {
    double most = 0;
    for (; feet; feet &= feet - 1) {
        int k = btg_lowest_bit(feet);
        double dr = room->row[RADIUS][k] - ring->radius, dz = room->row[HEIGHT][k] - ring->height;
        most = max2(most, dr * dr + dz * dz);
    }
    ring->wide = min2(ring->wide, wide - sqrt(most));
}

/* Cuts the way from P to Q and back into wedges. */
static BTG_APART void cut_ring(ring_room *room, const btg_ring *ring, bool two) {
    const btg_ring_contact *p = &ring->p, *q = &ring->q;
    double at_q = two ? atan2(q->sine, q->cosine) : BTG_PI, gap = two ? q->half : 0, tiny = 1e-3;
    if (at_q < 0) at_q += 2 * BTG_PI;
    /* where the contacts' own wedges meet there is nothing to cut, but it does no harm */
    double back = 2 * BTG_PI - p->half, to = max2(at_q - gap, p->half + tiny);
    double from = min2(at_q + gap, back - tiny), first = to - p->half, second = back - from;
    int count = (int)(WEDGES * first / (first + second) + 0.5), most = WEDGES - ARC_LEAST;
    count = count < ARC_LEAST ? ARC_LEAST : (count > most ? most : count);
    double *low = room->row[LOW_C], *high = room->row[HIGH_C], half = two ? q->half : CONTACT_MOST;
    cut_arc(p->half, to, p->half, half, count, low, high);
    cut_arc(from, back, half, p->half, WEDGES - count, low + count, high + count);
}

/* Proves the contacts' own wedges. */
static BTG_APART void begin_ring(btg_ring *ring, ring_room *room, double wide, bool two) {
    set_contact(room, 0, &ring->p);
    set_contact(room, 1, &ring->q);
    ring->radius = 0.5 * (ring->p.radius + ring->q.radius);
    ring->height = 0.5 * (ring->p.height + ring->q.height);
    ring->wide = wide;
    narrow(ring, room, 3, wide);
    add_contact(ring, &ring->p);
    if (two) add_contact(ring, &ring->q);
    ring->closed = two && ring->open == 0;
}

/* How far from the ring wedges reach. */
static double width_of(const btg_tool_element *e) {
    return WIDE * min2(e->ring_radius_mm, e->corner_radius_mm);
}

/* The contacts; false: P's place is elsewhere. */
static BTG_APART bool prove_contacts_of(btg_search *search) {
    const btg_tool_element *e = &search->query.tool->element[0];
    btg_ring *ring = &search->ring;
    ring_room *room = room_of(search);
    double wide = width_of(e), deep = RING_SHARE * search->tolerance;
    expand_contacts(search, room);
    /* wedges are cut from angle 0 on: there P's foot has to be */
    if (!(room->row[COSINE][0] > 0 && fabs(room->row[SINE][0]) < P_SINE)) return false;
    set_box(ring, search->p_place, room->row[RADIUS][0], e->ring_radius_mm + wide);
    prove_contacts(room, ring, wide, e->corner_radius_mm, deep);
    begin_ring(ring, room, wide, has_q(search));
    return true;
}

/* The feet of all wedges; false: the patch ends too near. */
static BTG_APART bool set_feet(btg_search *search) {
    btg_ring *ring = &search->ring;
    ring_room *room = room_of(search);
    double ro = search->query.tool->element[0].ring_radius_mm;
    cut_ring(room, ring, has_q(search));
    set_wedges(room, search->p_place, ring->step, ring->p.radius, ring->q.radius);
    if (feet_inside(room) < WEDGES / 2) return false;
    evaluate_feet(search->part, ring->item, WEDGES, room);
    place_feet(room, WEDGES, ring, &search->at, ro);
    turn_rows(room, WEDGES, ring, search->at.axis, SUU);
    set_slopes(room, WEDGES, ro);
    move_feet(room);
    return true;
}

static BTG_APART void finish_ring(btg_search *search) {
    const btg_tool_element *e = &search->query.tool->element[0];
    btg_ring *ring = &search->ring;
    ring_room *room = room_of(search);
    double wide = width_of(e), deep = RING_SHARE * search->tolerance;
    unsigned clear = set_halves(room);
    bound_wedges(room, WEDGES, ring, wide);
    clear &= prove_wedges(room, ring, wide, e->corner_radius_mm, deep);
    for (int k = 0; k < WEDGES; k++)
        if (!(clear >> k & 1))
            add_open(ring, room->row[LOW_C][k], room->row[LOW_S][k], room->row[HIGH_C][k],
                     room->row[HIGH_S][k]);
    narrow(ring, room, clear, wide);
    ring->stands = ring->open <= BTG_RING_OPEN;
    ring->closed = ring->closed && ring->stands;
}

/* Directions that wedges are measured by; false: P is on the axis. */
static bool turn_to_p(btg_search *search) {
    btg_ring *ring = &search->ring;
    btg_vec3 axis = search->at.axis, arm = vec_sub(search->query.p, search->at.centre);
    arm = vec_mad(arm, axis, -vec_dot(arm, axis));
    if (!(vec_norm2(arm) > 0)) return false;
    ring->x = vec_unit(arm);
    ring->y = vec_cross(axis, ring->x);
    return true;
}

/* Sets ring->step; false: there is none. */
static BTG_APART bool step_at_p(btg_search *search) {
    btg_ring *ring = &search->ring;
    btg_surface_point *s = &search->here;
    btg_part_point(search->part, search->p_place, s);
    double tu = vec_dot(s->su, ring->y), tv = vec_dot(s->sv, ring->y);
    double xu = vec_dot(s->su, ring->x), xv = vec_dot(s->sv, ring->x), det = tu * xv - tv * xu;
    ring->step[0] = xv / det;
    ring->step[1] = -xu / det;
    ring->step[2] = -tv / det;
    ring->step[3] = tu / det;
    return isfinite(ring->step[0] + ring->step[1] + ring->step[2] + ring->step[3]);
}

/* A hollow cutter tilts about a place of a patch, over which that is a sheet. */
static bool begins(btg_search *search) {
    return search->query.op == BTG_OP_TILT && search->query.tool->element[0].hollow &&
           search->p_place.item < search->part->patch_count && turn_to_p(search) &&
           step_at_p(search);
}

void btg_ring_prove(btg_search *search) {
    btg_ring *ring = &search->ring;
    ring->stale = ring->stands = ring->closed = false;
    ring->open = 0;
    /* before the tool has touched the part twice it cuts into it */
    if (!search->found || search->osculating || !begins(search)) return;
    if (!prove_contacts_of(search) || !set_feet(search)) return;
    expand_feet(search, room_of(search), WEDGES);
    finish_ring(search);
}

/* ---- where to begin ----------------------------------------------------------------------- */

/* What the tool has to turn back about P until it is clear of a foot, about: the deepest cut over
 * its way from P. */
static ALWAYS_INLINE lanes turn_back(const ring_room *room, uint32_t i, double radius,
                                     double corner) {
    lanes zero = lanes_all(0), one = lanes_all(1), u = get(room, U, i), v = get(room, V, i);
    lanes way = lanes_mul(get(room, RADIUS, i), get(room, COSINE, i));
    way = lanes_sub(lanes_all(radius), way);
    lanes deep = lanes_sub(lanes_all(corner), get(room, FAR, i));
    lanes turn = lanes_div(deep, lanes_max(way, lanes_all(START_WAY * radius)));
    lanes inside = lanes_min(lanes_min(u, lanes_sub(one, u)), lanes_min(v, lanes_sub(one, v)));
    turn = lanes_if_less(inside, zero, zero, turn);
    return lanes_if_less(get(room, HEIGHT, i), zero, turn, zero);
}

bool btg_ring_start(btg_search *search, btg_place *place) {
    const btg_tool_element *e = &search->query.tool->element[0];
    const btg_ring *ring = &search->ring;
    ring_room *room = room_of(search);
    double best = 0, radius;
    int from = -1;
    if (!begins(search)) return false;
    radius = vec_dot(vec_sub(search->query.p, search->at.centre), ring->x);
    for (int k = 0; k < WEDGES; k++)
        room->row[LOW_C][k] = room->row[HIGH_C][k] = (k + 0.5) * (2 * BTG_PI / WEDGES);
    set_wedges(room, search->p_place, ring->step, radius, radius);
    evaluate_feet(search->part, search->p_place.item, WEDGES, room);
    place_feet(room, WEDGES, ring, &search->at, e->ring_radius_mm);
    for (uint32_t i = 0; i < WEDGES; i += BTG_LANES)
        set(room, FAR, i, turn_back(room, i, radius, e->corner_radius_mm));
    for (int k = 0; k < WEDGES; k++)
        if (room->row[FAR][k] > best) {
            best = room->row[FAR][k];
            from = k;
        }
    if (from < 0) return false;
    *place = (btg_place){search->p_place.item, room->row[U][from], room->row[V][from]};
    return true;
}
