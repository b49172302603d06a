/* The report's machine: where its joints stand over time, as its program has them. */
#include "app/report.h"
#include "core/part.h"
#include "io/machine.h"

#include <stdlib.h>

#define JOINTS     5
#define ROOM_FIRST 4096
/* More moments make a page that no browser likes. */
#define MOMENTS_MAX 400000

typedef struct moment {
    float seconds; /* of the way here */
    float joint[JOINTS];
} moment;

typedef struct track {
    btg_machine machine;
    moment *list;
    size_t count, room;
    bool short_of_memory;
    bool any;
    btg_joints last;
} track;

static btg_status ignore(const char *text, size_t size, void *user) {
    (void)text, (void)size, (void)user;
    return BTG_OK;
}

/* A rapid takes as long as its slowest joint. */
static double rapid_seconds(const track *t, const btg_joints *to) {
    const btg_machine_def *d = &t->machine.def;
    double seconds = 0;
    for (int i = 0; t->any && i < 3; i++)
        seconds = fmax(seconds,
                       fabs(to->linear_mm[i] - t->last.linear_mm[i]) / d->linear[i].speed_mm_per_s);
    for (int i = 0; t->any && i < 2; i++)
        seconds = fmax(seconds, fabs(to->rotary_rad[i] - t->last.rotary_rad[i]) /
                                    d->rotary[i].speed_rad_per_s);
    return seconds;
}

static void follow(const btg_joints *joints, double seconds, void *user) {
    track *t = user;
    if (t->count == t->room) {
        size_t room = t->room ? 2 * t->room : ROOM_FIRST;
        moment *list = realloc(t->list, room * sizeof *list);
        if (!list) {
            t->short_of_memory = true;
            return;
        }
        t->list = list;
        t->room = room;
    }
    moment *m = &t->list[t->count++];
    m->seconds = (float)(seconds > 0 ? seconds : rapid_seconds(t, joints));
    for (int i = 0; i < 3; i++)
        m->joint[i] = (float)joints->linear_mm[i];
    for (int i = 0; i < 2; i++)
        m->joint[3 + i] = (float)(joints->rotary_rad[i] * (180 / BTG_PI));
    t->last = *joints;
    t->any = true;
}

static btg_status run(const report *r, track *t, btg_program_info *info, btg_message *message) {
    const path_options *o = r->summary->options;
    btg_program_def def = btg_program_def_default();
    def.feed_mm_per_min = o->feed_mm_per_min;
    def.clear_z_mm = r->clear_z_mm;
    def.tolerance_mm = o->motion_tolerance_mm;
    def.write = ignore;
    def.trace = follow;
    def.user = t;
    btg_program *program = NULL;
    btg_status status = btg_program_create(&def, &t->machine, r->tool, &program, message);
    for (size_t i = 0; i < r->scene->count && status == BTG_OK; i++) {
        const btg_scene_stop *s = &r->scene->stops[i];
        btg_position p = {.status = (btg_status)s->status};
        p.tip = s->exact_tip;
        p.axis = s->exact_axis;
        status = btg_program_add(program, &p, s->linked, message);
    }
    if (status == BTG_OK) status = btg_program_end(program, info, message);
    btg_program_destroy(program);
    return status;
}

static void put_limits(const btg_machine_def *d, btg_json *json) {
    btg_json_open(json, "limits", '[');
    for (int i = 0; i < JOINTS; i++) {
        bool turns = i >= 3;
        btg_json_open(json, NULL, '[');
        btg_json_number(json, NULL,
                        turns ? d->rotary[i - 3].min_rad * (180 / BTG_PI) : d->linear[i].min_mm);
        btg_json_number(json, NULL,
                        turns ? d->rotary[i - 3].max_rad * (180 / BTG_PI) : d->linear[i].max_mm);
        btg_json_close(json, ']');
    }
    btg_json_close(json, ']');
}

static btg_status put_track(const track *t, const btg_program_info *info, btg_json *json) {
    const btg_machine_def *d = &t->machine.def;
    char name[2] = "";
    float *values = malloc((JOINTS + 1) * t->count * sizeof *values);
    double time = 0;
    if (!values && t->count > 0) return BTG_ERROR_MEMORY;
    for (size_t i = 0; i < t->count; i++) {
        time += (double)t->list[i].seconds;
        values[(JOINTS + 1) * i] = (float)time;
        for (int k = 0; k < JOINTS; k++)
            values[(JOINTS + 1) * i + 1 + (size_t)k] = t->list[i].joint[k];
    }
    btg_json_open(json, "machine", '{');
    btg_json_string(json, "name", d->name);
    btg_json_open(json, "joints", '[');
    for (int i = 0; i < JOINTS; i++) {
        name[0] = i < 3 ? (char)('X' + i) : d->rotary[i - 3].letter;
        btg_json_string(json, NULL, name);
    }
    btg_json_close(json, ']');
    put_limits(d, json);
    btg_json_count(json, "blocks", info->blocks);
    btg_json_count(json, "slowed", info->slowed);
    btg_json_count(json, "retracts", info->retracts);
    btg_json_count(json, "rewinds", info->rewinds);
    btg_json_number(json, "cut_seconds", info->cut_seconds);
    btg_json_number(json, "seconds", time);
    btg_json_count(json, "moments", t->count);
    report_bytes(json, "track", values, (JOINTS + 1) * t->count * sizeof *values);
    btg_json_close(json, '}');
    free(values);
    return BTG_OK;
}

btg_status report_joints(const report *r, btg_json *json, btg_message *message) {
    const path_options *o = r->summary->options;
    track t = {0};
    btg_program_info info;
    if (!o->machine) return BTG_OK;
    btg_status status = btg_machine_load(o->machine, o->tool_length_mm, &t.machine, message);
    if (status == BTG_OK) status = run(r, &t, &info, message);
    if (status == BTG_OK && t.count > MOMENTS_MAX)
        status = btg_fail(message, BTG_ERROR_ARGUMENT,
                          "report: %zu blocks are too many for a page; choose longer steps or a "
                          "larger --motion-tolerance",
                          t.count);
    if (status == BTG_OK && (t.short_of_memory || put_track(&t, &info, json) != BTG_OK))
        status = btg_fail(message, BTG_ERROR_MEMORY, "report: out of memory");
    free(t.list);
    return status;
}
