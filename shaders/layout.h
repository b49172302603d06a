/* The device's buffers as C and GLSL both see them. Internal.
 *
 * Everything is made of vec4 and uvec4, which both lay out alike in any buffer; src/backend/device
 * checks the sizes. Coordinates are millimetres in single precision; where a difference of two of
 * them must keep its digits, each comes as a high and a low part about the middle of the part. */
#ifndef BTG_SHADERS_LAYOUT_H
#define BTG_SHADERS_LAYOUT_H

#ifdef GL_core_profile
#define BTG_GPU_STRUCT(name) struct name
#define BTG_GPU_VEC4         vec4
#define BTG_GPU_UVEC4        uvec4
#define BTG_GPU_FLOAT        float
#define BTG_GPU_UINT         uint
#else
#include <stdint.h>
typedef struct btg_gpu_vec4 {
    float x, y, z, w;
} btg_gpu_vec4;
typedef struct btg_gpu_uvec4 {
    uint32_t x, y, z, w;
} btg_gpu_uvec4;
#define BTG_GPU_STRUCT(name)                                                                       \
    typedef struct name name;                                                                      \
    struct name
#define BTG_GPU_VEC4  btg_gpu_vec4
#define BTG_GPU_UVEC4 btg_gpu_uvec4
#define BTG_GPU_FLOAT float
#define BTG_GPU_UINT  uint32_t
#endif

#define BTG_GPU_SCENE    0 /* bindings */
#define BTG_GPU_GEOMETRY 1
#define BTG_GPU_QUERIES  2
#define BTG_GPU_WINNERS  3
#define BTG_GPU_BINDINGS 4

/* Invocations a workgroup: some subgroups, for a wide device; where subgroups are narrow, as on a
 * processor, more would only wait for each other. */
#define BTG_GPU_GROUP_WIDE   64
#define BTG_GPU_GROUP_NARROW 16

#define BTG_GPU_ELEMENTS 10 /* cutter, shank, holder's cylinders */
#define BTG_GPU_LEVELS   16 /* of the tree */
#define BTG_GPU_FAN      8  /* children a node */
#define BTG_GPU_CELL     7  /* vec4s a cell */
#define BTG_GPU_PATCH    2  /* vec4s a patch, before its coefficients */

/* Part and tool. Level 0 of the tree are the cells' balls; node i of a level has the children
 * FAN i .. FAN i + FAN - 1 of the level below. */
BTG_GPU_STRUCT(btg_gpu_scene) {
    BTG_GPU_UVEC4 counts; /* patches, levels, tool elements, 1: the cutter is hollow */
    BTG_GPU_UVEC4 starts; /* in geometry: of cells, of patches; times the winner is followed */
    BTG_GPU_UVEC4 level[BTG_GPU_LEVELS];    /* start in geometry, nodes */
    BTG_GPU_VEC4 element[BTG_GPU_ELEMENTS]; /* ring radius, corner radius, from, to */
};

/* Geometry is one array of vec4. A ball: centre, radius. A cell, the piece
 *     centre + a s + b t + (uu s^2 + 2 uv s t + vv t^2) / 2,    |s|, |t| <= 1,
 * of a patch, about, or of a triangle, exactly:
 *     0  centre, radius      1  low part of centre, item as bits
 *     2  a, u of centre      3  b, v of centre      4  uu, half side in u
 *     5  uv, half side in v  6  vv, samples a side as bits
 * A patch: origin, index of its first coefficient as bits; low part of origin, and as bits
 * degree_u + 16 degree_v + 256 if rational. Its coefficients are the power form of the core. */

BTG_GPU_STRUCT(btg_gpu_query) {
    BTG_GPU_VEC4 u, v, w; /* the frame; u.w: the value to beat; v.w, w.w, n.w: low part of p */
    BTG_GPU_VEC4 origin;  /* of the frame, high part */
    BTG_GPU_VEC4 origin_low;
    BTG_GPU_VEC4 p; /* TILT: first contact from origin; squared radius left out about it */
    BTG_GPU_VEC4 n; /* TILT: its normal */
};

/* The best place of one query: what comes back. */
BTG_GPU_STRUCT(btg_gpu_winner) {
    BTG_GPU_FLOAT value; /* as in core/ray.h, from the frame's origin */
    BTG_GPU_FLOAT u, v;
    BTG_GPU_UINT item;
    BTG_GPU_UINT element;
    BTG_GPU_UINT found; /* 0: no ray meets the tool */
    BTG_GPU_UINT cells; /* tried */
    BTG_GPU_UINT full;  /* 1: the stack was too small; better places may have been missed */
};

#endif
