/* Four or eight doubles side by side: the same arithmetic, operation by operation, whatever the
 * processor. Vectors where the compiler knows them (64 bytes with AVX-512, 32 with AVX, else pairs
 * of 16), plain C elsewhere or where BTG_PLAIN_C asks for it. No operation fuses or reorders: all
 * give the same bits. Internal. */
#ifndef BTG_CORE_LANES_H
#define BTG_CORE_LANES_H

#include <math.h>
#include <stdint.h>
#include <string.h>

#if defined(__GNUC__)
#define ALWAYS_INLINE inline __attribute__((always_inline))
#else
#define ALWAYS_INLINE inline
#endif

/* Doubles that stand side by side in memory: six fours, three cache lines. */
#define BTG_BLOCK   24
#define BTG_ALIGNED _Alignas(64)

#if defined(__GNUC__) && defined(__AVX__) && !defined(BTG_PLAIN_C)
#include <immintrin.h>

/* One register each. */
#define LANES_UNARY(name, a, expression)                                                           \
    static inline lanes name(lanes a) {                                                            \
        return expression;                                                                         \
    }
#define LANES_BINARY(name, a, b, expression)                                                       \
    static inline lanes name(lanes a, lanes b) {                                                   \
        return expression;                                                                         \
    }
#endif

#if defined(__GNUC__) && defined(__AVX512F__) && defined(__AVX512DQ__) && !defined(BTG_PLAIN_C)
#define BTG_LANES 8

typedef __m512d lanes;
static inline lanes lanes_load(const double *p) {
    return _mm512_loadu_pd(p);
}
/* Four alone. */
static inline lanes lanes_load_four(const double p[4]) {
    return _mm512_zextpd256_pd512(_mm256_loadu_pd(p));
}
static inline void lanes_store(double *p, lanes a) {
    _mm512_storeu_pd(p, a);
}
static inline void lanes_store_four(double p[4], lanes a) {
    _mm256_storeu_pd(p, _mm512_castpd512_pd256(a));
}
/* The upper four alone, to their place. */
static inline void lanes_store_upper(double *p, lanes a) {
    _mm256_storeu_pd(p + 4, _mm512_extractf64x4_pd(a, 1));
}
static inline lanes lanes_all(double x) {
    return _mm512_set1_pd(x);
}
LANES_BINARY(lanes_add, a, b, a + b)
LANES_BINARY(lanes_sub, a, b, a - b)
LANES_BINARY(lanes_mul, a, b, a *b)
LANES_BINARY(lanes_div, a, b, a / b)
LANES_UNARY(lanes_sqrt, a, _mm512_sqrt_pd(a))
LANES_UNARY(lanes_abs, a, _mm512_andnot_pd(_mm512_set1_pd(-0.0), a))
LANES_BINARY(lanes_min, a, b, _mm512_min_pd(a, b)) /* a < b ? a : b */
LANES_BINARY(lanes_max, a, b, _mm512_max_pd(a, b)) /* a > b ? a : b */
/* a < b ? x : y */
static inline lanes lanes_if_less(lanes a, lanes b, lanes x, lanes y) {
    return _mm512_mask_blend_pd(_mm512_cmp_pd_mask(a, b, _CMP_LT_OQ), y, x);
}
/* Bit k: a < b in lane k. */
static inline unsigned lanes_less(lanes a, lanes b) {
    return _mm512_cmp_pd_mask(a, b, _CMP_LT_OQ);
}

#elif defined(__GNUC__) && defined(__AVX__) && !defined(BTG_PLAIN_C)
#define BTG_LANES 4

typedef __m256d lanes;
static inline lanes lanes_load(const double *p) {
    return _mm256_loadu_pd(p);
}
static inline void lanes_store(double *p, lanes a) {
    _mm256_storeu_pd(p, a);
}
static inline lanes lanes_all(double x) {
    return _mm256_set1_pd(x);
}
LANES_BINARY(lanes_add, a, b, a + b)
LANES_BINARY(lanes_sub, a, b, a - b)
LANES_BINARY(lanes_mul, a, b, a *b)
LANES_BINARY(lanes_div, a, b, a / b)
LANES_UNARY(lanes_sqrt, a, _mm256_sqrt_pd(a))
LANES_UNARY(lanes_abs, a, _mm256_andnot_pd(_mm256_set1_pd(-0.0), a))
LANES_BINARY(lanes_min, a, b, _mm256_min_pd(a, b)) /* a < b ? a : b */
LANES_BINARY(lanes_max, a, b, _mm256_max_pd(a, b)) /* a > b ? a : b */
/* a < b ? x : y */
static inline lanes lanes_if_less(lanes a, lanes b, lanes x, lanes y) {
    return _mm256_blendv_pd(y, x, _mm256_cmp_pd(a, b, _CMP_LT_OQ));
}
/* Bit k: a < b in lane k. */
static inline unsigned lanes_less(lanes a, lanes b) {
    return (unsigned)_mm256_movemask_pd(_mm256_cmp_pd(a, b, _CMP_LT_OQ));
}

#elif defined(__GNUC__) && !defined(BTG_PLAIN_C)
#ifdef __SSE2__
#include <emmintrin.h>
#endif

#define BTG_LANES 4

typedef double lanes_pair __attribute__((vector_size(16)));
typedef int64_t lanes_mask __attribute__((vector_size(16)));
typedef struct lanes {
    lanes_pair low, high;
} lanes;
#define LANES_UNARY(name, a, expression)                                                           \
    static inline lanes_pair name##_pair(lanes_pair a) {                                           \
        return expression;                                                                         \
    }                                                                                              \
    static inline lanes name(lanes a) {                                                            \
        return (lanes){name##_pair(a.low), name##_pair(a.high)};                                   \
    }
#define LANES_BINARY(name, a, b, expression)                                                       \
    static inline lanes_pair name##_pair(lanes_pair a, lanes_pair b) {                             \
        return expression;                                                                         \
    }                                                                                              \
    static inline lanes name(lanes a, lanes b) {                                                   \
        return (lanes){name##_pair(a.low, b.low), name##_pair(a.high, b.high)};                    \
    }
static inline lanes lanes_load(const double *p) {
    lanes a;
    memcpy(&a, p, sizeof a);
    return a;
}
static inline void lanes_store(double *p, lanes a) {
    memcpy(p, &a, sizeof a);
}
static inline lanes lanes_all(double x) {
    return (lanes){{x, x}, {x, x}};
}
static inline lanes_pair lanes_pair_choose(lanes_mask m, lanes_pair x, lanes_pair y) {
    return (lanes_pair)((m & (lanes_mask)x) | (~m & (lanes_mask)y));
}
static inline lanes_pair lanes_pair_sqrt(lanes_pair a) {
#ifdef __SSE2__
    return (lanes_pair)_mm_sqrt_pd((__m128d)a);
#else
    return (lanes_pair){sqrt(a[0]), sqrt(a[1])};
#endif
}
LANES_BINARY(lanes_add, a, b, a + b)
LANES_BINARY(lanes_sub, a, b, a - b)
LANES_BINARY(lanes_mul, a, b, a *b)
LANES_BINARY(lanes_div, a, b, a / b)
LANES_UNARY(lanes_sqrt, a, lanes_pair_sqrt(a))
LANES_UNARY(lanes_abs, a, (lanes_pair)((lanes_mask)a &INT64_MAX))
LANES_BINARY(lanes_min, a, b, lanes_pair_choose(a < b, a, b))
LANES_BINARY(lanes_max, a, b, lanes_pair_choose(a > b, a, b))
static inline lanes lanes_if_less(lanes a, lanes b, lanes x, lanes y) {
    return (lanes){lanes_pair_choose(a.low < b.low, x.low, y.low),
                   lanes_pair_choose(a.high < b.high, x.high, y.high)};
}
static inline unsigned lanes_less(lanes a, lanes b) {
    lanes_mask low = a.low < b.low, high = a.high < b.high;
    return (unsigned)((low[0] & 1) | (low[1] & 2) | (high[0] & 4) | (high[1] & 8));
}

#else

#define BTG_LANES 4

typedef struct lanes {
    double at[BTG_LANES];
} lanes;
#define LANES_EACH(result, expression)                                                             \
    lanes result;                                                                                  \
    for (int k = 0; k < BTG_LANES; k++)                                                            \
        result.at[k] = expression;                                                                 \
    return result;
#define LANES_UNARY(name, a, expression)                                                           \
    static inline lanes name(lanes a) {                                                            \
        LANES_EACH(r, expression)                                                                  \
    }
#define LANES_BINARY(name, a, b, expression)                                                       \
    static inline lanes name(lanes a, lanes b) {                                                   \
        LANES_EACH(r, expression)                                                                  \
    }
static inline lanes lanes_load(const double *p) {
    lanes a;
    memcpy(&a, p, sizeof a);
    return a;
}
static inline void lanes_store(double *p, lanes a) {
    memcpy(p, &a, sizeof a);
}
static inline lanes lanes_all(double x){LANES_EACH(r, x)} LANES_BINARY(lanes_add, a, b,
                                                                       a.at[k] + b.at[k])
    LANES_BINARY(lanes_sub, a, b, a.at[k] - b.at[k])
        LANES_BINARY(lanes_mul, a, b, a.at[k] * b.at[k])
            LANES_BINARY(lanes_div, a, b, a.at[k] / b.at[k])
                LANES_UNARY(lanes_sqrt, a, sqrt(a.at[k])) LANES_UNARY(lanes_abs, a, fabs(a.at[k]))
                    LANES_BINARY(lanes_min, a, b, a.at[k] < b.at[k] ? a.at[k] : b.at[k])
                        LANES_BINARY(lanes_max, a, b,
                                     a.at[k] > b.at[k] ? a.at[k] : b.at[k]) static inline lanes
    lanes_if_less(lanes a, lanes b, lanes x, lanes y) {
    LANES_EACH(r, a.at[k] < b.at[k] ? x.at[k] : y.at[k])
}
static inline unsigned lanes_less(lanes a, lanes b) {
    unsigned bits = 0;
    for (unsigned k = 0; k < BTG_LANES; k++)
        bits |= (unsigned)(a.at[k] < b.at[k]) << k;
    return bits;
}

#endif

#if BTG_LANES == 4
static inline lanes lanes_load_four(const double p[4]) {
    return lanes_load(p);
}
static inline void lanes_store_four(double p[4], lanes a) {
    lanes_store(p, a);
}
#endif

/* a + b c, rounded twice */
static inline lanes lanes_mad(lanes a, lanes b, lanes c) {
    return lanes_add(a, lanes_mul(b, c));
}

/* Vectors side by side. */
typedef struct lanes3 {
    lanes x, y, z;
} lanes3;

/* The same in memory: x, y, z of each. */
typedef struct lanes3_memory {
    BTG_ALIGNED double at[3][BTG_BLOCK];
} lanes3_memory;

/* Those from number i on. */
static inline lanes3 lanes3_load(const lanes3_memory *p, int i) {
    return (lanes3){lanes_load(p->at[0] + i), lanes_load(p->at[1] + i), lanes_load(p->at[2] + i)};
}
static inline void lanes3_store(lanes3_memory *p, int i, lanes3 a) {
    lanes_store(p->at[0] + i, a.x);
    lanes_store(p->at[1] + i, a.y);
    lanes_store(p->at[2] + i, a.z);
}
static inline lanes3 lanes3_scale(lanes3 a, lanes by) {
    return (lanes3){lanes_mul(a.x, by), lanes_mul(a.y, by), lanes_mul(a.z, by)};
}
static inline lanes lanes3_dot(lanes3 a, lanes3 b) {
    return lanes_mad(lanes_mad(lanes_mul(a.x, b.x), a.y, b.y), a.z, b.z);
}
static inline lanes lanes3_norm2(lanes3 a) {
    return lanes3_dot(a, a);
}

#endif
