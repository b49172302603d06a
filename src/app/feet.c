#include "app/feet.h"
#include "app/points.h"
#include "bitangent/verify.h"
#include "io/outline.h"

#include <stdlib.h>

/* The footprint over the part's extent. */
static btg_footprint_def over(const path_options *options, const btg_part_info *part) {
    btg_footprint_def def = options->footprint;
    def.x_min_mm = part->box_min.x - options->overrun_mm;
    def.x_max_mm = part->box_max.x + options->overrun_mm;
    def.y_min_mm = part->box_min.y - options->overrun_mm;
    def.y_max_mm = part->box_max.y + options->overrun_mm;
    return def;
}

static btg_status solve(const double *xy, size_t count, btg_position *positions, void *user) {
    return btg_backend_positions(user, xy, count, positions, NULL);
}

btg_status feet_side_step(path_options *options, const btg_part *part, const btg_tool *tool,
                          btg_backend *backend, btg_message *message) {
    if (!options->side_of_scallop || options->points) return BTG_OK;
    btg_part_info info;
    btg_part_get_info(part, &info);
    btg_side_step_def def = btg_side_step_def_default();
    def.footprint = over(options, &info);
    def.scallop_mm = options->solver.scallop_mm;
    def.threads = options->threads;
    def.solve = solve;
    def.user = backend;
    return btg_side_step(&def, part, tool, &options->footprint.side_step_mm, message);
}

btg_status feet_open(feet *f, const path_options *options, const btg_part *part,
                     btg_message *message) {
    feet result = {0};
    btg_status status;
    if (options->points) {
        status = points_read(options->points, &result.xy, &result.total, message);
    } else if (options->contour) {
        btg_outline_def def = {options->footprint.side_step_mm, options->footprint.forward_step_mm,
                               options->overrun_mm};
        status = btg_outline_passes(&def, part, &result.along, &result.total, message);
    } else {
        btg_part_info info;
        btg_part_get_info(part, &info);
        btg_footprint_def def = over(options, &info);
        status = btg_footprint_plan(&def, &result.layout, message);
        result.total = result.layout.total;
    }
    if (status == BTG_OK) *f = result;
    return status;
}

void feet_close(feet *f) {
    free(f->xy);
    free(f->along);
    *f = (feet){0};
}

btg_footprint_point feet_at(const feet *f, size_t index) {
    if (f->along) return f->along[index];
    if (!f->xy) return btg_footprint_at(&f->layout, index);
    return (btg_footprint_point){
        .point = (uint32_t)index, .x_mm = f->xy[2 * index], .y_mm = f->xy[2 * index + 1]};
}

bool feet_linked(const feet *f, btg_footprint_point point) {
    bool zigzag = !f->along && f->layout.def.kind == BTG_FOOTPRINT_ZIGZAG;
    return f->xy || zigzag || point.point > 0;
}
