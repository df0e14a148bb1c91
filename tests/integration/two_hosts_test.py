#!/usr/bin/env python3
"""Ranks on two hosts (network namespaces) render the picture that one process renders."""

import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
os.environ["ASAN_OPTIONS"] = "detect_leaks=0"  # as in mpi.py
BIN = pathlib.Path(os.environ["PARRAY_BIN_DIR"])
SCENE = pathlib.Path(os.environ["PARRAY_SOURCE_DIR"]) / "scenes" / "one-weekend-484.json"
SETTINGS = ["--width", "120", "--height", "80", "--spp", "64", "--quiet"]
SKIPPED = 77


def report_of(command, folder):
    """The report that a rendering command writes, and what it says on stderr."""
    report = pathlib.Path(folder) / "report.json"
    done = subprocess.run(
        [*command, SCENE, *SETTINGS, "-o", pathlib.Path(folder) / "picture.png", "--report", report],
        capture_output=True, text=True, timeout=120, check=False)
    if done.returncode == SKIPPED:
        raise unittest.SkipTest(done.stderr.strip() or "two_hosts")
    if done.returncode != 0:
        raise AssertionError(f"{command}: status {done.returncode}\n{done.stderr}")
    return json.loads(report.read_text()), done.stderr


class TwoHosts(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        # mpirun cannot start a remote shell whose path has blanks.
        self.two_hosts = shutil.copy(HERE / "two_hosts", self.folder)
        self.expected, _ = report_of([BIN / "parray", "render"], self.folder)

    def render(self, ranks, mode):
        return report_of([self.two_hosts, "-n", str(ranks), BIN / "parray-mpi",
                          "--mode", mode, "--threads", "1"], self.folder)

    def test_a_window_reaches_the_other_host_without_any_option_of_the_users(self):
        for ranks in (2, 3):
            report, _ = self.render(ranks, "window")
            self.assertEqual(report["mpi"]["transport"], "window")
            self.assertEqual({rank["host"] for rank in report["mpi"]["ranks"]}, {"left", "right"})
            self.assertEqual(report["image_sha256"], self.expected["image_sha256"])

    def test_messages_reach_the_other_host(self):
        report, _ = self.render(2, "messages")
        self.assertEqual(report["mpi"]["transport"], "messages")
        self.assertEqual(report["image_sha256"], self.expected["image_sha256"])

    def test_where_the_window_is_switched_off_messages_take_its_place(self):
        os.environ["OMPI_MCA_osc"] = "^ucx,pt2pt"  # Debian's default, here as the user's wish
        self.addCleanup(os.environ.pop, "OMPI_MCA_osc")
        report, said = self.render(2, "window")
        self.assertEqual(report["mpi"]["transport"], "messages")
        self.assertIn("ranks send messages instead", said)
        self.assertEqual(report["image_sha256"], self.expected["image_sha256"])


if __name__ == "__main__":
    unittest.main()
