/* Bezier patches: evaluation with first and second derivatives, subdivision, and the bound of a
 * sub-patch by its tangent plane and second derivatives.
 *
 * Bounds use the convex-hull property: a Bezier form lies within its control points, and its
 * derivatives are Bezier forms of differences (G. Farin, "Curves and Surfaces for CAGD", 2002,
 * chapters 5 and 14). */
#include "core/surface.h"

#include <string.h>

/* ---- evaluation --------------------------------------------------------------------------- */

/* Raises Bernstein polynomials of degree k - 1 at t to degree k, in place. */
static inline void raise_degree(double b[BTG_ORDER_MAX], int k, double t) {
    double s = 1 - t;
    b[k] = t * b[k - 1];
    for (int i = k - 1; i > 0; i--)
        b[i] = s * b[i] + t * b[i - 1];
    b[0] *= s;
}

/* Bernstein polynomials of degree n at t and their first two derivatives, which are differences
 * of those of degrees n - 1 and n - 2. */
static inline void bernstein(int n, double t, double b[3][BTG_ORDER_MAX]) {
    double *q = b[0];
    q[0] = 1;
    for (int k = 1; k <= n - 2; k++)
        raise_degree(q, k, t);
    double f = (double)n * (n - 1);
    for (int i = 0; i <= n; i++) {
        double low = i <= n - 2 ? q[i] : 0, mid = i >= 1 && i <= n - 1 ? q[i - 1] : 0;
        b[2][i] = n < 2 ? 0 : f * (low - 2 * mid + (i >= 2 ? q[i - 2] : 0));
    }
    if (n >= 2) raise_degree(q, n - 1, t);
    for (int i = 0; i <= n; i++)
        b[1][i] = n * ((i >= 1 ? q[i - 1] : 0) - (i <= n - 1 ? q[i] : 0));
    raise_degree(q, n, t);
}

/* The homogeneous form and its derivatives: value, u, v, uu, uv, vv. Four numbers a point keep
 * the inner loops in vector registers. */
static inline void evaluate(const double *restrict net, int n, int m, double u, double v,
                            double out[restrict 6][4]) {
    double bu[3][BTG_ORDER_MAX], bv[3][BTG_ORDER_MAX];
    bernstein(n, u, bu);
    bernstein(m, v, bv);
    memset(out, 0, 6 * sizeof *out);
    for (int i = 0; i <= n; i++) {
        double r0[4] = {0}, r1[4] = {0}, r2[4] = {0};
        for (int j = 0; j <= m; j++) {
            const double *p = net + 4 * (i * (m + 1) + j);
            for (int c = 0; c < 4; c++)
                r0[c] += bv[0][j] * p[c];
            for (int c = 0; c < 4; c++)
                r1[c] += bv[1][j] * p[c];
            for (int c = 0; c < 4; c++)
                r2[c] += bv[2][j] * p[c];
        }
        for (int c = 0; c < 4; c++)
            out[0][c] += bu[0][i] * r0[c];
        for (int c = 0; c < 4; c++)
            out[1][c] += bu[1][i] * r0[c];
        for (int c = 0; c < 4; c++)
            out[2][c] += bu[0][i] * r1[c];
        for (int c = 0; c < 4; c++)
            out[3][c] += bu[2][i] * r0[c];
        for (int c = 0; c < 4; c++)
            out[4][c] += bu[1][i] * r1[c];
        for (int c = 0; c < 4; c++)
            out[5][c] += bu[0][i] * r2[c];
    }
}

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

void btg_patch_evaluate(const btg_patch *patch, double u, double v, btg_surface_point *point) {
    double h[6][4];
    if (patch->degree_u == 3 && patch->degree_v == 3)
        evaluate(patch->coefficients, 3, 3, u, v, h); /* known lengths unroll */
    else
        evaluate(patch->coefficients, patch->degree_u, patch->degree_v, u, v, h);
    if (patch->rational)
        quotient(h, point);
    else
        *point = (btg_surface_point){head(h[0]), head(h[1]), head(h[2]),
                                     head(h[3]), head(h[4]), head(h[5])};
}

btg_vec3 btg_patch_point(const btg_patch *patch, double u, double v) {
    int n = patch->degree_u, m = patch->degree_v;
    double bu[BTG_ORDER_MAX] = {1}, bv[BTG_ORDER_MAX] = {1}, sum[4] = {0};
    for (int k = 1; k <= n; k++)
        raise_degree(bu, k, u);
    for (int k = 1; k <= m; k++)
        raise_degree(bv, k, v);
    for (int i = 0; i <= n; i++)
        for (int j = 0; j <= m; j++) {
            const double *p = patch->coefficients + 4 * (i * (m + 1) + j);
            double b = bu[i] * bv[j];
            for (int c = 0; c < 4; c++)
                sum[c] += b * p[c];
        }
    return patch->rational ? vec_scale(head(sum), 1 / sum[3]) : head(sum);
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
    for (int k = 0; k < du; k++)
        factor *= n - k;
    for (int l = 0; l < dv; l++)
        factor *= m - l;
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
    static const double binomial[4][4] = {{1, 0, 0, 0}, {1, 1, 0, 0}, {1, 2, 1, 0}, {1, 3, 3, 1}};
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
    for (int k = 0; k < 4; k++)
        third[k] = fmax(third[k], s[3 - k][k]);
}
