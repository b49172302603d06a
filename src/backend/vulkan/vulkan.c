/* Vulkan compute: a device finds the places, the core starts from them and proves its answers. */
#define _POSIX_C_SOURCE 200809L
#include "backend/vulkan/vulkan.h"
#include "backend/vulkan/device.h"
#include "core/part.h"

#include <stdio.h>
#include <string.h>
#include <time.h>

/* Queries a dispatch: enough to fill any device, few enough to stay a moment's work. */
#define DISPATCH 4096

typedef struct state {
    btg_backend_setup setup;
    btg_scene scene;
    btg_vulkan_device device;
    void *core; /* the cpu back end: polishes */
    double *shifts;
    btg_drop_query *drops; /* of one dispatch, with their starts */
    btg_tilt_query *tilts;
    btg_backend_times times;
} state;

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Adds the time since *since to *sum, and starts anew. */
static void lap(double *since, double *sum) {
    double t = now();
    *sum += t - *since;
    *since = t;
}

/* ---- opening ------------------------------------------------------------------------------ */

static btg_backend_state probe(char *device, size_t size) {
    btg_vulkan vk;
    btg_message message = {""};
    bool found = btg_vulkan_find(NULL, &vk, &message) == BTG_OK;
    bool ready = found && btg_vulkan_start(&vk, &message) == BTG_OK;
    snprintf(device, size, "%s", ready ? vk.name : message.text);
    if (found) btg_vulkan_end(&vk);
    return ready ? BTG_BACKEND_READY : BTG_BACKEND_NO_DEVICE;
}

static void close(void *opened) {
    state *s = opened;
    btg_allocator allocator = s->setup.allocator;
    if (s->core) btg_backend_cpu.close(s->core);
    btg_vulkan_unload(&s->device);
    btg_vulkan_end(&s->device.vk);
    btg_release(&allocator, s->shifts);
    btg_release(&allocator, s->drops);
    btg_release(&allocator, s->tilts);
    btg_release(&allocator, s);
}

static btg_status make_room(state *s, btg_message *message) {
    const btg_allocator *a = &s->setup.allocator;
    s->shifts = btg_allocate(a, s->device.capacity, sizeof *s->shifts);
    s->drops = btg_allocate(a, s->device.capacity, sizeof *s->drops);
    s->tilts = btg_allocate(a, s->device.capacity, sizeof *s->tilts);
    if (s->shifts && s->drops && s->tilts) return BTG_OK;
    return btg_fail(message, BTG_ERROR_MEMORY, "vulkan: out of memory");
}

static btg_status fill(state *s, const btg_vulkan_debug *debug, btg_message *message) {
    btg_vulkan *vk = &s->device.vk;
    btg_status status = btg_vulkan_find(debug, vk, message);
    if (status == BTG_OK) status = btg_vulkan_start(vk, message);
    if (status == BTG_OK)
        status = btg_scene_make(&s->setup, btg_vulkan_buffer_max(vk), &s->scene, message);
    if (status != BTG_OK) return status;
    status = btg_vulkan_load(&s->device, &s->scene, DISPATCH, message);
    /* The device has its own now. */
    btg_release(&s->setup.allocator, s->scene.geometry);
    s->scene.geometry = NULL;
    if (status == BTG_OK) status = make_room(s, message);
    if (status == BTG_OK) status = btg_backend_cpu.open(&s->setup, &s->core, message);
    return status;
}

btg_status btg_vulkan_open_debug(const btg_vulkan_debug *debug, const btg_backend_setup *setup,
                                 void **opened, btg_message *message) {
    state *s = btg_allocate(&setup->allocator, 1, sizeof *s);
    if (!s) return btg_fail(message, BTG_ERROR_MEMORY, "vulkan: out of memory");
    *s = (state){.setup = *setup};
    btg_status status = fill(s, debug, message);
    if (status != BTG_OK)
        close(s);
    else
        *opened = s;
    return status;
}

static btg_status open(const btg_backend_setup *setup, void **opened, btg_message *message) {
    return btg_vulkan_open_debug(NULL, setup, opened, message);
}

/* ---- batches ------------------------------------------------------------------------------ */

static const btg_gpu_winner *winners_of(const state *s) {
    return s->device.buffer[BTG_GPU_WINNERS].mapped;
}

static btg_gpu_query *queries_of(const state *s) {
    return s->device.buffer[BTG_GPU_QUERIES].mapped;
}

static btg_status drop_some(state *s, const btg_drop_query *queries, uint32_t count,
                            btg_drop_result *results) {
    double since = now();
    for (uint32_t i = 0; i < count; i++)
        btg_gpu_pack_drop(&s->scene, &queries[i], &queries_of(s)[i], &s->shifts[i]);
    lap(&since, &s->times.upload_s);
    btg_status status = btg_vulkan_run(&s->device, BTG_OP_DROP, count);
    lap(&since, &s->times.device_s);
    if (status != BTG_OK) return status;
    for (uint32_t i = 0; i < count; i++) {
        btg_gpu_winner winner = winners_of(s)[i];
        if (s->setup.raw) {
            btg_gpu_raw_drop(&s->setup, &queries[i], &winner, s->shifts[i], &results[i]);
            continue;
        }
        s->drops[i] = queries[i];
        if (btg_gpu_start(&s->setup, &winner, &s->drops[i].start)) s->drops[i].has_start = 1;
    }
    lap(&since, &s->times.readback_s);
    if (!s->setup.raw) status = btg_backend_cpu.drop(s->core, s->drops, count, results);
    lap(&since, &s->times.polish_s);
    return status;
}

static btg_status tilt_some(state *s, const btg_tilt_query *queries, uint32_t count,
                            btg_tilt_result *results) {
    double since = now();
    for (uint32_t i = 0; i < count; i++)
        btg_gpu_pack_tilt(&s->setup, &s->scene, &queries[i], &queries_of(s)[i]);
    lap(&since, &s->times.upload_s);
    btg_status status = btg_vulkan_run(&s->device, BTG_OP_TILT, count);
    lap(&since, &s->times.device_s);
    if (status != BTG_OK) return status;
    for (uint32_t i = 0; i < count; i++) {
        btg_gpu_winner winner = winners_of(s)[i];
        if (s->setup.raw) {
            btg_gpu_raw_tilt(&s->setup, &queries[i], &winner, &results[i]);
            continue;
        }
        s->tilts[i] = queries[i];
        if (btg_gpu_start_tilt(&s->setup, &queries[i], &winner, &s->tilts[i].start))
            s->tilts[i].has_start = 1;
    }
    lap(&since, &s->times.readback_s);
    if (!s->setup.raw) status = btg_backend_cpu.tilt(s->core, s->tilts, count, results);
    lap(&since, &s->times.polish_s);
    return status;
}

static uint32_t share(const state *s, size_t left) {
    return left < s->device.capacity ? (uint32_t)left : s->device.capacity;
}

static btg_status drop(void *opened, const btg_drop_query *queries, size_t count,
                       btg_drop_result *results) {
    state *s = opened;
    for (size_t i = 0; i < count; i += s->device.capacity) {
        btg_status status = drop_some(s, queries + i, share(s, count - i), results + i);
        if (status != BTG_OK) return status;
    }
    return BTG_OK;
}

static btg_status tilt(void *opened, const btg_tilt_query *queries, size_t count,
                       btg_tilt_result *results) {
    state *s = opened;
    for (size_t i = 0; i < count; i += s->device.capacity) {
        btg_status status = tilt_some(s, queries + i, share(s, count - i), results + i);
        if (status != BTG_OK) return status;
    }
    return BTG_OK;
}

static uint32_t threads(void *opened) {
    const state *s = opened;
    return btg_backend_cpu.threads(s->core);
}

static void times(void *opened, btg_backend_times *out) {
    *out = ((const state *)opened)->times;
}

const btg_backend_table btg_backend_vulkan = {
    .name = "vulkan",
    .summary = "DROP and TILT by Vulkan compute: searched in single precision on the device, "
               "polished and proven in double",
    .probe = probe,
    .open = open,
    .close = close,
    .drop = drop,
    .tilt = tilt,
    .threads = threads,
    .times = times,
    .block = DISPATCH,
};
