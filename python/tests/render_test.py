"""parray.render() on this machine, with the real program."""

import asyncio
import contextlib
import doctest
import hashlib
import json
import os
import pathlib
import pty
import re
import signal
import subprocess
import sys
import threading
import unittest.mock

from support import BIN, SCENE, SMALL, SOURCE, Test, cloud, main, np, parray

HELIX = SOURCE / "scenes/particles/helix.pdb"
LONG = {"width": 400, "height": 300, "spp": 100000}


def command_line(*arguments):
    return subprocess.run([BIN / "parray", *map(str, arguments)], capture_output=True, text=True, check=False)


class Bits(Test):
    def test_the_array_has_the_hash_that_the_report_states(self):
        picture = parray.render(*cloud(), **SMALL)
        self.assertEqual((picture.pixels.dtype, picture.pixels.shape), (np.float32, (40, 60, 3)))
        digest = hashlib.sha256(picture.pixels.astype("<f4").tobytes()).hexdigest()
        self.assertEqual(digest, picture.report["image_sha256"])
        self.assertEqual(digest, picture.recipe["parray:image_sha256"])

    def test_files_and_scenes_have_the_bits_of_the_command_line(self):
        (self.folder / "scene.json").write_text(json.dumps(SCENE))
        for file, source in ((HELIX, HELIX), (HELIX, str(HELIX)), (self.folder / "scene.json", SCENE),
                             (self.folder / "scene.json", self.folder / "scene.json")):
            with self.subTest(source=source):
                report = self.folder / "report.json"
                done = command_line("render", file, "-o", self.folder / "a.exr", "--report", report, "--width", 60,
                                    "--height", 40, "--spp", 8)
                self.assertEqual(done.returncode, 0, done.stderr)
                expected = json.loads(report.read_text())["image_sha256"]
                self.assertEqual(parray.render(source, **SMALL).report["image_sha256"], expected)

    def test_arrays_are_the_spheres_of_the_scene_to_the_last_bit(self):
        """In double precision, as the same numbers in a scene file."""
        positions, radii, colors = cloud()
        materials = {str(i): {"type": "diffuse", "albedo": color.tolist()} for i, color in enumerate(colors)}
        spheres = [{"center": p.tolist(), "radius": r, "material": str(i)}
                   for i, (p, r) in enumerate(zip(positions, radii.tolist()))]
        scene = {**SCENE, "materials": materials, "spheres": spheres}
        named = {**SCENE, "materials": {}, "spheres": [],
                 "particles": [{"file": parray.Particles(positions, radii, colors)}]}
        first, second = (parray.render(s, precision="f64", **SMALL) for s in (scene, named))
        self.assertEqual(first.report["scene_sha256"], second.report["scene_sha256"])
        self.assertEqual(first.report["image_sha256"], second.report["image_sha256"])

    def test_elements_have_the_bits_of_the_file_that_names_them(self):
        lines = (SOURCE / "scenes/particles/caffeine.xyz").read_text().split("\n")[2:]
        rows = [line.split() for line in lines if line.strip()]
        positions = [[float(x) for x in row[1:4]] for row in rows]
        expected = parray.render(SOURCE / "scenes/particles/caffeine.xyz", **SMALL).report["image_sha256"]
        numbers = {"H": 1, "C": 6, "N": 7, "O": 8}
        for elements in ([row[0] for row in rows], np.array([numbers[row[0]] for row in rows])):
            self.assertEqual(parray.render(positions, elements=elements, **SMALL).report["image_sha256"], expected)

    def test_like_makes_the_same_picture_again(self):
        first = parray.render(*cloud(), **SMALL, seed=5)
        first.save(self.folder / "first.exr")
        again = parray.render(*cloud(), like=self.folder / "first.exr")
        self.assertTrue(np.array_equal(first, again))


class Options(Test):
    def test_names_are_those_of_the_command_line(self):
        picture = parray.render(SCENE, width=30, height=20, target_error=0.05, max_depth=7, seed=3,
                                sampler="independent", precision="f64", adaptive=False, isa="scalar", threads=1)
        for name, value in {"width": 30, "target_error": 0.05, "max_depth": 7, "seed": 3, "sampler": "independent",
                            "precision": "f64", "adaptive": False, "isa": "scalar", "threads": 1,
                            "stopped_by": "error"}.items():
            self.assertEqual(picture.report[name], value, name)
        self.assertLessEqual(picture.error.high, 0.05)
        again = parray.render(SCENE, width=30, height=20, max_depth=7, seed=3, sampler="independent",
                              precision="f64", passes=picture.report["passes"])
        self.assertEqual(again.report["image_sha256"], picture.report["image_sha256"])

    def test_every_option_of_render_has_a_keyword(self):
        """But for those that say where files go, which the package does itself, and --radius, which is `radii`."""
        text = command_line("help", "render", "--all").stdout
        options = set(re.findall(r"(?m)^  (?:-\w, )?(--[a-z-]+)", text))
        own = {"--help", "--output", "--report", "--quiet", "--progress", "--preview", "--display", "--on-end", "--error-map",
               "--radius", "--legend-title"}
        names = {"--" + name.replace("_", "-") for name in parray.options.names_of(parray.options.RenderOptions)}
        self.assertEqual(options - own, names - {"--elements", "--camera", "--sky", "--values", "--frames", "--legend-title"})

    def test_an_unknown_keyword_names_the_nearest(self):
        self.refused(TypeError, "unknown option 'widht': did you mean width?", parray.render, SCENE, widht=3)
        self.refused(TypeError, "no_labels is now labels=False", parray.render, SCENE, no_labels=True)
        self.refused(TypeError, "opaque is now transparent=False", parray.render, SCENE, opaque=True)

    def test_camera_and_sky_replace_members_of_a_scene(self):
        changed = {**SCENE, "camera": {**SCENE["camera"], "vfov": 50}, "sky": {"zenith": [1, 0, 0]}}
        expected = parray.render(changed, **SMALL).report["image_sha256"]
        found = parray.render(SCENE, camera={"vfov": 50}, sky={"zenith": np.array([1, 0, 0])}, **SMALL)
        self.assertEqual(found.report["image_sha256"], expected)
        (self.folder / "scene.json").write_text(json.dumps(SCENE))
        found = parray.render(self.folder / "scene.json", camera={"vfov": 50}, sky={"zenith": (1, 0, 0)}, **SMALL)
        self.assertEqual(found.report["image_sha256"], expected)

    def test_another_projection_replaces_the_angle_of_view(self):
        parallel = {"projection": "orthographic", "view_height": 3.0}
        camera = {**SCENE["camera"], **parallel}
        del camera["vfov"]
        expected = parray.render({**SCENE, "camera": camera}, **SMALL).report["image_sha256"]
        self.assertEqual(parray.render(SCENE, camera=parallel, **SMALL).report["image_sha256"], expected)

    def test_a_transparent_picture_has_alpha(self):
        picture = parray.render(SCENE, transparent=True, **SMALL)
        self.assertEqual(picture.report["transparent"]["covered"] > 0, True)
        self.assertEqual(float(picture.channels["A"].max()), 1)
        self.assertNotIn("A", parray.render(SCENE, transparent=False, **SMALL).channels)
        transparent = {**SCENE, "image": {**SCENE.get("image", {}), "transparent": True}}
        self.assertIn("A", parray.render(transparent, **SMALL).channels)
        self.assertNotIn("A", parray.render(transparent, transparent=False, **SMALL).channels)

    def test_an_automatic_scene_with_another_camera_or_material_is_framed_for_its_size(self):
        positions, radii, _ = cloud()
        size = {"width": 30, "height": 60, "spp": 4, "precision": "f64"}
        plain = parray.render(positions, radii, **size)
        for same in ({"camera": {}}, {"material": "plain"}, {"sky": {}}):
            self.assertEqual(parray.render(positions, radii, **size, **same).report["image_sha256"],
                             plain.report["image_sha256"], same)
        gold = {"type": "metal", "albedo": [0.8, 0.6, 0.2], "fuzz": 0.1}
        metal = parray.render(positions, radii, material=gold, **size)
        self.assertIn("metal", metal.report["features"])
        self.assertEqual(metal.report["spheres"], plain.report["spheres"])

    def test_a_frame_of_a_file_is_that_frame(self):
        frames = ["2\n\nC 0 0 0\nC 2 0 0\n", "2\n\nC 0 0 0\nC 0 3 0\n"]
        (self.folder / "both.xyz").write_text("".join(frames))
        camera = {"look_from": [0, 0, 20], "look_at": [0, 0, 0], "vfov": 30, "up": [0, 1, 0]}
        first, second = (parray.render(self.folder / "both.xyz", frame=i, camera=camera, **SMALL) for i in (0, 1))
        self.assertNotEqual(first.report["scene_sha256"], second.report["scene_sha256"])
        self.refused(parray.InputError, "no frame 2", parray.render, self.folder / "both.xyz", frame=2, **SMALL)
        self.refused(parray.InputError, "has only one frame", parray.render, np.zeros((1, 3)), frame=2)

    def test_particles_are_chosen_coloured_and_seen_as_by_the_command_line(self):
        file = self.folder / "table.csv"
        file.write_text("x,y,z,speed\n" + "".join(f"{i % 4},{i // 4},{i * 0.3},{i * i}\n" for i in range(16)))
        for options, words in (({"color_by": "speed", "colormap": "magma", "range": (0, 100)},
                                ["--color-by", "speed", "--colormap", "magma", "--range", "0:100"]),
                               ({"select": "x > 0", "slice": ["y=0:2", "z=0:3"]}, ["--select", "x > 0", "--slice", "y=0:2,z=0:3"]),
                               ({"view": "top", "style": "night", "projection": "perspective"},
                                ["--view", "top", "--style", "night", "--projection", "perspective"]),
                               ({"style": ("flat", "sticks"), "arrows": "speed,speed,speed", "arrow_scale": 0.1},
                                ["--style", "flat,sticks", "--arrows", "speed,speed,speed", "--arrow-scale", 0.1]),
                               ({"radii": 0.3, "frame": 0, "hide": ["virtual"]},
                                ["--radius", 0.3, "--frame", 0, "--hide", "virtual"])):
            with self.subTest(options=options):
                report = self.folder / "report.json"
                done = command_line("render", file, "-o", self.folder / "a.png", "--report", report, "--width", 60,
                                    "--height", 40, "--spp", 8, *words)
                self.assertEqual(done.returncode, 0, done.stderr)
                picture = parray.render(file, **options, **SMALL)
                self.assertEqual(picture.report["image_sha256"], json.loads(report.read_text())["image_sha256"])
        self.refused(parray.InputError, "unknown view 'frnt': did you mean 'front'", parray.render, file, view="frnt")
        self.refused(parray.InputError, "view, style: these options are for particles", parray.render, SCENE, view="top", style="flat")

    def test_arrays_are_chosen_and_coloured_like_files(self):
        positions, radii, _ = cloud()
        plain, part = (parray.render(positions, radii, **SMALL, **o) for o in ({}, {"select": "x > 0", "color_by": "z"}))
        self.assertLess(part.report["spheres"], plain.report["spheres"])
        self.assertEqual(part.report["legends"][0]["title"], "z")

    def test_a_topology_beside_a_scene_of_its_own_is_found(self):
        """The automatic scene is in another folder than its files."""
        (self.folder / "names.pdb").write_bytes(HELIX.read_bytes())
        (self.folder / "atoms.pdb").write_bytes(HELIX.read_bytes())
        here = os.getcwd()
        self.addCleanup(os.chdir, here)
        os.chdir(self.folder)
        picture = parray.render("atoms.pdb", topology="names.pdb", color_by="element", **SMALL)
        self.assertEqual(picture.report["legends"][0]["entries"][0]["name"], "C")

    def test_labels_and_outlines_are_on_the_png_as_the_command_line_draws_it(self):
        size = {"width": 360, "height": 240, "spp": 4}
        words = ["--width", 360, "--height", 240, "--spp", 4]
        for options, more in (({"legend": True, "scale_bar": True, "text": "helix", "outline": True, "dpi": 100.0},
                               ["--legend", "--scale-bar", "--text", "helix", "--outline", "on", "--dpi", 100]),
                              ({"style": "publication"}, ["--style", "publication"])):
            with self.subTest(options=options):
                done = command_line("render", HELIX, "-o", self.folder / "a.png", *words, *more)
                self.assertEqual(done.returncode, 0, done.stderr)
                picture = parray.render(HELIX, **options, **size)
                picture.save(self.folder / "b.png")
                self.assertEqual(*((self.folder / name).read_bytes() for name in ("a.png", "b.png")))
                digest = hashlib.sha256(picture.pixels.astype("<f4").tobytes()).hexdigest()
                self.assertEqual(digest, picture.report["image_sha256"])
        self.refused(parray.InputError, "--legend", parray.render, SCENE, legend=True, **SMALL)
        for options in ({"legend": True}, {"dpi": 300}):
            said = f"aov: a picture with {next(iter(options))} has no extra channels: render the channels in another call"
            self.refused(parray.InputError, said, parray.render, HELIX, aov="depth", **options, **size)

    def test_denoised_pixels_state_their_own_error(self):
        raw = parray.render(SCENE, width=60, height=40, spp=16)
        picture = parray.render(SCENE, width=60, height=40, spp=16, denoise=True)
        self.assertLess(picture.error.rmse, raw.error.rmse)
        self.assertEqual(picture.error.rmse, picture.report["denoised"]["rmse"])
        digest = hashlib.sha256(picture.pixels.astype("<f4").tobytes()).hexdigest()
        self.assertEqual(digest, picture.report["denoised"]["image_sha256"])
        self.assertTrue(np.array_equal(np.stack([picture.channels["raw." + c] for c in "RGB"], -1), raw))

    def test_extra_channels_are_arrays_by_name(self):
        picture = parray.render(*cloud(), aov=["depth", "sphere", "normal"], **SMALL)
        self.assertEqual(set(picture.channels), {"Z", "sphere", "N.X", "N.Y", "N.Z"})
        self.assertEqual((picture.channels["Z"].dtype, picture.channels["sphere"].dtype), (np.float32, np.uint32))
        self.assertEqual(picture.channels["Z"].shape, (40, 60))


class Errors(Test):
    def test_bad_input_has_the_text_of_the_command_line(self):
        (self.folder / "bad.json").write_text("{")
        for source, options in ((self.folder / "bad.json", {}), (self.folder / "none.xyz", {}), (HELIX, {"spp": 0}),
                                (HELIX, {"target_error": -1}), (HELIX, {"like": "none.exr"})):
            words = [word for name, value in options.items() for word in ("--" + name.replace("_", "-"), str(value))]
            said = command_line("render", source, "-o", self.folder / "a.exr", *words)
            self.assertEqual(said.returncode, 2)
            with self.assertRaises(parray.InputError) as caught:
                parray.render(source, **options)
            self.assertEqual(f"parray: {caught.exception}\n", said.stderr)

    def test_arrays_that_make_no_spheres_are_refused_with_the_place(self):
        positions, radii, colors = cloud(5)
        (self.folder / "bad.json").write_text("{")
        hole = positions.copy()
        hole[2, 1] = np.nan
        radii[3] = 0
        cases = (("positions: the array has shape (5,)", (radii,), {}),
                 ("positions: the array has shape (0, 3)", (positions[:0],), {}),
                 ("positions: the values are not an array of numbers", ([["a", "b", "c"]],), {}),
                 ("positions[2, 1] is nan", (hole,), {}),
                 ("radii[3] is 0.0", (positions, radii), {}),
                 ("radii: the array has shape (4,): give (5,), or one value", (positions, radii[:4]), {}),
                 ("colors[0, 0] is 2.5", (positions, None, colors + 2.5 - colors[0, 0]), {}),
                 ("colors: the array has shape (5,)", (positions, None, radii), {}),
                 ("elements: the array has shape (2,)", (positions,), {"elements": ["C", "H"]}),
                 ("colors: a file has its own", (HELIX, None, colors), {}),
                 ("colors, material: both decide the colour", (HELIX, None, "tab:blue"), {"material": "by-element"}),
                 ("radii: these options are for particles", (SCENE, 0.5), {}),
                 ("material: these options are for particles", (SCENE,), {"material": "plain"}),
                 ("bad.json: the file is not valid JSON: ", (self.folder / "bad.json",), {"sky": {}}),
                 ("none.json: no such file", (self.folder / "none.json",), {"sky": {}}),
                 ("the scene is not valid JSON", ({**SCENE, "version": float("nan")},), {}))
        for mentions, arguments, options in cases:
            with self.subTest(mentions):
                self.refused(parray.InputError, mentions, parray.render, *arguments, **options)
        self.assertTrue(issubclass(parray.InputError, ValueError))

    def test_without_the_program_the_remedy_is_said(self):
        before = dict(os.environ)
        self.addCleanup(os.environ.update, before)
        os.environ["PARRAY_BIN"] = str(self.folder)
        self.refused(parray.ProgramNotFound, f"PARRAY_BIN is {self.folder}, where no program is", parray.render, SCENE)
        os.environ["PARRAY_BIN"] = str(BIN / "parray")
        self.assertEqual(parray.find_program(), str(BIN / "parray"))
        del os.environ["PARRAY_BIN"]
        os.environ["PATH"] = str(self.folder)
        self.refused(parray.ProgramNotFound, "name it in PARRAY_BIN", parray.render, SCENE)
        os.environ["PATH"] = str(BIN)
        self.assertEqual(parray.find_program(), str(BIN / "parray"))

    def test_the_program_inside_the_package_precedes_that_in_the_path_but_not_parray_bin(self):
        inside = self.folder / "parray"
        inside.write_text("#!/bin/sh\n")
        inside.chmod(0o755)
        with unittest.mock.patch("parray.program._BUNDLED", inside), unittest.mock.patch.dict(os.environ, PATH=str(BIN)):
            self.assertEqual(parray.find_program(), str(BIN / "parray"))
            del os.environ["PARRAY_BIN"]
            self.assertEqual(parray.find_program(), str(inside))
            inside.unlink()
            self.assertEqual(parray.find_program(), str(BIN / "parray"))

    def test_a_program_that_somebody_kills_is_an_error_of_its_own(self):
        fake = self.folder / "parray"
        for status, kind in ((1, parray.RenderError), (130, parray.Interrupted), (3, parray.RenderError)):
            fake.write_text(f"#!/bin/sh\necho 'parray: what happened' >&2\nexit {status}\n")
            fake.chmod(0o755)
            with unittest.mock.patch.dict(os.environ, PARRAY_BIN=str(fake)):
                self.refused(kind, "what happened", parray.render, SCENE)

    def test_what_the_program_warns_of_is_a_warning(self):
        double = {**SCENE, "spheres": SCENE["spheres"] + SCENE["spheres"][:1]}
        with self.assertWarnsRegex(parray.ParRayWarning, "scene.json"):
            parray.render(double, **SMALL)


def all_of(screen):
    """What a terminal got, whose other end is closed."""
    text = b""
    with os.fdopen(screen, "rb", 0) as file, contextlib.suppress(OSError):  # EIO is its end
        while part := file.read(100000):
            text += part
    return text


class Interruptions(Test):
    def running(self):
        """Whether a `parray` that this process has started is still there."""
        children = pathlib.Path(f"/proc/{os.getpid()}/task").glob("*/children")
        return bool("".join(child.read_text() for child in children).strip())

    def test_cancelling_the_task_ends_the_program(self):
        async def cancelled():
            seen = asyncio.Event()
            task = asyncio.create_task(parray.render_async(SCENE, **LONG, progress=lambda _: seen.set()))
            await asyncio.wait_for(seen.wait(), 60)
            task.cancel()
            with self.assertRaises(asyncio.CancelledError):
                await task
        asyncio.run(cancelled())
        self.assertFalse(self.running())

    def test_tasks_render_side_by_side(self):
        async def both():
            return await asyncio.gather(*(parray.render_async(SCENE, seed=seed, **SMALL) for seed in (1, 2)))
        first, second = asyncio.run(both())
        self.assertEqual(first.report["image_sha256"], parray.render(SCENE, seed=1, **SMALL).report["image_sha256"])
        self.assertNotEqual(first.report["image_sha256"], second.report["image_sha256"])
        with self.assertRaises(parray.InputError):
            asyncio.run(parray.render_async(SCENE, width=0))

    def test_control_c_ends_the_program(self):
        main_thread = threading.get_ident()
        # A shell that starts the tests in the background ignores SIGINT for them.
        before = signal.signal(signal.SIGINT, signal.default_int_handler)
        self.addCleanup(signal.signal, signal.SIGINT, before)
        def interrupt(_):
            signal.pthread_kill(main_thread, signal.SIGINT)
        with self.assertRaises(KeyboardInterrupt):
            parray.render(SCENE, **LONG, progress=interrupt)
        self.assertFalse(self.running())


class Shown(Test):
    def test_progress_is_told_until_the_end(self):
        told = []
        parray.render(SCENE, width=200, height=150, spp=256, progress=told.append)
        self.assertEqual((told[-1].state, told[-1].done, told[-1].ended), ("done", 1, True))
        self.assertEqual([p.done for p in told], sorted(p.done for p in told))
        self.assertGreater(told[-1].error.rmse, 0)

    def test_a_terminal_gets_a_bar_and_a_file_gets_nothing(self):
        script = ("import sys; sys.path[:0] = sys.argv[1:3]; from support import *; "
                  "parray.render(SCENE, **SMALL); parray.render(SCENE, progress=False, **SMALL)")
        command = [sys.executable, "-c", script, str(SOURCE / "python/src"), str(SOURCE / "python/tests")]
        main_end, terminal = pty.openpty()
        subprocess.run(command, stderr=terminal, check=True)
        os.close(terminal)
        text = all_of(main_end).decode()
        self.assertIn("\r[####", text)
        self.assertEqual((text.count("100.0 %  done"), text.count("\n")), (1, 1))
        self.assertEqual(subprocess.run(command, capture_output=True, check=True).stderr, b"")

    def test_a_notebook_gets_a_bar_and_the_picture_as_it_sharpens(self):
        shown = []
        class Handle:
            def update(self, html):
                shown.append(html)
        class IPython:
            class display:
                HTML = staticmethod(str)
                display = staticmethod(lambda html, display_id: Handle())
            @staticmethod
            def get_ipython():
                return type("Shell", (), {"kernel": object()})
        modules = {"IPython": IPython, "IPython.display": IPython.display}
        with unittest.mock.patch.dict(sys.modules, modules):
            for seconds in (2, 8, 32):  # a busy machine may have no picture in the first
                shown.clear()
                parray.render(SCENE, width=300, height=200, spp=400000, time_limit=seconds)
                if any("<img" in html for html in shown):
                    break
        self.assertTrue(any("<img src=\"data:image/png;base64,iVBOR" in html for html in shown))
        self.assertIn('<progress value="1', shown[-1])
        self.assertNotIn("<img", shown[-1])


class Readme(Test):
    def test_the_readme_shows_what_comes_out(self):
        here = os.getcwd()
        self.addCleanup(os.chdir, here)
        os.chdir(self.folder)
        (self.folder / "scenes").symlink_to(SOURCE / "scenes")
        result = doctest.testfile(str(SOURCE / "python/README.md"), module_relative=False)
        self.assertGreater(result.attempted, 10)
        self.assertEqual(result.failed, 0)


if __name__ == "__main__":
    main()
