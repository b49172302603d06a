/* The report's verification: the path is cut into a stock, as `bitangent verify` does. */
#include "app/report.h"
#include "app/progress.h"
#include "bitangent/verify.h"
#include "core/part.h"
#include "io/map.h"

#include <stdlib.h>

/* Cells along the part's longer side, about: a page is no place for millions of them. */
#define CELLS_SIDE 400.0

/* A deviation as one byte: 0 within the limits, else 1 + STEPS * log10(times the limit), below 0
 * where gouged; NONE where there is no part. */
#define STEPS     40.0
#define CODE_MOST 121
#define NONE      (-128)

static int code_of(const btg_map_scale *scale, double deviation) {
    if (isnan(deviation)) return NONE;
    double limit = deviation < 0 ? scale->gouge_mm : scale->scallop_mm;
    double excess = fabs(deviation) / limit;
    if (!(excess > 1)) return 0;
    double code = fmin(1 + floor(STEPS * log10(excess)), CODE_MOST);
    return (int)(deviation < 0 ? -code : code);
}

static double value_of(const btg_map_scale *scale, int code) {
    double limit = code < 0 ? -scale->gouge_mm : scale->scallop_mm;
    return code == 0 ? 0 : limit * pow(10, (abs(code) - 0.5) / STEPS);
}

/* Colours of -CODE_MOST .. CODE_MOST, 3 bytes each. */
static void put_palette(const btg_map_scale *scale, btg_json *json) {
    unsigned char rgb[3 * (2 * CODE_MOST + 1)], *at = rgb;
    for (int code = -CODE_MOST; code <= CODE_MOST; code++) {
        float c[3];
        btg_map_colour(scale, value_of(scale, code), c);
        for (int k = 0; k < 3; k++)
            *at++ = (unsigned char)(255 * c[k] + 0.5f);
    }
    report_bytes(json, "palette", rgb, sizeof rgb);
}

static btg_status put_map(const btg_verify_map *map, const btg_map_scale *scale, btg_json *json) {
    size_t size = (size_t)map->width * map->height;
    signed char *codes = malloc(size);
    if (!codes) return BTG_ERROR_MEMORY;
    for (size_t i = 0; i < size; i++)
        codes[i] = (signed char)code_of(scale, btg_verify_deviation(map, i));
    btg_json_open(json, "map", '{');
    btg_json_count(json, "width", map->width);
    btg_json_count(json, "height", map->height);
    btg_json_number(json, "x_mm", map->x_mm);
    btg_json_number(json, "y_mm", map->y_mm);
    btg_json_number(json, "cell_mm", map->cell_mm);
    btg_json_number(json, "gouge_limit_mm", scale->gouge_mm);
    btg_json_number(json, "scallop_limit_mm", scale->scallop_mm);
    btg_json_number(json, "steps_per_decade", STEPS);
    btg_json_count(json, "code_most", CODE_MOST);
    report_bytes(json, "codes", codes, size);
    put_palette(scale, json);
    btg_json_close(json, '}');
    free(codes);
    return BTG_OK;
}

static void put_place(btg_json *json, const char *name, const btg_verify_place *p) {
    btg_json_open(json, name, '[');
    btg_json_number(json, NULL, p->at.x);
    btg_json_number(json, NULL, p->at.y);
    btg_json_number(json, NULL, p->at.z);
    btg_json_close(json, ']');
}

static void put_figures(const btg_verify_result *v, btg_json *json) {
    btg_json_number(json, "max_gouge_mm", v->max_gouge_mm);
    if (v->gouge.position > 0) {
        btg_json_count(json, "gouge_line", v->gouge.line);
        put_place(json, "gouge_at_mm", &v->gouge);
    }
    btg_json_number(json, "gouge_area_mm2", v->gouge_area_mm2);
    btg_json_number(json, "position_bound_mm", v->position_bound_mm);
    btg_json_number(json, "motion_bound_mm", v->motion_bound_mm);
    btg_json_number(json, "max_scallop_mm", v->max_scallop_mm);
    put_place(json, "scallop_at_mm", &v->scallop);
    btg_json_number(json, "mean_scallop_mm", v->mean_scallop_mm);
    btg_json_number(json, "p90_scallop_mm", v->percentile_mm[1]);
    btg_json_number(json, "strip_width_mm", v->strip_width_mm);
    btg_json_number(json, "uncut_mm2", v->uncut_mm2);
    btg_json_number(json, "length_mm", v->length_mm);
    btg_json_count(json, "collisions", v->collisions);
    btg_json_number(json, "collision_mm", v->collision_mm);
}

/* `line` tells back which stop it was. */
static btg_status cut(const report *r, btg_verify *verify, btg_verify_result *result) {
    bool linked = false;
    progress bar = progress_begin(r->scene->count, r->summary->options->quiet);
    btg_status status = BTG_OK;
    for (size_t i = 0; i < r->scene->count && status >= 0; i++) {
        const btg_scene_stop *s = &r->scene->stops[i];
        btg_verify_pose pose = {.tip = s->exact_tip, .axis = s->exact_axis, .line = i};
        bool there = s->status != BTG_NO_CONTACT;
        pose.pass = s->pass;
        pose.point = s->point;
        pose.link = linked && s->linked;
        linked = there;
        if (there) status = btg_verify_add(verify, &pose);
        progress_show(&bar, i + 1, i + 1);
    }
    progress_end(&bar);
    return status < 0 ? status : btg_verify_end(verify, result);
}

btg_status report_check(const report *r, btg_json *json, btg_message *message) {
    btg_verify_def def = btg_verify_def_default();
    btg_part_info info;
    btg_part_get_info(r->part, &info);
    double longer = fmax(info.box_max.x - info.box_min.x, info.box_max.y - info.box_min.y);
    def.cell_mm = longer / CELLS_SIDE;
    def.threads = r->summary->options->threads;
    def.scallop_mm = r->summary->options->solver.scallop_mm;
    btg_verify *verify;
    btg_verify_result result;
    btg_message why;
    btg_status status = btg_verify_create(&def, r->part, r->tool, &verify, &why);
    if (status == BTG_OK) {
        status = cut(r, verify, &result);
        if (status < 0) btg_fail(&why, status, "a tool axis does not point up");
    } else {
        verify = NULL;
    }
    btg_json_open(json, "verify", '{');
    if (status < 0) {
        btg_json_string(json, "missing", why.text);
        status = status == BTG_ERROR_MEMORY ? status : BTG_OK;
    } else {
        const btg_map_scale scale = {.gouge_mm = def.gouge_mm, .scallop_mm = def.scallop_mm};
        btg_verify_map map = btg_verify_get_map(verify);
        put_figures(&result, json);
        status = put_map(&map, &scale, json);
    }
    btg_json_close(json, '}');
    btg_verify_destroy(verify);
    return status == BTG_OK ? status : btg_fail(message, status, "report: out of memory");
}
