#include "io/row.h"
#include "core/vec.h"

#include <string.h>

const char *const btg_row_names[BTG_ROW_VALUES] = {
    "foot_x", "foot_y", "tip_x", "tip_y", "tip_z",  "axis_x",   "axis_y",   "axis_z",
    "p_x",    "p_y",    "p_z",   "np_x",  "np_y",   "np_z",     "q_x",      "q_y",
    "q_z",    "nq_x",   "nq_y",  "nq_z",  "drop_z", "tilt_deg", "spin_deg", "inclination_deg"};

const char *btg_row_status(const btg_row *row) {
    return row->lift ? "lift" : btg_status_name(row->position.status);
}

static double degrees(double radians) {
    return radians * (180 / BTG_PI);
}

void btg_row_values(const btg_row *row, double values[BTG_ROW_VALUES]) {
    const btg_position *p = &row->position;
    const btg_vec3 direction[6] = {p->tip,      p->axis,    p->p.point,
                                   p->p.normal, p->q.point, p->q.normal};
    int n = 0;
    values[n++] = p->foot_x_mm;
    values[n++] = p->foot_y_mm;
    for (int i = 0; i < 6; i++) {
        values[n++] = direction[i].x;
        values[n++] = direction[i].y;
        values[n++] = direction[i].z;
    }
    values[n++] = p->drop_z_mm;
    values[n++] = degrees(p->tilt_rad);
    values[n++] = degrees(p->spin_rad);
    values[n++] = degrees(p->inclination_rad);
    if (!row->lift) return;
    for (int i = 8; i < BTG_ROW_VALUES; i++)
        values[i] = NAN;
}

static bool read_status(btg_row *row, const char *word) {
    row->lift = strcmp(word, "lift") == 0;
    row->position.status = BTG_OK;
    if (row->lift) return true;
    for (int i = BTG_OK; i <= BTG_BUDGET; i++) {
        row->position.status = (btg_status)i;
        if (strcmp(word, btg_status_name(row->position.status)) == 0) return true;
    }
    return false;
}

bool btg_row_read(btg_row *row, const char *status, const double values[BTG_ROW_VALUES]) {
    btg_position *p = &row->position;
    btg_vec3 *const direction[6] = {&p->tip,      &p->axis,    &p->p.point,
                                    &p->p.normal, &p->q.point, &p->q.normal};
    const double radians = BTG_PI / 180;
    int n = 0;
    *p = (btg_position){.bound_mm = NAN};
    if (!read_status(row, status)) return false;
    p->foot_x_mm = values[n++];
    p->foot_y_mm = values[n++];
    for (int i = 0; i < 6; i++, n += 3)
        *direction[i] = vec(values[n], values[n + 1], values[n + 2]);
    p->drop_z_mm = values[n++];
    p->tilt_rad = values[n++] * radians;
    p->spin_rad = values[n++] * radians;
    p->inclination_rad = values[n++] * radians;
    return true;
}
