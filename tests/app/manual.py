"""The manual page and the shells' completions: sound for those who read them, and every option and
word they offer is one that the program takes.

    python3 manual.py PROGRAM bitangent.1 BASH_FILE ZSH_FILE FISH_FILE [unittest's own options]
"""

import os
import re
import shutil
import subprocess
import sys
import unittest

import program

sys.path.insert(0, os.path.join(program.ROOT, "tools"))
import manual

FILES = {}
# What makes a word that ends in a colon whole.
REST = {"points:": "x", "fixed:": "10", "gap:": "2"}


def run(*words, text=None):
    return subprocess.run(words, input=text, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          encoding="utf-8", timeout=60)


def needs(name):
    return unittest.skipUnless(shutil.which(name), name + " is not installed")


class Manual(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        _, cls.commands, _ = manual.read(program.PROGRAM)

    def text(self):
        with open(FILES["man"], encoding="utf-8") as f:
            return f.read()

    def test_says_it_all(self):
        """Every word of every help text, and every option as an entry of its own."""
        text = self.text()
        flat = re.sub(r"\\f[BR]|^\.\w+ ?", "", text, flags=re.M)
        for roff, plain in (("\\-", "-"), ("\\(aq", "'"), ("\\&", "")):
            flat = flat.replace(roff, plain)
        for c in self.commands:
            help_text = run(program.PROGRAM, "help", c.name).stdout
            for word in help_text.split()[4:]:
                self.assertIn(word.lower(), flat.lower(), c.name)
            for e in c.entries():
                for name in e.options:
                    self.assertIn("\\fB" + manual.roff(name) + "\\fR", text, c.name)
        self.assertEqual(text.count(".TP\n"), sum(len(c.entries()) for c in self.commands) + 1)

    @needs("mandoc")
    def test_mandoc(self):
        self.assertEqual(run("mandoc", "-T", "lint", "-W", "warning", FILES["man"]).stdout, "")

    @needs("man")
    def test_man(self):
        done = run("man", "--warnings", "-E", "UTF-8", "-l", FILES["man"])
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("--side-step MM", done.stdout)


@unittest.skipIf("BTG_TEST_QUICK" in os.environ, "BTG_TEST_QUICK: completions are tried elsewhere")
class Completion(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        _, cls.commands, _ = manual.read(program.PROGRAM)

    def test_program_takes_them(self):
        for c in self.commands:
            part = ["no.gltf"] if "PART" in c.usage else []
            for e in c.all:
                for name in e.options:
                    done = run(program.PROGRAM, c.name, *part, name)
                    self.assertNotRegex(done.stderr, r"unknown option|: unknown '", (c.name, name))
                    takes = "needs a value" in done.stderr
                    self.assertEqual(takes, bool(e.value), (c.name, name, done.stderr))

    def test_program_takes_their_words(self):
        for name, words in manual.WORDS.items():
            command = next(c.name for c in self.commands for e in c.all if name in e.options)
            for word in words.split():
                done = run(program.PROGRAM, command, "no.gltf", "no.csv", name, word + REST.get(word, ""))
                self.assertNotIn(f"bitangent: {name}: '", done.stderr, (name, word))

    def test_words_are_those_of_the_help(self):
        """An option whose help names its words with | completes them."""
        for c in self.commands:
            for e in c.all:
                if re.fullmatch(r"[a-z0-9]+(\|[a-z0-9]+)+", e.value):
                    self.assertEqual(set(manual.WORDS.get(e.options[-1], "").split()), set(e.value.split("|")), e)

    def bash(self, *words):
        script = (f'source "{FILES["bash"]}"; COMP_WORDS=({" ".join(repr(w) for w in words)}); '
                  f'COMP_CWORD={len(words) - 1}; _bitangent; printf "%s\\n" "${{COMPREPLY[@]}}"')
        done = run("bash", "--norc", "-c", script)
        self.assertEqual(done.stderr, "")
        return done.stdout.split()

    @needs("bash")
    def test_bash(self):
        self.assertEqual(set(self.bash("bitangent", "")) - {"--version", "--help", "help"},
                         {c.name for c in self.commands})
        self.assertEqual(self.bash("bitangent", "ver"), ["verify"])
        self.assertEqual(self.bash("bitangent", "path", "--side"), ["--side-step"])
        self.assertEqual(self.bash("bitangent", "path", "x.gltf", "--up", ""), ["y", "z"])
        self.assertEqual(self.bash("bitangent", "path", "--spin", "w"), ["widest"])
        self.assertEqual(self.bash("bitangent", "report", "--forw"), ["--forward-step"])
        self.assertEqual(self.bash("bitangent", "verify", "--max-g"), ["--max-gouge"])
        self.assertEqual(self.bash("bitangent", "path", "--side-step", "1"), [])
        self.assertIn("tests", [os.path.basename(w) for w in
                                self.bash("bitangent", "path", program.ROOT + "/te")])
        self.assertEqual(self.bash("bitangent", "help", "be"), ["bench"])

    def zsh(self, *words):
        script = ("compdef() {}; _arguments() { print -rl -- \"$@\" }; "
                  "_describe() { print -rl -- $commands }; "
                  f'source "{FILES["zsh"]}"; words=({" ".join(repr(w) for w in words)}); '
                  f"CURRENT={len(words)}; _bitangent")
        done = run("zsh", "-fc", script)
        self.assertEqual(done.stderr, "")
        return done.stdout

    @needs("zsh")
    def test_zsh(self):
        self.assertEqual({line.split(":")[0] for line in self.zsh("bitangent", "").split("\n") if line} - {"help"},
                         {c.name for c in self.commands})
        for c in self.commands:
            text = self.zsh("bitangent", c.name, "-")
            for e in c.all:
                for name in e.options:
                    self.assertRegex(text, r"(?m)^\*?" + re.escape(name) + r"\[", (c.name, name))
        self.assertRegex(self.zsh("bitangent", "path", "-"), r"(?m)^--up\[.*\]:y\|z:\(y z\)$")

    def fish(self, line):
        done = run("fish", "--no-config", "-c", f'source "{FILES["fish"]}"; complete -C "{line}"')
        self.assertEqual(done.stderr, "")
        return [entry.split("\t")[0] for entry in done.stdout.splitlines()]

    @needs("fish")
    def test_fish(self):
        self.assertEqual(set(self.fish("bitangent ")) - {"help"}, {c.name for c in self.commands})
        self.assertEqual(self.fish("bitangent path --side"), ["--side-step"])
        self.assertEqual(self.fish("bitangent path --up "), ["y", "z"])
        self.assertEqual(self.fish("bitangent path --spin w"), ["widest"])
        self.assertIn("--max-gouge", self.fish("bitangent verify --max"))
        self.assertEqual(set(self.fish("bitangent help ")), {c.name for c in self.commands})


if __name__ == "__main__":
    program.PROGRAM = os.path.abspath(sys.argv.pop(1))
    for kind in ("man", "bash", "zsh", "fish"):
        FILES[kind] = os.path.abspath(sys.argv.pop(1))
    unittest.main()
