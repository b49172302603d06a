/* Parts of the glTF reader; see bitangent/gltf.h. Internal.
 *
 * The bytes go through five steps, each of which trusts only the ones before it:
 *   gltf_file    bytes -> JSON document and the binary chunk (sizes, nesting, text are checked)
 *   gltf_buffer  buffers: base64, the binary chunk, files beside the glTF file
 *   gltf_check   document -> a clean one that holds only checked values -> tinygltf::Model
 *   gltf_mesh, gltf_surface, gltf_brep   Model and document -> triangles, exact surfaces
 *   gltf_scene   node hierarchy, transforms, units -> one part
 * A fault is thrown as a Fault and becomes a btg_status and a message in gltf.cpp. */
#ifndef BTG_IO_GLTF_INTERNAL_H
#define BTG_IO_GLTF_INTERNAL_H

#include "bitangent/gltf.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>
#include <tiny_gltf.h>

namespace btg_gltf {

using Json = nlohmann::json;
using Bytes = std::vector<unsigned char>;

constexpr const char *surface_extension = "BITANGENT_tensor_surface";
constexpr const char *brep_extension = "KITTYCAD_boundary_representation";
constexpr const char *quantization_extension = "KHR_mesh_quantization";
constexpr const char *draco_extension = "KHR_draco_mesh_compression";

/* ---- faults and paths --------------------------------------------------------------------- */

/* `text`: "<JSON path>: <reason>; <remedy>". Words from the file must have gone through plain(). */
struct Fault {
    btg_status status;
    std::string text;
};

[[noreturn]] void fail(btg_status status, const std::string &path, const std::string &reason);
[[noreturn]] void malformed(const std::string &path, const std::string &reason);

/* Printable ASCII only, cut to `limit` characters. */
std::string plain(const std::string &text, size_t limit = 64);
/* A file name of the caller's: one line; the head of a very long one is cut off. */
std::string plain_file_name(const std::string &name);

std::string at(const std::string &path, const char *key);
std::string at(const std::string &path, size_t index);

/* ---- checked access to JSON --------------------------------------------------------------- */

constexpr uint64_t int_max = 0x7fffffff;
constexpr uint64_t offset_max = uint64_t(1) << 40; /* bytes: keeps sums and products in 64 bits */

struct Range {
    uint64_t min, max;
};

/* Null when the member is absent. */
const Json *find(const Json &object, const char *key);
const Json &need_object(const Json &value, const std::string &path);
const Json &need_array(const Json &value, const std::string &path);
const Json &need_member(const Json &object, const char *key, const std::string &path);
/* An empty array when the member is absent. */
const Json &array_member(const Json &object, const char *key, const std::string &path);
/* The extension of that name on an object, or null. */
const Json *find_extension(const Json &object, const char *name, const std::string &path);

uint64_t need_whole(const Json &value, Range range, const std::string &path);
uint64_t whole_member(const Json &object, const char *key, Range range, const std::string &path);
uint64_t whole_member(const Json &object, const char *key, Range range, const std::string &path,
                      uint64_t fallback);
/* An index below `count` into the array `what`. */
uint64_t need_index(const Json &value, size_t count, const char *what, const std::string &path);
double need_number(const Json &value, const std::string &path);
std::vector<double> need_numbers(const Json &value, size_t count, const std::string &path);

/* ---- gltf_file ---------------------------------------------------------------------------- */

struct Document {
    Json json;
    Bytes binary; /* the BIN chunk of a .glb */
    bool has_binary = false;
    uint64_t bytes = 0; /* size of the file */
};

/* The first `limit` bytes of a regular file. `where` opens the messages; empty for the file
 * itself. */
Bytes read_file(const std::filesystem::path &file, uint64_t limit, const std::string &where);
/* Any JSON text; faults say where it is none. */
Json parse_json(const char *text, size_t size);
Document read_document(const std::filesystem::path &file, uint64_t max_bytes);

/* ---- gltf_buffer -------------------------------------------------------------------------- */

/* Contents of all buffers, in order; external files from `folder` only, `budget` bytes in all. */
std::vector<Bytes> read_buffers(Document &document, const std::filesystem::path &folder,
                                uint64_t budget);

/* ---- gltf_check --------------------------------------------------------------------------- */

void check_version(const Json &json);
void check_extensions(const Json &json);
bool extension_declared(const Json &json, const char *name);
/* Takes the buffers into the model. */
tinygltf::Model build_model(const Json &json, std::vector<Bytes> &&buffers);
/* Names of the attributes in the model: indices are handed on as an attribute, because tinygltf
 * refuses index accessors without a buffer view, which are legal when sparse. */
constexpr const char *position_attribute = "POSITION";
constexpr const char *index_attribute = "_INDICES";

/* ---- what the part is made of ------------------------------------------------------------- */

struct Surface {
    int degree_u = 0, degree_v = 0, count_u = 0, count_v = 0;
    std::vector<double> points, weights, knots_u, knots_v;
    std::string path;
};

struct Mesh {
    std::vector<double> positions;
    std::vector<uint32_t> indices;
    std::string path;
};

/* A small file can ask for a lot by instancing and by accessors without data: every vertex,
 * triangle and control point is paid from a budget that grows with the bytes read. */
class Budget {
  public:
    explicit Budget(uint64_t bytes);
    void spend(uint64_t items, const std::string &path);

  private:
    uint64_t left;
};

struct Affine {
    double m[3][4];
    static Affine identity();
    Affine operator*(const Affine &right) const;
    void apply(const double in[3], double out[3]) const;
    bool operator==(const Affine &other) const;
};

/* From a mesh's space to the part frame, mm. Exact for the identity: one product a coordinate. */
struct Placement {
    Affine node;
    btg_gltf_unit unit;
    btg_gltf_up up;
    /* False when the point comes to lie out of range, or is not finite. */
    bool apply(double point[3]) const;
};

/* ---- gltf_mesh ---------------------------------------------------------------------------- */

/* Triangles of one primitive, or nothing for points, lines and primitives without POSITION. */
std::optional<Mesh> read_triangles(const tinygltf::Model &model,
                                   const tinygltf::Primitive &primitive, bool quantized,
                                   const std::string &path, Budget &budget);

/* ---- gltf_surface ------------------------------------------------------------------------- */

/* `surfaces` of a BITANGENT_tensor_surface extension at `path`. */
std::vector<Surface> read_tensor_surfaces(const Json &extension, const std::string &path,
                                          Budget &budget);
/* The "nurbs" object of a KITTYCAD_boundary_representation surface. */
Surface read_kittycad_nurbs(const Json &nurbs, const std::string &path, Budget &budget);

/* ---- gltf_brep ---------------------------------------------------------------------------- */

/* Either the surfaces that bound a solid exactly, or why they do not. */
struct Exact {
    std::vector<Surface> surfaces;
    std::string obstacle; /* "<JSON path>: <reason>", empty when exact */
};

class Brep {
  public:
    /* `extension` may be null: then there are no solids. */
    Brep(const Json *extension, size_t mesh_count);
    /* The solid a node stands for: its own, or the one that names its mesh. */
    std::optional<size_t> solid_of(const Json &node, const std::string &path, int mesh) const;
    Exact solid(size_t index, Budget &budget) const;
    /* Surfaces without any solid or face: the whole file's shape. */
    bool loose() const;
    Exact loose_surfaces(Budget &budget) const;

  private:
    const Json *extension;
    std::string path;
    std::vector<int> mesh_solid; /* by mesh; -1: none */

    Exact faces(const std::vector<size_t> &list, Budget &budget) const;
    std::vector<size_t> faces_of(size_t solid) const;
    std::string trimmed(const Json &face, const std::string &face_path,
                        const Surface &surface) const;
    std::optional<std::array<double, 3>> vertex(const Json &edge, const char *end,
                                                const std::string &edge_path) const;
};

/* ---- gltf_scene --------------------------------------------------------------------------- */

struct Shape {
    std::vector<Surface> surfaces;
    std::vector<Mesh> meshes;
    std::string note; /* why triangles stand in for an exact surface; empty otherwise */
};

Shape read_scene(const Json &json, const tinygltf::Model &model, const btg_gltf_def &def,
                 uint64_t bytes);

} // namespace btg_gltf

#endif
