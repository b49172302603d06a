/* Batches on a device that does as it is told: cut to its limits, two dispatches in flight at the
 * most, every way to fail told by its status, and `auto` going on elsewhere. */
#include "backend/device/batch.h"
#include "check.h"
#include "core/part.h"

#include <stdlib.h>
#include <string.h>

#define COUNT 100

/* What the device does; the test's own, there is one thread. */
static struct {
    uint32_t groups;
    btg_status start, load, write, dispatch, wait, read;
    uint32_t spoil_after; /* calls that work before those statuses count */
    uint32_t calls;
    /* What it saw. */
    uint32_t capacity, most, dispatches, in_flight, most_in_flight;
    int alive;
    bool misused;
    bool running[BTG_BATCH_SLOTS];
} device;

static btg_status say(btg_status status) {
    return device.calls++ < device.spoil_after ? BTG_OK : status;
}

static btg_status start(const btg_backend_setup *setup, const void *user, void **made,
                        btg_device_limits *limits, btg_message *message) {
    (void)setup, (void)user;
    if (device.start != BTG_OK) return btg_fail(message, device.start, "no such device");
    *limits = (btg_device_limits){1 << 24, device.groups};
    *made = &device;
    device.alive++;
    return BTG_OK;
}

static btg_status load(void *d, const btg_scene *scene, uint32_t capacity, size_t *bytes,
                       btg_message *message) {
    (void)d;
    device.capacity = capacity;
    *bytes = scene->count * sizeof *scene->geometry;
    if (device.load == BTG_OK) return BTG_OK;
    return btg_fail(message, device.load, "it does not fit");
}

static btg_status write(void *d, uint32_t slot, const btg_gpu_query *queries, uint32_t count) {
    (void)d;
    if (device.running[slot] || count == 0 || count > device.capacity || !queries)
        device.misused = true;
    return say(device.write);
}

static btg_status dispatch(void *d, uint32_t slot, btg_op op, uint32_t count) {
    (void)d, (void)op;
    device.running[slot] = true;
    device.dispatches++;
    if (count > device.most) device.most = count;
    if (++device.in_flight > device.most_in_flight) device.most_in_flight = device.in_flight;
    return say(device.dispatch);
}

static btg_status wait(void *d, uint32_t slot) {
    (void)d;
    if (!device.running[slot]) device.misused = true;
    device.running[slot] = false;
    device.in_flight--;
    return say(device.wait);
}

/* Finds nothing, or nonsense: the core knows better. */
static btg_status read(void *d, uint32_t slot, btg_gpu_winner *winners, uint32_t count) {
    (void)d, (void)slot;
    for (uint32_t i = 0; i < count; i++)
        winners[i] = (btg_gpu_winner){.found = i % 3 > 0,
                                      .item = i % 3 > 1 ? 77 : 0,
                                      .u = i % 2 > 0 ? NAN : 0.5f,
                                      .v = 0.25f};
    return say(device.read);
}

static void stop(void *d) {
    (void)d;
    device.alive--;
}

static const btg_device_ops ops = {.name = "told",
                                   .start = start,
                                   .load = load,
                                   .write = write,
                                   .dispatch = dispatch,
                                   .wait = wait,
                                   .read = read,
                                   .stop = stop};

static btg_backend_state probe(char *name, size_t size) {
    snprintf(name, size, "%s", device.start == BTG_OK ? "as told" : "no such device");
    return device.start == BTG_OK ? BTG_BACKEND_READY : BTG_BACKEND_NO_DEVICE;
}

static btg_status open_told(const btg_backend_setup *setup, void **state, btg_message *message) {
    return btg_batch_open(&ops, NULL, 16, setup, state, message);
}

static const btg_backend_table told = {.name = "told",
                                       .summary = "",
                                       .probe = probe,
                                       .open = open_told,
                                       .close = btg_batch_close,
                                       .drop = btg_batch_drop,
                                       .tilt = btg_batch_tilt,
                                       .threads = btg_batch_threads,
                                       .times = btg_batch_times};

/* ---- work --------------------------------------------------------------------------------- */

static btg_part *part;
static btg_tool tool;
static btg_solver_def solver;
static double feet[2 * COUNT];
static btg_position expected[COUNT];

static void make_work(void) {
    static const double height[9] = {10, 4, 9, 3, 14, 2, 8, 5, 11};
    double points[27];
    for (int i = 0; i < 9; i++) {
        points[3 * i] = 50 * (i / 3);
        points[3 * i + 1] = 50 * (i % 3);
        points[3 * i + 2] = height[i];
    }
    btg_surface_def surface = {2, 2, 3, 3, points, NULL, NULL, NULL};
    btg_part_def def = btg_part_def_default();
    btg_tool_def tool_def = btg_tool_def_default();
    def.surfaces = &surface;
    def.surface_count = 1;
    CHECK(btg_part_create(&def, &part, NULL) == BTG_OK);
    CHECK(btg_tool_init(&tool_def, &tool, NULL) == BTG_OK);
    solver = btg_solver_def_default();
    for (int i = 0; i < COUNT; i++) {
        feet[2 * i] = 10.3 * (i % 10);
        feet[2 * i + 1] = 9.9 * (double)(i / 10);
    }
}

static btg_status open_front(const btg_backend_table *table, const void *user, btg_backend **b,
                             btg_message *message) {
    btg_backend_def def = btg_backend_def_default();
    def.threads = 1;
    *b = NULL;
    return btg_backend_open_table(table, user, &def, part, &tool, &solver, b, message);
}

static void reset(void) {
    memset(&device, 0, sizeof device);
    device.groups = 65535;
}

/* The cpu's answers to what doubles show. */
static void check_answers(const btg_position *positions) {
    for (int i = 0; i < COUNT; i++) {
        CHECK(positions[i].status == expected[i].status);
        CHECK(fabs(positions[i].drop_z_mm - expected[i].drop_z_mm) < 1e-9);
        CHECK(!(fabs(positions[i].tilt_rad - expected[i].tilt_rad) > 1e-7));
    }
}

/* ---- tests -------------------------------------------------------------------------------- */

static void test_cut(void) {
    static const uint32_t groups[3] = {65535, 5, 1};
    btg_position positions[COUNT];
    for (int i = 0; i < 3; i++) {
        btg_backend *b;
        reset();
        device.groups = groups[i];
        CHECK(open_front(&told, NULL, &b, NULL) == BTG_OK);
        if (!b) continue;
        CHECK(btg_backend_positions(b, feet, COUNT, positions, NULL) == BTG_OK);
        check_answers(positions);
        uint32_t capacity = groups[i] < 16 ? groups[i] : 16;
        CHECK(device.capacity == capacity && device.most <= capacity);
        CHECK(device.dispatches > COUNT / capacity);
        CHECK(device.most_in_flight == 2 && device.in_flight == 0 && !device.misused);
        btg_backend_close(b);
        CHECK(device.alive == 0);
    }
    reset();
    device.groups = 0;
    btg_backend *b;
    btg_message message = {""};
    CHECK(open_front(&told, NULL, &b, &message) == BTG_ERROR_UNSUPPORTED);
    CHECK(strstr(message.text, "told") && device.alive == 0);
}

/* An error at every place a device can fail is the batch's status; then nothing more is asked of
 * it. */
static void test_failures(void) {
    static const btg_status errors[2] = {BTG_ERROR_DEVICE, BTG_ERROR_MEMORY};
    btg_status *const places[4] = {&device.write, &device.dispatch, &device.wait, &device.read};
    btg_position positions[COUNT];
    for (int i = 0; i < 8; i++) {
        btg_backend *b;
        reset();
        *places[i / 2] = errors[i % 2];
        device.spoil_after = 5;
        CHECK(open_front(&told, NULL, &b, NULL) == BTG_OK);
        if (!b) continue;
        CHECK(btg_backend_positions(b, feet, COUNT, positions, NULL) == errors[i % 2]);
        uint32_t calls = device.calls;
        CHECK(btg_backend_positions(b, feet, 1, positions, NULL) == errors[i % 2]);
        CHECK(device.calls == calls && !device.misused);
        btg_backend_close(b);
        CHECK(device.alive == 0);
    }
    reset();
    device.load = BTG_ERROR_MEMORY;
    btg_backend *b;
    btg_message message = {""};
    CHECK(open_front(&told, NULL, &b, &message) == BTG_ERROR_MEMORY);
    CHECK(strstr(message.text, "does not fit") && device.alive == 0);
}

/* With another one behind it the work is done all the same, and the caller hears why. */
static void test_goes_on(void) {
    const btg_backend_table *const tables[2] = {&btg_backend_cpu, &told};
    const btg_fallback_def begin_told = {tables, 2, &told}, alone = {tables + 1, 1, NULL},
                           in_order = {tables, 2, NULL};
    btg_position positions[COUNT];
    for (int i = 0; i < 5; i++) {
        btg_backend *b;
        btg_message message = {""};
        reset();
        device.spoil_after = 9;
        if (i == 1) device.wait = BTG_ERROR_DEVICE;
        if (i == 2) device.start = BTG_ERROR_NO_DEVICE;
        if (i == 3) device.load = BTG_ERROR_MEMORY;
        const btg_fallback_def *def = i == 4 ? &in_order : &begin_told;
        CHECK(open_front(&btg_backend_fallback, def, &b, &message) == BTG_OK);
        if (!b) continue;
        CHECK(btg_backend_positions(b, feet, COUNT, positions, NULL) == BTG_OK);
        check_answers(positions);
        static const char *const ran[5] = {"told", "cpu", "cpu", "cpu", "cpu"};
        static const char *const note[5] = {"", "told: the device was lost", "told: no such device",
                                            "told: it does not fit", ""};
        CHECK(strcmp(btg_backend_name(b), ran[i]) == 0);
        CHECK(strncmp(btg_backend_note(b), note[i], strlen(note[i])) == 0);
        CHECK((note[i][0] == '\0') == (btg_backend_note(b)[0] == '\0'));
        btg_backend_close(b);
        CHECK(device.alive == 0);
    }
    reset();
    device.dispatch = BTG_ERROR_DEVICE;
    btg_backend *b;
    CHECK(open_front(&btg_backend_fallback, &alone, &b, NULL) == BTG_OK);
    if (!b) return;
    CHECK(btg_backend_positions(b, feet, COUNT, positions, NULL) == BTG_ERROR_DEVICE);
    CHECK(btg_backend_positions(b, feet, COUNT, positions, NULL) == BTG_ERROR_DEVICE);
    btg_backend_close(b);
    CHECK(device.alive == 0);
}

int main(void) {
    btg_backend *cpu;
    make_work();
    CHECK(open_front(&btg_backend_cpu, NULL, &cpu, NULL) == BTG_OK);
    if (!cpu) return check_result();
    CHECK(btg_backend_positions(cpu, feet, COUNT, expected, NULL) == BTG_OK);
    btg_backend_close(cpu);
    test_cut();
    test_failures();
    test_goes_on();
    btg_part_destroy(part);
    return check_result();
}
