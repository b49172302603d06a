/* All the maths that the run phase may ask of a machine without an operating system. */
#ifndef BTG_TESTS_MATH_H
#define BTG_TESTS_MATH_H

#define INFINITY    __builtin_inf()
#define NAN         __builtin_nan("")
#define isfinite(x) __builtin_isfinite(x)
#define isinf(x)    __builtin_isinf(x)
#define isnan(x)    __builtin_isnan(x)
#define signbit(x)  __builtin_signbit(x)

double acos(double x);
double asin(double x);
double atan(double x);
double atan2(double y, double x);
double cbrt(double x);
double ceil(double x);
double copysign(double x, double y);
double cos(double x);
double exp(double x);
double fabs(double x);
double floor(double x);
double fma(double x, double y, double z);
double fmax(double x, double y);
double fmin(double x, double y);
double fmod(double x, double y);
double frexp(double x, int *exponent);
double hypot(double x, double y);
double ldexp(double x, int exponent);
double log(double x);
double nextafter(double x, double y);
double remainder(double x, double y);
double sin(double x);
double sqrt(double x);
double tan(double x);
float fabsf(float x);
float fmaxf(float x, float y);
float fminf(float x, float y);
float nextafterf(float x, float y);
float sqrtf(float x);

#endif
