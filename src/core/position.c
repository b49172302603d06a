/* Whole positions out of DROP and TILT: the frames between them, and what comes out.
 *
 * Spin keeps the first contact: the frame turns about nP, so that the tool's centre stands in
 * another direction from P (S. K. Sharma et al., "Numerical implementation of drop spin and tilt
 * method for five-axis tool positioning for tensor product surfaces"; the tilt is closed form
 * here). A spun tool may cut where it was dropped, so it is laid over first, to LAID_OVER, and
 * tilts down from there. */
#include "core/run.h"
#include "core/spin.h"

#include <stddef.h>

#define LAID_OVER (BTG_PI / 2)
/* A first contact this near the axis or inside the flat's rim (part of a radius) is on it. */
#define ON_RIM 1e-9

btg_drop_query btg_position_drop_query(double foot_x_mm, double foot_y_mm) {
    return (btg_drop_query){.origin = vec(foot_x_mm, foot_y_mm, 0), .axis = vec(0, 0, 1)};
}

static btg_vec3 drop_centre(const btg_drop_query *query, const btg_drop_result *drop) {
    return vec_mad(query->origin, query->axis, drop->height_mm);
}

static double inclination(btg_vec3 v, btg_vec3 w, btg_vec3 n) {
    return atan2(vec_dot(n, v), vec_dot(n, w));
}

/* The frame at the pseudo-insert of a drop; false when there is no tilt about it. */
static bool insert_frame(const btg_tool *tool, const btg_drop_query *query,
                         const btg_drop_result *drop, btg_tilt_query *frame) {
    const btg_tool_element *e = &tool->element[0];
    if (drop->status != BTG_OK || drop->element != 0) return false;
    double ro = e->ring_radius_mm, ri = e->corner_radius_mm;
    btg_vec3 centre = drop_centre(query, drop);
    btg_vec3 arm = vec_sub(drop->contact.point, centre);
    btg_vec3 radial = vec_mad(arm, query->axis, -vec_dot(arm, query->axis));
    double r = vec_norm(radial);
    if (ro <= 0 || r <= ON_RIM * (ro + ri)) return false;
    if (!e->hollow && r < ro * (1 - ON_RIM)) return false;
    radial = vec_scale(radial, 1 / r);
    frame->w = query->axis;
    frame->v = vec_scale(radial, -1);
    frame->u = vec_cross(frame->v, frame->w);
    frame->o1 = vec_mad(centre, radial, ro);
    frame->p = drop->contact;
    if (ri > 0) {
        frame->p.normal = vec_unit(vec_sub(frame->o1, frame->p.point));
    } else { /* the normal's part along the rim is rounding */
        btg_vec3 n = frame->p.normal;
        frame->o1 = frame->p.point;
        frame->p.normal = vec_unit(vec_mad(n, frame->u, -vec_dot(n, frame->u)));
    }
    return true;
}

static void spin_frame(double alpha, btg_tilt_query *frame) {
    btg_vec3 n = frame->p.normal;
    double dropped = inclination(frame->v, frame->w, n);
    btg_vec3 e0 = vec_cross(n, frame->u);
    btg_vec3 e = vec_add(vec_scale(e0, cos(alpha)), vec_scale(vec_cross(n, e0), sin(alpha)));
    e = vec_unit(vec_mad(e, n, -vec_dot(e, n)));
    frame->u = vec_cross(e, n);
    frame->v = vec_add(vec_scale(e, cos(LAID_OVER)), vec_scale(n, sin(LAID_OVER)));
    frame->w = vec_sub(vec_scale(n, cos(LAID_OVER)), vec_scale(e, sin(LAID_OVER)));
    frame->max_tilt_rad += LAID_OVER - dropped;
    if (frame->max_tilt_rad > BTG_PI) frame->max_tilt_rad = BTG_PI;
    if (frame->max_tilt_rad < 0) frame->max_tilt_rad = 0;
}

void btg_position_spin(double alpha, btg_tilt_query *frame) {
    if (alpha != 0) spin_frame(alpha, frame);
}

btg_status btg_position_tilt_query(const btg_tool *tool, const btg_solver_def *solver,
                                   const btg_drop_query *query, const btg_drop_result *drop,
                                   btg_tilt_query *tilt) {
    if (!tool || !solver || !query || !drop || !tilt) return BTG_ERROR_ARGUMENT;
    btg_tilt_query frame = {.max_tilt_rad = solver->max_tilt_rad};
    if (!insert_frame(tool, query, drop, &frame)) return BTG_SINGLE_CONTACT;
    if (solver->spin == BTG_SPIN_FIXED) spin_frame(solver->spin_rad, &frame);
    *tilt = frame;
    return BTG_OK;
}

static void set_nothing(btg_position *p) {
    btg_contact none = {.point = vec_nan(), .normal = vec_nan()};
    p->status = BTG_NO_CONTACT;
    p->tip = p->axis = vec_nan();
    p->p = p->q = none;
    p->drop_z_mm = p->tilt_rad = p->spin_rad = p->inclination_rad = p->bound_mm = NAN;
}

static void set_pose(btg_position *p, const btg_tool *tool, btg_vec3 centre, btg_vec3 axis) {
    p->axis = axis;
    p->tip = vec_mad(centre, axis, -tool->element[0].corner_radius_mm);
}

/* As dropped: one contact. */
static void set_dropped(btg_position *p, const btg_tool *tool, const btg_drop_query *query,
                        const btg_drop_result *drop) {
    btg_vec3 centre = drop_centre(query, drop), n = drop->contact.normal;
    set_pose(p, tool, centre, query->axis);
    p->status = drop->status == BTG_BUDGET ? BTG_BUDGET : BTG_SINGLE_CONTACT;
    p->p = drop->contact;
    p->q = (btg_contact){.point = vec_nan(), .normal = vec_nan()};
    p->drop_z_mm = centre.z;
    p->bound_mm = drop->bound_mm;
    p->tilt_rad = 0;
    if (drop->status == BTG_BUDGET) { /* somewhere above the part */
        p->p = p->q;
        p->inclination_rad = NAN;
        return;
    }
    btg_vec3 arm = vec_sub(p->p.point, centre);
    btg_vec3 v = vec_unit(vec_mad(arm, query->axis, -vec_dot(arm, query->axis)));
    p->inclination_rad = inclination(vec_scale(v, -1), query->axis, n);
}

/* Turned down by beta: the arm v, from o1 to the axis, and the axis w. */
static void turn_down(const btg_tilt_query *frame, double beta, btg_vec3 *v, btg_vec3 *w) {
    double c = cos(beta), s = sin(beta);
    *v = vec_unit(vec_sub(vec_scale(frame->v, c), vec_scale(frame->w, s)));
    *w = vec_unit(vec_add(vec_scale(frame->w, c), vec_scale(frame->v, s)));
}

void btg_position_pose(const btg_tool *tool, const btg_tilt_query *frame, double beta,
                       btg_vec3 *centre, btg_vec3 *axis) {
    btg_vec3 v;
    turn_down(frame, beta, &v, axis);
    *centre = vec_mad(frame->o1, v, tool->element[0].ring_radius_mm);
}

static void set_tilted(btg_position *p, const btg_tool *tool, const btg_tilt_query *frame,
                       double beta, double dropped) {
    btg_vec3 v, w;
    turn_down(frame, beta, &v, &w);
    set_pose(p, tool, vec_mad(frame->o1, v, tool->element[0].ring_radius_mm), w);
    p->p = frame->p;
    p->inclination_rad = inclination(v, w, frame->p.normal);
    double tilt = dropped - p->inclination_rad;
    p->tilt_rad = tilt > 0 ? tilt : 0;
}

btg_status btg_position_assemble(const btg_tool *tool, const btg_solver_def *solver,
                                 double foot_x_mm, double foot_y_mm, const btg_drop_query *query,
                                 const btg_drop_result *drop, const btg_tilt_query *frame,
                                 const btg_tilt_result *tilt, btg_position *position) {
    if (!tool || !solver || !query || !drop || !position || (tilt && !frame))
        return BTG_ERROR_ARGUMENT;
    if (drop->status < 0) return drop->status;
    btg_position p = {.foot_x_mm = foot_x_mm, .foot_y_mm = foot_y_mm};
    if (drop->status == BTG_NO_CONTACT) {
        set_nothing(&p);
        *position = p;
        return p.status;
    }
    set_dropped(&p, tool, query, drop);
    bool spun = solver->spin == BTG_SPIN_FIXED;
    p.spin_met = solver->spin == BTG_SPIN_NONE;
    if (tilt && tilt->status < 0 && tilt->status != BTG_ERROR_GOUGE) return tilt->status;
    /* A spun tool that is not free even laid over, or not known to be, stays unspun, as dropped. */
    bool usable = tilt && tilt->status >= 0 && (spun || tilt->status != BTG_SINGLE_CONTACT);
    if (spun && usable && tilt->status == BTG_BUDGET && tilt->tilt_rad <= 0) {
        usable = false;
        p.status = BTG_BUDGET;
    }
    if (usable) {
        double dropped = p.inclination_rad, beta = tilt->tilt_rad;
        if (tilt->status == BTG_SINGLE_CONTACT) beta -= solver->max_tilt_rad;
        set_tilted(&p, tool, frame, beta > 0 ? beta : 0, dropped);
        p.spin_rad = spun ? solver->spin_rad : 0;
        p.status = tilt->status;
        p.bound_mm = tilt->bound_mm;
        p.spin_met = 1;
        if (!spun) p.tilt_rad = beta;
        if (tilt->status == BTG_OK || tilt->status == BTG_OSCULATING) p.q = tilt->contact;
    }
    *position = p;
    return p.status;
}

/* ---- the whole position ------------------------------------------------------------------- */

/* A neighbour's contact as the place to start from. */
static int start_at(const btg_contact *contact, btg_place *start) {
    if (!vec_finite(contact->point)) return 0;
    *start = contact->place;
    return 1;
}

btg_status btg_position_solve(const btg_part *part, const btg_tool *tool,
                              const btg_solver_def *solver, double foot_x_mm, double foot_y_mm,
                              void *workspace, size_t workspace_size, btg_position *position) {
    return btg_position_follow(part, tool, solver, foot_x_mm, foot_y_mm, NULL, workspace,
                               workspace_size, position);
}

/* The search's state stands behind what btg_tilt uses of the workspace: it is too much for the
 * stack of a control. */
static size_t search_offset(const btg_part *part) {
    size_t align = _Alignof(max_align_t);
    return (btg_workspace_size(part) + align - 1) / align * align;
}

size_t btg_position_workspace_size(const btg_part *part) {
    return search_offset(part) + sizeof(btg_spin_search);
}

/* The calls of a position are made from small frames: they take what there is to take. */
static BTG_APART btg_status search_spin(const btg_part *part, const btg_tool *tool,
                                        const btg_solver_def *solver, const btg_position *neighbour,
                                        void *workspace, btg_position *position) {
    btg_position_parts *p = btg_workspace_parts(part, workspace);
    size_t offset = search_offset(part);
    btg_spin_search *search = (btg_spin_search *)((char *)workspace + offset);
    bool follows = neighbour && vec_finite(neighbour->q.point);
    btg_spin_begin(search, part, tool, solver, &p->frame, follows ? neighbour->spin_rad : NAN);
    if (follows) search->has_q = true, search->q = neighbour->q.place;
    while (btg_spin_next(search, &p->frame)) {
        p->tilt = (btg_tilt_result){0};
        bool guess = search->may_guess;
        btg_status status =
            guess ? btg_tilt_near(part, tool, solver, &p->frame, workspace, offset, &p->tilt)
                  : btg_tilt(part, tool, solver, &p->frame, workspace, offset, &p->tilt);
        if (status < 0 && status != BTG_ERROR_GOUGE) return status;
        if (status < 0) p->tilt.status = status;
        btg_spin_take(search, &p->frame, &p->tilt, guess);
    }
    btg_vec3 foot = p->query.origin;
    return btg_spin_finish(search, foot.x, foot.y, &p->query, &p->drop, position);
}

static BTG_APART void set_query(double foot_x_mm, double foot_y_mm, const btg_position *neighbour,
                                btg_drop_query *query) {
    *query = btg_position_drop_query(foot_x_mm, foot_y_mm);
    if (neighbour) query->has_start = start_at(&neighbour->p, &query->start);
}

btg_status btg_position_follow(const btg_part *part, const btg_tool *tool,
                               const btg_solver_def *solver, double foot_x_mm, double foot_y_mm,
                               const btg_position *neighbour, void *workspace,
                               size_t workspace_size, btg_position *position) {
    if (!position || !part || !solver) return BTG_ERROR_ARGUMENT;
    bool searches = btg_spin_searches(solver);
    if (searches && workspace_size < btg_position_workspace_size(part)) return BTG_ERROR_ARGUMENT;
    if (!workspace || workspace_size < btg_workspace_size(part)) return BTG_ERROR_ARGUMENT;
    btg_position_parts *p = btg_workspace_parts(part, workspace);
    set_query(foot_x_mm, foot_y_mm, neighbour, &p->query);
    btg_status status =
        btg_drop(part, tool, solver, &p->query, workspace, workspace_size, &p->drop);
    if (status < 0) return status;
    bool tilts = btg_position_tilt_query(tool, solver, &p->query, &p->drop, &p->frame) == BTG_OK;
    if (tilts && searches) return search_spin(part, tool, solver, neighbour, workspace, position);
    if (tilts) {
        if (neighbour) p->frame.has_start = start_at(&neighbour->q, &p->frame.start);
        status = btg_tilt(part, tool, solver, &p->frame, workspace, workspace_size, &p->tilt);
        if (status < 0 && status != BTG_ERROR_GOUGE) return status;
        if (status == BTG_ERROR_GOUGE) tilts = false;
    }
    return btg_position_assemble(tool, solver, foot_x_mm, foot_y_mm, &p->query, &p->drop,
                                 tilts ? &p->frame : NULL, tilts ? &p->tilt : NULL, position);
}
