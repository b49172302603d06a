/* The lower side of a placed cutter: where a vertical line first meets a torus that leans.
 *
 * With h the height along the axis and r the distance from it, the cutter is where
 * F = |(max(r - Ro, 0), h)| - Ri <= 0 (hollow: |(r - Ro, h)| - Ri). F is a true distance, so a step
 * of F along the line passes no root; and it is convex along the line where the cutter is solid,
 * so a Newton step from outside passes none either. The quartic of the same roots loses half of its
 * digits where the line grazes the tube; this search does not. */
#include "verify/internal.h"

#define ROUNDS_MAX 200
/* Of a root, as part of the cutter's size: some 100 roundings. */
#define ROOT_PART 2e-14
/* From a neighbour's height: so steep that Newton's method cannot leave the lower side. */
#define NEAR_SLOPE  (-0.2)
#define NEAR_ROUNDS 5
#define NEAR_ENOUGH 1e-6

typedef struct line {
    const btg_cutter *cutter;
    double size;        /* of numbers here, mm */
    double along, rise; /* h = along + rise * z */
    double flat2;       /* x^2 + y^2 */
    bool hollow;
} line;

/* F and its slope along the line. */
static double distance(const line *l, double z, double *slope) {
    double h = l->along + l->rise * z;
    double r2 = max2(l->flat2 + z * z - h * h, 0), r = sqrt(r2);
    double x = r - l->cutter->major;
    if (!l->hollow) x = max2(x, 0);
    double d = sqrt(x * x + h * h);
    double radial = r > 0 ? (z - h * l->rise) / r : 0;
    *slope = d > 0 ? (x * radial + h * l->rise) / d : l->rise;
    return d - l->cutter->minor;
}

/* A root between z (outside) and `inside`. */
static double bisect(const line *l, double z, double inside) {
    double slope;
    for (int i = 0; i < 60 && inside - z > ROOT_PART * l->size; i++) {
        double middle = 0.5 * (z + inside);
        if (distance(l, middle, &slope) > 0)
            z = middle;
        else
            inside = middle;
    }
    return z;
}

/* Outward past a hollow: the least F between z, where F falls, and `beyond`, where it rises. */
static double lowest(const line *l, double z, double beyond) {
    double slope;
    for (int i = 0; i < 50; i++) {
        double middle = 0.5 * (z + beyond), f = distance(l, middle, &slope);
        if (f <= 0) return middle;
        if (slope < 0)
            z = middle;
        else
            beyond = middle;
    }
    return z;
}

/* The flat of a disc: h = -Ri inside the major radius. */
static bool on_flat(const line *l, double z) {
    double h = l->along + l->rise * z;
    double r2 = l->flat2 + z * z - h * h, reach = l->cutter->major;
    return r2 <= reach * reach;
}

static line line_at(const btg_cutter *cutter, btg_vec3 axis, double x, double y) {
    return (line){.cutter = cutter,
                  .size = cutter->major + cutter->minor,
                  .along = axis.x * x + axis.y * y,
                  .rise = axis.z,
                  .flat2 = x * x + y * y,
                  .hollow = cutter->hollow};
}

bool btg_cutter_under_near(const btg_cutter *cutter, btg_vec3 axis, double x, double y, double near,
                           double *out) {
    line l = line_at(cutter, axis, x, y);
    double z = near, slope;
    for (int i = 0; i < NEAR_ROUNDS; i++) {
        double f = distance(&l, z, &slope);
        if (!(slope < NEAR_SLOPE)) return false;
        z -= f / slope;
        /* What Newton's method left before this step was f / slope: it now leaves its square over
         * the least radius that F bends with. */
        if (fabs(f) < NEAR_ENOUGH * cutter->minor) {
            *out = z;
            return true;
        }
    }
    return false;
}

bool btg_cutter_under(const btg_cutter *cutter, btg_vec3 axis, double x, double y, double *out) {
    line l = line_at(cutter, axis, x, y);
    if (l.flat2 > l.size * l.size) return false;
    /* Nothing of the cutter is below h = -Ri, nor above h = Ri. */
    double z = (-cutter->minor - l.along) / l.rise, slope, slope_next;
    double end = (cutter->minor - l.along) / l.rise;
    double least = -cutter->minor - cutter->major * norm2(axis.x, axis.y);
    double small = ROOT_PART * l.size;
    if (!cutter->hollow && on_flat(&l, z)) {
        *out = z;
        return true;
    }
    z = max2(z, least);
    double f = distance(&l, z, &slope);
    for (int i = 0; i < ROUNDS_MAX && z <= end + small; i++) {
        if (f <= small) {
            *out = z;
            return true;
        }
        if (slope >= 0 && !l.hollow) return false;
        double safe = z + f, next = slope < 0 ? z - f / slope : safe;
        if (next > end) next = max2(safe, end);
        double f_next = distance(&l, next, &slope_next);
        if (f_next < 0) {
            *out = bisect(&l, z, next);
            return true;
        }
        if (slope < 0 && slope_next > 0) {
            double middle = lowest(&l, z, next);
            if (distance(&l, middle, &slope) <= 0) {
                *out = bisect(&l, z, middle);
                return true;
            }
        }
        z = next;
        f = f_next;
        slope = slope_next;
    }
    return false;
}
