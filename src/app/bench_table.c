/* The back ends beside each other: as text, and as a picture. */
#include "app/bench_table.h"
#include "core/part.h"
#include "io/picture_backends.h"

#include <string.h>

static bool first_of(const bench_row *r) {
    return r->measure == BENCH_BACKENDS && strcmp(r->operation, "position") == 0;
}

/* The large batch of the same back end and part. */
static const bench_row *many_of(const bench_rows *rows, const bench_row *first) {
    for (size_t i = 0; i < rows->count; i++) {
        const bench_row *r = &rows->list[i];
        if (r->measure == BENCH_BACKENDS && strcmp(r->operation, "many") == 0 &&
            strcmp(r->backend, first->backend) == 0 && strcmp(r->surface, first->surface) == 0)
            return r;
    }
    return NULL;
}

static double memory_of(const bench_device *d) {
    return d->host_bytes + (isfinite(d->device_bytes) ? d->device_bytes : 0);
}

/* ---- text --------------------------------------------------------------------------------- */

static void cell(FILE *file, int width, const char *format, double value) {
    char text[32] = "-";
    if (isfinite(value)) snprintf(text, sizeof text, format, value);
    fprintf(file, " %*s", width, text);
}

static void print_speed(FILE *file, const bench_row *r) {
    const bench_device *d = &r->device;
    fprintf(file, "%-10s %-14.14s", r->backend, r->surface);
    if (!r->ok) {
        fprintf(file, "  WRONG: off by %.3g mm\n", r->max_error_mm);
        return;
    }
    cell(file, 7, "%.0f", (double)r->threads);
    cell(file, 10, "%.0f", (double)r->rate.count);
    cell(file, 10, "%.4g", r->rate.seconds);
    cell(file, 10, "%.0f", r->rate.median);
    cell(file, 9, "%.2g", d->upload_s);
    cell(file, 9, "%.3g", d->device_s);
    cell(file, 9, "%.2g", d->readback_s);
    cell(file, 9, "%.3g", d->polish_s);
    fprintf(file, "\n");
}

static void print_errors(FILE *file, const bench_row *r) {
    const bench_device *d = &r->device;
    fprintf(file, "%-10s %-14.14s", r->backend, r->surface);
    cell(file, 10, "%.1e", d->raw.drop_mm);
    cell(file, 10, "%.1e", d->raw.tilt_deg);
    cell(file, 10, "%.1e", d->raw.whole_mm);
    cell(file, 9, "%.1e", d->polished.drop_mm);
    cell(file, 9, "%.1e", d->polished.tilt_deg);
    cell(file, 9, "%.1e", d->polished.whole_mm);
    cell(file, 9, "%.3g", memory_of(d) / (1 << 20));
    cell(file, 9, "%.3g", d->open_s);
    fprintf(file, "\n");
}

void bench_table_print(FILE *file, const bench_rows *rows) {
    fprintf(file, "\nBack ends: five-axis positions\n%25s %7s %10s %10s %10s %9s %9s %9s %9s\n", "",
            "threads", "positions", "seconds", "a second", "upload, s", "device", "read back",
            "polish");
    for (size_t i = 0; i < rows->count; i++)
        if (rows->list[i].measure == BENCH_BACKENDS) print_speed(file, &rows->list[i]);
    fprintf(file, "\n%25s %32s %29s\n%25s %10s %10s %10s %9s %9s %9s %9s %9s\n", "",
            "greatest error, as found", "as answered", "", "drop, mm", "tilt, deg", "all, mm",
            "drop, mm", "tilt, deg", "all, mm", "MB", "open, s");
    for (size_t i = 0; i < rows->count; i++)
        if (first_of(&rows->list[i])) print_errors(file, &rows->list[i]);
    for (size_t i = 0; i < rows->left_out_count; i++)
        fprintf(file, "%s%s left out: %s\n", i == 0 ? "\n" : "", rows->left_out[i].backend,
                rows->left_out[i].why);
}

/* ---- picture ------------------------------------------------------------------------------ */

static btg_picture_backend bars_of(const bench_rows *rows, const bench_row *first) {
    const bench_row *many = many_of(rows, first);
    const bench_device *d = &first->device, *m = many ? &many->device : d;
    btg_picture_backend b = {.name = first->backend, .bytes = memory_of(d)};
    b.per_second[0] = first->rate.median;
    b.per_second[1] = many ? many->rate.median : NAN;
    const double phase[BTG_PICTURE_PHASES] = {m->upload_s, m->device_s, m->readback_s, m->polish_s};
    memcpy(b.phase, phase, sizeof phase);
    b.raw_mm[0] = d->raw.drop_mm;
    b.raw_mm[1] = d->raw.whole_mm;
    b.polished_mm[0] = d->polished.drop_mm;
    b.polished_mm[1] = d->polished.whole_mm;
    return b;
}

btg_status bench_table_picture(const bench_rows *rows, const char *machine, btg_output *png,
                               btg_message *message) {
    btg_picture_backend list[BENCH_LEFT_OUT_MAX];
    size_t count = 0;
    char title[256] = "", small[64] = "", large[64] = "up to 100000 positions";
    for (size_t i = 0; i < rows->count && count < BENCH_LEFT_OUT_MAX; i++) {
        const bench_row *r = &rows->list[i];
        if (!first_of(r)) continue;
        const bench_row *many = many_of(rows, r);
        snprintf(title, sizeof title, "%s on %s", r->surface, machine);
        snprintf(small, sizeof small, "%zu positions", r->rate.count);
        if (count == 0 && many)
            snprintf(large, sizeof large, "up to %zu positions", many->rate.count);
        list[count++] = bars_of(rows, r);
    }
    const char *const batches[2] = {small, large};
    btg_status status = btg_picture_backends(list, count, title, batches, png, message);
    if (status == BTG_OK) status = btg_output_finish(png, message);
    return status == BTG_OK ? btg_output_commit(png, message) : status;
}
