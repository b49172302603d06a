/* What the field says, once all is cut. */
#include "verify/internal.h"

#define BINS 4096
/* A cell seen from above stands for no more than a hundred times its area. */
#define NORMAL_Z_MIN 0.01

/* The value that `part` of the part's cells do not exceed: bins over all values, then over one of
 * those bins, so that it is exact to 1 / BINS^2 of the greatest. */
static double percentile(const btg_verify_map *map, double part, double most, uint64_t cells) {
    double low = 0, high = most;
    uint64_t before = 0, wanted = (uint64_t)ceil(part * (double)cells);
    size_t size = (size_t)map->width * map->height;
    for (int round = 0; round < 2 && high > low; round++) {
        uint64_t count[BINS] = {0};
        double scale = BINS / (high - low);
        for (size_t i = 0; i < size; i++) {
            double d = btg_verify_deviation(map, i);
            if (!(d >= low && d <= high) && !(low == 0 && d < 0)) continue;
            double bin = max2(d - low, 0) * scale;
            count[bin < BINS - 1 ? (int)bin : BINS - 1]++;
        }
        int k = 0;
        while (k < BINS - 1 && before + count[k] < wanted)
            before += count[k++];
        high = low + (k + 1) / scale;
        low = low + k / scale;
    }
    return min2(high, most);
}

void btg_result_of_field(const btg_field *f, const btg_verify_def *def, btg_verify_result *r) {
    static const double part[4] = {0.5, 0.9, 0.99, 0.999};
    btg_verify_map map = {f->width, f->height, f->x,        f->y,      f->cell,
                          f->top,   f->part_z, f->normal_z, f->stock_z};
    size_t size = (size_t)f->width * f->height;
    double square = f->cell * f->cell, sum = 0, strip = 0;
    r->cells = size;
    for (size_t i = 0; i < size; i++) {
        double d = btg_verify_deviation(&map, i);
        r->removed_mm3 += (f->top - max2(f->stock_z[i], f->bottom)) * square;
        if (isnan(d)) continue;
        double area = square / max2((double)f->normal_z[i], NORMAL_Z_MIN);
        r->part_cells++;
        sum += max2(d, 0);
        if (f->stock_z[i] >= f->top) r->uncut_mm2 += area;
        if (-d > def->gouge_mm) r->gouge_area_mm2 += area;
        if (d <= def->scallop_mm) strip += area;
        if (d > r->max_scallop_mm) {
            r->max_scallop_mm = d;
            r->scallop.at = vec(f->x + (double)(i % f->width) * f->cell,
                                f->y + (double)(i / f->width) * f->cell, f->part_z[i]);
        }
    }
    if (r->part_cells > 0) r->mean_scallop_mm = sum / (double)r->part_cells;
    for (int k = 0; k < 4; k++)
        r->percentile_mm[k] = percentile(&map, part[k], r->max_scallop_mm, r->part_cells);
    if (r->length_mm > 0) r->strip_width_mm = strip / r->length_mm;
}
