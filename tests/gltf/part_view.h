// What the glTF tests look at: a loaded part as plain numbers.
#ifndef TESTS_GLTF_PART_VIEW_H
#define TESTS_GLTF_PART_VIEW_H

#include "bitangent/gltf.h"

#include <array>
#include <string>
#include <vector>

using Triangle = std::array<double, 9>;

struct Loaded {
    btg_status status = BTG_ERROR_ARGUMENT;
    std::string message;
    btg_part_info info = {};
    std::vector<Triangle> triangles;
    btg_part *part = nullptr;

    Loaded() = default;
    Loaded(Loaded &&other) noexcept;
    Loaded &operator=(Loaded &&) = delete;
    ~Loaded();
};

Loaded load(const std::string &file, const btg_gltf_def &def = btg_gltf_def_default());

// Largest coordinate difference of a triangle to the nearest one of the other part, mm; infinite
// when their numbers differ.
double distance(const Loaded &a, const Loaded &b);

btg_vec3 point_at(const Loaded &loaded, uint32_t item, double u, double v);

// Counts a failure, with the line of the caller.
#define CHECK(condition, ...) check((condition), __FILE__, __LINE__, #condition, __VA_ARGS__)
#if defined(__GNUC__)
__attribute__((format(printf, 5, 6)))
#endif
bool check(bool condition, const char *file, int line, const char *text, const char *format, ...);
// Prints the sum; the program's exit code.
int report(const char *name);

#endif
