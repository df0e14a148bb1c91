#!/usr/bin/env python3
"""A rank of a real mpirun that returns wrong bits: rank 0 finds and names it, and the picture has the bits of `parray
render`. The program parray-mpi-liar (tests/integration/lying_mpi.cpp) is the faulty rank."""

import json
import pathlib
import socket
import tempfile
import unittest

from farm import BIN, SCENES, Farm, run
from mpi import MpiRun, why_not

SCENE = SCENES / "one-weekend-484.json"
# lying_mpi.cpp counts its cells: 100 samples of each pixel, in the first pass.
EVEN = ("--width", 100, "--height", 75, "--spp", 100)
IN_PASSES = ("--width", 100, "--height", 75, "--spp", 300, "--adaptive", "on", "--passes", "750000,300000")
HOST = socket.gethostname()


def why_no_liar():
    return why_not() or ("" if (BIN / "parray-mpi-liar").exists() else "parray-mpi-liar is not built")


def expected_report(*options):
    with tempfile.TemporaryDirectory() as directory:
        result = run("render", SCENE, "-o", f"{directory}/a.png", "--report", f"{directory}/a.json", *options)
        assert result.returncode == 0, result.stderr
        return json.loads(pathlib.Path(directory, "a.json").read_text())


@unittest.skipIf(why_no_liar(), why_no_liar())
class Liars(unittest.TestCase):
    def render(self, *options):
        """The report and the words of three ranks, of which rank 1 lies in all that it traces."""
        with tempfile.TemporaryDirectory() as folder:
            with MpiRun(3, SCENE, *options, "--schedule", "static", "--threads", 1, program="parray-mpi-liar",
                        env={"PARRAY_LIARS": folder}) as job:
                return job.finish(), job.lines()

    def check(self, report, lines, options, what_follows):
        expected = expected_report(*options)
        for field in ("image_sha256", "samples", "rays"):
            self.assertEqual(report[field], expected[field], field)
        self.assertGreater(report["mpi"]["mismatched_cells"], 0)
        [faulty] = report["mpi"]["faulty_ranks"]
        self.assertEqual((faulty["rank"], faulty["host"], faulty["left_out"]), (1, HOST, [1]))
        named = f"rank 1 on {HOST} returned wrong bits: "
        self.assertRegex(report["flag"], f"^{named}{what_follows}$")
        said = [line for line in lines if "wrong bits" in line]
        self.assertEqual(said, [f"parray-mpi: {named}rank 0 got different ones for the same samples. ParRay traces "
                                "its cells again without it. Test that machine's memory"])

    def test_a_rank_that_returns_wrong_bits_is_named_and_the_picture_is_right(self):
        for mode in ("window", "messages"):
            with self.subTest(mode=mode):
                report, lines = self.render(*EVEN, "--mode", mode)
                self.check(report, lines, EVEN, "[1-9][0-9]* cells were traced again")

    def test_a_picture_in_passes_is_begun_again_without_the_rank(self):
        report, lines = self.render(*IN_PASSES)
        self.check(report, lines, IN_PASSES, "the picture was begun again")
        self.assertTrue(report["mpi"]["faulty_ranks"][0]["restarted"])

    def test_without_lies_no_rank_is_named(self):
        with MpiRun(3, SCENE, *EVEN, program="parray-mpi-liar") as job:
            report = job.finish()
            self.assertEqual(report["mpi"]["faulty_ranks"], [])
            self.assertEqual(report["flag"], "")
            self.assertNotIn("wrong bits", job.text())

    def test_what_was_kept_of_a_job_with_a_faulty_rank_is_a_right_picture(self):
        with tempfile.TemporaryDirectory() as folder:
            state = pathlib.Path(folder, "state")
            report, lines = self.render(*EVEN, "--state", state, "--checkpoint", 1)
            self.check(report, lines, EVEN, "[1-9][0-9]* cells were traced again")
            with Farm("--state", state) as farm:
                self.assertEqual(farm.fetch(1)["image_sha256"], report["image_sha256"])


if __name__ == "__main__":
    unittest.main(verbosity=2)
