#!/usr/bin/env python3
"""parray plan: its commands run and reach about the predicted error, and what it refuses."""

import json
import pathlib
import shlex
import subprocess
import tempfile
import unittest

from farm import BIN, Farm, SCENES, run

SCENE = SCENES / "one-weekend-20.json"
SMALL = ["--width", 96, "--height", 64]


class PlanCase(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix="parray-plan-")
        self.addCleanup(temporary.cleanup)
        self.directory = pathlib.Path(temporary.name)
        self.image = self.directory / "it's a picture.exr"
        self.report = self.directory / "report.json"

    def plan(self, *options, scene=SCENE, probe=0.1):
        """`probe`: longer where numbers are compared with what comes of them."""
        done = run("plan", scene, *SMALL, "--probe-seconds", probe, "-o", self.image, "--json", *options)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def carry_out(self, choice):
        """Runs the line as a shell would; returns the report."""
        line = choice["command_line"].replace("parray", shlex.quote(str(BIN / "parray")), 1)
        done = subprocess.run(f"{line} --quiet --report {self.report}", shell=True, timeout=120,
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, f"{line}\n{done.stderr}")
        self.assertTrue(self.image.exists())
        return json.loads(self.report.read_text())

    def refused(self, words, *options, scene=SCENE):
        done = run("plan", scene, *SMALL, "--probe-seconds", 0.1, *options)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertEqual(len(done.stderr.strip().splitlines()), 1, done.stderr)
        for word in words:
            self.assertIn(word, done.stderr)


class Plan(PlanCase):
    def test_every_choice_for_an_error_runs_and_has_about_that_error(self):
        plan = self.plan("--error", 0.01, probe=0.3)
        self.assertEqual(plan["recommended"], plan["choices"][0])
        ways = {(choice["sampler"], choice["adaptive"]) for choice in plan["choices"]}
        self.assertEqual(ways, {(s, a) for s in ("independent", "sobol") for a in (False, True)})
        for choice in plan["choices"]:
            with self.subTest(choice=choice["command_line"]):
                report = self.carry_out(choice)
                self.assertEqual(report["sampler"], choice["sampler"])
                self.assertEqual(report["adaptive"], choice["adaptive"])
                ratio = report["error"]["rmse"] / choice["error"]["value"]
                self.assertTrue(0.6 < ratio < 1.6, ratio)
                self.assertLess(report["error"]["rmse"], 0.015)
                samples = report["samples"] / report["width"] / report["height"]
                ratio = samples / choice["samples_per_pixel"]["value"]
                self.assertTrue(0.5 < ratio < 2, ratio)

    def test_intervals_hold_their_values(self):
        for choice in self.plan("--error", 0.005)["choices"]:
            for key in ("samples_per_pixel", "error", "seconds"):
                of = choice[key]
                self.assertTrue(0 < of["low"] <= of["value"] <= of["high"], (key, of))

    def test_a_time_becomes_a_time_limit_which_counts_writing_too(self):
        choices = self.plan("--time", 20)["choices"]
        limited = next(choice for choice in choices if choice["adaptive"])
        limit = float(limited["command"][limited["command"].index("--time-limit") + 1])
        self.assertEqual(limit, 20)
        uniform = next(choice for choice in choices if not choice["adaptive"])
        self.assertIn("--spp", uniform["command"])
        errors = [choice["error"]["value"] for choice in choices]
        self.assertLess(max(errors), 0.01)

    def test_the_recommended_command_stops_at_the_goal_and_the_alternative_is_a_number_of_samples(self):
        for goal, option in ((["--error", 0.02], "--target-error"), (["--time", 20], "--time-limit")):
            plan = self.plan(*goal)
            self.assertIn(option, plan["recommended"]["command"])
            self.assertNotIn("--spp", plan["recommended"]["command"])
            self.assertIn("--spp", plan["alternative"]["command"])
            self.assertIn(plan["alternative"], plan["choices"])
        self.assertEqual(self.carry_out(self.plan("--error", 0.02)["recommended"])["stopped_by"], "error")
        text = run("plan", SCENE, *SMALL, "--probe-seconds", 0.1, "--error", 0.02).stdout
        self.assertRegex(text, r"\n  parray render .* --target-error 0.02\n(.*\n)*or, with a fixed number of samples .*:"
                               r"\n\n  parray render .* --spp \d+\n")

    def test_the_picture_of_a_scene_from_the_standard_input_has_a_name(self):
        done = subprocess.run([BIN / "parray", "plan", "-", *map(str, SMALL), "--error", "0.1", "--probe-seconds", "0.1"],
                              input=SCENE.read_text(), capture_output=True, text=True, timeout=60)
        self.assertIn("  parray render - -o picture.exr ", done.stdout, done.stderr)

    def test_options_of_the_picture_are_in_the_command(self):
        plan = self.plan("--error", 0.02, "--max-depth", 3, "--sampler", "sobol", "--threads", 1, "--transparent", "on")
        words = plan["recommended"]["command"]
        for option, value in (("--max-depth", "3"), ("--transparent", "on"), ("--sampler", "sobol"), ("--threads", "1"),
                              ("--width", "96")):
            self.assertEqual(words[words.index(option) + 1], value)
            self.assertEqual(words.count(option), 1)
        self.assertEqual({choice["sampler"] for choice in plan["choices"]}, {"sobol"})

    def test_options_of_particles_are_in_the_command_in_their_order(self):
        helix = SCENE.parent / "particles/helix.pdb"
        given = ["--style", "flat", "--show", "element C", "--color-by", "x", "--show", "element O", "--color-by", "y"]
        plan = self.plan("--error", 0.3, *given, scene=helix)
        words = plan["recommended"]["command"]
        first = words.index("--style")
        self.assertEqual(words[first:first + len(given)], given)
        self.carry_out(plan["recommended"])

    def test_the_recommended_command_keeps_the_goal_with_the_required_probability(self):
        for goal in (["--error", 0.01], ["--time", 20]):
            for confidence in (0.5, 0.95, 0.99):
                plan = self.plan(*goal, "--confidence", confidence)
                best = plan["recommended"]
                self.assertGreaterEqual(best["keeps_goal"], confidence - 1e-6)
                self.assertEqual(plan["goal"]["confidence"], confidence)
                cost = "seconds" if "--error" in goal else "error"
                for choice in plan["choices"]:
                    if choice["keeps_goal"] >= confidence and "--spp" not in choice["command"]:
                        self.assertLessEqual(best[cost]["value"], choice[cost]["value"])
        done = run("plan", SCENE, *SMALL, "--probe-seconds", 0.1, "--error", 0.02)
        self.assertRegex(done.stdout, r"probability +9[5-9][.0-9]* % that the error is at most 0.02\n")

    def test_impossible_workers_and_confidences_are_refused(self):
        self.refused(["--speeds", "2 speeds for 3 workers"], "--error", 0.1, "--workers", 3,
                     "--speeds", "1,2")
        for speeds in ("", "1,", "0", "-1", "fast", "1;2"):
            self.refused(["--speeds"], "--error", 0.1, "--speeds", speeds)
        self.refused(["--workers"], "--error", 0.1, "--workers", 0)
        for confidence in (0, 0.3, 1, 95):
            self.refused(["--confidence"], "--error", 0.1, "--confidence", confidence)

    def test_text_has_the_command_and_a_table(self):
        done = run("plan", SCENE, *SMALL, "--probe-seconds", 0.1, "--error", 0.02)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(f"  parray render {shlex.quote(str(SCENE))} -o one-weekend-20.exr", done.stdout)
        self.assertEqual(done.stdout.count("uniform"), 2)
        self.assertEqual(done.stdout.count("adaptive"), 2)

    def test_a_scene_without_noise_needs_hardly_a_sample(self):
        best = self.plan("--error", 0.001, scene=SCENES / "furnace.json")["recommended"]
        self.assertLess(best["samples_per_pixel"]["value"], 33)
        self.assertLess(best["error"]["value"], 1e-6)

    def test_a_scene_without_light_needs_hardly_a_sample(self):
        with tempfile.TemporaryDirectory() as folder:
            dark = pathlib.Path(folder) / "dark.json"
            sky = {"horizon": [0, 0, 0], "zenith": [0, 0, 0]}
            dark.write_text(json.dumps({**json.loads((SCENES / "furnace.json").read_text()), "sky": sky}))
            best = self.plan("--error", 0.001, scene=dark)["recommended"]
        self.assertLess(best["samples_per_pixel"]["value"], 33)
        self.assertLess(best["error"]["value"], 1e-6)

    def test_an_error_beyond_single_precision_is_refused(self):
        self.refused(["--error 1e-09", "32-bit numbers", "or more"], "--error", 1e-9)

    def test_an_error_that_takes_too_many_samples_is_refused(self):
        self.refused(["--error 1e-06", "16777216 samples per pixel", "or more"], "--error", 1e-6)

    def test_a_time_too_short_for_anything_is_refused(self):
        # However fast the machine, so many pixels take longer.
        self.refused(["--time 0.01", "use a longer time"], "--time", 0.01, "--width", 3000,
                     "--height", 2000)

    def test_no_goal_or_two_goals_are_refused(self):
        self.refused(["--error or --time"])
        self.refused(["--error or --time"], "--error", 0.1, "--time", 3)
        self.refused(["--error"], "--error", -1)
        self.refused(["--probe-seconds"], "--error", 0.1, "--probe-seconds", 0)

    def test_a_file_that_cannot_be_written_is_refused_before_the_probe(self):
        self.refused([".bmp"], "--error", 0.1, "-o", "picture.bmp")
        self.refused(["parray: a.jp2: JPEG 2000 needs"], "--error", 0.1, "-o", "a.jp2", "--width", 20)


class Times(PlanCase):
    """These compare times, which other tests would change: ctest runs nothing beside them."""

    def test_a_cheap_picture_has_a_short_probe_and_the_plan_says_that_rendering_is_cheaper(self):
        done = run("plan", SCENE, *SMALL, "--error", 0.02, "--json")
        plan = json.loads(done.stdout)
        self.assertLess(plan["probe"]["samples"], self.plan("--error", 0.0005, probe=3)["probe"]["samples"])
        cheaper = plan["recommended"]["seconds"]["value"] < plan["probe"]["seconds"]
        self.assertEqual(plan["rendering_is_cheaper"], cheaper)
        tiny = run("plan", SCENE, "--width", 16, "--height", 16, "--error", 0.1, "--probe-seconds", 3)
        self.assertTrue(tiny.stdout.endswith("rendering takes less time than this plan took\n"), tiny.stdout)

    def test_plan_prints_a_command_for_a_farm_that_submit_accepts(self):
        alone = self.plan("--error", 0.001, "--sampler", "sobol", "--threads", 1, probe=0.3)
        farm = self.plan("--error", 0.001, "--sampler", "sobol", "--threads", 1, "--speeds", "1,2,0.5", probe=0.3)
        self.assertEqual((alone["workers"], farm["workers"]), ([], [1, 2, 0.5]))
        self.assertEqual(self.plan("--error", 0.1, "--workers", 3)["workers"], [1, 1, 1])
        # Two probes differ; that one is 3.5 times as fast shows all the same.
        self.assertLess(farm["recommended"]["seconds"]["value"],
                        0.9 * alone["recommended"]["seconds"]["value"])
        words = farm["recommended"]["command"]
        self.assertEqual(words[:2] + [words[3]], ["parray", "submit", "--wait"])
        self.assertNotIn("--threads", words)
        with Farm() as real:
            real.start_worker("one")
            done = real.client(*words[1:], "-q")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertTrue(self.image.exists())


if __name__ == "__main__":
    unittest.main()
