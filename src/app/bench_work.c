/* The parts that `bitangent bench` works on, and the places for the tool. */
#include "app/app.h"
#include "app/bench.h"
#include "app/points.h"
#include "core/part.h"

#include <stdlib.h>
#include <string.h>

/* Side of the papers' parts, mm. */
#define PAPER_SIZE 150.0
/* Places for the tool; looked for among so many times as many. */
#define FEET       1024
#define FEET_TRIES 16
/* Hills of the patches of other degrees, mm: steep enough for two contacts, the tool fits in. */
#define HILL 12.0

/* Heights of the control points, 50 mm apart, u along x. M. Singh, S. Bedi, S. Mann, "Tool
 * Positioning in Five Axis Machining on a Tensor Product Surface using Circular Rays". */
static const struct {
    const char *name;
    double z[16];
} papers[3] = {
    {"convex", {80, 90, 90, 80, 90, 105, 105, 90, 90, 105, 105, 90, 80, 90, 90, 80}},
    {"concave", {80, 70, 70, 80, 70, 55, 55, 70, 70, 55, 55, 70, 80, 70, 70, 80}},
    {"saddle", {80, 65, 90, 85, 80, 85, 90, 95, 100, 105, 95, 100, 90, 100, 100, 85}},
};

static btg_status create(bench_subject *s, const btg_surface_def *surface, btg_message *message) {
    btg_part_def def = btg_part_def_default();
    btg_mesh_def mesh = {s->mesh.positions, s->mesh.vertex_count, s->mesh.indices,
                         s->mesh.triangle_count};
    def.surfaces = surface;
    def.surface_count = surface != NULL;
    def.meshes = &mesh;
    def.mesh_count = surface == NULL;
    double begin = app_seconds();
    btg_status status = btg_part_create(&def, &s->part, message);
    s->build_seconds = app_seconds() - begin;
    if (status != BTG_OK) bench_subject_free(s);
    return status;
}

btg_status bench_subject_paper(bench_subject *s, int surface, btg_message *message) {
    double points[48];
    for (int i = 0; i < 16; i++) {
        points[3 * i] = PAPER_SIZE / 3 * (i / 4);
        points[3 * i + 1] = PAPER_SIZE / 3 * (i % 4);
        points[3 * i + 2] = papers[surface].z[i];
    }
    *s = (bench_subject){.degree = 3};
    snprintf(s->name, sizeof s->name, "%s", papers[surface].name);
    btg_surface_def def = {3, 3, 4, 4, points, NULL, NULL, NULL};
    return create(s, &def, message);
}

btg_status bench_subject_degree(bench_subject *s, int degree, btg_message *message) {
    double points[3 * (BTG_DEGREE_MAX + 1) * (BTG_DEGREE_MAX + 1)];
    int n = degree + 1;
    for (int i = 0; i < n * n; i++) {
        double u = (double)(i / n) / degree, v = (double)(i % n) / degree;
        points[3 * i] = PAPER_SIZE * u;
        points[3 * i + 1] = PAPER_SIZE * v;
        points[3 * i + 2] = HILL * sin(7 * u + 1) * cos(6 * v - 1);
    }
    *s = (bench_subject){.degree = degree};
    snprintf(s->name, sizeof s->name, "degree %d", degree);
    btg_surface_def def = {degree, degree, n, n, points, NULL, NULL, NULL};
    return create(s, &def, message);
}

/* ---- triangles ----------------------------------------------------------------------------- */

static double bernstein(int i, double t) {
    static const double choose[4] = {1, 3, 3, 1};
    return choose[i] * pow(t, i) * pow(1 - t, 3 - i);
}

static double paper_height(int surface, double u, double v) {
    double z = 0;
    for (int i = 0; i < 16; i++)
        z += papers[surface].z[i] * bernstein(i / 4, u) * bernstein(i % 4, v);
    return z;
}

static bool mesh_room(bench_mesh *mesh, size_t vertices, size_t triangles) {
    mesh->vertex_count = vertices;
    mesh->triangle_count = triangles;
    mesh->positions = malloc(vertices * 3 * sizeof *mesh->positions);
    mesh->indices = malloc(triangles * 3 * sizeof *mesh->indices);
    return mesh->positions && mesh->indices;
}

static void mesh_fill(bench_mesh *mesh, int surface, int side) {
    size_t row = (size_t)side + 1, t = 0;
    for (size_t i = 0; i < row * row; i++) {
        double u = (double)(i / row) / side, v = (double)(i % row) / side;
        mesh->positions[3 * i] = PAPER_SIZE * u;
        mesh->positions[3 * i + 1] = PAPER_SIZE * v;
        mesh->positions[3 * i + 2] = paper_height(surface, u, v);
    }
    for (size_t i = 0; i < (size_t)side * (size_t)side; i++) {
        uint32_t a = (uint32_t)(i / (size_t)side * row + i % (size_t)side);
        uint32_t b = a + (uint32_t)row;
        const uint32_t corners[6] = {a, b, b + 1, a, b + 1, a + 1};
        memcpy(mesh->indices + t, corners, sizeof corners);
        t += 6;
    }
}

btg_status bench_subject_mesh(bench_subject *s, int surface, int side, btg_message *message) {
    *s = (bench_subject){0};
    snprintf(s->name, sizeof s->name, "%s %dx%d", papers[surface].name, side, side);
    size_t n = (size_t)side;
    if (!mesh_room(&s->mesh, (n + 1) * (n + 1), 2 * n * n)) {
        bench_subject_free(s);
        return btg_fail(message, BTG_ERROR_MEMORY, "bench: out of memory for %d x %d squares", side,
                        side);
    }
    mesh_fill(&s->mesh, surface, side);
    return create(s, NULL, message);
}

/* ---- files --------------------------------------------------------------------------------- */

/* The triangles of a part that has nothing else. */
static bool mesh_read(bench_mesh *mesh, const btg_part *part, const btg_part_info *info) {
    static const double corner[3][2] = {{0, 0}, {1, 0}, {0, 1}};
    if (!mesh_room(mesh, 3 * info->triangle_count, info->triangle_count)) return false;
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        btg_place place = {(uint32_t)(i / 3), corner[i % 3][0], corner[i % 3][1]};
        btg_surface_point point;
        if (btg_part_evaluate(part, place, &point) != BTG_OK) return false;
        memcpy(mesh->positions + 3 * i, &point.s, 3 * sizeof(double));
        mesh->indices[i] = (uint32_t)i;
    }
    return true;
}

btg_status bench_subject_load(bench_subject *s, const char *file, const path_options *options,
                              btg_message *message) {
    *s = (bench_subject){0};
    const char *slash = strrchr(file, '/');
    snprintf(s->name, sizeof s->name, "%s", slash ? slash + 1 : file);
    double begin = app_seconds();
    btg_status status = btg_gltf_load(file, &options->gltf, &s->part, message);
    s->build_seconds = app_seconds() - begin;
    if (status != BTG_OK) return status;
    btg_part_info info;
    btg_part_get_info(s->part, &info);
    if (info.patch_count == 0 && !mesh_read(&s->mesh, s->part, &info)) {
        bench_subject_free(s);
        return btg_fail(message, BTG_ERROR_MEMORY, "%.256s: out of memory", file);
    }
    return BTG_OK;
}

/* ---- places -------------------------------------------------------------------------------- */

void bench_spread(const btg_part_info *info, size_t i, double xy[2]) {
    /* Powers of the inverse of the number x with x^3 = x + 1: the most even such sequence known
     * in two dimensions. */
    double u = fmod(0.5 + 0.75487766624669276 * (double)i, 1);
    double v = fmod(0.5 + 0.56984029099805327 * (double)i, 1);
    xy[0] = info->box_min.x + u * (info->box_max.x - info->box_min.x);
    xy[1] = info->box_min.y + v * (info->box_max.y - info->box_min.y);
}

static btg_status read_points(const char *file, double **xy, size_t *count, btg_message *message) {
    if (file) return points_read(file, xy, count, message);
    *count = FEET * FEET_TRIES;
    *xy = malloc(*count * 2 * sizeof **xy);
    return *xy ? BTG_OK : btg_fail(message, BTG_ERROR_MEMORY, "bench: out of memory");
}

/* Keeps the places over the part, FEET of them where they need not be all. */
static btg_status keep_contacts(bench_subject *s, const btg_tool *tool, size_t count, size_t most) {
    btg_solver_def solver = btg_solver_def_default();
    size_t size = btg_workspace_size(s->part);
    void *workspace = malloc(size);
    if (!workspace) return BTG_ERROR_MEMORY;
    btg_status status = BTG_OK;
    for (size_t i = 0; i < count && s->foot_count < most && status >= 0; i++) {
        btg_drop_query query = btg_position_drop_query(s->feet[2 * i], s->feet[2 * i + 1]);
        btg_drop_result drop;
        status = btg_drop(s->part, tool, &solver, &query, workspace, size, &drop);
        if (status < 0 || drop.status == BTG_NO_CONTACT) continue;
        memmove(s->feet + 2 * s->foot_count++, s->feet + 2 * i, 2 * sizeof(double));
    }
    free(workspace);
    return status < 0 ? status : BTG_OK;
}

btg_status bench_subject_feet(bench_subject *s, const path_options *options, const btg_tool *tool,
                              btg_message *message) {
    size_t count;
    btg_status status = read_points(options->points, &s->feet, &count, message);
    if (status != BTG_OK) return status;
    btg_part_info info;
    btg_part_get_info(s->part, &info);
    for (size_t i = 0; i < count && !options->points; i++)
        bench_spread(&info, i, s->feet + 2 * i);
    status = keep_contacts(s, tool, count, options->points ? count : FEET);
    if (status < 0) {
        return btg_fail(message, status, "%s: cannot drop the tool (%s)", s->name,
                        btg_status_name(status));
    }
    if (s->foot_count > 0) return BTG_OK;
    return btg_fail(message, BTG_ERROR_ARGUMENT,
                    "%s: no place where the tool touches the part; check --points, --gltf-unit "
                    "and --up",
                    s->name);
}

void bench_subject_free(bench_subject *s) {
    btg_part_destroy(s->part);
    free(s->mesh.positions);
    free(s->mesh.indices);
    free(s->feet);
    *s = (bench_subject){0};
}
