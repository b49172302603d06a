#include "io/picture.h"
#include "core/part.h"
#include "io/picture_sheet.h"
#include "io/relief.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MARKS_FIRST 1024
#define OVERSAMPLE  2 /* relief pixels per picture pixel and side: smooth outlines */
/* Brightness = SHADE_DARK + SHADE_RANGE * cosine: level ground keeps its colour. */
#define SHADE_DARK   0.46
#define SHADE_RANGE  0.80
#define CONTOUR_DARK 0.26 /* how much darker a line of equal height is */
#define CONTOUR_HALF 1.0  /* half its width, relief pixels */

bool btg_picture_available(void) {
    return true;
}

void btg_picture_add(btg_picture *picture, const btg_position *position) {
    if (picture->count == picture->capacity) {
        size_t capacity = picture->capacity ? 2 * picture->capacity : MARKS_FIRST;
        btg_picture_mark *marks = NULL;
        if (capacity <= SIZE_MAX / sizeof *marks)
            marks = realloc(picture->marks, capacity * sizeof *marks);
        if (!marks) {
            picture->short_of_memory = true;
            return;
        }
        picture->marks = marks;
        picture->capacity = capacity;
    }
    picture->marks[picture->count++] = (btg_picture_mark){
        .foot_mm = {position->foot_x_mm, position->foot_y_mm},
        .p_mm = {position->p.point.x, position->p.point.y},
        .q_mm = {position->q.point.x, position->q.point.y},
        .tilt_rad = (float)position->tilt_rad,
        .status = (int8_t)position->status,
    };
}

void btg_picture_release(btg_picture *picture) {
    free(picture->marks);
    *picture = (btg_picture){0};
}

/* ---- the plot ----------------------------------------------------------------------------- */

static bool exists(const double at[2]) {
    return isfinite(at[0]) && isfinite(at[1]);
}

static void widen(sheet *s, const double at[2]) {
    if (!exists(at)) return;
    s->x_min = fmin(s->x_min, at[0]);
    s->x_max = fmax(s->x_max, at[0]);
    s->y_min = fmin(s->y_min, at[1]);
    s->y_max = fmax(s->y_max, at[1]);
}

static void place_plot(sheet *s, const btg_part *part, const btg_picture *picture) {
    btg_part_info info;
    btg_part_get_info(part, &info);
    s->x_min = info.box_min.x, s->x_max = info.box_max.x;
    s->y_min = info.box_min.y, s->y_max = info.box_max.y;
    s->z_min = info.box_min.z, s->z_max = info.box_max.z;
    for (size_t i = 0; i < picture->count; i++)
        widen(s, picture->marks[i].foot_mm);
    /* A margin, and some width where the part has none. */
    double longer = fmax(fmax(s->x_max - s->x_min, s->y_max - s->y_min), 1e-3);
    double margin = 0.03 * longer;
    double pad_x = fmax(margin, 0.05 * longer - 0.5 * (s->x_max - s->x_min));
    double pad_y = fmax(margin, 0.05 * longer - 0.5 * (s->y_max - s->y_min));
    s->x_min -= pad_x, s->x_max += pad_x;
    s->y_min -= pad_y, s->y_max += pad_y;
    s->scale = fmin(PLOT_WIDTH / (s->x_max - s->x_min), PLOT_HEIGHT / (s->y_max - s->y_min));
    s->width = floor((s->x_max - s->x_min) * s->scale);
    s->height = floor((s->y_max - s->y_min) * s->scale);
    s->left = PLOT_LEFT;
    s->top = PLOT_TOP;
    /* Crowded paths get finer marks. */
    double room = sqrt(s->width * s->height / (double)(picture->count + 1));
    s->mark = fmin(fmax(0.09 * room, 0.6), 2.8);
}

/* ---- the part ---------------------------------------------------------------------------- */

/* Darker below 1, towards white above. */
static colour lit(colour c, double shade) {
    double keep = shade < 1 ? shade : fmax(2 - shade, 0), add = fmin(fmax(shade - 1, 0), 1);
    return (colour){c.r * keep + add, c.g * keep + add, c.b * keep + add};
}

/* 1 on a line of equal height, 0 off it, from the slope in pixels. */
static double on_contour(double z, double dz_column, double dz_row, double step) {
    double slope = hypot(dz_column, dz_row);
    double off = fabs(z / step - floor(z / step + 0.5)) * step;
    if (!(slope > 1e-9 * step)) return 0;
    return fmin(fmax(CONTOUR_HALF + 0.5 - off / slope, 0), 1);
}

/* Colour of one relief pixel: height, light, lines of equal height and outlines; 0: no part. */
static int relief_colour(const sheet *s, const btg_relief *r, int column, int row, colour *c) {
    size_t at = (size_t)row * (size_t)r->width + (size_t)column;
    double z = r->z_mm[at], step = btg_sheet_contour_step(s), beside[2] = {-INFINITY, -INFINITY};
    if (z == -INFINITY) return 0;
    if (column + 1 < r->width) beside[0] = r->z_mm[at + 1];
    if (row + 1 < r->height) beside[1] = r->z_mm[at + (size_t)r->width];
    double shade = SHADE_DARK + SHADE_RANGE * r->light[at];
    if (beside[0] == -INFINITY || beside[1] == -INFINITY)
        shade *= 0.6;
    else if (step > 0)
        shade *= 1 - CONTOUR_DARK * on_contour(z, beside[0] - z, beside[1] - z, step);
    *c =
        btg_sheet_height_colour(s->z_max > s->z_min ? (z - s->z_min) / (s->z_max - s->z_min) : 0.5);
    *c = lit(*c, shade);
    return 1;
}

static void average_pixel(const sheet *s, const btg_relief *r, int x, int y, unsigned char *bgra) {
    colour sum = {0, 0, 0};
    int covered = 0;
    for (int i = 0; i < OVERSAMPLE * OVERSAMPLE; i++) {
        colour c;
        if (!relief_colour(s, r, x * OVERSAMPLE + i % OVERSAMPLE, y * OVERSAMPLE + i / OVERSAMPLE,
                           &c))
            continue;
        sum.r += c.r, sum.g += c.g, sum.b += c.b;
        ++covered;
    }
    double to_byte = 255.0 / (OVERSAMPLE * OVERSAMPLE);
    uint32_t argb = (uint32_t)(covered * to_byte + 0.5) << 24 |
                    (uint32_t)(sum.r * to_byte + 0.5) << 16 |
                    (uint32_t)(sum.g * to_byte + 0.5) << 8 | (uint32_t)(sum.b * to_byte + 0.5);
    memcpy(bgra, &argb, sizeof argb); /* Cairo's order: native, colours times alpha */
}

static btg_status draw_part(const sheet *s, const btg_part *part) {
    int width = (int)s->width, height = (int)s->height;
    btg_relief relief = {.width = width * OVERSAMPLE,
                         .height = height * OVERSAMPLE,
                         .x_min_mm = s->x_min,
                         .y_max_mm = s->y_max,
                         .mm_per_pixel = 1 / (s->scale * OVERSAMPLE)};
    btg_status status = btg_relief_render(&relief, part);
    if (status < 0) return status;
    cairo_surface_t *image = cairo_image_surface_create(CAIRO_FORMAT_ARGB32, width, height);
    unsigned char *data = cairo_image_surface_get_data(image);
    if (!data) {
        cairo_surface_destroy(image);
        btg_relief_release(&relief);
        return BTG_ERROR_MEMORY;
    }
    size_t stride = (size_t)cairo_image_surface_get_stride(image);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            average_pixel(s, &relief, x, y, data + (size_t)y * stride + 4 * (size_t)x);
    cairo_surface_mark_dirty(image);
    cairo_set_source_surface(s->cr, image, s->left, s->top);
    cairo_paint(s->cr);
    cairo_surface_destroy(image);
    btg_relief_release(&relief);
    return BTG_OK;
}

/* ---- the path ---------------------------------------------------------------------------- */

static void mark_at(const sheet *s, mark_kind kind, const double at[2]) {
    if (exists(at))
        btg_sheet_mark(s->cr, kind, btg_sheet_x(s, at[0]), btg_sheet_y(s, at[1]), s->mark);
}

static void draw_join(const sheet *s, const btg_picture_mark *m) {
    if (m->status != BTG_OK || !exists(m->p_mm) || !exists(m->q_mm)) return;
    cairo_move_to(s->cr, btg_sheet_x(s, m->p_mm[0]), btg_sheet_y(s, m->p_mm[1]));
    cairo_line_to(s->cr, btg_sheet_x(s, m->q_mm[0]), btg_sheet_y(s, m->q_mm[1]));
    cairo_stroke(s->cr);
}

static void draw_path(const sheet *s, const btg_picture *picture) {
    const btg_picture_mark *end = picture->marks + picture->count;
    cairo_save(s->cr);
    cairo_rectangle(s->cr, s->left, s->top, s->width, s->height);
    cairo_clip(s->cr);
    for (const btg_picture_mark *m = picture->marks; m < end; m++)
        mark_at(s, m->status == BTG_NO_CONTACT ? MARK_NONE : MARK_FOOT, m->foot_mm);
    btg_sheet_ink(s->cr, colour_ink, 0.42);
    cairo_set_line_width(s->cr, fmin(0.3 * s->mark, 0.8));
    for (const btg_picture_mark *m = picture->marks; m < end; m++)
        draw_join(s, m);
    for (const btg_picture_mark *m = picture->marks; m < end; m++)
        if (m->status == BTG_OK) mark_at(s, MARK_Q, m->q_mm);
    for (const btg_picture_mark *m = picture->marks; m < end; m++)
        if (m->status == BTG_OK) mark_at(s, MARK_P, m->p_mm);
    for (const btg_picture_mark *m = picture->marks; m < end; m++) { /* the rare ones on top */
        if (m->status == BTG_OSCULATING) mark_at(s, MARK_OSCULATING, m->p_mm);
        if (m->status == BTG_SINGLE_CONTACT) mark_at(s, MARK_SINGLE, m->p_mm);
    }
    cairo_restore(s->cr);
}

/* ---- the file ---------------------------------------------------------------------------- */

static void draw_titles(cairo_t *cr, const char *title, size_t count) {
    char line[96];
    btg_sheet_ink(cr, colour_ink, 1);
    btg_sheet_bold(cr, 1);
    btg_sheet_text_within(cr, PLOT_LEFT, 42, 22, SHEET_WIDTH - 2 * PLOT_LEFT, title);
    btg_sheet_bold(cr, 0);
    snprintf(line, sizeof line, "%zu tool positions, seen from +z", count);
    btg_sheet_text(cr, PLOT_LEFT, 68, TEXT_SIZE + 1, 0, line);
}

static btg_status draw(const sheet *s, const btg_part *part, const btg_tool *tool,
                       const btg_picture *picture, const char *title) {
    btg_sheet_ink(s->cr, (colour){1, 1, 1}, 1);
    cairo_paint(s->cr);
    draw_titles(s->cr, title, picture->count);
    btg_status status = draw_part(s, part);
    if (status < 0) return status;
    draw_path(s, picture);
    btg_sheet_axes(s);
    btg_sheet_panel(s, tool, picture);
    return cairo_status(s->cr) == CAIRO_STATUS_SUCCESS ? BTG_OK : BTG_ERROR_MEMORY;
}

btg_status btg_picture_write(const btg_picture *picture, btg_output *output, const btg_part *part,
                             const btg_tool *tool, const char *title, btg_message *message) {
    sheet s = {0};
    place_plot(&s, part, picture);
    s.bottom = fmax(PLOT_TOP + s.height + BELOW_PLOT, PANEL_BOTTOM);
    cairo_surface_t *surface =
        cairo_image_surface_create(CAIRO_FORMAT_RGB24, SHEET_WIDTH, (int)s.bottom);
    s.cr = cairo_create(surface);
    btg_status status = BTG_ERROR_MEMORY;
    if (!picture->short_of_memory) status = draw(&s, part, tool, picture, title);
    if (status >= 0) status = btg_sheet_png(surface, output);
    cairo_destroy(s.cr);
    cairo_surface_destroy(surface);
    if (status >= 0) return btg_output_check(output, message);
    return btg_fail(message, status, "picture: not enough memory to draw it; choose longer steps");
}
