#!/usr/bin/env python3
"""scenes/gallery/make writes a scene with its particles, which renders."""

import json
import pathlib
import subprocess
import tempfile
import unittest

import jsonschema
from farm import BIN, SCENES, SOURCE


class Gallery(unittest.TestCase):
    def test_a_scene_of_the_gallery_fits_the_schema_and_renders(self):
        with tempfile.TemporaryDirectory() as directory:
            directory = pathlib.Path(directory)
            done = subprocess.run([SOURCE / "scenes" / "gallery" / "make", "crystal", "-o", directory, "--width", "60",
                                   "--error", "0.1", "--parray", BIN / "parray"], capture_output=True, text=True, timeout=300)
            self.assertEqual(done.returncode, 0, done.stderr)
            scene = json.loads((directory / "crystal.json").read_text())
            jsonschema.Draft7Validator(json.loads((SCENES / "schema" / "scene.v1.schema.json").read_text())).validate(scene)
            self.assertIn("72594 spheres", done.stdout)
            self.assertIn("60 x 40 pixels", done.stdout)


if __name__ == "__main__":
    unittest.main()
