/* bisection: the tilt bisected with a gouge grid, where x and y are linear in u and v.
 *
 * A reconstruction: the method is that of R. K. Duvedi, S. Bedi, S. Mann, "An efficient multipoint
 * 5-axis tool positioning method for tensor product surfaces", 2018, of which we know its name in
 * the VCRF paper ("tool-tilt bisection"), that its gouge check is the drop-spin-tilt paper's, along
 * z, and that it wants x and y linear. So: both steps ask how deep a grid on the tool is in the
 * part along z, each of its points read off the surface without iteration (under.c, drd.c); the
 * tilt is bisected between poses that are clear and poses that are not (turn.c). The grid is
 * refined where it is deepest: the papers' 48 x 36 points alone miss what is between them. */
#include "methods/internal.h"

static btg_status open(const btg_backend_setup *setup, void **state, btg_message *message) {
    return btg_tool_rays_open(setup, "bisection", true, state, message);
}

const btg_backend_table btg_method_bisection = {
    .name = "bisection",
    .summary = "a gouge grid, bisected, where x and y are linear in u and v",
    .open = open,
    .close = btg_tool_rays_close,
    .drop = btg_tool_rays_drop,
    .tilt = btg_tool_rays_tilt};
