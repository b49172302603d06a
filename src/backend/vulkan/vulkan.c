/* Vulkan compute: a device finds the places, the core starts from them and proves its answers. */
#include "backend/vulkan/vulkan.h"
#include "backend/vulkan/device.h"
#include "core/part.h"

#include <stdio.h>
#include <string.h>

static btg_backend_state probe(char *device, size_t size) {
    btg_vulkan vk;
    btg_message message = {""};
    bool found = btg_vulkan_find(NULL, &vk, &message) == BTG_OK;
    bool ready = found && btg_vulkan_start(&vk, &message) == BTG_OK;
    snprintf(device, size, "%s", ready ? vk.name : message.text);
    if (found) btg_vulkan_end(&vk);
    return ready ? BTG_BACKEND_READY : BTG_BACKEND_NO_DEVICE;
}

/* ---- a device as the batches use it ------------------------------------------------------- */

typedef struct state {
    btg_vulkan_device device;
    btg_allocator allocator;
} state;

static void stop(void *device) {
    state *s = device;
    btg_vulkan_unload(&s->device);
    btg_vulkan_end(&s->device.vk);
    btg_allocator allocator = s->allocator;
    btg_release(&allocator, s);
}

static btg_status start(const btg_backend_setup *setup, const void *debug, void **device,
                        btg_device_limits *limits, btg_message *message) {
    state *s = btg_allocate(&setup->allocator, 1, sizeof *s);
    if (!s) return btg_fail(message, BTG_ERROR_MEMORY, "vulkan: out of memory");
    *s = (state){.allocator = setup->allocator};
    btg_status status = btg_vulkan_find(debug, &s->device.vk, message);
    if (status == BTG_OK) status = btg_vulkan_start(&s->device.vk, message);
    if (status != BTG_OK) {
        stop(s);
        return status;
    }
    const VkPhysicalDeviceLimits *all = &s->device.vk.limits;
    *limits = (btg_device_limits){all->maxStorageBufferRange, all->maxComputeWorkGroupCount[0]};
    *device = s;
    return BTG_OK;
}

static btg_status load(void *device, const btg_scene *scene, uint32_t capacity, size_t *bytes,
                       btg_message *message) {
    btg_vulkan_device *d = &((state *)device)->device;
    btg_status status = btg_vulkan_load(d, scene, capacity, message);
    *bytes = d->bytes;
    return status;
}

static btg_status write(void *device, uint32_t slot, const btg_gpu_query *queries, uint32_t count) {
    const state *s = device;
    memcpy(s->device.slot[slot].queries.mapped, queries, count * sizeof *queries);
    return BTG_OK;
}

static btg_status dispatch(void *device, uint32_t slot, btg_op op, uint32_t count) {
    return btg_vulkan_dispatch(&((state *)device)->device, slot, op, count);
}

static btg_status wait(void *device, uint32_t slot) {
    return btg_vulkan_wait(&((state *)device)->device, slot);
}

static btg_status read(void *device, uint32_t slot, btg_gpu_winner *winners, uint32_t count) {
    const state *s = device;
    memcpy(winners, s->device.slot[slot].winners.mapped, count * sizeof *winners);
    return BTG_OK;
}

static const btg_device_ops ops = {.name = "vulkan",
                                   .start = start,
                                   .load = load,
                                   .write = write,
                                   .dispatch = dispatch,
                                   .wait = wait,
                                   .read = read,
                                   .stop = stop};

/* ---- table -------------------------------------------------------------------------------- */

btg_status btg_vulkan_open_debug(const btg_vulkan_debug *debug, uint32_t dispatch,
                                 const btg_backend_setup *setup, void **opened,
                                 btg_message *message) {
    return btg_batch_open(&ops, debug, dispatch, setup, opened, message);
}

static btg_status open(const btg_backend_setup *setup, void **opened, btg_message *message) {
    return btg_batch_open(&ops, NULL, 0, setup, opened, message);
}

const btg_backend_table btg_backend_vulkan = {
    .name = "vulkan",
    .summary = "DROP and TILT by Vulkan compute: searched in single precision on the device, "
               "polished and proven in double",
    .probe = probe,
    .open = open,
    .close = btg_batch_close,
    .drop = btg_batch_drop,
    .tilt = btg_batch_tilt,
    .threads = btg_batch_threads,
    .times = btg_batch_times,
    .block = BTG_BATCH_BLOCK,
};
