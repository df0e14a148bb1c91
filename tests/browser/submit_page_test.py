#!/usr/bin/env python3
"""The form of the page against a real coordinator: it takes every control that the form shows."""

import pathlib
import sys
import unittest

from browser import BrowserTest, expect

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "integration"))
from web import Web  # noqa: E402

# A crystal of two frames, so that all options of particle files mean something.
FRAME = '2\nLattice="4 0 0 0 4 0 0 0 4" Properties=species:S:1:pos:R:3:vx:R:1\nNa 0 0 0 {0}\nCl 2 2 2 {1}\n'
CRYSTAL = FRAME.format(0.1, 0.9) + FRAME.format(0.2, 0.8)
SMALL = {"width": 64, "height": 48, "spp": 4}
VALUES = {"name": "a name", "quality": "draft", "time_limit": 20, "priority": 60, "max_depth": 4, "seed": 5, "sampler": "independent",
          "precision": "f64", "schedule": "static", "max_failures": 2, "style": "flat", "view": "iso", "background": "#ff0000",
          "select": "element Na", "color_by": "element", "colormap": "magma", "range": "0:1", "radius": 0.5, "crystal": "on",
          "replicate": "2x2x1", "frames": "all", "denoise": True, "legend": True}
NEEDS = {"colormap": {"color_by": "vx"}, "range": {"color_by": "vx"}, "legend": {"color_by": "vx", "width": 600, "height": 400}}


def fill(page, name, value):
    control = page.locator(f"form [name={name}]")
    if value is True:
        control.check()
    elif control.evaluate("control => control.tagName") == "SELECT":
        control.select_option(value)
    else:
        control.fill(str(value))


class Controls(BrowserTest):
    def test_a_real_coordinator_takes_each_control_that_the_form_shows(self):
        with Web() as farm:
            file = farm.directory / "crystal.xyz"
            file.write_text(CRYSTAL)
            self.submit_each(f"http://{farm.web}/", str(file))

    def submit_each(self, url, file):
        page = self.open(url, "#/submit")
        with page.expect_response("**/openapi.json"):  # it says which options the server takes
            page.reload()
        page.locator("#files").set_input_files(file)
        expect(page.locator(".jobs-to-submit li")).to_have_count(1)
        page.get_by_text("More options").click()
        page.wait_for_timeout(500)
        shown = page.locator("form").evaluate("form => [...form.elements].filter(e => e.name && !e.disabled && e.offsetParent).map(e => e.name)")
        names = set(shown) - {"target_kind", "target", "quick"}
        self.assertEqual(names - set(VALUES) - set(SMALL), set())
        for name in sorted(names - set(SMALL)):
            with self.subTest(control=name):
                self.submit_one(page, url, file, {**SMALL, **NEEDS.get(name, {}), name: VALUES[name]})

    def submit_one(self, page, url, file, options):
        page.goto(url + "#/submit")
        page.reload()
        expect(page.locator("#connection")).to_have_text("live")
        page.get_by_text("More options").click()
        page.locator("#files").set_input_files(file)
        page.get_by_label("Quick look first").uncheck()
        for name, value in options.items():
            fill(page, name, value)
        page.get_by_role("button", name="Submit").click()
        page.wait_for_function("() => location.hash.startsWith('#/jobs/') || !document.querySelector('#submit-problem').hidden")
        self.assertIn("#/jobs/", page.url, page.locator("main").inner_text()[-300:])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v", *sys.argv[1:]])
