/* sr: surface rotation. Rays from a grid of part points to the tool, and the part turned step by
 * step until the drop is the same again.
 *
 * A reconstruction: the method is that of R. K. Duvedi, M. Singh, S. Bedi, S. Mann, "Multipoint
 * tool positioning of a toroidal end mill for five-axis machining of generalized tensor product
 * Bezier surfaces", 2020, of which we know what the GPU paper tells: both steps by gouge checks
 * alone, rays "from the surface towards the tool, in a transformed coordinate system" where the
 * tool "could only move along the Z-axis", hundreds of times a position. */
#include "methods/internal.h"

/* Heights closer than this are the same: P is a point of the grid, and stays on the tool. */
#define SAME_HEIGHT_MM 1e-6

static btg_status open(const btg_backend_setup *setup, void **state, btg_message *message) {
    btg_grid *grid;
    btg_status status = btg_grid_create(setup, "sr", &grid, message);
    if (status == BTG_OK) *state = grid;
    return status;
}

static void close(void *state) {
    btg_grid_destroy(state);
}

static btg_status drop(void *state, const btg_drop_query *queries, size_t count,
                       btg_drop_result *results) {
    btg_method_context_of(btg_grid_setup(state))->counts->drops += count;
    return btg_grid_drop(state, queries, count, results);
}

static btg_status tilt(void *state, const btg_tilt_query *queries, size_t count,
                       btg_tilt_result *results) {
    btg_turn turn = {btg_grid_setup(state), btg_grid_drop, state, SAME_HEIGHT_MM};
    btg_method_context_of(turn.setup)->counts->tilts += count;
    return btg_turn_tilt(&turn, queries, count, results);
}

const btg_backend_table btg_method_sr = {
    .name = "sr",
    .summary = "vertical rays from a grid, and the part turned until the drop is the same again",
    .open = open,
    .close = close,
    .drop = drop,
    .tilt = tilt};
