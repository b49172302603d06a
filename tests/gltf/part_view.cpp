#include "part_view.h"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>

static int checks = 0, failures = 0;

bool check(bool condition, const char *file, int line, const char *text, const char *format, ...) {
    checks++;
    if (condition) return true;
    failures++;
    std::printf("%s:%d: %s: ", file, line, text);
    va_list arguments;
    va_start(arguments, format);
    std::vprintf(format, arguments);
    va_end(arguments);
    std::printf("\n");
    return false;
}

int report(const char *name) {
    std::printf("%s: %d checks, %d failed\n", name, checks, failures);
    return failures > 0 || checks == 0;
}

Loaded::Loaded(Loaded &&other) noexcept
    : status(other.status), message(std::move(other.message)), info(other.info),
      triangles(std::move(other.triangles)), part(other.part) {
    other.part = nullptr;
}

Loaded::~Loaded() {
    btg_part_destroy(part);
}

btg_vec3 point_at(const Loaded &loaded, uint32_t item, double u, double v) {
    btg_surface_point point = {};
    btg_place place = {item, u, v};
    if (btg_part_evaluate(loaded.part, place, &point) < 0) point.s = {NAN, NAN, NAN};
    return point.s;
}

static Triangle triangle(const Loaded &loaded, uint32_t item) {
    Triangle out;
    for (size_t i = 0; i < 3; i++) {
        btg_vec3 p = point_at(loaded, item, i == 1, i == 2);
        out[3 * i] = p.x, out[3 * i + 1] = p.y, out[3 * i + 2] = p.z;
    }
    return out;
}

Loaded load(const std::string &file, const btg_gltf_def &def) {
    Loaded loaded;
    btg_message message = {};
    loaded.status = btg_gltf_load(file.c_str(), &def, &loaded.part, &message);
    loaded.message = message.text;
    if (loaded.part == nullptr) return loaded;
    btg_part_get_info(loaded.part, &loaded.info);
    size_t first = loaded.info.patch_count;
    for (size_t i = 0; i < loaded.info.triangle_count; i++)
        loaded.triangles.push_back(triangle(loaded, static_cast<uint32_t>(first + i)));
    return loaded;
}

// Corners may come in any order.
static double apart(const Triangle &a, const Triangle &b) {
    std::array<size_t, 3> order = {0, 1, 2};
    double best = INFINITY;
    do {
        double worst = 0;
        for (size_t i = 0; i < 9; i++)
            worst = std::max(worst, std::fabs(a[i] - b[3 * order[i / 3] + i % 3]));
        best = std::min(best, worst);
    } while (std::next_permutation(order.begin(), order.end()));
    return best;
}

static double nearest(const Triangle &t, const std::vector<Triangle> &list) {
    double best = INFINITY;
    for (const Triangle &other : list)
        best = std::min(best, apart(t, other));
    return best;
}

double distance(const Loaded &a, const Loaded &b) {
    if (a.triangles.size() != b.triangles.size()) return INFINITY;
    double worst = 0;
    for (const Triangle &t : a.triangles)
        worst = std::max(worst, nearest(t, b.triangles));
    for (const Triangle &t : b.triangles)
        worst = std::max(worst, nearest(t, a.triangles));
    return worst;
}
