"""The program from outside: every option and every refusal.

    python3 program.py PATH_OF_BITANGENT [unittest's own options]
"""

import base64
import csv
import json
import math
import os
import struct
import subprocess
import sys
import tempfile
import unittest

PROGRAM = ""

HEADER = (
    "pass,point,status,foot_x,foot_y,tip_x,tip_y,tip_z,axis_x,axis_y,axis_z,p_x,p_y,p_z,np_x,np_y,"
    "np_z,q_x,q_y,q_z,nq_x,nq_y,nq_z,drop_z,tilt_deg,spin_deg,inclination_deg"
)
STATUSES = {"two-contact", "osculating", "single-contact", "no-contact", "budget", "lift"}
SIZE = 60.0  # of the part in x and y, mm


def make_part(path, unit=1000):
    """A bicubic dish, 60 mm square, beside two triangles for --use-mesh."""
    control = []
    for i in range(4):
        for j in range(4):
            height = 0.0 if 0 < i < 3 and 0 < j < 3 else 12.0
            x, y, z = SIZE * i / 3, SIZE * j / 3, height + i
            control += [x / unit, z / unit, -y / unit]
    corners = [control[k : k + 3] for k in (0, 9, 36, 45)]
    data = b"".join(struct.pack("<3f", *c) for c in corners) + struct.pack("<6H", 0, 2, 3, 0, 3, 1)
    low = [min(c[k] for c in corners) for k in range(3)]
    high = [max(c[k] for c in corners) for k in range(3)]
    single = lambda v: [struct.unpack("<f", struct.pack("<f", x))[0] for x in v]
    surface = {"degreeU": 3, "degreeV": 3, "countU": 4, "countV": 4, "controlPoints": control}
    gltf = {
        "asset": {"version": "2.0"},
        "extensionsUsed": ["BITANGENT_tensor_surface"],
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [
            {
                "primitives": [
                    {
                        "attributes": {"POSITION": 0},
                        "indices": 1,
                        "extensions": {"BITANGENT_tensor_surface": {"surfaces": [surface]}},
                    }
                ]
            }
        ],
        "accessors": [
            {
                "bufferView": 0,
                "componentType": 5126,
                "count": 4,
                "type": "VEC3",
                "min": single(low),
                "max": single(high),
            },
            {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 12},
        ],
        "buffers": [
            {
                "byteLength": len(data),
                "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode(),
            }
        ],
    }
    with open(path, "w") as f:
        json.dump(gltf, f)


def rows_of(path):
    with open(path, newline="") as f:
        return list(csv.DictReader(f))


def records_of(path):
    """APT records, continuation lines joined."""
    records, pending = [], ""
    with open(path) as f:
        for line in f.read().splitlines():
            pending += line.rstrip("$") if line.endswith("$") else line
            if not line.endswith("$"):
                records.append(pending)
                pending = ""
    assert pending == "", "the last record ends in $"
    return records


def numbers(record):
    return [float(x) for x in record.split("/", 1)[1].split(",")]


ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.dir = self.folder.name
        self.part = self.at("part.gltf")
        make_part(self.part)

    def at(self, name):
        return os.path.join(self.dir, name)

    def write(self, name, text):
        with open(self.at(name), "wb") as f:
            f.write(text if isinstance(text, bytes) else text.encode())
        return self.at(name)

    def run_program(self, *words, **more):
        more.setdefault("stdout", subprocess.PIPE)
        more.setdefault("timeout", 120)
        return subprocess.run(
            [PROGRAM, *words], stderr=subprocess.PIPE, stdin=subprocess.DEVNULL, **more
        )

    def good(self, *words, **more):
        done = self.run_program(*words, **more)
        self.assertEqual((done.returncode, done.stderr), (0, b""), words)
        return done.stdout.decode() if done.stdout is not None else ""

    def path(self, *words):
        """A small path as CSV rows."""
        out = self.at("out.csv")
        self.good("path", self.part, "--side-step", "20", "--forward-step", "10", "-o", out, *words)
        return rows_of(out)

    def bad(self, code, *words, say="", **more):
        before = sorted(os.listdir(self.dir))
        done = self.run_program(*words, **more)
        text = done.stderr.decode()
        self.assertEqual(done.returncode, code, (words, text))
        self.assertEqual(text.count("\n"), 1, (words, text))
        self.assertTrue(text.startswith("bitangent: ") and text.endswith("\n"), text)
        self.assertIn(say, text, words)
        self.assertFalse(done.stdout, words)
        self.assertEqual(sorted(os.listdir(self.dir)), before, words)
        return text


class Commands(Case):
    def test_help_and_version(self):
        self.assertRegex(self.good("--version"), r"^bitangent \d+\.\d+\.\d+\n$")
        for words in (["help"], ["--help"], ["-h"], ["help", "help"]):
            self.assertIn("bitangent path", self.good(*words))
        for words in (["help", "path"], ["path", "--help"], ["path", "-h"]):
            self.assertIn("--side-step", self.good(*words))
        self.assertIn("ready", self.good("help", "info"))

    def test_info(self):
        info = json.loads(self.good("info", "--json"))
        self.assertRegex(info["version"], r"^\d+\.\d+\.\d+$")
        states = {b["name"]: b["state"] for b in info["backends"]}
        self.assertEqual(states["cpu"], "ready")
        self.assertEqual(set(states), {"cpu", "reference", "osmesa", "gl", "vulkan"})
        self.assertLessEqual(set(states.values()), {"not-built", "no-device", "ready"})
        for b in info["backends"]:
            self.assertIsInstance(b["device"], str)
        text = self.good("info")
        for name in states:
            self.assertIn(name, text)

    def test_refusals(self):
        self.bad(2, say="no command")
        self.bad(2, "paht", say="unknown command")
        self.bad(2, "help", "nothing", say="no help")
        self.bad(2, "info", "--jsom", say="--jsom")
        self.bad(2, "plan", say="no part")
        self.bad(2, "plan", "x", "--side-step", "1", say="unknown option")
        self.bad(2, "plan", "x", "-o", self.at("x.pdf"), say=".png or .svg")


class Refusals(Case):
    def refuse(self, option, value, say=""):
        out = ["-o", self.at("out.csv")]
        words = [option] if value is None else [option, value]
        text = self.bad(2, "path", self.part, *out, *words, say=say)
        self.assertIn(option, text)
        if value is not None and option.startswith("--"):
            self.bad(2, "path", self.part, *out, option + "=" + value, say=say)

    def test_values(self):
        wrong = ["", "x", "12abc", "nan", "inf", "0x10", "1,5", " 1", "1e999", "1e"]
        for option in ("--side-step", "--forward-step", "--feed"):
            for value in wrong + ["0", "-1"]:
                self.refuse(option, value)
        for value in wrong + ["-1", "91"]:
            self.refuse("--max-tilt", value)
        for value in wrong + ["0", "-1", "2", "1e-10"]:
            self.refuse("--tolerance", value)
        for value in ("", "x", "0", "-1", "1.5", "1e2", "99999999999"):
            self.refuse("--threads", value)
            self.refuse("--node-budget", value)
        self.refuse("--threads", "1025")
        self.refuse("--feed", "1e7")
        self.refuse("--feed", "1e-300")

    def test_tool(self):
        for value in ("", "6.7", "6.7,6,toroidal,1", "6.7;6", "a,b", "6.7,6,", "1" * 200 + ",1"):
            self.refuse("--tool", value)
        self.refuse("--tool", "6.7,6,ball", say="toroidal or bullnose")
        self.refuse("--tool", "-1,6", say="major radius")
        self.refuse("--tool", "6.7,0", say="bullnose")
        self.refuse("--tool", "0,0,bullnose", say="both radii")
        self.refuse("--tool", "2e6,1")
        for option in ("--shank", "--holder"):
            for value in ("", "5", "5,1", "5,1,2,3", "0,1,2", "-5,1,2", "5,2,1", "5,-1,2", "5,1,x"):
                self.refuse(option, value)
        nine = ["--holder", "5,1,2"] * 9
        self.bad(2, "path", self.part, *nine, say="more than 8")

    def test_words(self):
        for value in ("", "paralel", "one-way:", "one-way:0", "one-way:x", "one-way:2e6", "points:"):
            self.refuse("--footprint", value)
        self.refuse("--method", "magic", say="vcrf")
        self.refuse("--backend", "abacus", say="auto, cpu, reference")
        for value in ("", "fixed", "fixed:", "fixed:x", "fixed:361", "gap", "gap:", "gap:0",
                      "gap:-1", "gap:2e6", "gap:x", "acros", "widest:1"):
            self.refuse("--spin", value)
        for value in ("", "0", "-1", "x", "101"):
            self.refuse("--scallop", value)
        for value in ("", "x", "361"):
            self.refuse("--feed-direction", value)
        for value in ("", "inch", "M"):
            self.refuse("--gltf-unit", value)
        self.refuse("--up", "x", say="y or z")
        for value in ("", "0", "3", "x"):
            self.refuse("--levels", value, say="1 or 2")
        for value in ("0", "-1", "x"):
            self.refuse("--ray-spacing", value)
        for value in ("", "7", "4097", "x"):
            self.refuse("--window", value, say="8 to 4096")
        self.bad(2, "path", self.part, "--json=1", say="takes no value")
        self.bad(2, "path", self.part, "--sidestep", "1", say="unknown option")
        self.bad(2, "path", self.part, "--tool", say="needs a value")

    def test_not_built(self):
        for b in json.loads(self.good("info", "--json"))["backends"]:
            if b["state"] == "not-built":
                self.refuse("--backend", b["name"], say="not built")
            elif b["state"] == "no-device":
                self.bad(1, "path", self.part, "--backend", b["name"], say="no device")

    def test_no_driver(self):
        """Vulkan's loader with no driver behind it: said so, and nothing else runs instead."""
        states = {b["name"]: b["state"] for b in json.loads(self.good("info", "--json"))["backends"]}
        if states["vulkan"] == "not-built":
            self.skipTest("vulkan is not built")
        env = dict(os.environ, VK_DRIVER_FILES="/dev/null", VK_ICD_FILENAMES="/dev/null")
        run = lambda *a: subprocess.run([PROGRAM, *a], env=env, capture_output=True, text=True)
        info = run("info", "--json")
        vulkan = [b for b in json.loads(info.stdout)["backends"] if b["name"] == "vulkan"][0]
        self.assertEqual(vulkan["state"], "no-device")
        self.assertRegex(vulkan["device"], "driver|device|loader")
        path = run("path", self.part, "--backend", "vulkan")
        self.assertEqual(path.returncode, 1)
        self.assertIn("no device", path.stderr)
        self.assertEqual(run("path", self.part, "--quiet").returncode, 0)

    def elsewhere(self, shim, **variables):
        """Runs the program as on another machine."""
        shim = os.path.join(os.path.dirname(PROGRAM), "tests", "app", shim + ".so")
        if not os.path.exists(shim):
            self.skipTest("no device is built")
        # A sanitizer's library wants to be first; it need not.
        asan = os.environ.get("ASAN_OPTIONS", "") + ":verify_asan_link_order=0"
        env = dict(os.environ, LD_PRELOAD=shim, ASAN_OPTIONS=asan, **variables)
        return lambda *a: subprocess.run([PROGRAM, *a], env=env, capture_output=True, text=True)

    def test_old_vulkan(self):
        """Vulkan 1.1 is enough, in the loader and in the device: the same path. 1.0 is not."""
        state = {b["name"]: b["state"] for b in json.loads(self.good("info", "--json"))["backends"]}
        if state["vulkan"] != "ready":
            self.skipTest("vulkan is " + state["vulkan"])
        work = ("path", self.part, "--quiet", "--backend", "vulkan", "-o", "csv:-")
        run = self.elsewhere("old_vulkan")
        self.assertRegex(run("info").stdout, r"driver version [\d.]+; Vulkan 1\.1\.0;")
        done = run(*work)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual(done.stdout, self.good(*work))
        for variable in ("BTG_TEST_LOADER", "BTG_TEST_DEVICE"):
            done = self.elsewhere("old_vulkan", **{variable: "1.0"})(*work)
            self.assertEqual(done.returncode, 1)
            self.assertRegex(done.stderr, r"^bitangent: back end 'vulkan' .*Vulkan 1\.1.*\n$")

    def test_no_library(self):
        """Where neither Vulkan nor OpenGL is installed: all else works, and what is missing is
        named, with what to install."""
        run = self.elsewhere("no_devices")
        info = run("info", "--json")
        self.assertEqual(info.returncode, 0)
        names = {"vulkan": ("libvulkan", "libvulkan1"), "gl": ("libOSMesa|libEGL", "libosmesa6|libegl1"),
                 "osmesa": ("libOSMesa|libEGL", "libosmesa6|libegl1")}
        for b in json.loads(info.stdout)["backends"]:
            if b["name"] not in names or b["state"] == "not-built":
                continue
            self.assertEqual(b["state"], "no-device")
            for pattern in names[b["name"]]:
                self.assertRegex(b["device"], pattern)
            done = run("path", self.part, "--backend", b["name"])
            self.assertEqual((done.returncode, done.stdout), (1, ""))
            self.assertRegex(done.stderr, r"^bitangent: back end '\w+' finds no device here: .*install.*\n$")
            done = run("path", self.part, "--quiet", "--backend", b["name"] + ",auto")
            self.assertEqual(done.returncode, 0)
            self.assertRegex(done.stderr, b["name"] + ": .*; back end cpu went on\n$")
        self.assertEqual(run("path", self.part, "--quiet").stderr, "")

    def test_instead(self):
        """NAME,auto is that one where it is ready, and says nothing then."""
        out = json.loads(self.good("path", self.part, "--backend", "reference,auto", "--json",
                                   "--side-step", "75", "--forward-step", "50"))
        self.assertEqual((out["backend"], out["backend_note"]), ("reference", ""))
        for word in ("cpu,gl", "cpu,", ",auto", "nix,auto", "cpu,auto,gl"):
            self.refuse("--backend", word, say="--backend")

    def test_vulkan(self):
        self.compare_device("vulkan")

    def test_gl(self):
        self.compare_device("gl")

    def test_gl_context(self):
        """Either provider: the same path, bit for bit."""
        self.refuse("--gl-context", "glx", say="osmesa")
        files = []
        for name in ("osmesa", "egl"):
            files.append(self.at(name + ".csv"))
            done = self.run_program("path", self.part, "--backend", "gl", "--gl-context", name,
                                    "-o", files[-1])
            if b"no" in done.stderr and done.returncode == 1:
                self.skipTest(done.stderr.decode())
            self.assertEqual((done.returncode, done.stderr), (0, b""))
        with open(files[0], "rb") as a, open(files[1], "rb") as b:
            self.assertEqual(a.read(), b.read())

    def compare_device(self, device):
        """The cpu's path, with all that single precision takes away put back."""
        states = {b["name"]: b["state"] for b in json.loads(self.good("info", "--json"))["backends"]}
        if states[device] != "ready":
            self.skipTest(device + " is " + states[device])
        rows = {}
        for name in ("cpu", device):
            self.good("path", self.part, "--backend", name, "-o", self.at(name + ".csv"))
            with open(self.at(name + ".csv"), newline="") as file:
                rows[name] = list(csv.DictReader(file))
        self.assertEqual(len(rows["cpu"]), len(rows[device]))
        for a, b in zip(rows["cpu"], rows[device]):
            self.assertEqual(a["status"], b["status"])
            for key, most in (("drop_z", 1e-6), ("tilt_deg", 1e-4)):
                if a[key] != "nan":
                    self.assertLess(abs(float(a[key]) - float(b[key])), most)
        raw = json.loads(self.good("path", self.part, "--backend", device, "--raw", "--json"))
        self.assertEqual(raw["backend"], device)
        self.assertGreater(raw["times"]["device_seconds"], 0)

    def test_parts(self):
        self.bad(2, "path", say="no part")
        self.bad(2, "path", "", say="empty")
        self.bad(2, "path", self.part, self.part, say="two parts")
        self.bad(2, "path", self.at("missing.gltf"), say="missing.gltf")
        self.bad(2, "path", self.dir)
        self.bad(2, "path", self.write("x.gltf", "{}"), say="x.gltf")
        self.bad(2, "path", self.at("a\nb.gltf"), say="a?b.gltf")
        self.bad(2, "path", "--", "--json", say="--json")

    def test_outputs(self):
        for name in ("out", "out.txt", "csv", ".", "out.csv.", "a.csv/b"):
            self.refuse("-o", self.at(name), say=".csv, .json, .cl, .png, .glb, .html or .ngc")
        self.bad(2, "path", self.part, "-o", "a.csv", "-o", "a.csv", say="twice")
        self.refuse("-o", "csv:", say="no file")
        many = [w for i in range(17) for w in ("-o", self.at("%d.csv" % i))]
        self.bad(2, "path", self.part, *many, say="more than 16")

    def test_inputs_stay(self):
        points = self.write("points.csv", "1 2\n")
        self.bad(
            2, "path", self.part, "--footprint", "points:" + points, "-o", points, say="is read from"
        )
        os.link(self.part, self.at("same.json"))
        self.bad(2, "path", self.part, "-o", self.at("same.json"), say="is read from")

    def test_too_many_points(self):
        self.bad(2, "path", self.part, "--side-step", "1e-6", say="larger steps")


class Csv(Case):
    def test_format(self):
        rows = self.path()
        with open(self.at("out.csv")) as f:
            lines = f.read().split("\n")
        self.assertEqual(lines[0], HEADER)
        self.assertEqual(lines[-1], "")
        self.assertEqual(len(rows), 4 * 7)
        for line in lines[1:-1]:
            cells = line.split(",")
            self.assertEqual(len(cells), 27)
            self.assertIn(cells[2], STATUSES)
            for cell in cells[3:]:
                self.assertTrue(cell == "nan" or "%.17g" % float(cell) == cell, cell)
        feet = [(float(r["foot_x"]), float(r["foot_y"])) for r in rows]
        x = [0, 20, 40, 60]
        self.assertEqual(feet, [(x[i // 7], 10.0 * (i % 7)) for i in range(28)])
        self.assertEqual([(int(r["pass"]), int(r["point"])) for r in rows],
                         [(i // 7, i % 7) for i in range(28)])

    def test_meaning(self):
        for r in self.path():
            v = {k: float(x) for k, x in r.items() if k != "status"}
            axis = [v["axis_" + c] for c in "xyz"]
            self.assertAlmostEqual(math.hypot(*axis), 1, 12)
            self.assertIn(r["status"], ("two-contact", "osculating"))
            # P lies on the insert: Ri from the major circle about the torus centre.
            for name in "pq":
                centre = [v["tip_" + c] + 6 * a for c, a in zip("xyz", axis)]
                arm = [v["%s_%s" % (name, c)] - m for c, m in zip("xyz", centre)]
                h = sum(a * b for a, b in zip(arm, axis))
                radius = math.sqrt(max(0, sum(a * a for a in arm) - h * h))
                self.assertAlmostEqual(math.hypot(radius - 6.7, h), 6, 2)

    def test_threads_do_not_show(self):
        texts = []
        for threads in ("1", "2", "7"):
            self.path("--threads", threads)
            with open(self.at("out.csv"), "rb") as f:
                texts.append(f.read())
        self.assertEqual(texts[0], texts[1])
        self.assertEqual(texts[0], texts[2])


class Options(Case):
    def test_steps(self):
        out = self.at("a.csv")
        self.good("path", self.part, "-o", out)
        self.assertEqual(len(rows_of(out)), 5 * 31)  # 0 18 36 54 60 by 0 2 ... 60
        self.good("path", self.part, "-o", out, "--side-step=7e1", "--forward-step=25")
        self.assertEqual([float(r["foot_y"]) for r in rows_of(out)], [0, 25, 50, 60] * 2)

    def test_contour(self):
        """Around a square: each pass closed, a side step inside the one before, to the middle."""
        words = ("path", self.part, "-o", self.at("c.csv"), "--footprint", "contour", "--side-step",
                 "8", "--forward-step", "1.5")
        if b"no Clipper" in self.run_program(*words).stderr:
            self.skipTest("built without Clipper")
        passes = {}
        for row in rows_of(self.at("c.csv")):
            point = passes.setdefault(int(row["pass"]), [])
            self.assertEqual(int(row["point"]), len(point))
            point.append((float(row["foot_x"]), float(row["foot_y"])))
        # 60 mm wide: 0, 8, 16, 24 mm in, and half a step farther.
        for points, inside in zip(passes.values(), (0, 8, 16, 24, 28), strict=True):
            self.assertEqual(points[0], points[-1])
            steps = [math.dist(a, b) for a, b in zip(points, points[1:])]
            self.assertLessEqual(max(steps), 1.5 + 1e-4)
            self.assertGreater(sum(steps), 4 * (SIZE - 2 * inside) - 3)
            for x, y in points:
                self.assertAlmostEqual(min(x, y, SIZE - x, SIZE - y), inside, delta=2e-3)
        row = rows_of(self.at("c.csv"))
        self.good(*words, "--overrun", "2")
        x = [float(r["foot_x"]) for r in rows_of(self.at("c.csv")) if r["pass"] == "0"]
        self.assertAlmostEqual(min(x), -2, delta=2e-3)
        self.assertAlmostEqual(max(x), SIZE + 2, delta=2e-3)
        self.assertGreater(len(rows_of(self.at("c.csv"))), len(row))
        self.bad(2, *words[:-1], "1e-6", say="contour: too many points")

    def test_zigzag(self):
        rows = self.path("--footprint", "zigzag")
        y = [float(r["foot_y"]) for r in rows]
        self.assertEqual(y[:7], y[7:14][::-1])
        straight = {(r["foot_x"], r["foot_y"]): r["tip_z"] for r in self.path()}
        for r in rows:
            self.assertEqual(straight[r["foot_x"], r["foot_y"]], r["tip_z"])

    def test_one_way(self):
        for words, lift in ((["one-way"], 20), (["one-way:3.5"], 3.5)):
            rows = self.path("--footprint", *words)
            self.assertEqual(len(rows), 4 * 9)
            summary = json.loads(self.good("path", self.part, "--json"))
            top = summary["part"]["box_max_mm"][2]
            for i, r in enumerate(rows):
                self.assertEqual(r["status"] == "lift", i % 9 in (0, 8))
                if r["status"] != "lift":
                    continue
                near = rows[i + 1] if i % 9 == 0 else rows[i - 1]
                for name in ("axis_x", "axis_y", "axis_z", "tip_x", "tip_y", "pass", "point"):
                    self.assertEqual(r[name], near[name])
                lean = math.acos(min(1, float(r["axis_z"])))
                droop = 6.7 * math.sin(lean) + 6 - 6 * math.cos(lean)
                self.assertAlmostEqual(float(r["tip_z"]), top + lift + droop, 6)
                self.assertEqual(r["p_x"], "nan")
                self.assertEqual(r["tilt_deg"], "nan")

    def test_one_way_over_chunks(self):
        """Lifts lean as their own position does, wherever the work is cut."""
        out = self.at("a.csv")
        self.good("path", self.part, "-o", out, "--footprint", "one-way", "--side-step", "0.5",
                  "--forward-step", "29")
        rows = rows_of(out)
        self.assertEqual(len(rows), 121 * 6)
        for i, r in enumerate(rows):
            if r["status"] == "lift":
                near = rows[i + 1] if i % 6 == 0 else rows[i - 1]
                self.assertEqual(r["axis_x"], near["axis_x"])

    def test_points(self):
        text = b"\xef\xbb\xbf# x y\n\n10 20\n 30,40 # here\n\t5\t6\t\r\n1e1 , 2.5"
        rows = self.path("--footprint", "points:" + self.write("p.txt", text))
        feet = [(float(r["foot_x"]), float(r["foot_y"])) for r in rows]
        self.assertEqual(feet, [(10, 20), (30, 40), (5, 6), (10, 2.5)])
        self.assertEqual([r["point"] for r in rows], ["0", "1", "2", "3"])

    def test_bad_points(self):
        long = "1" * 2000
        wrong = {
            "1 2\n3\n": ":2: y is not",
            "1 2\n\n# x\nx 3\n": ":4: x is not",
            "1 2 3\n": ":1: more than two",
            "1 2,\n": ":1: more than two",
            "1,,2\n": ":1: y is not",
            "1 nan\n": ":1: y is not",
            "1 0x2\n": ":1: y is not",
            "1 2\x00\n": ":1: a zero byte",
            "1 1e7\n": ":1: the point is",
            "# nothing\n": "no points",
            "": "no points",
            long: ":1: the line is longer",
            "1 " + "9" * 70 + "\n": ":1: y is not",
        }
        for text, say in wrong.items():
            p = self.write("p.txt", text)
            self.bad(2, "path", self.part, "--footprint", "points:" + p, say="p.txt" + (
                say if say[0] == ":" else ": " + say))
        self.bad(2, "path", self.part, "--footprint", "points:" + self.at("none"), say="cannot read")
        self.bad(2, "path", self.part, "--footprint", "points:" + self.dir, say="cannot read")
        self.bad(2, "path", self.part, "--footprint", "points:/dev/zero", say="zero byte")

    def test_tool(self):
        default = self.path()
        self.assertEqual(default, self.path("--tool", "6.7,6"))
        self.assertEqual(default, self.path("--tool", "6.7,6,toroidal"))
        other = self.path("--tool", "3,2,bullnose")
        self.assertNotEqual([r["tip_z"] for r in default], [r["tip_z"] for r in other])
        ball = self.path("--tool", "0,5")
        self.assertEqual({r["status"] for r in ball}, {"single-contact"})
        self.assertEqual({float(r["tilt_deg"]) for r in ball}, {0.0})

    def test_shank_and_holder(self):
        default = self.path()
        for option in ("--shank", "--holder"):
            wide = self.path(option, "60,8,100")
            self.assertEqual(default, self.path(option, "1,50,100"))
            self.assertNotEqual(default, wide)
            higher = [float(b["tip_z"]) >= float(a["tip_z"]) - 1e-6 for a, b in zip(default, wide)]
            self.assertIn(True, higher)
        two = self.path("--holder", "1,50,60", "--holder", "60,8,100")
        self.assertEqual(two, self.path("--holder", "60,8,100"))

    def test_solver(self):
        default = self.path("--method", "vcrf", "--spin", "none")
        self.assertEqual(default, self.path())
        spun = self.path("--spin", "fixed:30")
        self.assertIn(30.0, {round(float(r["spin_deg"]), 9) for r in spun})
        low = self.path("--max-tilt", "0.5")
        self.assertIn("single-contact", {r["status"] for r in low})
        for r in low:
            self.assertLessEqual(float(r["tilt_deg"]), 0.5 + 1e-9)
        short = self.path("--node-budget", "3")
        self.assertIn("budget", {r["status"] for r in short})
        for a, b in zip(default, short):
            self.assertGreater(float(b["drop_z"]), float(a["drop_z"]) - 1e-3)
        fine = self.path("--tolerance", "1e-6")
        for a, b in zip(default, fine):
            self.assertLess(abs(float(a["drop_z"]) - float(b["drop_z"])), 1e-3)

    def test_spin(self):
        self.part = os.path.join(ROOT, "assets", "saddle.gltf")
        words = ["--side-step", "50", "--forward-step", "30"]
        out = self.at("out.csv")
        gap = ["--spin", "gap:5", *words]
        said = json.loads(self.good("path", self.part, "--json", "-o", out, *gap))
        met = 0
        for r in rows_of(out):
            pq = [float(r["q_" + c]) - float(r["p_" + c]) for c in "xyz"]
            met += abs(math.hypot(*pq) - 5) <= 1e-4
        self.assertEqual((said["spin"], said["gap_mm"], said["spin_met"]), ("gap", 5, met))
        self.assertGreater(met, said["positions"] / 2)
        self.assertIn(f"met at {met} of", self.good("path", self.part, *gap))

        def axes(*spin):
            return [r["axis_x"] for r in self.path(*words, "--spin", *spin)]

        turned = axes("across", "--feed-direction", "0")
        self.assertNotEqual(axes("across"), turned)
        self.assertEqual(axes("across"), axes("across", "--feed-direction", "90"))
        self.assertNotEqual(axes("widest"), axes("widest", "--scallop", "0.1"))
        self.assertNotEqual(axes("widest"), axes("widest", "--feed-direction", "0"))
        self.assertEqual(axes("widest"), axes("widest", "--threads", "1"))

    def test_backends(self):
        points = "points:" + self.write("p.txt", "10 20\n30 31\n")
        rows = {b: self.path("--footprint", points, "--backend", b)
                for b in ("auto", "cpu", "reference")}
        self.assertEqual(rows["auto"], rows["cpu"])
        for a, b in zip(rows["cpu"], rows["reference"]):
            self.assertAlmostEqual(float(a["drop_z"]), float(b["drop_z"]), 3)
            self.assertAlmostEqual(float(a["tilt_deg"]), float(b["tilt_deg"]), 1)
        for b in ("cpu", "reference"):
            summary = json.loads(self.good(
                "path", self.part, "--footprint", points, "--backend", b, "--json"))
            self.assertEqual(summary["backend"], b)

    def test_part(self):
        def box(*words):
            part = json.loads(self.good("path", self.part, "--json", *words))["part"]
            return [b - a for a, b in zip(part["box_min_mm"], part["box_max_mm"])], part

        size, part = box()
        self.assertEqual([round(s, 6) for s in size[:2]], [60, 60])
        self.assertEqual((part["surfaces"], part["triangles"]), (1, 0))
        self.assertEqual([round(s, 6) for s in box("--up", "z")[0]],
                         [round(s, 6) for s in (size[0], size[2], size[1])])
        size, part = box("--use-mesh")
        self.assertEqual((part["surfaces"], part["triangles"]), (0, 2))
        make_part(self.part, 1)
        self.assertEqual([round(s, 6) for s in box("--gltf-unit", "mm")[0][:2]], [60, 60])

    def test_summary(self):
        text = self.good("path", self.part, "-o", self.at("out.csv"))
        for word in ("part.gltf", "1 surface", "toroidal", "parallel", "positions", "155",
                     "two-contact", "median", "positions/s", "cpu", "out.csv"):
            self.assertIn(word, text)
        self.assertEqual(self.good("path", self.part, "--quiet"), "")

    def test_json(self):
        s = json.loads(self.good("path", self.part, "--json", "--quiet", "--threads", "2"))
        self.assertEqual(s["positions"], 155)
        self.assertEqual((s["method"], s["backend"], s["threads"]), ("vcrf", "cpu", 2))
        self.assertEqual(sum(s["statuses"].values()), 155)
        self.assertEqual(set(s["statuses"]), STATUSES)
        self.assertAlmostEqual(s["positions_per_second"] * s["seconds"], 155, 6)

    def test_json_file(self):
        out = self.at("out.json")
        rows = self.path("-o", out, "--footprint", "one-way")
        with open(out) as f:
            whole = json.load(f)
        self.assertEqual(whole["summary"]["positions"], 28)
        self.assertEqual(whole["summary"]["statuses"]["lift"], 8)
        self.assertEqual(len(whole["positions"]), len(rows))
        for a, b in zip(whole["positions"], rows):
            self.assertEqual(list(a), HEADER.split(","))
            for name, value in a.items():
                if name == "status":
                    self.assertEqual(value, b[name])
                else:
                    self.assertTrue(b[name] == "nan" if value is None else value == float(b[name]))

    def test_nothing_touched(self):
        points = "points:" + self.write("p.txt", "500 500\n")
        self.bad(1, "path", self.part, "--footprint", points, "-o", self.at("out.csv"),
                 say="no position touches")
        points = "points:" + self.write("p.txt", "500 500\n30 30\n")
        self.assertEqual(self.path("--footprint", points)[0]["tip_z"], "nan")


    def on_terminal(self, *words):
        """Standard error of a run whose standard error is a terminal."""
        try:
            master, slave = os.openpty()
        except OSError as error:
            self.skipTest("no pseudo-terminal here: %s" % error)
        child = subprocess.Popen([PROGRAM, *words], stdout=subprocess.DEVNULL, stderr=slave)
        os.close(slave)
        text = b""
        try:
            while chunk := os.read(master, 4096):
                text += chunk
        except OSError:
            pass
        os.close(master)
        self.assertEqual(child.wait(60), 0)
        return text.decode()

    def test_progress(self):
        text, step = "", 2.0
        while "left" not in text and step > 0.01:  # work of more than 0.3 seconds
            step /= 2
            words = ["path", self.part, "--side-step", str(step), "--forward-step", str(step)]
            text = self.on_terminal(*words)
        self.assertRegex(text, r"\[[#.]+\] +\d+ %  \d+ positions/s  \d+ s left")
        self.assertTrue(text.endswith("\r\033[K"))
        self.assertEqual(self.on_terminal(*words, "--quiet"), "")


if __name__ == "__main__":
    PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
