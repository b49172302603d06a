/* Bezier nets: cutting B-splines and NURBS into patches, power forms, sub-patches. Internal; set-up
 * only. */
#ifndef BTG_CORE_SURFACE_H
#define BTG_CORE_SURFACE_H

#include "core/part.h"

/* Doubles of the largest patch: coefficients are kept homogeneous while cutting. */
#define BTG_NET_MAX (BTG_ORDER_MAX * BTG_ORDER_MAX * 4)

/* A patch's control net while it is cut: points (w x, w y, w z, w), v fastest. */
typedef struct btg_net {
    int degree_u, degree_v;
    double point[BTG_NET_MAX];
} btg_net;

/* Checks a definition; `index` names the surface in the message. */
btg_status btg_surface_check(const btg_surface_def *def, size_t index, btg_message *message);

/* Number of Bezier patches of a checked definition. */
size_t btg_surface_patch_count(const btg_surface_def *def);

/* Calls `sink` for each patch, u-spans outside, v-spans inside; stops at its first error. */
typedef btg_status (*btg_net_sink)(const btg_net *net, const double domain_u[2],
                                   const double domain_v[2], void *user);
btg_status btg_surface_cut(const btg_surface_def *def, btg_net_sink sink, void *user);

/* Halves a net in u (along_u) or v. */
void btg_net_split(const btg_net *net, bool along_u, btg_net *low, btg_net *high);

/* Raises `third` to the bounds of |Suuu|, |Suuv|, |Suvv|, |Svvv| over a net. */
void btg_net_third(const btg_net *net, double third[4]);

/* The polynomial of W (S - origin) in u - 1/2, v - 1/2: as many points as the net has. Returns the
 * largest rounding error of a point evaluated with it, mm. */
double btg_net_power(const btg_net *net, btg_vec3 origin, double *power);

#endif
