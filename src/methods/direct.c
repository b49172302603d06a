/* direct: drop and tilt by Newton's method where x and y are linear in u and v.
 *
 * A reconstruction: the method is that of R. K. Duvedi, S. Bedi, S. Mann, "Numerical implementation
 * of drop and tilt method of five-axis tool positioning for tensor product surfaces", 2018, of
 * which we know what the VCRF paper tells: Newton's method on the drop and tilt equations, and that
 * "the xy-values of the control points are linear functions of the uv-domain", which "simplifies
 * the search". So: the equations of dst (newton.c) without spin, seeds from under the tool's
 * shadow, which the linear map turns into u and v, and the surface's own derivatives. */
#include "methods/internal.h"

static btg_status open(const btg_backend_setup *setup, void **state, btg_message *message) {
    return btg_newton_create(setup, "direct", true, state, message);
}

const btg_backend_table btg_method_direct = {
    .name = "direct",
    .summary = "Newton's method where x and y are linear in u and v",
    .open = open,
    .close = btg_newton_destroy,
    .drop = btg_newton_drop,
    .tilt = btg_newton_tilt};
