#!/usr/bin/env python3
"""Help, man pages and completion come from one description: each contains all of it, and shells, man and the programs
accept the result."""

import contextlib
import functools
import json
import os
import pathlib
import pty
import re
import select
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

from farm import BIN, SCENES, SOURCE, Farm, run

PROGRAMS = [name for name in ("parray", "parray-coordinator", "parray-worker", "parray-mpi")
            if (BIN / name).exists()]
CTRL_C = "\x03"


@functools.cache
def described(program):
    """Returns the program's description of itself, read from JSON."""
    return json.loads(subprocess.run([BIN / program, "--describe", "json"], check=True,
                                     capture_output=True, text=True).stdout)


def make_pages(program, directory, manual=SOURCE / "deploy/MANUAL.md", command=(), **options):
    subprocess.run([sys.executable, SOURCE / "cmake/pages.py", manual, directory, *command, BIN / program], check=True,
                   **options)


def commands_of(program):
    """Returns the program and its commands."""
    description = described(program)
    return [description, *description["commands"]]


def names_of(command):
    return [name for option in command["options"] for name in option["names"]]


class PagesTest(unittest.TestCase):
    """Has the pages and completions of all programs."""

    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory(prefix="parray-pages-")
        cls.addClassCleanup(temporary.cleanup)
        cls.share = pathlib.Path(temporary.name)
        for program in PROGRAMS:
            make_pages(program, cls.share)

    def page(self, command):
        return self.share / "man/man1" / (command["page"] + ".1")

    def needs(self, program):
        if shutil.which(program) is None:
            self.skipTest(program + " is not installed")


class ManPages(PagesTest):
    def test_there_is_a_page_for_every_command(self):
        self.assertEqual({page.stem for page in self.share.glob("man/man1/*.1")},
                         {command["page"] for program in PROGRAMS for command in commands_of(program)})

    def test_man_formats_a_page_without_a_warning_and_shows_every_option_and_example_of_its_command(self):
        self.needs("man")
        environment = {**os.environ, "MANWIDTH": "300", "LC_ALL": "C.UTF-8"}
        for program in PROGRAMS:
            for command in commands_of(program):
                result = subprocess.run(["man", "--warnings=w", "-l", self.page(command)], capture_output=True, text=True,
                                        env=environment)
                text = result.stdout
                self.assertEqual((result.returncode, result.stderr), (0, ""), command["page"])
                for name in names_of(command):
                    self.assertRegex(text, rf"(?m)^ +(.*, )?{name}\b", command["name"])
                for example in command["examples"]:
                    self.assertIn("\n           " + example["command"] + "\n", text)
                self.assertNotIn("`", text)

    def test_pages_depend_neither_on_the_machine_nor_on_its_environment(self):
        for program in PROGRAMS:
            with tempfile.TemporaryDirectory() as other:
                make_pages(program, other, command=["taskset", "-c", "0"],
                           env={"COLUMNS": "50", "PARRAY_KEYS": "x", "PARRAY_COORDINATOR": "y"})
                for path in pathlib.Path(other).rglob("*.*"):
                    twin = self.share / path.relative_to(other)
                    if path.is_file():
                        self.assertEqual(path.read_text(), twin.read_text())

    def test_a_page_shows_characters_that_are_special_in_troff(self):
        with tempfile.TemporaryDirectory() as other:
            manual = pathlib.Path(other, "MANUAL.md")
            manual.write_text("# parray\n\n.dot at the beginning\n'quote' and \\back, `--literal`\n\n- point one\n"
                              "  goes on\n\n    literal 'block' \\n\n\n## Heading\n\nlast, [a link](x.md#y)\n\n"
                              "| a | b |\n|---|---|\n| `key` | value |\n\ninclude: part.md \"Part\"\n")
            pathlib.Path(other, "part.md").write_text("# Other\n\nno\n\n## Part\n\nincluded\n\n## More\n\nno\n")
            make_pages("parray", other, manual)
            page = pathlib.Path(other, "man/man1/parray.1").read_text()
        for part in ("\n\\&.dot at the beginning\n", "\n\\(aqquote\\(aq and \\eback, \\fB\\-\\-literal\\fR\n",
                     "\n.IP \\(bu 2\npoint one\ngoes on\n", "\n.EX\n\\&literal \\(aqblock\\(aq \\en\n.EE\n",
                     '\n.SH "HEADING"\n.PP\nlast, a link\n.TP\n\\fBkey\\fR\nvalue\n.PP\nincluded\n.SH COMMANDS\n'):
            self.assertIn(part, page)

    def test_every_text_of_the_manual_belongs_to_a_page(self):
        names = re.findall(r"(?m)^# (.*)", (SOURCE / "deploy/MANUAL.md").read_text())
        pages = {command["page"] for program in PROGRAMS for command in commands_of(program)}
        self.assertEqual(set(names) - pages - {"parray-mpi"}, set())


class Help(unittest.TestCase):
    def test_lines_fit_the_terminal_except_for_examples(self):
        for columns, widest in (("60", 60), ("80", 80), ("500", 100), ("", 80), ("7", 40)):
            for command in ("render", "submit", "tradeoff"):
                text = run(command, "--help", env={"COLUMNS": columns}).stdout
                body = re.sub(r"(?s)Examples:\n.*?\n\n", "", text)
                for line in body.splitlines():
                    if len(line.split()) > 2 and not line.endswith(":"):
                        self.assertLessEqual(len(line), widest, line)
        main, terminal = pty.openpty()
        subprocess.run(["stty", "cols", "64"], stdin=terminal, check=True)
        environment = {name: value for name, value in os.environ.items() if name != "COLUMNS"}
        subprocess.run([BIN / "parray", "doctor", "--help"], stdout=terminal, check=True,
                       env=environment)
        os.close(terminal)
        text = b""
        with os.fdopen(main, "rb", 0) as screen, contextlib.suppress(OSError):  # EIO is its end
            while part := screen.read(100000):
                text += part
        lines = text.decode().splitlines()
        self.assertTrue(64 >= max(map(len, lines)) > 40, lines)

    def test_the_command_help_prints_the_same_as_the_flag(self):
        self.assertEqual(run("help").stdout, run("--help").stdout)
        for command in described("parray")["commands"]:
            word = command["name"].split()[1]
            text = run("help", word).stdout
            self.assertEqual(text, run(word, "--help").stdout)
            self.assertEqual(text, run(word, "-h").stdout)
            self.assertIn("Examples:\n  parray " + word, text)
            self.assertRegex(text, f"\nMore.*man parray-{word}\n")
        special = "--accelerator", "--isa", "--schedule", "--row-order", "--passes", "--colormap", "--font-size"
        text = run("help", "render").stdout
        self.assertIn("More options: parray help render --all, man parray-render\n", text)
        self.assertLess(text.index("Examples:"), text.index("--width"))
        self.assertTrue(15 <= len(re.findall(r"(?m)^  (?:-\w, )?--", text)) <= 25, text)
        for name in special:
            self.assertNotIn(name, text)
            self.assertIn(name, run("help", "render", "--all").stdout)
        wrong = run("help", "rendr")
        self.assertEqual((wrong.returncode, wrong.stdout), (2, ""))
        self.assertEqual(wrong.stderr, "parray: unknown command 'rendr': did you mean render?; "
                                       "see `parray help`\n")

    def test_a_half_width_is_said_to_be_of_channels_as_it_is_counted(self):
        self.assertIn("99 % of all pixel values (each channel)",
                      re.sub(r"\s+", " ", run("help", "render", "--all").stdout))

    def test_no_help_says_a_thing_twice(self):
        for program in PROGRAMS:
            for command in commands_of(program):
                for option in command["options"]:
                    self.assertFalse(re.search(r"default.*default", option["text"] + option["default"]))
                    if option["default"]:
                        self.assertNotIn("default", option["text"])
                names = names_of(command)
                self.assertEqual(len(names), len(set(names)))

    def test_a_flag_has_one_name_but_for_short_forms_and_two_old_ones(self):
        aliases = set()
        for program in PROGRAMS:
            for command in commands_of(program):
                for option in command["options"]:
                    long_names = [name for name in option["names"] if name.startswith("--")]
                    aliases.update(long_names[1:])
                    self.assertLessEqual(len(long_names), 2)
        self.assertEqual(aliases, {"--bind", "--connect"})

    def test_a_name_takes_a_value_in_all_commands_or_in_none(self):
        for program in PROGRAMS:
            kinds = {}
            for command in commands_of(program):
                for option in command["options"]:
                    for name in option["names"]:
                        kinds.setdefault(name, set()).add(bool(option["value"]))
            self.assertEqual([name for name, kind in kinds.items() if len(kind) > 1], [])


SMALL = ["--width", "24", "--height", "16"]


class Examples(unittest.TestCase):
    """Run as they stand, but smaller."""

    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix="parray-examples-")
        self.addCleanup(temporary.cleanup)
        self.directory = pathlib.Path(temporary.name)
        (self.directory / "scenes").symlink_to(SCENES)
        for name in ("scene-0001.json", "scene-0002.json"):
            shutil.copy(SCENES / "glass.json", self.directory / name)
        (self.directory / "atoms.xyz").write_text("1\n\nC 0 0 0\n")
        (self.directory / "run.xyz").write_text("1\n\nC 0 0 0\n" * 21)
        (self.directory / "path.json").write_text(json.dumps({"cameras": [
            {"frame": frame, "look_from": [frame, 2, 9], "look_at": [0, 0, 0], "vfov": 30} for frame in (0, 4)]}))
        for picture in ("reference.exr", "a.exr", "b.png", "glass.exr"):
            self.take(["render", "scenes/glass.json", "-o", picture, "--spp", "4", *SMALL])

    def take(self, words, environment=None):
        result = subprocess.run([BIN / "parray", *words], cwd=self.directory, capture_output=True,
                                text=True, timeout=300, env={**os.environ, **(environment or {})})
        self.assertEqual(result.returncode, 0, (words, result.stderr))

    def smaller(self, command, words):
        extra = {"plan": [*SMALL, "--probe-seconds", "0.2"], "render": [*SMALL, "--spp", "2"],
                 "tradeoff": ["--width", "12", "--height", "8", "--time-budget", "1"]}
        if command in ("submit", "film"):
            return [*words, *SMALL, "--spp", "2"]
        if "--time-limit" in words:
            words = [*words]
            words[words.index("--time-limit") + 1] = "0.3"
        if "--denoise" in words or "--time-limit" in words or command == "plan":
            return [*words, *SMALL]
        return [*words, *extra.get(command, [])]

    def examples(self, with_farm):
        for command in described("parray")["commands"]:
            farm = "--coordinator" in names_of(command)
            if farm == with_farm:
                for example in command["examples"]:
                    yield command["name"].split()[1], shlex.split(example["command"])[1:]

    def test_examples_that_need_no_farm_do_what_they_say(self):
        for command, words in self.examples(with_farm=False):
            if words == ["keygen", "farm", "--remove", "ann"] or words[-2:] == ["--share", "3"]:
                shutil.rmtree(self.directory / "farm")
                self.take(["keygen", "farm"])
                if "--remove" in words:
                    self.take(["keygen", "farm", "--name", "ann"])
            if command != "doctor":  # doctor_test
                self.take(self.smaller(command, words))

    def test_examples_for_a_farm_do_what_they_say(self):
        with Farm() as farm:
            farm.start_worker("node7-4711")
            environment = {"PARRAY_COORDINATOR": farm.address}
            self.take(["submit", "scenes/glass.json", "--wait", *SMALL], environment)
            for command, words in self.examples(with_farm=True):
                if "tcp://farm:7400" in words or "frame-####" in " ".join(words) or "drain" in words:
                    continue  # another machine; two series; the only worker
                if command in ("pause", "resume", "requeue", "priority", "cancel", "forget"):
                    continue  # of a job that has ended: sharing_test steers others
                words = ["1" if word == "7" else word for word in words]
                self.take(self.smaller(command, words), environment)

    def test_what_the_pages_beside_the_code_show_is_understood(self):
        """Commands of their code blocks name options that there are."""
        known = {program: {command["name"]: set(names_of(command)) for command in commands_of(program)}
                 for program in PROGRAMS}
        seen = 0
        pages = ("README.md", "cli/REFERENCE.md", "coordinator/FARM.md", "scenes/README.md", "deploy/slurm/README.md",
                 "deploy/monitoring/README.md")
        for line in "\n".join((SOURCE / page).read_text() for page in pages).splitlines():
            for part in re.split(r"&&|[|&#]", line) if line.startswith("    ") else []:
                words = part.split()
                program = next((word for word in words if word in known), None)
                if program is None:
                    continue
                words = words[words.index(program):]
                name = " ".join(words[:2]) if " ".join(words[:2]) in known[program] else program
                for word in words:
                    if re.fullmatch(r"--[a-z-]+", word):
                        seen += 1
                        self.assertIn(word, known[program][name], line)
        self.assertGreater(seen, 50)


class Shell:
    """A shell at a terminal, in which the programs print their words, a line each."""

    def __init__(self, arguments, setup, directory, environment):
        self.process, self.terminal = pty.fork()
        if self.process == 0:
            os.chdir(directory)
            os.execvpe(arguments[0], arguments, {**os.environ, "TERM": "dumb", "PS1": "> ",
                                                 **environment})
        subprocess.run(["stty", "cols", "500"], stdin=self.terminal, check=False)
        self.ask(setup)

    def ask(self, text):
        """Types a line; what was printed until the mark."""
        mark = f"MARK{time.monotonic_ns()}"
        os.write(self.terminal, f"{text}\n".encode())
        os.write(self.terminal, f"echo {mark[:4]}''{mark[4:]}\n".encode())
        got = b""
        end = time.monotonic() + 60
        while mark.encode() not in got:
            if time.monotonic() > end:
                raise AssertionError(f"{text!r}: {got.decode(errors='replace')}")
            if select.select([self.terminal], [], [], 1)[0]:
                got += os.read(self.terminal, 65536)
        return got.decode(errors="replace")

    def close(self):
        os.kill(self.process, signal.SIGKILL)
        os.waitpid(self.process, 0)
        os.close(self.terminal)


class Completion(PagesTest):
    # What is typed, and the words that the program gets.
    TYPED = [
        ("parray rend\t", ["render"]),
        ("parray render sce\t", ["render", "scene one.json"]),
        ("parray render --prec\tmi\t", ["render", "--precision", "mixed"]),
        ("parray render 'scene one.json' -o pic\t", ["render", "scene one.json", "-o", "picture.exr"]),
        ("parray render --adaptive of\t", ["render", "--adaptive", "off"]),
        ("parray workers dra\t", ["workers", "drain"]),
        ("parray help trad\t", ["help", "tradeoff"]),
        ("parray keygen rel\t", ["keygen", "relics"]),
        ("parray show 11\t", ["show", "1177"]),
        ("parray-worker --idle\t 5 --sharing of\t", ["--idle-exit", "5", "--sharing", "off"]),
        ("parray-coordinator --log-l\tdeb\t", ["--log-level", "debug"]),
    ]

    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix="parray-shell-")
        self.addCleanup(temporary.cleanup)
        self.directory = pathlib.Path(temporary.name)
        (self.directory / "scene one.json").write_text("{}")
        (self.directory / "picture.exr").write_text("")
        (self.directory / "relics").mkdir()
        (self.directory / "relics.txt").write_text("")
        # Programs that print their words, and list a job for whoever completes one.
        self.bin = self.directory / ".bin"
        self.bin.mkdir()
        for program in PROGRAMS:
            script = self.bin / program
            script.write_text("#!/bin/sh\n[ \"$*\" = jobs ] && printf 'JOB STATE\\n1177 done\\n' && exit\n"
                              "for word; do printf '<%s>\\n' \"$word\"; done\n")
            script.chmod(0o755)

    def drive(self, arguments, setup):
        shell = Shell(arguments, setup, self.directory,
                      {"PATH": f"{self.bin}:{os.environ['PATH']}", "HOME": str(self.directory),
                       "LC_ALL": "C.UTF-8"})
        self.addCleanup(shell.close)
        for typed, words in self.TYPED:
            with self.subTest(typed=typed):
                printed = shell.ask(typed)
                got = re.findall(r"(?m)^<(.*)>\r?$", printed)
                # zsh puts = before a value, and takes away the / behind a directory.
                got = [part.rstrip("/") for word in got
                       for part in (word.split("=", 1) if word.startswith("--") else [word])]
                self.assertEqual(got, words, printed)

    def file(self, *parts):
        return self.share.joinpath(*parts)

    def test_bash_completes_commands_options_values_files_and_jobs(self):
        self.needs("bash")
        sources = "; ".join(f"source {self.file('bash-completion/completions', program)}"
                            for program in PROGRAMS)
        self.drive(["bash", "--norc", "--noprofile", "-i"], sources)

    def test_zsh_completes_them(self):
        self.needs("zsh")
        self.drive(["zsh", "-f", "-i"],
                   f"fpath=({self.file('zsh/site-functions')} $fpath); autoload -Uz compinit; "
                   "compinit -u -D; unsetopt list_beep auto_menu; unsetopt zle_bracketed_paste")

    def test_every_option_is_in_the_completion_of_every_shell(self):
        for program in PROGRAMS:
            texts = [self.file(place).read_text()
                     for place in (f"bash-completion/completions/{program}",
                                   f"zsh/site-functions/_{program}")]
            fish = self.file(f"fish/vendor_completions.d/{program}.fish").read_text()
            for command in commands_of(program):
                for name in names_of(command):
                    for text in texts:
                        self.assertIn(name, text)
                    self.assertIn((" -l " if name.startswith("--") else " -s ") + name.strip("-"), fish)
                for option in command["options"]:
                    for word in option["words"]:
                        for text in [*texts, fish]:
                            self.assertIn(word, text)

    def test_fish_completes_them(self):
        self.needs("fish")
        environment = {**os.environ, "PATH": f"{self.bin}:{os.environ['PATH']}",
                       "HOME": str(self.directory), "LC_ALL": "C.UTF-8"}
        for line, expected in (("parray rend", "render"), ("parray render sce", "scene one.json"),
                               ("parray render --prec", "--precision"),
                               ("parray render --precision mi", "mixed"),
                               ("parray workers dra", "drain"), ("parray keygen rel", "relics/"),
                               ("parray show 11", "1177"),
                               ("parray render --aov depth,nor", "depth,normal"),
                               ("parray-worker --sharing of", "off")):
            program = line.split()[0]
            script = (f"source {self.file('fish/vendor_completions.d', program + '.fish')}; "
                      f"complete -C {shlex.quote(line)}")
            result = subprocess.run(["fish", "--no-config", "-c", script], cwd=self.directory,
                                    capture_output=True, text=True, env=environment)
            offered = [candidate.split("\t")[0] for candidate in result.stdout.splitlines()]
            self.assertEqual(offered, [expected], (line, result.stderr))

    def test_bash_completes_lists_and_values_behind_an_equals_sign(self):
        self.needs("bash")
        script = (f"source {self.file('bash-completion/completions/parray')}; compopt() {{ :; }}; "
                  "_parray; printf '%s\\n' \"${COMPREPLY[@]}\"")
        for words, expected in ((["parray", "render", "--aov", "depth,nor"], "depth,normal"),
                                (["parray", "render", "--adaptive", "=", "of"], "off"),
                                (["parray", "render", "--adaptive", "="], "on\noff"),
                                (["parray", "render", "x", "--width", "5"], "")):
            setup = f"COMP_WORDS=({shlex.join(words)}); COMP_CWORD={len(words) - 1}; "
            result = subprocess.run(["bash", "--norc", "-c", setup + script], capture_output=True,
                                    text=True, cwd=self.directory)
            self.assertEqual(result.stdout.rstrip("\n"), expected, result.stderr)


if __name__ == "__main__":
    unittest.main()
