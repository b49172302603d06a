/* Surfaces cut into Bezier patches against de Boor's algorithm on the whole surface, in long
 * double; derivatives against differences of it. */
#include "check.h"
#include "core/part.h"

#include "../conformance/model.h"
#include "../conformance/rng.h"

#include <stdlib.h>
#include <string.h>

typedef long double real;
typedef struct point {
    real x[4]; /* w x, w y, w z, w */
} point;

/* De Boor: C. de Boor, "On calculating with B-splines", 1972. */
static point de_boor(const point *control, const double *knots, int degree, int count, real t) {
    int k = degree;
    while (k < count - 1 && t >= (real)knots[k + 1])
        k++;
    point d[10];
    for (int i = 0; i <= degree; i++)
        d[i] = control[k - degree + i];
    for (int r = 1; r <= degree; r++)
        for (int i = degree; i >= r; i--) {
            real low = knots[k - degree + i], high = knots[i + 1 + k - r];
            real a = high > low ? (t - low) / (high - low) : 0;
            for (int c = 0; c < 4; c++)
                d[i].x[c] = (1 - a) * d[i - 1].x[c] + a * d[i].x[c];
        }
    return d[degree];
}

static void whole_point(const btg_surface_def *s, real u, real v, real out[3]) {
    point column[64], row[64];
    double ku[128], kv[128];
    for (int i = 0; i < s->count_u + s->degree_u + 1; i++)
        ku[i] = s->knots_u ? s->knots_u[i] : i > s->degree_u;
    for (int i = 0; i < s->count_v + s->degree_v + 1; i++)
        kv[i] = s->knots_v ? s->knots_v[i] : i > s->degree_v;
    for (int i = 0; i < s->count_u; i++) {
        for (int j = 0; j < s->count_v; j++) {
            int at = i * s->count_v + j;
            real w = s->weights ? s->weights[at] : 1;
            for (int c = 0; c < 3; c++)
                row[j].x[c] = w * s->control_points[3 * at + c];
            row[j].x[3] = w;
        }
        column[i] = de_boor(row, kv, s->degree_v, s->count_v, v);
    }
    point p = de_boor(column, ku, s->degree_u, s->count_u, u);
    for (int c = 0; c < 3; c++)
        out[c] = p.x[c] / p.x[3];
}

/* Differences of the whole surface, in the patch's own parameters. */
static void difference(const btg_surface_def *s, const btg_patch *p, double u, double v, int nu,
                       int nv, real out[3]) {
    real h = nu + nv == 1 ? 1e-5L : 1e-4L, lu = (real)p->domain_u[1] - p->domain_u[0];
    real lv = (real)p->domain_v[1] - p->domain_v[0];
    const real weight[3][3] = {{0, 1, 0}, {-0.5L, 0, 0.5L}, {1, -2, 1}};
    for (int c = 0; c < 3; c++)
        out[c] = 0;
    for (int i = -1; i <= 1; i++)
        for (int j = -1; j <= 1; j++) {
            real k = weight[nu][i + 1] * weight[nv][j + 1], x[3];
            if (k == 0) continue;
            whole_point(s, p->domain_u[0] + lu * (u + i * h), p->domain_v[0] + lv * (v + j * h), x);
            for (int c = 0; c < 3; c++)
                out[c] += k * x[c];
        }
    for (int c = 0; c < 3; c++)
        out[c] /= nu + nv == 1 ? h : nu + nv == 2 ? h * h : 1;
}

static void compare(btg_vec3 got, const real want[3], double limit) {
    CHECK_NEAR(got.x, (double)want[0], limit);
    CHECK_NEAR(got.y, (double)want[1], limit);
    CHECK_NEAR(got.z, (double)want[2], limit);
}

static void check_patch(const btg_part *part, uint32_t item, const btg_surface_def *s, rng *r) {
    const btg_patch *p = &part->patches[item];
    /* inside, so that differences stay on one polynomial piece */
    double u = rng_range(r, 0.01, 0.99), v = rng_range(r, 0.01, 0.99);
    btg_surface_point got;
    CHECK(btg_part_evaluate(part, (btg_place){item, u, v}, &got) == BTG_OK);
    real want[3];
    difference(s, p, u, v, 0, 0, want);
    compare(got.s, want, 1e-12 * (1 + part->scale));
    compare(btg_patch_point(p, u, v), want, 1e-12 * (1 + part->scale));
    /* the differences' own error: h^2 f''' / 6 and rounding / h^2 */
    const double first = 2e-6, second = 2e-4;
    difference(s, p, u, v, 1, 0, want);
    compare(got.su, want, first * (1 + vec_norm(got.su) + 100));
    difference(s, p, u, v, 0, 1, want);
    compare(got.sv, want, first * (1 + vec_norm(got.sv) + 100));
    difference(s, p, u, v, 2, 0, want);
    compare(got.suu, want, second * (1 + vec_norm(got.suu) + 100));
    difference(s, p, u, v, 1, 1, want);
    compare(got.suv, want, second * (1 + vec_norm(got.suv) + 100));
    difference(s, p, u, v, 0, 2, want);
    compare(got.svv, want, second * (1 + vec_norm(got.svv) + 100));
}

/* The box holds the surface and is no larger than it, to 1e-6 of its size. */
static void check_box(const btg_part *part) {
    enum { N = 40 };
    btg_part_info info;
    btg_part_get_info(part, &info);
    btg_vec3 low = vec(INFINITY, INFINITY, INFINITY), high = vec_scale(low, -1);
    for (uint32_t item = 0; item < part->patch_count; item++)
        for (int i = 0; i <= N; i++)
            for (int j = 0; j <= N; j++) {
                btg_vec3 s = btg_patch_point(&part->patches[item], (double)i / N, (double)j / N);
                low = vec(fmin(low.x, s.x), fmin(low.y, s.y), fmin(low.z, s.z));
                high = vec(fmax(high.x, s.x), fmax(high.y, s.y), fmax(high.z, s.z));
            }
    double slack = 2e-6 * part->scale, sampling = 5e-3 * part->scale;
    const double got[6] = {info.box_min.x,  info.box_min.y,  info.box_min.z,
                           -info.box_max.x, -info.box_max.y, -info.box_max.z};
    const double sampled[6] = {low.x, low.y, low.z, -high.x, -high.y, -high.z};
    for (int i = 0; i < 6; i++) {
        CHECK(got[i] <= sampled[i] + slack);
        CHECK(got[i] >= sampled[i] - sampling);
    }
}

static void knots(double *k, rng *r, int degree, int count) {
    double at = rng_range(r, -5, 5);
    int repeats = 0;
    for (int i = degree; i <= count; i++) {
        bool again = i > degree && i < count && repeats + 1 < degree && rng_pick(r, 3) == 0;
        repeats = again ? repeats + 1 : 0;
        if (i > degree && (!again || i == degree + 1)) at += exp(rng_range(r, -3, 3));
        k[i] = at;
    }
    for (int i = 0; i < degree; i++)
        k[i] = k[degree], k[count + 1 + i] = k[count];
}

static void check_surface(rng *r, int n, int m, bool spline, bool rational) {
    model part_model = {0};
    int cu = n + 1, cv = m + 1;
    model_surface s;
    if (spline) {
        cu += rng_pick(r, 6);
        cv += rng_pick(r, 6);
        s = model_spline(&part_model, n, m, cu, cv, rational);
        knots(s.knots_u, r, n, cu);
        knots(s.knots_v, r, m, cv);
    } else {
        s = model_bezier(&part_model, n, m, rational);
    }
    for (int i = 0; i < 3 * cu * cv; i++)
        s.points[i] = rng_range(r, -100, 100);
    for (int i = 0; rational && i < cu * cv; i++)
        s.weights[i] = exp(rng_range(r, -1, 1));
    btg_part *part = model_part(&part_model);
    for (int i = 0; i < 12; i++)
        check_patch(part, (uint32_t)rng_pick(r, (int)part->patch_count), &part_model.surface[0], r);
    if (n < 4 && m < 4) check_box(part);
    btg_part_destroy(part);
    model_free(&part_model);
}

static void check_corners(void) {
    model m = {0};
    model_quad(&m, vec(0, 0, 0), vec(0, 1, 5), vec(1, 0, 7), vec(1, 1, 9));
    btg_part *part = model_part(&m);
    btg_surface_point s;
    CHECK(btg_part_evaluate(part, (btg_place){0, 0, 1}, &s) == BTG_OK && s.s.z == 5);
    CHECK(btg_part_evaluate(part, (btg_place){0, 1, 0}, &s) == BTG_OK && s.s.z == 7);
    CHECK(btg_part_evaluate(part, (btg_place){0, 1, 1}, &s) == BTG_OK && s.s.z == 9);
    CHECK(btg_part_evaluate(part, (btg_place){1, 0, 0}, &s) == BTG_ERROR_ARGUMENT);
    CHECK(btg_part_evaluate(part, (btg_place){0, 1.1, 0}, &s) == BTG_ERROR_ARGUMENT);
    CHECK(btg_part_evaluate(part, (btg_place){0, 0, NAN}, &s) == BTG_ERROR_ARGUMENT);
    btg_part_destroy(part);
    model_free(&m);
}

int main(void) {
    rng r = {11};
    for (int n = 1; n <= BTG_DEGREE_MAX; n++)
        for (int m = 1; m <= BTG_DEGREE_MAX; m++)
            for (int kind = 0; kind < 4; kind++)
                check_surface(&r, n, m, kind & 1, kind & 2);
    check_corners();
    return check_result();
}
