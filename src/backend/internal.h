/* The private side of the back ends: the table each one fills in, and a frame for those that
 * answer one query at a time on the processor. Internal.
 *
 * A back end exposes one `const btg_backend_table` and is named in registry.c; nothing else knows
 * it. The front (backend.c) validates every query before it dispatches, composes positions, and
 * splits long work into batches: a table's functions see valid input only and never NULL. */
#ifndef BTG_BACKEND_INTERNAL_H
#define BTG_BACKEND_INTERNAL_H

#include "bitangent/backend.h"

#include <stdbool.h>

/* What a back end is opened with. `part` is borrowed and outlives the back end; the rest is a
 * copy, already checked. `threads` is resolved: >= 1. */
typedef struct btg_backend_setup {
    const btg_part *part;
    btg_tool tool;
    btg_solver_def solver;
    uint32_t threads;
    btg_allocator allocator;
    bool raw;                /* devices: do not polish */
    uint32_t levels, window; /* of depth images: resolved */
    const char *gl_context;  /* as in btg_backend_def; while opening alone */
    const void *user;        /* what a table of btg_backend_open_table is told besides; else NULL */
} btg_backend_setup;

/* One back end. `state` is what open() made.
 *
 * The batch calls answer `count` >= 1 valid queries in input order, each as if it were alone: the
 * batch's size, its neighbours and the number of threads never show in a result. A query without
 * an answer (ERROR_GOUGE) leaves its error in its result's status, everything else there zero,
 * and the batch goes on. A returned error means that the device as a whole failed. */
typedef struct btg_backend_table {
    const char *name;    /* mandatory: "cpu" */
    const char *summary; /* mandatory: what it can do, one line */

    /* Mandatory where built; NULL marks a back end that was left out of this build, and then all
     * below is NULL as well. Says whether there is a device and names it in `device` (size
     * bytes), or says there what is missing. Never opens anything for good. */
    btg_backend_state (*probe)(char *device, size_t size);

    /* Mandatory. Set-up may allocate, through setup->allocator alone. `setup` is copied by those
     * who need it. On error *state is untouched and message tells why. */
    btg_status (*open)(const btg_backend_setup *setup, void **state, btg_message *message);
    /* Mandatory. Never NULL. */
    void (*close)(void *state);

    /* Mandatory. */
    btg_status (*drop)(void *state, const btg_drop_query *queries, size_t count,
                       btg_drop_result *results);
    btg_status (*tilt)(void *state, const btg_tilt_query *queries, size_t count,
                       btg_tilt_result *results);

    /* Optional: number of threads in use. NULL: 1. */
    uint32_t (*threads)(void *state);
    /* Optional: where the time went since open. */
    void (*times)(void *state, btg_backend_times *times);
    /* Optional: positions a batch the device likes best; 0: BTG_BACKEND_BLOCK. */
    size_t block;
    /* Optional: where a spin is searched for, the core may guess between tilts (core/spin.h). */
    bool guesses;
    /* Optional, where one stands for others: who it was, and what the caller should know ("":
     * nothing). */
    const char *(*ran)(void *state);
    const char *(*note)(void *state);
} btg_backend_table;

#define BTG_BACKEND_BLOCK 4096

/* In order of preference; those left out of the build included. */
extern const btg_backend_table *const btg_backend_registry[];
extern const size_t btg_backend_registry_count;

extern const btg_backend_table btg_backend_cpu;
extern const btg_backend_table btg_backend_reference;
extern const btg_backend_table btg_backend_gl;     /* where it was built: BTG_HAVE_GL */
extern const btg_backend_table btg_backend_osmesa; /* where it was built: BTG_HAVE_OSMESA */
extern const btg_backend_table btg_backend_vulkan; /* where it was built: BTG_HAVE_VULKAN */

/* One that goes on with the next where a device fails (fallback.c), opened by
 * btg_backend_open_table with one of these as `user`. */
typedef struct btg_fallback_def {
    const btg_backend_table *const *tables; /* in order of preference; up to 32 */
    size_t count;
    const btg_backend_table *first; /* one of them to begin with; NULL: the order decides */
} btg_fallback_def;
extern const btg_backend_table btg_backend_fallback;

/* Opens a table that is not in the registry: a method that answers the two questions in its own
 * way (methods/method.h) is composed to positions by the same front. `user` goes to the table's
 * open() in its setup; `def` names no back end here. Errors as btg_backend_open. */
btg_status btg_backend_open_table(const btg_backend_table *table, const void *user,
                                  const btg_backend_def *def, const btg_part *part,
                                  const btg_tool *tool, const btg_solver_def *solver,
                                  btg_backend **backend, btg_message *message);

/* ---- back ends that answer one query at a time on the processor (host.c) ------------------ */

/* What such a back end is made of. Each call gets a workspace of its own thread. The two
 * functions are called from several threads at once and must not write to `data`. */
typedef struct btg_host_ops {
    /* Bytes of workspace a thread needs; may be 0. */
    size_t (*workspace_size)(const btg_part *part);
    /* Optional, both or neither: what is worked out once a part and tool, and its end. */
    btg_status (*prepare)(const btg_backend_setup *setup, void **data, btg_message *message);
    void (*release)(const btg_backend_setup *setup, void *data);
    /* One valid query. On error (ERROR_GOUGE) the result may be left alone. */
    btg_status (*drop)(const btg_backend_setup *setup, const void *data,
                       const btg_drop_query *query, void *workspace, size_t workspace_size,
                       btg_drop_result *result);
    btg_status (*tilt)(const btg_backend_setup *setup, const void *data,
                       const btg_tilt_query *query, void *workspace, size_t workspace_size,
                       btg_tilt_result *result);
} btg_host_ops;

/* The frame's entry points. A table's own open() calls btg_host_open with its ops; the others go
 * into the table as they are:
 *
 *     static btg_status open(const btg_backend_setup *setup, void **state, btg_message *message) {
 *         return btg_host_open(&ops, setup, state, message);
 *     }
 *     const btg_backend_table btg_backend_x = {
 *         .name = "x", .summary = "...", .probe = btg_host_probe, .open = open,
 *         .close = btg_host_close, .drop = btg_host_drop, .tilt = btg_host_tilt,
 *         .threads = btg_host_threads};
 */
btg_backend_state btg_host_probe(char *device, size_t size);
btg_status btg_host_open(const btg_host_ops *ops, const btg_backend_setup *setup, void **state,
                         btg_message *message);
void btg_host_close(void *state);
btg_status btg_host_drop(void *state, const btg_drop_query *queries, size_t count,
                         btg_drop_result *results);
btg_status btg_host_tilt(void *state, const btg_tilt_query *queries, size_t count,
                         btg_tilt_result *results);
uint32_t btg_host_threads(void *state);

#endif
