/* Machine files: JSON -> btg_machine. */
#include "io/machine.h"
#include "io/gltf_internal.h"

#include <cmath>
#include <cstdio>
#include <cstring>
#include <new>

using namespace btg_gltf;

namespace {

/* More than any machine has to say. */
constexpr uint64_t file_max = 1 << 20;
constexpr double degree = 3.14159265358979323846 / 180;

void known_members(const Json &object, std::initializer_list<const char *> known,
                   const std::string &path) {
    need_object(object, path);
    for (auto member = object.begin(); member != object.end(); ++member) {
        std::string list;
        bool found = false;
        for (const char *name : known) {
            found = found || member.key() == name;
            list += (list.empty() ? "" : ", ") + std::string(name);
        }
        if (!found)
            malformed(at(path, plain(member.key(), 40).c_str()),
                      "is not a member of a machine; known here: " + list);
    }
}

std::string need_string(const Json &value, const std::string &path) {
    if (!value.is_string())
        malformed(path, std::string("a string is needed here, found ") + value.type_name());
    return value.get<std::string>();
}

/* Index of the word among `words`. */
int need_word(const Json &value, std::initializer_list<const char *> words,
              const std::string &path) {
    std::string text = need_string(value, path), list;
    int index = 0;
    for (const char *word : words) {
        if (text == word) return index;
        list += (index > 0 ? ", " : "") + std::string(word);
        index++;
    }
    malformed(path, "'" + plain(text, 40) + "' is unknown; give one of " + list);
}

btg_vec3 need_vector(const Json &value, const std::string &path) {
    std::vector<double> v = need_numbers(value, 3, path);
    return {v[0], v[1], v[2]};
}

void take_number(const Json &object, const char *key, double scale, double &number,
                 const std::string &path) {
    if (const Json *value = find(object, key)) number = need_number(*value, at(path, key)) * scale;
}

void take_vector(const Json &object, const char *key, btg_vec3 &vector, const std::string &path) {
    if (const Json *value = find(object, key)) vector = need_vector(*value, at(path, key));
}

void take_limits(const Json &object, const char *key, double scale, double &min, double &max,
                 const std::string &path) {
    const Json *value = find(object, key);
    if (value == nullptr) return;
    std::vector<double> v = need_numbers(*value, 2, at(path, key));
    min = v[0] * scale;
    max = v[1] * scale;
}

void read_rotary(const Json &json, btg_rotary_def &r, const std::string &path) {
    known_members(json,
                  {"axis", "in", "direction", "pivot_mm", "limits_deg", "speed_deg_per_s",
                   "acceleration_deg_per_s2"},
                  path);
    r.letter = "ABC"[need_word(need_member(json, "axis", path), {"A", "B", "C"}, at(path, "axis"))];
    r.in_head = need_word(need_member(json, "in", path), {"table", "head"}, at(path, "in"));
    r.direction = need_vector(need_member(json, "direction", path), at(path, "direction"));
    take_vector(json, "pivot_mm", r.pivot, path);
    take_limits(json, "limits_deg", degree, r.min_rad, r.max_rad, path);
    take_number(json, "speed_deg_per_s", degree, r.speed_rad_per_s, path);
    take_number(json, "acceleration_deg_per_s2", degree, r.acceleration_rad_per_s2, path);
}

void read_linear(const Json &json, btg_linear_def &l, const std::string &path) {
    known_members(json, {"limits_mm", "speed_mm_per_s", "acceleration_mm_per_s2"}, path);
    take_limits(json, "limits_mm", 1, l.min_mm, l.max_mm, path);
    take_number(json, "speed_mm_per_s", 1, l.speed_mm_per_s, path);
    take_number(json, "acceleration_mm_per_s2", 1, l.acceleration_mm_per_s2, path);
}

void read_program(const Json &json, btg_machine_def &def, const std::string &path) {
    known_members(json, {"control", "tcp", "orientation", "feed"}, path);
    def.control = static_cast<btg_control>(need_word(need_member(json, "control", path),
                                                     {"linuxcnc", "fanuc", "siemens", "heidenhain"},
                                                     at(path, "control")));
    if (const Json *tcp = find(json, "tcp")) {
        if (!tcp->is_boolean()) malformed(at(path, "tcp"), "true or false is needed here");
        def.tcp = tcp->get<bool>();
    }
    if (const Json *word = find(json, "orientation"))
        def.vectors = need_word(*word, {"angles", "vector"}, at(path, "orientation"));
    /* Turning and moving joints have no common speed. */
    def.inverse_time = def.control == BTG_CONTROL_LINUXCNC || !def.tcp;
    if (const Json *word = find(json, "feed"))
        def.inverse_time = need_word(*word, {"per-minute", "inverse-time"}, at(path, "feed"));
}

btg_machine_def read_machine(const Json &json) {
    btg_machine_def def = btg_machine_def_default();
    if (!json.is_object()) malformed("", "the JSON is no object, so this is no machine file");
    known_members(json,
                  {"machine", "rotary", "linear", "part_origin_mm", "tool_length_mm",
                   "retract_z_mm", "program"},
                  "");
    if (const Json *name = find(json, "machine")) {
        std::string text = plain(need_string(*name, "machine"), sizeof def.name - 4);
        std::snprintf(def.name, sizeof def.name, "%s", text.c_str());
    }
    const Json &rotary = need_array(need_member(json, "rotary", ""), "rotary");
    if (rotary.size() != 2)
        malformed("rotary", "has " + std::to_string(rotary.size()) +
                                " entries; five axes have two, the carrying one first");
    for (size_t i = 0; i < 2; i++)
        read_rotary(rotary[i], def.rotary[i], at("rotary", i));
    if (const Json *linear = find(json, "linear")) {
        const char *const letters[3] = {"X", "Y", "Z"};
        known_members(*linear, {"X", "Y", "Z"}, "linear");
        for (int i = 0; i < 3; i++) {
            if (const Json *one = find(*linear, letters[i]))
                read_linear(*one, def.linear[i], at("linear", letters[i]));
        }
    }
    take_vector(json, "part_origin_mm", def.part_origin, "");
    take_number(json, "tool_length_mm", 1, def.tool_length_mm, "");
    take_number(json, "retract_z_mm", 1, def.retract_z_mm, "");
    read_program(need_member(json, "program", ""), def, "program");
    return def;
}

btg_machine_def read_file_or_name(const char *name) {
    btg_machine_def def;
    if (btg_machine_find(name, &def) == BTG_OK) return def;
    std::error_code error;
    if (!std::filesystem::exists(name, error) && std::strpbrk(name, "./") == nullptr) {
        std::string list;
        for (size_t i = 0; btg_machine_at(i, &def) == BTG_OK; i++)
            list += (i > 0 ? ", " : "") + std::string(def.name);
        throw Fault{BTG_ERROR_FILE, "neither a built-in machine nor a file; built in are " + list};
    }
    Bytes bytes = read_file(name, file_max + 1, "");
    if (bytes.size() > file_max)
        throw Fault{BTG_ERROR_FORMAT, "is larger than 1 MiB; this is no machine file"};
    return read_machine(parse_json(reinterpret_cast<const char *>(bytes.data()), bytes.size()));
}

btg_status try_load(const char *name, double tool_length_mm, btg_machine *machine,
                    std::string &text) {
    try {
        btg_machine_def def = read_file_or_name(name);
        if (!std::isnan(tool_length_mm)) def.tool_length_mm = tool_length_mm;
        btg_message reason = {};
        if (btg_machine_init(&def, machine, &reason) == BTG_OK) return BTG_OK;
        text = reason.text;
        return BTG_ERROR_FORMAT;
    } catch (const Fault &fault) {
        text = fault.text;
        return fault.status;
    }
}

} // namespace

btg_status btg_machine_load(const char *name_or_file, double tool_length_mm, btg_machine *machine,
                            btg_message *message) {
    btg_status status;
    try {
        std::string text;
        status = try_load(name_or_file, tool_length_mm, machine, text);
        if (status != BTG_OK && message != nullptr)
            std::snprintf(message->text, sizeof message->text, "%s: %s",
                          plain_file_name(name_or_file).c_str(), text.c_str());
    } catch (...) { /* std::bad_alloc */
        status = BTG_ERROR_MEMORY;
        if (message != nullptr) std::strcpy(message->text, "machine: no memory left to read it");
    }
    return status;
}
