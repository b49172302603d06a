/* Is this input usable? Asked once, by the front, for all back ends. Internal. */
#ifndef BTG_BACKEND_CHECK_H
#define BTG_BACKEND_CHECK_H

#include "bitangent/bitangent.h"

#include <stdbool.h>

/* Limits as in bitangent.h; the message names the entry. */
btg_status btg_check_solver(const btg_solver_def *solver, btg_message *message);

/* Finite, within BTG_LENGTH_MAX; the axis is unit. */
bool btg_check_drop(const btg_drop_query *query);
/* The same; {u, v, w} right-handed and unit, and p a place of the part. */
bool btg_check_tilt(const btg_tilt_query *query, const btg_part_info *info);
bool btg_check_foot(double x_mm, double y_mm);

#endif
