"""Writes glTF 2.0 files for Bitangent: exact surfaces with display triangles beside them.

Everything here works in the part frame: millimetres, z up. The file's metres, y up, come out at
the end, chosen so that 1000 * value gives the millimetres back exactly where a double can.
"""
import array
import base64
import json
import math
import struct

FLOAT, U8, U16, U32 = 5126, 5121, 5123, 5125
I8, I16 = 5120, 5122
ARRAY_BUFFER, ELEMENT_BUFFER = 34962, 34963
FORMATS = {FLOAT: "f", U8: "B", U16: "H", U32: "I", I8: "b", I16: "h"}
WIDTHS = {"SCALAR": 1, "VEC3": 3}


def metres(mm):
    """A double X with 1000 * X == mm, or the nearest one."""
    x = mm / 1000.0
    for near in (x, math.nextafter(x, math.inf), math.nextafter(x, -math.inf)):
        if 1000.0 * near == mm:
            return near
    return x


def to_file_axes(p):
    """Part frame, mm -> glTF: x = 1000 X, y = -1000 Z, z = 1000 Y."""
    return (metres(p[0]), metres(p[2]), metres(-p[1]) + 0.0)


def json_number(x):
    """The shortest text that reads back as the same double; whole numbers without a point."""
    return int(x) if x == int(x) and abs(x) < 1e15 else x


# ---- surfaces ------------------------------------------------------------------------------


class Surface:
    """points[i][j], i along u, in the part frame, mm; knots None: Bezier."""

    def __init__(self, points, knots_u=None, knots_v=None, weights=None, degrees=None):
        self.points, self.weights = points, weights
        self.count_u, self.count_v = len(points), len(points[0])
        self.degree_u, self.degree_v = degrees or (self.count_u - 1, self.count_v - 1)
        self.knots_u, self.knots_v = knots_u, knots_v

    def knots(self):
        bezier = [[0.0] * (d + 1) + [1.0] * (d + 1) for d in (self.degree_u, self.degree_v)]
        return self.knots_u or bezier[0], self.knots_v or bezier[1]

    def evaluate(self, u, v):
        """Point, with u and v from 0 to 1 over the domain."""
        ku, kv = self.knots()
        nu = basis(ku, self.degree_u, self.count_u, u)
        nv = basis(kv, self.degree_v, self.count_v, v)
        sums = [0.0] * 4
        for i, a in enumerate(nu):
            for j, b in enumerate(nv):
                if a * b:
                    w = a * b * (self.weights[i][j] if self.weights else 1.0)
                    for k in range(3):
                        sums[k] += w * self.points[i][j][k]
                    sums[3] += w
        return tuple(s / sums[3] for s in sums[:3])

    def normal(self, u, v):
        """Unit normal by differences, from inside the domain (poles have none)."""
        h = 1e-4
        u, v = min(max(u, 2 * h), 1 - 2 * h), min(max(v, 2 * h), 1 - 2 * h)
        du = sub(self.evaluate(u + h, v), self.evaluate(u - h, v))
        dv = sub(self.evaluate(u, v + h), self.evaluate(u, v - h))
        return unit(cross(du, dv))

    def extension(self):
        flat = [json_number(x) for row in self.points for p in row for x in to_file_axes(p)]
        out = {"degreeU": self.degree_u, "degreeV": self.degree_v, "countU": self.count_u,
               "countV": self.count_v, "controlPoints": flat}
        if self.weights:
            out["weights"] = [json_number(w) for row in self.weights for w in row]
        if self.knots_u or self.knots_v:
            out["knotsU"], out["knotsV"] = ([json_number(k) for k in ks] for ks in self.knots())
        return out


def basis(knots, degree, count, t):
    """B-spline basis functions at t in 0..1 of the domain (Cox, de Boor)."""
    a, b = knots[degree], knots[count]
    x = a + t * (b - a)
    span = max(i for i in range(degree, count) if knots[i] <= x and knots[i] < knots[i + 1])
    n = [1.0 if i == span else 0.0 for i in range(len(knots) - 1)]
    for d in range(1, degree + 1):
        n = [(ratio(x - knots[i], knots[i + d] - knots[i]) * n[i] +
              ratio(knots[i + d + 1] - x, knots[i + d + 1] - knots[i + 1]) * n[i + 1])
             for i in range(len(n) - 1)]
    return n[:count]


def ratio(a, b):
    return a / b if b else 0.0


def sub(a, b):
    return tuple(x - y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    length = math.sqrt(sum(x * x for x in a))
    return tuple(x / length for x in a) if length > 0 else (0.0, 0.0, 1.0)


def single(x):
    return struct.unpack("<f", struct.pack("<f", x))[0]


# ---- display triangles ---------------------------------------------------------------------


class Mesh:
    """Positions (mm, part frame), normals, and triangles as index triples."""

    def __init__(self):
        self.positions, self.normals, self.triangles = [], [], []

    def add_surface(self, surface, steps_u, steps_v):
        first, row = len(self.positions), steps_v + 1
        for i in range(steps_u + 1):
            for j in range(row):
                u, v = i / steps_u, j / steps_v
                self.positions.append(surface.evaluate(u, v))
                self.normals.append(surface.normal(u, v))
        for i in range(steps_u):
            for j in range(steps_v):
                a = first + i * row + j
                for corners in ((a, a + row, a + row + 1), (a, a + row + 1, a + 1)):
                    if self.area(corners) > 1e-9:
                        self.triangles.append(corners)

    def area(self, corners):
        a, b, c = (self.positions[i] for i in corners)
        return math.sqrt(sum(x * x for x in cross(sub(b, a), sub(c, a)))) / 2


# ---- documents -----------------------------------------------------------------------------


class Document:
    """A glTF document under construction, with one buffer."""

    def __init__(self, title=""):
        self.json = {"asset": {"version": "2.0", "generator": "bitangent tools/make_assets.py"}}
        if title:
            self.json["asset"]["extras"] = {"title": title}
        self.buffer = bytearray()

    def append(self, key, entry):
        self.json.setdefault(key, []).append(entry)
        return len(self.json[key]) - 1

    def use(self, extension, required=False):
        for key in ["extensionsUsed"] + ["extensionsRequired"] * required:
            if extension not in self.json.get(key, []):
                self.append(key, extension)

    def view(self, data, target=None, stride=None):
        while len(self.buffer) % 4:
            self.buffer.append(0)
        entry = {"buffer": 0, "byteOffset": len(self.buffer), "byteLength": len(data)}
        if stride:
            entry["byteStride"] = stride
        if target:
            entry["target"] = target
        self.buffer += data
        return self.append("bufferViews", entry)

    def accessor(self, rows, kind, component, target=None, bounds=False, **more):
        flat = [x for row in rows for x in row] if kind != "SCALAR" else list(rows)
        packed = array.array(FORMATS[component], flat)
        entry = {"bufferView": self.view(packed.tobytes(), target), "componentType": component,
                 "count": len(flat) // WIDTHS[kind], "type": kind}
        if bounds:
            entry["min"], entry["max"] = extremes(packed, WIDTHS[kind])
        entry.update(more)
        return self.append("accessors", entry)

    def positions(self, points):
        return self.accessor([to_file_axes(p) for p in points], "VEC3", FLOAT, ARRAY_BUFFER, True)

    def primitive(self, mesh):
        normals = [tuple(single(x) for x in (n[0], n[2], -n[1])) for n in mesh.normals]
        kind = U16 if len(mesh.positions) < 65535 else U32
        attributes = {"POSITION": self.positions(mesh.positions)}
        if normals:
            attributes["NORMAL"] = self.accessor(normals, "VEC3", FLOAT, ARRAY_BUFFER)
        corners = [i for t in mesh.triangles for i in t]
        return {"attributes": attributes,
                "indices": self.accessor(corners, "SCALAR", kind, ELEMENT_BUFFER)}

    def scene(self, nodes):
        self.json["scene"] = self.append("scenes", {"nodes": nodes})

    def mesh_node(self, primitives, **node):
        mesh = self.append("meshes", {"primitives": primitives})
        return self.append("nodes", dict(mesh=mesh, **node))

    # -- output

    def save_gltf(self, path, buffer_uri=None):
        if self.buffer:
            data = base64.b64encode(bytes(self.buffer)).decode()
            uri = buffer_uri or "data:application/octet-stream;base64," + data
            self.json["buffers"] = [{"byteLength": len(self.buffer), "uri": uri}]
        with open(path, "w", newline="\n") as out:
            json.dump(self.json, out, separators=(",", ":"))
            out.write("\n")

    def save_glb(self, path):
        if self.buffer:
            self.json["buffers"] = [{"byteLength": len(self.buffer)}]
        text = json.dumps(self.json, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        binary = bytes(self.buffer) + b"\0" * (-len(self.buffer) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
        if binary:
            chunks += struct.pack("<II", len(binary), 0x004E4942) + binary
        with open(path, "wb") as out:
            out.write(struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks)


def extremes(packed, width):
    columns = [packed[i::width] for i in range(width)]
    return [min(c) for c in columns], [max(c) for c in columns]


def surface_document(title, surfaces, steps):
    """Exact surfaces and their display triangles as one primitive of one mesh."""
    document, mesh = Document(title), Mesh()
    for surface in surfaces:
        mesh.add_surface(surface, *steps)
    primitive = document.primitive(mesh)
    primitive["extensions"] = {
        "BITANGENT_tensor_surface": {"surfaces": [s.extension() for s in surfaces]}}
    document.use("BITANGENT_tensor_surface")
    document.scene([document.mesh_node([primitive])])
    return document
