#define _POSIX_C_SOURCE 200809L
#include "app/terminal.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define BOLD   "\033[1m"
#define RED    "\033[1;31m"
#define GREEN  "\033[32m"
#define YELLOW "\033[33m"
#define PLAIN  "\033[0m"

static const struct {
    const char *word, *colour;
} known[] = {
    {"NOT OK", RED},        {"BEYOND", RED},        {"MISSING", RED},
    {"WRONG", RED},         {"LINES CHANGED", RED}, {"collide", RED},
    {"ok", GREEN},          {"budget", YELLOW},     {"single-contact", YELLOW},
    {"no-contact", YELLOW}, {"disturbed", YELLOW},
};

bool terminal_coloured(FILE *file) {
    const char *no = getenv("NO_COLOR"), *term = getenv("TERM");
    if ((no && no[0]) || (term && strcmp(term, "dumb") == 0)) return false;
    int descriptor = fileno(file);
    return descriptor >= 0 && isatty(descriptor);
}

void terminal_open(terminal *t, FILE *file) {
    *t = (terminal){.file = file, .to = file};
    FILE *memory = terminal_coloured(file) ? open_memstream(&t->text, &t->size) : NULL;
    if (memory) t->file = memory;
}

static bool joins(char c) {
    return isalnum((unsigned char)c) || c == '-' || c == '_' || c == '.' || c == '/';
}

/* Characters of a known word that stands alone at s, and its colour; 0: none. */
static size_t word_at(const char *line, const char *s, const char **colour) {
    if (s > line && joins(s[-1])) return 0;
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        size_t n = strlen(known[i].word);
        if (strncmp(s, known[i].word, n) != 0 || joins(s[n])) continue;
        *colour = known[i].colour;
        return n;
    }
    return 0;
}

static void put(FILE *file, const char *s, size_t n) {
    for (size_t i = 0; i < n; i++)
        fputc(iscntrl((unsigned char)s[i]) ? '?' : s[i], file);
}

static void paint(const char *line, FILE *file) {
    const char *colour = BOLD, *s = line;
    size_t n = word_at(line, s, &colour);
    /* A label ends where two blanks begin. */
    const char *gap = strstr(line, "  ");
    if (n == 0 && line[0] != ' ') n = gap ? (size_t)(gap - line) : strcspn(line, " ");
    while (*s) {
        if (n > 0) {
            fputs(colour, file);
            put(file, s, n);
            fputs(PLAIN, file);
        } else {
            put(file, s, 1);
        }
        s += n > 0 ? n : 1;
        n = *s ? word_at(line, s, &colour) : 0;
    }
}

void terminal_close(terminal *t) {
    if (t->file == t->to) return;
    fclose(t->file);
    for (char *line = t->text; line && *line;) {
        char *end = strchr(line, '\n');
        if (end) *end = '\0';
        paint(line, t->to);
        if (!end) break;
        fputc('\n', t->to);
        line = end + 1;
    }
    free(t->text);
    *t = (terminal){0};
}
