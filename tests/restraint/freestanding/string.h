/* What a freestanding compiler asks for itself. */
#ifndef BTG_TESTS_STRING_H
#define BTG_TESTS_STRING_H

#include <stddef.h>

int memcmp(const void *a, const void *b, size_t count);
void *memcpy(void *to, const void *from, size_t count);
void *memmove(void *to, const void *from, size_t count);
void *memset(void *to, int value, size_t count);

#endif
