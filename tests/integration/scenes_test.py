#!/usr/bin/env python3
"""Scenes reach workers, with real processes: once from the coordinator, then from worker to worker on the machine,
whatever dies meanwhile."""

import json
import pathlib
import random
import re
import signal
import tempfile
import unittest

from farm import Farm, run, wait_for
from longer_jobs import JobOverTooEarly, LongerJobs, again_with_longer_jobs


def bytes_of(worker):
    """From the coordinator, from workers, handed on: what a worker that was stopped has said."""
    worker.send_signal(signal.SIGTERM)
    worker.wait(60)
    found = re.search(r"bytes of scenes: (\d+) from the coordinator, (\d+) from workers, (\d+) handed on",
                      worker.log.read_text())
    return [int(group) for group in found.groups()]


class Spread(LongerJobs, unittest.TestCase):
    growth = 4

    @classmethod
    def setUpClass(cls):
        dice = random.Random(1)
        cls.directory = tempfile.TemporaryDirectory()
        cls.scene = pathlib.Path(cls.directory.name) / "dust.csv"
        rows = (f"{dice.uniform(-9, 9)},{dice.uniform(-9, 9)},{dice.uniform(-9, 9)},0.05" for _ in range(60000))
        cls.scene.write_text("x,y,z,radius\n" + "\n".join(rows) + "\n")
        super().setUpClass()

    @classmethod
    def take_jobs(cls):
        cls.job = [cls.scene, "--width", "64", "--height", "48", "--spp", str(16 * cls.longer), "--schedule", "static"]
        picture = pathlib.Path(cls.directory.name) / "a.png"
        report = pathlib.Path(cls.directory.name) / "a.json"
        result = run("render", "-o", picture, "--report", report, *cls.job)
        assert result.returncode == 0, result.stderr
        cls.expected = json.loads(report.read_text())["image_sha256"]

    @classmethod
    def tearDownClass(cls):
        cls.directory.cleanup()

    def workers(self, farm, count, *options):
        workers = [farm._start("parray-worker", "--connect", farm.address, "--threads", 1, "--name", f"w{i}",
                               *options) for i in range(count)]
        wait_for(lambda: len(farm.workers()) == count, "the workers")
        return workers

    def sent_bytes(self, farm):
        found = wait_for(lambda: re.search(r"(\d+) workers requested scene \w+; the coordinator sent (\d+) bytes",
                                           farm.coordinator_log()),
                         "the scene to be forgotten")
        return int(found.group(1)), int(found.group(2))

    def check_all_took_part(self, said):
        """What each worker has said of its bytes; one that did not run meanwhile had its work done by others."""
        if any(s[0] + s[1] == 0 for s in said):
            raise JobOverTooEarly(f"a worker had no time to request the scene: {said}")

    def check_unfinished(self, farm, job):
        if farm.job(job)["state"] in ("finishing", "done"):
            raise JobOverTooEarly(f"job {job} is over")

    @again_with_longer_jobs
    def test_workers_of_a_machine_get_one_copy_from_the_coordinator(self):
        with Farm() as farm:
            workers = self.workers(farm, 5)
            report = farm.finish(farm.submit(*self.job))
            self.assertEqual(report["image_sha256"], self.expected)
            count, sent = self.sent_bytes(farm)
            said = [bytes_of(worker) for worker in workers]
            self.check_all_took_part(said)
            self.assertEqual(count, 5)
            self.assertEqual(sum(s[0] for s in said), sent)
            self.assertEqual({s[0] + s[1] for s in said}, {sent})  # each has it once
            self.assertEqual(sum(s[2] for s in said), 4 * sent)
            self.assertLess(sent, 60000 * 36)  # packed

    def test_without_sharing_all_comes_from_the_coordinator(self):
        with Farm() as farm:
            workers = self.workers(farm, 3, "--sharing", "off")
            report = farm.finish(farm.submit(*self.job))
            self.assertEqual(report["image_sha256"], self.expected)
            _, sent = self.sent_bytes(farm)
            said = [bytes_of(worker) for worker in workers]
            self.assertEqual([s[1:] for s in said], [[0, 0]] * 3)
            self.assertEqual(sum(s[0] for s in said), sent)

    @again_with_longer_jobs
    def test_a_stopped_source_is_replaced_by_another(self):
        with Farm("--heartbeat", "0.2") as farm:
            first = self.workers(farm, 1)[0]
            job = farm.submit(*self.job)
            wait_for(lambda: "received a scene" in first.log.read_text(), "the scene")
            first.send_signal(signal.SIGSTOP)  # the machine's source
            farm.start_worker("late")

            def asks():
                if re.search("for worker 2 'late': from (w0|the coordinator)", farm.coordinator_log()):
                    return True
                self.check_unfinished(farm, job)
                return False

            wait_for(asks, "another worker's question")
            self.assertEqual(farm.finish(job)["image_sha256"], self.expected)

    @again_with_longer_jobs
    def test_farms_with_keys_share_scenes_too(self):
        with tempfile.TemporaryDirectory() as directory:
            keys = pathlib.Path(directory) / "farm"
            self.assertEqual(run("keygen", keys).returncode, 0)
            with Farm("--keys", keys) as farm:
                env = {"PARRAY_COORDINATOR": farm.address, "PARRAY_KEYS": str(keys)}
                workers = [farm._start("parray-worker", "--connect", farm.address, "--threads", 1, "--keys", keys)
                           for _ in range(3)]
                wait_for(lambda: farm.coordinator_log().count("joined with") == 3, "the workers")
                job = run("submit", *self.job, env=env)
                self.assertEqual(job.returncode, 0, job.stderr)
                self.assertEqual(run("watch", job.stdout.strip(), env=env).returncode, 0)
                said = [bytes_of(worker) for worker in workers]
                self.check_all_took_part(said)
                self.assertEqual(sum(1 for s in said if s[0] > 0), 1)
                self.assertEqual(sum(1 for s in said if s[1] > 0), 2)


if __name__ == "__main__":
    unittest.main(verbosity=2)
