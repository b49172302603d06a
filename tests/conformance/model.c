#include "model.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void *grab(model *m, size_t count, size_t size) {
    void *p = m->block_count < MODEL_BLOCKS_MAX ? calloc(count, size) : NULL;
    if (!p) {
        fprintf(stderr, "model: out of memory\n");
        exit(2);
    }
    m->block[m->block_count++] = p;
    return p;
}

void model_free(model *m) {
    for (size_t i = 0; i < m->block_count; i++)
        free(m->block[i]);
    free(m->positions);
    free(m->indices);
    *m = (model){0};
}

static double *even_knots(model *m, int degree, int count) {
    double *k = grab(m, (size_t)(count + degree + 1), sizeof *k);
    int spans = count - degree;
    for (int i = 0; i < count + degree + 1; i++)
        k[i] = i <= degree ? 0 : i >= count ? 1 : (double)(i - degree) / spans;
    return k;
}

static model_surface add_surface(model *m, btg_surface_def def, bool rational) {
    size_t n = (size_t)(def.count_u * def.count_v);
    model_surface s = {.points = grab(m, 3 * n, sizeof(double))};
    if (rational) {
        s.weights = grab(m, n, sizeof(double));
        for (size_t i = 0; i < n; i++)
            s.weights[i] = 1;
    }
    def.control_points = s.points;
    def.weights = s.weights;
    if (m->surface_count >= MODEL_SURFACES_MAX) abort();
    m->surface[m->surface_count++] = def;
    return s;
}

model_surface model_bezier(model *m, int degree_u, int degree_v, bool rational) {
    btg_surface_def def = {.degree_u = degree_u,
                           .degree_v = degree_v,
                           .count_u = degree_u + 1,
                           .count_v = degree_v + 1};
    return add_surface(m, def, rational);
}

model_surface model_spline(model *m, int degree_u, int degree_v, int count_u, int count_v,
                           bool rational) {
    double *ku = even_knots(m, degree_u, count_u), *kv = even_knots(m, degree_v, count_v);
    btg_surface_def def = {.degree_u = degree_u,
                           .degree_v = degree_v,
                           .count_u = count_u,
                           .count_v = count_v,
                           .knots_u = ku,
                           .knots_v = kv};
    model_surface s = add_surface(m, def, rational);
    s.knots_u = ku;
    s.knots_v = kv;
    return s;
}

static void put(double *at, btg_vec3 p) {
    at[0] = p.x;
    at[1] = p.y;
    at[2] = p.z;
}

void model_quad(model *m, btg_vec3 p00, btg_vec3 p01, btg_vec3 p10, btg_vec3 p11) {
    model_surface s = model_bezier(m, 1, 1, false);
    put(s.points, p00);
    put(s.points + 3, p01);
    put(s.points + 6, p10);
    put(s.points + 9, p11);
}

const char *const model_paper_name[MODEL_PAPERS] = {"convex", "concave", "saddle"};

void model_paper(model *m, int number) {
    static const double z[MODEL_PAPERS][16] = {
        {80, 90, 90, 80, 90, 105, 105, 90, 90, 105, 105, 90, 80, 90, 90, 80},
        {80, 70, 70, 80, 70, 55, 55, 70, 70, 55, 55, 70, 80, 70, 70, 80},
        {80, 65, 90, 85, 80, 85, 90, 95, 100, 105, 95, 100, 90, 100, 100, 85}};
    model_surface s = model_bezier(m, 3, 3, false);
    for (int i = 0; i < 16; i++) {
        s.points[3 * i] = 50 * (i / 4);
        s.points[3 * i + 1] = 50 * (i % 4);
        s.points[3 * i + 2] = z[number][i];
    }
}

void model_triangle(model *m, btg_vec3 a, btg_vec3 b, btg_vec3 c) {
    if (m->triangle_count == m->triangle_capacity) {
        m->triangle_capacity = 2 * m->triangle_capacity + 64;
        m->positions = realloc(m->positions, m->triangle_capacity * 9 * sizeof(double));
        m->indices = realloc(m->indices, m->triangle_capacity * 3 * sizeof(uint32_t));
        if (!m->positions || !m->indices) abort();
    }
    size_t n = m->triangle_count++;
    put(m->positions + 9 * n, a);
    put(m->positions + 9 * n + 3, b);
    put(m->positions + 9 * n + 6, c);
    for (size_t i = 0; i < 3; i++)
        m->indices[3 * n + i] = (uint32_t)(3 * n + i);
}

void model_revolve(model *m, btg_vec3 centre, const double (*profile)[3], int count) {
    /* a quarter turn: (1,0), (1,1) of weight 1/sqrt 2, (0,1) */
    const double arc[3][3] = {{1, 0, 1}, {1, 1, 0.70710678118654752440}, {0, 1, 1}};
    for (int quarter = 0; quarter < 4; quarter++) {
        double c = quarter == 0 ? 1 : quarter == 2 ? -1 : 0;
        double s = quarter == 1 ? 1 : quarter == 3 ? -1 : 0;
        model_surface f = model_bezier(m, count - 1, 2, true);
        for (int i = 0; i < count; i++)
            for (int j = 0; j < 3; j++) {
                double r = profile[i][0], x = arc[j][0] * r, y = arc[j][1] * r;
                put(f.points + 3 * (3 * i + j),
                    vec(centre.x + c * x - s * y, centre.y + s * x + c * y,
                        centre.z + profile[i][1]));
                f.weights[3 * i + j] = profile[i][2] * arc[j][2];
            }
    }
}

btg_vec3 motion_vector(const motion *t, btg_vec3 v) {
    double c = cos(t->angle), s = sin(t->angle), x = t->mirror ? -v.x : v.x;
    return vec(c * x - s * v.y, s * x + c * v.y, v.z);
}

btg_vec3 motion_point(const motion *t, btg_vec3 p) {
    return vec_mad(t->shift, motion_vector(t, p), t->scale);
}

static void move_array(double *p, size_t count, const motion *t) {
    for (size_t i = 0; i < count; i++)
        put(p + 3 * i, motion_point(t, vec(p[3 * i], p[3 * i + 1], p[3 * i + 2])));
}

void model_move(model *m, const motion *t) {
    for (size_t i = 0; i < m->surface_count; i++) {
        btg_surface_def *d = &m->surface[i];
        size_t n = (size_t)(d->count_u * d->count_v);
        double *p = grab(m, 3 * n, sizeof *p);
        memcpy(p, d->control_points, 3 * n * sizeof *p);
        move_array(p, n, t);
        d->control_points = p;
    }
    move_array(m->positions, 3 * m->triangle_count, t);
}

static const double *clone(model *m, const double *from, int count) {
    if (!from) return NULL;
    double *p = grab(m, (size_t)count, sizeof *p);
    memcpy(p, from, (size_t)count * sizeof *p);
    return p;
}

model model_copy(const model *from) {
    model m = {.surface_count = from->surface_count};
    for (size_t i = 0; i < from->surface_count; i++) {
        btg_surface_def d = from->surface[i];
        int n = d.count_u * d.count_v;
        d.control_points = clone(&m, d.control_points, 3 * n);
        d.weights = clone(&m, d.weights, n);
        d.knots_u = clone(&m, d.knots_u, d.count_u + d.degree_u + 1);
        d.knots_v = clone(&m, d.knots_v, d.count_v + d.degree_v + 1);
        m.surface[i] = d;
    }
    for (size_t i = 0; i < from->triangle_count; i++) {
        const double *p = from->positions + 9 * i;
        model_triangle(&m, vec(p[0], p[1], p[2]), vec(p[3], p[4], p[5]), vec(p[6], p[7], p[8]));
    }
    return m;
}

btg_part *model_part(const model *m) {
    btg_part_def def = btg_part_def_default();
    btg_mesh_def mesh = {m->positions, 3 * m->triangle_count, m->indices, m->triangle_count};
    def.surfaces = m->surface;
    def.surface_count = m->surface_count;
    def.meshes = &mesh;
    def.mesh_count = m->triangle_count > 0;
    btg_part *part = NULL;
    btg_message message;
    if (btg_part_create(&def, &part, &message) == BTG_OK) return part;
    fprintf(stderr, "model: %s\n", message.text);
    exit(2);
}

static void print_array(const char *name, const double *p, size_t count) {
    if (!p) return;
    printf("      %s", name);
    for (size_t i = 0; i < count; i++)
        printf(" %a", p[i]);
    printf("\n");
}

void model_print(const model *m) {
    for (size_t i = 0; i < m->surface_count; i++) {
        const btg_surface_def *d = &m->surface[i];
        size_t n = (size_t)(d->count_u * d->count_v);
        printf("    surface %zu: degrees %d %d, counts %d %d\n", i, d->degree_u, d->degree_v,
               d->count_u, d->count_v);
        print_array("points", d->control_points, 3 * n);
        print_array("weights", d->weights, n);
        print_array("knots u", d->knots_u, (size_t)(d->count_u + d->degree_u + 1));
        print_array("knots v", d->knots_v, (size_t)(d->count_v + d->degree_v + 1));
    }
    if (m->triangle_count > 0) printf("    %zu triangles\n", m->triangle_count);
    if (m->triangle_count <= 16) print_array("corners", m->positions, 9 * m->triangle_count);
}
