#!/usr/bin/env python3
"""parray-mpi with real ranks: for any number of ranks, any way to share the work and after any crash the picture has
the bits of `parray render`."""

import itertools
import json
import os
import pathlib
import shutil
import signal
import tempfile
import time
import unittest

from farm import SCENES, Farm, child_processor_seconds, run, wait_for
from longer_jobs import JobOverTooEarly, LongerJobs, again_with_longer_jobs
from mpi import MpiRun, check_unfinished, committed_bytes, kept_bytes, kept_passes, why_not

SCENE = SCENES / "one-weekend-484.json"
RANKS = range(1, 7)
POLICIES = ("static", "guided", "factoring", "weighted")
THREADS = (1, 2)
# Each number of ranks, and each policy with each number of threads; Sweep has all combinations.
SOME = ((1, "static", 1), (2, "factoring", 2), (3, "weighted", 1), (4, "guided", 2), (5, "static", 2), (6, "guided", 1))


def size(width, height, spp):
    return ["--width", width, "--height", height, "--spp", spp]


SIZE = size(100, 75, 40)
LONG_CORE_SECONDS = 1.7  # several commits, on two cores, before it is done
MANY_PASSES = 5
PASS_CORE_SECONDS = 0.2
SOME_ROWS = 20_000  # bytes of a log with more than its first entries
# In passes, decided by what the passes before have found.
TO_AN_ERROR = (*size(100, 75, 2000), "--target-error", 0.012)
ADAPTIVE = (*size(100, 75, 120), "--adaptive", "on")
NO_WINDOW = ("--mca", "osc", "^rdma,sm,pt2pt,ucx,monitoring,portals4")
SAFE = ["--checkpoint", 0.1, "--threads", 1]


def render_report(*options):
    with tempfile.TemporaryDirectory() as directory:
        result = run("render", SCENE, "-o", f"{directory}/a.png", "--report", f"{directory}/a.json",
                     *options)
        assert result.returncode == 0, result.stderr
        return json.loads(pathlib.Path(directory, "a.json").read_text())


def core_speed():
    """Samples a second of one core, whatever else there is for it to do."""
    before = child_processor_seconds()
    return render_report(*size(100, 75, 400), "--threads", 1)["samples"] / (child_processor_seconds() - before)


def wait_for_commit(check_runs, is_kept):
    """Until a commit in the middle of the job has kept what is wanted."""
    def kept():
        check_runs()
        return is_kept()

    wait_for(kept, "the commit")


def wait_for_rows(state, check_runs):
    wait_for_commit(check_runs, lambda: committed_bytes(state) > SOME_ROWS)


def wait_for_later_pass(state, check_runs):
    wait_for_commit(check_runs, lambda: kept_passes(state) > 1 and committed_bytes(state) > SOME_ROWS)


class MpiCase(unittest.TestCase):
    """What all have. Each class takes the references that it needs."""

    @classmethod
    def setUpClass(cls):
        cls.expected = render_report(*SIZE, "--threads", 1)

    def setUp(self):
        directory = tempfile.TemporaryDirectory()
        self.addCleanup(directory.cleanup)
        self.state = pathlib.Path(directory.name) / "state"

    def check(self, report, expected):
        for field in ("image_sha256", "samples", "rays"):
            self.assertEqual(report[field], expected[field], field)

    def check_passes(self, report, expected):
        self.check(report, expected)
        for field in ("passes", "stopped_by", "error", "samples_per_pixel"):
            self.assertEqual(report[field], expected[field], field)

    def check_job(self, ranks, *options, **more):
        with MpiRun(ranks, SCENE, *SIZE, *options, **more) as job:
            report = job.finish()
            self.check(report, self.expected)
            self.assertEqual(report["isa"], self.expected["isa"])
            self.assertIn(self.expected["image_sha256"][:16], job.text())
            return report, job.text()

    def check_ranks(self, report, ranks, threads):
        """What the report says about the ranks adds up."""
        entries = report["mpi"]["ranks"]
        self.assertEqual([entry["threads"] for entry in entries], [threads] * ranks)
        self.assertEqual(sum(entry["leases"] for entry in entries), report["mpi"]["leases"])
        self.assertGreaterEqual(sum(entry["samples"] for entry in entries), report["samples"])
        self.assertEqual(report["mpi"]["mismatched_cells"], 0)
        self.assertEqual(report["mpi"]["corrupt_results"], 0)


class DisturbedJobs(LongerJobs, MpiCase):
    """Tests that disturb a job which still runs."""

    def check_farm_runs(self, farm, number):
        if farm.job(number)["state"] == "done":
            raise JobOverTooEarly(f"job {number} is done")

    def kill_coordinator_of(self, *options, wait=wait_for_rows):
        """Ends a coordinator in the middle of a job whose first rows it has kept."""
        with Farm("--state", self.state) as farm:
            farm.start_worker("w1", threads=2)
            number = farm.submit(SCENE, *options)
            wait(self.state, lambda: self.check_farm_runs(farm, number))
            farm.coordinator.send_signal(signal.SIGKILL)
            farm.coordinator.wait()
        check_unfinished(self.state)


class LongJobs(DisturbedJobs):
    @classmethod
    def take_jobs(cls):
        samples = cls.longer * LONG_CORE_SECONDS * core_speed()
        cls.long = size(200, 150, max(300, int(samples / (200 * 150))))
        cls.expected_long = render_report(*cls.long)

    def long_job(self, ranks, *options, **more):
        return MpiRun(ranks, SCENE, *self.long, *SAFE, "--state", self.state, *options, **more)

    def check_goes_on(self, ranks):
        with self.long_job(ranks) as job:
            report = job.finish()
            self.check(report, self.expected_long)
            self.assertRegex(job.text(), r"parray-mpi: continuing from [0-9.]+ % in ")


@unittest.skipIf(why_not(), why_not())
class OneHash(MpiCase):
    def test_one_hash_for_every_number_of_ranks_and_every_policy(self):
        for ranks, policy, threads in SOME:
            with self.subTest(ranks=ranks, policy=policy, threads=threads):
                report, _ = self.check_job(ranks, "--schedule", policy, "--threads", threads)
                self.check_ranks(report, ranks, threads)
                self.assertEqual(report["mpi"]["transport"], "memory" if ranks == 1 else "window")

    def test_one_hash_with_several_ledgers(self):
        for ranks, each in ((3, 1), (8, 3)):
            with self.subTest(ranks=ranks, each=each):
                report, _ = self.check_job(ranks, "--ledger-ranks", each, "--threads", 1)
                self.check_ranks(report, ranks, 1)
                self.assertEqual(report["mpi"]["transport"], "window")

    def test_one_hash_for_every_mode_with_and_without_tiles(self):
        # Others have window and messages without tiles.
        modes = {"window": ("window", 16), "messages": ("messages", 16), "static": ("window", 0),
                 "openmp": ("memory", 0), "sequential": ("memory", 0)}
        for mode, (transport, tile) in modes.items():
            with self.subTest(mode=mode):
                report, _ = self.check_job(3, "--mode", mode, "--tile", tile, "--threads", 2)
                self.assertEqual(report["mpi"]["mode"], mode)
                self.assertEqual(report["mpi"]["transport"], transport)
                self.assertEqual(len(report["mpi"]["ranks"]), 1 if transport == "memory" else 3)

    def test_one_hash_for_a_job_in_passes(self):
        # Passes has adaptive pictures of 1 to 3 ranks, over windows and messages.
        trials = {TO_AN_ERROR: [(1, "window", 0), (2, "window", 0), (3, "messages", 0)],
                  ADAPTIVE: [(3, "window", 16), (3, "static", 0), (2, "openmp", 0)]}
        for options, ways in trials.items():
            expected = render_report(*options)
            self.assertGreater(len(expected["passes"]), 1)
            for ranks, mode, tile in ways:
                with self.subTest(options=options[6:], ranks=ranks, mode=mode, tile=tile):
                    with MpiRun(ranks, SCENE, *options, "--mode", mode, "--tile", tile,
                                "--threads", 1) as job:
                        report = job.finish()
                        self.check_passes(report, expected)
                        self.assertEqual(report["mpi"]["mismatched_cells"], 0)
                        self.assertEqual(report["mpi"]["corrupt_results"], 0)
                        self.assertEqual(sum(rank["leases"] for rank in report["mpi"]["ranks"]),
                                         report["mpi"]["leases"])

    def test_without_windows_ranks_send_messages_and_say_so(self):
        report, text = self.check_job(3, mpirun=NO_WINDOW)
        self.assertEqual(report["mpi"]["transport"], "messages")
        self.assertRegex(text, "parray-mpi: one-sided communication of MPI does not work here .*: ranks send messages instead")

    def test_without_mpirun_it_renders_alone(self):
        self.check_job(None)

    def test_an_interrupt_before_tracing_names_this_program(self):
        scene = self.state.parent / "scene.json"
        os.mkfifo(scene)
        with MpiRun(None, scene) as job:
            def is_read():
                try:
                    return os.open(scene, os.O_WRONLY | os.O_NONBLOCK)
                except OSError:  # no process has opened the pipe for reading yet
                    return None
            os.write(wait_for(is_read, "a reader of the scene"), b"{")
            job.process.send_signal(signal.SIGINT)
            self.assertEqual(job.wait(), 130, job.text())
            self.assertEqual(job.lines(), ["parray-mpi: interrupted"])

    def test_a_picture_of_ranks_can_be_fetched_from_a_farm_and_nothing_else_is_left_behind(self):
        with MpiRun(2, SCENE, *SIZE, "--state", self.state, picture="a.exr") as job:
            self.check(job.finish(), self.expected)
            self.assertEqual(sorted(path.name for path in job.directory.iterdir()),
                             ["a.exr", "a.json", "log"])
        with Farm("--state", self.state) as farm:
            self.check(farm.fetch(1), self.expected)

    def test_the_command_of_on_end_may_start_mpirun_and_has_the_users_parameters(self):
        told = self.state.parent / "told"
        given = {"OMPI_MCA_btl": "self,vader,tcp", "OMPI_MCA_orte_base_help_aggregate": "0"}
        command = f"mpirun -n 2 --oversubscribe sh -c 'echo $PARRAY_STATE ${' $'.join(given)}' > {told}"
        with MpiRun(2, SCENE, *SIZE, "--on-end", command, env=given) as job:
            job.finish()
            self.assertNotIn("--on-end", job.text())
        self.assertEqual(told.read_text(), "done self,vader,tcp 0\n" * 2)

    def test_bad_input_is_refused_in_one_line_by_one_rank(self):
        cases = {"no-such-scene.json": ["no-such-scene.json"],
                 "--no-such-option": [SCENE, "--no-such-option"],
                 "0": [SCENE, "--threads", 0],
                 "unknown: use one of window": [SCENE, "--mode", "magic"],
                 "--target-error 1e-09": [SCENE, "-o", "a.exr", "--target-error", "1e-9"],
                 "no-such-folder": [SCENE, *SIZE, "-o", "/no-such-folder/a.exr"]}
        for wanted, options in cases.items():
            with self.subTest(options=options):
                with MpiRun(3, *options) as job:
                    self.assertEqual(job.wait(), 2, job.text())
                    self.assertEqual(len(job.lines()), 1, job.text())
                    self.assertIn(wanted, job.lines()[0])
                    self.assertEqual(kept_bytes(self.state), 0)


@unittest.skipIf(why_not(), why_not())
class Passes(DisturbedJobs):
    @classmethod
    def take_jobs(cls):
        samples = int(cls.longer * PASS_CORE_SECONDS * core_speed()) // 2 * 2
        adaptive = [*size(200, 150, MANY_PASSES * samples // (200 * 150) + 1), "--adaptive", "on"]
        cls.one_pass = [*adaptive, "--passes", samples]
        cls.passes = [*adaptive, "--passes", ",".join([str(samples)] * MANY_PASSES)]
        cls.expected_passes = render_report(*cls.passes)

    def test_a_job_stops_when_its_time_is_over_and_can_be_repeated(self):
        limit = 0.4
        with MpiRun(2, SCENE, *size(100, 75, 1_000_000), "--adaptive", "on", "--time-limit", limit,
                    "--threads", 1) as job:
            report = job.finish()
        self.assertEqual(report["stopped_by"], "time")
        self.assertLess(report["samples_per_pixel"], 500_000)
        expected = render_report(*size(100, 75, 1_000_000), "--adaptive", "on", "--passes",
                                 ",".join(map(str, report["passes"])))
        self.check(report, expected)

    @again_with_longer_jobs
    def test_a_later_pass_of_a_killed_rank_0_goes_on_with_other_ranks_and_in_a_farm(self):
        options = [*self.passes, *SAFE, "--state", self.state]
        with MpiRun(2, SCENE, *options) as job:
            wait_for_later_pass(self.state, job.check_runs)
            job.send(signal.SIGKILL, rank=0)
            job.wait_for_failure()
        in_farm = self.state.with_name("copy")
        shutil.copytree(self.state, in_farm)
        with MpiRun(3, SCENE, *options) as job:
            wait_for(lambda: "continuing from" in job.text(), "the job to go on")
            with job.stopped(rank=2):
                time.sleep(0.7)  # long enough for the others to come to the end of a pass
            self.check_passes(job.finish(), self.expected_passes)
            self.assertRegex(job.text(), r"parray-mpi: continuing from [0-9.]+ samples per pixel in ")
        self.assertGreater(kept_passes(in_farm), 1)
        with Farm("--state", in_farm) as farm:
            farm.start_worker("w1", threads=2)
            self.check_passes(farm.finish(1), self.expected_passes)

    @again_with_longer_jobs
    def test_ranks_go_on_with_a_later_pass_of_a_killed_coordinator(self):
        self.kill_coordinator_of(*self.passes, wait=wait_for_later_pass)
        with MpiRun(2, SCENE, *self.passes, *SAFE, "--state", self.state) as job:
            self.check_passes(job.finish(), self.expected_passes)
            self.assertRegex(job.text(), "parray-mpi: continuing from ")

    @again_with_longer_jobs
    def test_a_preview_shows_the_picture_before_it_is_done_and_changes_nothing(self):
        for mode in ("window", "messages"):
            preview = self.state.parent / f"{mode}.png"
            with MpiRun(2, SCENE, *self.passes, *SAFE, "--mode", mode,
                        "--preview", preview) as job:
                wait_for(preview.exists, "the preview")
                job.check_runs()
                self.assertGreater(preview.stat().st_size, 10000)
                self.check_passes(job.finish(), self.expected_passes)

    @again_with_longer_jobs
    def test_a_rank_that_does_not_come_to_the_end_of_a_pass_ends_the_job(self):
        options = [*self.passes, *SAFE, "--state", self.state]
        with MpiRun(3, SCENE, *options, "--patience", 2 * self.longer) as job:
            wait_for_rows(self.state, job.check_runs)
            job.send(signal.SIGSTOP, rank=2)
            job.wait_for_failure()
            self.assertRegex(job.text(),
                             r"parray-mpi: no rank has made progress for .*; [0-9.]+ samples per pixel are "
                             "kept in ")
        with MpiRun(2, SCENE, *self.one_pass, *SAFE, "--state", self.state) as job:
            job.finish()
            self.assertNotIn("continuing from", job.text())  # with other limits it is another job
        with MpiRun(1, SCENE, *options) as job:
            self.check_passes(job.finish(), self.expected_passes)
            self.assertIn("continuing from", job.text())


@unittest.skipIf(why_not(), why_not())
class Deaths(LongJobs):
    @again_with_longer_jobs
    def test_a_rank_killed_in_mid_job_ends_it_and_another_number_of_ranks_goes_on(self):
        # mpirun waits so long before it ends the other ranks, and again before it kills them. Meanwhile rank 0 goes on
        # alone, and then saves what it has, for which the time may be too short on a slow disk.
        seconds = self.longer
        patient = ("--mca", "odls_base_sigkill_timeout", str(seconds))
        with self.long_job(2, mpirun=patient) as job:
            wait_for_rows(self.state, job.check_runs)
            job.send(signal.SIGKILL, rank=1)
            job.wait_for_failure()
            self.assertRegex(job.text(), "rank 1 .*Killed")
            if "interrupted" not in job.text():
                raise JobOverTooEarly(f"rank 0 said nothing in {seconds} s: {job.text()}")
            self.assertRegex(job.text(), "parray-mpi: interrupted.* % is kept in ")
            self.assertFalse(job.picture.exists())
        self.check_goes_on(3)

    @again_with_longer_jobs
    def test_a_farm_goes_on_with_what_a_killed_rank_0_has_kept(self):
        with self.long_job(2) as job:
            wait_for_rows(self.state, job.check_runs)
            job.send(signal.SIGKILL, rank=0)
            job.wait_for_failure()
            self.assertRegex(job.text(), "rank 0 .*Killed")
        with Farm("--state", self.state) as farm:
            self.assertLess(farm.job(1)["progress"], 1)
            farm.start_worker("w1", threads=2)  # what is kept is read when there is one
            wait_for(lambda: farm.job(1)["progress"] > 0, "some progress")
            self.check(farm.finish(1), self.expected_long)

    @again_with_longer_jobs
    def test_ranks_go_on_with_what_a_killed_coordinator_has_kept(self):
        self.kill_coordinator_of(*self.long)
        self.check_goes_on(3)

    @again_with_longer_jobs
    def test_an_interrupted_mpirun_leaves_no_rank_and_what_is_finished(self):
        with self.long_job(2, mpirun=("--mca", "odls_base_sigkill_timeout", "0")) as job:
            wait_for_rows(self.state, job.check_runs)
            job.process.send_signal(signal.SIGINT)
            job.wait_for_failure()
            self.assertFalse(job.picture.exists())
        self.check_goes_on(3)


@unittest.skipIf(why_not(), why_not())
class Silences(LongJobs):
    @again_with_longer_jobs
    def test_cells_of_a_stopped_rank_are_traced_by_the_others_which_wait_for_the_end(self):
        ended = self.state.parent / "ended"
        with self.long_job(3, "--patience", 3, "--on-end", f"sleep 5; echo $PARRAY_STATE > {ended}") as job:
            wait_for_rows(self.state, job.check_runs)
            job.send(signal.SIGSTOP, rank=1)
            report = job.finish()
            self.check(report, self.expected_long)
            self.assertIn("parray-mpi: the work is done, but not all ranks answer", job.text())
        self.assertEqual(ended.read_text(), "done\n")

    @again_with_longer_jobs
    def test_a_rank_that_is_stopped_for_a_while_changes_nothing(self):
        with self.long_job(3) as job:
            wait_for_rows(self.state, job.check_runs)
            with job.stopped(rank=2):
                time.sleep(1)  # how long does not matter
            self.check(job.finish(), self.expected_long)

    def check_silent_coordinator(self, mode):
        with self.long_job(2, "--patience", 3 * self.longer, "--mode", mode) as job:
            wait_for_rows(self.state, job.check_runs)
            job.send(signal.SIGSTOP, rank=0)
            job.wait_for_failure(may_be_done=True)
            self.assertRegex(job.text(), "parray-mpi: rank 1 waits for a rank that does not answer")
        self.check_goes_on(1)

    @again_with_longer_jobs
    def test_ranks_whose_coordinator_is_silent_end_the_job(self):
        self.check_silent_coordinator("window")

    @again_with_longer_jobs
    def test_ranks_whose_coordinator_does_not_answer_messages_end_the_job(self):
        self.check_silent_coordinator("messages")


@unittest.skipIf(why_not(), why_not())
class Sweep(unittest.TestCase):
    """Every number of ranks x every policy x every number of threads: only when asked for."""

    def test_every_combination_gives_one_hash(self):
        expected = render_report(*SIZE)["image_sha256"]
        for ranks, policy, threads in itertools.product(RANKS, POLICIES, THREADS):
            for mode in ("window", "messages"):
                with self.subTest(ranks=ranks, policy=policy, threads=threads, mode=mode):
                    with MpiRun(ranks, SCENE, *SIZE, "--schedule", policy, "--threads", threads,
                                "--mode", mode) as job:
                        self.assertEqual(job.finish()["image_sha256"], expected)



if __name__ == "__main__":
    unittest.main(verbosity=2)
