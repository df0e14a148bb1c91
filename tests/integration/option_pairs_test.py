#!/usr/bin/env python3
"""Every pair of values of the options of `render`, in few runs: each ends soon, with a picture or one line."""

import itertools
import json
import os
import pathlib
import random
import subprocess
import tempfile
import unittest
from concurrent.futures import ThreadPoolExecutor

from farm import BIN, SCENES

# The picture of 8 x 8 pixels; None: the option is left out.
OPTIONS = {
    "--spp": [None, "1", "2", "3", "33"],
    "--max-depth": [None, "1"],
    "--seed": [None, "0"],
    "--precision": [None, "f32", "mixed", "f64"],
    "--accelerator": [None, "linear", "bvh", "octree"],
    "--isa": [None, "scalar"],
    "--sampler": [None, "independent", "sobol"],
    "--schedule": [None, "static", "guided", "factoring", "weighted"],
    "--row-order": [None, "sequential", "interleaved"],
    "--adaptive": [None, "on", "off"],
    "--target-error": [None, "0.2", "0.02"],
    "--target-half-width": [None, "0.5"],
    "--time-limit": [None, "0.01", "0.3"],
    "--passes": [None, "64", "64,64", "128,64", "2048"],
    "--threads": [None, "1", "3"],
    "--preview": [None, "preview.png"],
    "-o": ["x.png", "x.exr", "x.exr --aov samples", "x.exr --aov half-width", "x.exr --aov depth,cost",
           "x.exr --denoise", "x.png --transparent on", "x.exr --denoise --transparent on"],
    "--depth-cue": [None, "on", "1"],
    "--report": [None, "report.json"],
}


def pairs_of(row):
    return set(itertools.combinations(sorted(row.items(), key=lambda item: item[0]), 2))


def all_pairs():
    names = sorted(OPTIONS)
    return {((a, x), (b, y)) for a, b in itertools.combinations(names, 2)
            for x in OPTIONS[a] for y in OPTIONS[b]}


def covering_array(seed=1, tries=12):
    """Rows of which some one has any two values: greedy, the best of a few random rows at a time."""
    dice = random.Random(seed)
    left = all_pairs()
    rows = []
    while left:
        best, best_found = None, set()
        seeds = sorted(left, key=repr)
        for _ in range(tries):
            row = dict(dice.choice(seeds))
            for name in dice.sample(sorted(OPTIONS), len(OPTIONS)):
                if name in row:
                    continue

                def gain(value, name=name, row=row):
                    return sum(tuple(sorted([(name, value), other], key=lambda item: item[0])) in left
                               for other in row.items())
                row[name] = max(dice.sample(OPTIONS[name], len(OPTIONS[name])), key=gain)
            found = pairs_of(row) & left
            if len(found) > len(best_found):
                best, best_found = row, found
        rows.append(best)
        left -= best_found
    return rows


class OptionPairs(unittest.TestCase):
    def run_row(self, row):
        with tempfile.TemporaryDirectory() as directory:
            words = " ".join(f"{name} {value}" for name, value in row.items() if value is not None)
            command = [BIN / "parray", "render", SCENES / "glass.json", "--width", "8", "--height",
                       "8", "-q", *words.split()]
            done = subprocess.run(list(map(str, command)), cwd=directory, capture_output=True,
                                  text=True, timeout=60)
            shown = words + f"\n{done.stdout}{done.stderr}"
            picture = pathlib.Path(directory) / row["-o"].split()[0]
            if done.returncode == 2:
                if done.stderr.count("\n") != 1 or not done.stderr.startswith("parray: ") or \
                        picture.exists():
                    return "not refused with one line: " + shown
            elif done.returncode != 0 or "internal error" in done.stderr or not picture.exists():
                return f"status {done.returncode}: " + shown
            return None

    def render(self, *words):
        with tempfile.TemporaryDirectory() as directory:
            command = [BIN / "parray", "render", SCENES / "glass.json", "-q", "-o",
                       pathlib.Path(directory) / "x.exr", *words]
            done = subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=60)
            return done.returncode, done.stdout + done.stderr

    def test_passes_that_no_picture_has_are_refused_and_the_line_says_which_there_are(self):
        for words in (["--width", 30, "--height", 20, "--passes", 64],
                      ["--width", 30, "--height", 20, "--passes", 8, "--spp", 16],
                      ["--width", 200, "--height", 200, "--passes", "2500,40"]):
            status, said = self.render(*words)
            self.assertEqual(status, 2, said)
            self.assertEqual(said.count("\n"), 1, said)
            self.assertIn("cannot get a pass of", said)

    def test_a_picture_of_one_sample_has_statistics_and_says_that_its_error_is_unknown(self):
        for aov in ("samples", "half-width"):
            status, said = self.render("--width", 8, "--height", 8, "--spp", 1, "--aov", aov)
            self.assertEqual(status, 0, said)
            self.assertIn("1 sample per pixel, error not known", said)

    def test_the_line_about_a_picture_rounds_its_mean_number_of_samples(self):
        with tempfile.NamedTemporaryFile() as report:
            status, said = self.render("--width", 48, "--height", 36, "--target-half-width", 0.03, "--report", report.name)
            self.assertEqual(status, 0, said)
            mean = json.loads(pathlib.Path(report.name).read_text())["samples_per_pixel"]
        self.assertNotEqual(mean, int(mean))
        self.assertIn(f", {mean:.3g} samples per pixel, ", said)

    def test_every_pair_of_values_of_render_ends_with_a_picture_or_one_line(self):
        rows = covering_array()
        self.assertEqual(set().union(*map(pairs_of, rows)), all_pairs())
        with ThreadPoolExecutor(min(4, os.cpu_count())) as pool:
            faults = [fault for fault in pool.map(self.run_row, rows) if fault]
        self.assertEqual(faults, [])


if __name__ == "__main__":
    unittest.main()
