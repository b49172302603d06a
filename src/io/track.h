/* Reads tool paths back, one position at a time, whatever their length. Internal to the program. */
#ifndef BTG_IO_TRACK_H
#define BTG_IO_TRACK_H

#include "bitangent/verify.h"
#include "io/row.h"
#include "post/read.h"

#include <stdbool.h>
#include <stdio.h>

#define BTG_TRACK_LINE 4096 /* longest line or APT record, characters */

typedef enum btg_track_kind { BTG_TRACK_CSV, BTG_TRACK_APT, BTG_TRACK_PROGRAM } btg_track_kind;

/* What is to be known before a path is opened. */
typedef struct btg_track_def {
    bool link_all;              /* CSV: the tool also moves from pass to pass */
    bool rows;                  /* CSV: `row` is to tell all that the last line says */
    const btg_machine *machine; /* programs are for; NULL: none is expected */
    double error_mm; /* of a program's motion, as told by poses; of points up to reach_mm from the
                        tip */
    double reach_mm;
} btg_track_def;

typedef struct btg_track {
    const char *path;
    FILE *file;
    btg_track_kind kind;
    btg_track_def def;
    uint64_t line;
    char text[BTG_TRACK_LINE];
    /* CSV */
    int columns, column[12]; /* pass, point, status, tip, axis, row, foot */
    bool numbered;           /* `last` has the numbers of a row */
    uint32_t last_pass, last_point;
    uint64_t last_row;
    bool any_pass;     /* one has ended, */
    uint32_t pass_end; /* the longest by this point's number */
    /* Point numbers left out so far; of APT and programs: moves, when they have ended. */
    uint64_t missing;
    uint32_t missing_pass, missing_point; /* CSV: the first of them */
    int value_column[BTG_ROW_VALUES];
    bool whole; /* every column of ours is there, and passes are straight along y */
    uint32_t passes;
    double first_foot[2], first_end_y, second_foot_x, last_foot_x; /* of the passes */
    char before[BTG_TRACK_LINE];                                   /* the row before */
    uint64_t doubled, doubled_line; /* rows that are that one again; where the first is */
    bool told;                      /* with def.rows, and whole: */
    btg_row row;
    /* APT */
    bool cutter; /* the file says which: */
    double major_radius_mm, minor_radius_mm;
    double scale; /* mm per unit */
    bool ended;
    btg_vec3 axis; /* of the last GOTO: it stays */
    long promised; /* GOTO records, by PPRINT MOVES; -1: it does not say */
    /* programs */
    btg_reader reader;
    uint64_t hasty_line; /* where reader.haste is from */

    btg_verify_pose ahead; /* read while looking for the cutter */
    bool has_ahead;

    bool linked; /* the tool moves from the last position to the next */
} btg_track;

/* Opens a path by its ending, .csv, .cl (.apt) or .ngc (.nc, .mpf, .h), and reads up to the first
 * position. Errors: ERROR_FILE, ERROR_FORMAT, ERROR_UNSUPPORTED (a program that its machine cannot
 * run) with a message: file, line, reason, remedy. */
btg_status btg_track_open(btg_track *track, const btg_track_def *def, const char *path,
                          btg_message *message);
/* *ended: there was none left. Rows without contact are passed over. */
btg_status btg_track_next(btg_track *track, btg_verify_pose *pose, bool *ended,
                          btg_message *message);
/* When all is read: passes that are not there at the end of a path over a part of that extent are
 * missing too, where its feet stand as our straight passes do, from one end of the part to the
 * other with the same overrun on all sides. Elsewhere nothing tells. */
void btg_track_end(btg_track *track, btg_vec3 box_min, btg_vec3 box_max);
void btg_track_close(btg_track *track);

#endif
