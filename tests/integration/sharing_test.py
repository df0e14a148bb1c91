#!/usr/bin/env python3
"""Users share a farm of real processes: turns, actions on jobs and workers, the history of a job."""

import json
import subprocess
import unittest

from farm import BIN, SCENES, Farm, run, wait_for
from longer_jobs import JobOverTooEarly, LongerJobs, again_with_longer_jobs

SCENE = SCENES / "one-weekend-20.json"
QUICK = ["--width", "60", "--height", "40", "--spp", "4"]
LARGE = ["--width", "160", "--height", "100", "--spp"]
LONG = [*LARGE, "1000"]
ENDLESS = ["--width", "160", "--height", "100", "--spp", "1000000"]


class Sharing(LongerJobs, unittest.TestCase):
    def long(self):
        """A job that a test disturbs: a second of two cores."""
        return [*LARGE, str(1000 * self.longer)]

    def test_a_short_job_does_not_wait_for_a_long_one_that_came_before(self):
        with Farm() as farm:
            farm.start_worker("w1")
            long = farm.submit(SCENE, *ENDLESS)
            wait_for(lambda: farm.job(long)["progress"] > 0, "the long job")
            short = farm.submit(SCENE, *QUICK)
            farm.finish(short)
            events = farm.job(short)["events"]
            self.assertEqual([e["what"] for e in events][1:], ["started", "done"])
            self.assertEqual(farm.job(long)["state"], "running")
            # Its worker held two leases of half a second at most.
            self.assertLess(events[1]["at"] - events[0]["at"], 10)

    @again_with_longer_jobs
    def test_jobs_are_queued_again_forgotten_and_given_another_priority(self):
        with Farm() as farm:
            state = farm.directory / "state"
            farm.coordinator.terminate()
            farm.coordinator.wait()
            farm.options = ("--state", state)
            farm.start_coordinator()
            worker = farm.start_worker("w1", threads=2)
            job = farm.submit(SCENE, *self.long())
            wait_for(lambda: farm.job(job)["progress"] > 0.1, "some progress")
            cancelled = farm.client("cancel", job)
            if "is done" in cancelled.stderr or "is finishing" in cancelled.stderr:
                raise JobOverTooEarly(cancelled.stderr)
            self.assertEqual(cancelled.returncode, 0, cancelled.stderr)
            worker.terminate()  # so that the job does not end before it is steered
            worker.wait()
            self.assertEqual(farm.client("requeue", job).returncode, 0)
            self.assertEqual(farm.client("priority", job, 70).returncode, 0)
            self.assertEqual(farm.job(job)["priority"], 70)
            refused = farm.client("forget", job)
            self.assertEqual((refused.returncode, refused.stderr.count("\n")), (2, 1))
            self.assertIn("cancel it first", refused.stderr)
            farm.start_worker("w2", threads=2)
            report = farm.finish(job)
            picture = farm.directory / "again.png"
            rendered = run("render", SCENE, *self.long(), "-o", picture)
            self.assertIn(report["image_sha256"][:16], rendered.stdout)
            self.assertEqual(farm.client("forget", job).returncode, 0)
            self.assertEqual(farm.client("show", job).returncode, 2)

    def start_leaving(self, farm):
        """A second worker, w2, that has got work and leaves when it gets none any more."""
        def has_work():
            return leaving.poll() is not None or any(w["name"] == "w2" and w["leases"] > 0 for w in farm.workers())

        for patience in (1, 4, 16):  # a busy machine may take long to connect it
            leaving = farm._start("parray-worker", "--connect", farm.address, "--threads", "1",
                                  "--name", "w2", "--idle-exit", patience)
            wait_for(has_work, "leases of both")
            if leaving.poll() is None:
                return leaving
        raise AssertionError("the second worker got no work: " + leaving.log.read_text())

    def test_a_drained_worker_gets_no_more_and_an_idle_one_leaves(self):
        with Farm("--heartbeat", "0.2") as farm:
            farm.start_worker("w1")
            job = farm.submit(SCENE, *ENDLESS)
            # Then there is work from its first moment on for the one that leaves for want of it.
            wait_for(lambda: any(w["leases"] > 0 for w in farm.workers()), "leases")
            leaving = farm._start("parray-worker", "--coordinator", farm.address, "--threads", "1",
                                  "--name", "w2", "--idle-exit", "1")
            wait_for(lambda: [w["leases"] > 0 for w in farm.workers()] == [True, True], "leases of both")
            drained = farm.client("workers", "drain", "w2", "--json")
            self.assertIn(json.loads(drained.stdout)[0]["state"], ("draining", "drained"))
            self.assertEqual(leaving.wait(timeout=60), 0)
            self.assertIn("--idle-exit", leaving.log.read_text())
            self.assertEqual(farm.job(job)["state"], "running")
            readmitted = farm.client("workers", "readmit", "w2")
            self.assertEqual(readmitted.returncode, 0)
            self.assertIn("if it was drained or in quarantine, that has ended", readmitted.stderr)
            refused = farm.client("workers", "drain")
            self.assertEqual(refused.returncode, 2)
            self.assertIn("needs the name of a worker", refused.stderr)

    def test_limits_are_refused_with_their_flag(self):
        with Farm("--max-user-jobs", "1", "--max-pixels", "10000") as farm:
            farm.submit(SCENE, *QUICK)
            for options, flag in ((QUICK, "--max-user-jobs"), (LONG, "--max-pixels")):
                refused = farm.client("submit", SCENE, *options)
                self.assertEqual((refused.returncode, refused.stderr.count("\n")), (2, 1))
                self.assertIn(flag, refused.stderr)

    def test_a_limit_of_pixels_above_what_a_picture_may_have_is_refused(self):
        result = subprocess.run([BIN / "parray-coordinator", "--max-pixels", str(2**26 + 1)], capture_output=True, text=True,
                                check=False)
        self.assertEqual((result.returncode, result.stderr.count("\n")), (2, 1))
        self.assertIn("--max-pixels: Value 67108865 not in range", result.stderr)

    @again_with_longer_jobs
    def test_a_job_can_be_audited_and_replayed_and_shows_its_times(self):
        with Farm() as farm:
            for name in ("ann", "bob"):
                farm.start_worker(name)
            wait_for(lambda: len(farm.workers()) == 2, "two workers")
            job = farm.submit(SCENE, *self.long())
            sha = farm.finish(job)["image_sha256"]
            audit = farm.client("audit", job, "--json")
            self.assertEqual(audit.returncode, 0, audit.stderr)
            facts = json.loads(audit.stdout)
            self.assertTrue(facts["complete"])
            self.assertEqual(facts["image_sha256"], sha)
            names = {w["name"] for w in facts["workers"]}
            if len(names) < 2:  # the other did not run meanwhile
                raise JobOverTooEarly(f"{names} did all")
            self.assertEqual(names, {"ann", "bob"})
            self.assertIn("each once", farm.client("audit", job).stdout)
            self.assertRegex(farm.client("show", job).stdout, r"2 workers: \d+ % tracing")
            replayed = json.loads(farm.client("replay", job, "--json").stdout)
            weighted = {r["workers_times"]: r["seconds"] for r in replayed
                        if r["schedule"] == "weighted"}
            self.assertAlmostEqual(weighted[1] / weighted[2], 2, delta=0.4)
            self.assertEqual(farm.client("audit", 99).returncode, 2)

    def test_an_audit_without_a_journal_says_what_to_do(self):
        with Farm() as farm:
            job = farm.submit(SCENE, *QUICK)
            for action, remedy in ((None, "wait for its first result"), ("pause", f"parray resume {job}"),
                                   ("cancel", f"it is cancelled: parray requeue {job} continues it")):
                if action:
                    self.assertEqual(farm.client(action, job).returncode, 0)
                refused = farm.client("audit", job)
                self.assertEqual((refused.returncode, refused.stderr.count("\n")), (2, 1), refused.stderr)
                self.assertIn(f"job {job} has no journal: ", refused.stderr)
                self.assertIn(remedy, refused.stderr)

    def test_the_command_of_on_end_gets_the_state_of_the_job(self):
        with Farm() as farm:
            farm.start_worker("w1")
            told = farm.directory / "told"
            picture = farm.directory / "a.png"
            tell = f'echo "$PARRAY_JOB $PARRAY_STATE $PARRAY_IMAGE" >> {told}'
            done = farm.client("submit", SCENE, *QUICK, "--wait", "-o", picture, "--on-end", tell)
            self.assertEqual(done.returncode, 0, done.stderr)
            job = farm.submit(SCENE, *ENDLESS)
            watching = farm.start_client("watch", job, "--on-end", tell)
            wait_for(lambda: farm.job(job)["progress"] > 0, "some progress")
            farm.client("cancel", job)
            self.assertEqual(watching.wait(timeout=60), 1)
            self.assertEqual(told.read_text(), f"1 done {picture}\n2 cancelled \n")
            failing = run("render", SCENE, *QUICK, "-o", picture, "--on-end", "exit 3")
            self.assertEqual(failing.returncode, 0)
            self.assertIn("--on-end", failing.stderr)


if __name__ == "__main__":
    unittest.main()
