/* drd: drop, rotate, drop. Rays from the tool to the part, and the part turned until the drop is
 * the same again (turn.c).
 *
 * A reconstruction: the method is that of M. Singh, J. Qu, R. K. Duvedi, S. Bedi, S. Mann, "A new
 * approach to find gouge free tool positions for a toroidal cutter for Bezier surfaces in five-axis
 * machining", 2021, of which we know what the VCRF paper tells: the first point of contact "by
 * firing rays from the tool to the design surface", the second "using binary search", and "the ray
 * casting method was based on Newton's method". So: rays along the tool's axis from a polar grid on
 * its lower side, each brought to the part by Newton's method from where its neighbour met it
 * (under.c); around the shortest the grid is refined. */
#include "methods/internal.h"

/* The grid on the tool, and the finer ones: points to each side, and how much finer. */
#define AROUND  64
#define ACROSS  32
#define BESIDE  3
#define FINER   3.0
#define REFINES 9
/* Rays of the grid that are refined: the shortest among their neighbours, at most this many, and
 * longer than the shortest of all by no more than the grid may be off, mm. */
#define VALLEYS 12
#define VALLEY  0.15

/* Heights closer than this are the same: above what the finest grid leaves of P's own. */
#define SAME_HEIGHT_MM 1e-6

typedef struct ray {
    bool met;
    double phi, theta, height;
    btg_place place;
} ray;

static ray cast(const btg_tool_rays *t, const btg_tool_grid *g, double phi, double theta,
                btg_place near) {
    ray r = {.phi = phi, .theta = theta, .place = near};
    btg_vec3 x = btg_tool_grid_point(g, phi, theta);
    btg_vec3 along = t->vertical ? vec(0, 0, 1) : g->axis;
    r.met = btg_under_find(t->under, along, x, &r.place, &r.height);
    if (!r.met) r.height = -INFINITY;
    btg_method_context_of(&t->setup)->counts->rays++;
    return r;
}

static void cast_grid(const btg_tool_rays *t, const btg_tool_grid *g, ray grid[ACROSS][AROUND]) {
    btg_place near = {.item = UINT32_MAX};
    for (int i = 0; i < AROUND; i++)
        for (int j = 0; j < ACROSS; j++) {
            double theta = BTG_PI * ((j + 0.5) / ACROSS - 0.5);
            grid[j][i] = cast(t, g, 2 * BTG_PI * i / AROUND, theta, near);
            near = grid[j][i].place;
        }
}

/* Finer grids about a ray, each as wide as two steps of the one before. */
static ray refine(const btg_tool_rays *t, const btg_tool_grid *g, ray best) {
    double step_phi = 2 * BTG_PI / AROUND, step_theta = BTG_PI / ACROSS;
    for (int k = 0; k < REFINES; k++) {
        ray middle = best;
        step_phi /= FINER;
        step_theta /= FINER;
        for (int i = -BESIDE; i <= BESIDE; i++)
            for (int j = -BESIDE; j <= BESIDE; j++) {
                double theta = middle.theta + j * step_theta;
                if (fabs(theta) > BTG_PI / 2) continue;
                ray r = cast(t, g, middle.phi + i * step_phi, theta, middle.place);
                if (r.met && r.height > best.height) best = r;
            }
    }
    return best;
}

static bool is_valley(ray grid[ACROSS][AROUND], int j, int i) {
    for (int dj = -1; dj <= 1; dj++)
        for (int di = -1; di <= 1; di++) {
            int nj = j + dj, ni = (i + di + AROUND) % AROUND;
            if (nj < 0 || nj >= ACROSS || (di == 0 && dj == 0)) continue;
            if (grid[nj][ni].height > grid[j][i].height) return false;
        }
    return grid[j][i].met;
}

/* The shortest of all rays. */
static ray shortest(const btg_tool_rays *t, const btg_tool_grid *g) {
    ray grid[ACROSS][AROUND], best = {.height = -INFINITY};
    cast_grid(t, g, grid);
    for (int k = 0; k < ACROSS * AROUND; k++)
        if (grid[k / AROUND][k % AROUND].height > best.height) best = grid[k / AROUND][k % AROUND];
    if (!best.met) return best;
    double floor_mm = best.height - VALLEY;
    int valleys = 0;
    for (int k = 0; k < ACROSS * AROUND && valleys < VALLEYS; k++) {
        int j = k / AROUND, i = k % AROUND;
        if (grid[j][i].height < floor_mm || !is_valley(grid, j, i)) continue;
        ray r = refine(t, g, grid[j][i]);
        if (r.height > best.height) best = r;
        valleys++;
    }
    return best;
}

static btg_drop_result drop_one(const btg_tool_rays *t, const btg_drop_query *q) {
    btg_tool_grid g = btg_tool_grid_place(&t->setup.tool, q->origin, q->axis);
    btg_drop_result r = {.status = BTG_NO_CONTACT, .bound_mm = NAN};
    ray best = shortest(t, &g);
    if (!best.met) return r;
    btg_ray_query query = btg_ray_query_drop(&t->setup.tool, q);
    btg_vec3 point =
        btg_patch_point(&t->setup.part->patches[best.place.item], best.place.u, best.place.v);
    r.status = BTG_OK;
    r.height_mm = best.height;
    r.contact = btg_method_contact(&query, best.height, 0, best.place, point);
    return r;
}

/* The drops of turned tools are turn.c's to count. */
static btg_status turned_drop(void *state, const btg_drop_query *queries, size_t count,
                              btg_drop_result *results) {
    for (size_t i = 0; i < count; i++)
        results[i] = drop_one(state, &queries[i]);
    return BTG_OK;
}

btg_status btg_tool_rays_drop(void *state, const btg_drop_query *queries, size_t count,
                              btg_drop_result *results) {
    const btg_tool_rays *t = state;
    btg_method_context_of(&t->setup)->counts->drops += count;
    return turned_drop(state, queries, count, results);
}

btg_status btg_tool_rays_tilt(void *state, const btg_tilt_query *queries, size_t count,
                              btg_tilt_result *results) {
    const btg_tool_rays *t = state;
    btg_turn turn = {&t->setup, turned_drop, state, SAME_HEIGHT_MM};
    btg_method_context_of(&t->setup)->counts->tilts += count;
    return btg_turn_tilt(&turn, queries, count, results);
}

btg_status btg_tool_rays_open(const btg_backend_setup *setup, const char *name, bool vertical,
                              void **state, btg_message *message) {
    btg_under *under;
    btg_status status = btg_under_create(setup, name, vertical, &under, message);
    if (status != BTG_OK) return status;
    btg_tool_rays *t = btg_allocate(&setup->allocator, 1, sizeof *t);
    if (!t) {
        btg_under_destroy(under);
        return btg_fail(message, BTG_ERROR_MEMORY, "method %s: out of memory", name);
    }
    *t = (btg_tool_rays){*setup, under, vertical};
    *state = t;
    return BTG_OK;
}

void btg_tool_rays_close(void *state) {
    btg_tool_rays *t = state;
    btg_allocator allocator = t->setup.allocator;
    btg_under_destroy(t->under);
    btg_release(&allocator, t);
}

/* ---- the method --------------------------------------------------------------------------- */

static btg_status open(const btg_backend_setup *setup, void **state, btg_message *message) {
    return btg_tool_rays_open(setup, "drd", false, state, message);
}

const btg_backend_table btg_method_drd = {
    .name = "drd",
    .summary = "rays from a grid on the tool, and the part turned until the drop is the same again",
    .open = open,
    .close = btg_tool_rays_close,
    .drop = btg_tool_rays_drop,
    .tilt = btg_tool_rays_tilt};
