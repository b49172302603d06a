#define _POSIX_C_SOURCE 200809L
#include "io/glb.h"
#include "core/part.h"
#include "io/json.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define BYTE  5121
#define INDEX 5125
#define FLOAT 5126

#define POINTS_VIEW  34962
#define INDICES_VIEW 34963

/* Sizes in a .glb are 32 bits wide. */
#define SIZE_LIMIT 0x7fffffffu

btg_glb btg_glb_begin(const char *title) {
    return (btg_glb){.title = title, .animated = BTG_GLB_NONE};
}

void btg_glb_release(btg_glb *glb) {
    free(glb->data);
    *glb = (btg_glb){.animated = BTG_GLB_NONE};
}

float btg_glb_linear(float value) {
    double v = (double)value;
    return (float)(v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4));
}

/* ---- data --------------------------------------------------------------------------------- */

/* Room at the end, or NULL. All that goes in has a size that is a multiple of 4. */
static char *extend(btg_glb *g, size_t size) {
    if (g->short_of_memory || size > SIZE_LIMIT || g->size > SIZE_LIMIT - size) {
        g->short_of_memory = true;
        return NULL;
    }
    size_t wanted = g->capacity ? g->capacity : 65536;
    while (wanted < g->size + size)
        wanted *= 2;
    char *data = wanted == g->capacity ? g->data : realloc(g->data, wanted);
    if (!data) {
        g->short_of_memory = true;
        return NULL;
    }
    g->data = data;
    g->capacity = wanted;
    g->size += size;
    return data + g->size - size;
}

static void put32(char *at, uint32_t value) {
    for (int k = 0; k < 4; k++)
        at[k] = (char)(unsigned char)(value >> 8 * k);
}

static void put_float(char *at, float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    put32(at, bits);
}

static int add_accessor(btg_glb *g, btg_glb_accessor accessor) {
    if (g->accessors == 2 * BTG_GLB_ITEMS) {
        g->short_of_memory = true;
        return BTG_GLB_NONE;
    }
    g->accessor[g->accessors] = accessor;
    return g->accessors++;
}

static void convert(const float *in, int width, btg_glb_frame frame, float *out) {
    memcpy(out, in, (size_t)width * sizeof *out);
    if (frame == BTG_GLB_AS_IT_IS) return;
    float scale = frame == BTG_GLB_PLACE ? 1000 : 1;
    out[0] = in[0] / scale;
    out[1] = in[2] / scale;
    out[2] = -in[1] / scale;
}

int btg_glb_floats(btg_glb *g, const float *values, size_t count, int width, btg_glb_frame frame,
                   bool bounds) {
    btg_glb_accessor a = {.offset = g->size, .count = count, .width = width, .component = FLOAT};
    a.bounds = bounds;
    a.target = frame == BTG_GLB_AS_IT_IS ? 0 : POINTS_VIEW;
    if (count == 0 || count > SIZE_LIMIT / 16) {
        g->short_of_memory = g->short_of_memory || count > 0;
        return BTG_GLB_NONE;
    }
    char *at = extend(g, count * (size_t)width * 4);
    if (!at) return BTG_GLB_NONE;
    for (int k = 0; k < width; k++)
        a.low[k] = INFINITY, a.high[k] = -INFINITY;
    for (size_t i = 0; i < count; i++) {
        float v[4];
        convert(values + i * (size_t)width, width, frame, v);
        for (int k = 0; k < width; k++, at += 4) {
            put_float(at, v[k]);
            a.low[k] = fminf(a.low[k], v[k]);
            a.high[k] = fmaxf(a.high[k], v[k]);
        }
    }
    return add_accessor(g, a);
}

int btg_glb_colours(btg_glb *g, const unsigned char *rgba, size_t count) {
    btg_glb_accessor a = {.offset = g->size, .count = count, .width = 4, .component = BYTE};
    a.target = POINTS_VIEW;
    char *at = count <= SIZE_LIMIT / 4 ? extend(g, 4 * count) : NULL;
    if (!at) {
        g->short_of_memory = true;
        return BTG_GLB_NONE;
    }
    memcpy(at, rgba, 4 * count);
    return add_accessor(g, a);
}

int btg_glb_indices(btg_glb *g, const uint32_t *indices, size_t count) {
    btg_glb_accessor a = {.offset = g->size, .count = count, .width = 1, .component = INDEX};
    a.target = INDICES_VIEW;
    char *at = count <= SIZE_LIMIT / 4 ? extend(g, 4 * count) : NULL;
    if (!at) {
        g->short_of_memory = true;
        return BTG_GLB_NONE;
    }
    for (size_t i = 0; i < count; i++)
        put32(at + 4 * i, indices[i]);
    return add_accessor(g, a);
}

/* ---- things ------------------------------------------------------------------------------- */

int btg_glb_add_material(btg_glb *g, btg_glb_material material) {
    if (g->materials == BTG_GLB_ITEMS) {
        g->short_of_memory = true;
        return BTG_GLB_NONE;
    }
    g->material[g->materials] = material;
    return g->materials++;
}

int btg_glb_add_mesh(btg_glb *g, btg_glb_mesh mesh) {
    if (g->meshes == BTG_GLB_ITEMS) {
        g->short_of_memory = true;
        return BTG_GLB_NONE;
    }
    g->mesh[g->meshes] = mesh;
    return g->meshes++;
}

int btg_glb_add_node(btg_glb *g, btg_glb_node node) {
    if (g->nodes == BTG_GLB_ITEMS) {
        g->short_of_memory = true;
        return BTG_GLB_NONE;
    }
    g->node[g->nodes] = node;
    return g->nodes++;
}

void btg_glb_animate(btg_glb *g, int node, const float *times, const float *translations,
                     const float *rotations, size_t count) {
    g->times = btg_glb_floats(g, times, count, 1, BTG_GLB_AS_IT_IS, true);
    g->translations = btg_glb_floats(g, translations, count, 3, BTG_GLB_AS_IT_IS, false);
    g->rotations = btg_glb_floats(g, rotations, count, 4, BTG_GLB_AS_IT_IS, false);
    g->animated = node;
}

/* ---- the JSON chunk ----------------------------------------------------------------------- */

static void json_index(btg_json *json, const char *name, int index) {
    if (index != BTG_GLB_NONE) btg_json_count(json, name, (uint64_t)index);
}

static void json_floats(btg_json *json, const char *name, const float *values, int count) {
    btg_json_open(json, name, '[');
    for (int i = 0; i < count; i++)
        btg_json_number(json, NULL, (double)values[i]);
    btg_json_close(json, ']');
}

static void json_node(const btg_glb *g, btg_json *json, int index) {
    const btg_glb_node *n = &g->node[index];
    bool parent = false;
    btg_json_open(json, NULL, '{');
    btg_json_string(json, "name", n->name);
    json_index(json, "mesh", n->mesh);
    if (n->placed) {
        json_floats(json, "translation", n->translation, 3);
        json_floats(json, "rotation", n->rotation, 4);
    }
    for (int i = 0; i < g->nodes; i++) {
        if (g->node[i].parent != index) continue;
        if (!parent) btg_json_open(json, "children", '[');
        parent = true;
        btg_json_count(json, NULL, (uint64_t)i);
    }
    if (parent) btg_json_close(json, ']');
    btg_json_close(json, '}');
}

static void json_scene(const btg_glb *g, btg_json *json) {
    btg_json_count(json, "scene", 0);
    btg_json_open(json, "scenes", '[');
    btg_json_open(json, NULL, '{');
    btg_json_string(json, "name", g->title);
    btg_json_open(json, "nodes", '[');
    for (int i = 0; i < g->nodes; i++)
        if (g->node[i].parent == BTG_GLB_NONE) btg_json_count(json, NULL, (uint64_t)i);
    btg_json_close(json, ']');
    btg_json_close(json, '}');
    btg_json_close(json, ']');
    btg_json_open(json, "nodes", '[');
    for (int i = 0; i < g->nodes; i++)
        json_node(g, json, i);
    btg_json_close(json, ']');
}

static void json_meshes(const btg_glb *g, btg_json *json) {
    btg_json_open(json, "meshes", '[');
    for (int i = 0; i < g->meshes; i++) {
        const btg_glb_mesh *m = &g->mesh[i];
        btg_json_open(json, NULL, '{');
        btg_json_string(json, "name", m->name);
        btg_json_open(json, "primitives", '[');
        btg_json_open(json, NULL, '{');
        btg_json_open(json, "attributes", '{');
        json_index(json, "POSITION", m->points);
        json_index(json, "NORMAL", m->normals);
        json_index(json, "COLOR_0", m->colours);
        btg_json_close(json, '}');
        json_index(json, "indices", m->indices);
        json_index(json, "material", m->material);
        btg_json_count(json, "mode", (uint64_t)m->mode);
        btg_json_close(json, '}');
        btg_json_close(json, ']');
        btg_json_close(json, '}');
    }
    btg_json_close(json, ']');
}

static void json_materials(const btg_glb *g, btg_json *json) {
    bool unlit = false;
    btg_json_open(json, "materials", '[');
    for (int i = 0; i < g->materials; i++) {
        const btg_glb_material *m = &g->material[i];
        float rgba[4] = {0, 0, 0, 1};
        for (int k = 0; k < 3; k++)
            rgba[k] = btg_glb_linear(m->rgb[k]);
        btg_json_open(json, NULL, '{');
        btg_json_string(json, "name", m->name);
        btg_json_bool(json, "doubleSided", true);
        btg_json_open(json, "pbrMetallicRoughness", '{');
        json_floats(json, "baseColorFactor", rgba, 4);
        btg_json_number(json, "metallicFactor", (double)m->metallic);
        btg_json_number(json, "roughnessFactor", (double)m->roughness);
        btg_json_close(json, '}');
        if (m->unlit) {
            btg_json_open(json, "extensions", '{');
            btg_json_open(json, "KHR_materials_unlit", '{');
            btg_json_close(json, '}');
            btg_json_close(json, '}');
        }
        unlit = unlit || m->unlit;
        btg_json_close(json, '}');
    }
    btg_json_close(json, ']');
    if (!unlit) return;
    btg_json_open(json, "extensionsUsed", '[');
    btg_json_string(json, NULL, "KHR_materials_unlit");
    btg_json_close(json, ']');
}

static void json_accessors(const btg_glb *g, btg_json *json) {
    btg_json_open(json, "accessors", '[');
    for (int i = 0; i < g->accessors; i++) {
        const btg_glb_accessor *a = &g->accessor[i];
        btg_json_open(json, NULL, '{');
        btg_json_count(json, "bufferView", (uint64_t)i);
        btg_json_count(json, "componentType", (uint64_t)a->component);
        if (a->component == BYTE) btg_json_bool(json, "normalized", true);
        btg_json_count(json, "count", a->count);
        btg_json_string(json, "type", a->width == 1 ? "SCALAR" : a->width == 3 ? "VEC3" : "VEC4");
        if (a->bounds) {
            json_floats(json, "min", a->low, a->width);
            json_floats(json, "max", a->high, a->width);
        }
        btg_json_close(json, '}');
    }
    btg_json_close(json, ']');
    btg_json_open(json, "bufferViews", '[');
    for (int i = 0; i < g->accessors; i++) {
        const btg_glb_accessor *a = &g->accessor[i];
        btg_json_open(json, NULL, '{');
        btg_json_count(json, "buffer", 0);
        btg_json_count(json, "byteOffset", a->offset);
        btg_json_count(json, "byteLength",
                       a->count * (size_t)(a->component == BYTE ? 4 : 4 * a->width));
        if (a->target) btg_json_count(json, "target", (uint64_t)a->target);
        btg_json_close(json, '}');
    }
    btg_json_close(json, ']');
}

static void json_channel(const btg_glb *g, btg_json *json, int sampler, const char *what) {
    btg_json_open(json, NULL, '{');
    btg_json_count(json, "sampler", (uint64_t)sampler);
    btg_json_open(json, "target", '{');
    btg_json_count(json, "node", (uint64_t)g->animated);
    btg_json_string(json, "path", what);
    btg_json_close(json, '}');
    btg_json_close(json, '}');
}

static void json_animation(const btg_glb *g, btg_json *json) {
    const int outputs[2] = {g->translations, g->rotations};
    if (g->animated == BTG_GLB_NONE) return;
    btg_json_open(json, "animations", '[');
    btg_json_open(json, NULL, '{');
    btg_json_string(json, "name", "along the path");
    btg_json_open(json, "samplers", '[');
    for (int i = 0; i < 2; i++) {
        btg_json_open(json, NULL, '{');
        btg_json_count(json, "input", (uint64_t)g->times);
        btg_json_count(json, "output", (uint64_t)outputs[i]);
        btg_json_close(json, '}');
    }
    btg_json_close(json, ']');
    btg_json_open(json, "channels", '[');
    json_channel(g, json, 0, "translation");
    json_channel(g, json, 1, "rotation");
    btg_json_close(json, ']');
    btg_json_close(json, '}');
    btg_json_close(json, ']');
}

static void json_all(const btg_glb *g, btg_output *out) {
    btg_json json = btg_json_to(out);
    char generator[64];
    snprintf(generator, sizeof generator, "bitangent %s", btg_version());
    btg_json_open(&json, NULL, '{');
    btg_json_open(&json, "asset", '{');
    btg_json_string(&json, "version", "2.0");
    btg_json_string(&json, "generator", generator);
    btg_json_close(&json, '}');
    json_scene(g, &json);
    json_meshes(g, &json);
    json_materials(g, &json);
    json_accessors(g, &json);
    json_animation(g, &json);
    btg_json_open(&json, "buffers", '[');
    btg_json_open(&json, NULL, '{');
    btg_json_count(&json, "byteLength", g->size);
    btg_json_close(&json, '}');
    btg_json_close(&json, ']');
    btg_json_close(&json, '}');
}

/* ---- the file ----------------------------------------------------------------------------- */

static void word(btg_output *o, uint32_t value) {
    char bytes[4];
    put32(bytes, value);
    btg_output_write(o, bytes, 4);
}

/* The JSON chunk as text, filled up with blanks to a multiple of 4; freed by the caller. */
static char *json_text(const btg_glb *g, size_t *size) {
    char *text = NULL;
    FILE *file = open_memstream(&text, size);
    if (!file) return NULL;
    btg_output out = btg_output_borrow(file);
    json_all(g, &out);
    fflush(file);
    for (size_t n = *size; n % 4; n++)
        btg_output_text(&out, " ");
    bool ok = out.error == 0;
    if (fclose(file) == 0 && ok) return text;
    free(text);
    return NULL;
}

btg_status btg_glb_write(const btg_glb *g, btg_output *o, btg_message *message) {
    size_t size = 0;
    char *json = g->short_of_memory ? NULL : json_text(g, &size);
    if (!json) {
        return btg_fail(message, BTG_ERROR_MEMORY,
                        "model: out of memory, or over 2 GB; choose longer steps");
    }
    word(o, 0x46546c67); /* "glTF" */
    word(o, 2);
    word(o, (uint32_t)(12 + 8 + size + 8 + g->size));
    word(o, (uint32_t)size);
    word(o, 0x4e4f534a); /* "JSON" */
    btg_output_write(o, json, size);
    word(o, (uint32_t)g->size);
    word(o, 0x004e4942); /* "BIN" */
    btg_output_write(o, g->data, g->size);
    free(json);
    return btg_output_check(o, message);
}
