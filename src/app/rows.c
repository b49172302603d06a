#include "app/rows.h"
#include "app/app.h"
#include "core/vec.h"

static bool touches(const btg_position *p) {
    return p->status >= 0 && p->status != BTG_NO_CONTACT;
}

static void give(rows *r, btg_row *row, bool linked) {
    if (r->motion) row->number = ++r->given;
    summary_add(r->summary, row);
    sinks_row(r->sinks, row, linked);
}

/* ---- lifts -------------------------------------------------------------------------------- */

/* `near`: the position that the lift belongs to. */
static void lift(rows *r, btg_footprint_point point, const btg_position *near) {
    btg_row row = {.pass = point.pass, .point = point.point, .lift = true};
    btg_position *p = &row.position;
    *p = (btg_position){.foot_x_mm = point.x_mm, .foot_y_mm = point.y_mm};
    p->tip = vec(point.x_mm, point.y_mm, r->clear_z_mm);
    p->axis = vec(0, 0, 1);
    if (touches(near)) {
        double z = btg_post_lift_z(r->tool, near->axis, r->clear_z_mm);
        p->axis = near->axis;
        p->tip = vec(near->tip.x, near->tip.y, fmax(z, near->tip.z));
    }
    give(r, &row, false);
}

/* The footprint's lifts up to its next point; `coming` is the position there, NULL at the end. */
static void lifts(rows *r, const btg_position *coming) {
    while (r->next < r->feet->total) {
        btg_footprint_point point = feet_at(r->feet, r->next);
        if (!point.lift) return;
        bool after = !coming || (r->any && r->at.pass == point.pass);
        lift(r, point, after ? &r->last : coming);
        r->next++;
    }
}

/* ---- positions ---------------------------------------------------------------------------- */

/* A move was left out: the tool is lifted off the last position, and comes down on this one. */
static void retract(rows *r, btg_footprint_point point, const btg_position *p) {
    lift(r, r->at, &r->last);
    lift(r, point, p);
}

static void take_given(rows *r, const btg_motion_stop *stop) {
    const btg_position *p = &stop->position;
    lifts(r, p);
    btg_footprint_point point = feet_at(r->feet, r->next++);
    bool wanted = r->any && feet_linked(r->feet, point);
    if (wanted && !stop->link && touches(p) && touches(&r->last)) retract(r, point, p);
    r->any = true;
    r->last = *p;
    r->at = point;
    btg_row row = {.pass = point.pass, .point = point.point, .position = *p};
    give(r, &row, stop->link != 0);
}

static void take(const btg_motion_stop *stop, void *user) {
    rows *r = user;
    if (stop->kind == BTG_MOTION_GIVEN) {
        take_given(r, stop);
        return;
    }
    bool hop = stop->kind == BTG_MOTION_HOP;
    btg_row row = {.pass = r->at.pass, .point = r->at.point, .between = true, .lift = hop};
    row.position = stop->position;
    if (!stop->link) retract(r, r->at, &stop->position);
    if (!hop) r->last = stop->position;
    give(r, &row, stop->link != 0);
}

btg_status rows_open(rows *r, const path_options *o, btg_backend *backend, btg_message *message) {
    if (!path_inserts(o)) return BTG_OK;
    btg_motion_def def = btg_motion_def_default();
    def.tolerance_mm = o->chord_mm;
    def.turn_rad_per_mm = o->max_axis_change_deg * (BTG_PI / 180);
    def.clear_z_mm = r->clear_z_mm;
    def.give = take;
    def.user = r;
    return btg_motion_create(&def, backend, r->tool, &r->motion, message);
}

btg_status rows_add(rows *r, btg_footprint_point point, const btg_position *position) {
    bool linked = r->added > 0 && feet_linked(r->feet, point);
    btg_motion_stop stop = {.position = *position, .index = r->added++, .link = linked};
    if (!r->motion) {
        take_given(r, &stop);
        return BTG_OK;
    }
    double begin = app_seconds();
    btg_status status = btg_motion_add(r->motion, position, linked);
    r->summary->motion_seconds += app_seconds() - begin;
    return status;
}

btg_status rows_end(rows *r) {
    if (r->motion) {
        double begin = app_seconds();
        btg_status status = btg_motion_end(r->motion, &r->summary->motion);
        r->summary->motion_seconds += app_seconds() - begin;
        if (status < 0) return status;
    }
    lifts(r, NULL);
    return BTG_OK;
}

void rows_close(rows *r) {
    btg_motion_destroy(r->motion);
    r->motion = NULL;
}
