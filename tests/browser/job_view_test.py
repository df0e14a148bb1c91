#!/usr/bin/env python3
"""The view of one job in each of its states: what it shows, what it offers, and to whom."""

import re
import sys
import unittest

from browser import DESKTOP, PHONE, BrowserTest, axe, expect
from fake_farm import FakeFarm
from fake_jobs import BOTH, CANCELLED, DONE, FAILED, LOOK, PAUSED, QUEUED, REPORT, RUNNING, SERIES, UNLIMITED, JobFarm


def fact(page, term):
    """The value of a fact: the element after its term."""
    return page.locator(".facts").first.locator(f"dt:text-is('{term}') + dd")


class Missing(BrowserTest):
    def test_a_job_that_does_not_exist_has_a_view_of_its_own_without_tools(self):
        with JobFarm() as farm:
            page = self.open(farm.url, f"#/jobs/{RUNNING}")
            expect(page.get_by_role("button", name="Pause")).to_be_visible()
            page.goto(farm.url + "#/jobs/99999")
            expect(page.locator(".empty")).to_contain_text("Job 99999 does not exist")
            expect(page.locator("h1")).to_have_text("Job 99999")
            expect(page.locator(".job button:visible")).to_have_count(0)
            expect(page.locator(".job .progress, .job .facts, .job .stage").first).to_be_hidden()
            expect(page.locator(".bar-of-view .state")).to_have_count(0)
            page.get_by_role("link", name="All jobs").last.click()
            expect(page.locator("h1")).to_have_text("Jobs")

    def test_a_job_that_is_loading_shows_nothing_of_the_one_before(self):
        with JobFarm() as farm:
            page = self.open(farm.url, f"#/jobs/{DONE}")
            expect(page.locator(".readout")).to_contain_text("240 × 160")
            page.route(f"**/jobs/{FAILED}*", lambda _: None)  # is never answered
            page.goto(farm.url + f"#/jobs/{FAILED}")
            expect(page.locator("h1")).to_have_text(f"Job {FAILED}")
            expect(page.locator(".readout")).to_have_text("")
            expect(page.locator(".now")).to_have_text("")
            expect(page.locator(".facts, .job .actions button:visible, .history li, .report, .trend circle")).to_have_count(0)

    def test_a_job_that_somebody_else_deletes_is_said_to_be_deleted(self):
        with JobFarm(streams=False) as farm:
            page = self.open(farm.url, f"#/jobs/{RUNNING}")
            expect(page.get_by_role("button", name="Pause")).to_be_visible()
            del farm.jobs[RUNNING]
            expect(page.locator(".empty")).to_contain_text(f"Job {RUNNING} was deleted")


class Stopped(BrowserTest):
    def test_cancelled_and_failed_jobs_keep_their_picture_and_progress(self):
        with JobFarm() as farm:
            for job, share in ((CANCELLED, "2"), (FAILED, "20")):
                page = self.open(farm.url, f"#/jobs/{job}")
                expect(page.locator(".readout")).to_contain_text("240 × 160")
                expect(page.get_by_role("progressbar")).to_have_attribute("aria-valuenow", share)
                expect(page.get_by_role("group", name="Download").get_by_role("button")).to_have_text(["PNG", "EXR", "Error map"])
                expect(page.locator(".stage .message")).to_be_hidden()
                page.context.close()

    def test_without_a_picture_no_download_is_offered_and_none_is_requested(self):
        with JobFarm() as farm:
            farm.jobs[CANCELLED].update(has_picture=False, progress=0.0)
            page = self.open(farm.url, f"#/jobs/{CANCELLED}")
            expect(page.locator(".stage .message")).to_contain_text("No picture")
            expect(page.get_by_role("group", name="Download").get_by_role("button")).to_have_count(0)
            self.assertFalse([path for _, path in farm.asked if "pixels" in path or "image" in path])

    def test_only_a_failure_is_red_and_no_word_is_said_twice(self):
        with JobFarm() as farm:
            page = self.open(farm.url, f"#/jobs/{CANCELLED}")
            expect(page.locator("p.notice").first).to_have_text("Cancelled by 'ann'")
            expect(page.locator(".job .trouble:visible")).to_have_count(0)
            expect(page.locator(".history li").last).to_contain_text("cancelled by 'ann'")
            expect(page.locator(".history")).not_to_contain_text("cancelled: cancelled")
            page.goto(farm.url + f"#/jobs/{FAILED}")
            expect(page.locator(".trouble")).to_contain_text("did not have enough memory")


class Facts(BrowserTest):
    def test_a_limit_that_nobody_set_is_not_shown(self):
        with JobFarm() as farm:
            farm.jobs[PAUSED].update(samples_per_pixel=16777216)  # an older server's
            del farm.jobs[PAUSED]["samples_taken"]
            page = self.open(farm.url, f"#/jobs/{UNLIMITED}")
            expect(fact(page, "Samples")).to_have_text("47 per pixel so far")
            page.goto(farm.url + f"#/jobs/{RUNNING}")
            expect(fact(page, "Samples")).to_have_text("200 of 500 per pixel")
            page.goto(farm.url + f"#/jobs/{PAUSED}")
            expect(fact(page, "Samples")).to_have_text("40 per pixel so far")

    def test_each_target_has_a_row_and_the_page_says_which_one_ended_the_job(self):
        with JobFarm() as farm:
            page = self.open(farm.url, f"#/jobs/{BOTH}")
            expect(fact(page, "RMSE target")).to_have_text("0.00979 (target 0.01, reached)")
            expect(fact(page, "Half-width target")).to_have_text("0.0369 (target 0.01)")
            expect(fact(page, "Ended by")).to_have_text("the RMSE reached its target")

    def test_times_are_shown_with_the_exact_moment_in_their_title(self):
        with JobFarm() as farm:
            page = self.open(farm.url, f"#/jobs/{DONE}")
            for term in ("Submitted", "Started", "Finished"):
                expect(fact(page, term)).to_have_text(re.compile(r"^\d min ago$"))
                expect(fact(page, term).locator("time")).to_have_attribute("title", re.compile(r"\d\d:\d\d"))
            expect(page.locator(".now")).to_have_text("Took 49 s on 2 workers")

    def test_missing_fields_of_an_older_server_are_not_shown(self):
        with JobFarm() as farm:
            for job in (RUNNING, DONE, QUEUED, SERIES):
                for name in ("submitted", "started", "finished", "seconds_taken", "samples_taken", "has_picture", "denoise", "waits_for_job",
                             "queue_place", "starts_in", "ended_by"):
                    farm.jobs[job].pop(name, None)
                page = self.open(farm.url, f"#/jobs/{job}")
                expect(page.locator(".now, .waits").filter(visible=True).first).to_be_visible()
                expect(page.locator(".job")).not_to_contain_text(re.compile("undefined|null|NaN|Submitted"))
                page.context.close()

    def test_a_waiting_job_names_the_job_in_front_its_place_and_when_it_begins(self):
        with JobFarm() as farm:
            page = self.open(farm.url, f"#/jobs/{QUEUED}")
            expect(page.locator(".waits")).to_have_text("Waits for job 2 of priority 50, place 3 in the queue, begins in about 4 min")
            page.locator(".waits a").click()
            expect(page.locator("h1")).to_have_text("2  capsid.json")

    def test_a_job_whose_forecast_is_days_says_so_and_can_be_cancelled_there(self):
        with JobFarm() as farm:
            page = self.open(farm.url, f"#/jobs/{UNLIMITED}")
            expect(page.locator(".long-run")).to_contain_text("Needs about 121 days of all 16 present threads")
            page.get_by_role("button", name="Cancel job").click()
            page.get_by_role("dialog").get_by_role("button", name="Cancel job").click()
            expect(page.locator(".bar-of-view .state")).to_have_text("cancelled")
            expect(page.locator(".long-run")).to_be_hidden()

    def test_the_curve_of_the_error_survives_a_reload_and_grows(self):
        with JobFarm() as farm:
            page = self.open(farm.url, f"#/jobs/{UNLIMITED}")
            for _ in range(2):
                expect(page.locator(".trend circle")).to_have_count(8)
                expect(page.locator(".trend path.target")).to_have_count(1)
                expect(page.locator(".trend")).to_have_attribute("aria-label", re.compile(r"in 49\ss, target 0.01"))
                page.reload()
            expect(page.locator("#connection")).to_have_text("live")
            farm.jobs[UNLIMITED].update(seconds_taken=60.0, error={**farm.jobs[UNLIMITED]["error"], "rmse": 0.011})
            farm.changes = 100
            expect(page.locator(".trend circle")).to_have_count(9)

    def test_quick_look_and_job_name_each_other_in_any_tab(self):
        with JobFarm() as farm:
            page = self.open(farm.url, f"#/jobs/{RUNNING}")
            expect(fact(page, "Denoising")).to_have_text("denoised when written")
            fact(page, "Quick look").get_by_role("link").click()
            expect(page.locator("h1")).to_contain_text(f"{LOOK}  capsid.json (quick look)")
            expect(fact(page, "Quick look of").get_by_role("link")).to_have_attribute("href", f"#/jobs/{RUNNING}")


class Report(BrowserTest):
    def test_the_report_is_closed_grouped_and_without_zeros_and_copies_the_hash(self):
        with JobFarm() as farm:
            page = self.open(farm.url, f"#/jobs/{DONE}", permissions=["clipboard-read", "clipboard-write"])
            report = page.locator("details.report")
            expect(report).not_to_have_attribute("open", "")
            report.locator("summary").click()
            expect(report.locator("h2")).to_have_text(["Picture", "Error", "Time", "Bits"])
            for nothing in ("target_error", "duplicates_removed", "time_limit", "seconds.deciding", "flag"):
                expect(report.locator(f"dt:text-is('{nothing}')")).to_have_count(0)
            report.get_by_role("button", name="Copy").first.click()
            self.assertEqual(page.evaluate("navigator.clipboard.readText()"), REPORT["image_sha256"])

    def test_the_command_that_renders_the_same_bits_is_copied_with_its_file_quoted(self):
        with JobFarm() as farm:
            farm.jobs[DONE]["name"] = "it's.json"
            page = self.open(farm.url, f"#/jobs/{DONE}", permissions=["clipboard-read", "clipboard-write"])
            page.get_by_text("Render it again").click()
            page.locator(".recipe").get_by_role("button").click()
            self.assertEqual(page.evaluate("navigator.clipboard.readText()"), r"parray render --like 'it'\''s-4.png' SCENE -o again.png")


class Stage(BrowserTest):
    def test_a_map_is_disabled_with_the_reason_until_the_job_has_it(self):
        with JobFarm() as farm:
            del farm.jobs[RUNNING]["error"]
            page = self.open(farm.url, f"#/jobs/{QUEUED}")
            disabled = page.get_by_label("Layer").locator("option:disabled")
            expect(disabled).to_have_text(["Error (not known yet)", "Cost (no samples yet)", "Workers (no samples yet)"])
            page.goto(farm.url + f"#/jobs/{RUNNING}")
            expect(disabled).to_have_text(["Error (not known yet)"])
            page.locator(".stage").focus()
            page.keyboard.press("m")
            expect(page.get_by_label("Layer")).to_have_value("cost")
            page.goto(farm.url + f"#/jobs/{UNLIMITED}")
            expect(page.locator(".readout")).to_contain_text("240 × 160")
            expect(disabled).to_have_count(0)
            page.locator(".stage").focus()
            page.keyboard.press("m")
            page.keyboard.press("ArrowUp")
            expect(page.locator(".readout")).to_contain_text("±")

    def test_a_message_lies_on_a_plate(self):
        with JobFarm() as farm:
            page = self.open(farm.url, f"#/jobs/{QUEUED}")
            expect(page.locator(".stage .message")).to_be_visible()
            self.assertNotIn("rgba(0, 0, 0, 0)", page.locator(".stage .message").evaluate("node => getComputedStyle(node).backgroundColor"))

    def test_exposure_is_that_of_one_job_and_is_reset_by_a_button_or_a_double_click(self):
        with JobFarm() as farm:
            page = self.open(farm.url, f"#/jobs/{DONE}")
            exposure, stops = page.get_by_label("Exposure, stops"), page.locator(".stops")
            expect(stops).to_be_disabled()
            exposure.fill("5")
            expect(stops).to_contain_text("+5 EV")
            stops.click()
            expect(exposure).to_have_value("0")
            exposure.fill("5")
            exposure.dblclick()
            expect(exposure).to_have_value("0")
            exposure.fill("5")
            page.goto(farm.url + f"#/jobs/{BOTH}")
            expect(exposure).to_have_value("0")
            expect(stops).to_have_text("0 EV")

    def test_maps_leave_the_stage_its_size_and_no_value_of_another_map(self):
        with JobFarm() as farm:
            page = self.open(farm.url, f"#/jobs/{DONE}")
            expect(page.locator(".readout")).to_contain_text("240 × 160")
            tall = page.locator(".stage").bounding_box()["height"]
            page.locator(".stage").focus()
            page.keyboard.press("ArrowUp")
            page.get_by_label("Layer").select_option("workers")
            expect(page.locator(".legend .names")).to_contain_text("birch")
            expect(page.locator(".readout")).to_contain_text(re.compile("oak|birch"))
            self.assertEqual(page.locator(".stage").bounding_box()["height"], tall)
            page.get_by_label("Layer").select_option("picture")
            expect(page.locator(".readout")).not_to_contain_text(re.compile("oak|birch"))


class Steering(BrowserTest):
    def test_pause_resume_priority_cancel_requeue_and_forget(self):
        with FakeFarm(jobs=99, changes=0) as farm:
            page = self.open(farm.url, "#/jobs/99")
            state = page.locator(".bar-of-view .state")
            for word, there in (("Pause", "paused"), ("Resume", "running")):
                page.get_by_role("button", name=word).click()
                expect(state).to_have_text(there)
            page.get_by_label("Priority, 0 to 100").fill("77")
            page.get_by_role("button", name="Set").click()
            expect(page.locator("#notes")).to_contain_text("has priority 77")
            self.assertEqual(farm.jobs[99]["priority"], 77)
            page.get_by_role("button", name="Cancel").click()
            expect(page.get_by_role("button", name="Keep job")).to_be_focused()
            page.keyboard.press("Escape")
            self.assertEqual(farm.jobs[99]["state"], "running")
            page.get_by_role("button", name="Cancel").click()
            page.get_by_role("button", name="Cancel job").click()
            expect(state).to_have_text("cancelled")
            page.get_by_role("button", name="Requeue").click()
            expect(state).to_have_text("queued")
            farm.jobs[99]["state"] = "done"
            page.reload()
            page.get_by_role("button", name="Delete").click()
            page.get_by_role("button", name="Delete job").click()
            expect(page.locator("h1")).to_have_text("Jobs")
            self.assertNotIn(99, farm.jobs)

    def test_a_refusal_is_said_in_the_servers_words(self):
        with FakeFarm(jobs=99, changes=0) as farm:
            page = self.open(farm.url, "#/jobs/99")
            farm.refusal = (403, "job 99 is ben's: only ben and administrators steer it")
            page.get_by_role("button", name="Pause").click()
            expect(page.get_by_role("alert")).to_contain_text("only ben and administrators steer it")


class Users(BrowserTest):
    def test_the_jobs_of_others_have_no_buttons_for_a_client(self):
        with JobFarm(user="bob", role="client") as farm:
            farm.jobs[PAUSED]["user"] = "bob"
            page = self.open(farm.url, f"#/jobs/{RUNNING}")
            expect(fact(page, "Priority")).to_have_text("50")
            expect(page.get_by_role("button", name=re.compile("Pause|Cancel|Set"))).to_have_count(0)
            page.keyboard.press("p")
            expect(page.locator("#notes")).to_contain_text("belongs to ann")
            page.goto(farm.url + f"#/jobs/{PAUSED}")
            expect(page.get_by_role("button", name="Resume")).to_be_visible()
            self.assertFalse([path for method, path in farm.asked if method != "GET"])

    def test_key_p_says_why_it_does_nothing_on_a_done_job(self):
        with JobFarm() as farm:
            page = self.open(farm.url, f"#/jobs/{DONE}")
            expect(page.locator(".bar-of-view .state")).to_have_text("done")
            page.keyboard.press("p")
            expect(page.locator("#notes")).to_contain_text(f"Job {DONE} is done, so it cannot be paused")


class Everybody(BrowserTest):
    def test_axe_finds_no_violation_and_nothing_is_wider_than_a_phone_in_any_state(self):
        source = axe()
        with JobFarm() as farm:
            for theme, size in (("light", DESKTOP), ("dark", DESKTOP), ("light", PHONE)):
                page = self.open(farm.url, color_scheme=theme, viewport=size)
                expect(page.locator("#connection")).to_have_text("live")
                for job in (QUEUED, RUNNING, PAUSED, DONE, FAILED, CANCELLED, UNLIMITED, BOTH, 99999):
                    page.goto(farm.url + f"#/jobs/{job}")
                    expect(page.locator(".state, .empty").filter(visible=True).first).to_be_visible()
                    page.wait_for_timeout(300)
                    page.evaluate("for (const each of document.querySelectorAll('details')) each.open = true")
                    page.evaluate(source)
                    found = page.evaluate("axe.run().then(result => result.violations.map(v => [v.id, v.nodes.map(n => n.html + ' ' + n.failureSummary)]))")
                    self.assertEqual(found, [], f"{theme}, {size['width']}, {job}")
                    self.assertLessEqual(page.evaluate("document.documentElement.scrollWidth"), size["width"])
                page.context.close()


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v", *sys.argv[1:]])
