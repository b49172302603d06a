/* The papers' tables as text, JSON and CSV. */
#include "app/app.h"
#include "app/papers.h"
#include "io/json.h"

#include <math.h>
#include <string.h>

#define LINE 98

/* Ours over theirs. */
static double ratio(const papers_row *r) {
    return r->paper > 0 ? r->value / r->paper : NAN;
}

static bool begins(const papers *p, size_t i) {
    return i == 0 || strcmp(p->rows[i].table, p->rows[i - 1].table) != 0;
}

/* ---- for people --------------------------------------------------------------------------- */

static void print_number(FILE *file, double value) {
    if (isnan(value))
        fprintf(file, " %10s", "");
    else
        fprintf(file, " %10.4g", value);
}

/* Words of a note, in lines. */
static void print_wrapped(FILE *file, const char *text) {
    size_t column = 0;
    while (*text) {
        size_t word = strcspn(text, " ");
        if (column > 0 && column + word + 1 > LINE) {
            fprintf(file, "\n");
            column = 0;
        }
        fprintf(file, column == 0 ? "  %.*s" : " %.*s", (int)word, text);
        column += word + 1;
        text += word + (text[word] == ' ');
    }
    fprintf(file, "\n");
}

static void print_notes(const papers *p, FILE *file, const char *of) {
    for (size_t i = 0; i < p->note_count; i++)
        if (strcmp(p->notes[i].table, of) == 0) print_wrapped(file, p->notes[i].text);
}

static void print_head(FILE *file, const papers_row *r) {
    bool exact = !isnan(r->exact[0]);
    fprintf(file, "\n%s\n%-26s %-34s %-3s %10s %10s %10s%s\n", r->table, "", "", "", "here",
            "paper", "ratio", exact ? "  grid-exact  drd-exact" : "");
}

static void print_text(const papers *p, FILE *file) {
    for (size_t i = 0; i < p->row_count; i++) {
        const papers_row *r = &p->rows[i];
        if (begins(p, i)) print_head(file, r);
        bool again = !begins(p, i) && strcmp(r->item, r[-1].item) == 0;
        fprintf(file, "%-26s %-34s %-3s", again ? "" : r->item, r->quantity, r->unit);
        print_number(file, r->value);
        print_number(file, r->paper);
        print_number(file, ratio(r));
        if (!isnan(r->exact[0])) fprintf(file, "  %10.4g %10.4g", r->exact[0], r->exact[1]);
        fprintf(file, "\n");
        if (i + 1 == p->row_count || begins(p, i + 1)) print_notes(p, file, r->table);
    }
    fprintf(file, "\nall of it in %.0f s\n", p->seconds);
}

/* ---- for programs ------------------------------------------------------------------------- */

static void json_row(btg_json *json, const papers_row *r) {
    btg_json_open(json, NULL, '{');
    btg_json_string(json, "table", r->table);
    btg_json_string(json, "item", r->item);
    btg_json_string(json, "quantity", r->quantity);
    btg_json_string(json, "unit", r->unit);
    btg_json_number(json, "value", r->value);
    btg_json_number(json, "paper", r->paper);
    btg_json_number(json, "ratio", ratio(r));
    if (!isnan(r->exact[0])) {
        btg_json_number(json, "vcrf_grid_to_exact", r->exact[0]);
        btg_json_number(json, "drd_to_exact", r->exact[1]);
    }
    btg_json_close(json, '}');
}

static void print_json(const papers *p, btg_output *out) {
    char machine[BENCH_MACHINE_SIZE];
    btg_json json = btg_json_to(out);
    bench_name_machine(machine, sizeof machine);
    btg_json_open(&json, NULL, '{');
    btg_json_string(&json, "version", btg_version());
    btg_json_string(&json, "machine", machine);
    btg_json_number(&json, "seconds", p->seconds);
    btg_json_open(&json, "papers", '[');
    for (size_t i = 0; i < p->row_count; i++)
        json_row(&json, &p->rows[i]);
    btg_json_close(&json, ']');
    btg_json_open(&json, "notes", '[');
    for (size_t i = 0; i < p->note_count; i++) {
        btg_json_open(&json, NULL, '{');
        btg_json_string(&json, "table", p->notes[i].table);
        btg_json_string(&json, "text", p->notes[i].text);
        btg_json_close(&json, '}');
    }
    btg_json_close(&json, ']');
    btg_json_close(&json, '}');
    btg_output_text(out, "\n");
}

static void csv_number(btg_output *csv, double value) {
    if (isnan(value))
        btg_output_text(csv, ",");
    else
        btg_output_format(csv, ",%.9g", value);
}

static void write_csv(const papers *p, btg_output *csv) {
    btg_output_text(csv, "table,item,quantity,unit,value,paper,ratio,vcrf_grid_to_exact,"
                         "drd_to_exact\n");
    for (size_t i = 0; i < p->row_count; i++) {
        const papers_row *r = &p->rows[i];
        btg_output_format(csv, "\"%s\",\"%s\",\"%s\",\"%s\"", r->table, r->item, r->quantity,
                          r->unit);
        csv_number(csv, r->value);
        csv_number(csv, r->paper);
        csv_number(csv, ratio(r));
        csv_number(csv, r->exact[0]);
        csv_number(csv, r->exact[1]);
        btg_output_text(csv, "\n");
    }
}

/* ---- all of it ---------------------------------------------------------------------------- */

int papers_report(const papers *p, btg_output *csv) {
    const bench_options *o = p->options;
    btg_message message;
    bool standard = o->csv && strcmp(o->csv, "-") == 0;
    btg_output out = btg_output_borrow(standard ? stderr : stdout);
    btg_status status = BTG_OK;
    if (o->csv) {
        write_csv(p, csv);
        status = btg_output_finish(csv, &message);
        if (status == BTG_OK) status = btg_output_commit(csv, &message);
    }
    if (o->path.json)
        print_json(p, &out);
    else if (!o->path.quiet)
        print_text(p, out.file);
    if (status == BTG_OK) status = btg_output_finish(&out, &message);
    return status == BTG_OK ? APP_DONE : app_complain(APP_FAILED, "%s", message.text);
}
