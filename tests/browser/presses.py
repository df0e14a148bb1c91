"""Finds and presses the buttons of the page."""

import time

from browser import BrowserTest, PlaywrightError, expect

NODES = """place => [...document.querySelectorAll(place)].filter(node => node.checkVisibility({visibilityProperty: true}) && !node.disabled &&
  !node.closest('dialog, .row[hidden]'))"""
LABEL = "node => (node.getAttribute('aria-label') ?? node.textContent).trim()"
USERS = {"anybody": ("any", ""), "administrator": ("admin", "root"), "owner": ("client", "ann"), "another client": ("client", "ben")}
ACTING = "#main .actions button, #main form.inline button, #main .series-side > button, #main .long-run button"
NEUTRAL = "#main button, #main summary"
WITHIN = 20  # seconds, for a machine under load
ATTEMPTS = 5


def buttons(page, place="#main button"):
    """The labels of the buttons that are visible and can be pressed."""
    return page.evaluate(f"place => ({NODES})(place).map({LABEL})", place)


def wait_until(condition, what, page):
    """Waits until condition() is true; `what()` describes what was there instead."""
    end = time.monotonic() + WITHIN
    while not condition():
        if time.monotonic() > end:
            raise AssertionError(what())
        page.wait_for_timeout(50)


def wait_for_buttons(page, labels, where, place=ACTING):
    """Waits until exactly these buttons are offered."""
    wanted = sorted(labels)
    wait_until(lambda: sorted(buttons(page, place)) == wanted, lambda: f"{where}: the page offers {sorted(buttons(page, place))} instead of {wanted}", page)


def press(page, label, place=ACTING):
    """Presses the first button with this label. A view that is drawn again may replace the button meanwhile."""
    for attempt in range(ATTEMPTS):
        node = page.evaluate_handle(f"([place, label]) => ({NODES})(place).find(node => ({LABEL})(node) === label)", [place, label]).as_element()
        assert node, f"{label} is not offered: {buttons(page, place)}"
        try:
            return node.click()
        except PlaywrightError:
            if attempt == ATTEMPTS - 1 or node.evaluate("node => node.isConnected"):
                raise


def answer(page, yes, host=False):
    """Answers the question that a press has led to, if there is one. Returns whether there was one."""
    dialog = page.locator("dialog[open]")
    if not dialog.count():
        return False
    if host:
        dialog.get_by_role("checkbox").check()
    this = dialog.element_handle()
    dialog.locator(".answers button").nth(-1 if yes else 0).click()
    wait_until(lambda: not this.evaluate("node => node.isConnected"), lambda: "the question stays", page)
    return True


def errors(page):
    """The error messages that the page shows."""
    return page.evaluate("""() => [...document.querySelectorAll('#notes .error, [role=alert]')].filter(node => node.checkVisibility()).map(node => node.textContent)""")


def changes(farm):
    """The requests so far that ask for a change."""
    return [(method, path) for method, path in farm.asked if method != "GET"]


def press_neutral(page, farm, acting, where):
    """Presses every button that changes nothing of the farm, and asserts that it does not."""
    for label in dict.fromkeys(buttons(page, NEUTRAL)):
        if label in acting or label not in buttons(page, NEUTRAL):
            continue
        before = len(changes(farm))
        try:
            press(page, label, NEUTRAL)
        except (PlaywrightError, AssertionError):  # what is still being loaded may hide a button
            if label in buttons(page, NEUTRAL):
                raise
        answer(page, yes=False)
        assert len(changes(farm)) == before, f"{where}: {label} sends {changes(farm)[before:]}"
        assert errors(page) == [], f"{where}: {label} leads to {errors(page)}"


class ButtonsTest(BrowserTest):
    def open_farm(self, farm, view="#/jobs"):
        page = self.open(farm.url, view, permissions=["clipboard-read", "clipboard-write"])
        expect(page.locator("#connection")).to_have_text("live")
        return page

    def enter(self, page, farm, state):
        """Leaves the page, which must not ask about the state before, and changes the state. Returns the number of the job."""
        page.goto("about:blank")
        return farm.become(state)

    def visit(self, page, farm, view):
        """Loads the page, which knows nothing of an earlier state."""
        page.goto("about:blank")
        page.goto(farm.url + view)
        expect(page.locator("#connection")).to_have_text("live")

    def fine(self, page, farm, where):
        self.assertEqual(errors(page), [], where)
        self.assertEqual(farm.refused, [], where)
