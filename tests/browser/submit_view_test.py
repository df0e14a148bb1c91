#!/usr/bin/env python3
"""The form that submits jobs: every control, several jobs at once, targets, forecasts, errors at their fields."""

import json
import pathlib
import sys
import tempfile
import unittest

from browser import DESKTOP, PHONE, BrowserTest, axe, expect
from fake_console import options_of
from fake_farm import FakeFarm

SCENE = {"version": 1, "image": {"width": 600, "height": 300}, "render": {"samples_per_pixel": 64}, "spheres": []}


class Form(BrowserTest):
    def setUp(self):
        super().setUp()
        directory = tempfile.TemporaryDirectory()
        self.addCleanup(directory.cleanup)
        self.directory = pathlib.Path(directory.name)

    def file(self, name, content="1\n\nO 0 0 0\n"):
        path = self.directory / name
        path.write_text(content if isinstance(content, str) else json.dumps(content))
        return str(path)

    def form(self, farm, *files, **options):
        page = self.open(farm.url, "#/submit", **options)
        expect(page.locator("#connection")).to_have_text("live")
        page.locator("#files").set_input_files(list(files))
        return page

    def sent(self, farm):
        """The bodies and options of the jobs that were submitted."""
        return [(body, options_of(body)) for path, body in farm.sent if path.endswith("/jobs")]

    def test_every_control_arrives_as_its_option(self):
        """A control that the form has and that does not reach the server, or under another name, fails this test."""
        wanted = {"name": "my job", "width": 320, "height": 200, "spp": 8, "time_limit": 30.5, "priority": 60, "max_depth": 7, "seed": 3,
                  "sampler": "sobol", "precision": "f64", "schedule": "guided", "max_failures": 2, "webhook": "https://hook.example/done",
                  "quality": "draft", "style": "flat", "view": "iso", "background": "#ff0000", "select": "element O", "color_by": "element",
                  "colormap": "magma", "range": "1%:99%", "radius": 0.5, "crystal": True, "replicate": "2x2x1", "frames": "all",
                  "denoise": True, "legend": True}
        with FakeFarm(jobs=3, changes=0) as farm:
            farm.server_fields["webhooks"] = True
            page = self.form(farm, self.file("water.xyz"))
            page.get_by_text("More options").click()
            controls = page.locator("form").evaluate("form => [...form.elements].filter(e => e.name).map(e => [e.name, e.type])")
            names = {name for name, kind in controls} - {"target_kind", "target", "quick"}
            self.assertEqual(names, set(wanted))
            for name, value in wanted.items():
                control = page.locator(f"form [name={name}]")
                if dict(controls)[name] == "checkbox":
                    control.check()
                elif dict(controls)[name].startswith("select"):
                    control.select_option({True: "on"}.get(value, value))
                else:
                    control.fill(str(value))
            page.get_by_role("button", name="Submit").click()
            expect(page.locator("h1")).to_contain_text("4")
            (body, options), = self.sent(farm)
            self.assertEqual(options, {**wanted, "progressive": True})
            self.assertIn(b'name="water.xyz"', body)

    def test_the_server_describes_the_choices_and_the_ranges_of_numbers(self):
        with FakeFarm(jobs=3, changes=0) as farm:
            farm.descriptions = {"sampler": {"enum": ["sobol", "other"]}, "crystal": {"type": "boolean"}, "seed": {"minimum": 5, "maximum": 9}}
            page = self.form(farm, self.file("water.xyz"))
            values = lambda name: page.locator(f"form [name={name}]").evaluate("e => [...e.options].map(o => o.value)")
            expect(page.locator("form [name=seed]")).to_have_attribute("max", "9")
            expect(page.locator("form [name=seed]")).to_have_attribute("min", "5")
            self.assertEqual(values("sampler"), ["", "sobol", "other"])
            self.assertEqual(values("crystal"), ["", "on", "off"])
            self.assertIn("iso", values("view"))

    def test_fields_that_the_server_does_not_take_are_hidden_and_not_sent(self):
        with FakeFarm(jobs=3, changes=0) as farm:
            for name in ("denoise", "legend", "background", "preview_of"):
                farm.options.remove(name)
            page = self.form(farm, self.file("water.xyz"))
            expect(page.get_by_label("Style")).to_be_visible()
            for label in ("Denoise", "Legend", "Background"):
                expect(page.get_by_label(label)).to_be_hidden()
            page.get_by_role("button", name="Submit").click()
            expect(page.locator("h1")).to_contain_text("4")
            expect(page.locator("#notes")).not_to_contain_text("quick look")
            self.assertEqual(len(self.sent(farm)), 2)

    def test_without_any_control_only_the_name_is_sent(self):
        with FakeFarm(jobs=3, changes=0) as farm:
            page = self.form(farm, self.file("water.xyz"))
            page.get_by_role("button", name="Submit").click()
            expect(page.locator("h1")).to_contain_text("4")
            self.assertEqual(self.sent(farm)[0][1], {"name": "water", "progressive": True})

    def test_one_target_is_chosen_by_radio(self):
        with FakeFarm(jobs=3, changes=0) as farm:
            page = self.form(farm, self.file("water.xyz"))
            page.get_by_label("Quick look first").uncheck()
            expect(page.locator("[name=target]")).to_be_hidden()
            page.get_by_label("half-width", exact=True).check(force=True)
            page.get_by_label("Target half-width").fill("0.03")
            page.get_by_label("error (RMSE)", exact=True).check(force=True)
            page.get_by_label("Target error").fill("0.01")
            page.get_by_label("Time limit").fill("60")
            page.get_by_role("button", name="Submit").click()
            expect(page.locator("h1")).to_contain_text("4")
            self.assertEqual(self.sent(farm)[0][1], {"name": "water", "progressive": True, "target_error": 0.01, "time_limit": 60})

    def test_the_quick_look_follows_its_job_and_names_it(self):
        with FakeFarm(jobs=3, changes=0) as farm:
            page = self.form(farm, self.file("scene.json", SCENE))
            page.get_by_label("error (RMSE)", exact=True).check(force=True)
            page.get_by_label("Target error").fill("0.01")
            page.get_by_label("Denoise").check()
            page.get_by_role("button", name="Submit").click()
            expect(page.locator("h1")).to_contain_text("4")
            (_, job), (_, quick) = self.sent(farm)
            self.assertEqual(job, {"name": "scene", "progressive": True, "target_error": 0.01, "denoise": True})
            self.assertEqual(quick, {"name": "scene (quick look)", "progressive": True, "width": 300, "height": 150, "spp": 16, "priority": 51,
                                     "preview_of": 4})

    def test_a_refused_quick_look_does_not_lose_its_job(self):
        with FakeFarm(jobs=3, changes=0) as farm:
            page = self.form(farm, self.file("scene.json", SCENE))
            refuse = lambda route: (route.fulfill(status=422, body='{"detail": "options: /preview_of: unknown option"}')
                                    if b"preview_of" in (route.request.post_data_buffer or b"") else route.continue_())
            page.route("**/api/v1/jobs", refuse)
            page.get_by_role("button", name="Submit").click()
            expect(page.locator("#notes")).to_contain_text("Job 4 has no quick look")
            expect(page.locator("h1")).to_contain_text("4")

    def test_placeholders_are_the_numbers_of_the_scene(self):
        with FakeFarm(jobs=3, changes=0) as farm:
            page = self.form(farm, self.file("scene.json", SCENE))
            for name, text in (("width", "600"), ("height", "300"), ("spp", "64"), ("max_depth", "10"), ("seed", "1"), ("name", "scene")):
                expect(page.locator(f"form [name={name}]")).to_have_attribute("placeholder", text)
            expect(page.get_by_role("group", name="Particles")).to_be_hidden()

    def test_the_webhook_is_hidden_unless_the_server_permits_one(self):
        with FakeFarm(jobs=3, changes=0) as farm:
            page = self.form(farm)
            page.get_by_text("More options").click()
            expect(page.get_by_label("Seed")).to_be_visible()
            expect(page.get_by_label("Webhook")).to_be_hidden()

    def test_several_files_become_several_jobs_and_parts_follow_their_scenes(self):
        pool = {**SCENE, "particles": [{"file": "water.xyz"}]}
        with FakeFarm(jobs=3, changes=0) as farm:
            page = self.form(farm, self.file("pool.json", pool), self.file("bare.json", SCENE), self.file("water.xyz"), self.file("helix.pdb", "ATOM"))
            expect(page.get_by_label("Use of water.xyz")).to_have_value("0")
            expect(page.get_by_label("Use of helix.pdb")).to_have_value("own")
            page.get_by_label("Quick look first").uncheck()
            page.get_by_role("button", name="Submit 3 jobs").click()
            expect(page.locator(".submitted")).to_have_text("Submitted: job 4 (pool), job 5 (bare), job 6 (helix)")
            expect(page.locator(".jobs-to-submit li")).to_have_count(0)
            bodies = [body for body, _ in self.sent(farm)]
            self.assertEqual([b'name="scene"' in body for body in bodies], [True, True, False])
            self.assertEqual([b'name="water.xyz"' in body for body in bodies], [True, False, False])
            self.assertEqual([options["name"] for _, options in self.sent(farm)], ["pool", "bare", "helix"])

    def test_a_file_can_be_given_to_another_scene(self):
        with FakeFarm(jobs=3, changes=0) as farm:
            page = self.form(farm, self.file("pool.json", SCENE), self.file("water.xyz"))
            expect(page.get_by_role("button", name="Submit 2 jobs")).to_be_visible()
            page.get_by_label("Use of water.xyz").select_option(label="part of pool.json")
            page.get_by_role("button", name="Submit", exact=True).click()
            expect(page.locator("h1")).to_contain_text("4")
            self.assertIn(b'name="water.xyz"', self.sent(farm)[0][0])

    def test_a_trajectory_takes_the_names_of_its_topology(self):
        with FakeFarm(jobs=3, changes=0) as farm:
            page = self.form(farm, self.file("run.xtc"), self.file("start.gro"))
            expect(page.get_by_label("Use of start.gro")).to_have_value("0")
            page.get_by_label("Frames").fill("0:100:5")
            page.get_by_role("button", name="Submit", exact=True).click()
            expect(page.locator("h1")).to_contain_text("4")
            (body, options), = self.sent(farm)  # a series has no quick look
            self.assertEqual(options, {"name": "run", "progressive": True, "frames": "0:100:5", "topology": "start.gro"})
            self.assertIn(b'name="scene"; filename="run.xtc"', body)
            self.assertIn(b'name="start.gro"', body)

    def test_a_missing_part_is_named(self):
        with FakeFarm(jobs=3, changes=0) as farm:
            page = self.form(farm, self.file("pool.json", {**SCENE, "particles": [{"file": "water.xyz"}]}))
            expect(page.locator(".missing")).to_have_text("The scene refers to water.xyz: add the file.")
            page.locator("#files").set_input_files(self.file("water.xyz"))
            expect(page.locator(".missing")).to_have_count(0)

    def test_each_of_several_jobs_has_its_own_error_and_only_those_are_tried_again(self):
        with FakeFarm(jobs=3, changes=0) as farm:
            page = self.form(farm, self.file("a.xyz"), self.file("b.xyz"))
            page.get_by_label("Quick look first").uncheck()
            farm.refusal = (422, "a.xyz: line 3: no number")
            page.get_by_role("button", name="Submit 2 jobs").click()
            expect(page.locator(".submitted")).to_have_text("Submitted: job 4 (b)")
            expect(page.locator(".jobs-to-submit li")).to_have_count(1)
            expect(page.locator(".jobs-to-submit")).to_contain_text("a.xyz")
            expect(page.get_by_role("alert")).to_contain_text("1 of 2 jobs")
            expect(page.get_by_text("a.xyz: line 3: no number")).to_be_visible()
            page.get_by_role("button", name="Submit").click()
            expect(page.locator("h1")).to_contain_text("5")

    def test_an_error_that_names_an_option_marks_its_field(self):
        with FakeFarm(jobs=3, changes=0) as farm:
            page = self.form(farm, self.file("a.xyz"))
            for detail, name, text in (("options: /seed: 1.5 is not a whole number", "seed", "Seed: 1.5 is not a whole number"),
                                       ("--target-error: 0 is not above 0", "target", "Target error (RMSE): 0 is not above 0")):
                page.get_by_label("error (RMSE)", exact=True).check(force=True)
                page.get_by_label("Target error").fill("0.1")
                farm.refusal = (422, detail)
                page.get_by_role("button", name="Submit").click()
                expect(page.get_by_role("alert")).to_have_text(text)
                expect(page.locator(f"form [name={name}]")).to_have_attribute("aria-invalid", "true")
                expect(page.locator(f"form [name={name}]")).to_be_focused()
                expect(page.locator("[aria-invalid]")).to_have_count(1)

    def test_a_forecast_is_shown_on_demand(self):
        with FakeFarm(jobs=3, changes=0) as farm:
            page = self.form(farm, self.file("a.xyz"))
            page.get_by_role("button", name="Forecast").click()
            expect(page.locator(".forecast")).to_have_text("about 3 min on 8 threads, after 12 min in the queue; error 0.02")
            page.get_by_label("Seed")
            page.get_by_label("Height").fill("50")
            expect(page.locator(".forecast")).to_have_text("")
            self.assertEqual(self.sent(farm), [])

    def test_a_job_of_a_day_or_more_is_confirmed(self):
        with FakeFarm(jobs=3, changes=0) as farm:
            page = self.form(farm, self.file("a.xyz"))
            page.get_by_label("error (RMSE)", exact=True).check(force=True)
            page.get_by_label("Target error").fill("1e-8")
            page.get_by_role("button", name="Submit").click()
            dialog = page.get_by_role("dialog")
            expect(dialog).to_contain_text("This takes about 122 days. Submit it?")
            dialog.get_by_role("button", name="Keep editing").click()
            expect(page.locator(".forecast")).to_contain_text("about 122 days on 8 threads")
            self.assertEqual(self.sent(farm), [])
            page.get_by_role("button", name="Submit").click()
            dialog.get_by_role("button", name="Submit anyway").click()
            expect(page.locator("h1")).to_contain_text("4")

    def test_only_a_job_that_may_take_an_hour_is_forecast_before_it_is_submitted(self):
        with FakeFarm(jobs=3, workers=10, changes=0) as farm:
            for spp, forecasts in ((64, 0), (10**9, 1)):
                page = self.form(farm, self.file("scene.json", SCENE))
                expect(page.locator("#summary")).to_contain_text("10 workers")
                page.get_by_label("Samples per pixel", exact=True).fill(str(spp))
                page.get_by_role("button", name="Submit").click()
                expect(page.locator("h1")).not_to_have_text("Submit a scene")
                self.assertEqual(sum(path.endswith("/plan") for path, _ in farm.sent), forecasts)

    def test_a_job_of_hours_is_submitted_with_a_notice(self):
        with FakeFarm(jobs=3, changes=0) as farm:
            farm.plan_fields = {"seconds": {"low": 5000, "expected": 7200, "high": 9000}, "queue_seconds": None, "error": None, "notes": ["It is a guess."]}
            page = self.form(farm, self.file("scene.json", SCENE))
            page.get_by_role("button", name="Forecast").click()
            expect(page.locator(".foot")).to_contain_text("It is a guess.")
            page.get_by_label("Samples per pixel", exact=True).fill("1000000000")
            page.get_by_role("button", name="Submit").click()
            expect(page.locator("#notes")).to_contain_text("scene: about 2 h on 8 threads")
            expect(page.locator("h1")).to_contain_text("4")

    def test_without_forecasts_of_an_older_coordinator_jobs_are_submitted(self):
        with FakeFarm(jobs=3, changes=0) as farm:
            page = self.form(farm, self.file("a.xyz"))
            page.route("**/api/v1/plan", lambda route: route.fulfill(status=404, body='{"detail": "no such path"}'))
            page.get_by_role("button", name="Submit").click()
            expect(page.locator("h1")).to_contain_text("4")

    def test_axe_finds_no_violation_with_files_and_errors(self):
        source = axe()
        with FakeFarm(jobs=3, changes=0) as farm:
            for theme in ("light", "dark"):
                for size in (DESKTOP, PHONE):
                    page = self.form(farm, self.file("pool.json", {**SCENE, "particles": [{"file": "stone.csv"}]}), self.file("a.xyz"),
                                     color_scheme=theme, viewport=size)
                    page.get_by_text("More options").click()
                    page.get_by_label("half-width", exact=True).check(force=True)
                    page.get_by_label("Target half-width").fill("0.03")
                    page.get_by_label("Quick look first").uncheck()
                    farm.refusal = (422, "options: /seed: 1.5 is not a whole number")
                    page.get_by_role("button", name="Submit 2 jobs").click()
                    expect(page.get_by_role("alert")).to_be_visible()
                    page.evaluate(source)
                    found = page.evaluate("axe.run().then(result => result.violations.map(v => [v.id, v.nodes.map(n => n.html + ' ' + n.failureSummary)]))")
                    self.assertEqual(found, [], f"{theme}, {size['width']}")
                    self.assertLessEqual(page.evaluate("document.documentElement.scrollWidth"), size["width"])
                    page.context.close()


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v", *sys.argv[1:]])
