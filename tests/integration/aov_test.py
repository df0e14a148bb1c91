#!/usr/bin/env python3
"""Extra channels on the command line: what --aov writes into a picture, and what it does not change."""

import json
import unittest

from cli_usage_test import SCENE, CliTest
from exr import read_exr
from farm import Farm, run
from mpi import MpiRun, why_not

ALL = "depth,normal,albedo,sphere,cost"
RGB = {"R", "G", "B"}
TYPES = {**dict.fromkeys(["R", "G", "B", "Z", "N.X", "N.Y", "N.Z", "albedo.R", "albedo.G",
                          "albedo.B", "cost"], "f"), "sphere": "I"}
SKY = 2**32 - 1


class AovTest(CliTest):
    def channels(self, *options, name="a.exr"):
        report, _ = self.rendered(*options, name=name)
        return report, *read_exr(self.path(name))

    def at(self, x, y):
        """The place of a pixel of SCENE's picture."""
        return y * SCENE["image"]["width"] + x


class Channels(AovTest):
    def test_the_picture_is_the_same_and_has_the_channels_that_were_asked_for(self):
        plain, rgb, types = self.channels()
        self.assertEqual(set(types), RGB)
        self.assertNotIn("aovs", plain)
        report, values, types = self.channels("--aov", ALL)
        self.assertEqual(types, TYPES)
        self.assertEqual(report["image_sha256"], plain["image_sha256"])
        self.assertEqual({name: values[name] for name in RGB}, rgb)
        self.assertEqual(report["aovs"], ALL.split(","))
        self.assertGreater(report["seconds"]["aovs"], 0)
        report, few, types = self.channels("--aov", "sphere,depth")
        self.assertEqual(set(types), RGB | {"Z", "sphere"})
        self.assertEqual(report["aovs"], ["depth", "sphere"])
        self.assertEqual((few["Z"], few["sphere"]), (values["Z"], values["sphere"]))

    def test_the_channels_have_the_values_of_the_scene(self):
        report, values, _ = self.channels("--aov", ALL, "--spp", "16")
        sky = self.at(5, 0)
        self.assertEqual(values["sphere"][sky], SKY)
        self.assertEqual({values[name][sky] for name in ("N.Y", "albedo.R")}, {0})
        self.assertEqual(values["Z"][sky], float("inf"))
        self.assertEqual(values["cost"][sky], 1)
        ground = self.at(20, 28)
        self.assertEqual(values["sphere"][ground], 0)
        self.assertAlmostEqual(values["albedo.G"][ground], 0.5)
        self.assertGreater(values["N.Y"][ground], 0.99)
        self.assertLess(set(values["sphere"]) - {SKY}, set(range(len(SCENE["spheres"]) + 1)))
        self.assertEqual(len(set(values["sphere"])), len(SCENE["spheres"]) + 1)
        self.assertGreater(values["Z"][ground], 2)
        self.assertLess(values["Z"][ground], 8)
        rays = sum(values["cost"]) * 16  # of at most 16 samples cost knows all
        self.assertAlmostEqual(rays / report["rays"], 1, places=6)

    def test_the_channels_do_not_depend_on_how_the_work_is_done(self):
        _, expected, _ = self.channels("--aov", ALL)
        for options in (["--threads", "1"], ["--threads", "3"], ["--accelerator", "octree"],
                        ["--isa", "scalar"], ["--row-order", "sequential"]):
            with self.subTest(options=options):
                self.assertEqual(self.channels("--aov", ALL, *options)[1], expected)

    def test_spheres_are_numbered_after_duplicates_are_left_out_and_before_the_particles(self):
        atoms = self.path("atoms.xyz")
        atoms.write_text("3\n\nO 9 9 9\nO 9 9 9\nH 0 0.5 0\n")
        self.scene.write_text(json.dumps({**SCENE, "spheres": [SCENE["spheres"][0]] * 3,
                                          "particles": [{"file": "atoms.xyz", "radius": 0.5}]}))
        self.assertEqual(self.seen_in_the_middle(self.scene, "3 spheres left out"), 2)
        atoms.write_text("1\n\nH 0 0 0\n")
        ground_and_flag = 2  # of every portrait
        self.assertEqual(self.seen_in_the_middle(atoms, ""), ground_and_flag)

    def seen_in_the_middle(self, scene, warning):
        result = run("render", scene, "-q", "-o", self.path("a.exr"), "--aov", "sphere",
                     "--width", "40", "--height", "30", "--spp", "1")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn(warning, result.stderr)
        return read_exr(self.path("a.exr"))[0]["sphere"][self.at(20, 15)]

    def test_a_farms_picture_gets_the_same_channels(self):
        _, expected, _ = self.channels("--aov", ALL)
        with Farm() as farm:
            farm.start_worker("one")
            result = farm.client("submit", self.scene, "--wait", "-q", "-o", self.path("b.exr"),
                                 "--aov", ALL)
            self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(read_exr(self.path("b.exr"))[0], expected)

    @unittest.skipIf(why_not(), why_not())
    def test_a_picture_of_parray_mpi_gets_the_same_channels(self):
        report, expected, _ = self.channels("--aov", ALL)
        with MpiRun(2, self.scene, "--threads", "1", "--aov", ALL, picture="a.exr") as job:
            self.assertEqual(job.finish()["aovs"], report["aovs"])
            self.assertEqual(read_exr(job.picture)[0], expected)


class Refusals(AovTest):
    def test_a_picture_without_room_for_channels_is_refused_before_the_scene_is_read(self):
        missing = self.path("no-such-scene.json")
        for command in (["render", missing], ["submit", missing, "--wait"]):
            self.refused(*command, "-o", self.path("a.png"), "--aov", "depth",
                         mentions="write an EXR file (.exr)")

    def test_unknown_channels_and_channels_of_no_picture_are_refused(self):
        picture = ["-o", self.path("a.exr")]
        self.refused("render", self.scene, *picture, "--aov", "dpeth", mentions="'depth'")
        for value in ("", "Z", "depth,", "depth;cost"):
            self.refused("render", self.scene, *picture, "--aov", value, mentions="known: depth, ")
        self.refused("submit", self.scene, "--wait", "--aov", "depth", mentions="--output")
        self.refused("fetch", "1", *picture, "--aov", "depth", mentions="--aov")


if __name__ == "__main__":
    unittest.main()
