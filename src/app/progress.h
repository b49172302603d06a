/* A line on stderr about long work, where a person watches: only when stderr is a terminal. */
#ifndef BTG_APP_PROGRESS_H
#define BTG_APP_PROGRESS_H

#include <stdbool.h>
#include <stddef.h>

typedef struct progress {
    bool shown; /* someone watches */
    bool drawn; /* there is a line to clear */
    size_t total;
    double begin, last; /* seconds */
} progress;

progress progress_begin(size_t total, bool quiet);
/* `done` of the total, whatever it counts, which is `positions` positions. */
void progress_show(progress *p, size_t done, size_t positions);
/* Takes the line away. */
void progress_end(progress *p);

#endif
