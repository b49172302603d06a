/* Faults, JSON paths and checked access to JSON values. */
#include "io/gltf_internal.h"

#include <cmath>

namespace btg_gltf {

void fail(btg_status status, const std::string &path, const std::string &reason) {
    throw Fault{status, path.empty() ? reason : path + ": " + reason};
}

void malformed(const std::string &path, const std::string &reason) {
    fail(BTG_ERROR_FORMAT, path, reason);
}

std::string plain(const std::string &text, size_t limit) {
    std::string out;
    for (char c : text) {
        if (out.size() == limit) return out + "...";
        out += c >= 0x20 && c < 0x7f ? c : '?';
    }
    return out;
}

std::string plain_file_name(const std::string &name) {
    constexpr size_t limit = 160; /* leaves most of a btg_message to the fault itself */
    std::string out;
    for (char c : name)
        out += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '?' : c;
    return out.size() <= limit ? out : "..." + out.substr(out.size() - limit);
}

std::string at(const std::string &path, const char *key) {
    return path.empty() ? key : path + "." + key;
}

std::string at(const std::string &path, size_t index) {
    return path + "[" + std::to_string(index) + "]";
}

const Json *find(const Json &object, const char *key) {
    auto found = object.find(key);
    return found == object.end() ? nullptr : &*found;
}

static std::string found_instead(const Json &value) {
    return std::string(", found ") + value.type_name();
}

const Json &need_object(const Json &value, const std::string &path) {
    if (!value.is_object()) malformed(path, "an object is needed here" + found_instead(value));
    return value;
}

const Json &need_array(const Json &value, const std::string &path) {
    if (!value.is_array()) malformed(path, "an array is needed here" + found_instead(value));
    return value;
}

const Json &need_member(const Json &object, const char *key, const std::string &path) {
    need_object(object, path);
    const Json *value = find(object, key);
    if (value == nullptr) malformed(at(path, key), "is missing; add it");
    return *value;
}

const Json &array_member(const Json &object, const char *key, const std::string &path) {
    static const Json empty = Json::array();
    const Json *value = find(need_object(object, path), key);
    return value == nullptr ? empty : need_array(*value, at(path, key));
}

const Json *find_extension(const Json &object, const char *name, const std::string &path) {
    const Json *extensions = find(object, "extensions");
    if (extensions == nullptr) return nullptr;
    return find(need_object(*extensions, at(path, "extensions")), name);
}

/* JSON does not tell 4 from 4.0; glTF takes both for an integer. */
static std::optional<uint64_t> whole(const Json &value) {
    if (value.is_number_unsigned()) return value.get<uint64_t>();
    if (!value.is_number_float()) return std::nullopt;
    double number = value.get<double>();
    if (!(number >= 0 && number <= 9007199254740992.0) || number != std::floor(number))
        return std::nullopt;
    return static_cast<uint64_t>(number);
}

static std::string from_to(Range range) {
    return std::to_string(range.min) + " to " + std::to_string(range.max);
}

uint64_t need_whole(const Json &value, Range range, const std::string &path) {
    std::optional<uint64_t> number = whole(value);
    if (!number && !value.is_number())
        malformed(path, "a whole number is needed here" + found_instead(value));
    if (!number) malformed(path, "is not a whole number from " + from_to(range));
    if (*number < range.min || *number > range.max)
        malformed(path, std::to_string(*number) + " is outside " + from_to(range));
    return *number;
}

uint64_t whole_member(const Json &object, const char *key, Range range, const std::string &path) {
    return need_whole(need_member(object, key, path), range, at(path, key));
}

uint64_t whole_member(const Json &object, const char *key, Range range, const std::string &path,
                      uint64_t fallback) {
    const Json *value = find(need_object(object, path), key);
    return value == nullptr ? fallback : need_whole(*value, range, at(path, key));
}

uint64_t need_index(const Json &value, size_t count, const char *what, const std::string &path) {
    std::optional<uint64_t> index = whole(value);
    if (!index) malformed(path, std::string("an index into ") + what + " is needed here");
    if (*index >= count)
        malformed(path, "index " + std::to_string(*index) + " is not in " + what + ", which has " +
                            std::to_string(count) + (count == 1 ? " entry" : " entries"));
    return *index;
}

double need_number(const Json &value, const std::string &path) {
    if (!value.is_number()) malformed(path, "a number is needed here" + found_instead(value));
    double number = value.get<double>();
    if (!std::isfinite(number)) malformed(path, "is not finite");
    return number;
}

std::vector<double> need_numbers(const Json &value, size_t count, const std::string &path) {
    need_array(value, path);
    if (value.size() != count)
        malformed(path, "has " + std::to_string(value.size()) + " numbers; it needs " +
                            std::to_string(count));
    std::vector<double> numbers(count);
    for (size_t i = 0; i < count; i++) {
        if (!value[i].is_number()) need_number(value[i], at(path, i));
        numbers[i] = value[i].get<double>();
    }
    return numbers;
}

} // namespace btg_gltf
