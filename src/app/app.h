/* What the program's files share: exit codes and one-line complaints. */
#ifndef BTG_APP_APP_H
#define BTG_APP_APP_H

#include "bitangent/bitangent.h"

#include <stdbool.h>

#define APP_DONE     0
#define APP_FAILED   1 /* the work failed */
#define APP_UNUSABLE 2 /* the command line or an input file is unusable */

/* One line on stderr, "bitangent: ...". Returns `code`. */
int app_complain(int code, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 2, 3)))
#endif
    ;

/* The same for an option's value; returns false. */
bool app_refuse(const char *option, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 2, 3)))
#endif
    ;

/* Exit code for an error of the library: a bad argument or input is the caller's, 2. */
int app_code(btg_status status);

/* A path without its folders; points into it. */
const char *app_file_name(const char *path);

/* Seconds since some moment. */
double app_seconds(void);

int app_path(int count, char **words); /* `bitangent path`: the words after it */
int app_verify(int count, char **words);
int app_view(int count, char **words);
int app_report(int count, char **words);
int app_bench(int count, char **words);
int app_plan(int count, char **words);
int app_info(int count, char **words);
int app_help(const char *topic); /* NULL: what there is */

#endif
