#include "view/scene.h"
#include "view/pose.h"

extern "C" {
#include "io/scene.h"
#include "io/shape.h"
}

#include <algorithm>
#include <cmath>

namespace view {

static constexpr std::size_t triangles_max = 20000000;
/* Pixels: half the width of lines, radius of a contact's mark. */
static constexpr double line_px = 2.0, mark_px = 7.5, thin_px = 1.3;
/* A mark is drawn a little nearer than it is, so that the surfaces that touch there leave it whole.
 */
static constexpr float see_through = 0.75f;

/* ---- the part ----------------------------------------------------------------------------- */

static glm::vec3 near_origin(const scene &s, glm::dvec3 p) {
    return glm::vec3(p - s.origin);
}

static buffer keep(scene *s, const btg_shape &shape, glm::dvec3 origin) {
    mesh m;
    glm::vec3 from(origin);
    m.vertices.reserve(shape.point_count);
    for (std::size_t i = 0; i < shape.point_count; i++) {
        const float *p = shape.points + 3 * i, *n = shape.normals + 3 * i;
        m.vertices.push_back({glm::vec3(p[0], p[1], p[2]) - from, {n[0], n[1], n[2]}});
    }
    m.indices.assign(shape.indices, shape.indices + shape.index_count);
    return canvas_triangles(s->on, m);
}

static bool make_surface(scene *s, std::string *why) {
    btg_shape shape = {};
    btg_message message;
    bool done = btg_shape_part(&shape, s->part->part, triangles_max, &message) == BTG_OK;
    if (done)
        s->surface = keep(s, shape, s->origin);
    else
        *why = message.text;
    btg_shape_release(&shape);
    return done;
}

/* ---- the tool, in its own frame: axis z, tip at 0 ----------------------------------------- */

static void make_tool(scene *s) {
    const btg_tool &tool = s->part->tool;
    for (std::uint32_t i = 0; i < tool.element_count; i++) {
        btg_shape shape = {};
        if (btg_shape_tool(&shape, &tool, i) == BTG_OK) s->tool[i] = keep(s, shape, glm::dvec3(0));
        btg_shape_release(&shape);
    }
    btg_shape rod = {};
    bool bare = tool.element_count == 1;
    if (bare && btg_shape_rod(&rod, &tool, btg_scene_tool_mm(&tool)) == BTG_OK)
        s->rod = keep(s, rod, glm::dvec3(0));
    btg_shape_release(&rod);
}

/* ---- the path ----------------------------------------------------------------------------- */

/* From each position to the next of its pass; a little over the part, to be seen. */
static void make_trails(scene *s) {
    std::vector<glm::vec3> p, q;
    if (!s->path) return;
    const btg_tool_def &d = s->part->tool.def;
    double over = 0.01 * (d.major_radius_mm + d.minor_radius_mm);
    pose before = {};
    std::uint32_t pass = 0;
    for (const btg_row &row : s->path->rows) {
        pose at = pose_of(s->part->tool, row.position);
        bool same = row.pass == pass;
        if (same && at.has_p && before.has_p)
            for (const pose *end : {&before, &at})
                p.push_back(near_origin(*s, end->p + over * end->np));
        if (same && at.has_q && before.has_q)
            for (const pose *end : {&before, &at})
                q.push_back(near_origin(*s, end->q + over * end->nq));
        before = at, pass = row.pass;
    }
    s->trail_p = canvas_lines(s->on, p);
    s->trail_q = canvas_lines(s->on, q);
}

static void free_trails(scene *s) {
    canvas_free(s->on, &s->trail_p);
    canvas_free(s->on, &s->trail_q);
}

void scene_free(scene *s) {
    if (!s->on) return;
    for (buffer &b : s->tool)
        canvas_free(s->on, &b);
    canvas_free(s->on, &s->surface);
    canvas_free(s->on, &s->rod);
    free_trails(s);
    canvas_free_map(s->on);
    canvas *on = s->on;
    *s = scene();
    s->on = on;
}

static bool take_part(scene *s, const state &st, std::string *why) {
    scene_free(s);
    s->part = st.part;
    if (!s->part) return true;
    glm::dvec3 low = to_glm(s->part->info.box_min), high = to_glm(s->part->info.box_max);
    s->origin = s->centre = 0.5 * (low + high);
    s->radius = 0.5 * glm::distance(low, high) + 3 * btg_scene_tool_mm(&s->part->tool);
    if (!make_surface(s, why)) return false;
    make_tool(s);
    return true;
}

bool scene_update(scene *s, const state &st, std::string *why) {
    bool fresh = s->part != st.part;
    if (fresh && !take_part(s, st, why)) return false;
    if (fresh || s->path != st.path) {
        free_trails(s);
        s->path = st.path;
        make_trails(s);
    }
    if (s->left != st.left) {
        s->left = st.left;
        canvas_free_map(s->on);
        if (const field *f = s->left.get()) {
            double x = f->x_mm - 0.5 * f->cell_mm - s->origin.x;
            double y = f->y_mm - 0.5 * f->cell_mm - s->origin.y;
            canvas_set_map(s->on, f->width, f->height, f->rgba.data(),
                           {x, y, 1 / (f->width * f->cell_mm), 1 / (f->height * f->cell_mm)});
        }
    }
    return true;
}

glm::dvec3 scene_project(const scene &s, glm::dvec2 size, glm::dvec3 point) {
    return camera_project(s.on->matrix, s.origin, size, point);
}

/* ---- drawing ------------------------------------------------------------------------------ */

/* One picture's pen: sizes in pixels at the place where something is. */
struct pen {
    const scene *s;
    const camera *eye;
    double height;
    double mm(glm::dvec3 at, double pixels) const {
        return pixels * camera_pixel(*eye, height, at);
    }
};

static ink coloured(glm::vec3 colour, float alpha = 1) {
    ink i;
    i.colour = glm::vec4(colour, alpha);
    return i;
}

/* Where it is hidden it shines through, paler. */
static void draw_through(scene *s, const mesh &m, glm::vec3 colour) {
    ink i = coloured(colour, see_through);
    i.behind = true;
    canvas_draw_once(s->on, m, i);
    canvas_draw_once(s->on, m, coloured(colour));
}

static void rod(const pen &p, mesh *m, const std::vector<glm::dvec3> &points, double pixels) {
    std::vector<glm::vec3> near;
    for (glm::dvec3 point : points)
        near.push_back(near_origin(*p.s, point));
    add_rod(m, near, static_cast<float>(p.mm(points[points.size() / 2], pixels)));
}

static void dashes(const pen &p, mesh *m, glm::dvec3 from, glm::dvec3 to, double pixels) {
    double length = glm::distance(from, to), piece = p.mm(0.5 * (from + to), 9);
    int count = static_cast<int>(std::clamp(length / piece, 1.0, 400.0));
    for (int i = 0; i < count; i += 2)
        rod(p, m, {glm::mix(from, to, double(i) / count), glm::mix(from, to, (i + 1.0) / count)},
            pixels);
}

/* Points of a turn about a line, the end included. */
static std::vector<glm::dvec3> arc(glm::dvec3 point, glm::dvec3 origin, glm::dvec3 axis,
                                   double angle) {
    std::vector<glm::dvec3> points;
    for (int i = 0; i <= 48; i++)
        points.push_back(turned(point, origin, axis, angle * i / 48));
    return points;
}

static void draw_contacts(scene *s, const pen &p, const pose &at, bool osculating) {
    if (!at.has_p) return;
    if (at.has_q && !osculating) {
        mesh line;
        rod(p, &line, {at.p, at.q}, line_px);
        draw_through(s, line, colour_line);
    }
    mesh mark;
    add_sphere(&mark, near_origin(*s, at.p), static_cast<float>(p.mm(at.p, mark_px)));
    draw_through(s, mark, osculating ? colour_osculating : colour_p);
    if (!at.has_q || osculating) return;
    mesh second;
    add_sphere(&second, near_origin(*s, at.q), static_cast<float>(p.mm(at.q, mark_px)));
    draw_through(s, second, colour_q);
}

static void draw_normals(scene *s, const pen &p, const pose &at, double reach) {
    mesh first, second;
    if (at.has_p)
        add_arrow(&first, near_origin(*s, at.p), near_origin(*s, at.p + 0.9 * reach * at.np),
                  static_cast<float>(p.mm(at.p, line_px)));
    if (at.has_q)
        add_arrow(&second, near_origin(*s, at.q), near_origin(*s, at.q + 0.9 * reach * at.nq),
                  static_cast<float>(p.mm(at.q, line_px)));
    draw_through(s, first, colour_p);
    draw_through(s, second, colour_q);
}

/* The tube circle that touches at P, in the half-plane through the axis. */
static void draw_insert(scene *s, const pen &p, const pose &at, const btg_tool_def &d) {
    if (!at.framed || !(d.minor_radius_mm > 0)) return;
    mesh edge, middle;
    glm::dvec3 o1 = at.centre - d.major_radius_mm * at.v;
    rod(p, &edge, arc(o1 - d.minor_radius_mm * at.axis, o1, at.u, 2 * 3.14159265358979), line_px);
    add_sphere(&middle, near_origin(*s, o1), static_cast<float>(p.mm(o1, 4)));
    draw_through(s, edge, colour_insert);
    draw_through(s, middle, colour_insert);
}

/* On its circle about the pseudo-insert's axis Q came from where the dropped tool stood off. */
static void draw_ray(scene *s, const pen &p, const pose &at) {
    if (!at.framed || !at.has_q) return;
    glm::dvec3 middle = at.o1 + at.u * glm::dot(at.q - at.o1, at.u);
    mesh ray, spokes, axis;
    std::vector<glm::dvec3> points = arc(at.q, middle, at.u, at.tilt_rad);
    rod(p, &ray, points, line_px);
    dashes(p, &spokes, middle, at.q, thin_px);
    dashes(p, &spokes, middle, points.back(), thin_px);
    double half = p.mm(at.o1, 40);
    rod(p, &axis, {at.o1 - half * at.u, at.o1 + half * at.u}, thin_px);
    draw_through(s, ray, colour_ray);
    draw_through(s, spokes, colour_ray);
    draw_through(s, axis, colour_insert);
}

/* The axis as dropped, as tilted, and the angle between. */
static void draw_lean(scene *s, const pen &p, const pose &at, double reach) {
    if (!at.placed) return;
    mesh after, before, angle;
    double height = btg_scene_tool_mm(&s->part->tool) + 0.6 * reach;
    rod(p, &after, {at.tip, at.tip + height * at.axis}, thin_px);
    draw_through(s, after, colour_line);
    if (!at.framed || !(at.tilt_rad > 1e-4)) return;
    glm::dvec3 top = at.tip + height * at.axis;
    dashes(p, &before, at.tip, turned(top, at.tip, at.u, at.tilt_rad), thin_px);
    rod(p, &angle, arc(at.tip + lean_arc * reach * at.axis, at.tip, at.u, at.tilt_rad), thin_px);
    draw_through(s, before, colour_lean);
    draw_through(s, angle, colour_lean);
}

static glm::mat4 tool_matrix(const scene &s, const pose &at) {
    glm::dvec3 x = at.framed ? at.u : perpendicular(at.axis);
    glm::dvec3 y = glm::cross(at.axis, x);
    glm::dmat4 m(1);
    m[0] = glm::dvec4(x, 0), m[1] = glm::dvec4(y, 0), m[2] = glm::dvec4(at.axis, 0);
    m[3] = glm::dvec4(at.tip - s.origin, 1);
    return glm::mat4(m);
}

static constexpr glm::vec3 paint_part{0.70f, 0.76f, 0.82f};
static constexpr glm::vec3 paint_rod{0.84f, 0.87f, 0.90f};

static glm::vec3 paint_of(btg_solid solid) {
    if (solid == BTG_SOLID_INSERT) return {0.86f, 0.78f, 0.52f};
    return solid == BTG_SOLID_SHANK ? paint_rod : glm::vec3(0.58f, 0.62f, 0.68f);
}

/* The rod that stands for a shank where none is given is always seen through: it is not there. */
static void draw_tool(scene *s, const pose &at, tool_look look) {
    const btg_tool &tool = s->part->tool;
    glm::mat4 where = tool_matrix(*s, at);
    for (std::uint32_t i = 0; i < tool.element_count; i++) {
        glm::vec3 paint = paint_of(btg_shape_solid(&tool, i));
        if (look == tool_look::clear)
            canvas_draw_clear(s->on, s->tool[i], where, coloured(paint, 0.4f));
        else
            canvas_draw(s->on, s->tool[i], where, coloured(paint));
    }
    canvas_draw_clear(s->on, s->rod, where, coloured(paint_rod, 0.3f));
}

static void draw_trails(scene *s) {
    ink first = coloured(colour_p, 0.75f), second = coloured(colour_q, 0.75f);
    first.lit = second.lit = false;
    canvas_draw_lines(s->on, s->trail_p, first);
    canvas_draw_lines(s->on, s->trail_q, second);
}

void scene_draw(scene *s, const state &st) {
    canvas *c = s->on;
    if (!s->part) return;
    c->matrix =
        camera_matrix(st.eye, double(c->width) / c->height, s->origin, s->centre, s->radius);
    c->eye = near_origin(*s, camera_eye(st.eye));
    pen p = {s, &st.eye, double(c->height)};
    ink surface = coloured(paint_part);
    surface.mapped = st.gouge;
    canvas_draw(c, s->surface, glm::mat4(1), surface);
    if (st.trail) draw_trails(s);
    const btg_row *row = current(st);
    if (!row) return;
    const btg_tool_def &d = s->part->tool.def;
    pose at = pose_of(s->part->tool, row->position);
    double reach = d.major_radius_mm + d.minor_radius_mm;
    if (!at.placed) return;
    if (st.tool == tool_look::solid) draw_tool(s, at, st.tool);
    if (st.lean) draw_lean(s, p, at, reach);
    if (st.insert) draw_insert(s, p, at, d);
    if (st.ray) draw_ray(s, p, at);
    if (st.normals) draw_normals(s, p, at, reach);
    draw_contacts(s, p, at, row->position.status == BTG_OSCULATING);
    if (st.tool == tool_look::clear) draw_tool(s, at, st.tool);
}

} // namespace view
