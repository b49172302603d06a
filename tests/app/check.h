/* The least a test needs: CHECK counts and names what fails, `check_result` is main's answer. */
#ifndef BTG_TESTS_CHECK_H
#define BTG_TESTS_CHECK_H

#include <stdio.h>

static int check_failures;

#define CHECK(condition)                                                                           \
    do {                                                                                           \
        if (!(condition)) {                                                                        \
            fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #condition);                        \
            check_failures++;                                                                      \
        }                                                                                          \
    } while (0)

static inline int check_result(void) {
    if (check_failures > 0) fprintf(stderr, "%d checks failed\n", check_failures);
    return check_failures > 0;
}

#endif
