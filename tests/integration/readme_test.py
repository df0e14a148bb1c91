#!/usr/bin/env python3
"""The commands of README run unchanged, and print the quoted output."""

import json
import os
import pathlib
import re
import shlex
import subprocess
import tempfile
import unittest

from farm import BIN, SCENES, SOURCE
from png import read_text

README = (SOURCE / "README.md").read_text()


def quoted():
    """Each command behind a `$`, with the lines that it prints."""
    return [(command, printed.splitlines()) for command, printed in
            re.findall(r"^    \$ (parray .*)\n((?:    (?!\$).*\n)*)", README, re.MULTILINE)]


def without_times(line):
    line = re.sub(r"[\d.]+ [kMG]?\s?samples/s", "SPEED", line)
    return re.sub(r"\b[\d.]+ (ms|s|min|h)( \d+ (s|min))?\b", "TIME", line).strip()


class ReadmeTest(unittest.TestCase):
    def setUp(self):
        directory = tempfile.TemporaryDirectory()
        self.addCleanup(directory.cleanup)
        self.directory = directory.name
        os.symlink(SCENES, f"{self.directory}/scenes")

    def printed(self, command):
        words = shlex.split(command, comments=True)
        result = subprocess.run([BIN / words[0], *words[1:]], cwd=self.directory, capture_output=True, text=True,
                                timeout=600)
        self.assertEqual(result.returncode, 0, f"{command}: {result.stderr}")
        return [without_times(line) for line in result.stdout.splitlines()]


class Quick(ReadmeTest):
    def test_times_of_any_length_are_left_out(self):
        for time in ("0.6 s", "11 s", "1 min 03 s", "2 h 01 min", "20 ms"):
            with self.subTest(time=time):
                self.assertEqual(without_times(f"error 0.01, {time}, 19.0 M samples/s"), "error 0.01, TIME, SPEED")

    def test_the_first_command_prints_what_is_quoted(self):
        command, lines = quoted()[0]
        self.assertIn("scenes/glass.json", command)
        self.assertEqual(self.printed(command), [without_times(line) for line in lines])

    def test_the_error_beside_the_first_picture_is_the_one_in_its_file(self):
        kept = read_text(SCENES / "pictures" / "helix.png")
        rmse, low, high = (f"{float(kept['parray:error:' + name]):.3g}" for name in ("rmse", "low", "high"))
        self.assertIn(f"**{rmse}**,<br>{low} to {high} with 95 %", README)
        self.assertEqual(float(kept["parray:target_error"]), 0.01)

    def test_readme_names_all_files_that_stand_for_the_readers_own(self):
        own = re.search(r"Below, (.*?) stand for your own files", README, re.DOTALL).group(1)
        for line in re.findall(r"^    (?:\$ |mpirun -n 64 )?(parray.*)$", README, re.MULTILINE):
            words = shlex.split(line, comments=True)
            read = [word for before, word in zip(words, words[1:]) if before not in ("-o", "--error-map")]
            for word in read:
                is_file = pathlib.PurePath(word).suffix in (".json", ".pdb", ".xtc", ".lammpstrj", ".xyz")
                if is_file and not (SOURCE / word).exists():
                    self.assertIn(f"`{word}`", own, line)

    def test_readme_sets_the_path_before_the_first_command_that_uses_it(self):
        setting = '    export PATH="$PWD/build/release/bin:$PATH"'
        self.assertLess(README.index(setting), README.index("    $ parray "))


class Long(ReadmeTest):
    def test_every_quoted_output_is_printed(self):
        renders = [(command, lines) for command, lines in quoted() if command.startswith("parray render")]
        self.assertGreaterEqual(len(renders), 2)
        for command, lines in renders:
            with self.subTest(command=command):
                self.assertEqual(self.printed(command), [without_times(line) for line in lines])

    def test_every_render_and_validate_runs(self):
        # What stands for the reader's own files.
        small = {**json.loads((SCENES / "glass.json").read_text()), "image": {"width": 90, "height": 60}}
        with open(f"{self.directory}/scene.json", "w", encoding="utf-8") as scene:
            json.dump(small, scene)
        os.symlink(SCENES / "particles" / "helix.pdb", f"{self.directory}/protein.pdb")
        subprocess.run([SOURCE / "tests" / "corpus" / "picture_data.py", self.directory], check=True)
        os.rename(f"{self.directory}/box.lammpstrj", f"{self.directory}/run.lammpstrj")
        commands = re.findall(r"^    (parray (?:render|validate) .*)$", README, re.MULTILINE)
        run = [command for command in commands if "run.xtc" not in command]  # no trajectory is shipped
        self.assertGreaterEqual(len(run), 8)
        for command in run:
            with self.subTest(command=command):
                self.printed(command)


if __name__ == "__main__":
    unittest.main()
