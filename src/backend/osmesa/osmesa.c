/* Depth images by OpenGL without a window: a rasteriser finds the places, the core starts from them
 * and proves its answers. */
#include "backend/osmesa/osmesa.h"
#include "backend/osmesa/search.h"
#include "backend/device/batch.h"
#include "core/part.h"

#include <stdio.h>
#include <string.h>

/* Queries at once. */
#define CAPACITY 1024
/* What the part is cut into, as parts of the tool's radius: cells so small that views hardly bend
 * them, quadratic pieces that stand off the part by the sagitta at the most. Of two levels the fine
 * one cuts them again, eight times along each side. */
#define ONE_SIDE    0.1
#define ONE_SAGITTA 1e-5
#define TWO_SIDE    0.4
#define TWO_SAGITTA 1e-4

typedef struct state {
    btg_allocator allocator;
    btg_context *context;
    uint32_t atlas;
    btg_raster_search search;
    btg_gpu_winner *winners[BTG_BATCH_SLOTS];
} state;

static btg_backend_state probe(char *device, size_t size) {
    const btg_allocator allocator = {0};
    btg_context *context = NULL;
    btg_message message = {""};
    size_t bytes = 0;
    uint32_t side = 0;
    btg_status status = btg_context_open(NULL, &allocator, &context, &message);
    if (status == BTG_OK) status = btg_context_enter(context);
    if (status == BTG_OK) {
        status = btg_raster_limits(context, &bytes, &side, &message);
        btg_context_leave(context);
    }
    if (status == BTG_OK)
        snprintf(device, size, "%.150s; by %s; %zu MB a buffer, %lu pixels a side",
                 btg_context_name(context), btg_context_provider(context), bytes >> 20,
                 (unsigned long)side);
    else
        snprintf(device, size, "%s", message.text);
    btg_context_close(context);
    return status == BTG_OK ? BTG_BACKEND_READY : BTG_BACKEND_NO_DEVICE;
}

/* ---- a device as the batches use it ------------------------------------------------------- */

static void stop(void *device) {
    state *s = device;
    btg_allocator allocator = s->allocator;
    if (s->context && btg_context_enter(s->context) == BTG_OK) {
        btg_raster_unload(&s->search.raster);
        btg_context_leave(s->context);
    }
    btg_context_close(s->context);
    btg_raster_search_free(&s->search, &allocator);
    for (int i = 0; i < BTG_BATCH_SLOTS; i++)
        btg_release(&allocator, s->winners[i]);
    btg_release(&allocator, s);
}

static btg_status begin(state *s, const btg_context_def *context, btg_device_limits *limits,
                        btg_message *message) {
    uint32_t side = 0;
    btg_status status = btg_context_open(context, &s->allocator, &s->context, message);
    if (status != BTG_OK) return status;
    status = btg_context_enter(s->context);
    if (status != BTG_OK) return btg_fail(message, status, "osmesa: the context is refused");
    status = btg_raster_limits(s->context, &limits->buffer_bytes, &side, message);
    btg_context_leave(s->context);
    limits->groups = CAPACITY;
    s->atlas = btg_raster_search_atlas(&s->search.options, side);
    if (status == BTG_OK && s->atlas < s->search.options.window) {
        return btg_fail(message, BTG_ERROR_UNSUPPORTED,
                        "osmesa: a window of %lu pixels; the device has %lu at the most",
                        (unsigned long)s->search.options.window, (unsigned long)side);
    }
    return status;
}

static btg_status start(const btg_backend_setup *setup, const void *context, void **device,
                        btg_device_limits *limits, btg_message *message) {
    state *s = btg_allocate(&setup->allocator, 1, sizeof *s);
    if (!s) return btg_fail(message, BTG_ERROR_MEMORY, "osmesa: out of memory");
    *s = (state){.allocator = setup->allocator};
    s->search.part = setup->part;
    s->search.tool = setup->tool;
    s->search.options = (btg_raster_options){setup->levels, setup->window};
    const btg_context_def named = {.provider = setup->gl_context};
    btg_status status = begin(s, context ? context : &named, limits, message);
    if (status != BTG_OK)
        stop(s);
    else
        *device = s;
    return status;
}

/* The scene's geometry goes to the device; a copy stays for the choice of cells. */
static btg_status copy_scene(state *s, const btg_scene *scene, btg_message *message) {
    btg_gpu_vec4 *geometry = btg_allocate(&s->allocator, scene->count, sizeof *geometry);
    if (!geometry) return btg_fail(message, BTG_ERROR_MEMORY, "osmesa: out of memory");
    memcpy(geometry, scene->geometry, scene->count * sizeof *geometry);
    s->search.scene = *scene;
    s->search.scene.geometry = geometry;
    return BTG_OK;
}

static btg_status load(void *device, const btg_scene *scene, uint32_t capacity, size_t *bytes,
                       btg_message *message) {
    state *s = device;
    btg_status status = copy_scene(s, scene, message);
    if (status == BTG_OK)
        status = btg_raster_search_room(&s->search, &s->allocator, capacity, message);
    if (status != BTG_OK) return status;
    for (int i = 0; i < BTG_BATCH_SLOTS; i++) {
        s->winners[i] = btg_allocate(&s->allocator, capacity, sizeof *s->winners[i]);
        if (!s->winners[i]) return btg_fail(message, BTG_ERROR_MEMORY, "osmesa: out of memory");
    }
    status = btg_context_enter(s->context);
    if (status != BTG_OK) return btg_fail(message, status, "osmesa: the context is refused");
    status = btg_raster_load(&s->search.raster, s->context, scene, s->atlas,
                             s->search.options.window, bytes, message);
    btg_context_leave(s->context);
    return status;
}

static btg_status write(void *device, uint32_t slot, const btg_gpu_query *queries, uint32_t count) {
    state *s = device;
    (void)slot;
    memcpy(s->search.queries, queries, count * sizeof *queries);
    return BTG_OK;
}

/* Each level's windows depend on the one before: the work is done here, before it returns. */
static btg_status dispatch(void *device, uint32_t slot, btg_op op, uint32_t count) {
    state *s = device;
    btg_status status = btg_context_enter(s->context);
    if (status != BTG_OK) return status;
    status = btg_raster_search_run(&s->search, op, count, s->winners[slot]);
    btg_context_leave(s->context);
    return status;
}

static btg_status wait(void *device, uint32_t slot) {
    (void)device;
    (void)slot;
    return BTG_OK;
}

static btg_status read(void *device, uint32_t slot, btg_gpu_winner *winners, uint32_t count) {
    const state *s = device;
    memcpy(winners, s->winners[slot], count * sizeof *winners);
    return BTG_OK;
}

#define OPS(side, sagitta)                                                                         \
    {                                                                                              \
        .name = "osmesa", .cells = {side, 1, sagitta}, .start = start, .load = load,               \
        .write = write, .dispatch = dispatch, .wait = wait, .read = read, .stop = stop             \
    }

/* By levels. */
static const btg_device_ops one = OPS(ONE_SIDE, ONE_SAGITTA), two = OPS(TWO_SIDE, TWO_SAGITTA);

btg_status btg_osmesa_open_with(const btg_context_def *context, const btg_backend_setup *setup,
                                void **opened, btg_message *message) {
    const btg_device_ops *ops = setup->levels == 1 ? &one : &two;
    return btg_batch_open(ops, context, CAPACITY, setup, opened, message);
}

static btg_status open(const btg_backend_setup *setup, void **opened, btg_message *message) {
    return btg_osmesa_open_with(NULL, setup, opened, message);
}

const btg_backend_table btg_backend_osmesa = {
    .name = "osmesa",
    .summary = "DROP and TILT by depth images, OpenGL without a window: polished and proven in "
               "double",
    .probe = probe,
    .open = open,
    .close = btg_batch_close,
    .drop = btg_batch_drop,
    .tilt = btg_batch_tilt,
    .threads = btg_batch_threads,
    .times = btg_batch_times,
    .block = 4 * CAPACITY,
};
