/* Is this input usable? Asked by the run calls, and once a batch by the back ends' front. Internal.
 */
#ifndef BTG_CORE_CHECK_H
#define BTG_CORE_CHECK_H

#include "bitangent/bitangent.h"

#include <stdbool.h>

/* Limits as in bitangent.h; the message names the entry. */
btg_status btg_check_solver(const btg_solver_def *solver, btg_message *message);

/* Finite, within BTG_LENGTH_MAX; the axis is unit. */
bool btg_check_drop(const btg_drop_query *query, const btg_part_info *info);
/* The same; {u, v, w} right-handed and unit, p a place of the part and its point on the insert. */
bool btg_check_tilt(const btg_tilt_query *query, const btg_tool *tool, const btg_part_info *info);
/* A place of the part. */
bool btg_check_place(btg_place place, const btg_part_info *info);
bool btg_check_foot(double x_mm, double y_mm);

#endif
