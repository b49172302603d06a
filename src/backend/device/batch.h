/* Batches on a device: what every device back end does around its dispatches. Internal.
 *
 * Queries are packed and handed over, two dispatches in flight: while the device works at one, the
 * core polishes and proves what came back from the other. A batch is cut to what the device takes
 * at once. A device that failed once answers nothing more. */
#ifndef BTG_BACKEND_DEVICE_BATCH_H
#define BTG_BACKEND_DEVICE_BATCH_H

#include "backend/device/scene.h"
#include "core/ray.h"

#define BTG_BATCH_SLOTS 2
/* Queries a dispatch: enough to fill any device, few enough to stay a moment's work. */
#define BTG_BATCH_DISPATCH 2048
/* Positions that keep two dispatches in flight; a back end's table says so. */
#define BTG_BATCH_BLOCK (4 * BTG_BATCH_DISPATCH)

typedef struct btg_device_limits {
    size_t buffer_bytes; /* of one buffer */
    uint32_t groups;     /* workgroups a dispatch */
} btg_device_limits;

/* What a device back end is made of. All calls are mandatory, and made by one thread at a time.
 * Errors: ERROR_NO_DEVICE at start, ERROR_MEMORY, ERROR_DEVICE (lost, or no answer in time). */
typedef struct btg_device_ops {
    const char *name;
    btg_cell_size cells; /* the part is cut into, as parts of the tool's radius; optional */
    /* Finds and starts the device. `user` is what btg_batch_open was given. On error *device is
     * untouched, and nothing is left behind. */
    btg_status (*start)(const btg_backend_setup *setup, const void *user, void **device,
                        btg_device_limits *limits, btg_message *message);
    /* Gives it the part and tool, and makes room for `capacity` queries a slot. *bytes: memory it
     * takes in all. */
    btg_status (*load)(void *device, const btg_scene *scene, uint32_t capacity, size_t *bytes,
                       btg_message *message);
    /* Gives a slot that is free `count` <= capacity queries, and starts the dispatch over them. */
    btg_status (*write)(void *device, uint32_t slot, const btg_gpu_query *queries, uint32_t count);
    btg_status (*dispatch)(void *device, uint32_t slot, btg_op op, uint32_t count);
    /* Waits for the slot's dispatch, and takes its first `count` winners. */
    btg_status (*wait)(void *device, uint32_t slot);
    btg_status (*read)(void *device, uint32_t slot, btg_gpu_winner *winners, uint32_t count);
    /* Whatever goes on is waited for. */
    void (*stop)(void *device);
} btg_device_ops;

/* A table's own open() calls btg_batch_open with its ops; the others go into the table as they
 * are. `dispatch`: queries at once at the most; 0: BTG_BATCH_DISPATCH. */
btg_status btg_batch_open(const btg_device_ops *ops, const void *user, uint32_t dispatch,
                          const btg_backend_setup *setup, void **state, btg_message *message);
void btg_batch_close(void *state);
btg_status btg_batch_drop(void *state, const btg_drop_query *queries, size_t count,
                          btg_drop_result *results);
btg_status btg_batch_tilt(void *state, const btg_tilt_query *queries, size_t count,
                          btg_tilt_result *results);
uint32_t btg_batch_threads(void *state);
void btg_batch_times(void *state, btg_backend_times *times);

#endif
