#!/usr/bin/env python3
"""parray tradeoff: what it measures, that it continues after an interruption, and what it refuses."""

import csv
import json
import math
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

from farm import BIN, run
from longer_jobs import JobOverTooEarly, LongerJobs, again_with_longer_jobs

SCENE = {
    "version": 1,
    "camera": {"look_from": [0, 1, 6], "look_at": [0, 0.8, 0], "up": [0, 1, 0], "vfov": 40, "aperture": 0.1,
               "focus_distance": 6},
    "image": {"width": 64, "height": 48},
    "render": {"samples_per_pixel": 64, "max_depth": 16, "seed": 3},
    "materials": {"grey": {"type": "diffuse", "albedo": [0.6, 0.5, 0.4]},
                  "glass": {"type": "dielectric", "ior": 1.5},
                  "mirror": {"type": "metal", "albedo": [0.9, 0.9, 0.9], "fuzz": 0.1}},
    "spheres": [{"center": [0, -100, 0], "radius": 100, "material": "grey"},
                {"center": [-1.2, 0.8, 0], "radius": 0.8, "material": "grey"},
                {"center": [0.5, 0.8, 0.5], "radius": 0.8, "material": "glass"},
                {"center": [1.6, 0.6, -1], "radius": 0.6, "material": "mirror"}]}


class TradeoffCase(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix="parray-tradeoff-")
        self.addCleanup(temporary.cleanup)
        self.directory = pathlib.Path(temporary.name)
        self.scene = self.directory / "scene.json"
        self.scene.write_text(json.dumps(SCENE))
        self.output = self.directory / "trade"

    def trade(self, *options, scene=None):
        """Runs a short measurement without gnuplot, for tests that do not use the results."""
        result = run("tradeoff", scene or self.scene, "-o", self.output, "--time-budget", 1, "--quiet", *options,
                     env={"PATH": str(self.directory)})
        self.assertEqual(result.returncode, 0, result.stderr)
        return result

    def document(self):
        return json.loads((self.output / "tradeoff.json").read_text())

    def refused(self, *options, mentions, status=2):
        result = run("tradeoff", *options)
        self.assertEqual((result.returncode, result.stdout), (status, ""), result.stderr)
        self.assertRegex(result.stderr, r"\Aparray: [^\n]*\n\Z")
        for part in mentions:
            self.assertIn(str(part), result.stderr)


class Measured(TradeoffCase):
    """One longer run, whose results all tests read."""

    @classmethod
    def setUpClass(cls):
        kept = tempfile.TemporaryDirectory(prefix="parray-tradeoff-")
        cls.addClassCleanup(kept.cleanup)
        cls.kept = pathlib.Path(kept.name) / "trade"
        scene = cls.kept.with_name("scene.json")
        scene.write_text(json.dumps(SCENE))
        cls.result = run("tradeoff", scene, "-o", cls.kept, "--time-budget", 5, "--quiet", "--json", "--error", 0.02,
                         "--also", "--sampler sobol --spp 24 --denoise")
        assert cls.result.returncode == 0, cls.result.stderr

    def setUp(self):
        super().setUp()
        self.output = self.kept

    def test_tables_plots_budget_and_the_sentence(self):
        document = json.loads(self.result.stdout)
        self.assertEqual(document, self.document())
        rows = document["rows"]
        with open(self.output / "tradeoff.csv", newline="") as file:
            table = list(csv.DictReader(file))
        self.assertEqual([row["options"] for row in rows], [row["options"] for row in table])
        self.assertEqual({row["sampler"] for row in rows}, {"independent", "sobol"})
        for knob in ("scene", "spp", "target", "denoise", "depth", "precision"):
            self.assertTrue(any(row["knob"] == knob for row in rows), knob)
        for row in rows:
            parts = [row[part] for part in ("eps_mc", "eps_depth", "eps_precision")]
            self.assertAlmostEqual(row["predicted_rmse"], math.sqrt(sum(p * p for p in parts)))
            # Of parts that are measured by themselves. The scatter of few runs of few pixels apart,
            # they make up the whole; of a filter's few pictures the stated error scatters more.
            delta = 0.4 if row["denoised"] else 0.15
            self.assertAlmostEqual(row["predicted_to_rmse"], 1, delta=delta, msg=row["options"])
            self.assertAlmostEqual(row["predicted_to_rmse_8bit"], 1, delta=delta, msg=row["options"])
            self.assertEqual(row["on_front"], row["dominated_by"] == "", row["options"])
            faster = [other["options"] for other in rows
                      if other["seconds"] < row["seconds"] and other["rmse"] < row["rmse"]]
            self.assertTrue(faster == [] or not row["on_front"], row["options"])
        shallow = next(row for row in rows if row["max_depth"] == 2)
        self.assertGreater(shallow["eps_depth"], 5 * shallow["eps_mc"] / 10)
        self.assertLessEqual(abs(shallow["bias"]), shallow["depth_bound"] * 1.05)
        pooled = next(one for one in document["calibration"] if one["intervals"] == "all")
        for nominal, actual in zip(pooled["nominal"], pooled["pixels"]):
            self.assertAlmostEqual(actual, nominal, delta=0.04)
        self.assertIn("For an RMSE of", document["sentence"])
        self.assertIn("--sampler", document["answer"]["options"])
        self.assertLessEqual(document["answer"]["rmse"], document["answer"]["error"] * 1.01)
        values = (self.output / "plots/values.gp").read_text()
        self.assertIn(f"caption = 'scene, 4 spheres, {document['measured_settings']['width']} x", values)
        for fact in (document["isa"], document["version"], document["date"]):
            self.assertRegex(values, f"(?m)^caption = 'scene, .*{re.escape(fact)}.*'$")
        plots = {path.name for path in (self.output / "plots").iterdir()}
        for name in ("convergence", "front", "budget", "coverage", "farms"):
            self.assertIn(name + ".gp", plots)
            if shutil.which("gnuplot"):
                self.assertLessEqual({name + ".svg", name + ".png", name + ".pdf"}, plots)
                svg = (self.output / "plots" / (name + ".svg")).read_text()
                self.assertEqual(set(re.findall(r'font-size="([0-9.]+)"', svg)), {"12.00"}, name)
                self.assertEqual(set(re.findall(r'font-family="([^"]+)"', svg)), {"DejaVu Sans"}, name)
                self.assertTrue((self.output / "plots" / (name + ".pdf")).read_bytes().startswith(b"%PDF-"))

    def test_denoised_pictures_come_of_the_renders_of_raw_ones_and_are_held_to_what_they_state(self):
        document = self.document()
        rows = {row["options"]: row for row in document["rows"]}
        denoised = [row for row in document["rows"] if row["denoised"]]
        self.assertIn("also", {row["knob"] for row in denoised})
        for row in denoised:
            self.assertTrue(row["options"].endswith(" --denoise"))
            self.assertGreater(row["denoise_seconds"], 0)
            self.assertLess(row["denoise_seconds"], row["seconds"])
            self.assertEqual((row["eps_mc"], row["coverage_50"]), (row["claimed_rmse"], None))
        with open(self.output / "runs.csv", newline="") as file:
            runs = {(run["options"], run["seed"]): run for run in csv.DictReader(file)}
        pairs = [(run, runs[(options.removesuffix(" --denoise"), seed)]) for (options, seed), run in runs.items()
                 if options.endswith(" --denoise") and (options.removesuffix(" --denoise"), seed) in runs]
        self.assertGreater(len(pairs), 0)
        for clean, raw in pairs:
            self.assertEqual((clean["samples_per_pixel"], clean["rays_per_sample"]),
                             (raw["samples_per_pixel"], raw["rays_per_sample"]))
            self.assertGreater(float(clean["seconds"]), float(raw["seconds"]))
        # Few samples: a filter takes much of their noise away.
        clean = next(row for row in denoised if "--spp 16 " in row["options"])
        self.assertLess(clean["rmse"], rows[clean["options"].removesuffix(" --denoise")]["rmse"])

    def test_the_front_of_larger_farms_is_modelled_from_what_was_measured(self):
        document = self.document()
        rows = {row["options"]: row for row in document["rows"]}
        farms = document["farms"]
        self.assertEqual([farm["workers"] for farm in farms], [1, 4, 16, 64])
        here = {point["options"]: point for point in farms[0]["points"]}
        scale = 64 * 48 / (document["measured_settings"]["width"] * document["measured_settings"]["height"])
        for farm in farms:
            for point in farm["points"]:
                self.assertEqual(point["rmse"], rows[point["options"]]["rmse"])
                self.assertLessEqual(point["modelled_seconds"], here[point["options"]]["modelled_seconds"] * 1.001)
        for options, point in here.items():
            self.assertAlmostEqual(point["modelled_seconds"] / (rows[options]["seconds"] * scale), 1, delta=0.05)
        with open(self.output / "farms.csv", newline="") as file:
            self.assertEqual(len(list(csv.DictReader(file))), sum(len(farm["points"]) for farm in farms))

    def test_the_recommended_command_reaches_its_error(self):
        document = self.document()
        answer = document["answer"]
        self.assertEqual((answer["error"], answer["asked"]), (0.02, True))
        self.assertTrue(document["sentence"].startswith("For an RMSE of 0.02: --sampler "))
        picture = self.directory / "picture.exr"
        done = run("render", self.scene, "-o", picture, "--seed", 99, *answer["options"].split(), "--quiet")
        self.assertEqual(done.returncode, 0, done.stderr)
        reference = run("compare", self.output / "reference.exr", picture, "--json")
        rmse = json.loads(reference.stdout)["images"][0]["rmse"]
        self.assertLess(rmse, 0.02 * 1.15)


class Targets(TradeoffCase):
    def test_rows_with_targets_equal_their_commands_whatever_samples_the_scene_asks_for(self):
        self.scene.write_text(json.dumps(dict(SCENE, render=dict(SCENE["render"], samples_per_pixel=8))))
        result = self.trade("--error", 0.01)
        document = self.document()
        size = document["measured_settings"]
        rows = [row for row in document["rows"] if row["target_error"] > 0]
        self.assertGreater(len(rows), 0)
        report = self.directory / "report.json"
        for row in rows:
            with self.subTest(row["options"]):
                self.assertFalse(row["denoised"])
                done = run("render", self.scene, "-o", self.directory / "row.png", "--quiet", "--width", size["width"],
                           "--height", size["height"], "--report", report, *row["options"].split())
                self.assertEqual(done.returncode, 0, done.stderr)
                made = json.loads(report.read_text())
                samples = made["samples"] / size["width"] / size["height"]
                self.assertTrue(0.5 < samples / row["samples_per_pixel"] < 2, (samples, row["samples_per_pixel"]))
                self.assertLess(row["rmse"], 1.15 * row["target_error"])
        # The command comes first, to be copied; it meets the error.
        command = result.stdout.splitlines()[0]
        self.assertEqual(command.strip(), document["answer"]["command_line"])
        self.assertTrue(command.startswith(f"  parray render {self.scene} -o scene.exr --sampler "))
        words = command.split()
        done = run(*words[1:4], self.directory / words[4], *words[5:], "--quiet", "--report", report)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertLess(json.loads(report.read_text())["error"]["rmse"], 0.01 * 1.15)
        self.assertTrue(result.stdout.splitlines()[2].startswith("For an RMSE of 0.01: --sampler "))


class Runs(LongerJobs, TradeoffCase):
    @again_with_longer_jobs
    def test_the_same_command_continues_after_a_kill(self):
        budget = 2 * self.longer
        command = [BIN / "parray", "tradeoff", self.scene, "-o", self.output, "--time-budget", budget, "--quiet"]
        process = subprocess.Popen([str(word) for word in command], stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL)
        runs = self.output / "runs.csv"
        while process.poll() is None and not (runs.exists() and runs.read_bytes().count(b"\n") > 5):
            time.sleep(0.01)
        process.send_signal(signal.SIGKILL)
        if process.wait() == 0:
            raise JobOverTooEarly(f"it was over in {budget} s")
        self.assertEqual(process.returncode, -signal.SIGKILL)
        kept = runs.read_bytes()
        self.assertGreater(kept.count(b"\n"), 5)
        reference = (self.output / "reference.exr").read_bytes()
        with open(runs, "ab") as file:
            file.write(b"--sampler sobol --spp 16,1")  # cut by the end of the program
        self.trade()
        whole = kept[:kept.rindex(b"\n") + 1]
        self.assertEqual(runs.read_bytes()[:len(whole)], whole)
        self.assertEqual((self.output / "reference.exr").read_bytes(), reference)
        lines = runs.read_text().splitlines()
        keys = [tuple(line.split(",")[:2]) for line in lines]
        self.assertEqual(len(keys), len(set(keys)), "a render was repeated")
        self.trade()  # all is there: nothing is measured again
        self.assertEqual(runs.read_text().splitlines()[:len(lines)], lines)

    def test_an_interrupt_keeps_the_finished_renders_and_says_so(self):
        command = [BIN / "parray", "tradeoff", self.scene, "-o", self.output, "--time-budget", 60, "--quiet"]
        process = subprocess.Popen([str(word) for word in command], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
        while process.poll() is None and not (self.output / "state.json").exists():
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        output, errors = process.communicate(timeout=60)
        self.assertEqual((process.returncode, output), (130, ""))
        self.assertRegex(errors, r"\Aparray: interrupted: the same command continues[^\n]*\n\Z")

    def test_another_scene_or_size_needs_another_directory_or_restart(self):
        self.trade()
        other = dict(SCENE, spheres=SCENE["spheres"][:2])
        scene = self.directory / "other.json"
        scene.write_text(json.dumps(other))
        self.refused(scene, "-o", self.output, mentions=["scene_sha256", "another directory", "--restart"])
        self.refused(self.scene, "-o", self.output, "--width", 32, mentions=["another", "--restart"])
        self.trade("--restart", scene=scene)
        self.assertEqual(self.document()["scene"], str(scene))

    def test_damaged_measurements_are_refused(self):
        self.trade()
        runs = self.output / "runs.csv"
        whole = runs.read_text()
        runs.write_text(whole.replace(",", ";", 1))
        self.refused(self.scene, "-o", self.output, mentions=[f"{runs}:1", "--restart"])
        lines = whole.splitlines()
        lines[3] = lines[3].rsplit(",", 1)[0]
        runs.write_text("\n".join(lines) + "\n")
        self.refused(self.scene, "-o", self.output, mentions=[f"{runs}:4", "--restart"])
        for damaged in ("{", "[]", '{"identity": 3}'):
            (self.output / "state.json").write_text(damaged)
            self.refused(self.scene, "-o", self.output, mentions=["state.json", "--restart"])

    def test_measurements_that_cannot_be_deleted_are_named(self):
        (self.output / "runs.csv" / "folder").mkdir(parents=True)
        self.refused(self.scene, "-o", self.output, "--restart", mentions=["runs.csv: cannot be deleted"])

    def test_without_gnuplot_one_line_says_how_to_get_plots(self):
        result = self.trade()
        self.assertRegex(result.stderr, r"\Aparray: no plots: gnuplot is missing [^\n]*\n\Z")
        self.assertIn("gnuplot-nox", result.stderr)
        self.assertTrue((self.output / "plots" / "front.gp").exists())

    def test_bad_usage_is_refused_before_any_work(self):
        self.refused(self.scene, mentions=["--output"])
        self.refused(self.scene, "-o", self.output, "--error", 0, mentions=["--error"])
        self.refused(self.scene, "-o", self.output, "--time-budget", "nan", mentions=["--time-budget"])
        self.refused(self.directory / "none.json", "-o", self.output, mentions=["none.json"])
        self.assertFalse(self.output.exists())
        self.refused(self.scene, "-o", self.output, "--also", "--spp 1 --denoise", mentions=["two samples"])
        self.refused(self.scene, "-o", self.output, "--also", "--target-error 0.1 --denoise", mentions=["use --spp"])
        for options in ("--width 100", "--style flat", "--seed 5", "--schedule static", "--transparent on"):
            self.refused(self.scene, "-o", self.output, "--also", options, mentions=["the same picture", options.split()[0]])
        self.refused(self.scene, "-o", self.scene, mentions=["another directory"])

    def test_a_scene_without_noise_has_an_answer_too(self):
        empty = dict(SCENE, spheres=[], materials={})
        empty["sky"] = {"horizon": [0.5, 0.5, 0.5], "zenith": [0.5, 0.5, 0.5]}
        self.scene.write_text(json.dumps(empty))
        self.trade()
        self.assertIn("For an RMSE of", self.document()["sentence"])
        self.assertFalse(self.document()["answer"]["asked"])


if __name__ == "__main__":
    unittest.main()
