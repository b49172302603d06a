/* Where the picture is taken from: a camera that turns about a point, z up. Lengths in mm. */
#ifndef BTG_VIEW_CAMERA_H
#define BTG_VIEW_CAMERA_H

#include <glm/glm.hpp>

namespace view {

struct camera {
    glm::dvec3 target{0};
    double azimuth_deg = -60;  /* of the eye, from +x toward +y */
    double elevation_deg = 25; /* of the eye over the horizon, -90 .. 90 */
    double distance = 100;     /* eye to target, > 0 */
    double aside = 0;          /* the target stands so far left of the middle, of the width */
};

constexpr double camera_fov_deg = 30; /* of the picture's height */

glm::dvec3 camera_eye(const camera &c);
/* Unit; from eye to target, and what is right and up in the picture. */
glm::dvec3 camera_ahead(const camera &c);
glm::dvec3 camera_right(const camera &c);
glm::dvec3 camera_up(const camera &c);

/* Points relative to `origin`, in single precision, to clip space; near and far planes about the
 * sphere (centre, radius), that is all there is to see. */
glm::mat4 camera_matrix(const camera &c, double aspect, glm::dvec3 origin, glm::dvec3 centre,
                        double radius);
/* Pixels, from the picture's upper left; z: 0 .. 1 inside near and far, anything else is not seen.
 */
glm::dvec3 camera_project(const glm::mat4 &matrix, glm::dvec3 origin, glm::dvec2 size,
                          glm::dvec3 point);
/* mm that one pixel covers at a point. */
double camera_pixel(const camera &c, double height_pixels, glm::dvec3 point);

/* Shows a sphere whole. */
void camera_fit(camera *c, glm::dvec3 centre, double radius, double aspect);
/* Mouse moves in pixels; `zoom` > 0 nearer. */
void camera_orbit(camera *c, double right, double down);
void camera_pan(camera *c, double right, double down, double height_pixels);
void camera_zoom(camera *c, double steps);

} // namespace view

#endif
