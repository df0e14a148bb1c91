#!/usr/bin/env python3
"""Every button of a job for every user in every state: the page offers what the coordinator permits and nothing else, and what it
offers works. The rules are those of fake_rules.py, which rules_test.py compares with a real coordinator."""

import re
import sys
import unittest

import fake_rules
from browser import expect
from fake_jobs import SERIES
from fake_states import DOWNLOADS, FRAME, JOB_STATES, StateFarm
from presses import USERS, ButtonsTest, answer, changes, press, press_neutral, wait_for_buttons, wait_until


class Jobs(ButtonsTest):
    def check_states(self, user):
        with StateFarm(USERS[user]) as farm:
            page = self.open_farm(farm)
            for state in JOB_STATES:
                with self.subTest(state=state):
                    self.check_state(page, farm, state, f"{state}, {user}")

    def look(self, page, farm, state, where):
        number = self.enter(page, farm, state)
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
                    word = "Resume" if farm.jobs[number]["state"] == "paused" else "Pause"
                    page.keyboard.press("p")
                    expect(page.locator("#notes p").first).to_be_visible()
                    self.assertEqual(len(changes(farm)) > before, word in labels, state)
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
