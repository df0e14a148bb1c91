"""What a picture is and becomes: arrays, PNG, EXR and NPY files, HTML; particles as files."""

import base64
import json
import re
import struct
import subprocess
import sys
import zlib

from support import BIN, SCENE, SMALL, SOURCE, Test, cloud, main, np, parray

from parray.exr import read_exr
from parray.srgb import png_bytes, srgb_bytes


class Arrays(Test):
    @classmethod
    def setUpClass(cls):
        cls.picture = parray.render(*cloud(), **SMALL, aov="sphere")

    def test_numpy_takes_a_picture_for_its_pixels(self):
        picture = self.picture
        self.assertIs(np.asarray(picture), picture.pixels)
        self.assertEqual(np.asarray(picture, np.float64).dtype, np.float64)
        self.assertIsNot(np.array(picture), picture.pixels)
        self.assertEqual(picture.shape, np.shape(picture))
        self.assertAlmostEqual(np.mean(picture), picture.pixels.mean(), 5)
        self.assertRegex(repr(picture), r"<Picture 60 x 40, error 0\.\d+ \(0\.\d+ to 0\.\d+\)>")

    def test_the_error_is_that_of_the_report(self):
        error = self.picture.report["error"]
        self.assertEqual(self.picture.error, (error["rmse"], error["low"], error["high"]))
        self.assertIsNone(parray.render(SCENE, width=9, height=9, spp=1).error)

    def test_saved_files_are_what_the_command_line_writes(self):
        """The same floats, the same 8-bit values, and a recipe that `verify` accepts."""
        (self.folder / "scene.json").write_text(json.dumps(SCENE))
        picture = parray.render(self.folder / "scene.json", width=600, height=400, spp=2)
        for name in ("a.exr", "a.png", "a.npy"):
            picture.save(self.folder / name)
        for name in ("b.exr", "b.png"):
            subprocess.run([BIN / "parray", "render", self.folder / "scene.json", "--width", "600", "--height", "400",
                            "--spp", "2", "-q", "-o", self.folder / name], check=True, stdout=subprocess.DEVNULL)
        for kind in ("exr", "png"):
            a, b = (self.folder / f"{name}.{kind}" for name in "ab")
            said = subprocess.run([BIN / "parray", "compare", b, a, "--json"], capture_output=True, check=True).stdout
            self.assertTrue(json.loads(said)["images"][0]["identical"], said)
            said = subprocess.run([BIN / "parray", "verify", a, self.folder / "scene.json"], capture_output=True,
                                  text=True, check=False)
            self.assertEqual(said.returncode, 0, said.stderr + said.stdout)
        self.assertTrue(np.array_equal(np.load(self.folder / "a.npy"), picture))
        self.refused(parray.InputError, "unknown extension", picture.save, self.folder / "a.svg")

    def test_a_notebook_shows_the_png(self):
        html = self.picture._repr_html_()
        image = base64.b64decode(re.search(r'src="data:image/png;base64,([^"]+)"', html)[1])
        self.assertEqual(image, self.picture._repr_png_())
        self.assertEqual(image[:8], b"\x89PNG\r\n\x1a\n")
        self.assertIn("error 0.0", html)


class Files(Test):
    def test_channels_are_those_of_an_independent_reader(self):
        sys.path.insert(0, str(SOURCE / "tests/integration"))
        import exr
        picture = parray.render(*cloud(), width=37, height=21, spp=2, aov="sphere,depth,normal")
        picture.save(self.folder / "a.exr")
        values, letters = exr.read_exr(self.folder / "a.exr")
        found, attributes = read_exr((self.folder / "a.exr").read_bytes())
        self.assertEqual(set(found), set(values))
        for name, channel in found.items():
            self.assertEqual(channel.dtype.kind, {"I": "u", "f": "f"}[letters[name]])
            self.assertTrue(np.array_equal(channel.ravel(), np.array(values[name], channel.dtype)), name)
        expected = exr.read_attributes(self.folder / "a.exr")
        self.assertEqual({name: attributes[name] for name in expected}, expected)

    def test_files_that_are_not_compressed_are_read(self):
        """Previews are not."""
        preview = self.folder / "preview.exr"
        subprocess.run([BIN / "parray", "render", SOURCE / "scenes/shells.json", "--width", "64", "--height", "33", "--spp",
                        "20", "-q", "-o", self.folder / "a.exr", "--time-limit", "0.01"], check=True, capture_output=True)
        subprocess.run([BIN / "parray", "render", SOURCE / "scenes/shells.json", "--width", "64", "--height", "33", "--spp",
                        "20", "-q", "-o", self.folder / "a.png", "--preview", preview], check=True, capture_output=True)
        for file in (self.folder / "a.exr", preview):
            channels, _ = read_exr(file.read_bytes())
            self.assertEqual(channels["R"].shape, (33, 64))

    def test_what_is_no_exr_of_ours_is_a_value_error_wherever_it_ends(self):
        parray.render(SCENE, width=20, height=20, spp=1).save(self.folder / "a.exr")
        data = (self.folder / "a.exr").read_bytes()
        for end in [*range(0, len(data) - 1, 7), len(data) - 1]:
            with self.assertRaises(ValueError):
                read_exr(data[:end])
        with self.assertRaisesRegex(ValueError, "tiles"):
            read_exr(data[:5] + b"\x02" + data[6:])

    def test_every_8_bit_value_and_text_comes_back_from_a_png(self):
        pixels = np.arange(7 * 256 * 3, dtype=np.uint32).astype(np.uint8).reshape(7, 256, 3)
        data = png_bytes(pixels, {"key": "\u00e4 text"})
        chunks, at = {}, 8
        while at < len(data):
            size, kind = struct.unpack_from(">I4s", data, at)
            body = data[at + 8 : at + 8 + size]
            self.assertEqual(struct.unpack_from(">I", data, at + 8 + size)[0], zlib.crc32(kind + body))
            chunks[kind] = body
            at += size + 12
        rows = np.frombuffer(zlib.decompress(chunks[b"IDAT"]), np.uint8).reshape(7, 1 + 3 * 256)
        self.assertTrue((rows[:, 0] == 1).all())
        self.assertTrue(np.array_equal(np.cumsum(rows[:, 1:].reshape(7, 256, 3), 1, np.uint8), pixels))
        self.assertEqual(chunks[b"iTXt"], b"key\0\0\0\0\0" + "\u00e4 text".encode())
        self.assertEqual(struct.unpack(">II", chunks[b"IHDR"][:8]), (256, 7))

    def test_srgb_and_linear_are_inverse(self):
        codes = np.arange(256, dtype=np.uint8)
        self.assertTrue(np.array_equal(srgb_bytes(parray.srgb_to_linear(codes / 255)), codes))
        self.assertEqual(srgb_bytes([np.nan, -1, 2, np.inf, -np.inf]).tolist(), [0, 0, 255, 255, 0])


class ParticleFiles(Test):
    def facts(self, particles):
        """What `parray` reads from the file."""
        path = particles.write(self.folder)
        out = self.folder / "out.json"
        subprocess.run([BIN / "parray", "convert", path, out, "--expand"], check=True, capture_output=True)
        scene = json.loads(out.read_text())
        spheres = scene["spheres"][2:]  # after ground and flag
        return ([s["center"] for s in spheres], [s["radius"] for s in spheres],
                [scene["materials"][s["material"]]["albedo"] for s in spheres])

    def test_numbers_come_back_as_they_were(self):
        positions, radii, colors = cloud(50)
        positions[0] = [1e-14, 1 / 3, -123456.789]
        for elements in (None, ["C"] * 50):
            found = self.facts(parray.Particles(positions, radii, colors, elements))
            for was, came in zip((positions, radii, colors), found):
                self.assertEqual(was.tolist(), came)

    def test_8_bit_colours_are_srgb(self):
        positions, _, _ = cloud(4)
        colors = np.array([[0, 128, 255], [1, 2, 3], [255, 255, 255], [77, 88, 99]], np.uint8)
        for elements in (None, ["C"] * 4):
            _, _, found = self.facts(parray.Particles(positions, 0.1, colors, elements))
            np.testing.assert_allclose(found, parray.srgb_to_linear(colors / 255), rtol=1e-14)

    def test_one_value_stands_for_all(self):
        positions, _, _ = cloud(4)
        _, radii, colors = self.facts(parray.Particles(positions, 0.25, [0.1, 0.2, 0.3]))
        self.assertEqual((radii, colors), ([0.25] * 4, [[0.1, 0.2, 0.3]] * 4))

    def test_any_layout_and_type_of_array_is_taken(self):
        positions = np.asfortranarray(cloud(6)[0].astype(np.float32))[::-2]
        for given in (positions, positions.tolist(), positions.astype(">f8")):
            self.assertEqual(self.facts(parray.Particles(given, 1))[0], positions.astype(float).tolist())
        self.assertEqual(self.facts(parray.Particles([[1, 2, 3]], 1))[0], [[1, 2, 3]])

    def test_names_that_are_no_elements_do_not_break_the_file(self):
        names = ["C", "", " x y ", "\u00e4", "0", "Xx"]
        _, radii, _ = self.facts(parray.Particles(cloud(6)[0], elements=names))
        self.assertEqual(len(radii), 6)
        self.assertEqual(len(set(radii[1:])), 1)


if __name__ == "__main__":
    main()
