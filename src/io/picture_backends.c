#include "io/picture_backends.h"
#include "core/part.h"
#include "io/picture_sheet.h"

#include <math.h>
#include <stdio.h>

/* Pixels. */
#define TOP         132.0
#define ROW         92.0
#define BAR         24.0
#define SPEED_LEFT  150.0
#define SPEED_WIDTH 560.0
#define ERROR_LEFT  800.0
#define ERROR_WIDTH 410.0
#define BYTES_RIGHT 1350.0
#define FOOT        96.0

/* Dark to pale: what the device does not do is what one looks for. */
static const colour phase_colour[BTG_PICTURE_PHASES] = {
    {0.90, 0.62, 0.00}, {0.34, 0.45, 0.56}, {0.80, 0.47, 0.65}, {0.34, 0.71, 0.91}};
static const char *const phase_name[BTG_PICTURE_PHASES] = {"upload", "device", "read back",
                                                           "polish and proof"};

/* A logarithmic axis from 10^low to 10^high. */
typedef struct axis {
    double left, width;
    int low, high;
} axis;

static double place(const axis *a, double value) {
    double t = (log10(value) - a->low) / (a->high - a->low);
    return a->left + a->width * fmin(fmax(t, 0), 1);
}

static void widen(axis *a, double value) {
    if (!(value > 0) || !isfinite(value)) return;
    int low = (int)floor(log10(value)), high = (int)ceil(log10(value));
    if (a->low > a->high) {
        a->low = low;
        a->high = high;
    }
    a->low = low < a->low ? low : a->low;
    a->high = high > a->high ? high : a->high;
    if (a->low == a->high) a->high++;
}

static void draw_axis(cairo_t *cr, const axis *a, double bottom, const char *name) {
    cairo_set_line_width(cr, 1);
    int step = a->high - a->low > 9 ? 3 : 1;
    for (int k = a->low; k <= a->high; k += step) {
        char label[24];
        double x = floor(a->left + a->width * (k - a->low) / (a->high - a->low)) + 0.5;
        if (k >= 0 && k < 7)
            snprintf(label, sizeof label, "%.0f", pow(10, k));
        else
            snprintf(label, sizeof label, "1e%d", k);
        btg_sheet_ink(cr, colour_ink, 0.18);
        cairo_move_to(cr, x, TOP - 16);
        cairo_line_to(cr, x, bottom);
        cairo_stroke(cr);
        btg_sheet_ink(cr, colour_ink, 1);
        btg_sheet_text(cr, x, bottom + 20, TEXT_SIZE - 1, 0.5, label);
    }
    btg_sheet_bold(cr, 1);
    btg_sheet_text(cr, a->left, TOP - 26, TEXT_SIZE, 0, name);
    btg_sheet_bold(cr, 0);
}

/* One bar, cut in proportion to the phases where there are any. */
static void draw_bar(cairo_t *cr, const axis *a, double y, double value, const double *phase,
                     double alpha) {
    char label[32];
    if (!(value > 0)) return;
    double end = place(a, value), all = 0, from = a->left;
    for (int i = 0; phase && i < BTG_PICTURE_PHASES; i++)
        all += phase[i];
    if (all > 0) {
        for (int i = 0; i < BTG_PICTURE_PHASES; i++) {
            double to = from + (end - a->left) * phase[i] / all;
            btg_sheet_ink(cr, phase_colour[i], 1);
            cairo_rectangle(cr, from, y, to - from, BAR);
            cairo_fill(cr);
            from = to;
        }
    } else {
        btg_sheet_ink(cr, colour_bar, alpha);
        cairo_rectangle(cr, a->left, y, end - a->left, BAR);
        cairo_fill(cr);
    }
    btg_sheet_ink(cr, colour_ink, 1);
    snprintf(label, sizeof label, "%.3g/s", value);
    if (value >= 1000) snprintf(label, sizeof label, "%.0f/s", value);
    btg_sheet_text(cr, end + 6, y + 17, TEXT_SIZE - 1, 0, label);
}

static void draw_error(cairo_t *cr, const axis *a, double y, double value, bool raw) {
    if (!isfinite(value)) return;
    double x = value > 0 ? place(a, value) : a->left;
    char label[24];
    btg_sheet_ink(cr, raw ? colour_q : colour_p, 1);
    cairo_arc(cr, x, y, 6, 0, TURN);
    cairo_fill(cr);
    btg_sheet_ink(cr, colour_ink, 1);
    snprintf(label, sizeof label, "%.1e", value);
    bool left = x > a->left + 0.75 * a->width;
    btg_sheet_text(cr, left ? x - 11 : x + 11, y + 5, TEXT_SIZE - 2, left ? 1 : 0, label);
}

static void draw_row(cairo_t *cr, const axis *speed, const axis *error, double y,
                     const btg_picture_backend *b) {
    char label[32] = "-";
    btg_sheet_ink(cr, colour_ink, 1);
    btg_sheet_bold(cr, 1);
    btg_sheet_text(cr, SPEED_LEFT - 14, y + 32, TEXT_SIZE + 1, 1, b->name);
    btg_sheet_bold(cr, 0);
    draw_bar(cr, speed, y, b->per_second[0], NULL, 0.45);
    draw_bar(cr, speed, y + BAR + 4, b->per_second[1], b->phase, 1);
    draw_error(cr, error, y + 6, b->raw_mm[0], true);
    draw_error(cr, error, y + 22, b->polished_mm[0], false);
    draw_error(cr, error, y + 42, b->raw_mm[1], true);
    draw_error(cr, error, y + 58, b->polished_mm[1], false);
    if (isfinite(b->bytes)) snprintf(label, sizeof label, "%.3g MB", b->bytes / (1 << 20));
    btg_sheet_ink(cr, colour_ink, 1);
    btg_sheet_text(cr, BYTES_RIGHT, y + 32, TEXT_SIZE, 1, label);
}

static double swatch(cairo_t *cr, double x, double y, colour c, double alpha, bool dot,
                     const char *label) {
    btg_sheet_ink(cr, c, alpha);
    if (dot)
        cairo_arc(cr, x + 10, y - 5, 6, 0, TURN);
    else
        cairo_rectangle(cr, x, y - 12, 20, 14);
    cairo_fill(cr);
    btg_sheet_ink(cr, colour_ink, 1);
    return x + 28 + btg_sheet_text(cr, x + 26, y, TEXT_SIZE - 1, 0, label) + 22;
}

static void draw_legend(cairo_t *cr, double y, const char *const batches[2]) {
    char label[96];
    snprintf(label, sizeof label, "upper bar: %.60s", batches[0]);
    swatch(cr, SPEED_LEFT, y, colour_bar, 0.45, false, label);
    snprintf(label, sizeof label, "lower bar: %.60s, by", batches[1]);
    double x = swatch(cr, SPEED_LEFT, y + 24, colour_bar, 1, false, label);
    for (int i = 0; i < BTG_PICTURE_PHASES; i++)
        x = swatch(cr, x, y + 24, phase_colour[i], 1, false, phase_name[i]);
    x = swatch(cr, ERROR_LEFT, y, colour_q, 1, true, "as the device finds it");
    swatch(cr, x, y, colour_p, 1, true, "as answered");
}

static void draw(cairo_t *cr, const btg_picture_backend *list, size_t count, const char *title,
                 const char *const batches[2]) {
    axis speed = {SPEED_LEFT, SPEED_WIDTH, 1, 0}, error = {ERROR_LEFT, ERROR_WIDTH, 1, 0};
    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < 2; k++) {
            widen(&speed, list[i].per_second[k]);
            widen(&error, list[i].raw_mm[k]);
            widen(&error, list[i].polished_mm[k]);
        }
    double bottom = TOP + ROW * (double)count;
    btg_sheet_ink(cr, (colour){1, 1, 1}, 1);
    cairo_paint(cr);
    btg_sheet_ink(cr, colour_ink, 1);
    btg_sheet_bold(cr, 1);
    btg_sheet_text_within(cr, 60, 42, 22, SHEET_WIDTH - 120, title);
    btg_sheet_bold(cr, 0);
    btg_sheet_text(cr, 60, 68, TEXT_SIZE + 1, 0, "DROP and TILT by every back end of this machine");
    if (speed.low < speed.high) draw_axis(cr, &speed, bottom, "positions a second");
    if (error.low < error.high)
        draw_axis(cr, &error, bottom, "greatest error, mm; upper: drop, lower: all, as clearance");
    btg_sheet_text(cr, BYTES_RIGHT, TOP - 26, TEXT_SIZE, 1, "memory");
    for (size_t i = 0; i < count; i++)
        draw_row(cr, &speed, &error, TOP + ROW * (double)i, &list[i]);
    draw_legend(cr, bottom + 52, batches);
}

btg_status btg_picture_backends(const btg_picture_backend *list, size_t count, const char *title,
                                const char *const batches[2], btg_output *output,
                                btg_message *message) {
    int height = (int)(TOP + ROW * (double)count + FOOT);
    cairo_surface_t *surface = cairo_image_surface_create(CAIRO_FORMAT_RGB24, SHEET_WIDTH, height);
    cairo_t *cr = cairo_create(surface);
    draw(cr, list, count, title, batches);
    btg_status status = cairo_status(cr) == CAIRO_STATUS_SUCCESS ? BTG_OK : BTG_ERROR_MEMORY;
    if (status == BTG_OK) status = btg_sheet_png(surface, output);
    cairo_destroy(cr);
    cairo_surface_destroy(surface);
    if (status == BTG_OK) return btg_output_check(output, message);
    return btg_fail(message, status, "picture: not enough memory to draw it");
}
