#include "view/panel.h"
#include "view/pose.h"

extern "C" {
#include "app/app.h"
#include "io/map.h"
}

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <imgui.h>

namespace view {

static constexpr float panel_width = 330, margin = 10;
static constexpr double degrees = 180 / 3.14159265358979323846;

static ImVec4 tint(glm::vec3 c) {
    return {c.x, c.y, c.z, 1};
}

static ImU32 pixels_of(glm::vec3 c) {
    return ImGui::ColorConvertFloat4ToU32(tint(c));
}

/* ---- labels in the picture ---------------------------------------------------------------- */

struct place {
    ImVec2 at;
    bool seen;
};

static place place_of(const scene &s, glm::dvec2 size, glm::dvec3 point) {
    glm::dvec3 p = scene_project(s, size, point);
    return {{static_cast<float>(p.x), static_cast<float>(p.y)}, p.z >= 0 && p.z <= 1};
}

/* White on its colour, `away` from the mark it belongs to. */
static void label(place mark, ImVec2 away, glm::vec3 colour, const char *text) {
    if (!mark.seen) return;
    ImDrawList *list = ImGui::GetBackgroundDrawList();
    ImVec2 size = ImGui::CalcTextSize(text);
    float length = std::hypot(away.x, away.y), reach = 26 + 0.5f * size.x;
    if (!(length > 1e-3f)) away = {0, 1}, length = 1;
    ImVec2 middle = {mark.at.x + away.x / length * reach, mark.at.y + away.y / length * 26};
    ImVec2 low = {middle.x - size.x / 2 - 6, middle.y - size.y / 2 - 2};
    ImVec2 high = {middle.x + size.x / 2 + 6, middle.y + size.y / 2 + 2};
    list->AddLine(mark.at, middle, pixels_of(colour), 1.5f);
    list->AddRectFilled(low, high, pixels_of(colour), 5);
    list->AddText({middle.x - size.x / 2, middle.y - size.y / 2}, IM_COL32_WHITE, text);
}

static void label_contacts(const scene &s, glm::dvec2 size, const pose &at, bool osculating) {
    if (!at.has_p) return;
    place p = place_of(s, size, at.p);
    if (osculating) {
        label(p, {0, 1}, colour_osculating, "P = Q");
        return;
    }
    ImVec2 away = {0, 1};
    if (at.has_q) {
        place q = place_of(s, size, at.q);
        away = {p.at.x - q.at.x, p.at.y - q.at.y + 1};
        label(q, {-away.x, std::fabs(away.y) + 12}, colour_q, "Q");
    }
    label(p, {away.x, std::fabs(away.y) + 12}, colour_p, "P");
}

static void label_tilt(const scene &s, glm::dvec2 size, const pose &at, double reach) {
    if (!at.framed || !(at.tilt_rad > 1e-4)) return;
    char text[40];
    std::snprintf(text, sizeof text, "tilt %.2f\xc2\xb0", at.tilt_rad * degrees);
    glm::dvec3 top = at.tip + lean_arc * reach * at.axis;
    label(place_of(s, size, turned(top, at.tip, at.u, 0.5 * at.tilt_rad)), {0, -1}, colour_lean,
          text);
}

/* Where the path cuts deepest into the part; what counts as finished has no label. */
static void label_gouge(const scene &s, glm::dvec2 size, const field &left) {
    const btg_verify_result &r = left.result;
    btg_verify_def def = btg_verify_def_default();
    if (r.gouge.position == 0 || !(r.max_gouge_mm > def.gouge_mm)) return;
    char text[40];
    std::snprintf(text, sizeof text, "gouge %.3g mm", r.max_gouge_mm);
    glm::dvec3 at = {r.gouge.at.x, r.gouge.at.y, r.gouge.at.z};
    label(place_of(s, size, at), {-1, -1}, colour_gouge, text);
}

/* ---- the position's numbers --------------------------------------------------------------- */

static void line(const char *name, const char *format, ...) {
    char text[160];
    va_list values;
    va_start(values, format);
    std::vsnprintf(text, sizeof text, format, values);
    va_end(values);
    ImGui::TextDisabled("%s", name);
    ImGui::SameLine(104);
    ImGui::TextUnformatted(text);
}

static void vector_line(const char *name, glm::vec3 colour, glm::dvec3 v, int decimals) {
    char text[120];
    std::snprintf(text, sizeof text, "%.*f  %.*f  %.*f", decimals, v.x, decimals, v.y, decimals,
                  v.z);
    ImGui::TextColored(tint(colour), "%s", name);
    ImGui::SameLine(104);
    ImGui::TextUnformatted(text);
}

static void angle_line(const char *name, double radians) {
    if (std::isfinite(radians)) line(name, "%.3f\xc2\xb0", radians * degrees);
}

static const char *status_of(const btg_row &row, const pose &at) {
    if (row.lift) return "lift (a retract)";
    if (at.placed && !at.has_p) return "off the part";
    return btg_status_name(row.position.status);
}

static void numbers(const state &st, const btg_row &row, const pose &at) {
    const btg_position &r = row.position;
    line("status", "%s", status_of(row, at));
    line("pass, point", "%u, %u", row.pass, row.point);
    line("dropped over", "%.3f  %.3f mm", r.foot_x_mm, r.foot_y_mm);
    if (!at.placed) return;
    angle_line("tilt", r.tilt_rad);
    angle_line("inclination", r.inclination_rad);
    angle_line("spin", r.spin_rad);
    if (at.has_p) vector_line("P", colour_p, at.p, 3);
    if (at.has_q) vector_line("Q", colour_q, at.q, 3);
    if (at.has_q) line("P to Q", "%.3f mm", glm::distance(at.p, at.q));
    vector_line("tip", colour_line, at.tip, 3);
    vector_line("axis", colour_line, at.axis, 5);
    if (std::isfinite(r.bound_mm))
        line("gouge here", "at most %.2g mm, proven", std::max(r.bound_mm, 0.0));
    (void)st;
}

/* ---- switches ----------------------------------------------------------------------------- */

static void play_bar(state *st) {
    int count = static_cast<int>(st->path->rows.size()), at = static_cast<int>(st->at) + 1;
    if (ImGui::Button(st->playing ? "Stop" : "Play", {58, 0})) press(st, "space");
    ImGui::SameLine();
    if (ImGui::Button("<")) press(st, "left");
    ImGui::SameLine();
    if (ImGui::Button(">")) press(st, "right");
    ImGui::SameLine();
    ImGui::SetNextItemWidth(-1);
    char format[40];
    std::snprintf(format, sizeof format, "%%d of %d", count);
    if (ImGui::SliderInt("##position", &at, 1, count, format))
        go_to(st, static_cast<std::size_t>(at - 1));
}

static void ramp(const btg_map_scale &scale, double from, double to, const char *text) {
    ImDrawList *list = ImGui::GetWindowDrawList();
    ImVec2 at = ImGui::GetCursorScreenPos();
    for (int i = 0; i < 12; i++) {
        float rgb[3], x = at.x + 7 * static_cast<float>(i);
        double decade = std::pow(10, i / 4.0);
        btg_map_colour(&scale, from * decade + to, rgb);
        list->AddRectFilled({x, at.y + 3}, {x + 7, at.y + 15}, pixels_of({rgb[0], rgb[1], rgb[2]}));
    }
    ImGui::Dummy({88, 16});
    ImGui::SameLine();
    ImGui::TextUnformatted(text);
}

static void gouge_legend(state *st) {
    btg_verify_def def = btg_verify_def_default();
    btg_map_scale scale = {def.gouge_mm, def.scallop_mm};
    if (!st->left) {
        ImGui::TextDisabled("cutting the path into a stock ...");
        return;
    }
    ramp(scale, -1.01 * def.gouge_mm, 0, "gouged 0.01 to 10 mm");
    ramp(scale, 0, 0, "finished, within 0.01 mm");
    ramp(scale, 1.01 * def.scallop_mm, 0, "left 0.01 to 10 mm");
    line("most gouged", "%.4f mm", st->left->result.max_gouge_mm);
    if (st->left->result.gouge.position > 0) {
        ImGui::SameLine(200);
        if (ImGui::SmallButton("go there (W)")) press(st, "w");
    }
    line("most left", "%.4f mm", st->left->result.max_scallop_mm);
    line("cells", "of %.3g mm", st->left->cell_mm);
}

static void toggle(state *st, const char *text, bool on, const char *key) {
    bool value = on;
    if (ImGui::Checkbox(text, &value)) press(st, key);
}

static void switches(state *st) {
    static const char *const looks[] = {"Tool: solid (T)", "Tool: clear (T)", "Tool: hidden (T)"};
    if (ImGui::Button(looks[static_cast<int>(st->tool)], {-1, 0})) press(st, "t");
    toggle(st, "Normals (N)", st->normals, "n");
    ImGui::SameLine(170);
    toggle(st, "Tilt (L)", st->lean, "l");
    toggle(st, "Pseudo-insert (I)", st->insert, "i");
    ImGui::SameLine(170);
    toggle(st, "Trail (R)", st->trail, "r");
    toggle(st, "Circular ray to Q (C)", st->ray, "c");
    toggle(st, "Gouge and scallop (G)", st->gouge, "g");
    if (st->gouge) gouge_legend(st);
}

static void chooser(state *st, const char *text, const std::vector<std::string> &names,
                    const std::string &name, void (*choose)(state *st, const std::string &name)) {
    ImGui::TextDisabled("%s", text);
    ImGui::SameLine(104);
    ImGui::SetNextItemWidth(-1);
    ImGui::PushID(text);
    if (ImGui::BeginCombo("##names", name.c_str())) {
        for (const std::string &other : names)
            if (ImGui::Selectable(other.c_str(), other == name) && other != name) choose(st, other);
        ImGui::EndCombo();
    }
    ImGui::PopID();
}

/* Choosing another solves the path again, even one that came from a file. */
static void solver(state *st) {
    static const std::vector<std::string> methods = method_names(), backends = backend_names();
    chooser(st, "method (M)", methods, st->method, choose_method);
    chooser(st, "back end (B)", backends, st->backend, choose_backend);
    if (st->working.empty()) return;
    ImGui::ProgressBar(static_cast<float>(st->worked), {-1, 0}, st->working.c_str());
}

static void heading(const char *text) {
    ImGui::Spacing();
    ImGui::TextUnformatted(text);
    ImGui::Separator();
}

static void source(const state &st) {
    const btg_tool_def &d = st.part->tool.def;
    line("part", "%s", app_file_name(st.part->file.c_str()));
    line("tool", "%s %g / %g mm", d.profile == BTG_PROFILE_BULLNOSE ? "bullnose" : "toroidal",
         d.major_radius_mm, d.minor_radius_mm);
    if (!st.path->file.empty()) {
        line("path", "%s", app_file_name(st.path->file.c_str()));
        return;
    }
    line("solved", "%zu in %.3g s by %s", st.path->rows.size(), st.path->seconds,
         st.path->backend.c_str());
}

static float side_width(int width) {
    return std::min(panel_width, 0.45f * static_cast<float>(width));
}

double panel_aside(const state &st, int width, int height) {
    if (!st.panel || !current(st)) return 0;
    double middle = 0.5 * width, room = width - side_width(width) - 2 * margin;
    double contacts = 0.5 * std::min(width, height) / surroundings;
    return std::clamp(middle + contacts - room, 0.0, middle - 0.5 * room) / width;
}

static void side_panel(state *st, const pose &at, int width, int height) {
    float wide = side_width(width);
    ImGui::SetNextWindowPos({static_cast<float>(width) - wide - margin, margin});
    ImGui::SetNextWindowSizeConstraints({wide, 0}, {wide, static_cast<float>(height) - 2 * margin});
    ImGui::Begin("side", nullptr,
                 ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize |
                     ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove);
    play_bar(st);
    heading("Position");
    if (const btg_row *row = current(*st)) numbers(*st, *row, at);
    heading("Show");
    switches(st);
    heading("From");
    source(*st);
    solver(st);
    ImGui::End();
}

/* Beside the panel, with the tool to be seen between them, or in the panel's place. */
static bool help_fits(const state &st, int width) {
    constexpr float help_width = 350, between = 250;
    return !st.panel || static_cast<float>(width) >= panel_width + help_width + between;
}

static void help_line(const char *keys, const char *meaning, float column) {
    ImGui::TextUnformatted(keys);
    ImGui::SameLine(column);
    ImGui::TextDisabled("%s", meaning);
}

static void help_panel(const state &st, int width, int height) {
    ImGui::SetNextWindowPos({margin, static_cast<float>(height) - margin}, ImGuiCond_Always,
                            {0, 1});
    ImGui::Begin("keys", nullptr,
                 ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_AlwaysAutoResize |
                     ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoInputs);
    if (help_fits(st, width)) {
        for (std::size_t i = 0; i < key_count; i++)
            help_line(key_list[i].keys, key_list[i].meaning, 150);
    } else {
        help_line("Tab", "all keys, in the panel's place", 40);
    }
    ImGui::End();
}

static void note_panel(const state &st, int width) {
    ImGui::SetNextWindowPos({margin, margin});
    ImGui::Begin("note", nullptr,
                 ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_AlwaysAutoResize |
                     ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoInputs);
    ImGui::PushTextWrapPos(0.45f * static_cast<float>(width));
    ImGui::TextUnformatted(st.note.c_str());
    ImGui::PopTextWrapPos();
    ImGui::End();
}

void panel_say(state *st, const scene &s, int width, int height) {
    const btg_row *row = current(*st);
    glm::dvec2 size(width, height);
    pose at = row ? pose_of(st->part->tool, row->position) : pose();
    if (row && at.placed) {
        const btg_tool_def &d = st->part->tool.def;
        if (st->lean) label_tilt(s, size, at, d.major_radius_mm + d.minor_radius_mm);
        label_contacts(s, size, at, row->position.status == BTG_OSCULATING);
    }
    if (st->gouge && st->left) label_gouge(s, size, *st->left);
    if (st->panel && row) side_panel(st, at, width, height);
    if (st->help) help_panel(*st, width, height);
    if (!st->note.empty()) note_panel(*st, width);
}

} // namespace view
