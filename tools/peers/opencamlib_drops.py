"""Drops a bull-nose cutter with opencamlib: see tools/compare-peers for the work file and the
conversation on standard input and output."""
import array
import sys
import time

import opencamlib

numbers = array.array("d")
with open(sys.argv[1], "rb") as work:
    numbers.frombytes(work.read())
diameter, corner = numbers[0], numbers[1]
triangles, feet = int(numbers[2]), int(numbers[3])

surface = opencamlib.STLSurf()
for at in range(4, 4 + 9 * triangles, 9):
    surface.addTriangle(opencamlib.Triangle(
        *(opencamlib.Point(*numbers[at + i:at + i + 3]) for i in (0, 3, 6))))
cutter = opencamlib.BullCutter(diameter, corner, 100.0)


def batch():
    """A new one for each run: one that has run starts from its own answers."""
    new = opencamlib.BatchDropCutter()
    new.setSTL(surface)
    new.setCutter(cutter)
    new.setThreads(1)
    for at in range(4 + 9 * triangles, 4 + 9 * triangles + 2 * feet, 2):
        new.appendPoint(opencamlib.CLPoint(numbers[at], numbers[at + 1], -1000.0))
    return new


waiting = batch()
print("ready", flush=True)
for _ in sys.stdin:
    begin = time.perf_counter()
    waiting.run()
    seconds = time.perf_counter() - begin
    print(seconds, *(repr(point.z) for point in waiting.getCLPoints()), flush=True)
    waiting = batch()
