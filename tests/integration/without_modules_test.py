#!/usr/bin/env python3
"""A program whose folder lib/parray lacks OpenImageIO's module, or has a font, as in Python's wheel."""

import shutil
import subprocess
import unittest

from cli_usage_test import CliTest
from farm import BIN, SCENES

HELIX = SCENES / "particles" / "helix.pdb"
SMALL = ["--width", "20", "--height", "15", "--spp", "1", "-q"]


class WithoutModules(CliTest):
    def setUp(self):
        super().setUp()
        self.modules = self.path("lib") / "parray"
        self.modules.mkdir(parents=True)
        shutil.copy(BIN.parent / "lib/parray/exr_codec.so", self.modules)
        self.path("bin").mkdir()
        self.program = shutil.copy(BIN / "parray", self.path("bin"))

    def run_program(self, *arguments):
        return subprocess.run([self.program, *arguments], capture_output=True, text=True, check=False)

    def refusal(self, *arguments, status=2):
        result = self.run_program(*arguments)
        self.assertEqual(result.returncode, status, result.stderr)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        return result.stderr

    def test_pictures_that_need_openimageio_are_refused_before_tracing_and_the_message_names_pillow(self):
        for name in ("a.jpg", "a.tif", "a.jp2"):
            said = self.refusal("render", HELIX, "-o", self.path(name))
            self.assertIn(f"{name}: this ParRay has no OpenImageIO, which writes such pictures: use .png or .exr", said)
            self.assertIn(f'Pillow: picture.save("{name}")', said)
            self.assertFalse(self.path(name).exists())

    def test_an_exr_picture_without_its_module_is_refused_before_tracing(self):
        (self.modules / "exr_codec.so").unlink()
        said = self.refusal("render", HELIX, *SMALL, "-o", self.path("a.exr"), "--preview", self.path("p.png"), status=1)
        self.assertIn("loading the module that reads and writes EXR pictures: ", said)
        self.assertIn(": install ParRay and OpenEXR again", said)
        self.assertFalse(self.path("p.png").exists())

    def test_other_pictures_are_written_and_read(self):
        for name in ("a.png", "a.exr"):
            result = self.run_program("render", HELIX, *SMALL, "-o", self.path(name))
            self.assertEqual(result.returncode, 0, result.stderr)
        result = self.run_program("compare", self.path("a.exr"), self.path("a.exr"))
        self.assertEqual(result.returncode, 0, result.stderr)

    def test_reading_other_pictures_is_refused_with_a_remedy(self):
        self.path("a.jpg").write_bytes(b"\xff\xd8\xff\xe0 JFIF")
        said = self.refusal("compare", self.path("a.jpg"), self.path("a.jpg"))
        self.assertIn("a.jpg: is neither EXR nor PNG, and this ParRay has no OpenImageIO", said)
        self.assertIn("convert it to .png", said)

    def test_doctor_says_that_openimageio_is_missing_and_does_not_fail(self):
        result = self.run_program("doctor")
        self.assertIn("OpenImageIO none", result.stdout, result.stderr)
        self.assertNotIn("failed   libraries", result.stdout)

    def test_labels_take_the_font_beside_the_modules(self):
        (self.modules / "DejaVuSans.ttf").write_text("not a font")
        said = self.refusal("render", HELIX, *SMALL, "--text", "hello", "-o", self.path("a.png"), status=1)
        self.assertIn(f"{self.modules}/DejaVuSans.ttf: the font of labels cannot be read", said)


if __name__ == "__main__":
    unittest.main()
