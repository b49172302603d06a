/* The tool of one position and the geometry its picture tells: frames before and after the tilt,
 * contacts, the circle on which Q came. Part frame, mm. */
#ifndef BTG_VIEW_POSE_H
#define BTG_VIEW_POSE_H

#include "bitangent/bitangent.h"

#include <glm/glm.hpp>

namespace view {

inline glm::dvec3 to_glm(btg_vec3 p) {
    return {p.x, p.y, p.z};
}
inline btg_vec3 from_glm(glm::dvec3 p) {
    return {p.x, p.y, p.z};
}

struct pose {
    bool placed; /* the tool stands somewhere: tip and axis exist */
    bool has_p, has_q;
    glm::dvec3 tip, axis, centre; /* centre: of the torus */
    glm::dvec3 p, np, q, nq;
    /* {u, v, axis} at o1, the pseudo-insert's centre; `framed`: they exist. Before the tilt the
     * tool stood turned about u by +tilt. */
    bool framed;
    glm::dvec3 o1, u, v;
    double tilt_rad;
    glm::dvec3 dropped_axis, dropped_centre;
};

pose pose_of(const btg_tool &tool, const btg_position &position);

/* `point` turned about the line through `origin` along unit `axis`. */
glm::dvec3 turned(glm::dvec3 point, glm::dvec3 origin, glm::dvec3 axis, double angle_rad);
/* The same for a direction. */
glm::dvec3 turned(glm::dvec3 direction, glm::dvec3 axis, double angle_rad);
/* A unit vector at right angles to a unit vector. */
glm::dvec3 perpendicular(glm::dvec3 axis);

/* For paths that tell tip and axis alone: contacts and tilt as the part gives them, found by
 * dropping the tool along its axis and tilting it on from there; what stands off the part by more
 * than `tolerance_mm` or cuts into it keeps no contacts. `workspace` as for btg_position_solve. */
btg_position position_at(const btg_part *part, const btg_tool &tool, const btg_solver_def &solver,
                         glm::dvec3 tip, glm::dvec3 axis, double tolerance_mm, void *workspace,
                         size_t workspace_size);

} // namespace view

#endif
