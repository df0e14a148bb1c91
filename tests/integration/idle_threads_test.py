#!/usr/bin/env python3
"""Threads without work sleep instead of spinning, unless the user asks OpenMP for something else."""

import os
import subprocess
import unittest

from farm import BIN


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


if __name__ == "__main__":
    unittest.main()
