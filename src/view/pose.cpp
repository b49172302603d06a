#include "view/pose.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace view {

static bool finite(glm::dvec3 p) {
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

glm::dvec3 turned(glm::dvec3 d, glm::dvec3 axis, double angle) {
    double c = std::cos(angle), s = std::sin(angle);
    return d * c + glm::cross(axis, d) * s + axis * (glm::dot(axis, d) * (1 - c));
}

glm::dvec3 turned(glm::dvec3 point, glm::dvec3 origin, glm::dvec3 axis, double angle) {
    return origin + turned(point - origin, axis, angle);
}

glm::dvec3 perpendicular(glm::dvec3 axis) {
    glm::dvec3 e = std::fabs(axis.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    return glm::normalize(glm::cross(axis, e));
}

/* What a file says of a contact may be anything. */
static bool is_contact(glm::dvec3 point, glm::dvec3 normal) {
    return finite(point) && finite(normal) && glm::length(point) <= 4 * BTG_LENGTH_MAX &&
           std::fabs(glm::length(normal) - 1) < 0.01;
}

/* v points from o1 to the tool axis; where P is on the axis there is no such direction. */
static void frame(pose *s, const btg_tool &tool) {
    s->o1 = s->p + tool.def.minor_radius_mm * s->np;
    glm::dvec3 out = s->centre - s->o1;
    out -= s->axis * glm::dot(out, s->axis);
    double length = glm::length(out);
    if (!(length > 1e-9 * (1 + tool.def.major_radius_mm))) return;
    s->v = out / length;
    s->u = glm::cross(s->v, s->axis);
    s->framed = true;
    s->dropped_axis = turned(s->axis, s->u, s->tilt_rad);
    s->dropped_centre = turned(s->centre, s->o1, s->u, s->tilt_rad);
}

pose pose_of(const btg_tool &tool, const btg_position &at) {
    pose s = {};
    s.tip = to_glm(at.tip);
    s.axis = to_glm(at.axis);
    s.placed = at.status >= 0 && at.status != BTG_NO_CONTACT && finite(s.tip) && finite(s.axis);
    if (!s.placed) return s;
    s.centre = s.tip + tool.def.minor_radius_mm * s.axis;
    s.p = to_glm(at.p.point), s.np = to_glm(at.p.normal);
    s.q = to_glm(at.q.point), s.nq = to_glm(at.q.normal);
    s.has_p = is_contact(s.p, s.np);
    s.has_q = s.has_p && is_contact(s.q, s.nq);
    s.tilt_rad = std::fabs(at.tilt_rad) <= 4 ? at.tilt_rad : 0;
    if (s.has_p) frame(&s, tool);
    return s;
}

static btg_contact no_contact() {
    btg_vec3 none = {NAN, NAN, NAN};
    return {{0, 0, 0}, none, none};
}

static void second_contact(const btg_part *part, const btg_tool &tool, const btg_solver_def &solver,
                           double tolerance_mm, void *workspace, size_t size, btg_position *at) {
    pose s = pose_of(tool, *at);
    btg_tilt_query query = {};
    btg_tilt_result result;
    if (!s.framed) return;
    query.u = from_glm(s.u), query.v = from_glm(s.v), query.w = at->axis;
    query.o1 = from_glm(s.centre - tool.def.major_radius_mm * s.v);
    query.p = at->p;
    query.max_tilt_rad = solver.max_tilt_rad;
    btg_status status = btg_tilt(part, &tool, &solver, &query, workspace, size, &result);
    double reach = tool.def.major_radius_mm + tool.def.minor_radius_mm;
    if (status < 0 || (result.status != BTG_OK && result.status != BTG_OSCULATING)) return;
    if (!(result.tilt_rad * reach <= tolerance_mm)) return;
    at->status = result.status;
    at->q = result.contact;
    /* Dropped upright, the tool tilted about a level line at P. */
    btg_position swapped = *at;
    std::swap(swapped.p, swapped.q);
    pose other = pose_of(tool, swapped);
    if (other.framed && std::fabs(other.u.z) < std::fabs(s.u.z)) *at = swapped;
}

btg_position position_at(const btg_part *part, const btg_tool &tool, const btg_solver_def &solver,
                         glm::dvec3 tip, glm::dvec3 axis, double tolerance_mm, void *workspace,
                         size_t workspace_size) {
    btg_position at = {};
    glm::dvec3 centre = tip + tool.def.minor_radius_mm * axis;
    at.status = BTG_SINGLE_CONTACT;
    at.tip = from_glm(tip), at.axis = from_glm(axis);
    at.p = at.q = no_contact();
    at.foot_x_mm = tip.x, at.foot_y_mm = tip.y;
    at.drop_z_mm = at.tilt_rad = at.spin_rad = at.inclination_rad = at.bound_mm = NAN;
    btg_drop_query query = {};
    btg_drop_result drop;
    query.origin = from_glm(centre), query.axis = at.axis;
    btg_status status = btg_drop(part, &tool, &solver, &query, workspace, workspace_size, &drop);
    if (status < 0 || drop.status != BTG_OK) return at;
    at.bound_mm = std::fmax(drop.height_mm, 0.0) + drop.bound_mm;
    if (std::fabs(drop.height_mm) > tolerance_mm) return at;
    at.p = drop.contact;
    at.tilt_rad = std::acos(std::fmax(-1.0, std::fmin(1.0, axis.z)));
    if (drop.element == 0)
        second_contact(part, tool, solver, tolerance_mm, workspace, workspace_size, &at);
    glm::dvec3 n = to_glm(at.p.normal);
    pose framed = pose_of(tool, at);
    at.inclination_rad = framed.framed ? std::atan2(glm::dot(n, framed.v), glm::dot(n, axis))
                                       : std::acos(std::clamp(glm::dot(n, axis), -1.0, 1.0));
    return at;
}

} // namespace view
