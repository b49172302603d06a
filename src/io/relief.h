/* A shaded height map of a part seen from +z, as a picture wants it. Internal to the program. */
#ifndef BTG_IO_RELIEF_H
#define BTG_IO_RELIEF_H

#include "bitangent/bitangent.h"

/* Pixel (column, row) covers x_min + column .. x_min + column + 1 pixels to the right and as much
 * down from y_max; index = row * width + column. */
typedef struct btg_relief {
    int width, height;
    double x_min_mm, y_max_mm, mm_per_pixel;
    float *z_mm;  /* of the highest point; -INFINITY where there is no part */
    float *light; /* 0 .. 1: cosine between normal and light, in the same order */
} btg_relief;

/* Size and place are filled in by the caller; z_mm and light are allocated here. ERROR_MEMORY,
 * ERROR_ARGUMENT (a size below 1). */
btg_status btg_relief_render(btg_relief *relief, const btg_part *part);
void btg_relief_release(btg_relief *relief);

#endif
