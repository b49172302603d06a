/* What a patch's quadratic Taylor polynomial leaves out along one direction. Internal. */
#ifndef BTG_CORE_TAIL_H
#define BTG_CORE_TAIL_H

#include "core/part.h"

/* n . (S - S0) about a place to second order, in units s, t of half sides hu, hv:
 * a s + b t + (uu s^2 + 2 uv s t + vv t^2) / 2. */
typedef struct btg_taylor {
    double a, b, uu, uv, vv;
} btg_taylor;

/* Room for a patch's polynomials while they are moved: of n . W (S - S0), and of W. */
typedef struct btg_tail_room {
    double along[BTG_ORDER_MAX * BTG_ORDER_MAX], weight[BTG_ORDER_MAX * BTG_ORDER_MAX];
} btg_tail_room;

/* The most that n . S differs from its Taylor polynomial about (u, v) on |s|, |t| <= 1, mm for a
 * unit n; INFINITY where a weight is not bounded away from 0 that far. Bounds of whole third
 * derivatives (btg_piece) are larger where those run along the surface, as near a collapsed edge,
 * round which the other parameter turns. */
double btg_patch_tail(const btg_patch *patch, btg_vec3 n, double u, double v, double hu, double hv,
                      const btg_taylor *taylor, btg_tail_room *room);

#endif
