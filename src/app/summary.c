#include "app/summary.h"
#include "core/vec.h"

#include <inttypes.h>

static const btg_status order[SUMMARY_STATUSES] = {BTG_OK, BTG_OSCULATING, BTG_SINGLE_CONTACT,
                                                   BTG_NO_CONTACT, BTG_BUDGET};

void summary_add(summary *s, const btg_row *row) {
    if (row->lift) {
        s->lifts++;
        return;
    }
    btg_status status = row->position.status;
    s->positions++;
    if (status < 0 || status >= SUMMARY_STATUSES) return;
    s->statuses[status]++;
    if (status != BTG_OK && status != BTG_OSCULATING) return;
    double degrees = row->position.tilt_rad * (180 / BTG_PI);
    if (s->tilted == 0 || degrees < s->tilt_min_deg) s->tilt_min_deg = degrees;
    if (s->tilted == 0 || degrees > s->tilt_max_deg) s->tilt_max_deg = degrees;
    s->tilted++;
    if (row->position.spin_met) s->spin_met++;
    double bin = degrees * TILT_BINS_PER_DEGREE;
    s->tilt_bins[bin < TILT_BINS - 1 ? (size_t)bin : TILT_BINS - 1]++;
}

bool summary_contact(const summary *s) {
    return s->positions > s->statuses[BTG_NO_CONTACT];
}

static double median(const summary *s) {
    uint64_t before = 0;
    if (s->tilted == 0) return NAN;
    for (int i = 0; i < TILT_BINS; i++) {
        before += s->tilt_bins[i];
        if (2 * before < s->tilted) continue;
        double middle = (i + 0.5) / TILT_BINS_PER_DEGREE;
        return fmin(fmax(middle, s->tilt_min_deg), s->tilt_max_deg);
    }
    return s->tilt_max_deg;
}

static double rate(const summary *s) {
    return s->seconds > 0 ? (double)(s->positions - s->motion.inserted) / s->seconds : 0;
}

static const char *footprint_word(const path_options *o) {
    static const char *const word[3] = {"parallel", "zigzag", "one-way"};
    if (o->contour) return "contour";
    return o->points ? "points" : word[o->footprint.kind];
}

static const char *profile_word(const btg_tool_def *tool) {
    return tool->profile == BTG_PROFILE_TOROIDAL ? "toroidal" : "bullnose";
}

static const char *spin_word(const path_options *o) {
    static const char *const word[5] = {"none", "fixed", "gap", "across", "widest"};
    return word[o->solver.spin];
}

/* ---- for people --------------------------------------------------------------------------- */

static void print_part(const summary *s, FILE *file) {
    const btg_part_info *p = &s->part;
    fprintf(file, "part        %s: ", s->options->part);
    if (p->patch_count > 0) {
        fprintf(file, "%zu surface%s in %zu patch%s, ", p->surface_count,
                p->surface_count == 1 ? "" : "s", p->patch_count, p->patch_count == 1 ? "" : "es");
    }
    if (p->triangle_count > 0) fprintf(file, "%zu triangles, ", p->triangle_count);
    fprintf(file, "%.6g x %.6g x %.6g mm\n", p->box_max.x - p->box_min.x,
            p->box_max.y - p->box_min.y, p->box_max.z - p->box_min.z);
}

static void print_tool(const btg_tool_def *t, FILE *file) {
    fprintf(file, "tool        %s, major radius %.6g mm, minor radius %.6g mm", profile_word(t),
            t->major_radius_mm, t->minor_radius_mm);
    if (t->shank.radius_mm > 0) {
        fprintf(file, ", shank %.6g mm from %.6g to %.6g mm", t->shank.radius_mm, t->shank.from_mm,
                t->shank.to_mm);
    }
    for (uint32_t i = 0; i < t->holder_count; i++) {
        const btg_cylinder *c = &t->holder[i];
        fprintf(file, ", holder %.6g mm from %.6g to %.6g mm", c->radius_mm, c->from_mm, c->to_mm);
    }
    fprintf(file, "\n");
}

static void print_method(const path_options *o, FILE *file) {
    if (o->points) {
        fprintf(file, "footprint   points of %s\n", o->points);
    } else {
        fprintf(file, "footprint   %s, side step %.6g mm, forward step %.6g mm\n",
                footprint_word(o), o->footprint.side_step_mm, o->footprint.forward_step_mm);
    }
    fprintf(file, "method      %s, tolerance %.6g mm, tilt up to %.6g deg", o->method,
            o->solver.tolerance_mm, o->max_tilt_deg);
    if (o->solver.spin == BTG_SPIN_FIXED) fprintf(file, ", spin %.6g deg", o->spin_deg);
    if (o->solver.spin == BTG_SPIN_GAP) fprintf(file, ", gap %.6g mm", o->solver.gap_mm);
    if (o->solver.spin == BTG_SPIN_ACROSS) fprintf(file, ", contacts across the feed");
    if (o->solver.spin == BTG_SPIN_WIDEST)
        fprintf(file, ", widest strip, scallop %.6g mm", o->solver.scallop_mm);
    fprintf(file, "\n");
}

/* What a method did; nothing for those that count nothing. */
static void print_work(const btg_method_counts *c, FILE *file) {
    double drops = (double)c->drops, tilts = (double)c->tilts;
    if (c->rays > 0)
        fprintf(file, "rays        %.4g a drop or tilt, of the grid\n",
                (double)c->rays / (drops + tilts + (double)c->turned_drops));
    if (c->turned_drops > 0)
        fprintf(file, "bisection   %.4g drops a tilt\n", (double)c->turned_drops / tilts);
    if (c->drop_seeds == 0) return;
    drops -= (double)c->drops_given_up;
    tilts -= (double)c->tilts_given_up;
    fprintf(file,
            "newton      drop: %.4g seeds, %.4g iterations, the last %.4g; %" PRIu64 " given up\n",
            (double)c->drop_seeds / drops, (double)c->drop_iterations / drops,
            (double)c->drop_last_iterations / drops, c->drops_given_up);
    fprintf(file,
            "            tilt: %.4g seeds, %.4g iterations, the last %.4g; %" PRIu64 " given up\n",
            (double)c->tilt_seeds / tilts, (double)c->tilt_iterations / tilts,
            (double)c->tilt_last_iterations / tilts, c->tilts_given_up);
}

static void print_statuses(const summary *s, FILE *file) {
    fprintf(file, "positions   %" PRIu64 "\n", s->positions);
    for (int i = 0; i < SUMMARY_STATUSES; i++) {
        uint64_t n = s->statuses[order[i]];
        if (n > 0) fprintf(file, "            %-14s %10" PRIu64 "\n", btg_status_name(order[i]), n);
    }
    if (s->lifts > 0) fprintf(file, "            %-14s %10" PRIu64 "\n", "lift", s->lifts);
}

static void print_motion(const summary *s, FILE *file) {
    const btg_motion_info *m = &s->motion;
    const path_options *o = s->options;
    const char *label = "motion";
    if (o->chord_mm > 0) {
        fprintf(file,
                "motion      in the part by at most %.3g mm: %" PRIu64
                " positions inserted, %" PRIu64 " hops, %" PRIu64 " retracts; %" PRIu64
                " moments in %.3g s\n",
                m->bound_mm, m->inserted, m->hops, m->retracts, m->moments, s->motion_seconds);
        label = "";
    }
    if (o->max_axis_change_deg > 0) {
        fprintf(file,
                "%-11s axes turn by at most %.6g deg/mm: %" PRIu64
                " positions lean less and lose their second contact\n",
                label, o->max_axis_change_deg, m->leant);
    }
}

static void print_program(const btg_program_info *p, const char *machine, FILE *file) {
    fprintf(file,
            "program     for %s: %" PRIu64 " blocks, %" PRIu64 " inserted, %" PRIu64
            " slowed; %" PRIu64 " retracts, %" PRIu64 " of them rewinds; cuts for %.1f min\n",
            machine, p->blocks, p->inserted, p->slowed, p->retracts, p->rewinds,
            p->cut_seconds / 60);
    if (p->gaps > 0) {
        fprintf(file, "            %" PRIu64 " pieces uncut: their axes are beyond the limits\n",
                p->gaps);
    }
}

void summary_print(const summary *s, FILE *file) {
    const path_options *o = s->options;
    print_part(s, file);
    print_tool(&o->tool, file);
    print_method(o, file);
    print_statuses(s, file);
    if (s->tilted > 0) {
        fprintf(file, "tilt        min %.2f, median %.2f, max %.2f deg\n", s->tilt_min_deg,
                median(s), s->tilt_max_deg);
    }
    if (s->tilted > 0 && (o->solver.spin == BTG_SPIN_GAP || o->solver.spin == BTG_SPIN_ACROSS)) {
        fprintf(file, "spin        met at %" PRIu64 " of %" PRIu64 ", the nearest elsewhere\n",
                s->spin_met, s->tilted);
    }
    fprintf(file, "solved      in %.3g s, %.0f positions/s, by %s on %lu thread%s\n", s->seconds,
            rate(s), s->backend, (unsigned long)s->threads, s->threads == 1 ? "" : "s");
    print_work(&s->counts, file);
    if (s->times.device_s > 0) {
        fprintf(file, "            upload %.3g s, device %.3g s, read back %.3g s, %s %.3g s\n",
                s->times.upload_s, s->times.device_s, s->times.readback_s,
                o->raw ? "not polished:" : "polish and proof", s->times.polish_s);
    }
    if (s->motion.given > 0) print_motion(s, file);
    if (s->program) print_program(s->program, o->machine, file);
    for (int i = 0; i < o->output_count; i++) {
        fprintf(file, "%-11s %s\n", i == 0 ? "wrote" : "", o->outputs[i].path);
    }
}

/* ---- for programs ------------------------------------------------------------------------- */

static void json_part(const summary *s, btg_json *json) {
    const btg_part_info *p = &s->part;
    const double box[6] = {p->box_min.x, p->box_min.y, p->box_min.z,
                           p->box_max.x, p->box_max.y, p->box_max.z};
    btg_json_open(json, "part", '{');
    btg_json_string(json, "file", s->options->part);
    btg_json_count(json, "surfaces", p->surface_count);
    btg_json_count(json, "patches", p->patch_count);
    btg_json_count(json, "triangles", p->triangle_count);
    btg_json_open(json, "box_min_mm", '[');
    for (int i = 0; i < 3; i++)
        btg_json_number(json, NULL, box[i]);
    btg_json_close(json, ']');
    btg_json_open(json, "box_max_mm", '[');
    for (int i = 3; i < 6; i++)
        btg_json_number(json, NULL, box[i]);
    btg_json_close(json, ']');
    btg_json_close(json, '}');
}

static void json_cylinder(btg_json *json, const char *name, const btg_cylinder *c) {
    btg_json_open(json, name, '[');
    btg_json_number(json, NULL, c->radius_mm);
    btg_json_number(json, NULL, c->from_mm);
    btg_json_number(json, NULL, c->to_mm);
    btg_json_close(json, ']');
}

static void json_tool(const btg_tool_def *t, btg_json *json) {
    btg_json_open(json, "tool", '{');
    btg_json_string(json, "profile", profile_word(t));
    btg_json_number(json, "major_radius_mm", t->major_radius_mm);
    btg_json_number(json, "minor_radius_mm", t->minor_radius_mm);
    if (t->shank.radius_mm > 0) json_cylinder(json, "shank", &t->shank);
    btg_json_open(json, "holder", '[');
    for (uint32_t i = 0; i < t->holder_count; i++)
        json_cylinder(json, NULL, &t->holder[i]);
    btg_json_close(json, ']');
    btg_json_close(json, '}');
}

static void json_statuses(const summary *s, btg_json *json) {
    btg_json_open(json, "statuses", '{');
    for (int i = 0; i < SUMMARY_STATUSES; i++) {
        btg_json_count(json, btg_status_name(order[i]), s->statuses[order[i]]);
    }
    btg_json_count(json, "lift", s->lifts);
    btg_json_close(json, '}');
    btg_json_open(json, "tilt_deg", '{');
    btg_json_number(json, "min", s->tilted > 0 ? s->tilt_min_deg : NAN);
    btg_json_number(json, "median", median(s));
    btg_json_number(json, "max", s->tilted > 0 ? s->tilt_max_deg : NAN);
    btg_json_close(json, '}');
}

static void json_motion(const summary *s, btg_json *json) {
    const btg_motion_info *m = &s->motion;
    btg_json_open(json, "motion", '{');
    btg_json_number(json, "chord_tolerance_mm", s->options->chord_mm);
    btg_json_number(json, "max_axis_change_deg_per_mm", s->options->max_axis_change_deg);
    btg_json_number(json, "bound_mm", m->bound_mm);
    btg_json_count(json, "inserted", m->inserted);
    btg_json_count(json, "hops", m->hops);
    btg_json_count(json, "retracts", m->retracts);
    btg_json_count(json, "leant", m->leant);
    btg_json_count(json, "moments", m->moments);
    btg_json_number(json, "seconds", s->motion_seconds);
    btg_json_close(json, '}');
}

static void json_program(const btg_program_info *p, const char *machine, btg_json *json) {
    btg_json_open(json, "program", '{');
    btg_json_string(json, "machine", machine);
    btg_json_count(json, "blocks", p->blocks);
    btg_json_count(json, "inserted", p->inserted);
    btg_json_count(json, "slowed", p->slowed);
    btg_json_count(json, "retracts", p->retracts);
    btg_json_count(json, "rewinds", p->rewinds);
    btg_json_count(json, "gaps", p->gaps);
    btg_json_number(json, "cut_seconds", p->cut_seconds);
    btg_json_close(json, '}');
}

static void json_counts(const btg_method_counts *c, btg_json *json) {
    btg_json_open(json, "work", '{');
    btg_json_count(json, "rays", c->rays);
    btg_json_count(json, "turned_drops", c->turned_drops);
    btg_json_count(json, "drop_seeds", c->drop_seeds);
    btg_json_count(json, "drop_iterations", c->drop_iterations);
    btg_json_count(json, "drops_given_up", c->drops_given_up);
    btg_json_count(json, "tilt_seeds", c->tilt_seeds);
    btg_json_count(json, "tilt_iterations", c->tilt_iterations);
    btg_json_count(json, "tilts_given_up", c->tilts_given_up);
    btg_json_close(json, '}');
}

void summary_json(const summary *s, btg_json *json) {
    const path_options *o = s->options;
    btg_json_string(json, "version", btg_version());
    btg_json_count(json, "positions", s->positions);
    btg_json_number(json, "seconds", s->seconds);
    btg_json_number(json, "positions_per_second", rate(s));
    btg_json_string(json, "backend", s->backend);
    btg_json_string(json, "backend_note", s->note);
    btg_json_open(json, "times", '{');
    btg_json_number(json, "upload_seconds", s->times.upload_s);
    btg_json_number(json, "device_seconds", s->times.device_s);
    btg_json_number(json, "readback_seconds", s->times.readback_s);
    btg_json_number(json, "polish_seconds", s->times.polish_s);
    btg_json_close(json, '}');
    btg_json_string(json, "method", s->options->method);
    json_counts(&s->counts, json);
    btg_json_count(json, "threads", s->threads);
    json_statuses(s, json);
    btg_json_number(json, "tolerance_mm", o->solver.tolerance_mm);
    btg_json_number(json, "max_tilt_deg", o->max_tilt_deg);
    btg_json_string(json, "spin", spin_word(o));
    btg_json_number(json, "spin_deg", o->spin_deg);
    btg_json_count(json, "spin_met", s->spin_met);
    if (o->solver.spin == BTG_SPIN_GAP) btg_json_number(json, "gap_mm", o->solver.gap_mm);
    if (o->solver.spin == BTG_SPIN_WIDEST) {
        btg_json_number(json, "scallop_mm", o->solver.scallop_mm);
    }
    btg_json_number(json, "feed_direction_deg", o->feed_deg);
    btg_json_string(json, "footprint", footprint_word(o));
    json_part(s, json);
    json_tool(&o->tool, json);
    if (s->motion.given > 0) json_motion(s, json);
    if (s->program) json_program(s->program, o->machine, json);
    btg_json_open(json, "files", '[');
    for (int i = 0; i < o->output_count; i++)
        btg_json_string(json, NULL, o->outputs[i].path);
    btg_json_close(json, ']');
}
