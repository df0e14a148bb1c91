#!/usr/bin/env python3
"""The description of the HTTP interface, coordinator/http/openapi.json: every operation has examples, and they fit."""

import json
import pathlib
import unittest

import jsonschema

DOCUMENT = pathlib.Path(__file__).resolve().parents[2] / "coordinator/http/openapi.json"
METHODS = ("get", "put", "post", "delete")
BINARY = ("image/", "application/octet-stream", "application/zip")  # examples of these are of no use


class Examples(unittest.TestCase):
    def setUp(self):
        self.document = json.loads(DOCUMENT.read_text())
        self.resolver = jsonschema.RefResolver("", self.document)

    def resolved(self, part):
        return self.resolver.resolve(part["$ref"])[1] if "$ref" in part else part

    def operations(self):
        """(name, operation with the parameters of its path) of each."""
        for path, item in self.document["paths"].items():
            for method in METHODS:
                if method in item:
                    parameters = item.get("parameters", []) + item[method].get("parameters", [])
                    yield f"{method.upper()} {path}", {**item[method], "parameters": list(map(self.resolved, parameters))}

    def examples(self, operation):
        """(place, its object with schema and example) of whatever needs an example."""
        for parameter in operation["parameters"]:
            if "default" not in self.resolved(parameter["schema"]):
                yield f"parameter {parameter['name']}", parameter
        bodies = [("request", operation["requestBody"])] if "requestBody" in operation else []
        bodies += [(f"response {status}", self.resolved(response)) for status, response in operation["responses"].items()]
        for place, body in bodies:
            for media_type, content in body.get("content", {}).items():
                if not media_type.startswith(BINARY):
                    yield f"{place} {media_type}", content

    def test_every_operation_has_examples_that_fit_their_schemas(self):
        for name, operation in self.operations():
            for place, described in self.examples(operation):
                with self.subTest(f"{name}: {place}"):
                    self.assertIn("schema", described)
                    self.assertIn("example", described)
                    jsonschema.Draft202012Validator(described["schema"], resolver=self.resolver).validate(described["example"])

    def test_an_operation_has_a_name_a_summary_and_a_response(self):
        names = [operation.get("operationId") for _, operation in self.operations()]
        self.assertEqual(len(names), len({*names} - {None}))
        for name, operation in self.operations():
            with self.subTest(name):
                self.assertTrue(operation["summary"] and operation["tags"])
                self.assertTrue(any(status.startswith("2") for status in operation["responses"]))


if __name__ == "__main__":
    unittest.main()
