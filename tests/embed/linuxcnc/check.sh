#!/bin/bash
# The LinuxCNC component: built against the installed library, loaded headless, one position each
# millisecond. Skipped (77), with the reason as the last line, where that cannot be.
#   check.sh SOURCE_DIR BUILD_DIR
set -u
source=$1 build=$2
skip() {
    echo "$*"
    exit 77
}
for program in halrun halcompile; do
    command -v $program >/dev/null ||
        skip "LinuxCNC is not installed ($program is missing); tools/setup --all installs it"
done
command -v unshare >/dev/null || skip "unshare is missing: no module folder of our own"

folder=$(mktemp -d "${TMPDIR:-/tmp}/bitangent-linuxcnc.XXXXXX") || exit 1
trap 'rm -rf "$folder"' EXIT
bad=0
fault() {
    echo "FAULT: $*"
    bad=1
}

# LinuxCNC loads modules from one folder of the system's; in a name space of our own another
# folder stands there, and no other LinuxCNC's processes and shared memory are met. As root the
# real-time process becomes another user, who must reach the folder.
modules=/usr/lib/linuxcnc/modules
mkdir "$folder/modules" && mkdir -m 1777 "$folder/fifo" && chmod 755 "$folder" || exit 1
export RTAPI_FIFO_PATH=$folder/fifo/fifo
if [ "$(id -u)" = 0 ]; then
    export RTAPI_UID=65534
    inside() { unshare -mipf --mount-proc sh -c "mount --bind '$folder/modules' $modules && exec \"\$@\"" sh "$@"; }
else
    # The second name space gives back our own user: the real-time process refuses to be root.
    inside() {
        unshare -rmipf --mount-proc sh -c "mount --bind '$folder/modules' $modules &&
            exec unshare -U --map-user=$(id -u) \"\$@\"" sh "$@"
    }
fi
inside true 2>/dev/null || skip "no name spaces here (unshare): no module folder of our own"

DESTDIR=$folder/installed meson install -C "$build" --no-rebuild --quiet || exit 1
pc=$(find "$folder/installed" -name bitangent.pc)
archive=$(find "$folder/installed" -name libbitangent.a)
export PKG_CONFIG_SYSROOT_DIR=$folder/installed PKG_CONFIG_PATH=${pc%/*}
cp "$source"/tests/embed/linuxcnc/{Makefile,bitangent_tool.comp,bitangent_tool.hal} "$folder"
make -C "$folder" LIBBITANGENT="$archive" >"$folder/make.txt" 2>&1 || {
    cat "$folder/make.txt"
    exit 1
}
# Among them -Wframe-larger-than=2560, LinuxCNC's own.
if grep -q 'warning:' "$folder/make.txt"; then
    cat "$folder/make.txt"
    fault "the component compiles with warnings"
fi
cp "$folder/bitangent_tool.so" $modules/{threads,siggen,hal_lib}.so "$folder/modules" || exit 1

cd "$folder" || exit 1
inside timeout 60 halrun -f bitangent_tool.hal >out.txt 2>&1 || fault "halrun: exit code $?"
# "title value" a line: first what the component counted on its way, then its pins at a known place.
awk '
    /HALCMD MSG: / { title = $NF; gsub("\"", "", title); next }
    title != "" { print title, $1; title = ""; next }
    $NF ~ /^bitangent-tool\./ && NF >= 5 { sub("bitangent-tool.", "", $NF); print "pin-" $NF, $4 }
' out.txt >values.txt
value() { awk -v title="$1" '$1 == title { print $2 }' values.txt; }
near() { awk -v a="$(value "$1")" -v b="$2" -v off="$3" 'BEGIN { exit a == "" || a - b > off || b - a > off }'; }

# Not one for each of 4000 periods: the machine may be busy, and the thread is not real-time.
[ "$(value periods)" -ge 1000 ] 2>/dev/null || fault "$(value periods) periods in 4 s"
[ "$(value invalid)" = 0 ] || fault "$(value invalid) positions without a safe pose"
# What dense sampling gives there, without the library.
place() {
    near pin-tip-x 72.8975 0.001 && near pin-tip-y 74.1677 0.001 && near pin-tip-z 91.9920 0.001 &&
        near pin-tilt 8.1063 0.005 && [ "$(value pin-outcome)" = 0 ] && [ "$(value pin-valid)" = TRUE ]
}
place || fault "over (72, 74) it stands elsewhere"
[ $bad = 0 ] || cat out.txt

# On x86 LinuxCNC counts the processor's clocks, elsewhere nanoseconds.
mhz=$(sed -n 's/^cpu MHz[^0-9]*//p' /proc/cpuinfo | head -n 1)
microseconds() { awk -v n="$(value "$1")" -v mhz="${mhz:-1000}" 'BEGIN { printf "%.1f", n / mhz }'; }
grep -m 1 '^Note:' out.txt
echo "$(value periods) periods, $(value cut-short) cut short by the node budget, $(value invalid) without a pose"
echo "time $(value time) clocks, tmax $(value tmax) clocks: about $(microseconds time) and $(microseconds tmax) microseconds"
exit $bad
