/* What btg_part_create refuses, and that it gives back all memory when it runs out of it. */
#include "check.h"
#include "core/part.h"

#include "../conformance/model.h"
#include "../conformance/rng.h"

#include <stdlib.h>
#include <string.h>

/* ---- memory that is counted and runs out --------------------------------------------------- */

typedef struct budget {
    long left;      /* allocations still granted; < 0: all */
    long live, all; /* blocks */
    size_t bytes;
} budget;

static void *grant(size_t size, void *user) {
    budget *b = user;
    if (b->left == 0) return NULL;
    if (b->left > 0) b->left--;
    b->live++;
    b->all++;
    b->bytes += size;
    return malloc(size);
}

static void take_back(void *memory, void *user) {
    budget *b = user;
    if (memory) b->live--;
    free(memory);
}

/* ---- refusals ------------------------------------------------------------------------------ */

static btg_status create(const btg_part_def *def, btg_message *message) {
    btg_part *part = (btg_part *)&check_failures; /* must stay as it is on error */
    memset(message, 0, sizeof *message);
    btg_status status = btg_part_create(def, &part, message);
    if (status == BTG_OK)
        btg_part_destroy(part);
    else
        CHECK(part == (btg_part *)&check_failures);
    return status;
}

static void refused(const btg_part_def *def, btg_status want, int line) {
    btg_message message;
    budget b = {.left = -1};
    btg_part_def counted = *def;
    counted.allocator = (btg_allocator){grant, take_back, &b};
    btg_status got = create(&counted, &message);
    if (got != want) fprintf(stderr, "line %d: status %d, want %d\n", line, got, want);
    CHECK(got == want);
    CHECK(message.text[0] != 0 && memchr(message.text, 0, sizeof message.text));
    CHECK(b.live == 0);
}

#define REFUSED(def) refused(&(def), BTG_ERROR_ARGUMENT, __LINE__)

static const double grid[12] = {0, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 1};

static btg_surface_def good_surface(void) {
    return (btg_surface_def){1, 1, 2, 2, grid, NULL, NULL, NULL};
}

static btg_part_def part_of(const btg_surface_def *surface) {
    btg_part_def def = btg_part_def_default();
    def.surfaces = surface;
    def.surface_count = 1;
    return def;
}

static void refuse_counts(void) {
    const int bad[][4] = {{0, 1, 1, 2},
                          {1, 0, 2, 1},
                          {10, 1, 11, 2},
                          {1, 10, 2, 11},
                          {1, 1, 1, 2},
                          {1, 1, 2, 1},
                          {3, 1, 3, 2},
                          {-1, 1, 2, 2},
                          {1, 1, -2, 2},
                          {1, 1, 2, -2},
                          {1, 1, 2147483647, 2147483647},
                          {1, 1, 2, 2147483647}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        btg_surface_def s = good_surface();
        s.degree_u = bad[i][0], s.degree_v = bad[i][1];
        s.count_u = bad[i][2], s.count_v = bad[i][3];
        btg_part_def def = part_of(&s);
        REFUSED(def);
    }
    /* more points than degree + 1 without knots is no Bezier patch */
    double more[18] = {0};
    btg_surface_def s = {1, 1, 3, 2, more, NULL, NULL, NULL};
    btg_part_def def = part_of(&s);
    REFUSED(def);
}

static void refuse_numbers(void) {
    const double bad[] = {NAN, INFINITY, -INFINITY, 1e300, 2 * BTG_LENGTH_MAX};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        for (int k = 0; k < 12; k++) {
            double points[12];
            memcpy(points, grid, sizeof points);
            points[k] = bad[i];
            btg_surface_def s = good_surface();
            s.control_points = points;
            btg_part_def def = part_of(&s);
            REFUSED(def);
        }
    const double weights[] = {0, -1, NAN, INFINITY};
    for (size_t i = 0; i < sizeof weights / sizeof *weights; i++) {
        double w[4] = {1, 1, 1, weights[i]};
        btg_surface_def s = good_surface();
        s.weights = w;
        btg_part_def def = part_of(&s);
        REFUSED(def);
    }
    btg_surface_def s = good_surface();
    s.control_points = NULL;
    btg_part_def def = part_of(&s);
    REFUSED(def);
}

static void refuse_knots(void) {
    double points[24] = {0};
    for (int i = 0; i < 24; i++)
        points[i] = i * 0.25;
    const double good[7] = {0, 0, 0, 1, 2, 2, 2}, even[4] = {0, 0, 1, 1};
    const double bad[][7] = {{0, 0, 0, NAN, 2, 2, 2},
                             {0, 0, 0, 3, 2, 2, 2},
                             {0, 0, 0, 0, 0, 0, 0},
                             {0, 0, 0, INFINITY, 2, 2, 2},
                             {0, 0, 1, 0, 2, 2, 2}};
    btg_surface_def s = {2, 1, 4, 2, points, NULL, good, even};
    btg_part_def def = part_of(&s);
    btg_message message;
    CHECK(create(&def, &message) == BTG_OK);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        s.knots_u = bad[i];
        REFUSED(def);
    }
    s.knots_u = good;
    s.knots_v = NULL; /* both or none */
    REFUSED(def);
}

static void refuse_meshes(void) {
    double p[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    uint32_t index[3] = {0, 1, 2};
    btg_mesh_def mesh = {p, 3, index, 1};
    btg_part_def def = btg_part_def_default();
    def.meshes = &mesh;
    def.mesh_count = 1;
    btg_message message;
    CHECK(create(&def, &message) == BTG_OK);
    index[2] = 3;
    REFUSED(def);
    index[2] = UINT32_MAX;
    REFUSED(def);
    index[2] = 2;
    p[4] = NAN;
    REFUSED(def);
    p[4] = 0;
    mesh.positions = NULL;
    REFUSED(def);
    mesh.positions = p;
    mesh.indices = NULL;
    REFUSED(def);
    mesh.indices = index;
    mesh.triangle_count = SIZE_MAX;
    REFUSED(def);
    mesh.triangle_count = SIZE_MAX / 12;
    REFUSED(def);
    mesh.triangle_count = 1;
    mesh.vertex_count = SIZE_MAX;
    REFUSED(def);
    mesh.vertex_count = 0;
    REFUSED(def);
}

static void refuse_parts(void) {
    btg_message message;
    btg_part *part;
    btg_part_def def = btg_part_def_default();
    REFUSED(def); /* nothing in it */
    btg_surface_def s = good_surface();
    def = part_of(&s);
    def.version += 1;
    REFUSED(def);
    def = part_of(&s);
    def.surfaces = NULL;
    REFUSED(def);
    def = part_of(&s);
    CHECK(btg_part_create(NULL, &part, &message) == BTG_ERROR_ARGUMENT);
    CHECK(btg_part_create(&def, NULL, &message) == BTG_ERROR_ARGUMENT);
    s.degree_u = 0;
    CHECK(btg_part_create(&def, &part, NULL) == BTG_ERROR_ARGUMENT);
    btg_part_destroy(NULL);
}

/* ---- running out of memory ----------------------------------------------------------------- */

static model mixed_model(void) {
    rng r = {3};
    model m = {0};
    model_surface s = model_spline(&m, 3, 2, 7, 5, true);
    for (int i = 0; i < 3 * 35; i++)
        s.points[i] = rng_range(&r, -20, 20);
    model_quad(&m, vec(0, 0, 0), vec(0, 9, 0), vec(9, 0, 0), vec(9, 9, 1));
    for (int i = 0; i < 20; i++)
        model_triangle(&m, vec(i, 0, 0), vec(i + 1, 0, 0), vec(i, rng_range(&r, 1, 5), 1));
    return m;
}

static void check_memory(void) {
    model m = mixed_model();
    btg_mesh_def mesh = {m.positions, 3 * m.triangle_count, m.indices, m.triangle_count};
    btg_part_def def = btg_part_def_default();
    def.surfaces = m.surface;
    def.surface_count = m.surface_count;
    def.meshes = &mesh;
    def.mesh_count = 1;
    budget b = {.left = -1};
    def.allocator = (btg_allocator){grant, take_back, &b};
    btg_part *part = NULL;
    CHECK(btg_part_create(&def, &part, NULL) == BTG_OK);
    btg_part_info info;
    btg_part_get_info(part, &info);
    CHECK(info.surface_count == 2 && info.triangle_count == 20 && info.patch_count == 13);
    CHECK(info.memory_bytes > 0 && info.memory_bytes <= b.bytes);
    btg_part_destroy(part);
    CHECK(b.live == 0);
    long all = b.all;
    CHECK(all > 0);
    for (long n = 0; n < all; n++) {
        btg_message message;
        b = (budget){.left = n};
        CHECK(create(&def, &message) == BTG_ERROR_MEMORY);
        CHECK(b.live == 0);
    }
    model_free(&m);
}

/* The arrays are copied: changing or freeing them later does not matter. */
static void check_copied(void) {
    model m = mixed_model();
    btg_part *part = model_part(&m);
    btg_surface_point before, after;
    CHECK(btg_part_evaluate(part, (btg_place){0, 0.3, 0.4}, &before) == BTG_OK);
    model_free(&m);
    CHECK(btg_part_evaluate(part, (btg_place){0, 0.3, 0.4}, &after) == BTG_OK);
    CHECK(memcmp(&before, &after, sizeof before) == 0);
    btg_part_destroy(part);
}

int main(void) {
    refuse_counts();
    refuse_numbers();
    refuse_knots();
    refuse_meshes();
    refuse_parts();
    check_memory();
    check_copied();
    return check_result();
}
