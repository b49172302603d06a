#include "app/papers.h"
#include "app/app.h"
#include "app/progress.h"
#include "core/footprint.h"
#include "core/part.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

const char *const papers_surface[PAPERS_SURFACES] = {"convex", "concave", "saddle"};

/* ---- rows and notes ----------------------------------------------------------------------- */

/* Room for one more; NULL: no memory. */
static void *grow(void *list, size_t count, size_t *capacity, size_t size) {
    if (count < *capacity) return list;
    size_t more = *capacity ? 2 * *capacity : 64;
    void *larger = realloc(list, more * size);
    if (larger) *capacity = more;
    return larger;
}

papers_row *papers_add(papers *p, const char *table, const char *unit, double value, double paper) {
    static papers_row lost; /* written to when memory is out; the run then fails */
    papers_row *rows = grow(p->rows, p->row_count, &p->row_capacity, sizeof *rows);
    if (!rows) {
        p->short_of_memory = true;
        return &lost;
    }
    p->rows = rows;
    rows[p->row_count] = (papers_row){
        .table = table, .unit = unit, .value = value, .paper = paper, .exact = {NAN, NAN}};
    return &rows[p->row_count++];
}

void papers_name(papers_row *row, const char *item, const char *format, ...) {
    va_list list;
    snprintf(row->item, sizeof row->item, "%s", item);
    va_start(list, format);
    vsnprintf(row->quantity, sizeof row->quantity, format, list);
    va_end(list);
}

void papers_note_add(papers *p, const char *table, const char *format, ...) {
    papers_note *notes = grow(p->notes, p->note_count, &p->note_capacity, sizeof *notes);
    va_list list;
    if (!notes) {
        p->short_of_memory = true;
        return;
    }
    p->notes = notes;
    notes[p->note_count].table = table;
    va_start(list, format);
    vsnprintf(notes[p->note_count].text, sizeof notes->text, format, list);
    va_end(list);
    p->note_count++;
}

void papers_show(const papers *p, const char *what) {
    if (p->shown) fprintf(stderr, "\r\033[K%s", what);
}

btg_status papers_chart(papers *p, const char *name, const char *title,
                        const btg_chart_panel *panels, size_t count, size_t columns) {
    static const char *const ending[2] = {"png", "svg"};
    char path[1024];
    for (int i = 0; i < 2 && p->options->pictures; i++) {
        int size = snprintf(path, sizeof path, "%s/%s.%s", p->options->pictures, name, ending[i]);
        if (size >= (int)sizeof path)
            return btg_fail(&p->message, BTG_ERROR_FILE,
                            "--pictures: the folder's name is too "
                            "long; give a shorter one");
        btg_status status = btg_chart_write(path, title, panels, count, columns, &p->message);
        if (status != BTG_OK) return status;
    }
    return BTG_OK;
}

/* ---- positions ---------------------------------------------------------------------------- */

double *papers_footprint(size_t stride, size_t *count) {
    btg_footprint_def def = btg_footprint_def_default();
    btg_footprint_layout layout;
    def.x_max_mm = def.y_max_mm = 150;
    if (btg_footprint_plan(&def, &layout, NULL) != BTG_OK) return NULL;
    *count = (layout.total + stride - 1) / stride;
    double *xy = malloc(2 * *count * sizeof *xy);
    for (size_t i = 0; i < *count && xy; i++) {
        btg_footprint_point at = btg_footprint_at(&layout, i * stride);
        xy[2 * i] = at.x_mm;
        xy[2 * i + 1] = at.y_mm;
    }
    return xy;
}

btg_method_def papers_method(const char *name) {
    btg_method_def def = btg_method_def_default();
    def.name = name;
    def.backend.threads = 1; /* as the papers' programs */
    return def;
}

btg_status papers_solve(papers *p, int surface, const btg_method_def *def,
                        const btg_solver_def *solver, const double *xy, size_t count,
                        btg_position *out, double *seconds, btg_method_counts *counts) {
    btg_method *m = NULL;
    btg_status status = btg_method_open(def, p->part[surface], &p->tool, solver, &m, &p->message);
    if (status != BTG_OK) return status;
    double begin = app_seconds();
    status = btg_backend_positions(btg_method_front(m), xy, count, out, NULL);
    if (seconds) *seconds = app_seconds() - begin;
    if (counts) *counts = btg_method_get_counts(m);
    btg_method_close(m);
    if (status >= 0) return BTG_OK;
    return btg_fail(&p->message, status, "method %s: failed on %s (%s)", def->name,
                    papers_surface[surface], btg_status_name(status));
}

double papers_gap(const btg_position *position) {
    if (position->status == BTG_OSCULATING) return 0;
    if (position->status != BTG_OK) return NAN;
    return vec_norm(vec_sub(position->q.point, position->p.point));
}

/* ---- all of it ---------------------------------------------------------------------------- */

static btg_status open_all(papers *p) {
    btg_status status = btg_tool_init(&p->options->path.tool, &p->tool, &p->message);
    for (int i = 0; i < PAPERS_SURFACES && status == BTG_OK; i++) {
        bench_subject subject;
        status = bench_subject_paper(&subject, i, &p->message);
        if (status == BTG_OK) p->part[i] = subject.part;
    }
    return status;
}

static void close_all(papers *p) {
    for (int i = 0; i < PAPERS_SURFACES; i++)
        btg_part_destroy(p->part[i]);
    free(p->rows);
    free(p->notes);
}

int papers_run(const bench_options *options, btg_output *csv) {
    papers p = {.options = options, .solver = options->path.solver, .quick = options->quick};
    btg_status (*const make[])(papers *) = {papers_vcrf, papers_gpu, papers_dst, papers_spin};
    double begin = app_seconds();
    p.shown = !options->path.quiet && isatty(STDERR_FILENO);
    btg_status status = open_all(&p);
    for (int i = 0; i < 4 && status >= 0; i++)
        status = make[i](&p);
    if (status >= 0 && p.short_of_memory)
        status = btg_fail(&p.message, BTG_ERROR_MEMORY, "bench: out of memory");
    p.seconds = app_seconds() - begin;
    papers_show(&p, "");
    int code =
        status < 0 ? app_complain(app_code(status), "%s", p.message.text) : papers_report(&p, csv);
    close_all(&p);
    return code;
}
