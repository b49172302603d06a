/* KITTYCAD_boundary_representation (Khronos glTF pull request 2343, draft): solid -> shells ->
 * faces -> surfaces. A solid is taken exactly when all its faces are whole NURBS surfaces; planes,
 * cylinders and trimmed faces are not read, then the triangles of the node stand in. */
#include "io/gltf_internal.h"

#include <algorithm>
#include <cmath>

namespace btg_gltf {

/* ---- references --------------------------------------------------------------------------- */

/* Orientable objects are referred to as [index, +-1]; a bare index is understood too. */
static size_t reference(const Json &value, size_t count, const char *what,
                        const std::string &path) {
    if (!value.is_array()) return need_index(value, count, what, path);
    if (value.empty()) malformed(path, "an index is needed here");
    return need_index(value[0], count, what, at(path, size_t(0)));
}

static std::vector<size_t> references(const Json &object, const char *key, size_t count,
                                      const char *what, const std::string &path) {
    const Json &list = array_member(object, key, path);
    std::vector<size_t> out;
    for (size_t i = 0; i < list.size(); i++)
        out.push_back(reference(list[i], count, what, at(at(path, key), i)));
    return out;
}

Brep::Brep(const Json *given, size_t mesh_count)
    : extension(given), path(at("extensions", brep_extension)), mesh_solid(mesh_count, -1) {
    if (extension == nullptr) return;
    need_object(*extension, path);
    const Json &solids = array_member(*extension, "solids", path);
    for (size_t i = 0; i < solids.size(); i++) {
        std::string here = at(at(path, "solids"), i);
        const Json *mesh = find(need_object(solids[i], here), "mesh");
        if (mesh == nullptr || mesh->is_null()) continue;
        uint64_t index = need_index(*mesh, mesh_count, "meshes", at(here, "mesh"));
        if (mesh_solid[index] >= 0)
            malformed(at(here, "mesh"), "another solid has this mesh already");
        mesh_solid[index] = static_cast<int>(i);
    }
}

std::optional<size_t> Brep::solid_of(const Json &node, const std::string &node_path,
                                     int mesh) const {
    if (const Json *own = find_extension(node, brep_extension, node_path)) {
        std::string here = at(at(node_path, "extensions"), brep_extension);
        if (const Json *solid = find(need_object(*own, here), "solid")) {
            size_t count =
                extension == nullptr ? 0 : array_member(*extension, "solids", path).size();
            return need_index(*solid, count, "solids", at(here, "solid"));
        }
    }
    if (mesh < 0 || mesh_solid[static_cast<size_t>(mesh)] < 0) return std::nullopt;
    return static_cast<size_t>(mesh_solid[static_cast<size_t>(mesh)]);
}

std::vector<size_t> Brep::faces_of(size_t solid) const {
    std::string here = at(at(path, "solids"), solid);
    const Json &shells = array_member(*extension, "shells", path);
    size_t face_count = array_member(*extension, "faces", path).size();
    std::vector<size_t> out;
    for (size_t shell :
         references((*extension)["solids"][solid], "shells", shells.size(), "shells", here)) {
        std::string shell_path = at(at(path, "shells"), shell);
        std::vector<size_t> list = references(need_object(shells[shell], shell_path), "faces",
                                              face_count, "faces", shell_path);
        out.insert(out.end(), list.begin(), list.end());
        if (out.size() > face_count) malformed(here, "its shells share a face");
    }
    return out;
}

/* ---- trimming ----------------------------------------------------------------------------- */

static bool near(const std::array<double, 3> &a, const double *b, double tolerance) {
    double distance = 0;
    for (size_t i = 0; i < 3; i++)
        distance = std::max(distance, std::fabs(a[i] - b[i]));
    return distance <= tolerance;
}

static bool at_corner(const std::array<double, 3> &point, const Surface &surface) {
    const double *p = surface.points.data();
    double scale = 0;
    for (double x : surface.points)
        scale = std::max(scale, std::fabs(x));
    double tolerance = 1e-6 * scale; /* single precision, as exporters round vertices */
    size_t count_v = static_cast<size_t>(surface.count_v);
    size_t last_row = count_v * static_cast<size_t>(surface.count_u - 1);
    for (size_t corner : {size_t(0), count_v - 1, last_row, last_row + count_v - 1})
        if (near(point, p + 3 * corner, tolerance)) return true;
    return false;
}

std::optional<std::array<double, 3>> Brep::vertex(const Json &edge, const char *end,
                                                  const std::string &edge_path) const {
    const Json *index = find(need_object(edge, edge_path), end);
    if (index == nullptr || index->is_null()) return std::nullopt;
    const Json &list = array_member(*extension, "vertices", path);
    uint64_t number = need_index(*index, list.size(), "vertices", at(edge_path, end));
    std::vector<double> point = need_numbers(list[number], 3, at(at(path, "vertices"), number));
    return std::array<double, 3>{point[0], point[1], point[2]};
}

/* Empty when the face is the whole surface: no loop, or one of up to four edges (sides may be
 * poles) that all run between the surface's corners. */
std::string Brep::trimmed(const Json &face, const std::string &face_path,
                          const Surface &surface) const {
    const Json &loops = array_member(*extension, "loops", path);
    const Json &edges = array_member(*extension, "edges", path);
    std::string reason = at(face_path, "loops") + ": a trimmed face is not supported";
    std::vector<size_t> list = references(face, "loops", loops.size(), "loops", face_path);
    if (list.empty()) return "";
    if (list.size() > 1) return reason;
    std::string loop_path = at(at(path, "loops"), list[0]);
    const Json &loop = need_object(loops[list[0]], loop_path);
    if (array_member(loop, "edges", loop_path).size() > 4) return reason;
    std::vector<size_t> around = references(loop, "edges", edges.size(), "edges", loop_path);
    for (size_t edge : around)
        for (const char *end : {"start", "end"}) {
            auto point = vertex(edges[edge], end, at(at(path, "edges"), edge));
            if (!point || !at_corner(*point, surface)) return reason;
        }
    return "";
}

/* ---- surfaces ----------------------------------------------------------------------------- */

/* Why a surface is no NURBS; empty when it is one. */
static std::string other_type(const Json &surface, const std::string &path) {
    const Json &type = need_member(surface, "type", path);
    if (!type.is_string()) malformed(at(path, "type"), "a string is needed here");
    if (type == "nurbs") return "";
    return at(path, "type") + ": surfaces of type " +
           plain(type.get_ref<const std::string &>(), 32) + " are not supported";
}

Exact Brep::faces(const std::vector<size_t> &list, Budget &budget) const {
    const Json &faces = array_member(*extension, "faces", path);
    const Json &surfaces = array_member(*extension, "surfaces", path);
    Exact exact;
    for (size_t face : list) {
        std::string face_path = at(at(path, "faces"), face);
        const Json &value = need_member(faces[face], "surface", face_path);
        size_t index = reference(value, surfaces.size(), "surfaces", at(face_path, "surface"));
        std::string here = at(at(path, "surfaces"), index);
        exact.obstacle = other_type(surfaces[index], here);
        if (!exact.obstacle.empty()) return exact;
        const Json &nurbs = need_member(surfaces[index], "nurbs", here);
        Surface surface = read_kittycad_nurbs(nurbs, at(here, "nurbs"), budget);
        exact.obstacle = trimmed(faces[face], face_path, surface);
        if (!exact.obstacle.empty()) return exact;
        exact.surfaces.push_back(std::move(surface));
    }
    return exact;
}

Exact Brep::solid(size_t index, Budget &budget) const {
    std::vector<size_t> list = faces_of(index);
    budget.spend(list.size() + 1, at(at(path, "solids"), index));
    if (list.empty()) return {{}, at(at(path, "solids"), index) + ": has no faces"};
    return faces(list, budget);
}

bool Brep::loose() const {
    return extension != nullptr && array_member(*extension, "solids", path).empty() &&
           array_member(*extension, "faces", path).empty() &&
           !array_member(*extension, "surfaces", path).empty();
}

Exact Brep::loose_surfaces(Budget &budget) const {
    const Json &surfaces = array_member(*extension, "surfaces", path);
    Exact exact;
    for (size_t i = 0; i < surfaces.size(); i++) {
        std::string here = at(at(path, "surfaces"), i);
        exact.obstacle = other_type(surfaces[i], here);
        if (!exact.obstacle.empty()) return exact;
        const Json &nurbs = need_member(surfaces[i], "nurbs", here);
        exact.surfaces.push_back(read_kittycad_nurbs(nurbs, at(here, "nurbs"), budget));
    }
    return exact;
}

} // namespace btg_gltf
