/* The field of a verification as a picture: the part from above, coloured by what is left. */
#include "core/part.h"
#include "io/map.h"
#include "io/picture_sheet.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define SWATCHES   3 /* factors of ten beyond the limit that have a colour of their own */
#define ROW_HEIGHT 25.0

static void ink(cairo_t *cr, const float rgb[3]) {
    btg_sheet_ink(cr, (colour){(double)rgb[0], (double)rgb[1], (double)rgb[2]}, 1);
}

static void place_plot(sheet *s, const btg_verify_map *map) {
    double half = 0.5 * map->cell_mm;
    s->x_min = map->x_mm - half;
    s->y_min = map->y_mm - half;
    s->x_max = s->x_min + map->width * map->cell_mm;
    s->y_max = s->y_min + map->height * map->cell_mm;
    s->scale = fmin(PLOT_WIDTH / (s->x_max - s->x_min), PLOT_HEIGHT / (s->y_max - s->y_min));
    s->width = fmax(floor((s->x_max - s->x_min) * s->scale), 1);
    s->height = fmax(floor((s->y_max - s->y_min) * s->scale), 1);
    s->left = PLOT_LEFT;
    s->top = PLOT_TOP;
    s->bottom = fmax(PLOT_TOP + s->height + BELOW_PLOT, PANEL_BOTTOM);
}

/* Cells [from, to) under a pixel: one at least. */
static void under(double pixel, double pixels, uint32_t cells, uint32_t range[2]) {
    range[0] = (uint32_t)(pixel / pixels * cells);
    range[1] = (uint32_t)ceil((pixel + 1) / pixels * cells);
    if (range[1] > cells) range[1] = cells;
    if (range[0] >= range[1]) range[0] = range[1] - 1;
}

/* The deviation farthest beyond its limit under a pixel, so that no gouge is too small to be seen.
 * False: no part there. */
static bool worst(const sheet *s, const btg_verify_map *map, const btg_map_scale *scale, int x,
                  int y, double *deviation) {
    uint32_t columns[2], rows[2];
    double most = -1;
    under(x, s->width, map->width, columns);
    under(s->height - 1 - y, s->height, map->height, rows);
    for (uint32_t j = rows[0]; j < rows[1]; j++)
        for (uint32_t i = columns[0]; i < columns[1]; i++) {
            double d = btg_verify_deviation(map, (size_t)j * map->width + i);
            double limit = d < 0 ? scale->gouge_mm : scale->scallop_mm;
            double excess = fabs(d) / (limit > 0 ? limit : 1e-6);
            if (!(excess > most)) continue;
            most = excess;
            *deviation = d;
        }
    return most >= 0;
}

static btg_status draw_field(const sheet *s, const btg_verify_map *map,
                             const btg_map_scale *scale) {
    int width = (int)s->width, height = (int)s->height;
    cairo_surface_t *image = cairo_image_surface_create(CAIRO_FORMAT_ARGB32, width, height);
    unsigned char *data = cairo_image_surface_get_data(image);
    if (!data) {
        cairo_surface_destroy(image);
        return BTG_ERROR_MEMORY;
    }
    size_t stride = (size_t)cairo_image_surface_get_stride(image);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            double deviation = 0;
            float c[3];
            uint32_t argb = 0;
            if (worst(s, map, scale, x, y, &deviation)) {
                btg_map_colour(scale, deviation, c);
                argb = 0xff000000u | (uint32_t)(c[0] * 255 + 0.5f) << 16 |
                       (uint32_t)(c[1] * 255 + 0.5f) << 8 | (uint32_t)(c[2] * 255 + 0.5f);
            }
            memcpy(data + (size_t)y * stride + 4 * (size_t)x, &argb, sizeof argb);
        }
    cairo_surface_mark_dirty(image);
    cairo_set_source_surface(s->cr, image, s->left, s->top);
    cairo_paint(s->cr);
    cairo_surface_destroy(image);
    return BTG_OK;
}

/* ---- the panel ---------------------------------------------------------------------------- */

static double heading(cairo_t *cr, double y, const char *text) {
    btg_sheet_ink(cr, colour_ink, 1);
    btg_sheet_bold(cr, 1);
    btg_sheet_text(cr, PANEL_LEFT, y, TEXT_SIZE, 0, text);
    btg_sheet_bold(cr, 0);
    return y + ROW_HEIGHT;
}

static double swatch(cairo_t *cr, double y, const btg_map_scale *scale, double deviation,
                     const char *label) {
    float c[3];
    btg_map_colour(scale, deviation, c);
    ink(cr, c);
    cairo_rectangle(cr, PANEL_LEFT, y - 13, 24, 17);
    cairo_fill(cr);
    btg_sheet_ink(cr, colour_ink, 1);
    btg_sheet_text(cr, PANEL_LEFT + 36, y, TEXT_SIZE, 0, label);
    return y + ROW_HEIGHT;
}

static double side(cairo_t *cr, double y, const btg_map_scale *scale, double sign) {
    double limit = sign < 0 ? scale->gouge_mm : scale->scallop_mm;
    char label[64];
    for (int k = 0; k <= SWATCHES; k++) {
        double at = limit * pow(10, k);
        snprintf(label, sizeof label, "%s%.4g mm%s", k == 0 ? "just over " : "", at,
                 k == SWATCHES ? " and more" : "");
        y = swatch(cr, y, scale, sign * at * (1 + 1e-9), label);
    }
    return y;
}

static double figure(cairo_t *cr, double y, const char *name, double value, const char *unit) {
    char text[48];
    snprintf(text, sizeof text, "%.4g %s", value, unit);
    btg_sheet_text(cr, PANEL_LEFT, y, TEXT_SIZE, 0, name);
    btg_sheet_text(cr, PANEL_LEFT + PANEL_WIDTH, y, TEXT_SIZE, 1, text);
    return y + ROW_HEIGHT;
}

static void draw_panel(cairo_t *cr, const btg_verify_result *r, const btg_map_scale *scale) {
    char label[64];
    double y = heading(cr, PLOT_TOP + 14, "Left on the part");
    y = side(cr, y, scale, 1);
    snprintf(label, sizeof label, "finished: -%.4g to %.4g mm", scale->gouge_mm, scale->scallop_mm);
    y = swatch(cr, y + 8, scale, 0, label);
    y = heading(cr, y + 14, "Cut into it");
    y = side(cr, y, scale, -1);
    y = heading(cr, y + 14, "Figures");
    y = figure(cr, y, "greatest gouge", r->max_gouge_mm, "mm");
    y = figure(cr, y, "gouged area", r->gouge_area_mm2, "mm\xc2\xb2");
    y = figure(cr, y, "most left", r->max_scallop_mm, "mm");
    y = figure(cr, y, "mean left", r->mean_scallop_mm, "mm");
    y = figure(cr, y, "90 % have at most", r->percentile_mm[1], "mm");
    y = figure(cr, y, "strip width", r->strip_width_mm, "mm");
    y = figure(cr, y, "uncut area", r->uncut_mm2, "mm\xc2\xb2");
    figure(cr, y, "cells of", r->cell_mm, "mm");
}

static void draw_titles(cairo_t *cr, const char *title, const btg_verify_result *r) {
    char line[128];
    btg_sheet_ink(cr, colour_ink, 1);
    btg_sheet_bold(cr, 1);
    btg_sheet_text_within(cr, PLOT_LEFT, 42, 22, SHEET_WIDTH - 2 * PLOT_LEFT, title);
    btg_sheet_bold(cr, 0);
    snprintf(line, sizeof line,
             "what %llu tool positions and the moves between them leave, from +z",
             (unsigned long long)r->positions);
    btg_sheet_text(cr, PLOT_LEFT, 68, TEXT_SIZE + 1, 0, line);
}

static void draw_worst(const sheet *s, const btg_verify_result *r) {
    if (r->gouge.position == 0) return;
    double x = btg_sheet_x(s, r->gouge.at.x), y = btg_sheet_y(s, r->gouge.at.y);
    btg_sheet_ink(s->cr, colour_ink, 1);
    cairo_set_line_width(s->cr, 1.5);
    cairo_arc(s->cr, x, y, 9, 0, TURN);
    cairo_stroke(s->cr);
}

btg_status btg_map_png(const btg_verify_map *map, const btg_verify_result *result,
                       const btg_map_scale *scale, const char *title, btg_output *output,
                       btg_message *message) {
    sheet s = {0};
    place_plot(&s, map);
    cairo_surface_t *surface =
        cairo_image_surface_create(CAIRO_FORMAT_RGB24, SHEET_WIDTH, (int)s.bottom);
    s.cr = cairo_create(surface);
    btg_sheet_ink(s.cr, (colour){1, 1, 1}, 1);
    cairo_paint(s.cr);
    draw_titles(s.cr, title, result);
    btg_status status = draw_field(&s, map, scale);
    draw_worst(&s, result);
    btg_sheet_axes(&s);
    draw_panel(s.cr, result, scale);
    if (cairo_status(s.cr) != CAIRO_STATUS_SUCCESS) status = BTG_ERROR_MEMORY;
    if (status >= 0) status = btg_sheet_png(surface, output);
    cairo_destroy(s.cr);
    cairo_surface_destroy(surface);
    if (status >= 0) return btg_output_check(output, message);
    return btg_fail(message, status, "picture: not enough memory to draw it");
}
