/* Fitting sheets. The height over a mean plane is fitted by least squares; how far what it stands
 * for departs from the fit is then bounded: differences of quadratic forms lie within their Bezier
 * coefficients. Any fit is safe, a bad one only thick. */
#include "core/sheet.h"

/* Height over a plane: q = c[0] + c[1] x + c[2] y + (c[3] x^2 + 2 c[4] x y + c[5] y^2) / 2. */
typedef struct fit {
    btg_vec3 origin, x, y, n;
    double size; /* coordinates are measured in it */
    double m[6][6], r[6];
    double c[6];
    double low_x, high_x, low_y, high_y; /* what it covers */
    double low, high;                    /* height above the fit, all over that */
} fit;

/* The frame: normal as near as can be to all normals summed, x along a wanted direction. */
static void set_frame(fit *f, btg_vec3 origin, btg_vec3 normal, btg_vec3 along, double size) {
    *f = (fit){.origin = origin, .n = vec_unit(normal), .size = size > 0 ? size : 1};
    if (!(vec_norm2(f->n) > 0.5)) f->n = vec(0, 0, 1);
    btg_vec3 x = vec_mad(along, f->n, -vec_dot(along, f->n));
    f->x = vec_norm2(x) > 1e-12 * vec_norm2(along) && vec_norm2(x) > 0 ? vec_unit(x)
                                                                       : vec_perpendicular(f->n);
    f->y = vec_cross(f->n, f->x);
    f->low_x = f->low_y = f->low = INFINITY;
    f->high_x = f->high_y = f->high = -INFINITY;
}

/* In the frame, in units of its size. */
static btg_vec3 in_frame(const fit *f, btg_vec3 v) {
    double k = 1 / f->size;
    return vec(k * vec_dot(v, f->x), k * vec_dot(v, f->y), k * vec_dot(v, f->n));
}

static void add_point(fit *f, btg_vec3 p) {
    const double g[6] = {1, p.x, p.y, 0.5 * p.x * p.x, p.x * p.y, 0.5 * p.y * p.y};
    for (int i = 0; i < 6; i++) {
        for (int k = 0; k <= i; k++)
            f->m[i][k] += g[i] * g[k];
        f->r[i] += g[i] * p.z;
    }
}

/* Cholesky; what the points do not tell stays near 0. */
static void solve(fit *f) {
    double l[6][6], z[6], small = 1e-9 * f->m[0][0];
    for (int i = 0; i < 6; i++) {
        for (int k = 0; k <= i; k++) {
            double sum = f->m[i][k] + (i == k ? small : 0);
            for (int j = 0; j < k; j++)
                sum -= l[i][j] * l[k][j];
            l[i][k] = i == k ? sqrt(sum > small ? sum : small) : sum / l[k][k];
        }
        z[i] = f->r[i];
        for (int j = 0; j < i; j++)
            z[i] -= l[i][j] * z[j];
        z[i] /= l[i][i];
    }
    for (int i = 5; i >= 0; i--) {
        f->c[i] = z[i];
        for (int j = i + 1; j < 6; j++)
            f->c[i] -= l[j][i] * f->c[j];
        f->c[i] /= l[i][i];
    }
}

/* The fit's polar form: q at p when both are p. */
static double polar(const fit *f, btg_vec3 p, btg_vec3 q) {
    const double *c = f->c;
    return c[0] + 0.5 * (c[1] * (p.x + q.x) + c[2] * (p.y + q.y)) +
           0.5 * (c[3] * p.x * q.x + c[4] * (p.x * q.y + q.x * p.y) + c[5] * p.y * q.y);
}

static void cover(fit *f, double x, double y, double slack) {
    f->low_x = min2(f->low_x, x - slack);
    f->high_x = max2(f->high_x, x + slack);
    f->low_y = min2(f->low_y, y - slack);
    f->high_y = max2(f->high_y, y + slack);
}

static void add_height(fit *f, double height, double slack) {
    f->low = min2(f->low, height - slack);
    f->high = max2(f->high, height + slack);
}

static void finish(const fit *f, btg_sheet *sheet) {
    double x = 0.5 * (f->low_x + f->high_x), y = 0.5 * (f->low_y + f->high_y);
    double hx = 0.5 * (f->high_x - f->low_x), hy = 0.5 * (f->high_y - f->low_y), k = f->size;
    const double *c = f->c;
    btg_vec3 at = vec(x, y, 0);
    double height = polar(f, at, at) + 0.5 * (f->low + f->high);
    double gx = c[1] + c[3] * x + c[4] * y, gy = c[2] + c[4] * x + c[5] * y;
    sheet->centre =
        vec_mad(vec_mad(vec_mad(f->origin, f->x, k * x), f->y, k * y), f->n, k * height);
    sheet->a = vec_scale(vec_mad(f->x, f->n, gx), k * hx);
    sheet->b = vec_scale(vec_mad(f->y, f->n, gy), k * hy);
    sheet->uu = vec_scale(f->n, k * c[3] * hx * hx);
    sheet->uv = vec_scale(f->n, k * c[4] * hx * hy);
    sheet->vv = vec_scale(f->n, k * c[5] * hy * hy);
    sheet->error = 0.5 * k * (f->high - f->low) * (1 + 1e-9);
}

static double radius_of(const btg_sheet *s) {
    double p = vec_norm(vec_add(s->a, s->b)), m = vec_norm(vec_sub(s->a, s->b));
    double bend = 0.5 * (vec_norm(s->uu) + vec_norm(s->vv)) + vec_norm(s->uv);
    return (max2(p, m) + bend + s->error) * (1 + 1e-12);
}

/* Rounding of heights above the fit. */
static double rounding_of(const fit *f) {
    double sum = 1;
    for (int i = 0; i < 6; i++)
        sum += fabs(f->c[i]);
    return 1e-14 * sum;
}

/* ---- pieces ------------------------------------------------------------------------------- */

void btg_sheet_of_piece(const btg_part *part, const btg_piece *piece, btg_sheet *sheet) {
    const btg_patch *patch = &part->patches[piece->item];
    const float *t = piece->third;
    double hu = piece->hu, hv = piece->hv;
    btg_surface_point s;
    btg_patch_evaluate(patch, piece->u, piece->v, &s);
    *sheet = (btg_sheet){s.s,
                         vec_scale(s.su, hu),
                         vec_scale(s.sv, hv),
                         vec_scale(s.suu, hu * hu),
                         vec_scale(s.suv, hu * hv),
                         vec_scale(s.svv, hv * hv),
                         0,
                         0};
    sheet->error =
        ((double)t[0] + 3 * ((double)t[1] + (double)t[2]) + (double)t[3]) / 6 + patch->rounding;
    sheet->radius = radius_of(sheet);
}

/* ---- triangles ---------------------------------------------------------------------------- */

static btg_vec3 turned_to(btg_vec3 n, btg_vec3 sum) {
    return vec_dot(n, sum) < 0 ? vec_scale(n, -1) : n;
}

void btg_sheet_of_triangles(const btg_part *part, const uint32_t *triangles, uint32_t count,
                            btg_sheet *sheet) {
    btg_vec3 c[3], normal = vec(0, 0, 0), origin = vec(0, 0, 0), along = vec(0, 0, 0);
    double size = 0;
    for (uint32_t i = 0; i < count; i++) {
        btg_triangle_corners(part, triangles[i], c);
        btg_vec3 a = vec_sub(c[1], c[0]), b = vec_sub(c[2], c[0]);
        normal = vec_add(normal, turned_to(vec_cross(a, b), normal));
        if (i == 0) along = a;
        origin = vec_add(origin, vec_add(c[0], vec_add(c[1], c[2])));
    }
    origin = vec_scale(origin, 1 / (3.0 * count));
    for (uint32_t i = 0; i < count; i++) {
        btg_triangle_corners(part, triangles[i], c);
        for (int k = 0; k < 3; k++)
            size = max2(size, vec_norm2(vec_sub(c[k], origin)));
    }
    /* flat: a leaf's few triangles bend less than their parents', and triangles are many */
    fit f;
    set_frame(&f, origin, normal, along, sqrt(size));
    double rounding = 1e-14 * part->scale / f.size + rounding_of(&f);
    for (uint32_t i = 0; i < count; i++) {
        btg_triangle_corners(part, triangles[i], c);
        for (int k = 0; k < 3; k++) {
            btg_vec3 p = in_frame(&f, vec_sub(c[k], f.origin));
            cover(&f, p.x, p.y, 0);
            add_height(&f, p.z, rounding);
        }
    }
    finish(&f, sheet);
    sheet->radius = radius_of(sheet);
}

/* ---- sheets ------------------------------------------------------------------------------- */

/* A sheet in a fit's frame. */
typedef struct framed {
    btg_vec3 c, a, b;
    double uu, uv, vv; /* of the height */
    double aside;      /* what second derivatives lead along the plane, at most */
    double error, radius;
} framed;

static framed to_frame(const fit *f, const btg_sheet *s) {
    framed r;
    r.c = in_frame(f, vec_sub(s->centre, f->origin));
    r.a = in_frame(f, s->a);
    r.b = in_frame(f, s->b);
    btg_vec3 uu = in_frame(f, s->uu), uv = in_frame(f, s->uv), vv = in_frame(f, s->vv);
    r.uu = uu.z;
    r.uv = uv.z;
    r.vv = vv.z;
    r.aside = 0.5 * norm2(uu.x, uu.y) + norm2(uv.x, uv.y) + 0.5 * norm2(vv.x, vv.y);
    r.error = s->error / f->size;
    r.radius = s->radius / f->size;
    return r;
}

static btg_vec3 corner_of(const framed *s, int i, int k) {
    return vec_mad(vec_mad(s->c, s->a, i), s->b, k);
}

static double second_order(const framed *s, int i, int k) {
    return 0.5 * (s->uu * i * i + s->vv * k * k) + s->uv * i * k;
}

/* The Bezier coefficients of the height above the fit: its polar form at corners and sides. */
static void add_coefficients(fit *f, const framed *s, double slack) {
    static const int ends[3][2] = {{-1, -1}, {-1, 1}, {1, 1}};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            int s1 = ends[i][0], s2 = ends[i][1], t1 = ends[k][0], t2 = ends[k][1];
            double uv = 0.25 * (s1 + s2) * (t1 + t2);
            double z = s->c.z + 0.5 * (s1 + s2) * s->a.z + 0.5 * (t1 + t2) * s->b.z;
            z += 0.5 * (s->uu * s1 * s2 + s->vv * t1 * t2) + s->uv * uv;
            /* of the fit, symmetric in the pairs */
            double q = 0.5 * (polar(f, corner_of(s, s1, t1), corner_of(s, s2, t2)) +
                              polar(f, corner_of(s, s1, t2), corner_of(s, s2, t1)));
            add_height(f, z - q, slack);
        }
}

/* The steepest slope of the fit over what it covers. */
static double steepest(const fit *f) {
    const double *c = f->c;
    double x = max2(fabs(f->low_x), fabs(f->high_x)), y = max2(fabs(f->low_y), fabs(f->high_y));
    return norm2(fabs(c[1]) + fabs(c[3]) * x + fabs(c[4]) * y,
                 fabs(c[2]) + fabs(c[4]) * x + fabs(c[5]) * y);
}

/* Where the sheet lies over the plane: its corners, but no farther than its ball. */
static void cover_sheet(fit *f, const framed *s) {
    double x = fabs(s->a.x) + fabs(s->b.x) + s->aside + s->error;
    double y = fabs(s->a.y) + fabs(s->b.y) + s->aside + s->error;
    cover(f, s->c.x, s->c.y, 0);
    f->low_x = min2(f->low_x, s->c.x - min2(x, s->radius));
    f->high_x = max2(f->high_x, s->c.x + min2(x, s->radius));
    f->low_y = min2(f->low_y, s->c.y - min2(y, s->radius));
    f->high_y = max2(f->high_y, s->c.y + min2(y, s->radius));
}

static void add_points(fit *f, const framed *s) {
    for (int k = 0; k < 9; k += 2) { /* the corners and the middle */
        btg_vec3 p = corner_of(s, k % 3 - 1, k / 3 - 1);
        p.z += second_order(s, k % 3 - 1, k / 3 - 1);
        add_point(f, p);
    }
}

/* Sheets that face many ways have no common slope: then the box about their balls. */
static void box_of(fit *f, const framed *part, int count, btg_sheet *sheet) {
    for (int i = 0; i < 6; i++)
        f->c[i] = 0;
    f->low = INFINITY;
    f->high = -INFINITY;
    for (int i = 0; i < count; i++) {
        const framed *s = &part[i];
        double z = fabs(s->a.z) + fabs(s->b.z) + 0.5 * (fabs(s->uu) + fabs(s->vv)) + fabs(s->uv);
        add_height(f, s->c.z, min2(z + s->error, s->radius) + rounding_of(f));
    }
    finish(f, sheet);
}

void btg_sheet_merge(const btg_sheet *of, int count, btg_sheet *sheet) {
    btg_vec3 normal = vec(0, 0, 0), origin = vec(0, 0, 0);
    double size = 0;
    for (int i = 0; i < count; i++) {
        normal = vec_add(normal, turned_to(vec_cross(of[i].a, of[i].b), normal));
        origin = vec_mad(origin, of[i].centre, 1.0 / count);
    }
    for (int i = 0; i < count; i++)
        size = max2(size, vec_norm(vec_sub(of[i].centre, origin)) + of[i].radius);
    fit f;
    set_frame(&f, origin, normal, of[0].a, size);
    framed part[4];
    for (int i = 0; i < count; i++) {
        part[i] = to_frame(&f, &of[i]);
        cover_sheet(&f, &part[i]);
        add_points(&f, &part[i]);
    }
    solve(&f);
    double slope = steepest(&f), rounding = rounding_of(&f);
    for (int i = 0; i < count; i++)
        add_coefficients(&f, &part[i],
                         part[i].error * (1 + slope) + part[i].aside * slope + rounding);
    finish(&f, sheet);
    sheet->radius = radius_of(sheet);
    const double wide = 1.8; /* a flat square's corner is 1.41 away */
    if (!(sheet->radius <= wide * size)) {
        box_of(&f, part, count, sheet);
        sheet->radius = radius_of(sheet);
    }
    double ball = (vec_norm(vec_sub(sheet->centre, origin)) + size) * (1 + 1e-12);
    sheet->radius = min2(sheet->radius, ball);
}
