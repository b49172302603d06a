/* The papers' methods under one interface, for comparison. Internal to the program and its tests.
 *
 * A method answers DROP and TILT (backend.h) in its own way; the front of the back ends checks its
 * queries and composes positions from its answers, as it does for the back ends. So a method is
 * a table of two functions, and none has a drop or a gouge check that another has:
 *
 *     name        DROP                                 TILT
 *     vcrf        any back end's                       any back end's: the exact solver
 *     vcrf-grid   vertical rays from a grid            circular rays from the same grid
 *     depth       any back end's                       the part turned, DROP again: bisection
 *     dst         Newton, 3 unknowns                   Newton, 4 unknowns, after any spin
 *     drd         rays from a grid on the tool         the part turned, DROP again: bisection
 *     sr          vertical rays from a grid            the part turned, DROP again: bisection
 *     direct      Newton, where x, y are linear        Newton
 *     bisection   a gouge grid, where they are linear  the gouge grid again: bisection
 *
 * drd, sr, direct and bisection are reconstructed from what the three papers say of them; their own
 * papers were not at hand. */
#ifndef BTG_METHODS_METHOD_H
#define BTG_METHODS_METHOD_H

#include "bitangent/backend.h"

#include <stdbool.h>

/* Work done since a method was opened; what a method does not do stays 0. */
typedef struct btg_method_counts {
    uint64_t drops, tilts; /* answered */
    uint64_t rays;         /* vertical or circular, from the part or from the tool */
    uint64_t turned_drops; /* DROPs asked by bisections */
    /* Newton's method, over the drops and the tilts that found their contact: seeds tried, all
     * iterations, and those of the seeds that led there. */
    uint64_t drop_seeds, drop_iterations, drop_last_iterations;
    uint64_t tilt_seeds, tilt_iterations, tilt_last_iterations;
    uint64_t followed;                       /* tilts whose neighbour's answer was seed enough */
    uint64_t drops_given_up, tilts_given_up; /* no seed led to an answer: no contact, no tilt */
    uint64_t near_p, axis_down, gouged;      /* solutions thrown away, by the check that did it */
} btg_method_counts;

typedef struct btg_method_info {
    const char *name;
    const char *summary; /* one line */
    bool uses_backend;   /* asks a back end; the others work by themselves, on one thread */
    bool spins;          /* takes a spin */
    bool reconstructed;  /* from what other papers say of it */
} btg_method_info;

size_t btg_method_count(void);
/* index < btg_method_count(). */
btg_method_info btg_method_get_info(size_t index);
/* False: there is no such method. */
bool btg_method_find(const char *name, btg_method_info *info);

typedef struct btg_method_def {
    const char *name;        /* NULL: "vcrf" */
    btg_backend_def backend; /* for vcrf and depth */
    double ray_spacing_mm;   /* vcrf-grid, sr: between rays on the part; default 0.1, > 0 */
    int levels;              /* vcrf-grid, sr: 2 (default), a second grid around the best ray; 1 */
    uint32_t window; /* depth on a back end without depth images: pixels of a window's side, one
                        ray each, up to 4096; 0 (default): the back end's exact drops */
    uint64_t seed;   /* dst, direct: of the random seeds; any number */
} btg_method_def;

btg_method_def btg_method_def_default(void);

/* An opened method with one part and one tool. Thread-safety: one thread at a time. */
typedef struct btg_method btg_method;

/* The part must outlive the method. Errors: ERROR_ARGUMENT (no such method, or a value of the
 * definition), ERROR_UNSUPPORTED (this method cannot do this part, tool or spin; message says why
 * and which method can), and those of btg_backend_open. */
btg_status btg_method_open(const btg_method_def *def, const btg_part *part, const btg_tool *tool,
                           const btg_solver_def *solver, btg_method **method, btg_message *message);
void btg_method_close(btg_method *method); /* NULL is fine */

/* Asks DROP, TILT and whole positions; it is closed with the method. */
btg_backend *btg_method_front(const btg_method *method);
/* The back end that answers, or "none" for a method that works by itself; and its threads. */
const char *btg_method_backend_name(const btg_method *method);
uint32_t btg_method_threads(const btg_method *method);
void btg_method_get_times(const btg_method *method, btg_backend_times *times);
/* btg_backend_note of the back end that answers; "" without one. */
const char *btg_method_note(const btg_method *method);
btg_method_counts btg_method_get_counts(const btg_method *method);

#endif
