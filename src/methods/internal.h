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
