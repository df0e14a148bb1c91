#!/usr/bin/env python3
"""parray compare: what it prints and writes about pictures, and what it refuses."""

import json
import math
import pathlib
import struct
import tempfile
import unittest
import zlib

from farm import SCENES, run

GREY = [(0.5, 0.5, 0.5)] * 12  # 4 x 3


def write_exr(path, width, height, pixels):
    """An uncompressed EXR of float32 RGB: any floats, also those that no renderer would write."""
    def attribute(name, kind, value):
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    channels = b"".join(name + b"\0" + struct.pack("<iB3xii", 2, 0, 1, 1) for name in (b"B", b"G", b"R"))
    data = (struct.pack("<ii", 20000630, 2) + attribute("channels", "chlist", channels + b"\0")
            + attribute("compression", "compression", b"\0")
            + attribute("dataWindow", "box2i", window) + attribute("displayWindow", "box2i", window)
            + attribute("lineOrder", "lineOrder", b"\0")
            + attribute("pixelAspectRatio", "float", struct.pack("<f", 1))
            + attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0))
            + attribute("screenWindowWidth", "float", struct.pack("<f", 1)) + b"\0")
    line = width * 12
    first = len(data) + 8 * height
    data += b"".join(struct.pack("<Q", first + y * (line + 8)) for y in range(height))
    for y in range(height):
        row = pixels[y * width:(y + 1) * width]
        data += struct.pack("<ii", y, line)
        data += b"".join(struct.pack("<f", pixel[c]) for c in (2, 1, 0) for pixel in row)
    path.write_bytes(data)


def write_png(path, width, height, pixels):
    """8-bit RGB."""
    def chunk(kind, value):
        return (struct.pack(">I", len(value)) + kind + value
                + struct.pack(">I", zlib.crc32(kind + value)))
    rows = b"".join(b"\0" + bytes(v for pixel in pixels[y * width:(y + 1) * width] for v in pixel)
                    for y in range(height))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0))
                     + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


class Compare(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix="parray-compare-")
        self.addCleanup(temporary.cleanup)
        self.directory = pathlib.Path(temporary.name)
        self.reference = self.exr("ref.exr", GREY)

    def path(self, name):
        return self.directory / name

    def exr(self, name, pixels, width=4):
        write_exr(self.path(name), width, len(pixels) // width, pixels)
        return self.path(name)

    def compared(self, *arguments, warnings=""):
        result = run("compare", *arguments, "--json")
        self.assertEqual((result.returncode, result.stderr), (1 if warnings else 0, warnings))
        return json.loads(result.stdout)

    def text(self, *arguments, warnings=""):
        result = run("compare", *arguments)
        self.assertEqual((result.returncode, result.stderr), (1 if warnings else 0, warnings))
        return result.stdout

    def left_out(self, image, count, here, there, both):
        return (f"parray: warning: {image}: {count} left out, because not finite: {here} in this picture, "
                f"{there} in the reference, {both} in both\n")

    def refused(self, *arguments, mentions):
        before = {path: path.read_bytes() for path in self.directory.iterdir() if path.is_file()}
        result = run("compare", *arguments)
        self.assertEqual((result.returncode, result.stdout), (2, ""), arguments)
        self.assertRegex(result.stderr, r"\Aparray: [^\n]*\n\Z")
        for part in mentions:
            self.assertIn(str(part), result.stderr)
        after = {path: path.read_bytes() for path in self.directory.iterdir() if path.is_file()}
        self.assertEqual(before, after)

    def test_the_numbers_are_those_of_the_formulas(self):
        pixels = list(GREY)
        pixels[6] = (0.75, 0.5, 0.25)  # x 2, y 1
        pixels[9] = (0.5, 1.0, 0.5)    # x 1, y 2
        facts = self.compared(self.reference, self.exr("a.exr", pixels))
        one = facts["images"][0]
        errors = [0.25, -0.25, 0.5]
        self.assertAlmostEqual(one["mse"], sum(e * e for e in errors) / 36)
        self.assertAlmostEqual(one["rmse"], math.sqrt(one["mse"]))
        self.assertAlmostEqual(one["psnr"], -10 * math.log10(one["mse"]))
        self.assertAlmostEqual(one["relmse"], one["mse"] / 0.26)
        self.assertAlmostEqual(one["smape"], (0.25 / 1.26 + 0.25 / 0.76 + 0.5 / 1.51) / 36)
        self.assertAlmostEqual(one["mae"], 1 / 36)
        self.assertAlmostEqual(one["bias"], 0.5 / 36)
        self.assertEqual((one["p999"], one["max"], one["x"], one["y"]), (0.5, 0.5, 1, 2))
        self.assertTrue(0 < one["flip"] < 1 and 0 < one["hdr_flip"] < 1)
        self.assertGreaterEqual(one["hdr_flip_exposures"]["count"], 2)
        self.assertFalse(one["identical"])
        self.assertEqual((one["nonfinite_pixels"], one["excluded_pixels"]), (0, 0))
        self.assertEqual((facts["reference"]["width"], facts["reference"]["height"]), (4, 3))
        self.assertIn("R^2 + 0.01", facts["formulas"]["relmse"])
        self.assertEqual(facts["verification_picture"], {"file": None, "largest": 0.5})
        for name in facts["formulas"]:
            self.assertIn(name, one)

    def test_a_table_has_a_row_for_each_image_and_fits_100_columns(self):
        images = [self.exr(f"{'long' * 20}-{i}.exr", [(0.5 + 1e-3 * i, 0.5, -1e-5)] * 12)
                  for i in range(3)]
        self.exr("same.exr", GREY)
        text = self.text(self.reference, *images, self.path("same.exr"))
        lines = text.splitlines()
        for line in lines[1:]:  # the first names the reference, however long its name
            self.assertLessEqual(len(line), 100, line)
        for i in range(3):
            self.assertEqual(sum(f"long-{i}.exr" in line for line in lines), 2)
        self.assertRegex(text, r"same\.exr +0 +0 +inf +0 +0 +0 +0\n")
        self.assertRegex(text, r"same\.exr +0 +0 +0,0 +0\.0000 +0\.0000 +yes\n")
        self.assertIn("0.01", text)

    def test_identical_means_every_bit(self):
        self.exr("zero.exr", [(0, 0, 0)] * 12)
        self.exr("minus-zero.exr", [(-0.0, 0, 0)] * 12)
        self.exr("nan.exr", [(math.nan, 0, 0)] * 12)
        same = self.compared(self.path("nan.exr"), self.path("nan.exr"), warnings=self.left_out(
            self.path("nan.exr"), "12 pixels", 12, 12, 12))["images"][0]
        self.assertTrue(same["identical"])
        self.assertIsNone(same["mse"])
        zeros = self.compared(self.path("zero.exr"), self.path("zero.exr"), self.path("minus-zero.exr"))
        self.assertEqual([one["identical"] for one in zeros["images"]], [True, False])
        self.assertEqual([one["mse"] for one in zeros["images"]], [0, 0])
        self.assertEqual([one["psnr"] for one in zeros["images"]], [None, None])

    def test_pixels_that_are_not_finite_are_left_out_with_a_warning_and_status_1(self):
        pixels = list(GREY)
        pixels[0] = (math.nan, 0.5, 0.5)
        pixels[5] = (0.5, math.inf, 0.5)
        pixels[11] = (0.5, 0.5, 0.25)
        reference = list(GREY)
        reference[5] = (-math.inf, 0, 0)
        image = self.exr("a.exr", pixels)
        warning = self.left_out(image, "2 pixels", 2, 1, 1)
        facts = self.compared(self.exr("r.exr", reference), image, warnings=warning)
        one = facts["images"][0]
        self.assertEqual(facts["reference"]["nonfinite_pixels"], 1)
        self.assertEqual((one["nonfinite_pixels"], one["excluded_pixels"]), (2, 2))
        self.assertAlmostEqual(one["mse"], 0.0625 / 30)
        self.assertEqual((one["x"], one["y"]), (3, 2))
        for name in ("flip", "hdr_flip"):
            self.assertTrue(0 < one[name] < 1)
        self.text(self.path("r.exr"), image, warnings=warning)
        nothing = self.exr("nothing.exr", [(math.inf, 0, 0)] * 12)
        warning = self.left_out(nothing, "12 pixels", 12, 0, 0)
        one = self.compared(self.reference, nothing, warnings=warning)["images"][0]
        for name in ("mse", "bias", "max", "x", "y", "flip", "hdr_flip"):
            self.assertIsNone(one[name], name)
        self.assertRegex(self.text(self.reference, nothing, warnings=warning), r"nothing\.exr +nan +nan +- ")

    def test_a_png_is_compared_in_linear_values_and_has_no_hdr_flip(self):
        srgb = lambda v: v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4
        write_png(self.path("a.png"), 4, 3, [(188, 0, 255)] * 12)
        exact = self.exr("a.exr", [(srgb(188 / 255), 0, 1)] * 12)
        one = self.compared(exact, self.path("a.png"))["images"][0]
        self.assertLess(one["max"], 1e-7)
        self.assertLess(one["flip"], 1e-3)
        self.assertIsNone(one["hdr_flip"])
        self.assertIsNone(one["hdr_flip_exposures"])
        one = self.compared(self.path("a.png"), self.path("a.png"))["images"][0]
        self.assertTrue(one["identical"])
        self.assertIsNone(one["hdr_flip"])
        self.assertIn("n/a", self.text(self.path("a.png"), exact))

    def test_a_render_is_identified_by_its_image_sha256_in_every_file_format(self):
        options = ["-q", "--width", "60", "--height", "40", "--spp", "4"]
        for name in ("a.exr", "a.png", "b.exr"):
            seed = ["--seed", "99"] if name == "b.exr" else []
            result = run("render", SCENES / "glass.json", "-o", self.path(name), *options, *seed)
            self.assertEqual(result.returncode, 0, result.stderr)
        arguments = [self.path("a.exr"), self.path("a.png"), self.path("b.exr"), self.path("a.exr")]
        facts = self.compared(*arguments)
        hashes = [one["image_sha256"] for one in facts["images"]]
        sha256 = facts["reference"]["image_sha256"]
        self.assertRegex(sha256, r"\A[0-9a-f]{64}\Z")
        self.assertEqual([h == sha256 for h in hashes], [True, False, True])
        self.assertEqual([one["identical"] for one in facts["images"]], [False, False, True])
        text = self.text(*arguments)
        self.assertIn("a.png: has the image_sha256 of", text)
        self.assertEqual(text.count("come from the same traced picture"), 1)
        self.assertIsNone(self.compared(self.reference, self.reference)["reference"]["image_sha256"])

    def test_the_verification_picture_is_white_minus_all_differences(self):
        first = self.exr("a.exr", [(0.75, 0.5, 0.5)] * 12)
        second = self.exr("b.exr", [(0.25, 0.5, 0.375)] + [(0.5, 0.5, 3)] * 11)
        expected = self.exr("expected.exr", [(0.5, 1, 0.875)] + [(0.75, 1, 0)] * 11)
        facts = self.compared(self.reference, first, second, "-o", self.path("v.exr"))
        self.assertEqual(facts["verification_picture"], {"file": str(self.path("v.exr")), "largest": 2.5})
        self.assertTrue(self.compared(expected, self.path("v.exr"))["images"][0]["identical"])
        text = self.text(self.reference, first, second, "-o", self.path("v.png"))
        self.assertIn("over 2 images; largest V 2.5\n", text)
        self.assertLess(self.compared(expected, self.path("v.png"))["images"][0]["max"], 0.005)
        self.compared(self.reference, self.reference, "-o", self.path("white.exr"))
        white = self.exr("white-expected.exr", [(1, 1, 1)] * 12)
        self.assertTrue(self.compared(white, self.path("white.exr"))["images"][0]["identical"])

    def test_pictures_that_cannot_be_compared_are_refused_in_one_line_and_nothing_is_written(self):
        wide = self.exr("wide.exr", GREY, width=6)
        output = ["-o", self.path("v.png")]
        self.refused(self.reference, self.reference, wide, *output,
                     mentions=[wide, "6 x 2", self.reference, "4 x 3"])
        self.refused(self.reference, self.path("none.exr"), *output,
                     mentions=["none.exr: no such file"])
        self.refused(self.path("none.png"), self.reference, *output,
                     mentions=["none.png: no such file"])
        self.refused(self.reference, "", *output, mentions=["IMAGE: the value is empty"])
        self.path("text.exr").write_text("not a picture")
        self.refused(self.reference, self.path("text.exr"), *output, mentions=["text.exr: "])
        cut = self.path("cut.exr")
        cut.write_bytes(self.reference.read_bytes()[:-40])
        self.refused(self.reference, cut, *output, mentions=["cut.exr: "])
        self.path("folder.exr").mkdir()
        self.refused(self.reference, self.path("folder.exr"), *output, mentions=["folder.exr: is a directory"])

    def test_a_png_that_is_cut_off_or_damaged_is_one_line(self):
        """image_file_test.cpp does it at every byte."""
        whole = self.path("whole.png")
        write_png(whole, 4, 3, [(10 * i, 200, 3 * i) for i in range(12)])
        data = whole.read_bytes()
        self.assertTrue(self.compared(whole, whole)["images"][0]["identical"])
        cut = self.path("cut.png")
        for length in (41, len(data) - 13):  # in the pixels, before the end
            cut.write_bytes(data[:length])
            self.refused(whole, cut, mentions=["cut.png: the PNG file is truncated"])
        for place in (17, 50):  # in the header, in the pixels
            cut.write_bytes(data[:place] + bytes([data[place] ^ 4]) + data[place + 1:])
            self.refused(whole, cut, mentions=["cut.png: the PNG file is "])

    def test_a_verification_picture_of_an_impossible_size_is_refused_before_the_comparison(self):
        result = run("compare", self.reference, self.directory / "none.exr", "-o", self.path("v.jp2"))
        self.assertEqual(result.returncode, 2)
        self.assertIn("v.jp2: JPEG 2000 needs a width and a height of at least 32 pixels", result.stderr)

    def test_an_output_is_checked_before_the_pictures_are_read(self):
        missing = self.path("none.exr")
        self.refused(missing, missing, "-o", self.path("v.gif"), mentions=["'.gif'"])
        self.refused(missing, missing, "-o", self.path("none/v.png"), mentions=["does not exist"])
        self.refused(missing, missing, "-o", "", mentions=["--output"])
        for inputs in ([self.reference, missing], [missing, self.reference]):
            self.refused(*inputs, "-o", self.reference,
                         mentions=[self.reference, "is an input file: name another output file"])

    def test_a_reference_without_another_picture_is_refused(self):
        self.refused(mentions=["REF", "`parray compare --help`"])
        self.refused(self.reference, mentions=["IMAGE", "`parray compare --help`"])


if __name__ == "__main__":
    unittest.main()
