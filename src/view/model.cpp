#include "view/model.h"
#include "view/pose.h"

extern "C" {
#include "app/app.h"
#include "app/feet.h"
#include "app/solve.h"
#include "io/machine.h"
#include "io/map.h"
#include "io/track.h"
}

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace view {

/* Positions between two looks at `stop`: few at first, then as many as take about this long. */
static constexpr std::size_t chunk_min = 16, chunk_max = 4096;
static constexpr double chunk_s = 0.05;
/* What a path read back may stand off the part, and still touch it. */
static constexpr double touch_mm = 0.01;
/* Nodes a search for a contact visits at most: where it is not found soon there is none to see. */
static constexpr std::uint32_t touch_nodes = 5000;
/* Cells along the longer side of the field: as fine as a screen shows. */
static constexpr double field_cells = 900;

btg_status say(btg_message *message, btg_status status, const std::string &text) {
    std::snprintf(message->text, sizeof message->text, "%s", text.c_str());
    return status;
}

std::shared_ptr<subject> load_subject(const path_options &options, const char *file,
                                      btg_status *status, btg_message *message) {
    auto s = std::make_shared<subject>();
    s->file = file;
    *status = btg_tool_init(&options.tool, &s->tool, message);
    if (*status == BTG_OK) *status = btg_gltf_load(file, &options.gltf, &s->part, message);
    if (*status != BTG_OK) return nullptr;
    btg_part_get_info(s->part, &s->info);
    return s;
}

/* ---- a path of a file --------------------------------------------------------------------- */

static btg_status too_long(btg_message *message, const char *file) {
    return say(message, BTG_ERROR_ARGUMENT,
               std::string(file) + ": more than " + std::to_string(positions_max) +
                   " positions; view a part of the path, or take longer steps");
}

static btg_status read_rows(btg_track *track, const subject &s, const path_options &options,
                            work *w, tour *t, btg_message *message) {
    std::vector<char> workspace(btg_workspace_size(s.part));
    btg_solver_def solver = options.solver;
    solver.node_budget = std::min(solver.node_budget, touch_nodes);
    for (bool ended = false; !w->stop;) {
        btg_verify_pose pose;
        btg_status status = btg_track_next(track, &pose, &ended, message);
        if (status < 0 || ended) return status;
        if (t->rows.size() == positions_max) return too_long(message, track->path);
        btg_row row = {};
        row.pass = pose.pass, row.point = pose.point;
        row.position = position_at(s.part, s.tool, solver, to_glm(pose.tip), to_glm(pose.axis),
                                   touch_mm, workspace.data(), workspace.size());
        t->rows.push_back(row);
        w->done++;
    }
    return BTG_OK;
}

/* Opens a path, for the machine that the options name if it is a program. */
struct open_track {
    btg_machine machine = {};
    btg_track track = {};
    bool opened = false;

    btg_status open(const path_options &options, const char *file, btg_message *message) {
        btg_track_def def = {};
        def.rows = true;
        if (options.machine) {
            btg_status status =
                btg_machine_load(options.machine, options.tool_length_mm, &machine, message);
            if (status != BTG_OK) return status;
            def.machine = &machine;
            def.error_mm = touch_mm / 2;
            def.reach_mm = options.tool.major_radius_mm + 2 * options.tool.minor_radius_mm;
        }
        btg_status status = btg_track_open(&track, &def, file, message);
        opened = status == BTG_OK;
        return status;
    }
    ~open_track() {
        if (opened) btg_track_close(&track);
    }
};

btg_status take_cutter(path_options *options, const char *file, btg_message *message) {
    auto t = std::make_unique<open_track>();
    btg_status status = t->open(*options, file, message);
    if (status != BTG_OK || !t->track.cutter) return status;
    options->tool.major_radius_mm = t->track.major_radius_mm;
    options->tool.minor_radius_mm = t->track.minor_radius_mm;
    /* APT does not tell a hollow cutter from a solid one. */
    if (options->tool.minor_radius_mm == 0) options->tool.profile = BTG_PROFILE_BULLNOSE;
    return status;
}

std::shared_ptr<tour> load_tour(const subject &s, const path_options &options, const char *file,
                                work *w, btg_status *status, btg_message *message) {
    auto t = std::make_shared<tour>();
    auto track = std::make_unique<open_track>();
    t->file = file;
    *status = track->open(options, file, message);
    if (*status == BTG_OK) *status = read_rows(&track->track, s, options, w, t.get(), message);
    return *status == BTG_OK ? t : nullptr;
}

/* ---- a path of our own -------------------------------------------------------------------- */

static btg_status collect_feet(const subject &s, const path_options &options, tour *t,
                               std::vector<double> *xy, btg_message *message) {
    feet f = {};
    btg_status status = feet_open(&f, &options, s.part, message);
    if (status != BTG_OK) return status;
    if (f.total > positions_max) status = too_long(message, s.file.c_str());
    for (std::size_t i = 0; i < f.total && status == BTG_OK; i++) {
        btg_footprint_point point = feet_at(&f, i);
        if (point.lift) continue;
        btg_row row = {};
        row.pass = point.pass, row.point = point.point;
        t->rows.push_back(row);
        xy->insert(xy->end(), {point.x_mm, point.y_mm});
    }
    feet_close(&f);
    return status;
}

static btg_status solve_rows(btg_backend *backend, const std::vector<double> &xy, work *w, tour *t,
                             btg_message *message) {
    std::vector<btg_position> positions(chunk_max);
    std::size_t chunk = chunk_min;
    w->all = t->rows.size();
    for (std::size_t next = 0; next < t->rows.size() && !w->stop;) {
        std::size_t n = std::min(chunk, t->rows.size() - next);
        double begin = app_seconds();
        btg_status status =
            btg_backend_positions(backend, &xy[2 * next], n, positions.data(), nullptr);
        double seconds = app_seconds() - begin;
        t->seconds += seconds;
        if (status < 0)
            return say(message, status,
                       std::string("back end ") + btg_backend_name(backend) + ": failed (" +
                           btg_status_name(status) + "); try another --backend");
        for (std::size_t i = 0; i < n; i++)
            t->rows[next + i].position = positions[i];
        w->done = next += n;
        if (seconds < chunk_s / 2 && chunk < chunk_max) chunk *= 2;
    }
    return BTG_OK;
}

std::shared_ptr<tour> solve_tour(const subject &s, const path_options &options, work *w,
                                 btg_status *status, btg_message *message) {
    auto t = std::make_shared<tour>();
    std::vector<double> xy;
    *status = collect_feet(s, options, t.get(), &xy, message);
    if (*status != BTG_OK) return nullptr;
    btg_method *method = nullptr;
    *status = solve_open(&options, s.part, &s.tool, &method, message);
    if (*status != BTG_OK) return nullptr;
    t->method = options.method, t->backend_asked = options.backend;
    t->backend = btg_method_backend_name(method);
    *status = solve_rows(btg_method_front(method), xy, w, t.get(), message);
    btg_method_close(method);
    return *status == BTG_OK && !w->stop ? t : nullptr;
}

/* ---- what it leaves ----------------------------------------------------------------------- */

static bool stands(const btg_row &row) {
    const btg_position &at = row.position;
    return !row.lift && at.status >= 0 && at.status != BTG_NO_CONTACT && at.axis.z > 1e-3;
}

static btg_status add_rows(btg_verify *verify, const tour &t, work *w) {
    bool linked = false;
    w->all = t.rows.size();
    for (std::size_t i = 0; i < t.rows.size() && !w->stop; i++) {
        const btg_row &row = t.rows[i];
        w->done = i;
        if (!stands(row)) {
            linked = false;
            continue;
        }
        btg_verify_pose pose = {};
        pose.tip = row.position.tip, pose.axis = row.position.axis;
        pose.link = linked && row.pass == t.rows[i - 1].pass;
        pose.pass = row.pass, pose.point = row.point, pose.line = i + 1;
        linked = true;
        btg_status status = btg_verify_add(verify, &pose);
        if (status < 0) return status;
    }
    return BTG_OK;
}

static void colour_cells(const btg_verify_map &map, const btg_verify_def &def, field *f) {
    btg_map_scale scale = {def.gouge_mm, def.scallop_mm};
    std::size_t cells = static_cast<std::size_t>(map.width) * map.height;
    f->width = static_cast<int>(map.width), f->height = static_cast<int>(map.height);
    f->x_mm = map.x_mm, f->y_mm = map.y_mm, f->cell_mm = map.cell_mm;
    f->rgba.assign(4 * cells, 0);
    for (std::size_t i = 0; i < cells; i++) {
        double deviation = btg_verify_deviation(&map, i);
        if (std::isnan(deviation)) continue;
        float rgb[3];
        btg_map_colour(&scale, deviation, rgb);
        for (std::size_t k = 0; k < 3; k++)
            f->rgba[4 * i + k] = static_cast<unsigned char>(std::lround(255 * rgb[k]));
        f->rgba[4 * i + 3] = 255;
    }
}

std::shared_ptr<field> cut_field(const subject &s, const tour &t, const path_options &options,
                                 work *w, btg_status *status, btg_message *message) {
    auto f = std::make_shared<field>();
    btg_verify_def def = btg_verify_def_default();
    double longer =
        std::max(s.info.box_max.x - s.info.box_min.x, s.info.box_max.y - s.info.box_min.y);
    def.cell_mm = std::clamp(longer / field_cells, 1e-4, 1e5);
    def.threads = options.threads;
    def.prove = 0;
    btg_verify *verify = nullptr;
    *status = btg_verify_create(&def, s.part, &s.tool, &verify, message);
    if (*status != BTG_OK) return nullptr;
    *status = add_rows(verify, t, w);
    if (*status == BTG_OK) *status = btg_verify_end(verify, &f->result);
    if (*status >= 0 && !w->stop) colour_cells(btg_verify_get_map(verify), def, f.get());
    btg_verify_destroy(verify);
    if (*status < 0)
        say(message, *status,
            s.file + ": the path cannot be cut into a stock (" + btg_status_name(*status) + ")");
    return *status >= 0 && !w->stop ? f : nullptr;
}

} // namespace view
