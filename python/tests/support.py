"""What the tests share: the package from its sources, the programs, a scene. Without numpy, the tests print a message and are skipped."""

import importlib.util
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

PYTHON = pathlib.Path(__file__).resolve().parents[1]
SOURCE = PYTHON.parent
BIN = pathlib.Path(os.environ.get("PARRAY_BIN_DIR", SOURCE / "build/release/bin"))
SKIPPED = 77

sys.path.insert(0, str(PYTHON / "src"))
try:
    import numpy as np
except ModuleNotFoundError:
    print("skipped: needs numpy (Debian: python3-numpy)")
    sys.exit(SKIPPED)
import parray

os.environ["PARRAY_BIN"] = str(BIN)
SMALL = {"width": 60, "height": 40, "spp": 8}
SCENE = {
    "version": 1,
    "camera": {"look_from": [0, 1, 8], "look_at": [0, 0, 0], "vfov": 30},
    "materials": {"a": {"type": "diffuse", "albedo": [0.5, 0.2, 0.1]}, "b": {"type": "dielectric", "ior": 1.5}},
    "spheres": [
        {"center": [-1, 0, 0], "radius": 1, "material": "a"},
        {"center": [1, 0, 0], "radius": 1, "material": "b"},
    ],
}


def cloud(count=40, seed=1):
    """Positions, radii, colours."""
    dice = np.random.default_rng(seed)
    return dice.normal(size=(count, 3)), dice.uniform(0.1, 0.3, count), dice.uniform(0, 1, (count, 3))


class Test(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="parray-python-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def run_module(self, *words):
        """Runs python3 -m parray in the folder of the test."""
        environment = {**os.environ, "PYTHONPATH": str(PYTHON / "src")}
        return subprocess.run([sys.executable, "-m", "parray", *map(str, words)], capture_output=True, text=True, check=False,
                              cwd=self.folder, env=environment)  # fmt: skip

    def refused(self, kind, mentions, call, *arguments, **options):
        with self.assertRaises(kind) as caught:
            call(*arguments, **options)
        self.assertIn(mentions, str(caught.exception))
        self.assertNotIn("\n", str(caught.exception))


def needs(*modules):
    """Skips a test or a class without these packages of PyPI."""
    missing = [name for name in modules if importlib.util.find_spec(name) is None]
    return unittest.skipIf(missing, f"needs {', '.join(missing)} from PyPI: see PARRAY_PACKAGES_PYTHON in packages_test.py")


def main():
    unittest.main(verbosity=1)
