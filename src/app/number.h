/* Numbers as people type them: the whole word, finite, decimal ("2", "-0.5", "1e3"). */
#ifndef BTG_APP_NUMBER_H
#define BTG_APP_NUMBER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* The first `size` characters of text. */
bool number_parse(const char *text, size_t size, double *value);
bool number_parse_count(const char *text, uint32_t *value);

/* Splits "a,b,c" into at most `most` numbers; the count, or -1 when a word is no number or there
 * are more. */
int number_parse_list(const char *text, double *values, int most);

#endif
