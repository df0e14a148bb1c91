#!/usr/bin/env python3
"""Threads without work sleep instead of spinning, unless the user asks OpenMP for something else."""

import os
import pathlib
import subprocess
import tempfile
import unittest

from farm import BIN, SCENES, run


def version_text(program, **env):
    done = subprocess.run([BIN / program, "--version"], env={**os.environ, "OMP_DISPLAY_ENV": "true", **env}, check=True,
                          capture_output=True, text=True)
    return done.stderr



@unittest.skipUnless("OMP_WAIT_POLICY" in version_text("parray"),
                     "this OpenMP runtime does not show its settings at the start")
class IdleThreads(unittest.TestCase):
    def policy(self, program, **env):
        lines = version_text(program, **env).splitlines()
        line, = (line for line in lines if "OMP_WAIT_POLICY" in line)
        return line.split("'")[1]

    def test_idle_threads_of_each_program_sleep(self):
        for program in ("parray", "parray-worker", "parray-mpi"):
            if (BIN / program).exists():
                with self.subTest(program=program):
                    self.assertEqual(self.policy(program), "PASSIVE")

    def test_a_policy_of_the_user_is_kept(self):
        self.assertEqual(self.policy("parray", OMP_WAIT_POLICY="active"), "ACTIVE")


class Commands(unittest.TestCase):
    @unittest.skipIf("OMP_WAIT_POLICY" in os.environ, "the caller has set a policy")
    def test_a_command_of_the_user_inherits_no_policy_but_that_of_the_user(self):
        for given, told in (({}, "none"), ({"OMP_WAIT_POLICY": "active"}, "active")):
            with self.subTest(told=told), tempfile.TemporaryDirectory() as directory:
                file = pathlib.Path(directory, "told")
                done = run("render", SCENES / "one-weekend-20.json", "--width", 6, "--height", 4, "--spp", 1,
                           "-o", pathlib.Path(directory, "a.png"),
                           "--on-end", f'echo "${{OMP_WAIT_POLICY-none}}" > {file}', env=given)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertEqual(file.read_text().strip(), told)


if __name__ == "__main__":
    unittest.main()
