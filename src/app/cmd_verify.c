/* `bitangent verify`: reads a path back, has it cut into a stock, and says what is left. */
#include "app/app.h"
#include "app/progress.h"
#include "app/terminal.h"
#include "app/verify.h"
#include "core/part.h"
#include "io/machine.h"
#include "io/map.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* Positions between two looks at the clock. */
#define LOOK_EVERY 16
/* Share of --sweep-error by which a program's poses may tell the machine's motion wrong. */
#define POSE_SHARE 0.25

typedef struct run {
    verify_options options;
    verify_report report;
    btg_part *part;
    btg_tool tool;
    btg_machine machine;
    btg_track track;
    btg_verify *verify;
    btg_output outputs[BTG_OUTPUT_MAX];
    bool standard;
    btg_message message;
} run;

static bool same_file(const char *a, const char *b) {
    struct stat x, y;
    return stat(a, &x) == 0 && stat(b, &y) == 0 && S_ISREG(x.st_mode) && x.st_dev == y.st_dev &&
           x.st_ino == y.st_ino;
}

static int refuse(const run *r, btg_status status) {
    /* Every error here is an input's, but want of memory and a program its machine cannot run. */
    bool failed = status == BTG_ERROR_MEMORY || status == BTG_ERROR_UNSUPPORTED;
    return app_complain(failed ? APP_FAILED : APP_UNUSABLE, "%s", r->message.text);
}

static int open_outputs(run *r) {
    const verify_options *o = &r->options;
    for (int i = 0; i < o->output_count; i++) {
        const char *path = o->outputs[i].path;
        if (same_file(o->path.part, path) || same_file(o->track, path))
            return app_complain(APP_UNUSABLE, "-o: '%.200s' is read from; write elsewhere", path);
        if (btg_output_open(&r->outputs[i], path, &r->message) != BTG_OK)
            return app_complain(APP_FAILED, "%s", r->message.text);
        if (r->outputs[i].standard) r->standard = true;
        if (r->standard && o->path.json)
            return app_complain(APP_UNUSABLE,
                                "--json: the standard output takes the map already; drop one");
    }
    return APP_DONE;
}

/* The tool of the command line, or that of the path. */
static btg_status find_tool(run *r) {
    btg_tool_def *def = &r->options.path.tool;
    if (r->track.cutter && !r->options.tool_given) {
        def->major_radius_mm = r->track.major_radius_mm;
        def->minor_radius_mm = r->track.minor_radius_mm;
        /* APT does not tell a hollow cutter from a solid one. */
        if (def->minor_radius_mm == 0) def->profile = BTG_PROFILE_BULLNOSE;
    }
    return btg_tool_init(def, &r->tool, &r->message);
}

static btg_status open_track(run *r) {
    verify_options *o = &r->options;
    btg_track_def def = o->track_def;
    const btg_tool_def *tool = &o->path.tool;
    if (o->path.machine) {
        btg_status status =
            btg_machine_load(o->path.machine, o->path.tool_length_mm, &r->machine, &r->message);
        if (status != BTG_OK) return status;
        def.machine = &r->machine;
        def.error_mm = POSE_SHARE * o->def.sweep_error_mm;
        /* The rim's farthest point from the tip. */
        def.reach_mm = tool->major_radius_mm + 2 * tool->minor_radius_mm;
    }
    btg_status status = btg_track_open(&r->track, &def, o->track, &r->message);
    if (r->track.kind == BTG_TRACK_PROGRAM) o->def.pose_error_mm = def.error_mm;
    return status;
}

static int set_up(run *r) {
    const verify_options *o = &r->options;
    btg_status status = open_track(r);
    if (status == BTG_OK) status = find_tool(r);
    if (status == BTG_OK)
        status = btg_gltf_load(o->path.part, &o->path.gltf, &r->part, &r->message);
    if (status != BTG_OK) return refuse(r, status);
    int code = open_outputs(r);
    if (code != APP_DONE) return code;
    double begin = app_seconds();
    status = btg_verify_create(&o->def, r->part, &r->tool, &r->verify, &r->message);
    r->report.seconds += app_seconds() - begin;
    return status == BTG_OK ? APP_DONE : refuse(r, status);
}

static int cut(run *r) {
    struct stat file;
    double begin = app_seconds();
    bool ended = false;
    size_t total = fstat(fileno(r->track.file), &file) == 0 ? (size_t)file.st_size : 0;
    progress bar = progress_begin(total, r->options.path.quiet || total == 0);
    btg_status status = BTG_OK;
    for (size_t i = 1; status == BTG_OK; i++) {
        btg_verify_pose pose;
        status = btg_track_next(&r->track, &pose, &ended, &r->message);
        if (status < 0 || ended) break;
        status = btg_verify_add(r->verify, &pose);
        if (status < 0)
            btg_fail(&r->message, status, "%.256s:%llu: the pose is unusable; give a tool path",
                     r->options.track, (unsigned long long)pose.line);
        if (i % LOOK_EVERY == 0) progress_show(&bar, (size_t)ftell(r->track.file), i);
    }
    progress_end(&bar);
    if (status < 0) return refuse(r, status);
    btg_part_info part;
    btg_part_get_info(r->part, &part);
    btg_track_end(&r->track, part.box_min, part.box_max);
    btg_verify_end(r->verify, &r->report.result);
    r->report.seconds += app_seconds() - begin;
    return APP_DONE;
}

static btg_status write_map(run *r, int i) {
    btg_verify_map map = btg_verify_get_map(r->verify);
    const verify_options *o = &r->options;
    btg_map_scale scale = {.gouge_mm = o->def.gouge_mm, .scallop_mm = o->def.scallop_mm};
    const char *title = app_file_name(o->path.part);
    switch (o->outputs[i].kind) {
    case VERIFY_CSV:
        return btg_map_csv(&map, &r->outputs[i], &r->message);
    case VERIFY_PNG:
        return btg_map_png(&map, &r->report.result, &scale, title, &r->outputs[i], &r->message);
    default:
        return btg_map_glb(&map, &scale, title, &r->outputs[i], &r->message);
    }
}

static int finish(run *r) {
    const verify_options *o = &r->options;
    btg_status status = BTG_OK;
    for (int i = 0; i < o->output_count && status == BTG_OK; i++)
        status = write_map(r, i);
    for (int i = 0; i < o->output_count && status == BTG_OK; i++)
        status = btg_output_finish(&r->outputs[i], &r->message);
    for (int i = 0; i < o->output_count && status == BTG_OK; i++)
        status = btg_output_commit(&r->outputs[i], &r->message);
    if (status != BTG_OK) return app_complain(APP_FAILED, "%s", r->message.text);
    verify_report *v = &r->report;
    v->options = o;
    v->tool = &r->tool;
    v->threads = btg_verify_threads(r->verify);
    v->track = &r->track;
    v->ok = verify_ok(v);
    btg_output out = btg_output_borrow(r->standard ? stderr : stdout);
    if (o->path.json) {
        verify_json(v, &out);
    } else if (!o->path.quiet) {
        terminal table;
        terminal_open(&table, out.file);
        verify_print(v, table.file);
        terminal_close(&table);
    }
    if (btg_output_finish(&out, &r->message) != BTG_OK)
        return app_complain(APP_FAILED, "%s", r->message.text);
    return v->ok ? APP_DONE : APP_FAILED;
}

int app_verify(int count, char **words) {
    run *r = calloc(1, sizeof *r);
    if (!r) return app_complain(APP_FAILED, "out of memory");
    int code = APP_UNUSABLE;
    if (verify_options_parse(count, words, &r->options)) {
        if (r->options.path.help) {
            code = app_help("verify");
        } else {
            code = set_up(r);
            if (code == APP_DONE) code = cut(r);
            if (code == APP_DONE) code = finish(r);
        }
    }
    for (int i = 0; i < BTG_OUTPUT_MAX; i++)
        btg_output_discard(&r->outputs[i]);
    btg_track_close(&r->track);
    btg_verify_destroy(r->verify);
    btg_part_destroy(r->part);
    free(r);
    return code;
}
