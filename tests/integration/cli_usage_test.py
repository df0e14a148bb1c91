#!/usr/bin/env python3
"""parray on the command line: what it refuses, what it prints, which files it leaves."""

import itertools
import json
import pathlib
import shutil
import subprocess
import tempfile
import unittest

from farm import BIN, SCENES, Farm, run, wait_for

SCENE = {
    "version": 1,
    "camera": {"look_from": [3, 2, 5], "look_at": [0, 0.5, 0], "up": [0, 1, 0], "vfov": 40,
               "aperture": 0.1, "focus_distance": 6},
    "image": {"width": 40, "height": 30},
    "render": {"samples_per_pixel": 8, "max_depth": 10, "seed": 7},
    "sky": {"horizon": [1, 1, 1], "zenith": [0.5, 0.7, 1.0]},
    "materials": {"ground": {"type": "diffuse", "albedo": [0.5, 0.5, 0.5]},
                  "gold": {"type": "metal", "albedo": [0.8, 0.6, 0.2], "fuzz": 0.1},
                  "glass": {"type": "dielectric", "ior": 1.5}},
    "spheres": [{"center": [0, -100, 0], "radius": 100, "material": "ground"},
                {"center": [-1.1, 0.5, 0], "radius": 0.5, "material": "gold"},
                {"center": [0, 0.5, 0], "radius": 0.5, "material": "glass"},
                {"center": [1.1, 0.5, 0], "radius": 0.5, "material": "ground"},
                {"center": [0.4, 0.2, 1], "radius": 0.2, "material": "gold"},
                {"center": [-0.5, 0.2, 1.2], "radius": 0.2, "material": "glass"}],
}
LONG = ["--width", "1000", "--height", "1000", "--spp", "100000"]
REPORT_FIELDS = """image_sha256 width height samples_per_pixel max_depth seed precision accelerator
    isa sampler adaptive passes error stopped_by schedule spheres accelerator_bytes threads workers
    samples least_samples most_samples trace_version target_error target_half_width time_limit rays
    samples_per_second rays_per_second nonfinite_samples features duplicates_removed""".split()


class CliTest(unittest.TestCase):
    default_name = "a.exr"

    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix="parray-cli-")
        self.addCleanup(temporary.cleanup)
        self.directory = pathlib.Path(temporary.name)
        self.scene = self.directory / "scene.json"
        self.scene.write_text(json.dumps(SCENE))
        self.before = self.files()

    def files(self):
        return {path.name for path in self.directory.iterdir()}

    def path(self, name):
        return self.directory / name

    def refused(self, *arguments, mentions, status=2):
        with self.subTest(arguments=arguments):
            result = run(*arguments)
            self.assertEqual(result.returncode, status, result.stderr)
            self.assertEqual(result.stdout, "")
            self.assertRegex(result.stderr, r"\Aparray: [^\n]*\n\Z")
            self.assertIn(mentions, result.stderr)
            self.assertEqual(self.files(), self.before)

    def rendered(self, *options, name=None):
        name = name or self.default_name
        report = self.path("report.json")
        result = run("render", self.scene, "-o", self.path(name), "--report", report, "-q", *options)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(result.stderr, "")
        return json.loads(report.read_text()), result.stdout


class Refusals(CliTest):
    def test_invalid_numbers_and_numbers_out_of_range_are_refused_with_the_option(self):
        output = ["-o", self.path("a.png")]
        for option in ("--width", "--height", "--spp", "--max-depth", "--threads"):
            for value in ("-1", "0", "1e30", "1.5", "text", "", " 5", "+5", "0x10", "99999999999",
                          "18446744073709551617", "nan"):
                self.refused("render", self.scene, *output, option, value, mentions=option + ":")
        for value in ("-1", "18446744073709551616", "1e3", ""):
            self.refused("render", self.scene, *output, "--seed", value, mentions="--seed:")
        for value in ("-1", "101", "x"):
            self.refused("submit", self.scene, "--priority", value, mentions="--priority:")
        self.refused("render", self.scene, *output, "--width", "65536", "--height", "65536",
                     mentions="--width, --height: ")

    def test_targets_below_the_rounding_of_a_picture_are_refused_with_the_least_that_is_possible(self):
        for command in (["render", "-o", self.path("a.png")], ["submit"]):
            for option in ("--target-error", "--target-half-width"):
                self.refused(*command, self.scene, option, "1e-9", mentions=option + " 1e-09 is too small: ")
                self.refused(*command, self.scene, option, "4.5e-8", mentions="use 4.6e-08 or more")
        self.refused("plan", self.scene, "--error", "4.5e-8", mentions="--error 4.5e-08 is too small: ")
        coarse = ["--width", "8", "--height", "8", "--spp", "2"]
        self.rendered(*coarse, "--target-error", "4.6e-8")

    def test_spellings_of_version_from_other_programs_are_answered_with_the_right_one(self):
        for word in ("version", "-v", "-V"):
            result = run(word)
            self.assertEqual((result.returncode, result.stdout), (2, ""))
            self.assertIn("did you mean --version?", result.stderr)

    def test_unknown_words_are_refused_with_the_nearest_known_one(self):
        output = ["-o", self.path("a.png")]
        for option, value, hint in (("--precision", "f46", "f64"), ("--accelerator", "bhv", "bvh"),
                                    ("--isa", "avx215", "avx2"),
                                    ("--view", "frnt", "front"), ("--style", "publicaton", "publication"),
                                    ("--style", "flat,stick", "sticks"), ("--bonds", "fiel", "file"),
                                    ("--colormap", "virids", "viridis"), ("--projection", "ortografic", "orthographic"),
                                    ("--hide", "watr", "water"), ("--outline", "onn", "on"),
                                    ("--schedule", "guidd", "guided"),
                                    ("--row-order", "sequentially", "sequential"),
                                    ("--aov", "depth,normls", "normal")):
            self.refused("render", self.scene, *output, option, value, mentions=option + ":")
            self.refused("render", self.scene, *output, option, value, mentions=hint)
        self.refused("render", self.scene, *output, "--widht", "5", mentions="--width")
        self.refused("rendr", self.scene, *output, mentions="render")

    def test_old_spellings_are_refused_with_the_new_ones(self):
        for command in (["render", "-o", self.path("a.png")], ["submit"]):
            self.refused(*command, self.scene, "--no-labels", mentions="parray: --no-labels is now --labels off;")
            self.refused(*command, self.scene, "--opaque", mentions="parray: --opaque is now --transparent off;")
        self.refused("render", self.scene, "-o", self.path("a.png"), "--transparent",
                     mentions="--transparent needs a value after it: on|off;")

    def test_missing_and_surplus_arguments_are_refused_with_the_help_to_read(self):
        output = ["-o", self.path("a.png")]
        help_of_render = "`parray render --help`"
        self.refused("render", self.scene, mentions="--output")
        self.refused("render", *output, mentions="SCENE")
        self.refused("render", self.scene, *output, "--spp", mentions="--spp needs a value")
        self.refused("render", self.scene, *output, "surplus", mentions="'surplus'")
        self.refused("render", self.scene, *output, *output, mentions="only once")
        self.refused("render", self.scene, mentions=help_of_render)
        self.refused("submit", self.scene, *output, mentions="--wait")
        for option in ("--on-end", "--preview", "--display"):
            self.refused("submit", self.scene, option, "true", mentions="--wait")
        self.refused("submit", self.scene, "--threads", "2", mentions="--threads")
        self.refused("workers", "--host", mentions="--host needs an action")
        for command in ("show", "watch", "cancel"):
            self.refused(command, mentions="JOB")
            self.refused(command, "-1", mentions="JOB")
            self.refused(command, "first", mentions="JOB")
        self.refused("fetch", "1", mentions="--output")
        self.refused("--nonsense", mentions="`parray --help`")

    def test_a_place_that_cannot_be_written_to_is_refused_before_the_scene_is_read(self):
        missing = self.path("no-such-scene.json")
        for name, mentions in (("a.gif", "'.gif'"), ("a", ".exr"), ("", "directory"),
                               ("none/a.png", "does not exist"), ("x" * 300 + ".png", "too long")):
            self.refused("render", missing, "-o", self.path(name), mentions=mentions)
            self.refused("submit", missing, "--wait", "-o", self.path(name), mentions=mentions)
            self.refused("fetch", "1", "-o", self.path(name), mentions=mentions)
        self.refused("render", missing, "-o", "", mentions="--output")
        self.refused("render", missing, "-o", self.path("a.png"), "--report", self.directory,
                     mentions="directory")
        self.refused("render", missing, "-o", self.path("a.png"), "--report", self.path("a.png"),
                     mentions="different files")
        files = {"-o": self.path("a.png"), "--report": self.path("b.png"), "--error-map": self.path("c.png"),
                 "--preview": self.path("d.png")}
        for one, other in itertools.combinations(files, 2):
            same = files | {one: files[other]}
            allowed = {one, other} == {"-o", "--preview"}
            self.refused("render", missing, *(word for pair in same.items() for word in pair),
                         mentions="no-such-scene.json" if allowed else "need different files")
        self.refused("film", missing, "-o", self.path("a.mp4"), "--report", self.path("a.mp4"),
                     mentions="film and report need different files")
        self.refused("render", self.scene, "-o", self.path("a.png"), "--report", self.scene,
                     mentions="is an input file: name another output file")
        self.assertEqual(json.loads(self.scene.read_text()), SCENE)
        self.refused("render", missing, "-o", self.path("a.png"), mentions="no-such-scene.json")

    def test_an_output_that_would_replace_an_input_is_refused_and_the_input_stays(self):
        atoms, named, like = self.path("p.xyz"), self.path("named.json"), self.path("like.png")
        atoms.write_text("2\n\nO 0 0 0\nC 0 0 2\n")
        shutil.copy(atoms, self.path("top.xyz"))
        shutil.copy(atoms, self.path("top.json"))
        small = ["--width", "40", "--height", "30", "--spp", "2", "-q"]
        for command in (["convert", atoms, named, "--topology", self.path("top.xyz"), "--width", "40"],
                        ["render", self.scene, *small, "-o", like]):
            self.assertEqual(run(*command).returncode, 0)
        self.path("link").symlink_to(atoms)
        shutil.copy(named, self.path("tradeoff.json"))
        self.before = self.files()
        contents = {path: path.read_bytes() for path in self.directory.iterdir()}
        output = ["-o", self.path("a.png")]
        topology = [atoms, "--topology", self.path("top.xyz")]
        for command in ("render", "submit"):
            options = [*output, *(["--wait"] if command == "submit" else []), *small[:-1]]
            for report in (atoms, self.path("top.xyz"), self.path("link"), named):
                self.refused(command, named, *options, "--report", report,
                             mentions=f"parray: {report} is an input file: name another output file\n")
            self.refused(command, *topology, *options, "--report", self.path("top.xyz"), mentions="top.xyz is an input file")
        for option in ("--report", "--error-map", "--preview"):
            self.refused("render", self.scene, "--like", like, *output, option, like, mentions="like.png is an input file")
        self.refused("render", self.scene, "--like", like, "-o", like, mentions="like.png is an input file")
        self.refused("render", atoms, *output, *small, "--views", "front,top", "--report", atoms, mentions="p.xyz is an input")
        self.refused("convert", atoms, self.path("top.json"), "--topology", self.path("top.json"),
                     mentions="top.json is an input file")
        self.refused("tradeoff", self.path("tradeoff.json"), "-o", self.directory, mentions="tradeoff.json is an input file")
        with self.scene.open() as scene:
            result = subprocess.run([BIN / "parray", "render", "-", *output, "--report", self.scene], stdin=scene,
                                    capture_output=True, text=True, timeout=60)
        self.assertEqual((result.returncode, result.stdout), (2, ""))
        self.assertIn("scene.json is an input file", result.stderr)
        for path, content in contents.items():
            self.assertEqual(path.read_bytes(), content, path)

    def test_pictures_too_small_for_jpeg_2000_are_refused_before_the_render(self):
        small, large = self.path("a.jp2"), ["--width", "32", "--height", "32", "--spp", "1", "-q"]
        for name in ("render", "submit"):
            self.refused(name, self.scene, *(["--wait"] if name == "submit" else []), "-o", small,
                         mentions="a.jp2: JPEG 2000 needs a width and a height of at least 32 pixels: use .png")
        self.refused("render", self.scene, "-o", self.path("a.png"), "--preview", small, mentions="at least 32 pixels")
        helix = SCENES / "particles" / "helix.pdb"
        self.refused("render", helix, "-o", small, "--views", "front,top", *large, "--height", "31", mentions="at least 32")
        for scene, options in ((self.scene, large), (helix, ["--views", "front,top", *large, "--width", "16"])):
            result = run("render", scene, "-o", small, *options)
            self.assertEqual((result.returncode, result.stderr), (0, ""))

    def test_bad_scenes_are_refused_with_the_place(self):
        for name, change in (("radius", lambda s: s["spheres"][0].update(radius=-1)),
                             ("albdeo", lambda s: s["materials"]["gold"].update(albdeo=1)),
                             ("version", lambda s: s.update(version=99)),
                             ("look_from", lambda s: s["camera"].update(look_from=[0, 0]))):
            scene = json.loads(json.dumps(SCENE))
            change(scene)
            self.scene.write_text(json.dumps(scene))
            self.refused("validate", self.scene, mentions=name)
            self.refused("render", self.scene, "-o", self.path("a.png"), mentions="scene.json:")
        for text in ("", "{", "[]", "null", "\0", "[" * 100000):
            self.scene.write_text(text)
            self.refused("validate", self.scene, mentions="scene.json")
        self.refused("validate", self.directory, mentions="directory")

    def test_a_coordinator_that_cannot_be_reached_is_named(self):
        self.refused("jobs", "--coordinator", "http://127.0.0.1:1", mentions="http://127.0.0.1:1")
        self.refused("jobs", "--coordinator", "", mentions="tcp://127.0.0.1:7400")
        self.refused("jobs", "--coordinator", "tcp://127.0.0.1:1", mentions="tcp://127.0.0.1:1",
                     status=1)


class Pictures(CliTest):
    default_name = "a.png"  # a fifth of the time that .exr takes

    def test_the_bits_do_not_depend_on_how_the_work_is_done(self):
        report, _ = self.rendered()
        expected = report["image_sha256"]
        for options in (["--threads", "1"], ["--threads", "2"], ["--threads", "5"],
                        *(["--schedule", s] for s in ("static", "guided", "factoring", "weighted")),
                        *(["--row-order", o] for o in ("sequential", "interleaved")),
                        *(["--accelerator", a] for a in ("linear", "bvh", "octree")),
                        ["--isa", "scalar"]):
            with self.subTest(options=options):
                report, _ = self.rendered(*options)
                self.assertEqual(report["image_sha256"], expected)
        report, _ = self.rendered("--seed", "8")
        self.assertNotEqual(report["image_sha256"], expected)

    def test_the_sampler_decides_the_picture_and_is_sobol_by_default(self):
        hashes = {}
        for options in ([], ["--sampler", "sobol"], ["--sampler", "independent"]):
            report, _ = self.rendered(*options)
            self.assertEqual(report["sampler"], options[-1] if options else "sobol")
            hashes.setdefault(report["sampler"], set()).add(report["image_sha256"])
        self.assertEqual([len(of) for of in hashes.values()], [1, 1])
        self.assertNotEqual(hashes["sobol"], hashes["independent"])

    def test_options_come_before_the_scene_and_the_last_of_one_counts(self):
        report, _ = self.rendered()
        self.assertEqual((report["width"], report["height"], report["samples_per_pixel"],
                          report["max_depth"], report["seed"]), (40, 30, 8, 10, 7))
        report, _ = self.rendered("--width", "9", "--spp", "3", "--width", "11", "--max-depth", "2",
                                  "--seed", "18446744073709551615", "--precision", "f64")
        self.assertEqual((report["width"], report["height"], report["samples_per_pixel"],
                          report["max_depth"], report["seed"], report["precision"]),
                         (11, 30, 3, 2, 18446744073709551615, "f64"))

    def test_the_smallest_picture_and_an_empty_scene_render(self):
        report, _ = self.rendered("--width", "1", "--height", "1", "--spp", "1", "--max-depth", "1")
        self.assertEqual(report["samples"], 1)
        self.scene.write_text(json.dumps({**SCENE, "spheres": []}))
        report, _ = self.rendered()
        self.assertEqual(report["spheres"], 0)
        self.assertEqual(report["rays"], report["samples"])

    def test_the_report_says_everything(self):
        report, stdout = self.rendered("--threads", "2")
        for field in REPORT_FIELDS:
            self.assertIn(field, report)
        parts = dict(report["seconds"])
        self.assertTrue(all(value >= 0 for value in parts.values()))
        self.assertLessEqual(parts.pop("build"), parts["render"])
        self.assertEqual(parts.pop("deciding"), 0)
        self.assertEqual(set(parts), {"load", "submit", "render", "write", "other", "total"})
        self.assertAlmostEqual(parts.pop("total"), sum(parts.values()), places=6)
        self.assertEqual(report["samples"], 40 * 30 * 8)
        self.assertEqual((report["threads"], report["workers"], report["spheres"]), (2, 1, 6))
        self.assertEqual(report["nonfinite_samples"], 0)
        self.assertEqual(stdout.count("\n"), 1)
        self.assertIn(str(self.path(self.default_name)), stdout)
        self.assertIn(report["image_sha256"][:16], stdout)

    def test_only_the_picture_and_the_report_are_left(self):
        self.rendered(name="a.exr")
        self.rendered(name="b.PNG")
        self.assertEqual(self.files(), self.before | {"a.exr", "b.PNG", "report.json"})

    def test_the_scene_identity_is_that_of_its_contents(self):
        report, _ = self.rendered()
        validated = json.loads(run("validate", self.scene, "--json").stdout)
        self.assertEqual(validated["scene_sha256"], report["scene_sha256"])
        self.scene.write_text(json.dumps(SCENE, indent=1))
        self.assertEqual(self.rendered()[0]["scene_sha256"], report["scene_sha256"])


    def test_duplicate_spheres_are_left_out_with_a_warning(self):
        clean, _ = self.rendered()
        self.assertEqual(clean["duplicates_removed"], 0)
        spheres = SCENE["spheres"] + [{**SCENE["spheres"][3], "material": "glass"},
                                      SCENE["spheres"][1]]
        self.scene.write_text(json.dumps({**SCENE, "spheres": spheres}))
        warning = (f"parray: warning: {self.scene}: 2 spheres left out, because an earlier "
                   "sphere has the same centre and radius: the first is sphere 6 (from 0), which "
                   "equals sphere 3\n")
        validated = run("validate", self.scene, "--json")
        self.assertEqual((validated.returncode, validated.stderr), (0, warning))
        facts = json.loads(validated.stdout)
        self.assertEqual((facts["spheres"], facts["duplicates_removed"]), (6, 2))
        self.assertEqual(facts["scene_sha256"], clean["scene_sha256"])
        self.assertIn("2 duplicates", run("validate", self.scene).stdout)
        report = self.path("report.json")
        result = run("render", self.scene, "-q", "-o", self.path("a.png"), "--report", report)
        self.assertEqual((result.returncode, result.stderr), (0, warning))
        report = json.loads(report.read_text())
        self.assertEqual((report["spheres"], report["duplicates_removed"]), (6, 2))
        self.assertEqual(report["image_sha256"], clean["image_sha256"])


class Waiting(CliTest):
    def test_a_farm_without_workers_says_so_in_every_command_that_meets_it(self):
        with Farm() as farm:
            job = farm.submit(self.scene)
            self.assertEqual(farm.client("jobs").stderr,
                             "parray: 1 job waits for: a worker (none is connected)\n")
            self.assertIn("waits for  a worker (none is connected)", farm.client("show", job).stdout)
            self.assertIn("no workers are connected: start parray-worker --coordinator "
                          + farm.address, farm.client("workers").stderr)
            watch = farm.start_client("watch", job, "--quiet")
            wait_for(lambda: watch.log.read_text() ==
                     f"parray: job {job} waits for: a worker (none is connected)\n", "the quiet one's word")
            farm.start_worker("late")
            self.assertEqual(watch.wait(timeout=60), 0)
            done = farm.client("jobs")
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.assertEqual(farm.client("workers").stderr, "")


if __name__ == "__main__":
    unittest.main()
