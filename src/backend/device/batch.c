#define _POSIX_C_SOURCE 200809L
#include "backend/device/batch.h"
#include "core/part.h"

#include <time.h>

typedef struct batch {
    btg_backend_setup setup;
    const btg_device_ops *ops;
    void *device;
    btg_scene scene; /* its geometry is on the device alone */
    void *core;      /* the cpu back end: polishes */
    uint32_t capacity;
    btg_status failed; /* of the device */
    btg_gpu_query *queries;
    btg_gpu_winner *winners;
    double *shifts[BTG_BATCH_SLOTS];
    btg_drop_query *drops; /* of one dispatch, with their starts */
    btg_tilt_query *tilts;
    btg_backend_times times;
} batch;

/* One call's work; either of the two. */
typedef struct work {
    const btg_drop_query *drops;
    btg_drop_result *dropped;
    const btg_tilt_query *tilts;
    btg_tilt_result *tilted;
    size_t count;
} work;

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

void btg_batch_close(void *state) {
    batch *b = state;
    btg_allocator allocator = b->setup.allocator;
    if (b->core) btg_backend_cpu.close(b->core);
    if (b->device) b->ops->stop(b->device);
    btg_scene_free(&allocator, &b->scene);
    btg_release(&allocator, b->queries);
    btg_release(&allocator, b->winners);
    for (int i = 0; i < BTG_BATCH_SLOTS; i++)
        btg_release(&allocator, b->shifts[i]);
    btg_release(&allocator, b->drops);
    btg_release(&allocator, b->tilts);
    btg_release(&allocator, b);
}

static btg_status make_room(batch *b, btg_message *message) {
    const btg_allocator *a = &b->setup.allocator;
    b->queries = btg_allocate(a, b->capacity, sizeof *b->queries);
    b->winners = btg_allocate(a, b->capacity, sizeof *b->winners);
    b->drops = btg_allocate(a, b->capacity, sizeof *b->drops);
    b->tilts = btg_allocate(a, b->capacity, sizeof *b->tilts);
    bool all = b->queries && b->winners && b->drops && b->tilts;
    for (int i = 0; i < BTG_BATCH_SLOTS; i++) {
        b->shifts[i] = btg_allocate(a, b->capacity, sizeof *b->shifts[i]);
        all = all && b->shifts[i];
    }
    return all ? BTG_OK
               : btg_fail(message, BTG_ERROR_MEMORY, "%s: out of memory for %lu queries at once",
                          b->ops->name, (unsigned long)b->capacity);
}

/* Queries that one dispatch and one buffer take. */
static uint32_t capacity_of(uint32_t wanted, const btg_device_limits *limits) {
    size_t fit = limits->buffer_bytes / sizeof(btg_gpu_query);
    uint32_t most = limits->groups < wanted ? limits->groups : wanted;
    return fit < most ? (uint32_t)fit : most;
}

static btg_status fill(batch *b, const void *user, uint32_t dispatch, btg_message *message) {
    btg_device_limits limits;
    btg_status status = b->ops->start(&b->setup, user, &b->device, &limits, message);
    if (status != BTG_OK) return status;
    b->capacity = capacity_of(dispatch > 0 ? dispatch : BTG_BATCH_DISPATCH, &limits);
    if (b->capacity == 0)
        return btg_fail(message, BTG_ERROR_UNSUPPORTED, "%s: the device takes no query at all",
                        b->ops->name);
    status = make_room(b, message);
    if (status == BTG_OK)
        status = btg_scene_make(&b->setup, &b->ops->cells, limits.buffer_bytes, &b->scene, message);
    if (status != BTG_OK) return status;
    status = b->ops->load(b->device, &b->scene, b->capacity, &b->times.device_bytes, message);
    btg_release(&b->setup.allocator, b->scene.geometry);
    b->scene.geometry = NULL;
    if (status == BTG_OK) status = btg_backend_cpu.open(&b->setup, &b->core, message);
    return status;
}

btg_status btg_batch_open(const btg_device_ops *ops, const void *user, uint32_t dispatch,
                          const btg_backend_setup *setup, void **state, btg_message *message) {
    batch *b = btg_allocate(&setup->allocator, 1, sizeof *b);
    if (!b) return btg_fail(message, BTG_ERROR_MEMORY, "%s: out of memory", ops->name);
    *b = (batch){.setup = *setup, .ops = ops};
    btg_status status = fill(b, user, dispatch, message);
    if (status != BTG_OK)
        btg_batch_close(b);
    else
        *state = b;
    return status;
}

/* ---- dispatches --------------------------------------------------------------------------- */

static uint32_t share(const batch *b, const work *w, size_t first) {
    size_t left = w->count - first;
    return left < b->capacity ? (uint32_t)left : b->capacity;
}

static btg_status hand_over(batch *b, const work *w, uint32_t slot, size_t first) {
    double since = now();
    uint32_t count = share(b, w, first);
    for (uint32_t i = 0; i < count; i++) {
        if (w->drops)
            btg_gpu_pack_drop(&b->scene, &w->drops[first + i], &b->queries[i], &b->shifts[slot][i]);
        else
            btg_gpu_pack_tilt(&b->setup, &b->scene, &w->tilts[first + i], &b->queries[i]);
    }
    btg_op op = w->drops ? BTG_OP_DROP : BTG_OP_TILT;
    btg_status status = b->ops->write(b->device, slot, b->queries, count);
    lap(&since, &b->times.upload_s);
    if (status == BTG_OK) status = b->ops->dispatch(b->device, slot, op, count);
    lap(&since, &b->times.device_s);
    return status;
}

static void take_drop(batch *b, const work *w, uint32_t slot, size_t first, uint32_t i) {
    const btg_drop_query *query = &w->drops[first + i];
    if (b->setup.raw) {
        btg_gpu_raw_drop(&b->setup, query, &b->winners[i], b->shifts[slot][i],
                         &w->dropped[first + i]);
        return;
    }
    b->drops[i] = *query;
    if (btg_gpu_start(&b->setup, &b->winners[i], &b->drops[i].start)) b->drops[i].has_start = 1;
}

static void take_tilt(batch *b, const work *w, size_t first, uint32_t i) {
    const btg_tilt_query *query = &w->tilts[first + i];
    if (b->setup.raw) {
        btg_gpu_raw_tilt(&b->setup, query, &b->winners[i], &w->tilted[first + i]);
        return;
    }
    b->tilts[i] = *query;
    if (btg_gpu_start_tilt(&b->setup, query, &b->winners[i], &b->tilts[i].start))
        b->tilts[i].has_start = 1;
}

static btg_status polish(batch *b, const work *w, size_t first, uint32_t count) {
    if (b->setup.raw) return BTG_OK;
    return w->drops ? btg_backend_cpu.drop(b->core, b->drops, count, w->dropped + first)
                    : btg_backend_cpu.tilt(b->core, b->tilts, count, w->tilted + first);
}

static btg_status take_back(batch *b, const work *w, uint32_t slot, size_t first) {
    double since = now();
    uint32_t count = share(b, w, first);
    btg_status status = b->ops->wait(b->device, slot);
    lap(&since, &b->times.device_s);
    if (status == BTG_OK) status = b->ops->read(b->device, slot, b->winners, count);
    if (status != BTG_OK) return status;
    for (uint32_t i = 0; i < count; i++) {
        if (w->drops)
            take_drop(b, w, slot, first, i);
        else
            take_tilt(b, w, first, i);
    }
    lap(&since, &b->times.readback_s);
    return BTG_OK;
}

/* The next dispatch is handed over before the winners of this one are polished. */
static btg_status run(batch *b, const work *w) {
    if (b->failed != BTG_OK) return b->failed;
    btg_status status = hand_over(b, w, 0, 0);
    uint32_t slot = 0;
    for (size_t first = 0; first < w->count && status == BTG_OK; first += b->capacity) {
        uint32_t other = (slot + 1) % BTG_BATCH_SLOTS, count = share(b, w, first);
        if (w->count - first > count) status = hand_over(b, w, other, first + count);
        if (status == BTG_OK) status = take_back(b, w, slot, first);
        if (status != BTG_OK) break;
        double since = now();
        status = polish(b, w, first, count);
        lap(&since, &b->times.polish_s);
        slot = other;
    }
    b->failed = status;
    return status;
}

btg_status btg_batch_drop(void *state, const btg_drop_query *queries, size_t count,
                          btg_drop_result *results) {
    work w = {.drops = queries, .dropped = results, .count = count};
    return run(state, &w);
}

btg_status btg_batch_tilt(void *state, const btg_tilt_query *queries, size_t count,
                          btg_tilt_result *results) {
    work w = {.tilts = queries, .tilted = results, .count = count};
    return run(state, &w);
}

uint32_t btg_batch_threads(void *state) {
    return btg_backend_cpu.threads(((const batch *)state)->core);
}

void btg_batch_times(void *state, btg_backend_times *times) {
    *times = ((const batch *)state)->times;
}
