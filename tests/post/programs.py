"""Programs and machine files from outside: what `bitangent path --machine` writes for each control
is read back and compared with the path itself, and what it refuses is one clear line.

    python3 programs.py PATH_OF_BITANGENT [unittest's own options]
"""

import copy
import csv
import json
import math
import os
import re
import subprocess
import sys
import tempfile
import unittest

PROGRAM = ""
PART = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "assets",
                    "saddle.gltf")
STEPS = ["--side-step", "40", "--forward-step", "6"]

GOOD = {
    "machine": "mill",
    "rotary": [
        {"axis": "B", "in": "head", "direction": [0, 1, 0], "pivot_mm": [0, 0, 50],
         "limits_deg": [-100, 100], "speed_deg_per_s": 40, "acceleration_deg_per_s2": 200},
        {"axis": "C", "in": "table", "direction": [0, 0, 1], "pivot_mm": [10, 20, 0]},
    ],
    "linear": {"X": {"limits_mm": [-700, 700], "speed_mm_per_s": 300,
                     "acceleration_mm_per_s2": 3000}},
    "part_origin_mm": [1, 2, 3],
    "tool_length_mm": 120,
    "retract_z_mm": 400,
    "program": {"control": "fanuc", "tcp": True, "orientation": "angles", "feed": "per-minute"},
}


def turn(letter, degrees, v):
    s, c = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
    i, j = {"A": (1, 2), "B": (2, 0), "C": (0, 1)}[letter]
    out = list(v)
    out[i], out[j] = c * v[i] - s * v[j], s * v[i] + c * v[j]
    return out


# From a line's words to the tool's axis in the part, written down for each built-in machine.
AXIS = {
    "xyzac-trt": lambda w: turn("C", -w["C"], turn("A", -w["A"], [0, 0, 1])),
    "xyzbc-trt": lambda w: turn("C", -w["C"], turn("B", -w["B"], [0, 0, 1])),
    "fanuc": lambda w: turn("C", w["C"], turn("A", w["A"], [0, 0, 1])),
    "siemens": lambda w: [w["A3="], w["B3="], w["C3="]],
    "heidenhain": lambda w: turn("C", w["C"], turn("B", w["B"], [0, 0, 1])),
}


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def at(self, name):
        return os.path.join(self.folder.name, name)

    def run_program(self, *words):
        return subprocess.run([PROGRAM, "path", PART, *STEPS, "--quiet", *words], timeout=120,
                              stdin=subprocess.DEVNULL, capture_output=True, text=True)

    def program(self, *words):
        """Lines of a program, and the path's rows."""
        done = self.run_program("-o", self.at("o.ngc"), "-o", self.at("o.csv"), *words)
        self.assertEqual((done.returncode, done.stderr), (0, ""), words)
        with open(self.at("o.csv"), newline="") as f:
            rows = [r for r in csv.DictReader(f) if r["status"] != "no-contact"]
        with open(self.at("o.ngc")) as f:
            return f.read().splitlines(), rows

    def write(self, what):
        with open(self.at("m.json"), "w") as f:
            f.write(what if isinstance(what, str) else json.dumps(what))
        return self.at("m.json")

    def bad(self, code, *words, say):
        done = self.run_program("-o", self.at("o.ngc"), *words)
        self.assertEqual(done.returncode, code, done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        self.assertIn(say, done.stderr)
        self.assertFalse(os.path.exists(self.at("o.ngc")), words)

    def refuse(self, say, *steps, value=None, remove=False):
        """A machine file with one member changed, or removed."""
        what = copy.deepcopy(GOOD)
        place = what
        for step in steps[:-1]:
            place = place[step]
        if remove:
            del place[steps[-1]]
        else:
            place[steps[-1]] = value
        self.bad(2, "--machine", self.write(what), say="m.json: " + say)


def motions(lines):
    """Words of the lines that cut, those left out filled in."""
    now = {}
    for line in lines:
        if not re.match(r"(\d+ L|G[01]) ", line):
            continue
        words = re.findall(r"(A3=|B3=|C3=|[XYZABC])([+-]?[\d.]+)", line)
        now = dict(now, **{k: float(v) for k, v in words})
        if "FMAX" in line or line.startswith("G0"):
            continue
        yield now


class Controls(Case):
    def check_path(self, lines, rows, axis):
        """Every position is a block, in order."""
        left = iter(rows)
        row, found = next(left), 0
        for words in motions(lines):
            near = all(abs(words[k] - float(row["tip_" + k.lower()])) < 1e-3 for k in "XYZ")
            a = axis(words)
            near = near and all(abs(u - float(row["axis_" + k])) < 2e-4 for u, k in zip(a, "xyz"))
            if near:
                found += 1
                row = next(left, None)
                if row is None:
                    break
        self.assertEqual(found, len(rows))

    def test_read_back(self):
        for name, axis in AXIS.items():
            lines, rows = self.program("--machine", name)
            self.check_path(lines, rows, axis)

    def test_words(self):
        want = {
            "xyzac-trt": ["G43 H7", "T7 M6", "S1200 M3", "G93", "M2", "G54"],
            "fanuc": ["G43.4 H7", "T7 M6", "S1200 M3", "G49", "M30", "G54", "O0001"],
            "siemens": ["TRAORI", "T7 D1 M6", "S1200 M3", "TRAFOOF", "M30", "G54 D1"],
            "heidenhain": ["TOOL CALL 7 Z S1200", "M128", "M129", "M30", "END PGM SADDLE MM"],
        }
        for name, texts in want.items():
            lines, _ = self.program("--machine", name, "--tool-number", "7", "--spindle", "1200")
            lines = [re.sub(r"^\d+ ", "", x) for x in lines]
            for text in texts:
                self.assertIn(text, lines, name)
        lines, _ = self.program("--machine", "fanuc", "--spindle", "0")
        self.assertFalse([x for x in lines if x in ("M3", "M5") or x.startswith("S")])

    def test_file(self):
        lines, rows = self.program("--machine", self.write(GOOD))
        self.check_path(lines, rows,
                        lambda w: turn("C", -w["C"], turn("B", w["B"], [0, 0, 1])))
        vectors = copy.deepcopy(GOOD)
        vectors["program"]["orientation"] = "vector"
        lines, rows = self.program("--machine", self.write(vectors))
        self.assertIn("G43.5 H1", lines)
        cuts = [x for x in lines if x.startswith("G1") and " I" in x]
        self.assertEqual(len(cuts), len([x for x in lines if " K" in x and x[1] == "1"]))
        self.assertGreaterEqual(len(cuts), len(rows) // 2)

    def test_tool_length(self):
        """Without tool-centre-point control it is in every joint, also from the command line."""
        what = copy.deepcopy(GOOD)
        what["program"] = {"control": "fanuc", "tcp": False}
        short, _ = self.program("--machine", self.write(what))
        long, _ = self.program("--machine", self.write(what), "--tool-length", "170")
        self.assertNotEqual(short, long)
        what["tool_length_mm"] = 170
        self.assertEqual(long, self.program("--machine", self.write(what))[0])
        self.assertIn("G93", long)

    def test_tolerance(self):
        """Finer: more points, more decimals."""
        sizes = {}
        for mm in ("0.02", "0.002", "0.0002"):
            lines, rows = self.program("--machine", "fanuc", "--motion-tolerance", mm)
            sizes[mm] = len(lines), max(len(x) for x in lines)
        self.assertLess(sizes["0.02"], sizes["0.002"])
        self.assertLess(sizes["0.002"], sizes["0.0002"])
        self.assertLess(sizes["0.02"][1], sizes["0.0002"][1])

    def test_feed(self):
        lines, _ = self.program("--machine", "fanuc", "--feed", "250")
        self.assertTrue([x for x in lines if x.endswith(" F250.0")])


class Summary(Case):
    def test_json(self):
        done = subprocess.run([PROGRAM, "path", PART, *STEPS, "--machine", "fanuc", "--json",
                               "-o", self.at("o.ngc")], capture_output=True, text=True)
        program = json.loads(done.stdout)["program"]
        self.assertEqual(program["machine"], "fanuc")
        with open(self.at("o.ngc")) as f:
            moves = [x for x in f if re.match(r"G[01] ", x)]
        self.assertEqual(program["blocks"], len(moves))
        self.assertEqual((program["retracts"], program["rewinds"], program["gaps"]), (4, 0, 0))
        self.assertGreater(program["cut_seconds"], 40)

    def test_table(self):
        done = subprocess.run([PROGRAM, "path", PART, *STEPS, "--machine", "fanuc",
                               "-o", self.at("o.ngc")], capture_output=True, text=True)
        self.assertIn("program     for fanuc: ", done.stdout)


class MachineFiles(Case):
    def test_samples(self):
        """The files beside the parts, and the one the README shows, are as good as they look."""
        root = os.path.join(os.path.dirname(PART), "..")
        folder = os.path.join(root, "assets", "machines")
        files = [os.path.join(folder, name) for name in sorted(os.listdir(folder))]
        with open(os.path.join(root, "README.md")) as f:
            shown = re.findall(r"```json\n(.*?)```", f.read(), re.S)
        self.assertEqual(len(shown), 1)
        self.assertTrue(files)
        for file in files + [self.write(shown[0])]:
            self.program("--machine", file)


    def test_options(self):
        done = self.run_program("-o", self.at("o.ngc"))
        self.assertEqual(done.returncode, 2)
        self.assertIn("--machine", done.stderr)
        self.bad(2, "--machine", "lathe", say="built in are xyzac-trt, xyzbc-trt, fanuc")
        self.bad(2, "--machine", self.at("none.json"), say="none.json: cannot be opened")
        self.bad(2, "--machine", self.folder.name, say="not a regular file")
        self.bad(2, "--machine", "", say="--machine")
        for option in ("--tool-length", "--tool-number", "--spindle", "--motion-tolerance"):
            for value in ("", "x", "-1", "1e9"):
                self.bad(2, "--machine", "fanuc", option, value, say=option)

    def test_text(self):
        for text, say in (("", "not JSON"), ("{", "not JSON"), ("[]", "no object"),
                          ('{"rotary": [1,2}', "rotary[2]: line 1, column 16"), ("1e999", ""),
                          ("[" * 500, "nested deeper"), (" " * 2000000, "larger than 1 MiB")):
            self.bad(2, "--machine", self.write(text), say=say)

    def test_members(self):
        self.refuse("rotaries: is not a member of a machine", "rotaries", value=1)
        self.refuse("rotary[0].limit_deg: is not", "rotary", 0, "limit_deg", value=[0, 1])
        self.refuse("linear.A: is not", "linear", "A", value={})
        self.refuse("program.tpc: is not", "program", "tpc", value=True)
        self.refuse("rotary: is missing", "rotary", remove=True)
        self.refuse("program: is missing", "program", remove=True)
        self.refuse("rotary[1].axis: is missing", "rotary", 1, "axis", remove=True)
        self.refuse("rotary[1].direction: is missing", "rotary", 1, "direction", remove=True)
        self.refuse("program.control: is missing", "program", "control", remove=True)

    def test_values(self):
        self.refuse("rotary: has 1 entries", "rotary", value=[GOOD["rotary"][0]])
        self.refuse("rotary: an array", "rotary", value={})
        self.refuse("rotary[0]: an object", "rotary", 0, value=3)
        self.refuse("rotary[0].axis: 'X' is unknown; give one of A, B, C", "rotary", 0, "axis",
                    value="X")
        self.refuse("rotary[0].in: 'floor' is unknown", "rotary", 0, "in", value="floor")
        self.refuse("rotary[0].direction: has 2 numbers", "rotary", 0, "direction", value=[0, 1])
        self.refuse("rotary[0].direction: no direction", "rotary", 0, "direction",
                    value=[0, 0, 0])
        tilting = {"axis": "A", "in": "table", "direction": [1, 0, 0]}
        self.refuse("rotary[0].direction: parallel to the spindle", "rotary",
                    value=[GOOD["rotary"][1], tilting])
        self.refuse("rotary[1].direction: parallel to the first", "rotary", 1, "direction",
                    value=[0, -1, 0])
        self.refuse("rotary[1].axis: the same letter", "rotary", 1, "axis", value="B")
        self.refuse("rotary[0].limits_deg: no range", "rotary", 0, "limits_deg", value=[10, -10])
        self.refuse("rotary[0].limits_deg[1]: a number", "rotary", 0, "limits_deg",
                    value=[0, "up"])
        self.refuse("rotary[0].speed_deg_per_s: not above 0", "rotary", 0, "speed_deg_per_s",
                    value=0)
        for member in ("speed_mm_per_s", "acceleration_mm_per_s2"):  # feeds would round up from 0
            self.refuse(f"linear.X.{member}: not above 0.0001 mm/s", "linear", "X", member,
                        value=1e-300)
        self.refuse("linear.X.limits_mm: no range", "linear", "X", "limits_mm", value=[5, 5])
        self.refuse("linear.X.acceleration_mm_per_s2: not above", "linear", "X",
                    "acceleration_mm_per_s2", value=-1)
        self.refuse("part_origin_mm: an array", "part_origin_mm", value=0)
        self.refuse("part_origin_mm: not a point", "part_origin_mm", value=[0, 0, 1e7])
        self.refuse("tool_length_mm: not a length", "tool_length_mm", value=-5)
        self.refuse("retract_z_mm: a number", "retract_z_mm", value=None)
        self.refuse("machine: a string", "machine", value=5)
        self.refuse("program.control: 'mazak' is unknown", "program", "control", value="mazak")
        self.refuse("program.tcp: true or false", "program", "tcp", value=1)
        self.refuse("program.orientation: vectors need", "program",
                    value={"control": "heidenhain", "orientation": "vector"})

    def test_limits(self):
        """A machine that cannot: exit code 1, and which joint it is."""
        what = copy.deepcopy(GOOD)
        what["rotary"][0]["limits_deg"] = [-5, 5]
        self.bad(1, "--machine", self.write(what), say="joint B at")
        what = copy.deepcopy(GOOD)
        what["linear"]["X"]["limits_mm"] = [-30, 30]
        self.bad(1, "--machine", self.write(what), say="joint X at")


if __name__ == "__main__":
    PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
