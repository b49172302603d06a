#include "app/points.h"
#include "app/number.h"
#include "core/part.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Two numbers and a comment fit easily; a longer line is no such file. */
#define POINT_LINE_SIZE 1024
#define BYTE_ORDER_MARK "\xef\xbb\xbf"

typedef struct reader {
    const char *path;
    FILE *file;
    unsigned long line;
    double *xy;
    size_t count, capacity;
    btg_message *message;
} reader;

static btg_status fail(const reader *r, const char *reason) {
    return btg_fail(r->message, BTG_ERROR_FORMAT, "%.256s:%lu: %s", r->path, r->line, reason);
}

static btg_status fail_file(const reader *r, int error) {
    return btg_fail(r->message, BTG_ERROR_FILE,
                    "%.256s: cannot read: %s; give a readable file of two columns, x y in mm",
                    r->path, strerror(error));
}

static const char *skip_blanks(const char *s) {
    return s + strspn(s, " \t");
}

/* One number; *s moves behind it. */
static bool take_number(const char **s, double *value) {
    size_t size = strcspn(*s, " \t,#");
    if (!number_parse(*s, size, value)) return false;
    *s += size;
    return true;
}

static btg_status keep(reader *r, double x, double y) {
    if (r->count == BTG_FOOTPRINT_MAX) {
        return btg_fail(r->message, BTG_ERROR_FORMAT,
                        "%.256s:%lu: more than %d points; split the file", r->path, r->line,
                        BTG_FOOTPRINT_MAX);
    }
    if (r->count == r->capacity) {
        size_t capacity = r->capacity > 0 ? 2 * r->capacity : 1024;
        double *xy = realloc(r->xy, capacity * 2 * sizeof *xy);
        if (!xy) return btg_fail(r->message, BTG_ERROR_MEMORY, "%.256s: out of memory", r->path);
        r->xy = xy;
        r->capacity = capacity;
    }
    r->xy[2 * r->count] = x;
    r->xy[2 * r->count + 1] = y;
    r->count++;
    return BTG_OK;
}

static btg_status take_line(reader *r, const char *line) {
    double x, y;
    const char *s = skip_blanks(line);
    if (*s == '\0' || *s == '#') return BTG_OK;
    if (!take_number(&s, &x)) return fail(r, "x is not a number; give two columns, x y in mm");
    s = skip_blanks(s);
    if (*s == ',') s = skip_blanks(s + 1);
    if (!take_number(&s, &y)) return fail(r, "y is not a number; give two columns, x y in mm");
    s = skip_blanks(s);
    if (*s != '\0' && *s != '#') return fail(r, "more than two columns; give x y in mm");
    if (fabs(x) > BTG_LENGTH_MAX || fabs(y) > BTG_LENGTH_MAX) {
        return fail(r, "the point is more than 1e6 mm away; give coordinates in mm");
    }
    return keep(r, x, y);
}

/* One line without its end. *ended: there was none left. */
static btg_status get_line(reader *r, char line[POINT_LINE_SIZE], bool *ended) {
    size_t n = 0;
    int c;
    r->line++;
    errno = 0;
    while ((c = getc(r->file)) != EOF && c != '\n') {
        if (c == '\0') return fail(r, "a zero byte; give a text file of two columns, x y in mm");
        if (n == POINT_LINE_SIZE - 1) return fail(r, "the line is longer than 1023 characters");
        line[n++] = (char)c;
    }
    if (ferror(r->file)) return fail_file(r, errno);
    if (n > 0 && line[n - 1] == '\r') n--;
    line[n] = '\0';
    *ended = c == EOF && n == 0;
    return BTG_OK;
}

static btg_status read_all(reader *r) {
    char line[POINT_LINE_SIZE];
    for (;;) {
        bool ended = false;
        btg_status status = get_line(r, line, &ended);
        if (status != BTG_OK) return status;
        if (ended) break;
        bool marked = r->line == 1 && strncmp(line, BYTE_ORDER_MARK, 3) == 0;
        status = take_line(r, marked ? line + 3 : line);
        if (status != BTG_OK) return status;
    }
    if (r->count > 0) return BTG_OK;
    return btg_fail(r->message, BTG_ERROR_FORMAT, "%.256s: no points; give two columns, x y in mm",
                    r->path);
}

btg_status points_read(const char *path, double **xy, size_t *count, btg_message *message) {
    reader r = {.path = path, .message = message};
    r.file = fopen(path, "r");
    if (!r.file) return fail_file(&r, errno);
    btg_status status = read_all(&r);
    fclose(r.file);
    if (status != BTG_OK) {
        free(r.xy);
        return status;
    }
    *xy = r.xy;
    *count = r.count;
    return BTG_OK;
}
