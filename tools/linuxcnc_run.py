"""LinuxCNC without a display: a program runs under its kinematics module xyzac-trt, and the joints
are sampled on the way. Used by tools/demo-machine and tests/post/linuxcnc.py.

The machine: a tilting table A that carries a rotating table C, OFFSET from it, as in LinuxCNC's
sample configuration."""
import json
import math
import os
import re
import shutil
import subprocess

LENGTH = 80.0  # of the tool
OFFSET = (0.0, 20.0, 10.0)  # of the tilting axis from the rotating one
ORIGIN = (-75.0, -75.0, -60.0)  # of the part


REACH = 12.7  # mm, of the cutter
WINDOW = 2000  # samples among which the next block's end is looked for at a time
NEAR = 0.5  # mm at tip or rim: no further from it is the nearest sample


class Failure(Exception):
    """What went wrong, in one line."""


def missing():
    """The program of LinuxCNC that is not installed, or None."""
    return next((name for name in ("rs274", "linuxcnc") if shutil.which(name) is None), None)


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
XYZAC = machine("xyzac", rotary("A", "table", [1, 0, 0], 100, OFFSET), TABLE_C,
                {"control": "linuxcnc"})


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
loadrt sampler depth=16000 cfg=fffff
addf sampler.0 servo-thread
setp sampler.0.enable 0
setp xyzac-trt-kins.y-offset {1}
setp xyzac-trt-kins.z-offset {2}
"""

DRIVE = r'''#!/usr/bin/python3
"""Stands where a display would: homes, runs one program, writes down the joints on the way."""
import json, signal, subprocess, time
import linuxcnc

command, state, errors = linuxcnc.command(), linuxcnc.stat(), linuxcnc.error_channel()
said, stood = [], []

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
    command.program_open(FOLDER + "/PROGRAM")
    # The controller itself takes the joints each millisecond.
    sampler = subprocess.Popen(["halsampler", FOLDER + "/samples.txt"])
    subprocess.run(["halcmd", "setp", "sampler.0.enable", "1"], check=True)
    command.auto(linuxcnc.AUTO_RUN, 0)
    wait(lambda: state.interp_state != linuxcnc.INTERP_IDLE, 30)
    wait(idle, SECONDS)
    if not idle():
        said.append("the program does not end in %g s" % SECONDS)
    subprocess.run(["halcmd", "setp", "sampler.0.enable", "0"], check=True)
    time.sleep(0.2)
    sampler.send_signal(signal.SIGINT)
    sampler.wait(10)
    mdi("G43 H1")
    for words in STOPS:
        mdi("G0 X%.4f Y%.4f Z%.4f A%.4f C%.4f" % tuple(words))
        time.sleep(0.1)  # the last thousandths come after it says that it stands
        look()
        stood.append(list(state.joint_position[:5]))
except Exception as failure:
    said.append(repr(failure))
with open(FOLDER + "/answer.json", "w") as f:
    json.dump({"errors": said, "stood": stood}, f)
'''


def demand(condition, *words):
    if not condition:
        raise Failure(" ".join(str(w) for w in words))


def write_tools(folder):
    with open(os.path.join(folder, "tool.tbl"), "w") as f:
        f.write("T1 P1 Z%g D25.4\n" % LENGTH)


def configure(folder, program, seconds, stops):
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
        hal += ("net joint%d joint.%d.motor-pos-cmd => joint.%d.motor-pos-fb sampler.0.pin.%d\n"
                % (i, i, i, i))
    write_tools(folder)
    drive = DRIVE.replace("PROGRAM", program)
    for name, value in (("FOLDER", folder), ("ORIGIN", ORIGIN), ("SECONDS", seconds),
                        ("STOPS", stops)):
        drive = drive.replace(name, repr(value))
    for name, text in (("test.ini", ini), ("loop.hal", hal), ("drive", drive)):
        with open(os.path.join(folder, name), "w") as f:
            f.write(text)
    os.chmod(os.path.join(folder, "drive"), 0o755)


def run(folder, program, seconds=120, stops=()):
    """Runs folder/program, then goes to each of the stops (X Y Z A C words). Returns the five joints
    (mm, degrees) each millisecond on the way, and as they stood at the stops. A Failure says what
    LinuxCNC complains of."""
    configure(folder, program, seconds, [list(s) for s in stops])
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
                          stderr=subprocess.STDOUT, timeout=seconds + 80 + 10 * len(stops))
    log = done.stdout.decode(errors="replace")
    file = os.path.join(folder, "answer.json")
    demand(os.path.exists(file), "LinuxCNC did not run:\n" + log[-3000:])
    with open(file) as f:
        answer = json.load(f)
    demand(not answer["errors"], "LinuxCNC says", answer["errors"][:3])
    with open(os.path.join(folder, "samples.txt")) as f:
        lines = f.read().split("\n")[:-1]
    demand(lines and "overrun" not in lines, "samples of the joints are missing")
    # Standing still tells nothing new.
    lines = [b for a, b in zip([""] + lines, lines) if a != b]
    demand(len(lines) > 1, "the joints do not move")
    return [[float(x) for x in line.split()] for line in lines], answer["stood"]


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


def pass_by(blocks, samples):
    """Blocks (X Y Z A C words) in their order against what the joints did: by how much the worst of
    them was missed, mm, at the tip and at the rim."""
    poses = [pose_of(words_of(s)) for s in samples]
    at, worst = 0, [0, 0]
    for block in blocks:
        want, near, off = pose_of(block), at, math.inf
        for first in range(at, len(poses), WINDOW):
            window = range(first, min(first + WINDOW, len(poses)))
            found = min(window, key=lambda i: math.dist(poses[i], want))
            if math.dist(poses[found], want) < off:
                near, off = found, math.dist(poses[found], want)
            if off < NEAR and near < window[-1] - 3:
                break
        around = range(max(1, near - 3), min(near + 4, len(poses)))
        for k, size in enumerate((3, 6)):
            off = min(from_segment(poses[i - 1][:size], poses[i][:size], want[:size])
                      for i in around)
            worst[k] = max(worst[k], off)
        at = max(at, near - 3)
    return worst
