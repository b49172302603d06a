/* A part under construction: surfaces and triangles that can be moved before they are made. */
#ifndef BTG_TESTS_MODEL_H
#define BTG_TESTS_MODEL_H

#include "core/vec.h"

#define MODEL_SURFACES_MAX 64
#define MODEL_BLOCKS_MAX   512

typedef struct model {
    btg_surface_def surface[MODEL_SURFACES_MAX];
    size_t surface_count;
    double *positions; /* three corners a triangle, not shared */
    uint32_t *indices;
    size_t triangle_count, triangle_capacity;
    void *block[MODEL_BLOCKS_MAX]; /* memory the surfaces use */
    size_t block_count;
} model;

void model_free(model *m);

/* A surface with room for its points (and weights, all 1; and knots). Fill in through the
 * returned pointers; they stay valid until model_free. */
typedef struct model_surface {
    double *points, *weights, *knots_u, *knots_v;
} model_surface;

model_surface model_bezier(model *m, int degree_u, int degree_v, bool rational);
model_surface model_spline(model *m, int degree_u, int degree_v, int count_u, int count_v,
                           bool rational);

/* A bilinear patch: corners (0,0), (0,1), (1,0), (1,1). */
void model_quad(model *m, btg_vec3 p00, btg_vec3 p01, btg_vec3 p10, btg_vec3 p11);
void model_triangle(model *m, btg_vec3 a, btg_vec3 b, btg_vec3 c);

/* The papers' parts, bicubic patches of 150 mm x 150 mm: 0 convex, 1 concave, 2 saddle. */
#define MODEL_PAPERS 3
extern const char *const model_paper_name[MODEL_PAPERS];
void model_paper(model *m, int number);

/* A profile of `count` points (radius, height, weight: a Bezier curve) turned about the vertical
 * through `centre`: four rational patches. */
void model_revolve(model *m, btg_vec3 centre, const double (*profile)[3], int count);

/* p -> scale * Rz(angle) * mirror(x) * p + shift */
typedef struct motion {
    double angle, scale;
    bool mirror;
    btg_vec3 shift;
} motion;

btg_vec3 motion_vector(const motion *t, btg_vec3 v); /* direction, not scaled */
btg_vec3 motion_point(const motion *t, btg_vec3 p);
void model_move(model *m, const motion *t);
model model_copy(const model *m);

btg_part *model_part(const model *m);
void model_print(const model *m);

#endif
