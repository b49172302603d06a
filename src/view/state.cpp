#include "view/state.h"
#include "view/pose.h"

extern "C" {
#include "app/number.h"
#include "methods/method.h"
}

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>

namespace view {

static constexpr double degree = 3.14159265358979323846 / 180;

const btg_row *current(const state &s) {
    return s.path && s.at < s.path->rows.size() ? &s.path->rows[s.at] : nullptr;
}

/* ---- along the path ----------------------------------------------------------------------- */

static pose pose_here(const state &s) {
    const btg_row *row = current(s);
    return row && s.part ? pose_of(s.part->tool, row->position) : pose();
}

void go_to(state *s, std::size_t row) {
    if (!s->path || s->path->rows.empty()) return;
    pose before = pose_here(*s);
    s->at = std::min(row, s->path->rows.size() - 1);
    pose now = pose_here(*s);
    if (s->follow && before.placed && now.placed) s->eye.target += now.centre - before.centre;
}

void step(state *s, long rows) {
    long last = s->path ? static_cast<long>(s->path->rows.size()) - 1 : 0;
    go_to(s, static_cast<std::size_t>(std::clamp(static_cast<long>(s->at) + rows, 0L, last)));
}

void step_pass(state *s, int direction) {
    const btg_row *row = current(*s);
    if (!row) return;
    const std::vector<btg_row> &rows = s->path->rows;
    std::size_t at = s->at;
    if (direction > 0) {
        while (at + 1 < rows.size() && rows[at].pass == row->pass)
            at++;
    } else {
        if (at > 0) at--;
        while (at > 0 && rows[at - 1].pass == rows[at].pass)
            at--;
    }
    go_to(s, at);
}

void advance(state *s, double seconds) {
    if (!s->playing || !s->path) return;
    s->progress += seconds * s->speed;
    double whole = std::floor(s->progress);
    s->progress -= whole;
    if (whole > 0) step(s, static_cast<long>(std::min(whole, 1e6)));
    if (s->at + 1 >= s->path->rows.size()) s->playing = false;
}

/* How much there is to see: a tilt, and contacts that are apart. */
static double worth(const pose &at) {
    return at.has_q ? (0.01 + at.tilt_rad) * glm::distance(at.p, at.q) : 0;
}

/* Of the positions with about as much to see as any, the one nearest the middle of the part. */
void go_to_best(state *s) {
    if (!s->path || !s->part) return;
    const subject &part = *s->part;
    const std::vector<btg_row> &rows = s->path->rows;
    glm::dvec3 middle = 0.5 * (to_glm(part.info.box_min) + to_glm(part.info.box_max));
    double most = 0, nearest = INFINITY;
    std::size_t best = 0;
    for (const btg_row &row : rows)
        most = std::max(most, worth(pose_of(part.tool, row.position)));
    for (std::size_t i = 0; i < rows.size(); i++) {
        pose at = pose_of(part.tool, rows[i].position);
        double away = glm::distance(at.tip, middle);
        if (!at.placed || worth(at) < 0.6 * most || !(away < nearest)) continue;
        nearest = away, best = i;
    }
    go_to(s, best);
}

static void go_to_gouge(state *s) {
    std::size_t row = s->left->result.gouge.line;
    s->seek_gouge = false;
    if (row == 0) {
        s->note = "nothing is gouged";
        return;
    }
    go_to(s, row - 1);
    look_at_tool(s);
}

void set_field(state *s, std::shared_ptr<field> left) {
    s->left = std::move(left);
    if (s->seek_gouge && s->left) go_to_gouge(s);
}

static void seek_gouge(state *s) {
    s->gouge = true, s->seek_gouge = true;
    if (s->left) go_to_gouge(s);
}

void set_path(state *s, std::shared_ptr<tour> path) {
    s->path = std::move(path);
    s->left = nullptr;
    s->uncuttable = false;
    std::size_t count = s->path ? s->path->rows.size() : 0;
    s->at = count > 0 ? std::min(s->at, count - 1) : 0;
}

/* ---- files dropped on it ------------------------------------------------------------------ */

static bool is_part(const std::string &file) {
    std::size_t dot = file.find_last_of("./");
    std::string ending = dot == std::string::npos ? "" : file.substr(dot);
    for (char &c : ending)
        c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return ending == ".gltf" || ending == ".glb";
}

void open_dropped(state *s, const path_options &options) {
    std::string file = std::move(s->dropped);
    btg_status status = BTG_OK;
    btg_message message = {};
    work w;
    s->dropped.clear();
    s->note.clear();
    if (is_part(file)) {
        std::shared_ptr<subject> part = load_subject(options, file.c_str(), &status, &message);
        if (part) {
            set_path(s, nullptr);
            s->part = part;
            s->recompute = true;
            look_at_part(s);
        }
    } else if (std::shared_ptr<tour> path =
                   load_tour(*s->part, options, file.c_str(), &w, &status, &message)) {
        set_path(s, path);
        go_to_best(s);
        look_at_tool(s);
    }
    if (status < 0) s->note = message.text;
}

/* ---- the camera --------------------------------------------------------------------------- */

static double reach(const btg_tool &tool) {
    return tool.def.major_radius_mm + tool.def.minor_radius_mm;
}

void look_at_tool(state *s) {
    pose at = pose_here(*s);
    if (!at.placed) {
        look_at_part(s);
        return;
    }
    camera_fit(&s->eye, at.centre + 0.7 * reach(s->part->tool) * at.axis,
               surroundings * reach(s->part->tool), s->aspect);
}

void look_at_part(state *s) {
    if (!s->part) return;
    glm::dvec3 low = to_glm(s->part->info.box_min), high = to_glm(s->part->info.box_max);
    camera_fit(&s->eye, 0.5 * (low + high), 0.55 * glm::distance(low, high), s->aspect);
}

static const struct {
    const char *name;
    double azimuth_deg, elevation_deg;
} sides[] = {{"iso", -60, 30}, {"top", -90, 90}, {"front", -90, 0},
             {"back", 90, 0},  {"left", 180, 0}, {"right", 0, 0}};

static bool angles_of(const char *name, double angle[2]) {
    for (const auto &side : sides)
        if (std::strcmp(side.name, name) == 0) {
            angle[0] = side.azimuth_deg, angle[1] = side.elevation_deg;
            return true;
        }
    return number_parse_list(name, angle, 2) == 2 && std::fabs(angle[0]) <= 360 &&
           std::fabs(angle[1]) <= 90;
}

bool view_name_known(const char *name) {
    double angle[2];
    return std::strcmp(name, "tilt") == 0 || angles_of(name, angle);
}

/* Along u, from the side on which the eye is; a little from above, so that the part is seen. */
static void look_along_tilt(state *s) {
    pose at = pose_here(*s);
    s->eye.azimuth_deg = sides[0].azimuth_deg, s->eye.elevation_deg = 12;
    if (!at.framed || std::hypot(at.u.x, at.u.y) < 0.1) return;
    glm::dvec3 u = at.u.y > 0 ? -at.u : at.u;
    s->eye.azimuth_deg = std::atan2(u.y, u.x) / degree;
}

bool look_from(state *s, const char *name) {
    double angle[2];
    if (std::strcmp(name, "tilt") == 0) {
        look_along_tilt(s);
        return true;
    }
    if (!angles_of(name, angle)) return false;
    s->eye.azimuth_deg = angle[0], s->eye.elevation_deg = angle[1];
    return true;
}

/* ---- keys --------------------------------------------------------------------------------- */

const key_help key_list[] = {
    {"drag", "turn"},
    {"right drag, Shift drag", "move"},
    {"wheel, + -", "nearer, farther"},
    {"Space, [ ]", "play, stop; slower, faster"},
    {"Left Right", "one position"},
    {"Shift Left Right", "ten"},
    {"Up Down", "pass"},
    {"Home End", "first, last"},
    {"F, A", "look at tool, at all"},
    {"1 2 3 4 5", "along tilt, iso, top, front, right"},
    {"T", "tool solid, clear, hidden"},
    {"N", "normals at P and Q"},
    {"I", "pseudo-insert"},
    {"C", "circular ray to Q"},
    {"L", "tilt: axis before, after"},
    {"R", "trail of P and Q"},
    {"G", "gouge and scallop colours"},
    {"W", "where most is gouged"},
    {"M, B", "next method, back end"},
    {"S", "save picture"},
    {"H, Tab", "this help, panel"},
    {"Q, Esc", "quit"},
};
const std::size_t key_count = sizeof key_list / sizeof *key_list;

static void flip(bool *b) {
    *b = !*b;
}

/* From the start again where it has ended. */
static void play(state *s) {
    s->playing = !s->playing;
    if (s->playing && s->path && s->at + 1 >= s->path->rows.size()) go_to(s, 0);
}

static std::string next_of(const std::vector<std::string> &names, const std::string &name) {
    std::size_t at = 0;
    while (at < names.size() && names[at] != name)
        at++;
    return names[at < names.size() ? (at + 1) % names.size() : 0];
}

static bool uses_backend(const std::string &method) {
    btg_method_info info;
    return btg_method_find(method.c_str(), &info) && info.uses_backend;
}

void choose_method(state *s, const std::string &name) {
    s->method = name;
    if (!uses_backend(name)) s->backend = "auto";
    s->recompute = true;
}

void choose_backend(state *s, const std::string &name) {
    s->backend = name;
    if (!uses_backend(s->method)) s->method = "vcrf";
    s->recompute = true;
}

std::vector<std::string> backend_names() {
    std::vector<std::string> names = {"auto"};
    btg_backend_info info;
    for (std::size_t i = 0; i < btg_backend_count(); i++)
        if (btg_backend_get_info(i, &info) == BTG_OK && info.state == BTG_BACKEND_READY)
            names.push_back(info.name);
    return names;
}

std::vector<std::string> method_names() {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < btg_method_count(); i++)
        names.push_back(btg_method_get_info(i).name);
    return names;
}

struct binding {
    const char *name;
    void (*act)(state *s);
};

static const binding bindings[] = {
    {"space", play},
    {"[", [](state *s) { s->speed = std::max(s->speed / 2, 1.0); }},
    {"]", [](state *s) { s->speed = std::min(s->speed * 2, 2000.0); }},
    {"left", [](state *s) { step(s, -1); }},
    {"right", [](state *s) { step(s, 1); }},
    {"shift+left", [](state *s) { step(s, -10); }},
    {"shift+right", [](state *s) { step(s, 10); }},
    {"up", [](state *s) { step_pass(s, 1); }},
    {"down", [](state *s) { step_pass(s, -1); }},
    {"home", [](state *s) { go_to(s, 0); }},
    {"end", [](state *s) { go_to(s, positions_max); }},
    {"plus", [](state *s) { camera_zoom(&s->eye, 1); }},
    {"minus", [](state *s) { camera_zoom(&s->eye, -1); }},
    {"f", look_at_tool},
    {"a", look_at_part},
    {"1", [](state *s) { look_from(s, "tilt"); }},
    {"2", [](state *s) { look_from(s, "iso"); }},
    {"3", [](state *s) { look_from(s, "top"); }},
    {"4", [](state *s) { look_from(s, "front"); }},
    {"5", [](state *s) { look_from(s, "right"); }},
    {"t", [](state *s) { s->tool = static_cast<tool_look>((static_cast<int>(s->tool) + 1) % 3); }},
    {"n", [](state *s) { flip(&s->normals); }},
    {"i", [](state *s) { flip(&s->insert); }},
    {"c", [](state *s) { flip(&s->ray); }},
    {"l", [](state *s) { flip(&s->lean); }},
    {"r", [](state *s) { flip(&s->trail); }},
    {"g", [](state *s) { flip(&s->gouge); }},
    {"w", seek_gouge},
    {"b", [](state *s) { choose_backend(s, next_of(backend_names(), s->backend)); }},
    {"m", [](state *s) { choose_method(s, next_of(method_names(), s->method)); }},
    {"s", [](state *s) { s->save_picture = true; }},
    {"h", [](state *s) { flip(&s->help); }},
    {"tab", [](state *s) { flip(&s->panel); }},
    {"wait", [](state *) {}},
    {"q", [](state *s) { s->quit = true; }},
    {"escape", [](state *s) { s->quit = true; }},
};

static const std::string drop_word = "drop:";

static bool is_drop(const std::string &key) {
    return key.compare(0, drop_word.size(), drop_word) == 0 && key.size() > drop_word.size();
}

bool key_known(const std::string &key) {
    if (is_drop(key)) return true;
    for (const binding &b : bindings)
        if (key == b.name) return true;
    return false;
}

bool press(state *s, const std::string &key) {
    if (is_drop(key)) {
        s->dropped = key.substr(drop_word.size());
        return true;
    }
    for (const binding &b : bindings)
        if (key == b.name) {
            b.act(s);
            return true;
        }
    return false;
}

} // namespace view
