/* Reads tool paths back, one position at a time, whatever their length. Internal to the program. */
#ifndef BTG_IO_TRACK_H
#define BTG_IO_TRACK_H

#include "bitangent/verify.h"

#include <stdbool.h>
#include <stdio.h>

#define BTG_TRACK_LINE 4096 /* longest line or APT record, characters */

typedef enum btg_track_kind { BTG_TRACK_CSV, BTG_TRACK_APT } btg_track_kind;

typedef struct btg_track {
    const char *path;
    FILE *file;
    btg_track_kind kind;
    bool link_all; /* the tool also moves from pass to pass; set before the first btg_track_next */
    uint64_t line;
    char text[BTG_TRACK_LINE];
    /* CSV */
    int columns, column[9]; /* pass, point, status, tip, axis */
    bool numbered;          /* `last` has the numbers of a row */
    uint32_t last_pass, last_point;
    uint64_t missing;                     /* point numbers left out so far */
    uint32_t missing_pass, missing_point; /* the first of them */
    /* APT */
    bool cutter; /* the file says which: */
    double major_radius_mm, minor_radius_mm;
    double scale; /* mm per unit */
    bool ended;
    btg_verify_pose ahead; /* read while looking for the cutter */
    bool has_ahead;

    bool linked; /* the tool moves from the last position to the next */
} btg_track;

/* Opens a path by its ending, .csv or .cl (.apt), and reads up to the first position. Errors:
 * ERROR_FILE, ERROR_FORMAT with a message: file, line, reason, remedy. */
btg_status btg_track_open(btg_track *track, const char *path, btg_message *message);
/* *ended: there was none left. Rows without contact are passed over. */
btg_status btg_track_next(btg_track *track, btg_verify_pose *pose, bool *ended,
                          btg_message *message);
void btg_track_close(btg_track *track);

#endif
