#include "io/map.h"
#include "core/part.h"

#include <math.h>
#include <string.h>

/* ---- colours ------------------------------------------------------------------------------ */

/* Dark is far off; told apart with any colour vision, and gouged from left by hue. */
static const float left_ramp[4][3] = {
    {0.74f, 0.86f, 0.93f}, {0.42f, 0.68f, 0.84f}, {0.13f, 0.44f, 0.71f}, {0.03f, 0.19f, 0.42f}};
static const float gouge_ramp[4][3] = {
    {0.99f, 0.80f, 0.60f}, {0.99f, 0.55f, 0.24f}, {0.85f, 0.28f, 0.05f}, {0.50f, 0.09f, 0.02f}};
static const float finished[3] = {0.88f, 0.90f, 0.82f};

void btg_map_colour(const btg_map_scale *scale, double deviation, float rgb[3]) {
    double limit = deviation < 0 ? scale->gouge_mm : scale->scallop_mm;
    double excess = fabs(deviation) / (limit > 0 ? limit : 1e-6);
    const float(*ramp)[3] = deviation < 0 ? gouge_ramp : left_ramp;
    if (!(excess > 1)) {
        memcpy(rgb, finished, sizeof finished);
        return;
    }
    double at = fmin(log10(excess), 3);
    int i = at < 3 ? (int)at : 2;
    float f = (float)(at - i);
    for (int c = 0; c < 3; c++)
        rgb[c] = ramp[i][c] + f * (ramp[i + 1][c] - ramp[i][c]);
}

/* ---- CSV ---------------------------------------------------------------------------------- */

btg_status btg_map_csv(const btg_verify_map *map, btg_output *output, btg_message *message) {
    size_t size = (size_t)map->width * map->height;
    btg_output_text(output, "x,y,part_z,stock_z,deviation\n");
    for (size_t i = 0; i < size && output->error == 0; i++) {
        double d = btg_verify_deviation(map, i);
        if (isnan(d)) continue;
        btg_output_format(output, "%.9g,%.9g,%.9f,%.9f,%.9f\n",
                          map->x_mm + (double)(i % map->width) * map->cell_mm,
                          map->y_mm + (double)(i / map->width) * map->cell_mm, map->part_z_mm[i],
                          map->stock_z_mm[i], d);
    }
    return btg_output_check(output, message);
}
