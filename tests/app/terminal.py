"""What the program shows on a terminal: colours there and nowhere else, progress with rate and time
left, nothing of a file's name that the terminal would obey.

    python3 terminal.py PATH_OF_BITANGENT [unittest's own options]
"""

import os
import pty
import re
import subprocess
import sys
import threading
import unittest

import program


class Terminal(program.Case):
    def on_terminal(self, *words, **variables):
        """Everything the program writes, to a terminal."""
        environment = {k: v for k, v in os.environ.items() if k != "NO_COLOR"}
        environment.update({"TERM": "xterm", **variables})
        # The terminal outlives the program: one that hangs up may lose what was not read yet.
        end = b"\0the end\0"
        master, slave = pty.openpty()
        started = subprocess.Popen(
            [program.PROGRAM, *words], env=environment, stdin=slave, stdout=slave, stderr=slave, start_new_session=True
        )

        def say_end():
            self.code = started.wait()
            os.write(slave, end)

        ending = threading.Thread(target=say_end)
        ending.start()
        text = b""
        while not text.endswith(end):
            text += os.read(master, 65536)
        ending.join()
        os.close(slave)
        os.close(master)
        return text[: -len(end)].decode()

    def bare(self, text):
        return re.sub(r"\x1b\[[0-9;]*[mK]", "", text).replace("\r\n", "\n")

    def test_colours(self):
        words = ("path", self.part, "--forward-step", "20", "--max-tilt", "3")
        shown = self.on_terminal(*words)
        self.assertEqual(self.code, 0, shown)
        self.assertIn("\x1b[1mpositions\x1b[0m ", shown)
        self.assertRegex(shown, "\x1b\\[33msingle-contact\x1b\\[0m")
        # The same table, but for the time it took.
        same = lambda text: re.sub(r"solved.*", "", text)
        self.assertEqual(same(self.bare(shown)), same(self.good(*words)))

    def test_none_elsewhere(self):
        for words in (("path", self.part), ("info",), ("help",)):
            self.assertNotIn("\x1b", self.good(*words))
        self.assertNotIn("\x1b", self.on_terminal("info", NO_COLOR="1"))
        self.assertIn("\x1b", self.on_terminal("info", NO_COLOR=""))
        self.assertNotIn("\x1b", self.on_terminal("info", TERM="dumb"))
        self.assertNotIn("\x1b", self.on_terminal("path", self.part, "--json", "--quiet"))

    def test_trouble(self):
        path = self.at("path.csv")
        self.good("path", self.part, "--quiet", "-o", path)
        shown = self.on_terminal("verify", self.part, path, "--grid", "1", "--max-scallop", "1e-9")
        self.assertEqual(self.code, 1)
        self.assertIn("\x1b[1;31mBEYOND\x1b[0m", shown)
        self.assertIn("\x1b[1;31mNOT OK\x1b[0m", shown)
        shown = self.on_terminal("verify", self.part, path, "--grid", "1")
        self.assertIn("\x1b[32mok\x1b[0m", shown)
        shown = self.on_terminal("path", self.at("none.gltf"))
        self.assertEqual(self.code, 2)
        self.assertTrue(shown.startswith("\x1b[1;31mbitangent:\x1b[0m "), shown)

    def test_names_stay_text(self):
        """A name that clears the screen, or says ok in another's words, does neither."""
        part = self.at("\x1b[2J ok.gltf")
        program.make_part(part)
        shown = self.on_terminal("path", part, "--forward-step", "20")
        self.assertNotIn("\x1b[2J", shown)
        self.assertIn("?[2J ok.gltf", self.bare(shown))

    def test_progress(self):
        """A bar with rate and time left, gone at the end."""
        words = ("path", self.part, "--backend", "reference", "--forward-step", "0.3", "--side-step", "15")
        shown = self.on_terminal(*words)
        if float(re.search(r"in ([\d.e+-]+) s,", self.bare(shown))[1]) < 1:
            self.skipTest("this machine is done before there is progress to show")
        bars = re.findall(r"\r\[([#.]{30})\] +(\d+) %  (\d+) positions/s  ([\d:]+ s|[\d:]+) left\x1b\[K", shown)
        self.assertGreater(len(bars), 1, shown)
        shares = [int(b[1]) for b in bars]
        self.assertEqual(shares, sorted(shares))
        self.assertTrue(all(int(b[2]) > 0 for b in bars))
        self.assertTrue(all(abs(b[0].count("#") - 0.3 * int(b[1])) <= 1.2 for b in bars))
        self.assertIn("\r\x1b[K", shown)
        self.assertEqual(self.on_terminal("path", self.part, "--quiet"), "")


if __name__ == "__main__":
    program.PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
