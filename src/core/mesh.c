/* Triangle meshes: checks and points. */
#include "core/mesh.h"

btg_status btg_mesh_check(const btg_mesh_def *def, size_t index, btg_message *message) {
    if (def->triangle_count == 0 || !def->positions || !def->indices)
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "mesh %zu: no positions, indices or triangles; leave an empty mesh out",
                        index);
    if (def->vertex_count > UINT32_MAX || def->triangle_count > BTG_TRIANGLES_MAX)
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "mesh %zu: %zu vertices and %zu triangles are too many; at most %u "
                        "triangles",
                        index, def->vertex_count, def->triangle_count, BTG_TRIANGLES_MAX);
    for (size_t i = 0; i < 3 * def->vertex_count; i++)
        if (!(fabs(def->positions[i]) <= BTG_LENGTH_MAX))
            return btg_fail(message, BTG_ERROR_ARGUMENT,
                            "mesh %zu: vertex %zu is not finite or beyond %g mm; check the data "
                            "and its unit",
                            index, i / 3, BTG_LENGTH_MAX);
    for (size_t i = 0; i < 3 * def->triangle_count; i++)
        if (def->indices[i] >= def->vertex_count)
            return btg_fail(message, BTG_ERROR_ARGUMENT,
                            "mesh %zu: triangle %zu uses vertex %u of %zu; indices start at 0",
                            index, i / 3, def->indices[i], def->vertex_count);
    return BTG_OK;
}

void btg_mesh_append(btg_part *part, const btg_mesh_def *def, size_t vertex_at,
                     size_t triangle_at) {
    for (size_t i = 0; i < def->vertex_count; i++) {
        const double *p = def->positions + 3 * i;
        part->vertices[vertex_at + i] = vec(p[0], p[1], p[2]);
    }
    for (size_t i = 0; i < def->triangle_count; i++)
        for (size_t k = 0; k < 3; k++)
            part->triangles[triangle_at + i][k] = (uint32_t)(vertex_at + def->indices[3 * i + k]);
}
