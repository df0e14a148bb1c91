#!/usr/bin/env python3
"""A farm on three hosts (network namespaces) with keys: which processes may join, and failures of links."""

import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

import hosts

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "integration"))
from farm import SCENES, run, wait_for  # noqa: E402

SCENE = SCENES / "one-weekend-20.json"
SETTINGS = ("--width", "160", "--height", "100", "--spp", "500")  # about a second for two threads
SMALL = ("--width", "60", "--height", "40", "--spp", "16")
PORT = 7400


def keygen(directory, *options):
    result = run("keygen", directory, *options)
    if result.returncode != 0:
        raise AssertionError(result.stderr)


class Farms(unittest.TestCase):
    """Starts a coordinator on `head`, a worker on `left` and one on `right`, and uses a client on `left`."""

    def setUp(self):
        if not hosts.permitted():
            self.skipTest("network namespaces are not permitted")
        directory = tempfile.TemporaryDirectory()
        self.addCleanup(directory.cleanup)
        self.directory = pathlib.Path(directory.name)
        self.keys = self.directory / "keys"
        keygen(self.keys)
        keygen(self.keys, "--name", "ann")
        self.head, self.left, self.right = self.enterContext(hosts.Hosts("head", "left", "right"))
        self.address = f"tcp://{self.head.address}:{PORT}"
        self.coordinator = self.head.start("parray-coordinator", "--coordinator", self.address, "--keys", self.keys,
                                           "--state", self.directory / "state", "--heartbeat", "0.2",
                                           "--lease-timeout", "2", stdout=subprocess.PIPE)
        self.coordinator.stdout.readline()
        self.start_worker(self.left)
        self.start_worker(self.right)

    def start_worker(self, host):
        key = self.directory / f"{host.name}-worker.key"  # all that is copied there
        shutil.copy2(self.keys / "worker.key", key)
        return host.start("parray-worker", "--coordinator", self.address, "--keys", key, "--threads", 1, "--name",
                          host.name)

    def client(self, command, *arguments, key="ann"):
        return self.left.run("parray", command, *arguments, "--coordinator", self.address, "--keys",
                             self.keys / f"{key}.key")

    def submit(self, *settings):
        result = self.client("submit", SCENE, *settings)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout.strip()

    def progress(self, job):
        return json.loads(self.client("show", job, "--json").stdout)["progress"]

    def finish(self, job):
        report = self.directory / "report.json"
        watched = self.client("watch", job)
        self.assertEqual(watched.returncode, 0, watched.stderr)
        fetched = self.client("fetch", job, "-o", self.directory / "a.png", "--report", report)
        self.assertEqual(fetched.returncode, 0, fetched.stderr)
        return json.loads(report.read_text())

    def log(self):
        return self.coordinator.log.read_text()

    def wait_for_log(self, text, times=1):
        wait_for(lambda: self.log().count(text) >= times, f"the coordinator to say: {text}")


class Strangers(Farms):
    def test_only_keys_of_the_farm_with_the_right_role_are_accepted(self):
        wait_for(lambda: len(json.loads(self.client("workers", "--json").stdout)) == 2, "both workers to be let in")
        self.finish(self.submit(*SMALL))
        others = self.directory / "others"  # another farm's keys
        keygen(others)
        copied = self.directory / "copied"  # a stranger's list of who is known does not count
        shutil.copytree(self.keys, copied)
        keygen(copied, "--name", "eve")
        knocking = [self.left.start("parray", "jobs", "--coordinator", self.address, *keys)
                    for keys in ((), ("--keys", others / "admin.key"), ("--keys", copied / "eve.key"))]
        strangers = [self.right.start("parray-worker", "--coordinator", self.address, "--name", "stranger", *keys)
                     for keys in ((), ("--keys", others / "worker.key"))]
        poser = self.right.start("parray-worker", "--coordinator", self.address, "--name", "poser", "--keys",
                                 self.keys / "ann.key")
        self.assertEqual(poser.wait(timeout=60), 1)
        self.assertIn("the key 'ann' has the role client", poser.log.read_text())
        submitted = self.client("submit", SCENE, *SMALL, key="worker")
        self.assertEqual(submitted.returncode, 2)
        self.assertIn("has the role worker", submitted.stderr)
        for client in knocking:
            self.assertEqual(client.wait(timeout=60), 1)
            self.assertIn("no answer", client.log.read_text())
        self.assertEqual([stranger.poll() for stranger in strangers], [None, None])  # they still knock
        self.assertNotIn("'stranger'", self.log())
        names = {worker["name"] for worker in json.loads(self.client("workers", "--json").stdout)}
        self.assertEqual(names, {"left", "right"})


class Links(Farms):
    @classmethod
    def setUpClass(cls):
        with tempfile.TemporaryDirectory() as directory:
            done = run("render", SCENE, *SETTINGS, "-q", "-o", f"{directory}/a.png", "--report",
                       f"{directory}/a.json")
            assert done.returncode == 0, done.stderr
            cls.expected = json.loads(pathlib.Path(directory, "a.json").read_text())["image_sha256"]

    def check(self, job):
        self.assertEqual(self.finish(job)["image_sha256"], self.expected)

    def begun(self):
        wait_for(lambda: self.log().count(" joined ") >= 2, "both workers")
        job = self.submit(*SETTINGS)
        wait_for(lambda: self.progress(job) > 0.05, "some progress")
        return job

    def test_over_a_slow_link_the_picture_is_the_same(self):
        self.right.limit("500kbit")
        self.check(self.begun())

    def test_a_link_that_is_down_for_a_while_changes_nothing(self):
        job = self.begun()
        self.right.link(False)
        self.wait_for_log("'right' left (silent for too long)")
        self.right.link(True)
        self.check(job)
        self.wait_for_log("'right' joined", 2)

    def test_a_host_behind_a_switch_that_drops_everything_is_lost_and_comes_back(self):
        job = self.begun()
        self.right.blackhole(True)
        self.wait_for_log("'right' left (silent for too long)")
        self.right.blackhole(False)
        self.check(job)
        self.wait_for_log("'right' joined", 2)

    def test_a_host_that_loses_power_and_comes_back_changes_nothing(self):
        job = self.begun()
        self.right.reboot()
        self.start_worker(self.right)
        self.wait_for_log("'right' left (silent for too long)")
        self.check(job)

    def test_a_coordinator_that_is_unreachable_for_a_while_continues(self):
        job = self.begun()
        self.head.link(False)
        self.wait_for_log("left (silent for too long)", 2)
        self.head.link(True)
        self.check(job)


class Long(Farms):
    def test_after_a_long_partition_all_are_back_within_seconds(self):
        """With TCP alone, the next attempt would come after half of the partition's time again, 20 s."""
        wait_for(lambda: self.log().count(" joined ") >= 2, "both workers")
        self.head.blackhole(True)
        time.sleep(40)
        self.head.blackhole(False)
        healed = time.monotonic()
        self.wait_for_log(" joined ", 4)
        self.assertLess(time.monotonic() - healed, 12)


if __name__ == "__main__":
    hosts.enter()
    unittest.main()
