/* The motion between positions: more of them where the tool would cut into the part on its way
 * from one to the next, and axes that turn no faster than asked.
 *
 * Positions go in one by one, in order, and come out in order with what was put between them. The
 * tool moves as machines move it: the tip on a straight line, the axis from one direction to the
 * other in their plane. That motion is looked at in moments so close that the cutter at them misses
 * little of the swept one, and at each of them DROP along the tool's axis bounds how deep it is in
 * the part. Where that is more than the tolerance:
 * - the position over the footprint point half-way is solved, and both halves are looked at;
 * - where feet as close as closest_mm do not help (the second contact jumps, or the tool falls from
 *   a wall) the tool backs out along its axis at one, goes over, and down the other's axis: a hop;
 * - where no hop below clear_z_mm is clear the move is left out: the stop is not linked, and
 * whoever writes the path retracts.
 *
 * Axes turn no faster than asked where positions lean less: P stays, and all leans between none and
 * that of the second contact are clear; the second contact is lost. */
#ifndef BITANGENT_MOTION_H
#define BITANGENT_MOTION_H

#include "bitangent/backend.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum btg_motion_kind {
    BTG_MOTION_GIVEN = 0,    /* a position that was added */
    BTG_MOTION_INSERTED = 1, /* one solved between two of them */
    BTG_MOTION_HOP = 2       /* of a hop: its tip and axis alone count */
} btg_motion_kind;

typedef struct btg_motion_stop {
    btg_position position;
    btg_motion_kind kind;
    uint64_t index; /* from 0: the position added it is, or that it comes after */
    int link;       /* 1: the tool moves here from the stop before */
} btg_motion_stop;

typedef struct btg_motion_def {
    uint32_t version;
    double tolerance_mm; /* no deeper in the part than this on the way; 1e-6 .. 1, default 0.005; 0:
                            the way is not looked at */
    double closest_mm;   /* feet are put no closer; > 0, default 0.02 */
    double clear_z_mm;   /* tips up here are clear; no default */
    double turn_rad_per_mm; /* most that the axis may turn, by the way of the footprint; > 0; 0
                               (default): as it comes. Positions without spin alone lean less */
    void (*give)(const btg_motion_stop *stop, void *user); /* called in order */
    void *user;
    btg_allocator allocator;
} btg_motion_def;

BTG_API btg_motion_def btg_motion_def_default(void);

typedef struct btg_motion_info {
    uint64_t given, inserted; /* positions */
    uint64_t hops, retracts;  /* moves taken over the part, and left out */
    uint64_t leant;   /* positions that lean less than their second contact would let them */
    uint64_t moments; /* DROPs that looked at the way */
    double bound_mm;  /* proven: the cutter is nowhere deeper on any linked move; NaN: not
                         looked at, or the back end proves nothing */
} btg_motion_info;

/* Thread-safety: one thread at a time. Real-time: no. With turn_rad_per_mm memory grows with the
 * longest linked run of positions; else it is bounded. */
typedef struct btg_motion btg_motion;

/* `backend` solves and looks; it must outlive this, and `tool` be the one it was opened with.
 * Errors: ERROR_ARGUMENT, ERROR_MEMORY. */
BTG_API btg_status btg_motion_create(const btg_motion_def *def, btg_backend *backend,
                                     const btg_tool *tool, btg_motion **motion,
                                     btg_message *message);
BTG_API void btg_motion_destroy(btg_motion *motion); /* NULL is fine */

/* The next position; `link`: the tool is to come to it from the one before. Those without contact
 * pass through, and the tool neither comes to nor from them. Errors: ERROR_MEMORY, and those of the
 * back end; what is then still held is lost. */
BTG_API btg_status btg_motion_add(btg_motion *motion, const btg_position *position, int link);
/* Gives all that is held. Nothing can be added after. */
BTG_API btg_status btg_motion_end(btg_motion *motion, btg_motion_info *info);

#ifdef __cplusplus
}
#endif
#endif
