"""Makes a C array of a text, with the files it names put into it.

    python3 embed.py TEXT OUTPUT NAME     the array, ending with a zero byte
    python3 embed.py TEXT OUTPUT          the text itself, put together

Of a page `<link rel="stylesheet" href="FILE">` and `<script src="FILE"></script>` are replaced by
the files' contents, of a shader `#include "FILE"`; they stand beside TEXT.
"""

import os
import re
import sys


def read(folder, name):
    with open(os.path.join(folder, name), encoding="utf-8") as f:
        return f.read()


def shader(folder, name):
    text = read(folder, name)
    # Drivers know no includes, nor the extension for them.
    text = re.sub(r"#extension GL_GOOGLE_include_directive .*\n", "", text)
    return re.sub(r'#include "([\w.-]+)"\n', lambda m: shader(folder, m[1]), text)


def put_together(path):
    folder, name = os.path.split(path)
    if name.endswith(".comp"):
        return shader(folder, name)
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


def main(path, output, name=None):
    text = put_together(path)
    if not name:
        with open(output, "w", encoding="utf-8") as f:
            f.write(text)
        return
    data = text.encode() + b"\0"
    rows = [",".join(str(b) for b in data[i : i + 24]) for i in range(0, len(data), 24)]
    with open(output, "w", encoding="ascii") as f:
        f.write(f"extern const unsigned char {name}[];\n")
        f.write(f"const unsigned char {name}[] = {{\n" + ",\n".join(rows) + "};\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
