#!/usr/bin/env python3
"""The page around the views: signing in and out, a farm without workers, notifications, help."""

import sys
import unittest

from browser import DESKTOP, PHONE, BrowserTest, axe, expect, violations
from fake_farm import FakeFarm

TOKEN_PLACES = "[sessionStorage.getItem('parray-token'), localStorage.getItem('parray-token')]"
NOTIFICATIONS = """window.shown = [];
window.Notification = class extends EventTarget {
  static permission = 'default';
  static async requestPermission() { return Notification.permission = 'granted'; }
  constructor(title) { super(); shown.push(title); }
};"""


class SignIn(BrowserTest):
    def sign_in(self, page, value, keep=False):
        dialog = page.get_by_role("dialog")
        page.get_by_label("Token", exact=True).last.fill(value)
        dialog.get_by_label("Keep the token on this machine").set_checked(keep)
        dialog.get_by_role("button", name="Sign in").click()

    def test_a_token_is_asked_for_and_kept_for_the_tab_only(self):
        with FakeFarm(jobs=30, token="secret") as farm:
            page = self.open(farm.url)
            expect(page.get_by_role("dialog")).to_contain_text("parray keygen DIR --token NAME")
            self.sign_in(page, "wrong")
            expect(page.get_by_role("dialog").locator(".trouble")).to_be_visible()
            self.sign_in(page, "secret")
            expect(page.locator(".count")).to_have_text("30 jobs")
            self.assertEqual(page.evaluate(TOKEN_PLACES), ["secret", None])
            self.assertNotIn("secret", page.evaluate("document.cookie + location"))

    def test_signing_out_shows_nothing_of_the_farm(self):
        with FakeFarm(jobs=30, token="secret", changes=0) as farm:
            page = self.open(farm.url, "#/jobs/29")
            self.sign_in(page, "secret")
            expect(page.locator("h1")).to_contain_text(farm.jobs[29]["name"])
            page.get_by_role("button", name="Sign out ann").click()
            expect(page.get_by_role("dialog")).to_be_visible()
            page.get_by_role("dialog").get_by_role("button", name="Cancel").click()
            expect(page.locator("h1")).to_have_text("You are not signed in")
            page.goto(farm.url + "#/jobs")
            expect(page.locator("h1")).to_have_text("You are not signed in")
            text = page.content()
            for word in ("capsid", "helix", "glass", "chi", "node0001", "Sign out"):
                self.assertNotIn(f">{word}<", text)
            self.assertEqual(page.evaluate(TOKEN_PLACES), [None, None])

    def test_a_token_that_the_server_no_longer_accepts_empties_the_page(self):
        with FakeFarm(jobs=30, token="secret", changes=0) as farm:
            page = self.open(farm.url)
            self.sign_in(page, "secret")
            expect(page.locator(".count")).to_have_text("30 jobs")
            farm.stop()
            farm.token = "another"
            farm.start()
            expect(page.locator("h1")).to_have_text("You are not signed in")
            self.assertEqual(page.locator(".row").count(), 0)
            expect(page.locator("#summary")).to_have_text("")

    def test_a_kept_token_signs_in_other_tabs_and_is_forgotten_in_all(self):
        with FakeFarm(jobs=30, token="secret", changes=0) as farm:
            page = self.open(farm.url)
            self.sign_in(page, "secret", keep=True)
            expect(page.locator(".count")).to_have_text("30 jobs")
            self.assertEqual(page.evaluate(TOKEN_PLACES), [None, "secret"])
            other = page.context.new_page()
            other.goto(farm.url)
            expect(other.locator(".count")).to_have_text("30 jobs")
            other.get_by_role("button", name="Sign out ann").click()
            expect(page.get_by_role("dialog")).to_be_visible()
            self.assertEqual(page.evaluate(TOKEN_PLACES), [None, None])


class Around(BrowserTest):
    def test_a_farm_without_workers_says_so_across_the_page(self):
        with FakeFarm(jobs=10, workers=0, changes=0) as farm:
            page = self.open(farm.url)
            banner = page.locator("#banner")
            expect(banner).to_contain_text("No workers are connected")
            banner.get_by_role("link").click()
            expect(page.locator("h1")).to_have_text("Workers")
            expect(banner).to_be_hidden()

    def test_a_farm_with_workers_has_no_banner(self):
        with FakeFarm(jobs=10, workers=2, changes=0) as farm:
            page = self.open(farm.url)
            expect(page.locator("#summary")).to_contain_text("2 workers")
            page.wait_for_timeout(3000)
            expect(page.locator("#banner")).to_be_hidden()

    def test_help_has_a_glossary_and_leads_to_the_interface(self):
        with FakeFarm(jobs=3) as farm:
            page = self.open(farm.url)
            page.keyboard.press("?")
            dialog = page.get_by_role("dialog")
            dialog.get_by_text("Glossary").click()
            expect(dialog).to_contain_text("half-width")
            expect(dialog.get_by_role("link", name="HTTP interface")).to_have_attribute("href", "api")

    def wait_until(self, page, condition):
        """Not wait_for_function, which the page's policy about scripts forbids."""
        page.evaluate(f"async () => {{ while (!({condition})) await new Promise(requestAnimationFrame); }}")

    def test_notifications_come_only_after_the_user_has_switched_them_on(self):
        with FakeFarm(jobs=9, changes=0, user="ann") as farm:
            for number in (9, 8, 7):
                farm.jobs[number].update(state="running", user="ben" if number == 8 else "ann", name=f"scene {number}")
            page = self.open("about:blank", "")
            page.add_init_script(NOTIFICATIONS)
            page.goto(farm.url)
            end = lambda number: page.request.post(f"{farm.url}api/v1/jobs/{number}/cancel")  # the stream reports it
            expect(page.locator(".count")).to_have_text("9 jobs")
            end(7)
            expect(page.locator(".rows .state.cancelled").first).to_be_visible()
            self.assertEqual(page.evaluate("shown"), [])
            page.keyboard.press("?")
            page.get_by_label("Notify me when my jobs have ended").check()
            self.wait_until(page, "localStorage.getItem('parray-notices') === 'on'")  # the browser answers later
            page.keyboard.press("Escape")
            end(8)  # of another user
            end(9)
            self.wait_until(page, "shown.length > 0")
            self.assertEqual(page.evaluate("shown"), ["scene 9: cancelled"])


class Accessible(BrowserTest):
    def test_axe_finds_no_violation_without_a_token_and_with_chosen_jobs(self):
        source = axe()
        with FakeFarm(jobs=40, workers=0, changes=0) as farm:
            for theme in ("light", "dark"):
                for size in (DESKTOP, PHONE):
                    farm.token = "secret"
                    page = self.open(farm.url, color_scheme=theme, viewport=size)
                    where = f"{theme}, {size['width']}"
                    expect(page.get_by_role("dialog")).to_be_visible()
                    self.assertEqual(violations(page, source), [], where)
                    page.keyboard.press("Escape")
                    self.assertEqual(violations(page, source), [], where)
                    farm.token = None
                    page.reload()
                    expect(page.locator("#banner")).to_be_visible()
                    page.get_by_label("Choose all shown jobs").check(force=True) if size is DESKTOP else \
                        page.locator(".rows input").first.check()
                    expect(page.locator(".bulk")).to_be_visible()
                    self.assertEqual(page.evaluate("document.documentElement.scrollWidth"), size["width"])
                    self.assertEqual(violations(page, source), [], where)
                    page.get_by_role("button", name="Delete").click()
                    self.assertEqual(violations(page, source), [], where)
                    page.context.close()


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v", *sys.argv[1:]])
