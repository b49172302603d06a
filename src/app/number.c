#include "app/number.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define NUMBER_SIZE 64 /* more digits than any double needs */

static size_t digits(const char *text, size_t i, size_t size) {
    size_t n = 0;
    while (i + n < size && text[i + n] >= '0' && text[i + n] <= '9')
        n++;
    return n;
}

static size_t sign(const char *text, size_t i, size_t size) {
    return i < size && (text[i] == '+' || text[i] == '-');
}

/* [+-] digits [. digits] [e [+-] digits], with a digit on one side of the point: strtod alone
 * would take hexadecimal, "inf" and "nan" as well. */
static bool well_formed(const char *text, size_t size) {
    size_t i = sign(text, 0, size);
    size_t whole = digits(text, i, size), part = 0;
    i += whole;
    if (i < size && text[i] == '.') {
        part = digits(text, i + 1, size);
        i += 1 + part;
    }
    if (whole + part == 0) return false;
    if (i < size && (text[i] == 'e' || text[i] == 'E')) {
        i += 1;
        i += sign(text, i, size);
        size_t exponent = digits(text, i, size);
        if (exponent == 0) return false;
        i += exponent;
    }
    return i == size;
}

bool number_parse(const char *text, size_t size, double *value) {
    char copy[NUMBER_SIZE];
    if (size >= sizeof copy || !well_formed(text, size)) return false;
    memcpy(copy, text, size);
    copy[size] = '\0';
    double x = strtod(copy, NULL);
    if (!isfinite(x)) return false;
    *value = x;
    return true;
}

bool number_parse_count(const char *text, uint32_t *value) {
    size_t size = strlen(text);
    if (size == 0 || size > 9 || digits(text, 0, size) != size) return false;
    *value = (uint32_t)strtoul(text, NULL, 10);
    return true;
}

int number_parse_list(const char *text, double *values, int most) {
    int n = 0;
    for (;;) {
        size_t size = strcspn(text, ",");
        if (n == most || !number_parse(text, size, &values[n])) return -1;
        n++;
        if (text[size] == '\0') return n;
        text += size + 1;
    }
}
