"""Pictures against references, by structure: the mean colour of coarse cells, and where the marks of
P and Q are. Letters may differ from machine to machine, and a pixel here and there.

    python3 pictures.py PROGRAM PNG_GRID [unittest's own options]
    python3 pictures.py PROGRAM PNG_GRID --write        makes the references anew: look at the
                                                        pictures first
"""

import csv
import io
import os
import subprocess
import sys
import tempfile
import unittest

import program

COLUMNS, ROWS = 35, 25
SADDLE = os.path.join(program.ROOT, "assets", "saddle.gltf")
REFERENCES = os.path.join(program.ROOT, "tests", "data", "pictures")
GRID = ""
PLOT = range(3, 26), range(3, 23)  # columns and rows of cells that lie within the plot
COLOUR = 9  # greatest difference of a cell's mean colour within the plot,
LETTERS = 40  # and where letters are
MARKS = 3.5  # percent of a cell


def draw(folder, *words):
    """The program's pictures of the saddle: its path and what that leaves."""
    path, picture, left = (os.path.join(folder, n) for n in ("path.csv", "path.png", "verify.png"))
    quiet = {"check": True, "stdout": subprocess.DEVNULL}
    subprocess.run([program.PROGRAM, "path", SADDLE, *words, "-o", path, "-o", picture], **quiet)
    subprocess.run([program.PROGRAM, "verify", SADDLE, path, "--grid", "0.5", "-o", left], **quiet)
    return {"path": cells(picture), "verify": cells(left)}


def cells(picture):
    text = subprocess.run([GRID, picture, str(COLUMNS), str(ROWS)], check=True,
                          stdout=subprocess.PIPE).stdout.decode()
    return read(io.StringIO(text))


def read(file):
    rows = csv.reader(file)
    next(rows)
    return {(int(r[0]), int(r[1])): [float(v) for v in r[2:]] for r in rows}


def reference(name):
    with open(os.path.join(REFERENCES, name + ".csv"), newline="") as f:
        return read(f)


def differences(a, b):
    """Cells that differ: in colour, in marks."""
    assert a.keys() == b.keys() and len(a) == COLUMNS * ROWS
    colour, marks = [], []
    for at in a:
        inside = at[0] in PLOT[0] and at[1] in PLOT[1]
        off = max(abs(x - y) for x, y in zip(a[at][:3], b[at][:3]))
        if off > (COLOUR if inside else LETTERS):
            colour.append((at, a[at][:3], b[at][:3]))
        if inside and max(abs(x - y) for x, y in zip(a[at][3:], b[at][3:])) > MARKS:
            marks.append((at, a[at][3:], b[at][3:]))
    return colour, marks


class Pictures(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        with tempfile.TemporaryDirectory() as folder:
            cls.drawn = draw(folder)

    def test_path(self):
        self.assertEqual(differences(self.drawn["path"], reference("path")), ([], []))
        marks = [sum(c[k] for c in self.drawn["path"].values()) for k in (3, 4)]
        self.assertGreater(min(marks), 100)

    def test_verify(self):
        self.assertEqual(differences(self.drawn["verify"], reference("verify")), ([], []))

    def test_another_path_differs(self):
        """What the comparison is worth: a path a little to the side is another picture."""
        with tempfile.TemporaryDirectory() as folder:
            other = draw(folder, "--side-step", "16")
        colour, marks = differences(other["path"], reference("path"))
        self.assertGreater(len(marks), 20)
        colour, _ = differences(other["verify"], reference("verify"))
        self.assertGreater(len(colour), 50)


def write():
    os.makedirs(REFERENCES, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        for name, found in draw(folder).items():
            with open(os.path.join(REFERENCES, name + ".csv"), "w") as f:
                f.write("column,row,red,green,blue,p,q\n")
                for (column, row), v in found.items():
                    f.write(f"{column},{row}," + ",".join(f"{x:g}" for x in v) + "\n")


if __name__ == "__main__":
    program.PROGRAM, GRID = (os.path.abspath(sys.argv.pop(1)) for _ in range(2))
    if sys.argv[1:] == ["--write"]:
        write()
    else:
        unittest.main()
