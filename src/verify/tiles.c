/* Which tiles of the field a placed cutter cannot reach.
 *
 * A cell is cut when some of the cutter is at or below its stock; so no cell of a tile is, if that
 * holds at every point of a plane piece that the stock is nowhere above. With F the distance to the
 * cutter's ring less Ri (under.c) that takes F > 0 and F not rising along z, at each of these
 * points (stock.c says what else, where a line can meet the ring twice). From the piece's middle,
 * F >= F0 + grad F . step - K step^2 / 2 and |change of grad F| <= M step, where second derivatives
 * of the distance D to a circle are 1/D, 0, and (r - Ro) / (r D) around the axis; F of a solid
 * cutter is convex (K = 0). */
#include "verify/internal.h"

/* Rounding of coordinates of up to 1e6 mm. */
#define ROUNDING_MM 1e-9
/* Next to the axis of a hollow cutter its distance bends too much, in parts of the major radius. */
#define INNER 0.125

/* ---- planes ------------------------------------------------------------------------------- */

typedef struct cells {
    uint32_t x, y, width, height;
} cells;

static cells cells_of(const btg_field *f, uint32_t row, uint32_t column) {
    cells c = {column * BTG_TILE, row * BTG_TILE, BTG_TILE, BTG_TILE};
    if (c.width > f->width - c.x) c.width = f->width - c.x;
    if (c.height > f->height - c.y) c.height = f->height - c.y;
    return c;
}

static void refresh(btg_field *f, uint32_t row, uint32_t column) {
    cells c = cells_of(f, row, column);
    const double *z = f->stock_z + (size_t)c.y * f->width + c.x;
    double along_x = 0, along_y = 0, most = -INFINITY;
    uint32_t last_x = c.width - 1, last_y = c.height - 1;
    for (uint32_t j = 0; j <= last_y; j++)
        along_x += z[(size_t)j * f->width + last_x] - z[(size_t)j * f->width];
    for (uint32_t i = 0; i <= last_x; i++)
        along_y += z[(size_t)last_y * f->width + i] - z[i];
    /* For each cell. */
    along_x /= c.height * max2(last_x, 1);
    along_y /= c.width * max2(last_y, 1);
    for (uint32_t j = 0; j <= last_y; j++)
        for (uint32_t i = 0; i <= last_x; i++) {
            double plane = along_x * (i - 0.5 * last_x) + along_y * (j - 0.5 * last_y);
            most = max2(most, z[(size_t)j * f->width + i] - plane);
        }
    size_t at = (size_t)row * f->tiles.width + column;
    f->tiles.z[at] = most;
    f->tiles.along_x[at] = along_x / f->cell;
    f->tiles.along_y[at] = along_y / f->cell;
    f->tiles.stale[at] = 0;
}

void btg_tiles_refresh(btg_field *f, uint32_t row, uint32_t first, uint32_t end) {
    const uint8_t *stale = f->tiles.stale + (size_t)row * f->tiles.width;
    for (uint32_t i = first; i < end; i++)
        if (stale[i]) refresh(f, row, i);
}

/* ---- tiles under a cutter ------------------------------------------------------------------- */

typedef struct placed {
    double ax, ay, az, dy, cz, major, minor, half_x, half_y;
    double bend;     /* Ro of a hollow cutter: second derivatives grow towards the axis */
    double at_least; /* of r; both -INFINITY where r does not matter */
} placed;

static inline double room_of(const placed *p, double dx, double z, double sx, double sy,
                             bool hollow) {
    double dz = z - p->cz;
    double h = p->ax * dx + p->ay * p->dy + p->az * dz;
    double r2 = dx * dx + p->dy * p->dy + dz * dz - h * h, r = sqrt(r2 > 0 ? r2 : 0);
    double w = r - p->major, solid = w > 0 ? w : 0;
    w = hollow ? w : solid;
    double far = sqrt(w * w + h * h), lift_x = sx * p->half_x, lift_y = sy * p->half_y;
    double lift = fabs(lift_x) + fabs(lift_y);
    double size = sqrt(p->half_x * p->half_x + p->half_y * p->half_y + lift * lift);
    /* Of the gradient, times D: along the radius w, along the axis h. */
    double radial = r > 0 ? w / r : 0, along = h - radial * h;
    double gx = radial * dx + along * p->ax, gy = radial * p->dy + along * p->ay;
    double gz = radial * dz + along * p->az;
    double slope = fabs(gx + gz * sx) * p->half_x + fabs(gy + gz * sy) * p->half_y;
    double inner = r - size, nearest = far - size;
    double ratio = p->bend > inner ? (p->bend - inner) / inner : 0;
    double most = ratio > 1 ? ratio : 1;
    /* -F, and how steeply it might rise, both times a positive number */
    double deep = (p->minor + ROUNDING_MM) * far - far * far + slope +
                  0.5 * size * size * ratio * far / nearest;
    double rising = gz * nearest + most * size * far;
    double room = deep > rising ? deep : rising;
    double close = p->at_least - inner > -nearest ? p->at_least - inner : -nearest;
    return room > close ? room : close;
}

void btg_tiles_measure(const btg_field *f, const btg_cutter *cutter, btg_vec3 centre, btg_vec3 axis,
                       uint32_t row, uint32_t first, uint32_t end, double *room) {
    const btg_tiles *t = &f->tiles;
    cells c = cells_of(f, row, first);
    double middle = 0.5 * (BTG_TILE - 1) * f->cell;
    placed p = {axis.x, axis.y, axis.z, 0, centre.z, cutter->major, cutter->minor, middle, 0, 0, 0};
    p.bend = p.at_least = -INFINITY;
    p.half_y = 0.5 * (c.height - 1) * f->cell;
    p.dy = f->y + c.y * f->cell + p.half_y - centre.y;
    if (cutter->hollow) {
        p.bend = cutter->major;
        p.at_least = INNER * cutter->major;
        if (cutter->major * axis.z < cutter->minor) p.at_least = cutter->major;
    }
    size_t at = (size_t)row * t->width;
    double x = f->x + middle - centre.x;
    for (uint32_t i = first; i < end; i++) {
        double dx = x + (double)i * BTG_TILE * f->cell;
        double z = t->z[at + i], sx = t->along_x[at + i], sy = t->along_y[at + i];
        room[i - first] =
            cutter->hollow ? room_of(&p, dx, z, sx, sy, true) : room_of(&p, dx, z, sx, sy, false);
    }
    /* The last one may be narrower than these are taken for: its own middle is elsewhere. */
    if (end == t->width && f->width % BTG_TILE != 0) room[end - 1 - first] = 1;
}
