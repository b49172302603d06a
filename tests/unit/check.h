/* CHECK counts and names what fails; `check_result` is main's answer. */
#ifndef BTG_TESTS_UNIT_CHECK_H
#define BTG_TESTS_UNIT_CHECK_H

#include <stdio.h>

static int check_failures;

#define CHECK(condition) check_that((condition) != 0, __FILE__, __LINE__, #condition)

static inline void check_that(int holds, const char *file, int line, const char *text) {
    if (holds) return;
    if (check_failures++ < 20) fprintf(stderr, "%s:%d: %s\n", file, line, text);
}

/* |got - want| <= limit, NaN fails. */
#define CHECK_NEAR(got, want, limit) check_near(got, want, limit, __FILE__, __LINE__, #got)

static inline void check_near(double got, double want, double limit, const char *file, int line,
                              const char *text) {
    double error = got > want ? got - want : want - got;
    if (error <= limit) return;
    if (check_failures++ < 20)
        fprintf(stderr, "%s:%d: %s is %.17g (%a), want %.17g, error %g, limit %g\n", file, line,
                text, got, got, want, error, limit);
}

static inline int check_result(void) {
    if (check_failures > 0) fprintf(stderr, "%d checks failed\n", check_failures);
    return check_failures > 0;
}

#endif
