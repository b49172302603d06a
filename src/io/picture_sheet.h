/* The sheet a picture is drawn on: its measures, colours, marks and lettering. Internal to
 * picture*.c; needs Cairo. */
#ifndef BTG_IO_PICTURE_SHEET_H
#define BTG_IO_PICTURE_SHEET_H

#include "io/picture.h"

#include <cairo.h>

/* Pixels. */
#define SHEET_WIDTH  1400
#define PLOT_LEFT    92.0
#define PLOT_TOP     92.0
#define PLOT_WIDTH   940.0
#define PLOT_HEIGHT  832.0
#define BELOW_PLOT   76.0 /* the x axis and its name */
#define PANEL_BOTTOM 800.0
#define PANEL_LEFT   1090.0
#define PANEL_WIDTH  264.0
#define TEXT_SIZE    14.0

#define TURN 6.283185307179586

typedef struct colour {
    double r, g, b;
} colour;

/* Okabe and Ito's for the contacts: told apart with any colour vision. */
extern const colour colour_p, colour_q, colour_osculating, colour_single, colour_foot;
extern const colour colour_ink, colour_bar;

/* Where the plot lies: a point (x, y) of the part is at (left + (x - x_min) * scale,
 * top + (y_max - y) * scale). */
typedef struct sheet {
    cairo_t *cr;
    double left, top, width, height;   /* pixels */
    double x_min, x_max, y_min, y_max; /* mm */
    double z_min, z_max;               /* mm, of the part */
    double bottom;                     /* of the sheet, pixels */
    double scale;                      /* pixels per mm */
    double mark;                       /* radius of a mark, pixels */
} sheet;

typedef enum mark_kind {
    MARK_P,
    MARK_Q,
    MARK_OSCULATING,
    MARK_SINGLE,
    MARK_NONE, /* no contact */
    MARK_FOOT
} mark_kind;

void btg_sheet_ink(cairo_t *cr, colour c, double alpha);
void btg_sheet_bold(cairo_t *cr, int bold);

/* `at` is the left end of the text (align 0), its middle (0.5) or its right end (1), on the
 * baseline. Returns the width. */
double btg_sheet_text(cairo_t *cr, double at, double baseline, double size, double align,
                      const char *string);
/* As btg_sheet_text from the left, its end left out when it is wider than `width`. */
void btg_sheet_text_within(cairo_t *cr, double at, double baseline, double size, double width,
                           const char *string);

void btg_sheet_mark(cairo_t *cr, mark_kind kind, double x, double y, double radius);

/* Colour of a height, from the part's lowest point (0) to its highest (1). */
colour btg_sheet_height_colour(double t);
/* Distance of the lines of equal height, mm; 0 when the part is flat. */
double btg_sheet_contour_step(const sheet *s);

/* 1, 2 or 5 times a power of ten that cuts `range` into at most `steps`. */
double btg_sheet_step(double range, double steps);
/* A place of the plot, mm, on the sheet, pixels. */
double btg_sheet_x(const sheet *s, double x_mm);
double btg_sheet_y(const sheet *s, double y_mm);
/* Frame of the plot, its axes with numbers, and their names. */
void btg_sheet_axes(const sheet *s);

/* A surface whose drawing goes to the output as SVG, at the latest when it is finished. */
cairo_surface_t *btg_sheet_svg(btg_output *output, double width, double height);
/* ERROR_MEMORY; errors of writing latch in the output. */
btg_status btg_sheet_png(cairo_surface_t *surface, btg_output *output);

/* With the decimals that multiples of `step` need. */
void btg_sheet_number(char *buffer, size_t size, double value, double step);

/* The panel beside the plot: legend, heights, tilts, tool. */
void btg_sheet_panel(const sheet *s, const btg_tool *tool, const btg_picture *picture);

#endif
