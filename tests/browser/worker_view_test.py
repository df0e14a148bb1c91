#!/usr/bin/env python3
"""The list of workers, those that left, and the view of one worker."""

import sys
import unittest

from browser import DESKTOP, PHONE, BrowserTest, axe, expect
from fake_farm import FakeFarm


def row(page, name):
    return page.locator(".rows .row:not([hidden])").filter(has_text=name)


class Workers(BrowserTest):
    def test_a_drained_or_idle_worker_shows_no_speed_and_no_bar(self):
        with FakeFarm(workers=10, changes=0) as farm:
            farm.workers["node0005"]["contribution"] = 0
            page = self.open(farm.url, "#/workers")
            for name, text in (("node0005", ""), ("node0006", "idle"), ("node0009", "")):
                expect(row(page, name).locator(".share")).to_have_text(text)
                expect(row(page, name).locator(".tracing-speed")).to_have_text("")
                self.assertEqual(row(page, name).locator(".bar").evaluate("bar => getComputedStyle(bar).visibility"), "hidden")
            expect(row(page, "node0001").locator(".share")).to_have_text("38.4 M/s")
            expect(row(page, "node0001").locator(".tracing-speed")).to_have_text("48.0 M/s")
            expect(row(page, "node0001").get_by_role("link", name="job 2")).to_have_attribute("href", "#/jobs/2")

    def test_heads_and_buttons_explain_contribution_leases_results_and_resume(self):
        with FakeFarm(workers=10, changes=0) as farm:
            page = self.open(farm.url, "#/workers")
            for name in ("Contribution", "While tracing", "Leases", "Results"):
                self.assertGreater(len(page.get_by_role("button", name=name).get_attribute("title")), 20, name)
            self.assertIn("leases", page.get_by_role("button", name="Resume node0005").get_attribute("title"))

    def test_an_older_coordinator_without_contributions_shows_speeds(self):
        with FakeFarm(workers=3, changes=0) as farm:
            for worker in farm.workers.values():
                for name in ("contribution", "tracing", "version", "load", "failures"):
                    del worker[name]
            page = self.open(farm.url, "#/workers")
            expect(row(page, "node0001").locator(".share")).to_have_text("48.0 M/s")
            self.assertNotIn("undefined", page.locator("main").inner_text())

    def test_the_search_finds_states_and_the_address_sets_it(self):
        with FakeFarm(workers=300, changes=0) as farm:
            page = self.open(farm.url, "#/workers")
            expect(page.locator(".count")).to_contain_text("300 workers, 19 200 threads")
            page.get_by_label("Filter by name, host or state").fill("drained rack1")
            expect(page.locator(".count")).to_have_text("1 of 300")
            page.goto(farm.url + "#/workers?q=quarantined")
            expect(page.locator(".count")).to_have_text("2 of 300")

    def test_a_second_click_on_a_head_turns_the_order(self):
        with FakeFarm(workers=30, changes=0) as farm:
            page = self.open(farm.url, "#/workers")
            head = page.get_by_role("button", name="Results")
            head.click()
            expect(page.locator(".rows .row .name").first).to_have_text("node0029")
            expect(page.get_by_role("columnheader", name="Results")).to_have_attribute("aria-sort", "descending")
            head.click()
            expect(page.get_by_role("columnheader", name="Results")).to_have_attribute("aria-sort", "ascending")
            expect(page.locator(".rows .row:not([hidden])").filter(has_text="node0000")).to_be_visible()

    def test_an_empty_list_shows_the_command_of_this_server_with_a_copy_button(self):
        with FakeFarm(workers=0, changes=0) as farm:
            farm.server_fields["loopback"] = True
            page = self.open(farm.url, "#/workers", permissions=["clipboard-read", "clipboard-write"])
            expect(page.locator(".empty code")).to_have_text("parray-worker --coordinator tcp://farm.example:17400")
            expect(page.locator(".empty")).to_contain_text("serves only its own machine")
            page.get_by_role("button", name="Copy").click()
            expect(page.locator("#notes")).to_contain_text("Copied")
            self.assertEqual(page.evaluate("navigator.clipboard.readText()"), "parray-worker --coordinator tcp://farm.example:17400")

    def test_workers_are_added_to_a_farm_that_has_some(self):
        with FakeFarm(workers=3, token="secret", changes=0) as farm:
            page = self.open(farm.url, "#/workers")
            page.evaluate("sessionStorage['parray-token'] = 'secret'")
            page.reload()
            page.get_by_role("button", name="Add workers").click()
            expect(page.get_by_role("dialog")).to_contain_text("tcp://farm.example:17400")
            expect(page.get_by_role("dialog")).to_contain_text("worker.key")

    def test_workers_that_left_are_listed_below(self):
        with FakeFarm(workers=3, changes=0) as farm:
            page = self.open(farm.url, "#/workers")
            expect(page.get_by_role("list", name="Workers that left").get_by_role("listitem").first).to_have_text("2 min agow1 of rack9, lost: silent")


class OneWorker(BrowserTest):
    def test_it_shows_its_machine_its_job_its_last_hour_and_its_failures(self):
        with FakeFarm(jobs=30, workers=10, changes=0) as farm:
            page = self.open(farm.url, "#/workers")
            page.get_by_role("link", name="node0008").click()
            expect(page.locator("h1")).to_have_text("node0008")
            self.assertEqual(page.title(), "node0008 · ParRay")
            facts = page.locator(".facts")
            for text in ("job 4", "35.2 M/s in the last minute", "64 on 64 processors", "63.20", "270 GB", "0.2.0", "10.0.0.8:41022", "9 h ago"):
                expect(facts).to_contain_text(text)
            expect(facts.get_by_role("link", name="job 4")).to_have_attribute("href", "#/jobs/4")
            expect(page.locator(".chart .read")).to_contain_text("M")
            failures = page.get_by_role("region", name="Recent failures").get_by_role("listitem")
            expect(failures).to_have_text(["12 min agojob 7: not enough memory", "1 h agojob 3: two wrong rows"])

    def test_its_log_is_asked_for_once_and_again_by_the_button(self):
        with FakeFarm(jobs=30, workers=10, changes=0) as farm:
            page = self.open(farm.url, "#/workers/node0001")
            log = page.get_by_role("region", name="Log", exact=True)
            expect(log).to_contain_text("traced cell 98 of job 4")
            asked = lambda: sum(path.endswith("/log") for _, path in farm.asked)
            count = asked()
            farm.log_refusal = (502, "node0001 has not answered in 3 s: try again")
            page.get_by_role("button", name="Refresh log").click()
            expect(page.locator(".log-part")).to_contain_text("has not answered in 3 s")
            expect(log).to_contain_text("traced cell 98 of job 4")
            self.assertEqual(asked(), count + 1)

    def test_it_is_drained_and_resumed_by_administrators_only(self):
        with FakeFarm(jobs=30, workers=10, changes=0) as farm:
            page = self.open(farm.url, "#/workers/node0001")
            page.get_by_role("button", name="Drain").click()
            page.get_by_role("dialog").get_by_role("button", name="Drain", exact=True).click()
            expect(page.locator(".bar-of-view .state")).to_have_text("draining")
            expect(page.get_by_role("button", name="Resume")).to_be_visible()
            farm.server_fields["role"] = "client"
            page.reload()
            expect(page.locator(".bar-of-view .state")).to_have_text("draining")
            expect(page.locator("#connection")).to_have_text("live")
            expect(page.get_by_role("button", name="Resume")).to_be_hidden()

    def test_a_quarantined_worker_says_why(self):
        with FakeFarm(workers=10, changes=0) as farm:
            page = self.open(farm.url, "#/workers/node0009")
            expect(page.locator(".worker .trouble")).to_have_text("quarantined: gave two wrong rows")

    def test_a_worker_that_left_says_when_and_why(self):
        with FakeFarm(workers=3, changes=0) as farm:
            page = self.open(farm.url, "#/workers/w1")
            expect(page.locator(".empty")).to_contain_text("Worker w1 is not connected. It left the farm 2 min ago (lost: silent).")
            expect(page.locator(".worker-body")).to_be_hidden()
            expect(page.get_by_role("button", name="Drain")).to_be_hidden()

    def test_names_with_any_letters_are_text_and_lead_to_their_worker(self):
        evil = "<img src=x onerror='window.caught=1'> 100 %/#?"
        with FakeFarm(workers=1, changes=0) as farm:
            worker = {**farm.workers.pop("node0000"), "name": evil, "host": evil, "reason": evil, "version": evil, "address": evil}
            farm.workers[evil] = worker
            page = self.open(farm.url, "#/workers")
            page.get_by_role("link", name=evil).click()
            expect(page.locator("h1")).to_have_text(evil)
            expect(page.locator(".facts")).to_contain_text(evil)
            expect(page.get_by_role("region", name="Log", exact=True)).to_contain_text("traced cell")
            self.assertIsNone(page.evaluate("window.caught ?? null"))

    def test_axe_finds_no_violation(self):
        source = axe()
        with FakeFarm(jobs=30, workers=10, changes=0) as farm:
            for theme in ("light", "dark"):
                for size in (DESKTOP, PHONE):
                    for view in ("#/workers/node0008", "#/workers/w1", "#/workers"):
                        page = self.open(farm.url, view, color_scheme=theme, viewport=size)
                        expect(page.locator(".log" if "8" in view else ".worker .empty" if "w1" in view else ".left-part li").first).to_contain_text("w")
                        page.evaluate(source)
                        found = page.evaluate("axe.run().then(result => result.violations.map(v => [v.id, v.nodes.map(n => n.html + ' ' + n.failureSummary)]))")
                        self.assertEqual(found, [], f"{theme}, {size['width']}, {view}")
                        self.assertLessEqual(page.evaluate("document.documentElement.scrollWidth"), size["width"])
                        page.context.close()


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v", *sys.argv[1:]])
