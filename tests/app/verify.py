"""`bitangent verify` from outside: sound paths pass, broken ones are caught where they are broken,
bad input is refused, and long paths need no more memory.

    python3 verify.py PATH_OF_BITANGENT [unittest's own options]
"""

import csv
import json
import math
import os
import random
import re
import struct
import subprocess
import sys
import unittest

import program

LIMITS = ("--max-gouge", "0.01", "--max-scallop", "0.2")
STEPS = ("--side-step", "2.5", "--forward-step", "1.5", "--chord-tolerance", "0.005")


class Verify(program.Case):
    def setUp(self):
        super().setUp()
        self.path_csv, self.path_cl = self.at("path.csv"), self.at("path.cl")
        self.good("path", self.part, "--tool", "4,3", *STEPS, "--quiet", "-o", self.path_csv,
                  "-o", self.path_cl)

    def verify(self, path, *words, code=0, tool=("--tool", "4,3")):
        done = self.run_program("verify", self.part, path, "--grid", "0.25", "--json", *tool, *words)
        self.assertEqual((done.returncode, done.stderr), (code, b""), done.stdout)
        return json.loads(done.stdout)

    def changed(self, change):
        """The path with a change made to its rows (dictionaries), as a file."""
        rows = program.rows_of(self.path_csv)
        rows = change(rows) or rows
        name = self.at("broken.csv")
        with open(name, "w", newline="") as f:
            writer = csv.DictWriter(f, rows[0].keys(), lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
        return name

    # ---- sound paths

    def test_sound(self):
        v = self.verify(self.path_csv, *LIMITS)
        self.assertIs(v["ok"], True)
        rows = program.rows_of(self.path_csv)
        self.assertEqual(v["positions"], len(rows))
        self.assertGreater(v["steps"], v["positions"])
        self.assertLessEqual(v["max_gouge_mm"], 0.01)
        self.assertLessEqual(v["max_gouge_mm"], v["motion_bound_mm"])
        self.assertLessEqual(v["position_bound_mm"], 0.0012)
        self.assertEqual(v["uncut_area_mm2"], 0)
        self.assertEqual(v["part_cells"], 240 * 240)
        p = v["scallop_percentiles_mm"]
        self.assertTrue(0 <= p["p50"] <= p["p90"] <= p["p99"] <= p["p99.9"] <= v["max_scallop_mm"])
        table = self.good("verify", self.part, self.path_csv, "--tool", "4,3", "--grid", "0.25")
        for word in ("greatest gouge", "most left", "strip width", "removed", "ok in"):
            self.assertIn(word, table)
        self.assertEqual(
            self.good("verify", self.part, self.path_csv, "--tool=4,3", "--grid=1", "--quiet"), "")

    def test_apt(self):
        """The same path from APT, with the tool it names, retracts and rounding included."""
        a = self.verify(self.path_csv)
        b = self.verify(self.path_cl, *LIMITS, tool=())
        self.assertGreater(b["positions"], a["positions"])
        self.assertAlmostEqual(a["max_gouge_mm"], b["max_gouge_mm"], delta=1e-5)
        self.assertAlmostEqual(a["max_scallop_mm"], b["max_scallop_mm"], delta=1e-4)
        self.assertAlmostEqual(a["removed_mm3"], b["removed_mm3"], delta=0.05)

    def test_threads(self):
        a, b = (self.verify(self.path_csv, "--threads", n) for n in "13")
        for v in (a, b):
            v.pop("seconds"), v.pop("threads")
        self.assertEqual(a, b)

    # ---- broken paths

    def test_lowered(self):
        def lower(rows):
            rows[200]["tip_z"] = str(float(rows[200]["tip_z"]) - 0.05)

        v = self.verify(self.changed(lower), *LIMITS, code=1)
        self.assertIs(v["ok"], False)
        at = v["max_gouge_at"]
        self.assertEqual((at["position"], at["line"]), (201, 202))
        self.assertTrue(0.01 < v["max_gouge_mm"] < 0.06, v["max_gouge_mm"])
        self.assertTrue(0.05 <= v["position_bound_mm"] + 0.001)
        row = program.rows_of(self.path_csv)[200]
        touched = [math.dist((at["x"], at["y"], at["z"]), [float(row[c + k]) for k in "xyz"])
                   for c in ("p_", "q_") if row[c + "x"] != "nan"]
        self.assertLess(min(touched), 1.0)

    def test_turned(self):
        def turn(rows):
            for k, a in zip("xyz", (math.sin(0.5), 0, math.cos(0.5))):
                rows[150]["axis_" + k] = str(a)

        v = self.verify(self.changed(turn), *LIMITS, code=1)
        self.assertEqual(v["max_gouge_at"]["position"], 151)
        self.assertEqual(v["bound_at"]["position"], 151)
        self.assertGreater(v["position_bound_mm"], 0.1)

    def test_deleted(self):
        def delete(rows):
            return rows[:100] + rows[101:]

        row = program.rows_of(self.path_csv)[101]
        v = self.verify(self.changed(delete), code=1)
        self.assertEqual(v["missing"], 1)
        self.assertEqual(v["missing_before"], {"pass": int(row["pass"]), "point": int(row["point"])})
        self.assertIs(v["ok"], False)
        self.assertIn("MISSING", self.run_program("verify", self.part, self.at("broken.csv"),
                                                  "--tool", "4,3", "--grid", "1").stdout.decode())

    def test_deleted_by_points(self):
        """Paths without the rows' numbers: passes and points tell."""
        def delete(rows):
            rows = [{k: v for k, v in r.items() if k != "row"} for r in rows]
            last = next(i for i, r in enumerate(rows) if r["pass"] == "4" and r["point"] == "7")
            end = next(i for i, r in enumerate(rows) if r["pass"] == "5")
            assert last < end
            return [r for r in rows if (r["pass"], r["point"]) != ("4", "6")][:end - 1]

        v = self.verify(self.changed(delete), code=1)
        last = int(program.rows_of(self.path_csv)[-1]["pass"])
        self.assertEqual(v["missing"], 1 + last - 4)  # and the passes after
        self.assertEqual(v["missing_before"], {"pass": 4, "point": 7})

    def test_deleted_at_ends(self):
        """All passes have as many points: the last of a pass is missed, and the last of all."""
        def delete(rows, pass_, numbered):
            rows = [r if numbered else {k: v for k, v in r.items() if k != "row"} for r in rows]
            if not numbered:
                seen = set()
                rows = [r for r in rows if not ((r["pass"], r["point"]) in seen
                                                or seen.add((r["pass"], r["point"])))]
            ends = [i for i, r in enumerate(rows) if r["pass"] == pass_]
            top = rows[ends[-1]]["point"]
            gone = {i for i in ends if rows[i]["point"] == top}
            return [r for i, r in enumerate(rows) if i not in gone]

        last = program.rows_of(self.path_csv)[-1]["pass"]
        first = program.rows_of(self.path_csv)[0]["pass"]
        for pass_, numbered in ((first, False), ("4", False), (last, False), (last, True)):
            v = self.verify(self.changed(lambda rows, p=pass_, n=numbered: delete(rows, p, n)), code=1)
            self.assertEqual(v["missing"], 1, (pass_, numbered))

    def plain(self, *words):
        """A path without numbers of its rows, as lines."""
        self.good("path", self.part, "--tool", "4,3", "--side-step", "9", "--forward-step", "4",
                  "--quiet", "-o", self.path_csv, *words)
        with open(self.path_csv) as f:
            return f.readlines()

    def test_last_passes_deleted(self):
        """Passes go from one end of the part to the other: the last ones are missed too."""
        for words in ((), ("--overrun", "3"), ("--footprint", "zigzag"), ("--footprint", "one-way")):
            lines = self.plain(*words)
            self.assertEqual(self.verify(self.path_csv)["missing"], 0, words)
            last = int(lines[-1].split(",")[0])
            for gone in (1, 2, last - 1):
                cut = [line for line in lines if line.split(",")[0] not in
                       {str(last - k) for k in range(gone)}]
                v = self.verify(self.write("cut.csv", "".join(cut)), code=1)
                self.assertEqual(v["missing"], gone, words)
                self.assertEqual(v["missing_before"], {"pass": last + 1 - gone, "point": 0})

    def test_feet_of_their_own(self):
        """Feet from a file stand where they like."""
        feet = ["".join(f"{x} {y}\n" for x in xs for y in (0, 30, 60)) for xs in ((0, 9), (0,))]
        for footprint in ("points:" + self.write("two.txt", feet[0]),
                          "points:" + self.write("one.txt", feet[1]), "contour"):
            self.plain("--footprint", footprint)
            self.assertEqual(self.verify(self.path_csv)["missing"], 0, footprint)

    def test_doubled(self):
        """A row twice in a path whose rows have no numbers."""
        for words in ((), ("--footprint", "one-way")):
            lines = self.plain(*words)
            self.assertEqual(self.verify(self.path_csv)["doubled"], 0)
            for at in (1, 20, len(lines) - 1):
                broken = self.write("broken.csv", "".join(lines[:at + 1] + lines[at:]))
                v = self.verify(broken, code=1)
                self.assertEqual((v["doubled"], v["missing"], v["ok"]), (1, 0, False), at)
        self.assertRegex(self.run_program("verify", self.part, broken, "--tool", "4,3").stdout.decode(),
                         rf"DOUBLED +1 rows .* line {len(lines) + 1}\n")

    def test_bent_passes(self):
        """Passes that are not straight along y may have as many points as they like."""
        def bend(rows):
            rows = [{k: v for k, v in r.items() if k != "row"} for r in rows if r["pass"] in "01"]
            for r in rows:
                r["foot_x"] = r["foot_y"]
            return rows[:-10]

        self.assertEqual(self.verify(self.changed(bend))["missing"], 0)

    def test_record_deleted_from_apt(self):
        """One GOTO in the middle of a pass: nothing is gouged, the file's own count tells."""
        with open(self.path_cl) as f:
            head, *moves = f.read().split("GOTO/")
        broken = self.write("broken.cl", "GOTO/".join([head] + moves[:300] + moves[301:]))
        self.assertEqual(self.verify(self.path_cl, tool=())["missing"], 0)
        self.assertEqual(self.verify(broken, tool=(), code=1)["missing"], 1)

    def test_deleted_from_apt(self):
        """What a pass that ends too soon leaves breaks the limit, there."""
        with open(self.path_cl) as f:
            text = f.read()
        head, *moves = text.split("GOTO/")
        for k in range(500, 640):
            moves[k] = None
        broken = self.write("broken.cl", "GOTO/".join([head] + [m for m in moves if m]))
        self.verify(self.path_cl, *LIMITS, tool=())
        v = self.verify(broken, *LIMITS, tool=(), code=1)
        self.assertTrue(v["max_scallop_mm"] > 0.2 or v["max_gouge_mm"] > 0.01)

    def test_pass_deleted(self):
        gone = sum(r["pass"] in ("9", "10") for r in program.rows_of(self.path_csv))
        v = self.verify(self.changed(lambda rows: [r for r in rows if r["pass"] not in ("9", "10")]), *LIMITS,
                        code=1)
        self.assertEqual(v["missing"], gone)
        self.assertGreater(v["max_scallop_mm"], 0.2)
        self.assertAlmostEqual(v["max_scallop_at"]["x"], 23.75, delta=4)

    def test_limits(self):
        v = self.verify(self.path_csv)
        for option, key in (("--max-gouge", "max_gouge_mm"), ("--max-scallop", "max_scallop_mm")):
            self.verify(self.path_csv, option, repr(v[key] * 1.001))
            self.verify(self.path_csv, option, repr(v[key] * 0.999), code=1)

    def test_holder(self):
        wide = ("--holder", "40,5,50")
        v = self.verify(self.path_csv, *wide)
        self.assertGreater(v["collisions"], 0)
        self.assertGreater(v["collision_mm"], 0)
        self.assertIn("position", v["collision_at"])
        v = self.verify(self.path_csv, *wide, *LIMITS, code=1)
        self.assertLessEqual(v["max_gouge_mm"], 0.01)

    # ---- programs

    def program(self, machine):
        """A program that the machine runs, its path as CSV, and what verification says of that."""
        out = self.at("path.ngc")
        self.good("path", self.part, "--tool", "4,3", *STEPS, "--quiet", "-o", out, "--machine", machine)
        return out

    def lines(self, change, name="broken.ngc"):
        """The program with a change made to its cutting lines: (line, index) -> line or None."""
        with open(self.at("path.ngc")) as f:
            lines = f.read().split("\n")
        # Well inside the part, and with a word for each axis.
        cuts = [i for i, line in enumerate(lines)
                if re.match(r"(G1|\d+ L) X\+?[23]\d\.\d* Y\+?[23]\d\.\d* Z.* [AB]", line)]
        place = cuts[len(cuts) // 2]
        lines[place] = change(lines[place])
        return self.write(name, "\n".join(x for x in lines if x is not None)), place + 1

    def test_programs(self):
        """Joints, angles and vectors: each machine cuts what the path says."""
        want = self.verify(self.path_csv)
        joints = os.path.join(program.ROOT, "assets", "machines", "head-table.json")
        for machine in ("xyzac-trt", "xyzbc-trt", "fanuc", "siemens", "heidenhain", joints):
            v = self.verify(self.program(machine), "--machine", machine, *LIMITS)
            self.assertGreater(v["positions"], want["positions"], machine)
            self.assertAlmostEqual(v["max_gouge_mm"], want["max_gouge_mm"], delta=2e-3)
            self.assertAlmostEqual(v["max_scallop_mm"], want["max_scallop_mm"], delta=5e-3)
            self.assertAlmostEqual(v["removed_mm3"] / want["removed_mm3"], 1, delta=1e-4)
            if machine != "siemens":
                self.assertTrue(0.5 < v["joint_speed"] <= 1.01, v["joint_speed"])

    def test_broken_programs(self):
        def lower(line):
            return re.sub(r"Z\+?(-?[\d.]+)", lambda m: "Z%.4f" % (float(m[1]) - 0.05), line)

        def turn(line):
            return re.sub(r"([AB])\+?(-?[\d.]+)", lambda m: "%s%.3f" % (m[1], float(m[2]) + 10), line)

        for machine in ("xyzac-trt", "heidenhain"):
            self.program(machine)
            for change in (lower, turn):
                name, line = self.lines(change)
                v = self.verify(name, "--machine", machine, *LIMITS, code=1)
                self.assertIn(line, (v["max_gouge_at"]["line"], v["bound_at"]["line"]), (machine, change))
                self.assertGreater(v["max_gouge_mm"], 0.01)
            name, _ = self.lines(lambda line: None)
            v = self.verify(name, "--machine", machine, *LIMITS, code=1)
            self.assertEqual(v["missing"], 1)

    def test_deleted_blocks(self):
        """Any line of a program, but for its part's name and the marks around it."""
        for machine in ("xyzac-trt", "fanuc", "siemens", "heidenhain"):
            out = self.at("path.ngc")
            self.good("path", self.part, "--tool", "4,3", "--side-step", "40", "--forward-step", "40",
                      "--quiet", "-o", out, "--machine", machine)
            with open(out) as f:
                lines = f.read().splitlines(keepends=True)
            words = ("verify", self.part, self.at("less.ngc"), "--tool", "4,3", "--grid", "2", "--quiet",
                     "--machine", machine)
            self.write("less.ngc", "".join(lines))
            self.good(*words)
            for i, line in enumerate(lines):
                if line == "%\n" or "PART " in line or "BITANGENT " in line:
                    continue
                self.write("less.ngc", "".join(lines[:i] + lines[i + 1:]))
                self.assertNotEqual(self.run_program(*words).returncode, 0, (machine, line))

    def test_wrong_machine(self):
        """Angles meant for another table, a feed that no joint can follow, a limit."""
        out = self.program("xyzac-trt")
        turned = json.dumps({"rotary": [{"axis": "A", "in": "table", "direction": [-1, 0, 0]},
                                        {"axis": "C", "in": "table", "direction": [0, 0, 1]}],
                             "program": {"control": "linuxcnc"}})
        v = self.verify(out, "--machine", self.write("turned.json", turned), *LIMITS, code=1)
        self.assertGreater(v["max_gouge_mm"], 0.1)
        with open(out) as f:
            text = f.read()
        fast = self.write("fast.ngc", re.sub(r"(G1 .*)F[\d.]+", r"\1F9000.0", text))
        v = self.verify(fast, "--machine", "xyzac-trt", *LIMITS, code=1)
        self.assertGreater(v["joint_speed"], 2)
        far = self.write("far.ngc", re.sub(r"G0 Z\d+\.\d+", "G0 Z900.0", text))
        self.bad(1, "verify", self.part, far, "--machine", "xyzac-trt", say="far.ngc:12: joint Z comes to")

    # ---- files

    def test_files(self):
        names = [self.at("map." + e) for e in ("csv", "png", "glb")]
        v = self.verify(self.path_csv, *[w for n in names for w in ("-o", n)])
        rows = program.rows_of(names[0])
        self.assertEqual(len(rows), v["part_cells"])
        left = [float(r["deviation"]) for r in rows]
        self.assertAlmostEqual(max(left), v["max_scallop_mm"], delta=1e-8)
        self.assertAlmostEqual(-min(left), v["max_gouge_mm"], delta=1e-8)
        with open(names[1], "rb") as f:
            self.assertEqual(f.read(8), b"\x89PNG\r\n\x1a\n")
        with open(names[2], "rb") as f:
            data = f.read()
        magic, version, size, length, kind = struct.unpack("<4sIII4s", data[:20])
        self.assertEqual((magic, version, size, kind), (b"glTF", 2, len(data), b"JSON"))
        model = json.loads(data[20:20 + length])
        self.assertEqual(model["accessors"][0]["count"], 240 * 240)
        # It is a part like any other.
        self.good("path", names[2], "--side-step", "30", "--forward-step", "30")

    def test_refusals(self):
        def refuse(*words, say):
            return self.bad(2, "verify", *words, say=say)

        refuse(say="no part")
        refuse(self.part, say="no path")
        refuse(self.part, self.path_csv, self.path_csv, say="a third file")
        refuse(self.part, self.at("none.csv"), say="none.csv: cannot read")
        refuse(self.at("none.gltf"), self.path_csv, say="none.gltf")
        refuse(self.part, self.write("path.txt", "x"), say="path.txt: unknown kind")
        refuse(self.part, self.path_csv, "--grid", "0", say="--grid")
        refuse(self.part, self.path_csv, "--grid", "0.0002", say="too many")
        refuse(self.part, self.path_csv, "--max-gouge", "-1", say="--max-gouge")
        refuse(self.part, self.path_csv, "--max-scallop", "x", say="--max-scallop")
        refuse(self.part, self.path_csv, "--side-step", "1", say="--side-step")
        refuse(self.part, self.path_csv, "--links", "some", say="--links")
        refuse(self.part, self.path_csv, "--machine", "lathe", say="built in are")
        refuse(self.part, self.write("a.ngc", "M2\n"), say="a.ngc: a program for a machine")
        for text, say in (("", "it is cut short"), ("M2\n", "no position"), ("G2 X1\n", ":1: 'G2'"),
                          ("G43 H1\nG0 X1 Y1 Z1\n\0", ":3: a zero byte"), ("G91\n", ":1: 'G91'")):
            refuse(self.part, self.write("bad.ngc", text), "--machine", "xyzac-trt", say=say)
        refuse(self.part, self.path_csv, "-o", "map.txt", say="map.txt")
        refuse(self.part, self.path_csv, "-o", self.path_csv, say="is read from")
        with open(self.path_csv) as f:
            header, row = f.read().split("\n")[:2]
        self.assertEqual(header, program.HEADER + ",row")
        header += "\n"
        for text, say in (
            ("", ":1: "), ("a,b\n1,2\n", ":1: "), (header, "no position"),
            (header + row[:40], ":2: "), (header + row.replace(",", ";"), ":2: "),
            (header + "\0" + row, ":2: a zero byte"), (header + "x" * 5000, ":2: the line is longer"),
            (header + row + "\n" + row.replace("0", "x", 1), ":3: "),
        ):
            refuse(self.part, self.write("bad.csv", text), say=say)
        for text, say in (
            ("FINI\n", "no position"), ("GOTO/1,2\n", ":1: GOTO"), ("GOTO/1,2,x\n", ":1: GOTO"),
            ("GOTO/1,2,3,0,0,0\n", ":1: the tool axis"), ("GOTO/1,2,3,0,0,-1\n", ":1: the tool axis"),
            ("GOTO/1,2,$\n", "cut short"), ("GOTO/1,2,3\nCYCLE/DRILL,5\n", ":2: moves or turns"),
            ("CUTTER/3\nGOTO/1,2,3\n", ":1: CUTTER"), ("GOTO/1e9,2,3\n", ":1: the tip"),
        ):
            refuse(self.part, self.write("bad.cl", text), say=say)

    def test_damage(self):
        """Bytes of sound files changed, lost and doubled: an answer, or one line that says why not."""
        random_, codes = random.Random(3), set()
        self.program("siemens")
        files = {"csv": self.path_csv, "cl": self.path_cl, "ngc": self.at("path.ngc")}
        for i in range(30 if os.environ.get("BTG_TEST_QUICK") else 90):
            kind = ("csv", "cl", "ngc")[i % 3]
            with open(files[kind], "rb") as f:
                lines = f.read().split(b"\n")
            data = bytearray(b"\n".join(lines[:40] + lines[-8:]))
            for _ in range(random_.randrange(1, 4)):
                at, size = random_.randrange(len(data)), random_.randrange(1, 30)
                piece = [b"", bytes(data[at:at + size]) * 2, bytes([random_.randrange(256)]),
                         random_.choice([b"-", b"e9", b"1e999", b"nan", b"9" * 40, b"\n", b",", b"$\n"])]
                data[at:at + size] = random_.choice(piece)
            words = ("--machine", "siemens") if kind == "ngc" else ()
            done = self.run_program("verify", self.part, self.write("damaged." + kind, bytes(data)), *words,
                                    "--tool", "4,3", "--grid", "3", "--sweep-error", "0.5", "--quiet",
                                    "--threads", "1")
            codes.add(done.returncode)
            self.assertIn(done.returncode, (0, 1, 2), (kind, data))
            self.assertLessEqual(done.stderr.count(b"\n"), 1, done.stderr)
            if done.returncode == 2:
                self.assertIn(b"damaged." + kind.encode(), done.stderr)
        self.assertIn(2, codes)
        self.assertTrue(codes & {0, 1})

    def test_help(self):
        for words in (["help", "verify"], ["verify", "--help"]):
            self.assertIn("--max-gouge", self.good(*words))

    # ---- length

    def test_memory(self):
        """A path thirty times as long takes no more of it."""
        def peak(count):
            with open(self.at("long.csv"), "w") as f:
                f.write("tip_x,tip_y,tip_z,axis_x,axis_y,axis_z\n")
                for i in range(count):
                    f.write(f"{30 + 25 * math.cos(i):.6f},{30 + 25 * math.sin(i):.6f},20,0,0,1\n")
            child = subprocess.Popen(
                [program.PROGRAM, "verify", self.part, self.at("long.csv"), "--grid", "1",
                 "--sweep-error", "5", "--quiet", "--threads", "2"], stderr=subprocess.DEVNULL)
            _, status, usage = os.wait4(child.pid, 0)
            child.returncode = os.waitstatus_to_exitcode(status)
            self.assertEqual(child.returncode, 0)
            return usage.ru_maxrss

        short, long = peak(5000), peak(150000)
        self.assertLess(long, short * 1.05 + 1024)


if __name__ == "__main__":
    program.PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
