#include "app/feet.h"
#include "app/points.h"

#include <stdlib.h>

btg_status feet_open(feet *f, const path_options *options, const btg_part_info *part,
                     btg_message *message) {
    feet result = {0};
    btg_status status;
    if (options->points) {
        status = points_read(options->points, &result.xy, &result.total, message);
    } else {
        btg_footprint_def def = options->footprint;
        def.x_min_mm = part->box_min.x - options->overrun_mm;
        def.x_max_mm = part->box_max.x + options->overrun_mm;
        def.y_min_mm = part->box_min.y - options->overrun_mm;
        def.y_max_mm = part->box_max.y + options->overrun_mm;
        status = btg_footprint_plan(&def, &result.layout, message);
        result.total = result.layout.total;
    }
    if (status == BTG_OK) *f = result;
    return status;
}

void feet_close(feet *f) {
    free(f->xy);
    *f = (feet){0};
}

btg_footprint_point feet_at(const feet *f, size_t index) {
    if (!f->xy) return btg_footprint_at(&f->layout, index);
    return (btg_footprint_point){
        .point = (uint32_t)index, .x_mm = f->xy[2 * index], .y_mm = f->xy[2 * index + 1]};
}

bool feet_linked(const feet *f, btg_footprint_point point) {
    return f->xy || f->layout.def.kind == BTG_FOOTPRINT_ZIGZAG || point.point > 0;
}
