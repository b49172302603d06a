/* Queries on their way to the device, winners on their way back. */
#include "backend/device/scene.h"
#include "core/part.h"
#include "core/ray.h"

/* Radius about P, in minor radii, inside which single precision tells nothing of d: there the
 * osculating limit answers, and the core's polish. */
#define P_CLEARANCE 0.02
/* A place this near P, in minor radii, is no start: the peak may lie where the device saw nothing,
 * and the core looks there by itself. */
#define NEAR_P 0.1
/* Less than any height: what a DROP has to beat. */
#define LEAST (-3e38f)
/* P is on an edge that comes this close, part of the clearance. */
#define ON_EDGE 0.01

static btg_gpu_vec4 pack(btg_vec3 a, double w) {
    return (btg_gpu_vec4){(float)a.x, (float)a.y, (float)a.z, (float)w};
}

void btg_gpu_pack_drop(const btg_scene *scene, const btg_drop_query *query, btg_gpu_query *out,
                       double *shift) {
    btg_ray_query q = btg_ray_query_drop(NULL, query); /* the frame alone */
    /* The origin moves along the axis to the height of the part: heights keep their digits. */
    *shift = vec_dot(vec_sub(scene->middle, query->origin), query->axis);
    btg_vec3 origin = vec_sub(vec_mad(query->origin, query->axis, *shift), scene->middle);
    *out = (btg_gpu_query){.u = pack(q.u, 0), .v = pack(q.v, 0), .w = pack(q.w, 0)};
    out->u.w = LEAST;
    btg_gpu_split(origin, &out->origin, &out->origin_low);
}

/* What distances from P are measured by. */
static double size_of(const btg_backend_setup *setup) {
    const btg_tool_element *e = &setup->tool.element[0];
    return e->corner_radius_mm > 0 ? e->corner_radius_mm : e->ring_radius_mm;
}

void btg_gpu_pack_tilt(const btg_backend_setup *setup, const btg_scene *scene,
                       const btg_tilt_query *query, btg_gpu_query *out) {
    double clearance = P_CLEARANCE * size_of(setup);
    btg_gpu_vec4 p, low;
    btg_gpu_split(vec_sub(query->p.point, query->o1), &p, &low);
    p.w = (float)(clearance * clearance);
    *out = (btg_gpu_query){.u = pack(query->u, -query->max_tilt_rad),
                           .v = pack(query->v, low.x),
                           .w = pack(query->w, low.y),
                           .p = p,
                           .n = pack(query->p.normal, low.z)};
    btg_gpu_split(vec_sub(query->o1, scene->middle), &out->origin, &out->origin_low);
}

bool btg_gpu_start(const btg_backend_setup *setup, const btg_gpu_winner *w, btg_place *start) {
    const btg_part *part = setup->part;
    if (!w->found || w->item >= (uint64_t)part->patch_count + part->triangle_count) return false;
    btg_place at = {w->item, w->u, w->v};
    if (!(at.u >= 0 && at.u <= 1 && at.v >= 0 && at.v <= 1)) return false;
    if (at.item >= part->patch_count && at.u + at.v > 1) at.v = 1 - at.u;
    *start = at;
    return true;
}

bool btg_gpu_start_tilt(const btg_backend_setup *setup, const btg_tilt_query *query,
                        const btg_gpu_winner *winner, btg_place *start) {
    btg_place at;
    btg_surface_point s;
    if (!btg_gpu_start(setup, winner, &at)) return false;
    btg_part_point(setup->part, at, &s);
    double near = NEAR_P * size_of(setup);
    if (vec_norm2(vec_sub(s.s, query->p.point)) < near * near) return false;
    *start = at;
    return true;
}

/* ---- raw ---------------------------------------------------------------------------------- */

static btg_contact contact_at(const btg_backend_setup *setup, btg_place place, uint32_t element,
                              btg_placement tool) {
    btg_surface_point s;
    btg_part_point(setup->part, place, &s);
    btg_ray_distance d = btg_ray_tool_distance(&setup->tool.element[element], tool, s.s);
    return (btg_contact){place, s.s, vec_scale(d.normal, -1)};
}

void btg_gpu_raw_drop(const btg_backend_setup *setup, const btg_drop_query *query,
                      const btg_gpu_winner *winner, double shift, btg_drop_result *result) {
    btg_drop_result r = {.status = BTG_NO_CONTACT, .bound_mm = NAN, .nodes = winner->cells};
    btg_place at;
    if (btg_gpu_start(setup, winner, &at)) {
        btg_ray_query q = btg_ray_query_drop(&setup->tool, query);
        r.status = BTG_OK;
        r.height_mm = winner->value + shift;
        r.element = winner->element;
        r.contact = contact_at(setup, at, r.element, btg_ray_place(&q, r.height_mm));
    }
    *result = r;
}

/* The limits at P that the tool and P's own sheet set. */
static double limit_at_p(const btg_backend_setup *setup, const btg_ray_query *q, btg_place p) {
    double limit = -INFINITY, value, near = ON_EDGE * sqrt(q->p_clearance2);
    if (btg_ray_tool_limit(q, &value)) limit = value;
    btg_surface_point s;
    btg_part_point(setup->part, p, &s);
    bool triangle = p.item >= setup->part->patch_count;
    double tu = near / (vec_norm(s.su) + near), tv = near / (vec_norm(s.sv) + near);
    bool edge_u = p.u < tu || (!triangle && p.u > 1 - tu);
    bool edge_v = p.v < tv || (!triangle && p.v > 1 - tv);
    if (btg_ray_osculating(q, &s, edge_u, edge_v, &value)) limit = max2(limit, value);
    return limit;
}

void btg_gpu_raw_tilt(const btg_backend_setup *setup, const btg_tilt_query *query,
                      const btg_gpu_winner *winner, btg_tilt_result *result) {
    btg_ray_query q = btg_ray_query_tilt(&setup->tool, query);
    btg_tilt_result r = {.status = BTG_SINGLE_CONTACT, .tilt_rad = query->max_tilt_rad};
    r.bound_mm = NAN;
    r.nodes = winner->cells;
    double best = -query->max_tilt_rad, limit = limit_at_p(setup, &q, query->p.place);
    btg_place at;
    if (btg_gpu_start(setup, winner, &at) && winner->value > best) {
        best = winner->value;
        r.status = BTG_OK;
        r.element = winner->element;
        r.contact = contact_at(setup, at, r.element, btg_ray_place(&q, best));
    }
    if (limit > best) {
        best = limit;
        r.status = BTG_OSCULATING;
        r.element = 0;
        r.contact = query->p;
    }
    if (r.status != BTG_SINGLE_CONTACT) r.tilt_rad = best < 0 ? -best : 0;
    *result = r;
}
