/* One line of a tool path: what CSV and JSON both write. Internal to the program. */
#ifndef BTG_IO_ROW_H
#define BTG_IO_ROW_H

#include "bitangent/bitangent.h"

#include <stdbool.h>

typedef struct btg_row {
    uint64_t number; /* of the row, from 1: what is left out of a file shows; 0: not numbered */
    uint32_t pass, point;
    bool lift;    /* a retract: footprint, tip and axis of `position` alone count */
    bool between; /* put between two positions: a solved one, or with `lift` a move over the part;
                     pass and point are those of the row before */
    btg_position position;
} btg_row;

/* Columns after pass, point and status. */
#define BTG_ROW_VALUES 24
extern const char *const btg_row_names[BTG_ROW_VALUES];

/* "lift", or the status' name. */
const char *btg_row_status(const btg_row *row);
/* In the order of btg_row_names; millimetres and degrees; NaN where a value does not exist. */
void btg_row_values(const btg_row *row, double values[BTG_ROW_VALUES]);
/* The other way: what a line's status and values say. Places on the part are not told; bound_mm is
 * NaN. False: no such status. */
bool btg_row_read(btg_row *row, const char *status, const double values[BTG_ROW_VALUES]);

#endif
