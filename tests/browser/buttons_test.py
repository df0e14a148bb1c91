#!/usr/bin/env python3
"""Every button for every user in every state: the page offers what the coordinator permits and nothing else, and what it
offers works. The rules are those of fake_rules.py, which rules_test.py compares with a real coordinator."""

import json
import re
import sys
import unittest

import fake_rules
from browser import BrowserTest, expect
from fake_farm import FakeFarm
from fake_jobs import QUEUED, RUNNING, SERIES
from fake_states import DOWNLOADS, FRAME, JOB_STATES, LABELS, WORKER, WORKER_STATES, StateFarm, set_worker, worker_labels
from presses import ACTING, answer, buttons, changes, errors, press, press_neutral, wait_for_buttons, wait_until

USERS = {"anybody": ("any", ""), "administrator": ("admin", "root"), "owner": ("client", "ann"), "another client": ("client", "ben")}
BULK = "#main .bulk button"
BULK_LABELS = {**LABELS, "priority": "Priority"}


class ButtonsTest(BrowserTest):
    def open_farm(self, farm, view="#/jobs"):
        page = self.open(farm.url, view, permissions=["clipboard-read", "clipboard-write"])
        expect(page.locator("#connection")).to_have_text("live")
        return page

    def visit(self, page, farm, view):
        """Loads the page again, so that it knows nothing of an earlier state."""
        page.goto("about:blank")
        page.goto(farm.url + view)
        expect(page.locator("#connection")).to_have_text("live")

    def fine(self, page, farm, where):
        self.assertEqual(errors(page), [], where)
        self.assertEqual(farm.refused, [], where)


class Jobs(ButtonsTest):
    def check_states(self, user):
        with StateFarm(USERS[user]) as farm:
            page = self.open_farm(farm)
            for state in JOB_STATES:
                with self.subTest(state=state):
                    self.check_state(page, farm, state, f"{state}, {user}")

    def look(self, page, farm, state, where):
        number = farm.become(state)
        self.visit(page, farm, f"#/jobs/{number}")
        wait_for_buttons(page, farm.labels_of(number), where)
        return number

    def check_state(self, page, farm, state, where):
        number = self.look(page, farm, state, where)
        press_neutral(page, farm, farm.labels_of(number), where)
        page.keyboard.press("Escape")
        self.fine(page, farm, where)
        self.assertEqual(page.url, f"{farm.url}#/jobs/{number}", where)
        for label, word in farm.labels_of(number).items():
            self.look(page, farm, state, where)
            if word in DOWNLOADS:
                self.download(page, farm, label, f"{label}: {where}")
            else:
                self.act(page, farm, number, label, word, f"{label}: {where}")

    def download(self, page, farm, label, where):
        with page.expect_download() as download:
            press(page, label)
        self.assertTrue(download.value.suggested_filename, where)
        self.fine(page, farm, where)

    def act(self, page, farm, number, label, word, where):
        before = len(changes(farm))
        if word == "priority":
            page.get_by_label("Priority, 0 to 100").fill("77")
        else:
            press(page, label)
            if answer(page, yes=False):
                self.assertEqual(len(changes(farm)), before, f"{where}: nothing was confirmed")
                press(page, label)
            self.assertEqual(answer(page, yes=True), word in ("cancel", "forget"), where)
        if word == "priority":
            press(page, label)
        wait_until(lambda: len(changes(farm)) > before, lambda: f"{where}: no request", page)
        self.shows_the_change(page, farm, number, word, where)
        self.assertEqual(len(changes(farm)), before + 1, where)
        self.fine(page, farm, where)

    def shows_the_change(self, page, farm, number, word, where):
        job = farm.jobs.get(number)
        if word == "forget":
            self.assertIsNone(job, where)
            series = next((one for one in farm.jobs.values() if one["id"] == SERIES), None)
            expect(page.locator("h1")).to_have_text(f"{SERIES}  {series['name']}" if FRAME <= number and series else "Jobs")
            return
        expect(page.locator(".bar-of-view .state")).to_have_text(job["state"])
        expect(page.locator("#notes")).to_contain_text(re.compile(r"\bis\b|\bare\b|has priority 77"))
        if word == "priority":
            self.assertEqual({one["priority"] for one in fake_rules.frames_of(farm.jobs, number) or [job] if fake_rules.unfinished(one)}, {77}, where)
        wait_for_buttons(page, farm.labels_of(number), "after " + where)

    def test_anybody_on_a_farm_without_keys(self):
        self.check_states("anybody")

    def test_an_administrator(self):
        self.check_states("administrator")

    def test_the_owner(self):
        self.check_states("owner")

    def test_another_client_reads_and_downloads_only(self):
        self.check_states("another client")

    def test_key_p_does_what_the_button_does_and_never_leads_to_a_refusal(self):
        for user in USERS.values():
            with StateFarm(user) as farm:
                page = self.open_farm(farm)
                for state in JOB_STATES:
                    number = self.look(page, farm, state, state)
                    labels, before = farm.labels_of(number), len(changes(farm))
                    page.keyboard.press("p")
                    expect(page.locator("#notes p").first).to_be_visible()
                    paused = farm.jobs[number]["state"] == "paused" or "Pause" not in labels and "Resume" in labels
                    self.assertEqual(len(changes(farm)) > before or paused, "Pause" in labels or "Resume" in labels or paused, state)
                    self.fine(page, farm, state)


class BeforeTheServerAnswers(ButtonsTest):
    def test_no_button_acts_before_the_server_has_said_who_the_user_is(self):
        with StateFarm(USERS["owner"]) as farm:
            farm.become("running for days")
            held = []
            page = self.open("about:blank", "")
            page.route("**/api/v1/server", lambda route: held.append(route))
            for state in ("running for days", "running series with stopped frames"):
                number = farm.become(state)
                page.goto("about:blank")
                page.goto(f"{farm.url}#/jobs/{number}")
                expect(page.locator(".bar-of-view .state")).to_have_text("running")
                downloads = [label for label, word in farm.labels_of(number).items() if word in DOWNLOADS]
                wait_for_buttons(page, downloads, state)
                page.keyboard.press("p")
                self.assertEqual(changes(farm), [])
                held.pop().continue_()
                wait_for_buttons(page, farm.labels_of(number), state)


class Bulk(ButtonsTest):
    def chosen(self, page, number):
        page.get_by_role("checkbox", name=f"Choose job {number}", exact=True).check()

    def words_of(self, farm, numbers):
        """{word: the jobs that it changes}. The list knows no frames, so it cannot resume a series with one paused frame."""
        words = {word: [number for number in numbers if word in farm.permitted(number)] for word in BULK_LABELS}
        return {word: found for word, found in words.items() if found}

    def test_one_chosen_job_in_each_state_gets_the_actions_that_it_permits(self):
        for name, user in USERS.items():
            with StateFarm(user) as farm:
                page = self.open_farm(farm)
                for state in JOB_STATES:
                    number = farm.become(state)
                    if "frame" in farm.jobs[number] or state == "running series with a paused frame":
                        continue
                    self.visit(page, farm, "#/jobs")
                    self.chosen(page, number)
                    wait_for_buttons(page, ["Clear", *(BULK_LABELS[word] for word in self.words_of(farm, [number]))], f"{state}, {name}", BULK)

    def test_each_action_on_all_jobs_asks_only_for_those_that_permit_it(self):
        for name, user in USERS.items():
            with StateFarm(user) as farm:
                page = self.open_farm(farm)
                for word, label in BULK_LABELS.items():
                    farm.become("running series with stopped frames")
                    listed = [job["id"] for job in farm.jobs.values() if "frame" not in job]
                    words = self.words_of(farm, listed)
                    self.visit(page, farm, "#/jobs")
                    expect(page.locator(".count")).to_have_text(re.compile(r"\d+ jobs"))
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
                for view in ("#/jobs", "#/jobs?state=failed&q=nothing", "#/workers", "#/farm", "#/submit", "#/jobs/99999"):
                    self.visit(page, farm, view)
                    expect(page.locator("h1")).to_be_visible()
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


class Frames(ButtonsTest):
    def test_an_unfinished_frame_is_loaded_again_although_no_event_tells_of_it(self):
        with StateFarm(USERS["owner"]) as farm:
            number = farm.become("running frame")
            page = self.open_farm(farm, f"#/jobs/{number}")
            wait_for_buttons(page, farm.labels_of(number), "a running frame")
            farm.jobs[number].update(state="failed", reason="the scene is damaged")
            expect(page.locator(".bar-of-view .state")).to_have_text("failed")
            wait_for_buttons(page, farm.labels_of(number), "a failed frame")

    def test_a_frame_that_fails_is_seen_in_its_series_although_no_event_tells_of_it(self):
        with StateFarm(USERS["owner"]) as farm:
            number = farm.become("running series")
            page = self.open_farm(farm, f"#/jobs/{number}")
            wait_for_buttons(page, farm.labels_of(number), "a running series")
            farm.jobs[FRAME + 1].update(state="failed", reason="the scene is damaged")
            expect(page.get_by_role("button", name="Requeue 1 failed frame")).to_be_visible()

    def test_frames_that_begin_in_another_tab_can_be_deleted_when_their_series_has_ended(self):
        with StateFarm(USERS["owner"]) as farm:
            number = farm.become("done frame of a running series")
            page = self.open_farm(farm, f"#/jobs/{number}")
            wait_for_buttons(page, farm.labels_of(number), "a running series")
            for frame in fake_rules.frames_of(farm.jobs, SERIES):
                frame.update(state="done", has_picture=True)
            fake_rules.sum_up(farm.jobs, farm.jobs[SERIES])
            self.assertIn("Delete", farm.labels_of(number))
            wait_for_buttons(page, farm.labels_of(number), "a done series")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v", *sys.argv[1:]])
