#include "hard_depth.h"

#include <stdlib.h>

#define GRID     48 /* samples of a patch, either way */
#define TRIANGLE 4  /* of a triangle */
#define SEEDS    6  /* about the deepest of them it is sought deeper */
#define STEPS    300
/* Steps end where they tell nothing any more, part of the parameters' range. */
#define STEP_LEAST 1e-11

typedef struct seed {
    double distance;
    btg_place at;
} seed;

btg_vec3 hard_point(const btg_part *part, btg_place p) {
    if (p.item < part->patch_count) return btg_patch_point(&part->patches[p.item], p.u, p.v);
    btg_vec3 c[3];
    btg_triangle_corners(part, p.item - part->patch_count, c);
    return vec_mad(vec_mad(c[0], vec_sub(c[1], c[0]), p.u), vec_sub(c[2], c[0]), p.v);
}

double hard_distance(const hard_field *f, const hard_pose *p, btg_place at) {
    return btg_tool_distance(p->tool, p->centre, p->axis, hard_point(f->part, at));
}

hard_field hard_field_make(const btg_part *part) {
    hard_field f = {.part = part};
    size_t each = (GRID + 1) * (GRID + 1);
    f.sample = malloc(sizeof *f.sample * (part->patch_count * each + 1));
    if (!f.sample) abort();
    for (uint32_t item = 0; item < part->patch_count; item++)
        for (int i = 0; i <= GRID; i++)
            for (int k = 0; k <= GRID; k++) {
                btg_place at = {item, (double)i / GRID, (double)k / GRID};
                f.sample[item * each + (size_t)(i * (GRID + 1) + k)] = hard_point(part, at);
            }
    return f;
}

void hard_field_free(hard_field *f) {
    free(f->sample);
    f->sample = NULL;
}

/* Keeps the deepest, in order. */
static void keep(seed *kept, seed one) {
    int i = SEEDS;
    for (; i > 0 && kept[i - 1].distance > one.distance; i--)
        if (i < SEEDS) kept[i] = kept[i - 1];
    if (i < SEEDS) kept[i] = one;
}

static void keep_patch(const hard_field *f, const hard_pose *p, uint32_t item, seed *kept) {
    static double d[GRID + 1][GRID + 1];
    const btg_vec3 *sample = f->sample + (size_t)item * (GRID + 1) * (GRID + 1);
    for (int i = 0; i <= GRID; i++)
        for (int k = 0; k <= GRID; k++)
            d[i][k] = btg_tool_distance(p->tool, p->centre, p->axis, sample[i * (GRID + 1) + k]);
    for (int i = 0; i <= GRID; i++)
        for (int k = 0; k <= GRID; k++) {
            double x = d[i][k];
            bool low = (i == 0 || x <= d[i - 1][k]) && (i == GRID || x <= d[i + 1][k]) &&
                       (k == 0 || x <= d[i][k - 1]) && (k == GRID || x <= d[i][k + 1]);
            if (low) keep(kept, (seed){x, {item, (double)i / GRID, (double)k / GRID}});
        }
}

static void keep_triangle(const hard_field *f, const hard_pose *p, uint32_t item, seed *kept) {
    seed best = {.distance = INFINITY};
    for (int i = 0; i <= TRIANGLE; i++)
        for (int k = 0; k <= TRIANGLE - i; k++) {
            seed one = {0, {item, (double)i / TRIANGLE, (double)k / TRIANGLE}};
            one.distance = hard_distance(f, p, one.at);
            if (one.distance < best.distance) best = one;
        }
    keep(kept, best);
}

/* The eight neighbours of a place, a step away, held inside the item; of a triangle two of them
 * along its third side. */
static btg_place neighbour(const btg_part *part, btg_place at, int i, double h) {
    bool triangle = at.item >= part->patch_count;
    btg_place next = {at.item, at.u + (i / 3 - 1) * h, at.v + (i % 3 - 1) * h};
    if (triangle && i == 0) next.u = at.u + h, next.v = at.v - h;
    if (triangle && i == 8) next.u = at.u - h, next.v = at.v + h;
    next.u = min2(max2(next.u, 0), 1);
    next.v = min2(max2(next.v, 0), triangle ? 1 - next.u : 1);
    return next;
}

/* Least distance to the tool or, without one, to a point. */
static double descend(const btg_part *part, const hard_pose *p, btg_vec3 point, btg_place *at,
                      double h) {
    hard_field f = {.part = part};
    double least = INFINITY;
    for (int step = 0; step < STEPS && h > STEP_LEAST; step++) {
        btg_place best = *at;
        double before = least;
        for (int i = 0; i < 9; i++) {
            btg_place next = neighbour(part, *at, step == 0 ? 4 : i, h);
            double d =
                p ? hard_distance(&f, p, next) : vec_norm(vec_sub(hard_point(part, next), point));
            if (!(d < least)) continue;
            least = d;
            best = next;
        }
        *at = best;
        if (least == before) h *= 0.5;
    }
    return least;
}

double hard_descend(const hard_field *f, const hard_pose *p, btg_place from, double step) {
    return descend(f->part, p, vec(0, 0, 0), &from, step);
}

double hard_least_distance(const hard_field *f, const hard_pose *p, const btg_place *also) {
    seed kept[SEEDS];
    for (int i = 0; i < SEEDS; i++)
        kept[i] = (seed){.distance = INFINITY};
    for (uint32_t i = 0; i < f->part->patch_count; i++)
        keep_patch(f, p, i, kept);
    for (uint32_t i = 0; i < f->part->triangle_count; i++)
        keep_triangle(f, p, f->part->patch_count + i, kept);
    double least = INFINITY;
    for (int i = 0; i < SEEDS && kept[i].distance < INFINITY; i++)
        least = min2(least, hard_descend(f, p, kept[i].at, 0.5 / GRID));
    return also ? min2(least, hard_descend(f, p, *also, 0.5 / GRID)) : least;
}

double hard_nearest(const btg_part *part, uint32_t item, btg_vec3 point, btg_place *place) {
    double least = INFINITY;
    btg_place from = {item, 0, 0};
    for (int i = 0; i <= TRIANGLE; i++)
        for (int k = 0; k <= TRIANGLE; k++) {
            btg_place at = {item, (double)i / TRIANGLE, (double)k / TRIANGLE};
            if (item >= part->patch_count && i + k > TRIANGLE) continue;
            double d = vec_norm(vec_sub(hard_point(part, at), point));
            if (!(d < least)) continue;
            least = d;
            from = at;
        }
    *place = from;
    return descend(part, NULL, point, place, 0.5 / TRIANGLE);
}
