#include "io/picture_sheet.h"

#include <math.h>
#include <stdio.h>

#define DEGREES 57.295779513082323

static void heading(cairo_t *cr, double y, const char *string) {
    btg_sheet_ink(cr, colour_ink, 1);
    btg_sheet_bold(cr, 1);
    btg_sheet_text(cr, PANEL_LEFT, y, TEXT_SIZE, 0, string);
    btg_sheet_bold(cr, 0);
}

static double legend_row(cairo_t *cr, double y, mark_kind kind, const char *label, size_t count) {
    char number_text[32];
    btg_sheet_mark(cr, kind, PANEL_LEFT + 16, y - 5, kind == MARK_FOOT ? 4.5 : 4);
    btg_sheet_ink(cr, colour_ink, 1);
    btg_sheet_text(cr, PANEL_LEFT + 38, y, TEXT_SIZE, 0, label);
    snprintf(number_text, sizeof number_text, "%zu", count);
    btg_sheet_text(cr, PANEL_LEFT + PANEL_WIDTH, y, TEXT_SIZE, 1, number_text);
    return y + 25;
}

static size_t count_status(const btg_picture *picture, btg_status status) {
    size_t n = 0;
    for (size_t i = 0; i < picture->count; i++)
        n += picture->marks[i].status == status;
    return n;
}

static double draw_legend(cairo_t *cr, double y, const btg_picture *picture) {
    heading(cr, y, "Contacts");
    y += 28;
    btg_sheet_ink(cr, colour_ink, 0.6);
    cairo_set_line_width(cr, 1);
    cairo_move_to(cr, PANEL_LEFT + 6, y - 5);
    cairo_line_to(cr, PANEL_LEFT + 26, y - 5);
    cairo_stroke(cr);
    btg_sheet_mark(cr, MARK_P, PANEL_LEFT + 6, y - 5, 4);
    btg_sheet_mark(cr, MARK_Q, PANEL_LEFT + 26, y - 5, 4);
    btg_sheet_ink(cr, colour_p, 1);
    double x = PANEL_LEFT + 38;
    x += btg_sheet_text(cr, x, y, TEXT_SIZE, 0, "first P");
    btg_sheet_ink(cr, colour_ink, 1);
    x += btg_sheet_text(cr, x, y, TEXT_SIZE, 0, " and ");
    btg_sheet_ink(cr, colour_q, 1);
    btg_sheet_text(cr, x, y, TEXT_SIZE, 0, "second Q");
    btg_sheet_ink(cr, colour_ink, 1);
    char two[32];
    snprintf(two, sizeof two, "%zu", count_status(picture, BTG_OK));
    btg_sheet_text(cr, PANEL_LEFT + PANEL_WIDTH, y, TEXT_SIZE, 1, two);
    y += 25;
    y = legend_row(cr, y, MARK_OSCULATING, "both at one place",
                   count_status(picture, BTG_OSCULATING));
    y = legend_row(cr, y, MARK_SINGLE, "one contact only",
                   count_status(picture, BTG_SINGLE_CONTACT));
    y = legend_row(cr, y, MARK_NONE, "no contact", count_status(picture, BTG_NO_CONTACT));
    return legend_row(cr, y, MARK_FOOT, "footprint points", picture->count);
}

static double draw_heights(const sheet *s, double y) {
    cairo_t *cr = s->cr;
    double step = btg_sheet_contour_step(s), bar = 18;
    heading(cr, y, "Height of the part, mm");
    y += 14;
    for (int i = 0; i < (int)PANEL_WIDTH; i++) {
        btg_sheet_ink(cr, btg_sheet_height_colour(i / PANEL_WIDTH), 1);
        cairo_rectangle(cr, PANEL_LEFT + i, y, 1, bar);
        cairo_fill(cr);
    }
    btg_sheet_ink(cr, colour_ink, 1);
    cairo_set_line_width(cr, 1);
    cairo_rectangle(cr, PANEL_LEFT - 0.5, y - 0.5, PANEL_WIDTH + 1, bar + 1);
    cairo_stroke(cr);
    double range = s->z_max - s->z_min;
    double last_label = -INFINITY;
    for (double k = ceil(s->z_min / step); step > 0 && k * step <= s->z_max; ++k) {
        char label[32];
        double x = floor(PANEL_LEFT + (k * step - s->z_min) / range * PANEL_WIDTH) + 0.5;
        cairo_move_to(cr, x, y + bar);
        cairo_rel_line_to(cr, 0, 5);
        cairo_stroke(cr);
        if (x - last_label < 44) continue;
        btg_sheet_number(label, sizeof label, k * step, step);
        btg_sheet_text(cr, x, y + bar + 20, TEXT_SIZE - 1, 0.5, label);
        last_label = x;
    }
    char caption[96], spacing[32];
    if (step > 0) {
        btg_sheet_number(spacing, sizeof spacing, step, step);
        snprintf(caption, sizeof caption, "lines of equal height every %s mm", spacing);
    } else {
        snprintf(caption, sizeof caption, "flat at %g mm", s->z_min);
    }
    btg_sheet_text(cr, PANEL_LEFT, y + bar + 42, TEXT_SIZE - 1, 0, caption);
    return y + bar + 42;
}

#define BINS_MAX 64

typedef struct histogram {
    double width; /* of a bin, degrees */
    int bins;
    size_t two[BINS_MAX], osculating[BINS_MAX], most, all;
    double least, greatest;
} histogram;

static int has_tilt(const btg_picture_mark *p) {
    return (p->status == BTG_OK || p->status == BTG_OSCULATING) && isfinite(p->tilt_rad);
}

static histogram histogram_of(const btg_picture *picture) {
    histogram h = {.least = INFINITY, .greatest = 0};
    for (size_t i = 0; i < picture->count; i++) {
        if (!has_tilt(&picture->marks[i])) continue;
        h.least = fmin(h.least, picture->marks[i].tilt_rad * DEGREES);
        h.greatest = fmax(h.greatest, picture->marks[i].tilt_rad * DEGREES);
        ++h.all;
    }
    double range = fmax(h.greatest, 0.1);
    h.width = btg_sheet_step(range, 24);
    h.bins = (int)floor(range / h.width) + 1;
    for (size_t i = 0; i < picture->count; i++) {
        if (!has_tilt(&picture->marks[i])) continue;
        int bin = (int)fmin(fmax(picture->marks[i].tilt_rad * DEGREES / h.width, 0), h.bins - 1);
        ++(picture->marks[i].status == BTG_OK ? h.two : h.osculating)[bin];
    }
    for (int i = 0; i < h.bins; i++)
        if (h.two[i] + h.osculating[i] > h.most) h.most = h.two[i] + h.osculating[i];
    return h;
}

static double draw_histogram(cairo_t *cr, double y, const btg_picture *picture) {
    histogram h = histogram_of(picture);
    const double height = 170;
    char label[96];
    heading(cr, y, "Tilt, degrees");
    if (h.all == 0) {
        btg_sheet_text(cr, PANEL_LEFT, y + 24, TEXT_SIZE - 1, 0, "no second contact at all");
        return y + 24;
    }
    double base = floor(y + 20 + height) + 0.5, bar = PANEL_WIDTH / h.bins;
    for (int i = 0; i < h.bins; i++) {
        double two = height * (double)h.two[i] / (double)h.most;
        double both = height * (double)h.osculating[i] / (double)h.most;
        btg_sheet_ink(cr, colour_bar, 1);
        cairo_rectangle(cr, PANEL_LEFT + i * bar + 0.5, base - two, bar - 1, two);
        cairo_fill(cr);
        btg_sheet_ink(cr, colour_osculating, 1);
        cairo_rectangle(cr, PANEL_LEFT + i * bar + 0.5, base - two - both, bar - 1, both);
        cairo_fill(cr);
    }
    btg_sheet_ink(cr, colour_ink, 1);
    cairo_set_line_width(cr, 1);
    cairo_move_to(cr, PANEL_LEFT, base);
    cairo_rel_line_to(cr, PANEL_WIDTH, 0);
    cairo_stroke(cr);
    double span = h.width * h.bins, step = btg_sheet_step(span, 6);
    for (double k = 0; k * step <= span * (1 + 1e-9); ++k) {
        double x = floor(PANEL_LEFT + k * step / span * PANEL_WIDTH) + 0.5;
        cairo_move_to(cr, x, base);
        cairo_rel_line_to(cr, 0, 5);
        cairo_stroke(cr);
        btg_sheet_number(label, sizeof label, k * step, step);
        btg_sheet_text(cr, x, base + 20, TEXT_SIZE - 1, 0.5, label);
    }
    snprintf(label, sizeof label, "from %.3g to %.3g; highest bar: %zu", h.least, h.greatest,
             h.most);
    btg_sheet_text(cr, PANEL_LEFT, base + 42, TEXT_SIZE - 1, 0, label);
    return base + 42;
}

/* The tool seen from above at the plot's scale, where it has room. */
static void draw_tool(const sheet *s, double y, const btg_tool *tool) {
    cairo_t *cr = s->cr;
    const btg_tool_def *def = &tool->def;
    double outer = (def->major_radius_mm + def->minor_radius_mm) * s->scale;
    double inner = def->major_radius_mm * s->scale;
    heading(cr, y, "Tool");
    char label[96];
    snprintf(label, sizeof label, "%s %g / %g mm",
             def->profile == BTG_PROFILE_BULLNOSE ? "bullnose" : "toroidal", def->major_radius_mm,
             def->minor_radius_mm);
    btg_sheet_ink(cr, colour_ink, 1);
    btg_sheet_text(cr, PANEL_LEFT + 52, y, TEXT_SIZE, 0, label);
    double room = fmin(PANEL_WIDTH / 2, (s->bottom - y - 40) / 2);
    if (outer > room || outer < 2) {
        btg_sheet_text(cr, PANEL_LEFT, y + 24, TEXT_SIZE - 1, 0, "(major / minor radius)");
        return;
    }
    double cx = PANEL_LEFT + PANEL_WIDTH / 2, cy = y + 18 + outer;
    cairo_set_line_width(cr, 1.2);
    cairo_arc(cr, cx, cy, outer, 0, TURN);
    btg_sheet_ink(cr, colour_bar, 0.2);
    cairo_fill_preserve(cr);
    btg_sheet_ink(cr, colour_ink, 1);
    cairo_stroke(cr);
    if (inner > 0) {
        const double dash[] = {5, 4};
        cairo_set_dash(cr, dash, 2, 0);
        cairo_arc(cr, cx, cy, inner, 0, TURN);
        cairo_stroke(cr);
        cairo_set_dash(cr, NULL, 0, 0);
    }
    if (outer > 40) btg_sheet_text(cr, cx, cy + 5, TEXT_SIZE - 2, 0.5, "to scale");
}

void btg_sheet_panel(const sheet *s, const btg_tool *tool, const btg_picture *picture) {
    double y = draw_legend(s->cr, PLOT_TOP + 14, picture);
    y = draw_heights(s, y + 20);
    y = draw_histogram(s->cr, y + 44, picture);
    draw_tool(s, y + 44, tool);
}
