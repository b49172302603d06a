#include "io/picture_sheet.h"
#include "io/palette.h"

#include <cairo-svg.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

const colour colour_p = {BTG_RGB_P};
const colour colour_q = {BTG_RGB_Q};
const colour colour_osculating = {BTG_RGB_OSCULATING};
const colour colour_single = {BTG_RGB_SINGLE};
const colour colour_foot = {0.36, 0.38, 0.42};
const colour colour_ink = {BTG_RGB_INK};
const colour colour_bar = {0.42, 0.49, 0.56};

/* Pale, so that marks stand out; lightness alone tells the order. */
static const colour ramp[] = {{0.62, 0.70, 0.77},
                              {0.73, 0.79, 0.82},
                              {0.83, 0.86, 0.84},
                              {0.92, 0.91, 0.84},
                              {0.985, 0.955, 0.86}};
#define RAMP_LAST ((int)(sizeof ramp / sizeof ramp[0]) - 1)

void btg_sheet_ink(cairo_t *cr, colour c, double alpha) {
    cairo_set_source_rgba(cr, c.r, c.g, c.b, alpha);
}

void btg_sheet_bold(cairo_t *cr, int bold) {
    cairo_select_font_face(cr, "sans-serif", CAIRO_FONT_SLANT_NORMAL,
                           bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
}

double btg_sheet_text(cairo_t *cr, double at, double baseline, double size, double align,
                      const char *string) {
    cairo_text_extents_t e;
    cairo_set_font_size(cr, size);
    cairo_text_extents(cr, string, &e);
    cairo_move_to(cr, floor(at - align * e.x_advance + 0.5), floor(baseline + 0.5));
    cairo_show_text(cr, string);
    cairo_new_path(cr);
    return e.x_advance;
}

/* Length of the UTF-8 character that `s` begins with; 0: it is none, or cannot be printed. */
static size_t character(const unsigned char *s) {
    size_t length = s[0] < 0x80 ? 1 : s[0] < 0xC2 ? 0 : s[0] < 0xE0 ? 2 : s[0] < 0xF0 ? 3 : 4;
    if (s[0] < 0x20 || s[0] == 0x7F || s[0] > 0xF4) return 0;
    for (size_t i = 1; i < length; i++)
        if ((s[i] & 0xC0) != 0x80) return 0;
    if (s[0] == 0xE0 && s[1] < 0xA0) return 0; /* overlong */
    if (s[0] == 0xED && s[1] > 0x9F) return 0; /* surrogate */
    if (s[0] == 0xF0 && s[1] < 0x90) return 0;
    if (s[0] == 0xF4 && s[1] > 0x8F) return 0;
    return length;
}

/* Cairo refuses what is not UTF-8, and file names need not be. True when all of it had room. */
static bool make_printable(const char *string, char *clean, size_t size) {
    size_t used = 0;
    while (*string) {
        size_t length = character((const unsigned char *)string), step = length ? length : 1;
        if (used + step >= size) break;
        memcpy(clean + used, length ? string : "?", step);
        used += step;
        string += step;
    }
    clean[used] = '\0';
    return *string == '\0';
}

void btg_sheet_text_within(cairo_t *cr, double at, double baseline, double size, double width,
                           const char *string) {
    static const char ellipsis[] = "\xE2\x80\xA6";
    char clean[256], fitted[sizeof clean + sizeof ellipsis];
    bool whole = make_printable(string, clean, sizeof clean);
    size_t length = strlen(clean);
    cairo_set_font_size(cr, size);
    for (;;) {
        cairo_text_extents_t e;
        snprintf(fitted, sizeof fitted, "%.*s%s", (int)length, clean, whole ? "" : ellipsis);
        cairo_text_extents(cr, fitted, &e);
        if (e.x_advance <= width || length == 0) break;
        whole = false;
        do {
            length--;
        } while (length > 0 && ((unsigned char)clean[length] & 0xC0) == 0x80);
    }
    btg_sheet_text(cr, at, baseline, size, 0, fitted);
}

double btg_sheet_step(double range, double steps) {
    double least = range / steps, power = pow(10, floor(log10(least)));
    double factor = least / power;
    return power * (factor <= 1 + 1e-9 ? 1 : factor <= 2 ? 2 : factor <= 5 ? 5 : 10);
}

void btg_sheet_number(char *buffer, size_t size, double value, double step) {
    int decimals = (int)ceil(-log10(step) - 1e-9);
    if (fabs(value) < step * 1e-6) value = 0;
    snprintf(buffer, size, "%.*f", decimals < 0 ? 0 : decimals > 9 ? 9 : decimals, value);
}

colour btg_sheet_height_colour(double t) {
    double at = fmin(fmax(t, 0), 1) * RAMP_LAST;
    int i = at < RAMP_LAST ? (int)at : RAMP_LAST - 1;
    double f = at - i;
    colour a = ramp[i], b = ramp[i + 1];
    return (colour){a.r + f * (b.r - a.r), a.g + f * (b.g - a.g), a.b + f * (b.b - a.b)};
}

double btg_sheet_contour_step(const sheet *s) {
    double range = s->z_max - s->z_min;
    return range > 1e-6 * (s->x_max - s->x_min) ? btg_sheet_step(range, 12) : 0;
}

void btg_sheet_mark(cairo_t *cr, mark_kind kind, double x, double y, double r) {
    cairo_new_path(cr);
    switch (kind) {
    case MARK_P:
    case MARK_Q:
        btg_sheet_ink(cr, kind == MARK_P ? colour_p : colour_q, 1);
        cairo_arc(cr, x, y, r, 0, TURN);
        cairo_fill(cr);
        break;
    case MARK_OSCULATING:
        btg_sheet_ink(cr, colour_osculating, 1);
        for (int i = 0; i < 4; i++)
            cairo_line_to(cr, x + (i - 1) % 2 * 1.7 * r, y + (i - 2) % 2 * 1.7 * r);
        cairo_fill(cr);
        break;
    case MARK_SINGLE:
        btg_sheet_ink(cr, colour_single, 1);
        cairo_set_line_width(cr, 0.6 * r);
        cairo_rectangle(cr, x - 1.2 * r, y - 1.2 * r, 2.4 * r, 2.4 * r);
        cairo_stroke(cr);
        break;
    case MARK_NONE:
        btg_sheet_ink(cr, colour_single, 0.8);
        cairo_set_line_width(cr, 0.5 * r);
        for (int i = -1; i <= 1; i += 2) {
            cairo_move_to(cr, x - r, y - i * r);
            cairo_line_to(cr, x + r, y + i * r);
        }
        cairo_stroke(cr);
        break;
    case MARK_FOOT:
        btg_sheet_ink(cr, colour_foot, 0.55);
        cairo_arc(cr, x, y, 0.5 * r, 0, TURN);
        cairo_fill(cr);
        break;
    }
}

/* ---- axes and file ------------------------------------------------------------------------ */

double btg_sheet_x(const sheet *s, double x_mm) {
    return s->left + (x_mm - s->x_min) * s->scale;
}

double btg_sheet_y(const sheet *s, double y_mm) {
    return s->top + (s->y_max - y_mm) * s->scale;
}

static void draw_axis(const sheet *s, bool vertical) {
    double from = vertical ? s->y_min : s->x_min, to = vertical ? s->y_max : s->x_max;
    double length = vertical ? s->height : s->width;
    double step = btg_sheet_step(to - from, fmax(length / 70, 1));
    for (double k = ceil(from / step); k * step <= to; ++k) {
        char label[32];
        btg_sheet_number(label, sizeof label, k * step, step);
        double x = vertical ? s->left : floor(btg_sheet_x(s, k * step)) + 0.5;
        double y = vertical ? floor(btg_sheet_y(s, k * step)) + 0.5 : s->top + s->height;
        cairo_move_to(s->cr, x, y);
        cairo_rel_line_to(s->cr, vertical ? -6 : 0, vertical ? 0 : 6);
        cairo_stroke(s->cr);
        btg_sheet_text(s->cr, vertical ? x - 10 : x, vertical ? y + 5 : y + 22, TEXT_SIZE,
                       vertical ? 1 : 0.5, label);
    }
}

void btg_sheet_axes(const sheet *s) {
    btg_sheet_ink(s->cr, colour_ink, 1);
    cairo_set_line_width(s->cr, 1);
    cairo_rectangle(s->cr, s->left - 0.5, s->top - 0.5, s->width + 1, s->height + 1);
    cairo_stroke(s->cr);
    draw_axis(s, false);
    draw_axis(s, true);
    btg_sheet_text(s->cr, s->left + s->width / 2, s->top + s->height + 46, TEXT_SIZE + 1, 0.5,
                   "x, mm");
    cairo_save(s->cr);
    cairo_translate(s->cr, s->left - 58, s->top + s->height / 2);
    cairo_rotate(s->cr, -TURN / 4);
    btg_sheet_text(s->cr, 0, 0, TEXT_SIZE + 1, 0.5, "y, mm");
    cairo_restore(s->cr);
}

static cairo_status_t write_bytes(void *output, const unsigned char *data, unsigned length) {
    btg_output *o = output;
    btg_output_write(o, (const char *)data, length);
    return o->error ? CAIRO_STATUS_WRITE_ERROR : CAIRO_STATUS_SUCCESS;
}

cairo_surface_t *btg_sheet_svg(btg_output *output, double width, double height) {
    return cairo_svg_surface_create_for_stream(write_bytes, output, width, height);
}

btg_status btg_sheet_png(cairo_surface_t *surface, btg_output *output) {
    cairo_status_t status = cairo_surface_write_to_png_stream(surface, write_bytes, output);
    return status == CAIRO_STATUS_NO_MEMORY ? BTG_ERROR_MEMORY : BTG_OK;
}
