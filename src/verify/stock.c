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

#define ORDERS      32
#define ROW_PIECE   256
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

static void cut_row(btg_field *f, const btg_cutter *cutter, const btg_step *step, uint32_t row,
                    btg_band *band) {
    double reach = cutter->major + cutter->minor;
    double y = f->y + row * f->cell - step->centre.y, half2 = reach * reach - y * y;
    if (half2 < 0) return;
    double half = sqrt(half2), from = (step->centre.x - half - f->x) / f->cell;
    double to = (step->centre.x + half - f->x) / f->cell;
    if (to < 0 || from > f->width - 1) return;
    uint32_t first = from > 0 ? (uint32_t)ceil(from) : 0;
    uint32_t end = to < f->width - 1 ? (uint32_t)to + 1 : f->width;
    btg_vec3 a = step->axis;
    place p = {a.x, a.y, a.z, y, step->centre.z, cutter->major, cutter->minor, 0};
    p.doubt = cutter->hollow && cutter->major * a.z < cutter->minor;
    double room[ROW_PIECE];
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
            /* The next height, from the last two. */
            double near = 2 * last[0] - last[1];
            if (p.doubt > 0) near = NAN;
            if (room[k] > 0)
                under = lower(f, cutter, step, at + (size_t)k, x + k * f->cell, y, near, band);
            last[1] = last[0];
            last[0] = under;
        }
    }
}

/* ---- a band ------------------------------------------------------------------------------- */

static void cut_step(btg_field *f, const btg_cutter *cutter, const btg_step *step,
                     uint32_t first_row, uint32_t end_row, btg_band *band) {
    double reach = cutter->major + cutter->minor;
    double sink = cutter->major * norm2(step->axis.x, step->axis.y) + cutter->minor;
    if (step->centre.z - sink >= f->top) return;
    double from = (step->centre.y - reach - f->y) / f->cell;
    double to = (step->centre.y + reach - f->y) / f->cell;
    if (to < first_row || from > end_row) return;
    if (from > first_row) first_row = (uint32_t)ceil(from);
    if (to < end_row - 1) end_row = (uint32_t)to + 1;
    for (uint32_t row = first_row; row < end_row; row++)
        cut_row(f, cutter, step, row, band);
}

void btg_stock_cut(btg_field *field, const btg_cutter *cutter, const btg_step *steps, size_t count,
                   uint32_t first_row, uint32_t end_row, btg_band *band) {
    for (uint32_t order = 0; order < ORDERS; order++)
        for (size_t i = 0; i < count; i++)
            if (steps[i].order == order)
                cut_step(field, cutter, &steps[i], first_row, end_row, band);
}
