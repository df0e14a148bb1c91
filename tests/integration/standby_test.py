"""Coordinators that take over from each other, as real processes."""

import pathlib
import random
import re
import shutil
import signal
import socket
import subprocess
import tempfile
import time
import unittest

from farm import BIN, Farm, run, wait_for
from farm_test import SCENE, render_report
from longer_jobs import JobOverTooEarly, LongerJobs, again_with_longer_jobs

SMALL = ("--width", "16", "--height", "16", "--spp", "1")
SYSTEMS_PORTS = pathlib.Path("/proc/sys/net/ipv4/ip_local_port_range")


def free_address():
    """An address with a port that the system gives to no other program meanwhile."""
    first = int(SYSTEMS_PORTS.read_text().split()[0])
    while True:
        port = random.randrange(first // 2, first)
        with socket.socket() as probe:
            try:
                probe.bind(("127.0.0.1", port))
            except OSError:
                continue
        return f"tcp://127.0.0.1:{port}"


def run_coordinator(*arguments):
    return subprocess.run([BIN / "parray-coordinator", *map(str, arguments)], capture_output=True, text=True,
                          timeout=60)


class LongJobs(LongerJobs, unittest.TestCase):
    """Tests that disturb a job which still runs."""

    @classmethod
    def take_jobs(cls):
        spp = 1000 * cls.longer  # at first about two seconds of a core
        cls.long = ("--width", 160, "--height", 100, "--spp", spp)
        cls.expected = render_report(SCENE, *cls.long)["image_sha256"]

    def progress_of_unfinished(self, farm, job):
        progress = farm.job(job)["progress"]
        if progress == 1:
            raise JobOverTooEarly(f"job {job} is done")
        return progress


class OnOneHost(LongJobs):
    @again_with_longer_jobs
    def test_the_next_coordinator_takes_the_killed_ones_place_and_finishes_the_job(self):
        with tempfile.TemporaryDirectory() as state, \
                Farm("--state", state, "--heartbeat", "0.1", bind=free_address()) as farm:
            farm.start_worker("w1")
            farm.start_worker("w2")
            second = farm._start("parray-coordinator", "--bind", farm.address, "--wait", *farm.options)
            wait_for(lambda: "waiting for its end" in second.log.read_text(), "the second to wait")
            job = farm.submit(SCENE, *self.long)
            wait_for(lambda: self.progress_of_unfinished(farm, job) > 0.1, "some progress")
            farm.coordinator.send_signal(signal.SIGSTOP)
            time.sleep(1)
            self.assertNotIn("serves", second.log.read_text(), "a stopped coordinator still has its state")
            farm.coordinator.send_signal(signal.SIGCONT)
            farm.coordinator.send_signal(signal.SIGKILL)
            wait_for(lambda: "serves" in second.log.read_text(), "the second to serve")
            self.assertEqual(second.log.read_text().count("waiting for its end"), 1)
            self.progress_of_unfinished(farm, job)
            self.assertEqual(farm.finish(job)["image_sha256"], self.expected)

    def test_a_signal_ends_the_wait(self):
        with tempfile.TemporaryDirectory() as state, Farm("--state", state) as farm:
            second = farm._start("parray-coordinator", "--bind", farm.bind, "--wait", *farm.options)
            wait_for(lambda: "waiting for its end" in second.log.read_text(), "the second to wait")
            second.send_signal(signal.SIGTERM)
            self.assertEqual(second.wait(timeout=60), 130)


class Twins(Farm):
    """A primary, at `address`, and its standby, at `second`."""

    def __init__(self, *options):
        super().__init__(bind=free_address())
        self.second = free_address()
        self.link = free_address()
        self.options = ["--state", self.directory / "first", "--replicate-to", self.link,
                        "--heartbeat", "0.2", *options]
        self.standby_options = ["--takeover-after", "2", "--heartbeat", "0.2", *options]

    def __enter__(self):
        self.start_standby()
        return super().__enter__()

    def start_standby(self, state="second"):
        self.standby = self._start("parray-coordinator", "--coordinator", self.second, "--standby", self.link,
                                   "--state", self.directory / state, *self.standby_options)
        wait_for(lambda: "standing by" in self.standby.log.read_text(), "the standby")

    def wait_until_in_step(self):
        def in_step():
            said = re.findall("(no longer )?in step with", self.standby.log.read_text())
            return said and not said[-1]

        wait_for(in_step, "the standby to be in step")

    def kill_the_first(self):
        self.coordinator.send_signal(signal.SIGKILL)
        self.coordinator.wait()
        wait_for(lambda: "serves tcp" in self.standby.log.read_text(), "the standby to take over")

    def everywhere(self):
        self.address = f"{self.address},{self.second}"


class BetweenHosts(LongJobs):
    @again_with_longer_jobs
    def test_the_standby_finishes_the_job_of_a_killed_primary_which_then_is_fenced(self):
        with Twins() as farm:
            farm.wait_until_in_step()
            first = farm.address
            farm.everywhere()
            farm.start_worker("w1")
            farm.start_worker("w2")
            job = farm.submit(SCENE, *self.long)
            watch = farm.start_client("watch", job)
            wait_for(lambda: self.progress_of_unfinished(farm, job), "some progress")
            farm.kill_the_first()
            self.assertEqual(watch.wait(timeout=120), 0, watch.log.read_text())
            self.assertEqual(farm.fetch(job)["image_sha256"], self.expected)
            old = farm._start("parray-coordinator", "--coordinator", first, *farm.options)
            self.assertEqual(old.wait(timeout=60), 1)
            self.assertRegex(old.log.read_text(), "fenced: the standby at .* has taken over")
            alone = ("--coordinator", "tcp://127.0.0.1:*", "--state", farm.directory / "first")
            refused = run_coordinator(*alone)
            self.assertEqual(refused.returncode, 2, refused.stderr)
            self.assertIn("--serve-fenced", refused.stderr)
            insisting = farm._start("parray-coordinator", *alone, "--serve-fenced")
            wait_for(lambda: "serves tcp" in insisting.log.read_text(), "the old one to serve")

    def test_a_primary_that_was_set_back_erases_nothing_of_its_standby(self):
        patient = Twins()
        patient.standby_options[1] = "60"  # seconds until the takeover
        with patient as farm:
            farm.wait_until_in_step()
            first = farm.directory / "first"
            farm.start_worker("w1")
            farm.finish(farm.submit(SCENE, *SMALL))
            farm.coordinator.send_signal(signal.SIGTERM)
            farm.coordinator.wait()
            shutil.copytree(first, farm.directory / "snapshot")
            farm.start_coordinator(farm.address)
            jobs = [farm.submit(SCENE, *SMALL) for _ in range(2)]
            expected = [farm.finish(job)["image_sha256"] for job in jobs]
            farm.coordinator.send_signal(signal.SIGKILL)
            farm.coordinator.wait()
            shutil.rmtree(first)
            shutil.move(farm.directory / "snapshot", first)
            set_back = farm._start("parray-coordinator", "--coordinator", farm.address, *farm.options)
            self.assertEqual(set_back.wait(timeout=60), 1)
            self.assertRegex(set_back.log.read_text(), "the state of the primary is older than that of the standby, and [0-9]+ batches of changes would be lost")
            farm.standby.send_signal(signal.SIGTERM)
            farm.standby.wait()
            farm.options = ["--state", farm.directory / "second"]
            farm.start_coordinator()
            self.assertEqual([farm.fetch(job)["image_sha256"] for job in jobs], expected)

    def test_a_damaged_picture_comes_back_from_the_standby_when_it_is_asked_for(self):
        with Twins() as farm:
            farm.wait_until_in_step()
            farm.start_worker("w1")
            job = farm.submit(SCENE, *self.long)
            farm.finish(job)
            picture, = (farm.directory / "first" / "jobs" / str(job)).glob("picture*")
            whole = picture.read_bytes()
            picture.write_bytes(whole[:100] + bytes([whole[100] ^ 1]) + whole[101:])
            self.assertEqual(farm.fetch(job)["image_sha256"], self.expected)
            self.assertIn("restored from the standby", farm.job(job)["flag"])
            files = wait_for(lambda: (found := list(picture.parent.glob("picture*"))) and len(found) == 1 and found,
                             "the damaged file to go")
            self.assertEqual(files[0].read_bytes(), whole)

    def end_standby(self, farm):
        farm.standby.send_signal(signal.SIGTERM)
        farm.standby.wait()
        return farm.directory / "second"

    def check_takeover(self, farm, job, digest):
        farm.wait_until_in_step()
        farm.kill_the_first()
        farm.address = farm.second
        self.assertEqual(farm.fetch(job)["image_sha256"], digest)

    def finished_job(self, farm):
        """A job that the standby has, and the hash of its picture."""
        farm.wait_until_in_step()
        farm.start_worker("w1")
        job = farm.submit(SCENE, *SMALL)
        return job, farm.finish(job)["image_sha256"]

    def test_a_standby_whose_picture_is_in_the_wrong_place_gets_it_again_before_it_takes_over(self):
        with Twins() as farm:
            job, digest = self.finished_job(farm)
            picture, = (self.end_standby(farm) / "jobs" / str(job)).glob("picture*")
            picture.unlink()
            picture.mkdir()
            farm.start_standby()
            self.assertIn("is a directory, not a file: moved to lost/", farm.standby.log.read_text())
            self.check_takeover(farm, job, digest)

    def test_a_standby_whose_state_needs_repair_says_so_and_after_that_takes_over(self):
        with Twins() as farm:
            job, digest = self.finished_job(farm)
            state = self.end_standby(farm)
            (state / "parray.sqlite").unlink()
            refused = run_coordinator("--coordinator", farm.second, "--standby", farm.link, "--state", state)
            self.assertEqual((refused.returncode, len(refused.stderr.splitlines())), (1, 1), refused.stderr)
            self.assertIn(f"--repair {state}", refused.stderr)
            self.assertEqual(run_coordinator("--repair", state).returncode, 0)
            farm.start_standby()
            self.check_takeover(farm, job, digest)

    def test_a_backup_of_a_standby_serves_all_that_was_acknowledged(self):
        with Twins() as farm:
            job, digest = self.finished_job(farm)
            copied = run_coordinator("--backup", farm.directory / "second", farm.directory / "copy")
            self.assertEqual(copied.returncode, 0, copied.stdout + copied.stderr)
            with Farm("--state", farm.directory / "copy") as restored:
                self.assertEqual(restored.fetch(job)["image_sha256"], digest)

    def test_a_stopped_primary_is_fenced_when_it_continues(self):
        with Twins() as farm:
            farm.wait_until_in_step()
            farm.coordinator.send_signal(signal.SIGSTOP)
            wait_for(lambda: "serves tcp" in farm.standby.log.read_text(), "the standby to take over")
            self.assertIn("To have a standby again, start the former primary with --standby", farm.standby.log.read_text())
            farm.coordinator.send_signal(signal.SIGCONT)
            self.assertEqual(farm.coordinator.wait(timeout=60), 1)
            self.assertRegex(farm.coordinator_log(), "fenced: .*replace --replicate-to by --standby, and restart the other coordinator")

    def test_without_its_standby_a_primary_acknowledges_nothing_and_a_new_one_gets_a_full_copy(self):
        with Twins() as farm:
            farm.wait_until_in_step()
            farm.standby.send_signal(signal.SIGKILL)
            farm.standby.wait()
            submit = farm.start_client("submit", SCENE, *self.long)
            time.sleep(2)  # two beats of the replication
            self.assertIsNone(submit.poll(), "acknowledged what the standby has not")
            farm.start_standby("third")
            self.assertEqual(submit.wait(timeout=60), 0, submit.log.read_text())
            farm.wait_until_in_step()
            farm.kill_the_first()
            farm.address = farm.second
            farm.start_worker("w1")
            farm.start_worker("w2")
            self.assertEqual(farm.finish(1)["image_sha256"], self.expected)

    def test_a_standby_that_was_never_in_step_does_not_take_over(self):
        with Twins() as farm:
            lonely = farm._start("parray-coordinator", "--coordinator", free_address(), "--standby", free_address(),
                                 "--state", farm.directory / "lonely", "--takeover-after", "1")
            wait_for(lambda: "no complete copy of a state yet: start the primary with --replicate-to"
                     in lonely.log.read_text(), "the advice")
            self.assertNotIn("without --standby", lonely.log.read_text(), "there is nothing to serve")
            self.assertNotIn("has taken over", lonely.log.read_text())
            lonely.send_signal(signal.SIGTERM)
            self.assertEqual(lonely.wait(timeout=60), 130)

    def test_a_restarted_standby_whose_primary_is_lost_says_how_to_serve_its_copy(self):
        with Twins() as farm:
            job, digest = self.finished_job(farm)
            state = self.end_standby(farm)
            farm.coordinator.send_signal(signal.SIGKILL)
            farm.coordinator.wait()
            farm.start_standby()
            wait_for(lambda: "no primary has reached this standby for 2 s" in farm.standby.log.read_text(), "the advice")
            self.assertIn("start this coordinator without --standby", farm.standby.log.read_text())
            self.end_standby(farm)
            self.assertEqual(farm.standby.log.read_text().count("no primary has reached"), 1)
            with Farm("--state", state) as alone:
                self.assertEqual(alone.fetch(job)["image_sha256"], digest)

    def test_an_old_primary_that_has_served_alone_says_why_it_serves_despite_standby(self):
        def stop(coordinator):
            coordinator.send_signal(signal.SIGTERM)
            coordinator.wait()

        with Twins() as farm:
            farm.wait_until_in_step()
            stop(farm.coordinator)
            self.end_standby(farm)
            farm.options = ["--state", farm.directory / "first"]
            farm.start_coordinator()
            stop(farm.coordinator)
            old = farm._start("parray-coordinator", "--coordinator", farm.bind, "--standby", farm.link, *farm.options)
            wait_for(lambda: "serves tcp" in old.log.read_text(), "the old primary to serve")
            self.assertIn("no standby, because its state has served without one", old.log.read_text())
            self.assertIn("start another coordinator with an empty directory and with --standby", old.log.read_text())

    def test_with_keys_only_the_coordinators_own_key_is_let_in(self):
        with tempfile.TemporaryDirectory() as directory:
            for name in ("ours", "others"):
                self.assertEqual(run("keygen", f"{directory}/{name}").returncode, 0)
            with Twins("--keys", f"{directory}/ours") as farm:
                farm.wait_until_in_step()
            stranger = Twins()
            stranger.standby_options += ["--keys", f"{directory}/ours"]
            stranger.options += ["--keys", f"{directory}/others"]
            with stranger as farm:
                time.sleep(2)
                self.assertNotIn("in step", farm.standby.log.read_text())


class Refusals(unittest.TestCase):
    def refused(self, *options, mentions):
        with tempfile.TemporaryDirectory() as state:
            result = run_coordinator(*options, "--state", state)
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertEqual(result.stderr.count("\n"), 1, result.stderr)
            self.assertIn(mentions, result.stderr)

    def test_addresses_that_every_machine_could_use_are_refused(self):
        self.refused("--standby", "tcp://0.0.0.0:7401", mentions="pose as the primary")
        self.refused("--replicate-to", "tcp://192.0.2.1:7401", mentions="read all jobs")

    def test_contradictory_options_are_refused(self):
        self.refused("--coordinator", "tcp://127.0.0.1:1,tcp://127.0.0.1:2", mentions="must be one address")
        self.refused("--standby", "tcp://127.0.0.1:*", "--replicate-to", "tcp://127.0.0.1:1",
                     mentions="a standby cannot have a standby")


if __name__ == "__main__":
    unittest.main()
