/* Cutting patches and triangles into cells. */
#include "backend/device/scene.h"
#include "core/part.h"

#include <string.h>

/* Cells a side of one item at the most. */
#define SIDE_MAX 256
/* Points a side that a patch's lengths are taken from. */
#define PROBES 9
/* Samples a side of a cell. */
#define SAMPLES_MIN 2
#define SAMPLES_MAX 10
/* A ball through nine points of a cell is that much wider, for what bulges between them. */
#define BULGE 1.02

float btg_gpu_bits(uint32_t bits) {
    float f;
    memcpy(&f, &bits, sizeof f);
    return f;
}

void btg_gpu_split(btg_vec3 p, btg_gpu_vec4 *high, btg_gpu_vec4 *low) {
    high->x = (float)p.x;
    high->y = (float)p.y;
    high->z = (float)p.z;
    low->x = (float)(p.x - high->x);
    low->y = (float)(p.y - high->y);
    low->z = (float)(p.z - high->z);
}

static btg_vec3 point_at(const btg_part *part, uint32_t item, double u, double v) {
    btg_surface_point s;
    btg_part_point(part, (btg_place){item, u, v}, &s);
    return s.s;
}

/* The longest of the lines of one parameter. */
static void lengths(const btg_part *part, uint32_t item, double *along_u, double *along_v) {
    *along_u = *along_v = 0;
    for (int i = 0; i < PROBES; i++) {
        double u_length = 0, v_length = 0, fixed = i / (PROBES - 1.0);
        for (int k = 1; k < PROBES; k++) {
            double a = (k - 1) / (PROBES - 1.0), b = k / (PROBES - 1.0);
            u_length +=
                vec_norm(vec_sub(point_at(part, item, b, fixed), point_at(part, item, a, fixed)));
            v_length +=
                vec_norm(vec_sub(point_at(part, item, fixed, b), point_at(part, item, fixed, a)));
        }
        *along_u = max2(*along_u, u_length);
        *along_v = max2(*along_v, v_length);
    }
}

static uint32_t cuts(double length, double side) {
    double n = ceil(length / side);
    return n > SIDE_MAX ? SIDE_MAX : (n < 1 ? 1 : (uint32_t)n);
}

/* The piece about the cell's centre, at (s, t). */
static btg_vec3 taylor(const btg_surface_point *c, double s, double t) {
    btg_vec3 p = vec_mad(vec_mad(c->s, c->su, s), c->sv, t);
    return vec_mad(vec_mad(vec_mad(p, c->suu, 0.5 * s * s), c->suv, s * t), c->svv, 0.5 * t * t);
}

/* Derivatives in units of half a cell. */
static void scale(btg_surface_point *c, double hu, double hv) {
    c->su = vec_scale(c->su, hu);
    c->sv = vec_scale(c->sv, hv);
    c->suu = vec_scale(c->suu, hu * hu);
    c->suv = vec_scale(c->suv, hu * hv);
    c->svv = vec_scale(c->svv, hv * hv);
}

/* How far quadratic pieces stand off the patch at their corners, over some of the cells. */
static double residual(const btg_part *part, uint32_t item, uint32_t nu, uint32_t nv) {
    double most = 0, hu = 0.5 / nu, hv = 0.5 / nv;
    uint32_t step_u = 1 + nu / 16, step_v = 1 + nv / 16;
    for (uint32_t i = 0; i < nu; i += step_u)
        for (uint32_t j = 0; j < nv; j += step_v) {
            double u = (2 * i + 1) * hu, v = (2 * j + 1) * hv;
            btg_surface_point c;
            btg_part_point(part, (btg_place){item, u, v}, &c);
            scale(&c, hu, hv);
            for (int k = 0; k < 4; k++) {
                double s = k & 1 ? 1 : -1, t = k & 2 ? 1 : -1;
                btg_vec3 p = point_at(part, item, u + s * hu, v + t * hv);
                most = max2(most, vec_norm(vec_sub(p, taylor(&c, s, t))));
            }
        }
    return most;
}

void btg_cells_count(const btg_part *part, uint32_t item, const btg_cell_size *size, uint32_t *nu,
                     uint32_t *nv) {
    if (item >= part->patch_count) {
        btg_vec3 c[3];
        btg_triangle_corners(part, item - part->patch_count, c);
        double a = vec_norm(vec_sub(c[1], c[0])), b = vec_norm(vec_sub(c[2], c[0]));
        *nu = *nv = cuts(max2(max2(a, b), vec_norm(vec_sub(c[2], c[1]))), size->side);
        return;
    }
    double along_u, along_v;
    lengths(part, item, &along_u, &along_v);
    *nu = cuts(along_u, size->side);
    *nv = cuts(along_v, size->side);
    while ((*nu < SIDE_MAX || *nv < SIDE_MAX) && residual(part, item, *nu, *nv) > size->residual) {
        *nu = *nu > SIDE_MAX / 2 ? SIDE_MAX : 2 * *nu;
        *nv = *nv > SIDE_MAX / 2 ? SIDE_MAX : 2 * *nv;
    }
}

static void put(btg_gpu_vec4 *to, btg_vec3 xyz, float w) {
    *to = (btg_gpu_vec4){(float)xyz.x, (float)xyz.y, (float)xyz.z, w};
}

static uint32_t samples(double length, double pitch) {
    double n = ceil(length / pitch) + 1;
    return n > SAMPLES_MAX ? SAMPLES_MAX : (n < SAMPLES_MIN ? SAMPLES_MIN : (uint32_t)n);
}

btg_vec3 btg_cells_fill(const btg_part *part, uint32_t item, uint32_t nu, uint32_t nv, uint32_t i,
                        uint32_t j, const btg_cell_size *size, btg_vec3 middle,
                        btg_gpu_vec4 cell[BTG_GPU_CELL]) {
    double hu = 0.5 / nu, hv = 0.5 / nv, u = (2 * i + 1) * hu, v = (2 * j + 1) * hv, far = 0;
    bool triangle = item >= part->patch_count;
    btg_surface_point c;
    btg_part_point(part, (btg_place){item, u, v}, &c);
    for (int k = 0; k < 9; k++) {
        double pu = u + (k % 3 - 1) * hu, pv = v + (double)(k / 3 - 1) * hv;
        if (triangle && pu + pv > 1) {
            double over = 0.5 * (pu + pv - 1);
            pu -= over;
            pv -= over;
        }
        far = max2(far, vec_norm(vec_sub(point_at(part, item, pu, pv), c.s)));
    }
    scale(&c, hu, hv);
    double length = 2 * max2(vec_norm(c.su), vec_norm(c.sv));
    btg_gpu_split(vec_sub(c.s, middle), &cell[0], &cell[1]);
    /* A ball's centre is its high part alone. */
    cell[0].w = (float)(BULGE * far) + fabsf(cell[1].x) + fabsf(cell[1].y) + fabsf(cell[1].z);
    cell[1].w = btg_gpu_bits(item);
    put(&cell[2], c.su, (float)u);
    put(&cell[3], c.sv, (float)v);
    put(&cell[4], c.suu, (float)hu);
    put(&cell[5], c.suv, (float)hv);
    put(&cell[6], c.svv, btg_gpu_bits(samples(length, size->pitch)));
    return vec_sub(c.s, middle);
}
