#include "app/app.h"
#include "app/feet.h"
#include "app/progress.h"
#include "app/rows.h"
#include "app/solve.h"
#include "app/terminal.h"
#include "core/vec.h"
#include "io/machine.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* Entries solved between two looks at the clock: few at first, then as many as take about a tenth
 * of a second, so that progress is seen whatever the back end's speed. */
#define CHUNK_MIN    64
#define CHUNK_MAX    4096
#define CHUNK_TIME_S 0.1

typedef struct run {
    path_options options;
    btg_part *part;
    btg_tool tool;
    feet feet;
    btg_method *method;
    btg_backend *front; /* of the method: composes positions */
    sinks sinks;
    summary summary;
    double clear_z_mm;
    rows rows;
    btg_message message;
    /* One chunk. */
    btg_footprint_point points[CHUNK_MAX];
    double xy[2 * CHUNK_MAX];
    btg_position positions[CHUNK_MAX];
} run;

/* ---- set-up ------------------------------------------------------------------------------- */

static bool same_file(const char *a, const char *b) {
    struct stat x, y;
    return a && stat(a, &x) == 0 && stat(b, &y) == 0 && S_ISREG(x.st_mode) &&
           x.st_dev == y.st_dev && x.st_ino == y.st_ino;
}

static int check_outputs(const path_options *o) {
    for (int i = 0; i < o->output_count; i++) {
        const char *path = o->outputs[i].path;
        if (!same_file(o->part, path) && !same_file(o->points, path)) continue;
        return app_complain(APP_UNUSABLE, "-o: '%.200s' is read from; write elsewhere", path);
    }
    return APP_DONE;
}

/* The tilt's limit from the machine's. */
static int limit_tilt(run *r) {
    path_options *o = &r->options;
    btg_machine machine;
    if (!o->machine_tilt) return APP_DONE;
    btg_status status = btg_machine_load(o->machine, o->tool_length_mm, &machine, &r->message);
    if (status != BTG_OK) return app_complain(APP_UNUSABLE, "%s", r->message.text);
    double most = btg_machine_max_tilt(&machine, o->solver.max_tilt_rad);
    if (most == 0) {
        return app_complain(APP_UNUSABLE,
                            "--max-tilt: the limits of machine '%.100s' leave leaning axes out of "
                            "reach some way, however little they lean; give degrees",
                            o->machine);
    }
    o->solver.max_tilt_rad = most;
    o->max_tilt_deg = most * (180 / BTG_PI);
    return APP_DONE;
}

static int set_up(run *r) {
    const path_options *o = &r->options;
    int code = check_outputs(o);
    if (code == APP_DONE) code = limit_tilt(r);
    if (code != APP_DONE) return code;
    btg_status status = btg_tool_init(&o->tool, &r->tool, &r->message);
    if (status == BTG_OK) status = btg_gltf_load(o->part, &o->gltf, &r->part, &r->message);
    if (status != BTG_OK) return app_complain(app_code(status), "%s", r->message.text);
    btg_part_get_info(r->part, &r->summary.part);
    r->clear_z_mm = r->summary.part.box_max.z + o->lift_mm;
    status = solve_open(o, r->part, &r->tool, &r->method, &r->message);
    if (status != BTG_OK) return app_complain(app_code(status), "%s", r->message.text);
    r->front = btg_method_front(r->method);
    status = feet_side_step(&r->options, r->part, &r->tool, r->front, &r->message);
    if (status == BTG_OK) status = feet_open(&r->feet, o, r->part, &r->message);
    if (status != BTG_OK) return app_complain(app_code(status), "%s", r->message.text);
    status = sinks_open(&r->sinks, o, r->part, &r->tool, r->clear_z_mm, &r->message);
    if (status == BTG_OK) {
        r->rows = (rows){&r->feet, &r->tool, &r->sinks, &r->summary, .clear_z_mm = r->clear_z_mm};
        status = rows_open(&r->rows, o, r->front, &r->message);
    }
    if (status == BTG_OK) return APP_DONE;
    return app_complain(status == BTG_ERROR_FILE ? APP_FAILED : APP_UNUSABLE, "%s",
                        r->message.text);
}

/* ---- solving ------------------------------------------------------------------------------ */

/* Fills points from `next` on, those that are no lifts; returns how many. *passed: lifts too. */
static size_t take_chunk(run *r, size_t next, size_t most, size_t *passed) {
    size_t n = 0;
    for (*passed = 0; *passed < most && next + *passed < r->feet.total; ++*passed) {
        btg_footprint_point p = feet_at(&r->feet, next + *passed);
        if (p.lift) continue;
        r->xy[2 * n] = p.x_mm;
        r->xy[2 * n + 1] = p.y_mm;
        r->points[n++] = p;
    }
    return n;
}

static int refuse_position(const btg_footprint_point *p, const btg_position *position) {
    return app_complain(APP_FAILED,
                        "pass %lu, point %lu, at %.9g, %.9g mm: no answer (%s); try another "
                        "--tolerance or --backend",
                        (unsigned long)p->pass, (unsigned long)p->point, p->x_mm, p->y_mm,
                        btg_status_name(position->status));
}

static int refuse_work(const run *r, btg_status status) {
    return app_complain(APP_FAILED,
                        "method %s, back end %s: failed (%s); try another --backend, or "
                        "NAME,auto, which goes on with another",
                        r->options.method, btg_method_backend_name(r->method),
                        btg_status_name(status));
}

static int solve_chunk(run *r, size_t count, double *seconds) {
    double begin = app_seconds();
    btg_status status = btg_backend_positions(r->front, r->xy, count, r->positions, NULL);
    *seconds = app_seconds() - begin;
    r->summary.seconds += *seconds;
    if (status < 0) return refuse_work(r, status);
    for (size_t i = 0; i < count; i++) {
        if (r->positions[i].status < 0) return refuse_position(&r->points[i], &r->positions[i]);
        status = rows_add(&r->rows, r->points[i], &r->positions[i]);
        if (status < 0) return refuse_work(r, status);
    }
    if (sinks_check(&r->sinks, &r->message) == BTG_OK) return APP_DONE;
    return app_complain(APP_FAILED, "%s", r->message.text);
}

static int solve(run *r) {
    progress bar = progress_begin(r->feet.total, r->options.quiet);
    size_t chunk = CHUNK_MIN;
    int code = APP_DONE;
    for (size_t next = 0; next < r->feet.total && code == APP_DONE;) {
        double seconds;
        size_t passed, n = take_chunk(r, next, chunk, &passed);
        code = solve_chunk(r, n, &seconds);
        next += passed;
        if (seconds < CHUNK_TIME_S / 2 && chunk < CHUNK_MAX) chunk *= 2;
        if (seconds > CHUNK_TIME_S * 2 && chunk > CHUNK_MIN) chunk /= 2;
        progress_show(&bar, next, next);
    }
    progress_end(&bar);
    if (code != APP_DONE) return code;
    btg_status status = rows_end(&r->rows);
    if (status < 0) return refuse_work(r, status);
    return APP_DONE;
}

/* ---- the end ------------------------------------------------------------------------------ */

static int report(run *r) {
    const path_options *o = &r->options;
    btg_output out = btg_output_borrow(r->sinks.standard ? stderr : stdout);
    if (o->json) {
        btg_json json = btg_json_to(&out);
        btg_json_open(&json, NULL, '{');
        summary_json(&r->summary, &json);
        btg_json_close(&json, '}');
        btg_output_text(&out, "\n");
    } else if (!o->quiet) {
        terminal table;
        terminal_open(&table, out.file);
        summary_print(&r->summary, table.file);
        terminal_close(&table);
    }
    btg_status status = btg_output_finish(&out, &r->message);
    if (status == BTG_OK) return APP_DONE;
    return app_complain(APP_FAILED, "%s", r->message.text);
}

static int finish(run *r) {
    r->summary.backend = btg_method_backend_name(r->method);
    r->summary.note = btg_method_note(r->method);
    if (r->summary.note[0])
        app_complain(APP_DONE, "%s; back end %s went on", r->summary.note, r->summary.backend);
    r->summary.threads = btg_method_threads(r->method);
    r->summary.counts = btg_method_get_counts(r->method);
    btg_method_get_times(r->method, &r->summary.times);
    if (!summary_contact(&r->summary)) {
        return app_complain(APP_FAILED,
                            "%.256s: no position touches the part; check the footprint, "
                            "--gltf-unit and --up",
                            r->options.part);
    }
    btg_status status = sinks_end(&r->sinks, &r->summary, &r->message);
    if (status != BTG_OK) return app_complain(APP_FAILED, "%s", r->message.text);
    r->summary.program = sinks_program(&r->sinks);
    return report(r);
}

int app_path(int count, char **words) {
    run *r = calloc(1, sizeof *r);
    if (!r) return app_complain(APP_FAILED, "out of memory");
    int code = APP_UNUSABLE;
    if (options_parse(count, words, &r->options)) {
        r->summary.options = &r->options;
        if (r->options.help) {
            code = app_help("path");
        } else {
            code = set_up(r);
            if (code == APP_DONE) code = solve(r);
            if (code == APP_DONE) code = finish(r);
        }
    }
    rows_close(&r->rows);
    sinks_close(&r->sinks);
    feet_close(&r->feet);
    btg_method_close(r->method);
    btg_part_destroy(r->part);
    free(r);
    return code;
}
