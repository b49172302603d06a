/* Cutting steps of the tool into the field.
 *
 * Between two steps each point of the cutter's ring (or disc) moves by at most s, and leaves the
 * straight way by at most the sagitta of its turn. The cutter is balls of its minor radius about
 * those points, and what two balls at a distance s miss of the ball that rolls between them is
 * Ri - sqrt(Ri^2 - (s/2)^2), at most. A flat disc that moves in its own plane misses
 * Ro - sqrt(Ro^2 - (s/2)^2) of its rim, and no more than half its way along the axis. Every point
 * of the swept cutter is that near to one of the steps.
 *
 * The field is the lower envelope of the steps, in whatever order they are cut. Those far apart go
 * first: after them few cells are left that the ones between can lower, and to see that needs a
 * square root, not the search of under.c. */
#include "verify/internal.h"

#include <string.h>

#define ORDERS      32
#define ROW_PIECE   256
#define TILES_PIECE 64
#define TURN_LIMIT  0.5 /* of a step, radians: the bound below is for small turns */
#define STEPS_LIMIT 10000000.0

static double cusp(double radius, double s) {
    double half = 0.5 * s;
    return half < radius ? half * half / (radius + sqrt(radius * radius - half * half)) : INFINITY;
}

static double step_error(const btg_cutter *c, double way, double turn, double n) {
    double arm = norm2(c->major, c->minor), part = turn / n;
    double s = way / n + arm * part;
    double most = min2(cusp(c->minor, s), 0.5 * s);
    return most + arm * part * part / 8;
}

uint32_t btg_stock_steps(const btg_cutter *cutter, double way, double turn, double error) {
    double n = max2(1, ceil(turn / TURN_LIMIT));
    while (step_error(cutter, way, turn, n) > error && n < STEPS_LIMIT)
        n = max2(n + 1, floor(n * 1.05));
    return (uint32_t)n;
}

/* ---- one row ------------------------------------------------------------------------------ */

typedef struct place {
    double ax, ay, az, dy, cz, major, minor;
    double doubt; /* 1: a line can meet the ring twice, so its inside is to be searched */
} place;

/* > 0 where the stock's top may be above the lower side of the cutter: the point is inside it, or
 * not below it. `z` are heights of the stock, `x` the first cell from the torus centre. */
static void measure(const place *p, bool hollow, const double *restrict z, double x, double cell,
                    int count, double *restrict out) {
    for (int i = 0; i < count; i++) {
        double dx = x + i * cell, dz = z[i] - p->cz;
        double h = p->ax * dx + p->ay * p->dy + p->az * dz;
        double r2 = dx * dx + p->dy * p->dy + dz * dz - h * h;
        double r = sqrt(r2 > 0 ? r2 : 0), w = r - p->major;
        double solid = w > 0 ? w : 0;
        w = hollow ? w : solid;
        double inside = p->minor * p->minor - (w * w + h * h);
        /* r times the slope of F along z, times the distance from the ring */
        double rising = w * (dz - h * p->az) + h * p->az * r;
        double doubt = p->doubt * (p->major - r);
        double most = inside > rising ? inside : rising;
        most = most > doubt ? most : doubt;
        double below = h + p->minor;
        out[i] = below < most ? below : most;
    }
}

/* Returns the height of the cutter's lower side there, from the torus centre; NaN: none. `near`: a
 * height to start from, or NaN. */
static double lower(btg_field *f, const btg_cutter *cutter, const btg_step *step, size_t at,
                    double x, double y, double near, btg_band *band) {
    double under;
    if (isnan(near) || !btg_cutter_under_near(cutter, step->axis, x, y, near, &under))
        if (!btg_cutter_under(cutter, step->axis, x, y, &under)) return NAN;
    double z = under + step->centre.z;
    if (!(z < f->stock_z[at])) return under;
    f->stock_z[at] = z;
    double gouge = (f->part_z[at] - z) * (double)f->normal_z[at];
    if (!(gouge > band->gouge)) return under;
    band->gouge = gouge;
    band->place = step->place;
    band->place.at = vec(step->centre.x + x, step->centre.y + y, f->part_z[at]);
    return under;
}

/* Cells `first` to `end` - 1 of a row. Returns whether one was cut. */
static bool cut_cells(btg_field *f, const btg_cutter *cutter, const btg_step *step, uint32_t row,
                      uint32_t first, uint32_t end, btg_band *band) {
    double y = f->y + row * f->cell - step->centre.y;
    btg_vec3 a = step->axis;
    place p = {a.x, a.y, a.z, y, step->centre.z, cutter->major, cutter->minor, 0};
    p.doubt = cutter->hollow && cutter->major * a.z < cutter->minor;
    double room[ROW_PIECE];
    bool cut = false;
    for (uint32_t i = first; i < end; i += ROW_PIECE) {
        int count = (int)(end - i < ROW_PIECE ? end - i : ROW_PIECE);
        size_t at = (size_t)row * f->width + i;
        double x = f->x + i * f->cell - step->centre.x;
        if (cutter->hollow)
            measure(&p, true, f->stock_z + at, x, f->cell, count, room);
        else
            measure(&p, false, f->stock_z + at, x, f->cell, count, room);
        double last[2] = {NAN, NAN};
        for (int k = 0; k < count; k++) {
            double under = NAN;
            /* The next height, from the last two, or from the stock's. */
            double near = 2 * last[0] - last[1];
            if (isnan(near)) near = f->stock_z[at + (size_t)k] - step->centre.z;
            if (p.doubt > 0) near = NAN;
            if (room[k] > 0) {
                under = lower(f, cutter, step, at + (size_t)k, x + k * f->cell, y, near, band);
                cut = true;
            }
            last[1] = last[0];
            last[0] = under;
        }
    }
    return cut;
}

/* ---- tiles ---------------------------------------------------------------------------------- */

/* Rows and cells of a run of tiles, each row as far as the cutter reaches. */
static void cut_run(btg_field *f, const btg_cutter *cutter, const btg_step *step, uint32_t tile_row,
                    uint32_t first, uint32_t end, btg_band *band) {
    double reach = cutter->major + cutter->minor;
    uint32_t row = tile_row * BTG_TILE, row_end = row + BTG_TILE;
    bool cut = false;
    if (row_end > f->height) row_end = f->height;
    for (; row < row_end; row++) {
        double y = f->y + row * f->cell - step->centre.y, half2 = reach * reach - y * y;
        if (half2 < 0) continue;
        double half = sqrt(half2), from = (step->centre.x - half - f->x) / f->cell;
        double to = (step->centre.x + half - f->x) / f->cell;
        uint32_t low = first * BTG_TILE, high = end * BTG_TILE;
        if (high > f->width) high = f->width;
        if (to < low || from > high) continue;
        if (from > low) low = (uint32_t)ceil(from);
        if (to < high - 1) high = (uint32_t)to + 1;
        if (low < high && cut_cells(f, cutter, step, row, low, high, band)) cut = true;
    }
    if (cut) memset(f->tiles.stale + (size_t)tile_row * f->tiles.width + first, 1, end - first);
}

static void cut_tiles(btg_field *f, const btg_cutter *cutter, const btg_step *step,
                      uint32_t tile_row, uint32_t first, uint32_t end, btg_band *band) {
    double room[TILES_PIECE];
    for (; first < end; first += TILES_PIECE) {
        uint32_t count = end - first < TILES_PIECE ? end - first : TILES_PIECE;
        btg_tiles_refresh(f, tile_row, first, first + count);
        btg_tiles_measure(f, cutter, step->centre, step->axis, tile_row, first, first + count,
                          room);
        for (uint32_t i = 0, from; i < count; i++) {
            if (room[i] < 0) continue;
            for (from = i; i < count && !(room[i] < 0);)
                i++;
            cut_run(f, cutter, step, tile_row, first + from, first + i, band);
        }
    }
}

/* Tiles that [low, high], in cells, spans. False: none of `count` cells. */
static bool tile_span(double low, double high, uint32_t count, uint32_t range[2]) {
    if (!(high >= 0) || !(low <= count - 1)) return false;
    range[0] = low > 0 ? (uint32_t)low / BTG_TILE : 0;
    range[1] = (high < count - 1 ? (uint32_t)high : count - 1) / BTG_TILE + 1;
    return true;
}

/* ---- a band ------------------------------------------------------------------------------- */

static void cut_step(btg_field *f, const btg_cutter *cutter, const btg_step *step,
                     uint32_t first_row, uint32_t end_row, btg_band *band) {
    double reach = (cutter->major + cutter->minor) / f->cell;
    double sink = cutter->major * norm2(step->axis.x, step->axis.y) + cutter->minor;
    if (step->centre.z - sink >= f->top) return;
    double x = (step->centre.x - f->x) / f->cell, y = (step->centre.y - f->y) / f->cell;
    uint32_t rows[2], columns[2];
    if (!tile_span(x - reach, x + reach, f->width, columns)) return;
    if (!tile_span(y - reach - first_row, y + reach - first_row, end_row - first_row, rows)) return;
    for (uint32_t row = rows[0]; row < rows[1]; row++)
        cut_tiles(f, cutter, step, first_row / BTG_TILE + row, columns[0], columns[1], band);
}

void btg_stock_cut(btg_field *field, const btg_cutter *cutter, const btg_step *steps, size_t count,
                   uint32_t first_row, uint32_t end_row, btg_band *band) {
    for (uint32_t order = 0; order < ORDERS; order++)
        for (size_t i = 0; i < count; i++)
            if (steps[i].order == order)
                cut_step(field, cutter, &steps[i], first_row, end_row, band);
}
