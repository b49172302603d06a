/* The picture: part, tool, contacts and what explains them. */
#ifndef BTG_VIEW_SCENE_H
#define BTG_VIEW_SCENE_H

#include "view/canvas.h"
#include "view/state.h"

extern "C" {
#include "io/palette.h"
}

namespace view {

/* On the device, made anew when the part, the path or the field changes. */
struct scene {
    canvas *on = nullptr;
    std::shared_ptr<subject> part;
    std::shared_ptr<tour> path;
    std::shared_ptr<field> left;
    glm::dvec3 origin{0}; /* single precision counts from here */
    glm::dvec3 centre{0}; /* of all there is to see */
    double radius = 1;
    buffer surface, tool[BTG_HOLDER_MAX + 2], rod, trail_p, trail_q;
};

/* False: the part cannot be drawn. */
bool scene_update(scene *s, const state &st, std::string *why);
void scene_draw(scene *s, const state &st);
void scene_free(scene *s);

/* Pixels from the upper left of a picture `size`; z outside 0 .. 1: not in it. */
glm::dvec3 scene_project(const scene &s, glm::dvec2 size, glm::dvec3 point);

/* The arc of the tilt stands so far over the tip, in outer radii of the tool. */
constexpr double lean_arc = 2.3;

/* Of contacts: as in the pictures of paths. */
constexpr glm::vec3 colour_p{BTG_RGB_P}, colour_q{BTG_RGB_Q};
constexpr glm::vec3 colour_osculating{BTG_RGB_OSCULATING}, colour_line{BTG_RGB_INK};
constexpr glm::vec3 colour_insert{0.00f, 0.55f, 0.40f};
constexpr glm::vec3 colour_ray{0.72f, 0.25f, 0.58f};
constexpr glm::vec3 colour_gouge{0.60f, 0.10f, 0.05f};
constexpr glm::vec3 colour_lean{0.27f, 0.29f, 0.33f};

} // namespace view

#endif
