#include "io/scene.h"
#include "core/part.h"
#include "io/glb.h"
#include "io/palette.h"
#include "io/shape.h"

#include <stdlib.h>
#include <string.h>

#define STOPS_FIRST 1024
/* Triangles that exact surfaces may become, beside those that the part has. */
#define PART_FINE 2000000
/* Over this many contacts, marks are left out: the lines between P and Q still show them. */
#define MARKS_MOST 500000
/* Seconds of the animation from stop to stop, and for the jump where the tool is lifted. */
#define STOP_SECONDS 0.1f
#define JUMP_SECONDS 0.001f

/* ---- stops -------------------------------------------------------------------------------- */

static void keep(float out[3], btg_vec3 v) {
    out[0] = (float)v.x, out[1] = (float)v.y, out[2] = (float)v.z;
}

static bool make_room(btg_scene *s) {
    if (s->count < s->capacity) return true;
    size_t capacity = s->capacity ? 2 * s->capacity : STOPS_FIRST;
    btg_scene_stop *stops = NULL;
    if (capacity <= SIZE_MAX / sizeof *stops) stops = realloc(s->stops, capacity * sizeof *stops);
    if (!stops) {
        s->short_of_memory = true;
        return false;
    }
    s->stops = stops;
    s->capacity = capacity;
    return true;
}

void btg_scene_add(btg_scene *s, const btg_row *row, bool linked) {
    if (row->lift || !make_room(s)) return;
    const btg_position *p = &row->position;
    const btg_scene_stop *last = s->count > 0 ? &s->stops[s->count - 1] : NULL;
    btg_scene_stop stop = {.foot_mm = {p->foot_x_mm, p->foot_y_mm},
                           .exact_tip = p->tip,
                           .exact_axis = p->axis,
                           .tilt_rad = (float)p->tilt_rad,
                           .status = (int8_t)p->status,
                           .pass = row->pass,
                           .point = row->point};
    keep(stop.tip, p->tip);
    keep(stop.axis, p->axis);
    keep(stop.p, p->p.point);
    keep(stop.q, p->q.point);
    stop.linked = linked && last && last->status != BTG_NO_CONTACT && p->status != BTG_NO_CONTACT;
    s->stops[s->count++] = stop;
}

void btg_scene_release(btg_scene *s) {
    free(s->stops);
    *s = (btg_scene){0};
}

static bool exists(const float at[3]) {
    return isfinite(at[0]) && isfinite(at[1]) && isfinite(at[2]);
}

size_t btg_scene_best(const btg_scene *s) {
    size_t best = SIZE_MAX;
    for (size_t i = 0; i < s->count; i++) {
        const btg_scene_stop *a = &s->stops[i];
        if (!exists(a->tip)) continue;
        bool better = best == SIZE_MAX;
        if (!better && isfinite(a->tilt_rad))
            better = !isfinite(s->stops[best].tilt_rad) || a->tilt_rad > s->stops[best].tilt_rad;
        if (better) best = i;
    }
    return best;
}

double btg_scene_mark_mm(const btg_scene *s, const btg_part *part, const btg_tool *tool) {
    btg_vec3 size = vec_sub(part->info.box_max, part->info.box_min);
    double room = sqrt(fmax(size.x * size.y, 1e-12) / (double)(s->count + 1));
    double rim = tool->def.major_radius_mm + tool->def.minor_radius_mm;
    return fmin(0.14 * room, 0.06 * rim);
}

double btg_scene_tool_mm(const btg_tool *tool) {
    const btg_tool_def *d = &tool->def;
    double top = 4 * (d->major_radius_mm + d->minor_radius_mm);
    if (tool->element_count > 1) top = 0;
    for (uint32_t i = 1; i < tool->element_count; i++)
        top = fmax(top, d->minor_radius_mm + tool->element[i].to_mm);
    return top;
}

/* ---- the model ---------------------------------------------------------------------------- */

static int matt(btg_glb *g, const char *name, double red, double green, double blue,
                double metallic) {
    return btg_glb_add_material(g,
                                (btg_glb_material){.name = name,
                                                   .rgb = {(float)red, (float)green, (float)blue},
                                                   .metallic = (float)metallic,
                                                   .roughness = 0.55f});
}

static int plain(btg_glb *g, const char *name, double red, double green, double blue) {
    return btg_glb_add_material(g,
                                (btg_glb_material){.name = name,
                                                   .rgb = {(float)red, (float)green, (float)blue},
                                                   .roughness = 1,
                                                   .unlit = true});
}

/* A node with the shape, which is released; nothing where the shape is empty. */
static void add_shape(btg_glb *g, const char *name, btg_shape *shape, int material, int parent) {
    if (shape->short_of_memory) g->short_of_memory = true;
    if (shape->index_count > 0 && !g->short_of_memory) {
        btg_glb_mesh mesh = {.name = name, .colours = BTG_GLB_NONE, .material = material};
        mesh.mode = BTG_GLB_TRIANGLES;
        mesh.points = btg_glb_floats(g, shape->points, shape->point_count, 3, BTG_GLB_PLACE, true);
        mesh.normals =
            btg_glb_floats(g, shape->normals, shape->point_count, 3, BTG_GLB_DIRECTION, false);
        mesh.indices = btg_glb_indices(g, shape->indices, shape->index_count);
        int number = btg_glb_add_mesh(g, mesh);
        btg_glb_add_node(g, (btg_glb_node){.name = name, .mesh = number, .parent = parent});
    }
    btg_shape_release(shape);
}

/* Both ends of a line that belongs to stop i; false: there is none. */
typedef bool (*line_of)(const btg_scene *s, size_t i, double length_mm, float ends[6]);

static bool path_line(const btg_scene *s, size_t i, double length_mm, float ends[6]) {
    (void)length_mm;
    if (i == 0 || !s->stops[i].linked) return false;
    memcpy(ends, s->stops[i - 1].tip, 3 * sizeof *ends);
    memcpy(ends + 3, s->stops[i].tip, 3 * sizeof *ends);
    return true;
}

static bool axis_line(const btg_scene *s, size_t i, double length_mm, float ends[6]) {
    const btg_scene_stop *a = &s->stops[i];
    for (int k = 0; k < 3; k++) {
        ends[k] = a->tip[k];
        ends[3 + k] = a->tip[k] + (float)length_mm * a->axis[k];
    }
    return true;
}

static bool contact_line(const btg_scene *s, size_t i, double length_mm, float ends[6]) {
    (void)length_mm;
    memcpy(ends, s->stops[i].p, 3 * sizeof *ends);
    memcpy(ends + 3, s->stops[i].q, 3 * sizeof *ends);
    return s->stops[i].status != BTG_OSCULATING;
}

static void add_lines(btg_glb *g, const char *name, const btg_scene *s, line_of line,
                      double length_mm, int material) {
    float *ends = malloc((s->count + 1) * 6 * sizeof *ends);
    size_t lines = 0;
    if (!ends) g->short_of_memory = true;
    for (size_t i = 0; ends && i < s->count; i++) {
        float *at = ends + 6 * lines;
        if (line(s, i, length_mm, at) && exists(at) && exists(at + 3)) lines++;
    }
    if (lines > 0) {
        btg_glb_mesh mesh = {.name = name, .material = material, .mode = BTG_GLB_LINES};
        mesh.normals = mesh.colours = mesh.indices = BTG_GLB_NONE;
        mesh.points = btg_glb_floats(g, ends, 2 * lines, 3, BTG_GLB_PLACE, true);
        int number = btg_glb_add_mesh(g, mesh);
        btg_glb_add_node(g, (btg_glb_node){.name = name, .mesh = number, .parent = BTG_GLB_NONE});
    }
    free(ends);
}

typedef enum mark { MARK_FIRST, MARK_SECOND, MARK_BOTH, MARK_ONE } mark;

static const float *marked(const btg_scene_stop *stop, mark kind) {
    bool both = stop->status == BTG_OSCULATING, one = stop->status == BTG_SINGLE_CONTACT;
    if (!exists(stop->p)) return NULL;
    if (kind == MARK_BOTH) return both ? stop->p : NULL;
    if (kind == MARK_ONE) return one ? stop->p : NULL;
    if (both || one) return NULL;
    if (kind == MARK_FIRST) return stop->p;
    return exists(stop->q) ? stop->q : NULL;
}

static void add_marks(btg_glb *g, const char *name, const btg_scene *s, mark kind, double radius_mm,
                      int material) {
    btg_shape shape = {0};
    for (size_t i = 0; i < s->count && s->count <= MARKS_MOST; i++) {
        const float *at = marked(&s->stops[i], kind);
        if (at) btg_shape_mark(&shape, at, (float)radius_mm);
    }
    add_shape(g, name, &shape, material, BTG_GLB_NONE);
}

static void add_path(btg_glb *g, const btg_scene *s, const btg_part *part, const btg_tool *tool) {
    double mark_mm = btg_scene_mark_mm(s, part, tool);
    double axis_mm = tool->def.major_radius_mm + tool->def.minor_radius_mm;
    add_lines(g, "path of the tip", s, path_line, 0, plain(g, "path", BTG_RGB_INK));
    add_lines(g, "tool axes", s, axis_line, axis_mm, plain(g, "axes", 0.45, 0.50, 0.55));
    add_lines(g, "contacts P to Q", s, contact_line, 0, plain(g, "P to Q", 0.30, 0.32, 0.36));
    add_marks(g, "contacts P", s, MARK_FIRST, mark_mm, matt(g, "P", BTG_RGB_P, 0));
    add_marks(g, "contacts Q", s, MARK_SECOND, mark_mm, matt(g, "Q", BTG_RGB_Q, 0));
    add_marks(g, "P and Q at one place", s, MARK_BOTH, mark_mm,
              matt(g, "osculating", BTG_RGB_OSCULATING, 0));
    add_marks(g, "single contacts P", s, MARK_ONE, mark_mm, matt(g, "single", BTG_RGB_SINGLE, 0));
}

/* ---- the tool ----------------------------------------------------------------------------- */

/* Where the tool stands, in glTF's frame: turned the shortest way from upright. */
static void pose_of(const btg_scene_stop *stop, float translation[3], float rotation[4]) {
    const float up[3] = {stop->axis[0], stop->axis[2], -stop->axis[1]};
    float w = 1 + up[1], length = sqrtf(up[2] * up[2] + up[0] * up[0] + w * w);
    bool over = length > 1e-6f;
    rotation[0] = over ? up[2] / length : 1;
    rotation[1] = 0;
    rotation[2] = over ? -up[0] / length : 0;
    rotation[3] = over ? w / length : 0;
    translation[0] = stop->tip[0] / 1000;
    translation[1] = stop->tip[2] / 1000;
    translation[2] = -stop->tip[1] / 1000;
}

static void animate(btg_glb *g, int node, const btg_scene *s) {
    size_t room = 2 * s->count, n = 0;
    float *times = malloc(room * 8 * sizeof *times);
    float *places = times ? times + room : NULL, *turns = times ? times + 4 * room : NULL;
    if (!times) {
        g->short_of_memory = true;
        return;
    }
    float time = 0;
    for (size_t i = 0; i < s->count; i++) {
        const btg_scene_stop *stop = &s->stops[i];
        if (!exists(stop->tip)) continue;
        if (n > 0) time = STOP_SECONDS * (float)i;
        if (n > 0 && !stop->linked) { /* stays where it is until it jumps */
            memcpy(places + 3 * n, places + 3 * (n - 1), 3 * sizeof *places);
            memcpy(turns + 4 * n, turns + 4 * (n - 1), 4 * sizeof *turns);
            times[n++] = time - JUMP_SECONDS;
        }
        pose_of(stop, places + 3 * n, turns + 4 * n);
        times[n++] = time;
    }
    /* Beyond this, single precision no longer tells two times apart. */
    bool apart = true;
    for (size_t i = 1; i < n; i++)
        apart = apart && times[i] > times[i - 1];
    if (n > 1 && apart) btg_glb_animate(g, node, times, places, turns, n);
    free(times);
}

static void add_tool(btg_glb *g, const btg_scene *s, const btg_tool *tool) {
    size_t best = btg_scene_best(s);
    if (best == SIZE_MAX) return;
    static const char *const name[3] = {"insert", "shank", "holder"};
    btg_glb_node node = {.name = "tool", .mesh = BTG_GLB_NONE, .parent = BTG_GLB_NONE};
    node.placed = true;
    pose_of(&s->stops[best], node.translation, node.rotation);
    int parent = btg_glb_add_node(g, node);
    const int material[3] = {matt(g, name[0], 0.85, 0.65, 0.20, 0.6),
                             matt(g, name[1], 0.62, 0.65, 0.69, 0.6),
                             matt(g, name[2], 0.33, 0.36, 0.40, 0.6)};
    for (uint32_t i = 0; i < tool->element_count; i++) {
        btg_shape shape = {0};
        btg_solid solid = btg_shape_solid(tool, i);
        btg_shape_tool(&shape, tool, i);
        add_shape(g, name[solid], &shape, material[solid], parent);
    }
    if (tool->def.shank.radius_mm == 0) {
        btg_shape shape = {0};
        btg_shape_rod(&shape, tool, btg_scene_tool_mm(tool));
        add_shape(g, "body, for the eye", &shape, material[1], parent);
    }
    animate(g, parent, s);
}

/* ---- the file ----------------------------------------------------------------------------- */

btg_status btg_scene_glb(const btg_scene *s, const btg_part *part, const btg_tool *tool,
                         const char *title, btg_output *output, btg_message *message) {
    btg_glb *g = malloc(sizeof *g);
    if (!g || s->short_of_memory) {
        free(g);
        return btg_fail(message, BTG_ERROR_MEMORY, "model: out of memory; choose longer steps");
    }
    *g = btg_glb_begin(title);
    btg_shape shape = {0};
    btg_status status = btg_shape_part(&shape, part, part->triangle_count + PART_FINE, message);
    if (status == BTG_OK) {
        add_shape(g, "part", &shape, matt(g, "part", 0.62, 0.67, 0.72, 0), BTG_GLB_NONE);
        add_path(g, s, part, tool);
        add_tool(g, s, tool);
        status = btg_glb_write(g, output, message);
    }
    btg_glb_release(g);
    free(g);
    return status;
}
