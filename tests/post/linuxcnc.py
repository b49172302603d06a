"""Programs of `bitangent path` in LinuxCNC itself: its interpreter reads all of them, and its
controller runs one whole path whose joints are sampled on the way.

    python3 linuxcnc.py PATH_OF_BITANGENT

Exit code 77: LinuxCNC is not installed.
"""

import csv
import json
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
PART = os.path.join(HERE, "..", "..", "assets", "saddle.gltf")
LENGTH = 80.0  # of the tool
OFFSET = (0.0, 20.0, 10.0)  # of the tilting axis from the rotating one, as in LinuxCNC's sample
ORIGIN = (-75.0, -75.0, -60.0)  # of the part
SKIPPED = 77

RTCP = {"control": "linuxcnc"}
JOINTS = {"control": "linuxcnc", "tcp": False}


def rotary(axis, place, direction, limit=36000, pivot=(0, 0, 0)):
    return {"axis": axis, "in": place, "direction": direction, "pivot_mm": list(pivot),
            "limits_deg": [-limit, limit], "speed_deg_per_s": 90,
            "acceleration_deg_per_s2": 400}


def machine(name, first, second, program):
    linear = {"limits_mm": [-500, 500], "speed_mm_per_s": 200, "acceleration_mm_per_s2": 2000}
    return {"machine": name, "rotary": [first, second], "linear": dict.fromkeys("XYZ", linear),
            "part_origin_mm": list(ORIGIN), "tool_length_mm": LENGTH, "retract_z_mm": 300,
            "program": program}


TABLE_C = rotary("C", "table", [0, 0, 1])
XYZAC = machine("xyzac", rotary("A", "table", [1, 0, 0], 100, OFFSET), TABLE_C, RTCP)
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


def blocks_of(file):
    """Words of every motion line, those left out filled in; None where they are not known yet."""
    now, blocks = dict.fromkeys("XYZABC"), []
    with open(file) as f:
        for line in f:
            words = dict(re.findall(r"([GXYZABCF])(-?[\d.]+)", line.split("(")[0]))
            if words.get("G") not in ("0", "1") or line.startswith("G53"):
                continue
            now.update({k: float(v) for k, v in words.items() if k in now})
            blocks.append(dict(now, rapid=words["G"] == "0", feed=words.get("F")))
    return blocks


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

INI = """[EMC]
VERSION = 1.1
MACHINE = test
[DISPLAY]
DISPLAY = {folder}/drive
[RS274NGC]
PARAMETER_FILE = t.var
[EMCMOT]
EMCMOT = motmod
COMM_TIMEOUT = 1
SERVO_PERIOD = 1000000
[TASK]
TASK = milltask
CYCLE_TIME = 0.001
[HAL]
HALFILE = loop.hal
[KINS]
KINEMATICS = xyzac-trt-kins
JOINTS = 5
[TRAJ]
COORDINATES = XYZAC
LINEAR_UNITS = mm
ANGULAR_UNITS = degree
MAX_LINEAR_VELOCITY = 400
MAX_LINEAR_ACCELERATION = 4000
[EMCIO]
EMCIO = io
CYCLE_TIME = 0.1
TOOL_TABLE = tool.tbl
"""

LIMITS = """MIN_LIMIT = -{limit}
MAX_LIMIT = {limit}
MAX_VELOCITY = {speed}
MAX_ACCELERATION = {rate}
"""

HAL = """loadrt xyzac-trt-kins
loadrt motmod servo_period_nsec=1000000 num_joints=5
addf motion-command-handler servo-thread
addf motion-controller servo-thread
net estop iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in
net prepare iocontrol.0.tool-prepare => iocontrol.0.tool-prepared
net change iocontrol.0.tool-change => iocontrol.0.tool-changed
net length motion.tooloffset.z => xyzac-trt-kins.tool-offset
setp xyzac-trt-kins.y-offset {1}
setp xyzac-trt-kins.z-offset {2}
"""

DRIVE = r'''#!/usr/bin/python3
"""Stands where a display would: homes, runs one program, writes down the joints on the way."""
import json, sys, time
import linuxcnc

command, state, errors = linuxcnc.command(), linuxcnc.stat(), linuxcnc.error_channel()
samples, said = [], []

def look():
    state.poll()
    error = errors.poll()
    if error:
        said.append(error[1])

def wait(done, seconds):
    end = time.monotonic() + seconds
    while True:
        look()
        if done() or time.monotonic() > end:
            return
        time.sleep(0.002)

def idle():
    return state.interp_state == linuxcnc.INTERP_IDLE and state.inpos

def mdi(text):
    command.mode(linuxcnc.MODE_MDI)
    command.wait_complete()
    command.mdi(text)
    command.wait_complete(10)
    wait(idle, 20)

try:
    command.state(linuxcnc.STATE_ESTOP_RESET)
    command.wait_complete()
    command.state(linuxcnc.STATE_ON)
    command.wait_complete()
    command.mode(linuxcnc.MODE_MANUAL)
    command.wait_complete()
    command.teleop_enable(0)
    command.wait_complete()
    command.home(-1)
    wait(lambda: all(state.homed[:5]), 10)
    mdi("G10 L2 P1 X%g Y%g Z%g" % ORIGIN)
    command.mode(linuxcnc.MODE_AUTO)
    command.wait_complete()
    command.program_open(FOLDER + "/xyzac.ngc")
    command.auto(linuxcnc.AUTO_RUN, 0)
    time.sleep(0.2)
    end = time.monotonic() + 120
    while time.monotonic() < end:
        look()
        samples.append([state.motion_line] + list(state.joint_position[:5]))
        if idle():
            break
        time.sleep(0.001)
except Exception as failure:
    said.append(repr(failure))
with open(FOLDER + "/samples.json", "w") as f:
    json.dump({"samples": samples, "errors": said}, f)
'''


def configure(folder):
    ini = INI.format(folder=folder)
    for i, axis in enumerate("XYZAC"):
        turns = axis in "AC"
        limits = LIMITS.format(limit=36000 if axis == "C" else 500, speed=90 if turns else 400,
                               rate=400 if turns else 4000)
        kind = "ANGULAR" if turns else "LINEAR"
        ini += "[AXIS_%s]\n%s[JOINT_%d]\nTYPE = %s\nHOME = 0\nHOME_SEQUENCE = 0\n%s" % (
            axis, limits, i, kind, limits)
    hal = HAL.format(*OFFSET)
    for i in range(5):
        hal += "net joint%d joint.%d.motor-pos-cmd => joint.%d.motor-pos-fb\n" % (i, i, i)
    drive = DRIVE.replace("FOLDER", repr(folder)).replace("ORIGIN", repr(ORIGIN))
    for name, text in (("test.ini", ini), ("loop.hal", hal), ("drive", drive)):
        with open(os.path.join(folder, name), "w") as f:
            f.write(text)
    os.chmod(os.path.join(folder, "drive"), 0o755)


def run_controller(folder):
    more = dict(os.environ, RTAPI_FIFO_PATH=os.path.join(folder, "fifo"), LC_ALL="C.UTF-8")
    more.pop("DISPLAY", None)
    more.pop("LD_PRELOAD", None)
    if os.geteuid() == 0:
        more["RTAPI_UID"] = "1000"
        for root, _, files in os.walk(folder):
            os.chmod(root, 0o777)
            for name in files:
                os.chmod(os.path.join(root, name), 0o777)
    done = subprocess.run(["linuxcnc", os.path.join(folder, "test.ini")], cwd=folder, env=more,
                          stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, timeout=200)
    log = done.stdout.decode(errors="replace")
    file = os.path.join(folder, "samples.json")
    check(os.path.exists(file), "LinuxCNC did not run:\n" + log[-3000:])
    with open(file) as f:
        answer = json.load(f)
    check(not answer["errors"], "LinuxCNC says", answer["errors"][:3])
    return answer["samples"]


def joints_of(words):
    """Where the joints are to stand: written from LinuxCNC's description of its kinematics."""
    a, c = math.radians(words[3]), math.radians(words[4])
    x, y, z = (w + o for w, o in zip(words, ORIGIN))
    x, y = math.cos(c) * x - math.sin(c) * y, math.sin(c) * x + math.cos(c) * y
    y, z = y - OFFSET[1], z - OFFSET[2]
    y, z = math.cos(a) * y - math.sin(a) * z, math.sin(a) * y + math.cos(a) * z
    return x, y + OFFSET[1], z + OFFSET[2] + LENGTH, words[3], words[4]


def words_of(joints):
    """The other way round."""
    a, c = math.radians(joints[3]), math.radians(joints[4])
    x, y, z = joints[0], joints[1] - OFFSET[1], joints[2] - OFFSET[2] - LENGTH
    y, z = math.cos(a) * y + math.sin(a) * z, math.cos(a) * z - math.sin(a) * y
    y, z = y + OFFSET[1], z + OFFSET[2]
    x, y = math.cos(c) * x + math.sin(c) * y, math.cos(c) * y - math.sin(c) * x
    return [x - ORIGIN[0], y - ORIGIN[1], z - ORIGIN[2], joints[3], joints[4]]


def pose_of(words):
    """Tip, and a point of the cutter's rim that shows how far an error of the axis moves it."""
    a, c = math.radians(words[3]), math.radians(words[4])
    axis = math.sin(c) * math.sin(a), math.cos(c) * math.sin(a), math.cos(a)
    return list(words[:3]) + [REACH * x for x in axis]


def from_segment(a, b, p):
    """Largest difference of p from the nearest point between a and b."""
    way = [v - u for u, v in zip(a, b)]
    square = sum(w * w for w in way)
    part = sum(w * (v - u) for w, u, v in zip(way, a, p)) / square if square else 0
    part = min(1, max(0, part))
    return max(abs(u + w * part - v) for u, w, v in zip(a, way, p))


def stray(a, b, w):
    """As words, or as poses: LinuxCNC rounds corners by up to G64's P in mm at the tip, and by as
    much as it likes in degrees, which next to the pole is many of them."""
    return min(from_segment(a, b, w), from_segment(pose_of(a), pose_of(b), pose_of(w)))


REACH = 12.7  # mm, of the cutter
BLEND = 0.05  # mm; measured 0.016, of which the program itself may take 0.002
STEP = 0.5  # mm and degrees between two samples at most, where a block is to be seen
AHEAD = 40  # blocks a sample may be further than the one before


def compare(file, samples):
    blocks = [[b[k] for k in "XYZAC"] for b in blocks_of(file)]
    blocks = [b for b in blocks if None not in b]
    words = [words_of(s[1:]) for s in samples]
    begin = next(i for i, w in enumerate(words) if stray(blocks[0], blocks[1], w) < BLEND)
    end = max(i for i, w in enumerate(words) if stray(blocks[-2], blocks[-1], w) < BLEND)
    at, worst = 0, 0
    for w in words[begin:end + 1]:
        last = min(at + AHEAD, len(blocks) - 1)
        near = [stray(blocks[k], blocks[k + 1], w) for k in range(at, last)]
        worst = max(worst, min(near))
        at += near.index(min(near))
    check(worst < BLEND, "the machine strays from the program by", worst)
    missed = 0
    for block in blocks:
        joints = joints_of(block)
        missed = max(missed, min(max(abs(u - v) for u, v in zip(joints, s[1:]))
                                 for s in samples))
    check(missed < STEP, "a block's joints are not reached: off by", missed)
    print("LinuxCNC runs %d blocks: %d samples, at most %.2g mm from the program; every block's "
          "joints within %.2g mm or degrees of a sample"
          % (len(blocks), end - begin, worst, missed))


def compare_path(file, samples):
    """Tool and tip, from the joints alone, pass through every position that was solved."""
    poses = [pose_of(words_of(s[1:])) for s in samples]
    worst = count = 0
    with open(file, newline="") as f:
        for row in csv.DictReader(f):
            want = [float(row["tip_" + k]) for k in "xyz"]
            want += [REACH * float(row["axis_" + k]) for k in "xyz"]
            near = min(range(len(poses)), key=lambda i: math.dist(poses[i], want))
            off = min(from_segment(poses[i - 1], poses[i], want)
                      for i in range(max(1, near - 3), min(near + 4, len(poses))))
            worst, count = max(worst, off), count + 1
    check(worst < BLEND, "a position is missed by", worst)
    print("%d positions of the path: passed within %.2g mm" % (count, worst))


def control(program, folder):
    path = os.path.join(folder, "path.csv")
    file = make_program(program, folder, XYZAC, "--side-step", "150", "--forward-step", "15",
                        "--tool-length", str(LENGTH), "--feed", "3000", "-o", path)
    configure(folder)
    samples = run_controller(folder)
    compare(file, samples)
    compare_path(path, samples)


def main():
    program = os.path.abspath(sys.argv[1])
    for needed in ("rs274", "linuxcnc"):
        if shutil.which(needed) is None:
            print("LinuxCNC is not installed: no", needed)
            sys.exit(SKIPPED)
    with tempfile.TemporaryDirectory() as folder:
        interpret(program, folder)
        # Half a minute that a sanitized build need not spend again.
        if not os.environ.get("BTG_TEST_QUICK"):
            control(program, folder)


main()
