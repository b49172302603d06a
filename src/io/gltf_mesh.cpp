/* Triangles: accessors of every layout glTF 2.0 allows for positions and indices. */
#include "io/gltf_internal.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace btg_gltf {

/* ---- accessors ---------------------------------------------------------------------------- */

/* Elements in a range of bytes that has been checked. */
struct Elements {
    const unsigned char *data = nullptr; /* null: all zero */
    size_t stride = 0, count = 0;
    int component = 0;
    size_t width = 0; /* components */
    bool normalized = false;

    double value(size_t element, size_t index) const;
    uint32_t whole(size_t element) const;
};

struct Accessor {
    Elements base, sparse_indices, sparse_values;
    double value(size_t element, size_t index) const;
    uint32_t whole(size_t element) const;

  private:
    std::optional<size_t> replaced(size_t element) const;
};

static size_t component_size(int type) {
    if (type == TINYGLTF_COMPONENT_TYPE_BYTE || type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE)
        return 1;
    return type == TINYGLTF_COMPONENT_TYPE_SHORT || type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT
               ? 2
               : 4;
}

/* Little-endian, any alignment, any host. */
static uint32_t load(const unsigned char *data, size_t size) {
    uint32_t bits = 0;
    for (size_t i = size; i-- > 0;)
        bits = bits << 8 | data[i];
    return bits;
}

static double number(uint32_t bits, int type, bool normalized) {
    switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE: {
        double signed_byte = static_cast<int8_t>(bits);
        return normalized ? std::max(signed_byte / 127.0, -1.0) : signed_byte;
    }
    case TINYGLTF_COMPONENT_TYPE_SHORT: {
        double signed_short = static_cast<int16_t>(bits);
        return normalized ? std::max(signed_short / 32767.0, -1.0) : signed_short;
    }
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return normalized ? bits / 255.0 : bits;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return normalized ? bits / 65535.0 : bits;
    case TINYGLTF_COMPONENT_TYPE_FLOAT: {
        float single;
        std::memcpy(&single, &bits, sizeof single);
        return single;
    }
    default:
        return bits;
    }
}

uint32_t Elements::whole(size_t element) const {
    return data == nullptr ? 0 : load(data + element * stride, component_size(component));
}

double Elements::value(size_t element, size_t index) const {
    if (data == nullptr) return 0.0;
    size_t size = component_size(component);
    return number(load(data + element * stride + index * size, size), component, normalized);
}

std::optional<size_t> Accessor::replaced(size_t element) const {
    size_t low = 0, high = sparse_indices.count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        uint32_t found = sparse_indices.whole(middle);
        if (found == element) return middle;
        if (found < element) low = middle + 1;
        if (found > element) high = middle;
    }
    return std::nullopt;
}

double Accessor::value(size_t element, size_t index) const {
    std::optional<size_t> change = replaced(element);
    return change ? sparse_values.value(*change, index) : base.value(element, index);
}

uint32_t Accessor::whole(size_t element) const {
    std::optional<size_t> change = replaced(element);
    return change ? sparse_values.whole(*change) : base.whole(element);
}

/* ---- opening an accessor ------------------------------------------------------------------ */

/* `shape` says count, component and width. */
static Elements open_elements(const tinygltf::Model &model, Elements shape, int view_index,
                              uint64_t offset, bool strided, const std::string &path) {
    const tinygltf::BufferView &view = model.bufferViews[static_cast<size_t>(view_index)];
    uint64_t size = component_size(shape.component) * shape.width;
    uint64_t stride = strided && view.byteStride > 0 ? view.byteStride : size;
    uint64_t end = offset + stride * (shape.count - 1) + size;
    if (end > view.byteLength)
        malformed(path, "needs " + std::to_string(end) + " bytes of bufferViews[" +
                            std::to_string(view_index) + "], which has " +
                            std::to_string(view.byteLength));
    if (stride < size) malformed(path, "its bufferView's byteStride is less than one element");
    const Bytes &bytes = model.buffers[static_cast<size_t>(view.buffer)].data;
    shape.data = bytes.data() + view.byteOffset + offset;
    shape.stride = stride;
    return shape;
}

static void open_sparse(const tinygltf::Model &model, const tinygltf::Accessor &accessor,
                        Accessor &out, const std::string &path) {
    const auto &sparse = accessor.sparse;
    Elements indices;
    indices.count = static_cast<size_t>(sparse.count);
    indices.component = sparse.indices.componentType;
    indices.width = 1;
    Elements values = out.base;
    values.count = indices.count;
    out.sparse_indices =
        open_elements(model, indices, sparse.indices.bufferView,
                      static_cast<uint64_t>(sparse.indices.byteOffset), false, at(path, "indices"));
    out.sparse_values =
        open_elements(model, values, sparse.values.bufferView,
                      static_cast<uint64_t>(sparse.values.byteOffset), false, at(path, "values"));
    for (size_t i = 0; i < indices.count; i++) {
        uint32_t index = out.sparse_indices.whole(i);
        if (index >= out.base.count || (i > 0 && index <= out.sparse_indices.whole(i - 1)))
            malformed(at(path, "indices"),
                      "entry " + std::to_string(i) + " is out of range or out of order");
    }
}

/* Elements of an accessor without data, which are zero: no bytes of a file pay for them. */
constexpr size_t zeros_max = 1000000;

static Accessor open_accessor(const tinygltf::Model &model, int index, bool strided) {
    const tinygltf::Accessor &accessor = model.accessors[static_cast<size_t>(index)];
    std::string path = at("accessors", static_cast<size_t>(index));
    Accessor out;
    out.base.count = accessor.count;
    out.base.component = accessor.componentType;
    out.base.width = accessor.type == TINYGLTF_TYPE_SCALAR ? 1 : 3;
    out.base.normalized = accessor.normalized;
    if (accessor.bufferView < 0 && accessor.count > zeros_max)
        fail(BTG_ERROR_MEMORY, at(path, "count"),
             std::to_string(accessor.count) + " elements without data; add a bufferView");
    Elements shape = out.base;
    if (accessor.sparse.isSparse) open_sparse(model, accessor, out, at(path, "sparse"));
    if (accessor.bufferView >= 0)
        out.base =
            open_elements(model, shape, accessor.bufferView, accessor.byteOffset, strided, path);
    return out;
}

static Accessor open_positions(const tinygltf::Model &model, int index, bool quantized,
                               const std::string &path) {
    const tinygltf::Accessor &accessor = model.accessors[static_cast<size_t>(index)];
    int component = accessor.componentType;
    if (accessor.type != TINYGLTF_TYPE_VEC3)
        malformed(path, "POSITION must be VEC3; export the file again");
    if (component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT ||
        (component != TINYGLTF_COMPONENT_TYPE_FLOAT && !quantized))
        malformed(path, "POSITION must be of componentType 5126 (float), or 8 or 16 bit under "
                        "KHR_mesh_quantization");
    return open_accessor(model, index, true);
}

static Accessor open_indices(const tinygltf::Model &model, int index, const std::string &path) {
    const tinygltf::Accessor &accessor = model.accessors[static_cast<size_t>(index)];
    int component = accessor.componentType;
    if (accessor.type != TINYGLTF_TYPE_SCALAR ||
        (component != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE &&
         component != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
         component != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT))
        malformed(path, "indices must be SCALAR of componentType 5121, 5123 or 5125");
    return open_accessor(model, index, false);
}

/* ---- triangles ---------------------------------------------------------------------------- */

/* Corner numbers of a primitive's triangles, in order of the index list. */
static std::vector<uint32_t> corners(int mode, size_t count, const std::string &path) {
    if (mode == TINYGLTF_MODE_TRIANGLES ? count % 3 != 0 : count < 3)
        malformed(path, std::to_string(count) + " vertices or indices make no whole triangles");
    std::vector<uint32_t> out;
    out.reserve(mode == TINYGLTF_MODE_TRIANGLES ? count : 3 * (count - 2));
    uint32_t last = static_cast<uint32_t>(count);
    if (mode == TINYGLTF_MODE_TRIANGLES)
        for (uint32_t i = 0; i < last; i++)
            out.push_back(i);
    else
        for (uint32_t i = 2; i < last; i++)
            out.insert(out.end(), {mode == TINYGLTF_MODE_TRIANGLE_FAN ? 0 : i - 2, i - 1, i});
    return out;
}

static void look_up(std::vector<uint32_t> &list, const Accessor &indices, size_t vertex_count,
                    const std::string &path) {
    for (uint32_t &entry : list) {
        uint32_t index = indices.whole(entry);
        if (index >= vertex_count)
            malformed(path, "index number " + std::to_string(entry) + " is " +
                                std::to_string(index) + ", but there are " +
                                std::to_string(vertex_count) + " vertices");
        entry = index;
    }
}

/* Many primitives may share one long list of vertices: keep the ones in use. */
static std::vector<uint32_t> keep_used(std::vector<uint32_t> &indices) {
    std::vector<uint32_t> used = indices;
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    if (used.size() == size_t(used.back()) + 1) return used;
    for (uint32_t &index : indices)
        index =
            static_cast<uint32_t>(std::lower_bound(used.begin(), used.end(), index) - used.begin());
    return used;
}

static void copy_positions(const std::vector<uint32_t> &used, const Accessor &positions,
                           const std::string &path, std::vector<double> &out) {
    out.reserve(3 * used.size());
    for (uint32_t vertex : used)
        for (size_t axis = 0; axis < 3; axis++) {
            double value = positions.value(vertex, axis);
            if (!std::isfinite(value))
                malformed(path, "POSITION of vertex " + std::to_string(vertex) +
                                    " is not finite; repair the mesh");
            out.push_back(value);
        }
}

std::optional<Mesh> read_triangles(const tinygltf::Model &model,
                                   const tinygltf::Primitive &primitive, bool quantized,
                                   const std::string &path, Budget &budget) {
    auto position = primitive.attributes.find(position_attribute);
    if (primitive.mode < TINYGLTF_MODE_TRIANGLES || position == primitive.attributes.end())
        return std::nullopt;
    std::string position_path = at("accessors", static_cast<size_t>(position->second));
    Accessor positions = open_positions(model, position->second, quantized, position_path);
    auto index = primitive.attributes.find(index_attribute);
    bool indexed = index != primitive.attributes.end();
    std::string index_path =
        indexed ? at("accessors", static_cast<size_t>(index->second)) : position_path;
    Accessor indices = indexed ? open_indices(model, index->second, index_path) : positions;
    budget.spend(indices.base.count, at(index_path, "count"));
    Mesh mesh;
    mesh.path = path;
    mesh.indices = corners(primitive.mode, indices.base.count, at(index_path, "count"));
    if (indexed) look_up(mesh.indices, indices, positions.base.count, index_path);
    copy_positions(keep_used(mesh.indices), positions, position_path, mesh.positions);
    return mesh;
}

} // namespace btg_gltf
