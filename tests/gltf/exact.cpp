// Exact surfaces: values to the last digit, copies by nodes, boundary representations, the assets.
#include "part_view.h"

#include <cmath>
#include <cstdio>
#include <filesystem>

namespace fs = std::filesystem;

static double saddle_heights[4][4] = {
    {80, 65, 90, 85}, {80, 85, 90, 95}, {100, 105, 95, 100}, {90, 100, 100, 85}};

// Bernstein polynomials, written out.
static void bernstein(double t, double b[4]) {
    double s = 1 - t;
    b[0] = s * s * s, b[1] = 3 * s * s * t, b[2] = 3 * s * t * t, b[3] = t * t * t;
}

static btg_vec3 saddle(double u, double v) {
    double bu[4], bv[4];
    bernstein(u, bu), bernstein(v, bv);
    btg_vec3 p = {0, 0, 0};
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            double w = bu[i] * bv[j];
            p.x += w * 50 * i, p.y += w * 50 * j, p.z += w * saddle_heights[i][j];
        }
    return p;
}

static double apart(btg_vec3 a, btg_vec3 b) {
    return std::fmax(std::fabs(a.x - b.x), std::fmax(std::fabs(a.y - b.y), std::fabs(a.z - b.z)));
}

// `mirrored`: what the second node of exact_copies does.
static void test_saddle(const Loaded &part, uint32_t item, bool mirrored, const char *name) {
    double worst = 0;
    for (int i = 0; i <= 10; i++)
        for (int j = 0; j <= 10; j++) {
            btg_vec3 expected = saddle(i / 10.0, j / 10.0);
            if (mirrored) expected.x = -125 - expected.x;
            worst = std::fmax(worst, apart(point_at(part, item, i / 10.0, j / 10.0), expected));
        }
    CHECK(worst <= 1e-12 * 1000, "%s: off by %g mm", name, worst);
    // Corners are control points: exact.
    btg_vec3 corner = point_at(part, item, 0, 1);
    CHECK(mirrored || (corner.x == 0 && corner.y == 150 && corner.z == 85), "%s: %.17g %.17g %.17g",
          name, corner.x, corner.y, corner.z);
}

static void test_saddles(const fs::path &folder) {
    for (const char *name : {"exact_saddle.gltf", "exact_saddle.glb", "exact_kittycad.gltf",
                             "exact_kittycad.glb", "exact_kittycad_no_loops.gltf",
                             "exact_kittycad_loose.gltf", "exact_kittycad_no_mesh.gltf"}) {
        Loaded part = load((folder / name).string());
        if (!CHECK(part.status == BTG_OK, "%s", part.message.c_str())) continue;
        CHECK(part.message.empty(), "%s", part.message.c_str());
        CHECK(part.info.surface_count == 1 && part.info.patch_count == 1, "%s", name);
        CHECK(part.info.triangle_count == 0, "%s: %zu triangles beside the exact surface", name,
              part.info.triangle_count);
        test_saddle(part, 0, false, name);
    }
    Loaded copies = load((folder / "exact_copies.gltf").string());
    CHECK(copies.info.surface_count == 2, "%zu", copies.info.surface_count);
    test_saddle(copies, 0, false, "first copy");
    test_saddle(copies, 1, true, "second copy");
}

// Faces that are not whole NURBS surfaces: triangles stand in, and the message says why.
static void test_stand_in(const fs::path &folder) {
    struct {
        const char *name, *words;
    } const cases[] = {
        {"kittycad_plane.gltf", "extensions.KITTYCAD_boundary_representation.surfaces[1].type: "
                                "surfaces of type plane are not supported"},
        {"kittycad_trimmed.gltf", "extensions.KITTYCAD_boundary_representation.faces[0].loops: a "
                                  "trimmed face"},
    };
    for (const auto &one : cases) {
        Loaded part = load((folder / one.name).string());
        CHECK(part.status == BTG_OK, "%s", part.message.c_str());
        CHECK(part.info.triangle_count == 32 && part.info.patch_count == 0, "%s", one.name);
        CHECK(part.message.find(one.words) != std::string::npos, "%s", part.message.c_str());
    }
}

struct Asset {
    const char *name;
    size_t surfaces, patches, triangles; // triangles: with use_mesh
    double box[6];
};

// Also in assets/list.md.
static const Asset assets[] = {
#include "assets.inc"
};

static void test_asset(const Asset &asset, const fs::path &folder) {
    std::string file = (folder / (std::string(asset.name) + ".gltf")).string();
    Loaded part = load(file);
    if (!CHECK(part.status == BTG_OK, "%s", part.message.c_str())) return;
    CHECK(part.info.surface_count == asset.surfaces && part.info.patch_count == asset.patches,
          "%s: %zu surfaces, %zu patches", asset.name, part.info.surface_count,
          part.info.patch_count);
    const btg_vec3 low = part.info.box_min, high = part.info.box_max;
    const double box[6] = {low.x, low.y, low.z, high.x, high.y, high.z};
    for (int i = 0; i < 6; i++)
        CHECK(std::fabs(box[i] - asset.box[i]) <= 1e-3, "%s: box %d is %.6f", asset.name, i,
              box[i]);
    btg_gltf_def def = btg_gltf_def_default();
    def.use_mesh = 1;
    Loaded mesh = load(file, def);
    CHECK(mesh.info.triangle_count == asset.triangles, "%s: %zu triangles", asset.name,
          mesh.info.triangle_count);
    // The display triangles are the same part, to their sagitta.
    double reach = std::fmax(apart(mesh.info.box_min, low), apart(mesh.info.box_max, high));
    CHECK(reach <= 0.5, "%s: triangles end %g mm from the surface", asset.name, reach);
}

int main(int count, char **words) {
    if (count < 3) return 2;
    test_saddles(words[1]);
    test_stand_in(words[1]);
    for (const Asset &asset : assets)
        test_asset(asset, words[2]);
    return report("exact");
}
