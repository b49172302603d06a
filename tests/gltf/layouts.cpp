// Every layout of triangles glTF 2.0 allows gives the same part; units, axes and nodes are applied.
#include "part_view.h"

#include <cmath>
#include <cstdio>
#include <filesystem>

namespace fs = std::filesystem;

// Rounding of a rotation and a scale in double, at 100 mm.
static const double placement_mm = 1e-10;

// Coordinates of tools/gltf_variants.py: x = 15.625 i, y = 15.625 j, z = 7.8125 height.
static void test_plain(const Loaded &plain) {
    CHECK(plain.status == BTG_OK, "%s", plain.message.c_str());
    CHECK(plain.message.empty(), "%s", plain.message.c_str());
    CHECK(plain.triangles.size() == 24, "%zu", plain.triangles.size());
    const btg_vec3 low = plain.info.box_min, high = plain.info.box_max;
    CHECK(low.x == 0 && low.y == 0 && low.z == 0, "%g %g %g", low.x, low.y, low.z);
    CHECK(high.x == 62.5 && high.y == 46.875 && high.z == 54.6875, "%g %g %g", high.x, high.y,
          high.z);
    // i = 2, j = 1: the only vertex of height 7 (54.6875 mm); it is the corner of 6 triangles.
    int found = 0;
    for (const Triangle &t : plain.triangles)
        for (size_t i = 0; i < 9; i += 3)
            found += t[i] == 31.25 && t[i + 1] == 15.625 && t[i + 2] == 54.6875;
    CHECK(found == 6, "%d", found);
}

static void test_same(const Loaded &plain, const fs::path &folder) {
    int files = 0;
    for (const auto &entry : fs::directory_iterator(folder)) {
        std::string name = entry.path().filename().string();
        if (name.rfind("same_", 0) != 0) continue;
        files++;
        Loaded other = load(entry.path().string());
        CHECK(other.status == BTG_OK, "%s", other.message.c_str());
        CHECK(distance(plain, other) <= placement_mm, "%s differs by %g", name.c_str(),
              distance(plain, other));
        CHECK(other.info.surface_count == 0, "%s", name.c_str());
    }
    CHECK(files == 23, "%d files named same_*", files);
}

static void test_units_and_axes(const Loaded &plain, const fs::path &folder) {
    btg_gltf_def def = btg_gltf_def_default();
    def.unit = BTG_GLTF_MILLIMETRE;
    def.up = BTG_GLTF_UP_Z;
    std::string file = (folder / "millimetres_z_up.gltf").string();
    CHECK(distance(plain, load(file, def)) == 0, "millimetres, z up");
    // The same file taken as metres is 1000 times as large, and taken as y up it lies turned.
    def.unit = BTG_GLTF_METRE;
    CHECK(load(file, def).info.box_max.x == 62500, "metres, z up");
    def.unit = BTG_GLTF_MILLIMETRE, def.up = BTG_GLTF_UP_Y;
    Loaded turned = load(file, def);
    CHECK(turned.info.box_max.z == 46.875 && turned.info.box_min.y == -54.6875,
          "millimetres, y up: z to %g, y from %g", turned.info.box_max.z, turned.info.box_min.y);
}

static void test_use_mesh(const fs::path &folder) {
    btg_gltf_def def = btg_gltf_def_default();
    def.use_mesh = 1;
    for (const char *name : {"exact_saddle.gltf", "exact_saddle.glb", "exact_kittycad.gltf",
                             "exact_kittycad_loose.gltf"}) {
        Loaded mesh = load((folder / name).string(), def);
        CHECK(mesh.info.triangle_count == 32 && mesh.info.patch_count == 0, "%s: %zu triangles",
              name, mesh.info.triangle_count);
    }
}

int main(int count, char **words) {
    if (count < 2) return 2;
    fs::path folder = words[1];
    Loaded plain = load((folder / "same_u16.gltf").string());
    test_plain(plain);
    test_same(plain, folder);
    test_units_and_axes(plain, folder);
    test_use_mesh(folder);
    return report("layouts");
}
