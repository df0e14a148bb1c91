#!/usr/bin/env python3
"""Pictures with less than one sample per pixel, as after a short time limit: their passes repeat the same bits, verify
accepts them, filled pixels differ from traced ones, and a line always says what is missing."""

import json
import pathlib
import tempfile
import unittest

import exr
from farm import SCENES, Farm, run

SCENE = SCENES / "one-weekend-20.json"
SIZE = ["--width", "300", "--height", "200"]
PASSES = "3750,7500,18750"  # of 300 x 200: every 4th pixel both ways, every 2nd, every other one


class FilledPictures(unittest.TestCase):
    def setUp(self):
        directory = tempfile.TemporaryDirectory()
        self.addCleanup(directory.cleanup)
        self.directory = pathlib.Path(directory.name)

    def render(self, name, *options):
        picture = self.directory / name
        report = self.directory / "report.json"
        done = run("render", SCENE, *options, "-o", picture, "--report", report, "-q")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.said = done.stdout
        return json.loads(report.read_text()), picture

    def test_it_is_the_same_for_any_portions_threads_schedule_and_on_a_farm(self):
        first, _ = self.render("a.png", *SIZE, "--passes", PASSES)
        self.assertEqual(first["samples"], 30_000)
        self.assertEqual(first["filled_pixels"], 60_000 - 30_000)
        self.assertEqual(first["fill_block"], 2)
        self.assertEqual(first["least_samples"], 0)
        self.assertIsNone(first["error"]["rmse"])
        for options in (["--passes", "30000"], ["--passes", PASSES, "--threads", "3"],
                        ["--passes", "3750,26250", "--schedule", "guided", "--isa", "scalar"],
                        ["--passes", PASSES, "--adaptive", "off", "--row-order", "sequential"]):
            again, _ = self.render("b.png", *SIZE, *options)
            self.assertEqual(again["image_sha256"], first["image_sha256"], options)
        with Farm() as farm:
            farm.start_worker("a")
            farm.start_worker("b")
            job = farm.submit(SCENE, *SIZE, "--passes", PASSES)
            self.assertEqual(farm.finish(job)["image_sha256"], first["image_sha256"])

    def test_its_file_tells_filled_pixels_apart_and_its_recipe_repeats_it(self):
        report, picture = self.render("a.exr", *SIZE, "--passes", PASSES)
        self.assertIn("50 % of them traced, the others filled in blocks of up to 2 x 2, error not "
                      "known", self.said)
        channels, _ = exr.read_exr(picture)
        samples = channels["samples"]
        self.assertEqual(sorted(set(samples)), [0, 1])
        self.assertEqual(sum(samples), report["samples"])
        for y in range(0, 200):
            for x in range(0, 300):
                if samples[y * 300 + x] == 0:
                    corner = y // 2 * 2 * 300 + x // 2 * 2
                    if samples[corner] == 1:
                        for name in "RGB":
                            self.assertEqual(channels[name][y * 300 + x], channels[name][corner])
        again, _ = self.render("b.png", "--like", picture)
        self.assertEqual(again["image_sha256"], report["image_sha256"])
        self.assertEqual(again["filled_pixels"], report["filled_pixels"])

    def test_verify_traces_what_fills_a_pixel_and_refuses_a_png_of_it(self):
        _, picture = self.render("a.exr", *SIZE, "--passes", PASSES)
        done = run("verify", picture, SCENE, "--all")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("all 60000 pixels traced again with the same bits", done.stdout)
        _, png = self.render("a.png", *SIZE, "--passes", PASSES)
        self.assertEqual(run("verify", png).returncode, 0)
        refused = run("verify", png, SCENE)
        self.assertEqual(refused.returncode, 2)
        self.assertIn("a file of 8 bits does not contain the numbers", refused.stderr)

    def test_however_short_the_limit_there_is_a_picture_that_says_what_it_is(self):
        report, picture = self.render("a.exr", "--width", "1000", "--height", "800",
                                      "--time-limit", "0.01")
        self.assertEqual(report["stopped_by"], "time")
        self.assertGreater(report["filled_pixels"], 0)
        done = run("verify", picture, SCENE)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        again, _ = self.render("b.png", "--like", picture)
        self.assertEqual(again["image_sha256"], report["image_sha256"])


if __name__ == "__main__":
    unittest.main()
