"""The committed parts are what tools/make_assets.py writes, and --mesh writes what it promises."""
import filecmp
import os
import struct
import subprocess
import sys
import tempfile

root = sys.argv[1]
script = os.path.join(root, "tools", "make_assets.py")
faults = 0


def make(*words):
    subprocess.run([sys.executable, script, *words], check=True)


def compare(kept, made):
    global faults
    names = sorted(os.listdir(made))
    for name in names:
        if not os.path.exists(os.path.join(kept, name)) or not filecmp.cmp(
                os.path.join(kept, name), os.path.join(made, name), shallow=False):
            print(f"{os.path.join(kept, name)} is not what make_assets.py writes")
            faults += 1
    return len(names)


with tempfile.TemporaryDirectory() as folder:
    parts, tests = os.path.join(folder, "a"), os.path.join(folder, "t")
    make("-d", parts)
    make("--tests", "-d", tests)
    count = compare(os.path.join(root, "assets"), parts)
    count += compare(os.path.join(root, "tests", "data", "gltf"), tests)
    mesh = os.path.join(folder, "mesh.glb")
    make("--mesh", "1000", "-o", mesh)
    with open(mesh, "rb") as f:
        head = f.read(12)
    if struct.unpack("<I", head[8:])[0] != os.path.getsize(mesh):
        print("mesh.glb says another length than it has")
        faults += 1
print(f"{count} files, {faults} faults")
sys.exit(faults > 0 or count == 0)
