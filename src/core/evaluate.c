/* Points and derivatives of patches, one place at a time or a block of them.
 *
 * A patch is held as a polynomial about the middle of its domain and of its net, so rounding errors
 * are those of its own size, and Horner's scheme gives value and derivatives together. */
#include "core/part.h"

/* Value, u, v, uu, uv, vv. */
typedef struct form {
    lanes d[6];
} form;

/* One coefficient: its four coordinates (coordinate < 0), or one of them in all lanes. */
static ALWAYS_INLINE lanes coefficient(const double *power, int at, int coordinate) {
    return coordinate < 0 ? lanes_load_four(power + 4 * at) : lanes_all(power[4 * at + coordinate]);
}

/* Value and derivatives of one row's polynomial in t; half the second derivative. */
static ALWAYS_INLINE void row(const double *power, int first, int m, int coordinate, lanes t,
                              lanes out[3]) {
    lanes p = coefficient(power, first + m, coordinate), d = p, e = lanes_all(0);
    for (int j = m - 1; j >= 0; j--) {
        if (j < m - 1) {
            e = j < m - 2 ? lanes_mad(d, e, t) : d;
            d = lanes_mad(p, d, t);
        }
        p = lanes_mad(coefficient(power, first + j, coordinate), p, t);
    }
    out[0] = p;
    out[1] = d;
    out[2] = e;
}

static ALWAYS_INLINE form horner(const double *power, int n, int m, int coordinate, lanes s,
                                 lanes t) {
    lanes r[3], zero = lanes_all(0);
    row(power, n * (m + 1), m, coordinate, t, r);
    lanes p = r[0], pu = r[0], puu = zero, v = r[1], vu = r[1], w = r[2];
    for (int i = n - 1; i >= 0; i--) {
        row(power, i * (m + 1), m, coordinate, t, r);
        if (i < n - 1) {
            puu = i < n - 2 ? lanes_mad(pu, puu, s) : pu;
            pu = lanes_mad(p, pu, s);
            vu = lanes_mad(v, vu, s);
        }
        p = lanes_mad(r[0], p, s);
        v = lanes_mad(r[1], v, s);
        w = lanes_mad(r[2], w, s);
    }
    return (form){{p, pu, v, lanes_add(puu, puu), vu, lanes_add(w, w)}};
}

/* ---- one place ---------------------------------------------------------------------------- */

static btg_vec3 head(const double h[4]) {
    return vec(h[0], h[1], h[2]);
}

/* N/W and its derivatives from those of N and W. */
static void quotient(double h[6][4], btg_surface_point *out) {
    double k = 1 / h[0][3], wu = h[1][3], wv = h[2][3];
    out->s = vec_scale(head(h[0]), k);
    out->su = vec_scale(vec_mad(head(h[1]), out->s, -wu), k);
    out->sv = vec_scale(vec_mad(head(h[2]), out->s, -wv), k);
    btg_vec3 uu = vec_mad(vec_mad(head(h[3]), out->su, -2 * wu), out->s, -h[3][3]);
    btg_vec3 uv = vec_mad(vec_mad(head(h[4]), out->su, -wv), out->sv, -wu);
    btg_vec3 vv = vec_mad(vec_mad(head(h[5]), out->sv, -2 * wv), out->s, -h[5][3]);
    out->suu = vec_scale(uu, k);
    out->suv = vec_scale(vec_mad(uv, out->s, -h[4][3]), k);
    out->svv = vec_scale(vv, k);
}

static btg_vec3 first_three(lanes a) {
    double h[4];
    lanes_store_four(h, a);
    return head(h);
}

static ALWAYS_INLINE form form_at(const btg_patch *patch, int n, int m, double u, double v) {
    return horner(patch->power, n, m, -1, lanes_all(u - 0.5), lanes_all(v - 0.5));
}

static ALWAYS_INLINE void set_point(const form *f, const btg_patch *patch,
                                    btg_surface_point *point) {
    point->s = vec_add(first_three(f->d[0]), patch->origin);
    point->su = first_three(f->d[1]);
    point->sv = first_three(f->d[2]);
    point->suu = first_three(f->d[3]);
    point->suv = first_three(f->d[4]);
    point->svv = first_three(f->d[5]);
}

/* Each apart, so that none has another's frame above it. */
static BTG_APART void point_of_rational(const btg_patch *patch, double u, double v,
                                        btg_surface_point *point) {
    form f = form_at(patch, patch->degree_u, patch->degree_v, u, v);
    double h[6][4];
    lanes_store_four(h[0], f.d[0]);
    lanes_store_four(h[1], f.d[1]);
    lanes_store_four(h[2], f.d[2]);
    lanes_store_four(h[3], f.d[3]);
    lanes_store_four(h[4], f.d[4]);
    lanes_store_four(h[5], f.d[5]);
    quotient(h, point);
    point->s = vec_add(point->s, patch->origin);
}

static BTG_APART void point_of_any(const btg_patch *patch, double u, double v,
                                   btg_surface_point *point) {
    form f = form_at(patch, patch->degree_u, patch->degree_v, u, v);
    set_point(&f, patch, point);
}

static BTG_APART void point_of_bicubic(const btg_patch *patch, double u, double v,
                                       btg_surface_point *point) {
    form f = form_at(patch, 3, 3, u, v);
    set_point(&f, patch, point);
}

void btg_patch_evaluate(const btg_patch *patch, double u, double v, btg_surface_point *point) {
    if (patch->rational)
        point_of_rational(patch, u, v, point);
    else if (patch->degree_u == 3 && patch->degree_v == 3)
        point_of_bicubic(patch, u, v, point);
    else
        point_of_any(patch, u, v, point);
}

/* ---- side by side ------------------------------------------------------------------------- */

/* Coordinate c of S (k = 0) or of its derivative k, in the order of `form`: all stand in a row. */
static ALWAYS_INLINE double *row_of(btg_surface_block *out, int k, int c) {
    return ((lanes3_memory *)(void *)out)[k].at[c];
}

/* Where the lanes of one four of a block begin, and where they go. Eight lanes hold two fours: the
 * second one's patch, where it is another, is evaluated in both and stored over the upper four. */
#if BTG_LANES == 4
static ALWAYS_INLINE int first_of(int four) {
    return 4 * four;
}
static ALWAYS_INLINE void store_row(lanes a, int four, double *row) {
    lanes_store(row + 4 * four, a);
}
#else
static ALWAYS_INLINE int first_of(int four) {
    return 4 * (four & ~1);
}
static ALWAYS_INLINE void store_row(lanes a, int four, double *row) {
    if (four & 1)
        lanes_store_upper(row + first_of(four), a);
    else
        lanes_store(row + first_of(four), a);
}
#endif

/* A loop would keep the form in memory where it is not unrolled. */
static ALWAYS_INLINE void store(const form *f, int four, int c, btg_surface_block *out) {
    store_row(f->d[0], four, row_of(out, 0, c));
    store_row(f->d[1], four, row_of(out, 1, c));
    store_row(f->d[2], four, row_of(out, 2, c));
    store_row(f->d[3], four, row_of(out, 3, c));
    store_row(f->d[4], four, row_of(out, 4, c));
    store_row(f->d[5], four, row_of(out, 5, c));
}

static ALWAYS_INLINE lanes load(btg_surface_block *from, int k, int c, int four) {
    return lanes_load(row_of(from, k, c) + first_of(four));
}

static ALWAYS_INLINE lanes centred(const double *parameter, int four) {
    return lanes_sub(lanes_load(parameter + first_of(four)), lanes_all(0.5));
}

/* One coordinate after the other: where the patch is rational, of N alone. */
static ALWAYS_INLINE void evaluate_four(const btg_patch *patch, int n, int m, int four,
                                        const double *u, const double *v, btg_surface_block *out) {
    lanes s = centred(u, four), t = centred(v, four);
    const double origin[3] = {patch->origin.x, patch->origin.y, patch->origin.z};
    for (int c = 0; c < 3; c++) {
        form f = horner(patch->power, n, m, c, s, t);
        if (!patch->rational) f.d[0] = lanes_add(f.d[0], lanes_all(origin[c]));
        store(&f, four, c, out);
    }
}

/* Each apart, so that none has another's frame above it. */
static BTG_APART void evaluate_bicubic(const btg_patch *patch, int four, const double *u,
                                       const double *v, btg_surface_block *out) {
    evaluate_four(patch, 3, 3, four, u, v, out);
}

static BTG_APART void evaluate_any(const btg_patch *patch, int four, const double *u,
                                   const double *v, btg_surface_block *out) {
    evaluate_four(patch, patch->degree_u, patch->degree_v, four, u, v, out);
}

/* N/W and its derivatives from those of N and W, of that 1 / W; one coordinate. */
static BTG_APART void divide(const form *w, double origin, int four, int c,
                             btg_surface_block *out) {
    lanes k = w->d[0], two = lanes_all(2);
    form q;
    q.d[0] = lanes_mul(load(out, 0, c, four), k);
    q.d[1] = lanes_mul(lanes_sub(load(out, 1, c, four), lanes_mul(q.d[0], w->d[1])), k);
    q.d[2] = lanes_mul(lanes_sub(load(out, 2, c, four), lanes_mul(q.d[0], w->d[2])), k);
    lanes uu = lanes_sub(load(out, 3, c, four), lanes_mul(two, lanes_mul(q.d[1], w->d[1])));
    lanes uv = lanes_sub(load(out, 4, c, four), lanes_mul(q.d[1], w->d[2]));
    uv = lanes_sub(uv, lanes_mul(q.d[2], w->d[1]));
    lanes vv = lanes_sub(load(out, 5, c, four), lanes_mul(two, lanes_mul(q.d[2], w->d[2])));
    q.d[3] = lanes_mul(lanes_sub(uu, lanes_mul(q.d[0], w->d[3])), k);
    q.d[4] = lanes_mul(lanes_sub(uv, lanes_mul(q.d[0], w->d[4])), k);
    q.d[5] = lanes_mul(lanes_sub(vv, lanes_mul(q.d[0], w->d[5])), k);
    q.d[0] = lanes_add(q.d[0], lanes_all(origin));
    store(&q, four, c, out);
}

/* W and its derivatives, but 1 / W. */
static BTG_APART void evaluate_weight(const btg_patch *patch, int four, const double *u,
                                      const double *v, form *w) {
    *w = horner(patch->power, patch->degree_u, patch->degree_v, 3, centred(u, four),
                centred(v, four));
    w->d[0] = lanes_div(lanes_all(1), w->d[0]);
}

static BTG_APART void divide_out_four(const btg_patch *patch, int four, const double *u,
                                      const double *v, btg_surface_block *out) {
    form w;
    evaluate_weight(patch, four, u, v, &w);
    divide(&w, patch->origin.x, four, 0, out);
    divide(&w, patch->origin.y, four, 1, out);
    divide(&w, patch->origin.z, four, 2, out);
}

void btg_patch_evaluate_block(const btg_patch *const patch[], int fours, const double u[BTG_BLOCK],
                              const double v[BTG_BLOCK], btg_surface_block *out) {
    for (int four = 0; four < fours; four++) {
        const btg_patch *of = patch[four];
        if (BTG_LANES == 8 && four & 1 && of == patch[four - 1]) continue; /* done with that */
        if (of->degree_u == 3 && of->degree_v == 3)
            evaluate_bicubic(of, four, u, v, out);
        else
            evaluate_any(of, four, u, v, out);
        if (of->rational) divide_out_four(of, four, u, v, out);
    }
}

/* ---- any item ------------------------------------------------------------------------------ */

void btg_part_point(const btg_part *part, btg_place place, btg_surface_point *point) {
    if (place.item < part->patch_count) {
        btg_patch_evaluate(&part->patches[place.item], place.u, place.v, point);
        return;
    }
    btg_vec3 c[3];
    btg_triangle_corners(part, place.item - part->patch_count, c);
    *point = (btg_surface_point){.su = vec_sub(c[1], c[0]), .sv = vec_sub(c[2], c[0])};
    point->s = vec_mad(vec_mad(c[0], point->su, place.u), point->sv, place.v);
}
