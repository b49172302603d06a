/* The report on a path: one page for a browser, with all it needs inside. report.c writes the page
 * and what is known of the path, report_check.c verifies it, report_backends.c asks the other back
 * ends, report_joints.c follows the machine; the page itself is under report/. */
#ifndef BTG_APP_REPORT_H
#define BTG_APP_REPORT_H

#include "app/summary.h"
#include "io/scene.h"

/* More positions make a page that no browser likes. */
#define REPORT_STOPS_MAX 200000

typedef struct report {
    const btg_scene *scene;
    const btg_part *part;
    const btg_tool *tool;
    const summary *summary; /* its options have a machine where joints are wanted */
    double clear_z_mm;      /* of retracts */
} report;

/* ERROR_ARGUMENT (too many positions), ERROR_MEMORY, ERROR_FILE, and what a machine refuses. */
btg_status report_write(const report *r, btg_output *output, btg_message *message);

/* An array as base64; little-endian, as it lies in memory. */
void report_bytes(btg_json *json, const char *name, const void *data, size_t size);

/* Each adds members to the open object. What cannot be had, a path whose axes do not point up, or a
 * back end that fails, is said in it. Errors: ERROR_MEMORY, and those of a machine. */
btg_status report_check(const report *r, btg_json *json, btg_message *message);
btg_status report_backends(const report *r, btg_json *json, btg_message *message);
btg_status report_joints(const report *r, btg_json *json, btg_message *message);

#endif
