#include "core/check.h"
#include "core/part.h"

/* How far from unit or from a right angle a direction may be: a thousand times the rounding of
 * any sane way to make one, and at BTG_LENGTH_MAX still below the smallest tolerance. */
#define UNIT_TOLERANCE 1e-9

/* A pose may stand off the part by the tool's own size and more. */
#define REACH 10

/* P may be off the insert by that, for rounding at large offsets; and its normal off the plane. */
#define ON_INSERT_MM 1e-6

#define TOLERANCE_MIN_MM 1e-9
#define TOLERANCE_MAX_MM 1.0
/* Beyond this many turns an angle has lost digits. */
#define SPIN_MAX_RAD 1e6
/* More than any cut is meant to leave. */
#define SCALLOP_MAX_MM 100.0

static btg_status check_spin(const btg_solver_def *solver, btg_message *message) {
    if (!(solver->spin >= BTG_SPIN_NONE && solver->spin <= BTG_SPIN_WIDEST)) {
        return btg_fail(message, BTG_ERROR_ARGUMENT, "solver: unknown spin");
    }
    if (!(fabs(solver->spin_rad) <= SPIN_MAX_RAD)) {
        return btg_fail(message, BTG_ERROR_ARGUMENT, "solver: the spin is %g rad; give an angle",
                        solver->spin_rad);
    }
    if (solver->spin == BTG_SPIN_GAP && !(solver->gap_mm > 0 && solver->gap_mm <= BTG_LENGTH_MAX)) {
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "solver: the gap of the contacts is %g mm; give more than 0",
                        solver->gap_mm);
    }
    if (!isfinite(solver->feed_x) || !isfinite(solver->feed_y)) {
        return btg_fail(message, BTG_ERROR_ARGUMENT, "solver: the feed direction is not finite");
    }
    if (!(solver->scallop_mm >= 0 && solver->scallop_mm <= SCALLOP_MAX_MM)) {
        return btg_fail(message, BTG_ERROR_ARGUMENT, "solver: the scallop is %g mm; give 0 to %g",
                        solver->scallop_mm, SCALLOP_MAX_MM);
    }
    return BTG_OK;
}

btg_status btg_check_solver(const btg_solver_def *solver, btg_message *message) {
    if (solver->version != btg_solver_def_default().version) {
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "solver: unknown version; start from btg_solver_def_default()");
    }
    if (!(solver->tolerance_mm >= TOLERANCE_MIN_MM && solver->tolerance_mm <= TOLERANCE_MAX_MM)) {
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "solver: the tolerance is %g mm; give %g to %g", solver->tolerance_mm,
                        TOLERANCE_MIN_MM, TOLERANCE_MAX_MM);
    }
    if (!(solver->max_tilt_rad >= 0 && solver->max_tilt_rad <= BTG_PI / 2)) {
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "solver: the largest tilt is %g rad; give 0 to pi / 2",
                        solver->max_tilt_rad);
    }
    if (solver->node_budget < 1) {
        return btg_fail(message, BTG_ERROR_ARGUMENT, "solver: the node budget is 0; give more");
    }
    return check_spin(solver, message);
}

static bool length(double x) {
    return fabs(x) <= REACH * BTG_LENGTH_MAX;
}

static bool place(btg_vec3 p) {
    return length(p.x) && length(p.y) && length(p.z);
}

static bool unit(btg_vec3 a) {
    return fabs(vec_norm2(a) - 1) <= 2 * UNIT_TOLERANCE;
}

static bool on_part(btg_place p, const btg_part_info *info) {
    if (!(p.u >= 0 && p.u <= 1 && p.v >= 0 && p.v <= 1)) return false;
    if (p.item < info->patch_count) return true;
    return p.item - info->patch_count < info->triangle_count && p.u + p.v <= 1 + UNIT_TOLERANCE;
}

bool btg_check_drop(const btg_drop_query *query, const btg_part_info *info) {
    return place(query->origin) && unit(query->axis) &&
           (!query->has_start || on_part(query->start, info));
}

bool btg_check_place(btg_place place, const btg_part_info *info) {
    return on_part(place, info);
}

/* The point that the insert, and the normal at it, say is P. */
static bool on_insert(const btg_tilt_query *q, const btg_tool *tool) {
    double minor = tool->element[0].corner_radius_mm;
    btg_vec3 off = vec_sub(vec_mad(q->o1, q->p.normal, -minor), q->p.point);
    return vec_norm(off) <= ON_INSERT_MM * (1 + minor) &&
           fabs(vec_dot(q->p.normal, q->u)) <= ON_INSERT_MM;
}

bool btg_check_tilt(const btg_tilt_query *query, const btg_tool *tool, const btg_part_info *info) {
    if (!unit(query->u) || !unit(query->v) || !unit(query->w) || !unit(query->p.normal)) {
        return false;
    }
    btg_vec3 skew = vec_sub(vec_cross(query->u, query->v), query->w);
    if (!(vec_norm(skew) <= 4 * UNIT_TOLERANCE)) return false;
    if (!place(query->o1) || !place(query->p.point)) return false;
    if (!(query->max_tilt_rad >= 0 && query->max_tilt_rad <= BTG_PI)) return false;
    if (query->has_start && !on_part(query->start, info)) return false;
    return on_insert(query, tool) && on_part(query->p.place, info);
}

bool btg_check_foot(double x_mm, double y_mm) {
    return length(x_mm) && length(y_mm);
}
