/* The part's upper side over the field: where the vertical line of each cell meets each surface,
 * by Newton's method in the surface's parameters; the highest wins. */
#include "verify/internal.h"

/* Cells along a side of the pieces a patch is taken in: small enough that a straight guess is good,
 * large enough that few cells are looked at by two of them. */
#define PIECE_CELLS 12.0
#define PIECES_MAX  4096
#define PROBES      8
#define ROUNDS_MAX  8
/* A Newton step this small, of the unit domain: the second-order Taylor polynomial is then good to
 * 1e-15 of the patch. */
#define LAST_STEP 1e-5
/* A line on the border of two pieces, or of two patches, is found by one of them at least. */
#define BORDER 1e-9
/* How far outside a piece a straight guess may be and still be tried, in pieces. */
#define GUESS_ROOM 0.3

typedef struct rows {
    btg_field *field;
    const btg_part *part;
    uint32_t first, end;
} rows;

/* Cells that [low, high] spans, of those from `first` to `end` - 1. False: none. */
static bool span(double low, double high, double origin, double cell, uint32_t first, uint32_t end,
                 uint32_t range[2]) {
    double a = ceil((low - origin) / cell), b = floor((high - origin) / cell);
    if (!(a < end) || !(b >= first) || b < a) return false;
    range[0] = a > first ? (uint32_t)a : first;
    range[1] = b < end - 1 ? (uint32_t)b + 1 : end;
    return range[0] < range[1];
}

static void keep(btg_field *f, size_t at, double z, btg_vec3 normal) {
    if (!(z > f->part_z[at])) return;
    double length = vec_norm(normal);
    f->part_z[at] = z;
    f->normal_z[at] = length > 0 ? (float)(fabs(normal.z) / length) : 1;
}

/* ---- patches ------------------------------------------------------------------------------ */

typedef struct piece {
    uint32_t item;
    double u, v, hu, hv;     /* middle and half sides in the domain */
    btg_surface_point point; /* there */
} piece;

/* The step in u and v that moves the point by (dx, dy). False: the surface stands upright. */
static bool solve(const btg_surface_point *s, double dx, double dy, double step[2]) {
    double det = s->su.x * s->sv.y - s->su.y * s->sv.x;
    if (!(fabs(det) > 0)) return false;
    step[0] = (dx * s->sv.y - dy * s->sv.x) / det;
    step[1] = (s->su.x * dy - s->su.y * dx) / det;
    return true;
}

static bool within(double at, double middle, double half, double room) {
    return fabs(at - middle) <= half * (1 + room);
}

static double into_domain(double at) {
    return at < 0 ? 0 : at > 1 ? 1 : at;
}

/* Newton from `at`; then the point there is in *s, with the last step added to its height. */
static bool meet(const rows *r, const piece *p, double x, double y, double at[2],
                 btg_surface_point *s, double *z) {
    for (int i = 0; i < ROUNDS_MAX; i++) {
        double d[2];
        btg_place place = {p->item, into_domain(at[0]), into_domain(at[1])};
        if (btg_part_evaluate(r->part, place, s) < 0) return false;
        if (!solve(s, x - s->s.x, y - s->s.y, d)) return false;
        if (fabs(d[0]) < LAST_STEP && fabs(d[1]) < LAST_STEP) {
            /* The same second order in x and y: the step once more, from where it led to. */
            double q[3] = {0.5 * d[0] * d[0], d[0] * d[1], 0.5 * d[1] * d[1]};
            double ex = q[0] * s->suu.x + q[1] * s->suv.x + q[2] * s->svv.x;
            double ey = q[0] * s->suu.y + q[1] * s->suv.y + q[2] * s->svv.y, e[2];
            if (!solve(s, -ex, -ey, e)) return false;
            d[0] += e[0], d[1] += e[1];
            at[0] = place.u + d[0], at[1] = place.v + d[1];
            *z = s->s.z + d[0] * s->su.z + d[1] * s->sv.z + q[0] * s->suu.z + q[1] * s->suv.z +
                 q[2] * s->svv.z;
            return at[0] >= -BORDER && at[0] <= 1 + BORDER && at[1] >= -BORDER &&
                   at[1] <= 1 + BORDER && within(at[0], p->u, p->hu, 1e-6) &&
                   within(at[1], p->v, p->hv, 1e-6);
        }
        at[0] = place.u + d[0];
        at[1] = place.v + d[1];
        if (!within(at[0], p->u, p->hu, 2) || !within(at[1], p->v, p->hv, 2)) return false;
    }
    return false;
}

static void fill_row(const rows *r, const piece *p, uint32_t row, const uint32_t columns[2]) {
    btg_field *f = r->field;
    double y = f->y + row * f->cell;
    btg_surface_point s = p->point;
    double from[2] = {p->u, p->v};
    for (uint32_t i = columns[0]; i < columns[1]; i++) {
        double x = f->x + i * f->cell, d[2], z;
        if (!solve(&s, x - s.s.x, y - s.s.y, d)) return;
        double at[2] = {from[0] + d[0], from[1] + d[1]};
        if (!within(at[0], p->u, p->hu, GUESS_ROOM) || !within(at[1], p->v, p->hv, GUESS_ROOM))
            continue;
        btg_surface_point found;
        if (!meet(r, p, x, y, at, &found, &z)) continue;
        keep(f, (size_t)row * f->width + i, z, vec_cross(found.su, found.sv));
        /* The neighbour's guess starts where this one was evaluated. */
        s = found;
        if (!solve(&s, x - s.s.x, y - s.s.y, d)) return;
        from[0] = at[0] - d[0], from[1] = at[1] - d[1];
    }
}

static double reach(double a, double b, double c, double d, double e) {
    /* first and second order over the piece, and half as much again for the rest */
    return 1.5 * (fabs(a) + fabs(b) + 0.5 * fabs(c) + fabs(d) + 0.5 * fabs(e));
}

static void fill_piece(const rows *r, piece *p) {
    btg_field *f = r->field;
    if (btg_part_evaluate(r->part, (btg_place){p->item, p->u, p->v}, &p->point) < 0) return;
    const btg_surface_point *s = &p->point;
    double uu = p->hu * p->hu, uv = p->hu * p->hv, vv = p->hv * p->hv;
    double rx =
        reach(s->su.x * p->hu, s->sv.x * p->hv, s->suu.x * uu, s->suv.x * uv, s->svv.x * vv);
    double ry =
        reach(s->su.y * p->hu, s->sv.y * p->hv, s->suu.y * uu, s->suv.y * uv, s->svv.y * vv);
    uint32_t columns[2], lines[2];
    if (!span(s->s.x - rx, s->s.x + rx, f->x, f->cell, 0, f->width, columns)) return;
    if (!span(s->s.y - ry, s->s.y + ry, f->y, f->cell, r->first, r->end, lines)) return;
    for (uint32_t row = lines[0]; row < lines[1]; row++)
        fill_row(r, p, row, columns);
}

/* Pieces along u (0) or v (1): from the longest of a few lines, seen from above. */
static uint32_t pieces_of(const rows *r, uint32_t item, int direction) {
    double longest = 0;
    for (int i = 0; i <= PROBES; i++) {
        double length = 0;
        btg_surface_point before = {0}, now;
        for (int j = 0; j <= PROBES; j++) {
            double s = (double)i / PROBES, t = (double)j / PROBES;
            btg_place at = {item, direction ? s : t, direction ? t : s};
            if (btg_part_evaluate(r->part, at, &now) < 0) return 1;
            if (j > 0) length += norm2(now.s.x - before.s.x, now.s.y - before.s.y);
            before = now;
        }
        longest = max2(longest, length);
    }
    double n = ceil(longest / (PIECE_CELLS * r->field->cell));
    return n < PROBES ? PROBES : n > PIECES_MAX ? PIECES_MAX : (uint32_t)n;
}

static void fill_patch(const rows *r, uint32_t item) {
    uint32_t nu = pieces_of(r, item, 0), nv = pieces_of(r, item, 1);
    for (uint32_t i = 0; i < nu; i++)
        for (uint32_t j = 0; j < nv; j++) {
            piece p = {.item = item, .hu = 0.5 / nu, .hv = 0.5 / nv};
            p.u = (i + 0.5) / nu;
            p.v = (j + 0.5) / nv;
            fill_piece(r, &p);
        }
}

/* ---- triangles ---------------------------------------------------------------------------- */

static void fill_triangle(const rows *r, uint32_t item) {
    btg_field *f = r->field;
    btg_surface_point s;
    if (btg_part_evaluate(r->part, (btg_place){item, 0, 0}, &s) < 0) return;
    btg_vec3 b = vec_add(s.s, s.su), c = vec_add(s.s, s.sv);
    uint32_t columns[2], lines[2];
    double room = BORDER * (1 + fabs(s.s.x) + fabs(s.s.y));
    if (!span(min2(s.s.x, min2(b.x, c.x)) - room, max2(s.s.x, max2(b.x, c.x)) + room, f->x, f->cell,
              0, f->width, columns) ||
        !span(min2(s.s.y, min2(b.y, c.y)) - room, max2(s.s.y, max2(b.y, c.y)) + room, f->y, f->cell,
              r->first, r->end, lines))
        return;
    btg_vec3 normal = vec_cross(s.su, s.sv);
    for (uint32_t row = lines[0]; row < lines[1]; row++)
        for (uint32_t i = columns[0]; i < columns[1]; i++) {
            double d[2], x = f->x + i * f->cell, y = f->y + row * f->cell;
            if (!solve(&s, x - s.s.x, y - s.s.y, d)) return;
            if (d[0] < -BORDER || d[1] < -BORDER || d[0] + d[1] > 1 + BORDER) continue;
            keep(f, (size_t)row * f->width + i, s.s.z + d[0] * s.su.z + d[1] * s.sv.z, normal);
        }
}

void btg_field_part(btg_field *field, const btg_part *part, uint32_t first_row, uint32_t end_row) {
    rows r = {field, part, first_row, end_row};
    btg_part_info info;
    btg_part_get_info(part, &info);
    for (size_t i = 0; i < info.patch_count; i++)
        fill_patch(&r, (uint32_t)i);
    for (size_t i = 0; i < info.triangle_count; i++)
        fill_triangle(&r, (uint32_t)(info.patch_count + i));
}
