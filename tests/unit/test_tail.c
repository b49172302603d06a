/* What a quadratic Taylor polynomial leaves out along one direction: no point differs by more than
 * btg_patch_tail says, and that is near what points do differ by. The points come from the Bezier
 * net, by another way than the tail's polynomials. */
#include "check.h"
#include "core/tail.h"
#include "hard_parts.h"

#include <math.h>
#include <stdlib.h>

#define ROUNDS 400
#define POINTS 9 /* along each side */

static long pieces, close_ones;

static double along(const btg_patch *patch, btg_vec3 n, double u, double v) {
    return vec_dot(n, vec_sub(btg_patch_point(patch, u, v), patch->origin));
}

static void check_piece(const btg_part *part, const btg_patch *patch, rng *r, btg_tail_room *room) {
    btg_vec3 n = hard_unit(r);
    double size = pow(10, rng_range(r, -3, -0.5)), slim = pow(10, rng_range(r, -1, 0));
    double hu = rng_pick(r, 2) ? size : size * slim, hv = size == hu ? size * slim : size;
    double u = rng_range(r, hu, 1 - hu), v = rng_range(r, hv, 1 - hv);
    btg_surface_point s;
    btg_patch_evaluate(patch, u, v, &s);
    btg_taylor t = {vec_dot(n, s.su) * hu, vec_dot(n, s.sv) * hv, vec_dot(n, s.suu) * hu * hu,
                    vec_dot(n, s.suv) * hu * hv, vec_dot(n, s.svv) * hv * hv};
    double tail = btg_patch_tail(patch, n, u, v, hu, hv, &t, room), most = 0;
    double here = along(patch, n, u, v), rounding = 1e-13 * part->scale;
    for (int i = 0; i < POINTS * POINTS; i++) {
        double x = 2.0 * (i / POINTS) / (POINTS - 1) - 1, y = 2.0 * (i % POINTS) / (POINTS - 1) - 1;
        double taylor = t.a * x + t.b * y + 0.5 * (t.uu * x * x + t.vv * y * y) + t.uv * x * y;
        double left = along(patch, n, u + x * hu, v + y * hv) - here - taylor;
        if (fabs(left) > most) most = fabs(left);
    }
    CHECK(most <= tail + rounding);
    if (most <= 10 * rounding) return;
    pieces++;
    close_ones += tail < 4 * most;
}

int main(void) {
    btg_tail_room *room = malloc(sizeof *room);
    if (!room) return 2;
    for (int round = 0; round < ROUNDS; round++) {
        rng r = rng_of(3, "tail", (uint64_t)round);
        model m = {0};
        hard_add_patch(&m, &r, (hard_patch)(round % HARD_PATCHES), 40);
        btg_part *part = model_part(&m);
        if (!part) return 2;
        for (int i = 0; i < 20; i++)
            check_piece(part, &part->patches[rng_pick(&r, (int)part->patch_count)], &r, room);
        btg_part_destroy(part);
        model_free(&m);
    }
    printf("%ld pieces, %.1f %% within 4 times what points differ by\n", pieces,
           100.0 * (double)close_ones / (double)pieces);
    CHECK(pieces > 3000 && 10 * close_ones > 9 * pieces);
    free(room);
    return check_result();
}
