"""Motion between positions, from outside: what is inserted, what it is worth by `bitangent verify`,
and that everyone else's rows stay as they were.

    python3 motion.py PATH_OF_BITANGENT [unittest's own options]
"""

import json
import math
import os
import sys
import unittest

import program

CHORD = 0.01
# How deep paths are in their parts, at least, when nothing is done about the way between positions.
PARTS = {"saddle": 3 * CHORD, "concave": 3 * CHORD, "convex": 3 * CHORD, "blade": 10 * CHORD,
         "crease": CHORD / 2}
if os.environ.get("BTG_TEST_QUICK", "0") != "0":
    PARTS = {"saddle": PARTS["saddle"]}


def keys(row):
    return row["pass"], row["point"]


def vector(row, name):
    return [float(row[name + c]) for c in "xyz"]


class Motion(program.Case):
    def make(self, part, *words):
        out = self.at("made.csv")
        told = self.good("path", part, "--json", "-o", out, *words)
        # Where a row stands in the file changes with what is inserted before it.
        return json.loads(told), [{k: v for k, v in row.items() if k != "row"}
                                  for row in program.rows_of(out)]

    def verify(self, part, *words):
        done = self.run_program("verify", part, self.at("made.csv"), "--grid", "0.3", "--json", *words)
        self.assertEqual((done.returncode, done.stderr), (0, b""))
        return json.loads(done.stdout)

    def asset(self, name):
        return os.path.join(program.ROOT, "assets", name + ".gltf")

    def test_swept(self):
        for name, before in PARTS.items():
            with self.subTest(name):
                part = self.asset(name)
                _, plain = self.make(part)
                self.assertGreater(self.verify(part)["max_gouge_mm"], before)
                told, rows = self.make(part, "--chord-tolerance", str(CHORD))
                self.assertLessEqual(self.verify(part)["max_gouge_mm"], CHORD)
                motion = told["motion"]
                self.assertLessEqual(motion["bound_mm"], CHORD)
                self.assertEqual(motion["retracts"], 0)
                lifts = sum(r["status"] == "lift" for r in rows)
                self.assertEqual(len(rows), len(plain) + motion["inserted"] + lifts)
                self.assertEqual(lifts, 2 * motion["hops"])
                # The first row with a number is the footprint's own.
                first = {}
                for row in rows:
                    first.setdefault(keys(row), row)
                self.assertEqual(list(first.values()), plain)

    def test_teapot(self):
        """Falls from edges, overhangs: hops, no retracts."""
        told, rows = self.make(self.asset("teapot"), "--chord-tolerance", "0.02")
        self.assertGreater(told["motion"]["hops"], 0)
        self.assertLessEqual(told["motion"]["bound_mm"], 0.02)
        hops = [i for i, r in enumerate(rows) if r["status"] == "lift"]
        for out, down in zip(hops[::2], hops[1::2]):
            self.assertEqual(down, out + 1)
            for hop, at in ((out, out - 1), (down, down + 1)):
                axis = vector(rows[at], "axis_")
                self.assertEqual(axis, vector(rows[hop], "axis_"))
                way = [a - b for a, b in zip(vector(rows[hop], "tip_"), vector(rows[at], "tip_"))]
                along = sum(a * b for a, b in zip(way, axis))
                self.assertGreater(along, 0)
                self.assertAlmostEqual(math.hypot(*way), along, delta=1e-9)

    def test_axes(self):
        for name, limit in (("concave", 2.0), ("blade", 3.0)):
            with self.subTest(name):
                part = self.asset(name)
                told, rows = self.make(part, "--chord-tolerance", str(CHORD), "--max-axis-change",
                                       str(limit))
                self.assertGreater(told["motion"]["leant"], 0)
                self.assertLessEqual(self.verify(part)["max_gouge_mm"], CHORD)
                greatest = 0
                for a, b in zip(rows, rows[1:]):
                    if a["pass"] != b["pass"] or "nan" in (a["tip_x"], b["tip_x"]):
                        continue
                    if "lift" in (a["status"], b["status"]):
                        continue
                    turn = 2 * math.asin(math.dist(vector(a, "axis_"), vector(b, "axis_")) / 2)
                    way = math.dist(*([float(r["foot_x"]), float(r["foot_y"])] for r in (a, b)))
                    greatest = max(greatest, math.degrees(turn) / way)
                self.assertLessEqual(greatest, limit * (1 + 1e-6))
                self.assertGreater(greatest, limit / 2)

    def test_overrun(self):
        """The footprint reaches beyond the part, and what was left along the edges goes."""
        part, left = self.asset("saddle"), []
        for overrun in (0, 6):
            _, rows = self.make(part, "--side-step", "6", "--overrun", str(overrun))
            for name in ("foot_x", "foot_y"):
                reach = [float(r[name]) for r in rows]
                self.assertAlmostEqual(min(reach), -overrun, delta=1e-9)
                self.assertAlmostEqual(max(reach), 150 + overrun, delta=1e-9)
            left.append(self.verify(part)["scallop_percentiles_mm"]["p99.9"])
        self.assertLess(left[1], left[0] / 2)

    def test_side_step(self):
        """The side step of a scallop height leaves no more than that, well inside the part."""
        step, left = [], []
        for scallop in (0.02, 0.08):
            words = ("--tool", "4,3", "--forward-step", "1", "--scallop", str(scallop),
                     "--side-step", "scallop")
            _, rows = self.make(self.part, *words)
            passes = sorted({float(r["foot_x"]) for r in rows})
            step.append(passes[1] - passes[0])
            left.append(self.verify(self.part, "--tool", "4,3")["scallop_percentiles_mm"]["p50"])
            self.assertLess(left[-1], scallop)
        self.assertGreater(step[1], 1.1 * step[0])

    def test_machine_tilt(self):
        """A machine that leans to 6 degrees: the path keeps to that, and its program is written."""
        machine = {
            "machine": "short", "program": {"control": "linuxcnc"},
            "rotary": [{"axis": "A", "in": "table", "direction": [1, 0, 0], "limits_deg": [-6, 4]},
                       {"axis": "C", "in": "table", "direction": [0, 0, 1]}]}
        name = self.write("short.json", json.dumps(machine))
        words = ("--tool", "4,3", "-o", self.at("a.ngc"), "--machine", name)
        self.bad(1, "path", self.part, "--quiet", *words, say="A")
        told, rows = self.make(self.part, "--max-tilt", "machine", *words)
        self.assertAlmostEqual(told["max_tilt_deg"], 6, delta=1e-6)
        tilts = [float(r["tilt_deg"]) for r in rows if r["status"] == "two-contact"]
        self.assertLessEqual(max(tilts), 6)
        self.bad(2, "path", self.part, "--max-tilt", "machine", say="--machine")

    def test_program(self):
        """What is inserted goes into programs and APT too, hops included."""
        counts = []
        for words in ((), ("--chord-tolerance", "0.002")):
            cl, ngc = self.at("a.cl"), self.at("a.ngc")
            told = self.good("path", self.part, "--tool", "4,3", "--side-step", "30", "--json", "-o", cl,
                             "-o", ngc, "--machine", "xyzac-trt", *words)
            goto = sum(r.startswith("GOTO/") for r in program.records_of(cl))
            told = json.loads(told)
            counts.append((goto, told["program"]["blocks"], told.get("motion", {}).get("inserted", 0)))
        (goto, blocks, _), (goto_after, blocks_after, inserted) = counts
        self.assertGreater(inserted, 0)
        self.assertEqual(goto_after - goto, inserted)
        self.assertGreater(blocks_after, blocks)

    def test_refusals(self):
        for words, say in (
            (("--chord-tolerance", "0"), "1e-6 to 1"),
            (("--chord-tolerance", "x"), "not a number"),
            (("--chord-tolerance", "0.01", "--raw"), "--raw"),
            (("--max-axis-change", "-1"), "not above 0"),
            (("--overrun", "-1"), "0 to 1e6"),
            (("--side-step", "scallop", "--scallop", "1e-5"), "0.001 mm or more"),
            (("--max-axis-change", "5", "--spin", "fixed:10"), "--spin"),
        ):
            self.bad(2, "path", self.part, *words, say=say)


if __name__ == "__main__":
    program.PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
