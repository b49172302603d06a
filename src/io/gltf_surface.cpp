/* Exact surfaces: BITANGENT_tensor_surface and the NURBS of KITTYCAD_boundary_representation.
 * Numbers come from the JSON itself: tinygltf keeps whole numbers in 32 bits. */
#include "io/gltf_internal.h"

namespace btg_gltf {

/* The core's limits, said again here so that a fault has a JSON path. */
constexpr uint64_t count_max = 1000000;
constexpr double weight_min = 1e-6, weight_max = 1e6;

/* ---- shared by both ----------------------------------------------------------------------- */

struct Side {
    int degree, count;
};

static void check_side(Side side, const std::string &degree_path, const std::string &count_path) {
    if (side.degree < 1 || side.degree > BTG_DEGREE_MAX)
        malformed(degree_path, "degree " + std::to_string(side.degree) + " is outside 1 to " +
                                   std::to_string(BTG_DEGREE_MAX));
    if (side.count <= side.degree)
        malformed(count_path, std::to_string(side.count) +
                                  " control points are too few for degree " +
                                  std::to_string(side.degree) + "; at least degree + 1 are needed");
}

static void check_knots(const std::vector<double> &knots, Side side, const std::string &path,
                        size_t first) {
    size_t degree = static_cast<size_t>(side.degree), count = static_cast<size_t>(side.count);
    int run = 1;
    for (size_t i = 1; i < knots.size(); i++) {
        if (knots[i] < knots[i - 1])
            malformed(at(path, first + i), "is below the knot before it; sort the knots");
        run = knots[i] == knots[i - 1] ? run + 1 : 1;
        bool interior = knots[i] > knots[degree] && knots[i] < knots[count];
        if (interior && run > side.degree)
            malformed(at(path, first + i), "repeats more than degree " +
                                               std::to_string(side.degree) +
                                               " times, which tears the surface; split it there");
    }
    if (!(knots[degree] < knots[count]))
        malformed(path, "the knots span nothing; the domain must have a length");
}

static std::vector<double> read_weights(const Json &value, size_t count, const std::string &path) {
    std::vector<double> weights = need_numbers(value, count, path);
    for (size_t i = 0; i < count; i++)
        if (!(weights[i] >= weight_min && weights[i] <= weight_max))
            malformed(at(path, i), "a weight must be within 1e-6 to 1e6");
    return weights;
}

/* Control points as one flat list, or as a list of [x, y, z]. */
static std::vector<double> read_points(const Json &value, size_t count, const std::string &path) {
    need_array(value, path);
    if (value.empty() || !value[0].is_array()) return need_numbers(value, 3 * count, path);
    if (value.size() != count)
        malformed(path, "has " + std::to_string(value.size()) + " points; it needs " +
                            std::to_string(count));
    std::vector<double> points;
    points.reserve(3 * count);
    for (size_t i = 0; i < count; i++) {
        std::vector<double> point = need_numbers(value[i], 3, at(path, i));
        points.insert(points.end(), point.begin(), point.end());
    }
    return points;
}

static size_t point_count(const Surface &surface) {
    return static_cast<size_t>(surface.count_u) * static_cast<size_t>(surface.count_v);
}

/* ---- BITANGENT_tensor_surface ------------------------------------------------------------- */

static std::vector<double> bezier_knots(int degree) {
    std::vector<double> knots(2 * static_cast<size_t>(degree + 1), 0.0);
    std::fill(knots.begin() + degree + 1, knots.end(), 1.0);
    return knots;
}

static std::vector<double> read_side_knots(const Json &object, const char *key, Side side,
                                           const char *count_key, const std::string &path) {
    const Json *value = find(object, key);
    if (value == nullptr && side.count != side.degree + 1)
        malformed(at(path, count_key),
                  "without " + std::string(key) + " the side is Bezier, which takes degree + 1 = " +
                      std::to_string(side.degree + 1) + " control points; add the knots");
    if (value == nullptr) return bezier_knots(side.degree);
    size_t count = static_cast<size_t>(side.count + side.degree + 1);
    std::vector<double> knots = need_numbers(*value, count, at(path, key));
    check_knots(knots, side, at(path, key), 0);
    return knots;
}

static Side read_side(const Json &object, const char *degree_key, const char *count_key,
                      const std::string &path) {
    Side side = {static_cast<int>(whole_member(object, degree_key, {0, 1000}, path)),
                 static_cast<int>(whole_member(object, count_key, {0, count_max}, path))};
    check_side(side, at(path, degree_key), at(path, count_key));
    return side;
}

static Surface read_tensor_surface(const Json &object, const std::string &path, Budget &budget) {
    Side u = read_side(need_object(object, path), "degreeU", "countU", path);
    Side v = read_side(object, "degreeV", "countV", path);
    Surface surface;
    surface.path = path;
    surface.degree_u = u.degree, surface.count_u = u.count;
    surface.degree_v = v.degree, surface.count_v = v.count;
    size_t count = point_count(surface);
    const Json &points = need_member(object, "controlPoints", path);
    surface.points = need_numbers(points, 3 * count, at(path, "controlPoints"));
    budget.spend(count, path);
    if (const Json *weights = find(object, "weights"))
        surface.weights = read_weights(*weights, count, at(path, "weights"));
    surface.knots_u = read_side_knots(object, "knotsU", u, "countU", path);
    surface.knots_v = read_side_knots(object, "knotsV", v, "countV", path);
    return surface;
}

std::vector<Surface> read_tensor_surfaces(const Json &extension, const std::string &path,
                                          Budget &budget) {
    std::string here = at(path, "surfaces");
    const Json &list = need_array(need_member(extension, "surfaces", path), here);
    if (list.empty()) malformed(here, "is empty; give a surface or leave the extension out");
    std::vector<Surface> surfaces;
    for (size_t i = 0; i < list.size(); i++)
        surfaces.push_back(read_tensor_surface(list[i], at(here, i), budget));
    return surfaces;
}

/* ---- KITTYCAD_boundary_representation ----------------------------------------------------- */

/* [u, v] */
static std::array<int, 2> read_pair(const Json &object, const char *key, const std::string &path) {
    std::string here = at(path, key);
    const Json &pair = need_array(need_member(object, key, path), here);
    if (pair.size() != 2) malformed(here, "two numbers, for u and v, are needed here");
    return {static_cast<int>(need_whole(pair[0], {0, count_max + 100}, at(here, size_t(0)))),
            static_cast<int>(need_whole(pair[1], {0, count_max + 100}, at(here, size_t(1))))};
}

/* knotVector holds those of u, then those of v. */
static void read_knot_vector(const Json &nurbs, Side u, Side v, const std::string &path,
                             Surface &surface) {
    std::array<int, 2> counts = read_pair(nurbs, "numKnots", path);
    Side sides[2] = {u, v};
    for (size_t i = 0; i < 2; i++)
        if (counts[i] != sides[i].count + sides[i].degree + 1)
            malformed(at(at(path, "numKnots"), i),
                      "must be control points + order = " +
                          std::to_string(sides[i].count + sides[i].degree + 1));
    std::string here = at(path, "knotVector");
    size_t count_u = static_cast<size_t>(counts[0]), count_v = static_cast<size_t>(counts[1]);
    std::vector<double> all =
        need_numbers(need_member(nurbs, "knotVector", path), count_u + count_v, here);
    auto middle = all.begin() + counts[0];
    surface.knots_u.assign(all.begin(), middle);
    surface.knots_v.assign(middle, all.end());
    check_knots(surface.knots_u, u, here, 0);
    check_knots(surface.knots_v, v, here, count_u);
}

Surface read_kittycad_nurbs(const Json &nurbs, const std::string &path, Budget &budget) {
    std::array<int, 2> order = read_pair(need_object(nurbs, path), "order", path);
    std::array<int, 2> counts = read_pair(nurbs, "numControlPoints", path);
    Side u = {order[0] - 1, counts[0]}, v = {order[1] - 1, counts[1]};
    std::string order_path = at(path, "order"), count_path = at(path, "numControlPoints");
    for (size_t i = 0; i < 2; i++)
        check_side(i == 0 ? u : v, at(order_path, i), at(count_path, i));
    Surface surface;
    surface.path = path;
    surface.degree_u = u.degree, surface.count_u = u.count;
    surface.degree_v = v.degree, surface.count_v = v.count;
    size_t count = point_count(surface);
    surface.points =
        read_points(need_member(nurbs, "controlPoints", path), count, at(path, "controlPoints"));
    budget.spend(count, path);
    const Json *weights = find(nurbs, "weights");
    if (weights != nullptr && !weights->is_null() && !weights->empty())
        surface.weights = read_weights(*weights, count, at(path, "weights"));
    read_knot_vector(nurbs, u, v, path, surface);
    return surface;
}

} // namespace btg_gltf
