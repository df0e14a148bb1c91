#!/usr/bin/env python3
"""Every button of the lists, of a worker and of the other views for every user: the page offers what the coordinator permits
and nothing else, and what it offers works. The rules are those of fake_rules.py."""

import json
import re
import sys
import unittest

from browser import expect
from fake_farm import FakeFarm
from fake_states import JOB_STATES, LABELS, WORKER, WORKER_STATES, StateFarm, set_worker, worker_labels
from presses import USERS, ButtonsTest, answer, buttons, changes, errors, press, press_neutral, wait_for_buttons, wait_until

LOADED = {"#/jobs": ".rows .row", "#/jobs?state=failed&q=nothing": ".empty button", "#/workers": ".rows .row", "#/farm": ".farm-content",
          "#/submit": ".drop", "#/jobs/99999": ".empty a"}  # what each view shows when it is loaded
BULK = "#main .bulk button"
BULK_LABELS = {**LABELS, "priority": "Priority"}


class Bulk(ButtonsTest):
    def load(self, page, farm):
        self.visit(page, farm, "#/jobs")
        expect(page.locator(".count")).to_have_text(re.compile(r"\d+ jobs"))

    def choose(self, page, number):
        page.get_by_role("checkbox", name=f"Choose job {number}", exact=True).check()
        expect(page.locator(".bulk [role=status]")).to_have_text("1 chosen")

    def words_of(self, farm, numbers):
        """{word: the jobs that it changes}. The list knows no frames, so it cannot resume a series with one paused frame."""
        words = {word: [number for number in numbers if word in farm.permitted(number)] for word in BULK_LABELS}
        return {word: found for word, found in words.items() if found}

    def test_one_chosen_job_in_each_state_gets_the_actions_that_it_permits(self):
        for name, user in USERS.items():
            with StateFarm(user) as farm:
                page = self.open_farm(farm)
                for state in JOB_STATES:
                    number = self.enter(page, farm, state)
                    if "frame" in farm.jobs[number] or state == "running series with a paused frame":
                        continue
                    self.load(page, farm)
                    self.choose(page, number)
                    wait_for_buttons(page, ["Clear", *(BULK_LABELS[word] for word in self.words_of(farm, [number]))], f"{state}, {name}", BULK)

    def test_each_action_on_all_jobs_asks_only_for_those_that_permit_it(self):
        for name, user in USERS.items():
            with StateFarm(user) as farm:
                page = self.open_farm(farm)
                for word, label in BULK_LABELS.items():
                    self.enter(page, farm, "running series with stopped frames")
                    listed = [job["id"] for job in farm.jobs.values() if "frame" not in job]
                    words = self.words_of(farm, listed)
                    self.load(page, farm)
                    page.get_by_label("Choose all shown jobs").check()
                    shown = [each for each in buttons(page, BULK) if each.startswith(label)]
                    self.assertEqual(bool(shown), word in words, f"{label}, {name}")
                    if shown:
                        self.act(page, farm, shown[0], word, words[word], f"{label}, {name}")

    def act(self, page, farm, label, word, expected, where):
        press(page, label, BULK)
        answer(page, yes=True)
        expect(page.locator("#notes")).to_contain_text(re.compile("job"))
        asked = json.loads(farm.bodies[f"/api/v1/jobs/{word}"])["ids"]
        hidden = set(expected) - set(asked)  # quick looks are folded into their jobs
        self.assertTrue(all("preview_of" in farm.jobs.get(number, {"preview_of": 0}) for number in hidden), f"{where}: {hidden}")
        self.assertEqual(set(asked) - set(expected), set(), where)
        self.fine(page, farm, where)


class Workers(ButtonsTest):
    def test_every_state_offers_the_users_what_the_rules_permit_in_both_views(self):
        for name, user in USERS.items():
            with FakeFarm(jobs=9, workers=3, changes=0, role=user[0], user=user[1]) as farm:
                page = self.open_farm(farm)
                for state in WORKER_STATES:
                    for view in ("#/workers", f"#/workers/{WORKER}"):
                        self.check_worker(page, farm, state, view, f"{state}, {view}, {name}")

    def check_worker(self, page, farm, state, view, where):
        set_worker(farm, state)
        labels = worker_labels(farm)
        row = page.locator(".rows .row:not([hidden])").filter(has_text=WORKER) if view == "#/workers" else page.locator(".bar-of-view")
        for label, word in [*labels.items()] or [(None, None)]:
            for host in (False, True):
                set_worker(farm, state)
                self.visit(page, farm, view)
                expect(row.locator(".state")).to_have_text(farm.workers[WORKER]["state"])
                place = f"#main .row .act button[aria-label$=' {WORKER}']" if view == "#/workers" else "#main .bar-of-view .actions button"
                named = lambda text: f"{text} {WORKER}" if view == "#/workers" else text
                wait_for_buttons(page, map(named, labels), where, place)
                if label is None:
                    return
                before = len(changes(farm))
                press(page, named(label), place)
                answer(page, yes=False)
                self.assertEqual(len(changes(farm)), before, where)
                press(page, named(label), place)
                answer(page, yes=True, host=host)
                wait_until(lambda: len(changes(farm)) > before, lambda: f"{where}: no request", page)
                expect(row.locator(".state")).to_have_text(farm.workers[WORKER]["state"])
                wait_for_buttons(page, map(named, worker_labels(farm)), f"after {label}: {where}", place)
                self.assertNotEqual(farm.workers[WORKER]["state"], {"drain": "ready", "readmit": "drained"}[word], where)
                self.fine(page, farm, where)

    def test_a_machine_in_quarantine_without_a_worker_is_resumed_and_has_no_log(self):
        for name in ("anybody", "owner"):
            with FakeFarm(jobs=9, workers=3, changes=0, role=USERS[name][0], user=USERS[name][1]) as farm:
                set_worker(farm, "absent")
                page = self.open_farm(farm, f"#/workers/{WORKER}")
                expect(page.locator(".bar-of-view .state")).to_have_text("quarantined")
                expect(page.get_by_role("button", name="Refresh log")).to_have_count(0)
                expect(page.get_by_role("button", name="Resume")).to_have_count(0 if name == "owner" else 1)
                if name == "owner":
                    continue
                page.get_by_role("button", name="Resume").click()
                expect(page.get_by_role("dialog").get_by_role("checkbox")).to_have_count(0)
                answer(page, yes=True)
                expect(page.locator(".empty")).to_contain_text(f"Worker {WORKER} is not connected")
                expect(page.locator("#main .bar-of-view button:visible")).to_have_count(0)
                self.assertEqual((changes(farm), errors(page)), ([("POST", f"/api/v1/workers/{WORKER}/readmit")], []))

    def test_a_worker_that_has_left_offers_nothing(self):
        with FakeFarm(jobs=9, workers=3, changes=0) as farm:
            page = self.open_farm(farm, "#/workers/w1")
            expect(page.locator(".empty")).to_contain_text("It left the farm")
            self.assertEqual(buttons(page), [])

    def test_a_worker_of_a_drained_host_is_resumed_with_its_host(self):
        with FakeFarm(jobs=9, workers=3, changes=0) as farm:
            page = self.open_farm(farm, f"#/workers/{WORKER}")
            press(page, "Drain", "#main .bar-of-view button")
            answer(page, yes=True, host=True)
            expect(page.locator(".bar-of-view .state")).to_have_text("draining")
            press(page, "Resume", "#main .bar-of-view button")
            answer(page, yes=True)
            expect(page.get_by_role("dialog")).to_contain_text("Resume all workers of host rack0?")
            answer(page, yes=True)
            expect(page.locator(".bar-of-view .state")).to_have_text("ready")
            self.fine(page, farm, "a drained host")


class OtherViews(ButtonsTest):
    def test_the_buttons_of_the_lists_and_of_the_farm_change_nothing(self):
        for name, user in USERS.items():
            with StateFarm(user) as farm:
                page = self.open_farm(farm)
                for view, loaded in LOADED.items():
                    self.visit(page, farm, view)
                    expect(page.locator(loaded).filter(visible=True).first).to_be_visible()
                    press_neutral(page, farm, [label for label in buttons(page) if re.match("Drain|Resume", label)], f"{view}, {name}")
                    self.assertEqual((errors(page), changes(farm)), ([], []), f"{view}, {name}")
                for label in buttons(page, "header button"):
                    if not label.startswith("Sign out"):
                        press(page, label, "header button")
                        answer(page, yes=True)
                self.assertEqual(errors(page), [])

    def test_who_may_submit_gets_a_forecast_a_job_and_back_an_empty_form(self):
        scene = {"name": "small.json", "mimeType": "application/json", "buffer": json.dumps({"version": 1, "image": {"width": 60, "height": 30}, "spheres": []}).encode()}
        for name, user in USERS.items():
            with StateFarm(user) as farm:
                page = self.open_farm(farm, "#/submit")
                self.assertFalse({"Submit", "Forecast"} & set(buttons(page)), name)
                page.locator("#files").set_input_files([scene])
                page.get_by_role("button", name="Remove small.json").click()
                expect(page.get_by_role("button", name="Submit", exact=True)).to_be_disabled()
                page.locator("#files").set_input_files([scene])
                page.get_by_role("button", name="Forecast").click()
                expect(page.locator(".forecast")).to_contain_text("min")
                page.get_by_role("button", name="Submit", exact=True).click()
                expect(page.locator("h1")).to_contain_text(re.compile(r"^\d+ "))
                self.fine(page, farm, name)

    def test_who_is_not_signed_in_can_only_sign_in(self):
        with FakeFarm(jobs=30, token="secret", changes=0) as farm:
            for view in ("#/jobs", "#/jobs/29", "#/workers", "#/farm", "#/submit"):
                page = self.open(farm.url, view)
                expect(page.get_by_role("dialog")).to_be_visible()
                answer(page, yes=False)
                self.assertEqual(buttons(page), ["Sign in"], view)
                press(page, "Sign in", "#main button")
                expect(page.get_by_role("dialog")).to_be_visible()
                answer(page, yes=False)
                self.assertEqual(changes(farm), [], view)
                page.context.close()


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v", *sys.argv[1:]])
