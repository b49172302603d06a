/* The results of `bitangent bench` as tables, JSON and CSV. */
#define _GNU_SOURCE
#include "app/app.h"
#include "app/bench.h"
#include "app/terminal.h"
#include "app/bench_table.h"
#include "core/part.h"
#include "io/json.h"

#include <string.h>
#include <sys/utsname.h>
#include <unistd.h>

/* "AMD EPYC, 2 cores"; the kind of processor where the system does not tell its name. */
void bench_name_machine(char *name, size_t size) {
    char line[BENCH_MACHINE_SIZE];
    struct utsname system;
    const char *model = uname(&system) == 0 ? system.machine : "unknown";
    FILE *file = fopen("/proc/cpuinfo", "r");
    while (file && fgets(line, sizeof line, file)) {
        char *colon = strchr(line, ':');
        if (strncmp(line, "model name", 10) != 0 || !colon) continue;
        line[strcspn(line, "\n")] = '\0';
        model = colon + 1 + strspn(colon + 1, " ");
        break;
    }
    if (file) fclose(file);
    snprintf(name, size, "%.64s, %ld cores", model, sysconf(_SC_NPROCESSORS_ONLN));
    for (char *c = name; *c; c++)
        if (*c == '"') *c = '\'';
}

/* ---- numbers by name, for JSON and CSV ------------------------------------------------------ */

typedef struct column {
    const char *name;
    double value; /* NaN: none */
} column;

#define COLUMNS 40

static double count_of(size_t n) {
    return n > 0 ? (double)n : NAN;
}

static void columns_of(const bench_row *r, column out[COLUMNS]) {
    const bench_device *d = &r->device;
    const column list[COLUMNS] = {
        {"threads", r->threads},
        {"tolerance_mm", r->tolerance_mm},
        {"degree", count_of((size_t)r->degree)},
        {"triangles", count_of(r->triangles)},
        {"positions", (double)(r->rate.count > 0 ? r->rate.count : r->latency_positions)},
        {"seconds", r->rate.seconds},
        {"positions_per_second", r->rate.median},
        {"positions_per_second_min", r->rate.min},
        {"positions_per_second_max", r->rate.max},
        {"runs", count_of((size_t)r->rate.runs)},
        {"processors", r->rate.processors},
        {"max_error_mm", r->max_error_mm},
        {"limit_mm", r->limit_mm},
        {"nodes", r->ok ? r->nodes : NAN},
        {"ratio", r->ratio},
        {"latency_positions", count_of(r->latency_positions)},
        {"latency_us_p50", r->latency_us.p50},
        {"latency_us_p99", r->latency_us.p99},
        {"latency_us_p999", r->latency_us.p999},
        {"latency_us_max", r->latency_us.max},
        {"nodes_p50", r->latency_nodes.p50},
        {"nodes_p99", r->latency_nodes.p99},
        {"nodes_p999", r->latency_nodes.p999},
        {"nodes_max", r->latency_nodes.max},
        {"build_triangles_per_second", r->ok ? r->build_triangles_per_second : NAN},
        {"bytes_per_triangle", r->ok ? r->bytes_per_triangle : NAN},
        {"upload_seconds", d->upload_s},
        {"device_seconds", d->device_s},
        {"readback_seconds", d->readback_s},
        {"polish_seconds", d->polish_s},
        {"open_seconds", d->open_s},
        {"host_bytes", d->host_bytes},
        {"device_bytes", d->device_bytes},
        {"raw_drop_error_mm", d->raw.drop_mm},
        {"raw_tilt_error_deg", d->raw.tilt_deg},
        {"raw_error_mm", d->raw.whole_mm},
        {"drop_error_mm", d->polished.drop_mm},
        {"tilt_error_deg", d->polished.tilt_deg},
        {"major_radius_mm", NAN},
        {"minor_radius_mm", NAN},
    };
    memcpy(out, list, sizeof list);
}

static void columns_for(const bench_options *o, const bench_row *r, column out[COLUMNS]) {
    columns_of(r, out);
    out[COLUMNS - 2].value = o->path.tool.major_radius_mm;
    out[COLUMNS - 1].value = o->path.tool.minor_radius_mm;
}

/* ---- JSON ---------------------------------------------------------------------------------- */

static void write_left_out(btg_json *json, const bench_rows *rows) {
    btg_json_open(json, "left_out", '[');
    for (size_t i = 0; i < rows->left_out_count; i++) {
        btg_json_open(json, NULL, '{');
        btg_json_string(json, "backend", rows->left_out[i].backend);
        btg_json_string(json, "why", rows->left_out[i].why);
        btg_json_close(json, '}');
    }
    btg_json_close(json, ']');
}

static void write_json(btg_output *out, const bench_options *o, const bench_rows *rows) {
    char machine[BENCH_MACHINE_SIZE];
    bench_name_machine(machine, sizeof machine);
    btg_json json = btg_json_to(out);
    btg_json_open(&json, NULL, '{');
    btg_json_string(&json, "version", btg_version());
    btg_json_string(&json, "machine", machine);
    btg_json_string(&json, "commit", o->commit);
    btg_json_open(&json, "rows", '[');
    for (size_t i = 0; i < rows->count; i++) {
        const bench_row *r = &rows->list[i];
        column columns[COLUMNS];
        columns_for(o, r, columns);
        btg_json_open(&json, NULL, '{');
        btg_json_string(&json, "measure", bench_measure_name[r->measure]);
        btg_json_string(&json, "surface", r->surface);
        btg_json_string(&json, "operation", r->operation);
        btg_json_string(&json, "backend", r->backend);
        btg_json_string(&json, "method", r->method);
        btg_json_bool(&json, "ok", r->ok);
        for (int k = 0; k < COLUMNS; k++)
            btg_json_number(&json, columns[k].name, columns[k].value);
        btg_json_close(&json, '}');
    }
    btg_json_close(&json, ']');
    if (o->measure[BENCH_BACKENDS]) write_left_out(&json, rows);
    btg_json_close(&json, '}');
    btg_output_text(out, "\n");
}

/* ---- CSV ----------------------------------------------------------------------------------- */

/* A field; quoted where it needs to be. */
static void csv_text(btg_output *out, const char *text) {
    bool quoted = strpbrk(text, ",\"\n") != NULL;
    if (quoted) btg_output_text(out, "\"");
    for (const char *c = text; *c; c++) {
        if (*c == '"') btg_output_text(out, "\"");
        btg_output_write(out, c, 1);
    }
    if (quoted) btg_output_text(out, "\"");
}

static void csv_header(btg_output *out) {
    column columns[COLUMNS];
    const bench_row none = {.operation = ""};
    columns_of(&none, columns);
    btg_output_text(out, "machine,commit,version,measure,surface,operation,backend,method,ok");
    for (int k = 0; k < COLUMNS; k++)
        btg_output_format(out, ",%s", columns[k].name);
    btg_output_text(out, "\n");
}

static void write_csv(btg_output *out, const bench_options *o, const bench_rows *rows) {
    char machine[BENCH_MACHINE_SIZE];
    bench_name_machine(machine, sizeof machine);
    csv_header(out);
    for (size_t i = 0; i < rows->count; i++) {
        const bench_row *r = &rows->list[i];
        const char *const texts[8] = {
            machine,    o->commit,    btg_version(), bench_measure_name[r->measure],
            r->surface, r->operation, r->backend,    r->method};
        for (int k = 0; k < 8; k++) {
            csv_text(out, texts[k]);
            btg_output_text(out, ",");
        }
        btg_output_text(out, r->ok ? "yes" : "no");
        column columns[COLUMNS];
        columns_for(o, r, columns);
        for (int k = 0; k < COLUMNS; k++) {
            if (isfinite(columns[k].value)) {
                btg_output_format(out, ",%.6g", columns[k].value);
            } else {
                btg_output_text(out, ",");
            }
        }
        btg_output_text(out, "\n");
    }
}

/* ---- tables -------------------------------------------------------------------------------- */

static const char *const title[BENCH_MEASURES] = {
    "Speed",
    "Latency at random places",
    "Number of triangles",
    "Degree",
    "Threads",
    "Tolerance",
    "Path: each position from its neighbour",
    "Spin searched for: alone, and from its neighbour",
    "Back ends"};

/* Below this part of the processors that a row could use, others took them. */
#define UNDISTURBED 0.95

static void print_note(FILE *file, const bench_row *r) {
    if (!r->ok) {
        fprintf(file, "  WRONG");
    } else if (r->measure == BENCH_TRIANGLES) {
        fprintf(file, "  built at %.3g triangles/s, %.0f bytes a triangle",
                r->build_triangles_per_second, r->bytes_per_triangle);
    } else if (r->measure == BENCH_THREADS) {
        fprintf(file, "  %u thread%s, %.2f times one, same bits", (unsigned)r->threads,
                r->threads > 1 ? "s" : "", r->ratio);
    } else if (r->measure == BENCH_TOLERANCE) {
        fprintf(file, "  to %g mm", r->tolerance_mm);
    } else if (r->measure == BENCH_PATH || r->measure == BENCH_SPIN) {
        fprintf(file, "  %.2f times", r->ratio);
    }
    if (r->rate.processors < UNDISTURBED * r->threads)
        fprintf(file, "  disturbed: had %.2f processors", r->rate.processors);
}

static void print_value(FILE *file, int width, const char *format, double value) {
    char text[32] = "-";
    if (isfinite(value)) {
        if (strcmp(format, "e") == 0) {
            snprintf(text, sizeof text, "%.1e", value);
        } else {
            snprintf(text, sizeof text, value < 99.95 ? "%.1f" : "%.0f", value);
        }
    }
    fprintf(file, " %*s", width, text);
}

static void print_row(FILE *file, const bench_row *r) {
    fprintf(file, "%-16.40s %-13s", r->surface, r->operation);
    if (r->measure == BENCH_LATENCY) {
        const bench_quantiles *q[2] = {&r->latency_us, &r->latency_nodes};
        for (int i = 0; i < 2; i++) {
            print_value(file, 8, "f", q[i]->p50);
            print_value(file, 8, "f", q[i]->p99);
            print_value(file, 8, "f", q[i]->p999);
            print_value(file, 8, "f", q[i]->max);
        }
        fprintf(file, " %9zu", r->latency_positions);
    } else {
        print_value(file, 10, "f", r->rate.min);
        print_value(file, 10, "f", r->rate.median);
        print_value(file, 10, "f", r->rate.max);
        print_value(file, 9, "e", r->max_error_mm);
        print_value(file, 8, "f", r->ok ? r->nodes : NAN);
    }
    print_note(file, r);
    fprintf(file, "\n");
}

static void print_heading(FILE *file, bench_measure measure) {
    fprintf(file, "\n%s\n", title[measure]);
    if (measure == BENCH_LATENCY) {
        fprintf(file, "%-30s %35s %35s\n", "", "us: p50      p99    p99.9      max",
                "nodes: p50      p99    p99.9      max  measured");
        return;
    }
    fprintf(file, "%-30s %10s %10s %10s %9s %8s\n", "", "min/s", "median/s", "max/s", "error, mm",
            "nodes");
}

static void print_tables(FILE *file, const bench_options *o, const bench_rows *rows) {
    char machine[BENCH_MACHINE_SIZE];
    bench_name_machine(machine, sizeof machine);
    const btg_tool_def *t = &o->path.tool;
    fprintf(file, "bitangent %s on %s\n", btg_version(), machine);
    fprintf(file, "tool %g/%g %s; tolerance %g mm and one thread where nothing else is said\n",
            t->major_radius_mm, t->minor_radius_mm,
            t->profile == BTG_PROFILE_TOROIDAL ? "toroidal" : "bullnose",
            o->path.solver.tolerance_mm);
    fprintf(file, "drop: three axes, one contact; position: drop and tilt; %d runs of %.2g s\n",
            bench_runs(o), bench_slice(o));
    for (int m = 0; m < BENCH_BACKENDS; m++) {
        bool any = false;
        for (size_t i = 0; i < rows->count; i++) {
            if (rows->list[i].measure != (bench_measure)m) continue;
            if (!any) print_heading(file, (bench_measure)m);
            any = true;
            print_row(file, &rows->list[i]);
        }
    }
    if (o->measure[BENCH_BACKENDS]) bench_table_print(file, rows);
}

/* ---- all of it ----------------------------------------------------------------------------- */

static btg_status save_csv(const bench_options *o, const bench_rows *rows, btg_output *csv,
                           btg_message *message) {
    write_csv(csv, o, rows);
    btg_status status = btg_output_finish(csv, message);
    return status == BTG_OK ? btg_output_commit(csv, message) : status;
}

static btg_status save_png(const bench_rows *rows, btg_output *png, btg_message *message) {
    char machine[BENCH_MACHINE_SIZE];
    bench_name_machine(machine, sizeof machine);
    return bench_table_picture(rows, machine, png, message);
}

int bench_report(const bench_options *o, const bench_rows *rows, btg_output *csv, btg_output *png) {
    btg_message message;
    btg_status status = o->csv ? save_csv(o, rows, csv, &message) : BTG_OK;
    if (o->png && status == BTG_OK) status = save_png(rows, png, &message);
    bool taken = o->csv && csv->standard;
    btg_output out = btg_output_borrow(taken ? stderr : stdout);
    if (o->path.json) {
        write_json(&out, o, rows);
    } else if (!o->path.quiet) {
        terminal table;
        terminal_open(&table, out.file);
        print_tables(table.file, o, rows);
        terminal_close(&table);
    }
    btg_status shown = status == BTG_OK ? btg_output_finish(&out, &message) : status;
    if (shown == BTG_OK) return APP_DONE;
    return app_complain(APP_FAILED, "%s", message.text);
}
