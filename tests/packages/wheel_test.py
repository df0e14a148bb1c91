"""deploy/wheel: one file for pip that renders on a Debian with Python and without a compiler."""

import json
import os
import pathlib
import platform
import shutil
import subprocess
import sys
import tempfile
import unittest

from packs import BIN, SOURCE, need, output

TAG = f"manylinux_2_36_{platform.machine()}"
HELIX = SOURCE / "scenes/particles/helix.pdb"
SIZE = ["--width", "240", "--height", "160", "--spp", "4", "-q"]
FIRST = """
import parray, pathlib
program = parray.find_program()
assert pathlib.Path(parray.__file__).parent in pathlib.Path(program).parents, program
picture = parray.render([[0, 0, 0], [1, 0, 0]], 0.6, width=240, height=160, spp=4, text="two spheres")
picture.save("first.png")
"""
# Libraries that the tag leaves to the machine.
SYSTEM = {"linux-vdso", "ld-linux-x86-64", "ld-linux-aarch64", "libc", "libm", "libgcc_s", "libstdc++", "libz", "libpthread", "libresolv",
          "libdl", "librt"}


class WheelTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.directory = pathlib.Path(tempfile.mkdtemp(prefix="parray-wheel-"))
        cls.addClassCleanup(shutil.rmtree, cls.directory)
        output(sys.executable, "-m", "venv", cls.directory / "venv")
        cls.bin = cls.directory / "venv/bin"
        (cls.directory / "house").mkdir()
        # What the wheel needs: only numpy. Installing it needs no network later.
        got = subprocess.run([cls.bin / "pip", "download", "-q", "--only-binary", ":all:", "-d", cls.directory / "house", "numpy"],
                             capture_output=True, text=True)
        if got.returncode != 0:
            raise unittest.SkipTest("numpy cannot be downloaded: " + got.stderr[-300:])
        output(SOURCE / "deploy/wheel", cls.directory / "dist")
        (cls.wheel,) = (cls.directory / "dist").iterdir()

    def install(self, root, *prefix, directory):
        """Installs the wheel in a new environment in `directory` of the root, and returns its folder of programs."""
        python = sys.executable if root == pathlib.Path("/") else "/usr/bin/python3"
        output(*prefix, python, "-m", "venv", directory / "venv")
        output(*prefix, directory / "venv/bin/pip", "install", "-q", "--no-index", "--find-links", directory / "house",
               directory / "dist" / self.wheel.name)
        return directory / "venv/bin"

    def renders(self, root, *prefix, directory):
        """Checks pictures of the package and of the program in an environment without variables."""
        bare = [*prefix, "env", "-i", f"--chdir={directory}"]
        programs = self.install(root, *prefix, directory=directory)
        output(*bare, programs / "python3", "-c", FIRST)
        here = root / directory.relative_to("/")
        self.assertEqual((here / "first.png").read_bytes()[:8], b"\x89PNG\r\n\x1a\n")

        shutil.copy(HELIX, here)
        output("xz", "-kf", here / HELIX.name)
        options = [*SIZE, "--color-by", "element", "--legend"]
        output(*bare, programs / "parray", "render", HELIX.name + ".xz", *options, "-o", "helix.png", "--report", "report.json")
        there = json.loads((here / "report.json").read_text())["image_sha256"]
        output(BIN / "parray", "render", HELIX, *options, "-o", here / "here.png", "--report", here / "here.json")
        self.assertEqual(there, json.loads((here / "here.json").read_text())["image_sha256"])
        output(*bare, programs / "parray", "render", HELIX.name, *SIZE, "-o", "helix.exr")
        output(*bare, programs / "parray", "verify", "helix.exr", HELIX.name)

        refused = subprocess.run([str(part) for part in [*bare, programs / "parray", "render", HELIX.name, "-o", "helix.jpg"]],
                                 capture_output=True, text=True)
        self.assertEqual(refused.returncode, 2)
        self.assertIn('Pillow: picture.save("helix.jpg")', refused.stderr)
        for name in ("parray-worker", "parray-coordinator"):
            self.assertRegex(output(*bare, programs / name, "--version"), r"\d")


class Wheel(WheelTest):
    def test_it_has_the_tag_and_at_most_60_mb(self):
        self.assertRegex(self.wheel.name, rf"^parray-[0-9.]+-py3-none-{TAG}\.whl$")
        self.assertLessEqual(self.wheel.stat().st_size, 60_000_000)
        shown = output(SOURCE / "build/wheel/tools/bin/auditwheel", "show", self.wheel)
        self.assertIn(f'"{TAG}"', shown.replace("\n", " "))

    def test_packing_twice_makes_the_same_bytes(self):
        output(SOURCE / "deploy/wheel", self.directory / "again")
        self.assertEqual((self.directory / "again" / self.wheel.name).read_bytes(), self.wheel.read_bytes())

    def test_a_new_environment_renders_with_the_libraries_of_the_wheel(self):
        self.renders(pathlib.Path("/"), directory=self.directory)
        package = next((self.directory / "venv").glob("lib/python*/site-packages/parray"))
        for program in [*package.glob("bundled/bin/*"), *package.glob("bundled/lib/parray/*")]:
            if program.suffix == ".ttf":
                continue
            for line in output("ldd", program).splitlines():
                name, _, found = line.strip().partition(" => ")
                if pathlib.Path(name.split()[0]).name.split(".so")[0].split(".")[0] not in SYSTEM:
                    self.assertIn("/parray.libs/", os.path.normpath(found.split(" (")[0]), f"{program.name}: {line}")
        self.assertIn("Copyright", (package / "bundled/licences/libzmq5").read_text())
        self.assertFalse((package / "bundled/licences/libc6").exists())


class BareMachine(WheelTest):
    def test_it_renders_on_a_debian_without_a_compiler(self):
        need("mmdebstrap", "unshare", root=True)
        root = self.directory / "root"
        made = subprocess.run(["mmdebstrap", "--quiet", "--variant=minbase", "--include=python3,python3-venv", "bookworm", root],
                              capture_output=True, text=True)
        if made.returncode != 0:
            self.skipTest("no Debian root could be made: " + made.stderr[-300:])
        self.assertFalse(any((root / "usr/bin" / name).exists() for name in ("cc", "gcc", "g++", "ld")))
        (root / "home/user").mkdir()
        for name in ("house", "dist"):
            shutil.copytree(self.directory / name, root / "home/user" / name)
        self.renders(root, "unshare", "--mount", "--pid", "--fork", "--mount-proc", f"--root={root}",
                     directory=pathlib.Path("/home/user"))


del WheelTest

if __name__ == "__main__":
    unittest.main()
