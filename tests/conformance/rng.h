/* Numbers that are the same on every machine: splitmix64 (S. Vigna, 2015, public domain). */
#ifndef BTG_TESTS_RNG_H
#define BTG_TESTS_RNG_H

#include <stdint.h>

typedef struct rng {
    uint64_t state;
} rng;

static inline uint64_t rng_next(rng *r) {
    uint64_t z = r->state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

/* Even in low .. high. */
static inline double rng_range(rng *r, double low, double high) {
    return low + (high - low) * ((double)(rng_next(r) >> 11) * 0x1p-53);
}

/* 0 .. count - 1 */
static inline int rng_pick(rng *r, int count) {
    return (int)(rng_next(r) % (uint64_t)count);
}

/* A stream of its own for each seed, name and round. */
static inline rng rng_of(uint64_t seed, const char *name, uint64_t round) {
    rng r = {seed * 0x9e3779b97f4a7c15u + round};
    for (; *name; name++)
        r.state = (r.state ^ (uint64_t)(unsigned char)*name) * 0x100000001b3u;
    rng_next(&r);
    return r;
}

#endif
