#!/usr/bin/env python3
"""Pictures with their recipe: parray verify, which traces pixels again, and --like, which renders the same bits
again."""

import hashlib
import json
import struct
import unittest

from cli_usage_test import SCENE, CliTest
from exr import forge_exr, read_attributes, read_exr, rgb_bytes
from farm import Farm, run
from mpi import MpiRun, why_not
from png import forge_png, read_text

WIDTH, HEIGHT = SCENE["image"]["width"], SCENE["image"]["height"]
PIXELS = WIDTH * HEIGHT
ADAPTIVE = ["--target-error", "0.004"]


def next_float(value):
    """Returns the number with one other bit."""
    return struct.unpack("<f", struct.pack("<I", struct.unpack("<I", struct.pack("<f", value))[0] + 1))[0]


def matching_hash(values):
    return {"parray:image_sha256": hashlib.sha256(rgb_bytes(values)).hexdigest()}


class VerifyTest(CliTest):
    def verified(self, *arguments, status=0):
        """Returns the output of --json."""
        result = run("verify", *arguments, "--json")
        self.assertEqual((result.returncode, result.stderr), (status, ""))
        document = json.loads(result.stdout)
        self.assertEqual(document["right"], status == 0)
        return document

    def line(self, *arguments, status=0):
        """Returns the text output."""
        result = run("verify", *arguments)
        self.assertEqual((result.returncode, result.stderr), (status, ""))
        self.assertRegex(result.stdout, r"\A[^\n]+\n\Z")
        self.assertEqual(": wrong: " in result.stdout, status != 0)
        return result.stdout

    def refused_picture(self, *arguments, mentions):
        result = run("verify", *arguments)
        self.assertEqual((result.returncode, result.stdout), (2, ""))
        self.assertRegex(result.stderr, r"\Aparray: [^\n]*\n\Z")
        self.assertIn(mentions, result.stderr)


class Recipes(VerifyTest):
    def test_an_exr_picture_has_numbers_as_numbers(self):
        report, _ = self.rendered(*ADAPTIVE, "--seed", "5")
        kept = {name[7:]: value for name, value in read_attributes(self.path("a.exr")).items()
                if name.startswith("parray:")}
        for name in ("image_sha256", "scene_sha256", "width", "height", "max_depth", "seed",
                     "sampler", "precision", "samples", "trace_version", "target_error", "version"):
            self.assertEqual(kept[name], report[name], name)
            self.assertEqual(isinstance(kept[name], str), isinstance(report[name], str), name)
        self.assertEqual(kept["error:rmse"], report["error"]["rmse"])
        self.assertEqual([int(n) for n in kept["passes"].split(",")], report["passes"])

    def test_a_png_picture_has_the_same_as_text(self):
        report, _ = self.rendered(name="a.png")
        kept = read_text(self.path("a.png"))
        for name in ("image_sha256", "scene_sha256", "width", "seed", "trace_version"):
            self.assertEqual(kept["parray:" + name], str(report[name]))
        self.assertEqual(float(kept["parray:error:rmse"]), report["error"]["rmse"])

    def test_the_file_has_the_samples_of_each_pixel_if_they_differ(self):
        report, _ = self.rendered(*ADAPTIVE)
        values, types = read_exr(self.path("a.exr"))
        self.assertEqual(types["samples"], "I")
        self.assertEqual(sum(values["samples"]), report["samples"])
        self.assertEqual((min(values["samples"]), max(values["samples"])),
                         (report["least_samples"], report["most_samples"]))
        self.assertNotIn("parray:samples_per_pixel", read_attributes(self.path("a.exr")))
        self.rendered()
        self.assertEqual(set(read_exr(self.path("a.exr"))[1]), {"R", "G", "B"})
        self.assertEqual(read_attributes(self.path("a.exr"))["parray:samples_per_pixel"], 8)

    def test_a_preview_and_a_picture_of_others_are_refused(self):
        self.rendered()
        self.refused_picture(self.scene, self.path("a.exr"),
                             mentions=f"give the picture before its scene: parray verify {self.path('a.exr')} {self.scene}")
        difference = self.path("difference.exr")
        self.assertEqual(run("compare", self.path("a.exr"), self.path("a.exr"), "-o",
                             difference).returncode, 0)
        self.refused_picture(difference, mentions="has no recipe")
        self.refused_picture(self.scene, mentions=str(self.scene))
        self.refused_picture(self.path("none.exr"), mentions="none.exr")


class Verdicts(VerifyTest):
    def test_without_the_scene_only_the_hash_is_checked_and_verify_says_so(self):
        for name in ("a.exr", "a.png"):
            self.rendered(name=name)
            self.assertEqual(self.verified(self.path(name))["traced_pixels"], 0)
            line = self.line(self.path(name))
            self.assertIn("not checked", line)
            self.assertIn("add the scene", line)

    def test_pictures_of_every_kind_are_right(self):
        for options in (["--sampler", "independent"], ["--precision", "mixed"],
                        ["--precision", "f64", "--seed", "18446744073709551615"], ADAPTIVE,
                        ["--target-half-width", "0.04"],
                        ["--target-error", "0.006", "--adaptive", "off", "--aov", "samples"]):
            with self.subTest(options=options):
                self.rendered(*options)
                document = self.verified(self.path("a.exr"), self.scene, "--all")
                self.assertEqual((document["traced_pixels"], document["wrong_pixels"]), (PIXELS, 0))

    def test_pixels_are_picked_at_random_and_again_by_the_same_seed(self):
        self.rendered()
        document = self.verified(self.path("a.exr"), self.scene)
        self.assertEqual(document["traced_pixels"], 299)
        self.assertLess(document["share_found"], 0.01)
        line = self.line(self.path("a.exr"), self.scene)
        self.assertIn(": right: ", line)
        self.assertIn("if 1 % of all pixels were wrong, this would find one with a probability of 95 %", line)
        self.assertNotIn(f"--seed {document['seed']})", line)
        same = self.verified(self.path("a.exr"), self.scene, "--seed", document["seed"])
        self.assertEqual(same, document)
        many = self.verified(self.path("a.exr"), self.scene, "--pixels", "5000")
        self.assertEqual((many["traced_pixels"], many["share_found"]), (PIXELS, 0))

    def test_an_8_bit_picture_is_right_after_the_same_conversion(self):
        self.rendered(name="a.png")
        self.verified(self.path("a.png"), self.scene, "--all")

    def test_a_picture_that_a_farm_has_rendered_is_right(self):
        with Farm() as farm:
            farm.start_worker("one")
            number = farm.submit(self.scene, *ADAPTIVE)
            self.assertEqual(farm.client("watch", number).returncode, 0)
            fetched = farm.client("fetch", number, "-o", self.path("b.exr"))
            self.assertEqual(fetched.returncode, 0, fetched.stderr)
        self.assertIn("samples", read_exr(self.path("b.exr"))[1])
        self.verified(self.path("b.exr"), self.scene, "--all")

    def test_the_picture_of_a_particle_file_is_verified_with_that_file(self):
        atoms = self.path("atoms.xyz")
        atoms.write_text("3\n\nO 0 0 0\nH 0 0.8 0.6\nH 0 0.8 -0.6\n")
        result = run("render", atoms, "-q", "-o", self.path("a.exr"), "--width", "40", "--height",
                     "24", "--spp", "4")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.verified(self.path("a.exr"), atoms, "--all")

    def test_a_picture_of_particles_with_options_is_verified_with_the_scene_that_convert_writes(self):
        atoms, scene, size = self.path("atoms.xyz"), self.path("atoms.json"), ["--width", "40", "--height", "40"]
        atoms.write_text("3\n\nO 0 0 0\nH 0 0.8 0.6\nH 0 0.8 -0.6\n")
        for words in (["render", "-q", "-o", self.path("a.exr"), "--spp", "4", atoms], ["convert", atoms, scene]):
            result = run(*words, "--style", "flat", *size)
            self.assertEqual(result.returncode, 0, result.stderr)
        self.refused_picture(self.path("a.exr"), atoms, mentions="(parray verify takes none), or name the scene file that parray convert writes")
        self.verified(self.path("a.exr"), scene, "--all")

    def test_the_picture_of_a_crystal_is_verified_with_its_file_or_with_the_scene_that_convert_writes(self):
        crystal, scene = self.path("POSCAR"), self.path("crystal.json")
        crystal.write_text("salt\n5.6\n1 0 0\n0 1 0\n0 0 1\nNa Cl\n1 1\nDirect\n0 0 0\n0.5 0.5 0.5\n")
        # The cell and its names are part of a picture of the first size, and too large for the others.
        for width, height in ((160, 120), (128, 96), (40, 30)):
            for options, fits in (([], [crystal, scene]), (["--labels", "off"], [scene]), (["--font-size", "6"], [scene]),
                                  (["--dpi", "80"], [scene]), (["--transparent", "on"], [crystal, scene])):
                with self.subTest(width=width, options=options):
                    size = ["--width", width, "--height", height]
                    for words in (["render", "-q", "-o", self.path("a.exr"), "--spp", "2", crystal], ["convert", crystal, scene]):
                        result = run(*words, *size, *options)
                        self.assertEqual(result.returncode, 0, result.stderr)
                    for file in fits:
                        result = run("verify", self.path("a.exr"), file)
                        self.assertEqual(result.returncode, 0, result.stderr)
                        result = run("render", "--like", self.path("a.exr"), scene, "-q", "-o", self.path("b.exr"))
                        self.assertEqual(result.returncode, 0, result.stderr)


class Forgeries(VerifyTest):
    def setUp(self):
        super().setUp()
        self.rendered("--spp", "4")
        self.forged = self.path("forged.exr")

    def forge(self, places, texts=lambda values: {}):
        def change(values):
            for place in places:
                values["G"][place] = next_float(values["G"][place])

        forge_exr(self.path("a.exr"), self.forged, change, texts)

    def test_a_copy_is_right(self):
        self.forge([], matching_hash)
        self.verified(self.forged, self.scene, "--all")

    def test_one_changed_bit_does_not_fit_the_hash(self):
        self.forge([17])
        damage = self.verified(self.forged, status=1)["damage"]
        self.assertIn("image_sha256 does not match the pixels", damage)
        self.assertIn(damage, self.line(self.forged, status=1))

    def test_one_forged_pixel_in_a_hundred_is_found_by_tracing_though_the_hash_fits(self):
        places = range(50, PIXELS, 100)
        self.forge(places, matching_hash)
        self.assertIsNone(self.verified(self.forged)["damage"])
        sample = [self.forged, self.scene, "--seed", "1"]
        document = self.verified(*sample, status=1)
        line = self.line(*sample, status=1)
        wrong = document["wrong"]
        self.assertEqual(len(wrong), document["wrong_pixels"])
        self.assertLess({(p["x"], p["y"]) for p in wrong},
                        {(place % WIDTH, place // WIDTH) for place in places})
        self.assertIn(f"({wrong[0]['x']}, {wrong[0]['y']})", line)
        self.assertEqual(next_float(wrong[0]["traced"][1]), wrong[0]["stored"][1])
        document = self.verified(self.forged, self.scene, "--all", status=1)
        self.assertEqual(document["wrong_pixels"], len(places))

    def test_forged_numbers_of_samples_are_found(self):
        self.rendered(*ADAPTIVE)

        def change(values):
            values["samples"][100] += 2

        forge_exr(self.path("a.exr"), self.forged, change)
        self.assertIn("samples", self.verified(self.forged, status=1)["damage"])

        def move(values):
            change(values)
            values["samples"][101] -= 2

        forge_exr(self.path("a.exr"), self.forged, move)
        self.verified(self.forged)
        document = self.verified(self.forged, self.scene, "--all", status=1)
        self.assertEqual({(p["x"], p["y"]) for p in document["wrong"]},
                         {(100 % WIDTH, 100 // WIDTH), (101 % WIDTH, 101 // WIDTH)})

    def test_a_forged_8_bit_picture_is_found_by_its_hash_or_by_tracing(self):
        self.rendered(name="a.png")
        forged = self.path("forged.png")

        def change(pixels):
            pixels[3 * 25 + 1] ^= 1

        forge_png(self.path("a.png"), forged, change)
        self.assertIn("pixels_sha256", self.verified(forged, status=1)["damage"])
        forge_png(self.path("a.png"), forged, change, lambda pixels: {
            "parray:pixels_sha256": hashlib.sha256(pixels).hexdigest()})
        self.verified(forged)
        document = self.verified(forged, self.scene, "--all", status=1)
        self.assertEqual([(p["x"], p["y"]) for p in document["wrong"]], [(25, 0)])

    def test_an_8_bit_picture_without_its_hash_is_the_file_of_another_program(self):
        self.rendered(name="a.png")
        changed = self.path("changed.png")
        forge_png(self.path("a.png"), changed, lambda pixels: None, lambda pixels: {"parray:pixels_sha256": ""})
        self.refused_picture(changed, mentions="so another program wrote the file: verify the original file")

    def test_another_scene_is_refused_by_its_hash(self):
        other = self.path("other.json")
        other.write_text(json.dumps({**SCENE, "sky": {"horizon": [1, 1, 1], "zenith": [0.5, 0.7, 0.9]}}))
        self.refused_picture(self.path("a.exr"), other, mentions="not the scene of")
        # Settings are no part of it: they are the picture's.
        other.write_text(json.dumps({**SCENE, "render": {"samples_per_pixel": 9, "seed": 3},
                                     "image": {"width": 9, "height": 9}}))
        self.verified(self.path("a.exr"), other, "--all")

    def test_an_adaptive_8_bit_picture_can_only_be_rendered_again(self):
        report, _ = self.rendered(*ADAPTIVE, name="a.png")
        self.verified(self.path("a.png"))
        self.refused_picture(self.path("a.png"), self.scene, mentions="render --like")
        again, _ = self.rendered("--like", self.path("a.png"), name="b.png")
        self.assertEqual(again["image_sha256"], report["image_sha256"])


class Statements(VerifyTest):
    """What a file states beside its colours: extra channels and its error."""

    AOVS = ["--aov", "depth,normal,albedo,sphere,cost,half-width"]
    TRACED = {"Z", "N.X", "N.Y", "N.Z", "albedo.R", "albedo.G", "albedo.B", "sphere", "cost"}

    def test_right_channels_and_errors_are_right_whatever_the_samples(self):
        for options in (["--spp", "4"], ["--spp", "40"], ADAPTIVE, ["--target-error", "0.05"],
                        ["--sampler", "independent", "--spp", "9"]):
            with self.subTest(options=options):
                report, _ = self.rendered(*options, *self.AOVS)
                some = self.verified(self.path("a.exr"), self.scene)
                self.assertEqual(set(some["wrong_in_channels"]), self.TRACED)
                self.assertIn("channel half_width.*", some["not_checked"])
                every = self.verified(self.path("a.exr"), self.scene, "--all")
                self.assertEqual(set(every["wrong_in_channels"]), self.TRACED | {f"half_width.{c}" for c in "RGB"})
                self.assertEqual(set(every["wrong_in_channels"].values()), {0})
                self.assertEqual(every["error"]["traced"], report["error"]["rmse"])

    def test_a_flipped_bit_of_any_channel_is_found(self):
        self.rendered(*self.AOVS)
        for channel in ("Z", "N.Y", "sphere", "cost", "half_width.G"):
            def flip(values):
                value = values[channel][5]
                values[channel][5] = value ^ 1 if channel == "sphere" else next_float(value)
            forge_exr(self.path("a.exr"), self.path("forged.exr"), flip)
            with self.subTest(channel=channel):
                found = self.verified(self.path("forged.exr"), self.scene, "--all", status=1)
                self.assertEqual({name: wrong for name, wrong in found["wrong_in_channels"].items() if wrong},
                                 {channel: 1})
                self.assertIn(f"channel {channel} differs in 1 pixel",
                              self.line(self.path("forged.exr"), self.scene, "--all", status=1))

    def test_some_pixels_detect_an_error_stated_too_low_and_all_pixels_any_wrong_error(self):
        report, _ = self.rendered(name="a.png")
        true = report["error"]["rmse"]
        half = ["--seed", "3", "--pixels", PIXELS // 2]
        for factor, status in ((0.5, 1), (1.5, 0)):
            forge_png(self.path("a.png"), self.path("forged.png"), lambda pixels: None,
                      lambda pixels: {"parray:error:rmse": repr(factor * true)})
            with self.subTest(factor=factor):
                some = self.verified(self.path("forged.png"), self.scene, *half, status=status)
                self.assertEqual(some["error"]["right"], status == 0)
                self.assertEqual(self.verified(self.path("forged.png"), self.scene, "--all", status=1)["wrong_pixels"], 0)
                if status:
                    self.assertIn("is too low", self.line(self.path("forged.png"), self.scene, *half, status=1))

    def test_what_was_not_checked_is_named(self):
        self.rendered(*ADAPTIVE, *self.AOVS)
        alone = self.verified(self.path("a.exr"))["not_checked"]
        self.assertEqual(alone[:3], ["whether the pixels are what the scene gives", "the stated error",
                                     "how many samples each pixel was given"])
        self.assertIn("channel Z", alone)
        self.rendered()
        self.assertEqual(self.verified(self.path("a.exr"), self.scene)["not_checked"], [])
        self.assertNotIn("not checked", self.line(self.path("a.exr"), self.scene))
        few = self.verified(self.path("a.exr"), self.scene, "--pixels", "9")
        self.assertEqual((few["not_checked"], few["error"]), (["the stated error"], None))


class Like(VerifyTest):
    def again(self, expected, name="a.exr", new="b.png"):
        report, _ = self.rendered("--like", self.path(name), name=new)
        self.assertEqual(report["image_sha256"], expected["image_sha256"])
        self.assertEqual(report["samples"], expected["samples"])
        return report

    def test_like_renders_the_same_bits_again(self):
        for options in (["--sampler", "independent", "--width", "31", "--seed", "9"],
                        ["--precision", "mixed", "--spp", "11", "--max-depth", "4"], ADAPTIVE,
                        ["--target-half-width", "0.04"], ["--time-limit", "0.3"],
                        ["--target-error", "0.006", "--adaptive", "off"],
                        ["--spp", "70", "--adaptive", "on"]):
            with self.subTest(options=options):
                report, _ = self.rendered(*options)
                again = self.again(report)
                self.assertEqual(again["precision"], report["precision"])
        # A picture that was made again has a recipe as good.
        self.again(report, name="b.png", new="c.png")

    def test_like_of_a_denoised_picture_says_that_the_new_one_is_not_denoised(self):
        made = ["render", self.scene, "-q", "-o"]
        size = ["--width", "48", "--height", "32", "--spp", "8"]
        self.assertEqual(run(*made, self.path("a.exr"), *size, "--denoise").returncode, 0)
        again = run(*made, self.path("b.exr"), "--like", self.path("a.exr"))
        self.assertEqual(again.returncode, 0)
        self.assertRegex(again.stderr, r"\Aparray: --like \S+a\.exr: this picture is denoised, [^\n]* add --denoise [^\n]*\n\Z")
        again = run(*made, self.path("c.exr"), "--like", self.path("a.exr"), "--denoise")
        self.assertEqual((again.returncode, again.stderr), (0, ""))
        self.assertEqual(run("compare", self.path("a.exr"), self.path("c.exr"), "--json").returncode, 0)

    def test_like_of_a_denoised_picture_says_the_same_on_a_farm_and_repeats_it_with_denoise(self):
        says = r"parray: --like \S+a\.exr: this picture is denoised, [^\n]* add --denoise "
        for options in (["--spp", "8"], ["--target-error", "0.08"]):
            made = run("render", self.scene, "-q", "-o", self.path("a.exr"), "--width", "48", "--height", "32", *options, "--denoise")
            self.assertEqual(made.returncode, 0, made.stderr)
            with Farm() as farm:
                farm.start_worker("one")
                for job, output in enumerate(([], ["--wait", "-o", self.path("b.exr"), "-q"]), 1):
                    with self.subTest(options=options, output=output):
                        like = ["submit", self.scene, "--like", self.path("a.exr"), *output]
                        plain = farm.client(*like)
                        self.assertEqual(plain.returncode, 0, plain.stderr)
                        self.assertRegex(plain.stderr, says)
                        again = farm.client(*like, "--denoise")
                        self.assertEqual(again.returncode, 0, again.stderr)
                        self.assertNotIn("--denoise", again.stderr)
                        farm.finish(2 * job)
                        fetched = farm.client("fetch", 2 * job, "-o", self.path("c.exr"))
                        self.assertEqual(fetched.returncode, 0, fetched.stderr)
                        for name in ["c.exr"] + ["b.exr"] * bool(output):
                            compared = run("compare", self.path("a.exr"), self.path(name), "--json")
                            self.assertEqual(compared.returncode, 0, compared.stdout + compared.stderr)

    def test_a_picture_with_other_bits_than_its_original_is_kept_and_reported(self):
        report, _ = self.rendered(*ADAPTIVE, name="a.png")
        forge_png(self.path("a.png"), self.path("forged.png"), lambda pixels: None, lambda pixels: {"parray:seed": "77"})
        with Farm() as farm:
            farm.start_worker("one")
            for name, start in (("b.png", ["render", self.scene]),
                                ("c.png", ["submit", self.scene, "--wait", "--coordinator", farm.address])):
                result = run(*start, "--like", self.path("forged.png"), "-o", self.path(name), "-q")
                self.assertEqual(result.returncode, 1)
                self.assertRegex(result.stderr, r"\Aparray: --like [^\n]*forged\.png: the new picture has different bits: "
                                 rf"image_sha256 [0-9a-f]{{16}}, not {report['image_sha256'][:16]}[^\n]*\n\Z")
                made = read_text(self.path(name))
                self.assertEqual(made["parray:seed"], "77")
                self.assertNotEqual(made["parray:image_sha256"], report["image_sha256"])

    def test_a_recipe_of_another_version_is_refused_before_anything_is_traced(self):
        self.rendered(name="a.png")
        forge_png(self.path("a.png"), self.path("old.png"), lambda pixels: None,
                  lambda pixels: {"parray:trace_version": "4"})
        result = run("render", self.scene, "--like", self.path("old.png"), "-o", self.path("b.png"))
        self.assertEqual((result.returncode, result.stdout), (2, ""))
        self.assertRegex(result.stderr, r"\Aparray: [^\n]*traced by other rules \(trace_version 4[^\n]*\n\Z")
        self.assertFalse(self.path("b.png").exists())

    def test_options_that_do_not_decide_the_bits_are_allowed(self):
        report, _ = self.rendered(*ADAPTIVE)
        again, _ = self.rendered("--like", self.path("a.exr"), "--accelerator", "octree", "--threads",
                                 "1", "--schedule", "static", "--aov", "depth", name="b.exr")
        self.assertEqual(again["image_sha256"], report["image_sha256"])

    def test_like_repeats_a_job_of_a_farm_on_this_machine_and_on_the_farm(self):
        with Farm() as farm:
            farm.start_worker("one")
            report = farm.finish(farm.submit(self.scene, *ADAPTIVE))
            fetched = farm.client("fetch", 1, "-o", self.path("a.exr"))
            self.assertEqual(fetched.returncode, 0, fetched.stderr)
            again = farm.finish(farm.submit(self.scene, "--like", self.path("a.exr")))
        self.assertEqual(again["image_sha256"], report["image_sha256"])
        self.again(report)

    @unittest.skipIf(why_not(), why_not())
    def test_parray_mpi_makes_the_same_bits_again(self):
        report, _ = self.rendered(*ADAPTIVE)
        with MpiRun(2, self.scene, "--threads", "1", "--like", self.path("a.exr"), picture="a.exr") as job:
            self.assertEqual(job.finish()["image_sha256"], report["image_sha256"])
            self.assertIn("samples", read_exr(job.picture)[1])

    def test_options_without_an_effect_are_refused(self):
        self.rendered()
        picture = self.path("a.exr")
        for option in (["--pixels", "9"], ["--all"], ["--seed", "1"], ["--threads", "1"]):
            self.refused_picture(picture, *option, mentions=f"{option[0]} requires SCENE; see `parray verify --help`")
        for option in (["--pixels", "9"], ["--seed", "1"]):
            self.refused_picture(picture, self.scene, *option, "--all", mentions="exclude each other: leave one of them out")

    def test_options_that_decide_the_picture_another_scene_and_no_recipe_are_refused(self):
        self.rendered()
        self.before = self.files()
        like = ["-o", self.path("b.exr"), "--like", self.path("a.exr")]
        for option in (["--spp", "8"], ["--width", "40"], ["--seed", "7"], ["--precision", "auto"],
                       ["--target-error", "0.1"], ["--passes", "9"], ["--adaptive", "on"]):
            self.refused("render", self.scene, *like, *option, mentions=f"{option[0]} and --like")
            self.refused("submit", self.scene, "--wait", *like, *option,
                         mentions=f"{option[0]} and --like")
        atoms = self.path("atoms.xyz")
        atoms.write_text("1\n\nH 0 0.5 0\n")
        self.before = self.files()
        self.refused("render", atoms, *like, mentions="not the scene of")
        self.refused("render", self.scene, "-o", self.path("b.exr"), "--like", atoms,
                     mentions="atoms.xyz")


if __name__ == "__main__":
    unittest.main()
