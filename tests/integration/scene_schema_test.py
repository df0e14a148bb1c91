#!/usr/bin/env python3
"""The JSON schema of scenes accepts and refuses the same as the reader.

The reader's half of the agreement is tests/unit/cli/input/scene_file/scene_reader_test.cpp, over the same cases.
"""

import copy
import json
import os
import pathlib
import runpy
import subprocess
import unittest

import jsonschema

ROOT = pathlib.Path(__file__).resolve().parents[2]


def load(path):
    return json.loads((ROOT / path).read_text(encoding="utf-8"))


def merge_patch(target, patch):
    """RFC 7386."""
    if not isinstance(patch, dict):
        return patch
    target = dict(target) if isinstance(target, dict) else {}
    for key, value in patch.items():
        if value is None:
            target.pop(key, None)
        else:
            target[key] = merge_patch(target.get(key), value)
    return target


class SceneSchema(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.schema = load("scenes/schema/scene.v1.schema.json")
        cls.validator = jsonschema.Draft7Validator(cls.schema)
        cls.cases = load("tests/unit/cli/input/scene_file/scene_cases.json")

    def document(self, case):
        if "document" in case:
            return case["document"]
        return merge_patch(copy.deepcopy(self.cases["base"]), case["patch"])

    def test_the_schema_is_a_schema(self):
        jsonschema.Draft7Validator.check_schema(self.schema)

    def test_good_cases_are_accepted(self):
        for case in self.cases["good"]:
            with self.subTest(case["name"]):
                self.validator.validate(self.document(case))

    def test_bad_cases_are_refused(self):
        self.assertGreater(len(self.cases["bad"]), 50)
        for case in self.cases["bad"]:
            with self.subTest(case["name"]):
                self.assertFalse(self.validator.is_valid(self.document(case)))

    def test_shipped_scenes_are_accepted(self):
        paths = sorted((ROOT / "scenes").glob("**/*.json"))
        paths = [path for path in paths if path.parent.name != "schema"]
        self.assertGreaterEqual(len(paths), 23)
        for path in paths:
            with self.subTest(path.name):
                self.validator.validate(json.loads(path.read_text(encoding="utf-8")))


class Descriptions(unittest.TestCase):
    """The program's descriptions of settings and sections decide; see scenes/schema/renew."""

    @classmethod
    def setUpClass(cls):
        cls.text = subprocess.run([os.environ["PARRAY_BIN_DIR"] + "/settings-document"], check=True,
                                  capture_output=True, text=True).stdout
        cls.document = json.loads(cls.text)

    def keys_of(self, *sections):
        return {key for section in sections for key in self.document["sections"][section]["properties"]}

    def test_the_schema_python_and_the_http_service_are_as_described(self):
        check = subprocess.run([ROOT / "scenes/schema/renew", "--check", "-"], input=self.text,
                               capture_output=True, text=True)
        self.assertEqual(check.stderr, "")
        self.assertEqual(check.returncode, 0)

    def test_a_difference_is_found(self):
        other = copy.deepcopy(self.document)
        other["sections"]["camera"]["properties"]["vfov"]["maximum"] = 5
        del other["sections"]["render"]["properties"]["seed"]
        other["keywords"]["depth"] = {"python": "int", "schema": {"type": "integer"}}
        check = subprocess.run([ROOT / "scenes/schema/renew", "--check", "-"], input=json.dumps(other),
                               capture_output=True, text=True)
        self.assertEqual(check.returncode, 1)
        for found in ("camera: vfov is ", "render: seed is in the schema only", "Python: other keywords",
                      "HTTP: depth differs from the description"):
            self.assertIn(found, check.stderr)

    def test_python_knows_the_keys_of_sections(self):
        python = runpy.run_path(str(ROOT / "python/src/parray/options.py"))
        self.assertEqual(set(python["Camera"].__annotations__), self.keys_of("camera"))
        self.assertEqual(set(python["Sky"].__annotations__), self.keys_of("sky"))
        self.assertEqual(set(python["_DRAWN"]), self.keys_of("finishing", "labels"))
        self.assertLessEqual(self.keys_of("finishing", "labels"), set(python["RenderOptions"].__annotations__))


class GeneratedScenes(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.generate = runpy.run_path(str(ROOT / "scenes/generate"))

    def test_shipped_scenes_are_what_the_generator_writes(self):
        for name, scene in self.generate["shipped"]().items():
            with self.subTest(name):
                shipped = (ROOT / "scenes" / name).read_text(encoding="utf-8")
                self.assertEqual(shipped, scene.text())

    def test_one_weekend_has_exactly_so_many_spheres(self):
        for count in (4, 5, 9, 100, 1000):
            self.assertEqual(len(self.generate["one_weekend"](count).spheres), count)


if __name__ == "__main__":
    unittest.main()
