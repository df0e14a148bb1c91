#!/usr/bin/env python3
"""Real workers whose messages a proxy rewrites: a liar is found and its cells are mended, a worker of another
release is refused."""

import json
import pathlib
import sys
import unittest

import hosts
import impostors
from proxy import Proxy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "integration"))
from farm import SCENES, Farm, run, wait_for  # noqa: E402

SCENE = SCENES / "one-weekend-20.json"
SETTINGS = ("--width", "64", "--height", "48", "--spp", "600")


class Impostors(unittest.TestCase):
    """Each worker connects from an address of its own: to the coordinator they are different machines."""

    @classmethod
    def setUpClass(cls):
        if not hosts.permitted():
            raise unittest.SkipTest("network namespaces are not permitted")
        cls.addresses = hosts.local_addresses(11)

    def farm(self, *options):
        return Farm("--insecure", *options, bind=f"tcp://{self.addresses[0]}:*")

    def start(self, farm, name, address, rewrite=None):
        target = (self.addresses[0], int(farm.address.rsplit(":", 1)[1]))
        proxy = self.enterContext(Proxy(target, 1, rewrite, source=address))
        return farm._start("parray-worker", "--connect", proxy.address, "--threads", 1, "--name", name)

    def start_all(self, farm, liars):
        """Workers by name; those in `liars` lie. All are there when it returns."""
        for name, address in zip(("ann", "bob", *liars), self.addresses[1:]):
            self.start(farm, name, address, liars.get(name))
        wait_for(lambda: len(farm.workers()) == len(liars) + 2, "the workers")

    def expected(self, farm, settings):
        report = farm.directory / "expected.json"
        rendered = run("render", SCENE, *settings, "-q", "-o", farm.directory / "a.png", "--report", report)
        self.assertEqual(rendered.returncode, 0, rendered.stderr)
        return json.loads(report.read_text())["image_sha256"]

    def states(self, farm):
        return {worker["name"]: worker["state"] for worker in farm.workers()}

    def test_a_liar_is_found_by_checks_and_what_it_has_traced_is_traced_again(self):
        for settings in (SETTINGS, ("--width", "64", "--height", "48", "--target-error", "0.004")):
            with self.subTest(settings), self.farm("--spot-checks", 1) as farm:
                liar = impostors.Liar(1, 1)
                self.start_all(farm, {"impostor": liar})
                job = farm.submit(SCENE, *settings)
                report = farm.finish(job)
                self.assertGreater(len(liar.lies), 0)
                self.assertEqual(report["image_sha256"], self.expected(farm, settings))
                self.assertEqual(self.states(farm), {"impostor": "quarantined", "ann": "ready", "bob": "ready"})
                # Of a liar whose results were only second opinions there is nothing to trace again.
                self.assertRegex(farm.job(job)["flag"], "'impostor'.* returned (wrong|different) bits")

    def test_two_liars_that_agree_are_found_by_the_referee_and_stay_in_quarantine_under_other_names(self):
        with self.farm("--spot-checks", 1) as farm:
            self.start_all(farm, {"liar 1": impostors.Liar(1, 1), "liar 2": impostors.Liar(1, 1)})
            report = farm.finish(farm.submit(SCENE, *SETTINGS))
            self.assertEqual(report["image_sha256"], self.expected(farm, SETTINGS))
            states = self.states(farm)
            self.assertEqual((states["ann"], states["bob"]), ("ready", "ready"))
            self.assertIn("quarantined", states.values())
            found = next(worker for worker in farm.workers() if worker["state"] == "quarantined")
            self.start(farm, "somebody else", found["machine"].split()[1])
            wait_for(lambda: self.states(farm).get("somebody else") == "quarantined", "the new name's quarantine")

    def test_nobody_is_checked_on_the_coordinators_machine_under_its_user_unless_asked(self):
        with Farm() as farm:
            for name in ("ann", "bob"):
                farm.start_worker(name)
            wait_for(lambda: len(farm.workers()) == 2, "two workers")
            self.assertEqual(farm.finish(farm.submit(SCENE, *SETTINGS))["checked_share"], 0)

    def test_the_referee_checks_the_only_machine_of_a_farm(self):
        with self.farm("--spot-checks", 1) as farm:
            self.start(farm, "ann", self.addresses[1])
            report = farm.finish(farm.submit(SCENE, *SETTINGS))
            self.assertGreater(report["checked_share"], 0)
            self.assertEqual(report["flag"], "")

    def test_a_worker_of_another_release_is_refused_with_a_word(self):
        with self.farm() as farm:
            worker = self.start(farm, "impostor", self.addresses[1], impostors.of_another_release)
            self.assertEqual(worker.wait(timeout=30), 1)
            self.assertIn("trace version 1000000, but this coordinator uses", worker.log.read_text())
            self.assertEqual(farm.workers(), [])


if __name__ == "__main__":
    hosts.enter()
    unittest.main()
