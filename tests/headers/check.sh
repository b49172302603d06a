#!/bin/bash
# Every public header compiles alone, and a second time over, as C11 and as C++17, with pedantic
# warnings as errors.    check.sh INCLUDE_DIR    (CC and CXX name the compilers)
set -u
include=$1
strict="-fsyntax-only -pedantic -pedantic-errors -Wall -Wextra -Wshadow -Wconversion -Wundef -Werror"
checked=0 bad=0

# compile LANGUAGE HEADER COMPILER FLAG...
compile() {
    local language=$1 header=$2
    shift 2
    # shellcheck disable=SC2086
    printf '#include "bitangent/%s"\n#include "bitangent/%s"\nint main(void) { return 0; }\n' \
        "$header" "$header" | "$@" -x "$language" $strict -I"$include" - || {
        echo "bitangent/$header does not compile alone: $*"
        bad=$((bad + 1))
    }
    checked=$((checked + 1))
}

for path in "$include"/bitangent/*.h; do
    header=${path##*/}
    # shellcheck disable=SC2086
    compile c "$header" $CC -std=c11 -Wstrict-prototypes
    # shellcheck disable=SC2086
    compile c++ "$header" $CXX -std=c++17
done
echo "$checked compilations, $bad bad"
[ "$bad" = 0 ] && [ "$checked" -ge 4 ]
