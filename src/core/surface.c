/* Bezier nets: points, power forms, subdivision, and bounds of third derivatives.
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

static btg_vec3 head(const double h[4]) {
    return vec(h[0], h[1], h[2]);
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

/* ---- power form --------------------------------------------------------------------------- */

static double binomial_of(int n, int k) {
    double c = 1;
    for (int i = 0; i < k; i++)
        c = c * (n - i) / (i + 1);
    return k < 0 || k > n ? 0 : c;
}

/* From a Bezier form of degree n to the polynomial about 1/2: coefficient k = sum over i of
 * to[k][i] b_i. Exact: small integers over powers of two. */
static void power_matrix(int n, double to[BTG_ORDER_MAX][BTG_ORDER_MAX]) {
    for (int k = 0; k <= n; k++)
        for (int i = 0; i <= n; i++) {
            double sum = 0;
            for (int r = 0; r <= k; r++) {
                double term = binomial_of(k, r) * binomial_of(n - k, i - r);
                sum += (k - r) % 2 ? -term : term;
            }
            to[k][i] = ldexp(binomial_of(n, k) * sum, k - n);
        }
}

double btg_net_power(const btg_net *net, btg_vec3 origin, double *power) {
    int n = net->degree_u, m = net->degree_v;
    double to_u[BTG_ORDER_MAX][BTG_ORDER_MAX], to_v[BTG_ORDER_MAX][BTG_ORDER_MAX];
    double part[BTG_NET_MAX], size[4] = {0}, w_min = INFINITY;
    power_matrix(n, to_u);
    power_matrix(m, to_v);
    const double shift[4] = {origin.x, origin.y, origin.z, 0};
    for (int i = 0; i <= n; i++)
        for (int l = 0; l <= m; l++)
            for (int c = 0; c < 4; c++) {
                double sum = 0;
                for (int j = 0; j <= m; j++) {
                    const double *p = net->point + 4 * (i * (m + 1) + j);
                    sum += to_v[l][j] * (p[c] - p[3] * shift[c]);
                    w_min = fmin(w_min, p[3]);
                }
                part[4 * (i * (m + 1) + l) + c] = sum;
            }
    for (int k = 0; k <= n; k++)
        for (int l = 0; l <= m; l++)
            for (int c = 0; c < 4; c++) {
                double sum = 0;
                for (int i = 0; i <= n; i++)
                    sum += to_u[k][i] * part[4 * (i * (m + 1) + l) + c];
                power[4 * (k * (m + 1) + l) + c] = sum;
                size[c] += ldexp(fabs(sum), -k - l);
            }
    /* Horner's scheme rounds n + m times, each at most the size of the terms. */
    double reach = (size[0] + size[1] + size[2]) / w_min, far = vec_norm(origin);
    return 0x1p-52 * ((n + m + 8) * reach * (1 + size[3] / w_min) + 2 * (far + reach));
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

void btg_net_third(const btg_net *net, double third[4]) {
    const double *p = net_point(net, net->degree_u / 2, net->degree_v / 2);
    net_bounds bounds;
    double s[4][4];
    measure(net, vec(p[0] / p[3], p[1] / p[3], p[2] / p[3]), 3, &bounds);
    quotient_bounds(&bounds, 3, s);
    for (int k = 0; k < 4; k++)
        third[k] = fmax(third[k], s[3 - k][k]);
}
