#!/usr/bin/env python3
"""The page /api: every operation of the description, with a command to copy, readable for everybody."""

import json
import shlex
import unittest

from browser import DESKTOP, PHONE, BrowserTest, axe, expect
from fake_farm import PAGE, FakeFarm

DOCUMENT = json.loads((PAGE.parent / "openapi.json").read_text())
OPERATIONS = [operation for item in DOCUMENT["paths"].values() for method, operation in item.items() if method != "parameters"]


class ApiPage(BrowserTest):
    def opened(self, farm, view="", **options):
        page = self.open(farm.url, "api" + view, **options)
        expect(page.locator("section.operation").first).to_be_visible()
        return page

    def test_it_shows_every_operation_with_a_command_and_examples(self):
        with FakeFarm() as farm:
            page = self.opened(farm)
            for operation in OPERATIONS:
                section = page.locator("#" + operation["operationId"])
                self.assertIn(operation["summary"].replace("`", ""), section.inner_text())
                self.assertRegex(section.locator(".command code").first.inner_text(), r"^curl .*http://127\.0\.0\.1:\d+/")
            text = page.locator("main").inner_text()
            for wrong in ("undefined", "[object", "NaN", "null,null"):
                self.assertNotIn(wrong, text)
            self.assertEqual(page.locator("#contents a").count(), page.locator("section.operation").count())

    def test_commands_have_body_token_and_output(self):
        with FakeFarm(token="secret") as farm:
            page = self.opened(farm)
            words = lambda name: shlex.split(page.locator(f"#{name} .command code").first.inner_text())
            api = farm.url + "api/v1"
            token = ["-H", "Authorization: Bearer $TOKEN"]
            self.assertEqual(words("jobPng"), ["curl", "-o", "image.png", *token, api + "/jobs/7/image.png"])
            self.assertEqual(words("cancelJob"), ["curl", "-X", "POST", *token, api + "/jobs/7/cancel"])
            self.assertEqual(words("events"), ["curl", "-N", *token, api + "/events"])
            submit = words("submitJob")
            self.assertIn("Content-Type: application/json", submit)
            self.assertEqual(json.loads(submit[submit.index("-d") + 1])["version"], 1)
            form = shlex.split(page.locator("#submitJob .command code").nth(1).inner_text())
            self.assertEqual(form[:4] + form[-3:], ["curl", *token, "-F", "-F", "file=@FILE", api + "/jobs"])
            self.assertEqual(words("setPriority")[1:3], ["-X", "PUT"])
            self.assertEqual(words("healthz"), ["curl", farm.url + "healthz"])  # needs no token

    def test_a_command_is_copied_and_links_lead_to_their_operation(self):
        with FakeFarm() as farm:
            page = self.opened(farm, permissions=["clipboard-read", "clipboard-write"])
            page.locator("#showJob").get_by_role("button", name="Copy").click()
            expect(page.locator("#notes")).to_contain_text("Copied")
            self.assertEqual(page.evaluate("navigator.clipboard.readText()"),
                             page.locator("#showJob .command code").inner_text())
            page.locator("#contents a", has_text="/workers/{name}/drain").click()
            expect(page.locator("#drainWorker")).to_be_in_viewport()
            page = self.opened(farm, "#schema-Job")
            expect(page.locator("#schema-Job")).to_be_in_viewport()

    def test_help_links_to_it(self):
        with FakeFarm() as farm:
            page = self.open(farm.url)
            page.locator("#help").click()
            with page.expect_popup() as opened:  # the help opens a new tab
                page.get_by_role("link", name="HTTP interface").click()
            expect(opened.value.locator("main.api h1")).to_have_text("API")

    def test_it_is_accessible_and_needs_no_sideways_scrolling(self):
        for options in ({"viewport": DESKTOP}, {"viewport": DESKTOP, "color_scheme": "dark"}, {"viewport": PHONE}):
            with self.subTest(options), FakeFarm() as farm:
                page = self.opened(farm, **options)
                self.assertLessEqual(page.evaluate("document.documentElement.scrollWidth"), options["viewport"]["width"])
                page.evaluate(axe())
                found = page.evaluate("axe.run()")["violations"]
                self.assertEqual([(each["id"], [node["html"][:100] for node in each["nodes"]][:3]) for each in found], [])


if __name__ == "__main__":
    unittest.main()
