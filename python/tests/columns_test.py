"""Columns of arrays and tables, colours by arrays, frames and views, further formats of pictures, and the command line.

Needs only numpy and the program.
"""

import importlib.util
import io
import re
import subprocess
import sys
import unittest.mock
import warnings
import zlib

from support import BIN, SMALL, SOURCE, Test, cloud, main, np, parray

HELIX = SOURCE / "scenes/particles/helix.pdb"
LARGE = {"width": 300, "height": 200, "spp": 2}


def legend_of(picture):
    return picture.report["legends"][0]


def without(*names):
    """Makes packages seem to be missing."""
    found = importlib.util.find_spec
    return unittest.mock.patch("importlib.util.find_spec", lambda name: None if name in names else found(name))


class ColorsByArrays(Test):
    def setUp(self):
        super().setUp()
        self.positions, self.radii, _ = cloud()
        self.numbers = self.positions[:, 0] ** 2

    def test_an_array_a_list_and_values_are_one_column(self):
        for options in ({"color_by": self.numbers}, {"color_by": self.numbers.tolist()}, {"values": self.numbers}):
            picture = parray.render(self.positions, self.radii, colormap="magma", **options, **SMALL)
            legend = legend_of(picture)
            self.assertEqual((legend["title"], legend["high"]), ("value", self.numbers.max()))
        self.refused(TypeError, "give one of them", parray.render, self.positions, color_by="z", values=self.numbers)

    def test_an_array_colours_like_the_column_of_a_file(self):
        table = np.column_stack([self.positions, self.radii, self.numbers])
        np.savetxt(self.folder / "a.csv", table, "%.17g", ",", header="x,y,z,radius,speed", comments="")
        of_file = parray.render(self.folder / "a.csv", color_by="speed", range=(0, 2), **SMALL)
        of_array = parray.render(self.positions, self.radii, color_by=self.numbers, range=(0, 2), **SMALL)
        self.assertEqual(of_array.report["scene_sha256"], of_file.report["scene_sha256"])

    def test_representations_give_parts_their_own_look(self):
        shows = ["all", {"select": "z > 0", "color_by": "z", "radius_by": "z:0.5:1"}]
        picture = parray.render(self.positions, self.radii, show=shows, select="x < 100", **SMALL)
        self.assertEqual([legend["title"] for legend in picture.report["legends"]], ["z"])
        self.refused(TypeError, "has no selection", parray.render, HELIX, show=[{"radius": 1}])
        self.refused(parray.InputError, "--radius-by excludes --radius", parray.render, HELIX,
                     show=[{"select": "all", "radius": 1, "radius_by": "z"}])  # fmt: skip

    def test_an_unknown_number_has_a_colour_of_its_own(self):
        self.numbers[3] = np.nan
        with self.assertWarnsRegex(parray.ParRayWarning, r"^parray: particles\.ply: 1 particle without a known value"):
            parray.render(self.positions, self.radii, color_by=self.numbers, **SMALL)

    def test_texts_are_categories(self):
        picture = parray.render(self.positions, self.radii, color_by=["solid", "melt"] * 20, **SMALL)
        self.assertEqual([entry["name"] for entry in legend_of(picture)["entries"]], ["melt", "solid"])

    def test_truth_values_are_categories_and_dates_are_refused(self):
        picture = parray.render(self.positions, self.radii, color_by=self.positions[:, 0] > 0, **SMALL)
        self.assertEqual([entry["name"] for entry in legend_of(picture)["entries"]], ["false", "true"])
        dates = np.full(40, "2026-01-01", "datetime64[D]")
        self.refused(parray.InputError, "not numbers or texts", parray.render, self.positions, color_by=dates)

    def test_arrays_of_another_length_and_arrays_for_files_are_refused(self):
        self.refused(parray.InputError, "shape (3,)", parray.render, self.positions, color_by=[1, 2, 3], **SMALL)
        self.refused(parray.InputError, "name a column of the file", parray.render, HELIX, color_by=[1, 2], **SMALL)
        self.refused(parray.InputError, "the numbers as color_by", parray.render, self.positions, 1, self.numbers, **SMALL)

    def test_words_of_matplotlib_name_the_option(self):
        for word, option in (("cmap", "colormap"), ("c", "color_by"), ("vmin", "range"), ("color", "colors")):
            self.refused(TypeError, f"did you mean {option}", parray.render, self.positions, **{word: 1})


class TitleOfTheLegend(Test):
    def test_the_title_is_on_the_picture(self):
        """The option of the program."""
        known = subprocess.run([BIN / "parray", "help", "render", "--all"], capture_output=True, text=True, check=True)
        if "--legend-title" not in known.stdout:
            self.skipTest("needs a program with --legend-title")
        positions, radii, _ = cloud()
        options = {"color_by": radii, "legend": True, **LARGE}
        fixed = {**options, "camera": {"look_from": (0, 0, 9), "look_at": (0, 0, 0)}}
        plain, titled = (parray.render(positions, radii, **fixed, **o) for o in ({}, {"legend_title": "Speed (m/s)"}))
        self.assertEqual(plain.pixels.tobytes(), titled.pixels.tobytes())
        plain, titled = (parray.render(positions, radii, **options, **o) for o in ({}, {"legend_title": "Speed (m/s)"}))
        self.assertNotEqual(plain._repr_png_(), titled._repr_png_())
        phases = np.array([("a", *p) for p in positions], [("Phase", "U1"), ("x", float), ("y", float), ("z", float)])
        titles = ({}, {"legend_title": "Phase"})
        own, same = (parray.render(phases, radii, color_by="Phase", legend=True, **LARGE, **title) for title in titles)
        self.assertEqual(own._repr_png_(), same._repr_png_())
        options = {"color_by": "Phase", "legend": True}
        (call,) = parray.several.calls_of([phases], radii, None, options, parray.program._TOOLS)
        self.assertEqual(call.options["legend_title"], "Phase")


class NamesOfColors(Test):
    def test_names_are_the_colours_of_css_and_matplotlib(self):
        positions, radii, _ = cloud(2)
        for names, codes in (("red", [255, 0, 0]), ("tab:blue", [31, 119, 180]), ("#0a0B0c", [10, 11, 12]),
                             (["teal", "Orange"], [[0, 128, 128], [255, 165, 0]])):  # fmt: skip
            found = parray.Particles(positions, radii, names).colors
            expected = np.broadcast_to(parray.srgb_to_linear(np.array(codes) / 255), (2, 3))
            np.testing.assert_allclose(found, expected, rtol=1e-14)

    def test_without_matplotlib_the_known_names_are_said(self):
        with without("matplotlib"):
            self.refused(parray.InputError, "matplotlib knows more names", parray.render, *cloud(2)[:2], "rebeccapurple")

    def test_one_colour_for_a_file_is_its_material(self):
        material = {"type": "diffuse", "albedo": parray.srgb_to_linear([31 / 255, 119 / 255, 180 / 255])}
        blue, same = (parray.render(HELIX, **SMALL, **o) for o in ({"colors": "tab:blue"}, {"material": material}))
        self.assertEqual(blue.report["scene_sha256"], same.report["scene_sha256"])


class Columns(Test):
    def test_elements_by_numbers_are_not_types(self):
        for elements in ([1, 1], ["1", "1"]):
            picture = parray.render([[0, 0, 0], [0, 0, 0.7]], elements=elements, color_by="element", **SMALL)
            self.assertEqual(legend_of(picture)["entries"][0]["name"], "H")

    def test_residues_cell_and_numbers_reach_the_program(self):
        particles = parray.Particles(
            [[0, 0, 0], [3, 0, 0], [0, 3, 0]], elements=["N", "C", "O"],
            numbers={"resid": [7, 7, 9], "b factor": [1, 2, 3], "force": [[1, 0, 0], [0, 3, 4], [0, 0, 0]]},
            texts={"name": ["N", "CA", "O"], "resname": ["ALA", "ALA", "HOH"], "chain": ["A", "A", ""],
                   "phase": ["x", "y", "y"]},
            cell=np.diag([5, 6, 7]), origin=(1, 1, 1), time=2.5)  # fmt: skip
        for by, low in (("resid", 7), ("b factor", 1), ("force", 0), ("force_y", 0), ("force.y", 0)):
            self.assertEqual(legend_of(parray.render(particles, color_by=by, **SMALL))["low"], low)
        for by, names in (("chain", ["A", "no name"]), ("atom", ["CA", "N", "O"]), ("phase", ["x", "y"]),
                          ("residue", ["aliphatic", "water"])):  # fmt: skip
            entries = legend_of(parray.render(particles, color_by=by, **SMALL))["entries"]
            self.assertEqual([entry["name"] for entry in entries], names)
        with self.assertWarns(parray.ParRayWarning):
            protein = parray.render(particles, select="protein", cell=True, time_stamp=True, **LARGE)
        self.assertEqual(protein.report["spheres"], 2 + 2)
        in_scene = {"version": 1, "camera": {"look_from": [9, 9, 9], "look_at": [0, 0, 0], "vfov": 20},
                    "particles": [{"file": particles, "select": "resid 9"}]}  # fmt: skip
        self.assertEqual(parray.render(in_scene, **SMALL).report["spheres"], 1)

    def test_a_scale_bar_is_in_angstrom_only_for_atoms(self):
        options = {"scale_bar": True, "view": "front", **LARGE}
        atoms, other = ({"elements": ["C", "O"]}, {"texts": {"type": ["gas", "stars"]}})
        for columns, unit in ((atoms, "angstrom"), (other, " "), ({**other, "unit": "kpc"}, "kpc"),
                              ({"unit": "angstrom"}, "angstrom")):  # fmt: skip
            particles = parray.Particles([[0, 0, 0], [30, 0, 9]], [5, 5], **columns)
            plain, named = (parray.render(particles, **options, **o) for o in ({}, {"unit": unit}))
            self.assertEqual(plain._repr_png_(), named._repr_png_())
            (frame,) = parray.render([particles], **options)
            self.assertEqual(frame.srgb().shape, plain.srgb().shape)
        for elements, check in ((None, self.assertNotEqual), (["C", "O"], self.assertEqual)):
            first, angstrom = (
                parray.render([[0, 0, 0], [30, 0, 9]], 5, elements=elements, unit=unit, **options) for unit in (None, "angstrom")
            )
            check(first._repr_png_(), angstrom._repr_png_())

    def test_numbers_that_particles_with_names_lack_are_refused(self):
        particles = parray.Particles([[0, 0, 0]], numbers={"resid": [1]})
        self.refused(parray.InputError, "charge: the particles have no charge", parray.render, particles, color_by="charge")
        self.refused(parray.InputError, "mass: the particles", parray.render, particles, select="x > 0 and Mass > 1")

    def test_a_structured_array_is_a_table(self):
        positions, radii, _ = cloud()
        table = np.zeros(40, [(name, float) for name in ("X", "Y", "Z [nm]", "diameter", "speed")] + [("kind", "U1")])
        for name, values in zip(table.dtype.names, (*positions.T, 2 * radii, radii)):
            table[name] = values
        table["kind"] = ["a", "b"] * 20
        picture = parray.render(table, color_by="speed", **SMALL)
        expected = parray.render(positions, radii, color_by=radii, **SMALL)
        self.assertEqual(picture.report["scene_sha256"], expected.report["scene_sha256"])
        self.assertEqual(len(legend_of(parray.render(table, color_by="kind", **SMALL))["entries"]), 2)
        self.refused(parray.InputError, "no columns x, y and z: it has speed", parray.render, table[["speed", "kind"]])

    def test_stars_stand_where_ra_dec_and_parallax_say(self):
        table = np.array([(0, 0, 10.0), (90, 0, 5.0), (0, 90, -1.0)], [("ra", float), ("dec", float), ("parallax", float)])
        found = parray.tables.particles_of_table(table)
        np.testing.assert_allclose(found.positions, [[100, 0, 0], [0, 200, 0]], atol=1e-12)

    def test_of_many_numbers_only_those_that_are_mentioned_are_written(self):
        columns = {name: np.zeros(300_000) for name in ("heat", "mass", "age", "speed")}
        particles = parray.Particles(np.zeros((300_000, 3)), numbers=columns)
        self.assertIn(b"property double age\n", particles.write(self.folder).read_bytes()[:400])
        header = particles.write(self.folder, "--color-by Speed").read_bytes()[:400]
        self.assertIn(b"property double speed\n", header)
        self.assertNotIn(b"property double age\n", header)


class Several(Test):
    def setUp(self):
        super().setUp()
        self.positions, self.radii, _ = cloud()

    def test_frames_share_camera_light_and_colours(self):
        """The first frame does not contain the others."""
        frames = [self.positions, 3 * self.positions]
        for source in (frames, np.stack(frames), iter(frames)):
            pictures = parray.render(source, 0.2, color_by="z", aov="depth", **SMALL)
            self.assertEqual([legend_of(p)["high"] for p in pictures], [3 * self.positions[:, 2].max()] * 2)
        alone = parray.render(frames[0], 0.2, color_by="z", aov="depth", **SMALL)
        ground = [p.channels["Z"][-1, 0] for p in pictures]
        self.assertEqual(ground[0], ground[1])
        self.assertNotEqual(alone.channels["Z"][-1, 0], ground[0])

    def test_a_category_has_one_colour_in_all_frames(self):
        """Also if a frame lacks another."""
        kinds = [["a", "b"] * 20, ["b", "c"] * 20, ["c"] * 40]
        for select, count in (("all", 40), ("x > 0", (self.positions[:, 0] > 0).sum())):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                pictures = parray.render([self.positions] * 3, 0.2, color_by=kinds, select=select, **SMALL)
            entries = [{e["name"]: tuple(e["color"]) for e in legend_of(p)["entries"]} for p in pictures]
            self.assertEqual([set(e) for e in entries], [set(k) for k in kinds])
            self.assertEqual(len(set().union(*(e.items() for e in entries))), 3)
            self.assertEqual([p.report["spheres"] - 2 for p in pictures], [count] * 3)

    def test_arrays_of_each_frame_are_its_colours(self):
        numbers = [self.radii, 2 * self.radii]
        pictures = parray.render([self.positions] * 2, 0.2, color_by=numbers, **SMALL)
        self.assertEqual([legend_of(p)["high"] for p in pictures], [2 * self.radii.max()] * 2)
        self.assertNotEqual(*(p.report["scene_sha256"] for p in pictures))

    def test_hidden_particles_do_not_widen_the_range(self):
        frames = [self.positions, 2 * self.positions]
        lines = [f"{len(f)}\n\n" + "".join(f"C {x} {y} {z}\n" for x, y, z in f) for f in frames]
        (self.folder / "run.xyz").write_text("".join(lines))
        below = max(f[f[:, 2] < 0.5][:, 2].max() for f in frames)
        for source, options in ((frames, {}), (self.folder / "run.xyz", {"frames": "all"})):
            with self.assertWarnsRegex(parray.ParRayWarning, "not selected") as caught:
                pictures = parray.render(source, 0.2, color_by="z", select="z < 0.5", **options, **SMALL)
            self.assertEqual([legend_of(p)["high"] for p in pictures], [below] * 2)
            self.assertEqual(caught.filename, __file__)

    def test_frames_of_a_file_share_camera_and_colours(self):
        lines = ["2\n\nC 0 0 0\nC 2 0 0\n", "2\n\nC 0 0 1\nC 2 0 5\n", "2\n\nC 0 0 1\nC 2 0 2\n"]
        (self.folder / "run.xyz").write_text("".join(lines))
        for frames, count in ((range(0, 3, 2), 2), ("all", 3)):
            pictures = parray.render(self.folder / "run.xyz", frames=frames, color_by="z", view="front", **SMALL)
            self.assertEqual(len(pictures), count)
            self.assertEqual({legend_of(p)["high"] for p in pictures}, {2 if count == 2 else 5})
        for by, high in (("index", 1), ("fz", 1)):
            pictures_of_by = parray.render(self.folder / "run.xyz", frames="all", color_by=by, view="front", **SMALL)
            self.assertEqual({legend_of(p)["high"] for p in pictures_of_by}, {high})
        first = parray.render(self.folder / "run.xyz", frame=0, color_by="z", range=(0, 5), view="front", **SMALL)
        self.assertEqual(first.report["image_sha256"], pictures[0].report["image_sha256"])

    def test_parts_of_frames_have_the_range_of_their_selection_in_all_frames(self):
        lines = [f"3\nProperties=species:S:1:pos:R:3:speed:R:1\nC 0 0 0 {low}\nC 2 0 1 {high}\nO 0 2 0 90\n"
                 for low, high in ((3, 4), (1, 2), (5, 7))]  # fmt: skip
        (self.folder / "run.xyz").write_text("".join(lines))
        places = [[[0, 0, 0], [2, 0, 1], [0, 2, 0]]] * 3
        speeds = ((3, 4, 90), (1, 2, 90), (5, 7, 90))
        objects = [parray.Particles(at, 1, elements=["C", "C", "O"], numbers={"speed": v}) for at, v in zip(places, speeds)]
        shows = [{"select": "element C", "color_by": "speed"}, {"select": "element O", "color_by": "element"}]
        for source, frames in ((self.folder / "run.xyz", "all"), (objects, None)):
            for more in ({}, {"select": "index < 3"}, {"color_by": "x"}, {"material": {"type": "metal", "albedo": [0.9] * 3}}):
                pictures = parray.render(source, frames=frames, show=shows, **more, **SMALL)
                legends = [next(item for item in p.report["legends"] if item["title"] == "speed") for p in pictures]
                self.assertEqual([(item["low"], item["high"]) for item in legends], [(1, 7)] * 3)
        chosen = [{**shows[0], "range": (0, 9)}, shows[1]]
        self.assertEqual({legend_of(p)["high"] for p in parray.render(objects, show=chosen, **SMALL)}, {9})
        percent = [{**shows[0], "range": "1%:99%"}]
        self.refused(parray.InputError, "give two numbers", parray.render, objects, show=percent, **SMALL)

    def test_what_several_frames_exclude_is_said(self):
        frames = [self.positions] * 2
        for options, text in (({"frame": 1, "frames": [0]}, "give one of them"),
                              ({"range": "1%:99%", "color_by": "z"}, "give two numbers"),
                              ({"views": "top"}, "call render() for each frame"), ({"color_by": "speed"}, "a frame has no speed")):  # fmt: skip
            self.refused(parray.InputError, text, parray.render, frames, 0.2, **options, **SMALL)
        for chosen, text in (([], "there are no frames"), (3, "is not a list of numbers"), ("last", "is not a list")):
            self.refused(parray.InputError, text, parray.render, HELIX, frames=chosen, **SMALL)
        self.refused(parray.InputError, "has 2 frames", parray.render, frames, frames=[2], **SMALL)
        for mixed in ([HELIX, parray.Particles([[0, 0, 0]])], [parray.Particles([[0, 0, 0]]), HELIX]):
            self.refused(parray.InputError, "are mixed", parray.render, mixed, **SMALL)

    def test_views_are_a_list_of_pictures(self):
        pictures = parray.render(self.positions, 0.2, views="front, iso", **SMALL)
        expected = [parray.render(self.positions, 0.2, view=view, **SMALL) for view in ("front", "iso")]
        self.assertEqual([p.report["image_sha256"] for p in pictures], [p.report["image_sha256"] for p in expected])
        self.refused(parray.InputError, "views: cannot be combined", parray.render, HELIX, views=["top"], view="top")

    def test_pictures_are_shown_and_saved_together(self):
        pictures = parray.render(self.positions, 0.2, views="front,iso", **SMALL)
        self.assertEqual(pictures._repr_html_().count("data:image/png;base64,"), 2)
        pictures.save(self.folder / "view-##.png")
        self.assertEqual((self.folder / "view-01.png").read_bytes(), pictures[1]._repr_png_())
        self.refused(parray.InputError, "view-####.png", pictures.save, "view.png")

    def test_a_logarithmic_scale_of_frames_begins_at_the_least_number_above_0(self):
        frames = [np.array([[-1, 0, 0], [2, 0, 0], [4, 1, 0.0]]), np.array([[0, 0, 0], [3, 0, 0], [8, 1, 0.0]])]
        lines = [f"{len(f)}\n\n" + "".join(f"C {x} {y} {z}\n" for x, y, z in f) for f in frames]
        (self.folder / "run.xyz").write_text("".join(lines))
        for source, options in ((frames, {}), (self.folder / "run.xyz", {"frames": "all"})):
            with self.assertWarnsRegex(parray.ParRayWarning, "without a positive x"):
                pictures = parray.render(source, 0.2, color_by="x", color_scale="log", **options, **SMALL)
            self.assertEqual([(legend_of(p)["low"], legend_of(p)["high"]) for p in pictures], [(2, 8)] * 2)

    def test_numbers_as_categories_of_frames_are_refused_with_a_remedy(self):
        with self.assertRaisesRegex(parray.InputError, "^color_scale: .*give an array of texts"):
            parray.render([self.positions] * 2, 0.2, color_by="x", color_scale="categories", **SMALL)

    def test_the_range_of_a_fraction_of_the_cell_is_not_that_of_forces_with_its_name(self):
        frame = ("ITEM: TIMESTEP\n{}\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp pp\n0 4\n0 4\n0 4\n"
                 "ITEM: ATOMS id type x y z fx fy fz\n1 1 1 1 1 50 0 0\n2 1 2 3 3 -30 1 0\n")  # fmt: skip
        (self.folder / "run.dump").write_text(frame.format(0) + frame.format(1))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            pictures = parray.render(self.folder / "run.dump", 0.2, color_by="fx", frames="all", **SMALL)
        self.assertEqual([(legend_of(p)["low"], legend_of(p)["high"]) for p in pictures], [(0.25, 0.5)] * 2)

    def test_an_angle_of_view_or_a_height_fits_any_view(self):
        """With an angle of view alone, the camera moves so that the picture contains the same."""
        options = {"view": "iso", "style": "flat", "transparent": True, **LARGE}
        covered = [parray.render(self.positions, 0.2, camera={"vfov": angle}, **options).report["transparent"]["covered"]
                   for angle in (20, 10, 2)]  # fmt: skip
        np.testing.assert_allclose(covered, covered[0], rtol=0.1)
        for view in ("iso", "auto"):
            parray.render(self.positions, 0.2, camera={"view_height": 9}, **{**options, "view": view})


class OtherPictures(Test):
    def setUp(self):
        super().setUp()
        self.picture = parray.render(*cloud(), text="labelled", width_mm=30, spp=2)

    def test_a_pdf_has_the_pixels_of_the_png_in_the_size_of_print(self):
        self.picture.save(self.folder / "a.pdf")
        pdf = (self.folder / "a.pdf").read_bytes()
        height, width, _ = self.picture.shape
        self.assertAlmostEqual(float(re.search(rb"/MediaBox \[0 0 (\S+)", pdf)[1]), width * 72 / 300, places=1)
        data = pdf[pdf.rindex(b" >> stream\n") + 11 : pdf.rindex(b"\nendstream")]
        self.assertEqual(len(zlib.decompress(data)), height * (3 * width + 1))
        start = int(re.search(rb"startxref\n(\d+)\n", pdf)[1])
        self.assertTrue(pdf[start:].startswith(b"xref\n0 6\n"))
        for number, place in enumerate(re.findall(rb"(\d{10}) 00000 n", pdf), 1):
            self.assertTrue(pdf[int(place) :].startswith(b"%d 0 obj" % number))
        transparent = parray.render(*cloud(), transparent=True, **SMALL)
        self.refused(parray.InputError, "only opaque pictures", transparent.save, self.folder / "a.pdf")

    def test_without_pillow_the_error_names_it(self):
        with without("PIL"):
            self.refused(parray.InputError, "pip install pillow", self.picture.save, self.folder / "a.jpg")

    @unittest.skipIf(importlib.util.find_spec("PIL") is None, "needs Pillow")
    def test_pillow_writes_jpeg_and_tiff_in_the_size_of_print(self):
        from PIL import Image

        pixels = np.asarray(Image.open(io.BytesIO(self.picture._repr_png_())).convert("RGB"), float)
        for name, allowed in (("a.jpg", 4), ("a.tif", 0)):
            self.picture.save(self.folder / name)
            with Image.open(self.folder / name) as again:
                self.assertLessEqual(np.abs(np.asarray(again, float) - pixels).mean(), allowed)
                self.assertAlmostEqual(float(again.info["dpi"][0]), 300, delta=1)
        transparent = parray.render(*cloud(), transparent=True, **SMALL)
        self.refused(parray.InputError, "JPEG has no transparency", transparent.save, self.folder / "b.jpg")


class CommandLine(Test):
    def test_arrays_of_numpy_are_rendered_with_the_options_of_the_program(self):
        positions, radii, _ = cloud()
        np.savez(self.folder / "a.npz", positions=positions, radius=radii, speed=radii, kind=["a", "b"] * 20)
        for by in ("speed", "kind"):
            done = self.run_module("render", "-q", "a.npz", "-o", "a.png", "--color-by", by, "--spp", 2)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertTrue((self.folder / "a.png").exists())

    def test_other_files_and_commands_go_to_the_program(self):
        for words in (("render", HELIX, "-o", "a.png", "--width", 0), ("render", "none.xyz", "-o", "a.png"), ("doktor",),
                      ("--version",)):  # fmt: skip
            own = subprocess.run([BIN / "parray", *map(str, words)], capture_output=True, text=True, check=False,
                                 cwd=self.folder)  # fmt: skip
            done = self.run_module(*words)
            self.assertEqual((done.returncode, done.stderr, done.stdout), (own.returncode, own.stderr, own.stdout))

    def test_bad_files_and_missing_packages_are_one_line(self):
        (self.folder / "a.npz").write_bytes(b"PK\3\4 and no more")
        (self.folder / "snapshot.hdf5").write_bytes(b"\x89HDF\r\n\x1a\n and no more")
        for name, text in (("a.npz", "numpy cannot read this file"), ("snapshot.hdf5", "h5py")):
            done = self.run_module("render", name, "-o", "a.png")
            self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1), done.stderr)
            self.assertIn(text, done.stderr)
        with without("h5py"):
            self.refused(parray.InputError, "pip install h5py", parray.render, self.folder / "snapshot.hdf5")


if __name__ == "__main__":
    main()
