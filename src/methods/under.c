/* The part under a point, and the gouge check by a grid on the tool.
 *
 * S. K. Sharma, R. K. Duvedi, S. Bedi, S. Mann, "Numerical implementation of drop spin and tilt
 * method for five-axis tool positioning for tensor product surfaces", 2021, appendix A.3: where
 * x and y are linear in u and v, a point of the tool maps to the part's at once. Elsewhere
 * Newton's method finds it, from where it was for the point before. */
#include "methods/internal.h"

/* The papers' gouge grid. */
#define AROUND 48
#define ACROSS 36
/* Samples along a side of a patch, to begin from where nothing is near. */
#define SAMPLES 12
/* Patches tried for one point. */
#define PATCHES_TRIED 3
#define ITERATIONS    20
/* Newton's end, and how far outside its domain a patch still counts, in parameters. */
#define STEP_END 1e-13
#define OUTSIDE  1e-9
/* Normals are sampled; between the samples they may lean that much more, rad. */
#define STEEPER 0.05
/* Control points may be off the linear map by that part of the part's size. */
#define LINEAR 1e-9

/* x and y of a patch that is linear: origin + u a + v b, and the inverse. */
typedef struct linear_map {
    double origin[2], inverse[2][2];
} linear_map;

struct btg_under {
    btg_backend_setup setup;
    linear_map *maps;  /* NULL: not linear */
    btg_vec3 *samples; /* SAMPLES^2 a patch */
    double steepest;   /* angle of the part's normals to z at the most, rad */
};

/* ---- what can be asked -------------------------------------------------------------------- */

static bool map_of(const btg_patch *p, double scale, linear_map *map) {
    int n = p->degree_u, m = p->degree_v;
    const double *c = p->coefficients, *cu = c + 4 * n * (m + 1), *cv = c + 4 * m;
    if (p->rational) return false;
    double a[2] = {cu[0] - c[0], cu[1] - c[1]}, b[2] = {cv[0] - c[0], cv[1] - c[1]};
    for (int i = 0; i <= n; i++)
        for (int j = 0; j <= m; j++)
            for (int k = 0; k < 2; k++) {
                double want = c[k] + a[k] * i / n + b[k] * j / m;
                if (fabs(c[4 * (i * (m + 1) + j) + k] - want) > LINEAR * scale) return false;
            }
    double det = a[0] * b[1] - a[1] * b[0];
    if (fabs(det) < LINEAR * scale * LINEAR * scale) return false;
    *map = (linear_map){{c[0], c[1]}, {{b[1] / det, -b[0] / det}, {-a[1] / det, a[0] / det}}};
    return true;
}

static bool make_maps(btg_under *u) {
    const btg_part *part = u->setup.part;
    for (uint32_t i = 0; i < part->patch_count; i++)
        if (!map_of(&part->patches[i], part->scale, &u->maps[i])) return false;
    return true;
}

static void make_samples(btg_under *u) {
    const btg_part *part = u->setup.part;
    for (uint32_t i = 0; i < part->patch_count; i++)
        for (int k = 0; k < SAMPLES * SAMPLES; k++)
            u->samples[i * SAMPLES * SAMPLES + (uint32_t)k] = btg_patch_point(
                &part->patches[i], (k / SAMPLES + 0.5) / SAMPLES, (k % SAMPLES + 0.5) / SAMPLES);
}

static void find_steepest(btg_under *u) {
    const btg_part *part = u->setup.part;
    for (uint32_t i = 0; i < part->patch_count; i++)
        for (int k = 0; k < (SAMPLES + 1) * (SAMPLES + 1); k++) {
            btg_surface_point f;
            btg_patch_evaluate(&part->patches[i], (double)(k / (SAMPLES + 1)) / SAMPLES,
                               (double)(k % (SAMPLES + 1)) / SAMPLES, &f);
            btg_vec3 n = vec_cross(f.su, f.sv);
            u->steepest = fmax(u->steepest, atan2(norm2(n.x, n.y), fabs(n.z)));
        }
    u->steepest += STEEPER;
}

static btg_status check(const btg_backend_setup *setup, const char *name, btg_message *message) {
    if (setup->part->triangle_count > 0)
        return btg_fail(message, BTG_ERROR_UNSUPPORTED,
                        "method %s needs exact surfaces, this part has triangles; take vcrf, "
                        "vcrf-grid, depth or sr",
                        name);
    if (!setup->tool.element[0].hollow || setup->tool.element_count > 1)
        return btg_fail(message, BTG_ERROR_UNSUPPORTED,
                        "method %s knows a torus alone; leave shank and holder out and give "
                        "--tool RO,RI,toroidal, or take vcrf",
                        name);
    return BTG_OK;
}

btg_status btg_under_create(const btg_backend_setup *setup, const char *name, bool linear,
                            btg_under **under, btg_message *message) {
    btg_status status = check(setup, name, message);
    if (status != BTG_OK) return status;
    const btg_allocator *a = &setup->allocator;
    size_t patches = setup->part->patch_count;
    btg_under *u = btg_allocate(a, 1, sizeof *u);
    if (!u) return btg_fail(message, BTG_ERROR_MEMORY, "method %s: out of memory", name);
    *u = (btg_under){.setup = *setup};
    u->maps = btg_allocate(a, patches, sizeof *u->maps);
    u->samples = btg_allocate(a, patches, SAMPLES * SAMPLES * sizeof *u->samples);
    if (!u->maps || !u->samples) {
        btg_under_destroy(u);
        return btg_fail(message, BTG_ERROR_MEMORY, "method %s: out of memory", name);
    }
    if (!make_maps(u)) {
        btg_release(a, u->maps);
        u->maps = NULL;
    }
    if (linear && !u->maps) {
        btg_under_destroy(u);
        return btg_fail(message, BTG_ERROR_UNSUPPORTED,
                        "method %s needs a part whose x and y are linear in u and v, as of a "
                        "Bezier patch over an even net; take vcrf, depth, drd or sr",
                        name);
    }
    make_samples(u);
    find_steepest(u);
    *under = u;
    return BTG_OK;
}

void btg_under_destroy(btg_under *under) {
    if (!under) return;
    btg_allocator a = under->setup.allocator;
    btg_release(&a, under->maps);
    btg_release(&a, under->samples);
    btg_release(&a, under);
}

/* ---- one line ----------------------------------------------------------------------------- */

static bool in_domain(btg_place *p) {
    if (!(p->u >= -OUTSIDE && p->u <= 1 + OUTSIDE && p->v >= -OUTSIDE && p->v <= 1 + OUTSIDE))
        return false;
    p->u = fmin(fmax(p->u, 0), 1);
    p->v = fmin(fmax(p->v, 0), 1);
    return true;
}

/* Along z, x and y linear: no iteration. */
static bool find_linear(const btg_under *u, btg_vec3 point, btg_place *near, double *height) {
    const btg_part *part = u->setup.part;
    uint32_t first = near->item < part->patch_count ? near->item : 0;
    for (uint32_t k = 0; k < part->patch_count; k++) {
        uint32_t item = (first + k) % part->patch_count;
        const linear_map *m = &u->maps[item];
        double x = point.x - m->origin[0], y = point.y - m->origin[1];
        btg_place at = {item, m->inverse[0][0] * x + m->inverse[0][1] * y,
                        m->inverse[1][0] * x + m->inverse[1][1] * y};
        if (!in_domain(&at)) continue;
        *near = at;
        *height = btg_patch_point(&part->patches[item], at.u, at.v).z - point.z;
        return true;
    }
    return false;
}

/* From a place to the point of its patch on the line through `point` along the axis. */
static bool descend(const btg_under *u, btg_vec3 axis, btg_vec3 a, btg_vec3 b, btg_vec3 point,
                    btg_place *at, double *height) {
    const btg_patch *patch = &u->setup.part->patches[at->item];
    for (int k = 0; k < ITERATIONS; k++) {
        btg_surface_point f;
        btg_patch_evaluate(patch, at->u, at->v, &f);
        btg_vec3 d = vec_sub(f.s, point);
        double ra = vec_dot(d, a), rb = vec_dot(d, b);
        double au = vec_dot(f.su, a), av = vec_dot(f.sv, a);
        double bu = vec_dot(f.su, b), bv = vec_dot(f.sv, b), det = au * bv - av * bu;
        double du = (ra * bv - rb * av) / det, dv = (rb * au - ra * bu) / det;
        at->u -= du;
        at->v -= dv;
        if (!(fabs(at->u - 0.5) < 2 && fabs(at->v - 0.5) < 2)) return false;
        if (fabs(du) + fabs(dv) > STEP_END) continue;
        *height = vec_dot(d, axis);
        return in_domain(at);
    }
    return false;
}

/* Of the patches not tried yet, the sample that is nearest to the line. */
static bool nearest_sample(const btg_under *u, btg_vec3 axis, btg_vec3 point, const uint32_t *tried,
                           int count, btg_place *at) {
    double best = INFINITY;
    for (uint32_t i = 0; i < u->setup.part->patch_count; i++) {
        bool again = false;
        for (int k = 0; k < count; k++)
            again = again || tried[k] == i;
        for (int k = 0; k < SAMPLES * SAMPLES && !again; k++) {
            btg_vec3 d = vec_sub(u->samples[i * SAMPLES * SAMPLES + (uint32_t)k], point);
            double off = vec_norm2(vec_cross(d, axis));
            if (off >= best) continue;
            best = off;
            *at = (btg_place){i, (k / SAMPLES + 0.5) / SAMPLES, (k % SAMPLES + 0.5) / SAMPLES};
        }
    }
    return best < INFINITY;
}

bool btg_under_find(const btg_under *u, btg_vec3 axis, btg_vec3 point, btg_place *near,
                    double *height) {
    if (u->maps && axis.x == 0 && axis.y == 0) return find_linear(u, point, near, height);
    btg_vec3 a = vec_perpendicular(axis), b = vec_cross(axis, a);
    btg_place at = *near;
    if (at.item < u->setup.part->patch_count && descend(u, axis, a, b, point, &at, height)) {
        *near = at;
        return true;
    }
    uint32_t tried[PATCHES_TRIED];
    for (int k = 0; k < PATCHES_TRIED; k++) {
        if (!nearest_sample(u, axis, point, tried, k, &at)) return false;
        tried[k] = at.item;
        if (!descend(u, axis, a, b, point, &at, height)) continue;
        *near = at;
        return true;
    }
    return false;
}

/* ---- a grid on the tool ------------------------------------------------------------------- */

btg_tool_grid btg_tool_grid_place(const btg_tool *tool, btg_vec3 centre, btg_vec3 axis) {
    btg_vec3 a = vec_perpendicular(axis);
    return (btg_tool_grid){centre,
                           axis,
                           a,
                           vec_cross(axis, a),
                           tool->element[0].ring_radius_mm,
                           tool->element[0].corner_radius_mm};
}

btg_vec3 btg_tool_grid_point(const btg_tool_grid *g, double phi, double theta) {
    double r = g->major_radius + g->minor_radius * sin(theta);
    btg_vec3 arm = vec_add(vec_scale(g->a, cos(phi)), vec_scale(g->b, sin(phi)));
    return vec_mad(vec_mad(g->centre, arm, r), g->axis, -g->minor_radius * cos(theta));
}

bool btg_under_clear(const btg_under *u, const btg_tool_grid *grid, double allowed) {
    btg_place near = {.item = UINT32_MAX};
    /* The paper's theta_min and theta_max: where the tool is deepest in the part, both have one
     * normal, so that theta is no more than the part's slope and the axis's lean together. */
    double most = u->steepest + acos(fmin(fabs(grid->axis.z), 1));
    most = fmin(most, 0.5 * BTG_PI);
    for (int j = 0; j < ACROSS; j++)
        for (int i = 0; i < AROUND; i++) {
            double theta = most * (2 * (j + 0.5) / ACROSS - 1), height;
            btg_vec3 x = btg_tool_grid_point(grid, 2 * BTG_PI * i / AROUND, theta);
            if (btg_under_find(u, vec(0, 0, 1), x, &near, &height) && height > allowed)
                return false;
        }
    return true;
}
