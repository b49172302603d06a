/* Files that appear whole or not at all. Internal to the program.
 *
 * A regular file is written under a temporary name in its own directory and renamed at the end; a
 * device, pipe or the standard output is written directly. Errors latch: write freely, ask once.
 * A signal that ends the program removes what is unfinished (btg_output_guard). */
#ifndef BTG_IO_OUTPUT_H
#define BTG_IO_OUTPUT_H

#include "bitangent/bitangent.h"

#include <stdbool.h>
#include <stdio.h>

#define BTG_OUTPUT_MAX 16 /* files open at once */

typedef struct btg_output {
    FILE *file;
    char *path;      /* where it shall stand, links resolved */
    char *temporary; /* NULL: written directly */
    int slot;        /* in the list that the signal handler clears */
    int error;       /* errno of the first failure, or 0 */
    bool standard;   /* this is the standard output */
} btg_output;

/* Ends the program cleanly on SIGINT, SIGTERM and SIGHUP; failed writes are errors, not SIGPIPE
 * or SIGXFSZ. Call once, first. */
void btg_output_guard(void);

/* ERROR_FILE with a message: file, reason, remedy. "-" is the standard output. */
btg_status btg_output_open(btg_output *output, const char *path, btg_message *message);
/* Writes to `file`, which stays the caller's and is only flushed. */
btg_output btg_output_borrow(FILE *file);

void btg_output_write(btg_output *output, const char *text, size_t size);
void btg_output_text(btg_output *output, const char *text);
void btg_output_format(btg_output *output, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 2, 3)))
#endif
    ;

/* ERROR_FILE when anything written so far failed. */
btg_status btg_output_check(const btg_output *output, btg_message *message);
/* All is on the disk, but not yet under its name. The output is to be committed or discarded. */
btg_status btg_output_finish(btg_output *output, btg_message *message);
/* Gives the finished file its name. */
btg_status btg_output_commit(btg_output *output, btg_message *message);
/* Leaves nothing behind. Fine after every other call and on a zeroed struct. */
void btg_output_discard(btg_output *output);

#endif
