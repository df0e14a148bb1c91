#!/usr/bin/env python3
"""Views, styles and postprocessing on the command line."""

import json
import unittest

import jsonschema

from cli_usage_test import SCENE, CliTest
from farm import SCENES, run
from png import read_rgb, read_text

SMALL = ["--width", "40", "--height", "30", "--spp", "4", "-q"]
STYLES = ["studio", "publication", "flat", "night"]
BOX = """ITEM: TIMESTEP
0
ITEM: NUMBER OF ATOMS
4
ITEM: BOX BOUNDS pp pp pp
0 8
0 8
0 8
ITEM: ATOMS id type x y z
1 1 1 1 1
2 1 7 1 1
3 2 1 7 1
4 2 1 1 7
"""


class ViewsTest(CliTest):
    def setUp(self):
        super().setUp()
        self.path("atoms.xyz").write_text("3\n\nO 0 0 0\nO 3 0 0\nH -0.24 0.93 4\n")
        self.path("box.dump").write_text(BOX)
        self.atoms = self.path("atoms.xyz")
        self.before = self.files()

    def render(self, name, *options, scene=None):
        report = self.path(name + ".json")
        result = run("render", scene or self.atoms, "-o", self.path(name), "--report", report, *SMALL, *options)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        return json.loads(report.read_text())

    def converted(self, source, *options):
        out = self.path("out.json")
        result = run("convert", source, out, *options)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        return json.loads(out.read_text())


class Refusals(ViewsTest):
    def test_unknown_words_are_refused_with_the_nearest(self):
        picture = self.path("a.png")
        for options, mentions in (
                (["--view", "tpo"], "did you mean 'top'?"),
                (["--style", "publicatoin"], "did you mean 'publication'?"),
                (["--projection", "ortographic"], "did you mean 'orthographic'?"),
                (["--outline", "onn"], "did you mean 'on'?"),
                (["--outline", "0"], "pixels from 0.1 to 100"),
                (["--outline", "0.5pt"], "add --dpi or --width-mm"),
                (["--depth-cue", "2"], "a share from 0 to 1"),
                (["--views", "front,front"], "'front' occurs twice"),
                (["--views", "front,"], "unknown view ''"),
                (["--views", "front", "--view", "top"], "--view: not possible for one picture of several views")):
            self.refused("render", self.atoms, "-o", picture, *options, mentions=mentions)

    def test_options_for_8_bit_pictures_are_refused_for_exr_files(self):
        self.refused("render", self.atoms, "-o", self.path("a.exr"), "--outline", "on",
                     mentions="--outline: an EXR file stores the traced values, without postprocessing")
        self.refused("render", self.atoms, "-o", self.path("a.exr"), "--views", "front,top",
                     mentions="write a .png, .tif, .jpg or .jp2, or an EXR file of each")

    def test_impossible_options_of_a_sheet_of_views_are_refused_before_any_work(self):
        for option in (["--error-map", self.path("e.png")], ["--preview", self.path("p.png")],
                       ["--display", "127.0.0.1:1"], ["--on-end", "true"], ["--like", self.path("a.png")]):
            self.refused("render", self.atoms, "-o", self.path("a.png"), "--views", "front,top", *option,
                         mentions=option[0] + ": not possible for one picture of several views (--views): leave it out, or")
        self.refused("render", "-", "-o", self.path("a.png"), "--views", "front,top", mentions="save it as a file")
        self.refused("render", self.atoms, "-o", self.path("a.png"), "--views", "front,top", "--aov", "samples",
                     mentions="--aov samples: not possible for one picture of several views (--views): leave it out, or")

    def test_views_and_styles_are_for_files_of_particles(self):
        self.scene.write_text(json.dumps(SCENE))
        self.before = self.files()
        for option in (["--view", "top"], ["--style", "flat"], ["--projection", "perspective"]):
            self.refused("render", self.scene, "-o", self.path("a.png"), *option,
                         mentions=option[0] + ": ")
        self.refused("render", self.scene, "-o", self.path("a.png"), "--views", "top,front",
                     mentions="is not a particle file")

    def test_outlines_need_a_camera_without_a_lens(self):
        scene = {**SCENE, "camera": {**SCENE["camera"], "aperture": 0.5}}
        self.scene.write_text(json.dumps(scene))
        self.before = self.files()
        self.refused("render", self.scene, "-o", self.path("a.png"), "--outline", "on",
                     mentions="set aperture to 0")


class Camera(ViewsTest):
    def test_impossible_cameras_and_colours_are_refused_with_a_remedy(self):
        for options, mentions in (
                (["--up", "w"], "--up: 'w' is not a direction: write x, y, z"),
                (["--up", "0,0,0"], "is not a direction"),
                (["--azimuth", "361"], "--azimuth: '361' is not a number from -360 to 360"),
                (["--elevation", "-91"], "--elevation: '-91' is not a number from -90 to 90"),
                (["--zoom", "0"], "--zoom: '0' is not a number from 0.1 to 100"),
                (["--view", "iso", "--elevation", "80"], "view iso would turn over the top"),
                (["--view", "+x", "--up", "y"], "name a side with --view"),
                (["--views", "+x,top", "--up", "y"], "name a side with --view"),
                (["--background", "blueish"], "'blueish' is not a colour: write white, black, grey, or a code"),
                (["--background", "#12345g"], "is not a colour"),
                (["--background", "white", "--transparent", "on"], "exclude each other")):
            self.refused("render", self.atoms, "-o", self.path("a.png"), *options, mentions=mentions)
        self.refused("render", self.atoms, "-o", self.path("a.exr"), "--background", "white",
                     mentions="--background: an EXR file stores")
        self.scene.write_text(json.dumps(SCENE))
        self.before = self.files()
        for option in (["--up", "y"], ["--azimuth", "3"], ["--elevation", "3"], ["--zoom", "2"],
                       ["--background", "black"]):
            self.refused("render", self.scene, "-o", self.path("a.png"), *option, mentions=option[0] + ": ")

    def test_up_turns_the_scene_and_a_scene_file_keeps_the_camera(self):
        camera = self.converted(self.atoms, "--view", "front", "--up", "y")["camera"]
        self.assertEqual(camera["up"], [0, 1, 0])
        self.assertGreater(camera["look_from"][2], camera["look_at"][2])
        options = ["--up=-x", "--azimuth=-30", "--elevation", "25", "--zoom", "1.5", "--style", "flat"]
        portrait = self.render("a.png", *options)
        self.converted(self.atoms, *options, "--width", "40", "--height", "30")
        self.assertEqual(self.render("b.png", scene=self.path("out.json"))["scene_sha256"], portrait["scene_sha256"])

    def test_a_background_is_exact_and_the_picture_is_checked_against_its_own_hash(self):
        for name in ("a.png", "a.tif"):
            self.render(name, "--background", "#1e90ff", "--style", "night", "--legend", "--font-size", "3")
        width, height, pixels = read_rgb(self.path("a.png"))
        self.assertEqual(pixels[:3], b"\x1e\x90\xff")
        self.assertEqual(read_text(self.path("a.png"))["parray:finished"], "background, depth-cue, legend")
        result = run("verify", self.path("a.png"))
        self.assertEqual(result.returncode, 0, result.stdout)
        plain = self.render("b.png", "--transparent", "on", "--style", "night", "--legend", "--font-size", "3")
        again = self.render("c.jpg", "--background", "black", "--style", "night", "--legend", "--font-size", "3")
        self.assertEqual(again["image_sha256"], plain["image_sha256"])


class Quality(ViewsTest):
    def report(self, *options, scene=None):
        result = run("render", scene or self.atoms, "-o", self.path("q.png"), "--report", self.path("q.json"), "-q",
                     *options)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        return json.loads(self.path("q.json").read_text())

    def test_a_bare_file_stops_at_an_error_unless_an_option_says_when(self):
        size = ["--width", "40", "--height", "30"]
        report = self.report(*size)
        self.assertEqual((report["target_error"], report["stopped_by"]), (0.02, "error"))
        self.assertEqual(self.report(*size, "--spp", "6")["samples_per_pixel"], 6)
        self.assertEqual(self.report(*size, "--spp", "6")["target_error"], 0)
        self.assertEqual(self.report(*size, "--target-error", "0.1")["target_error"], 0.1)
        limited = self.report(*size, "--time-limit", "0.5")
        self.assertEqual((limited["target_error"], limited["time_limit"]), (0, 0.5))

    def test_a_scene_file_keeps_its_samples(self):
        self.scene.write_text(json.dumps(SCENE))
        report = self.report(scene=self.scene)
        self.assertEqual(report["target_error"], 0)
        self.assertEqual(report["stopped_by"], "samples")

    def test_a_quality_sets_size_error_and_denoising_and_options_win(self):
        self.scene.write_text(json.dumps(SCENE))
        usual = self.report(scene=self.scene)
        for name, size, error in (("draft", 0.5, 0.05), ("good", 1, 0.02), ("print", 2, 0.005)):
            report = self.report("--quality", name, scene=self.scene)
            self.assertEqual((report["width"], report["height"], report["target_error"]),
                             (round(usual["width"] * size), round(usual["height"] * size), error))
            self.assertEqual("denoised" in report, name == "draft")
        report = self.report("--quality", "draft", "--spp", "5", "--width", "24")
        self.assertEqual((report["width"], report["height"], report["samples_per_pixel"], report["target_error"]),
                         (24, 450, 5, 0))
        self.assertNotIn("denoised", self.report("--quality", "draft", "--spp", "1", "--width", "24"))
        self.before = self.files()
        self.refused("render", self.atoms, "-o", self.path("a.png"), "--quality", "best",
                     mentions="--quality: unknown quality 'best': known: draft, good, print")
        self.refused("render", self.atoms, "-o", self.path("a.png"), "--quality", "good", "--like", self.path("q.png"),
                     mentions="--quality and --like exclude each other")


class Portraits(ViewsTest):
    def test_scenes_of_all_styles_and_views_follow_the_schema(self):
        schema = json.loads((SCENES / "schema/scene.v1.schema.json").read_text())
        for style in STYLES:
            for view in ("auto", "front", "iso"):
                with self.subTest(style=style, view=view):
                    scene = self.converted(self.path("box.dump"), "--style", style, "--view", view)
                    jsonschema.validate(scene, schema)
                    names = [sphere["material"] for sphere in scene["spheres"]]
                    self.assertEqual(names, {"studio": ["ground", "flag"], "publication": ["flag"],
                                             "flat": [], "night": ["wall", "flag"]}[style])

    def test_a_scene_with_a_style_equals_the_automatic_scene(self):
        for style in STYLES:
            portrait = self.render("a.png", "--style", style, "--view", "front")
            self.converted(self.atoms, "--style", style, "--view", "front", "--width", "40", "--height", "30")
            scene = self.render("b.png", scene=self.path("out.json"))
            self.assertEqual(scene["scene_sha256"], portrait["scene_sha256"])
            if style != "night":  # whose wall is one sphere of many in the scene
                self.assertEqual(read_rgb(self.path("a.png")), read_rgb(self.path("b.png")))

    def test_a_box_is_seen_with_z_up_and_its_cell_fits_where_it_is_drawn(self):
        camera = self.converted(self.path("box.dump"))["camera"]
        self.assertGreater(camera["up"][2], 0.9)
        front = self.converted(self.path("box.dump"), "--view", "front")["camera"]
        self.assertEqual(front["up"], [0, 0, 1])
        self.assertEqual(front["projection"], "orthographic")


class Finishing(ViewsTest):
    def test_outlines_change_the_png_and_not_what_was_traced(self):
        plain = self.render("plain.png", "--style", "flat", "--outline", "off")
        lines = self.render("lines.png", "--style", "flat")
        exr = self.render("a.exr", "--style", "flat")
        self.assertEqual(plain["image_sha256"], lines["image_sha256"])
        self.assertEqual(plain["image_sha256"], exr["image_sha256"])
        self.assertNotEqual(read_rgb(self.path("plain.png")), read_rgb(self.path("lines.png")))
        self.assertNotIn("parray:finished", read_text(self.path("plain.png")))
        self.assertEqual(read_text(self.path("lines.png"))["parray:finished"], "outline")
        width, height, pixels = read_rgb(self.path("lines.png"))
        self.assertLess(min(pixels), 60)  # ink
        self.assertEqual(pixels[:3], b"\xff\xff\xff")

    def test_depth_cue_comes_before_outline(self):
        self.render("a.png", "--depth-cue", "on", "--outline", "0.5pt", "--dpi", "144")
        self.assertEqual(read_text(self.path("a.png"))["parray:finished"], "depth-cue, outline")

    def test_the_depth_cue_of_a_night_fades_far_particles_though_their_gaps_show_the_wall(self):
        layers = [(x, 0 if x < 8 else 12, z) for x in range(16) for z in range(8)]
        self.path("layers.txt").write_text("x y z\n" + "".join(f"{x} {y} {z}.5\n" for x, y, z in layers))
        light = {}
        for share in ("0", "1"):
            run("render", self.path("layers.txt"), "-o", self.path("a.png"), "--style", "night", "--view", "front",
                "--radius", "0.5", "--depth-cue", share, "--width", "96", "--height", "72", "--spp", "4", "-q")
            width, height, pixels = read_rgb(self.path("a.png"))
            rows = [pixels[3 * width * y:3 * width * (y + 1)] for y in range(height)]
            light[share] = [sum(sum(row[at:at + 3 * width // 2]) for row in rows) for at in (0, 3 * width // 2)]
        self.assertGreater(light["1"][0], 0.8 * light["0"][0])  # the near half
        self.assertLess(light["1"][1], 0.6 * light["0"][1])

    def test_a_sheet_shows_every_view_as_it_is_alone(self):
        sheet = self.render("sheet.png", "--views", "front,top,iso,left", "--style", "publication")
        width, height, pixels = read_rgb(self.path("sheet.png"))
        self.assertEqual((width, height), (2 * 40 + 2, 2 * 30 + 2))
        self.assertEqual([view["view"] for view in sheet["views"]], ["front", "top", "iso", "left"])
        for i, view in enumerate(sheet["views"]):
            alone = self.render("alone.png", "--view", view["view"], "--style", "publication")
            self.assertEqual(view["image_sha256"], alone["image_sha256"])
            _, _, expected = read_rgb(self.path("alone.png"))
            left, top = i % 2 * 42, i // 2 * 32
            for y in range(30):
                row = 3 * ((top + y) * width + left)
                self.assertEqual(pixels[row:row + 120], expected[120 * y:120 * (y + 1)])

    def sheet_within(self, limit, *options):
        """Report and stderr of a sheet of three views."""
        report = self.path("sheet.json")
        result = run("render", self.atoms, "-o", self.path("sheet.png"), "--report", report, "-q",
                     "--views", "front,top,iso", "--time-limit", limit, *options)
        self.assertEqual(result.returncode, 0, result.stderr)
        return json.loads(report.read_text()), result.stderr

    def test_a_time_limit_counts_all_views_and_each_gets_the_same_part_of_the_rest(self):
        sheet, said = self.sheet_within("1.5", "--width", "40", "--height", "30")
        self.assertEqual(said, "")
        self.assertEqual(len(sheet["views"]), 3)
        limits = [view["time_limit"] for view in sheet["views"]]
        self.assertLessEqual(sum(limits), 1.5)
        self.assertLess(limits[0], 0.5)
        for view in sheet["views"]:
            self.assertEqual(view["stopped_by"], "time")
            self.assertGreater(view["samples_per_pixel"], 0)

    def test_time_that_a_view_leaves_goes_to_the_next(self):
        sheet, _ = self.sheet_within("60", "--width", "40", "--height", "30", "--target-error", "0.1")
        limits = [view["time_limit"] for view in sheet["views"]]
        self.assertLess(limits[0], 20)
        self.assertGreater(limits[1], limits[0])
        self.assertGreater(limits[2], limits[1])
        self.assertGreater(limits[2], 40)

    def test_views_are_denoised_all_or_none_under_a_time_limit(self):
        sheet, said = self.sheet_within("60", "--width", "40", "--height", "30", "--denoise", "--target-error", "0.1")
        self.assertEqual(said, "")
        self.assertTrue(all("denoised" in view for view in sheet["views"]))
        sheet, said = self.sheet_within("0.3", "--width", "1500", "--height", "1000", "--denoise")
        self.assertFalse(any("denoised" in view for view in sheet["views"]))
        self.assertEqual(said.count("parray: --time-limit 0.3: denoising takes about"), 1)

    def test_a_sheet_that_cannot_fit_into_its_time_is_written_with_one_warning(self):
        sheet, said = self.sheet_within("0.01", "--width", "400", "--height", "300")
        self.assertEqual(len(sheet["views"]), 3)
        self.assertRegex(said, r"\Aparray: --time-limit 0\.01: loading and writing alone take about [^\n]*: as "
                               r"little as possible is traced\n\Z")


if __name__ == "__main__":
    unittest.main()
