/* Back ends: who answers DROP and TILT for batches of poses. One front that validates, then a
 * table per back end; no silent fallback: what ran is what was opened. */
#ifndef BITANGENT_BACKEND_H
#define BITANGENT_BACKEND_H

#include "bitangent/bitangent.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum btg_backend_state {
    BTG_BACKEND_NOT_BUILT = 0,
    BTG_BACKEND_NO_DEVICE = 1,
    BTG_BACKEND_READY = 2
} btg_backend_state;

typedef struct btg_backend_info {
    const char *name; /* "cpu", "reference", ... static storage */
    btg_backend_state state;
    char device[256];  /* what it runs on: name, driver, version, limits; or why on nothing */
    char summary[256]; /* what it can do, one line */
} btg_backend_info;

/* Number of back ends this version knows, built or not, in order of preference. */
BTG_API size_t btg_backend_count(void);
/* ERROR_ARGUMENT when index is out of range. */
BTG_API btg_status btg_backend_get_info(size_t index, btg_backend_info *info);
/* "not-built", "no-device", "ready" */
BTG_API const char *btg_backend_state_name(btg_backend_state state);

typedef struct btg_backend_def {
    uint32_t version;
    /* NULL or "auto": the first that is ready; should its device fail, the next goes on from there.
     * "vulkan,auto": the same, with that one to begin with. A name alone: that one and no other. */
    const char *name;
    uint32_t threads; /* 0: as many as the machine has; default 0 */
    btg_allocator allocator;
    int raw; /* 1: a device's answers as it finds them in single precision, nothing polished and
                nothing proven (bound_mm NaN); the cpu and the reference have no such. Default 0 */
    const char *gl_context; /* who makes OpenGL's contexts: "osmesa" or "egl"; NULL or "auto": the
                               first of them that is there. Used while opening alone */
    /* Depth images (osmesa; others take no notice): */
    uint32_t levels; /* 1: one image of the tool's width; 2: and then one two pixels wide about each
                        valley. Default 2 */
    uint32_t window_pixels; /* an image's side, 8 .. 4096; 0 (default): 50, or 625 on one level */
} btg_backend_def;

BTG_API btg_backend_def btg_backend_def_default(void);

/* An opened back end with one part and one tool. Thread-safety: one thread at a time an object.
 * Real-time: no (use btg_drop and btg_tilt of bitangent.h directly). */
typedef struct btg_backend btg_backend;

/* The part must outlive the back end. Errors: ERROR_ARGUMENT (unknown name: message lists the
 * known ones), ERROR_NOT_BUILT, ERROR_NO_DEVICE, ERROR_MEMORY. */
BTG_API btg_status btg_backend_open(const btg_backend_def *def, const btg_part *part,
                                    const btg_tool *tool, const btg_solver_def *solver,
                                    btg_backend **backend, btg_message *message);
BTG_API void btg_backend_close(btg_backend *backend);
BTG_API const char *btg_backend_name(const btg_backend *backend);
/* Who was to run and could not, and why, where `auto` took another; "" when nothing happened. Valid
 * until the next call or close. */
BTG_API const char *btg_backend_note(const btg_backend *backend);
BTG_API uint32_t btg_backend_threads(const btg_backend *backend);

/* Where the time of a device back end went since it was opened, seconds, and the memory it takes;
 * all zero for others. The device works on while the core polishes: what is left then is waited
 * for. */
typedef struct btg_backend_times {
    double upload_s;     /* queries made ready and handed over */
    double device_s;     /* dispatches, as far as they had to be waited for */
    double readback_s;   /* winners taken back */
    double polish_s;     /* the core's part: polish and proof */
    size_t device_bytes; /* buffers of part, queries and answers */
} btg_backend_times;

BTG_API void btg_backend_get_times(const btg_backend *backend, btg_backend_times *times);

/* Batches: results in input order, bit-identical for any number of threads. count may be 0. An
 * invalid query gives ERROR_ARGUMENT and the index of the first one in *bad (may be NULL);
 * results are then untouched. */
BTG_API btg_status btg_backend_drop(btg_backend *backend, const btg_drop_query *queries,
                                    size_t count, btg_drop_result *results, size_t *bad);
BTG_API btg_status btg_backend_tilt(btg_backend *backend, const btg_tilt_query *queries,
                                    size_t count, btg_tilt_result *results, size_t *bad);

/* Whole positions over footprint points (x, y pairs): a DROP batch, then a TILT batch; or, where
 * the spin is searched for, rounds of TILT batches until the last position has its spin. */
BTG_API btg_status btg_backend_positions(btg_backend *backend, const double *foot_xy_mm,
                                         size_t count, btg_position *positions, size_t *bad);

#ifdef __cplusplus
}
#endif
#endif
