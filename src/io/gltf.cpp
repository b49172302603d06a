/* The C side of the glTF reader: definitions, the boundary no exception passes, messages. */
#include "io/gltf_internal.h"

#include <cstdio>
#include <cstring>
#include <new>

using namespace btg_gltf;

static void set_message(btg_message *message, const std::string &text) {
    if (message == nullptr) return;
    std::snprintf(message->text, sizeof message->text, "%s", text.c_str());
}

/* ---- handing the shape to the core -------------------------------------------------------- */

static btg_surface_def surface_def(const Surface &surface) {
    btg_surface_def def = {};
    def.degree_u = surface.degree_u, def.degree_v = surface.degree_v;
    def.count_u = surface.count_u, def.count_v = surface.count_v;
    def.control_points = surface.points.data();
    def.weights = surface.weights.empty() ? nullptr : surface.weights.data();
    def.knots_u = surface.knots_u.data();
    def.knots_v = surface.knots_v.data();
    return def;
}

static btg_mesh_def mesh_def(const Mesh &mesh) {
    btg_mesh_def def = {};
    def.positions = mesh.positions.data();
    def.vertex_count = mesh.positions.size() / 3;
    def.indices = mesh.indices.data();
    def.triangle_count = mesh.indices.size() / 3;
    return def;
}

/* The core names "surface 3" or "mesh 0"; the file calls it otherwise. */
static std::string core_place(const Shape &shape, const char *text) {
    size_t index = 0;
    if (std::sscanf(text, "surface %zu:", &index) == 1 && index < shape.surfaces.size())
        return shape.surfaces[index].path + ": ";
    if (std::sscanf(text, "mesh %zu:", &index) == 1 && index < shape.meshes.size())
        return shape.meshes[index].path + ": ";
    return "";
}

static btg_part *create_part(const Shape &shape, const btg_allocator &allocator) {
    std::vector<btg_surface_def> surfaces;
    std::vector<btg_mesh_def> meshes;
    for (const Surface &surface : shape.surfaces)
        surfaces.push_back(surface_def(surface));
    for (const Mesh &mesh : shape.meshes)
        meshes.push_back(mesh_def(mesh));
    btg_part_def def = btg_part_def_default();
    def.surfaces = surfaces.data(), def.surface_count = surfaces.size();
    def.meshes = meshes.data(), def.mesh_count = meshes.size();
    def.allocator = allocator;
    btg_part *part = nullptr;
    btg_message message = {};
    btg_status status = btg_part_create(&def, &part, &message);
    if (status < 0)
        throw Fault{status == BTG_ERROR_ARGUMENT ? BTG_ERROR_FORMAT : status,
                    core_place(shape, message.text) + message.text};
    return part;
}

/* ---- public ------------------------------------------------------------------------------- */

static void check_def(const btg_gltf_def &def) {
    bool known = def.version == 1 &&
                 (def.unit == BTG_GLTF_METRE || def.unit == BTG_GLTF_MILLIMETRE) &&
                 (def.up == BTG_GLTF_UP_Y || def.up == BTG_GLTF_UP_Z);
    if (!known)
        throw Fault{BTG_ERROR_ARGUMENT, "glTF definition: version, unit or up axis is unknown; "
                                        "start from btg_gltf_def_default"};
}

static Shape load(const std::filesystem::path &file, const btg_gltf_def &def) {
    check_def(def);
    Document document = read_document(file, def.max_file_bytes);
    check_version(document.json);
    check_extensions(document.json);
    uint64_t bytes = document.bytes;
    std::vector<Bytes> buffers = read_buffers(document, file.parent_path(), def.max_file_bytes);
    for (const Bytes &buffer : buffers)
        bytes += buffer.size();
    tinygltf::Model model = build_model(document.json, std::move(buffers));
    return read_scene(document.json, model, def, bytes);
}

btg_gltf_def btg_gltf_def_default(void) {
    btg_gltf_def def = {};
    def.version = 1;
    def.unit = BTG_GLTF_METRE;
    def.up = BTG_GLTF_UP_Y;
    def.max_file_bytes = uint64_t(1) << 30;
    return def;
}

/* Everything that may throw. */
static btg_status try_load(const char *path, const btg_gltf_def &def, btg_part **part,
                           btg_message *message) {
    Fault fault = {BTG_OK, ""};
    try {
        Shape shape = load(path, def);
        if (!shape.note.empty()) fault.text = plain_file_name(path) + ": " + shape.note;
        *part = create_part(shape, def.allocator);
        set_message(message, fault.text);
        return BTG_OK;
    } catch (const Fault &caught) {
        fault = caught;
    } catch (const std::bad_alloc &) {
        fault = {BTG_ERROR_MEMORY, "no memory left to read it; split the file"};
    } catch (const std::exception &caught) {
        fault = {BTG_ERROR_FORMAT, "cannot be read: " + plain(caught.what(), 200)};
    }
    set_message(message, plain_file_name(path) + ": " + fault.text);
    return fault.status;
}

btg_status btg_gltf_load(const char *path, const btg_gltf_def *def, btg_part **part,
                         btg_message *message) {
    if (path == nullptr || def == nullptr || part == nullptr) {
        if (message != nullptr)
            std::strcpy(message->text, "glTF: path, definition or part is NULL");
        return BTG_ERROR_ARGUMENT;
    }
    try {
        return try_load(path, *def, part, message);
    } catch (...) { /* no memory even for the message */
        if (message != nullptr) std::strcpy(message->text, "glTF: no memory left to read a file");
        return BTG_ERROR_MEMORY;
    }
}
