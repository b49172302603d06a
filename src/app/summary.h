/* What came out of a run, for people (a table) and for programs (a JSON object). */
#ifndef BTG_APP_SUMMARY_H
#define BTG_APP_SUMMARY_H

#include "app/options.h"
#include "bitangent/motion.h"
#include "bitangent/post.h"
#include "io/json.h"
#include "methods/method.h"

#include <stdio.h>

/* Resolution of the median tilt, which is counted in bins: 0.01 degrees. */
#define TILT_BINS_PER_DEGREE 100
#define TILT_BINS            (90 * TILT_BINS_PER_DEGREE + 1)

#define SUMMARY_STATUSES 5 /* BTG_OK to BTG_BUDGET */

typedef struct summary {
    const path_options *options;
    btg_part_info part;
    const char *backend;
    const char *note; /* what kept another back end from running; "": nothing */
    uint32_t threads;
    double seconds; /* solving alone */
    btg_backend_times times;
    btg_method_counts counts;
    uint64_t positions, lifts;
    uint64_t statuses[SUMMARY_STATUSES]; /* by btg_status */
    uint64_t tilted;                     /* positions with two contacts, osculating ones included */
    uint64_t spin_met;                   /* of those, with the spin that was asked for */
    double tilt_min_deg, tilt_max_deg;
    uint64_t tilt_bins[TILT_BINS];
    btg_motion_info motion; /* of the way between positions, where it was looked at */
    double motion_seconds;
    const btg_program_info *program; /* of the .ngc file; NULL: none */
} summary;

void summary_add(summary *s, const btg_row *row);
/* At least one position touches the part. */
bool summary_contact(const summary *s);
void summary_print(const summary *s, FILE *file);
/* The members of an object that is open. */
void summary_json(const summary *s, btg_json *json);

#endif
