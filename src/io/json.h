/* A minimal JSON writer. Internal to the program.
 *
 * Values come in order; a name is given inside an object and NULL inside an array. Strings that
 * are not UTF-8 are mended, numbers that are not finite become null. */
#ifndef BTG_IO_JSON_H
#define BTG_IO_JSON_H

#include "io/output.h"
#include "io/row.h"

typedef struct btg_json {
    btg_output *output;
    bool comma; /* the next value follows another one */
} btg_json;

btg_json btg_json_to(btg_output *output);
void btg_json_open(btg_json *json, const char *name, char bracket); /* '{' or '[' */
void btg_json_close(btg_json *json, char bracket);                  /* '}' or ']' */
void btg_json_string(btg_json *json, const char *name, const char *text);
void btg_json_number(btg_json *json, const char *name, double value);
void btg_json_count(btg_json *json, const char *name, uint64_t value);
void btg_json_bool(btg_json *json, const char *name, bool value);
/* One object with the columns of the CSV. */
void btg_json_row(btg_json *json, const btg_row *row);

#endif
