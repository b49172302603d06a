#include "core/footprint.h"
#include "core/part.h"

#include <float.h>
#include <string.h>

#define FOOTPRINT_DEF_VERSION 1

/* A last step of this share of a step, or less, may be rounding: extents come from files in single
 * precision, whose rounding counts up to it. No machine follows steps a thousand times longer. */
#define SLIVER 1e-3

btg_footprint_def btg_footprint_def_default(void) {
    btg_footprint_def def;
    memset(&def, 0, sizeof def);
    def.version = FOOTPRINT_DEF_VERSION;
    def.kind = BTG_FOOTPRINT_PARALLEL;
    def.side_step_mm = 18.0;
    def.forward_step_mm = 2.0;
    return def;
}

/* Number of stations at min, min + step, ..., and max. BTG_FOOTPRINT_MAX + 1: too many. */
static uint32_t stations(double min, double max, double step) {
    double length = max - min;
    double steps = length / step;
    if (!(steps < BTG_FOOTPRINT_MAX)) return BTG_FOOTPRINT_MAX + 1;
    double whole = floor(steps);
    double rest = length - whole * step;
    double rounding = fmin(FLT_EPSILON * (fabs(min) + fabs(max)), SLIVER * step);
    if (rest > rounding) whole += 1;
    return (uint32_t)whole + 1;
}

static double station(double min, double max, double step, uint32_t index, uint32_t count) {
    if (index + 1 == count && count > 1) return max;
    return min + index * step;
}

static btg_status check(const btg_footprint_def *def, btg_message *message) {
    if (def->version != FOOTPRINT_DEF_VERSION) {
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "footprint: unknown version; start from btg_footprint_def_default()");
    }
    if (def->kind != BTG_FOOTPRINT_PARALLEL && def->kind != BTG_FOOTPRINT_ZIGZAG &&
        def->kind != BTG_FOOTPRINT_ONE_WAY) {
        return btg_fail(message, BTG_ERROR_ARGUMENT, "footprint: unknown kind");
    }
    if (!isfinite(def->x_min_mm) || !isfinite(def->x_max_mm) || !isfinite(def->y_min_mm) ||
        !isfinite(def->y_max_mm)) {
        return btg_fail(message, BTG_ERROR_ARGUMENT, "footprint: the rectangle is not finite");
    }
    if (def->x_max_mm < def->x_min_mm || def->y_max_mm < def->y_min_mm) {
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "footprint: the rectangle is reversed: x %g to %g, y %g to %g mm",
                        def->x_min_mm, def->x_max_mm, def->y_min_mm, def->y_max_mm);
    }
    if (!isfinite(def->side_step_mm) || def->side_step_mm <= 0) {
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "footprint: the side step is %g mm; give a positive number",
                        def->side_step_mm);
    }
    if (!isfinite(def->forward_step_mm) || def->forward_step_mm <= 0) {
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "footprint: the forward step is %g mm; give a positive number",
                        def->forward_step_mm);
    }
    return BTG_OK;
}

btg_status btg_footprint_plan(const btg_footprint_def *def, btg_footprint_layout *layout,
                              btg_message *message) {
    btg_status status = check(def, message);
    if (status != BTG_OK) return status;
    uint32_t passes = stations(def->x_min_mm, def->x_max_mm, def->side_step_mm);
    uint32_t points = stations(def->y_min_mm, def->y_max_mm, def->forward_step_mm);
    uint32_t lifts = def->kind == BTG_FOOTPRINT_ONE_WAY ? 2 : 0;
    uint64_t total = (uint64_t)passes * (points + lifts);
    if (total > BTG_FOOTPRINT_MAX) {
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "footprint: more than %d points; take larger steps than %g and %g mm",
                        BTG_FOOTPRINT_MAX, def->side_step_mm, def->forward_step_mm);
    }
    *layout = (btg_footprint_layout){*def, passes, points, lifts, (size_t)total};
    return BTG_OK;
}

btg_footprint_point btg_footprint_at(const btg_footprint_layout *layout, size_t index) {
    const btg_footprint_def *def = &layout->def;
    uint32_t stride = layout->points + layout->lifts;
    uint32_t pass = (uint32_t)(index / stride);
    uint32_t entry = (uint32_t)(index % stride);
    bool lift = layout->lifts > 0 && (entry == 0 || entry == stride - 1);
    uint32_t point = entry;
    if (layout->lifts > 0) point = entry == 0 ? 0 : entry == stride - 1 ? entry - 2 : entry - 1;
    bool back = def->kind == BTG_FOOTPRINT_ZIGZAG && pass % 2 == 1;
    uint32_t along = back ? layout->points - 1 - point : point;
    return (btg_footprint_point){
        .pass = pass,
        .point = point,
        .x_mm = station(def->x_min_mm, def->x_max_mm, def->side_step_mm, pass, layout->passes),
        .y_mm = station(def->y_min_mm, def->y_max_mm, def->forward_step_mm, along, layout->points),
        .lift = lift};
}

btg_status btg_footprint_count(const btg_footprint_def *def, size_t *count, btg_message *message) {
    if (!def || !count) {
        return btg_fail(message, BTG_ERROR_ARGUMENT, "footprint: definition or result is NULL");
    }
    btg_footprint_layout layout;
    btg_status status = btg_footprint_plan(def, &layout, message);
    if (status == BTG_OK) *count = layout.total;
    return status;
}

btg_status btg_footprint_fill(const btg_footprint_def *def, btg_footprint_point *points,
                              size_t capacity) {
    if (!def || !points) return BTG_ERROR_ARGUMENT;
    btg_footprint_layout layout;
    btg_status status = btg_footprint_plan(def, &layout, NULL);
    if (status != BTG_OK) return status;
    if (capacity < layout.total) return BTG_ERROR_ARGUMENT;
    for (size_t i = 0; i < layout.total; i++)
        points[i] = btg_footprint_at(&layout, i);
    return BTG_OK;
}
