#!/usr/bin/env python3
"""--denoise on the command line: what it changes and keeps, and that its stated error is true."""

import json
import math
import unittest

from cli_usage_test import CliTest
from exr import read_exr
from farm import SOURCE, Farm, child_processor_seconds, run
from mpi import MpiRun, why_not

RGB = ("R", "G", "B")


class Denoise(CliTest):
    def picture(self, *options, name="a.exr"):
        report, _ = self.rendered(*options, name=name)
        return report, read_exr(self.path(name))[0]

    @staticmethod
    def distance(values, truth):
        squares = sum((a - b) ** 2 for c in RGB for a, b in zip(values[c], truth[c]))
        return math.sqrt(squares / 3 / len(truth["R"]))

    def test_it_lowers_the_error_states_the_remaining_error_and_keeps_the_raw_picture(self):
        plain, raw = self.picture("--spp", "16")
        report, values = self.picture("--spp", "16", "--denoise")
        self.assertEqual(report["image_sha256"], plain["image_sha256"])
        self.assertEqual(report["error"], plain["error"])
        self.assertEqual([values[f"raw.{c}"] for c in RGB], [raw[c] for c in RGB])
        self.assertGreater(report["seconds"]["denoise"], 0)
        _, truth = self.picture("--spp", "4000", "--seed", "99", name="truth.exr")
        real = self.distance(values, truth)
        self.assertLess(real, 0.8 * self.distance(raw, truth))
        stated = report["denoised"]
        # Both hold 95 % of the time; the factor is for the rest.
        self.assertGreater(real, 0.8 * stated["low"])
        self.assertLess(real, 1.2 * stated["high"])

    def test_its_bits_do_not_depend_on_how_the_work_is_done(self):
        expected = self.picture("--spp", "6", "--denoise")[0]["denoised"]
        for options in (["--threads", "1"], ["--threads", "3"], ["--isa", "scalar"],
                        ["--isa", "avx2"], ["--accelerator", "octree"]):
            with self.subTest(options=options):
                report, _ = self.picture("--spp", "6", "--denoise", *options)
                self.assertEqual(report["denoised"], expected)

    def test_a_farm_and_parray_mpi_make_the_same_picture(self):
        expected = self.picture("--denoise")[0]["denoised"]
        with Farm() as farm:
            farm.start_worker("one")
            result = farm.client("submit", self.scene, "--wait", "-q", "-o", self.path("b.exr"),
                                 "--report", self.path("b.json"), "--denoise")
            self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(json.loads(self.path("b.json").read_text())["denoised"], expected)
        if why_not():
            self.skipTest(why_not())
        with MpiRun(2, self.scene, "--threads", "1", "--denoise") as job:
            self.assertEqual(job.finish()["denoised"], expected)

    def test_a_target_counts_the_denoised_picture(self):
        report, _ = self.picture("--spp", "100000", "--denoise", "--target-error", "0.02")
        self.assertEqual(report["stopped_by"], "error")
        self.assertTrue(report["target_denoised"])
        self.assertLessEqual(report["denoised"]["high"], 0.02)
        self.assertGreater(report["error"]["high"], 0.02)
        expected = report["denoised"]
        again, _ = self.picture("--denoise", "--passes", ",".join(map(str, report["passes"])))
        self.assertEqual(again["denoised"], expected)

    def test_a_target_of_the_denoised_picture_may_have_a_time_limit(self):
        options = ["--spp", "100000", "--denoise", "--target-error"]
        within, _ = self.rendered(*options, "0.02", "--time-limit", "60")
        self.assertEqual(within["stopped_by"], "error")
        self.assertLessEqual(within["denoised"]["high"], 0.02)
        for limit in ("1", "4", "16"):  # on a slow machine, denoising does not fit into a short one
            result = run("render", self.scene, "-q", "-o", self.path("a.png"), "--report", self.path("report.json"), *options,
                         "0.00001", "--time-limit", limit)
            if "left out" not in result.stderr:
                break
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        beyond = json.loads(self.path("report.json").read_text())
        self.assertEqual(beyond["stopped_by"], "time")
        self.assertGreater(beyond["denoised"]["high"], 0.00001)

    def test_denoising_that_does_not_fit_into_a_time_limit_is_left_out_and_said(self):
        large = ["--width", "3000", "--height", "2000", "--time-limit", "0.1", "-q", "--report", self.path("a.json")]
        result = run("render", self.scene, "-o", self.path("a.png"), "--denoise", *large)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertRegex(result.stderr, r"parray: --time-limit 0\.1: denoising takes about [^\n]*, which is too long: left out\n")
        self.assertNotIn("denoised", json.loads(self.path("a.json").read_text()))

    def test_submit_with_wait_also_leaves_out_steps_that_do_not_fit(self):
        large = ["--width", "3000", "--height", "2000", "--time-limit", "0.1", "-q", "--report", self.path("a.json")]
        with Farm() as farm:
            farm.start_worker("one")
            result = run("submit", self.scene, "--wait", "-o", self.path("a.png"), "--denoise", *large, "--coordinator",
                         farm.address)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("denoising takes about", result.stderr)
        self.assertNotIn("denoised", json.loads(self.path("a.json").read_text()))

    def test_predicting_whether_denoising_pays_keeps_a_time_limit_with_slow_samples(self):
        white = {"type": "diffuse", "albedo": [0.999] * 3}
        scene = {"version": 1, "camera": {"look_from": [0, 0, 0], "look_at": [0, 0, -1], "vfov": 60},
                 "render": {"max_depth": 300}, "sky": {"horizon": [1, 1, 1], "zenith": [1, 1, 1]},
                 "materials": {"white": white}, "spheres": [{"center": [0, 0, 0], "radius": 10, "material": "white"}]}
        self.path("slow.json").write_text(json.dumps(scene))
        seconds = []
        for quiet in ["-q"], []:  # -q predicts nothing
            before = child_processor_seconds()
            result = run("render", self.path("slow.json"), "-o", self.path("slow.png"), "--width", "600", "--height", "400",
                         "--threads", "1", "--denoise", "--time-limit", "0.5", *quiet)
            self.assertEqual(result.returncode, 0, result.stderr)
            seconds.append(child_processor_seconds() - before)
        self.assertLess(seconds[1], 3 * seconds[0])  # about ten times without a bound

    def test_extra_channels_that_do_not_fit_into_a_time_limit_are_left_out_and_said(self):
        large = ["--width", "3000", "--height", "2000", "--time-limit", "0.1", "-q", "--report", self.path("a.json")]
        result = run("render", self.scene, "-o", self.path("a.exr"), "--aov", "depth,normal", *large)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("tracing extra channels takes about", result.stderr)
        self.assertNotIn("aovs", json.loads(self.path("a.json").read_text()))

    def test_a_target_of_the_denoised_picture_is_refused_where_its_error_is_unknown(self):
        options = ["--denoise", "--target-error", "0.02", "-o", self.path("a.exr")]
        for command in (["submit", self.scene, "--wait"],
                        ["render", self.scene, "--target-half-width", "0.05"]):
            with self.subTest(command=command):
                result = run(*command, *options)
                self.assertEqual(result.returncode, 2)
                self.assertIn("--target-error with --denoise", result.stderr)
                self.assertEqual(result.stderr.count("\n"), 1)

    def test_verify_checks_the_raw_and_the_denoised_picture(self):
        self.picture("--denoise")
        result = run("verify", self.path("a.exr"), self.scene)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("the picture before denoising", result.stdout)
        result = run("render", self.scene, "-q", "-o", self.path("a.png"), "--denoise")
        self.assertEqual(result.returncode, 0, result.stderr)
        result = run("verify", self.path("a.png"), self.scene)
        self.assertEqual(result.returncode, 2)
        self.assertIn("verify the EXR picture", result.stderr)

    def test_a_picture_with_one_sample_per_pixel_is_not_denoised_and_says_so(self):
        plain, _ = self.picture("--spp", "1")
        result = run("render", self.scene, "-q", "-o", self.path("b.exr"), "--spp", "1",
                     "--denoise", "--report", self.path("b.json"))
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("fewer than 2 samples", result.stderr)
        report = json.loads(self.path("b.json").read_text())
        self.assertNotIn("denoised", report)
        self.assertEqual(report["image_sha256"], plain["image_sha256"])

    def test_the_interval_counts_light_that_no_sample_has_shown(self):
        picture = run("render", SOURCE / "scenes/particles/helix.pdb", "-q", "--denoise", "--width", 1, "--height", 1,
                      "--spp", 8, "--seed", 1, "-o", self.path("one.exr"), "--report", self.path("one.json"))
        self.assertEqual(picture.returncode, 0, picture.stderr)
        report = json.loads(self.path("one.json").read_text())
        self.assertEqual(report["error"]["rmse"], 0)  # all samples are alike
        self.assertAlmostEqual(report["denoised"]["high"], report["error"]["high"], places=6)

    def test_it_is_refused_for_a_series(self):
        self.refused("submit", self.scene, "--wait", "--denoise", "--frames", "1-2", "-o",
                     self.path("a-##.exr"), mentions="--denoise")


class Forecasts(CliTest):
    """These measure times, which other tests would change: ctest runs nothing beside them."""

    def test_a_line_says_where_denoising_is_not_expected_to_pay(self):
        """The scenes are far from where denoising begins to pay."""
        scenes = SOURCE / "scenes" / "regression"
        options = ["-o", self.path("a.png"), "--width", "300", "--height", "200", "--threads", "1", "--denoise"]
        few = [scenes / "ball-lens.json", "--spp", "4", *options]
        result = run("render", *few)
        self.assertRegex(result.stderr, r"parray: --denoise is not expected to pay: 4 samples per pixel, denoised, have an "
                                        r"error of about 0\.0\d+; in the same time \d+ samples without --denoise have 0\.0\d+\n")
        self.assertEqual(result.returncode, 0, result.stderr)
        slow = [scenes / "coated-ball.json", "--spp", "8", "--isa", "scalar", *options]
        for arguments in slow, [*few, "-q"]:
            with self.subTest(arguments=arguments):
                self.assertNotIn("expected to pay", run("render", *arguments).stderr)


if __name__ == "__main__":
    unittest.main()
