#include "io/map.h"
#include "core/part.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define GRID_MAX 1000 /* vertices along a side of the model */

/* ---- colours ------------------------------------------------------------------------------ */

/* Dark is far off; told apart with any colour vision, and gouged from left by hue. */
static const float left_ramp[4][3] = {
    {0.74f, 0.86f, 0.93f}, {0.42f, 0.68f, 0.84f}, {0.13f, 0.44f, 0.71f}, {0.03f, 0.19f, 0.42f}};
static const float gouge_ramp[4][3] = {
    {0.99f, 0.80f, 0.60f}, {0.99f, 0.55f, 0.24f}, {0.85f, 0.28f, 0.05f}, {0.50f, 0.09f, 0.02f}};
static const float finished[3] = {0.88f, 0.90f, 0.82f};

void btg_map_colour(const btg_map_scale *scale, double deviation, float rgb[3]) {
    double limit = deviation < 0 ? scale->gouge_mm : scale->scallop_mm;
    double excess = fabs(deviation) / (limit > 0 ? limit : 1e-6);
    const float(*ramp)[3] = deviation < 0 ? gouge_ramp : left_ramp;
    if (!(excess > 1)) {
        memcpy(rgb, finished, sizeof finished);
        return;
    }
    double at = fmin(log10(excess), 3);
    int i = at < 3 ? (int)at : 2;
    float f = (float)(at - i);
    for (int c = 0; c < 3; c++)
        rgb[c] = ramp[i][c] + f * (ramp[i + 1][c] - ramp[i][c]);
}

/* ---- CSV ---------------------------------------------------------------------------------- */

btg_status btg_map_csv(const btg_verify_map *map, btg_output *output, btg_message *message) {
    size_t size = (size_t)map->width * map->height;
    btg_output_text(output, "x,y,part_z,stock_z,deviation\n");
    for (size_t i = 0; i < size && output->error == 0; i++) {
        double d = btg_verify_deviation(map, i);
        if (isnan(d)) continue;
        btg_output_format(output, "%.9g,%.9g,%.9f,%.9f,%.9f\n",
                          map->x_mm + (double)(i % map->width) * map->cell_mm,
                          map->y_mm + (double)(i / map->width) * map->cell_mm, map->part_z_mm[i],
                          map->stock_z_mm[i], d);
    }
    return btg_output_check(output, message);
}

/* ---- GLB ---------------------------------------------------------------------------------- */

typedef struct model {
    const btg_verify_map *map;
    uint32_t stride, width, height; /* cells a vertex, vertices along x and y */
    uint32_t *number;               /* of each vertex; UINT32_MAX: none */
    uint32_t vertices, triangles;
    float low[3], high[3];
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

static void point_of(const model *m, size_t cell, float p[3]) {
    double x = m->map->x_mm + (double)(cell % m->map->width) * m->map->cell_mm;
    double y = m->map->y_mm + (double)(cell / m->map->width) * m->map->cell_mm;
    p[0] = (float)(x / 1000);
    p[1] = (float)(m->map->part_z_mm[cell] / 1000);
    p[2] = (float)(-y / 1000);
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

static void count(model *m) {
    uint32_t corner[4];
    for (int c = 0; c < 3; c++)
        m->low[c] = INFINITY, m->high[c] = -INFINITY;
    for (uint32_t j = 0; j < m->height; j++)
        for (uint32_t i = 0; i < m->width; i++) {
            size_t cell = 0;
            float p[3];
            bool some = worst(m, i, j, &cell);
            m->number[(size_t)j * m->width + i] = some ? m->vertices++ : UINT32_MAX;
            if (!some) continue;
            point_of(m, cell, p);
            for (int c = 0; c < 3; c++) {
                m->low[c] = fminf(m->low[c], p[c]);
                m->high[c] = fmaxf(m->high[c], p[c]);
            }
        }
    for (uint32_t j = 0; j + 1 < m->height; j++)
        for (uint32_t i = 0; i + 1 < m->width; i++)
            if (square(m, i, j, corner)) m->triangles += 2;
}

static void put32(btg_output *o, uint32_t value) {
    const unsigned char b[4] = {(unsigned char)value, (unsigned char)(value >> 8),
                                (unsigned char)(value >> 16), (unsigned char)(value >> 24)};
    btg_output_write(o, (const char *)b, 4);
}

static void put_float(btg_output *o, float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    put32(o, bits);
}

static void put_vertices(const model *m, btg_output *o, const btg_map_scale *scale, bool colours) {
    for (uint32_t j = 0; j < m->height; j++)
        for (uint32_t i = 0; i < m->width; i++) {
            size_t cell = 0;
            float p[3];
            if (!worst(m, i, j, &cell)) continue;
            if (!colours) {
                point_of(m, cell, p);
                for (int c = 0; c < 3; c++)
                    put_float(o, p[c]);
                continue;
            }
            btg_map_colour(scale, btg_verify_deviation(m->map, cell), p);
            /* glTF's vertex colours are linear light. */
            uint32_t rgba = 0xff000000u;
            for (int c = 0; c < 3; c++)
                rgba |= (uint32_t)(255 * pow((double)p[c], 2.2) + 0.5) << 8 * c;
            put32(o, rgba);
        }
}

static void put_triangles(const model *m, btg_output *o) {
    uint32_t corner[4];
    for (uint32_t j = 0; j + 1 < m->height; j++)
        for (uint32_t i = 0; i + 1 < m->width; i++) {
            if (!square(m, i, j, corner)) continue;
            const int order[6] = {0, 1, 2, 0, 2, 3};
            for (int k = 0; k < 6; k++)
                put32(o, corner[order[k]]);
        }
}

static void put_file(const model *m, btg_output *o, const btg_map_scale *scale) {
    char json[1400];
    unsigned points = m->vertices * 12, colours = m->vertices * 4, indices = m->triangles * 12;
    int n = snprintf(
        json, sizeof json,
        "{\"asset\":{\"version\":\"2.0\",\"generator\":\"bitangent verify\"},\"scene\":0,"
        "\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],\"materials\":[{\"doubleSided\":"
        "true,\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"roughnessFactor\":0.9}}],\"meshes\":"
        "[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"COLOR_0\":1},\"indices\":2,"
        "\"material\":0}]}],\"buffers\":[{\"byteLength\":%u}],\"bufferViews\":["
        "{\"buffer\":0,\"byteOffset\":0,\"byteLength\":%u},"
        "{\"buffer\":0,\"byteOffset\":%u,\"byteLength\":%u},"
        "{\"buffer\":0,\"byteOffset\":%u,\"byteLength\":%u}],\"accessors\":["
        "{\"bufferView\":0,\"componentType\":5126,\"count\":%u,\"type\":\"VEC3\",\"min\":[%.9g,%."
        "9g,"
        "%.9g],\"max\":[%.9g,%.9g,%.9g]},"
        "{\"bufferView\":1,\"componentType\":5121,\"normalized\":true,\"count\":%u,\"type\":"
        "\"VEC4\"},"
        "{\"bufferView\":2,\"componentType\":5125,\"count\":%u,\"type\":\"SCALAR\"}]}",
        points + colours + indices, points, points, colours, points + colours, indices, m->vertices,
        (double)m->low[0], (double)m->low[1], (double)m->low[2], (double)m->high[0],
        (double)m->high[1], (double)m->high[2], m->vertices, 3 * m->triangles);
    while (n % 4)
        json[n++] = ' ';
    put32(o, 0x46546c67); /* "glTF" */
    put32(o, 2);
    put32(o, 12 + 8 + (uint32_t)n + 8 + points + colours + indices);
    put32(o, (uint32_t)n);
    put32(o, 0x4e4f534a); /* "JSON" */
    btg_output_write(o, json, (size_t)n);
    put32(o, points + colours + indices);
    put32(o, 0x004e4942); /* "BIN" */
    put_vertices(m, o, scale, false);
    put_vertices(m, o, scale, true);
    put_triangles(m, o);
}

btg_status btg_map_glb(const btg_verify_map *map, const btg_map_scale *scale, btg_output *output,
                       btg_message *message) {
    uint32_t longest = map->width > map->height ? map->width : map->height;
    model m = {.map = map, .stride = (longest + GRID_MAX - 1) / GRID_MAX};
    m.width = (map->width + m.stride - 1) / m.stride;
    m.height = (map->height + m.stride - 1) / m.stride;
    m.number = malloc((size_t)m.width * m.height * sizeof *m.number);
    if (!m.number) return btg_fail(message, BTG_ERROR_MEMORY, "model: out of memory");
    count(&m);
    btg_status status = BTG_OK;
    if (m.triangles == 0)
        status = btg_fail(message, BTG_ERROR_ARGUMENT,
                          "model: the part shows no face to the tool; give a smaller --grid");
    else
        put_file(&m, output, scale);
    free(m.number);
    return status == BTG_OK ? btg_output_check(output, message) : status;
}
