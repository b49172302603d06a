"""`bitangent view`: pictures by what is in them, without a display, and the window under Xvfb.

    python3 view.py PATH_OF_BITANGENT [unittest's own options]
"""

import json
import math
import os
import struct
import subprocess
import sys
import unittest
import zlib

import program
from program import Case, SIZE, rows_of

BACKGROUND = (246, 248, 250)


class Picture:
    """An 8-bit RGB PNG."""

    def __init__(self, path):
        with open(path, "rb") as f:
            data = f.read()
        assert data[:8] == b"\x89PNG\r\n\x1a\n"
        at, packed = 8, b""
        while at < len(data):
            (size,) = struct.unpack(">I", data[at : at + 4])
            kind, body = data[at + 4 : at + 8], data[at + 8 : at + 8 + size]
            if kind == b"IHDR":
                self.width, self.height, bits, colours = struct.unpack(">IIBB", body[:10])
                assert (bits, colours) == (8, 2), (bits, colours)
            if kind == b"IDAT":
                packed += body
            at += 12 + size
        self.rows = self.unfilter(zlib.decompress(packed))

    def unfilter(self, raw):
        stride, rows, before = 3 * self.width, [], bytearray(3 * self.width)
        for y in range(self.height):
            kind = raw[y * (stride + 1)]
            line = bytearray(raw[y * (stride + 1) + 1 : (y + 1) * (stride + 1)])
            for i in range(stride if kind else 0):
                left = line[i - 3] if i > 2 else 0
                up, corner = before[i], before[i - 3] if i > 2 else 0
                if kind == 1:
                    guess = left
                elif kind == 2:
                    guess = up
                elif kind == 3:
                    guess = (left + up) // 2
                else:
                    guess = min((left, up, corner), key=lambda v: abs(left + up - corner - v))
                line[i] = (line[i] + guess) & 255
            rows.append(line)
            before = line
        return rows

    def at(self, x, y):
        return tuple(self.rows[y][3 * x : 3 * x + 3])

    def near(self, x, y, reach):
        """Pixels of a square about a place."""
        return [
            self.at(i, k)
            for k in range(max(int(y) - reach, 0), min(int(y) + reach + 1, self.height))
            for i in range(max(int(x) - reach, 0), min(int(x) + reach + 1, self.width))
        ]

    def places(self, kind):
        return [
            (x, y) for y in range(self.height) for x in range(self.width) if kind(self.at(x, y))
        ]


def is_blue(c):
    return c[2] > 1.3 * c[0] + 30 and c[2] > c[1] + 15


def is_orange(c):
    return c[0] > c[1] + 40 and c[1] > c[2] + 15


def is_part(c):
    return max(abs(a - b) for a, b in zip(c, BACKGROUND)) > 8


def sub(a, b):
    return [x - y for x, y in zip(a, b)]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(a):
    return [x / math.sqrt(dot(a, a)) for x in a]


def project(facts, size, point):
    """A pinhole's image of a point, z up in the picture; straight from above, +y is up."""
    camera = facts["camera"]
    ahead = unit(sub(camera["target_mm"], camera["eye_mm"]))
    right = unit(cross(ahead, [0, 0, 1])) if abs(ahead[2]) < 0.999999 else [1, 0, 0]
    up = cross(right, ahead)
    to = sub(point, camera["eye_mm"])
    scale = size[1] / 2 / math.tan(math.radians(camera["height_deg"] / 2)) / dot(to, ahead)
    middle = camera["target_px"]
    return middle[0] + scale * dot(to, right), middle[1] - scale * dot(to, up)


def vector(row, name):
    return [float(row[name + "_" + axis]) for axis in "xyz"]


class View(Case):
    steps = ("--side-step", "20", "--forward-step", "10")

    def setUp(self):
        super().setUp()
        done = self.run_program("view", self.part, "--screenshot", self.at("probe.png"),
                                "--size", "64x64")
        text = done.stderr.decode()
        if done.returncode == 1 and ("not in this build" in text or "without a window" in text):
            self.skipTest(text.strip())

    def look(self, *words, size=(320, 200), track=()):
        out = self.at("view.png")
        text = self.good("view", self.part, *track, *self.steps, "--screenshot", out, "--json",
                         "--size", "%dx%d" % size, *words)
        picture = Picture(out)
        self.assertEqual((picture.width, picture.height), size)
        return picture, json.loads(text)


class Screenshot(View):
    def check_contacts(self, picture, facts, row, size):
        for name, colour, other in (("p", is_blue, is_orange), ("q", is_orange, is_blue)):
            x, y = project(facts, size, vector(row, name))
            self.assertAlmostEqual(x, facts[name + "_pixel"][0], delta=0.5)
            self.assertAlmostEqual(y, facts[name + "_pixel"][1], delta=0.5)
            here = picture.near(x, y, 2)
            self.assertGreater(sum(map(colour, here)), 0.8 * len(here), (name, here))
            self.assertEqual(sum(map(other, here)), 0, name)

    def test_contacts(self):
        rows = self.path()
        apart = [
            (math.dist(vector(r, "p"), vector(r, "q")), i)
            for i, r in enumerate(rows)
            if r["status"] == "two-contact"
        ]
        _, best = max(apart)
        size = (400, 300)
        for side in ("tilt", "top", "front", "200,35"):
            for tool in ("t,t,r", "r"):
                picture, facts = self.look("--position", str(best + 1), "--view-from", side,
                                           "--keys", tool + ",tab,h", size=size)
                self.assertEqual((facts["position"], facts["positions"]), (best + 1, len(rows)))
                self.check_contacts(picture, facts, rows[best], size)

    def test_where_from(self):
        for side, want in (("top", (0, 0, 1)), ("front", (0, -1, 0)), ("right", (1, 0, 0)),
                           ("left", (-1, 0, 0)), ("back", (0, 1, 0)), ("90,30", (0, 0.866025, 0.5))):
            _, facts = self.look("--view-from", side, size=(64, 64))
            camera = facts["camera"]
            got = unit(sub(camera["eye_mm"], camera["target_mm"]))
            for a, b in zip(got, want):
                self.assertAlmostEqual(a, b, 5, side)

    def test_part_silhouette(self):
        """The dish is 60 mm square from above; what is drawn lies where its rim projects."""
        size = (300, 300)
        picture, facts = self.look("--view-from", "top", "--look-at", "part", "--position",
                                   "11", "--keys", "t,t,r,l,tab,h", size=size)
        rim = {}
        for i in range(2):
            for k in range(2):
                rim[i, k] = project(facts, size, (SIZE * i, SIZE * k, 12 + 3 * i))
        drawn = picture.places(is_part)
        left, right = rim[0, 0][0], rim[1, 0][0]
        top, bottom = min(rim[0, 1][1], rim[1, 1][1]), max(rim[0, 0][1], rim[1, 0][1])
        self.assertAlmostEqual(min(x for x, _ in drawn), left, delta=2)
        self.assertAlmostEqual(max(x for x, _ in drawn) + 1, right, delta=2)
        self.assertAlmostEqual(min(y for _, y in drawn), top, delta=2)
        self.assertAlmostEqual(max(y for _, y in drawn) + 1, bottom, delta=2)
        wide = [rim[0, 0], rim[1, 0], rim[1, 1], rim[0, 1]]
        area = 0.5 * abs(sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(wide, wide[1:] + wide[:1])))
        self.assertAlmostEqual(len(drawn) / area, 1, delta=0.03)

    def test_refusals(self):
        out = self.at("x.png")
        view = ("view", self.part)
        for words, say in (
            (("view",), "no part"),
            ((*view, "a.csv", "b.csv"), "third file"),
            ((*view, "--screenshot", "x.jpg"), ".png"),
            ((*view, "--size", "12x12"), "WIDTHxHEIGHT"),
            ((*view, "--size", "640"), "WIDTHxHEIGHT"),
            ((*view, "--size", "640x-480"), "WIDTHxHEIGHT"),
            ((*view, "--position", "0"), "from 1"),
            ((*view, "--position", "100000", "--screenshot", out), "no 100000"),
            ((*view, "--view-from", "below"), "below"),
            ((*view, "--view-from", "10,91"), "10,91"),
            ((*view, "--look-at", "me"), "tool or part"),
            ((*view, "--keys", "space,,n"), "keys like"),
            ((*view, "--keys", "space,hyper"), "hyper"),
            ((*view, "-o", "x.csv"), "unknown option"),
            ((*view, "--tool"), "needs a value"),
            ((*view, self.at("none.csv"), "--screenshot", out), "none.csv"),
            ((*view, self.part, "--screenshot", out), "unknown kind of path"),
            (("view", self.at("none.gltf")), "none.gltf"),
        ):
            self.bad(2, *words, say=say)
        self.bad(1, *view, "--screenshot", "/nowhere/x.png", say="/nowhere/x.png")

    def test_help(self):
        self.assertIn("--screenshot", self.good("help", "view"))
        self.assertEqual(self.good("view", "--help"), self.good("help", "view"))


def count(picture, kind):
    return sum(kind(picture.at(x, y)) for y in range(picture.height) for x in range(picture.width))


def is_green(c):
    return c[1] > c[0] + 20 and c[1] > c[2] + 8


def is_purple(c):
    return c[0] > c[1] + 30 and c[2] > c[1] + 25


def is_deep_blue(c):
    """What is left beside the passes: a ridge of some tenths."""
    return c[2] > c[0] + 60


class Switches(View):
    """Every key changes the picture the way its name says."""

    size = (320, 240)

    def bare(self, *keys):
        picture, _ = self.look("--keys", ",".join(("tab", "h", "l", "r") + keys), size=self.size)
        return picture

    def test_keys(self):
        plain = self.bare()
        clear, hidden = self.bare("t"), self.bare("t", "t")
        gold = lambda c: c[0] > c[2] + 25 and abs(c[0] - c[1]) < 40
        self.assertGreater(count(plain, gold), 2000)
        self.assertLess(count(hidden, gold), 200)
        self.assertNotEqual(clear.rows, plain.rows)
        self.assertGreater(count(self.bare("t", "t", "i"), is_green), count(hidden, is_green) + 200)
        self.assertGreater(count(self.bare("t", "t", "c"), is_purple), count(hidden, is_purple) + 20)
        normals = self.bare("t", "t", "n")
        self.assertGreater(count(normals, is_orange), count(hidden, is_orange) + 40)
        self.assertGreater(count(normals, is_blue), count(hidden, is_blue) + 40)
        self.assertEqual(self.bare(*"nniicctttgg").rows, plain.rows)

    def test_left_and_gouged(self):
        """Passes 20 mm apart leave blue ridges, the colours of 'verify'."""
        off = self.bare("t", "t", "3", "a")
        on = self.bare("t", "t", "3", "a", "g")
        self.assertLess(count(off, is_deep_blue), 1000)
        self.assertGreater(count(on, is_deep_blue), 3000)

    def test_panel_leaves_room(self):
        """P and Q are seen beside the panel in narrow windows too, and stand as without it in wide
        ones."""
        rows = self.path()
        for size in ((800, 500), (500, 400), (1280, 720)):
            picture, facts = self.look("--keys", "h,t,t,r,l", size=size)
            _, alone = self.look("--keys", "h,tab", size=size)
            panel = min(330, 0.45 * size[0]) + 10
            for name, colour in (("p", is_blue), ("q", is_orange)):
                x, y = project(facts, size, vector(rows[facts["position"] - 1], name))
                self.assertAlmostEqual(x, facts[name + "_pixel"][0], delta=0.5)
                self.assertLess(x + 5, size[0] - panel)
                here = picture.near(x, y, 2)
                self.assertGreater(sum(map(colour, here)), 0.8 * len(here), (size, name))
            if size[0] == 1280:
                self.assertEqual(facts["p_pixel"], alone["p_pixel"])

    def test_help_leaves_room(self):
        """In a narrow window the list of keys waits for the panel's place: the tool is seen."""
        gold = lambda c: c[0] > c[2] + 25 and abs(c[0] - c[1]) < 40
        tool, _ = self.look("--keys", "h", size=(800, 500))
        helped, _ = self.look(size=(800, 500))
        self.assertGreater(count(tool, gold), 3000)
        self.assertGreater(count(helped, gold), 0.95 * count(tool, gold))
        keys, _ = self.look("--keys", "tab", size=(800, 500))
        bare, _ = self.look("--keys", "tab,h", size=(800, 500))
        changed = sum(keys.at(x, y) != bare.at(x, y) for x in range(0, 340, 3)
                      for y in range(60, 500, 3))
        self.assertGreater(changed, 5000)

    def test_most_gouged(self):
        """`W` goes to the position at which 'verify' finds the deepest gouge, and names it."""
        rows = self.path()
        x = [float(r["foot_x"]) for r in rows]
        cell = str((max(x) - min(x)) / 900)
        want = json.loads(self.good("verify", self.part, self.at("out.csv"), "--grid", cell, "--json"))
        self.assertGreater(want["max_gouge_mm"], 0.1)
        start, first = self.look("--keys", "tab,h,l,r,t,t,g")
        there, facts = self.look("--keys", "tab,h,l,r,t,t,w")
        self.assertNotEqual(first["position"], facts["position"])
        self.assertEqual(facts["position"], want["max_gouge_at"]["position"])
        at = project(facts, (320, 200), [want["max_gouge_at"][k] for k in "xyz"])
        dark_red = lambda c: c[0] > 110 and c[1] < 60 and c[2] < 60
        self.assertTrue(0 <= at[0] < 320 and 0 <= at[1] < 200, at)
        self.assertGreater(sum(map(dark_red, there.near(*at, 60))), 300)

    def test_moving(self):
        rows = self.path()
        for keys, at in (("home", 1), ("end", len(rows)), ("home,right,right,left", 2),
                         ("home,shift+right", 11), ("home,up", 8), ("home,up,up,down", 8),
                         ("end,right", len(rows)), ("home,left", 1)):
            _, facts = self.look("--keys", keys, size=(64, 64))
            self.assertEqual(facts["position"], at, keys)

    def test_solves_again(self):
        _, first = self.look("--position", "10", "--backend", "cpu")
        _, other = self.look("--position", "10", "--backend", "cpu", "--keys", "b")
        self.assertEqual(first["backend"], "cpu")
        self.assertNotEqual(other["backend"], "cpu")
        for name in ("p_pixel", "q_pixel"):
            for a, b in zip(first[name], other[name]):
                self.assertAlmostEqual(a, b, delta=1)
        _, method = self.look("--position", "10", "--keys", "m")
        self.assertNotEqual(method["method"], first["method"])


class Tracks(View):
    def test_same_contacts(self):
        """A CSV tells its contacts; of APT they are found on the part."""
        rows = self.path("-o", self.at("p.cl"))
        at = [i for i, r in enumerate(rows) if r["status"] == "two-contact"
              and math.dist(vector(r, "p"), vector(r, "q")) > 2
              and float(r["inclination_deg"]) < -0.01][0]
        _, want = self.look("--position", str(at + 1), "--view-from", "iso")
        for track in (self.at("out.csv"), self.at("p.cl")):
            found = []
            # Retracts come between passes in .cl.
            last = at + 2 if track.endswith(".csv") else at + 8 + 2 * int(rows[at]["pass"])
            for number in range(at + 1, last):
                done = self.run_program("view", self.part, track, "--json", "--size", "320x200",
                                        "--view-from", "iso", "--position", str(number),
                                        "--screenshot", self.at("t.png"))
                if done.returncode:
                    break
                facts = json.loads(done.stdout)
                target = facts["camera"]["target_mm"]
                if math.dist(target, want["camera"]["target_mm"]) < 1e-3:
                    found = facts
                    break
            self.assertTrue(found, track)
            for name in ("tilt_deg", "inclination_deg"):
                self.assertAlmostEqual(found[name], float(rows[at][name]), delta=1e-3, msg=track)
            for name in ("p_pixel", "q_pixel"):
                self.assertEqual(len(found[name]), 2, (track, name))
                for a, b in zip(found[name], want[name]):
                    self.assertAlmostEqual(a, b, delta=0.5, msg=(track, name))


class Dropped(View):
    def test_part_and_path(self):
        rows = self.path()
        saddle = os.path.join(program.ROOT, "assets", "saddle.gltf")
        _, alone = self.look("--position", "3")
        _, path = self.look("--keys", "drop:%s,home,right,right,f,1" % self.at("out.csv"))
        self.assertEqual(path["positions"], len(rows))
        for a, b in zip(alone["p_pixel"], path["p_pixel"]):
            self.assertAlmostEqual(a, b, delta=0.5)
        _, part = self.look("--keys", "drop:" + saddle)
        self.assertEqual(part["positions"], json.loads(self.good("path", saddle, *self.steps,
                                                                 "--json"))["positions"])
        self.assertEqual(len(part["p_pixel"]), 2)

    def test_refusals(self):
        out = self.at("x.png")
        for name, text, say in (("a.gltf", "{}", "a.gltf"), ("b.csv", "pass\n1\n", "b.csv"),
                                ("c.txt", "c", "unknown kind")):
            file = self.write(name, text)
            self.bad(2, "view", self.part, "--screenshot", out, "--keys", "drop:" + file, say=say)

    def test_wild_contacts(self):
        """Whatever a path says of its contacts, there is a picture."""
        self.path()
        with open(self.at("out.csv")) as f:
            lines = f.read().splitlines()
        names = lines[0].split(",")
        for wild in ("1e300", "-1e18", "nan", "0"):
            words = lines[5].split(",")
            for name in ("p_x", "np_x", "q_y", "nq_z", "tilt_deg", "foot_x"):
                words[names.index(name)] = wild
            track = self.write("wild.csv", "\n".join([lines[0], ",".join(words)]) + "\n")
            self.look("--keys", "n,i,c", track=(track,))


class Window(View):
    def show(self, *words, keys):
        screen = ["xvfb-run", "-a", "-s", "-screen 0 640x480x24"]
        try:
            return subprocess.run(
                [*screen, program.PROGRAM, "view", self.part, *self.steps, "--json", "--size",
                 "400x300", "--keys", keys, *words],
                stdout=subprocess.PIPE, stderr=subprocess.PIPE, stdin=subprocess.DEVNULL,
                timeout=120, cwd=self.dir)
        except FileNotFoundError:
            self.skipTest("xvfb-run is missing; tools/setup installs it")

    def test_plays_and_quits(self):
        done = self.show(keys="home,],space" + 8 * ",wait" + ",n,i,c,t,g,b,wait,s,space,q")
        self.assertEqual((done.returncode, done.stderr), (0, b""))
        facts = json.loads(done.stdout)
        self.assertGreater(facts["position"], 1)
        self.assertGreaterEqual(facts["frames"], 18)
        picture = Picture(self.at("bitangent-view-001.png"))
        self.assertEqual((picture.width, picture.height), (400, 300))
        self.assertGreater(count(picture, is_blue), 30)

    def test_same_picture(self):
        """Window and screenshot show the same; what cannot be dropped leaves it as it was."""
        self.path()
        done = self.show(keys="h,drop:none.csv,wait,drop:out.csv,wait,home,f,1,wait,s,q")
        self.assertEqual((done.returncode, done.stderr), (0, b""))
        window = Picture(self.at("bitangent-view-001.png"))
        alone, _ = self.look("--keys", "h,home,f,1", size=(400, 300), track=(self.at("out.csv"),))
        differ = sum(
            max(abs(a - b) for a, b in zip(window.at(x, y), alone.at(x, y))) > 40
            for y in range(300)
            for x in range(400)
        )
        self.assertLess(differ, 0.02 * 400 * 300)

    def test_no_display(self):
        bare = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
        self.bad(1, "view", self.part, say="--screenshot", env=bare)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit("usage: view.py PATH_OF_BITANGENT [unittest's own options]")
    program.PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
