#!/usr/bin/env python3
"""How a picture's error is shown: in the last line, beside the target, and as a map."""

import json
import re
import struct
import unittest

from cli_usage_test import SCENE, CliTest
from exr import read_exr
from farm import Farm, wait_for
from mpi import MpiRun, why_not
from png import read_chunks, read_text

LINE = re.compile(r"error ([0-9.e-]+) \(([0-9.e-]+) to ([0-9.e-]+)\)")


class MapTest(CliTest):
    def check_map(self, path, sha256):
        width, height = struct.unpack_from(">2I", read_chunks(path)[0][1])
        self.assertGreaterEqual(width, SCENE["image"]["width"])
        self.assertGreater(height, SCENE["image"]["height"])
        texts = read_text(path)
        self.assertEqual(texts["parray:error_map_of"], sha256)
        low, high = (float(texts[f"parray:error_map_{end}"]) for end in ("low", "high"))
        self.assertLess(0, low)
        self.assertLess(low, high)
        return low, high

    def check_line(self, text, report):
        figures = [float(figure) for figure in LINE.search(text).groups()]
        for figure, name in zip(figures, ("rmse", "low", "high")):
            self.assertAlmostEqual(figure / report["error"][name], 1, delta=0.006)


class Maps(MapTest):
    def test_a_map_has_the_range_of_the_half_widths_and_leaves_the_picture_alone(self):
        plain, _ = self.rendered("--spp", "16")
        report, _ = self.rendered("--spp", "16", "--error-map", self.path("e.PNG"), name="b.exr")
        self.assertEqual(report["image_sha256"], plain["image_sha256"])
        self.assertEqual(read_exr(self.path("a.exr")), read_exr(self.path("b.exr")))
        low, high = self.check_map(self.path("e.PNG"), report["image_sha256"])
        self.assertLess(low, report["error"]["half_width_p50"])
        self.assertGreaterEqual(high, report["error"]["half_width_p99"])
        before = self.path("e.PNG").read_bytes()
        self.rendered("--spp", "16", "--error-map", self.path("e.PNG"), "--threads", "3")
        self.assertEqual(self.path("e.PNG").read_bytes(), before)

    def test_a_farm_s_picture_and_a_series_have_the_same_maps(self):
        report, _ = self.rendered("--error-map", self.path("e.png"))
        expected = self.path("e.png").read_bytes()
        with Farm() as farm:
            farm.start_worker("one")
            result = farm.client("submit", self.scene, "--wait", "-q", "-o", self.path("b.png"),
                                 "--error-map", self.path("f.png"))
            self.assertEqual(result.returncode, 0, result.stderr)
            self.check_line(result.stdout, report)
            self.assertEqual(self.path("f.png").read_bytes(), expected)
            number = result.stdout.split()[0]
            result = farm.client("fetch", number, "-o", self.path("b.png"), "--error-map",
                                 self.path("g.png"))
            self.assertEqual(result.returncode, 0, result.stderr)
            self.check_line(result.stdout, report)
            self.assertEqual(self.path("g.png").read_bytes(), expected)
            self.path("s-0007.json").write_text(json.dumps(SCENE))
            result = farm.client("submit", self.path("s-####.json"), "--frames", "7-7", "--wait",
                                 "-q", "-o", self.path("s-####.png"), "--error-map",
                                 self.path("m-####.png"))
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual(self.path("m-0007.png").read_bytes(), expected)

    @unittest.skipIf(why_not(), why_not())
    def test_a_picture_of_parray_mpi_has_the_same_map(self):
        self.rendered("--error-map", self.path("e.png"))
        with MpiRun(2, self.scene, "--threads", "1", "--error-map", self.path("f.png")) as job:
            report = job.finish()
            self.check_line(job.text(), report)
        self.assertEqual(self.path("f.png").read_bytes(), self.path("e.png").read_bytes())

    def test_impossible_maps_are_refused_before_any_work(self):
        picture = ["-o", self.path("a.exr")]
        missing = self.path("no-such-scene.json")
        for name, mentions in (("e.exr", "write a PNG file"), ("e", "use .exr"),
                               ("no/e.png", "no/e.png"), ("", "--error-map")):
            path = self.path(name) if name else ""
            self.refused("render", missing, *picture, "--error-map", path, mentions=mentions)
        self.refused("render", missing, "-o", self.path("a.png"), "--error-map", self.path("a.png"),
                     mentions="different files")
        self.refused("fetch", "1", *picture, "--error-map", self.path("e.exr"), mentions="PNG")
        self.refused("submit", self.scene, "--error-map", self.path("e.png"), mentions="--output")
        self.refused("submit", self.path("s-####.json"), "--frames", "1-2", "--wait", "-o",
                     self.path("a-####.png"), "--error-map", self.path("e.png"), mentions="####")


class Words(MapTest):
    def test_the_last_line_says_the_error_or_that_it_is_not_known(self):
        report, line = self.rendered("--spp", "16")
        self.check_line(line, report)
        report, line = self.rendered("--spp", "1", "--error-map", self.path("e.png"))
        self.assertIsNone(report["error"]["rmse"])
        self.assertIn(", error not known, ", line)
        self.check_map(self.path("e.png"), report["image_sha256"])

    def test_jobs_show_and_progress_say_how_far_the_error_is_from_its_target(self):
        far = re.compile(r"error [0-9.e-]+ of 1e-05")
        with Farm() as farm:
            farm.start_worker("one")
            number = farm.submit(self.scene, "--target-error", "0.00001")
            wait_for(lambda: far.search(farm.client("jobs").stdout), "the first pass")
            shown = farm.client("show", number).stdout
            self.assertRegex(shown, r"error so far +[0-9.e-]+ \([0-9.e-]+ to [0-9.e-]+\)")
            self.assertRegex(shown, far)
            job = farm.job(number)
            self.assertEqual(job["target_error"], 0.00001)
            self.assertLess(job["error"]["rmse"], job["error"]["high"])
            farm.client("cancel", number)
            number = farm.submit(self.scene, "--target-error", "0.02")
            report = farm.finish(number)
            row = farm.client("jobs").stdout.splitlines()[2]
            self.assertIn(f"  {report['error']['rmse']:.3g}  ", row)
            self.assertEqual(farm.job(number)["error"]["high"], report["error"]["high"])
            self.check_line("error " + farm.client("show", number).stdout.split("error")[1].strip(),
                            report)


if __name__ == "__main__":
    unittest.main()
