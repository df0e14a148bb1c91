#!/usr/bin/env python3
"""The page against a farm that renders nothing: thousands of jobs and workers, breaks, tokens, hostile
names, and who uses it by keyboard, on a phone, or does not see it."""

import json
import pathlib
import re
import sys
import tempfile
import unittest

from browser import DESKTOP, PHONE, BrowserTest, axe, expect, violations
from fake_farm import FakeFarm
from fake_jobs import SERIES, JobFarm

SCROLL = """async () => {
  const scroller = document.querySelector('.scroller');
  const frames = [];
  let last = performance.now();
  for (let i = 0; i <= 600; ++i) {
    scroller.scrollTop = scroller.scrollHeight * i / 600;
    await new Promise(requestAnimationFrame);
    frames.push(performance.now() - last);
    last = performance.now();
  }
  return frames.sort((a, b) => a - b);
}"""


def load_all(page, jobs):
    """Scrolls until the last page of jobs has come."""
    for _ in range(400):
        ready = page.get_by_role("table").get_attribute("aria-rowcount") == str(jobs + 1)
        page.evaluate("() => { const s = document.querySelector('.scroller'); s.scrollTop = s.scrollHeight; }")
        if ready:
            return
        page.wait_for_timeout(100)
    raise AssertionError("the last page of jobs never came")


class Lists(BrowserTest):
    def test_10000_jobs_scroll_to_the_last_with_few_elements(self):
        with FakeFarm(jobs=10000, workers=2000) as farm:
            page = self.open(farm.url)
            expect(page.locator("#connection")).to_have_text("live")
            expect(page.locator(".count")).to_contain_text("jobs")
            load_all(page, 10000)
            expect(page.locator(".count")).to_have_text(re.compile(r"10\s000 jobs"))
            expect(page.get_by_role("table")).to_have_attribute("aria-rowcount", "10001")
            # Those of an earlier element may be reused: what counts is what is shown.
            expect(page.locator(".rows .row:not([hidden]) .id").filter(has_text=re.compile("^1$"))).to_be_visible()
            self.assertLess(page.locator(".row").count(), 60)
            self.report_frames(page, "10,000 jobs")
            page.goto(farm.url + "#/workers")
            expect(page.locator(".count")).to_contain_text("2000 workers")
            self.assertLess(page.locator(".row").count(), 60)
            self.report_frames(page, "2,000 workers")

    def report_frames(self, page, what):
        session = page.context.new_cdp_session(page)
        session.send("Performance.enable")
        thread_time = lambda: next(metric["value"] for metric in session.send("Performance.getMetrics")["metrics"]
                                   if metric["name"] == "ThreadTime")
        begin = thread_time()
        frames = page.evaluate(SCROLL)
        spent = 1000 * (thread_time() - begin) / len(frames)
        print(f"{what}, each frame all other rows: median {frames[len(frames) // 2]:.0f} ms, "
              f"95 % {frames[len(frames) * 95 // 100]:.0f} ms, longest {frames[-1]:.0f} ms; "
              f"{spent:.1f} ms of the main thread's processor time a frame", flush=True)

    def test_a_state_alone_is_asked_of_the_server_and_shown(self):
        with FakeFarm(jobs=3000) as farm:
            page = self.open(farm.url)
            page.get_by_label("failed", exact=True).check(force=True)
            expect(page.locator(".count")).to_have_text(f"{sum(job['state'] == 'failed' for job in farm.jobs.values())} jobs")
            self.assertTrue(any("state=failed" in path for _, path in farm.asked))
            self.assertEqual(set(page.locator(".rows .row:not([hidden]) .state").all_inner_texts()), {"failed"})

    def test_events_change_rows_and_their_number(self):
        with FakeFarm(jobs=50, changes=0) as farm:
            page = self.open(farm.url)
            expect(page.locator(".count")).to_have_text("50 jobs")
            first = page.locator(".rows .row").filter(has_text=re.compile("^49")).locator(".share")
            farm.changes = 20
            before = first.inner_text()
            expect(first).not_to_have_text(before)

    def test_workers_sort_and_are_searched(self):
        with FakeFarm(workers=300) as farm:
            page = self.open(farm.url, "#/workers")
            expect(page.locator(".count")).to_contain_text("300 workers")
            page.get_by_role("button", name="State").click()
            expect(page.locator(".rows .row:not([hidden]) .state").first).to_have_text("drained")
            page.get_by_label("Filter by name, host or state").fill("node0299")
            expect(page.locator(".count")).to_have_text("1 of 300")

    def test_a_drained_worker_is_one_that_was_confirmed(self):
        with FakeFarm(workers=3) as farm:
            page = self.open(farm.url, "#/workers")
            drain = page.get_by_role("button", name="Drain node0001")
            drain.click()
            page.get_by_role("dialog").get_by_role("button", name="Cancel").click()
            self.assertEqual(farm.workers["node0001"]["state"], "ready")
            drain.click()
            page.get_by_role("dialog").get_by_role("button", name="Drain", exact=True).click()
            expect(page.get_by_role("button", name="Resume node0001")).to_be_visible()
            self.assertEqual(farm.workers["node0001"]["state"], "draining")


class Keyboard(BrowserTest):
    def test_from_the_list_to_a_pixel_and_back_by_keys_alone(self):
        with FakeFarm(jobs=100, changes=0) as farm:
            page = self.open(farm.url)
            expect(page.locator(".count")).to_have_text("100 jobs")
            page.get_by_role("table").focus()
            page.keyboard.press("End")
            expect(page.locator(":focus")).to_have_attribute("href", "#/jobs/1")
            page.keyboard.press("Home")
            expect(page.locator(":focus")).to_have_attribute("href", "#/jobs/100")
            page.keyboard.press("ArrowDown")
            page.keyboard.press("Enter")
            expect(page.locator("h1")).to_be_focused()
            page.locator(".stage").focus()
            expect(page.locator(".readout")).to_contain_text("240 × 160")
            page.keyboard.press("ArrowRight")
            # The fake's picture is x / width, y / height, and 0.25 or 2.
            expect(page.locator(".readout")).to_contain_text(f"x 121  y 80   R {121 / 240:.6f}  G 0.500000")
            page.keyboard.press("j")
            expect(page.locator("h1")).to_have_text("Jobs")

    def test_question_mark_lists_keys_and_single_letters_can_be_switched_off(self):
        with FakeFarm(jobs=10) as farm:
            page = self.open(farm.url)
            page.keyboard.press("?")
            expect(page.get_by_role("dialog")).to_contain_text("submit a new scene")
            page.get_by_label("Enable keyboard shortcuts").uncheck()
            page.keyboard.press("Escape")
            page.keyboard.press("w")
            expect(page.locator("h1")).to_have_text("Jobs")


class Steering(BrowserTest):
    def test_a_repeated_attempt_has_the_same_idempotency_key(self):
        with FakeFarm(jobs=9) as farm, tempfile.TemporaryDirectory() as directory:
            scene = pathlib.Path(directory, "small.json")
            scene.write_text(json.dumps({"version": 1, "image": {"width": 600, "height": 300}, "spheres": []}))
            page = self.open(farm.url, "#/submit")
            keys = []
            page.on("request", lambda request: request.url.endswith("/jobs") and request.method == "POST" and keys.append(request.headers["idempotency-key"]))
            page.locator("#files").set_input_files(str(scene))
            farm.refusal = (503, "the disk is full")
            page.get_by_role("button", name="Submit").click()
            expect(page.get_by_role("alert")).to_have_text("the disk is full")
            page.get_by_role("button", name="Submit").click()
            expect(page.locator("h1")).to_contain_text("10")
            self.assertEqual(len(keys), 3)
            self.assertEqual(keys[0], keys[1])
            self.assertNotEqual(keys[1], keys[2])  # the job's own and the quick look's


class Strangers(BrowserTest):
    def test_names_are_text_wherever_they_are_shown(self):
        evil = "<img src=x onerror='window.caught=1'><script>window.caught=1</script>"
        with FakeFarm(jobs=30, workers=3, changes=0) as farm:
            farm.jobs[29].update(name=evil, user=evil, reason=evil, flag=evil, waits_for=evil)
            worker = {**farm.workers.pop("node0000"), "name": evil, "host": evil, "reason": evil}
            farm.workers[evil] = worker
            page = self.open(farm.url)
            expect(page.locator(".rows")).to_contain_text(evil)
            page.goto(farm.url + "#/jobs/29")
            expect(page.locator("h1")).to_contain_text(evil)
            expect(page.locator(".panel .notice", has_text=evil)).to_have_count(2)
            page.goto(farm.url + "#/workers")
            expect(page.locator(".rows")).to_contain_text(evil)
            page.get_by_role("button", name=f"Drain {evil}").click()
            expect(page.get_by_role("dialog")).to_contain_text(evil)
            self.assertIsNone(page.evaluate("window.caught ?? null"))


class Connection(BrowserTest):
    def test_a_lost_connection_is_said_and_found_again(self):
        with FakeFarm(jobs=30, workers=4) as farm:
            page = self.open(farm.url)
            expect(page.locator("#connection")).to_have_text("live")
            farm.stop()
            expect(page.locator("#connection")).to_contain_text("connection lost")
            del farm.jobs[30]
            farm.start()
            expect(page.locator("#connection")).to_have_text("live")
            expect(page.locator(".count")).to_have_text("29 jobs")

    def test_without_room_for_a_stream_it_asks_again_and_again(self):
        with FakeFarm(jobs=30, streams=False, changes=0) as farm:
            page = self.open(farm.url)
            expect(page.locator("#connection")).to_contain_text("polling every")
            farm.jobs[29]["state"] = "done"
            expect(page.locator(".rows .row").filter(has_text=re.compile("^29")).locator(".state")).to_have_text("done")


class Everybody(BrowserTest):
    VIEWS = ("#/jobs", "#/jobs/30", "#/jobs/29", "#/farm", "#/workers", "#/workers/node0009", "#/submit")

    def test_axe_finds_no_violation_in_either_theme_and_on_a_phone(self):
        source = axe()
        with FakeFarm(jobs=40, workers=200, changes=0) as farm:
            farm.jobs[30].update(state="done", progress=1.0)
            farm.jobs[29].update(state="failed", reason="three workers failed at the same rows")
            for theme in ("light", "dark"):
                for size in (DESKTOP, PHONE):
                    for view in self.VIEWS + ("?",):
                        page = self.open(farm.url, view if view != "?" else "#/jobs", color_scheme=theme, viewport=size)
                        expect(page.locator("#connection")).to_have_text("live")
                        if view == "?":
                            page.keyboard.press("?")
                        self.assertEqual(violations(page, source), [], f"{theme}, {size['width']}, {view}")
                        page.context.close()

    def test_at_360_pixels_nothing_is_wider_than_the_screen(self):
        with FakeFarm(jobs=40, workers=40, changes=0) as farm:
            for view in self.VIEWS:
                page = self.open(farm.url, view, viewport=PHONE, has_touch=True, is_mobile=True)
                expect(page.locator("#connection")).to_have_text("live")
                self.assertEqual(page.evaluate("document.documentElement.scrollWidth"), 360, view)
                page.context.close()

    def test_the_document_never_scrolls_its_views_do(self):
        with JobFarm(frames=61) as farm:
            for size in (DESKTOP, PHONE):
                for view in (f"#/jobs/{SERIES}", *self.VIEWS[1:], "api"):
                    page = self.open(farm.url, view, viewport=size)
                    expect(page.locator("#connection, .operation").first).to_be_visible()
                    page.wait_for_timeout(500)
                    self.assertEqual(page.evaluate("document.documentElement.scrollHeight - innerHeight"), 0, f"{size['width']}, {view}")
                    page.context.close()

    def test_the_help_begins_at_its_top_and_placeholders_fit(self):
        with FakeFarm(jobs=4, changes=0) as farm:
            for size in (DESKTOP, PHONE):
                page = self.open(farm.url, "#/submit", viewport=size)
                page.get_by_role("button", name="Help").click()
                self.assertEqual(page.get_by_role("dialog").evaluate("dialog => dialog.scrollTop"), 0)
                page.keyboard.press("Escape")
                # Only a value can be measured: digits of at least the width of the placeholder.
                cut = page.evaluate("""() => [...document.querySelectorAll('.fields input[type=number]')].filter(input => input.getClientRects().length).filter(input => {
                  const style = getComputedStyle(input), pen = document.createElement('canvas').getContext('2d');
                  pen.font = `${style.fontSize} ${style.fontFamily}`;
                  input.value = '1'.repeat(Math.ceil(pen.measureText(input.placeholder).width / pen.measureText('1').width));
                  return input.scrollWidth > input.clientWidth;
                }).map(input => input.name)""")
                self.assertEqual(cut, [], size["width"])
                page.context.close()

    def test_the_theme_is_the_systems_until_another_is_chosen(self):
        with FakeFarm(jobs=4) as farm:
            page = self.open(farm.url, color_scheme="dark")
            ground = "getComputedStyle(document.body).backgroundColor"
            dark = page.evaluate(ground)
            page.get_by_role("button", name="Theme").click()
            self.assertNotEqual(page.evaluate(ground), dark)
            page.reload()
            self.assertNotEqual(page.evaluate(ground), dark)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v", *sys.argv[1:]])
