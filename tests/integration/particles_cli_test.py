#!/usr/bin/env python3
"""Particles on the command line: scenes that name particle files, automatic scenes, and convert."""

import json
import os
import pathlib
import resource
import subprocess
import unittest

import jsonschema

from cli_usage_test import SCENE, CliTest
from farm import BIN, SCENES, Farm, run
from png import read_text

MOLECULES = {"caffeine.xyz": 24, "helix.pdb": 68}
SMALL = ["--width", "40", "--height", "30", "--spp", "4"]


class ParticlesTest(CliTest):
    def setUp(self):
        super().setUp()
        self.write("atoms.xyz", "3\n\nO 0 0 0\nH 0.96 0 0\nH -0.24 0.93 0\n")
        self.write("points.csv", "x,y,z\n0,0,0\n0,0,4\n0,3,0\n")
        self.write_scene({"file": "atoms.xyz"})
        self.before = self.files()

    def write(self, name, text):
        self.path(name).write_text(text)

    def write_scene(self, *particles):
        self.scene.write_text(json.dumps({**SCENE, "particles": particles}))

    def facts(self, scene):
        result = run("validate", scene, "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        return json.loads(result.stdout)

    def identity(self, scene):
        return self.facts(scene)["scene_sha256"]

    def convert(self, *arguments, **options):
        result = run("convert", *arguments, **options)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        return result.stdout


class Refusals(ParticlesTest):
    def test_files_of_particles_that_are_not_there_are_refused_with_the_place_in_the_scene(self):
        self.write_scene({"file": "atoms.xyz"}, {"file": "none.xyz"})
        for command in (["validate"], ["render", "-o", self.path("a.png")], ["submit"],
                        ["convert", self.path("a.json")]):
            name, *rest = command
            self.refused(name, *([self.scene, *rest]), mentions="scene.json:1: /particles/1/file: ")
            self.refused(name, *([self.scene, *rest]), mentions="none.xyz: no such file")
        self.refused("render", self.path("none.pdb"), "-o", self.path("a.png"),
                     mentions="none.pdb: no such file")

    def test_columns_that_the_file_lacks_are_refused_with_those_that_it_has(self):
        self.write_scene({"file": "atoms.xyz", "radius": "column"})
        self.refused("validate", self.scene, mentions="scene.json:1: /particles/0/radius: atoms.xyz "
                                                      "has no radii: use by-element or a number")
        self.write_scene({"file": "atoms.xyz", "material": "column"})
        self.refused("validate", self.scene, mentions="/particles/0/material: atoms.xyz has no colours")
        self.write_scene({"file": "points.csv", "radius": 1, "material": "gold"},
                         {"file": "points.csv", "material": "gold"})
        self.refused("validate", self.scene, mentions="/particles/1/radius: points.csv has no radii or "
                                                      "elements: use a number")
        out = self.path("a.json")
        self.refused("convert", self.path("atoms.xyz"), out, "--radius", "column",
                     mentions="atoms.xyz has no radii: use by-element or a number")
        self.refused("convert", self.path("points.csv"), out, "--material", "by-element",
                     mentions="points.csv has no elements: use plain")

    def test_rules_that_are_none_are_refused_by_option(self):
        arguments = ["convert", self.path("atoms.xyz"), self.path("a.json")]
        for value in ("0", "-1", "1e16", "nan", "inf", "1e400", "", " 1", "1 ", "0x1", "by-type",
                      "big"):
            self.refused(*arguments, "--radius", value, mentions="--radius:")
        for value in ("gold", "", "by-elements"):
            self.refused(*arguments, "--material", value, mentions="--material:")
        self.refused(*arguments, "--material", "by-elements", mentions="did you mean 'by-element'?")
        self.refused("convert", self.path("atoms.xyz"), mentions="OUT.json")

    def test_selections_and_colours_that_are_none_are_refused_by_option(self):
        arguments = ["convert", self.path("atoms.xyz"), self.path("a.json")]
        for option, value, mentions in (
                ("--select", "element O und z", "--select: character 11: 'und' is not an element"),
                ("--select", "", "--select: the selection is empty"),
                ("--select", "z > 5", "--select: the selection leaves none of 3 particles: there are z from 0 to 0"),
                ("--select", "chain A", "--select: character 1: the file has no chains: it has elements"),
                ("--slice", "z", "--slice: 'z' is not a slice: write z=10:20"),
                ("--hide", "hydrogen,watr", "--hide: 'watr' is not a class of particles: did you mean 'water'?"),
                ("--color-by", "charge", "--color-by: the file has no numeric column 'charge'"),
                ("--color-by", '"radius"', "the file has no numeric column '\"radius\"'"),
                ("--colormap", "virids", "did you mean 'viridis'?"),
                ("--colormap", "viridis", "--colormap has no effect without --color-by: add it"),
                ("--range", "5", "--range: '5' is not a range"),
                ("--material=by-type", "--color-by=type", "--color-by: --material is by-type, which also sets"),
                ("--radius=1", "--radius-by=z", "--radius-by excludes --radius: leave out one of them")):
            with self.subTest(option=option, value=value):
                self.refused(*arguments, option, value, mentions=mentions)

    def test_places_that_cannot_be_written_to_are_refused_before_anything_is_read(self):
        missing = self.path("none.xyz")
        for name, mentions in (("a.png", ".json"), ("a", ".json"), ("none/a.json", "does not exist"),
                               ("x" * 300 + ".json", "too long")):
            self.refused("convert", missing, self.path(name), mentions=mentions)
        self.refused("convert", self.scene, self.scene, mentions="is an input file")
        self.path("folder.json").mkdir()
        self.before = self.files()
        self.refused("convert", missing, self.path("folder.json"), mentions="directory")

    def test_options_for_particles_are_refused_for_scenes(self):
        for option in (["--radius", "1"], ["--material", "column"], ["--expand"],
                       ["--width", "100"]):
            self.refused("convert", self.scene, self.path("a.json"), *option,
                         mentions="scene.json is not a particle file")

    def test_a_portrait_has_the_size_of_a_picture_at_most(self):
        self.refused("convert", self.path("atoms.xyz"), self.path("a.json"), "--width", "65536", "--height", "65536",
                     mentions="--width, --height: ")

    @unittest.skipIf(os.environ.get("PARRAY_SANITIZED"), "its OpenMP has a file that becomes too large")
    def test_a_full_disk_is_a_failure_that_leaves_what_was_there(self):
        self.path("a.json").write_text("an older scene")
        small = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
        result = subprocess.run([BIN / "parray", "convert", SCENES / "one-weekend-484.json",
                                 self.path("a.json")], preexec_fn=small, capture_output=True,
                                text=True, check=False)
        self.assertEqual(result.returncode, 1)
        self.assertEqual(result.stderr, f"parray: writing {self.path('a.json')}: File too large\n")
        self.assertEqual(self.path("a.json").read_text(), "an older scene")
        self.assertEqual(self.files(), self.before | {"a.json"})


class Conversions(ParticlesTest):
    def test_scenes_read_back_as_themselves(self):
        seed = pathlib.Path(__file__).parent / "seed-scene.json"
        for scene in (*sorted(SCENES.glob("*.json")), seed, self.scene):
            with self.subTest(scene.name):
                out = self.path("out.json")
                self.convert(scene, out)
                before, after = self.facts(scene), self.facts(out)
                for facts in (before, after):
                    facts.pop("file")
                    facts.pop("format")
                    facts.pop("particle_files")
                self.assertEqual(after, before)
                self.assertNotIn("particles", json.loads(out.read_text()))

    def test_a_portrait_is_framed_for_the_size_asked_for(self):
        """As `render` frames it: that scene is the same to the last bit."""
        size = ["--width", "100", "--height", "200"]
        self.convert(self.path("atoms.xyz"), self.path("tall.json"), *size)
        self.assertEqual(json.loads(self.path("tall.json").read_text())["image"], {"width": 100, "height": 200})
        report = self.path("report.json")
        self.assertEqual(run("render", self.path("atoms.xyz"), *size, "--spp", "1", "--quiet", "-o", self.path("a.png"),
                             "--report", report).returncode, 0)
        self.assertEqual(self.identity(self.path("tall.json")), json.loads(report.read_text())["scene_sha256"])

    def test_an_automatic_scene_is_the_same_with_and_without_convert(self):
        for name, count in MOLECULES.items():
            with self.subTest(name):
                molecule = SCENES / "particles" / name
                portrait = self.facts(molecule)
                self.assertEqual((portrait["format"], portrait["spheres"]),
                                 ("particles", count + 2))
                reference, spheres = self.path("reference.json"), self.path("spheres.json")
                self.convert(molecule, reference)
                self.convert(molecule, spheres, "--expand")
                self.assertEqual(self.identity(reference), portrait["scene_sha256"])
                self.assertEqual(self.identity(spheres), portrait["scene_sha256"])
                self.assertEqual(len(json.loads(reference.read_text())["spheres"]), 2)
                self.assertEqual(len(json.loads(spheres.read_text())["spheres"]), count + 2)

    def test_a_reference_leads_from_the_scene_to_the_file_wherever_the_command_was_run(self):
        (self.path("scenes") / "deep").mkdir(parents=True)
        out = self.path("scenes") / "deep" / "a.json"
        subprocess.run([BIN / "parray", "convert", "atoms.xyz", "scenes/deep/a.json"],
                       cwd=self.directory, check=True, capture_output=True)
        self.assertEqual(json.loads(out.read_text())["particles"],
                         [{"file": "../../atoms.xyz", "style": "balls-and-sticks", "material": "by-element",
                           "radius": "by-element"}])
        self.assertEqual(self.identity(out), self.identity(self.path("atoms.xyz")))
        self.path("link").symlink_to(out.parent)
        self.convert(self.path("atoms.xyz"), self.path("link") / "b.json")
        self.assertEqual(self.identity(out.parent / "b.json"), self.identity(out))

    def test_rules_are_written_as_asked(self):
        out = self.path("a.json")
        for options, material, radius in (([], "plain", None), (["--radius", "0.1"], "plain", 0.1),
                                          (["--material", "plain", "--radius", "1e-3"], "plain",
                                           0.001)):
            self.convert(self.path("points.csv"), out, *options)
            particles = json.loads(out.read_text())["particles"][0]
            self.assertEqual(particles["material"], material)
            self.assertEqual(particles["radius"], radius or particles["radius"])
            self.assertGreater(particles["radius"], 0)
        self.convert(self.path("atoms.xyz"), out, "--material", "by-type", "--radius", "by-element")
        particles = json.loads(out.read_text())["particles"][0]
        self.assertEqual((particles["material"], particles["radius"]), ("by-type", "by-element"))

    def test_selections_and_colours_are_kept_by_reference_and_applied_by_expand(self):
        options = ["--select", "not element O", "--hide", "ions", "--color-by", "x", "--colormap", "magma",
                   "--range", "1%:99%"]
        refused = self.path("no.json")
        self.refused("convert", self.path("atoms.xyz"), refused, *options, mentions="--hide: ")
        options[3] = "none"
        kept, expanded = self.path("kept.json"), self.path("expanded.json")
        told = run("convert", self.path("atoms.xyz"), kept, *options)
        self.assertEqual(told.returncode, 0, told.stderr)
        self.assertIn("atoms.xyz: 1 particle not selected", told.stderr)
        item = json.loads(kept.read_text())["particles"][0]
        self.assertEqual({key: item.get(key) for key in ("select", "hide", "color_by", "colormap", "range")},
                         {"select": "not element O", "hide": [], "color_by": "x", "colormap": "magma",
                          "range": "1%:99%"})
        self.assertNotIn("material", item)
        self.assertEqual(run("convert", self.path("atoms.xyz"), expanded, *options, "--expand").returncode, 0)
        self.assertEqual(self.facts(expanded)["spheres"], 2 + 2)
        self.assertEqual(self.identity(expanded), self.identity(kept))

    def test_what_is_written_is_said_and_replaces_what_was_there(self):
        out = self.path("a.json")
        self.assertEqual(self.convert(self.path("atoms.xyz"), out),
                         f"wrote {out}: 2 spheres and the particles of atoms.xyz\n")
        self.assertEqual(self.convert(self.path("atoms.xyz"), out, "--expand"),
                         f"wrote {out}: 5 spheres and 4 capsules\n")
        self.assertEqual(self.files(), self.before | {"a.json"})

    def test_converted_scenes_follow_the_schema(self):

        schema = json.loads((SCENES / "schema/scene.v1.schema.json").read_text())
        out = self.path("a.json")
        for name in MOLECULES:
            for options in ([], ["--expand"], ["--style", "sticks", "--stick-radius", "0.2", "--bonds", "auto"],
                            ["--style", "flat,sticks", "--expand"]):
                self.convert(SCENES / "particles" / name, out, *options)
                jsonschema.validate(json.loads(out.read_text()), schema)

    def test_arrows_and_a_solid_cell_are_kept_by_reference_and_are_capsules_when_expanded(self):
        self.write("moving.xyz", "1\nLattice=\"9 0 0 0 9 0 0 0 9\" Properties=species:S:1:pos:R:3:velo:R:3\nAr 1 1 1 0 0 3\n")
        options = ["--arrows", "velocity", "--arrow-scale", "0.5", "--solid-cell", "--bonds", "off", "--show", "all",
                   "--style", "sticks"]
        kept, expanded = self.path("kept.json"), self.path("expanded.json")
        self.convert(self.path("moving.xyz"), kept, *options)
        self.convert(self.path("moving.xyz"), expanded, *options, "--expand")
        item = json.loads(kept.read_text())["particles"][0]
        self.assertEqual((item["arrows"], item["arrow_scale"], item["solid_cell"]), ("velocity", 0.5, True))
        self.assertEqual(item["show"][0]["style"], "sticks")
        self.assertEqual(len(json.loads(expanded.read_text())["capsules"]), 21 + 12)
        self.assertEqual(self.identity(expanded), self.identity(kept))
        schema = json.loads((SCENES / "schema/scene.v1.schema.json").read_text())
        for file in (kept, expanded):
            jsonschema.validate(json.loads(file.read_text()), schema)

    def test_a_material_of_capsules_alone_and_particles_keep_the_identity_of_the_scene(self):
        capsule = {"from": [0, 5, 0], "to": [1, 5, 0], "radius": 0.2, "material": "rod"}
        rod = {"rod": {"type": "metal", "albedo": [0.5, 0.4, 0.3], "fuzz": 0}}
        self.scene.write_text(json.dumps({**SCENE, "materials": {**SCENE["materials"], **rod}, "capsules": [capsule],
                                          "particles": [{"file": "atoms.xyz"}]}))
        out = self.path("out.json")
        self.convert(self.scene, out)
        self.assertEqual(self.identity(out), self.identity(self.scene))

    def test_a_converted_scene_keeps_the_unit_of_its_scale_bar_but_no_label_that_only_a_particle_file_has(self):
        self.write("box.xyz", "1\nLattice=\"9 0 0 0 9 0 0 0 9\" Properties=species:S:1:pos:R:3 Time=1.5\nAr 1 1 1\n")
        labels = {"legend": True, "legend_title": "element", "scale_bar": True, "time_stamp": True, "cell": True, "text": "argon"}
        self.scene.write_text(json.dumps({**SCENE, "labels": labels, "particles": [{"file": "box.xyz", "color_by": "element"}]}))
        out = self.path("out.json")
        self.convert(self.scene, out)
        self.assertEqual(json.loads(out.read_text())["labels"], {"scale_bar": True, "unit": "angstrom", "text": "argon"})
        self.assertEqual(self.identity(out), self.identity(self.scene))

    def test_sticks_arrows_and_cells_that_a_file_lacks_are_refused_in_one_line(self):
        for options, mentions in ((["--bonds", "file"], "--bonds: the file states no bonds"),
                                  (["--arrows", "velocity"], "--arrows: the file has no vectors 'velocity'"),
                                  (["--arrow-scale", "2"], "--arrow-scale has no effect without --arrows: add it"),
                                  (["--solid-cell"], "--solid-cell: the file has no box and no cell"),
                                  (["--style", "spheres", "--stick-radius", "1"], "--stick-radius has no effect on --style spheres")):
            self.refused("convert", self.path("atoms.xyz"), self.path("no.json"), *options, mentions=mentions)


class Crystals(ParticlesTest):
    def setUp(self):
        super().setUp()
        self.write("po.xyz", "1\nLattice=\"3.35 0 0 0 3.35 0 0 0 3.35\" Properties=species:S:1:pos:R:3\nPo 0 0 0\n")
        self.before = self.files()

    def render(self, *options):
        result = run("render", self.path("po.xyz"), "-o", self.path("a.png"), "--spp", "2", "-q", *options)
        self.assertEqual(result.returncode, 0, result.stderr)
        return read_text(self.path("a.png")).get("parray:finished")

    def test_the_cell_is_drawn_by_default_where_it_fits(self):
        large = ["--width", "300", "--height", "240"]
        self.assertEqual(self.render(*large), "cell")
        self.assertEqual(self.render(*large, "--scale-bar"), "scale-bar, cell")
        self.assertIsNone(self.render(*large, "--crystal", "off"))
        self.assertIsNone(self.render(*large, "--labels", "off"))
        self.assertIsNone(self.render("--width", "24", "--height", "16"))
        self.before = self.files()
        self.refused("render", self.path("po.xyz"), "-o", self.path("b.png"), "--width", "24", "--height", "16", "--cell",
                     mentions="--cell: the label does not fit")

    def test_options_of_the_cell_reach_the_converted_scene_which_follows_the_schema(self):
        out = self.path("a.json")
        result = run("convert", self.path("po.xyz"), out, "--replicate", "2x1x1", "--wrap", "--whole", "--center", "all")
        self.assertEqual(result.returncode, 0, result.stderr)
        scene = json.loads(out.read_text())
        jsonschema.validate(scene, json.loads((SCENES / "schema/scene.v1.schema.json").read_text()))
        self.assertEqual(scene["particles"], [{"file": "po.xyz", "crystal": True, "replicate": "2x1x1", "wrap": True,
                                               "whole": True, "center": "all", "material": "by-element",
                                               "radius": "covalent"}])
        self.assertEqual(scene["labels"], {"cell": True})
        expanded = self.path("b.json")
        self.assertEqual(run("convert", self.path("po.xyz"), expanded, "--expand").returncode, 0)
        self.assertEqual(self.facts(expanded)["spheres"], 2 + 8)
        self.assertNotIn("labels", json.loads(expanded.read_text()))

    def test_options_of_the_cell_are_refused_without_a_cell_and_for_scenes(self):
        for options in (["--replicate", "2x2x2"], ["--wrap"], ["--whole"], ["--center", "all"], ["--crystal", "on"]):
            self.refused("render", self.path("atoms.xyz"), "-o", self.path("a.png"), *options,
                         mentions=f"{options[0]}: the file has no box and no cell")
            self.refused("render", self.scene, "-o", self.path("a.png"), *options,
                         mentions=f"{options[0]}: {self.scene} is not a particle file")
        for text in ("3", "0x1x1", "1.5x1x1", "-1x2x2", "4294967297x1x1"):
            self.refused("render", self.path("po.xyz"), "-o", self.path("a.png"), "--replicate", text,
                         mentions=f"--replicate: '{text}' is not a number of copies")
        self.refused("render", self.path("po.xyz"), "-o", self.path("a.png"), "--replicate", "99999999x99999999x9",
                     mentions="are more than 100000000 spheres")


class Pictures(ParticlesTest):
    def render(self, scene, *options):
        report = self.path("report.json")
        result = run("render", scene, "-o", self.path("a.png"), "--report", report, "-q", *options)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        return json.loads(report.read_text())

    def test_a_scene_with_particles_is_the_picture_of_its_spheres(self):
        report = self.render(self.scene)
        self.assertEqual(report["spheres"], len(SCENE["spheres"]) + 3)
        self.convert(self.scene, self.path("spheres.json"))
        self.assertEqual(self.render(self.path("spheres.json"))["image_sha256"],
                         report["image_sha256"])

    def test_a_file_of_particles_renders_and_is_framed_for_the_size_asked_for(self):
        report = self.render(self.path("atoms.xyz"), *SMALL)
        self.assertEqual((report["spheres"], report["width"], report["samples_per_pixel"]), (5, 40, 4))
        self.assertEqual(report["nonfinite_samples"], 0)
        self.assertEqual(self.render(self.path("points.csv"), *SMALL)["spheres"], 5)
        tall = self.render(self.path("atoms.xyz"), "--width", "20", "--height", "60", "--spp", "1")
        self.assertNotEqual(tall["scene_sha256"], report["scene_sha256"])
        facts = self.facts(self.path("atoms.xyz"))
        self.assertEqual((facts["width"], facts["height"], facts["target_error"], facts["max_depth"]),
                         (1200, 900, 0.02, 10))

    def test_a_farm_renders_the_same_bits_and_never_sees_the_file(self):
        expected = self.render(self.path("atoms.xyz"), *SMALL)
        with Farm() as farm:
            job = farm.submit(self.path("atoms.xyz"), *SMALL)
            self.path("atoms.xyz").unlink()
            farm.start_worker("one")
            self.assertEqual(farm.finish(job)["image_sha256"], expected["image_sha256"])


if __name__ == "__main__":
    unittest.main()
