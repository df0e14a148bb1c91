#!/usr/bin/env python3
"""The recipe of each shipped picture renders the same bits again."""

import importlib.machinery
import importlib.util
import pathlib
import tempfile
import unittest

from farm import SCENES, run
from png import read_text

_loader = importlib.machinery.SourceFileLoader("renew", str(SCENES / "pictures" / "renew"))
renew = importlib.util.module_from_spec(importlib.util.spec_from_loader("renew", _loader))
_loader.exec_module(renew)

QUICK = "glass"  # takes the least time
WITHOUT_RECIPE = {"helix-views"}  # several renders in one file


class PicturesTest(unittest.TestCase):
    def check_again(self, names):
        with tempfile.TemporaryDirectory() as directory:
            for name in names:
                with self.subTest(picture=name):
                    self.check_one(name, pathlib.Path(directory))

    def check_one(self, name, directory):
        shipped = SCENES / "pictures" / f"{name}.png"
        again = directory / f"{name}.png"
        shown = [str(directory / word) if word.endswith(".png") else word for word in renew.PICTURES[name][1]]
        result = run("render", renew.scene_of(name, directory), *shown, "--like", shipped, "-o", again, "-q", timeout=1800)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        for hash_of in ("image_sha256", "pixels_sha256"):
            self.assertEqual(read_text(again)["parray:" + hash_of], read_text(shipped)["parray:" + hash_of])


class Quick(PicturesTest):
    def test_the_recipe_of_one_picture_renders_it_again(self):
        self.check_again([QUICK])

    def test_every_picture_with_a_recipe_is_renewed_by_the_script(self):
        with_recipe = {path.stem for path in (SCENES / "pictures").glob("*.png")
                       if "parray:image_sha256" in read_text(path)}
        self.assertEqual(with_recipe, set(renew.PICTURES) - WITHOUT_RECIPE)


class Long(PicturesTest):
    def test_all_other_recipes_render_their_pictures_again(self):
        self.check_again(sorted(set(renew.PICTURES) - WITHOUT_RECIPE - {QUICK}))


if __name__ == "__main__":
    unittest.main()
