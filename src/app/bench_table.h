/* The back ends beside each other. Internal to `bitangent bench`. */
#ifndef BTG_APP_BENCH_TABLE_H
#define BTG_APP_BENCH_TABLE_H

#include "app/bench.h"

void bench_table_print(FILE *file, const bench_rows *rows);
/* Writes the file and gives it its name. */
btg_status bench_table_picture(const bench_rows *rows, const char *machine, btg_output *png,
                               btg_message *message);

#endif
