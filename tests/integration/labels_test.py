#!/usr/bin/env python3
"""Labels on pictures and in their files: legends, scale bars, text, size in print."""

import json
import struct
import unittest

from cli_usage_test import SCENE, CliTest
from exr import read_attributes
from farm import Farm, run
from mpi import MpiRun, why_not
from png import read_chunks, read_text

ATOMS = "3\n\nO 0 0 0\nH 0.96 0 0\nH -0.24 0.93 0\n"
SMALL = ["--width", "240", "--height", "180", "--spp", "2", "-q"]
ENTRIES = [{"name": "H", "color": [1.0, 1.0, 1.0], "count": 2}, {"name": "O", "count": 1}]


class Labels(CliTest):
    def setUp(self):
        super().setUp()
        self.atoms = self.path("atoms.xyz")
        self.atoms.write_text(ATOMS)
        self.scene.write_text(json.dumps({**SCENE, "particles": [{"file": "atoms.xyz"}]}))
        self.before = self.files()

    def render(self, *options, scene=None, name="a.png"):
        result = run("render", scene or self.atoms, "-o", self.path(name), "--report",
                     self.path("r.json"), *SMALL, *options)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        return json.loads(self.path("r.json").read_text())

    def pixels(self, name):
        return [contents for kind, contents in read_chunks(self.path(name)) if kind == b"IDAT"]

    def check_legends(self, legends):
        self.assertEqual([legend["title"] for legend in legends], ["element"])
        for entry, expected in zip(legends[0]["entries"], ENTRIES, strict=True):
            self.assertEqual({**entry, **expected}, entry)

    def test_what_is_drawn_changes_the_png_alone_and_not_the_hash_of_what_was_traced(self):
        plain = self.render(name="plain.png", scene=self.scene)
        report = self.render("--legend", "--scale-bar", "--text", "water", scene=self.scene)
        self.assertEqual(report["image_sha256"], plain["image_sha256"])
        self.assertNotEqual(self.pixels("a.png"), self.pixels("plain.png"))
        texts = read_text(self.path("a.png"))
        self.assertEqual(texts["parray:finished"], "legend, scale-bar, text")
        self.assertEqual(texts["parray:image_sha256"], plain["image_sha256"])
        self.assertNotIn("parray:finished", read_text(self.path("plain.png")))

    def test_a_legend_is_in_files_and_report_whether_it_is_drawn_or_not(self):
        self.check_legends(self.render(name="a.png")["legends"])
        self.check_legends(json.loads(read_text(self.path("a.png"))["parray:legends"]))
        self.check_legends(self.render(name="a.exr")["legends"])
        self.check_legends(json.loads(read_attributes(self.path("a.exr"))["parray:legends"]))
        self.path("bare.json").write_text(json.dumps(SCENE))
        self.assertNotIn("legends", self.render(scene=self.path("bare.json")))

    def test_the_camera_of_a_bare_file_makes_room_for_labels_and_that_of_a_scene_stays(self):
        plain = self.render("--view", "front")
        large = ["--legend", "--font-size", "20", "--view", "front"]
        self.assertNotEqual(self.render(*large)["scene_sha256"], plain["scene_sha256"])
        self.assertEqual(self.render(*large)["scene_sha256"], self.render(*large, name="b.png")["scene_sha256"])
        self.assertEqual(self.render("--legend", scene=self.scene)["scene_sha256"],
                         self.render(scene=self.scene)["scene_sha256"])

    def test_convert_writes_the_labels_and_the_camera_that_makes_room_for_them(self):
        labels = ["--legend", "--legend-title", "Atoms", "--scale-bar", "--text", "water", "--font-size", "9"]
        drawn = self.render(*labels, "--dpi", "90")
        converted = run("convert", self.atoms, self.path("l.json"), *SMALL[:4], *labels, "--dpi", "90")
        self.assertEqual(converted.returncode, 0, converted.stderr)
        self.assertEqual(json.loads(self.path("l.json").read_text())["labels"],
                         {"legend": True, "legend_title": "Atoms", "scale_bar": True, "text": "water", "font_size": 9, "dpi": 90})
        again = self.render(scene=self.path("l.json"), name="b.png")
        self.assertEqual(again["image_sha256"], drawn["image_sha256"])
        self.assertEqual(self.pixels("b.png"), self.pixels("a.png"))
        run("convert", self.atoms, self.path("wide.json"), "--width-mm", "42")
        self.assertEqual(json.loads(self.path("wide.json").read_text())["image"]["width"], 496)

    def test_convert_refuses_labels_for_which_the_scene_has_no_place(self):
        out = self.path("out.json")
        self.refused("convert", self.atoms, out, "--legend", "--expand", mentions="--legend and --expand exclude each other")
        self.refused("convert", self.atoms, out, "--cell", mentions="--cell: ")
        self.refused("convert", self.scene, out, "--legend", mentions="--legend: ")
        self.refused("convert", self.scene, out, "--transparent", "on", mentions="scene.json is not a particle file")

    def test_a_crystal_s_cell_is_left_out_of_a_picture_that_is_too_small_for_it(self):
        crystal = self.path("POSCAR")
        crystal.write_text("salt\n5.6\n1 0 0\n0 1 0\n0 0 1\nNa Cl\n1 1\nDirect\n0 0 0\n0.5 0.5 0.5\n")
        for width, finished in ((160, "cell"), (136, None), (128, None), (40, None)):
            size = ["--width", width, "--height", width * 3 // 4]
            with self.subTest(width=width):
                result = run("render", crystal, "-o", self.path("a.png"), "--spp", "1", "-q", *size)
                self.assertEqual(result.returncode, 0, result.stderr)
                self.assertEqual(run("convert", crystal, self.path("c.json"), *size).returncode, 0)
                result = run("render", self.path("c.json"), "-o", self.path("b.png"), "--spp", "1", "-q")
                self.assertEqual(result.returncode, 0, result.stderr)
                drawn, again = (read_text(self.path(name)) for name in ("a.png", "b.png"))
                self.assertEqual((drawn.get("parray:finished"), again.get("parray:finished")), (finished, finished))
                self.assertEqual(again["parray:image_sha256"], drawn["parray:image_sha256"])
        self.before = self.files()
        self.assertEqual(run("render", crystal, "-o", self.path("c.png"), "--cell", "--width", "128", "--height", "96").returncode, 2)
        self.assertEqual(self.files(), self.before)

    def test_a_title_of_the_user_names_the_legend_in_picture_and_files(self):
        self.assertEqual(self.render("--legend", "--legend-title", "Atoms")["legends"][0]["title"], "Atoms")
        titled = self.pixels("a.png")
        self.render("--legend")
        self.assertNotEqual(self.pixels("a.png"), titled)
        self.before = self.files()
        self.refused("render", self.atoms, "-o", self.path("c.png"), "--legend-title", "Atoms",
                     mentions="--legend-title has no effect without a legend: add --legend")

    def test_a_unit_and_a_size_of_letters_that_nothing_shows_are_refused(self):
        self.before = self.files()
        for name in ("c.png", "c.exr"):
            render = ["render", self.scene, "-o", self.path(name)]
            self.refused(*render, "--font-size", "20", mentions="--font-size has no effect without labels: add one")
            self.refused(*render, "--unit", "nm", mentions="--unit has no effect without a scale bar or a legend: add --scale-bar")
        self.render("--scale-bar", "--unit", "nm", "--font-size", "3")
        lengths = self.render("--color-by", "x", "--unit", "nm", scene=self.atoms, name="a.exr")["legends"]
        self.assertEqual(lengths[0]["unit"], "nm")

    def test_a_width_in_print_decides_the_pixels_and_is_in_the_file(self):
        for options, width, dpi in ((["--width-mm", "42"], 496, 300),
                                    (["--width-mm", "42", "--dpi", "150"], 248, 150),
                                    (["--width-mm", "25.4", "--width", "100"], 100, 100)):
            result = run("render", self.atoms, "-o", self.path("p.png"), "--spp", "1", "-q", *options)
            self.assertEqual(result.returncode, 0, result.stderr)
            chunks = dict(read_chunks(self.path("p.png")))
            got = struct.unpack_from(">2I", chunks[b"IHDR"])
            self.assertEqual(got[0], width)
            if "--width" not in options:
                self.assertEqual(got[1], round(width * 3 / 4))
            x, y, unit = struct.unpack(">2IB", chunks[b"pHYs"])
            self.assertEqual((x, y, unit), (round(dpi / 0.0254),) * 2 + (1,))
        self.render(name="plain.png")
        self.assertNotIn(b"pHYs", dict(read_chunks(self.path("plain.png"))))

    def test_a_scene_s_labels_are_drawn_and_options_win_over_them(self):
        scene = json.loads(self.scene.read_text())
        self.path("l.json").write_text(json.dumps({**scene, "labels": {"legend": True, "dpi": 150}}))
        self.render("--legend", "--dpi", "150", scene=self.scene, name="by-option.png")
        self.render(scene=self.path("l.json"), name="by-scene.png")
        self.assertEqual(self.pixels("by-scene.png"), self.pixels("by-option.png"))
        self.render(scene=self.scene, name="plain.png")
        self.render("--labels", "off", scene=self.path("l.json"), name="none.png")
        self.assertEqual(self.pixels("none.png"), self.pixels("plain.png"))
        self.render("--text", "more", scene=self.path("l.json"), name="more.png")
        self.assertEqual(read_text(self.path("more.png"))["parray:finished"], "legend, text")
        self.render(scene=self.path("l.json"), name="a.exr")  # nothing to draw on: no error
        result = run("convert", self.path("l.json"), self.path("copy.json"))
        self.assertEqual(result.returncode, 0, result.stderr)
        # The copy has spheres instead of the particles that a legend explains.
        self.assertEqual(json.loads(self.path("copy.json").read_text())["labels"], {"dpi": 150})
        self.render(scene=self.path("copy.json"), name="copy.png")

    def test_verify_checks_what_was_drawn_on_against_its_own_hash_and_refuses_to_trace_it(self):
        self.render("--text", "water")
        result = run("verify", self.path("a.png"))
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("pixels_sha256 matches the pixels", result.stdout)
        self.before = self.files()
        self.refused("verify", self.path("a.png"), self.atoms, mentions="text was drawn on it")

    def test_impossible_labels_are_refused_in_one_line_before_any_work(self):
        out = ["-o", self.path("a.png"), "-q"]
        render = ["render", self.atoms]
        self.refused(*render, *out, "--cell", mentions="--cell: ")
        self.refused(*render, *out, "--text", "\u4e2d", mentions="U+4E2D")
        self.refused(*render, *out, "--text", "", mentions="--text: ")
        self.refused(*render, *out, "--text", "x" * 4001, mentions="4001 bytes")
        self.refused(*render, *out, "--text", "long " * 99, mentions="does not fit")
        for option, value in (("--font-size", "0"), ("--dpi", "x"), ("--width-mm", "nan"),
                              ("--dpi", "1e9"), ("--width-mm", "-1")):
            self.refused(*render, *out, option, value, mentions=option + ": ")
        self.refused(*render, *out, "--width-mm", "5000", "--dpi", "9999", mentions="wide: at most")
        self.refused(*render, *out, "--width-mm", "85", "--dpi", "300", "--width", "500",
                     mentions="leave one of them out")
        self.refused(*render, "-o", self.path("a.exr"), "--legend", mentions="an EXR file stores")
        self.path("bare.json").write_text(json.dumps(SCENE))
        self.before = self.files()
        self.refused("render", self.path("bare.json"), *out, "--legend", mentions="--legend: the scene has no colours")
        self.refused("render", self.path("bare.json"), *out, "--time-stamp", mentions="--time-stamp: ")
        self.refused("submit", self.path("bare.json"), "--frames", "1-2", "--wait", "-o",
                     self.path("a-####.png"), "--text", "a", mentions="--text: not possible for a series of frames")

    def test_a_farm_s_picture_has_the_same_labels(self):
        self.render("--legend", "--text", "water")
        with Farm() as farm:
            farm.start_worker("one")
            result = farm.client("submit", self.atoms, "--wait", "-o", self.path("b.png"), "--legend",
                                 "--text", "water", *SMALL)
            self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(self.pixels("b.png"), self.pixels("a.png"))

    @unittest.skipIf(why_not(), why_not())
    def test_a_picture_of_parray_mpi_has_the_same_labels(self):
        self.render("--legend", "--scale-bar")
        with MpiRun(2, self.atoms, "--threads", "1", "--preview", self.path("b.png"),
                    "--legend", "--scale-bar", *SMALL) as job:
            job.finish()
        self.assertEqual(self.pixels("b.png"), self.pixels("a.png"))


if __name__ == "__main__":
    unittest.main()
