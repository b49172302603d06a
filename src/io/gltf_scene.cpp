/* The default scene: node hierarchy, transforms, units and axes. */
#include "io/gltf_internal.h"

#include <algorithm>
#include <cmath>

namespace btg_gltf {

/* ---- budget ------------------------------------------------------------------------------- */

/* Room for a few thousand copies of a bolt, not for a bomb; the ceiling keeps counts in 32 bits. */
constexpr uint64_t budget_floor = 5000000, budget_ceiling = 200000000, budget_per_byte = 64;

Budget::Budget(uint64_t bytes)
    : left(bytes > budget_ceiling
               ? budget_ceiling
               : std::min(budget_ceiling, budget_floor + budget_per_byte * bytes)) {}

void Budget::spend(uint64_t items, const std::string &path) {
    if (items > left)
        fail(BTG_ERROR_MEMORY, path,
             "asks for more vertices or control points than a file of this "
             "size can mean; check counts and instances");
    left -= items;
}

/* ---- transforms --------------------------------------------------------------------------- */

Affine Affine::identity() {
    return {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
}

Affine Affine::operator*(const Affine &right) const {
    Affine out;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++) {
            out.m[i][j] = j == 3 ? m[i][3] : 0.0;
            for (int k = 0; k < 3; k++)
                out.m[i][j] += m[i][k] * right.m[k][j];
        }
    return out;
}

void Affine::apply(const double in[3], double out[3]) const {
    for (int i = 0; i < 3; i++)
        out[i] = m[i][0] * in[0] + m[i][1] * in[1] + m[i][2] * in[2] + m[i][3];
}

bool Affine::operator==(const Affine &other) const {
    return std::equal(&m[0][0], &m[0][0] + 12, &other.m[0][0]);
}

bool Placement::apply(double point[3]) const {
    double p[3];
    node.apply(point, p);
    double k = unit == BTG_GLTF_METRE ? 1000.0 : 1.0;
    /* 0 - a, not -a: a zero stays +0. */
    double x = k * p[0], y = up == BTG_GLTF_UP_Y ? 0.0 - k * p[2] : k * p[1];
    double z = up == BTG_GLTF_UP_Y ? k * p[1] : k * p[2];
    point[0] = x, point[1] = y, point[2] = z;
    for (double coordinate : {x, y, z})
        if (!(std::fabs(coordinate) <= BTG_LENGTH_MAX)) return false;
    return true;
}

static void place_points(std::vector<double> &points, const Placement &placement,
                         const std::string &path, const char *what) {
    for (size_t i = 0; i < points.size(); i += 3)
        if (!placement.apply(&points[i]))
            malformed(path, what + std::to_string(i / 3) +
                                " lies beyond 1e6 mm once placed; check the data and its unit");
}

static Affine from_matrix(const std::vector<double> &c, const std::string &path) {
    if (c[3] != 0 || c[7] != 0 || c[11] != 0 || c[15] != 1)
        malformed(path, "its last row is not 0 0 0 1, so it is no affine transform");
    return {{{c[0], c[4], c[8], c[12]}, {c[1], c[5], c[9], c[13]}, {c[2], c[6], c[10], c[14]}}};
}

/* Exporters round quaternions to single precision; what is further off is a fault. */
constexpr double quaternion_slack = 1e-2;

static Affine from_rotation(const std::vector<double> &q, const std::string &path) {
    double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(std::fabs(norm - 1.0) <= quaternion_slack))
        malformed(path, "is no unit quaternion; normalise it");
    double x = q[0] / norm, y = q[1] / norm, z = q[2] / norm, w = q[3] / norm;
    return {{{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), 0},
             {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), 0},
             {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), 0}}};
}

static Affine local_transform(const tinygltf::Node &node, const std::string &path) {
    if (!node.matrix.empty()) return from_matrix(node.matrix, at(path, "matrix"));
    Affine out = Affine::identity();
    if (!node.rotation.empty()) out = from_rotation(node.rotation, at(path, "rotation"));
    for (size_t i = 0; i < 3 && !node.scale.empty(); i++)
        for (size_t row = 0; row < 3; row++)
            out.m[row][i] *= node.scale[i];
    for (size_t i = 0; i < 3 && !node.translation.empty(); i++)
        out.m[i][3] = node.translation[i];
    return out;
}

/* ---- hierarchy ---------------------------------------------------------------------------- */

static std::vector<int> find_parents(const tinygltf::Model &model) {
    std::vector<int> parent(model.nodes.size(), -1);
    for (size_t i = 0; i < model.nodes.size(); i++)
        for (size_t k = 0; k < model.nodes[i].children.size(); k++) {
            size_t child = static_cast<size_t>(model.nodes[i].children[k]);
            if (parent[child] >= 0)
                malformed(at(at(at("nodes", i), "children"), k),
                          "node " + std::to_string(child) +
                              " has another parent already; nodes must form a tree");
            parent[child] = static_cast<int>(i);
        }
    return parent;
}

/* With one parent each, a node whose way up never ends lies on a cycle or below one. */
static void refuse_cycles(const std::vector<int> &parent) {
    std::vector<size_t> walk(parent.size(), 0); /* number of the walk that came by */
    for (size_t start = 0; start < parent.size(); start++) {
        size_t node = start;
        while (walk[node] == 0) {
            walk[node] = start + 1;
            if (parent[node] < 0) break;
            node = static_cast<size_t>(parent[node]);
            if (walk[node] == start + 1)
                malformed(at("nodes", node),
                          "is among its own descendants; nodes must form a tree");
        }
    }
}

static std::vector<int> scene_roots(const tinygltf::Model &model, const std::vector<int> &parent) {
    std::vector<int> roots;
    if (model.scenes.empty()) {
        for (size_t i = 0; i < parent.size(); i++)
            if (parent[i] < 0) roots.push_back(static_cast<int>(i));
        return roots;
    }
    size_t scene = model.defaultScene < 0 ? 0 : static_cast<size_t>(model.defaultScene);
    std::vector<bool> seen(parent.size(), false);
    std::string path = at(at("scenes", scene), "nodes");
    for (size_t i = 0; i < model.scenes[scene].nodes.size(); i++) {
        size_t root = static_cast<size_t>(model.scenes[scene].nodes[i]);
        if (parent[root] >= 0)
            malformed(at(path, i), "node " + std::to_string(root) +
                                       " is a child of another node; a scene lists roots");
        if (seen[root]) malformed(at(path, i), "node " + std::to_string(root) + " is listed twice");
        seen[root] = true;
        roots.push_back(static_cast<int>(root));
    }
    return roots;
}

/* ---- gathering ---------------------------------------------------------------------------- */

class Gatherer {
  public:
    Gatherer(const Json &document, const tinygltf::Model &m, const btg_gltf_def &d, uint64_t bytes)
        : json(document), model(m), def(d), budget(bytes),
          brep(find_extension(document, brep_extension, ""), m.meshes.size()),
          quantized(extension_declared(document, quantization_extension)) {}
    Shape run(const std::vector<int> &roots);

  private:
    struct Visit {
        size_t node;
        Affine above;
    };
    const Json &json;
    const tinygltf::Model &model;
    const btg_gltf_def &def;
    Budget budget;
    Brep brep;
    bool quantized;
    Shape shape;

    std::vector<Visit> mesh_nodes(const std::vector<int> &roots) const;
    void add_node(const Visit &visit);
    bool add_solid(const Visit &visit, const Placement &placement);
    void add_mesh(size_t mesh, const Placement &placement);
    void add_primitive(size_t mesh, size_t primitive, const Placement &placement);
    bool add_loose_surfaces(const std::vector<Visit> &visits);
    void place(std::vector<Surface> &&surfaces, const Placement &placement);
    void place(Mesh &&mesh, const Placement &placement);
    bool stand_in(const std::string &obstacle, bool triangles);
};

void Gatherer::place(std::vector<Surface> &&surfaces, const Placement &placement) {
    for (Surface &surface : surfaces) {
        place_points(surface.points, placement, at(surface.path, "controlPoints"), "point ");
        shape.surfaces.push_back(std::move(surface));
    }
}

void Gatherer::place(Mesh &&mesh, const Placement &placement) {
    place_points(mesh.positions, placement, mesh.path, "vertex ");
    shape.meshes.push_back(std::move(mesh));
}

void Gatherer::add_primitive(size_t mesh, size_t primitive, const Placement &placement) {
    std::string path = at(at(at("meshes", mesh), "primitives"), primitive);
    const Json &object = json["meshes"][mesh]["primitives"][primitive];
    budget.spend(1, path);
    const Json *exact = find_extension(object, surface_extension, path);
    if (exact != nullptr && !def.use_mesh) {
        std::string here = at(at(path, "extensions"), surface_extension);
        place(read_tensor_surfaces(*exact, here, budget), placement);
        return;
    }
    std::optional<Mesh> triangles =
        read_triangles(model, model.meshes[mesh].primitives[primitive], quantized, path, budget);
    if (triangles) place(std::move(*triangles), placement);
    if (!triangles && exact != nullptr)
        fail(BTG_ERROR_UNSUPPORTED, path, "has no triangles beside its exact surfaces; load them");
}

void Gatherer::add_mesh(size_t mesh, const Placement &placement) {
    for (size_t i = 0; i < model.meshes[mesh].primitives.size(); i++)
        add_primitive(mesh, i, placement);
}

/* Notes that triangles take an exact surface's place, when there are any. */
bool Gatherer::stand_in(const std::string &obstacle, bool triangles) {
    if (!triangles)
        throw Fault{BTG_ERROR_UNSUPPORTED,
                    obstacle + "; give the node a mesh, whose triangles can stand in"};
    if (shape.note.empty()) shape.note = obstacle + "; its triangles are used instead";
    return false;
}

bool Gatherer::add_solid(const Visit &visit, const Placement &placement) {
    int mesh = model.nodes[visit.node].mesh;
    std::optional<size_t> solid =
        brep.solid_of(json["nodes"][visit.node], at("nodes", visit.node), mesh);
    if (!solid || (def.use_mesh && mesh >= 0)) return false;
    Exact exact = brep.solid(*solid, budget);
    if (!exact.obstacle.empty()) return stand_in(exact.obstacle, mesh >= 0);
    place(std::move(exact.surfaces), placement);
    return true;
}

void Gatherer::add_node(const Visit &visit) {
    const tinygltf::Node &node = model.nodes[visit.node];
    Placement placement = {visit.above * local_transform(node, at("nodes", visit.node)), def.unit,
                           def.up};
    if (add_solid(visit, placement)) return;
    if (node.mesh >= 0) add_mesh(static_cast<size_t>(node.mesh), placement);
}

/* All nodes of the scene, in file order of a walk from the roots; an own stack, no recursion. */
std::vector<Gatherer::Visit> Gatherer::mesh_nodes(const std::vector<int> &roots) const {
    std::vector<Visit> stack, out;
    for (size_t i = roots.size(); i-- > 0;)
        stack.push_back({static_cast<size_t>(roots[i]), Affine::identity()});
    while (!stack.empty()) {
        Visit visit = stack.back();
        stack.pop_back();
        out.push_back(visit);
        const tinygltf::Node &node = model.nodes[visit.node];
        if (node.children.empty()) continue;
        Affine here = visit.above * local_transform(node, at("nodes", visit.node));
        for (size_t i = node.children.size(); i-- > 0;)
            stack.push_back({static_cast<size_t>(node.children[i]), here});
    }
    return out;
}

/* Root-level surfaces that no solid or face refers to are the shape of the whole file. They stand
 * in the space of its meshes, which must then be one. */
bool Gatherer::add_loose_surfaces(const std::vector<Visit> &visits) {
    std::optional<Affine> space;
    for (const Visit &visit : visits) {
        const tinygltf::Node &node = model.nodes[visit.node];
        if (node.mesh < 0) continue;
        Affine here = visit.above * local_transform(node, at("nodes", visit.node));
        if (space && !(*space == here))
            return stand_in(at(at("extensions", brep_extension), "surfaces") +
                                ": meshes are placed differently and no solid says which is meant",
                            true);
        space = here;
    }
    if (def.use_mesh && space) return false;
    Exact exact = brep.loose_surfaces(budget);
    if (!exact.obstacle.empty()) return stand_in(exact.obstacle, space.has_value());
    place(std::move(exact.surfaces), {space.value_or(Affine::identity()), def.unit, def.up});
    return true;
}

Shape Gatherer::run(const std::vector<int> &roots) {
    std::vector<Visit> visits = mesh_nodes(roots);
    if (!brep.loose() || !add_loose_surfaces(visits))
        for (const Visit &visit : visits)
            add_node(visit);
    if (shape.surfaces.empty() && shape.meshes.empty())
        malformed(model.scenes.empty() ? "nodes" : "scenes",
                  "the default scene has no surface and no triangle; give a node a mesh");
    return std::move(shape);
}

Shape read_scene(const Json &json, const tinygltf::Model &model, const btg_gltf_def &def,
                 uint64_t bytes) {
    std::vector<int> parent = find_parents(model);
    refuse_cycles(parent);
    return Gatherer(json, model, def, bytes).run(scene_roots(model, parent));
}

} // namespace btg_gltf
