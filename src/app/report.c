#define _POSIX_C_SOURCE 200809L
#include "app/report.h"
#include "app/app.h"
#include "core/part.h"
#include "io/shape.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* report/page.html with its style sheet and scripts (tools/embed.py). */
extern const unsigned char report_page[];
/* Where the data goes. */
#define MARKER "@DATA@"

/* Triangles of the part: as many as a phone turns smoothly, beside its own. */
#define TRIANGLES_FINE 150000
#define TRIANGLES_MOST 1500000

/* ---- data --------------------------------------------------------------------------------- */

void report_bytes(btg_json *json, const char *name, const void *data, size_t size) {
    static const char digit[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const unsigned char *in = data;
    char *text = malloc((size + 2) / 3 * 4 + 1), *out = text;
    if (!text) { /* latches like a failed write */
        json->output->error = ENOMEM;
        return;
    }
    for (size_t i = 0; i < size; i += 3) {
        size_t n = size - i < 3 ? size - i : 3;
        uint32_t v = (uint32_t)in[i] << 16;
        if (n > 1) v |= (uint32_t)in[i + 1] << 8;
        if (n > 2) v |= in[i + 2];
        *out++ = digit[v >> 18];
        *out++ = digit[v >> 12 & 63];
        *out++ = n > 1 ? digit[v >> 6 & 63] : '=';
        *out++ = n > 2 ? digit[v & 63] : '=';
    }
    *out = '\0';
    btg_json_string(json, name, text);
    free(text);
}

/* Normals as signed bytes, a fourth for alignment. */
static btg_status put_shape(const btg_shape *s, btg_json *json) {
    signed char *normals = malloc(4 * s->point_count + 1);
    if (!normals || s->short_of_memory) {
        free(normals);
        return BTG_ERROR_MEMORY;
    }
    for (size_t i = 0; i < 4 * s->point_count; i++)
        normals[i] = i % 4 == 3 ? 0 : (signed char)lrintf(127 * s->normals[i / 4 * 3 + i % 4]);
    report_bytes(json, "points", s->points, 3 * s->point_count * sizeof *s->points);
    report_bytes(json, "normals", normals, 4 * s->point_count);
    report_bytes(json, "indices", s->indices, s->index_count * sizeof *s->indices);
    free(normals);
    return BTG_OK;
}

static btg_status put_part(const report *r, btg_json *json, btg_message *message) {
    btg_shape shape = {0};
    btg_part_info info;
    btg_part_get_info(r->part, &info);
    if (info.triangle_count > TRIANGLES_MOST)
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "report: the part's %zu triangles are too many for a page; give one with "
                        "at most %d",
                        info.triangle_count, TRIANGLES_MOST);
    btg_status status =
        btg_shape_part(&shape, r->part, info.triangle_count + TRIANGLES_FINE, message);
    btg_json_open(json, "mesh", '{');
    if (status == BTG_OK) status = put_shape(&shape, json);
    btg_json_close(json, '}');
    btg_shape_release(&shape);
    return status;
}

static btg_status put_solid(btg_shape *shape, const char *kind, btg_json *json) {
    btg_json_open(json, NULL, '{');
    btg_json_string(json, "kind", kind);
    btg_status status = put_shape(shape, json);
    btg_json_close(json, '}');
    btg_shape_release(shape);
    return status;
}

static btg_status put_tool(const report *r, btg_json *json) {
    static const char *const kind[3] = {"insert", "shank", "holder"};
    btg_status status = BTG_OK;
    btg_json_open(json, "tool_solids", '[');
    for (uint32_t i = 0; i < r->tool->element_count && status == BTG_OK; i++) {
        btg_shape shape = {0};
        btg_shape_tool(&shape, r->tool, i);
        status = put_solid(&shape, kind[btg_shape_solid(r->tool, i)], json);
    }
    if (r->tool->def.shank.radius_mm == 0 && status == BTG_OK) {
        btg_shape shape = {0};
        btg_shape_rod(&shape, r->tool, btg_scene_tool_mm(r->tool));
        status = put_solid(&shape, "body", json);
    }
    btg_json_close(json, ']');
    btg_json_number(json, "tool_height_mm", btg_scene_tool_mm(r->tool));
    return status;
}

/* Numbers of one stop in the page: tip, axis, P, Q, tilt. */
#define STOP_FLOATS 13

static btg_status put_stops(const btg_scene *s, btg_json *json) {
    float *values = malloc(s->count * STOP_FLOATS * sizeof *values);
    uint32_t *names = malloc(s->count * 4 * sizeof *names); /* pass, point, status, linked */
    if (!values || !names) {
        free(values);
        free(names);
        return BTG_ERROR_MEMORY;
    }
    for (size_t i = 0; i < s->count; i++) {
        const btg_scene_stop *a = &s->stops[i];
        float *v = values + STOP_FLOATS * i;
        const uint32_t name[4] = {a->pass, a->point, (uint32_t)a->status, a->linked};
        memcpy(v, a->tip, sizeof a->tip);
        memcpy(v + 3, a->axis, sizeof a->axis);
        memcpy(v + 6, a->p, sizeof a->p);
        memcpy(v + 9, a->q, sizeof a->q);
        v[12] = a->tilt_rad * (float)(180 / BTG_PI);
        memcpy(names + 4 * i, name, sizeof name);
    }
    btg_json_open(json, "stops", '{');
    btg_json_count(json, "count", s->count);
    report_bytes(json, "values", values, s->count * STOP_FLOATS * sizeof *values);
    report_bytes(json, "names", names, s->count * 4 * sizeof *names);
    btg_json_close(json, '}');
    free(values);
    free(names);
    return BTG_OK;
}

/* ---- settings ----------------------------------------------------------------------------- */

static void setting(btg_json *json, const char *name, const char *format, double value) {
    char text[64];
    snprintf(text, sizeof text, format, value);
    btg_json_open(json, NULL, '[');
    btg_json_string(json, NULL, name);
    btg_json_string(json, NULL, text);
    btg_json_close(json, ']');
}

static void setting_word(btg_json *json, const char *name, const char *word) {
    btg_json_open(json, NULL, '[');
    btg_json_string(json, NULL, name);
    btg_json_string(json, NULL, word);
    btg_json_close(json, ']');
}

/* Names and values as the command line has them. */
static void put_settings(const path_options *o, btg_json *json) {
    static const char *const footprint[3] = {"parallel", "zigzag", "one-way"};
    static const char *const spin[5] = {"none", "fixed", "gap", "across", "widest"};
    char tool[96];
    snprintf(tool, sizeof tool, "%.6g,%.6g,%s", o->tool.major_radius_mm, o->tool.minor_radius_mm,
             o->tool.profile == BTG_PROFILE_TOROIDAL ? "toroidal" : "bullnose");
    btg_json_open(json, "settings", '[');
    setting_word(json, "--tool", tool);
    if (o->points) {
        setting_word(json, "--footprint points", o->points);
    } else {
        setting_word(json, "--footprint", o->contour ? "contour" : footprint[o->footprint.kind]);
        setting(json, "--side-step", "%.6g mm", o->footprint.side_step_mm);
        setting(json, "--forward-step", "%.6g mm", o->footprint.forward_step_mm);
    }
    setting_word(json, "--method", o->method);
    setting_word(json, "--spin", spin[o->solver.spin]);
    if (o->solver.spin == BTG_SPIN_FIXED) setting(json, "spin", "%.6g\xc2\xb0", o->spin_deg);
    if (o->solver.spin == BTG_SPIN_GAP) setting(json, "gap", "%.6g mm", o->solver.gap_mm);
    setting(json, "--scallop", "%.6g mm", o->solver.scallop_mm);
    setting(json, "--feed-direction", "%.6g\xc2\xb0", o->feed_deg);
    setting(json, "--max-tilt", "%.6g\xc2\xb0", o->max_tilt_deg);
    setting(json, "--tolerance", "%.6g mm", o->solver.tolerance_mm);
    setting(json, "--feed", "%.6g mm/min", o->feed_mm_per_min);
    if (o->machine) setting_word(json, "--machine", o->machine);
    if (o->gltf.use_mesh) setting_word(json, "--use-mesh", "on");
    if (o->raw) setting_word(json, "--raw", "on");
    btg_json_close(json, ']');
}

/* ---- the page ----------------------------------------------------------------------------- */

static btg_status put_data(const report *r, btg_json *json, btg_message *message) {
    btg_json_open(json, NULL, '{');
    btg_json_string(json, "title", app_file_name(r->summary->options->part));
    btg_json_open(json, "summary", '{');
    summary_json(r->summary, json);
    btg_json_close(json, '}');
    put_settings(r->summary->options, json);
    btg_status status = put_part(r, json, message);
    if (status == BTG_OK) {
        status = put_tool(r, json);
        if (status == BTG_OK) status = put_stops(r->scene, json);
        if (status != BTG_OK) btg_fail(message, status, "report: out of memory");
    }
    if (status == BTG_OK) status = report_check(r, json, message);
    if (status == BTG_OK) status = report_backends(r, json, message);
    if (status == BTG_OK) status = report_joints(r, json, message);
    btg_json_close(json, '}');
    return status;
}

/* JSON that cannot end the script element it stands in, whatever names it holds. */
static void write_data(btg_output *output, const char *text) {
    for (const char *s = text; *s;) {
        size_t n = strcspn(s, "<");
        btg_output_write(output, s, n);
        s += n;
        if (*s == '\0') break;
        btg_output_text(output, "\\u003c");
        s++;
    }
}

static btg_status collect(const report *r, char **text, btg_message *message) {
    size_t size = 0;
    FILE *file = open_memstream(text, &size);
    if (!file) return btg_fail(message, BTG_ERROR_MEMORY, "report: out of memory");
    btg_output memory = btg_output_borrow(file);
    btg_json json = btg_json_to(&memory);
    btg_status status = put_data(r, &json, message);
    bool failed = memory.error != 0;
    if ((fclose(file) != 0 || failed) && status == BTG_OK)
        status = btg_fail(message, BTG_ERROR_MEMORY, "report: out of memory");
    return status;
}

btg_status report_write(const report *r, btg_output *output, btg_message *message) {
    const char *page = (const char *)report_page, *marker = strstr(page, MARKER);
    char *data = NULL;
    if (r->scene->short_of_memory)
        return btg_fail(message, BTG_ERROR_MEMORY, "report: out of memory; choose longer steps");
    if (r->scene->count > REPORT_STOPS_MAX)
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "report: %zu positions are too many for a page; choose longer steps, for "
                        "at most %d",
                        r->scene->count, REPORT_STOPS_MAX);
    btg_status status = collect(r, &data, message);
    if (status == BTG_OK) {
        btg_output_write(output, page, (size_t)(marker - page));
        write_data(output, data);
        btg_output_text(output, marker + strlen(MARKER));
        status = btg_output_check(output, message);
    }
    free(data);
    return status;
}
