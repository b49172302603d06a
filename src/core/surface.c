/* Bezier patches: evaluation with first and second derivatives, subdivision, and the bound of a
 * sub-patch by its tangent plane and second derivatives.
 *
 * Bounds use the convex-hull property: a Bezier form lies within its control points, and its
 * derivatives are Bezier forms of differences (G. Farin, "Curves and Surfaces for CAGD", 2002,
 * chapters 5 and 14). */
#include "core/surface.h"

#include <string.h>

/* ---- evaluation --------------------------------------------------------------------------- */

/* Bernstein polynomials of degree n at t, with first and second derivatives. */
static void bernstein(int n, double t, double b[BTG_ORDER_MAX], double d1[BTG_ORDER_MAX],
                      double d2[BTG_ORDER_MAX]) {
    double s = 1 - t;
    for (int i = 0; i <= n; i++) d1[i] = d2[i] = 0;
    b[0] = 1;
    for (int k = 1; k <= n; k++) {
        if (k == n - 1) /* b holds degree n - 2 */
            for (int i = 0; i <= n - 2; i++) {
                d2[i] += n * (n - 1) * b[i];
                d2[i + 1] -= 2.0 * n * (n - 1) * b[i];
                d2[i + 2] += n * (n - 1) * b[i];
            }
        if (k == n) /* b holds degree n - 1 */
            for (int i = 0; i <= n - 1; i++) {
                d1[i] -= n * b[i];
                d1[i + 1] += n * b[i];
            }
        b[k] = t * b[k - 1];
        for (int i = k - 1; i > 0; i--) b[i] = s * b[i] + t * b[i - 1];
        b[0] *= s;
    }
}

typedef struct homogeneous {
    btg_vec3 p;
    double w;
} homogeneous;

static homogeneous h_mad(homogeneous a, homogeneous b, double k) {
    return (homogeneous){vec_mad(a.p, b.p, k), a.w + b.w * k};
}

/* N/W and its derivatives from those of N and W. */
static void quotient(const homogeneous n[6], btg_surface_point *out) {
    double k = 1 / n[0].w;
    out->s = vec_scale(n[0].p, k);
    out->su = vec_scale(vec_mad(n[1].p, out->s, -n[1].w), k);
    out->sv = vec_scale(vec_mad(n[2].p, out->s, -n[2].w), k);
    btg_vec3 uu = vec_mad(vec_mad(n[3].p, out->su, -2 * n[1].w), out->s, -n[3].w);
    btg_vec3 uv = vec_mad(vec_mad(n[4].p, out->su, -n[2].w), out->sv, -n[1].w);
    btg_vec3 vv = vec_mad(vec_mad(n[5].p, out->sv, -2 * n[2].w), out->s, -n[5].w);
    out->suu = vec_scale(uu, k);
    out->suv = vec_scale(vec_mad(uv, out->s, -n[4].w), k);
    out->svv = vec_scale(vv, k);
}

static homogeneous coefficient(const btg_patch *patch, int index) {
    const double *c = patch->coefficients + (size_t)index * (patch->rational ? 4 : 3);
    return (homogeneous){vec(c[0], c[1], c[2]), patch->rational ? c[3] : 1};
}

void btg_patch_evaluate(const btg_patch *patch, double u, double v, btg_surface_point *point) {
    int n = patch->degree_u, m = patch->degree_v;
    double bu[3][BTG_ORDER_MAX], bv[3][BTG_ORDER_MAX];
    bernstein(n, u, bu[0], bu[1], bu[2]);
    bernstein(m, v, bv[0], bv[1], bv[2]);
    homogeneous sum[6]; /* value, u, v, uu, uv, vv */
    memset(sum, 0, sizeof sum);
    for (int i = 0; i <= n; i++) {
        homogeneous row[3];
        memset(row, 0, sizeof row);
        for (int j = 0; j <= m; j++) {
            homogeneous c = coefficient(patch, i * (m + 1) + j);
            for (int k = 0; k < 3; k++) row[k] = h_mad(row[k], c, bv[k][j]);
        }
        sum[0] = h_mad(sum[0], row[0], bu[0][i]);
        sum[1] = h_mad(sum[1], row[0], bu[1][i]);
        sum[2] = h_mad(sum[2], row[1], bu[0][i]);
        sum[3] = h_mad(sum[3], row[0], bu[2][i]);
        sum[4] = h_mad(sum[4], row[1], bu[1][i]);
        sum[5] = h_mad(sum[5], row[2], bu[0][i]);
    }
    if (patch->rational) {
        quotient(sum, point);
        return;
    }
    *point = (btg_surface_point){sum[0].p, sum[1].p, sum[2].p, sum[3].p, sum[4].p, sum[5].p};
}

btg_vec3 btg_patch_point(const btg_patch *patch, double u, double v) {
    int n = patch->degree_u, m = patch->degree_v;
    double bu[BTG_ORDER_MAX], bv[BTG_ORDER_MAX], d1[BTG_ORDER_MAX], d2[BTG_ORDER_MAX];
    bernstein(n, u, bu, d1, d2);
    bernstein(m, v, bv, d1, d2);
    homogeneous sum = {vec(0, 0, 0), 0};
    for (int i = 0; i <= n; i++) {
        homogeneous row = {vec(0, 0, 0), 0};
        for (int j = 0; j <= m; j++) row = h_mad(row, coefficient(patch, i * (m + 1) + j), bv[j]);
        sum = h_mad(sum, row, bu[i]);
    }
    return patch->rational ? vec_scale(sum.p, 1 / sum.w) : sum.p;
}

/* ---- subdivision -------------------------------------------------------------------------- */

static double *net_at(btg_net *net, int i, int j) {
    return net->point + 4 * (i * (net->degree_v + 1) + j);
}

static const double *net_point(const btg_net *net, int i, int j) {
    return net->point + 4 * (i * (net->degree_v + 1) + j);
}

/* De Casteljau at 1/2 on n + 1 points `stride` apart: the low half replaces `line`, the high half
 * goes to `high`. */
static void split_line(double *line, double *high, int n, int stride) {
    for (int c = 0; c < 4; c++) {
        high[n * stride + c] = line[n * stride + c];
        for (int k = 1; k <= n; k++) {
            for (int i = n; i >= k; i--) {
                double *p = line + i * stride + c;
                *p = 0.5 * (p[0] + p[-stride]);
            }
            high[(n - k) * stride + c] = line[n * stride + c];
        }
    }
}

void btg_net_split(const btg_net *net, bool along_u, btg_net *low, btg_net *high) {
    *low = *net;
    high->degree_u = net->degree_u;
    high->degree_v = net->degree_v;
    int row = 4 * (net->degree_v + 1);
    if (along_u) {
        for (int j = 0; j <= net->degree_v; j++)
            split_line(net_at(low, 0, j), net_at(high, 0, j), net->degree_u, row);
    } else {
        for (int i = 0; i <= net->degree_u; i++)
            split_line(net_at(low, i, 0), net_at(high, i, 0), net->degree_v, 4);
    }
}

/* ---- bounds ------------------------------------------------------------------------------- */

/* Bounds of the derivatives of N = W (S - c) and of W over a net, by order in u and v, and of
 * S - c itself. */
typedef struct net_bounds {
    double n[4][4], w[4][4];
    double w_min, reach; /* smallest W, largest |S - c| */
} net_bounds;

/* Difference of order (du, dv) at (i, j), without the degree factors: W (S - c) and W. */
static void difference(const btg_net *net, btg_vec3 c, int i, int j, int du, int dv,
                       double *point_norm, double *weight) {
    static const double binomial[4][4] = {
        {1, 0, 0, 0}, {-1, 1, 0, 0}, {1, -2, 1, 0}, {-1, 3, -3, 1}};
    btg_vec3 sum = vec(0, 0, 0);
    double w = 0;
    for (int k = 0; k <= du; k++)
        for (int l = 0; l <= dv; l++) {
            const double *p = net_point(net, i + k, j + l);
            double f = binomial[du][k] * binomial[dv][l];
            btg_vec3 q = vec(p[0] - p[3] * c.x, p[1] - p[3] * c.y, p[2] - p[3] * c.z);
            sum = vec_mad(sum, q, f);
            w += f * p[3];
        }
    *point_norm = vec_norm(sum);
    *weight = fabs(w);
}

static void derivative_bound(const btg_net *net, btg_vec3 c, int du, int dv, double *point_max,
                             double *weight_max) {
    int n = net->degree_u, m = net->degree_v;
    double factor = 1;
    for (int k = 0; k < du; k++) factor *= n - k;
    for (int l = 0; l < dv; l++) factor *= m - l;
    *point_max = *weight_max = 0;
    for (int i = 0; i <= n - du; i++)
        for (int j = 0; j <= m - dv; j++) {
            double p, w;
            difference(net, c, i, j, du, dv, &p, &w);
            *point_max = fmax(*point_max, factor * p);
            *weight_max = fmax(*weight_max, factor * w);
        }
}

/* All derivatives up to an order. */
static void measure(const btg_net *net, btg_vec3 c, int order, net_bounds *b) {
    for (int du = 0; du <= order; du++)
        for (int dv = 0; dv <= order - du; dv++)
            derivative_bound(net, c, du, dv, &b->n[du][dv], &b->w[du][dv]);
    b->w_min = INFINITY;
    b->reach = 0;
    for (int i = 0; i <= net->degree_u; i++)
        for (int j = 0; j <= net->degree_v; j++) {
            const double *p = net_point(net, i, j);
            b->w_min = fmin(b->w_min, p[3]);
            btg_vec3 s = vec(p[0] / p[3] - c.x, p[1] / p[3] - c.y, p[2] / p[3] - c.z);
            b->reach = fmax(b->reach, vec_norm(s));
        }
}

/* Bounds of the derivatives of S = N / W + c from those of N and W, by Leibniz' rule:
 * W S(i,j) = N(i,j) - sum over (k,l) < (i,j) of binomials times W(i-k,j-l) S(k,l). */
static void quotient_bounds(const net_bounds *b, int order, double s[4][4]) {
    static const double binomial[4][4] = {
        {1, 0, 0, 0}, {1, 1, 0, 0}, {1, 2, 1, 0}, {1, 3, 3, 1}};
    const double over = 1 + 1e-12; /* rounding of the sums */
    s[0][0] = b->reach;
    for (int sum = 1; sum <= order; sum++)
        for (int i = 0; i <= sum; i++) {
            int j = sum - i;
            double total = b->n[i][j];
            for (int k = 0; k <= i; k++)
                for (int l = 0; l <= j; l++)
                    if (k + l < sum)
                        total += binomial[i][k] * binomial[j][l] * b->w[i - k][j - l] * s[k][l];
            s[i][j] = total / b->w_min * over;
        }
}

static float round_up(double x) {
    float f = (float)x;
    return f < x ? nextafterf(f, INFINITY) : f;
}

static void to_float(btg_vec3 a, float out[3]) {
    out[0] = (float)a.x;
    out[1] = (float)a.y;
    out[2] = (float)a.z;
}

void btg_net_tile(const btg_net *net, double scale, btg_tile *tile) {
    btg_patch patch = {.coefficients = net->point, .rational = true};
    patch.degree_u = (uint8_t)net->degree_u;
    patch.degree_v = (uint8_t)net->degree_v;
    btg_surface_point mid;
    btg_patch_evaluate(&patch, 0.5, 0.5, &mid);
    btg_vec3 a = vec_scale(mid.su, 0.5), b = vec_scale(mid.sv, 0.5);
    tile->centre = mid.s;
    to_float(a, tile->a);
    to_float(b, tile->b);
    net_bounds bounds;
    double s[4][4];
    measure(net, mid.s, 2, &bounds);
    quotient_bounds(&bounds, 2, s);
    /* a and b as floats are off by half a unit in the last place; points by a few of `scale`. */
    double slack = 6e-8 * (vec_norm(a) + vec_norm(b)) + 1e-14 * scale;
    tile->bend_uu = round_up(s[2][0] / 8 + slack);
    tile->bend_uv = round_up(s[1][1] / 4 + slack);
    tile->bend_vv = round_up(s[0][2] / 8 + slack);
    tile->child = 0;
}

void btg_net_third(const btg_net *net, double third[4]) {
    const double *p = net_point(net, net->degree_u / 2, net->degree_v / 2);
    net_bounds bounds;
    double s[4][4];
    measure(net, vec(p[0] / p[3], p[1] / p[3], p[2] / p[3]), 3, &bounds);
    quotient_bounds(&bounds, 3, s);
    for (int k = 0; k < 4; k++) third[k] = fmax(third[k], s[3 - k][k]);
}
