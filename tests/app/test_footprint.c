#include "bitangent/bitangent.h"
#include "check.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static btg_footprint_def rectangle(double x0, double x1, double y0, double y1) {
    btg_footprint_def def = btg_footprint_def_default();
    def.x_min_mm = x0;
    def.x_max_mm = x1;
    def.y_min_mm = y0;
    def.y_max_mm = y1;
    return def;
}

static btg_footprint_point *points_of(const btg_footprint_def *def, size_t *count) {
    btg_message message;
    *count = 0;
    CHECK(btg_footprint_count(def, count, &message) == BTG_OK);
    btg_footprint_point *points = malloc((*count + 1) * sizeof *points);
    CHECK(points && btg_footprint_fill(def, points, *count) == BTG_OK);
    return points;
}

/* The papers' footprint: 10 passes at 0, 18, ..., 144, 150, of 76 points each. */
static void test_parallel(void) {
    btg_footprint_def def = rectangle(0, 150, 0, 150);
    size_t count;
    btg_footprint_point *p = points_of(&def, &count);
    CHECK(count == 760);
    for (size_t i = 0; i < count; i++) {
        size_t pass = i / 76, point = i % 76;
        CHECK(p[i].pass == pass && p[i].point == point && !p[i].lift);
        CHECK(p[i].x_mm == (pass == 9 ? 150.0 : 18.0 * (double)pass));
        CHECK(p[i].y_mm == 2.0 * (double)point);
    }
    free(p);
}

/* A step that divides the length up to rounding gives no last sliver: 0.1 into 0.3, 0.1 into 1,
 * 1/3 into 1 and into 7. */
static void test_rounding(void) {
    const double length[] = {0.3, 1, 1, 7, 1e5};
    const double step[] = {0.1, 0.1, 1.0 / 3, 1.0 / 3, 0.1};
    const size_t expected[] = {4, 11, 4, 22, 1000001};
    for (int i = 0; i < 5; i++) {
        btg_footprint_def def = rectangle(-17.3, -17.3, -8.1, -8.1 + length[i]);
        def.forward_step_mm = step[i];
        size_t count;
        btg_footprint_point *p = points_of(&def, &count);
        CHECK(count == expected[i]);
        CHECK(p[count - 1].y_mm == def.y_max_mm);
        for (size_t k = 1; k < count; k++)
            CHECK(p[k].y_mm - p[k - 1].y_mm > step[i] / 2);
        free(p);
    }
}

/* 0.15 m in single precision is a little more than 150 mm, which is no further step; a hundredth of
 * a millimetre is one. */
static void test_single_precision(void) {
    const double length[] = {150, 1000.0 * (double)0.15f, 149.999994, 150.01, 149.99};
    const size_t expected[] = {76, 76, 76, 77, 76};
    for (int i = 0; i < 5; i++) {
        btg_footprint_def def = rectangle(0, 0, 0, length[i]);
        size_t count;
        btg_footprint_point *p = points_of(&def, &count);
        CHECK(count == expected[i]);
        CHECK(p[count - 1].y_mm == length[i]);
        free(p);
    }
}

static void test_small(void) {
    size_t count;
    btg_footprint_def def = rectangle(3, 3, 4, 4);
    btg_footprint_point *p = points_of(&def, &count);
    CHECK(count == 1 && p[0].x_mm == 3 && p[0].y_mm == 4);
    free(p);
    def = rectangle(0, 1, 0, 0.5);
    p = points_of(&def, &count);
    CHECK(count == 4);
    CHECK(p[0].x_mm == 0 && p[3].x_mm == 1 && p[0].y_mm == 0 && p[3].y_mm == 0.5);
    free(p);
}

static void test_zigzag(void) {
    btg_footprint_def def = rectangle(0, 36, 0, 5);
    def.kind = BTG_FOOTPRINT_ZIGZAG;
    size_t count;
    btg_footprint_point *p = points_of(&def, &count);
    CHECK(count == 12);
    const double y[] = {0, 2, 4, 5, 5, 4, 2, 0, 0, 2, 4, 5};
    for (size_t i = 0; i < count; i++)
        CHECK(p[i].y_mm == y[i] && p[i].point == i % 4);
    free(p);
}

static void test_one_way(void) {
    btg_footprint_def def = rectangle(0, 18, 0, 4);
    def.kind = BTG_FOOTPRINT_ONE_WAY;
    size_t count;
    btg_footprint_point *p = points_of(&def, &count);
    CHECK(count == 10);
    const int lift[] = {1, 0, 0, 0, 1};
    const uint32_t point[] = {0, 0, 1, 2, 2};
    const double y[] = {0, 0, 2, 4, 4};
    for (size_t i = 0; i < count; i++) {
        CHECK(p[i].pass == i / 5 && p[i].lift == lift[i % 5]);
        CHECK(p[i].point == point[i % 5] && p[i].y_mm == y[i % 5]);
    }
    free(p);
}

static void refused(btg_footprint_def def, const char *word) {
    size_t count = 77;
    btg_message message = {""};
    btg_footprint_point point;
    CHECK(btg_footprint_count(&def, &count, &message) == BTG_ERROR_ARGUMENT);
    CHECK(count == 77);
    CHECK(strstr(message.text, word) != NULL);
    CHECK(btg_footprint_count(&def, &count, NULL) == BTG_ERROR_ARGUMENT);
    CHECK(btg_footprint_fill(&def, &point, 1) == BTG_ERROR_ARGUMENT);
}

static void test_refusals(void) {
    const double bad_step[] = {0, -1, NAN, INFINITY};
    for (int i = 0; i < 4; i++) {
        btg_footprint_def def = rectangle(0, 1, 0, 1);
        def.side_step_mm = bad_step[i];
        refused(def, "side step");
        def = rectangle(0, 1, 0, 1);
        def.forward_step_mm = bad_step[i];
        refused(def, "forward step");
    }
    refused(rectangle(1, 0, 0, 1), "reversed");
    refused(rectangle(0, NAN, 0, 1), "finite");
    refused(rectangle(-1e308, 1e308, 0, 1), "larger steps");
    btg_footprint_def def = rectangle(0, 1e5, 0, 1e5);
    def.side_step_mm = def.forward_step_mm = 1;
    refused(def, "larger steps");
    def = rectangle(0, 1, 0, 1);
    def.version = 0;
    refused(def, "version");
    def = rectangle(0, 1, 0, 1);
    btg_footprint_point point[2];
    CHECK(btg_footprint_fill(&def, point, 2) == BTG_ERROR_ARGUMENT);
    CHECK(btg_footprint_count(NULL, NULL, NULL) == BTG_ERROR_ARGUMENT);
}

int main(void) {
    test_parallel();
    test_rounding();
    test_single_precision();
    test_small();
    test_zigzag();
    test_one_way();
    test_refusals();
    return check_result();
}
