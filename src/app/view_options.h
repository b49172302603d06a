/* The command line of `bitangent view`. */
#ifndef BTG_APP_VIEW_OPTIONS_H
#define BTG_APP_VIEW_OPTIONS_H

#include "app/options.h"

#define VIEW_KEYS_MAX 256 /* keys of --keys */
#define VIEW_KEY_SIZE 200 /* characters of one, its end included */

typedef struct view_options {
    path_options path;      /* part, and how a path over it is made */
    bool tool_given;        /* --tool counts more than what the path's file says */
    const char *track;      /* file of a path; NULL: made here */
    const char *screenshot; /* PNG file; NULL: a window */
    int width, height;      /* pixels */
    uint32_t position;      /* from 1; 0: one where there is much to see */
    const char *view_from;  /* NULL: along the tilt */
    bool look_at_part;      /* all of it, not the tool's surroundings */
    char keys[VIEW_KEYS_MAX][VIEW_KEY_SIZE];
    int key_count;
} view_options;

#define VIEW_SIDE_MIN 64
#define VIEW_SIDE_MAX 8192

/* False: a line on stderr says why. Names of keys and views are checked by the caller. */
bool view_options_parse(int count, char **words, view_options *options);

#endif
