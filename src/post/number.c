#include "post/internal.h"

int64_t btg_number_scaled(double value, int decimals) {
    static const double scale[BTG_DECIMALS_MAX + 1] = {1,   1e1, 1e2, 1e3, 1e4,
                                                       1e5, 1e6, 1e7, 1e8, 1e9};
    return llround(value * scale[decimals]);
}

char *btg_number_text(char *text, int64_t scaled, int decimals, int least) {
    char digit[BTG_NUMBER_SIZE];
    int n = 0, skip = 0;
    uint64_t rest = scaled < 0 ? (uint64_t)0 - (uint64_t)scaled : (uint64_t)scaled;
    for (; rest > 0 || n <= decimals; n++) {
        digit[n] = (char)('0' + rest % 10);
        rest /= 10;
    }
    while (skip < decimals - least && digit[skip] == '0')
        skip++;
    if (scaled < 0) *text++ = '-';
    while (n > decimals)
        *text++ = digit[--n];
    if (skip < decimals) *text++ = '.';
    while (n > skip)
        *text++ = digit[--n];
    return text;
}
