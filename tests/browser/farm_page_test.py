#!/usr/bin/env python3
"""The page of a real coordinator with two real workers: a scene goes in by a file, a picture comes out."""

import json
import pathlib
import re
import struct
import sys
import unittest

from browser import BrowserTest, expect

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "integration"))
from farm import run  # noqa: E402
from web import SCENE, WATER, Web  # noqa: E402


def scene_file(farm, name="two spheres.json", **more):
    file = farm.directory / name
    file.write_text(json.dumps({**SCENE, **more}))
    return str(file)


class RealJob(BrowserTest):
    def test_a_scene_is_chosen_watched_and_downloaded_with_a_quick_look_first(self):
        with Web() as farm:
            page = self.open(f"http://{farm.web}/", "#/submit")
            page.locator("#files").set_input_files(scene_file(farm))
            page.get_by_label("Samples per pixel", exact=True).fill("64")
            page.get_by_label("Height").fill("90")
            page.get_by_label("Width", exact=True).fill("120")
            page.get_by_role("button", name="Submit").click()
            expect(page.locator("h1")).to_have_text("1  two spheres")
            expect(page.locator(".waits")).to_contain_text("worker")  # there are none yet
            farm.start_worker("oak")
            farm.start_worker("birch")
            expect(page.locator("#summary")).to_contain_text("2 workers")
            expect(page.locator(".bar-of-view .state")).to_have_text("done", timeout=120000)
            quick = farm.get("/jobs/2").json()
            self.assertEqual((quick["name"], quick["width"], quick["height"], quick["samples_per_pixel"], quick["priority"]),
                             ("two spheres (quick look)", 120, 90, 16, 51))
            expect(page.locator(".panel")).to_contain_text(farm.get("/jobs/1/report").json()["image_sha256"])
            self.check_values(farm, page)
            with page.expect_download() as download:
                page.get_by_role("button", name="PNG").click()
            self.assertEqual(download.value.suggested_filename, "two spheres-1.png")
            self.assertEqual(pathlib.Path(download.value.path()).read_bytes(), farm.get("/jobs/1/image.png").body)

    def check_values(self, farm, page):
        """Under the cursor stands what the server has."""
        pixels = struct.unpack(f"<{120 * 90 * 3}f", farm.get("/jobs/1/pixels.f32").body)
        errors = struct.unpack(f"<{120 * 90}f", farm.get("/jobs/1/error.f32").body)
        self.check_maps(farm, page)
        page.locator(".stage").focus()
        page.keyboard.press("ArrowUp")
        at = 44 * 120 + 60
        expect(page.locator(".readout")).to_contain_text(re.compile(r"x 60\s+y 44\b.*±", re.DOTALL))
        text = page.locator(".readout").inner_text()
        shown = [float(value) for value in re.findall(r"[RGB±] ([\d.e-]+)", text)]
        for value, there in zip(shown, [*pixels[3 * at:3 * at + 3], errors[at]], strict=True):
            self.assertAlmostEqual(value / there, 1, delta=5e-3)
        centre = page.locator(".stage").evaluate("stage => [...stage.firstChild.getContext('2d').getImageData("
                                                 "stage.firstChild.width / 2 + 30, stage.firstChild.height / 2 + 30, 1, 1).data]")
        self.assertEqual(centre[3], 255)
        self.assertGreater(centre[0], centre[2])  # a red sphere

    def check_maps(self, farm, page):
        """Maps of the error, of what pixels cost and of who traced them, with their legends, and the picture again."""
        choice = page.get_by_label("Layer")
        legend = page.locator(".legend")
        expect(legend).to_be_hidden()
        choice.select_option("error")
        expect(legend).to_contain_text("half-width of the 95 % interval")
        choice.select_option("cost")
        expect(legend).to_contain_text("thread-seconds per pixel")
        expect(legend.locator(".scale")).to_contain_text("µs")
        choice.select_option("workers")
        names = farm.get("/jobs/1/workers.json").json()["workers"]
        expect(legend.locator(".names > span")).to_have_text(names)
        page.locator(".stage").focus()
        page.keyboard.press("ArrowUp")
        traced = struct.unpack(f"<{120 * 90}I", farm.get("/jobs/1/workers.u32").body)
        expect(page.locator(".readout")).to_contain_text(names[traced[44 * 120 + 60]])
        page.keyboard.press("m")  # after the last map the picture
        expect(choice).to_have_value("picture")
        expect(legend).to_be_hidden()
        page.keyboard.press("ArrowDown")

    def test_what_is_wrong_with_a_scene_is_said_in_the_words_of_the_command_line(self):
        with Web() as farm:
            page = self.open(f"http://{farm.web}/", "#/submit")
            file = scene_file(farm, "wrong.json", camera={"look_form": [0, 0, 5]})
            page.locator("#files").set_input_files(file)
            page.get_by_role("button", name="Submit").click()
            alert = page.get_by_role("alert")
            expect(alert).to_contain_text("look_form")
            said = run("validate", file).stderr.strip()
            self.assertTrue(said.endswith(alert.inner_text()[-60:]), (said, alert.inner_text()))
            self.assertEqual(farm.get("/jobs").json()["jobs"], [])

    def test_particles_dropped_anywhere_become_a_job(self):
        with Web() as farm:
            farm.start_worker("oak")
            page = self.open(f"http://{farm.web}/")
            drop = page.evaluate_handle("text => { const all = new DataTransfer(); all.items.add(new File([text], 'water.xyz')); return all; }", WATER)
            page.dispatch_event("main", "drop", {"dataTransfer": drop})
            expect(page.locator(".jobs-to-submit")).to_contain_text("water.xyz")
            page.get_by_label("Quick look first").uncheck()
            for label, value in (("Height", "30"), ("Samples per pixel", "4")):
                page.get_by_label(label, exact=True).fill(value)
            page.get_by_label("Width", exact=True).fill("40")
            page.get_by_role("button", name="Submit").click()
            expect(page.locator(".bar-of-view .state")).to_have_text("done", timeout=120000)

    def test_a_job_is_paused_resumed_and_cancelled_and_a_worker_drained(self):
        with Web() as farm:
            farm.start_worker("oak")
            job = farm.submitted(farm.post_scene({**SCENE, "render": {"samples_per_pixel": 10000000}}))
            page = self.open(f"http://{farm.web}/", f"#/jobs/{job}")
            state = page.locator(".bar-of-view .state")
            expect(state).to_have_text("running")
            page.keyboard.press("p")
            expect(state).to_have_text("paused")
            page.get_by_role("button", name="Resume").click()
            expect(state).to_have_text(re.compile("running|queued"))
            page.get_by_role("button", name="Cancel").click()
            page.get_by_role("button", name="Cancel job").click()
            expect(state).to_have_text("cancelled")
            expect(page.locator(".history")).to_contain_text("cancelled")
            page.goto(f"http://{farm.web}/#/workers")
            page.get_by_role("button", name="Drain oak").click()
            page.get_by_role("dialog").get_by_role("button", name="Drain", exact=True).click()
            expect(page.locator(".rows .state").first).to_have_text(re.compile("drain"))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v", *sys.argv[1:]])
