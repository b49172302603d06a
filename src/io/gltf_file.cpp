/* From bytes to a JSON document: file, GLB container, limits on the text before it is parsed. */
#include "io/gltf_internal.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

namespace btg_gltf {

namespace fs = std::filesystem;

/* Ours needs 9 levels and exporters some 20; a parser must not be made to recurse by a file. */
constexpr size_t depth_max = 128;
/* Members and elements of one document. A value costs some 16 to 100 bytes once parsed. */
constexpr size_t values_max = 10000000;

static std::string within(const std::string &where, const std::string &text) {
    return where.empty() ? text : where + ": " + text;
}

static uint64_t regular_file_size(const fs::path &file, const std::string &where) {
    std::error_code error;
    fs::file_status status = fs::status(file, error);
    if (error || !fs::exists(status))
        throw Fault{BTG_ERROR_FILE, within(where, "cannot be opened, " +
                                                      (error ? error.message() : "no such file") +
                                                      "; check the name")};
    if (!fs::is_regular_file(status))
        throw Fault{BTG_ERROR_FILE, within(where, "is not a regular file; name a file")};
    uint64_t size = fs::file_size(file, error);
    if (error) throw Fault{BTG_ERROR_FILE, within(where, "has no size, " + error.message())};
    return size;
}

Bytes read_file(const fs::path &file, uint64_t limit, const std::string &where) {
    uint64_t size = std::min(regular_file_size(file, where), limit);
    std::unique_ptr<FILE, int (*)(FILE *)> stream(std::fopen(file.c_str(), "rb"), std::fclose);
    if (!stream)
        throw Fault{BTG_ERROR_FILE,
                    within(where, std::string("cannot be opened, ") + std::strerror(errno) +
                                      "; check the permissions")};
    Bytes bytes(size);
    if (size > 0 && std::fread(bytes.data(), 1, size, stream.get()) != size)
        throw Fault{BTG_ERROR_FILE, within(where, "cannot be read to its end; read error")};
    return bytes;
}

/* ---- GLB ---------------------------------------------------------------------------------- */

static uint32_t u32(const Bytes &bytes, size_t offset) {
    return uint32_t(bytes[offset]) | uint32_t(bytes[offset + 1]) << 8 |
           uint32_t(bytes[offset + 2]) << 16 | uint32_t(bytes[offset + 3]) << 24;
}

struct Chunk {
    size_t begin = 0, size = 0;
    bool present = false;
};

static constexpr uint32_t glb_magic = 0x46546c67, chunk_json = 0x4e4f534a, chunk_bin = 0x004e4942;

static void check_glb_header(const Bytes &bytes) {
    if (bytes.size() < 20)
        malformed("GLB header", "the file has " + std::to_string(bytes.size()) +
                                    " bytes; a GLB has at least 20: it is cut short");
    if (u32(bytes, 4) != 2)
        malformed("GLB header", "container version " + std::to_string(u32(bytes, 4)) +
                                    " is not 2; convert the file to glTF 2.0");
    if (u32(bytes, 8) != bytes.size())
        malformed("GLB header", "length " + std::to_string(u32(bytes, 8)) +
                                    " is not the file's size, " + std::to_string(bytes.size()) +
                                    " bytes; fetch the file again");
}

/* Chunk `number` begins at `offset`; unknown ones are skipped, as the specification asks. */
static void split_glb(const Bytes &bytes, Chunk &json, Chunk &binary) {
    check_glb_header(bytes);
    size_t offset = 12;
    for (size_t number = 0; offset < bytes.size(); number++) {
        std::string path = "GLB chunk " + std::to_string(number);
        if (bytes.size() - offset < 8) malformed(path, "its header is cut short");
        size_t size = u32(bytes, offset);
        uint32_t type = u32(bytes, offset + 4);
        offset += 8;
        if (size > bytes.size() - offset)
            malformed(path, "its length of " + std::to_string(size) +
                                " bytes passes the end of the file");
        if (size % 4 != 0) malformed(path, "its length is no multiple of 4");
        if (number == 0 && type != chunk_json) malformed(path, "the first chunk must be JSON");
        if (number == 0) json = {offset, size, true};
        if (number == 1 && type == chunk_bin) binary = {offset, size, true};
        offset += size;
    }
}

/* ---- JSON --------------------------------------------------------------------------------- */

/* Nesting and number of values, before a parser sees the text. */
static void check_text(const char *text, size_t size) {
    size_t depth = 0, values = 0;
    bool quoted = false;
    for (size_t i = 0; i < size; i++) {
        char c = text[i];
        if (quoted) {
            if (c == '\\') i++;
            if (c == '"') quoted = false;
            continue;
        }
        if (c == '"') quoted = true;
        if (c == '[' || c == '{') depth++, values++;
        if ((c == ']' || c == '}') && depth > 0) depth--;
        if (c == ',') values++;
        if (depth > depth_max)
            malformed("byte " + std::to_string(i), "the JSON is nested deeper than " +
                                                       std::to_string(depth_max) +
                                                       " levels; flatten it");
        if (values > values_max)
            fail(BTG_ERROR_MEMORY, "byte " + std::to_string(i),
                 "the JSON has more than " + std::to_string(values_max) +
                     " values; put triangles into binary buffers");
    }
}

/* Follows the parser to say where in the document it stopped. */
class Locator : public nlohmann::json_sax<Json> {
  public:
    bool null() override {
        return value();
    }
    bool boolean(bool) override {
        return value();
    }
    bool number_integer(number_integer_t) override {
        return value();
    }
    bool number_unsigned(number_unsigned_t) override {
        return value();
    }
    bool number_float(number_float_t, const string_t &) override {
        return value();
    }
    bool string(string_t &) override {
        return value();
    }
    bool binary(binary_t &) override {
        return value();
    }
    bool start_object(std::size_t) override {
        steps.push_back({true, "", 0});
        return true;
    }
    bool key(string_t &name) override {
        steps.back().key = plain(name, 40);
        return true;
    }
    bool end_object() override {
        steps.pop_back();
        return value();
    }
    bool start_array(std::size_t) override {
        steps.push_back({false, "", 0});
        return true;
    }
    bool end_array() override {
        steps.pop_back();
        return value();
    }
    bool parse_error(std::size_t byte, const std::string &,
                     const nlohmann::detail::exception &error) override {
        position = byte;
        too_large = error.id == 406; /* number overflow */
        return false;
    }
    std::string path() const {
        std::string out;
        for (const Step &step : steps)
            out = step.object ? at(out, step.key.c_str()) : at(out, step.index);
        return out;
    }
    std::size_t position = 0;
    bool too_large = false;

  private:
    struct Step {
        bool object;
        std::string key;
        size_t index;
    };
    std::vector<Step> steps;

    bool value() {
        if (!steps.empty()) steps.back().index++;
        return true;
    }
};

[[noreturn]] static void explain(const char *text, size_t size) {
    Locator locator;
    Json::sax_parse(text, text + size, &locator);
    size_t end = std::min(locator.position, size), line = 1, column = 0;
    for (size_t i = 0; i < end; i++) {
        column++;
        if (text[i] == '\n' && i + 1 < end) line++, column = 0;
    }
    malformed(locator.path(),
              "line " + std::to_string(line) + ", column " + std::to_string(column) +
                  (locator.too_large ? ": the number is too large for a double"
                                     : ": this is not JSON; mend or export the file again"));
}

Json parse_json(const char *text, size_t size) {
    check_text(text, size);
    Json json = Json::parse(text, text + size, nullptr, false);
    if (json.is_discarded()) explain(text, size);
    return json;
}

static Json parse(const char *text, size_t size) {
    Json json = parse_json(text, size);
    if (!json.is_object()) malformed("", "the JSON is no object, so this is no glTF file");
    return json;
}

Document read_document(const fs::path &file, uint64_t max_bytes) {
    uint64_t size = regular_file_size(file, "");
    if (size > max_bytes)
        throw Fault{BTG_ERROR_MEMORY, "has " + std::to_string(size) + " bytes, more than the " +
                                          std::to_string(max_bytes) +
                                          " allowed; raise max_file_bytes or split the file"};
    Bytes bytes = read_file(file, max_bytes, "");
    Document document;
    document.bytes = bytes.size();
    const char *text = reinterpret_cast<const char *>(bytes.data());
    if (bytes.size() < 4 || u32(bytes, 0) != glb_magic) {
        document.json = parse(text, bytes.size());
        return document;
    }
    Chunk json, binary;
    split_glb(bytes, json, binary);
    document.json = parse(text + json.begin, json.size);
    document.has_binary = binary.present;
    bytes.resize(binary.begin + binary.size);
    bytes.erase(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(binary.begin));
    document.binary = std::move(bytes);
    return document;
}

} // namespace btg_gltf
