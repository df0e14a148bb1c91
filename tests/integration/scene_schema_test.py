#!/usr/bin/env python3
"""The JSON schema of scenes takes what the reader takes and refuses what it refuses.

The reader's half of the agreement is tests/unit/cli/input/scene_file/scene_reader_test.cpp, over the same cases.
"""

import copy
import json
import pathlib
import runpy
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
