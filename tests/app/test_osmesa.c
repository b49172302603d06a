/* The osmesa back end in contexts of both providers; four threads with one each; and its raw
 * answers against the bounds of the method: M. Singh, S. Bedi, S. Mann, "A GPU Method and Error
 * Analysis of Multi-Point Positioning of a Toroidal Tool for 5-Axis Machining", 2024, equation 2.
 * Exit code 77: no device. */
#include "backend/osmesa/osmesa.h"
#include "check.h"
#include "core/part.h"
#include "device_checks.h"

#include <stdlib.h>
#include <string.h>

#define SIDE  8
#define COUNT (SIDE * SIDE)

static bool test_provider(const btg_backend_setup *setup, const char *provider) {
    btg_context_def def = {.provider = provider};
    btg_message message = {""};
    void *state = NULL;
    btg_status status = btg_osmesa_open_with(&def, setup, &state, &message);
    if (status == BTG_ERROR_NO_DEVICE) {
        printf("without %s: %s\n", provider, message.text);
        return false;
    }
    CHECK(status == BTG_OK);
    if (!state) return true;
    device_check_batches(state);
    btg_backend_osmesa.close(state);
    return true;
}

static void test_missing(const btg_backend_setup *setup) {
    btg_context_def def = {.provider = "egl", .egl_library = "libnosuch.so"};
    btg_message message = {""};
    void *state = NULL;
    CHECK(btg_osmesa_open_with(&def, setup, &state, &message) == BTG_ERROR_NO_DEVICE);
    CHECK(strstr(message.text, "libnosuch.so") && strstr(message.text, "install"));
    CHECK(!state);
}

/* ---- bounds ------------------------------------------------------------------------------- */

/* Rounding of a depth, a pixel and a point in single precision: parts of the part's size. */
#define ROUNDING 3e-7

/* The papers' surfaces, 150 mm square, by the heights of their control points. */
static const double heights[3][16] = {
    {80, 90, 90, 80, 90, 105, 105, 90, 90, 105, 105, 90, 80, 90, 90, 80},
    {80, 70, 70, 80, 70, 55, 55, 70, 70, 55, 55, 70, 80, 70, 70, 80},
    {80, 65, 90, 85, 80, 85, 90, 95, 100, 105, 95, 100, 90, 100, 100, 85},
};

typedef struct study {
    btg_part *part;
    btg_tool tool;
    btg_solver_def solver;
    double scale;
    btg_drop_query drops[COUNT];
    btg_drop_result dropped[COUNT];
    btg_tilt_query tilts[COUNT];
    btg_tilt_result tilted[COUNT];
    size_t tilt_count;
} study;

static btg_backend *open_backend(const study *s, const char *name, uint32_t levels,
                                 uint32_t window) {
    btg_backend_def def = btg_backend_def_default();
    btg_backend *backend = NULL;
    def.name = name;
    def.raw = strcmp(name, "cpu") != 0;
    def.levels = levels;
    def.window_pixels = window;
    CHECK(btg_backend_open(&def, s->part, &s->tool, &s->solver, &backend, NULL) == BTG_OK);
    if (!backend) exit(1);
    return backend;
}

/* The right answers to the drops, by the cpu. TILT starts from the right P: its own error is looked
 * at. */
static void solve_study(study *s, const btg_surface_def *surfaces, size_t count, double scale) {
    btg_part_def def = btg_part_def_default();
    btg_tool_def tool = btg_tool_def_default();
    def.surfaces = surfaces;
    def.surface_count = count;
    s->solver = btg_solver_def_default();
    s->scale = scale;
    CHECK(btg_part_create(&def, &s->part, NULL) == BTG_OK);
    CHECK(btg_tool_init(&tool, &s->tool, NULL) == BTG_OK);
    btg_backend *cpu = open_backend(s, "cpu", 2, 0);
    CHECK(btg_backend_drop(cpu, s->drops, COUNT, s->dropped, NULL) == BTG_OK);
    s->tilt_count = 0;
    for (int i = 0; i < COUNT; i++)
        if (btg_position_tilt_query(&s->tool, &s->solver, &s->drops[i], &s->dropped[i],
                                    &s->tilts[s->tilt_count]) == BTG_OK)
            s->tilt_count++;
    CHECK(s->tilt_count > COUNT / 2);
    CHECK(btg_backend_tilt(cpu, s->tilts, s->tilt_count, s->tilted, NULL) == BTG_OK);
    btg_backend_close(cpu);
}

static void begin_study(study *s, const double height[16]) {
    double points[48];
    for (int i = 0; i < 16; i++) {
        points[3 * i] = 50 * (i / 4);
        points[3 * i + 1] = 50 * (i % 4);
        points[3 * i + 2] = height[i];
    }
    btg_surface_def surface = {
        .degree_u = 3, .degree_v = 3, .count_u = 4, .count_v = 4, .control_points = points};
    for (int i = 0; i < COUNT; i++)
        s->drops[i] = btg_position_drop_query(15.3 + 17 * (i / SIDE), 14.7 + 17.1 * (i % SIDE));
    solve_study(s, &surface, 1, 150);
}

/* The greatest normal curvature at a place, either way. */
static double curvature(const study *s, btg_place place) {
    btg_surface_point p;
    btg_part_point(s->part, place, &p);
    btg_vec3 n = vec_unit(vec_cross(p.su, p.sv));
    double e = vec_norm2(p.su), f = vec_dot(p.su, p.sv), g = vec_norm2(p.sv);
    double l = vec_dot(p.suu, n), m = vec_dot(p.suv, n), k = vec_dot(p.svv, n), det = e * g - f * f;
    double mean = 0.5 * (l * g - 2 * m * f + k * e) / det, gauss = (l * k - m * m) / det;
    return fabs(mean) + sqrt(max2(mean * mean - gauss, 0));
}

static bool on_edge(btg_place p) {
    return min2(min2(p.u, p.v), min2(1 - p.u, 1 - p.v)) < 1e-3;
}

/* Clearance that a pixel may hide: half its diagonal from the contact, on a part that curves away
 * from the insert; `c` the cosine between the ray and the normal, `bend` the ray's own curvature.
 */
static double pixel_bound(const study *s, btg_place place, double pixel, double c, double bend) {
    double ri = s->tool.element[0].corner_radius_mm, curves = 1 / ri + curvature(s, place) + bend;
    return pixel * pixel * curves / (4 * c * c) + ROUNDING * s->scale;
}

/* Heights; returns the greatest error. */
static double test_drops(const study *s, btg_backend *raw, double pixel) {
    btg_drop_result results[COUNT];
    double most = 0;
    CHECK(btg_backend_drop(raw, s->drops, COUNT, results, NULL) == BTG_OK);
    for (int i = 0; i < COUNT; i++) {
        const btg_drop_result *right = &s->dropped[i];
        if (on_edge(right->contact.place)) continue;
        double c = right->contact.normal.z, error = fabs(results[i].height_mm - right->height_mm);
        CHECK(results[i].status == BTG_OK);
        CHECK(error <= pixel_bound(s, right->contact.place, pixel, c, 0) / c);
        most = max2(most, error);
    }
    return most;
}

/* How far the tool moves at its second contact, along the normal there, by a turn. */
static double lever_of(const btg_tilt_query *query, const btg_contact *q) {
    return fabs(vec_dot(vec_cross(query->u, vec_sub(q->point, query->o1)), q->normal));
}

/* Tilts, as clearances. */
static double test_tilts(const study *s, btg_backend *raw, double pixel) {
    btg_tilt_result results[COUNT];
    double most = 0;
    CHECK(btg_backend_tilt(raw, s->tilts, s->tilt_count, results, NULL) == BTG_OK);
    for (size_t i = 0; i < s->tilt_count; i++) {
        const btg_tilt_query *q = &s->tilts[i];
        const btg_tilt_result *right = &s->tilted[i];
        if (right->status != BTG_OK || on_edge(right->contact.place)) continue;
        btg_vec3 arm = vec_sub(right->contact.point, q->o1);
        double lever = lever_of(q, &right->contact);
        double along = vec_dot(arm, q->u), radius = sqrt(vec_norm2(arm) - along * along);
        double error = lever * fabs(results[i].tilt_rad - right->tilt_rad);
        CHECK(error <= pixel_bound(s, right->contact.place, pixel, lever / radius, 1 / radius));
        most = max2(most, error);
    }
    return most;
}

/* Windows of several sizes: the error stays inside the bound, and falls with it. */
static void test_bounds(const double height[16]) {
    static const uint32_t sizes[][2] = {{1, 60}, {2, 20}, {2, 30}, {2, 50}, {2, 80}};
    study *s = calloc(1, sizeof *s);
    if (!s) exit(1);
    begin_study(s, height);
    double width = 2 * (s->tool.def.major_radius_mm + s->tool.def.minor_radius_mm), last = 1;
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        double pixel = width / sizes[i][1];
        if (sizes[i][0] == 2) pixel *= 2.0 / sizes[i][1];
        btg_backend *raw = open_backend(s, "osmesa", sizes[i][0], sizes[i][1]);
        double drop = test_drops(s, raw, pixel), tilt = test_tilts(s, raw, pixel);
        printf("%u levels of %u pixels, %.3f mm: heights within %.1e mm, tilts within %.1e mm\n",
               (unsigned)sizes[i][0], (unsigned)sizes[i][1], pixel, drop, tilt);
        CHECK(drop < last);
        last = drop;
        btg_backend_close(raw);
    }
    btg_part_destroy(s->part);
    free(s);
}

/* ---- two valleys -------------------------------------------------------------------------- */

/* Domes stand this far apart by groups, are so wide and curve so much, 1/mm. */
#define APART  40
#define HALF   2
#define BEND   0.3
#define SPREAD 0.006 /* of their heights, mm: less than a coarse pixel hides */

typedef struct domes {
    btg_surface_def surfaces[3 * COUNT];
    double points[3 * COUNT][27];
    size_t count;
    uint32_t seed;
} domes;

/* From -0.5 to 0.5. */
static double any(domes *d) {
    d->seed = d->seed * 1664525u + 1013904223u;
    return d->seed / 4294967296.0 - 0.5;
}

/* A paraboloid's top about there: where among the pixels is chance. */
static void add_dome(domes *d, double x, double y, double z) {
    static const double square[3] = {HALF * HALF, -HALF * HALF, HALF * HALF};
    double *point = d->points[d->count];
    x += any(d);
    y += any(d);
    for (int i = 0; i < 9; i++) {
        point[3 * i] = x + HALF * (i / 3 - 1);
        point[3 * i + 1] = y + HALF * (i % 3 - 1);
        point[3 * i + 2] = z - 0.5 * BEND * (square[i / 3] + square[i % 3]);
    }
    d->surfaces[d->count++] = (btg_surface_def){
        .degree_u = 2, .degree_v = 2, .count_u = 3, .count_v = 3, .control_points = point};
}

static void lift_dome(domes *d, int i, double by) {
    for (int k = 0; k < 9; k++)
        d->points[i][3 * k + 2] += by;
}

/* The domes but that one of each group. */
static study *solve_domes(const domes *d, int without) {
    study *s = calloc(1, sizeof *s);
    btg_surface_def surfaces[3 * COUNT];
    size_t count = 0;
    if (!s) exit(1);
    for (int i = 0; i < COUNT; i++) {
        for (int k = 0; k < 3; k++)
            if (k != without) surfaces[count++] = d->surfaces[3 * i + k];
        s->drops[i] = btg_position_drop_query(APART * (i / SIDE), APART * (i % SIDE));
    }
    solve_study(s, surfaces, count, APART * SIDE);
    CHECK(s->tilt_count == COUNT);
    return s;
}

/* Lifts the last of each three, so that the tool stops at it as it stops at the other. */
static void level_domes(domes *d) {
    study *s[2] = {solve_domes(d, 2), solve_domes(d, 1)};
    for (int i = 0; i < COUNT; i++) {
        const btg_tilt_result *a = &s[0]->tilted[i], *b = &s[1]->tilted[i];
        double lever = lever_of(&s[1]->tilts[i], &b->contact);
        lift_dome(d, 3 * i + 2, (b->tilt_rad - a->tilt_rad) * lever / b->contact.normal.z);
    }
    for (int k = 0; k < 2; k++) {
        btg_part_destroy(s[k]->part);
        free(s[k]);
    }
}

/* Groups of three: one to touch first, two that stop the tilt together. Lifted by ten millimetres,
 * these stop the drop, together too. */
static study *begin_domes(domes *d, bool tilt) {
    for (int i = 0; i < COUNT; i++) {
        double x = APART * (i / SIDE), y = APART * (i % SIDE);
        add_dome(d, x, y - 6.7, 1.5);
        add_dome(d, x - 5, y + 4.5, 0);
        add_dome(d, x + 5, y + 4.5, 0);
    }
    for (int i = 0; tilt && i < 2; i++)
        level_domes(d);
    for (int i = 0; i < 3 * COUNT; i++)
        lift_dome(d, i, SPREAD * any(d) + (tilt || i % 3 == 0 ? 0 : 10));
    return solve_domes(d, 3);
}

/* How many of them the contact is on another dome than it should. */
static int wrong_drops(const study *s, btg_backend *raw) {
    btg_drop_result found[COUNT];
    int wrong = 0;
    CHECK(btg_backend_drop(raw, s->drops, COUNT, found, NULL) == BTG_OK);
    for (int i = 0; i < COUNT; i++)
        wrong += found[i].contact.place.item != s->dropped[i].contact.place.item;
    return wrong;
}

static int wrong_tilts(const study *s, btg_backend *raw) {
    btg_tilt_result found[COUNT];
    int wrong = 0;
    CHECK(btg_backend_tilt(raw, s->tilts, s->tilt_count, found, NULL) == BTG_OK);
    for (size_t i = 0; i < s->tilt_count; i++)
        wrong += found[i].contact.place.item != s->tilted[i].contact.place.item;
    return wrong;
}

/* Which of two valleys is lower no coarse image tells: both have to be looked at closely. */
static void test_two_valleys(bool tilt) {
    static const uint32_t window = 50;
    domes *d = calloc(1, sizeof *d);
    if (!d) exit(1);
    study *s = begin_domes(d, tilt);
    double pixel = 2 * (s->tool.def.major_radius_mm + s->tool.def.minor_radius_mm) / window;
    btg_backend *coarse = open_backend(s, "osmesa", 1, window);
    btg_backend *both = open_backend(s, "osmesa", 2, window);
    int wrong = tilt ? wrong_tilts(s, coarse) : wrong_drops(s, coarse);
    printf("two valleys, %s: a coarse image alone takes the wrong one %d times of %d\n",
           tilt ? "tilts" : "drops", wrong, COUNT);
    CHECK(wrong > COUNT / 16);
    if (tilt)
        test_tilts(s, both, pixel * 2 / window);
    else
        test_drops(s, both, pixel * 2 / window);
    btg_backend_close(coarse);
    btg_backend_close(both);
    btg_part_destroy(s->part);
    free(s);
    free(d);
}

/* Windows as large as they may be asked for are looked at whole. */
static void test_large_window(const double height[16]) {
    static const uint32_t pixels = 1400;
    study *s = calloc(1, sizeof *s);
    btg_drop_result results[COUNT];
    if (!s) exit(1);
    begin_study(s, height);
    double pixel = 2 * (s->tool.def.major_radius_mm + s->tool.def.minor_radius_mm) / pixels;
    btg_backend *raw = open_backend(s, "osmesa", 1, pixels);
    CHECK(btg_backend_drop(raw, s->drops, COUNT, results, NULL) == BTG_OK);
    for (int i = 0; i < COUNT; i++) {
        const btg_drop_result *right = &s->dropped[i];
        double c = right->contact.normal.z, error = fabs(results[i].height_mm - right->height_mm);
        if (on_edge(right->contact.place)) continue;
        CHECK(error <= pixel_bound(s, right->contact.place, pixel, c, 0) / c);
    }
    btg_backend_close(raw);
    btg_part_destroy(s->part);
    free(s);
}

/* What no depth image can be. */
static void test_refusals(const btg_backend_setup *setup) {
    static const uint32_t wrong[][2] = {{0, 50}, {3, 50}, {2, 7}, {1, 4097}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        btg_backend_def def = btg_backend_def_default();
        btg_backend *backend = NULL;
        btg_message message = {""};
        def.name = "osmesa";
        def.levels = wrong[i][0];
        def.window_pixels = wrong[i][1];
        CHECK(btg_backend_open(&def, setup->part, &setup->tool, &setup->solver, &backend,
                               &message) == BTG_ERROR_ARGUMENT);
        CHECK(!backend && strstr(message.text, "8 to 4096"));
    }
}

int main(void) {
    btg_backend_setup setup = device_checks_begin("osmesa");
    test_missing(&setup);
    test_refusals(&setup);
    bool osmesa = test_provider(&setup, "osmesa"), egl = test_provider(&setup, "egl");
    if (osmesa || egl) {
        /* Fine pixels of 0.02 mm; on edges of the part a height is a pixel times the slope off. */
        device_check_threads_raw_times(0.04);
        for (int i = 0; i < 3; i++)
            test_bounds(heights[i]);
        test_two_valleys(false);
        test_two_valleys(true);
        test_large_window(heights[0]);
    }
    int result = osmesa || egl ? 0 : 77;
    return device_checks_end(check_failures > 0 ? 1 : result);
}
