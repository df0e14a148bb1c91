#!/usr/bin/env python3
"""Real workers with messages that a proxy rewrites: a faulty worker is found and its cells are traced again, a worker of
another release is refused."""

import json
import pathlib
import sys
import unittest

import hosts
import impostors
from proxy import Proxy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "integration"))
from farm import SCENES, Farm, run, wait_for  # noqa: E402
from longer_jobs import JobOverTooEarly, LongerJobs, again_with_longer_jobs  # noqa: E402

SCENE = SCENES / "one-weekend-20.json"
SIZE = ("--width", "64", "--height", "48")
SETTINGS = (*SIZE, "--spp", "600")


class Impostors(LongerJobs, unittest.TestCase):
    """Each worker connects from its own address, so the coordinator sees different machines."""

    growth = 4  # jobs must not be over before a faulty worker's first result

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

    def start_all(self, farm, faulty_workers):
        """Starts two correct workers and the faulty ones, by name. Returns when all have joined."""
        for name, address in zip(("ann", "bob", *faulty_workers), self.addresses[1:]):
            self.start(farm, name, address, faulty_workers.get(name))
        wait_for(lambda: len(farm.workers()) == len(faulty_workers) + 2, "the workers")

    def expected(self, farm, settings):
        report = farm.directory / "expected.json"
        rendered = run("render", SCENE, *settings, "-q", "-o", farm.directory / "a.png", "--report", report)
        self.assertEqual(rendered.returncode, 0, rendered.stderr)
        return json.loads(report.read_text())["image_sha256"]

    def states(self, farm):
        return {worker["name"]: worker["state"] for worker in farm.workers()}

    def finish(self, farm, job, faulty_workers):
        """Returns the report of a job if a faulty worker took part in it."""
        report = farm.finish(job)
        if "quarantined" not in self.states(farm).values() and not any(faulty.merged for faulty in faulty_workers):
            raise JobOverTooEarly("the correct workers were done before a faulty one's first result")
        return report

    def check_one_faulty_worker(self, *settings):
        with self.farm("--spot-checks", 1) as farm:
            faulty = impostors.FaultyWorker(1, 1)
            self.start_all(farm, {"impostor": faulty})
            job = farm.submit(SCENE, *SIZE, *settings)
            report = self.finish(farm, job, [faulty])
            self.assertGreater(len(faulty.wrong), 0)
            self.assertEqual(report["image_sha256"], self.expected(farm, [*SIZE, *settings]))
            self.assertEqual(self.states(farm), {"impostor": "quarantined", "ann": "ready", "bob": "ready"})
            # If the results of the faulty worker were only checks, there is nothing to trace again.
            self.assertRegex(farm.job(job)["flag"], "'impostor'.* returned (wrong|different) bits")

    @again_with_longer_jobs
    def test_checks_find_a_faulty_worker_and_its_cells_are_traced_again(self):
        self.check_one_faulty_worker("--spp", 600 * self.longer)

    @again_with_longer_jobs
    def test_checks_find_a_faulty_worker_in_passes(self):
        self.check_one_faulty_worker("--target-error", 0.004 / self.longer**0.5)

    @again_with_longer_jobs
    def test_the_referee_finds_two_faulty_workers_that_agree_and_other_names_do_not_end_the_quarantine(self):
        settings = (*SIZE, "--spp", 600 * self.longer)
        with self.farm("--spot-checks", 1) as farm:
            faulty_workers = {"faulty 1": impostors.FaultyWorker(1, 1), "faulty 2": impostors.FaultyWorker(1, 1)}
            self.start_all(farm, faulty_workers)
            report = self.finish(farm, farm.submit(SCENE, *settings), faulty_workers.values())
            self.assertEqual(report["image_sha256"], self.expected(farm, settings))
            states = self.states(farm)
            self.assertEqual((states["ann"], states["bob"]), ("ready", "ready"))
            self.assertIn("quarantined", states.values())
            found = next(worker for worker in farm.workers() if worker["state"] == "quarantined")
            self.start(farm, "another name", found["machine"].split()[1])
            wait_for(lambda: self.states(farm).get("another name") == "quarantined", "the new name's quarantine")

    def test_workers_of_the_coordinators_user_on_its_machine_are_not_checked_by_default(self):
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
            # On a slow machine the referee has no time for all cells.
            self.assertEqual(report["flag"] == "", report["checked_share"] == 1, report["flag"])

    def test_a_worker_of_another_release_is_refused_with_a_message(self):
        with self.farm() as farm:
            worker = self.start(farm, "impostor", self.addresses[1], impostors.of_another_release)
            self.assertEqual(worker.wait(timeout=60), 1)
            self.assertIn("trace version 1000000, but this coordinator uses", worker.log.read_text())
            self.assertEqual(farm.workers(), [])


if __name__ == "__main__":
    hosts.enter()
    unittest.main()
