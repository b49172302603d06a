#!/usr/bin/env python3
"""Writes the parts in assets/, the test files in tests/data/gltf/, and triangle meshes of any size.

    make_assets.py                      assets/*.gltf
    make_assets.py --tests              tests/data/gltf/
    make_assets.py --mesh N -o FILE     a .glb of at least N triangles, none exact
    -d DIR                              another directory than the one above

Python's standard library only; the output is the same on every machine and run.
"""
import argparse
import math
import os
import sys

import gltf_variants
from gltf_write import Document, Mesh, Surface, surface_document
from teapot_data import PATCHES, VERTICES

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))

# ---- the papers' patches: control points at 0, 50, 100, 150 mm, row i is x ------------------

HEIGHTS = {
    "convex": [[80, 90, 90, 80], [90, 105, 105, 90], [90, 105, 105, 90], [80, 90, 90, 80]],
    "concave": [[80, 70, 70, 80], [70, 55, 55, 70], [70, 55, 55, 70], [80, 70, 70, 80]],
    "saddle": [[80, 65, 90, 85], [80, 85, 90, 95], [100, 105, 95, 100], [90, 100, 100, 85]],
}


def paper_surface(name):
    return Surface([[(50.0 * i, 50.0 * j, float(z)) for j, z in enumerate(row)]
                    for i, row in enumerate(HEIGHTS[name])])


# ---- Utah teapot ---------------------------------------------------------------------------

TEAPOT_MM = 24.0  # mm a unit of the data: 154 mm from handle to spout


def teapot_surfaces():
    points = [tuple(round(TEAPOT_MM * x, 6) for x in v) for v in VERTICES]
    patches = []
    for p in range(32):
        net = [points[i] for i in PATCHES[16 * p:16 * p + 16]]
        # transposed: the data's own order has its normals inside
        patches.append(Surface([[net[4 * j + i] for j in range(4)] for i in range(4)]))
    return patches


# ---- blade: a twisted, cambered foil, all of it seen from +z --------------------------------

BLADE_KNOTS_U = [0.0] * 4 + [0.2, 0.45, 0.8] + [1.0] * 4
BLADE_KNOTS_V = [0.0] * 4 + [0.15, 0.5] + [1.0] * 4


def greville(knots, degree, count):
    return [sum(knots[i + 1:i + degree + 1]) / degree for i in range(count)]


def blade_point(s, t):
    """s along the span (root to tip), t along the chord (leading to trailing edge)."""
    chord = 78.0 - 22.0 * s
    twist = math.radians(16.0 - 34.0 * s)
    along = (t - 0.45) * chord
    up = 26.0 * (1.0 - 0.35 * s) * math.sqrt(t) * (1.0 - t) * 1.9
    x = 150.0 * s
    y = 42.0 + along * math.cos(twist) + 6.0 * s * s
    z = 38.0 + up * math.cos(twist) + along * math.sin(twist)
    return tuple(round(c, 3) for c in (x, y, z))


def blade_surface():
    us, vs = greville(BLADE_KNOTS_U, 3, 7), greville(BLADE_KNOTS_V, 3, 6)
    points = [[blade_point(s, t) for t in vs] for s in us]
    weights = [[1.0 if j in (0, 5) else round(1.0 + 0.25 * math.sin(1.3 * i + 0.9 * j), 3)
                for j in range(6)] for i in range(7)]
    return Surface(points, BLADE_KNOTS_U, BLADE_KNOTS_V, weights, (3, 3))


# ---- crease: 5 x 2 bicubic patches, heights f(x) + g(y) --------------------------------------

# Ordinates of cubic pieces of 30 mm: smooth at 30 and 90, a sharp ridge at 60, a sharp valley at
# 120. In y pieces of 75 mm, smooth at 75.
CREASE_F = [[60, 64, 70, 76], [76, 82, 90, 100], [100, 90, 82, 76], [76, 70, 66, 62],
            [62, 70, 76, 80]]
CREASE_G = [[0, 4, 6, 6], [6, 6, 2, -6]]


def crease_surfaces():
    return [Surface([[(30.0 * a + 10.0 * i, 75.0 * b + 25.0 * j, float(f[i] + g[j]))
                      for j in range(4)] for i in range(4)])
            for a, f in enumerate(CREASE_F) for b, g in enumerate(CREASE_G)]


# ---- triangles only ------------------------------------------------------------------------


def wave(x, y):
    return 60.0 + 14.0 * math.sin(x / 17.0) * math.cos(y / 23.0) + 6.0 * math.sin((x + y) / 9.0)


def mesh_document(triangles):
    side = math.ceil(math.sqrt(triangles / 2))
    mesh, row = Mesh(), side + 1
    for i in range(row):
        for j in range(row):
            x, y = 150.0 * i / side, 150.0 * j / side
            mesh.positions.append((x, y, wave(x, y)))
    for i in range(side):
        for j in range(side):
            a = i * row + j
            mesh.triangles += [(a, a + row, a + row + 1), (a, a + row + 1, a + 1)]
    document = Document("waves")
    document.scene([document.mesh_node([document.primitive(mesh)])])
    return document


# ---- command line --------------------------------------------------------------------------


def write_assets(folder):
    parts = {name: ([paper_surface(name)], (16, 16)) for name in HEIGHTS}
    parts["teapot"] = (teapot_surfaces(), (8, 8))
    parts["blade"] = ([blade_surface()], (28, 24))
    parts["crease"] = (crease_surfaces(), (6, 8))
    for name, (surfaces, steps) in parts.items():
        surface_document(name, surfaces, steps).save_gltf(os.path.join(folder, name + ".gltf"))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--tests", action="store_true")
    parser.add_argument("--mesh", type=int, metavar="N")
    parser.add_argument("-o", metavar="FILE")
    parser.add_argument("-d", metavar="DIR")
    options = parser.parse_args()
    if options.mesh is not None:
        if not options.o or options.mesh < 2:
            sys.exit("make_assets.py: --mesh needs a count of 2 or more and -o FILE")
        mesh_document(options.mesh).save_glb(options.o)
    elif options.tests:
        folder = options.d or os.path.join(ROOT, "tests", "data", "gltf")
        os.makedirs(folder, exist_ok=True)
        gltf_variants.write_all(folder, paper_surface("saddle"), blade_surface())
    else:
        folder = options.d or os.path.join(ROOT, "assets")
        os.makedirs(folder, exist_ok=True)
        write_assets(folder)


if __name__ == "__main__":
    main()
