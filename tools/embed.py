"""Makes a C array of a page, with the style sheets and scripts it names put into it.

    python3 embed.py PAGE OUTPUT.c NAME

`<link rel="stylesheet" href="FILE">` and `<script src="FILE"></script>` are replaced by the files'
contents, which stand beside PAGE. The array ends with a zero byte.
"""

import os
import re
import sys


def read(folder, name):
    with open(os.path.join(folder, name), encoding="utf-8") as f:
        return f.read()


def put_together(path):
    folder, name = os.path.split(path)
    page = read(folder, name)
    page = re.sub(
        r'<link rel="stylesheet" href="([\w.-]+)">',
        lambda m: "<style>\n" + read(folder, m[1]) + "</style>",
        page,
    )
    return re.sub(
        r'<script src="([\w.-]+)"></script>',
        lambda m: "<script>\n" + read(folder, m[1]) + "</script>",
        page,
    )


def main(page, output, name):
    data = put_together(page).encode() + b"\0"
    rows = [",".join(str(b) for b in data[i : i + 24]) for i in range(0, len(data), 24)]
    with open(output, "w", encoding="ascii") as f:
        f.write(f"extern const unsigned char {name}[];\n")
        f.write(f"const unsigned char {name}[] = {{\n" + ",\n".join(rows) + "};\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
