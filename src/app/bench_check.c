/* Answers before they are timed: against the reference back end, or against every triangle. */
#include "app/bench.h"
#include "bitangent/backend.h"
#include "core/part.h"

#include <stdlib.h>
#include <string.h>

/* A number that is none counts as wrong. */
static double worst(double a, double b) {
    return b <= a ? a : b < INFINITY ? b : INFINITY;
}

/* The pseudo-insert's centre and axis of a position as dropped. */
static bool insert_of(const btg_tool *tool, const btg_position *p, btg_vec3 *o1, btg_vec3 *u) {
    btg_vec3 centre = vec(p->foot_x_mm, p->foot_y_mm, p->drop_z_mm);
    btg_vec3 arm = vec_sub(centre, p->p.point);
    arm.z = 0;
    btg_vec3 v = vec_unit(arm);
    *o1 = vec_mad(centre, v, -tool->def.major_radius_mm);
    *u = vec_cross(v, vec(0, 0, 1));
    return vec_norm2(v) > 0 && vec_finite(*o1);
}

/* How fast the second contact comes nearer when the tool turns, mm a radian; where both contacts
 * are one, that of the insert. */
static double lever(const btg_tool *tool, const btg_position *p) {
    btg_vec3 o1, u;
    if (p->status == BTG_OSCULATING) return tool->def.minor_radius_mm;
    if (p->status != BTG_OK || !insert_of(tool, p, &o1, &u)) return 0;
    return fabs(vec_dot(vec_cross(u, vec_sub(p->q.point, o1)), p->q.normal));
}

static double turned(const btg_solver_def *solver, const btg_position *p) {
    return p->status == BTG_SINGLE_CONTACT ? solver->max_tilt_rad : p->tilt_rad;
}

double bench_difference(const btg_tool *tool, const btg_solver_def *solver, const btg_position *a,
                        const btg_position *b) {
    bool none = a->status == BTG_NO_CONTACT;
    if (none != (b->status == BTG_NO_CONTACT)) return INFINITY;
    if (none) return 0;
    double drop = fabs(a->drop_z_mm - b->drop_z_mm);
    double arm = fmin(lever(tool, a), lever(tool, b));
    /* One of them alone has a second contact: that one says what the turn means. */
    if (arm == 0) arm = fmax(lever(tool, a), lever(tool, b));
    double turn = fabs(turned(solver, a) - turned(solver, b));
    return worst(worst(0, drop), arm * turn);
}

/* ---- the same bits ------------------------------------------------------------------------- */

static size_t put_contact(double *out, const btg_contact *c) {
    const double values[9] = {c->place.item, c->place.u,  c->place.v,  c->point.x, c->point.y,
                              c->point.z,    c->normal.x, c->normal.y, c->normal.z};
    memcpy(out, values, sizeof values);
    return 9;
}

bool bench_identical(const btg_position *a, const btg_position *b) {
    double bits[2][32] = {{0}};
    const btg_position *both[2] = {a, b};
    for (int i = 0; i < 2; i++) {
        const btg_position *p = both[i];
        const double values[14] = {p->status,          p->tip.x,     p->tip.y,    p->tip.z,
                                   p->axis.x,          p->axis.y,    p->axis.z,   p->foot_x_mm,
                                   p->foot_y_mm,       p->drop_z_mm, p->tilt_rad, p->spin_rad,
                                   p->inclination_rad, p->bound_mm};
        memcpy(bits[i], values, sizeof values);
        size_t n = 14 + put_contact(bits[i] + 14, &p->p);
        put_contact(bits[i] + n, &p->q);
    }
    return memcmp(bits[0], bits[1], sizeof bits[0]) == 0;
}

/* ---- checks -------------------------------------------------------------------------------- */

static btg_status solve(const bench_subject *s, const btg_tool *tool, const btg_solver_def *solver,
                        size_t count, btg_position *positions) {
    size_t size = btg_workspace_size(s->part);
    void *workspace = malloc(size);
    btg_status status = workspace ? BTG_OK : BTG_ERROR_MEMORY;
    for (size_t i = 0; i < count && status >= 0; i++) {
        const double *xy = s->feet + 2 * i;
        status =
            btg_position_solve(s->part, tool, solver, xy[0], xy[1], workspace, size, &positions[i]);
    }
    free(workspace);
    return status < 0 ? status : BTG_OK;
}

/* How far the contacts are from the cutter as it is finally placed: what puts answers together is
 * not the reference's own. */
static double off_tool(const btg_tool *tool, const btg_position *p) {
    double major = tool->def.major_radius_mm, minor = tool->def.minor_radius_mm, error = 0;
    btg_vec3 centre = vec_mad(p->tip, p->axis, minor);
    for (int i = 0; i < 2; i++) {
        if (i == 1 && p->status != BTG_OK && p->status != BTG_OSCULATING) break;
        btg_vec3 arm = vec_sub(i == 0 ? p->p.point : p->q.point, centre);
        double height = vec_dot(arm, p->axis);
        double beyond = vec_norm(vec_mad(arm, p->axis, -height)) - major;
        if (tool->def.profile == BTG_PROFILE_BULLNOSE) beyond = fmax(beyond, 0);
        error = worst(error, fabs(hypot(beyond, height) - minor));
    }
    return error;
}

static btg_status by_reference(const bench_subject *s, const btg_tool *tool,
                               const btg_solver_def *solver, size_t count, btg_position *positions,
                               bench_error *error, btg_message *message) {
    btg_position *others = positions + count;
    btg_backend *backend = NULL;
    btg_backend_def def = btg_backend_def_default();
    def.name = "reference";
    def.threads = 1;
    btg_status status = btg_backend_open(&def, s->part, tool, solver, &backend, message);
    if (status != BTG_OK) return status;
    status = btg_backend_positions(backend, s->feet, count, others, NULL);
    btg_backend_close(backend);
    if (status < 0) return btg_fail(message, status, "%s: the reference fails", s->name);
    for (size_t i = 0; i < count; i++) {
        double drop = fabs(positions[i].drop_z_mm - others[i].drop_z_mm);
        double whole = bench_difference(tool, solver, &positions[i], &others[i]);
        bool touches = positions[i].status != BTG_NO_CONTACT && positions[i].status != BTG_BUDGET;
        if (touches) whole = worst(whole, off_tool(tool, &positions[i]));
        if (!(drop < INFINITY)) drop = whole; /* NaN: neither touches, or one of them alone */
        error->drop_mm = worst(error->drop_mm, drop);
        error->position_mm = worst(error->position_mm, whole);
    }
    return BTG_OK;
}

static void by_triangles(const bench_subject *s, const btg_tool *tool, const btg_solver_def *solver,
                         size_t count, const btg_position *positions, bench_error *error) {
    for (size_t i = 0; i < count; i++) {
        bench_error e = bench_brute_error(&s->mesh, tool, solver, &positions[i]);
        error->drop_mm = worst(error->drop_mm, e.drop_mm);
        error->position_mm = worst(error->position_mm, e.position_mm);
    }
}

btg_status bench_check(const bench_subject *s, const btg_tool *tool, const btg_solver_def *solver,
                       size_t count, bench_error *error, btg_message *message) {
    if (count > s->foot_count) count = s->foot_count;
    btg_position *positions = calloc(2 * count, sizeof *positions);
    if (!positions) return btg_fail(message, BTG_ERROR_MEMORY, "bench: out of memory");
    *error = (bench_error){0, 0};
    btg_status status = solve(s, tool, solver, count, positions);
    if (status < 0) {
        btg_fail(message, status, "%s: no answer (%s)", s->name, btg_status_name(status));
    } else if (s->mesh.triangle_count > 0) {
        by_triangles(s, tool, solver, count, positions, error);
    } else {
        status = by_reference(s, tool, solver, count, positions, error, message);
    }
    free(positions);
    return status;
}
