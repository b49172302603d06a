#include "app/verify.h"
#include "io/json.h"

#include <inttypes.h>
#include <math.h>

/* A joint's speed over what it can do; a program's numbers are rounded. */
#define HASTE_MAX 1.01

bool verify_ok(const verify_report *v) {
    const verify_options *o = v->options;
    /* Shank or holder in the part are no gouge of the field, and worse. */
    if (isfinite(o->max_gouge_mm) && v->result.collisions > 0) return false;
    return v->result.max_gouge_mm <= o->max_gouge_mm &&
           v->result.max_scallop_mm <= o->max_scallop_mm && v->track->missing == 0 &&
           v->track->doubled == 0 && v->track->reader.haste <= HASTE_MAX;
}

/* ---- for people --------------------------------------------------------------------------- */

static void print_place(const btg_verify_place *p, bool on_part, FILE *file) {
    if (p->position == 0) return;
    fprintf(file, ", %s %.3f, %.3f, %.3f, position %" PRIu64 " (line %" PRIu64 ")",
            on_part ? "at" : "tip", p->at.x, p->at.y, p->at.z, p->position, p->line);
}

static void print_limit(double value, double limit, FILE *file) {
    if (isfinite(limit))
        fprintf(file, "; %s the limit of %.6g mm", value <= limit ? "within" : "BEYOND", limit);
}

static void print_program(const btg_track *t, FILE *file) {
    const btg_reader *r = &t->reader;
    const btg_machine_def *d = &r->machine->def;
    if (t->missing > 0)
        fprintf(file, "%-14s the program says %ld moves of %ld blocks, and has %lu of %lu\n",
                "LINES CHANGED", r->promised[0], r->promised[1], r->moves, r->blocks);
    fprintf(file, "%-14s %s: ", "machine", d->name);
    if (r->haste == 0) {
        fprintf(file, "%lu moves, joint speeds not known\n", r->moves);
        return;
    }
    char joint =
        (char)(r->hasty_joint < 3 ? 'X' + r->hasty_joint : d->rotary[r->hasty_joint - 3].letter);
    fprintf(file, "%lu moves, joints at most at %.1f %% of their speed (%c, line %" PRIu64 ")%s\n",
            r->moves, 100 * r->haste, joint, t->hasty_line,
            r->haste > HASTE_MAX ? "; BEYOND the limit" : "");
}

static void print_missing(const btg_track *t, FILE *file) {
    if (t->kind == BTG_TRACK_PROGRAM) {
        print_program(t, file);
    } else if (t->kind == BTG_TRACK_APT && t->missing > 0) {
        fprintf(file, "%-14s the file says that it has %ld GOTO records, and has %u\n",
                "LINES CHANGED", t->promised, t->last_point);
    } else if (t->missing > 0) {
        fprintf(file,
                "%-14s %10" PRIu64 " positions by their numbers, first before pass %u, point %u\n",
                "MISSING", t->missing, t->missing_pass, t->missing_point);
    }
    if (t->doubled > 0)
        fprintf(file, "%-14s %10" PRIu64 " rows are the one before again, first line %" PRIu64 "\n",
                "DOUBLED", t->doubled, t->doubled_line);
}

static void print_bounds(const verify_report *v, FILE *file) {
    const btg_verify_result *r = &v->result;
    if (isnan(r->motion_bound_mm)) return;
    fprintf(file, "%-14s %10.6f mm at the positions\n", "proven gouge", r->position_bound_mm);
    fprintf(file, "%-14s %10.6f mm between them too", "", r->motion_bound_mm);
    print_place(&r->bound, false, file);
    fprintf(file, "\n");
    if (v->tool->element_count < 2) return;
    fprintf(file, "%-14s %10" PRIu64, "collisions", r->collisions);
    if (r->collisions > 0) {
        fprintf(file, " of shank or holder, %.3f mm to back out", r->collision_mm);
        print_place(&r->collision, false, file);
    }
    fprintf(file, "\n");
}

void verify_print(const verify_report *v, FILE *file) {
    const btg_verify_result *r = &v->result;
    const verify_options *o = v->options;
    fprintf(file, "%-14s %s\n", "part", o->path.part);
    fprintf(file, "%-14s %s: %" PRIu64 " positions, %" PRIu64 " steps, %.6g mm\n", "path", o->track,
            r->positions, r->steps, r->length_mm);
    fprintf(file, "%-14s %" PRIu64 " cells of %.6g mm, swept tool to %.6g mm\n", "field", r->cells,
            r->cell_mm, r->sweep_error_mm);
    print_missing(v->track, file);
    fprintf(file, "%-14s %10.6f mm", "greatest gouge", r->max_gouge_mm);
    print_place(&r->gouge, true, file);
    print_limit(r->max_gouge_mm, o->max_gouge_mm, file);
    fprintf(file, "\n%-14s %10.3f mm2 deeper than %.6g mm\n", "gouged area", r->gouge_area_mm2,
            o->def.gouge_mm);
    print_bounds(v, file);
    fprintf(file, "%-14s %10.6f mm, at %.3f, %.3f, %.3f", "most left", r->max_scallop_mm,
            r->scallop.at.x, r->scallop.at.y, r->scallop.at.z);
    print_limit(r->max_scallop_mm, o->max_scallop_mm, file);
    fprintf(file, "\n%-14s %10.6f mm mean; 50 %% %.6f, 90 %% %.6f, 99 %% %.6f, 99.9 %% %.6f mm\n",
            "", r->mean_scallop_mm, r->percentile_mm[0], r->percentile_mm[1], r->percentile_mm[2],
            r->percentile_mm[3]);
    fprintf(file, "%-14s %10.3f mm, up to %.6g mm left\n", "strip width", r->strip_width_mm,
            o->def.scallop_mm);
    fprintf(file, "%-14s %10.3f mm2\n", "uncut area", r->uncut_mm2);
    fprintf(file, "%-14s %10.1f mm3\n", "removed", r->removed_mm3);
    fprintf(file, "%-14s %10s in %.3g s on %" PRIu32 " thread%s\n", "verified",
            v->ok ? "ok" : "NOT OK", v->seconds, v->threads, v->threads == 1 ? "" : "s");
    for (int i = 0; i < o->output_count; i++)
        fprintf(file, "%-14s %s\n", i == 0 ? "wrote" : "", o->outputs[i].path);
}

/* ---- for programs ------------------------------------------------------------------------- */

static void json_place(btg_json *json, const char *name, const btg_verify_place *p, bool known) {
    btg_json_open(json, name, '{');
    if (p->position > 0) {
        btg_json_count(json, "position", p->position);
        btg_json_count(json, "line", p->line);
        btg_json_count(json, "pass", p->pass);
        btg_json_count(json, "point", p->point);
    }
    if (known || p->position > 0) {
        btg_json_number(json, "x", p->at.x);
        btg_json_number(json, "y", p->at.y);
        btg_json_number(json, "z", p->at.z);
    }
    btg_json_close(json, '}');
}

static void json_field(btg_json *json, const btg_verify_result *r) {
    static const char *const percent[4] = {"p50", "p90", "p99", "p99.9"};
    btg_json_open(json, "scallop_percentiles_mm", '{');
    for (int i = 0; i < 4; i++)
        btg_json_number(json, percent[i], r->percentile_mm[i]);
    btg_json_close(json, '}');
    btg_json_number(json, "mean_scallop_mm", r->mean_scallop_mm);
    btg_json_number(json, "gouge_area_mm2", r->gouge_area_mm2);
    btg_json_number(json, "strip_width_mm", r->strip_width_mm);
    btg_json_number(json, "uncut_area_mm2", r->uncut_mm2);
    btg_json_number(json, "removed_mm3", r->removed_mm3);
    btg_json_number(json, "length_mm", r->length_mm);
    btg_json_count(json, "cells", r->cells);
    btg_json_count(json, "part_cells", r->part_cells);
    btg_json_number(json, "grid_mm", r->cell_mm);
    btg_json_number(json, "sweep_error_mm", r->sweep_error_mm);
}

static void json_missing(btg_json *json, const btg_track *t) {
    btg_json_count(json, "missing", t->missing);
    if (t->kind == BTG_TRACK_CSV && t->missing > 0) {
        btg_json_open(json, "missing_before", '{');
        btg_json_count(json, "pass", t->missing_pass);
        btg_json_count(json, "point", t->missing_point);
        btg_json_close(json, '}');
    }
    btg_json_count(json, "doubled", t->doubled);
    if (t->kind != BTG_TRACK_PROGRAM) return;
    btg_json_string(json, "machine", t->reader.machine->def.name);
    btg_json_count(json, "moves", t->reader.moves);
    btg_json_number(json, "joint_speed", t->reader.haste > 0 ? t->reader.haste : NAN);
    btg_json_count(json, "joint_speed_line", t->hasty_line);
}

void verify_json(const verify_report *v, btg_output *output) {
    const btg_verify_result *r = &v->result;
    const verify_options *o = v->options;
    btg_json json = btg_json_to(output);
    btg_json_open(&json, NULL, '{');
    btg_json_string(&json, "version", btg_version());
    btg_json_string(&json, "part", o->path.part);
    btg_json_string(&json, "path", o->track);
    btg_json_bool(&json, "ok", v->ok);
    btg_json_count(&json, "positions", r->positions);
    btg_json_count(&json, "steps", r->steps);
    json_missing(&json, v->track);
    btg_json_number(&json, "max_gouge_mm", r->max_gouge_mm);
    json_place(&json, "max_gouge_at", &r->gouge, false);
    btg_json_number(&json, "max_scallop_mm", r->max_scallop_mm);
    json_place(&json, "max_scallop_at", &r->scallop, true);
    btg_json_number(&json, "gouge_limit_mm", o->max_gouge_mm);
    btg_json_number(&json, "scallop_limit_mm", o->max_scallop_mm);
    btg_json_number(&json, "position_bound_mm", r->position_bound_mm);
    btg_json_number(&json, "motion_bound_mm", r->motion_bound_mm);
    json_place(&json, "bound_at", &r->bound, false);
    btg_json_count(&json, "collisions", r->collisions);
    btg_json_number(&json, "collision_mm", r->collision_mm);
    json_place(&json, "collision_at", &r->collision, false);
    json_field(&json, r);
    btg_json_count(&json, "threads", v->threads);
    btg_json_number(&json, "seconds", v->seconds);
    btg_json_close(&json, '}');
    btg_output_text(output, "\n");
}
