#include "view/shapes.h"

#include <algorithm>
#include <cmath>

namespace view {

static constexpr int around = 72;    /* segments of a turn */
static constexpr int rod_sides = 12; /* of a rod, few pixels thick */
static constexpr float whole = 6.2831853f;

static std::uint32_t count_of(const mesh *m) {
    return static_cast<std::uint32_t>(m->vertices.size());
}

static void add_quad(mesh *m, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    m->indices.insert(m->indices.end(), {a, b, c, a, c, d});
}

static glm::vec3 any_perpendicular(glm::vec3 axis) {
    glm::vec3 e = std::fabs(axis.x) < 0.6f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
    return glm::normalize(glm::cross(axis, e));
}

void add_sphere(mesh *m, glm::vec3 centre, float radius) {
    constexpr int rings = 16;
    std::uint32_t first = count_of(m), row = 2 * rings + 1;
    for (int i = 0; i <= rings; i++)
        for (int k = 0; k <= 2 * rings; k++) {
            float a = 0.5f * whole * static_cast<float>(i) / rings;
            float b = 0.5f * whole * static_cast<float>(k) / rings;
            glm::vec3 n(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a));
            m->vertices.push_back({centre + radius * n, n});
            if (i == 0 || k == 0) continue;
            std::uint32_t at =
                first + static_cast<std::uint32_t>(i) * row + static_cast<std::uint32_t>(k);
            add_quad(m, at - row - 1, at - 1, at, at - row);
        }
}

/* A ring of vertices about `axis`; joined to the ring before. */
static void add_ring(mesh *m, glm::vec3 centre, glm::vec3 side, glm::vec3 up, float radius,
                     glm::vec3 lean, bool join) {
    std::uint32_t first = count_of(m);
    for (int k = 0; k <= rod_sides; k++) {
        float a = whole * static_cast<float>(k) / rod_sides;
        glm::vec3 n = std::cos(a) * side + std::sin(a) * up;
        m->vertices.push_back({centre + radius * n, glm::normalize(n + lean)});
        if (!join || k == 0) continue;
        std::uint32_t at = first + static_cast<std::uint32_t>(k);
        add_quad(m, at - rod_sides - 2, at - rod_sides - 1, at, at - 1);
    }
}

void add_rod(mesh *m, const std::vector<glm::vec3> &points, float radius) {
    glm::vec3 side(0);
    for (std::size_t i = 0; i < points.size(); i++) {
        glm::vec3 along = points[std::min(i + 1, points.size() - 1)] - points[i > 0 ? i - 1 : 0];
        if (!(glm::length(along) > 0)) continue;
        along = glm::normalize(along);
        /* Carried along, so that the rod does not twist. */
        side -= along * glm::dot(side, along);
        side = glm::length(side) > 0.1f ? glm::normalize(side) : any_perpendicular(along);
        add_ring(m, points[i], side, glm::cross(along, side), radius, glm::vec3(0), i > 0);
    }
}

void add_arrow(mesh *m, glm::vec3 from, glm::vec3 to, float radius) {
    float length = glm::distance(from, to), head = std::min(5 * radius, 0.5f * length);
    if (!(length > 0)) return;
    glm::vec3 along = (to - from) / length, side = any_perpendicular(along);
    glm::vec3 up = glm::cross(along, side), neck = to - head * along;
    add_rod(m, {from, neck}, radius);
    add_disc(m, neck, -along, 2.4f * radius);
    add_ring(m, neck, side, up, 2.4f * radius, 0.5f * along, false);
    add_ring(m, to, side, up, 0, 0.5f * along, true);
}

void add_disc(mesh *m, glm::vec3 centre, glm::vec3 axis, float radius) {
    glm::vec3 side = any_perpendicular(axis), up = glm::cross(axis, side);
    std::uint32_t middle = count_of(m);
    m->vertices.push_back({centre, axis});
    for (int i = 0; i <= around; i++) {
        float a = whole * static_cast<float>(i) / around;
        m->vertices.push_back({centre + radius * (std::cos(a) * side + std::sin(a) * up), axis});
        if (i == 0) continue;
        std::uint32_t at = middle + 1 + static_cast<std::uint32_t>(i);
        m->indices.insert(m->indices.end(), {middle, at - 1, at});
    }
}

} // namespace view
