#include "app/sink.h"
#include "app/app.h"
#include "app/report.h"
#include "core/part.h"
#include "io/csv.h"
#include "io/machine.h"

#include <string.h>

static btg_status write_text(const char *text, size_t size, void *user) {
    btg_output *output = user;
    btg_output_write(output, text, size);
    return output->error ? BTG_ERROR_FILE : BTG_OK;
}

/* The part's file name without folders and ending. */
static void name_part(const char *path, char *name, size_t size) {
    const char *base = app_file_name(path);
    const char *dot = strrchr(base, '.');
    int length = dot && dot > base ? (int)(dot - base) : (int)strlen(base);
    snprintf(name, size, "%.*s", length, base);
}

static btg_status begin_program(sink *k, const path_options *options, const btg_tool *tool,
                                double clear_z_mm, btg_message *message) {
    char name[64];
    btg_machine machine;
    btg_status status =
        btg_machine_load(options->machine, options->tool_length_mm, &machine, message);
    if (status != BTG_OK) return status == BTG_ERROR_FILE ? BTG_ERROR_FORMAT : status;
    btg_program_def def = btg_program_def_default();
    name_part(options->part, name, sizeof name);
    def.name = name;
    def.feed_mm_per_min = options->feed_mm_per_min;
    def.clear_z_mm = clear_z_mm;
    def.tolerance_mm = options->motion_tolerance_mm;
    def.tool_number = options->tool_number;
    def.spindle_rpm = options->spindle_rpm;
    def.write = write_text;
    def.user = &k->output;
    return btg_program_create(&def, &machine, tool, &k->program, message);
}

static btg_status begin(sink *k, const path_options *options, const btg_tool *tool,
                        double clear_z_mm, btg_message *message) {
    char name[64];
    if (k->kind == OUTPUT_CSV) {
        btg_csv_header(&k->output, path_inserts(options));
    } else if (k->kind == OUTPUT_JSON) {
        k->json = btg_json_to(&k->output);
        btg_json_open(&k->json, NULL, '{');
        btg_json_open(&k->json, "positions", '[');
        btg_output_text(&k->output, "\n");
    } else if (k->kind == OUTPUT_CL) {
        btg_apt_def def = btg_apt_def_default();
        name_part(options->part, name, sizeof name);
        def.part_name = name;
        def.feed_mm_per_min = options->feed_mm_per_min;
        def.clear_z_mm = clear_z_mm;
        def.write = write_text;
        def.user = &k->output;
        btg_status status = btg_apt_begin(&k->apt, &def, tool, message);
        k->apt.def.part_name = NULL;
        if (status != BTG_OK && k->output.error == 0) return status;
    } else if (k->kind == OUTPUT_NGC) {
        btg_status status = begin_program(k, options, tool, clear_z_mm, message);
        if (status != BTG_OK) return status;
    }
    return btg_output_check(&k->output, message);
}

btg_status sinks_open(sinks *s, const path_options *options, const btg_part *part,
                      const btg_tool *tool, double clear_z_mm, btg_message *message) {
    memset(s, 0, sizeof *s);
    s->part = part;
    s->tool = tool;
    s->clear_z_mm = clear_z_mm;
    btg_status status = BTG_OK;
    for (int i = 0; i < options->output_count && status == BTG_OK; i++) {
        sink *k = &s->list[i];
        k->kind = options->outputs[i].kind;
        status = btg_output_open(&k->output, options->outputs[i].path, message);
        if (status != BTG_OK) break;
        s->count++;
        if (k->output.standard) s->standard = true;
        if (s->standard && options->json) {
            status = btg_fail(message, BTG_ERROR_ARGUMENT,
                              "--json: the standard output takes the path already; drop one");
        } else {
            status = begin(k, options, tool, clear_z_mm, message);
        }
    }
    if (status != BTG_OK) sinks_close(s);
    return status;
}

void sinks_row(sinks *s, const btg_row *row, bool linked) {
    for (int i = 0; i < s->count; i++) {
        sink *k = &s->list[i];
        if (k->kind == OUTPUT_CSV) {
            btg_csv_row(&k->output, row);
        } else if (k->kind == OUTPUT_JSON) {
            btg_json_row(&k->json, row);
            btg_output_text(&k->output, "\n");
        } else if (k->kind == OUTPUT_PNG) {
            if (!row->lift) btg_picture_add(&k->picture, &row->position);
        } else if (k->kind == OUTPUT_GLB || k->kind == OUTPUT_HTML) {
            btg_scene_add(&k->scene, row, linked);
        } else if (row->lift && !row->between) {
            /* APT and programs make their own retracts, also where the path has none. */
        } else if (k->kind == OUTPUT_CL) {
            btg_apt_add(&k->apt, &row->position, linked);
        } else if (k->status == BTG_OK) {
            k->status = btg_program_add(k->program, &row->position, linked, &k->message);
        }
    }
}

btg_status sinks_check(const sinks *s, btg_message *message) {
    for (int i = 0; i < s->count; i++) {
        btg_status status = btg_output_check(&s->list[i].output, message);
        if (status != BTG_OK) return status;
        if (s->list[i].status == BTG_OK) continue;
        return btg_fail(message, s->list[i].status, "%s", s->list[i].message.text);
    }
    return BTG_OK;
}

static btg_status end(const sinks *s, sink *k, const summary *result, btg_message *message) {
    if (k->kind == OUTPUT_JSON) {
        btg_json_close(&k->json, ']');
        btg_json_open(&k->json, "summary", '{');
        summary_json(result, &k->json);
        btg_json_close(&k->json, '}');
        btg_json_close(&k->json, '}');
        btg_output_text(&k->output, "\n");
    } else if (k->kind == OUTPUT_CL) {
        btg_apt_end(&k->apt);
    } else if (k->kind == OUTPUT_NGC) {
        btg_status status = btg_program_end(k->program, &k->info, message);
        /* A failed write is told by the file itself. */
        return k->output.error ? btg_output_check(&k->output, message) : status;
    } else if (k->kind == OUTPUT_PNG) {
        return btg_picture_write(&k->picture, &k->output, s->part, s->tool,
                                 app_file_name(result->options->part), message);
    } else if (k->kind == OUTPUT_GLB) {
        return btg_scene_glb(&k->scene, s->part, s->tool, app_file_name(result->options->part),
                             &k->output, message);
    } else if (k->kind == OUTPUT_HTML) {
        const report r = {.scene = &k->scene,
                          .part = s->part,
                          .tool = s->tool,
                          .summary = result,
                          .clear_z_mm = s->clear_z_mm};
        return report_write(&r, &k->output, message);
    }
    return BTG_OK;
}

btg_status sinks_end(sinks *s, const summary *result, btg_message *message) {
    for (int i = 0; i < s->count; i++) {
        btg_status status = end(s, &s->list[i], result, message);
        if (status != BTG_OK) return status;
    }
    for (int i = 0; i < s->count; i++) {
        btg_status status = btg_output_finish(&s->list[i].output, message);
        if (status != BTG_OK) return status;
    }
    for (int i = 0; i < s->count; i++) {
        btg_status status = btg_output_commit(&s->list[i].output, message);
        if (status != BTG_OK) return status;
    }
    return BTG_OK;
}

const btg_program_info *sinks_program(const sinks *s) {
    for (int i = 0; i < s->count; i++) {
        if (s->list[i].kind == OUTPUT_NGC) return &s->list[i].info;
    }
    return NULL;
}

void sinks_close(sinks *s) {
    for (int i = 0; i < s->count; i++) {
        btg_output_discard(&s->list[i].output);
        btg_picture_release(&s->list[i].picture);
        btg_scene_release(&s->list[i].scene);
        btg_program_destroy(s->list[i].program);
    }
    s->count = 0;
}
