#include "io/image.h"
#include "core/part.h"
#include "io/picture_sheet.h"

static void fill(cairo_surface_t *surface, const unsigned char *rgb, int width, int height) {
    unsigned char *to = cairo_image_surface_get_data(surface);
    int stride = cairo_image_surface_get_stride(surface);
    cairo_surface_flush(surface);
    for (int y = 0; y < height; y++) {
        uint32_t *row = (uint32_t *)(void *)(to + (size_t)y * (size_t)stride);
        for (int x = 0; x < width; x++, rgb += 3)
            row[x] = (uint32_t)rgb[0] << 16 | (uint32_t)rgb[1] << 8 | rgb[2];
    }
    cairo_surface_mark_dirty(surface);
}

btg_status btg_image_write(const unsigned char *rgb, int width, int height, btg_output *output,
                           btg_message *message) {
    cairo_surface_t *surface = cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height);
    btg_status status = BTG_ERROR_MEMORY;
    if (cairo_surface_status(surface) == CAIRO_STATUS_SUCCESS) {
        fill(surface, rgb, width, height);
        status = btg_sheet_png(surface, output);
    }
    cairo_surface_destroy(surface);
    if (status == BTG_OK) return btg_output_check(output, message);
    return btg_fail(message, status, "picture: not enough memory for %d x %d pixels", width,
                    height);
}
