/* A million positions in one stream: the time is told, memory does not grow with the path. */
#include "listing.h"

#include <time.h>

#define POSITIONS 1000000
#define PASS      1000

#define WINDOW     20000
#define MEMORY_MAX (16u << 20)

static size_t allocated, written;

static void *allocate(size_t size, void *user) {
    (void)user;
    allocated += size;
    return malloc(size);
}

static void release(void *memory, void *user) {
    (void)user;
    free(memory);
}

static btg_status count(const char *text, size_t size, void *user) {
    (void)text, (void)user;
    written += size;
    return BTG_OK;
}

/* Of this process: other work on the machine does not count. */
static double now(void) {
    return (double)clock() / CLOCKS_PER_SEC;
}

/* A wavy part; the axis passes close to the pole and winds about it. */
static btg_position position(int i) {
    double x = 150.0 * (i / PASS) / (POSITIONS / PASS), y = 150.0 * (i % PASS) / PASS;
    btg_position p = {.tip = {x, y, 80 + 10 * sin(x / 30) * cos(y / 25)}};
    p.axis = vec_unit(vec(0.2 * cos(x / 30) * cos(y / 25), 0.2 * sin(y / 20), 1));
    return p;
}

static void run(const char *name, int positions) {
    btg_machine_def d;
    btg_machine machine = {.def = {.version = 0}};
    btg_tool tool = listing_tool();
    btg_program_def def = btg_program_def_default();
    btg_program_info info;
    btg_program *p = NULL;
    CHECK(btg_machine_find(name, &d) == BTG_OK);
    CHECK(btg_machine_init(&d, &machine, NULL) == BTG_OK);
    def.clear_z_mm = 120;
    def.window = WINDOW;
    def.allocator = (btg_allocator){allocate, release, NULL};
    def.write = count;
    allocated = written = 0;
    double begin = now();
    CHECK(btg_program_create(&def, &machine, &tool, &p, NULL) == BTG_OK);
    for (int i = 0; i < positions; i++) {
        btg_position at = position(i);
        CHECK(btg_program_add(p, &at, i % PASS > 0, NULL) == BTG_OK);
    }
    CHECK(btg_program_end(p, &info, NULL) == BTG_OK);
    double seconds = now() - begin;
    btg_program_destroy(p);
    printf("%s: %d positions in %.2f s, %zu bytes written, %zu allocated\n", name, positions,
           seconds, written, allocated);
    CHECK(info.positions == (uint64_t)positions && info.gaps == 0);
    CHECK(allocated < MEMORY_MAX);
}

int main(void) {
    /* Sanitized, for the memory alone. */
    int positions = getenv("BTG_TEST_QUICK") ? POSITIONS / 20 : POSITIONS;
    run("xyzac-trt", positions);
    run("siemens", positions);
    return check_result();
}
