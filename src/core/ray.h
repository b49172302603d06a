/* Vertical and circular rays in closed form, and the placed tool they lead to. Internal.
 *
 * Both questions maximise one number over the part, its `value`: the larger, the earlier the tool
 * meets the point. DROP: the height of the torus centre along the axis. TILT: -beta. The tool
 * placed at the largest value touches the part and is clear of it. */
#ifndef BTG_CORE_RAY_H
#define BTG_CORE_RAY_H

#include "core/vec.h"

typedef enum btg_op { BTG_OP_DROP, BTG_OP_TILT } btg_op;

/* A query in the frame both ops share. DROP: o = origin, w = axis. TILT: o = o1, {u, v, w}. */
typedef struct btg_ray_query {
    btg_op op;
    const btg_tool *tool;
    btg_vec3 u, v, w, o;
    /* TILT alone: */
    btg_vec3 p, n;       /* first contact and its normal, part to tool */
    double inclination;  /* lambda of the start pose: angle from n to w */
    double p_clearance2; /* squared radius about p where rays to the cutter's round corner are
                            ill-posed and the osculating limit answers instead, mm^2 */
} btg_ray_query;

btg_ray_query btg_ray_query_drop(const btg_tool *tool, const btg_drop_query *query);
btg_ray_query btg_ray_query_tilt(const btg_tool *tool, const btg_tilt_query *query);

/* The minor radius; of a sharp tool the major: what distances from P are measured by, mm. */
double btg_ray_insert_size(const btg_tool *tool);

typedef struct btg_ray_hit {
    double value;     /* height, or -beta; a TILT value > 0 means the start pose is inside */
    uint32_t element; /* of the tool */
    bool round;       /* on the cutter's round corner */
    double tv, tw;    /* TILT, there: where the point stands then, along the turned v and w */
} btg_ray_hit;

/* The first meeting of the part point s with any element of the tool. False: never. */
bool btg_ray_cast(const btg_ray_query *query, btg_vec3 s, btg_ray_hit *hit);

/* An upper bound of the value of all points within `radius` of s that one element meets: the
 * value of s itself for the element offset by the radius. False: none meets it. */
bool btg_ray_ball_value(const btg_ray_query *query, uint32_t element, btg_vec3 s, double radius,
                        double *value);

/* The tool placed at a value. */
typedef struct btg_placement {
    btg_vec3 centre; /* torus centre */
    btg_vec3 axis;
    bool swept; /* DROP: elements stand for all they pass on the way down, so they have no top */
} btg_placement;

btg_placement btg_ray_place(const btg_ray_query *query, double value);

/* The osculating limit (geometry: where P and Q meet): the largest value of points of one sheet
 * of the part as they approach P. The sheet is given by its derivatives at P; `edge_u`/`edge_v`
 * say that P lies on an edge along v (u fixed) / along u (v fixed) of the sheet. False: no limit
 * (the sheet leaves P away from the tool's tangent plane in all directions). */
bool btg_ray_osculating(const btg_ray_query *query, const btg_surface_point *sheet, bool edge_u,
                        bool edge_v, double *value);

/* The direction from P in which a smooth sheet reaches its osculating limit: parameters of a step
 * of 1 mm. False: none. */
bool btg_ray_ridge(const btg_ray_query *query, const btg_surface_point *sheet, double ridge[2],
                   double *limit);

/* Limits that the tool alone sets to the tilt about its first contact: P reaches the flat of a
 * bullnose, or the axis where the major radius is the smaller one. False: none. */
bool btg_ray_tool_limit(const btg_ray_query *query, double *value);

/* Distance of s to one element as placed (its swept side: see ray.c), with unit gradient and the
 * two principal curvatures of the distance at s: `ring` along the circle about the axis, `meridian`
 * across it. */
typedef struct btg_ray_distance {
    double distance;
    btg_vec3 normal; /* gradient: from the tool outward */
    btg_vec3 ring_tangent, meridian_tangent;
    double ring_curvature, meridian_curvature;
} btg_ray_distance;

void btg_ray_measure(const btg_tool_element *element, const btg_placement *placement, btg_vec3 s,
                     btg_ray_distance *distance);

static inline btg_ray_distance btg_ray_tool_distance(const btg_tool_element *element,
                                                     btg_placement placement, btg_vec3 s) {
    btg_ray_distance d;
    btg_ray_measure(element, &placement, s, &d);
    return d;
}

/* The distance alone. */
double btg_ray_tool_gap(const btg_tool_element *element, const btg_placement *placement,
                        btg_vec3 s);

/* The tool placed where it meets s, and the distance there. */
void btg_ray_touch(const btg_ray_query *query, btg_vec3 s, const btg_ray_hit *hit,
                   btg_placement *placement, btg_ray_distance *distance);

#endif
