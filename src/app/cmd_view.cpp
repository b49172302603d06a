/* `bitangent view`: a window on a part and a path over it, or one picture of them. */
#include "view/window.h"
#include "view/worker.h"

extern "C" {
#include "app/app.h"
#include "app/view_options.h"
#include "io/json.h"
}

#include <memory>

namespace {

/* The path that the options ask for. */
int solve(const path_options &options, view::state *s) {
    view::worker worker;
    s->recompute = true;
    if (worker_finish(&worker, s, options)) return APP_DONE;
    return app_complain(app_code(worker.status), "%s", s->note.c_str());
}

int load(const view_options &o, view::state *s) {
    btg_status status = BTG_OK;
    btg_message message = {};
    view::work work;
    path_options path = o.path;
    s->method = o.path.method, s->backend = o.path.backend;
    if (o.track && !o.tool_given) status = view::take_cutter(&path, o.track, &message);
    if (status == BTG_OK) s->part = view::load_subject(path, path.part, &status, &message);
    if (s->part && o.track)
        set_path(s, view::load_tour(*s->part, path, o.track, &work, &status, &message));
    if (status < 0) return app_complain(app_code(status), "%s", message.text);
    int code = o.track ? APP_DONE : solve(path, s);
    if (code != APP_DONE) return code;
    if (!s->path || s->path->rows.empty())
        return app_complain(APP_FAILED, "%.256s: the path has no position", o.path.part);
    if (o.position > s->path->rows.size())
        return app_complain(APP_UNUSABLE, "--position: the path has %zu positions, no %lu",
                            s->path->rows.size(), static_cast<unsigned long>(o.position));
    if (o.position > 0)
        go_to(s, o.position - 1);
    else
        go_to_best(s);
    return APP_DONE;
}

int check_words(const view_options &o) {
    view::state nowhere;
    if (o.view_from && !view::view_name_known(o.view_from))
        return app_complain(
            APP_UNUSABLE,
            "--view-from: unknown '%.100s'; give tilt, iso, top, front, back, left, "
            "right, or AZIMUTH,ELEVATION in degrees",
            o.view_from);
    for (int i = 0; i < o.key_count; i++)
        if (!view::key_known(o.keys[i]))
            return app_complain(APP_UNUSABLE, "--keys: unknown key '%s'; see 'bitangent help view'",
                                o.keys[i]);
    return APP_DONE;
}

void numbers(btg_json *json, const char *name, glm::dvec3 value, int count) {
    btg_json_open(json, name, '[');
    for (int i = 0; i < count; i++)
        btg_json_number(json, nullptr, value[i]);
    btg_json_close(json, ']');
}

/* [] when it is not in the picture. */
void pixel(btg_json *json, const char *name, glm::dvec3 at) {
    numbers(json, name, at, at.z >= 0 && at.z <= 1 ? 2 : 0);
}

void angle(btg_json *json, const char *name, double radians) {
    btg_json_number(json, name, radians * 180 / 3.14159265358979323846);
}

int report(const view_options &o, const view::state &s, const view::frame_facts &facts) {
    if (!o.path.json) return APP_DONE;
    btg_message message;
    btg_output out = btg_output_borrow(stdout);
    btg_json json = btg_json_to(&out);
    btg_json_open(&json, nullptr, '{');
    btg_json_count(&json, "positions", s.path->rows.size());
    btg_json_count(&json, "position", s.at + 1);
    btg_json_count(&json, "frames", facts.frames);
    btg_json_string(&json, "method", s.method.c_str());
    btg_json_string(&json, "backend", s.path->backend.c_str());
    if (const btg_row *row = current(s)) {
        angle(&json, "tilt_deg", row->position.tilt_rad);
        angle(&json, "inclination_deg", row->position.inclination_rad);
    }
    pixel(&json, "p_pixel", facts.p_pixel);
    pixel(&json, "q_pixel", facts.q_pixel);
    btg_json_open(&json, "camera", '{');
    numbers(&json, "eye_mm", camera_eye(s.eye), 3);
    numbers(&json, "target_mm", s.eye.target, 3);
    btg_json_number(&json, "height_deg", view::camera_fov_deg);
    numbers(&json, "target_px", facts.target_pixel, 2);
    btg_json_close(&json, '}');
    btg_json_close(&json, '}');
    btg_output_text(&out, "\n");
    if (btg_output_finish(&out, &message) == BTG_OK) return APP_DONE;
    return app_complain(APP_FAILED, "%s", message.text);
}

int screenshot(const view_options &o, view::state *s) {
    view::picture picture;
    view::frame_facts facts;
    btg_message message;
    view::worker worker;
    for (int i = 0; i < o.key_count; i++) {
        press(s, o.keys[i]);
        if (!s->dropped.empty()) open_dropped(s, o.path);
        if (!s->note.empty()) return app_complain(APP_UNUSABLE, "%s", s->note.c_str());
    }
    if (!worker_finish(&worker, s, o.path)) return app_complain(APP_FAILED, "%s", s->note.c_str());
    btg_status status = render_picture(s, o.width, o.height, &picture, &facts, &message);
    if (status == BTG_OK) status = save_picture(picture, o.screenshot, &message);
    if (status != BTG_OK) return app_complain(APP_FAILED, "%s", message.text);
    return report(o, *s, facts);
}

int window(const view_options &o, view::state *s) {
    view::window_def def = {o.width, o.height, &o.path, {}};
    view::frame_facts facts;
    btg_message message;
    for (int i = 0; i < o.key_count; i++)
        def.keys.push_back(o.keys[i]);
    if (show_window(s, def, &facts, &message) != BTG_OK)
        return app_complain(APP_FAILED, "%s", message.text);
    return report(o, *s, facts);
}

int run(const view_options &o) {
    view::state s;
    int code = check_words(o);
    if (code == APP_DONE) code = load(o, &s);
    if (code != APP_DONE) return code;
    s.aspect = double(o.width) / o.height;
    look_from(&s, o.view_from ? o.view_from : "tilt");
    if (o.look_at_part)
        look_at_part(&s);
    else
        look_at_tool(&s);
    if (o.screenshot) return screenshot(o, &s);
    return window(o, &s);
}

} // namespace

int app_view(int count, char **words) {
    auto options = std::make_unique<view_options>();
    if (!view_options_parse(count, words, options.get())) return APP_UNUSABLE;
    if (options->path.help) return app_help("view");
    try {
        return run(*options);
    } catch (const std::bad_alloc &) {
        return app_complain(APP_FAILED, "view: out of memory");
    }
}
