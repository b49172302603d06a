/* Writes glTF 2.0 binaries (.glb). Internal to the program.
 *
 * Things are added in any order and named by the number they get; btg_glb_write puts them down.
 * Vectors go in as the part frame's (mm, z up) and come out as glTF's (metres, y up). What is short
 * of memory, or too much of something, latches and is told by btg_glb_write. */
#ifndef BTG_IO_GLB_H
#define BTG_IO_GLB_H

#include "io/output.h"

#define BTG_GLB_ITEMS 64 /* of each kind; views and accessors twice that */
#define BTG_GLB_NONE  (-1)

typedef enum btg_glb_mode { BTG_GLB_LINES = 1, BTG_GLB_TRIANGLES = 4 } btg_glb_mode;

/* What a vector is: a place, converted and scaled; a direction, converted alone; neither. */
typedef enum btg_glb_frame { BTG_GLB_PLACE, BTG_GLB_DIRECTION, BTG_GLB_AS_IT_IS } btg_glb_frame;

typedef struct btg_glb_accessor {
    size_t offset, count;
    int width;     /* components */
    int component; /* glTF's number: 5121 normalized bytes, 5125, 5126 */
    int target;    /* of the buffer view: 34962, 34963, or 0 */
    bool bounds;
    float low[4], high[4];
} btg_glb_accessor;

typedef struct btg_glb_mesh {
    const char *name; /* static */
    int points, normals, colours, indices, material;
    btg_glb_mode mode;
} btg_glb_mesh;

typedef struct btg_glb_node {
    const char *name;
    int mesh, parent; /* NONE */
    float translation[3], rotation[4];
    bool placed; /* translation and rotation count */
} btg_glb_node;

typedef struct btg_glb_material {
    const char *name;
    float rgb[3]; /* as on a screen (sRGB); written as glTF wants it, linear */
    float metallic, roughness;
    bool unlit; /* lines */
} btg_glb_material;

typedef struct btg_glb {
    const char *title; /* of the scene; UTF-8 is mended */
    char *data;
    size_t size, capacity;
    btg_glb_accessor accessor[2 * BTG_GLB_ITEMS];
    btg_glb_mesh mesh[BTG_GLB_ITEMS];
    btg_glb_node node[BTG_GLB_ITEMS];
    btg_glb_material material[BTG_GLB_ITEMS];
    int accessors, meshes, nodes, materials;
    int animated, times, translations, rotations; /* a node's animation; animated NONE */
    bool short_of_memory;
} btg_glb;

btg_glb btg_glb_begin(const char *title);
/* `count` vectors of `width` (1, 3 or 4) floats. Bounds are for positions and times. */
int btg_glb_floats(btg_glb *glb, const float *values, size_t count, int width, btg_glb_frame frame,
                   bool bounds);
/* 4 bytes each, linear light. */
int btg_glb_colours(btg_glb *glb, const unsigned char *rgba, size_t count);
int btg_glb_indices(btg_glb *glb, const uint32_t *indices, size_t count);
int btg_glb_add_material(btg_glb *glb, btg_glb_material material);
int btg_glb_add_mesh(btg_glb *glb, btg_glb_mesh mesh);
int btg_glb_add_node(btg_glb *glb, btg_glb_node node);
/* Rotations are quaternions x, y, z, w; times are seconds, increasing. */
void btg_glb_animate(btg_glb *glb, int node, const float *times, const float *translations,
                     const float *rotations, size_t count);

/* From sRGB to linear light, 0 .. 1. */
float btg_glb_linear(float value);

btg_status btg_glb_write(const btg_glb *glb, btg_output *output, btg_message *message);
void btg_glb_release(btg_glb *glb);

#endif
