/* Three-vectors in double precision. Internal. */
#ifndef BTG_CORE_VEC_H
#define BTG_CORE_VEC_H

#include "bitangent/bitangent.h"

#include <math.h>
#include <stdbool.h>

/* Keeps a function's frame off the stack of those that go deeper. */
#if defined(__GNUC__)
#define BTG_APART __attribute__((noinline))
#else
#define BTG_APART
#endif

#define BTG_PI 3.14159265358979323846

/* Unlike fmin and fmax these compile to one instruction; b when either is NaN. */
static inline double min2(double a, double b) {
    return a < b ? a : b;
}
static inline double max2(double a, double b) {
    return a > b ? a : b;
}

static inline double norm2(double a, double b) {
    return sqrt(a * a + b * b);
}

static inline btg_vec3 vec(double x, double y, double z) {
    return (btg_vec3){x, y, z};
}
static inline btg_vec3 vec_add(btg_vec3 a, btg_vec3 b) {
    return vec(a.x + b.x, a.y + b.y, a.z + b.z);
}
static inline btg_vec3 vec_sub(btg_vec3 a, btg_vec3 b) {
    return vec(a.x - b.x, a.y - b.y, a.z - b.z);
}
static inline btg_vec3 vec_scale(btg_vec3 a, double k) {
    return vec(a.x * k, a.y * k, a.z * k);
}
/* a + k b */
static inline btg_vec3 vec_mad(btg_vec3 a, btg_vec3 b, double k) {
    return vec(a.x + b.x * k, a.y + b.y * k, a.z + b.z * k);
}
static inline double vec_dot(btg_vec3 a, btg_vec3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline btg_vec3 vec_cross(btg_vec3 a, btg_vec3 b) {
    return vec(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
static inline double vec_norm2(btg_vec3 a) {
    return vec_dot(a, a);
}
static inline double vec_norm(btg_vec3 a) {
    return sqrt(vec_dot(a, a));
}
static inline bool vec_finite(btg_vec3 a) {
    return isfinite(a.x) && isfinite(a.y) && isfinite(a.z);
}
/* Zero stays zero. */
static inline btg_vec3 vec_unit(btg_vec3 a) {
    double n = vec_norm(a);
    return n > 0.0 ? vec_scale(a, 1.0 / n) : a;
}
/* A unit vector at right angles to the unit vector a. */
static inline btg_vec3 vec_perpendicular(btg_vec3 a) {
    btg_vec3 e = fabs(a.x) < 0.6 ? vec(1, 0, 0) : vec(0, 1, 0);
    return vec_unit(vec_cross(a, e));
}
/* The unit vector at `part` of the even turn from unit a to unit b, in the plane of both. */
static inline btg_vec3 vec_turned(btg_vec3 a, btg_vec3 b, double part) {
    double angle = atan2(vec_norm(vec_cross(a, b)), vec_dot(a, b));
    /* Below this the chord is the arc to a double's last digit. */
    if (angle < 1e-8) return vec_unit(vec_mad(a, vec_sub(b, a), part));
    btg_vec3 across = vec_unit(vec_mad(b, a, -vec_dot(a, b)));
    return vec_unit(vec_add(vec_scale(a, cos(angle * part)), vec_scale(across, sin(angle * part))));
}
static inline btg_vec3 vec_nan(void) {
    return vec(NAN, NAN, NAN);
}

#endif
