#!/usr/bin/env python3
"""A state directory that becomes read-only while the coordinator serves, and writable again."""

import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

import hosts

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "integration"))
from farm import SCENES, Farm, run, wait_for  # noqa: E402
from longer_jobs import JobOverTooEarly, LongerJobs, again_with_longer_jobs  # noqa: E402

SETTINGS = ("--width", "160", "--height", "100", "--spp", "64")


def mount(*arguments):
    subprocess.run(["mount", *map(str, arguments)], check=True, capture_output=True)


class ReadOnlyState(LongerJobs, unittest.TestCase):
    def setUp(self):
        if not hosts.permitted():
            self.skipTest("mount namespaces are not permitted")
        hosts.ip("link", "set", "lo", "up")  # of the network namespace that hosts.enter() made
        directory = tempfile.TemporaryDirectory()
        self.addCleanup(directory.cleanup)
        self.state = pathlib.Path(directory.name) / "state"
        self.state.mkdir()

    def make_longer(self):
        self.make_writable()
        super().make_longer()

    def make_read_only(self):
        """Covers the directory by a read-only view of itself, as if its file system were remounted."""
        mount("--bind", self.state, self.state)
        self.addCleanup(subprocess.run, ["umount", self.state], capture_output=True)
        mount("-o", "remount,bind,ro", self.state)

    def make_writable(self):
        """A process that has just looked at the directory may keep it busy for a moment."""
        wait_for(lambda: subprocess.run(["umount", self.state], capture_output=True).returncode == 0, "the unmounting")

    def until_held(self, farm, job):
        """Until the job waits for its state."""
        def waits():
            shown = farm.job(job)
            if shown["state"] == "done":
                raise JobOverTooEarly("the worker was faster than the test")
            return "ead-only" in shown["waits_for"]

        wait_for(waits, "the reason in show")

    @again_with_longer_jobs
    def test_jobs_wait_with_the_reason_and_continue_when_the_state_is_writable_again(self):
        long = ("--width", "160", "--height", "100", "--spp", 700 * self.longer)
        with Farm("--state", self.state) as farm:
            before = farm.submit(SCENES / "glass.json", *SETTINGS)
            farm.start_worker("w1")
            farm.finish(before)
            held = farm.submit(SCENES / "shells.json", *long)
            wait_for(lambda: farm.job(held)["progress"] > 0.05, "some progress")
            self.make_read_only()
            self.until_held(farm, held)
            wait_for(lambda: "ead-only" in farm.coordinator_log(), "the reason in the log")
            self.assertEqual(farm.fetch(before)["samples"], 64 * 160 * 100)  # what is kept can still be read
            refused = farm.client("submit", SCENES / "glass.json", *SETTINGS)
            self.assertEqual((refused.returncode, refused.stderr.count("\n")), (1, 1))
            self.assertIn("make the directory writable again", refused.stderr)
            self.make_writable()
            report = farm.finish(held)
            run("render", SCENES / "shells.json", *long, "-o", farm.directory / "r.png", "--report",
                farm.directory / "r.json")
            rendered = json.loads((farm.directory / "r.json").read_text())
            self.assertEqual(report["image_sha256"], rendered["image_sha256"])
            self.assertEqual(farm.client("audit", 2).returncode, 0)


if __name__ == "__main__":
    hosts.enter()
    unittest.main()
