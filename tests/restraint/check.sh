#!/bin/bash
# What the run phase asks of its surroundings: a few functions of libm, and memcpy and the like.
# No stdio, no memory, no locks, no clock.
#   check.sh SOURCE_DIR [FILE]...    (CC: the compiler)
# FILE: sources that are built again for AVX2 and AVX-512.
set -u
source=$1
shift
# Most bytes of a frame: LinuxCNC warns above (Makefile.modinc).
FRAME_BYTES=2560
# Set-up: they word messages and ask for memory.
SET_UP="status.c tool.c"

bad=0
fault() {
    echo "FAULT: $*"
    bad=1
}
folder=$(mktemp -d "${TMPDIR:-/tmp}/bitangent-restraint.XXXXXX") || exit 1
trap 'rm -rf "$folder"' EXIT
flags="-std=c11 -O2 -DNDEBUG -ffp-contract=off -fno-asynchronous-unwind-tables"
include="-I$source/src -I$source/src/include"

# ---- the functions that the run calls reach, whatever file they stand in ---------------------

compile() {
    local object=$folder/$1
    shift
    # shellcheck disable=SC2086
    $CC $flags -ffunction-sections -fdata-sections $include -Wframe-larger-than=$FRAME_BYTES \
        "$@" -c -o "$object" 2>>"$folder/warnings.txt" || {
        cat "$folder/warnings.txt"
        exit 1
    }
}
variants=""
if [ "$(uname -m)" = x86_64 ] && [ $# != 0 ]; then
    variants="-DBTG_HAVE_AVX2 -DBTG_HAVE_AVX512"
    for file in "$@"; do
        name=$(basename "$file" .c)
        compile "$name-avx2.o" -include core/variant.h -DBTG_VARIANT=avx2 -mavx2 "$file"
        compile "$name-avx512.o" -include core/variant.h -DBTG_VARIANT=avx512 -mavx2 -mavx512f \
            -mavx512vl -mavx512dq -mprefer-vector-width=256 "$file"
    done
fi
for file in "$source"/src/core/*.c; do
    # shellcheck disable=SC2086
    compile "$(basename "$file" .c).o" $variants "$file"
done

# One that is wide for certain.
# shellcheck disable=SC2086
echo "void use(char *); void known_wide(void); void known_wide(void) { char a[2 * $FRAME_BYTES]; use(a); }" |
    $CC $flags -Wframe-larger-than=$FRAME_BYTES -x c -c - -o /dev/null 2>>"$folder/warnings.txt"

# Names from outside that are missed when only what ROOT... reach is linked. btg_fail words messages;
# run calls give it none, and it comes back at once: it is not followed.
asked_by() {
    local root roots=""
    for root in "$@"; do roots="$roots -Wl,-u,$root"; done
    # shellcheck disable=SC2086
    LC_ALL=C $CC -nostdlib -static -Wl,--gc-sections -Wl,--wrap=btg_fail -Wl,-e,"$1" $roots \
        -Wl,--warn-unresolved-symbols "$folder"/*.o -o "$folder/reached.elf" 2>"$folder/link.txt" || {
        cat "$folder/link.txt" >&2
        return 1
    }
    sed -n "s/.*undefined reference to .\([A-Za-z_0-9]*\).*/\1/p" "$folder/link.txt" | sort -u
}
# __cpu_model: what the compiler's start-up code learnt of the processor.
allowed="__wrap_btg_fail __cpu_model memcmp memcpy memmove memset sincos
$(sed -n 's/^\(double\|float\) \([a-z0-9]*\)(.*/\2/p' "$source/tests/restraint/freestanding/math.h")"
more_than_allowed() { grep -vxF -f <(tr ' ' '\n' <<<"$allowed"); }

run_calls="btg_drop btg_tilt btg_position_solve btg_position_follow btg_position_drop_query
btg_position_tilt_query btg_position_assemble btg_position_strip btg_tool_distance btg_workspace_size
btg_position_workspace_size"
# shellcheck disable=SC2086
asked=$(asked_by $run_calls) || fault "the core does not link"
echo "the run calls ask for:" "${asked//$'\n'/ }"
[ "$(wc -w <<<"$asked")" -ge 3 ] || fault "that is too little to be true"
for name in $(more_than_allowed <<<"$asked"); do fault "the run phase asks for $name"; done
reached=$(nm "$folder/reached.elf" | awk '{ sub(/\..*/, "", $NF); print $NF }')
# The same question must catch set-up.
asked_by btg_part_create | more_than_allowed | grep -qx malloc || fault "malloc in btg_part_create goes unseen"

# ---- frames: set-up may have wide ones, it runs before a controller's real-time threads do ---

# Both compilers name the function: "In function 'x':" or "(n) exceeds limit (m) in 'x'".
wide=$(grep -B 2 -E 'frame size|stack frame' "$folder/warnings.txt" |
    sed -n "s/.*[iI]n function .\([a-z_0-9]*\).*/\1/p; s/.*exceeds limit.* in '\([a-z_0-9]*\)'.*/\1/p" | sort -u)
echo "frames above $FRAME_BYTES bytes: ${wide//$'\n'/ }"
grep -qx known_wide <<<"$wide" || fault "a frame known to be wide goes unseen"
for name in $wide; do
    grep -qx "$name" <<<"$reached" && fault "$name, in the run phase, has a frame of more than $FRAME_BYTES bytes"
done

# ---- the same files without any library's headers ------------------------------------------

own=$($CC -print-file-name=include)
[ -f "$own/stddef.h" ] || own=$($CC -print-resource-dir)/include
built=0
for file in "$source"/src/core/*.c; do
    case " $SET_UP " in *" ${file##*/} "*) continue ;; esac
    # shellcheck disable=SC2086
    $CC $flags -ffreestanding -nostdinc -isystem "$source/tests/restraint/freestanding" -isystem "$own" \
        $include -Werror -c "$file" -o "$folder/freestanding.o" ||
        fault "${file##*/} does not compile freestanding"
    built=$((built + 1))
done
echo "$built files compile with -ffreestanding -nostdinc (set-up left out: $SET_UP)"
exit $bad
