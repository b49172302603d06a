/* The tool path as CSV: a header, then one line a position, numbers in full double precision
 * (%.17g), `nan` where a value does not exist. Internal to the program. */
#ifndef BTG_IO_CSV_H
#define BTG_IO_CSV_H

#include "io/output.h"
#include "io/row.h"

/* `numbered`: rows have numbers, in a last column. */
void btg_csv_header(btg_output *output, bool numbered);
void btg_csv_row(btg_output *output, const btg_row *row);

#endif
