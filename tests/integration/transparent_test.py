#!/usr/bin/env python3
"""Transparent pictures on the command line: their files, and the commands that make, check and refuse them."""

import json
import unittest

from cli_usage_test import SCENE, CliTest
from exr import forge_exr, read_exr
from farm import Farm, run
from mpi import MpiRun, why_not
from png import read_rgba

SKY = [0.25, 0.5, 0.75]  # the same everywhere
FLOATING = {**SCENE, "spheres": SCENE["spheres"][1:], "sky": {"horizon": SKY, "zenith": SKY}}


def srgb_byte(linear):
    linear = min(max(linear, 0), 1)
    return 255 * (12.92 * linear if linear <= 0.0031308 else 1.055 * linear ** (1 / 2.4) - 0.055)


class TransparentTest(CliTest):
    def setUp(self):
        super().setUp()
        self.scene.write_text(json.dumps(FLOATING))

    def picture(self, *options, name="a.exr"):
        report, _ = self.rendered(*options, name=name)
        return report, read_exr(self.path(name))[0]

    def said(self, *arguments, status=0):
        result = run(*arguments)
        self.assertEqual(result.returncode, status, result.stdout + result.stderr)
        return result.stdout + result.stderr


class Files(TransparentTest):
    def test_convert_writes_the_transparent_scene_of_a_particle_file(self):
        atoms, scene, size = self.path("atoms.xyz"), self.path("atoms.json"), ["--width", "40", "--height", "30"]
        atoms.write_text("3\n\nO 0 0 0\nH 0 0.8 0.6\nH 0 0.8 -0.6\n")
        options = ["--transparent", "on", "--select", "element O", *size]
        self.said("render", atoms, "-q", "-o", self.path("a.exr"), "--spp", "4", *options)
        for expand in ([], ["--expand"]):
            self.said("convert", atoms, scene, *options, *expand)
            self.assertEqual(json.loads(scene.read_text())["image"]["transparent"], True)
            self.assertIn("right: ", self.said("verify", self.path("a.exr"), scene, "--all"))
            self.said("render", scene, "-q", "-o", self.path("b.exr"), "--spp", "4")
            self.assertEqual(read_exr(self.path("b.exr"))[0], read_exr(self.path("a.exr"))[0])

    def check_completed(self, values, opaque):
        for c, sky in zip("RGB", SKY):
            for colour, alpha, whole in zip(values[c], values["A"], opaque[c]):
                self.assertLess(abs(colour + (1 - alpha) * sky - whole), 1e-6)
                self.assertTrue(alpha > 0 or colour == 0)

    def test_the_sky_behind_a_transparent_picture_completes_the_opaque_one(self):
        for options in ([], ["--sampler", "independent"], ["--target-error", "0.02", "--adaptive", "on"],
                        ["--precision", "f64"]):
            with self.subTest(options=options):
                report, opaque = self.picture(*options)
                cut, values = self.picture("--transparent", "on", *options, name="b.exr")
                self.assertEqual(cut["image_sha256"], report["image_sha256"])
                self.assertEqual(cut["error"], report["error"])
                self.check_completed(values, opaque)
                self.assertAlmostEqual(cut["transparent"]["covered"],
                                       sum(values["A"]) / len(values["A"]), places=6)
                self.assertNotEqual(cut["transparent"]["image_sha256"], cut["image_sha256"])
                self.assertGreater(cut["seconds"]["transparent"], 0)
                self.assertIn(0, values["A"])
                self.assertIn(1, values["A"])
                self.assertGreater(len(set(values["A"])), 3)
                self.assertNotIn("transparent", report)

    def test_a_png_has_the_same_colours_unassociated(self):
        _, values = self.picture("--transparent", "on")
        self.rendered("--transparent", "on", name="b.png")
        pixels = read_rgba(self.path("b.png"))
        for place, (*colour, code) in enumerate(pixels):
            alpha = values["A"][place]
            self.assertLessEqual(abs(code - 255 * alpha), 0.5)
            for byte, c in zip(colour, "RGB"):
                linear = values[c][place] / alpha if code else 0
                self.assertLessEqual(abs(byte - srgb_byte(linear)), 0.501)

    def test_a_scene_asks_for_it_and_an_option_leaves_the_background_in(self):
        self.scene.write_text(json.dumps({**FLOATING, "image": {**SCENE["image"], "transparent": True}}))
        self.assertIn("A", self.picture()[1])
        self.assertNotIn("A", self.picture("--transparent", "off")[1])
        converted = self.path("c.json")
        self.said("convert", self.scene, converted)
        self.assertIs(json.loads(converted.read_text())["image"]["transparent"], True)

    def test_a_denoised_picture_is_completed_by_the_sky_as_well(self):
        _, opaque = self.picture("--denoise")
        report, values = self.picture("--denoise", "--transparent", "on", "--aov", "depth", name="b.exr")
        self.assertIn("Z", values)
        for c, sky in zip("RGB", SKY):
            for colour, alpha, whole in zip(values[c], values["A"], opaque[c]):
                if alpha > 0 and colour > 0:
                    self.assertLess(abs(colour + (1 - alpha) * sky - whole), 1e-6)
        self.assertIn("right", self.said("verify", self.path("b.exr"), self.scene, "--all"))

    def test_an_automatic_scene_has_no_ground(self):
        atoms = self.path("atoms.xyz")
        atoms.write_text("3\n\nO 0 0 0\nH 0.96 0 0\nH -0.24 0.93 0\n")
        result = run("render", atoms, "-q", "-o", self.path("a.png"), "--transparent", "on", "--width", "40",
                     "--height", "30", "--spp", "4")
        self.assertEqual(result.returncode, 0, result.stderr)
        pixels = read_rgba(self.path("a.png"))
        self.assertEqual(pixels[0], (0, 0, 0, 0))
        self.assertEqual(pixels[15 * 40 + 20][3], 255)
        self.assertIn("right", self.said("verify", self.path("a.png"), atoms, "--all"))
        self.said("render", atoms, "-q", "-o", self.path("b.png"), "--like", self.path("a.png"))
        self.assertEqual(read_rgba(self.path("b.png")), pixels)


class Checks(TransparentTest):
    def test_a_transparent_picture_is_verified_by_its_hash_and_traced_again(self):
        for name, options in (("a.exr", []), ("a.png", []), ("b.exr", ["--passes", "38400,5000"]),
                              ("c.exr", ["--width", "200", "--height", "100", "--passes", "1250"])):
            with self.subTest(name=name):
                self.rendered("--transparent", "on", *options, name=name)
                self.assertIn("matches the pixels; not checked", self.said("verify", self.path(name)))
                said = self.said("verify", self.path(name), self.scene, "--all")
                self.assertIn("right: ", said)
                same = "bits" if name.endswith(".exr") else "8-bit values"
                self.assertIn(f"traced again with the same {same}", said)

    def test_wrong_colours_and_wrong_alpha_are_found(self):
        self.rendered("--transparent", "on")
        _, values = self.picture("--transparent", "on")
        inside = values["A"].index(1)
        for channel in ("A", "G"):
            def change(channels, channel=channel):
                channels[channel][inside] *= 0.5
            forge_exr(self.path("a.exr"), self.path("f.exr"), change)
            said = self.said("verify", self.path("f.exr"), self.scene, "--all", status=1)
            self.assertIn("wrong: transparent:image_sha256 does not match the pixels", said)
            self.assertIn("1 differ", said)

    def test_a_picture_is_made_again_by_its_recipe(self):
        _, values = self.picture("--transparent", "on", "--seed", "9")
        _, again = self.picture("--like", self.path("a.exr"), name="b.exr")
        self.assertEqual(again, values)
        self.assertIn("identical", self.said("compare", self.path("a.exr"), self.path("b.exr")))

    def test_pictures_with_and_without_background_are_not_compared(self):
        self.rendered("--transparent", "on")
        self.rendered(name="b.exr")
        self.before = self.files()
        for pair in (("a.exr", "b.exr"), ("b.exr", "a.exr")):
            self.refused("compare", *map(self.path, pair), mentions="a.exr is transparent and ")


class Who(TransparentTest):
    def test_a_farms_picture_is_the_same(self):
        _, expected = self.picture("--transparent", "on")
        with Farm() as farm:
            farm.start_worker("one")
            result = farm.client("submit", self.scene, "--wait", "-q", "-o", self.path("b.exr"),
                                 "--transparent", "on")
            self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(read_exr(self.path("b.exr"))[0], expected)

    @unittest.skipIf(why_not(), why_not())
    def test_a_picture_of_parray_mpi_is_the_same(self):
        _, expected = self.picture("--transparent", "on")
        with MpiRun(2, self.scene, "--threads", "1", "--transparent", "on", picture="a.exr") as job:
            job.finish()
            self.assertEqual(read_exr(job.picture)[0], expected)

    def test_commands_that_write_no_picture_refuse_in_one_line(self):
        self.refused("submit", self.scene, "--transparent", "on", mentions="add --wait -o IMAGE, or --transparent off")
        self.refused("submit", self.scene, "--transparent", "on", "--wait", mentions="--transparent off")
        self.refused("submit", self.scene, "--transparent", "on", "--frames", "1-2",
                     mentions="--transparent: not possible for a series of frames")
        self.refused("submit", self.scene, "--background", "white",
                     mentions="--background: not possible for parray submit without a picture file: add --wait -o IMAGE.png, or "
                              "leave it out")
        self.refused("submit", self.scene, "--background", "white", "--frames", "1-2",
                     mentions="--background: not possible for a series of frames: leave it out, or")
        self.refused("fetch", "1", "-o", self.path("a.png"), "--transparent", "on", mentions="--transparent")


if __name__ == "__main__":
    unittest.main()
