/* The one table of tolerances. A class is a clearance in mm: how much deeper in the part, or
 * farther from it, the placed tool may be. A value's limit follows by its lever. */
#include "conformance.h"

#include <stdio.h>

/* Part of the tolerance asked that an answer in double may use: the solver promises the whole. */
#define F64_SHARE 1e-3
/* Rounding of a coordinate through some tens of operations, part of the largest coordinate. */
#define F64_ROUNDING 1e-13
/* The same in single precision. */
#define F32_ROUNDING (8 * 0x1p-24)
/* Pixels across the tool, and across two of those when looking closer (geometry: depth buffer). */
#define PIXELS 50
/* 1e-4 degrees: what the reference answers are held to. */
#define TILT_FLOOR (1e-4 * BTG_PI / 180)
/* Below this lever (part of the cutter's size) both contacts count as one. */
#define LEVER_MIN            0.02
#define LEVER_MIN_OSCULATING 0.0002

static double exact(const fixture *f) {
    (void)f;
    return 0;
}

static double f64(const fixture *f) {
    return F64_SHARE * f->solver.tolerance_mm + F64_ROUNDING * fixture_scale(f);
}

static double f32(const fixture *f) {
    return f->solver.tolerance_mm + F32_ROUNDING * fixture_scale(f);
}

static double raster(const fixture *f) {
    const btg_tool_element *e = &f->tool.element[0];
    double pixel = 2 * (e->ring_radius_mm + e->corner_radius_mm) / PIXELS * (2.0 / PIXELS);
    return f32(f) + pixel / 4;
}

static const struct {
    const char *name, *formula, *reason;
    double (*clearance)(const fixture *f);
} table[TOLERANCE_COUNT] = {
    [TOLERANCE_EXACT] = {"EXACT", "0", "the same bits: order and threads must not show", exact},
    [TOLERANCE_F64] = {"F64", "1e-3 tolerance + 1e-13 scale",
                       "the search leaves out a thousandth of the tolerance; rounding of points",
                       f64},
    [TOLERANCE_F32] = {"F32", "tolerance + 8 * 2^-24 scale",
                       "a device's raw answer: coordinates in single precision", f32},
    [TOLERANCE_RASTER] = {"RASTER", "F32 + pixel / 4",
                          "a fine pixel at the insert's side is a quarter of its width off",
                          raster},
    [TOLERANCE_OSCULATING] = {"OSCULATING", "F64; lever down to 2e-4 of the cutter",
                              "near P an angle hardly moves the contact: small clearances are "
                              "large angles",
                              f64},
};

double tolerance_clearance(tolerance_class tolerance, const fixture *f) {
    return table[tolerance].clearance(f);
}

const char *tolerance_name(tolerance_class tolerance) {
    return table[tolerance].name;
}

limits tolerance_limits(tolerance_class tolerance, const fixture *f, double lever) {
    double clearance = tolerance_clearance(tolerance, f), size = fixture_size(f);
    if (tolerance == TOLERANCE_EXACT) return (limits){0, 0};
    if (f->op == BTG_OP_DROP) {
        double limit = clearance / fmax(lever, LEVER_MIN);
        return (limits){limit, limit};
    }
    double least = tolerance == TOLERANCE_OSCULATING ? LEVER_MIN_OSCULATING : LEVER_MIN;
    double limit = TILT_FLOOR + clearance / fmax(lever, least * size);
    return (limits){limit, limit};
}

void tolerance_print(void) {
    for (int i = 0; i < TOLERANCE_COUNT; i++)
        printf("%-11s %-38s %s\n", table[i].name, table[i].formula, table[i].reason);
}
