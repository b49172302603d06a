"""The report's page: what is in it, and in a headless Chromium that it loads alone and without
complaint, that the canvas shows the part, and that its controls do what they say.

    python3 report.py PATH_OF_BITANGENT [unittest's own options]
"""

import base64
import json
import math
import os
import re
import sys
import unittest

import browser
import program

STEPS = ("--side-step", "6", "--forward-step", "4")
HOSTILE = "<script>window.bad=1<!--&'\"><img src=x onerror=bad=2>.gltf"


def data_of(page):
    with open(page, encoding="utf-8") as f:
        text = f.read()
    (data,) = re.findall(r'<script type="application/json" id="data">(.*?)</script>', text, re.S)
    return text, json.loads(data)


class Page(program.Case):
    """What the file holds."""

    def report(self, *words, part=None):
        page = self.at("report.html")
        self.good("report", part or self.part, "--quiet", *STEPS, *words, "-o", page)
        return data_of(page)

    def test_data(self):
        out = self.at("path.csv")
        text, data = self.report("-o", out)
        rows = program.rows_of(out)
        self.assertEqual(data["stops"]["count"], len(rows))
        self.assertEqual(data["summary"]["positions"], len(rows))
        self.assertEqual(dict(data["settings"])["--side-step"], "6 mm")
        names = {b["name"]: b for b in data["backends"]}
        self.assertTrue(names["cpu"]["used"])
        self.assertLess(names["reference"]["difference_mm"], 1e-3)
        self.assertGreater(names["cpu"]["positions"], 50)
        self.assertNotIn("machine", data)
        # Nothing in it is fetched from anywhere: the one address is the name of SVG itself.
        self.assertEqual(set(re.findall(r"https?:[^\"'` ]*", text)), {"http://www.w3.org/2000/svg"})
        self.assertIn("default-src 'none'", text)
        self.check_verification(data["verify"], out)

    def check_verification(self, v, path):
        """The same figures as `bitangent verify` on the same cells."""
        m = v["map"]
        done = self.run_program("verify", self.part, path, "--grid", repr(m["cell_mm"]), "--json")
        other = json.loads(done.stdout)
        for name in ("max_gouge_mm", "max_scallop_mm", "mean_scallop_mm", "motion_bound_mm"):
            self.assertAlmostEqual(v[name], other[name], delta=1e-9, msg=name)
        codes = base64.b64decode(m["codes"])
        self.assertEqual(len(codes), m["width"] * m["height"])
        most = max(c if c < 128 else 0 for c in codes)
        limit = m["scallop_limit_mm"]
        below, above = (limit * 10 ** ((most - k) / m["steps_per_decade"]) for k in (1, 0))
        self.assertTrue(below <= v["max_scallop_mm"] * 1.000001 and v["max_scallop_mm"] <= above)

    def test_machine(self):
        program_file = self.at("path.ngc")
        page = self.at("report.html")
        words = ("--machine", "xyzac-trt", "-o", program_file, "-o", page)
        summary = json.loads(self.good("path", self.part, "--json", *STEPS, *words))
        _, data = data_of(page)
        m = data["machine"]
        for name in ("blocks", "slowed", "retracts", "rewinds", "cut_seconds"):
            self.assertEqual(m[name], summary["program"][name], name)
        self.assertEqual(m["joints"], ["X", "Y", "Z", "A", "C"])
        track = memoryview(base64.b64decode(m["track"])).cast("f")
        self.assertEqual(len(track), 6 * m["moments"])
        times = track.tolist()[::6]
        self.assertTrue(all(a <= b for a, b in zip(times, times[1:])))
        self.assertGreaterEqual(times[-1], m["cut_seconds"] * 0.9999)
        # The angles are those of the program's blocks.
        with open(program_file) as f:
            words = re.findall(r"\bA(-?[\d.]+)", f.read())
        angles = sorted({round(float(a), 2) for a in words} - {0.0})
        shown = {round(a, 2) for a in track.tolist()[4::6]}
        self.assertGreater(len(angles), 5)
        near = [a for a in angles if min(abs(a - b) for b in shown) < 0.011]
        self.assertGreater(len(near), 0.95 * len(angles))

    def test_names(self):
        """The default name; other outputs beside the page; kinds by prefix."""
        self.good("report", self.part, "--quiet", *STEPS, "-o", self.at("a.csv"), cwd=self.dir)
        self.assertLess({"report.html", "a.csv"}, set(os.listdir(self.dir)))
        self.assertIn("--side-step", self.good("report", "--help"))
        self.assertIn("report.html", self.good("help", "report"))

    def test_refusals(self):
        self.bad(2, "report", say="no part")
        self.bad(2, "report", self.at("none.gltf"), "-o", self.at("x.html"), say="none.gltf")
        self.bad(1, "report", self.part, "-o", self.at("no/x.html"), say="x.html")
        points = self.write("points.txt", "30 30\n" + "500 500\n" * 200000)
        self.bad(1, "report", self.part, "--footprint", "points:" + points, "--quiet",
                 "-o", self.at("x.html"), say="too many for a page")

    def test_overhung(self):
        """Axes that do not point up cannot be verified: the page says so. Kinds by prefix."""
        page = self.at("page.txt")
        points = self.write("points.txt", "5 30\n30 30\n55 30\n")
        self.good("report", self.part, "--quiet", "--footprint", "points:" + points, "--spin",
                  "fixed:180", "--max-tilt", "90", "-o", "html:" + page)
        _, data = data_of(page)
        axes = memoryview(base64.b64decode(data["stops"]["values"])).cast("f").tolist()[5::13]
        self.assertEqual("missing" in data["verify"], min(axes) <= 0, axes)


# The page is the same whatever the program was built with.
@unittest.skipIf("BTG_TEST_QUICK" in os.environ, "BTG_TEST_QUICK: the page is looked at elsewhere")
@unittest.skipUnless(browser.available(), "chromium is not installed")
class Shown(program.Case):
    @classmethod
    def setUpClass(cls):
        case = program.Case()
        case.setUp()
        cls.case, cls.page = case, case.at("report.html")
        cls.csv = case.at("path.csv")
        case.good("report", case.part, "--quiet", *STEPS, "--machine", "xyzac-trt",
                  "-o", cls.page, "-o", cls.csv)
        cls.rows = program.rows_of(cls.csv)
        cls.browser = browser.Browser()

    @classmethod
    def tearDownClass(cls):
        cls.browser.close()
        cls.case.doCleanups()

    def open(self, page=None, width=800, height=500, phone=False, dark=False, fresh=True):
        """The page; `fresh` False: as it is, when it is open already and only looked at."""
        b, how = self.browser, (page, width, height, phone, dark)
        if not fresh and how == getattr(b, "how", None):
            return b
        b.how = how if not fresh else None
        b.size(width, height, phone)
        b.dark(dark)
        b.open(page or self.page)
        b.settle()
        self.assertEqual(b.errors, [])
        return b

    def tearDown(self):
        self.assertEqual(self.browser.errors, [])
        super().tearDown()

    def colours(self, selector="#scene"):
        """How many pixels of an element, as it is on the screen, are of what kind; where it is
        not the background."""
        png = base64.b64encode(self.browser.picture(selector)).decode()
        return self.browser.run("""(async () => {
          const image = new Image();
          image.src = "data:image/png;base64,%s";
          await image.decode();
          const c = document.createElement("canvas");
          [c.width, c.height] = [image.width, image.height];
          const g = c.getContext("2d");
          g.drawImage(image, 0, 0);
          const d = g.getImageData(0, 0, c.width, c.height).data;
          const n = {all: c.width * c.height, drawn: 0, blue: 0, orange: 0, gold: 0, light: 0,
                     box: [1e9, 1e9, -1, -1], scale: c.width / document.querySelector("%s").clientWidth};
          const back = [...d.slice(4 * (c.width * 60 + 20), 4 * (c.width * 60 + 20) + 3)];
          let sum = 0;
          for (let i = 0; i < n.all; i++) {
            const [r, g, b] = [d[4 * i], d[4 * i + 1], d[4 * i + 2]];
            n.light += (r + g + b) / 765 / n.all;
            if (Math.abs(r - 0) < 25 && Math.abs(g - 114) < 25 && Math.abs(b - 178) < 25) n.blue++;
            if (Math.abs(r - 213) < 25 && Math.abs(g - 94) < 25 && Math.abs(b - 0) < 25) n.orange++;
            if (r > 150 && g > 100 && g < r - 20 && b < g - 40) n.gold++;
            if (Math.hypot(r - back[0], g - back[1], b - back[2]) < 12) continue;
            const x = i %% c.width, y = Math.floor(i / c.width), edge = 12;  // its corners are round
            if (Math.min(x, y, c.width - 1 - x, c.height - 1 - y) < edge) continue;
            n.drawn++;
            n.box = [Math.min(n.box[0], x), Math.min(n.box[1], y), Math.max(n.box[2], x), Math.max(n.box[3], y)];
          }
          return n;
        })()""" % (png, selector))

    def hide(self, *names):
        """Switches off what is shown, and takes labels and legend away."""
        for name in names:
            self.browser.run(f"document.getElementById('show-{name}').click()")
        self.bare()
        self.browser.settle()

    def bare(self):
        self.browser.run("document.querySelectorAll('#labels, .legend')"
                         ".forEach(e => { e.style.visibility = 'hidden'; })")

    def text(self, selector):
        return self.browser.run(f"document.querySelector({json.dumps(selector)}).textContent")

    def press(self, name):
        self.browser.run(f"document.getElementById({json.dumps(name)}).click()")
        self.browser.settle()

    def at(self, name):
        return self.case.at(name)

    def position(self):
        value = int(self.browser.run("document.getElementById('position').value"))
        self.assertIn(f"{value + 1} of {len(self.rows)}", self.text("#stop"))
        return value

    # ---- loading

    def test_loads_alone(self):
        b = self.open(fresh=False)
        self.assertEqual([r[:8] for r in b.requests], ["file:///"])
        self.assertEqual(self.browser.run("document.title"), "part.gltf – Bitangent report")
        self.assertEqual(self.text("h1"), "part.gltf")

    def test_numbers(self):
        b = self.open(fresh=False)
        cards = self.text("#cards")
        self.assertIn(f"{len(self.rows)}tool positions", cards)
        two = sum(r["status"] == "two-contact" for r in self.rows)
        self.assertIn(f"two-contact{two}", self.text("#statuses"))
        tilt = max(float(r["tilt_deg"]) for r in self.rows if r["tilt_deg"] != "nan")
        self.assertIn(f"up to {tilt:.3g}", cards)
        self.assertEqual(b.run("document.querySelectorAll('#joints svg').length"), 5)
        # Each histogram holds every position once.
        for name, rows in (("tilts", [r for r in self.rows if r["status"] in ("two-contact", "osculating")]),
                           ("gaps", [r for r in self.rows if r["status"] == "two-contact"])):
            counts = b.run(f"[...document.querySelectorAll('#{name} td')].map(e => Number(e.textContent))")
            self.assertEqual(sum(counts), len(rows))
            self.assertEqual(b.run(f"document.querySelectorAll('#{name} rect').length"), len(counts))
        states = self.text("#backends")
        self.assertIn("ready, made this path", states)

    def test_hostile_names(self):
        part, page = os.path.join(self.dir, HOSTILE), os.path.join(self.dir, "hostile.html")
        program.make_part(part)
        self.good("report", part, "--quiet", "--side-step", "30", "--forward-step", "20", "-o", page)
        b = self.open(page)
        self.assertEqual(self.text("h1"), HOSTILE)
        self.assertIn(HOSTILE, b.run("document.getElementById('settings').textContent"))
        self.assertEqual(b.run("typeof window.bad"), "undefined")
        self.assertEqual(b.run("document.querySelectorAll('img').length"), 0)
        self.assertEqual(len(b.requests), 1)

    # ---- the canvas

    def test_part_is_drawn(self):
        """The picture's outline is that of the part's corners, projected."""
        b = self.open()
        everything = self.colours()
        self.assertGreater(everything["drawn"], 0.1 * everything["all"])
        self.assertGreater(everything["blue"], 50)
        self.assertGreater(everything["orange"], 50)
        self.assertGreater(everything["gold"], 50)
        self.hide("tool", "contacts", "path")
        self.press("from-above")
        bare = self.colours()
        self.assertEqual((bare["blue"], bare["orange"], bare["gold"]), (0, 0, 0))
        corners = b.run("""[[0, 0], [1, 0], [0, 1], [1, 1]].map(([i, j]) =>
            report.view.project([60 * i, 60 * j, 12 + 3 * i]))""")
        want = [min(c[0] for c in corners), min(c[1] for c in corners),
                max(c[0] for c in corners), max(c[1] for c in corners)]
        for k in range(4):
            self.assertAlmostEqual(bare["box"][k] / bare["scale"], want[k], delta=4)
        area = (want[2] - want[0]) * (want[3] - want[1]) * bare["scale"] ** 2
        self.assertGreater(bare["drawn"], 0.95 * area)

    def test_contacts_stand_where_they_are(self):
        """P and Q of the position shown are blue and orange where they project to."""
        b = self.open()
        self.bare()
        self.press("from-above")
        row = self.rows[self.position()]
        for column, colour in (("p", "blue"), ("q", "orange")):
            place = [float(row[f"{column}_{c}"]) for c in "xyz"]
            x, y = b.run(f"report.view.project({place})")
            b.run(f"""(() => {{ const r = document.getElementById("scene").getBoundingClientRect();
                const e = document.createElement("div"); e.id = "probe";
                e.style.cssText = `position:absolute;left:${{r.x + scrollX + {x} - 2}}px;top:${{r.y + scrollY + {y} - 2}}px;width:4px;height:4px;pointer-events:none`;
                document.getElementById("probe")?.remove(); document.body.append(e); }})()""")
            n = self.colours("#probe")
            self.assertGreater(n[colour], 0.8 * n["all"], (column, n))

    def test_turns_under_the_mouse(self):
        b = self.open()
        x, y, w, h = b.run("(() => { const r = document.getElementById('scene').getBoundingClientRect(); return [r.x, r.y, r.width, r.height]; })()")
        before = b.picture("#scene")
        b.drag((x + w / 2, y + h / 2), (x + w / 2 + 120, y + h / 2 + 20))
        b.settle()
        turned = b.picture("#scene")
        self.assertNotEqual(before, turned)
        self.assertAlmostEqual(b.run("report.view.yaw"), -0.6 - 0.96, delta=1e-6)
        wide = self.colours()["drawn"]
        b.call("Input.dispatchMouseEvent", type="mouseWheel", x=x + w / 2, y=y + h / 2, deltaX=0, deltaY=400)
        b.wait("report.view.distance > 0 && true")
        b.settle()
        self.assertLess(self.colours()["drawn"], wide)

    def test_deviation_colours(self):
        self.open()
        self.hide("tool", "contacts", "path")
        self.press("from-above")
        plain = self.browser.picture("#scene")
        self.press("show-map")
        self.assertNotEqual(plain, self.browser.picture("#scene"))
        n = self.colours("#map")
        self.assertGreater(n["drawn"], 0)

    # ---- controls

    def test_steps(self):
        b = self.open(fresh=False)
        b.run("(() => { const r = document.getElementById('position'); r.value = 5; r.dispatchEvent(new Event('input')); })()")
        self.assertEqual(self.position(), 5)
        self.press("next")
        self.assertEqual(self.position(), 6)
        self.press("previous")
        self.assertEqual(self.position(), 5)
        b.run("document.getElementById('scene').focus()")
        b.key(".", ".")
        self.assertEqual(self.position(), 6)
        yaw = b.run("report.view.yaw")
        b.key("ArrowLeft")
        self.assertNotEqual(b.run("report.view.yaw"), yaw)
        distance = b.run("report.view.distance")
        b.key("+", "+")
        self.assertLess(b.run("report.view.distance"), distance)
        row = self.rows[6]
        numbers = self.text("#stop")
        self.assertIn(row["status"], numbers)
        if row["tilt_deg"] != "nan":
            self.assertIn(f"{float(row['tilt_deg']):.4g}"[:4], numbers)

    def test_go_to(self):
        self.open(fresh=False)
        self.press("to-tilt")
        tilts = [float(r["tilt_deg"]) if r["status"] in ("two-contact", "osculating") else -1 for r in self.rows]
        self.assertAlmostEqual(tilts[self.position()], max(tilts), delta=1e-4)
        self.press("to-gap")
        def gap(r):
            if r["status"] != "two-contact":
                return -1
            return math.dist(*([float(r[f"{k}_{c}"]) for c in "xyz"] for k in "pq"))
        gaps = [gap(r) for r in self.rows]
        self.assertAlmostEqual(gaps[self.position()], max(gaps), delta=1e-4)
        if not self.browser.run("document.getElementById('to-gouge').disabled"):
            self.press("to-gouge")
            self.assertTrue(self.browser.run("report.view.show.map"))
            self.assertEqual(self.position(), self.browser.run("report.data.verify.gouge_line"))

    def test_plays(self):
        b = self.open(fresh=False)
        b.run("(() => { const r = document.getElementById('position'); r.value = 0; r.dispatchEvent(new Event('input')); })()")
        self.press("play")
        self.assertEqual(self.text("#play"), "Pause")
        b.wait("Number(document.getElementById('position').value) >= 3")
        self.press("play")
        self.assertEqual(self.text("#play"), "Play")
        at = self.position()
        b.settle()
        self.assertEqual(self.position(), at)

    def test_labels(self):
        """P, Q, the tilt and the gouge are named on the screen."""
        self.open(fresh=False)
        self.press("to-gap")
        self.press("near-tool")
        labels = self.browser.run("[...document.querySelectorAll('#labels span')].map(e => e.textContent)")
        self.assertEqual(labels[:2], ["P", "Q"])
        self.assertRegex(labels[2], r"^tilt [\d.]+°$")
        self.assertIn("P, first contact", self.text(".legend"))

    # ---- every reader

    def test_themes(self):
        self.open()
        light = self.colours(".view aside")["light"]
        self.press("theme")
        dark = self.colours(".view aside")["light"]
        self.assertGreater(light, 0.75)
        self.assertLess(dark, 0.35)
        self.open(dark=True)
        self.assertLess(self.colours(".view aside")["light"], 0.35)

    def test_contrast(self):
        """WCAG AA: 4.5 for text, 3 for marks and borders of controls."""
        script = """(() => {
          const style = getComputedStyle(document.documentElement);
          const light = (name) => {
            const rgb = style.getPropertyValue(name).trim().match(/\\w\\w/g).map((h) => parseInt(h, 16) / 255)
              .map((c) => c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
            return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
          };
          return (a, b) => { const [x, y] = [light(a), light(b)].sort((p, q) => q - p); return (x + 0.05) / (y + 0.05); };
        })()"""
        for dark in (False, True):
            b = self.open(fresh=False)
            b.run(f"document.documentElement.dataset.theme = '{'dark' if dark else 'light'}'")
            for text in ("--ink", "--soft", "--link"):
                for back in ("--back", "--panel"):
                    self.assertGreater(b.run(f"{script}('{text}', '{back}')"), 4.5, (dark, text, back))
            for mark in ("--bar", "--p", "--q", "--one", "--focus"):
                for back in ("--back", "--stage"):
                    self.assertGreater(b.run(f"{script}('{mark}', '{back}')"), 3, (dark, mark, back))

    def test_phone(self):
        b = self.open(width=360, height=740, phone=True)
        self.assertLessEqual(b.run("document.documentElement.scrollWidth"), 360)
        self.assertGreaterEqual(b.run("Math.min(...[...document.querySelectorAll('button')].map(e => e.getBoundingClientRect().height))"), 32)
        self.assertGreaterEqual(b.run("document.getElementById('scene').clientWidth"), 300)
        scale = b.run("Math.min(...[...document.querySelectorAll('svg')].map(e => e.clientWidth / e.viewBox.baseVal.width))")
        self.assertGreaterEqual(scale, 0.9)  # letters of figures are as large as said
        n = self.colours()
        self.assertGreater(n["drawn"], 0.1 * n["all"])

    def test_names_for_readers(self):
        b = self.open(fresh=False)
        nodes = b.call("Accessibility.getFullAXTree")["nodes"]
        seen = {}
        for node in nodes:
            role, name = node.get("role", {}).get("value"), node.get("name", {}).get("value", "")
            if node.get("ignored"):
                continue
            if role in ("button", "slider", "checkbox", "image", "img", "application", "heading", "group", "region"):
                self.assertTrue(name or role in ("group", "region"), (role, node))
                seen[role] = seen.get(role, 0) + 1
        self.assertGreater(seen["button"], 10)
        self.assertEqual(seen["slider"], 1)
        self.assertEqual(seen["checkbox"], 5)
        self.assertGreaterEqual(seen.get("image", 0) + seen.get("img", 0), 8)
        levels = b.run("[...document.querySelectorAll('h1,h2,h3')].map(e => Number(e.tagName[1]))")
        self.assertEqual(levels[0], 1)
        self.assertTrue(all(b - a <= 1 for a, b in zip(levels, levels[1:])))


if __name__ == "__main__":
    program.PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
