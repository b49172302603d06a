/* B-spline and NURBS surfaces: checks, and cutting into Bezier patches by knot insertion
 * (W. Boehm, "Inserting new knots into B-spline curves", 1980). */
#include "core/surface.h"

#include <string.h>

/* ---- checks ------------------------------------------------------------------------------- */

static btg_status check_knots(const double *knots, int count, int degree, char side, size_t index,
                              btg_message *message) {
    int total = count + degree + 1, run = 1;
    for (int i = 0; i < total; i++) {
        if (!isfinite(knots[i]))
            return btg_fail(message, BTG_ERROR_ARGUMENT,
                            "surface %zu: knot %c[%d] is not finite; give a number", index, side,
                            i);
        if (i > 0 && knots[i] < knots[i - 1])
            return btg_fail(message, BTG_ERROR_ARGUMENT,
                            "surface %zu: knot %c[%d] is below the one before it; sort the knots",
                            index, side, i);
        run = i > 0 && knots[i] == knots[i - 1] ? run + 1 : 1;
        bool interior = knots[i] > knots[degree] && knots[i] < knots[count];
        if (interior && run > degree)
            return btg_fail(message, BTG_ERROR_ARGUMENT,
                            "surface %zu: knot %c[%d] repeats more than degree %d times, which "
                            "tears the surface; split it there",
                            index, side, i, degree);
    }
    if (!(knots[degree] < knots[count]))
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "surface %zu: the knots %c span nothing; the domain must have a length",
                        index, side);
    return BTG_OK;
}

static btg_status check_points(const btg_surface_def *def, size_t index, btg_message *message) {
    size_t count = (size_t)def->count_u * (size_t)def->count_v;
    for (size_t i = 0; i < 3 * count; i++)
        if (!(fabs(def->control_points[i]) <= BTG_LENGTH_MAX))
            return btg_fail(message, BTG_ERROR_ARGUMENT,
                            "surface %zu: control point %zu is not finite or beyond %g mm; "
                            "check the data and its unit",
                            index, i / 3, BTG_LENGTH_MAX);
    /* Weights spread further than this leave no digits in the sums. */
    for (size_t i = 0; def->weights && i < count; i++)
        if (!(def->weights[i] >= 1e-6 && def->weights[i] <= 1e6))
            return btg_fail(message, BTG_ERROR_ARGUMENT,
                            "surface %zu: weight %zu is not within 1e-6 .. 1e6; weights must be "
                            "positive",
                            index, i);
    return BTG_OK;
}

btg_status btg_surface_check(const btg_surface_def *def, size_t index, btg_message *message) {
    if (def->degree_u < 1 || def->degree_u > BTG_DEGREE_MAX || def->degree_v < 1 ||
        def->degree_v > BTG_DEGREE_MAX)
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "surface %zu: degrees %d x %d are not within 1 .. %d", index, def->degree_u,
                        def->degree_v, BTG_DEGREE_MAX);
    if (def->count_u <= def->degree_u || def->count_v <= def->degree_v || def->count_u > 1000000 ||
        def->count_v > 1000000)
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "surface %zu: %d x %d control points do not fit degrees %d x %d; at least "
                        "degree + 1 and at most 1000000 a side",
                        index, def->count_u, def->count_v, def->degree_u, def->degree_v);
    if (!def->control_points)
        return btg_fail(message, BTG_ERROR_ARGUMENT, "surface %zu: control_points is NULL", index);
    bool bezier = !def->knots_u && !def->knots_v;
    if (bezier && (def->count_u != def->degree_u + 1 || def->count_v != def->degree_v + 1))
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "surface %zu: without knots it is a Bezier patch, which takes degree + 1 "
                        "points a side, not %d x %d",
                        index, def->count_u, def->count_v);
    if (!bezier && (!def->knots_u || !def->knots_v))
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "surface %zu: knots in one direction only; give both or none", index);
    btg_status status = check_points(def, index, message);
    if (status || bezier) return status;
    status = check_knots(def->knots_u, def->count_u, def->degree_u, 'u', index, message);
    if (status) return status;
    return check_knots(def->knots_v, def->count_v, def->degree_v, 'v', index, message);
}

/* ---- spans -------------------------------------------------------------------------------- */

static const double unit_interval[2 * BTG_ORDER_MAX] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
                                                        1, 1, 1, 1, 1, 1, 1, 1, 1, 1};

/* A Bezier patch is a B-spline with these knots. */
static const double *knots_or_bezier(const double *knots, int degree) {
    return knots ? knots : unit_interval + BTG_ORDER_MAX - (degree + 1);
}

/* Next span from knot index i on: returns k with knots[k] < knots[k + 1], or count. */
static int next_span(const double *knots, int count, int i) {
    while (i < count && !(knots[i] < knots[i + 1]))
        i++;
    return i;
}

static size_t span_count(const double *knots, int count, int degree) {
    size_t n = 0;
    for (int k = next_span(knots, count, degree); k < count; k = next_span(knots, count, k + 1))
        n++;
    return n;
}

size_t btg_surface_patch_count(const btg_surface_def *def) {
    const double *ku = knots_or_bezier(def->knots_u, def->degree_u);
    const double *kv = knots_or_bezier(def->knots_v, def->degree_v);
    return span_count(ku, def->count_u, def->degree_u) *
           span_count(kv, def->count_v, def->degree_v);
}

/* The blossom of span k at `degree` arguments, the first degree - j of them a and the rest b:
 * point j of the Bezier form over [a, b] = the span. `line` holds degree + 1 points of 4. */
static void blossom(const double *knots, int k, int degree, int j, const double *line,
                    double out[4]) {
    double d[BTG_ORDER_MAX][4];
    memcpy(d, line, sizeof(double) * 4 * (size_t)(degree + 1));
    for (int r = 1; r <= degree; r++) {
        double t = r <= degree - j ? knots[k] : knots[k + 1];
        for (int i = degree; i >= r; i--) {
            double lo = knots[k - degree + i], hi = knots[k + 1 + i - r];
            double f = (t - lo) / (hi - lo);
            for (int c = 0; c < 4; c++)
                d[i][c] = (1 - f) * d[i - 1][c] + f * d[i][c];
        }
    }
    memcpy(out, d[degree], sizeof d[degree]);
}

/* One span's net: rows by the blossom in v, then columns in u. */
static void span_net(const btg_surface_def *def, const double *ku, const double *kv, int k, int l,
                     btg_net *net) {
    int n = def->degree_u, m = def->degree_v;
    double rows[BTG_ORDER_MAX][BTG_ORDER_MAX][4]; /* [v][u] */
    for (int i = 0; i <= n; i++) {
        double line[BTG_ORDER_MAX][4];
        for (int j = 0; j <= m; j++) {
            size_t index = (size_t)(k - n + i) * (size_t)def->count_v + (size_t)(l - m + j);
            double w = def->weights ? def->weights[index] : 1;
            for (int c = 0; c < 3; c++)
                line[j][c] = def->control_points[3 * index + (size_t)c] * w;
            line[j][3] = w;
        }
        for (int j = 0; j <= m; j++)
            blossom(kv, l, m, j, line[0], rows[j][i]);
    }
    net->degree_u = n;
    net->degree_v = m;
    for (int i = 0; i <= n; i++)
        for (int j = 0; j <= m; j++)
            blossom(ku, k, n, i, rows[j][0], net->point + 4 * (i * (m + 1) + j));
}

btg_status btg_surface_cut(const btg_surface_def *def, btg_net_sink sink, void *user) {
    const double *ku = knots_or_bezier(def->knots_u, def->degree_u);
    const double *kv = knots_or_bezier(def->knots_v, def->degree_v);
    btg_net net;
    for (int k = next_span(ku, def->count_u, def->degree_u); k < def->count_u;
         k = next_span(ku, def->count_u, k + 1))
        for (int l = next_span(kv, def->count_v, def->degree_v); l < def->count_v;
             l = next_span(kv, def->count_v, l + 1)) {
            span_net(def, ku, kv, k, l, &net);
            double domain_u[2] = {ku[k], ku[k + 1]}, domain_v[2] = {kv[l], kv[l + 1]};
            btg_status status = sink(&net, domain_u, domain_v, user);
            if (status) return status;
        }
    return BTG_OK;
}
