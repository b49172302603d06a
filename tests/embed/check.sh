#!/bin/bash
# The library as others meet it: installed into a folder of its own, found through pkg-config,
# built against shared and static, as C and (with CXX) as C++, and run.
#   check.sh SOURCE_DIR BUILD_DIR [gltf]
set -u
source=$1 build=$2 gltf=${3-}
bad=0
fault() {
    echo "FAULT: $*"
    bad=1
}
folder=$(mktemp -d "${TMPDIR:-/tmp}/bitangent-embed.XXXXXX") || exit 1
trap 'rm -rf "$folder"' EXIT

DESTDIR=$folder meson install -C "$build" --no-rebuild --quiet || {
    echo "meson install failed"
    exit 1
}
pc=$(find "$folder" -name bitangent.pc)
library=$(find "$folder" -name 'libbitangent.so' | head -n 1)
if [ -z "$pc" ] || [ -z "$library" ]; then
    echo "no bitangent.pc or no libbitangent.so among the installed files:"
    find "$folder" -type f
    exit 1
fi
export PKG_CONFIG_SYSROOT_DIR=$folder PKG_CONFIG_PATH=${pc%/*}

# Every public header is there.
for header in "$source"/src/include/bitangent/*.h; do
    [ "${header##*/}" = gltf.h ] && [ -z "$gltf" ] && continue
    [ -n "$(find "$folder" -path "*/include/bitangent/${header##*/}")" ] ||
        fault "${header##*/} is not installed"
done

# The shared library asks for the C library and its maths only.
needed=$(readelf -d "$library" | sed -n 's/.*(NEEDED).*\[\(.*\)\]/\1/p' | tr '\n' ' ')
echo "libbitangent.so needs: $needed"
for name in $needed; do
    case "$name" in
    libc.so.* | libm.so.* | ld-linux*.so.*) ;;
    *) fault "libbitangent.so needs $name" ;;
    esac
done

# Only its own names are visible.
foreign=$(nm -D --defined-only "$library" | awk '{print $NF}' | sed 's/@.*//' | grep -v '^btg_' | tr '\n' ' ')
[ -z "$foreign" ] || fault "libbitangent.so shows names without btg_: $foreign"

# Eleven positions, and over (72, 74) what dense sampling of the surface gives, without the library.
compare() {
    awk 'BEGIN {
        n = split("72.8975 74.1677 91.9920 -0.13861 -0.02590 0.99001 8.1063", want)
        split("0.001 0.001 0.001 0.0001 0.0001 0.0001 0.005", off)
    }
    / over / { positions++; bad += $1 != "two-contact" && $1 != "osculating"; here = / 72 74$/ }
    $1 == "tip" && here {
        for (i = 2; i <= NF; i++)
            if ($i ~ /^-?[0-9.]+$/ && (++k > n || $i - want[k] > off[k] || want[k] - $i > off[k])) bad++
    }
    END { exit bad || k != n || positions != 11 }' "$1"
}
run() {
    local kind=$1
    shift
    if ! "$@" -o "$folder/embed-$kind"; then
        fault "the program does not build, $kind: $*"
        return
    fi
    LD_LIBRARY_PATH=${library%/*} "$folder/embed-$kind" >"$folder/$kind.txt" || fault "$kind: exit code $?"
    compare "$folder/$kind.txt" || {
        fault "$kind: other positions than these should be:"
        cat "$folder/$kind.txt"
    }
    echo "$kind: $(grep -c over "$folder/$kind.txt") positions"
}
program=$source/tests/embed/embed.c
strict="-pedantic -Wall -Wextra -Werror"
flags=$(pkg-config --cflags bitangent)
shared=$(pkg-config --libs bitangent)
static="-static $(pkg-config --libs --static bitangent)"
# shellcheck disable=SC2086
{
    run c-shared $CC -std=c11 $strict $flags "$program" $shared
    run c-static $CC -std=c11 $strict $flags "$program" $static
    if [ -n "${CXX-}" ]; then
        run c++-shared $CXX -std=c++11 $strict $flags -x c++ "$program" -x none $shared
        run c++-static $CXX -std=c++11 $strict $flags -x c++ "$program" -x none $static
    fi
}
exit $bad
