#include "app/number.h"
#include "check.h"

#include <string.h>

static void test_taken(void) {
    const char *text[] = {"2", "-0.5", "+3", "1e3", "1E-3", ".5", "5.", "0", "-0", "1e+2"};
    const double value[] = {2, -0.5, 3, 1000, 0.001, 0.5, 5, 0, 0, 100};
    for (int i = 0; i < 10; i++) {
        double x = 77;
        CHECK(number_parse(text[i], strlen(text[i]), &x) && x == value[i]);
    }
}

static void test_refused(void) {
    const char *text[] = {"",    "12abc", "nan", "inf", "0x10",  " 1",    "1 ",  "1,5", "1e",
                          "1e+", ".",     "-",   "+-1", "1.2.3", "1e999", "--1", "1d3"};
    for (int i = 0; i < 17; i++) {
        double x = 77;
        CHECK(!number_parse(text[i], strlen(text[i]), &x));
        CHECK(x == 77);
    }
    char digits[100];
    memset(digits, '1', sizeof digits);
    double x;
    CHECK(!number_parse(digits, sizeof digits, &x));
}

static void test_lists(void) {
    double x[3];
    CHECK(number_parse_list("1,2,3", x, 3) == 3 && x[0] == 1 && x[2] == 3);
    CHECK(number_parse_list("1", x, 3) == 1);
    CHECK(number_parse_list("1,2,3,4", x, 3) == -1);
    CHECK(number_parse_list("1,,3", x, 3) == -1);
    CHECK(number_parse_list("1,2,", x, 3) == -1);
    CHECK(number_parse_list("", x, 3) == -1);
}

static void test_counts(void) {
    uint32_t n;
    CHECK(number_parse_count("12", &n) && n == 12);
    CHECK(!number_parse_count("-1", &n) && !number_parse_count("1.0", &n));
    CHECK(!number_parse_count("", &n) && !number_parse_count("99999999999", &n));
}

int main(void) {
    test_taken();
    test_refused();
    test_lists();
    test_counts();
    return check_result();
}
