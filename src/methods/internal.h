/* What the methods share. Internal to src/methods. */
#ifndef BTG_METHODS_INTERNAL_H
#define BTG_METHODS_INTERNAL_H

#include "backend/internal.h"
#include "core/part.h"
#include "core/ray.h"
#include "methods/method.h"

/* What a method's table finds in setup->user. */
typedef struct btg_method_context {
    const btg_method_def *def;
    btg_method_counts *counts;
    btg_backend *inner; /* of methods that use a back end */
} btg_method_context;

static inline const btg_method_context *btg_method_context_of(const btg_backend_setup *setup) {
    return setup->user;
}

extern const btg_backend_table btg_method_vcrf_grid, btg_method_depth, btg_method_dst,
    btg_method_drd, btg_method_sr, btg_method_direct, btg_method_bisection;

/* The contact of a tool as placed with the part point at a place; the normal is the tool's. */
btg_contact btg_method_contact(const btg_ray_query *query, double value, uint32_t element,
                               btg_place place, btg_vec3 point);

/* ---- under.c ------------------------------------------------------------------------------ */

/* The part's height under a point along an axis, for rays fired from the tool. */
typedef struct btg_under btg_under;

/* What a method can be asked of: its tool is a torus alone, its part has exact surfaces, and
 * (`linear`) their x and y are linear in u and v. ERROR_UNSUPPORTED with a message otherwise. */
btg_status btg_under_create(const btg_backend_setup *setup, const char *name, bool linear,
                            btg_under **under, btg_message *message);
void btg_under_destroy(btg_under *under); /* NULL is fine */

/* Where the line through `point` along unit `axis` meets the part, and how high over `point`.
 * `near`: where a neighbouring line did, and where this one does; item UINT32_MAX: not known. A
 * part that is met more than once is taken where it is next to `near`. False: not at all. */
bool btg_under_find(const btg_under *under, btg_vec3 axis, btg_vec3 point, btg_place *near,
                    double *height);

/* A grid on the torus, placed: rings of `around` points, `across` of them from one side of the
 * tube's lower half to the other. */
typedef struct btg_tool_grid {
    btg_vec3 centre, axis, a, b; /* a, b: unit, at right angles to the axis */
    double major_radius, minor_radius;
} btg_tool_grid;

btg_tool_grid btg_tool_grid_place(const btg_tool *tool, btg_vec3 centre, btg_vec3 axis);
/* phi about the axis, theta across the tube: 0 at its lowest, positive outward. */
btg_vec3 btg_tool_grid_point(const btg_tool_grid *grid, double phi, double theta);

/* The papers' gouge check: a grid of 48 x 36 points on the tool's lower half against the part's
 * height under each, along z. True: none is deeper than `allowed`. */
bool btg_under_clear(const btg_under *under, const btg_tool_grid *grid, double allowed);

/* ---- drd.c -------------------------------------------------------------------------------- */

/* DROP by rays from a grid on the tool to the part; the state is a btg_tool_rays.
 * Grids ever finer around those rays that may be the shortest. */
typedef struct btg_tool_rays {
    btg_backend_setup setup;
    btg_under *under;
    bool vertical; /* rays along z however the tool leans: then `height` of a leaning tool is how
                      deep it is in the part along z, and no rest */
} btg_tool_rays;

/* `vertical` needs x and y linear in u and v, and no iteration. */
btg_status btg_tool_rays_open(const btg_backend_setup *setup, const char *name, bool vertical,
                              void **state, btg_message *message);
void btg_tool_rays_close(void *state);
btg_status btg_tool_rays_drop(void *state, const btg_drop_query *queries, size_t count,
                              btg_drop_result *results);
/* By turn.c. */
btg_status btg_tool_rays_tilt(void *state, const btg_tilt_query *queries, size_t count,
                              btg_tilt_result *results);

/* ---- pixels.c ----------------------------------------------------------------------------- */

/* DROP by rays through the pixels of a window as wide as the tool, and of a second one two pixels
 * wide where levels is 2. */
typedef struct btg_pixels {
    const btg_backend_setup *setup;
    btg_under *under;
    uint32_t window;
    int levels;
} btg_pixels;

btg_status btg_pixels_drop(void *pixels, const btg_drop_query *queries, size_t count,
                           btg_drop_result *results);
/* Between the rays of the last level, mm. */
double btg_pixels_pitch(const btg_pixels *pixels);

/* ---- newton.c ----------------------------------------------------------------------------- */

/* The drop-spin-tilt paper's equations by Newton's method. */
typedef struct btg_newton btg_newton;

/* `exact`: the part's derivatives as they are, and seeds from under the tool's shadow alone
 * (direct); else by Richardson extrapolation, and seeds from all of the part (dst). */
btg_status btg_newton_create(const btg_backend_setup *setup, const char *name, bool exact,
                             void **newton, btg_message *message);
void btg_newton_destroy(void *newton);
btg_status btg_newton_drop(void *newton, const btg_drop_query *queries, size_t count,
                           btg_drop_result *results);
btg_status btg_newton_tilt(void *newton, const btg_tilt_query *queries, size_t count,
                           btg_tilt_result *results);

/* ---- turn.c ------------------------------------------------------------------------------- */

typedef btg_status (*btg_drop_op)(void *user, const btg_drop_query *queries, size_t count,
                                  btg_drop_result *results);

/* TILT from DROPs alone: the part is turned about the pseudo-insert (here the tool, the other way)
 * and the tool dropped on it, at bisected angles, until it comes to rest as high as before. */
typedef struct btg_turn {
    const btg_backend_setup *setup;
    btg_drop_op drop;
    void *user;
    double same_height_mm; /* rests at most so much higher: the same height */
} btg_turn;

btg_status btg_turn_tilt(const btg_turn *turn, const btg_tilt_query *queries, size_t count,
                         btg_tilt_result *results);

/* ---- grid.c ------------------------------------------------------------------------------- */

/* Points of the part, evenly spaced in its parameters, that rays are fired from. */
typedef struct btg_grid btg_grid;

/* ERROR_UNSUPPORTED: too many points. `name`: of the method, for the message. */
btg_status btg_grid_create(const btg_backend_setup *setup, const char *name, btg_grid **grid,
                           btg_message *message);
void btg_grid_destroy(btg_grid *grid); /* NULL is fine */

/* Vertical rays, and circular rays, from all points under the tool's shadow. */
btg_status btg_grid_drop(void *grid, const btg_drop_query *queries, size_t count,
                         btg_drop_result *results);
btg_status btg_grid_tilt(void *grid, const btg_tilt_query *queries, size_t count,
                         btg_tilt_result *results);
const btg_backend_setup *btg_grid_setup(const btg_grid *grid);

#endif
