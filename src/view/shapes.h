/* Triangles of the simple bodies that a picture is made of. Single precision; units are the
 * caller's. */
#ifndef BTG_VIEW_SHAPES_H
#define BTG_VIEW_SHAPES_H

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace view {

struct vertex {
    glm::vec3 point, normal;
};

struct mesh {
    std::vector<vertex> vertices;
    std::vector<std::uint32_t> indices;
};

void add_sphere(mesh *m, glm::vec3 centre, float radius);
/* Round rod through the points. */
void add_rod(mesh *m, const std::vector<glm::vec3> &points, float radius);
void add_arrow(mesh *m, glm::vec3 from, glm::vec3 to, float radius);
/* Flat disc. */
void add_disc(mesh *m, glm::vec3 centre, glm::vec3 axis, float radius);

} // namespace view

#endif
