"""Programs of `bitangent path` in LinuxCNC itself: its interpreter reads all of them, and
tools/demo-machine has its controller run one.

    python3 linuxcnc.py PATH_OF_BITANGENT

Exit code 77: LinuxCNC is not installed.
"""

import json
import os
import re
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
PART = os.path.join(HERE, "..", "..", "assets", "saddle.gltf")
sys.path.insert(0, os.path.join(HERE, "..", "..", "tools"))
sys.dont_write_bytecode = True
import linuxcnc_run  # noqa: E402
from linuxcnc_run import (LENGTH, OFFSET, TABLE_C, XYZAC, blocks_of, machine,  # noqa: E402
                          rotary)

SKIPPED = 77
RTCP = {"control": "linuxcnc"}
JOINTS = {"control": "linuxcnc", "tcp": False}
MACHINES = [
    XYZAC,
    machine("xyzbc", rotary("B", "table", [0, 1, 0], 100, (20, 0, 10)), TABLE_C, RTCP),
    machine("tight", rotary("A", "table", [1, 0, 0], 30), rotary("C", "table", [0, 0, 1], 200),
            RTCP),
    machine("ac-joints", rotary("A", "table", [1, 0, 0], 100, OFFSET), TABLE_C, JOINTS),
    machine("bc-joints", rotary("B", "head", [0, 1, 0], 100), TABLE_C, JOINTS),
    machine("ca-joints", rotary("C", "head", [0, 0, 1]), rotary("A", "head", [1, 0, 0], 100),
            JOINTS),
]


def check(condition, *words):
    if not condition:
        print("FAILED:", *words)
        sys.exit(1)


def make_program(program, folder, what, *words):
    file = os.path.join(folder, what["machine"] + ".json")
    out = os.path.join(folder, what["machine"] + ".ngc")
    with open(file, "w") as f:
        json.dump(what, f)
    done = subprocess.run([program, "path", PART, "-o", out, "--machine", file, "--quiet", *words],
                          capture_output=True, text=True)
    check(done.returncode == 0, what["machine"], done.stderr)
    return out


# ---- the interpreter -----------------------------------------------------------------------


def interpret(program, folder):
    table, store = os.path.join(folder, "tool.tbl"), os.path.join(folder, "t.var")
    with open(table, "w") as f:
        f.write("T1 P1 Z%g D25.4\n" % LENGTH)
    words = ["--side-step", "12", "--forward-step", "3", "--tool-length", str(LENGTH)]
    for what in MACHINES:
        file = make_program(program, folder, what, *words)
        done = subprocess.run(["rs274", "-g", "-t", table, "-v", store, file],
                              capture_output=True, text=True)
        check(done.returncode == 0, "rs274 refuses", file, done.stderr[-500:])
        feeds = len(re.findall(r"STRAIGHT_FEED", done.stdout))
        wanted = sum(not b["rapid"] for b in blocks_of(file))
        check(feeds == wanted > 300, file, feeds, "feeds read,", wanted, "written")
        check(done.stdout.count("PROGRAM_END") == 1, file, "has no end")
        print("rs274 reads %s: %d feeds" % (what["machine"], feeds))


# ---- the controller ------------------------------------------------------------------------


def demonstrate(program):
    done = subprocess.run([sys.executable, os.path.join(HERE, "..", "..", "tools", "demo-machine"),
                           "--quick", program], capture_output=True, text=True)
    print(done.stdout, end="")
    check(done.returncode == 0, "tools/demo-machine", done.stderr[-2000:])
    check(done.stdout.count(" ok\n") == 6, "not all of its steps ran")


def main():
    program = os.path.abspath(sys.argv[1])
    if linuxcnc_run.missing():
        print("LinuxCNC is not installed: no", linuxcnc_run.missing())
        sys.exit(SKIPPED)
    with tempfile.TemporaryDirectory() as folder:
        interpret(program, folder)
    # Half a minute that a sanitized build need not spend again.
    if not os.environ.get("BTG_TEST_QUICK"):
        demonstrate(program)


main()
