"""Small glTF files for the tests: one part in every layout, and the exact surfaces in theirs.

All files named `same_*` hold the same 24 triangles (a grid of 5 x 4 vertices whose coordinates are
multiples of 1/128 m, exact in single precision); those named `exact_*` hold the saddle.
"""
import array
import os
import struct

from gltf_write import (ARRAY_BUFFER, ELEMENT_BUFFER, FLOAT, I16, U8, U16, U32, Document, Mesh,
                        json_number, surface_document, to_file_axes)

COLUMNS, ROWS = 5, 4
HEIGHTS = [0, 2, 3, 1, 1, 4, 6, 2, 2, 7, 5, 3, 0, 3, 4, 1, 5, 2, 1, 0]
SQUARE_ROOT_OF_HALF = 0.5 ** 0.5


def vertices():
    """glTF space, metres."""
    return [(i / 64, HEIGHTS[i * ROWS + j] / 128, -j / 64 + 0.0)
            for i in range(COLUMNS) for j in range(ROWS)]


def quads():
    return [(a, a + ROWS, a + ROWS + 1, a + 1)
            for i in range(COLUMNS - 1) for j in range(ROWS - 1) for a in [i * ROWS + j]]


def triangles():
    return [t for a, b, c, d in quads() for t in ((a, b, c), (a, c, d))]


def corners():
    return [i for t in triangles() for i in t]


class Variant(Document):
    """A document with the usual steps at hand."""

    def points(self, rows=None, component=FLOAT, **more):
        return self.accessor(rows or vertices(), "VEC3", component, ARRAY_BUFFER, True, **more)

    def indices(self, list_, component=U16):
        return self.accessor(list_, "SCALAR", component, ELEMENT_BUFFER)

    def finish(self, primitives, **node):
        self.scene([self.mesh_node(primitives, **node)])
        return self


def primitive(position, indices=None, **more):
    out = {"attributes": {"POSITION": position}}
    if indices is not None:
        out["indices"] = indices
    out.update(more)
    return out


# ---- indices and modes ---------------------------------------------------------------------


def plain(component=U16):
    v = Variant()
    return v.finish([primitive(v.points(), v.indices(corners(), component))])


def unindexed():
    v, points = Variant(), vertices()
    return v.finish([primitive(v.points([points[i] for i in corners()]))])


def strips():
    """One strip a row of quads, wound like the others: 16 17 12 13 8 9 4 5 0 1."""
    v = Variant()
    position = v.points()
    out = []
    for j in range(ROWS - 1):
        strip = [k for i in reversed(range(COLUMNS)) for k in (i * ROWS + j, i * ROWS + j + 1)]
        out.append(primitive(position, v.indices(strip, U8), mode=5))
    return v.finish(out)


def fans():
    v = Variant()
    position = v.points()
    return v.finish([primitive(position, v.indices(q, U8), mode=6) for q in quads()])


def with_points_and_lines():
    v = Variant()
    position = v.points()
    return v.finish([primitive(position, mode=0),
                     primitive(position, v.indices([0, 1, 2, 3]), mode=1),
                     primitive(position, v.indices(corners()))])


# ---- accessors -----------------------------------------------------------------------------


def interleaved():
    """Position and normal side by side, byteStride 24, an accessor that starts inside."""
    v = Variant()
    data = b"".join(struct.pack("<6f", 0, 1, 0, *p) for p in vertices())
    view = v.view(data, ARRAY_BUFFER, 24)
    columns = list(zip(*vertices()))
    entry = {"bufferView": view, "byteOffset": 12, "componentType": FLOAT, "count": 20,
             "type": "VEC3", "min": [min(c) for c in columns], "max": [max(c) for c in columns]}
    position = v.append("accessors", entry)
    normal = v.append("accessors", {"bufferView": view, "componentType": FLOAT, "count": 20,
                                    "type": "VEC3"})
    out = primitive(position, v.indices(corners()))
    out["attributes"]["NORMAL"] = normal
    return v.finish([out])


def sparse(changed, rows, component=U16):
    """Positions of which `changed` are given sparsely, over `rows` or over zeros."""
    v = Variant()
    position = v.points(rows) if rows else v.append("accessors", {
        "componentType": FLOAT, "count": 20, "type": "VEC3"})
    entry = v.json["accessors"][position]
    kind = {U8: "B", U16: "H", U32: "I"}[component]
    values = [x for i in changed for x in vertices()[i]]
    entry["sparse"] = {
        "count": len(changed),
        "indices": {"bufferView": v.view(array.array(kind, changed).tobytes()),
                    "componentType": component},
        "values": {"bufferView": v.view(array.array("f", values).tobytes())}}
    columns = list(zip(*vertices()))
    entry["min"], entry["max"] = [min(c) for c in columns], [max(c) for c in columns]
    return v.finish([primitive(position, v.indices(corners()))])


def sparse_over_data():
    wrong = [(9.0, 9.0, 9.0) if i in (3, 7, 12) else p for i, p in enumerate(vertices())]
    return sparse([3, 7, 12], wrong, U8)


def sparse_indices():
    """Index accessor without a buffer view: zeros, changed where they are not zero."""
    v = Variant()
    changed = [i for i, c in enumerate(corners()) if c]
    values = [corners()[i] for i in changed]
    index = v.append("accessors", {
        "componentType": U16, "count": len(corners()), "type": "SCALAR",
        "sparse": {"count": len(changed),
                   "indices": {"bufferView": v.view(array.array("H", changed).tobytes()),
                               "componentType": U16},
                   "values": {"bufferView": v.view(array.array("H", values).tobytes())}}})
    return v.finish([primitive(v.points(), index)])


def quantized(normalized):
    """16-bit positions, brought back by the node's scale."""
    v = Variant()
    v.use("KHR_mesh_quantization", True)
    rows = [tuple(int(x * 128) for x in p) + (0,) for p in vertices()]
    view = v.view(array.array("h", [x for r in rows for x in r]).tobytes(), ARRAY_BUFFER, 8)
    columns = list(zip(*rows))[:3]
    entry = {"bufferView": view, "componentType": I16, "count": 20, "type": "VEC3",
             "min": [min(c) for c in columns], "max": [max(c) for c in columns]}
    if normalized:
        entry["normalized"] = True
    scale = 32767 / 128 if normalized else 1 / 128
    position = v.append("accessors", entry)
    return v.finish([primitive(position, v.indices(corners()))], scale=[scale] * 3)


# ---- nodes ---------------------------------------------------------------------------------
# The vertices are moved back, so that the node brings them to where `plain` has them.


def matrix_node():
    """Quarter turn about Y, twice the size, moved: column-major."""
    v = Variant()
    rows = [((-z + 0.25) / 2, (y - 0.5) / 2, (x - 0.125) / 2) for x, y, z in vertices()]
    m = [0, 0, -2, 0, 0, 2, 0, 0, 2, 0, 0, 0, 0.125, 0.5, 0.25, 1]
    return v.finish([primitive(v.points(rows), v.indices(corners()))], matrix=m)


def trs_node():
    v = Variant()
    rows = [((-z + 0.25) / 2, (y - 0.5) / 4, (x - 0.125) / 8) for x, y, z in vertices()]
    half = SQUARE_ROOT_OF_HALF
    return v.finish([primitive(v.points(rows), v.indices(corners()))],
                    rotation=[0, half, 0, half], scale=[2, 4, 8], translation=[0.125, 0.5, 0.25])


def turned_node():
    """A third of a turn about x = y = z; the quaternion is off unit, as exporters leave it."""
    v = Variant()
    rows = [((y - 0.5) / 2, (z - 0.25) / 2, (x - 0.125) / 2) for x, y, z in vertices()]
    return v.finish([primitive(v.points(rows), v.indices(corners()))],
                    rotation=[0.5000001] * 4, scale=[2, 2, 2], translation=[0.125, 0.5, 0.25])


def hierarchy():
    """Two meshes under two levels of nodes; listed children first."""
    v = Variant()
    rows = [((x - 0.5) / 4, (y - 0.25) / 4, (z + 1) / 4) for x, y, z in vertices()]
    position = v.points(rows)
    half = len(corners()) // 2
    one = v.mesh_node([primitive(position, v.indices(corners()[:half]))], scale=[2, 2, 2])
    two = v.mesh_node([primitive(position, v.indices(corners()[half:]))], scale=[2, 2, 2])
    middle = v.append("nodes", {"children": [two, one], "scale": [2, 2, 2]})
    root = v.append("nodes", {"children": [middle], "translation": [0.5, 0.25, -1]})
    v.scene([root])
    return v


def other_scene():
    """The default scene is the second; the first holds a mesh that must stay out."""
    v = Variant()
    far = v.mesh_node([primitive(v.points())], translation=[5, 5, 5])
    v.json["meshes"][0]["primitives"][0]["mode"] = 4
    v.json["meshes"][0]["primitives"][0]["indices"] = v.indices(corners())
    near = v.append("nodes", {"mesh": 0})
    v.scene([far])
    v.scene([near])
    return v


def no_scene():
    v = plain()
    del v.json["scenes"], v.json["scene"]
    return v


def with_missing_texture():
    v = plain()
    v.append("images", {"uri": "there-is-no-such-picture.png"})
    v.append("textures", {"source": 0})
    v.append("materials", {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}})
    v.json["meshes"][0]["primitives"][0]["material"] = 0
    return v


def millimetres_z_up():
    """Not glTF's convention: for --gltf-unit mm --up z."""
    v = Variant()
    rows = [(1000 * x, -1000 * z + 0.0, 1000 * y) for x, y, z in vertices()]
    return v.finish([primitive(v.points(rows), v.indices(corners()))])


# ---- exact surfaces ------------------------------------------------------------------------


def kittycad_surface(surface):
    ku, kv = surface.knots()
    nurbs = {"controlPoints": [[json_number(x) for x in to_file_axes(p)]
                               for row in surface.points for p in row],
             "numControlPoints": [surface.count_u, surface.count_v],
             "numKnots": [len(ku), len(kv)],
             "knotVector": [json_number(k) for k in ku + kv],
             "order": [surface.degree_u + 1, surface.degree_v + 1]}
    if surface.weights:
        nurbs["weights"] = [json_number(w) for row in surface.weights for w in row]
    return {"type": "nurbs", "nurbs": nurbs}


def kittycad(surface, loops=True, steps=4):
    """A solid of one face beside its triangles, as Zoo writes them."""
    v, mesh = Variant(), Mesh()
    mesh.add_surface(surface, steps, steps)
    ends = [surface.points[i][j] for i, j in ((0, 0), (-1, 0), (-1, -1), (0, -1))]
    line = {"type": "line", "line": {"origin": [0, 0, 0], "direction": [1, 0, 0]}}
    root = {"solids": [{"mesh": 0, "shells": [[0, 1]]}],
            "shells": [{"faces": [[0, 1]]}],
            "faces": [{"surface": [0, 1]}],
            "surfaces": [kittycad_surface(surface)]}
    if loops:
        root["faces"][0]["loops"] = [[0, 1]]
        root["loops"] = [{"edges": [[i, 1] for i in range(4)]}]
        root["edges"] = [{"start": i, "end": (i + 1) % 4, "curve": [0, 1], "t": [0, 1]}
                         for i in range(4)]
        root["vertices"] = [list(to_file_axes(p)) for p in ends]
        root["curves3D"] = [line]
    v.json["extensions"] = {"KITTYCAD_boundary_representation": root}
    v.use("KITTYCAD_boundary_representation")
    return v.finish([v.primitive(mesh)])


def kittycad_root(v):
    return v.json["extensions"]["KITTYCAD_boundary_representation"]


def kittycad_loose(surface):
    v = kittycad(surface, False)
    root = kittycad_root(v)
    v.json["extensions"]["KITTYCAD_boundary_representation"] = {"surfaces": root["surfaces"]}
    return v


def kittycad_without_mesh(surface):
    v = kittycad(surface)
    root = kittycad_root(v)
    del root["solids"][0]["mesh"]
    bare = Variant()
    bare.json["extensions"] = v.json["extensions"]
    bare.use("KITTYCAD_boundary_representation", True)
    bare.scene([bare.append("nodes", {"extensions": {
        "KITTYCAD_boundary_representation": {"solid": 0}}})])
    return bare


def kittycad_plane(surface):
    """A face that is no NURBS: the triangles stand in."""
    v = kittycad(surface)
    root = kittycad_root(v)
    root["surfaces"].append({"type": "plane", "plane": {"origin": [0, 0, 0], "xAxis": [1, 0, 0],
                                                        "yAxis": [0, 0, -1]}})
    root["faces"].append({"surface": [1, 1]})
    root["shells"][0]["faces"].append([1, 1])
    return v


def kittycad_trimmed(surface):
    v = kittycad(surface)
    kittycad_root(v)["vertices"][2] = [0.1, 0.09, -0.1]
    return v


def exact_copies(surface):
    """The same mesh twice: as it is, and mirrored and moved by its node."""
    v = surface_document("", [surface], (4, 4))
    v.json["scenes"][0]["nodes"].append(
        v.append("nodes", {"mesh": 0, "scale": [-1, 1, 1], "translation": [-0.125, 0, 0]}))
    return v


# ---- all of them ---------------------------------------------------------------------------


def triangle_files():
    return {
        "same_u16": plain(), "same_u8": plain(U8), "same_u32": plain(U32),
        "same_unindexed": unindexed(), "same_strips": strips(), "same_fans": fans(),
        "same_points_lines": with_points_and_lines(), "same_interleaved": interleaved(),
        "same_sparse": sparse_over_data(), "same_sparse_zeros": sparse(list(range(20)), None),
        "same_sparse_u32": sparse(list(range(20)), None, U32),
        "same_sparse_indices": sparse_indices(),
        "same_quantized": quantized(False), "same_normalized": quantized(True),
        "same_matrix": matrix_node(), "same_trs": trs_node(),
        "same_turned": turned_node(), "same_hierarchy": hierarchy(),
        "same_other_scene": other_scene(), "same_no_scene": no_scene(),
        "same_missing_texture": with_missing_texture(),
        "millimetres_z_up": millimetres_z_up(),
    }


def exact_files(saddle, blade):
    return {
        "exact_saddle": surface_document("", [saddle], (4, 4)),
        "exact_kittycad": kittycad(saddle), "exact_kittycad_no_loops": kittycad(saddle, False),
        "exact_kittycad_loose": kittycad_loose(saddle),
        "exact_kittycad_no_mesh": kittycad_without_mesh(saddle),
        "exact_kittycad_blade": kittycad(blade, True),
        "exact_copies": exact_copies(saddle),
        "kittycad_plane": kittycad_plane(saddle), "kittycad_trimmed": kittycad_trimmed(saddle),
    }


def write_all(folder, saddle, blade):
    files = dict(triangle_files(), **exact_files(saddle, blade))
    for name, document in files.items():
        document.save_gltf(os.path.join(folder, name + ".gltf"))
    plain().save_glb(os.path.join(folder, "same_binary.glb"))
    surface_document("", [saddle], (4, 4)).save_glb(os.path.join(folder, "exact_saddle.glb"))
    kittycad(saddle).save_glb(os.path.join(folder, "exact_kittycad.glb"))
    outside = plain()
    outside.save_gltf(os.path.join(folder, "same_external.gltf"), "grid%20of%2020%20points.bin")
    with open(os.path.join(folder, "grid of 20 points.bin"), "wb") as out:
        out.write(outside.buffer)
