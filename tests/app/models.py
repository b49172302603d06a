"""The models (.glb) that `path` and `verify` write, against the path's own CSV: what stands where,
in metres, y up; that Khronos' validator has nothing to say where it is installed.

    python3 models.py PATH_OF_BITANGENT [unittest's own options]
"""

import json
import math
import os
import shutil
import struct
import subprocess
import sys
import unittest

import program

STEPS = ("--side-step", "12", "--forward-step", "5")
SHANK = ("--shank", "5,6,30", "--holder", "12,30,50")
WIDTH = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}
CODE = {5121: "B", 5125: "I", 5126: "f"}


class Model:
    def __init__(self, path):
        with open(path, "rb") as f:
            data = f.read()
        magic, version, size, length, kind = struct.unpack("<4sIII4s", data[:20])
        assert (magic, version, size, kind) == (b"glTF", 2, len(data), b"JSON")
        self.json = json.loads(data[20 : 20 + length])
        size, kind = struct.unpack("<I4s", data[20 + length : 28 + length])
        assert (kind, 28 + length + size) == (b"BIN\0", len(data))
        self.bin = data[28 + length :]
        self.mesh = {m["name"]: m["primitives"][0] for m in self.json["meshes"]}

    def values(self, index):
        """An accessor as tuples."""
        a = self.json["accessors"][index]
        view = self.json["bufferViews"][a["bufferView"]]
        code = f"<{WIDTH[a['type']]}{CODE[a['componentType']]}"
        end = view["byteOffset"] + view["byteLength"]
        return list(struct.iter_unpack(code, self.bin[view["byteOffset"] : end]))

    def points(self, name, what="POSITION"):
        return self.values(self.mesh[name]["attributes"][what])

    def triangles(self, name):
        i = [v[0] for v in self.values(self.mesh[name]["indices"])]
        return [i[k : k + 3] for k in range(0, len(i), 3)]

    def node(self, name):
        return next(n for n in self.json["nodes"] if n["name"] == name)


def to_gltf(x, y, z):
    return (x / 1000, z / 1000, -y / 1000)


def of(row, name):
    return to_gltf(*(float(row[name + "_" + c]) for c in "xyz"))


def distance(a, b):
    return math.dist(a, b) * 1000  # mm


def turned(q, v):
    """v turned by the quaternion x, y, z, w."""
    x, y, z, w = q
    t = [2 * c for c in (y * v[2] - z * v[1], z * v[0] - x * v[2], x * v[1] - y * v[0])]
    c = (y * t[2] - z * t[1], z * t[0] - x * t[2], x * t[1] - y * t[0])
    return tuple(v[i] + w * t[i] + c[i] for i in range(3))


class Models(program.Case):
    def setUp(self):
        super().setUp()
        self.glb, csv = self.at("path.glb"), self.at("path.csv")
        self.good("path", self.part, "--quiet", *STEPS, *SHANK, "-o", self.glb, "-o", csv)
        self.model, self.rows = Model(self.glb), program.rows_of(csv)

    def assert_near(self, a, b, most=1e-3):
        self.assertLess(distance(a, b), most, (a, b))

    def test_part(self):
        points, normals = self.model.points("part"), self.model.points("part", "NORMAL")
        size = program.SIZE / 1000
        self.assertEqual([round(max(p[k] for p in points), 6) for k in (0, 2)], [size, 0])
        self.assertEqual([round(min(p[k] for p in points), 6) for k in (0, 2)], [0, -size])
        for n in normals:
            self.assertAlmostEqual(math.hypot(*n), 1, delta=1e-5)
        for a, b, c in self.model.triangles("part"):
            ab, ac = ([points[k][i] - points[a][i] for i in range(3)] for k in (b, c))
            up = ab[2] * ac[0] - ab[0] * ac[2]
            self.assertGreater(up, 0)  # the dish looks up, its faces and its normals
            self.assertGreater(normals[a][1], 0)

    def test_path(self):
        lines = self.model.points("path of the tip")
        tips = [of(r, "tip") for r in self.rows]
        links = [i for i in range(1, len(tips)) if self.rows[i]["pass"] == self.rows[i - 1]["pass"]]
        self.assertEqual(len(lines), 2 * len(links))
        for k, i in enumerate(links):
            self.assert_near(lines[2 * k], tips[i - 1])
            self.assert_near(lines[2 * k + 1], tips[i])
        axes = self.model.points("tool axes")
        self.assertEqual(len(axes), 2 * len(tips))
        for i, row in enumerate(self.rows):
            self.assert_near(axes[2 * i], tips[i])
            way = [axes[2 * i + 1][k] - tips[i][k] for k in range(3)]
            length = math.hypot(*way)
            want = [1000 * c for c in of(row, "axis")]
            for k in range(3):
                self.assertAlmostEqual(way[k] / length, want[k], delta=1e-4)

    def test_contacts(self):
        for name, column in (("contacts P", "p"), ("contacts Q", "q")):
            rows = [r for r in self.rows if r["status"] == "two-contact"]
            self.assertGreater(len(rows), 20)
            marks = self.model.points(name)
            self.assertEqual(len(marks), 6 * len(rows))
            for i, row in enumerate(rows):
                corner = marks[6 * i : 6 * i + 6]
                self.assert_near([sum(c[k] for c in corner) / 6 for k in range(3)], of(row, column))
        p, q = (
            self.model.json["materials"][self.model.mesh[n]["material"]]["pbrMetallicRoughness"]
            for n in ("contacts P", "contacts Q")
        )
        self.assertGreater(math.dist(p["baseColorFactor"], q["baseColorFactor"]), 0.5)

    def test_tool(self):
        row = max((r for r in self.rows if r["tip_x"] != "nan"), key=lambda r: float(r["tilt_deg"]))
        tool = self.model.node("tool")
        self.assert_near(tool["translation"], of(row, "tip"))
        axis = turned(tool["rotation"], (0, 1, 0))
        for k in range(3):
            self.assertAlmostEqual(axis[k], 1000 * of(row, "axis")[k], delta=1e-5)
        names = {self.model.json["nodes"][k]["name"] for k in tool["children"]}
        self.assertEqual(names, {"insert", "shank", "holder"})
        for x, y, z in self.model.points("insert"):  # on the torus 6.7, 6, the tip at 0
            ring = math.hypot(math.hypot(x, z) - 0.0067, y - 0.006)
            self.assertAlmostEqual(ring, 0.006, delta=1e-6)
        for x, y, z in self.model.points("holder"):
            self.assertLess(math.hypot(x, z), 0.012 + 1e-6)
            self.assertTrue(0.036 - 1e-6 < y < 0.056 + 1e-6)
        for name in ("insert", "holder"):
            points, normals = self.model.points(name), self.model.points(name, "NORMAL")
            for a, b, c in self.model.triangles(name):
                ab, ac = ([points[k][i] - points[a][i] for i in range(3)] for k in (b, c))
                n = [ab[(i + 1) % 3] * ac[(i + 2) % 3] - ab[(i + 2) % 3] * ac[(i + 1) % 3]
                     for i in range(3)]
                mean = [sum(normals[k][i] for k in (a, b, c)) for i in range(3)]
                self.assertGreater(sum(n[i] * mean[i] for i in range(3)), 0)

    def test_animation(self):
        """Stands at each row in turn, and stays put until it jumps to the next pass."""
        (animation,) = self.model.json["animations"]
        place, turn = animation["samplers"]
        times = [t[0] for t in self.model.values(place["input"])]
        places, turns = self.model.values(place["output"]), self.model.values(turn["output"])
        self.assertTrue(all(a < b for a, b in zip(times, times[1:])))
        for i, row in enumerate(self.rows):
            k = min(range(len(times)), key=lambda k: abs(times[k] - 0.1 * i))
            self.assert_near(places[k], of(row, "tip"))
            axis = turned(turns[k], (0, 1, 0))
            self.assertLess(math.dist(axis, [1000 * c for c in of(row, "axis")]), 1e-4)
        passes = len({r["pass"] for r in self.rows})
        self.assertEqual(len(times), len(self.rows) + passes - 1)

    def test_reads_back(self):
        """A model is a part like any other: what is drawn lies where the part does."""
        summary = json.loads(self.good("path", self.glb, "--json", "--forward-step", "20"))
        self.assertGreater(summary["part"]["triangles"], 1000)

    def test_names(self):
        """A file's name is the scene's, whatever is in it."""
        part = self.at('a "b" \\ <c>.gltf')
        program.make_part(part)
        self.good("path", part, "--quiet", *STEPS, "-o", self.glb)
        self.assertEqual(Model(self.glb).json["scenes"][0]["name"], os.path.basename(part))

    def test_empty_kinds(self):
        """A path of single contacts has no Q, and no empty mesh."""
        self.good("path", self.part, "--quiet", *STEPS, "--max-tilt", "0", "-o", self.glb)
        model = Model(self.glb)
        self.assertNotIn("contacts Q", model.mesh)
        self.assertIn("single contacts P", model.mesh)
        self.assertIn("body, for the eye", model.mesh)

    def test_validator(self):
        node = shutil.which("node")
        if not node:
            self.skipTest("node is not installed")
        csv, names = self.at("path.csv"), [self.glb, self.at("map.glb"), self.at("flat.glb")]
        self.good("verify", self.part, csv, "--grid", "0.5", "--quiet", "-o", names[1])
        self.good("path", self.part, "--quiet", "--tool", "5,0,bullnose", "--max-tilt", "0",
                  "--side-step", "40", "--forward-step", "40", "-o", names[2])
        script = os.path.join(program.ROOT, "tools", "validate_gltf.mjs")
        done = subprocess.run([node, script, *names], stdout=subprocess.PIPE)
        if done.returncode == 77:
            self.skipTest("gltf-validator is not installed")
        self.assertEqual(done.stdout.decode().strip(), "3 files, 0 with errors or warnings")


if __name__ == "__main__":
    program.PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
