/* `bitangent verify`: its command line, and what comes out of it. */
#ifndef BTG_APP_VERIFY_H
#define BTG_APP_VERIFY_H

#include "app/options.h"
#include "bitangent/verify.h"
#include "io/track.h"

typedef enum verify_kind { VERIFY_CSV, VERIFY_PNG, VERIFY_GLB } verify_kind;

typedef struct verify_output {
    verify_kind kind;
    const char *path;
} verify_output;

typedef struct verify_options {
    path_options path; /* part, tool, reading, threads, --json, --quiet, --help */
    const char *track;
    bool tool_given;
    btg_track_def track_def;
    btg_verify_def def;
    double max_gouge_mm, max_scallop_mm; /* INFINITY: no limit */
    verify_output outputs[BTG_OUTPUT_MAX];
    int output_count;
} verify_options;

/* False: a line on stderr says why. */
bool verify_options_parse(int count, char **words, verify_options *options);

typedef struct verify_report {
    const verify_options *options;
    const btg_tool *tool;
    btg_verify_result result;
    uint32_t threads;
    const btg_track *track; /* at its end */
    double seconds;
    bool ok;
} verify_report;

/* No limit is broken, no position is missing, no joint too fast. */
bool verify_ok(const verify_report *report);
void verify_print(const verify_report *report, FILE *file);
void verify_json(const verify_report *report, btg_output *output);

#endif
