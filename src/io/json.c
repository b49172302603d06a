#include "io/json.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

btg_json btg_json_to(btg_output *output) {
    return (btg_json){.output = output};
}

/* Bytes of the UTF-8 sequence at s, or 0 when it is none (RFC 3629: no surrogates, no overlong
 * forms, nothing above U+10FFFF). */
static int sequence(const unsigned char *s) {
    int n = s[0] < 0x80                   ? 1
            : s[0] >= 0xc2 && s[0] < 0xe0 ? 2
            : s[0] >= 0xe0 && s[0] < 0xf0 ? 3
            : s[0] >= 0xf0 && s[0] < 0xf5 ? 4
                                          : 0;
    for (int i = 1; i < n; i++) {
        if ((s[i] & 0xc0) != 0x80) return 0;
    }
    if (s[0] == 0xe0 && s[1] < 0xa0) return 0;
    if (s[0] == 0xed && s[1] > 0x9f) return 0;
    if (s[0] == 0xf0 && s[1] < 0x90) return 0;
    if (s[0] == 0xf4 && s[1] > 0x8f) return 0;
    return n;
}

static void quote(btg_output *o, const char *text) {
    btg_output_text(o, "\"");
    for (const unsigned char *s = (const unsigned char *)text; *s;) {
        int n = sequence(s);
        if (n == 0) {
            btg_output_text(o, "\xef\xbf\xbd");
            n = 1;
        } else if (*s == '"' || *s == '\\') {
            btg_output_format(o, "\\%c", *s);
        } else if (*s < 0x20 || *s == 0x7f) {
            btg_output_format(o, "\\u%04x", *s);
        } else {
            btg_output_write(o, (const char *)s, (size_t)n);
        }
        s += n;
    }
    btg_output_text(o, "\"");
}

static void lead(btg_json *json, const char *name) {
    if (json->comma) btg_output_text(json->output, ",");
    json->comma = true;
    if (!name) return;
    quote(json->output, name);
    btg_output_text(json->output, ":");
}

void btg_json_open(btg_json *json, const char *name, char bracket) {
    lead(json, name);
    btg_output_write(json->output, &bracket, 1);
    json->comma = false;
}

void btg_json_close(btg_json *json, char bracket) {
    btg_output_write(json->output, &bracket, 1);
    json->comma = true;
}

void btg_json_string(btg_json *json, const char *name, const char *text) {
    lead(json, name);
    quote(json->output, text);
}

void btg_json_number(btg_json *json, const char *name, double value) {
    char text[40];
    lead(json, name);
    if (!isfinite(value)) {
        btg_output_text(json->output, "null");
        return;
    }
    /* The shorter form where it reads back as the same number. */
    snprintf(text, sizeof text, "%.15g", value);
    if (strtod(text, NULL) != value) snprintf(text, sizeof text, "%.17g", value);
    btg_output_text(json->output, text);
}

void btg_json_count(btg_json *json, const char *name, uint64_t value) {
    lead(json, name);
    btg_output_format(json->output, "%" PRIu64, value);
}

void btg_json_bool(btg_json *json, const char *name, bool value) {
    lead(json, name);
    btg_output_text(json->output, value ? "true" : "false");
}

void btg_json_row(btg_json *json, const btg_row *row) {
    double values[BTG_ROW_VALUES];
    btg_row_values(row, values);
    btg_json_open(json, NULL, '{');
    btg_json_count(json, "pass", row->pass);
    btg_json_count(json, "point", row->point);
    btg_json_string(json, "status", btg_row_status(row));
    for (int i = 0; i < BTG_ROW_VALUES; i++)
        btg_json_number(json, btg_row_names[i], values[i]);
    if (row->number > 0) btg_json_count(json, "row", row->number);
    btg_json_close(json, '}');
}
