/* dst: drop, spin and tilt by Newton's method: S. K. Sharma, R. K. Duvedi, S. Bedi, S. Mann,
 * "Numerical implementation of drop spin and tilt method for five-axis tool positioning for tensor
 * product surfaces", 2021, appendix A. Equations 2 (drop: u, v, h) and 6, 7 (tilt: u, v, beta, phi)
 * as they stand there; its derivatives of equation 7 are misprinted (the product rule's second
 * factors) and are the true ones here. The spin is closed form, as in core/position.c.
 *
 * The paper leaves its tolerances open; ours are below. Where no seed leads to a second contact the
 * paper says that both contacts are at one place: then the tilt is the osculating limit at P in
 * closed form (core/ray.c), unless the gouge grid objects. */
#include "core/spin.h"
#include "methods/internal.h"

/* Richardson's extrapolation, as the paper has it: first step, and the error it ends at. */
#define STEP_FIRST 1e-3
#define STEP_ERROR 1e-5
#define STEP_TIMES 8

/* Iterations of one seed, seeds of one drop and one tilt. */
#define ITERATIONS 40
#define DROP_SEEDS 200
#define TILT_SEEDS 200
/* The equations hold when they are off by that, mm. */
#define CONVERGED_MM 1e-9
/* Parameters that far outside the patch: the seed is lost. */
#define ASTRAY 0.5
/* Checks: how near to P, in parameters, is P; how deep a point of the gouge grid may be, mm. */
#define VICINITY 1e-4
#define GOUGE_MM 1e-6
/* Seeds of `direct`: that much wider than the tool's shadow. */
#define SHADOW 1.2

#define UNKNOWNS 4

struct btg_newton {
    btg_backend_setup setup;
    const btg_method_context *context;
    btg_under *under;
    bool exact;
    uint64_t random;
    double ro, ri;
    btg_part_info info;
    bool has_last; /* the tilt before this one found its second contact: */
    uint32_t last_item;
    double last[UNKNOWNS];
};

btg_status btg_newton_create(const btg_backend_setup *setup, const char *name, bool exact,
                             void **newton, btg_message *message) {
    btg_under *under;
    btg_status status = btg_under_create(setup, name, exact, &under, message);
    if (status != BTG_OK) return status;
    btg_newton *n = btg_allocate(&setup->allocator, 1, sizeof *n);
    if (!n) {
        btg_under_destroy(under);
        return btg_fail(message, BTG_ERROR_MEMORY, "method %s: out of memory", name);
    }
    *n = (btg_newton){.setup = *setup, .under = under, .exact = exact};
    n->context = btg_method_context_of(setup);
    n->random = n->context->def->seed;
    n->ro = setup->tool.element[0].ring_radius_mm;
    n->ri = setup->tool.element[0].corner_radius_mm;
    btg_part_get_info(setup->part, &n->info);
    *newton = n;
    return BTG_OK;
}

void btg_newton_destroy(void *newton) {
    btg_newton *n = newton;
    btg_allocator allocator = n->setup.allocator;
    btg_under_destroy(n->under);
    btg_release(&allocator, n);
}

/* 0 .. 1 (splitmix64: G. Steele, D. Lea, C. Flood, 2014). */
static double random_unit(btg_newton *n) {
    uint64_t x = n->random += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return (double)((x ^ (x >> 31)) >> 11) * 0x1p-53;
}

/* ---- derivatives -------------------------------------------------------------------------- */

/* A function of the two parameters with up to 6 values. */
typedef void (*place_function)(const void *context, double u, double v, double *out);

static void difference(place_function f, const void *context, double u, double v, bool along_u,
                       double step, int size, double *out) {
    double low[6];
    double du = along_u ? step : 0, dv = along_u ? 0 : step;
    f(context, u + du, v + dv, out);
    f(context, u - du, v - dv, low);
    for (int i = 0; i < size; i++)
        out[i] = (out[i] - low[i]) / (2 * step);
}

/* Central differences, the step halved, until two in a row are near; the limit of both. */
static void richardson(place_function f, const void *context, double u, double v, bool along_u,
                       int size, double *out) {
    double wide[6], narrow[6], step = STEP_FIRST;
    difference(f, context, u, v, along_u, step, size, wide);
    for (int k = 0; k < STEP_TIMES; k++) {
        double change = 0;
        step *= 0.5;
        difference(f, context, u, v, along_u, step, size, narrow);
        for (int i = 0; i < size; i++) {
            change = fmax(change, fabs(narrow[i] - wide[i]));
            out[i] = narrow[i] + (narrow[i] - wide[i]) / 3;
            wide[i] = narrow[i];
        }
        if (change < 3 * STEP_ERROR) return;
    }
}

typedef struct sheet {
    const btg_newton *newton;
    const btg_patch *patch;
    btg_vec3 up;     /* normals point to this side: where the tool comes from */
    btg_vec3 origin; /* on the tool's axis, for the drop */
} sheet;

static void put(double *out, btg_vec3 a) {
    out[0] = a.x;
    out[1] = a.y;
    out[2] = a.z;
}

static btg_vec3 get(const double *in) {
    return vec(in[0], in[1], in[2]);
}

static void point_alone(const void *context, double u, double v, double *out) {
    const sheet *s = context;
    put(out, btg_patch_point(s->patch, u, v));
}

static btg_vec3 normal_at(const sheet *s, double u, double v) {
    btg_vec3 su, sv;
    if (s->newton->exact) {
        btg_surface_point p;
        btg_patch_evaluate(s->patch, u, v, &p);
        su = p.su;
        sv = p.sv;
    } else {
        double a[3], b[3];
        richardson(point_alone, s, u, v, true, 3, a);
        richardson(point_alone, s, u, v, false, 3, b);
        su = get(a);
        sv = get(b);
    }
    btg_vec3 n = vec_unit(vec_cross(su, sv));
    return vec_dot(n, s->up) < 0 ? vec_scale(n, -1) : n;
}

/* Point and normal side by side. */
static void point_and_normal(const void *context, double u, double v, double *out) {
    put(out, btg_patch_point(((const sheet *)context)->patch, u, v));
    put(out + 3, normal_at(context, u, v));
}

/* ---- Newton's method ---------------------------------------------------------------------- */

/* Solves J x = r by elimination with pivots; false: singular. */
static bool eliminate(int size, double j[UNKNOWNS][UNKNOWNS], double r[UNKNOWNS]) {
    for (int k = 0; k < size; k++) {
        int p = k;
        for (int i = k + 1; i < size; i++)
            if (fabs(j[i][k]) > fabs(j[p][k])) p = i;
        if (!(fabs(j[p][k]) > 0)) return false;
        for (int c = 0; c < size; c++) {
            double t = j[k][c];
            j[k][c] = j[p][c];
            j[p][c] = t;
        }
        double t = r[k];
        r[k] = r[p];
        r[p] = t;
        for (int i = k + 1; i < size; i++) {
            double f = j[i][k] / j[k][k];
            for (int c = k; c < size; c++)
                j[i][c] -= f * j[k][c];
            r[i] -= f * r[k];
        }
    }
    for (int k = size - 1; k >= 0; k--) {
        for (int c = k + 1; c < size; c++)
            r[k] -= j[k][c] * r[c];
        r[k] /= j[k][k];
    }
    return true;
}

/* The equations at x and their derivatives. */
typedef void (*equations)(const sheet *s, const void *query, const double *x, double *residual,
                          double j[UNKNOWNS][UNKNOWNS]);

static bool astray(double t) {
    return !(t >= -ASTRAY && t <= 1 + ASTRAY);
}

/* From a seed; x[0], x[1] are u, v. Counts its iterations. */
static bool iterate(const sheet *s, equations f, const void *query, int size, double *x,
                    uint64_t *iterations) {
    for (int k = 0; k < ITERATIONS; k++) {
        double r[UNKNOWNS], j[UNKNOWNS][UNKNOWNS], off = 0;
        f(s, query, x, r, j);
        for (int i = 0; i < size; i++)
            off += r[i] * r[i];
        if (off < CONVERGED_MM * CONVERGED_MM)
            return x[0] >= 0 && x[0] <= 1 && x[1] >= 0 && x[1] <= 1;
        ++*iterations;
        if (!isfinite(off) || !eliminate(size, j, r)) return false;
        for (int i = 0; i < size; i++)
            x[i] -= r[i];
        if (astray(x[0]) || astray(x[1])) return false;
    }
    return false;
}

/* What one drop or tilt took. */
typedef struct effort {
    uint64_t seeds, iterations, last;
} effort;

static bool solve(const sheet *s, equations f, const void *query, int size, double *x, effort *e) {
    e->seeds++;
    e->last = 0;
    bool converged = iterate(s, f, query, size, x, &e->last);
    e->iterations += e->last;
    return converged;
}

/* ---- drop --------------------------------------------------------------------------------- */

/* Equation 2's left side: S + Ri n + Ro nr, nr level, from the insert's centre to the axis. On the
 * outer side of the insert n points toward the axis and nr is n made level (equation 3); on the
 * inner side it points away, and nr comes from P itself (equation 8). */
static void offset_point(const void *context, double u, double v, double *out) {
    const sheet *s = context;
    btg_vec3 p = btg_patch_point(s->patch, u, v), n = normal_at(s, u, v);
    btg_vec3 level = vec_mad(n, s->up, -vec_dot(n, s->up));
    btg_vec3 in = vec_sub(s->origin, p);
    in = vec_mad(in, s->up, -vec_dot(in, s->up));
    btg_vec3 radial = vec_dot(level, in) > 0 ? level : in;
    btg_vec3 o = vec_mad(p, n, s->newton->ri);
    put(out, vec_mad(o, vec_unit(radial), s->newton->ro));
}

static void drop_equations(const sheet *s, const void *query, const double *x, double *residual,
                           double j[UNKNOWNS][UNKNOWNS]) {
    const btg_drop_query *q = query;
    double f[3], fu[3], fv[3], axis[3], t[3];
    offset_point(s, x[0], x[1], f);
    richardson(offset_point, s, x[0], x[1], true, 3, fu);
    richardson(offset_point, s, x[0], x[1], false, 3, fv);
    put(axis, q->axis);
    put(t, q->origin);
    for (int i = 0; i < 3; i++) {
        residual[i] = f[i] - t[i] - x[2] * axis[i];
        j[i][0] = fu[i];
        j[i][1] = fv[i];
        j[i][2] = -axis[i];
    }
}

/* u and v of a seed: anywhere; for `direct` under the tool's shadow, where the linear map says. */
static uint32_t seed_place(btg_newton *n, btg_vec3 foot, double *x) {
    double a = random_unit(n), b = random_unit(n);
    uint32_t item = (uint32_t)(random_unit(n) * n->setup.part->patch_count);
    x[0] = a;
    x[1] = b;
    if (!n->exact) return item;
    double reach = SHADOW * (n->ro + n->ri), height;
    btg_place near = {.item = UINT32_MAX};
    btg_vec3 at = vec(foot.x + (2 * a - 1) * reach, foot.y + (2 * b - 1) * reach, 0);
    at.x = fmin(fmax(at.x, n->info.box_min.x), n->info.box_max.x);
    at.y = fmin(fmax(at.y, n->info.box_min.y), n->info.box_max.y);
    if (!btg_under_find(n->under, vec(0, 0, 1), at, &near, &height)) return item;
    x[0] = near.u;
    x[1] = near.v;
    return near.item;
}

static bool drop_once(btg_newton *n, const btg_drop_query *q, btg_drop_result *r, effort *e) {
    const btg_part_info *info = &n->info;
    double x[UNKNOWNS];
    sheet s = {.newton = n, .up = q->axis, .origin = q->origin};
    uint32_t item = seed_place(n, q->origin, x);
    x[2] = info->box_min.z + random_unit(n) * (info->box_max.z - info->box_min.z);
    s.patch = &n->setup.part->patches[item];
    if (!solve(&s, drop_equations, q, 3, x, e)) return false;
    btg_vec3 centre = vec_mad(q->origin, q->axis, x[2]);
    btg_tool_grid grid = btg_tool_grid_place(&n->setup.tool, centre, q->axis);
    if (!btg_under_clear(n->under, &grid, GOUGE_MM)) {
        n->context->counts->gouged++;
        return false;
    }
    *r = (btg_drop_result){.status = BTG_OK, .height_mm = x[2], .bound_mm = NAN};
    r->contact.place = (btg_place){item, x[0], x[1]};
    r->contact.point = btg_patch_point(s.patch, x[0], x[1]);
    r->contact.normal = normal_at(&s, x[0], x[1]);
    return true;
}

btg_status btg_newton_drop(void *newton, const btg_drop_query *queries, size_t count,
                           btg_drop_result *results) {
    btg_newton *n = newton;
    btg_method_counts *c = n->context->counts;
    for (size_t i = 0; i < count; i++) {
        btg_drop_result r = {.status = BTG_NO_CONTACT, .bound_mm = NAN};
        effort e = {0};
        bool found = false;
        while (!found && e.seeds < DROP_SEEDS)
            found = drop_once(n, &queries[i], &r, &e);
        r.nodes = (uint32_t)e.seeds;
        c->drops++;
        results[i] = r;
        if (!found) {
            c->drops_given_up++;
            continue;
        }
        c->drop_seeds += e.seeds;
        c->drop_iterations += e.iterations;
        c->drop_last_iterations += e.last;
    }
    return BTG_OK;
}

/* ---- tilt --------------------------------------------------------------------------------- */

/* Equation 6: S + Ri n is a point of the tilted major circle, O1 + Ro (1 + sin phi) v + Ro cos phi
 * u, where v is the arm after the turn by beta. Equation 7: the normal's line meets the axis. */
static void tilt_equations(const sheet *s, const void *query, const double *x, double *residual,
                           double j[UNKNOWNS][UNKNOWNS]) {
    const btg_tilt_query *q = query;
    double f[6], fu[6], fv[6], ro = s->newton->ro, ri = s->newton->ri;
    point_and_normal(s, x[0], x[1], f);
    richardson(point_and_normal, s, x[0], x[1], true, 6, fu);
    richardson(point_and_normal, s, x[0], x[1], false, 6, fv);
    double cb = cos(x[2]), sb = sin(x[2]), cp = cos(x[3]), sp = sin(x[3]);
    btg_vec3 v = vec_sub(vec_scale(q->v, cb), vec_scale(q->w, sb));
    btg_vec3 w = vec_add(vec_scale(q->w, cb), vec_scale(q->v, sb)); /* dv = -w, dw = v */
    btg_vec3 circle = vec_mad(vec_mad(q->o1, v, ro * (1 + sp)), q->u, ro * cp);
    btg_vec3 centre = vec_mad(q->o1, v, ro);
    btg_vec3 point = get(f), n = get(f + 3), to = vec_sub(centre, point), wn = vec_cross(w, n);
    put(residual, vec_sub(vec_mad(point, n, ri), circle));
    residual[3] = vec_dot(wn, to);
    double column[UNKNOWNS][3];
    put(column[0], vec_mad(get(fu), get(fu + 3), ri));
    put(column[1], vec_mad(get(fv), get(fv + 3), ri));
    put(column[2], vec_scale(w, ro * (1 + sp)));
    put(column[3], vec_sub(vec_scale(q->u, ro * sp), vec_scale(v, ro * cp)));
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < UNKNOWNS; k++)
            j[i][k] = column[k][i];
    j[3][0] = vec_dot(vec_cross(w, get(fu + 3)), to) - vec_dot(wn, get(fu));
    j[3][1] = vec_dot(vec_cross(w, get(fv + 3)), to) - vec_dot(wn, get(fv));
    j[3][2] = vec_dot(vec_cross(v, n), to) - ro * vec_dot(wn, w);
    j[3][3] = 0;
}

/* The paper's three checks of a solution. */
static bool accept(btg_newton *n, const btg_tilt_query *q, uint32_t item, const double *x) {
    btg_method_counts *c = n->context->counts;
    btg_place p = q->p.place;
    if (item == p.item && fabs(x[0] - p.u) < VICINITY && fabs(x[1] - p.v) < VICINITY) {
        c->near_p++;
        return false;
    }
    btg_vec3 centre, axis;
    btg_position_pose(&n->setup.tool, q, x[2], &centre, &axis);
    if (!(x[2] >= 0 && x[2] <= q->max_tilt_rad && vec_dot(axis, q->p.normal) > 0)) {
        c->axis_down++;
        return false;
    }
    btg_tool_grid grid = btg_tool_grid_place(&n->setup.tool, centre, axis);
    if (btg_under_clear(n->under, &grid, GOUGE_MM)) return true;
    c->gouged++;
    return false;
}

static bool tilt_once(btg_newton *n, const btg_tilt_query *q, bool follow, btg_tilt_result *r,
                      effort *e) {
    double x[UNKNOWNS];
    uint32_t item = n->last_item;
    sheet s = {.newton = n, .up = q->p.normal};
    for (int i = 0; i < UNKNOWNS; i++)
        x[i] = n->last[i];
    if (!follow) {
        item = seed_place(n, vec_mad(q->o1, q->v, n->ro), x);
        x[2] = random_unit(n) * q->max_tilt_rad;
        x[3] = random_unit(n) * 2 * BTG_PI;
    }
    s.patch = &n->setup.part->patches[item];
    if (!solve(&s, tilt_equations, q, 4, x, e)) return false;
    x[2] = remainder(x[2], 2 * BTG_PI);
    if (!accept(n, q, item, x)) return false;
    if (follow) n->context->counts->followed++;
    n->has_last = true;
    n->last_item = item;
    for (int i = 0; i < UNKNOWNS; i++)
        n->last[i] = x[i];
    *r = (btg_tilt_result){.status = BTG_OK, .tilt_rad = x[2], .bound_mm = NAN};
    r->contact.place = (btg_place){item, x[0], x[1]};
    r->contact.point = btg_patch_point(s.patch, x[0], x[1]);
    r->contact.normal = normal_at(&s, x[0], x[1]);
    return true;
}

/* Both contacts at one place; ERROR_GOUGE: that is not so, the search failed. */
static btg_tilt_result merged(btg_newton *n, const btg_tilt_query *q) {
    btg_tilt_result r = {.status = BTG_OSCULATING, .bound_mm = NAN, .contact = q->p};
    btg_ray_query ray = btg_ray_query_tilt(&n->setup.tool, q);
    btg_surface_point f;
    double value = 0;
    btg_patch_evaluate(&n->setup.part->patches[q->p.place.item], q->p.place.u, q->p.place.v, &f);
    bool limit = btg_ray_osculating(&ray, &f, false, false, &value);
    r.tilt_rad = -value;
    if (limit && r.tilt_rad >= 0 && r.tilt_rad <= q->max_tilt_rad) {
        btg_vec3 centre, axis;
        btg_position_pose(&n->setup.tool, q, r.tilt_rad, &centre, &axis);
        btg_tool_grid grid = btg_tool_grid_place(&n->setup.tool, centre, axis);
        if (btg_under_clear(n->under, &grid, GOUGE_MM)) return r;
    }
    return (btg_tilt_result){.status = BTG_ERROR_GOUGE};
}

btg_status btg_newton_tilt(void *newton, const btg_tilt_query *queries, size_t count,
                           btg_tilt_result *results) {
    btg_newton *n = newton;
    btg_method_counts *c = n->context->counts;
    for (size_t i = 0; i < count; i++) {
        btg_tilt_result r = {.status = BTG_ERROR_GOUGE};
        effort e = {0};
        bool found = n->has_last && tilt_once(n, &queries[i], true, &r, &e);
        while (!found && e.seeds < TILT_SEEDS)
            found = tilt_once(n, &queries[i], false, &r, &e);
        c->tilts++;
        if (found) {
            c->tilt_seeds += e.seeds;
            c->tilt_iterations += e.iterations;
            c->tilt_last_iterations += e.last;
        } else {
            c->tilts_given_up++;
            r = merged(n, &queries[i]);
        }
        r.nodes = (uint32_t)e.seeds;
        results[i] = r;
    }
    return BTG_OK;
}

/* ---- the method --------------------------------------------------------------------------- */

static btg_status open(const btg_backend_setup *setup, void **state, btg_message *message) {
    return btg_newton_create(setup, "dst", false, state, message);
}

const btg_backend_table btg_method_dst = {
    .name = "dst",
    .summary = "drop, spin and tilt by Newton's method from random seeds",
    .open = open,
    .close = btg_newton_destroy,
    .drop = btg_newton_drop,
    .tilt = btg_newton_tilt};
