/* The files a path goes to: each takes every row, and all appear together at the end. */
#ifndef BTG_APP_SINK_H
#define BTG_APP_SINK_H

#include "app/summary.h"
#include "bitangent/post.h"
#include "io/picture.h"
#include "io/scene.h"

typedef struct sink {
    output_kind kind;
    btg_output output;
    btg_json json;
    btg_apt apt;
    btg_program *program;
    btg_status status;   /* of the program; the first error stays, */
    btg_message message; /* and what is to be said about it */
    btg_program_info info;
    btg_picture picture;
    btg_scene scene;
} sink;

typedef struct sinks { /* stays where it is while open */
    sink list[BTG_OUTPUT_MAX];
    int count;
    bool standard;        /* one of them is the standard output */
    const btg_part *part; /* for pictures and reports */
    const btg_tool *tool;
    double clear_z_mm;
} sinks;

/* Opens all or none; part and tool are to outlive them. Errors: ERROR_FILE; ERROR_ARGUMENT when
 * path and --json both want the standard output. */
btg_status sinks_open(sinks *s, const path_options *options, const btg_part *part,
                      const btg_tool *tool, double clear_z_mm, btg_message *message);
/* Write errors latch until sinks_check. */
void sinks_row(sinks *s, const btg_row *row, bool linked);
btg_status sinks_check(const sinks *s, btg_message *message);
/* Ends the files and gives them their names. */
btg_status sinks_end(sinks *s, const summary *result, btg_message *message);
/* What the first program says of itself; NULL where there is none. */
const btg_program_info *sinks_program(const sinks *s);
/* Leaves nothing behind but what sinks_end has named. */
void sinks_close(sinks *s);

#endif
