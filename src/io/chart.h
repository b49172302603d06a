/* Charts: panels of lines, dots and bars with axes, as PNG or SVG. Internal to the program; drawn
 * with Cairo (btg_picture_available). */
#ifndef BTG_IO_CHART_H
#define BTG_IO_CHART_H

#include "io/output.h"

typedef enum btg_chart_kind {
    BTG_CHART_LINE,
    BTG_CHART_DASHES,
    BTG_CHART_DOTS,
    BTG_CHART_JOINS, /* points two by two: a thin line from the first to the second */
    BTG_CHART_BARS   /* x: middles, evenly spaced */
} btg_chart_kind;

#define BTG_CHART_COLOURS 6

/* Points that are not finite are left out, and break a line. */
typedef struct btg_chart_series {
    const char *name; /* in the legend; NULL: not there */
    btg_chart_kind kind;
    int ink; /* its colour: 0 .. BTG_CHART_COLOURS - 1 */
    const double *x, *y;
    size_t count;
} btg_chart_series;

#define BTG_CHART_SERIES_MAX 8

/* Limits are the data's where they are NaN. */
typedef struct btg_chart_panel {
    const char *title, *x_name, *y_name; /* names with units */
    double x_min, x_max, y_min, y_max;
    bool legend_left; /* else right; at the top */
    bool same_scale;  /* a millimetre is as long along y as along x */
    btg_chart_series series[BTG_CHART_SERIES_MAX];
    size_t series_count;
} btg_chart_panel;

/* All limits NaN, no series. */
btg_chart_panel btg_chart_panel_of(const char *title, const char *x_name, const char *y_name);
/* False, and left out: BTG_CHART_SERIES_MAX are there. The arrays stay the caller's. */
bool btg_chart_add(btg_chart_panel *panel, btg_chart_kind kind, int ink, const char *name,
                   const double *x, const double *y, size_t count);

/* `columns` panels beside each other, and as many rows as that takes. `path` ends in .png or
 * .svg. Errors: ERROR_FILE, ERROR_MEMORY, ERROR_NOT_BUILT. */
btg_status btg_chart_write(const char *path, const char *title, const btg_chart_panel *panels,
                           size_t panel_count, size_t columns, btg_message *message);

#endif
