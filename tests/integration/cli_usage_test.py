#!/usr/bin/env python3
"""parray on the command line: what it refuses, what it prints, which files it leaves."""

import hashlib
import itertools
import json
import os
import pathlib
import pty
import re
import resource
import signal
import subprocess
import tempfile
import time
import unittest

from farm import BIN, SCENES, Farm, run, wait_for
from png import read_text

# A shell that may mount file systems of its own.
ALONE = "unshare", "--user", "--map-root-user", "--mount", "sh", "-c"

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
RENDER_OPTIONS = ["--width", "--height", "--spp", "--max-depth", "--seed", "--precision",
                  "--accelerator", "--isa", "--schedule", "--row-order", "--sampler", "--adaptive",
                  "--target-error", "--target-half-width", "--time-limit", "--passes",
                  "--transparent"]
LABEL_OPTIONS = ["--legend", "--legend-title", "--scale-bar", "--unit", "--time-stamp", "--cell", "--text", "--font-size",
                 "--width-mm", "--dpi", "--labels"]
FINISHING_OPTIONS = ["--outline", "--depth-cue"]
PARTICLE_OPTIONS = ["--frame", "--topology", "--alternatives", "--crystal", "--replicate", "--wrap", "--whole", "--center",
                    "--material", "--radius", "--select", "--slice", "--hide",
                    "--color-by", "--colormap", "--range", "--color-scale", "--radius-by", "--show",
                    "--stick-radius", "--bonds", "--arrows", "--arrow-scale", "--solid-cell",
                    "--view", "--style", "--projection",
                    "--up", "--azimuth", "--elevation", "--zoom"]
COORDINATOR = ["--coordinator", "PARRAY_COORDINATOR", "--keys", "PARRAY_KEYS"]
OPTIONS = {
    "render": RENDER_OPTIONS + PARTICLE_OPTIONS + FINISHING_OPTIONS + LABEL_OPTIONS + [
                                "--background", "--quality", "--views", "--like", "--output", "--aov", "--denoise", "--error-map", "--report", "--threads", "--quiet", "--progress",
                                "--preview", "--display", "--on-end"],
    "submit": RENDER_OPTIONS + PARTICLE_OPTIONS + FINISHING_OPTIONS + LABEL_OPTIONS + COORDINATOR + ["--background", "--quality", "--like", "--wait", "--output", "--aov", "--denoise", "--error-map", "--report",
                                              "--name", "--priority", "--max-failures", "--quiet", "--progress",
                                              "--frames", "--camera-path",
                                              "--preview", "--display", "--on-end"],
    "film": RENDER_OPTIONS + PARTICLE_OPTIONS + FINISHING_OPTIONS + LABEL_OPTIONS + COORDINATOR + [
        "--background", "--quality", "--output", "--fps", "--report", "--denoise", "--frames", "--turntable",
        "--camera-path", "--count", "--moving-noise", "--threads", "--farm", "--priority", "--quiet"],
    "jobs": COORDINATOR + ["--user", "--name", "--sort", "--order", "--limit", "--json"],
    "show": COORDINATOR + ["--json"],
    "watch": COORDINATOR + ["--quiet", "--progress", "--preview", "--display", "--on-end"],
    "cancel": COORDINATOR + ["--json"],
    "requeue": COORDINATOR + ["--json"],
    "forget": COORDINATOR + ["--json"],
    "priority": COORDINATOR + ["--json"],
    "audit": COORDINATOR + ["--json"],
    "replay": COORDINATOR + ["--json"],
    "fetch": COORDINATOR + ["--output", "--report", "--aov", "--error-map", "--partial", "--raw"],
    "workers": COORDINATOR + ["--host", "--json"],
    "validate": RENDER_OPTIONS + PARTICLE_OPTIONS + ["--background", "--json"],
    "convert": PARTICLE_OPTIONS + ["--width", "--height", "--expand"],
    "compare": ["--output", "--json"],
    "verify": ["--pixels", "--all", "--seed", "--threads", "--json"],
    "doctor": ["--json", "--extremes"],
}
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
                self.refused(*command, self.scene, option, "1e-9", mentions=option + " 1e-09: ")
                self.refused(*command, self.scene, option, "4.5e-8", mentions="use 4.6e-08 or more")
        self.refused("plan", self.scene, "--error", "4.5e-8", mentions="--error 4.5e-08: ")
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
                     mentions="is the scene file")
        self.assertEqual(json.loads(self.scene.read_text()), SCENE)
        self.refused("render", missing, "-o", self.path("a.png"), mentions="no-such-scene.json")

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


class Failures(CliTest):
    def start(self, *arguments, **options):
        process = subprocess.Popen([BIN / "parray", *map(str, arguments)], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True, **options)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process

    def wait_for_handler(self, process):
        """Until the process catches SIGINT: a slow build is still loading its libraries before."""
        def caught():
            status = pathlib.Path(f"/proc/{process.pid}/status").read_text()
            mask = int(next(line for line in status.splitlines()
                            if line.startswith("SigCgt")).split()[1], 16)
            return mask >> (signal.SIGINT - 1) & 1
        wait_for(lambda: process.poll() is not None or caught(), "the signal handler")

    def test_an_interrupted_render_stops_at_once_and_leaves_nothing(self):
        self.path("a.exr").write_text("an older picture")
        for number in (signal.SIGINT, signal.SIGTERM):
            for pause in (0.3, 1.0):
                process = self.start("render", self.scene, "-o", self.path("a.exr"), "--report",
                                     self.path("r.json"), *LONG)
                self.wait_for_handler(process)
                time.sleep(pause)  # into the loading, into the rendering
                self.assertIsNone(process.poll())
                process.send_signal(number)
                process.send_signal(number)  # people press it twice
                _, stderr = process.communicate(timeout=20)  # the picture would take far longer
                self.assertEqual(process.returncode, 130)
                self.assertEqual(stderr, "parray: interrupted\n")
                self.assertEqual(self.files(), self.before | {"a.exr"})
        self.assertEqual(self.path("a.exr").read_text(), "an older picture")

    def test_paths_of_a_million_segments_do_not_delay_an_interrupt(self):
        """A closed mirror ball around the camera: hardly a path ever ends by itself."""
        scene = {**SCENE, "materials": {"mirror": {"type": "metal", "albedo": [1, 1, 1], "fuzz": 0}},
                 "spheres": [{"center": [0, 0, 0], "radius": 50, "material": "mirror"}]}
        self.scene.write_text(json.dumps(scene))
        process = self.start("render", self.scene, "-o", self.path("a.exr"), "--max-depth",
                             "1048576", *LONG)
        self.wait_for_handler(process)
        time.sleep(1)  # into the rendering
        self.assertIsNone(process.poll())
        process.send_signal(signal.SIGINT)
        _, stderr = process.communicate(timeout=20)
        self.assertEqual((process.returncode, stderr), (130, "parray: interrupted\n"))
        self.assertEqual(self.files(), self.before)

    def test_an_interrupt_while_the_picture_is_written_leaves_nothing(self):
        process = self.start("render", self.scene, "-o", self.path("a.png"), "--width", "3000",
                             "--height", "3000", "--spp", "1", "-q")
        wait_for(lambda: process.poll() is not None or self.writing() > 1000, "the writing")
        self.assertIsNone(process.poll())
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130)
        self.assertEqual(self.files(), self.before)

    def writing(self):
        """Bytes in the unfinished picture; the probe before the rendering has none."""
        for name in self.files() - self.before:
            try:
                return self.path(name).stat().st_size
            except FileNotFoundError:
                pass
        return 0

    @unittest.skipIf(os.environ.get("PARRAY_SANITIZED"), "its OpenMP has a file that becomes too large")
    def test_a_full_disk_is_a_failure_that_leaves_what_was_there(self):
        small = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
        for name in ("a.exr", "a.png"):
            self.path(name).write_text("an older picture")
            process = self.start("render", self.scene, "-o", self.path(name), "-q",
                                 preexec_fn=small)
            _, stderr = process.communicate(timeout=60)
            self.assertEqual(process.returncode, 1)
            self.assertEqual(stderr, f"parray: writing {self.path(name)}: File too large\n")
            self.assertEqual(self.path(name).read_text(), "an older picture")
        self.assertEqual(self.files(), self.before | {"a.exr", "a.png"})

    @unittest.skipUnless(subprocess.run([*ALONE, "mount -t tmpfs tmpfs /mnt"], capture_output=True).returncode == 0,
                         "no mounts of one's own here")
    def test_a_picture_is_written_elsewhere_if_its_disk_is_full(self):
        full, spare = self.path("full"), self.path("spare")
        full.mkdir()
        spare.mkdir()
        render = (f"mount -t tmpfs -o size=8k tmpfs {full} && TMPDIR={spare} '{BIN}/parray' render {self.scene} -q "
                  f"--width 200 --height 150 -o {full}/a.png; echo $?; ls {full}")
        failed = subprocess.run([*ALONE, render], capture_output=True, text=True, timeout=60)
        self.assertEqual(failed.stdout, "1\n", failed.stderr)
        self.assertEqual(failed.stderr, f"parray: writing {full}/a.png: No space left on device: "
                         f"the picture was saved to {spare}/a.png\n")
        self.assertEqual(run("render", self.scene, "-q", "--width", "200", "--height", "150", "-o",
                             self.path("b.png")).returncode, 0)
        self.assertEqual(read_text(spare / "a.png")["parray:image_sha256"],
                         read_text(self.path("b.png"))["parray:image_sha256"])

    def test_a_closed_output_is_a_failure_and_no_crash(self):
        with open("/dev/full", "w", encoding="utf-8") as full:
            result = subprocess.run([BIN / "parray", "validate", self.scene], stdout=full,
                                    stderr=subprocess.PIPE, text=True, check=False)
        self.assertEqual(result.returncode, 1)
        self.assertEqual(result.stderr, "parray: writing to standard output failed\n")


class Talk(CliTest):
    def test_every_command_lists_every_option(self):
        for command, options in OPTIONS.items():
            text = run("help", command, "--all").stdout
            for option in options:
                self.assertIn(option, text, command)
            known = {*options, "--help", "--wait"}
            self.assertLessEqual(set(re.findall(r"--[a-z][a-z-]+", text)), known, command)

    def test_commands_list_the_channels_that_they_can_write(self):
        for command, lacks in (("render", set()), ("submit", set()), ("fetch", {"depth", "normal", "albedo", "sphere", "cost"})):
            described = re.search(r"(?ms)^  --aov .*?^  --error-map", run("help", command, "--all").stdout)[0]
            named = {"depth", "normal", "albedo", "sphere", "cost", "samples", "half-width"}
            self.assertEqual({name for name in named if f"{name}:" in described or f"{name}," in described}, named - lacks)

    def test_parray_alone_prints_the_help(self):
        result = run()
        self.assertEqual(result.returncode, 0)
        self.assertEqual(result.stdout, run("--help").stdout)
        for command in OPTIONS:
            self.assertRegex(result.stdout, rf"\n  {command} +\w")
        self.assertRegex(run("--version").stdout, r"\Aparray \d+\.\d+\.\d+\n\Z")

    def test_validate_says_what_the_scene_requires(self):
        result = run("validate", self.scene, "--json")
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        facts = json.loads(result.stdout)
        self.assertEqual((facts["spheres"], facts["diffuse"], facts["metal"], facts["dielectric"]),
                         (6, 2, 2, 2))
        self.assertEqual((facts["smallest_radius"], facts["largest_radius"], facts["extent"]),
                         (0.2, 100, 100))
        self.assertEqual(facts["features"],
                         ["diffuse", "metal", "fuzz", "dielectric", "lens", "many-radii"])
        self.assertIn(facts["precision"], ("f32", "f64"))
        self.assertIn(facts["accelerator"], ("linear", "bvh"))
        self.assertGreater(facts["accelerator_bytes"], 0)
        text = run("validate", self.scene).stdout
        for part in (facts["precision_reason"], facts["accelerator_reason"], facts["scene_sha256"]):
            self.assertIn(part, text)

    def test_every_scene_that_ships_is_valid(self):
        for scene in sorted(SCENES.glob("*.json")):
            result = run("validate", scene)
            self.assertEqual((result.returncode, result.stderr), (0, ""))

    def test_a_terminal_gets_a_bar_and_a_log_gets_lines(self):
        arguments = [BIN / "parray", "render", self.scene, "-o", self.path("a.png")]
        for term, bar in (("xterm", True), ("dumb", False)):
            main, terminal = pty.openpty()
            result = subprocess.run(arguments, stderr=terminal, stdout=subprocess.PIPE, check=False,
                                    env={**os.environ, "TERM": term})
            os.close(terminal)
            text = os.read(main, 100000).decode()
            os.close(main)
            self.assertEqual(result.returncode, 0)
            self.assertEqual("\r[" in text, bar)
            self.assertIn("100.0 %", text)
            self.assertNotIn("\x1b", text)
        result = run(*arguments[1:])
        self.assertEqual(result.stderr, "scene.json: 100.0 %  done\n")
        self.assertEqual(run(*arguments[1:], "--quiet").stderr, "")

    def test_programs_get_json_lines(self):
        result = run("render", self.scene, "-o", self.path("a.png"), "--progress", "json")
        lines = [json.loads(line) for line in result.stderr.splitlines()]
        self.assertEqual(set(lines[-1]), {"state", "progress", "samples_per_second", "seconds_left",
                                          "waits_for", "error"})
        self.assertEqual((lines[-1]["state"], lines[-1]["progress"], lines[-1]["seconds_left"]), ("done", 1, 0))
        self.assertGreater(lines[-1]["error"]["rmse"], 0)
        self.assertEqual(run("render", self.scene, "-o", self.path("a.png"), "--progress", "pie").returncode, 2)

    def test_the_same_picture_is_the_same_file(self):
        arguments = ["render", self.scene, "-q", "-o"]
        run(*arguments, self.path("a.png"))
        run(*arguments, self.path("b.png"), "--threads", "1")
        digests = {hashlib.sha256(self.path(name).read_bytes()).hexdigest()
                   for name in ("a.png", "b.png")}
        self.assertEqual(len(digests), 1)


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
