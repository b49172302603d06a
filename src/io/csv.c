#include "io/csv.h"

#include <math.h>

/* Longest line: 24 numbers of at most 24 characters and their commas, three short words. */
#define LINE_SIZE 1024

void btg_csv_header(btg_output *output, bool numbered) {
    btg_output_text(output, "pass,point,status");
    for (int i = 0; i < BTG_ROW_VALUES; i++) {
        btg_output_text(output, ",");
        btg_output_text(output, btg_row_names[i]);
    }
    btg_output_text(output, numbered ? ",row\n" : "\n");
}

void btg_csv_row(btg_output *output, const btg_row *row) {
    double values[BTG_ROW_VALUES];
    char line[LINE_SIZE];
    btg_row_values(row, values);
    int n = snprintf(line, sizeof line, "%lu,%lu,%s", (unsigned long)row->pass,
                     (unsigned long)row->point, btg_row_status(row));
    for (int i = 0; i < BTG_ROW_VALUES; i++) {
        size_t room = sizeof line - (size_t)n;
        /* The sign of a NaN, which printf shows, means nothing. */
        n += isnan(values[i]) ? snprintf(line + n, room, ",nan")
                              : snprintf(line + n, room, ",%.17g", values[i]);
    }
    size_t room = sizeof line - (size_t)n;
    if (row->number > 0) n += snprintf(line + n, room, ",%llu", (unsigned long long)row->number);
    line[n++] = '\n';
    btg_output_write(output, line, (size_t)n);
}
