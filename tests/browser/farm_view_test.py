#!/usr/bin/env python3
"""The view of the farm: its last hour, users, limits, events, and what stops it."""

import re
import sys
import time
import unittest

from browser import DESKTOP, PHONE, BrowserTest, axe, expect
from fake_farm import FakeFarm


class Farm(BrowserTest):
    def test_figures_say_speed_threads_the_rest_of_the_queue_and_states(self):
        with FakeFarm(jobs=100, workers=10, changes=0) as farm:
            page = self.open(farm.url, "#/farm")
            figures = page.locator(".figures")
            for text in ("224 M samples/s", "512 of 512 busy", "1 h 10 min", "8 ready", "1 quarantined", "10 running"):
                expect(figures).to_contain_text(text)
            expect(figures.get_by_role("link", name="1 quarantined")).to_have_attribute("href", "#/workers?q=quarantined")
            expect(figures.get_by_role("link", name="10 running")).to_have_attribute("href", "#/jobs?state=running")

    def test_charts_have_a_summary_a_value_under_the_pointer_and_a_table(self):
        with FakeFarm(jobs=20, workers=10, changes=0) as farm:
            page = self.open(farm.url, "#/farm")
            chart = page.locator(".chart").first
            expect(chart.get_by_role("img")).to_have_attribute("aria-label", re.compile(
                "Samples per second, last hour: now 3.* M, lowest 0, highest 3.* M, mean"))
            box = chart.get_by_role("img").bounding_box()
            page.mouse.move(box["x"] + box["width"] / 2, box["y"] + 60)
            expect(chart.locator(".read")).to_have_text("30 min ago: 0")
            page.mouse.move(2, 2)
            chart.get_by_text("Table").click()
            expect(chart.locator("tbody tr")).to_have_count(12)
            self.assertEqual(chart.locator("tbody td").all_inner_texts()[6], "0")  # the break

    def test_a_young_farm_has_a_short_time_axis(self):
        with FakeFarm(jobs=20, workers=10, changes=0) as farm:
            farm.steps = 30
            page = self.open(farm.url, "#/farm")
            chart = page.locator(".chart").first
            expect(chart.locator("path.stroke")).to_have_count(1)
            # From the chart, because the path is drawn again with each answer.
            widths = chart.evaluate("chart => [chart.querySelector('path.stroke').getBBox().width, chart.querySelector('svg').clientWidth]")
            self.assertAlmostEqual(widths[0] / widths[1], 29 / 72, delta=0.02)
            expect(chart).to_contain_text("12 min ago")

    def test_unknown_values_are_gaps(self):
        with FakeFarm(jobs=20, workers=10, changes=0) as farm:
            page = self.open(farm.url)
            history = {"interval": 10, "end": time.time(), "samples_per_second": [5, 6, None, None, 7, 8], "busy_threads": [], "threads": []}
            page.route("**/farm/history", lambda route: route.fulfill(json=history))
            page.goto(farm.url + "#/farm")
            expect(page.locator(".chart").first.locator("path.stroke")).to_have_count(2)

    def test_users_have_shares_of_the_time_and_link_to_their_jobs(self):
        with FakeFarm(jobs=100, changes=0) as farm:
            usual = {"share": 1, "open_jobs": 2, "done_jobs": 3, "failed_jobs": 0, "cancelled_jobs": 0, "queue_seconds_mean": None}
            farm.farm_fields["users"] = [{"user": "ben", "thread_seconds": 100, **usual}, {"user": "ann", "thread_seconds": 300, **usual}]
            page = self.open(farm.url, "#/farm")
            expect(page.get_by_role("row").nth(1)).to_contain_text("ann")  # the largest first
            row = page.get_by_role("row").filter(has_text="ann")
            expect(row).to_contain_text("75 %")
            expect(row.get_by_role("link", name="ann")).to_have_attribute("href", "#/jobs?user=ann")

    def test_limits_warn_before_they_are_reached(self):
        with FakeFarm(jobs=10, changes=0) as farm:
            page = self.open(farm.url, "#/farm")
            memory, disk = page.locator(".limit").all()
            expect(memory.locator(".advice")).to_be_hidden()
            expect(disk).to_contain_text("90 %")
            expect(disk.locator(".advice")).to_contain_text("--max-disk")
            farm.farm_fields["disk"] = {"used": 106e9, "most": 107e9}
            expect(disk).to_have_class("limit full")

    def test_a_storage_problem_stands_on_top(self):
        with FakeFarm(jobs=10, changes=0) as farm:
            farm.farm_fields["storage"] = "no space left on /var/lib/parray"
            page = self.open(farm.url, "#/farm")
            expect(page.get_by_role("alert")).to_contain_text("no space left on /var/lib/parray")

    def test_events_link_to_workers_and_jobs_and_are_filtered(self):
        with FakeFarm(jobs=100, changes=0) as farm:
            farm.farm_fields["events"] = [
                {"at": time.time() - 120, "kind": "lost", "worker": "w 1", "text": "w 1 lost: silent for 5 s"},
                {"at": time.time() - 240, "kind": "job_failed", "job": 7, "text": "job 7 failed: three workers failed"},
                {"at": time.time() - 300, "kind": "job_done", "job": 6, "text": "24 s"},
                {"at": time.time() - 7200, "kind": "started", "text": "the coordinator started"}]
            page = self.open(farm.url, "#/farm")
            rows = page.get_by_role("list", name="Events").get_by_role("listitem")
            expect(rows).to_have_text(["2 min agow 1 lost: silent for 5 s", "4 min agojob 7 failed: three workers failed",
                                       "5 min agojob 6 done: 24 s", "2 h ago the coordinator started"])
            expect(rows.first.get_by_role("link")).to_have_attribute("href", "#/workers/w%201")
            expect(rows.nth(1).get_by_role("link")).to_have_attribute("href", "#/jobs/7")
            page.get_by_label("problems", exact=True).check(force=True)
            expect(rows).to_have_count(2)

    def test_workers_that_left_are_listed(self):
        with FakeFarm(jobs=10, changes=0) as farm:
            page = self.open(farm.url, "#/farm")
            expect(page.get_by_role("list", name="Workers that left").get_by_role("listitem").first).to_have_text("2 min agow1 of rack9, lost: silent")

    def test_without_workers_the_command_that_starts_one_is_shown(self):
        with FakeFarm(jobs=3, workers=0, changes=0) as farm:
            page = self.open(farm.url, "#/farm")
            expect(page.locator(".warning")).to_contain_text("No workers are connected. Jobs wait.")
            expect(page.locator(".warning code")).to_have_text("parray-worker --coordinator tcp://farm.example:17400")

    def test_an_older_coordinator_is_named_as_the_cause(self):
        with FakeFarm(jobs=3) as farm:
            page = self.open(farm.url)
            page.route("**/api/v1/farm**", lambda route: route.fulfill(status=404, body='{"detail": "no such path"}'))
            page.goto(farm.url + "#/farm")
            expect(page.locator(".farm .trouble").first).to_contain_text("older than this page")

    def test_the_view_asks_only_while_it_is_shown(self):
        with FakeFarm(jobs=3, changes=0) as farm:
            page = self.open(farm.url, "#/farm")
            expect(page.locator(".figures")).to_contain_text("ready")
            page.goto(farm.url + "#/submit")
            expect(page.locator("h1")).to_have_text("Submit a scene")
            page.wait_for_timeout(500)
            count = len(farm.asked)
            page.wait_for_timeout(6000)
            self.assertEqual([path for _, path in farm.asked[count:] if "farm" in path], [])

    def test_signing_out_empties_the_view(self):
        with FakeFarm(jobs=30, token="secret", changes=0) as farm:
            page = self.open(farm.url, "#/farm")
            page.evaluate("sessionStorage['parray-token'] = 'secret'")
            page.reload()
            expect(page.locator(".figures")).to_contain_text("ready")
            page.get_by_role("button", name="Sign out ann").click()
            expect(page.locator(".figures")).to_be_hidden()
            expect(page.locator("main")).not_to_contain_text("ann")


class Everybody(BrowserTest):
    def test_axe_finds_no_violation_with_problems_and_without_workers(self):
        source = axe()
        for workers in (0, 10):
            with FakeFarm(jobs=30, workers=workers, changes=0) as farm:
                farm.farm_fields = {"storage": "no space left", "disk": {"used": 106e9, "most": 107e9}}
                for theme in ("light", "dark"):
                    for size in (DESKTOP, PHONE):
                        page = self.open(farm.url, "#/farm", color_scheme=theme, viewport=size)
                        expect(page.locator(".figures")).to_contain_text("queued")
                        page.locator(".chart summary").first.click()
                        page.evaluate(source)
                        found = page.evaluate("axe.run().then(result => result.violations.map(v => [v.id, v.nodes.map(n => n.html + ' ' + n.failureSummary)]))")
                        self.assertEqual(found, [], f"{theme}, {size['width']}, {workers} workers")
                        self.assertLessEqual(page.evaluate("document.documentElement.scrollWidth"), size["width"])
                        page.context.close()


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v", *sys.argv[1:]])
