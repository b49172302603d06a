"""What the program writes: APT, pictures, and every way a file cannot be written.

    python3 program_files.py PATH_OF_BITANGENT [unittest's own options]
"""

import json
import math
import os
import resource
import signal
import stat
import struct
import subprocess
import sys
import threading
import time
import unittest

import program
from program import Case, rows_of, records_of, numbers


class Apt(Case):
    def test_syntax(self):
        out = self.at("out.cl")
        rows = self.path("-o", out, "--feed", "1234.5", "--tool", "3,2", "--shank", "2,5,40")
        with open(out) as f:
            lines = f.read().split("\n")
        self.assertEqual(lines.pop(), "")
        for line in lines:
            self.assertLess(len(line), 72)
            self.assertNotRegex(line.split("PARTNO")[0], r"\d[eE]|nan|inf")
        records = records_of(out)
        self.assertEqual(records[:3], ["PARTNO part", "UNITS/MM", "MULTAX/ON"])
        self.assertEqual(records[-1], "FINI")
        self.assertEqual(numbers(records[3]), [10, 2, 3, 2, 0, 0, 42])
        self.assertEqual(records[4], "FEDRAT/1234.500000,MMPM")
        feeds, rapids, previous = [], [], ""
        self.assertEqual(records[-2], f"PPRINT MOVES {sum(r.startswith('GOTO') for r in records)}")
        for r in records[5:-2]:
            self.assertIn(r.split("/")[0], ("RAPID", "GOTO"))
            if r.startswith("GOTO"):
                self.assertEqual(len(numbers(r)), 6)
                self.assertAlmostEqual(math.hypot(*numbers(r)[3:]), 1, 8)
                (rapids if previous == "RAPID" else feeds).append(numbers(r))
            previous = r
        self.assertEqual(len(feeds), len(rows))
        for g, r in zip(feeds, rows):
            for value, name in zip(g, ("tip_x", "tip_y", "tip_z", "axis_x", "axis_y", "axis_z")):
                self.assertAlmostEqual(value, float(r[name]), 6)
        # Up, across and down between the 4 passes, once before and once after.
        self.assertEqual(len(rapids), 2 * 4)
        for g in rapids:
            self.assertGreater(g[2], 12 + 20 - 1)

    def test_links(self):
        out = self.at("out.cl")
        for kind, rapids in (("parallel", 8), ("one-way", 8), ("zigzag", 2)):
            rows = self.path("-o", out, "--footprint", kind)
            records = records_of(out)
            self.assertEqual(records.count("RAPID"), rapids, kind)
            solved = [r for r in rows if r["status"] != "lift"]
            self.assertEqual(sum(r.startswith("GOTO") for r in records) - rapids, len(solved))

    def test_gap(self):
        out = self.at("out.cl")
        points = self.write("p.txt", "10 10\n20 10\n500 500\n30 10\n500 500\n")
        self.path("-o", out, "--footprint", "points:" + points)
        records = [r.split("/")[0] for r in records_of(out)[5:]]
        move = ["RAPID", "GOTO"]
        self.assertEqual(records, move + ["GOTO"] * 2 + move * 2 + ["GOTO"] + move
                         + ["PPRINT MOVES 7", "FINI"])


class Picture(Case):
    def setUp(self):
        super().setUp()
        done = self.run_program("path", self.part, "-o", self.at("probe.png"))
        if b"draws no pictures" in done.stderr:
            self.assertEqual(done.returncode, 2)
            self.skipTest("built without Cairo")

    def draw(self, *words, part=None):
        out = self.at("out.png")
        self.good("path", part or self.part, "--quiet", "-o", out, *words)
        with open(out, "rb") as f:
            return f.read()

    def test_format(self):
        data = self.draw("--side-step", "20")
        self.assertEqual(data[:16], b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR")
        width, height = struct.unpack(">2I", data[16:24])
        self.assertEqual(width, 1400)
        self.assertTrue(800 <= height <= 1000, height)
        self.assertEqual(data[-8:-4], b"IEND")

    def test_shows_the_path(self):
        one = self.draw("--side-step", "20")
        self.assertEqual(one, self.draw("--side-step", "20", "--threads", "1"))
        self.assertNotEqual(one, self.draw("--side-step", "30"))
        self.assertNotEqual(one, self.draw("--side-step", "20", "--tool", "3,2"))
        self.assertNotEqual(one, self.draw("--side-step", "20", "--use-mesh"))

    def test_any_name(self):
        for name in (b"b\xff\xc3\xa4\x01.gltf", b"x" * 250 + b".glt", b"\xc3\xa4" * 120 + b".gltf"):
            odd = os.path.join(os.fsencode(self.dir), name)
            os.symlink(self.part, odd)
            self.assertGreater(len(self.draw("--side-step", "30", part=odd)), 10000)

    def test_standard_output(self):
        done = self.run_program("path", self.part, "-o", "png:-")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stdout[:4], b"\x89PNG")

    def test_full_device(self):
        self.bad(1, "path", self.part, "-o", "png:/dev/full", say="No space")


class Files(Case):
    def limit(self, size):
        def act():
            resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
        return act

    def skip_under(self, *marks):
        """Sanitizers' run-time parts do not live within such limits."""
        with open(program.PROGRAM, "rb") as f:
            text = f.read()
        if any(m in text for m in marks) or "LD_PRELOAD" in os.environ:
            self.skipTest("the program is not itself here")

    def test_disk_full(self):
        self.skip_under(b"__tsan_init")
        for size in (0, 100, 4096, 20000):
            for name in ("out.csv", "out.json", "out.cl", "out.ngc"):
                self.bad(1, "path", self.part, "--forward-step", "0.2", "-o", self.at(name),
                         "--machine", "siemens", say="cannot write", preexec_fn=self.limit(size))
        old = self.write("old.csv", "old\n")
        self.bad(1, "path", self.part, "-o", old, "-o", self.at("x.json"), say="cannot write",
                 preexec_fn=self.limit(4096))
        with open(old) as f:
            self.assertEqual(f.read(), "old\n")

    def test_full_device(self):
        os.symlink("/dev/full", self.at("full.csv"))
        self.bad(1, "path", self.part, "-o", self.at("full.csv"), say="No space")
        self.bad(1, "path", self.part, "-o", "json:/dev/full", say="No space")
        self.assertTrue(stat.S_ISCHR(os.stat("/dev/full").st_mode))
        for words in (["path", self.part], ["path", self.part, "--json"], ["info"], ["help"],
                      ["info", "--json"], ["--version"]):
            with open("/dev/full", "w") as full:
                self.bad(1, *words, say="standard output", stdout=full)

    def test_no_place(self):
        self.bad(1, "path", self.part, "-o", self.at("none/out.csv"), say="make its directory")
        os.mkdir(self.at("folder.csv"))
        self.bad(1, "path", self.part, "-o", self.at("folder.csv"), say="s a directory")
        self.bad(1, "path", self.part, "-o", self.part + "/out.csv", say="ot a directory")
        os.symlink("nowhere/x", self.at("lost.csv"))
        self.bad(1, "path", self.part, "-o", self.at("lost.csv"), say="cannot write")
        self.bad(1, "path", self.part, "-o", self.at("x" * 300 + ".csv"), say="too long")
        self.bad(1, "path", self.part, "-o", self.at("out.csv"), "-o", self.at("none/out.cl"))

    def test_no_permission(self):
        """As a user who may read the part, but not write here."""
        more = {}
        if os.geteuid() == 0:
            more["preexec_fn"] = lambda: os.setuid(65534)
            os.chmod(self.dir, 0o755)
            try:
                self.run_program("--version", **more)
            except (PermissionError, FileNotFoundError):
                self.skipTest("another user cannot run the program here")
        os.chmod(self.part, 0o644)
        old = self.write("old.csv", "old\n")
        os.chmod(old, 0o444)
        self.bad(1, "path", self.part, "-o", old, say="ermission", **more)
        os.chmod(self.dir, 0o555)
        self.bad(1, "path", self.part, "-o", self.at("out.csv"), say="ermission", **more)
        os.chmod(self.dir, 0o755)

    def test_standard_output(self):
        self.path()
        with open(self.at("out.csv")) as f:
            expected = f.read()
        words = ["path", self.part, "--side-step", "20", "--forward-step", "10"]
        for name in ("csv:-", "csv:/dev/stdout", "csv:/dev/fd/1", "csv:/proc/self/fd/1"):
            done = self.run_program(*words, "-o", name)
            self.assertEqual((done.returncode, done.stdout.decode()), (0, expected))
            self.assertIn("positions/s", done.stderr.decode())
            self.assertEqual(self.good(*words, "--quiet", "-o", name), expected)
            with open(self.at("file"), "w") as f:
                f.write("before\n")
                f.flush()
                self.good(*words, "--quiet", "-o", name, stdout=f)
            with open(self.at("file")) as f:
                self.assertEqual(f.read(), "before\n" + expected)
            os.remove(self.at("file"))
        self.bad(2, *words, "-o", "csv:-", "--json", say="--json")
        self.assertTrue(os.path.islink("/dev/stdout"))

    def test_pipe(self):
        os.mkfifo(self.at("pipe.csv"))
        text = []
        def read():
            with open(self.at("pipe.csv")) as f:
                text.append(f.read())
        reader = threading.Thread(target=read)
        reader.start()
        self.good("path", self.part, "-o", self.at("pipe.csv"))
        reader.join()
        self.assertEqual(text[0].count("\n"), 156)
        self.assertTrue(stat.S_ISFIFO(os.stat(self.at("pipe.csv")).st_mode))

    def test_broken_pipe(self):
        read, write = os.pipe()
        os.close(read)
        self.bad(1, "path", self.part, "-o", "csv:-", say="Broken pipe", stdout=write)
        os.close(write)

    def test_closed_output(self):
        done = self.run_program("path", self.part, "-o", self.at("out.csv"),
                                preexec_fn=lambda: os.close(1))
        self.assertEqual(done.returncode, 1)
        self.assertIn(b"standard output", done.stderr)
        self.assertEqual(len(rows_of(self.at("out.csv"))), 155)
        closed = "standard output: cannot write: it is not open for writing; open it or "
        for words in (["path", self.part, "-o", "csv:-"], ["path", self.part], ["info"]):
            self.bad(1, *words, say=closed, preexec_fn=lambda: os.close(1))
        self.bad(1, "path", self.part, "-o", "json:/dev/fd/77", say="77: cannot write: it is not")

    def test_existing(self):
        target = self.write("target.csv", "old\n")
        os.chmod(target, 0o640)
        os.symlink("target.csv", self.at("link.csv"))
        self.good("path", self.part, "-o", self.at("link.csv"))
        self.assertTrue(os.path.islink(self.at("link.csv")))
        self.assertEqual(len(rows_of(target)), 155)
        self.assertEqual(stat.S_IMODE(os.stat(target).st_mode), 0o640)

    def test_mode(self):
        self.good("path", self.part, "-o", self.at("out.csv"), preexec_fn=lambda: os.umask(0o027))
        self.assertEqual(stat.S_IMODE(os.stat(self.at("out.csv")).st_mode), 0o640)

    def test_relative(self):
        self.good("path", "part.gltf", "-o", "OUT.CSV", "-o", "-x.csv", cwd=self.dir)
        self.assertEqual(sorted(os.listdir(self.dir)), ["-x.csv", "OUT.CSV", "part.gltf"])

    def test_long_name(self):
        name = "x" * 250 + ".csv"
        self.good("path", self.part, "-o", self.at(name))
        self.assertIn(name, os.listdir(self.dir))

    def test_signals(self):
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            words = ["path", self.part, "--side-step", "0.02", "--forward-step", "0.02"]
            child = subprocess.Popen(
                [program.PROGRAM, *words, "-o", self.at("out.csv"), "-o", self.at("out.cl")],
                stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                # nohup and background jobs ignore some; what is ignored stays so in a child.
                preexec_fn=lambda: signal.signal(number, signal.SIG_DFL))
            end = time.monotonic() + 30
            while len(os.listdir(self.dir)) < 3 and time.monotonic() < end:
                time.sleep(0.01)
            self.assertEqual(len(os.listdir(self.dir)), 3)
            time.sleep(0.05)
            child.send_signal(number)
            self.assertEqual(child.wait(30), -number)
            self.assertEqual(os.listdir(self.dir), ["part.gltf"])

    def test_fewer_threads(self):
        """Where the system refuses threads, those there are do the work."""
        self.skip_under(b"__asan_init", b"__tsan_init")
        def act():
            resource.setrlimit(resource.RLIMIT_STACK, (256 << 20, resource.RLIM_INFINITY))
            resource.setrlimit(resource.RLIMIT_AS, (700 << 20, 700 << 20))
        words = ["path", self.part, "--forward-step", "0.05", "--side-step", "30", "--json"]
        few = json.loads(self.good(*words, "--threads", "200", preexec_fn=act))
        many = json.loads(self.good(*words))
        self.assertLess(few["threads"], 200)
        self.assertEqual(few["statuses"], many["statuses"])


if __name__ == "__main__":
    program.PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
