#!/usr/bin/env python3
"""The list of jobs: what a row says, search and order, many jobs at once."""

import json
import re
import sys
import unittest

from browser import BrowserTest, expect
from fake_farm import FakeFarm

FORMER_FIELDS = ("submitted", "started", "finished", "seconds_taken", "samples_taken", "has_picture", "waits_for_job", "queue_place",
                 "starts_in", "denoise")


def row_of(page, number):
    return page.locator(".rows .row:not([hidden])").filter(has=page.locator(f'a[href="#/jobs/{number}"]')).first


def requests(farm, start="/api/v1/jobs?"):
    return [path for method, path in farm.asked if method == "GET" and path.startswith(start)]


def scroll_to(page, top):
    """Scrolls the list and waits until its rows are drawn there."""
    page.evaluate("""async top => {
      document.querySelector('.scroller').scrollTop = top;
      for (let i = 0; i < 3; ++i) await new Promise(requestAnimationFrame);
    }""", top)


class Rows(BrowserTest):
    def test_each_state_says_what_matters_about_it(self):
        with FakeFarm(jobs=20, changes=0) as farm:
            farm.jobs[20].update(state="done", progress=1.0, seconds_taken=49.0)
            farm.jobs[19].update(state="failed", reason="not enough memory")
            farm.jobs[18].update(state="queued", progress=0.0, waits_for="job 7 of priority 50", waits_for_job=7, queue_place=3, starts_in=None)
            farm.jobs[17].update(state="running", progress=0.2, waits_for="a worker", seconds_left=-1)
            farm.jobs[16].update(state="running", progress=0.2, waits_for="", samples_per_pixel=None, samples_taken=47.2)
            farm.jobs[15].update(state="cancelled", progress=0.028, seconds_taken=3.0)
            page = self.open(farm.url)
            expect(row_of(page, 20).locator(".progress")).to_have_text("49 s")
            expect(row_of(page, 20).locator(".bar")).to_be_hidden()
            expect(row_of(page, 19).locator(".progress")).to_have_text("not enough memory")
            expect(row_of(page, 18).locator(".state")).to_have_text("queued, 3rd")
            expect(row_of(page, 18).locator(".progress")).to_have_text("after job 7")
            expect(row_of(page, 17).locator(".state")).to_have_text("waiting")
            expect(row_of(page, 17).locator(".progress")).to_contain_text("waits for a worker")
            expect(row_of(page, 16).locator(".size")).to_have_text("1200 × 800, 47 spp")
            expect(row_of(page, 16).locator(".size")).to_have_attribute("title", re.compile("no limit"))
            expect(row_of(page, 15).locator(".progress")).to_have_text("at 2.8 %, 3.0 s")
            expect(row_of(page, 20).locator("time").first).to_have_text(re.compile(r" ago$"))

    def test_fields_that_an_older_server_lacks_are_left_out(self):
        with FakeFarm(jobs=40, changes=0) as farm:
            for job in farm.jobs.values():
                for name in FORMER_FIELDS:
                    job.pop(name, None)
                job["samples_per_pixel"] = 2**24
            page = self.open(farm.url)
            expect(page.locator(".count")).to_have_text("40 jobs")
            self.assertNotRegex(page.locator(".rows").inner_text(), "undefined|null|NaN|16.?777|Invalid")
            self.assertEqual(requests(farm, "/api/v1/jobs/"), [])  # no thumbnails

    def test_a_quick_look_stands_in_the_row_of_its_job(self):
        with FakeFarm(jobs=20, changes=0) as farm:
            farm.jobs[21] = {**farm.jobs[20], "id": 21, "name": "glass (quick look)", "preview_of": 20, "state": "done"}
            farm.jobs[22] = {**farm.jobs[20], "id": 22, "name": "lost (quick look)", "preview_of": 999, "state": "done"}
            page = self.open(farm.url)
            expect(page.locator(".count")).to_have_text("21 jobs")
            expect(row_of(page, 20).locator(".quick")).to_have_attribute("href", "#/jobs/21")
            self.assertEqual(page.locator(".rows .id:visible").filter(has_text="21").count(), 0)
            expect(page.locator(".rows")).to_contain_text("lost (quick look)")  # its job is not here

    def test_no_cell_is_cut_at_1280_pixels(self):
        with FakeFarm(jobs=60, changes=0) as farm:
            for job in farm.jobs.values():
                job.update(samples_per_pixel=16384, target_error=0.0035)
            farm.jobs[60].update(frames=61, frames_done=12, state="running")
            for place, number in enumerate((59, 58, 57)):
                farm.jobs[number].update(state="queued", waits_for="job 60 of priority 50", waits_for_job=60, queue_place=10 + place, starts_in=500.0)
            page = self.open(farm.url, viewport={"width": 1280, "height": 800})
            expect(page.locator(".count")).to_have_text("60 jobs")
            cut = page.evaluate("""() => [...document.querySelectorAll('.jobs .row:not([hidden]) > *')]
                .filter(cell => cell.getClientRects().length && cell.scrollWidth > cell.clientWidth + 1).map(cell => cell.className + ': ' + cell.textContent)""")
            self.assertEqual(cut, [])

    def test_thumbnails_are_requested_for_visible_rows_only_and_with_the_token(self):
        with FakeFarm(jobs=400, changes=0, token="secret") as farm:
            page = self.open("about:blank", "")
            page.add_init_script("sessionStorage.setItem('parray-token', 'secret')")
            page.goto(farm.url)
            expect(row_of(page, 399).locator("img")).to_be_visible()
            page.wait_for_timeout(1000)
            asked = {int(path.split("/")[4]) for path in requests(farm, "/api/v1/jobs/")}
            self.assertTrue(asked and min(asked) > 350, asked)
            self.assertTrue(all("width=64" in path for path in requests(farm, "/api/v1/jobs/")))
            page.get_by_label("pictures").uncheck()
            expect(row_of(page, 399).locator("img")).to_be_hidden()
            before = len(requests(farm, "/api/v1/jobs/"))
            page.get_by_role("table").focus()
            page.keyboard.press("End")
            page.wait_for_timeout(600)
            self.assertEqual(len(requests(farm, "/api/v1/jobs/")), before)


class Query(BrowserTest):
    def test_a_search_is_asked_of_the_server_and_kept_in_the_address(self):
        with FakeFarm(jobs=3000, changes=0) as farm:
            farm.jobs[7]["name"] = "Needle in hay"
            page = self.open(farm.url)
            expect(page.locator(".count")).to_have_text(re.compile(r"3\s000 jobs"))
            page.keyboard.press("/")
            page.keyboard.type("needle")
            expect(page.locator(".count")).to_have_text("1 job")
            expect(row_of(page, 7)).to_be_visible()
            self.assertTrue(any("name=needle" in path for path in requests(farm)))
            self.assertTrue(page.url.endswith("#/jobs?q=needle"))
            page.reload()
            expect(page.locator(".count")).to_have_text("1 job")
            page.get_by_label("Search name or number").fill("12")  # the number of a job
            expect(row_of(page, 12)).to_be_visible()

    def test_heads_sort_on_the_server_and_reverse(self):
        with FakeFarm(jobs=1500, changes=0) as farm:
            farm.jobs[3]["seconds_taken"] = 1e6
            farm.jobs[3].update(state="done")
            page = self.open(farm.url)
            expect(page.locator(".count")).to_contain_text("jobs")
            first = page.locator(".rows .row:not([hidden]) .id")
            page.get_by_role("button", name="Took").click()
            expect(row_of(page, 3)).to_be_visible()
            self.assertTrue(any("sort=taken&order=desc" in path for path in requests(farm)))
            self.assertIn("sort=taken", page.url)
            head = page.get_by_role("columnheader", name="Took")
            expect(head).to_have_attribute("aria-sort", "descending")
            page.get_by_role("button", name="Took").click()
            expect(head).to_have_attribute("aria-sort", "ascending")
            expect(page.locator(".rows .row:not([hidden]) .state").first).to_have_text(re.compile("queued"))  # they have taken no time yet
            # All pages of another order than by number.
            page.get_by_role("button", name="Scene").click()
            for _ in range(100):
                page.evaluate("() => { const s = document.querySelector('.scroller'); s.scrollTop = s.scrollHeight; }")
                if page.get_by_role("table").get_attribute("aria-rowcount") == "1501":
                    break
                page.wait_for_timeout(100)
            self.assertEqual(page.get_by_role("table").get_attribute("aria-rowcount"), "1501")
            self.assertTrue(any("sort=name&order=asc&offset=1000" in path for path in requests(farm)))
            self.assertGreater(first.count(), 0)

    def test_user_and_mine_are_filters_of_the_address(self):
        with FakeFarm(jobs=100, changes=0, user="ben") as farm:
            of = {user: sum(job["user"] == user for job in farm.jobs.values()) for user in ("ann", "ben")}
            page = self.open(farm.url, "#/jobs?user=ann&state=done")
            done = sum(job["user"] == "ann" and job["state"] == "done" for job in farm.jobs.values())
            expect(page.locator(".count")).to_have_text(f"{done} jobs")
            page.get_by_label("all", exact=True).check(force=True)
            expect(page.locator(".count")).to_have_text(f"{of['ann']} jobs")
            page.get_by_label("only mine").check()
            expect(page.locator(".count")).to_have_text(f"{of['ben']} jobs")
            self.assertIn("mine=1", page.url)
            self.assertTrue(any("user=ben" in path for path in requests(farm)))
            page.get_by_role("link", name="Jobs", exact=True).click()  # of the list itself: all jobs again
            expect(page.locator(".count")).to_have_text("100 jobs")

    def test_back_from_a_job_the_list_is_where_it_was(self):
        with FakeFarm(jobs=400, changes=0) as farm:
            page = self.open(farm.url, "#/jobs?state=done")
            expect(page.locator(".count")).to_contain_text("jobs")
            scroll_to(page, 3000)
            link = page.locator(".rows .row:not([hidden]) .name a:first-child").nth(12)
            href = link.get_attribute("href")
            top = page.evaluate("document.querySelector('.scroller').scrollTop")
            link.click()
            expect(page).to_have_url(farm.url + href)
            page.get_by_role("link", name="All jobs").click()
            expect(page.locator(":focus")).to_have_attribute("href", href)
            self.assertEqual(page.evaluate("document.querySelector('.scroller').scrollTop"), top)
            self.assertTrue(page.url.endswith("#/jobs?state=done"))

    def test_the_list_does_not_move_under_the_reader_when_jobs_arrive(self):
        with FakeFarm(jobs=200, changes=0) as farm:
            page = self.open(farm.url)
            expect(page.locator(".count")).to_have_text("200 jobs")
            scroll_to(page, 2000)
            link = page.locator(".rows .row:not([hidden]) .name a:first-child").nth(8)
            href = link.get_attribute("href")
            link.focus()
            where = page.evaluate("document.activeElement.getBoundingClientRect().top")
            for number in (201, 202, 203):
                farm.jobs[number] = {**farm.jobs[199], "id": number, "state": "running"}
            expect(page.locator(".count")).to_have_text("203 jobs")
            expect(page.locator(":focus")).to_have_attribute("href", href)
            self.assertAlmostEqual(page.evaluate("document.activeElement.getBoundingClientRect().top"), where, delta=1)


class ManyJobs(BrowserTest):
    def choose(self, page, first, last):
        row_of(page, first).get_by_role("checkbox").click()
        row_of(page, last).get_by_role("checkbox").click(modifiers=["Shift"])

    def test_a_range_is_cancelled_with_one_question_and_one_request_and_refusals_are_listed(self):
        with FakeFarm(jobs=40, changes=0) as farm:
            for job in farm.jobs.values():
                job.update(state="running", progress=0.3)
            farm.jobs[35].update(state="done")
            farm.locked = {33, 31}
            page = self.open(farm.url)
            expect(page.locator(".count")).to_have_text("40 jobs")
            self.choose(page, 38, 30)
            bar = page.get_by_role("group", name="Actions for the chosen jobs")
            expect(bar).to_contain_text("9 chosen")
            bar.get_by_role("button", name="Cancel 8").click()
            expect(page.get_by_role("button", name="Keep jobs")).to_be_focused()
            page.get_by_role("dialog").get_by_role("button", name="Cancel 8 jobs").click()
            dialog = page.get_by_role("dialog")
            expect(dialog).to_contain_text("6 jobs cancelled.")
            expect(dialog).to_contain_text("2 jobs refused")
            sent = [path for method, path in farm.asked if method == "POST"]
            self.assertEqual(sent, ["/api/v1/jobs/cancel"])
            self.assertEqual(json.loads(farm.bodies["/api/v1/jobs/cancel"]), {"ids": [38, 37, 36, 34, 33, 32, 31, 30]})
            self.assertEqual(farm.jobs[38]["state"], "cancelled")
            dialog.get_by_role("button", name="Close").click()
            expect(row_of(page, 38).locator(".state")).to_have_text("cancelled")

    def test_priority_and_delete_of_many(self):
        with FakeFarm(jobs=20, changes=0) as farm:
            for job in farm.jobs.values():
                job.update(state="queued")
            page = self.open(farm.url)
            self.choose(page, 20, 18)
            page.get_by_role("button", name="Priority").last.click()
            page.get_by_label("Priority, 0 to 100").fill("77")
            page.get_by_role("button", name="Set").click()
            expect(page.locator("#notes")).to_contain_text("3 jobs changed to priority 77.")
            self.assertEqual([farm.jobs[number]["priority"] for number in (20, 19, 18, 17)], [77, 77, 77, 50])
            for number in (20, 19, 18):
                farm.jobs[number]["state"] = "done"
            page.reload()
            self.choose(page, 20, 18)
            page.get_by_role("button", name="Delete").click()
            page.get_by_role("dialog").get_by_role("button", name="Delete 3 jobs").click()
            expect(page.locator(".count")).to_have_text("17 jobs")
            expect(page.locator(".bulk")).to_be_hidden()

    def test_keys_choose_rows_and_escape_chooses_none(self):
        with FakeFarm(jobs=30, changes=0) as farm:
            page = self.open(farm.url)
            expect(page.locator(".count")).to_have_text("30 jobs")
            page.get_by_role("table").focus()
            page.keyboard.press("Home")
            page.keyboard.press("x")
            page.keyboard.press("Shift+ArrowDown")
            page.keyboard.press("Shift+ArrowDown")
            expect(page.locator(".bulk")).to_contain_text("3 chosen")
            page.keyboard.press("Escape")
            expect(page.locator(".bulk")).to_be_hidden()

    def test_only_jobs_that_the_user_controls_can_be_changed(self):
        with FakeFarm(jobs=20, changes=0, user="ben", role="client") as farm:
            for job in farm.jobs.values():
                job.update(state="running")
            own = sum(job["user"] == "ben" for job in farm.jobs.values())
            page = self.open(farm.url)
            expect(page.locator(".count")).to_have_text("20 jobs")
            page.get_by_label("Choose all shown jobs").check()
            expect(page.get_by_role("button", name=f"Cancel {own}")).to_be_enabled()
            expect(page.get_by_role("button", name="Delete")).to_be_disabled()

    def test_all_jobs_of_a_query_are_changed_in_requests_of_500(self):
        with FakeFarm(jobs=2500, changes=0) as farm:
            for job in farm.jobs.values():
                job.update(state="done", name="kept" if job["id"] % 5 == 0 else "old")
            page = self.open(farm.url, "#/jobs?q=old")
            expect(page.locator(".count")).to_have_text(re.compile(r"2\s000 jobs"))
            page.get_by_label("Choose all shown jobs").check()
            page.get_by_role("button", name=re.compile(r"Choose all 2\s000")).click()
            expect(page.locator(".bulk")).to_contain_text(re.compile(r"2\s000 chosen"))
            page.get_by_role("button", name="Delete").click()
            page.get_by_role("dialog").get_by_role("button", name=re.compile("Delete 2")).click()
            expect(page.locator(".empty")).to_contain_text("No job matches")
            self.assertEqual(len(farm.jobs), 500)
            self.assertEqual(sum(method == "POST" for method, _ in farm.asked), 4)

    def test_if_a_later_request_fails_the_page_says_which_jobs_were_changed(self):
        with FakeFarm(jobs=700, changes=0) as farm:
            for job in farm.jobs.values():
                job.update(state="done")
            page = self.open(farm.url)
            expect(page.locator(".count")).to_have_text("700 jobs")
            page.get_by_label("Choose all shown jobs").check()
            page.get_by_role("button", name="Choose all 700").click()
            def fail_later(route):
                if any(method == "POST" for method, _ in farm.asked):
                    farm.refusal = (503, "the coordinator does not answer")
                route.continue_()
            page.route("**/jobs/forget", fail_later)
            page.get_by_role("button", name="Delete").click()
            page.get_by_role("dialog").get_by_role("button", name="Delete 700 jobs").click()
            expect(page.get_by_role("alert")).to_contain_text("the coordinator does not answer. 500 jobs deleted.")
            expect(page.locator(".count")).to_have_text("200 jobs")
            expect(page.locator(".bulk")).to_contain_text("200 chosen")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v", *sys.argv[1:]])
