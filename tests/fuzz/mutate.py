#!/usr/bin/env python3
"""Damages glTF files in many ways, the same ways for the same seed.

    mutate.py [--seed S] [--count N] -o DIR SOURCE...       writes N damaged files into DIR
    mutate.py [--seed S] [--count N] --run PROGRAM [ARGUMENT]... -- SOURCE...
                                        writes them into a temporary folder and runs PROGRAM on it

SOURCE is a .gltf or .glb file, or a folder of them.
"""
import argparse
import json
import os
import random
import shutil
import struct
import subprocess
import sys
import tempfile

NUMBERS = [0, 1, -1, 2, 3, 255, 256, 65535, 65536, 2**31 - 1, 2**31, 2**32 - 1, 2**32, 2**53,
           2**63, 2**64 - 1, 2**64, 10**30, -2**31, -2**63, 0.5, -0.0, 1e-320, 1e300, -1e300,
           5120, 5121, 5123, 5125, 5126, 4.0]
VALUES = [None, True, False, "", "x", "VEC3", "SCALAR", [], {}, [[]], [0], {"a": 1}, [None] * 3,
          "../secret.bin", "/etc/passwd", "http://example.com/a.bin", "%2e%2e/a.bin", "a\nb",
          "data:application/octet-stream;base64,AAAA", "data:,", "\u0000", "\u202e", "9" * 300]
RAW = [b"NaN", b"Infinity", b"-Infinity", b"1e999", b"-1e999", b"[" * 5000, b"{\"a\":" * 3000,
       b"\xff\xfe", b"\x00", b"0x10", b"01", b"1.", b"\"\\ud800\"", b"\xef\xbb\xbf", b"/*", b"]"]


# ---- JSON ----------------------------------------------------------------------------------


def places(value, out):
    """All (container, key) pairs of a document."""
    entries = value.items() if isinstance(value, dict) else enumerate(value)
    for key, child in entries:
        out.append((value, key))
        if isinstance(child, (dict, list)):
            places(child, out)
    return out


def pick(random_, document):
    """A place; lists of numbers are long, so half of the time it must not be one of theirs."""
    all_ = places(document, [])
    short = [(c, k) for c, k in all_ if not (isinstance(c, list) and len(c) > 8)]
    return random_.choice(short if short and random_.random() < 0.5 else all_)


def delete_member(random_, document):
    container, key = pick(random_, document)
    del container[key]


def replace_number(random_, document):
    numbers = [(c, k) for c, k in places(document, [])
               if isinstance(c[k], (int, float)) and not (isinstance(c, list) and len(c) > 16 and
                                                          random_.random() < 0.9)]
    if numbers:
        container, key = random_.choice(numbers)
        container[key] = random_.choice(NUMBERS)


def nudge_number(random_, document):
    numbers = [(c, k) for c, k in places(document, [])
               if type(c[k]) in (int, float) and not isinstance(c, list)]
    if numbers:
        container, key = random_.choice(numbers)
        container[key] += random_.choice([-8, -4, -1, 1, 4, 8])


def swap_type(random_, document):
    container, key = pick(random_, document)
    container[key] = random_.choice(VALUES)


def swap_two(random_, document):
    (a, i), (b, j) = pick(random_, document), pick(random_, document)
    a[i], b[j] = json.loads(json.dumps(b[j])), json.loads(json.dumps(a[i]))


def repeat_entry(random_, document):
    lists = [(c, k) for c, k in places(document, []) if isinstance(c[k], list) and c[k]]
    if lists:
        container, key = random_.choice(lists)
        container[key] += [random_.choice(container[key])] * random_.choice([1, 2, 50])


def point_elsewhere(random_, document):
    """Node and accessor references: cycles, two parents, the wrong kind."""
    keys = ("children", "nodes", "mesh", "indices", "POSITION", "bufferView", "buffer", "scene",
            "solid", "surface", "faces", "shells", "edges", "loops")
    found = [(c, k) for c, k in places(document, []) if k in keys]
    if found:
        container, key = random_.choice(found)
        number = random_.randrange(5)
        container[key] = [number] if isinstance(container[key], list) else number


def add_extension(random_, document):
    name = random_.choice(["KHR_draco_mesh_compression", "EXT_meshopt_compression", "NONE_such\n",
                           "KHR_mesh_quantization", "BITANGENT_tensor_surface",
                           "KITTYCAD_boundary_representation"])
    if random_.random() < 0.5:
        document.setdefault("extensionsRequired", [])
        if isinstance(document["extensionsRequired"], list):
            document["extensionsRequired"].append(name)
        return
    objects = [document] + [c[k] for c, k in places(document, []) if isinstance(c[k], dict)]
    random_.choice(objects)["extensions"] = {name: random_.choice(VALUES)}


JSON_DAMAGE = [delete_member, replace_number, replace_number, nudge_number, swap_type, swap_type,
               swap_two, repeat_entry, point_elsewhere, add_extension]


def damage_json(random_, text):
    document = json.loads(text)
    for _ in range(random_.choice([1, 1, 1, 2, 4])):
        random_.choice(JSON_DAMAGE)(random_, document)
        if not document:
            break
    return json.dumps(document).encode()


# ---- bytes ---------------------------------------------------------------------------------


def cut_short(random_, data):
    return data[:random_.randrange(len(data))]


def flip_bits(random_, data):
    out = bytearray(data)
    for _ in range(random_.choice([1, 1, 3, 20])):
        out[random_.randrange(len(out))] ^= 1 << random_.randrange(8)
    return bytes(out)


def insert_raw(random_, data):
    """Puts something that is hardly JSON in place of a value."""
    starts = [i for i in range(len(data) - 1) if data[i:i + 1] in b":,["]
    if not starts:
        return data
    i = random_.choice(starts) + 1
    return data[:i] + random_.choice(RAW) + data[i + random_.choice([0, 1, 3]):]


def overwrite_block(random_, data):
    i, size = random_.randrange(len(data)), random_.choice([1, 4, 64])
    filler = random_.choice([b"\0", b"\xff", b"A", bytes([random_.randrange(256)])])
    return data[:i] + filler * size + data[i + size:]


BYTE_DAMAGE = [cut_short, flip_bits, insert_raw, overwrite_block]


# ---- files ---------------------------------------------------------------------------------


def glb_parts(data):
    size = struct.unpack_from("<I", data, 12)[0]
    return data[20:20 + size], data[20 + size:]


def glb_join(text, rest):
    text += b" " * (-len(text) % 4)
    body = struct.pack("<II", len(text), 0x4E4F534A) + text + rest
    return struct.pack("<III", 0x46546C67, 2, 12 + len(body)) + body


def damage_glb_header(random_, data):
    """A length or type of the header or of a chunk."""
    text, _ = glb_parts(data)
    at = random_.choice([4, 8, 12, 16, 20 + len(text), 24 + len(text)])
    if at + 4 > len(data):
        return data
    value = random_.choice([0, 1, 3, 4, len(data), len(data) - 4, len(data) + 8, 2**31, 2**32 - 1,
                            2**32 - 4, len(text) + 4, 0x004E4942, 0x4E4F534A])
    return data[:at] + struct.pack("<I", value) + data[at + 4:]


def damage(random_, data):
    binary = data[:4] == b"glTF"
    roll = random_.random()
    if binary and roll < 0.25:
        return damage_glb_header(random_, data)
    if roll < 0.7:
        text, rest = glb_parts(data) if binary else (data, b"")
        text = damage_json(random_, text)
        return glb_join(text, rest) if binary else text
    if binary and roll < 0.8:
        text, rest = glb_parts(data)
        return glb_join(text, flip_bits(random_, rest) if rest else rest)
    if binary and roll < 0.85:
        text, rest = glb_parts(data)
        return glb_join(insert_raw(random_, text), rest)
    return random_.choice(BYTE_DAMAGE)(random_, data)


def sources(paths):
    files = []
    for path in paths:
        names = [os.path.join(path, n) for n in sorted(os.listdir(path))] if os.path.isdir(
            path) else [path]
        files += [n for n in names if n.endswith((".gltf", ".glb"))]
    if not files:
        sys.exit("mutate.py: no .gltf or .glb among the sources")
    return files


def write_damaged(seed, count, files, folder):
    """Larger files come up less often: most of the loader shows in the small ones."""
    weights = [1.0 / (1000 + os.path.getsize(f)) for f in files]
    contents = [open(f, "rb").read() for f in files]
    for number in range(count):
        random_ = random.Random(seed * 1000003 + number)
        choice = random_.choices(range(len(files)), weights)[0]
        name = os.path.basename(files[choice])
        with open(os.path.join(folder, f"{number:05d}-{name}"), "wb") as out:
            out.write(damage(random_, contents[choice]))
    for path in {os.path.dirname(f) for f in files}:
        for name in os.listdir(path):
            if name.endswith(".bin"):
                shutil.copy(os.path.join(path, name), folder)


def main():
    words = sys.argv[1:]
    command = []
    if "--run" in words:
        start = words.index("--run")
        end = words.index("--", start)
        command, words = words[start + 1:end], words[:start] + words[end + 1:]
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=4000)
    parser.add_argument("-o", metavar="DIR")
    parser.add_argument("sources", nargs="+")
    options = parser.parse_args(words)
    if bool(options.o) == bool(command):
        parser.error("give -o DIR or --run PROGRAM ... --")
    files = sources(options.sources)
    if options.o:
        os.makedirs(options.o, exist_ok=True)
        write_damaged(options.seed, options.count, files, options.o)
        return 0
    with tempfile.TemporaryDirectory(prefix="bitangent-fuzz-") as folder:
        write_damaged(options.seed, options.count, files, folder)
        print(f"seed {options.seed}, {options.count} files of {len(files)} sources", flush=True)
        return subprocess.run(command + [folder]).returncode


if __name__ == "__main__":
    sys.exit(main())
