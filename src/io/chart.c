#include "io/chart.h"
#include "core/part.h"
#include "io/picture_sheet.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Pixels: a panel with its axes and names, and the plot inside it. */
#define CELL_WIDTH   560.0
#define CELL_HEIGHT  430.0
#define LEFT         76.0
#define RIGHT        24.0
#define TOP          34.0
#define BOTTOM       60.0
#define HEAD         54.0 /* the chart's title */
#define LEGEND_LINE  19.0
#define LEGEND_WIDTH 30.0
#define DOT          1.9

/* One panel as it is drawn: where, and from what to what. */
typedef struct frame {
    cairo_t *cr;
    double left, top, width, height;
    double x_min, x_max, y_min, y_max;
} frame;

/* Okabe and Ito's. */
static const colour palette[BTG_CHART_COLOURS] = {{0.000, 0.447, 0.698}, {0.835, 0.369, 0.000},
                                                  {0.000, 0.620, 0.451}, {0.800, 0.475, 0.655},
                                                  {0.420, 0.490, 0.560}, {0.130, 0.150, 0.180}};

btg_chart_panel btg_chart_panel_of(const char *title, const char *x_name, const char *y_name) {
    return (btg_chart_panel){.title = title,
                             .x_name = x_name,
                             .y_name = y_name,
                             .x_min = NAN,
                             .x_max = NAN,
                             .y_min = NAN,
                             .y_max = NAN};
}

bool btg_chart_add(btg_chart_panel *panel, btg_chart_kind kind, int ink, const char *name,
                   const double *x, const double *y, size_t count) {
    if (panel->series_count == BTG_CHART_SERIES_MAX) return false;
    panel->series[panel->series_count++] = (btg_chart_series){name, kind, ink, x, y, count};
    return true;
}

/* ---- limits ------------------------------------------------------------------------------- */

static void widen(double value, double *low, double *high) {
    if (!isfinite(value)) return;
    *low = fmin(*low, value);
    *high = fmax(*high, value);
}

static double bar_width(const btg_chart_series *s) {
    return s->count > 1 ? s->x[1] - s->x[0] : 1;
}

/* Bars stand on 0 and are as wide as they are apart. */
static void measure(const btg_chart_panel *p, frame *f) {
    f->x_min = f->y_min = INFINITY;
    f->x_max = f->y_max = -INFINITY;
    for (size_t k = 0; k < p->series_count; k++) {
        const btg_chart_series *s = &p->series[k];
        double half = s->kind == BTG_CHART_BARS ? 0.5 * bar_width(s) : 0;
        if (half > 0) widen(0, &f->y_min, &f->y_max);
        for (size_t i = 0; i < s->count; i++) {
            widen(s->x[i] - half, &f->x_min, &f->x_max);
            widen(s->x[i] + half, &f->x_min, &f->x_max);
            widen(s->y[i], &f->y_min, &f->y_max);
        }
    }
}

static void settle(double given_min, double given_max, double *low, double *high) {
    if (!(*low <= *high)) *low = 0, *high = 1;
    double room = 0.04 * (*high - *low);
    if (*low != 0) *low -= room;
    *high += room;
    if (isfinite(given_min)) *low = given_min;
    if (isfinite(given_max)) *high = given_max;
    if (*high - *low < 1e-12) *high = *low + 1;
}

static void keep_scale(frame *f) {
    double across = (f->x_max - f->x_min) / f->width, up = (f->y_max - f->y_min) / f->height;
    if (across > up) {
        double middle = 0.5 * (f->y_min + f->y_max), half = 0.5 * across * f->height;
        f->y_min = middle - half;
        f->y_max = middle + half;
    } else {
        double middle = 0.5 * (f->x_min + f->x_max), half = 0.5 * up * f->width;
        f->x_min = middle - half;
        f->x_max = middle + half;
    }
}

static double at_x(const frame *f, double x) {
    return f->left + (x - f->x_min) / (f->x_max - f->x_min) * f->width;
}

static double at_y(const frame *f, double y) {
    return f->top + (f->y_max - y) / (f->y_max - f->y_min) * f->height;
}

/* ---- axes --------------------------------------------------------------------------------- */

static void tick(const frame *f, bool vertical, double value, double step) {
    char label[32];
    double x = vertical ? f->left : floor(at_x(f, value)) + 0.5;
    double y = vertical ? floor(at_y(f, value)) + 0.5 : f->top + f->height;
    btg_sheet_ink(f->cr, colour_ink, 0.12);
    cairo_move_to(f->cr, x, y);
    cairo_rel_line_to(f->cr, vertical ? f->width : 0, vertical ? 0 : -f->height);
    cairo_stroke(f->cr);
    btg_sheet_ink(f->cr, colour_ink, 1);
    cairo_move_to(f->cr, x, y);
    cairo_rel_line_to(f->cr, vertical ? -5 : 0, vertical ? 0 : 5);
    cairo_stroke(f->cr);
    btg_sheet_number(label, sizeof label, value, step);
    btg_sheet_text(f->cr, vertical ? x - 8 : x, vertical ? y + 4 : y + 19, TEXT_SIZE - 1,
                   vertical ? 1 : 0.5, label);
}

static void ticks(const frame *f, bool vertical) {
    double low = vertical ? f->y_min : f->x_min, high = vertical ? f->y_max : f->x_max;
    double step = btg_sheet_step(high - low, vertical ? 6 : 7);
    cairo_set_line_width(f->cr, 1);
    for (double k = ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++)
        tick(f, vertical, k * step, step);
}

static void axes(const frame *f, const btg_chart_panel *p) {
    ticks(f, false);
    ticks(f, true);
    cairo_rectangle(f->cr, floor(f->left) + 0.5, floor(f->top) + 0.5, f->width, f->height);
    cairo_stroke(f->cr);
    btg_sheet_bold(f->cr, 1);
    btg_sheet_text_within(f->cr, f->left, f->top - 12, TEXT_SIZE + 1, f->width, p->title);
    btg_sheet_bold(f->cr, 0);
    btg_sheet_text(f->cr, f->left + f->width / 2, f->top + f->height + 42, TEXT_SIZE, 0.5,
                   p->x_name);
    cairo_save(f->cr);
    cairo_translate(f->cr, f->left - 58, f->top + f->height / 2);
    cairo_rotate(f->cr, -TURN / 4);
    btg_sheet_text(f->cr, 0, 0, TEXT_SIZE, 0.5, p->y_name);
    cairo_restore(f->cr);
}

/* ---- series ------------------------------------------------------------------------------- */

static bool exists(const btg_chart_series *s, size_t i) {
    return isfinite(s->x[i]) && isfinite(s->y[i]);
}

static void draw_line(const frame *f, const btg_chart_series *s) {
    const double dashes[2] = {7, 5};
    bool going = false;
    cairo_set_line_width(f->cr, 1.8);
    if (s->kind == BTG_CHART_DASHES) cairo_set_dash(f->cr, dashes, 2, 0);
    for (size_t i = 0; i < s->count; i++) {
        if (!exists(s, i)) {
            going = false;
            continue;
        }
        if (going)
            cairo_line_to(f->cr, at_x(f, s->x[i]), at_y(f, s->y[i]));
        else
            cairo_move_to(f->cr, at_x(f, s->x[i]), at_y(f, s->y[i]));
        going = true;
    }
    cairo_stroke(f->cr);
    cairo_set_dash(f->cr, NULL, 0, 0);
}

static void draw_joins(const frame *f, const btg_chart_series *s) {
    cairo_set_line_width(f->cr, 0.6);
    for (size_t i = 0; i + 1 < s->count; i += 2) {
        if (!exists(s, i) || !exists(s, i + 1)) continue;
        cairo_move_to(f->cr, at_x(f, s->x[i]), at_y(f, s->y[i]));
        cairo_line_to(f->cr, at_x(f, s->x[i + 1]), at_y(f, s->y[i + 1]));
    }
    cairo_stroke(f->cr);
}

static void draw_marks(const frame *f, const btg_chart_series *s) {
    double half = 0.5 * bar_width(s), ground = at_y(f, 0);
    for (size_t i = 0; i < s->count; i++) {
        if (!exists(s, i)) continue;
        double x = at_x(f, s->x[i]), y = at_y(f, s->y[i]);
        if (s->kind == BTG_CHART_DOTS) {
            cairo_arc(f->cr, x, y, DOT, 0, TURN);
        } else {
            double left = at_x(f, s->x[i] - half), right = at_x(f, s->x[i] + half);
            cairo_rectangle(f->cr, left + 0.5, y, right - left - 1, ground - y);
        }
        cairo_fill(f->cr);
    }
}

static void draw_series(const frame *f, const btg_chart_series *s) {
    btg_sheet_ink(f->cr, palette[s->ink], s->kind == BTG_CHART_JOINS ? 0.6 : 1);
    switch (s->kind) {
    case BTG_CHART_LINE:
    case BTG_CHART_DASHES:
        draw_line(f, s);
        break;
    case BTG_CHART_JOINS:
        draw_joins(f, s);
        break;
    default:
        draw_marks(f, s);
    }
}

/* A sample of a series, and its name, on a pale ground at the plot's top. */
static void legend(const frame *f, const btg_chart_panel *p) {
    double widest = 0, y = f->top + 8;
    size_t lines = 0;
    cairo_set_font_size(f->cr, TEXT_SIZE - 1);
    for (size_t k = 0; k < p->series_count; k++) {
        cairo_text_extents_t e;
        if (!p->series[k].name) continue;
        cairo_text_extents(f->cr, p->series[k].name, &e);
        widest = fmax(widest, e.x_advance);
        lines++;
    }
    if (lines == 0) return;
    double left = f->left + f->width - widest - LEGEND_WIDTH - 16;
    if (p->legend_left) left = f->left + 10;
    btg_sheet_ink(f->cr, (colour){1, 1, 1}, 0.85);
    cairo_rectangle(f->cr, left - 4, y - 4, widest + LEGEND_WIDTH + 14,
                    (double)lines * LEGEND_LINE + 6);
    cairo_fill(f->cr);
    for (size_t k = 0; k < p->series_count; k++) {
        const btg_chart_series *s = &p->series[k];
        if (!s->name) continue;
        double xs[2] = {0, 1}, ys[2] = {0.5, 0.5};
        btg_chart_series sample = {NULL, s->kind, s->ink, xs, ys, 2};
        frame at = {f->cr, left, y, LEGEND_WIDTH - 8, LEGEND_LINE - 4, 0, 1, 0, 1};
        if (s->kind == BTG_CHART_BARS || s->kind == BTG_CHART_DOTS) xs[0] = 0.5, sample.count = 1;
        draw_series(&at, &sample);
        btg_sheet_ink(f->cr, colour_ink, 1);
        btg_sheet_text(f->cr, left + LEGEND_WIDTH, y + 12, TEXT_SIZE - 1, 0, s->name);
        y += LEGEND_LINE;
    }
}

static void draw_panel(cairo_t *cr, const btg_chart_panel *p, double left, double top) {
    frame f = {.cr = cr, .left = left + LEFT, .top = top + TOP};
    f.width = CELL_WIDTH - LEFT - RIGHT;
    f.height = CELL_HEIGHT - TOP - BOTTOM;
    measure(p, &f);
    settle(p->x_min, p->x_max, &f.x_min, &f.x_max);
    settle(p->y_min, p->y_max, &f.y_min, &f.y_max);
    if (p->same_scale) keep_scale(&f);
    axes(&f, p);
    cairo_save(cr);
    cairo_rectangle(cr, f.left, f.top, f.width, f.height);
    cairo_clip(cr);
    for (size_t k = 0; k < p->series_count; k++)
        draw_series(&f, &p->series[k]);
    cairo_restore(cr);
    legend(&f, p);
}

/* ---- the file ----------------------------------------------------------------------------- */

static btg_status draw(cairo_surface_t *surface, const char *title, const btg_chart_panel *panels,
                       size_t count, size_t columns, double width) {
    cairo_t *cr = cairo_create(surface);
    btg_sheet_ink(cr, (colour){1, 1, 1}, 1);
    cairo_paint(cr);
    btg_sheet_ink(cr, colour_ink, 1);
    btg_sheet_bold(cr, 1);
    btg_sheet_text_within(cr, LEFT, 36, 20, width - LEFT - RIGHT, title);
    btg_sheet_bold(cr, 0);
    for (size_t i = 0; i < count; i++)
        draw_panel(cr, &panels[i], (double)(i % columns) * CELL_WIDTH,
                   HEAD + (double)(i / columns) * CELL_HEIGHT);
    bool drawn = cairo_status(cr) == CAIRO_STATUS_SUCCESS;
    cairo_destroy(cr);
    return drawn ? BTG_OK : BTG_ERROR_MEMORY;
}

btg_status btg_chart_write(const char *path, const char *title, const btg_chart_panel *panels,
                           size_t panel_count, size_t columns, btg_message *message) {
    size_t length = strlen(path), rows = (panel_count + columns - 1) / columns;
    bool svg = length > 4 && strcmp(path + length - 4, ".svg") == 0;
    double width = (double)columns * CELL_WIDTH, height = HEAD + (double)rows * CELL_HEIGHT;
    btg_output output;
    btg_status status = btg_output_open(&output, path, message);
    if (status != BTG_OK) return status;
    cairo_surface_t *surface =
        svg ? btg_sheet_svg(&output, width, height)
            : cairo_image_surface_create(CAIRO_FORMAT_RGB24, (int)width, (int)height);
    status = draw(surface, title, panels, panel_count, columns, width);
    if (status == BTG_OK && !svg) status = btg_sheet_png(surface, &output);
    cairo_surface_finish(surface);
    cairo_surface_destroy(surface);
    if (status != BTG_OK) btg_fail(message, status, "%.256s: not enough memory to draw it", path);
    if (status == BTG_OK) status = btg_output_finish(&output, message);
    if (status == BTG_OK) status = btg_output_commit(&output, message);
    btg_output_discard(&output);
    return status;
}
