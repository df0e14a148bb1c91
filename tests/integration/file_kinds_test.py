#!/usr/bin/env python3
"""Kinds of files: the content decides, compressed or not, from a pipe or from the standard input; and what `validate`
prints about particles."""

import bz2
import gzip
import json
import lzma
import subprocess
import unittest

from cli_usage_test import SCENE, CliTest
from farm import BIN, SCENES, run

HELIX = SCENES / "particles" / "helix.pdb"
SMALL = ["--width", "20", "--height", "15", "--spp", "1", "-q"]
MESH = """ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
0 1 0
3 0 1 2
"""


class FileTest(CliTest):
    def setUp(self):
        super().setUp()
        self.before = self.files()

    def put(self, name, data):
        data = data.encode() if isinstance(data, str) else data
        self.path(name).write_bytes(data)
        return self.path(name)

    def facts(self, file, data=None):
        result = subprocess.run([BIN / "parray", "validate", file, "--json"], input=data, capture_output=True, check=False)
        self.assertEqual(result.returncode, 0, result.stderr)
        return json.loads(result.stdout)


class Contents(FileTest):
    def test_a_scene_and_a_molecule_need_no_name_and_may_be_packed(self):
        for source in (HELIX, self.scene):
            data = source.read_bytes()
            expected = self.facts(source)["scene_sha256"]
            for name, kept in (("noname", data), ("a.xyz", data), ("a.json", data), ("b", gzip.compress(data)),
                               ("c.gz", bz2.compress(data)), ("d.pdb", lzma.compress(data))):
                with self.subTest(source=source.name, name=name):
                    self.assertEqual(self.facts(self.put(name, kept))["scene_sha256"], expected)

    def test_standard_input_and_pipes_are_scenes_to_every_command(self):
        data = gzip.compress(HELIX.read_bytes())
        expected = self.facts(HELIX)
        self.assertEqual(self.facts("-", data)["scene_sha256"], expected["scene_sha256"])
        self.assertEqual(self.facts("-", data)["file"], "standard input")
        self.assertEqual(self.facts("-", self.scene.read_bytes())["format"], "v1")
        for command in (["render", "-", "-o", self.path("a.png"), *SMALL],
                        ["convert", "-", self.path("a.json"), "--expand"],
                        ["render", "/dev/stdin", "-o", self.path("b.png"), *SMALL]):
            with self.subTest(command[0]):
                done = subprocess.run([BIN / "parray", *command], input=data, capture_output=True, check=False)
                self.assertEqual((done.returncode, done.stderr), (0, b""))
        self.assertEqual(self.facts(self.path("a.json"))["scene_sha256"], expected["scene_sha256"])

    def test_where_standard_input_cannot_serve_one_line_says_why(self):
        def refusal(*arguments, data=b""):
            done = subprocess.run([BIN / "parray", *arguments], input=data, capture_output=True, text=False, check=False)
            self.assertEqual(done.returncode, 2)
            self.assertEqual(done.stderr.count(b"\n"), 1)
            return done.stderr.decode()

        self.assertIn("standard input has no name for a scene to refer to: add --expand",
                      refusal("convert", "-", self.path("a.json"), data=HELIX.read_bytes()))
        self.assertIn("standard input: the file is empty", refusal("validate", "-"))
        self.assertIn("standard input can be read only once: save it as a file",
                      refusal("submit", "-", "--frames", "0-3", "--coordinator", "tcp://127.0.0.1:1"))

    def test_what_is_neither_is_told_for_what_it_looks_like(self):
        for name, data, mentions in (("scene.json", "<!DOCTYPE html><html>", "an HTML page: check that the download succeeded"),
                                     ("a.xyz", "version https://git-lfs.github.com/spec/v1\n", "a Git LFS pointer"),
                                     ("dump.melt", "LAMMPS (23 Jun 2022)\n", "a log of LAMMPS: name the dump"),
                                     ("a", "Dear Sir\n", "text that begins with 'Dear Sir'"),
                                     ("s.json", "{}".encode("utf-16"), "UTF-16 text: save the file as UTF-8")):
            with self.subTest(name):
                file = self.put(name, data)
                for command in (["validate", file], ["render", file, "-o", self.path("a.png")],
                                ["convert", file, self.path("a.json")]):
                    result = run(*command)
                    self.assertEqual(result.returncode, 2)
                    self.assertTrue(result.stderr.startswith(f"parray: {file}: "), result.stderr)
                    self.assertIn(mentions, result.stderr)
                    self.assertEqual(result.stderr.count("\n"), 1)
                    self.assertNotIn("NaN", result.stderr)


class Particles(FileTest):
    def test_validate_tells_what_is_in_a_file_of_particles(self):
        facts = self.facts(self.put("a", lzma.compress(HELIX.read_bytes())))
        self.assertEqual((facts["format"], facts["spheres"]), ("particles", 70))
        file, = facts["particle_files"]
        self.assertEqual((file["format"], file["packing"], file["particles"]), ("PDB", "xz", 68))
        self.assertEqual(file["elements"], {"C": 36, "O": 18, "N": 12, "S": 2})
        self.assertEqual((file["frame"], file["notes"]), (0, []))
        self.assertEqual((file["box"]["low"][1], file["box"]["high"][1]), (-9.661, 10.345))
        text = run("validate", HELIX).stdout
        self.assertRegex(text, r"format +PDB: particles, in an automatic scene\n")
        self.assertRegex(text, r"particles +68: C 36, O 18, N 12, S 2\n")
        self.assertRegex(text, r"spheres +70 and 128 capsules: .*, surroundings included\n")

    def test_numbers_of_particles_are_told_with_their_range(self):
        file, = self.facts(self.put("a.csv", "x,y,z,radius,type\n0,0,0,1,a\n1,0,0,2,b\n5,0,0,2,b\n"))["particle_files"]
        self.assertEqual(file["properties"]["radius"], {"low": 1, "high": 2, "missing": 0})
        self.assertEqual((file["types"], file["type_count"]), ({"a": 1, "b": 2}, 2))
        self.assertNotIn("elements", file)

    def test_units_and_guessed_columns_of_a_table_are_told(self):
        table = self.put("a.csv", "x [m],y [m],z [m],speed [m/s]\n0,0,0,1\n1,0,0,2\n")
        file, = self.facts(table)["particle_files"]
        self.assertEqual(file["unit"], "m")
        self.assertEqual(file["properties"]["speed"], {"low": 1, "high": 2, "missing": 0, "unit": "m/s"})
        text = run("validate", table).stdout
        self.assertRegex(text, r"positions +x 0 to 1, y 0 to 0, z 0 to 0 m\n")
        self.assertRegex(text, r"speed +1 to 2 m/s\n")
        file, = self.facts(self.put("b.xyz", "0 0 0 0.5\n1 1 1 0.25\n"))["particle_files"]
        self.assertEqual(file["notes"], [{"key": "guessed_columns", "count": 2, "text": "particles in a table "
                                          "without names of columns, read as x, y, z, radius"}])

    def test_a_scene_tells_of_each_file_that_it_names(self):
        self.put("mesh.ply", MESH)
        scene = self.put("s.json", json.dumps({**SCENE, "particles": [{"file": "mesh.ply", "radius": 1, "material": "gold"},
                                                                      {"file": str(HELIX)}]}))
        files = self.facts(scene)["particle_files"]
        self.assertEqual([(f["format"], f["particles"]) for f in files], [("PLY", 3), ("PDB", 68)])
        text = run("validate", scene).stdout
        self.assertRegex(text, r"particles +\S*mesh.ply: PLY, 3 particles\n")
        self.assertRegex(text, r"note +1 face of a mesh not shown\n")

    def test_what_a_reader_leaves_out_is_told_by_every_command_and_in_the_report(self):
        mesh = self.put("mesh.ply", MESH)
        line = f"parray: {mesh}: 1 face of a mesh not shown\n"
        note = {"key": "faces", "count": 1, "text": "face of a mesh not shown"}
        report = self.path("r.json")
        for command in (["validate", mesh], ["convert", mesh, self.path("a.json")],
                        ["render", mesh, "-o", self.path("a.png"), "--report", report, *SMALL]):
            result = run(*command)
            self.assertEqual((result.returncode, result.stderr), (0, line))
        self.assertEqual(json.loads(report.read_text())["notes"], [{"file": str(mesh), **note}])
        self.assertEqual(self.facts(mesh)["particle_files"][0]["notes"], [note])
        run("render", HELIX, "-o", self.path("a.png"), "--report", report, *SMALL)
        self.assertNotIn("notes", json.loads(report.read_text()))


if __name__ == "__main__":
    unittest.main()
