"""The same source makes the same bytes, and the tarball runs where there is a C library and nothing else."""

import hashlib
import json
import pathlib
import shutil
import tempfile
import unittest

from packs import BIN, BUILD, SOURCE, need, output, pack


def different(first, second):
    """What is not the same in two packages: names of members, by their contents."""
    parts = []
    for file in (first, second):
        with tempfile.TemporaryDirectory() as directory:
            output("dpkg-deb" if file.suffix == ".deb" else "tar", *(
                ["--raw-extract", file, directory] if file.suffix == ".deb" else ["-xzf", file, "-C", directory]))
            parts.append({str(path.relative_to(directory)): (path.lstat().st_mode, int(path.lstat().st_mtime),
                          path.is_file() and hashlib.sha256(path.read_bytes()).hexdigest())
                          for path in pathlib.Path(directory).rglob("*")})
    return sorted(name for name in parts[0].keys() | parts[1].keys() if parts[0].get(name) != parts[1].get(name))


class Scratch(unittest.TestCase):
    def setUp(self):
        self.directory = pathlib.Path(tempfile.mkdtemp(prefix="parray-bytes-"))
        self.addCleanup(shutil.rmtree, self.directory)


class SameBytes(Scratch):
    def test_packing_twice_makes_the_same_packages(self):
        first = pack("DEB", self.directory / "here")
        second = pack("DEB", self.directory / "somewhere" / "else")
        self.assertEqual(list(first), list(second))
        for name, file in first.items():
            self.assertTrue(file.read_bytes() == second[name].read_bytes(), f"{name}: {different(file, second[name])}")

    def test_programs_do_not_tell_where_they_were_built(self):
        for program in [*BIN.glob("parray*"), *(BUILD / "lib/parray").iterdir()]:
            content = program.read_bytes()
            for place in (SOURCE, BUILD):
                self.assertNotIn(bytes(place), content, program.name)


class Tarball(Scratch):
    def bare_root(self):
        """A C library and nothing else: not even a shell."""
        root = self.directory / "root"
        for name in ("ld-linux", "libc", "libm", "libdl", "libpthread", "librt", "libresolv", "libmvec", "libnss_files"):
            for file in pathlib.Path("/lib").glob(f"*-linux-gnu/{name}*.so.*"):
                target = root / file.relative_to("/")
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(file, target)
        for loader in pathlib.Path("/lib64").glob("ld-linux*"):
            (root / "lib64").mkdir(exist_ok=True)
            shutil.copy(loader, root / "lib64")
        (root / "proc").mkdir()
        (root / "tmp").mkdir(mode=0o777)
        (root / "home").mkdir()
        return root

    def test_it_renders_where_there_is_only_a_c_library(self):
        need("unshare", root=True)
        if (BIN / "parray").read_bytes()[18] != 62:  # bare_root() knows this machine's names
            self.skipTest("not x86-64")
        packed = pack("TGZ", self.directory / "packed")
        self.assertEqual(len(packed), 1)
        tarball = next(iter(packed.values()))
        root = self.bare_root()
        output("tar", "-xzf", tarball, "-C", root / "home")
        home = next((root / "home").iterdir())
        self.assertRegex(home.name, r"^parray-[0-9.]+-linux-\w+$")
        for package in ("libzmq5", "fonts-dejavu-core"):
            self.assertTrue((home / "share/doc/parray/licences" / package).read_text())
        (root / "tmp").chmod(0o777)

        def run(program, *arguments):
            return output("unshare", "--mount", "--pid", "--fork", "--mount-proc", f"--root={root}", "--setgid=65534",
                          "--setuid=65534", f"/home/{home.name}/bin/{program}", *arguments)

        self.assertRegex(run("parray-worker", "--version"), r"\d")
        self.assertRegex(run("parray-coordinator", "--version"), r"\d")
        scene = f"/home/{home.name}/share/parray/scenes/one-weekend-8.json"
        options = ["--width", "48", "--height", "32", "--spp", "4"]
        run("parray", "render", scene, *options, "-o", "/tmp/picture.exr", "--report", "/tmp/report.json")
        run("parray", "verify", "/tmp/picture.exr", scene)  # reads it, by the module of pictures
        run("parray", "render", scene, "--width", "240", "--height", "160", "--spp", "1", "--text", "spheres", "-o", "/tmp/text.png")
        there = json.loads((root / "tmp/report.json").read_text())["image_sha256"]
        output(BIN / "parray", "render", SOURCE / "scenes/one-weekend-8.json", *options, "-o", self.directory / "here.exr",
               "--report", self.directory / "here.json")
        self.assertEqual(there, json.loads((self.directory / "here.json").read_text())["image_sha256"])


del Scratch

if __name__ == "__main__":
    unittest.main()
