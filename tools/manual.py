"""Writes the manual page and the shells' completions from the program's own help.

    python3 manual.py KIND OUTPUT PROGRAM       KIND: man, bash, zsh or fish

A help text is a line of usage, paragraphs, and entries: two blanks, options, two blanks or more (or
a new line), what they do; lines without indentation between entries are headings.
"""

import re
import subprocess
import sys
from dataclasses import dataclass, field

# Words an option takes; what is not here takes a file, or something of the user's own.
WORDS = {
    "--tool": "",
    "--footprint": "parallel zigzag one-way contour points:",
    "--method": "vcrf vcrf-grid depth dst drd sr direct bisection",
    "--levels": "1 2",
    "--backend": "auto cpu reference osmesa gl vulkan",
    "--spin": "none fixed: gap: across widest",
    "--gltf-unit": "m mm",
    "--up": "y z",
    "--machine": "xyzac-trt xyzbc-trt fanuc siemens heidenhain",
    "--links": "pass all",
    "--look-at": "tool part",
    "--view-from": "tilt iso top front back left right",
    "--only": "speed latency triangles degree threads tolerance path spin backends",
}
DATE = "2026-11-22"  # of this version
FILES = {"-o", "--output", "--machine", "--points", "--csv", "--screenshot"}


@dataclass
class Entry:
    options: list  # names, the long one last
    value: str  # "" where it takes none
    text: str
    head: str
    others: bool = False  # a list of options that another command explains


@dataclass
class Command:
    name: str
    usage: str
    summary: str
    blocks: list = field(default_factory=list)  # ("text" or "heading", str) or ("entry", Entry)

    def entries(self):
        return [b for kind, b in self.blocks if kind == "entry"]


def ask(program, *words):
    return subprocess.run(
        [program, "help", *words], check=True, stdout=subprocess.PIPE, encoding="utf-8"
    ).stdout


def parse_entry(head, text):
    names = re.findall(r"(?<![\w-])(--[a-z][a-z-]*|-[a-z])(?![\w-])", head)
    others = len([n for n in names if n.startswith("--")]) > 1
    value = re.search(r"(?:--?[a-z-]+) (\S+)$", head)
    return Entry(names, "" if others or not value else value[1], text, head, others)


def parse(name, summary, text):
    lines = text.rstrip("\n").split("\n")
    command = Command(name, lines[0], summary)
    i = 1
    while i < len(lines):
        line = lines[i]
        i += 1
        if not line:
            continue
        if line.startswith("  -"):
            head, _, about = re.match(r"  (.*?)(  +(.*))?$", line).groups()
            parts = [about] if about else []
            while i < len(lines) and re.match(r" {10,}\S|  --?\S+,", lines[i]):
                more = lines[i].strip()
                if not lines[i].startswith(" " * 10):
                    if not head.endswith(","):
                        break
                    head += " " + more
                else:
                    parts.append(more)
                i += 1
            command.blocks.append(("entry", parse_entry(head, " ".join(parts))))
            continue
        after_entry = command.blocks and command.blocks[-1][0] == "entry"
        if after_entry and i < len(lines) and lines[i].startswith("  -"):
            command.blocks.append(("heading", line))
            continue
        if not after_entry and i < len(lines) and lines[i].startswith("  -") and lines[i - 2]:
            command.blocks.append(("heading", line))
            continue
        parts = [line]
        while i < len(lines) and lines[i] and not lines[i].startswith("  -"):
            parts.append(lines[i])
            i += 1
        command.blocks.append(("text", " ".join(p.strip() for p in parts)))
    return command


def takes(program, command, option):
    """The command knows the option."""
    done = subprocess.run([program, command, "no.gltf", option], stdout=subprocess.DEVNULL,
                          stderr=subprocess.PIPE, encoding="utf-8")
    return "unknown option" not in done.stderr


def read(program):
    general, commands = ask(program), []
    for name, summary in re.findall(r"^  bitangent (\w+)(?: \S+)*?  +(.*)$", general, re.M):
        if name != "help":
            commands.append(parse(name, summary, ask(program, name)))
    path = next(c for c in commands if c.name == "path")
    for c in commands:
        # Taken over from `path`: with its values, and all of them where the help says so.
        known = {n: e for e in path.entries() for n in e.options}
        taken = [known[n] for e in c.entries() if e.others for n in e.options if n in known]
        whole = c.name == "report" or any(e.head.endswith("...") for e in c.entries())
        c.all = [e for e in c.entries() if not e.others]
        c.all += [Entry([n], "", "", n) for n in re.findall(r"\[(--[a-z-]+)\]", c.usage)]
        have = {n for e in c.all for n in e.options}
        for e in path.entries() if whole else taken:
            if not set(e.options) & have and takes(program, c.name, e.options[-1]):
                c.all.append(e)
    version = subprocess.run([program, "--version"], check=True, stdout=subprocess.PIPE,
                             encoding="utf-8").stdout.split()[1]
    return general, commands, version


# ---- man -----------------------------------------------------------------------------------------


def roff(text):
    text = text.replace("\\", "\\e").replace("-", "\\-").replace("'", "\\(aq")
    return "\\&" + text if text.startswith(".") else text


def bold_options(head):
    return re.sub(r"(?<![\w-])(--?[a-z][a-z-]*)", lambda m: f"\\fB{roff(m[1])}\\fR", head)


def manual(general, commands, version):
    out = [f'.TH BITANGENT 1 {DATE} "bitangent {version}" "User Commands"', ".SH NAME",
           "bitangent \\- " + roff(general.split("\n")[0].split(": ", 1)[1]), ".SH SYNOPSIS"]
    for i, c in enumerate(commands):
        words = c.usage.split(" ", 2)
        out += ([] if i == 0 else [".br"]) + [f".B bitangent {words[1]}", roff(" ".join(words[2:]))]
    out += [".SH DESCRIPTION",
            "Places a milling cutter on a freeform part so that it touches the part at two points "
            "and cuts into it nowhere, for five\\-axis machines."]
    for c in commands:
        out += [".SH " + roff("bitangent " + c.name).upper()]
        fresh = True
        for kind, b in c.blocks:
            if kind == "text":
                out += ([] if fresh else [".PP"]) + [roff(b)]
            elif kind == "heading":
                out += [".SS " + roff(b[0].upper() + b[1:])]
            else:
                out += [".TP", bold_options(b.head), roff(b.text)]
            fresh = kind == "heading"
    status = re.search(r"Exit status: (.*)", general)[1]
    out += [".SH EXIT STATUS", roff(status[0].upper() + status[1:]), ".SH ENVIRONMENT", ".TP",
            ".B NO_COLOR", "No colours on terminals when this is set."]
    return "\n".join(out) + "\n"


# ---- shells --------------------------------------------------------------------------------------


def bash(commands):
    cases = []
    for c in commands:
        options = " ".join(n for e in c.all for n in e.options)
        cases.append(f'    {c.name}) options="{options} --help" ;;')
    words = [f'    {n}) COMPREPLY=($(compgen -W "{w}" -- "$word")) ;;' for n, w in WORDS.items()
             if w and n not in FILES]
    mixed = [f'    {n}) COMPREPLY=($(compgen -W "{w}" -- "$word") $(compgen -f -- "$word")) ;;'
             for n, w in WORDS.items() if n in FILES]
    files = "|".join(sorted(FILES - set(WORDS)))
    values = sorted({n for c in commands for e in c.all if e.value for n in e.options}
                    - set(n for n, w in WORDS.items() if w) - FILES)
    return f"""# bash completion for bitangent
_bitangent() {{
    local word=${{COMP_WORDS[COMP_CWORD]}} last=${{COMP_WORDS[COMP_CWORD-1]}} options
    COMPREPLY=()
    compopt -o filenames 2>/dev/null
    if [ "$COMP_CWORD" -eq 1 ]; then
        COMPREPLY=($(compgen -W "{' '.join(c.name for c in commands)} help --version --help" -- "$word"))
        return
    fi
    case ${{COMP_WORDS[1]}} in
{chr(10).join(cases)}
    help)
        COMPREPLY=($(compgen -W "{' '.join(c.name for c in commands)}" -- "$word"))
        return
        ;;
    *) return ;;
    esac
    case $last in
{chr(10).join(words + mixed)}
    {files}) COMPREPLY=($(compgen -f -- "$word")) ;;
    {"|".join(values)}) ;;
    *)
        case $word in
        -*) COMPREPLY=($(compgen -W "$options" -- "$word")) ;;
        *) COMPREPLY=($(compgen -f -- "$word")) ;;
        esac
        ;;
    esac
    [[ ${{COMPREPLY[0]}} == *: ]] && compopt -o nospace 2>/dev/null
    return 0
}}
complete -F _bitangent bitangent
"""


def plain(text, most=72):
    text = re.split(r"; |: |\. ", text)[0].strip().rstrip(".,")
    return text if len(text) <= most else text[: most - 1].rsplit(" ", 1)[0] + "…"


def action(entry):
    if not entry.value:
        return ""
    name, words = entry.options[-1], WORDS.get(entry.options[-1], "")
    if name in FILES and words:
        return f":{entry.value.lower()}:_alternative 'words\\:name\\:({words})' 'files\\:file\\:_files'"
    if name in FILES:
        return ":file:_files"
    return f":{entry.value.split(',')[0].lower()}:" + (f"({words})".replace(":", "\\:") if words else "")


def zsh(commands):
    quote = lambda s: "'" + s.replace("'", "'\\''") + "'"
    escape = lambda s: re.sub(r"([\[\]:\\])", r"\\\1", s)
    blocks = []
    for c in commands:
        lines = []
        for e in c.all:
            about = escape(plain(e.text)) or "option"
            for name in e.options:
                repeat = "*" if name in ("-o", "--output", "--holder") else ""
                lines.append(quote(f"{repeat}{name}[{about}]{action(e)}"))
        lines += ["'--help[show the help]'", "'*:file:_files'"]
        blocks.append(f"    {c.name})\n        _arguments \\\n            " +
                      " \\\n            ".join(lines) + "\n        ;;")
    names = " \\\n            ".join(quote(f"{c.name}:{c.summary}") for c in commands)
    return f"""#compdef bitangent
_bitangent() {{
    local -a commands
    commands=({names} 'help:show the help')
    if (( CURRENT == 2 )); then
        _describe command commands
        return
    fi
    local command=$words[2]
    shift words
    (( CURRENT-- ))
    case $command in
{chr(10).join(blocks)}
    help) _describe command commands ;;
    esac
}}
if [ "$funcstack[1]" = _bitangent ]; then
    _bitangent "$@"
else
    compdef _bitangent bitangent
fi
"""


def fish(commands):
    quote = lambda s: "'" + s.replace("\\", "\\\\").replace("'", "\\'") + "'"
    names = " ".join(c.name for c in commands) + " help"
    out = ["# fish completion for bitangent", "complete -c bitangent -e",
           f"complete -c bitangent -f -n 'not __fish_seen_subcommand_from {names}' -l version -d 'Version'"]
    for c in commands:
        out.append(f"complete -c bitangent -f -n 'not __fish_seen_subcommand_from {names}' "
                   f"-a {c.name} -d {quote(c.summary)}")
        seen = f"-n '__fish_seen_subcommand_from {c.name}'"
        for e in c.all:
            short = [n[1:] for n in e.options if not n.startswith("--")]
            long = [n[2:] for n in e.options if n.startswith("--")]
            line = f"complete -c bitangent {seen}"
            line += "".join(f" -s {s}" for s in short) + "".join(f" -l {n}" for n in long)
            words = WORDS.get(e.options[-1], "")
            if e.value:
                line += " -r" + ("" if e.options[-1] in FILES else " -f")
            if words:
                line += f" -a {quote(words)}"
            out.append(line + f" -d {quote(plain(e.text))}")
    out.append(f"complete -c bitangent -f -n '__fish_seen_subcommand_from help' "
               f"-a {quote(' '.join(c.name for c in commands))}")
    return "\n".join(out) + "\n"


def main(kind, output, program):
    general, commands, version = read(program)
    text = manual(general, commands, version) if kind == "man" else \
        {"bash": bash, "zsh": zsh, "fish": fish}[kind](commands)
    with open(output, "w", encoding="utf-8") as f:
        f.write(text)


if __name__ == "__main__":
    main(*sys.argv[1:])
