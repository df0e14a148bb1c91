"""Chromium for tests of the web page. Ends the program with 77, ctest's word for skipped, where there
is no Playwright (PyPI; PYTHONPATH may name where it is) or no chromium."""

import os
import pathlib
import re
import shutil
import sys
import unittest

try:
    from playwright.sync_api import Error as PlaywrightError, expect, sync_playwright
except ImportError:
    print("skipped: no Playwright for this Python: pip install playwright in a venv, and name its site-packages in PYTHONPATH")
    sys.exit(77)

CHROMIUM = shutil.which("chromium")
if not CHROMIUM:
    print("skipped: there is no chromium: apt install chromium")
    sys.exit(77)
expect.set_options(timeout=30000)  # a machine under load
DESKTOP = {"width": 1360, "height": 820}
PHONE = {"width": 360, "height": 740}


class BrowserTest(unittest.TestCase):
    """open() gives a page; whatever the page complains of fails the test, the server's policy about
    scripts and styles included."""

    @classmethod
    def setUpClass(cls):
        cls.playwright = sync_playwright().start()
        cls.chromium = cls.playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])

    @classmethod
    def tearDownClass(cls):
        cls.chromium.close()
        cls.playwright.stop()

    def setUp(self):
        self.complaints = []

    def open(self, url, view="#/jobs", **options):
        context = self.chromium.new_context(**{"viewport": DESKTOP, "accept_downloads": True, **options})
        self.addCleanup(context.close)
        page = context.new_page()
        page.on("pageerror", lambda error: self.complaints.append(str(error)))
        page.on("console", lambda message: self.note(message))
        page.goto(url + view)
        return page

    def note(self, message):
        refused = re.search(r"the server responded with a status of|net::ERR", message.text)  # the browser's own words
        if message.type == "error" and not refused:
            self.complaints.append(message.text)

    def tearDown(self):
        self.assertEqual(self.complaints, [])


def axe():
    """The source of axe-core (npm), named by PARRAY_AXE."""
    place = os.environ.get("PARRAY_AXE")
    if not place:
        raise unittest.SkipTest("PARRAY_AXE names no axe.min.js")
    return pathlib.Path(place).read_text()


def violations(page, source):
    """What axe-core (`source`) finds on the page: [(rule, elements)]."""
    page.wait_for_timeout(300)
    page.evaluate(source)
    return page.evaluate("axe.run().then(result => result.violations.map(v => [v.id, v.nodes.map(n => n.html + ' ' + n.failureSummary)]))")
