/* `bitangent report`: a path whose output is a page. */
#include "app/app.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define PAGE "report.html"

static bool is_page(const char *value) {
    size_t size = strlen(value);
    return strncasecmp(value, "html:", 5) == 0 ||
           (size > 5 && strcasecmp(value + size - 5, ".html") == 0);
}

/* Among the words there is a file for the page. */
static bool names_page(int count, char **words) {
    for (int i = 0; i < count && strcmp(words[i], "--") != 0; i++) {
        const char *word = words[i];
        if (strncmp(word, "--output=", 9) == 0 && is_page(word + 9)) return true;
        bool output = strcmp(word, "-o") == 0 || strcmp(word, "--output") == 0;
        if (output && i + 1 < count && is_page(words[i + 1])) return true;
    }
    return false;
}

static bool asks_help(int count, char **words) {
    for (int i = 0; i < count; i++)
        if (strcmp(words[i], "--help") == 0 || strcmp(words[i], "-h") == 0) return true;
    return false;
}

int app_report(int count, char **words) {
    static char name[] = "-o", page[] = PAGE;
    if (asks_help(count, words)) return app_help("report");
    if (names_page(count, words)) return app_path(count, words);
    char **more = malloc(((size_t)count + 2) * sizeof *more);
    if (!more) return app_complain(APP_FAILED, "out of memory");
    more[0] = name;
    more[1] = page;
    memcpy(more + 2, words, (size_t)count * sizeof *more);
    int code = app_path(count + 2, more);
    free(more);
    return code;
}
