#!/bin/bash
# The library as others meet it: installed into a folder of its own, found through pkg-config,
# built against shared and static, and run.    check.sh SOURCE_DIR BUILD_DIR [gltf]
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
[ -n "$pc" ] && [ -n "$library" ] || {
    echo "no bitangent.pc or no libbitangent.so among the installed files:"
    find "$folder" -type f
    exit 1
}
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

# The answer that dense sampling of the surface gives, without the library.
compare() {
    awk 'BEGIN {
        n = split("72.8975 74.1677 91.9920 -0.13861 -0.02590 0.99001 8.1063", want)
        split("0.001 0.001 0.001 0.0001 0.0001 0.0001 0.005", off)
    }
    NR == 1 { bad = $0 != "two-contact" }
    NR > 1 {
        for (i = 2; i <= NF; i++)
            if ($i ~ /^-?[0-9.]+$/ && (++k > n || $i - want[k] > off[k] || want[k] - $i > off[k])) bad = 1
    }
    END { exit bad || k != n }' "$1"
}
run() {
    local kind=$1
    shift
    # shellcheck disable=SC2086
    if ! "$@"; then
        fault "the program does not build against the $kind library: $*"
        return
    fi
    LD_LIBRARY_PATH=${library%/*} "$folder/embed-$kind" >"$folder/$kind.txt" || fault "$kind: exit code $?"
    sed "s/^/$kind: /" "$folder/$kind.txt"
    compare "$folder/$kind.txt" || fault "the $kind program prints another position"
}
strict="-std=c11 -pedantic -Wall -Wextra -Werror"
# shellcheck disable=SC2086,SC2046
{
    run shared $CC $strict "$source/tests/embed/embed.c" -o "$folder/embed-shared" \
        $(pkg-config --cflags --libs bitangent)
    run static $CC $strict "$source/tests/embed/embed.c" -o "$folder/embed-static" -static \
        $(pkg-config --cflags --static --libs bitangent)
}
exit $bad
