#!/usr/bin/env python3
"""The view of a series: its frames as thumbnails, played, timed and repeated; and the view of one frame."""

import json
import re
import sys
import unittest
import zipfile

import fake_rules
from browser import DESKTOP, PHONE, BrowserTest, axe, expect
from fake_jobs import SERIES, JobFarm
from presses import wait_until


class SeriesTest(BrowserTest):
    def open_series(self, farm, **options):
        page = self.open(farm.url, f"#/jobs/{SERIES}", **options)
        expect(page.locator(".frame").first).to_be_visible()
        expect(page.locator("#connection")).to_have_text("live")
        return page

    def shown(self, page, frame):
        expect(page.locator(".open-frame")).to_have_text(f"Open frame {frame}")
        expect(page.locator(".frame[aria-pressed=true] .number")).to_have_text(str(frame))


class Thumbnails(SeriesTest):
    def test_only_visible_frames_are_requested_and_small(self):
        with JobFarm(frames=400) as farm:
            page = self.open_series(farm)
            expect(page.locator(".frame")).to_have_count(400)
            expect(page.locator(".frame img[src]").first).to_be_visible()
            small = lambda: [path for _, path in farm.asked if path.endswith("image.png?width=128")]
            wait_until(lambda: len(small()) > 5, lambda: f"only {small()} were requested", page)
            page.wait_for_timeout(1500)
            asked = small()
            self.assertLess(len(asked), 100)  # of 133 with a picture
            self.assertFalse([path for _, path in farm.asked if re.search(r"image\.png$|pixels", path)])
            frame = page.locator(".frame").nth(100)
            frame.scroll_into_view_if_needed()
            expect(frame.locator("img[src]")).to_have_count(1)

    def test_counts_by_state_and_the_reason_of_a_failed_frame_are_said(self):
        with JobFarm(frames=61) as farm:
            page = self.open_series(farm)
            expect(page.locator(".counts li")).to_have_text(["19 done", "2 running", "39 queued", "1 failed"])
            expect(page.get_by_role("button", name=re.compile("^Frame 2 failed.*the scene of frame 2 is damaged"))).to_be_visible()
            expect(page.locator(".now")).to_contain_text("19 of 61 frames")

    def test_a_frame_that_ends_gets_its_picture_by_itself(self):
        with JobFarm(frames=9) as farm:
            page = self.open_series(farm)
            last = page.locator(".frame").last
            expect(last).to_contain_text("queued")
            expect(last.locator("img[src]")).to_have_count(0)
            farm.jobs[SERIES + 9].update(state="done", progress=1.0, has_picture=True, seconds_taken=12.0)
            farm.jobs[SERIES]["frames_done"] += 1
            farm.changes = 100
            expect(last.locator("img[src]")).to_have_count(1)
            expect(last).to_contain_text("12 s")

    def test_a_frame_that_was_deleted_is_missed(self):
        with JobFarm(frames=9) as farm:
            del farm.jobs[SERIES + 1 + 4]
            page = self.open_series(farm)
            expect(page.locator(".series-side .notice")).to_contain_text("1 of 9 frames is missing")


class Playback(SeriesTest):
    def test_arrows_step_and_space_plays_and_stops(self):
        with JobFarm(frames=12) as farm:
            page = self.open_series(farm)
            self.shown(page, 0)
            page.keyboard.press("ArrowRight")
            self.shown(page, 1)
            page.keyboard.press("ArrowLeft")
            self.shown(page, 0)
            page.keyboard.press("Space")
            expect(page.get_by_role("button", name="Pause", exact=True).locator("visible=true").last).to_be_visible()
            expect(page.locator(".open-frame")).not_to_have_text("Open frame 0")
            page.keyboard.press("Space")
            expect(page.get_by_role("button", name="Play")).to_be_visible()
            where = page.locator(".open-frame").inner_text()
            page.wait_for_timeout(500)
            self.assertEqual(page.locator(".open-frame").inner_text(), where)

    def test_the_slider_shows_any_frame_and_says_if_it_has_no_picture(self):
        with JobFarm(frames=12) as farm:
            page = self.open_series(farm)
            page.get_by_role("slider", name="Frame").fill("11")
            self.shown(page, 11)
            expect(page.locator(".screen .message")).to_contain_text("Frame 11 is queued")
            page.locator(".frame").nth(3).click()
            self.shown(page, 3)
            expect(page.locator(".screen img")).to_have_attribute("alt", "Frame 3")
            expect(page.locator(".screen img")).to_be_visible()
            page.locator(".open-frame").click()
            expect(page.locator("h1")).to_have_text(f"{SERIES + 4}  orbit.json")

    def test_another_view_stops_and_empties_the_player(self):
        with JobFarm(frames=12) as farm:
            page = self.open_series(farm)
            page.get_by_role("button", name="Play").click()
            page.goto(farm.url + "#/jobs/4")
            expect(page.locator(".readout")).to_contain_text("240 × 160")
            expect(page.locator(".series")).to_be_hidden()
            before = len(farm.asked)
            page.wait_for_timeout(800)
            self.assertEqual([path for _, path in farm.asked[before:] if "image.png" in path], [])


class Steering(SeriesTest):
    def test_failed_frames_are_requeued_by_one_request(self):
        with JobFarm(frames=12) as farm:
            page = self.open_series(farm)
            page.get_by_role("button", name="Requeue 1 failed frame").click()
            expect(page.locator("#notes")).to_contain_text("1 frame is queued again")
            self.assertEqual(json.loads(farm.bodies["/api/v1/jobs/requeue"]), {"ids": [SERIES + 3]})
            expect(page.locator(".counts")).not_to_contain_text("failed")
            expect(page.get_by_role("button", name=re.compile("Requeue"))).to_have_count(0)

    def test_done_frames_come_as_one_file(self):
        with JobFarm(frames=12) as farm:
            page = self.open_series(farm)
            with page.expect_download() as download:
                page.get_by_role("button", name="All frames (zip)").click()
            self.assertEqual(download.value.suggested_filename, f"orbit-{SERIES}.zip")
            with zipfile.ZipFile(download.value.path()) as archive:
                self.assertEqual(archive.namelist(), ["frame-0000.png", "frame-0001.png", "frame-0003.png"])

    def test_the_frame_that_took_longest_is_seen_and_sorted_to_the_top(self):
        with JobFarm(frames=61) as farm:
            page = self.open_series(farm)
            expect(page.locator(".frame-times .hint")).to_contain_text("longest 3 min 20 s (frame 1)")
            expect(page.locator(".strip .outlier")).to_have_count(1)
            page.get_by_text("Times per frame", exact=True).click()
            time = page.get_by_role("button", name="Time", exact=True)
            time.click()
            time.click()
            expect(page.locator("th[aria-sort=descending]")).to_have_text("Time")
            expect(page.locator(".times-table tbody tr").first).to_contain_text("3 min 20 s")
            expect(page.locator(".times-table tbody tr").first.locator("a")).to_have_attribute("href", f"#/jobs/{SERIES + 2}")


class Frame(SeriesTest):
    def test_a_frame_leads_to_the_frames_beside_it_and_to_its_series(self):
        with JobFarm(frames=5) as farm:
            page = self.open(farm.url, f"#/jobs/{SERIES + 2}")
            beside = page.get_by_role("navigation", name="Frames")
            beside.get_by_role("link", name="Next frame").click()
            expect(page.locator("h1")).to_contain_text(str(SERIES + 3))
            expect(beside).to_contain_text("frame 2")
            page.keyboard.press(",")
            expect(page.locator("h1")).to_contain_text(str(SERIES + 2))
            expect(beside).to_contain_text("frame 1")
            page.keyboard.press(",")
            expect(beside).to_contain_text("frame 0")
            expect(beside.get_by_role("link", name="Previous frame")).to_have_count(0)
            beside.get_by_role("link", name="frame 0").click()
            expect(page.locator(".series")).to_be_visible()

    def test_who_deletes_a_frame_of_an_ended_series_comes_to_its_series(self):
        with JobFarm(frames=5) as farm:
            for frame in farm.frames():
                frame.update(state="done")
            fake_rules.sum_up(farm.jobs, farm.jobs[SERIES])
            page = self.open(farm.url, f"#/jobs/{SERIES + 1}")
            page.get_by_role("button", name="Delete").click()
            page.get_by_role("button", name="Delete job").click()
            expect(page.locator("h1")).to_have_text(f"{SERIES}  orbit.json")
            expect(page.locator(".frame")).to_have_count(4)


class Everybody(SeriesTest):
    def test_axe_finds_no_violation_and_nothing_is_wider_than_a_phone(self):
        source = axe()
        with JobFarm(frames=61) as farm:
            for theme in ("light", "dark"):
                for size in (DESKTOP, PHONE):
                    page = self.open_series(farm, color_scheme=theme, viewport=size)
                    page.get_by_text("Times per frame", exact=True).click()
                    page.wait_for_timeout(300)
                    page.evaluate(source)
                    found = page.evaluate("axe.run().then(result => result.violations.map(v => [v.id, v.nodes.map(n => n.html + ' ' + n.failureSummary)]))")
                    self.assertEqual(found, [], f"{theme}, {size['width']}")
                    self.assertLessEqual(page.evaluate("document.documentElement.scrollWidth"), size["width"])
                    page.context.close()


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v", *sys.argv[1:]])
