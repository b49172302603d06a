/* The command line of `bitangent path`. */
#ifndef BTG_APP_OPTIONS_H
#define BTG_APP_OPTIONS_H

#include "bitangent/gltf.h"
#include "io/output.h"

typedef enum output_kind {
    OUTPUT_CSV,
    OUTPUT_JSON,
    OUTPUT_CL,
    OUTPUT_PNG,
    OUTPUT_NGC,
    OUTPUT_GLB,
    OUTPUT_HTML
} output_kind;

typedef struct output_choice {
    output_kind kind;
    const char *path;
} output_choice;

typedef struct path_options {
    bool help; /* help was asked for: nothing else counts */
    const char *part;
    output_choice outputs[BTG_OUTPUT_MAX];
    int output_count;

    btg_tool_def tool;
    btg_footprint_def footprint; /* the rectangle is filled in later */
    const char *points;          /* file of footprint points, or NULL */
    bool contour;                /* passes along the part's outline instead */
    bool side_of_scallop;        /* the side step is to be that of the solver's scallop */
    double overrun_mm;           /* of the footprint beyond the part's extent */
    double lift_mm;              /* clearance of retracts over the part's top */
    double feed_mm_per_min;
    const char *machine;   /* a built-in one's name, or a file; NULL without .ngc */
    double tool_length_mm; /* NaN: as the machine says */
    double spindle_rpm;
    double motion_tolerance_mm; /* between positions */
    uint32_t tool_number;
    double chord_mm;            /* deepest in the part between positions; 0: not looked at */
    double max_axis_change_deg; /* per mm of the footprint; 0: any */

    const char *method;
    double ray_spacing_mm; /* of the methods that fire rays from a grid */
    int levels;            /* of grids and of depth buffers */
    uint32_t window;       /* pixels of a depth buffer's side; 0: as the method likes */
    const char *backend;
    uint32_t threads; /* 0: as many as there are */
    btg_solver_def solver;
    double spin_deg, max_tilt_deg; /* as typed, for the summary */
    bool machine_tilt;             /* the tilt's limit is the machine's */
    double feed_deg;               /* from +x toward +y; the footprint's passes run along 90 */
    btg_gltf_def gltf;
    bool raw; /* a device's answers as they are */
    const char *gl_context;
    bool json, quiet;
} path_options;

/* Rows may come between the footprint's, whose points' numbers are not theirs: rows get numbers. */
static inline bool path_inserts(const path_options *o) {
    return o->chord_mm > 0 || o->max_axis_change_deg > 0;
}

/* What holds where nothing is given. */
void options_default(path_options *options);
/* False: a line on stderr says why. */
bool options_parse(int count, char **words, path_options *options);

/* One option (options_set.c): its name, and what takes its value (NULL for those without). */
typedef struct option {
    const char *name;
    bool (*set)(path_options *options, const char *name, const char *value);
    bool flag; /* takes no value */
} option;

extern const option path_option_list[];
extern const size_t path_option_count;

/* What a command that lends itself options of `bitangent path` is asked for by one word. */
typedef struct option_word {
    const option *path; /* lent; NULL: the command's own, number `own` */
    size_t own;
    const char *name, *value; /* value: NULL for those without */
} option_word;

/* The word at *i, and the next where that is its value. `own_name`: of the command's own options by
 * number, NULL after the last; `lent`: the command takes that option of `bitangent path`. False: a
 * line on stderr says why. */
bool options_word(const char *command, const char *(*own_name)(size_t number),
                  bool (*lent)(const char *name), int count, char **words, int *i,
                  option_word *word);
/* A word that is no option: the part, then the path. False: a line on stderr says why. */
bool options_part_and_path(const char *command, const char *word, path_options *options,
                           const char **track);

#endif
