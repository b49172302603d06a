/* The field of a verification as a model: the part's upper side, coloured by what is left. */
#include "core/part.h"
#include "io/glb.h"
#include "io/map.h"

#include <math.h>
#include <stdlib.h>

#define GRID_MAX 1000 /* vertices along a side of the model */

typedef struct model {
    const btg_verify_map *map;
    uint32_t stride, width, height; /* cells a vertex, vertices along x and y */
    uint32_t *number;               /* of each vertex; UINT32_MAX: none */
    uint32_t vertices, triangles;
    float *points;
    unsigned char *colours;
    uint32_t *indices;
} model;

/* The cell that stands for a vertex: where part is, the one farthest off among its stride^2. */
static bool worst(const model *m, uint32_t column, uint32_t row, size_t *cell) {
    double most = -1;
    for (uint32_t j = 0; j < m->stride; j++)
        for (uint32_t i = 0; i < m->stride; i++) {
            uint32_t x = column * m->stride + i, y = row * m->stride + j;
            if (x >= m->map->width || y >= m->map->height) continue;
            size_t at = (size_t)y * m->map->width + x;
            double d = fabs(btg_verify_deviation(m->map, at));
            if (!(d > most)) continue;
            most = d;
            *cell = at;
        }
    return most >= 0;
}

static void add_vertex(model *m, size_t cell, const btg_map_scale *scale) {
    float rgb[3], *p = m->points + 3 * (size_t)m->vertices;
    unsigned char *colour = m->colours + 4 * (size_t)m->vertices;
    p[0] = (float)(m->map->x_mm + (double)(cell % m->map->width) * m->map->cell_mm);
    p[1] = (float)(m->map->y_mm + (double)(cell / m->map->width) * m->map->cell_mm);
    p[2] = (float)m->map->part_z_mm[cell];
    btg_map_colour(scale, btg_verify_deviation(m->map, cell), rgb);
    for (int c = 0; c < 3; c++)
        colour[c] = (unsigned char)(255 * btg_glb_linear(rgb[c]) + 0.5f);
    colour[3] = 255;
    m->vertices++;
}

static uint32_t vertex(const model *m, uint32_t column, uint32_t row) {
    return m->number[(size_t)row * m->width + column];
}

static bool square(const model *m, uint32_t i, uint32_t j, uint32_t corner[4]) {
    corner[0] = vertex(m, i, j);
    corner[1] = vertex(m, i + 1, j);
    corner[2] = vertex(m, i + 1, j + 1);
    corner[3] = vertex(m, i, j + 1);
    for (int k = 0; k < 4; k++)
        if (corner[k] == UINT32_MAX) return false;
    return true;
}

static void fill(model *m, const btg_map_scale *scale) {
    static const int order[6] = {0, 1, 2, 0, 2, 3};
    uint32_t corner[4];
    for (uint32_t j = 0; j < m->height; j++)
        for (uint32_t i = 0; i < m->width; i++) {
            size_t cell = 0;
            bool some = worst(m, i, j, &cell);
            m->number[(size_t)j * m->width + i] = some ? m->vertices : UINT32_MAX;
            if (some) add_vertex(m, cell, scale);
        }
    for (uint32_t j = 0; j + 1 < m->height; j++)
        for (uint32_t i = 0; i + 1 < m->width; i++) {
            if (!square(m, i, j, corner)) continue;
            for (int k = 0; k < 6; k++)
                m->indices[3 * (size_t)m->triangles + (size_t)k] = corner[order[k]];
            m->triangles += 2;
        }
}

static bool open_model(model *m, const btg_verify_map *map) {
    uint32_t longest = map->width > map->height ? map->width : map->height;
    *m = (model){.map = map, .stride = (longest + GRID_MAX - 1) / GRID_MAX};
    m->width = (map->width + m->stride - 1) / m->stride;
    m->height = (map->height + m->stride - 1) / m->stride;
    size_t size = (size_t)m->width * m->height;
    m->number = malloc(size * sizeof *m->number);
    m->points = malloc(size * 3 * sizeof *m->points);
    m->colours = malloc(size * 4);
    m->indices = malloc(size * 6 * sizeof *m->indices);
    return m->number && m->points && m->colours && m->indices;
}

static void close_model(model *m) {
    free(m->number);
    free(m->points);
    free(m->colours);
    free(m->indices);
}

static btg_status write_model(const model *m, const char *title, btg_output *output,
                              btg_message *message) {
    btg_glb *g = malloc(sizeof *g);
    if (!g) return btg_fail(message, BTG_ERROR_MEMORY, "model: out of memory");
    *g = btg_glb_begin(title);
    btg_glb_material material = {.name = "deviation", .rgb = {1, 1, 1}, .roughness = 0.9f};
    btg_glb_mesh mesh = {.name = "part", .normals = BTG_GLB_NONE, .mode = BTG_GLB_TRIANGLES};
    mesh.material = btg_glb_add_material(g, material);
    mesh.points = btg_glb_floats(g, m->points, m->vertices, 3, BTG_GLB_PLACE, true);
    mesh.colours = btg_glb_colours(g, m->colours, m->vertices);
    mesh.indices = btg_glb_indices(g, m->indices, 3 * (size_t)m->triangles);
    btg_glb_node node = {.name = "part", .parent = BTG_GLB_NONE};
    node.mesh = btg_glb_add_mesh(g, mesh);
    btg_glb_add_node(g, node);
    btg_status status = btg_glb_write(g, output, message);
    btg_glb_release(g);
    free(g);
    return status;
}

btg_status btg_map_glb(const btg_verify_map *map, const btg_map_scale *scale, const char *title,
                       btg_output *output, btg_message *message) {
    model m;
    btg_status status = BTG_OK;
    if (!open_model(&m, map)) {
        status = btg_fail(message, BTG_ERROR_MEMORY, "model: out of memory");
    } else {
        fill(&m, scale);
        status = m.triangles > 0
                     ? write_model(&m, title, output, message)
                     : btg_fail(message, BTG_ERROR_ARGUMENT,
                                "model: the part shows no face to the tool; give a smaller --grid");
    }
    close_model(&m);
    return status;
}
