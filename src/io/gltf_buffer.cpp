/* Buffers: base64 text, the binary chunk, and files in the glTF file's own folder. */
#include "io/gltf_internal.h"

#include <algorithm>

namespace btg_gltf {

namespace fs = std::filesystem;

/* ---- base64 ------------------------------------------------------------------------------- */

static int sextet(char c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    if (c == '+') return 62;
    return c == '/' ? 63 : -1;
}

/* Strict: one foreign character means the file is damaged, and so would be the part. */
static Bytes decode_base64(const char *text, size_t size, const std::string &path) {
    if (size % 4 != 0) malformed(path, "its base64 text is cut short");
    size_t padding = 0;
    while (padding < 2 && padding < size && text[size - 1 - padding] == '=')
        padding++;
    Bytes bytes;
    bytes.reserve(size / 4 * 3);
    uint32_t bits = 0;
    for (size_t i = 0; i < size - padding; i++) {
        int value = sextet(text[i]);
        if (value < 0)
            malformed(path, "character " + std::to_string(i) + " of its data is not base64");
        bits = bits << 6 | static_cast<uint32_t>(value);
        size_t filled = i % 4;
        if (filled > 0) bytes.push_back(static_cast<unsigned char>(bits >> (6 - 2 * filled)));
    }
    return bytes;
}

static Bytes decode_data_uri(const std::string &uri, const std::string &path) {
    size_t comma = uri.find(',');
    static const std::string marker = ";base64";
    bool base64 = comma != std::string::npos && comma >= marker.size() &&
                  uri.compare(comma - marker.size(), marker.size(), marker) == 0;
    if (!base64)
        fail(BTG_ERROR_UNSUPPORTED, path, "a data URI must be base64; export the file again");
    return decode_base64(uri.data() + comma + 1, uri.size() - comma - 1, path);
}

/* ---- files -------------------------------------------------------------------------------- */

static int hex_digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

static std::string percent_decode(const std::string &uri, const std::string &path) {
    std::string out;
    for (size_t i = 0; i < uri.size(); i++) {
        char c = uri[i];
        if (c == '%') {
            int high = i + 2 < uri.size() ? hex_digit(uri[i + 1]) : -1;
            int low = i + 2 < uri.size() ? hex_digit(uri[i + 2]) : -1;
            if (high < 0 || low < 0) malformed(path, "has a broken %-sequence");
            c = static_cast<char>(high * 16 + low);
            i += 2;
        }
        if ((c >= 0 && c < 0x20) || c == 0x7f) malformed(path, "has a control character");
        out += c;
    }
    return out;
}

static bool has_scheme(const std::string &uri) {
    size_t end = uri.find_first_of(":/");
    return end != std::string::npos && uri[end] == ':';
}

/* A relative path without a way up, on any system. */
static fs::path relative_path(const std::string &uri, const std::string &path) {
    const char *remedy = "; keep buffers beside the glTF file, or pack them into a .glb";
    if (has_scheme(uri)) malformed(path, std::string("URIs with a scheme are not opened") + remedy);
    std::string name = percent_decode(uri, path);
    if (name.empty()) malformed(path, std::string("is empty") + remedy);
    fs::path relative(name);
    bool outside = relative.has_root_path() || name[0] == '\\' || has_scheme(name) ||
                   name.find('\\') != std::string::npos;
    for (const fs::path &step : relative)
        outside = outside || step == "..";
    if (outside) malformed(path, std::string("leads out of the file's folder") + remedy);
    return relative;
}

static Bytes read_beside(const fs::path &folder, const std::string &uri, uint64_t size,
                         const std::string &path) {
    fs::path relative = relative_path(uri, path);
    std::error_code error;
    fs::path base = fs::canonical(folder.empty() ? fs::path(".") : folder, error);
    fs::path file = fs::canonical(base / relative, error);
    if (error)
        fail(BTG_ERROR_FILE, path,
             "cannot be opened, " + error.message() +
                 "; put the buffer's file beside the glTF file");
    if (std::mismatch(base.begin(), base.end(), file.begin(), file.end()).first != base.end())
        malformed(path, "a symbolic link leads out of the file's folder; copy the file there");
    return read_file(file, size, path);
}

/* ---- all of them -------------------------------------------------------------------------- */

static bool meshopt_fallback(const Json &buffer, const std::string &path) {
    return find_extension(buffer, "EXT_meshopt_compression", path) != nullptr ||
           find_extension(buffer, "KHR_meshopt_compression", path) != nullptr;
}

static Bytes read_embedded(Document &document, const Json &buffer, size_t index,
                           const std::string &path) {
    if (meshopt_fallback(buffer, path))
        fail(BTG_ERROR_UNSUPPORTED, path,
             "its data is there with meshopt compression only; "
             "export the file without compression");
    if (index != 0 || !document.has_binary)
        malformed(at(path, "uri"), "is missing, and there is no binary chunk for it; add the uri");
    return std::move(document.binary);
}

static Bytes read_buffer(Document &document, const Json &buffer, size_t index, uint64_t size,
                         const fs::path &folder, const std::string &path) {
    const Json *uri = find(buffer, "uri");
    if (uri == nullptr) return read_embedded(document, buffer, index, path);
    std::string uri_path = at(path, "uri");
    if (!uri->is_string()) malformed(uri_path, "a string is needed here");
    const std::string &text = uri->get_ref<const std::string &>();
    if (text.compare(0, 5, "data:") == 0) return decode_data_uri(text, uri_path);
    return read_beside(folder, text, size, uri_path);
}

std::vector<Bytes> read_buffers(Document &document, const fs::path &folder, uint64_t budget) {
    const Json &list = array_member(document.json, "buffers", "");
    std::vector<Bytes> buffers;
    if (list.size() > 10000) fail(BTG_ERROR_MEMORY, "buffers", "more than 10000; join them");
    for (size_t i = 0; i < list.size(); i++) {
        std::string path = at("buffers", i);
        uint64_t size = whole_member(list[i], "byteLength", {1, offset_max}, path);
        if (size > budget)
            fail(BTG_ERROR_MEMORY, at(path, "byteLength"),
                 std::to_string(size) + " bytes are more than is left of the bytes allowed, " +
                     std::to_string(budget) + "; raise max_file_bytes");
        budget -= size;
        Bytes bytes = read_buffer(document, list[i], i, size, folder, path);
        if (bytes.size() < size)
            malformed(at(path, "byteLength"), "says " + std::to_string(size) +
                                                  " bytes, but the buffer holds " +
                                                  std::to_string(bytes.size()));
        bytes.resize(size);
        buffers.push_back(std::move(bytes));
    }
    return buffers;
}

} // namespace btg_gltf
