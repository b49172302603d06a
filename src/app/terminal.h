/* Colours, where a terminal shows them. */
#ifndef BTG_APP_TERMINAL_H
#define BTG_APP_TERMINAL_H

#include <stdbool.h>
#include <stdio.h>

/* True on a terminal, unless NO_COLOR is set (to anything but nothing) or TERM is `dumb`. */
bool terminal_coloured(FILE *file);

/* A table on its way to a file. */
typedef struct terminal {
    FILE *file; /* write here: the file itself where there are no colours */
    FILE *to;
    char *text;
    size_t size;
} terminal;

/* `t` stays where it is until it is closed. */
void terminal_open(terminal *t, FILE *file);
/* Labels (what stands at a line's beginning) bold, words that tell of trouble red or yellow;
 * control characters of file names do not reach the terminal. */
void terminal_close(terminal *t);

#endif
