#include "io/outline.h"

#include <clipper.hpp>

#include <cmath>
#include <cstdlib>
#include <new>
#include <vector>

namespace {

using ClipperLib::Path;
using ClipperLib::Paths;

/* Clipper counts in whole units: 1e-5 mm. */
constexpr double UNITS = 1e5;
/* Gaps between the facets of neighbouring patches are closed up to twice that. */
constexpr double CHORD_MM = BTG_OUTLINE_CHORD_MM;

struct failure {
    btg_status status;
    const char *text;
};

ClipperLib::cInt units(double mm) {
    return static_cast<ClipperLib::cInt>(std::llround(mm * UNITS));
}

Path triangle(const double *xy) {
    Path path;
    for (int k = 0; k < 3; k++)
        path.emplace_back(units(xy[2 * k]), units(xy[2 * k + 1]));
    if (!ClipperLib::Orientation(path)) ClipperLib::ReversePath(path);
    return path;
}

Paths grown(const Paths &from, double by_mm) {
    ClipperLib::ClipperOffset offset(2, 0.01 * CHORD_MM * UNITS);
    Paths to;
    offset.AddPaths(from, ClipperLib::jtRound, ClipperLib::etClosedPolygon);
    offset.Execute(to, by_mm * UNITS);
    return to;
}

Paths shadow(const double *xy, size_t triangles) {
    ClipperLib::Clipper clipper;
    Paths all;
    for (size_t i = 0; i < triangles; i++) {
        Path path = triangle(xy + 6 * i);
        if (ClipperLib::Area(path) > 0) clipper.AddPath(path, ClipperLib::ptSubject, true);
    }
    clipper.Execute(ClipperLib::ctUnion, all, ClipperLib::pftNonZero, ClipperLib::pftNonZero);
    all = grown(grown(all, CHORD_MM), -CHORD_MM);
    ClipperLib::CleanPolygons(all, 0.01 * CHORD_MM * UNITS);
    return all;
}

/* One pass after the other. */
class passes {
  public:
    explicit passes(double step) : step_(step) {}

    void add(const Path &path) {
        if (path.size() < 3) return;
        double length = 0;
        for (size_t i = 0; i < path.size(); i++)
            length += way(path[i], path[(i + 1) % path.size()]);
        if (!(length / step_ < BTG_FOOTPRINT_MAX))
            throw failure{BTG_ERROR_ARGUMENT, "too many points; give a larger --forward-step"};
        size_t pieces = static_cast<size_t>(std::ceil(length / step_));
        for (size_t k = 0, edge = 0; k <= pieces; k++) {
            double at = length * static_cast<double>(k % pieces) / static_cast<double>(pieces);
            if (k == pieces) edge = 0, before_ = 0;
            if (k == 0) before_ = 0;
            while (edge + 1 < path.size() && before_ + way(path[edge], path[edge + 1]) < at)
                before_ += way(path[edge], path[edge + 1]), edge++;
            put(path[edge], path[(edge + 1) % path.size()], at - before_, k);
        }
        number_++;
    }

    std::vector<btg_footprint_point> points;

  private:
    static double way(const ClipperLib::IntPoint &a, const ClipperLib::IntPoint &b) {
        return std::hypot(static_cast<double>(b.X - a.X), static_cast<double>(b.Y - a.Y)) / UNITS;
    }

    void put(const ClipperLib::IntPoint &a, const ClipperLib::IntPoint &b, double on, size_t k) {
        double share = way(a, b) > 0 ? on / way(a, b) : 0;
        if (points.size() == BTG_FOOTPRINT_MAX)
            throw failure{BTG_ERROR_ARGUMENT, "too many points; give larger steps"};
        btg_footprint_point p = {};
        p.pass = number_;
        p.point = static_cast<uint32_t>(k);
        p.x_mm = (static_cast<double>(a.X) + share * static_cast<double>(b.X - a.X)) / UNITS;
        p.y_mm = (static_cast<double>(a.Y) + share * static_cast<double>(b.Y - a.Y)) / UNITS;
        points.push_back(p);
    }

    double step_, before_ = 0;
    uint32_t number_ = 0;
};

/* The last pass before nothing is left is followed by one half a step on, where there is room:
 * so no place is farther than a step from a pass. */
std::vector<btg_footprint_point> along(const Paths &outline, const btg_outline_def &def) {
    passes out(def.forward_step_mm);
    double in = -def.overrun_mm;
    for (bool last = false; !last;) {
        Paths here = grown(outline, -in);
        for (const Path &path : here)
            out.add(path);
        in += def.side_step_mm;
        if (!here.empty() && grown(outline, -in).empty()) in -= 0.5 * def.side_step_mm, last = true;
        if (here.empty()) break;
        if (last)
            for (const Path &path : grown(outline, -in))
                out.add(path);
    }
    return std::move(out.points);
}

} // namespace

btg_status btg_outline_trace(const btg_outline_def *def, const double *xy, size_t triangles,
                             btg_footprint_point **points, size_t *count, const char **why) {
    try {
        Paths outline = shadow(xy, triangles);
        if (outline.empty())
            throw failure{BTG_ERROR_ARGUMENT,
                          "the part has no width from above; give another footprint"};
        std::vector<btg_footprint_point> made = along(outline, *def);
        auto *list = static_cast<btg_footprint_point *>(malloc((made.size() + 1) * sizeof made[0]));
        if (!list) throw std::bad_alloc();
        std::copy(made.begin(), made.end(), list);
        *points = list;
        *count = made.size();
        return BTG_OK;
    } catch (const failure &f) {
        *why = f.text;
        return f.status;
    } catch (const std::bad_alloc &) {
        *why = "out of memory";
        return BTG_ERROR_MEMORY;
    } catch (const ClipperLib::clipperException &) {
        *why = "the part is too large; give another footprint";
        return BTG_ERROR_ARGUMENT;
    }
}
