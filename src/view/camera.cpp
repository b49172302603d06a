#include "view/camera.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

namespace view {

static constexpr double degree = 3.14159265358979323846 / 180;
static constexpr double degrees_per_pixel = 0.35;
static constexpr double zoom_per_step = 1.15;
static constexpr double distance_min = 1e-3, distance_max = 1e7;

glm::dvec3 camera_ahead(const camera &c) {
    double a = c.azimuth_deg * degree, e = c.elevation_deg * degree;
    return -glm::dvec3(std::cos(a) * std::cos(e), std::sin(a) * std::cos(e), std::sin(e));
}

glm::dvec3 camera_right(const camera &c) {
    double a = c.azimuth_deg * degree;
    return {-std::sin(a), std::cos(a), 0};
}

glm::dvec3 camera_up(const camera &c) {
    return glm::cross(camera_right(c), camera_ahead(c));
}

glm::dvec3 camera_eye(const camera &c) {
    return c.target - c.distance * camera_ahead(c);
}

glm::mat4 camera_matrix(const camera &c, double aspect, glm::dvec3 origin, glm::dvec3 centre,
                        double radius) {
    glm::dvec3 eye = camera_eye(c);
    double depth = glm::dot(centre - eye, camera_ahead(c));
    double far = std::max(depth + radius, 2 * c.distance);
    /* No nearer than a 24-bit depth tells apart. */
    double near = std::clamp(depth - radius, std::min(far * 1e-3, c.distance * 0.1), far * 0.9);
    glm::dmat4 look(1);
    glm::dvec3 axis[3] = {camera_right(c), camera_up(c), -camera_ahead(c)};
    for (int row = 0; row < 3; row++) {
        for (int column = 0; column < 3; column++)
            look[column][row] = axis[row][column];
        look[3][row] = glm::dot(axis[row], origin - eye);
    }
    glm::dmat4 lens = glm::perspective(camera_fov_deg * degree, aspect, near, far);
    lens[2][0] += 2 * c.aside;
    return glm::mat4(lens * look);
}

glm::dvec3 camera_project(const glm::mat4 &matrix, glm::dvec3 origin, glm::dvec2 size,
                          glm::dvec3 point) {
    glm::dvec4 clip = glm::dmat4(matrix) * glm::dvec4(point - origin, 1);
    if (!(clip.w > 0)) return {0, 0, -1};
    glm::dvec3 at = glm::dvec3(clip) / clip.w;
    return {size.x * (0.5 + 0.5 * at.x), size.y * (0.5 - 0.5 * at.y), 0.5 + 0.5 * at.z};
}

double camera_pixel(const camera &c, double height_pixels, glm::dvec3 point) {
    double depth = std::max(glm::dot(point - camera_eye(c), camera_ahead(c)), 1e-6);
    return 2 * depth * std::tan(0.5 * camera_fov_deg * degree) / height_pixels;
}

void camera_fit(camera *c, glm::dvec3 centre, double radius, double aspect) {
    double half = std::sin(0.5 * camera_fov_deg * degree) * std::min(1.0, aspect);
    c->target = centre;
    c->distance = std::clamp(radius / half, distance_min, distance_max);
}

void camera_orbit(camera *c, double right, double down) {
    c->azimuth_deg = std::remainder(c->azimuth_deg - degrees_per_pixel * right, 360.0);
    c->elevation_deg = std::clamp(c->elevation_deg + degrees_per_pixel * down, -90.0, 90.0);
}

void camera_pan(camera *c, double right, double down, double height_pixels) {
    double mm = camera_pixel(*c, height_pixels, c->target);
    c->target += mm * (-right * camera_right(*c) + down * camera_up(*c));
}

void camera_zoom(camera *c, double steps) {
    c->distance =
        std::clamp(c->distance * std::pow(zoom_per_step, -steps), distance_min, distance_max);
}

} // namespace view
