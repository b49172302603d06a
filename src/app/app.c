#define _GNU_SOURCE
#include "app/app.h"
#include "app/terminal.h"
#include "core/part.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

static void say(const char *option, const char *format, va_list arguments) {
    char text[1024];
    btg_message line;
    vsnprintf(text, sizeof text, format, arguments);
    btg_fail(&line, BTG_OK, "bitangent: %s%s%s", option ? option : "", option ? ": " : "", text);
    /* The program's name stands out among other programs' lines. */
    const char *rest = line.text + sizeof "bitangent:" - 1;
    if (terminal_coloured(stderr))
        fprintf(stderr, "\033[1;31mbitangent:\033[0m%s\n", rest);
    else
        fprintf(stderr, "%s\n", line.text);
}

int app_complain(int code, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    say(NULL, format, arguments);
    va_end(arguments);
    return code;
}

bool app_refuse(const char *option, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    say(option, format, arguments);
    va_end(arguments);
    return false;
}

int app_code(btg_status status) {
    switch (status) {
    case BTG_ERROR_MEMORY:
    case BTG_ERROR_NO_DEVICE:
    case BTG_ERROR_GOUGE:
        return APP_FAILED;
    default:
        return APP_UNUSABLE;
    }
}

const char *app_file_name(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

double app_seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}
