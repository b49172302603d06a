/* Checks the document and hands a clean copy to tinygltf.
 *
 * tinygltf 2.7 takes what it understands and drops the rest without a word: integers wrap at 32
 * bits, members of a wrong type count as absent, a primitive it cannot read vanishes and shifts
 * those after it, its GLB reader may read 8 bytes past the end, and it looks for external files in
 * the working directory too. So it gets a document of checked values only, in one piece, and
 * buffers that are already in memory; images, materials, animations and the like are left out. */
#include "io/gltf_internal.h"

#include <algorithm>

namespace btg_gltf {

/* ---- version and extensions --------------------------------------------------------------- */

static int major_version(const std::string &version) {
    size_t dot = version.find('.');
    bool digits = dot != std::string::npos && dot > 0 && dot < 4 &&
                  std::all_of(version.begin(), version.begin() + static_cast<std::ptrdiff_t>(dot),
                              [](char c) { return c >= '0' && c <= '9'; });
    return digits ? std::stoi(version.substr(0, dot)) : -1;
}

static void check_version_member(const Json &asset, const char *key) {
    const Json &version = need_member(asset, key, "asset");
    if (!version.is_string()) malformed(at("asset", key), "a string is needed here");
    const std::string &text = version.get_ref<const std::string &>();
    if (major_version(text) != 2)
        fail(major_version(text) < 0 ? BTG_ERROR_FORMAT : BTG_ERROR_UNSUPPORTED, at("asset", key),
             "version " + plain(text, 16) + " is not 2.0; convert the file to glTF 2.0");
}

void check_version(const Json &json) {
    const Json &asset = need_object(need_member(json, "asset", ""), "asset");
    check_version_member(asset, "version");
    const Json *minimum = find(asset, "minVersion");
    if (minimum == nullptr) return;
    check_version_member(asset, "minVersion");
    if (minimum->get_ref<const std::string &>() != "2.0")
        fail(BTG_ERROR_UNSUPPORTED, "asset.minVersion",
             "only glTF 2.0 is known; export the file as glTF 2.0");
}

static bool starts_with(const std::string &text, const char *head) {
    return text.rfind(head, 0) == 0;
}

/* Those that cannot change the shape pass even when required. */
static bool extension_known(const std::string &name) {
    return name == surface_extension || name == brep_extension || name == quantization_extension ||
           name == "KHR_lights_punctual" || name == "KHR_animation_pointer" ||
           name == "MSFT_texture_dds" || starts_with(name, "KHR_materials_") ||
           starts_with(name, "KHR_texture_") || starts_with(name, "EXT_texture_");
}

static std::string extension_reason(const std::string &name) {
    std::string shown = plain(name);
    if (name == draco_extension)
        return shown + ": Draco compression is not supported; export the file without compression";
    if (name.find("meshopt") != std::string::npos)
        return shown +
               ": meshopt compression is not supported; export the file without compression";
    return "the file requires the extension " + shown + ", which is not known; export it without";
}

void check_extensions(const Json &json) {
    const Json &list = array_member(json, "extensionsRequired", "");
    for (size_t i = 0; i < list.size(); i++) {
        std::string path = at("extensionsRequired", i);
        if (!list[i].is_string()) malformed(path, "a string is needed here");
        const std::string &name = list[i].get_ref<const std::string &>();
        if (!extension_known(name)) fail(BTG_ERROR_UNSUPPORTED, path, extension_reason(name));
    }
}

bool extension_declared(const Json &json, const char *name) {
    for (const char *key : {"extensionsUsed", "extensionsRequired"})
        for (const Json &entry : array_member(json, key, ""))
            if (entry == name) return true;
    return false;
}

/* Nodes, primitives, accessors and the like of one document: each costs a kilobyte in the model. */
constexpr size_t entries_max = 250000;

static void limit_entries(size_t count, const std::string &path) {
    if (count > entries_max)
        fail(BTG_ERROR_MEMORY, path,
             std::to_string(count) + " entries are more than the " + std::to_string(entries_max) +
                 " allowed; join meshes or split the file");
}

/* ---- buffers, views, accessors ------------------------------------------------------------ */

static Json clean_buffers(const std::vector<Bytes> &buffers) {
    Json out = Json::array();
    for (size_t i = 0; i < buffers.size(); i++)
        out.push_back({{"byteLength", buffers[i].size()}, {"uri", std::to_string(i)}});
    return out;
}

static Json clean_view(const Json &view, const std::vector<Bytes> &buffers,
                       const std::string &path) {
    uint64_t buffer = need_index(need_member(view, "buffer", path), buffers.size(), "buffers",
                                 at(path, "buffer"));
    uint64_t offset = whole_member(view, "byteOffset", {0, offset_max}, path, 0);
    uint64_t length = whole_member(view, "byteLength", {1, offset_max}, path);
    if (offset + length > buffers[buffer].size())
        malformed(at(path, "byteLength"),
                  "bytes " + std::to_string(offset) + " to " + std::to_string(offset + length) +
                      " pass the end of buffers[" + std::to_string(buffer) + "], which has " +
                      std::to_string(buffers[buffer].size()));
    uint64_t stride = whole_member(view, "byteStride", {4, 252}, path, 0);
    if (stride % 4 != 0) malformed(at(path, "byteStride"), "is no multiple of 4");
    Json out = {{"buffer", buffer}, {"byteOffset", offset}, {"byteLength", length}};
    if (stride > 0) out["byteStride"] = stride;
    return out;
}

static uint64_t component_type(const Json &object, const std::string &path) {
    uint64_t type = whole_member(object, "componentType", {0, 65535}, path);
    if (type < 5120 || type > 5126 || type == 5124)
        malformed(at(path, "componentType"),
                  std::to_string(type) + " is none of 5120 5121 5122 5123 5125 5126");
    return type;
}

static Json clean_sparse_part(const Json &sparse, const char *key, size_t view_count,
                              const std::string &path) {
    const Json &part = need_member(sparse, key, path);
    std::string here = at(path, key);
    Json out = {{"bufferView", need_index(need_member(part, "bufferView", here), view_count,
                                          "bufferViews", at(here, "bufferView"))},
                {"byteOffset", whole_member(part, "byteOffset", {0, int_max}, here, 0)}};
    return out;
}

static Json clean_sparse(const Json &sparse, uint64_t count, size_t view_count,
                         const std::string &path) {
    uint64_t changed = whole_member(sparse, "count", {1, int_max}, path);
    if (changed > count)
        malformed(at(path, "count"), std::to_string(changed) + " is more than the accessor's " +
                                         std::to_string(count));
    Json indices = clean_sparse_part(sparse, "indices", view_count, path);
    Json values = clean_sparse_part(sparse, "values", view_count, path);
    std::string here = at(path, "indices");
    uint64_t type = component_type(sparse["indices"], here);
    if (type != 5121 && type != 5123 && type != 5125)
        malformed(at(here, "componentType"), "is none of 5121 5123 5125");
    indices["componentType"] = type;
    return {{"count", changed}, {"indices", indices}, {"values", values}};
}

static std::string accessor_type(const Json &accessor, const std::string &path) {
    const Json &type = need_member(accessor, "type", path);
    for (const char *known : {"SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"})
        if (type == known) return known;
    malformed(at(path, "type"), "is none of SCALAR VEC2 VEC3 VEC4 MAT2 MAT3 MAT4");
}

static Json clean_accessor(const Json &accessor, size_t view_count, const std::string &path) {
    uint64_t count = whole_member(accessor, "count", {1, offset_max}, path);
    Json out = {{"byteOffset", whole_member(accessor, "byteOffset", {0, offset_max}, path, 0)},
                {"componentType", component_type(accessor, path)},
                {"count", count},
                {"type", accessor_type(accessor, path)}};
    if (const Json *view = find(accessor, "bufferView"))
        out["bufferView"] = need_index(*view, view_count, "bufferViews", at(path, "bufferView"));
    if (const Json *normalized = find(accessor, "normalized")) {
        if (!normalized->is_boolean())
            malformed(at(path, "normalized"), "true or false is needed here");
        out["normalized"] = *normalized;
    }
    if (const Json *sparse = find(accessor, "sparse"))
        out["sparse"] = clean_sparse(*sparse, count, view_count, at(path, "sparse"));
    return out;
}

/* ---- meshes, nodes, scenes ---------------------------------------------------------------- */

static void refuse_draco_only(const Json &primitive, const Json &accessor,
                              const std::string &path) {
    if (find_extension(primitive, draco_extension, path) != nullptr &&
        find(accessor, "bufferView") == nullptr)
        fail(BTG_ERROR_UNSUPPORTED, at(at(path, "extensions"), draco_extension),
             extension_reason(draco_extension));
}

static Json clean_primitive(const Json &primitive, const Json &accessors, const std::string &path) {
    const Json &attributes =
        need_object(need_member(primitive, "attributes", path), at(path, "attributes"));
    Json kept = Json::object();
    if (const Json *position = find(attributes, position_attribute)) {
        std::string here = at(at(path, "attributes"), position_attribute);
        uint64_t index = need_index(*position, accessors.size(), "accessors", here);
        refuse_draco_only(primitive, accessors[index], path);
        kept[position_attribute] = index;
    }
    if (const Json *indices = find(primitive, "indices"))
        kept[index_attribute] =
            need_index(*indices, accessors.size(), "accessors", at(path, "indices"));
    return {{"attributes", kept}, {"mode", whole_member(primitive, "mode", {0, 6}, path, 4)}};
}

/* `primitives` counts those of all meshes. */
static Json clean_mesh(const Json &mesh, const Json &accessors, size_t &primitives,
                       const std::string &path) {
    Json out = Json::array();
    const Json &list = need_array(need_member(mesh, "primitives", path), at(path, "primitives"));
    limit_entries(primitives += list.size(), at(path, "primitives"));
    for (size_t i = 0; i < list.size(); i++)
        out.push_back(clean_primitive(list[i], accessors, at(at(path, "primitives"), i)));
    return {{"primitives", out}};
}

static Json clean_indices(const Json &list, size_t count, const char *what,
                          const std::string &path) {
    Json out = Json::array();
    for (size_t i = 0; i < list.size(); i++)
        out.push_back(need_index(list[i], count, what, at(path, i)));
    return out;
}

static Json clean_node(const Json &node, size_t node_count, size_t mesh_count,
                       const std::string &path) {
    Json out = {{"children", clean_indices(array_member(node, "children", path), node_count,
                                           "nodes", at(path, "children"))}};
    if (const Json *mesh = find(node, "mesh"))
        out["mesh"] = need_index(*mesh, mesh_count, "meshes", at(path, "mesh"));
    struct {
        const char *key;
        size_t count;
    } const transforms[] = {{"matrix", 16}, {"translation", 3}, {"rotation", 4}, {"scale", 3}};
    for (const auto &transform : transforms)
        if (const Json *value = find(node, transform.key))
            out[transform.key] = need_numbers(*value, transform.count, at(path, transform.key));
    if (out.contains("matrix") &&
        (out.contains("translation") || out.contains("rotation") || out.contains("scale")))
        malformed(at(path, "matrix"), "stands beside translation, rotation or scale; keep one");
    if (find_extension(node, "EXT_mesh_gpu_instancing", path) != nullptr)
        fail(BTG_ERROR_UNSUPPORTED, at(path, "extensions.EXT_mesh_gpu_instancing"),
             "instancing is not supported; export one node for each copy");
    return out;
}

static Json clean_scene(const Json &scene, size_t node_count, const std::string &path) {
    return {{"nodes", clean_indices(array_member(scene, "nodes", path), node_count, "nodes",
                                    at(path, "nodes"))}};
}

/* ---- the document ------------------------------------------------------------------------- */

/* clean[key] = each entry of json[key] through `clean_entry(entry, path)`. */
template <typename CleanEntry>
static void clean_list(const Json &json, const char *key, Json &clean, CleanEntry clean_entry) {
    Json out = Json::array();
    const Json &list = array_member(json, key, "");
    limit_entries(list.size(), key);
    for (size_t i = 0; i < list.size(); i++) {
        std::string path = at(key, i);
        out.push_back(clean_entry(need_object(list[i], path), path));
    }
    clean[key] = std::move(out);
}

static Json clean_document(const Json &json, const std::vector<Bytes> &buffers) {
    Json clean = {{"asset", {{"version", "2.0"}}}};
    clean["buffers"] = clean_buffers(buffers);
    clean_list(json, "bufferViews", clean, [&](const Json &view, const std::string &path) {
        return clean_view(view, buffers, path);
    });
    size_t views = clean["bufferViews"].size();
    clean_list(json, "accessors", clean, [&](const Json &accessor, const std::string &path) {
        return clean_accessor(accessor, views, path);
    });
    const Json &accessors = array_member(json, "accessors", "");
    size_t primitives = 0;
    clean_list(json, "meshes", clean, [&](const Json &mesh, const std::string &path) {
        return clean_mesh(mesh, accessors, primitives, path);
    });
    size_t meshes = clean["meshes"].size(), nodes = array_member(json, "nodes", "").size();
    clean_list(json, "nodes", clean, [&](const Json &node, const std::string &path) {
        return clean_node(node, nodes, meshes, path);
    });
    clean_list(json, "scenes", clean, [&](const Json &scene, const std::string &path) {
        return clean_scene(scene, nodes, path);
    });
    if (const Json *scene = find(json, "scene"))
        clean["scene"] = need_index(*scene, clean["scenes"].size(), "scenes", "scene");
    return clean;
}

/* ---- tinygltf ----------------------------------------------------------------------------- */

/* tinygltf joins folders to the name it is given; ours are numbers. */
static size_t buffer_number(const std::string &name) {
    return std::stoul(name.substr(name.find_last_of("/\\") + 1));
}

static bool read_whole_file(Bytes *out, std::string *, const std::string &name, void *user) {
    *out = std::move((*static_cast<std::vector<Bytes> *>(user))[buffer_number(name)]);
    return true;
}

tinygltf::Model build_model(const Json &json, std::vector<Bytes> &&buffers) {
    std::string text = clean_document(json, buffers).dump();
    if (text.size() > UINT32_MAX)
        throw Fault{BTG_ERROR_MEMORY, "the JSON is larger than 4 GB; split the file"};
    tinygltf::TinyGLTF reader;
    reader.SetFsCallbacks({[](const std::string &, void *) { return true; },
                           [](const std::string &name, void *) { return name; }, read_whole_file,
                           nullptr, &buffers});
    reader.SetImageLoader([](tinygltf::Image *, int, std::string *, std::string *, int, int,
                             const unsigned char *, int, void *) { return true; },
                          nullptr);
    tinygltf::Model model;
    std::string error, warning;
    if (!reader.LoadASCIIFromString(&model, &error, &warning, text.data(),
                                    static_cast<unsigned>(text.size()), ""))
        throw Fault{BTG_ERROR_FORMAT, "tinygltf cannot read it: " + plain(error, 200)};
    return model;
}

} // namespace btg_gltf
