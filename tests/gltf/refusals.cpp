// What the reader must refuse: the status, and a line that names the place in the file.
#include "part_view.h"

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>

#include <nlohmann/json.hpp>
#include <unistd.h>

namespace fs = std::filesystem;
using Json = nlohmann::json;

static fs::path data, scratch;

static Json read(const std::string &name) {
    std::ifstream in(data / name);
    return Json::parse(in);
}

static fs::path write(const std::string &name, const std::string &bytes) {
    std::ofstream(scratch / name, std::ios::binary) << bytes;
    return scratch / name;
}

static void expect(const fs::path &file, btg_status status, const std::string &words,
                   const std::string &name) {
    Loaded result = load(file.string());
    CHECK(result.status == status, "%s: %s, expected %s: %s", name.c_str(),
          btg_status_name(result.status), btg_status_name(status), result.message.c_str());
    CHECK(result.message.find(words) != std::string::npos, "%s: \"%s\" is not in \"%s\"",
          name.c_str(), words.c_str(), result.message.c_str());
    CHECK(result.message.rfind(file.string(), 0) == 0, "%s: the line does not begin with the file",
          name.c_str());
    for (char c : result.message)
        CHECK(static_cast<unsigned char>(c) >= 0x20, "%s: control character", name.c_str());
}

// One change to a file that loads.
struct Case {
    const char *pointer; // JSON pointer; an empty value deletes
    Json value;
    btg_status status;
    const char *words;
};

static const Json nothing; // null: delete

static void run(const char *base, const std::vector<Case> &cases) {
    for (const Case &one : cases) {
        Json json = read(base);
        Json::json_pointer pointer(one.pointer);
        if (one.value.is_null())
            json[pointer.parent_pointer()].erase(pointer.back());
        else
            json[pointer] = one.value;
        expect(write("case.gltf", json.dump()), one.status, one.words,
               std::string(base) + " " + one.pointer + " = " + one.value.dump().substr(0, 60));
    }
}

#define SURFACE      "/meshes/0/primitives/0/extensions/BITANGENT_tensor_surface/surfaces"
#define SURFACE_PATH "meshes[0].primitives[0].extensions.BITANGENT_tensor_surface.surfaces"

static void test_surfaces() {
    const btg_status bad = BTG_ERROR_FORMAT;
    run("exact_saddle.gltf",
        {{SURFACE, Json::array(), bad, SURFACE_PATH ": is empty"},
         {SURFACE "/0", 7, bad, SURFACE_PATH "[0]: an object"},
         {SURFACE "/0/degreeU", 0, bad, SURFACE_PATH "[0].degreeU: degree 0"},
         {SURFACE "/0/degreeU", 10, bad, SURFACE_PATH "[0].degreeU: degree 10"},
         {SURFACE "/0/degreeV", "3", bad, SURFACE_PATH "[0].degreeV: a whole number"},
         {SURFACE "/0/degreeV", -3, bad, SURFACE_PATH "[0].degreeV: is not a whole number"},
         {SURFACE "/0/countU", 3, bad, SURFACE_PATH "[0].countU: 3 control points are too few"},
         {SURFACE "/0/countU", 4.5, bad, SURFACE_PATH "[0].countU: "},
         {SURFACE "/0/countU", 4294967300, bad, SURFACE_PATH "[0].countU: 4294967300 is outside"},
         {SURFACE "/0/countU", 65540, bad, SURFACE_PATH "[0].controlPoints: has 48 numbers"},
         {SURFACE "/0/countV", 5, bad,
          SURFACE_PATH "[0].controlPoints: has 48 numbers; it needs 60"},
         {SURFACE "/0/countV", nothing, bad, SURFACE_PATH "[0].countV: is missing"},
         {SURFACE "/0/controlPoints", nothing, bad, SURFACE_PATH "[0].controlPoints: is missing"},
         {SURFACE "/0/controlPoints/17", "x", bad, SURFACE_PATH "[0].controlPoints[17]: a number"},
         {SURFACE "/0/controlPoints/17", 1e300, bad,
          SURFACE_PATH "[0].controlPoints: point 5 lies"},
         {SURFACE "/0/weights", Json::array({1, 2}), bad,
          SURFACE_PATH "[0].weights: has 2 numbers"},
         {SURFACE "/0/weights", std::vector<double>(16, 0.0), bad, SURFACE_PATH "[0].weights[0]: "},
         {SURFACE "/0/weights", std::vector<double>(16, -1.0), bad,
          SURFACE_PATH "[0].weights[0]: "},
         {SURFACE "/0/knotsU", {0, 0, 0, 0, 1, 1, 1}, bad, SURFACE_PATH "[0].knotsU: has 7"},
         {SURFACE "/0/knotsU",
          {0, 0, 0, 0, 1, 1, 0.5, 1},
          bad,
          SURFACE_PATH "[0].knotsU[6]: is below"},
         {SURFACE "/0/knotsV",
          {1, 1, 1, 1, 1, 1, 1, 1},
          bad,
          SURFACE_PATH "[0].knotsV: the knots span"},
         {SURFACE "/0/knotsV",
          {0, 0, 0, 0, 1, 1, 1, "1"},
          bad,
          SURFACE_PATH "[0].knotsV[7]: a number"}});
}

static void test_knots_inside() {
    Json json = read("exact_saddle.gltf");
    Json &surface = json[Json::json_pointer(SURFACE "/0")];
    surface["degreeU"] = 1;
    surface["knotsU"] = {0, 0, 0.5, 0.5, 1, 1};
    expect(write("case.gltf", json.dump()), BTG_ERROR_FORMAT,
           SURFACE_PATH "[0].knotsU[3]: repeats more than degree 1", "torn surface");
    surface.erase("knotsU");
    expect(write("case.gltf", json.dump()), BTG_ERROR_FORMAT, SURFACE_PATH "[0].countU: without",
           "Bezier of another count");
}

#define BREP      "/extensions/KITTYCAD_boundary_representation"
#define BREP_PATH "extensions.KITTYCAD_boundary_representation"

static void test_breps() {
    const btg_status bad = BTG_ERROR_FORMAT;
    run("exact_kittycad.gltf",
        {{BREP "/solids/0/mesh", 7, bad, BREP_PATH ".solids[0].mesh: index 7"},
         {BREP "/solids/0/shells/0/0", 1, bad, BREP_PATH ".solids[0].shells[0][0]: index 1"},
         {BREP "/shells/0/faces/0/0", 9, bad, BREP_PATH ".shells[0].faces[0][0]: index 9"},
         {BREP "/faces/0/surface/0", 1, bad, BREP_PATH ".faces[0].surface[0]: index 1"},
         {BREP "/faces/0/surface", nothing, bad, BREP_PATH ".faces[0].surface: is missing"},
         {BREP "/surfaces/0/type", 3, bad, BREP_PATH ".surfaces[0].type: a string"},
         {BREP "/surfaces/0/nurbs", nothing, bad, BREP_PATH ".surfaces[0].nurbs: is missing"},
         {BREP "/surfaces/0/nurbs/order/0", 0, bad, BREP_PATH ".surfaces[0].nurbs.order[0]: "},
         {BREP "/surfaces/0/nurbs/order/1", 11, bad, BREP_PATH ".surfaces[0].nurbs.order[1]: "},
         {BREP "/surfaces/0/nurbs/numKnots/1", 7, bad,
          BREP_PATH ".surfaces[0].nurbs.numKnots[1]: "},
         {BREP "/surfaces/0/nurbs/knotVector/9", -1, bad,
          BREP_PATH ".surfaces[0].nurbs.knotVector[9]: "},
         {BREP "/surfaces/0/nurbs/controlPoints/3",
          {1, 2},
          bad,
          BREP_PATH ".surfaces[0].nurbs.controlPoints[3]: has 2"}});
    run("exact_kittycad_no_mesh.gltf",
        {{BREP "/surfaces/0",
          {{"type", "cyl\ninder"}},
          BTG_ERROR_UNSUPPORTED,
          BREP_PATH ".surfaces[0].type: surfaces of type cyl?inder"},
         {BREP "/vertices/1", {0, 0, 0.01}, BTG_ERROR_UNSUPPORTED, BREP_PATH ".faces[0].loops: "},
         {"/nodes/0/extensions/KITTYCAD_boundary_representation/solid", 1, bad,
          "nodes[0].extensions.KITTYCAD_boundary_representation.solid: index 1"}});
}

static void test_accessors() {
    const btg_status bad = BTG_ERROR_FORMAT;
    run("same_u16.gltf",
        {{"/accessors/0/count", 21, bad,
          "accessors[0]: needs 252 bytes of bufferViews[0], which has 240"},
         {"/accessors/0/count", 0, bad, "accessors[0].count: 0 is outside"},
         {"/accessors/0/count", 18446744073709551615u, bad, "accessors[0].count: "},
         {"/accessors/0/count", 1099511627776, bad, "accessors[0]: needs"},
         {"/accessors/0/byteOffset", 4, bad, "accessors[0]: needs 244"},
         {"/accessors/0/byteOffset", -4, bad, "accessors[0].byteOffset: "},
         {"/accessors/0/componentType", 5125, bad, "accessors[0]: POSITION must be of"},
         {"/accessors/0/componentType", 5122, bad, "accessors[0]: POSITION must be of"},
         {"/accessors/0/componentType", 5130, bad, "accessors[0].componentType: 5130"},
         {"/accessors/0/type", "VEC4", bad, "accessors[0]: POSITION must be VEC3"},
         {"/accessors/0/type", "vec3", bad, "accessors[0].type: "},
         {"/accessors/0/bufferView", 2, bad,
          "accessors[0].bufferView: index 2 is not in bufferViews"},
         {"/accessors/0/bufferView", 4294967296, bad, "accessors[0].bufferView: index 4294967296"},
         {"/accessors/1/componentType", 5126, bad, "accessors[1]: indices must be"},
         {"/accessors/1/count", 71, bad,
          "accessors[1].count: 71 vertices or indices make no whole"},
         {"/accessors/1/bufferView", 0, bad, "accessors[1]: index number "},
         {"/bufferViews/0/byteLength", 100000, bad, "bufferViews[0].byteLength: bytes 0 to 100000"},
         {"/bufferViews/0/byteStride", 8, bad, "accessors[0]: its bufferView's byteStride"},
         {"/bufferViews/0/byteStride", 254, bad, "bufferViews[0].byteStride: "},
         {"/bufferViews/0/buffer", 1, bad, "bufferViews[0].buffer: index 1 is not in buffers"},
         {"/bufferViews/0", "x", bad, "bufferViews[0]: an object"},
         {"/bufferViews", nothing, bad,
          "accessors[0].bufferView: index 0 is not in bufferViews, which has 0"},
         {"/accessors", nothing, bad, "meshes[0].primitives[0].attributes.POSITION: index 0"},
         {"/meshes/0/primitives/0/mode", 7, bad, "meshes[0].primitives[0].mode: 7"},
         {"/meshes/0/primitives/0/mode", 1, bad, "scenes: the default scene has no surface"},
         {"/meshes/0/primitives/0/attributes", nothing, bad,
          "meshes[0].primitives[0].attributes: is missing"},
         {"/meshes/0/primitives", {{"x", 1}}, bad, "meshes[0].primitives: an array"}});
}

static void test_sparse() {
    const btg_status bad = BTG_ERROR_FORMAT;
    run("same_sparse_zeros.gltf",
        {{"/accessors/0/count", 1000001, BTG_ERROR_MEMORY, "accessors[0].count: 1000001 elements"},
         {"/accessors/0/sparse/count", 21, bad, "accessors[0].sparse.count: 21"},
         {"/accessors/0/sparse/indices/componentType", 5126, bad,
          "accessors[0].sparse.indices.componentType"},
         {"/accessors/0/sparse/indices/bufferView", 1, bad, "accessors[0].sparse.indices: entry "},
         {"/accessors/0/sparse/values", nothing, bad, "accessors[0].sparse.values: is missing"}});
}

// The first coordinate of the first vertex becomes a NaN.
static void test_nan() {
    Json json = read("same_u16.gltf");
    std::string uri = json["buffers"][0]["uri"];
    uri.replace(uri.find(',') + 1, 8, "AADAfwAA");
    json["buffers"][0]["uri"] = uri;
    expect(write("case.gltf", json.dump()), BTG_ERROR_FORMAT,
           "accessors[0]: POSITION of vertex 0 is not finite", "NaN");
}

static void test_nodes() {
    const btg_status bad = BTG_ERROR_FORMAT;
    run("same_hierarchy.gltf",
        {{"/nodes/0/children", {3}, bad, "nodes["},
         {"/nodes/2/children", {0, 0}, bad, "nodes[2].children[1]: node 0 has another parent"},
         {"/nodes/2/children", {2}, bad, "nodes[3].children[0]: node 2 has another parent"},
         {"/nodes/3/children", {3}, bad, "nodes[3]: is among its own descendants"},
         {"/nodes/3/children/0", 4, bad, "nodes[3].children[0]: index 4"},
         {"/nodes/3/children/0", "2", bad, "nodes[3].children[0]: an index into nodes"},
         {"/nodes/0/mesh", 2, bad, "nodes[0].mesh: index 2"},
         {"/nodes/0/scale", {1, 2}, bad, "nodes[0].scale: has 2 numbers"},
         {"/nodes/0/rotation", {0, 0, 0, 0}, bad, "nodes[0].rotation: is no unit quaternion"},
         {"/nodes/0/matrix", std::vector<int>(16, 1), bad, "nodes[0].matrix: stands beside"},
         {"/nodes/0/scale", {1e300, 1, 1}, bad, "meshes[0].primitives[0]: vertex 0 lies beyond"},
         {"/scenes/0/nodes", {0}, bad, "scenes[0].nodes[0]: node 0 is a child"},
         {"/scenes/0/nodes", {3, 3}, bad, "scenes[0].nodes[1]: node 3 is listed twice"},
         {"/scenes/0/nodes", {4}, bad, "scenes[0].nodes[0]: index 4"},
         {"/scenes/0/nodes", nothing, bad, "scenes: the default scene has no surface"},
         {"/scene", 1, bad, "scene: index 1 is not in scenes, which has 1 entry"}});
    run("same_matrix.gltf", {{"/nodes/0/matrix/3", 1, bad, "nodes[0].matrix: its last row"}});
}

static void test_document() {
    const btg_status bad = BTG_ERROR_FORMAT, no = BTG_ERROR_UNSUPPORTED;
    run("same_u16.gltf", {{"/asset", nothing, bad, "asset: is missing"},
                          {"/asset/version", "1.0", no, "asset.version: version 1.0"},
                          {"/asset/version", 2, bad, "asset.version: a string"},
                          {"/asset/minVersion", "2.1", no, "asset.minVersion: "},
                          {"/extensionsRequired",
                           {"KHR_draco_mesh_compression"},
                           no,
                           "extensionsRequired[0]: KHR_draco_mesh_compression: Draco"},
                          {"/extensionsRequired",
                           {"EXT_meshopt_compression"},
                           no,
                           "extensionsRequired[0]: EXT_meshopt_compression: meshopt"},
                          {"/extensionsRequired",
                           {"KHR_materials_unlit", "ACME_thing\n"},
                           no,
                           "extensionsRequired[1]: the file requires the extension ACME_thing?"},
                          {"/nodes/0/extensions/EXT_mesh_gpu_instancing", Json::object(), no,
                           "nodes[0].extensions.EXT_mesh_gpu_instancing: "},
                          {"/meshes", nothing, bad, "nodes[0].mesh: index 0 is not in meshes"}});
    Json draco = read("same_u16.gltf");
    draco["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"] = {};
    draco["accessors"][0].erase("bufferView");
    expect(write("case.gltf", draco.dump()), no,
           "meshes[0].primitives[0].extensions.KHR_draco_mesh_compression: ", "Draco data only");
}

static void test_buffer_uris() {
    const btg_status bad = BTG_ERROR_FORMAT;
    fs::create_directories(scratch / "inner");
    write("outside.bin", std::string(384, 'x'));
    fs::remove(scratch / "inner" / "link.bin");
    fs::create_symlink(scratch / "outside.bin", scratch / "inner" / "link.bin");
    fs::path absolute = scratch / "outside.bin";
    struct {
        std::string uri;
        btg_status status;
        const char *words;
    } const cases[] = {
        {"../outside.bin", bad, "buffers[0].uri: leads out"},
        {"a/../../outside.bin", bad, "buffers[0].uri: leads out"},
        {"%2e%2e/outside.bin", bad, "buffers[0].uri: leads out"},
        {"%2E%2E%2Foutside.bin", bad, "buffers[0].uri: leads out"},
        {"..\\outside.bin", bad, "buffers[0].uri: leads out"},
        {absolute.string(), bad, "buffers[0].uri: leads out"},
        {"file://" + absolute.string(), bad, "buffers[0].uri: URIs with a scheme"},
        {"http://example.com/a.bin", bad, "buffers[0].uri: URIs with a scheme"},
        {"link.bin", bad, "buffers[0].uri: a symbolic link"},
        {"none.bin", BTG_ERROR_FILE, "buffers[0].uri: cannot be opened"},
        {".", BTG_ERROR_FILE, "buffers[0].uri: is not a regular file"},
        {"", bad, "buffers[0].uri: is empty"},
        {"a%00b", bad, "buffers[0].uri: has a control"},
        {"a\nb", bad, "buffers[0].uri: has a control"},
        {"a%zz", bad, "buffers[0].uri: has a broken"},
        {"data:application/octet-stream;base64,AAAA", bad, "buffers[0].byteLength: says 384 bytes"},
        {"data:application/octet-stream;base64,AA*A", bad, "buffers[0].uri: character 2"},
        {"data:application/octet-stream;base64,AAA", bad, "buffers[0].uri: its base64"},
        {"data:text/plain,hello", BTG_ERROR_UNSUPPORTED, "buffers[0].uri: a data URI"},
    };
    for (const auto &one : cases) {
        Json json = read("same_u16.gltf");
        json["buffers"][0]["uri"] = one.uri;
        expect(write("inner/case.gltf", json.dump()), one.status, one.words, one.uri);
    }
}

static void test_buffers() {
    const btg_status bad = BTG_ERROR_FORMAT;
    run("same_u16.gltf",
        {{"/buffers/0/uri", nothing, bad, "buffers[0].uri: is missing"},
         {"/buffers/0/uri", 5, bad, "buffers[0].uri: a string"},
         {"/buffers/0/byteLength", 0, bad, "buffers[0].byteLength: 0 is outside"},
         {"/buffers/0/byteLength", 1099511627776, BTG_ERROR_MEMORY, "buffers[0].byteLength: "}});
}

static std::string u32(uint32_t value) {
    std::string out;
    for (int i = 0; i < 4; i++)
        out += static_cast<char>(value >> (8 * i) & 255);
    return out;
}

static std::string glb(const std::string &text, const std::string &rest, uint32_t version = 2,
                       int length_error = 0) {
    std::string body = u32(static_cast<uint32_t>(text.size())) + "JSON" + text + rest;
    return "glTF" + u32(version) +
           u32(static_cast<uint32_t>(12 + body.size()) + static_cast<uint32_t>(length_error)) +
           body;
}

static void test_glb() {
    const std::string text = "{\"asset\":{\"version\":\"2.0\"}} ";
    const std::string bin = std::string("BIN") + '\0';
    struct {
        const char *name;
        std::string bytes;
        const char *words;
    } const cases[] = {
        {"magic alone", "glTF", "GLB header: the file has 4 bytes"},
        {"version 1", glb(text, "", 1), "GLB header: container version 1"},
        {"length too large", glb(text, "", 2, 4),
         "GLB header: length 52 is not the file's size, 48"},
        {"length too small", glb(text, "", 2, -4), "GLB header: length 44"},
        {"binary first", "glTF" + u32(2) + u32(24) + u32(4) + bin + "abcd",
         "GLB chunk 0: the first"},
        {"chunk header cut", glb(text, "abcd"), "GLB chunk 1: its header"},
        {"chunk past the end", glb(text, u32(8) + bin + "abcd"), "GLB chunk 1: its length of 8"},
        {"chunk of 4 GB", glb(text, u32(0xfffffffc) + bin + "abcd"), "GLB chunk 1: its length"},
        {"odd length", glb(text, u32(3) + bin + "abc"), "GLB chunk 1: its length is no multiple"},
        {"no scene", glb(text, ""), "nodes: the default scene has no surface"},
    };
    for (const auto &one : cases)
        expect(write("case.glb", one.bytes), BTG_ERROR_FORMAT, one.words, one.name);
}

static void test_text() {
    struct {
        const char *name;
        std::string bytes;
        const char *words;
    } const cases[] = {
        {"empty", "", "line 1, column 0: this is not JSON"},
        {"no JSON", "solid part", "line 1, column 1: this is not JSON"},
        {"cut short", "{\"asset\": {\n\"version\":", "asset.version: line 2, column 10: this"},
        {"array", "[]", "the JSON is no object"},
        {"not a number", "{\"nodes\": [{\"scale\": [1, NaN]}]}",
         "nodes[0].scale[1]: line 1, column "},
        {"too large", "{\"nodes\": [{\"scale\": [1, 1e999]}]}",
         "nodes[0].scale[1]: line 1, column 30: the number is too large"},
        {"deep", std::string(100000, '['), "byte 128: the JSON is nested deeper than 128"},
        {"deep objects", "{\"a\":" + std::string(70000, '[') + std::string(70000, ']') + "}",
         "byte 132"},
        {"key of the file", "{\"a\\n\\u202eb\": nul}", "a????b: line 1"},
        {"bad UTF-8", "{\"a\": \"\xff\"}", "a: line 1, column "},
    };
    for (const auto &one : cases)
        expect(write("case.gltf", one.bytes), BTG_ERROR_FORMAT, one.words, one.name);
    expect(scratch / "there is none.gltf", BTG_ERROR_FILE, "cannot be opened, ", "missing file");
    expect(scratch, BTG_ERROR_FILE, "is not a regular file", "directory");
}

// The name is the caller's, yet the message stays one line.
static void test_name() {
    Loaded result = load((scratch / "a\nb\tc.gltf").string());
    CHECK(result.message.find("a?b?c.gltf: cannot be opened") != std::string::npos, "%s",
          result.message.c_str());
    result.~Loaded();
    new (&result) Loaded(load(std::string(3000, 'x')));
    CHECK(result.status == BTG_ERROR_FILE && result.message.size() < 300, "%s",
          result.message.c_str());
}

static void test_arguments() {
    btg_gltf_def def = btg_gltf_def_default();
    btg_part *part = nullptr;
    CHECK(btg_gltf_load(nullptr, &def, &part, nullptr) == BTG_ERROR_ARGUMENT, "NULL path");
    CHECK(btg_gltf_load("x", nullptr, &part, nullptr) == BTG_ERROR_ARGUMENT, "NULL definition");
    CHECK(btg_gltf_load("x", &def, nullptr, nullptr) == BTG_ERROR_ARGUMENT, "NULL part");
    def.version = 0;
    CHECK(btg_gltf_load("x", &def, &part, nullptr) == BTG_ERROR_ARGUMENT, "version 0");
    def = btg_gltf_def_default();
    def.max_file_bytes = 100;
    Loaded large = load((data / "same_u16.gltf").string(), def);
    CHECK(large.status == BTG_ERROR_MEMORY, "%s", large.message.c_str());
    def.max_file_bytes = 1000; // the .bin beside it has 384, the file 600
    Loaded fits = load((data / "same_external.gltf").string(), def);
    CHECK(fits.status == BTG_OK, "%s", fits.message.c_str());
}

static void *refuse_memory(size_t, void *) {
    return nullptr;
}

static void test_no_memory() {
    btg_gltf_def def = btg_gltf_def_default();
    def.allocator.allocate = refuse_memory;
    def.allocator.release = [](void *, void *) {};
    Loaded result = load((data / "same_u16.gltf").string(), def);
    CHECK(result.status == BTG_ERROR_MEMORY, "%s", result.message.c_str());
}

static void test_many_entries() {
    Json json = read("same_u16.gltf");
    json["nodes"] = std::vector<Json>(250001, Json::object());
    expect(write("case.gltf", json.dump()), BTG_ERROR_MEMORY, "nodes: 250001 entries", "nodes");
    json = read("same_u16.gltf");
    json["meshes"][0]["primitives"] = std::vector<Json>(250001, {{"attributes", Json::object()}});
    expect(write("case.gltf", json.dump()), BTG_ERROR_MEMORY,
           "meshes[0].primitives: 250001 entries", "primitives");
    std::string zeros = "{\"a\":[0";
    for (int i = 0; i < 10000000; i++)
        zeros += ",0";
    expect(write("case.gltf", zeros + "]}"), BTG_ERROR_MEMORY,
           ": the JSON has more than 10000000 values", "values");
}

// A kilobyte that asks for gigabytes: copies of a mesh, and of a list of zeros.
static void test_bombs() {
    Json json = read("same_sparse_zeros.gltf");
    json["accessors"][0]["count"] = 999999;
    json["meshes"][0]["primitives"][0].erase("indices");
    for (int i = 1; i < 10; i++) {
        json["nodes"].push_back({{"mesh", 0}});
        json["scenes"][0]["nodes"].push_back(i);
    }
    expect(write("case.gltf", json.dump()), BTG_ERROR_MEMORY, "accessors[0].count: asks for more",
           "instances of zeros");
}

int main(int count, char **words) {
    if (count < 2) return 2;
    data = words[1];
    char folder[] = "/tmp/bitangent-gltf-XXXXXX";
    if (mkdtemp(folder) == nullptr) return 2;
    scratch = fs::canonical(folder);
    for (auto test :
         {test_surfaces, test_knots_inside, test_breps, test_accessors, test_sparse, test_nan,
          test_nodes, test_document, test_buffer_uris, test_buffers, test_glb, test_text, test_name,
          test_arguments, test_no_memory, test_many_entries, test_bombs})
        test();
    fs::remove_all(scratch);
    return report("refusals");
}
