#!/usr/bin/env python3
"""The batch scripts of deploy/slurm on a real Slurm of two nodes: preempted and requeued jobs continue, and the picture
is that of parray render."""

import json
import pathlib
import tempfile
import unittest

import slurm
from farm import SCENES, SOURCE, run, wait_for
from mpi import kept_bytes
from slurm import hosts

SCENE = SCENES / "one-weekend-484.json"
SETTINGS = ("--width", "240", "--height", "160", "--spp", "2500")  # some seconds for four threads
SMALL = ("--width", "60", "--height", "40", "--spp", "16")
ONE_NODE = ("--nodes=1", "--cpus-per-task=1")
ALL = ("--nodes=2", f"--cpus-per-task={slurm.CPUS}")
ENDED = ("COMPLETED", "FAILED", "CANCELLED", "TIMEOUT", "NODE_FAIL")


class Jobs(unittest.TestCase):
    def setUp(self):
        why = slurm.why_not()
        if why:
            self.skipTest(why)
        directory = tempfile.TemporaryDirectory(prefix="parray-slurm-")
        self.addCleanup(directory.cleanup)
        self.directory = pathlib.Path(directory.name)
        self.cluster = self.enterContext(slurm.Cluster(self.directory))
        self.jobs = 0
        self.scripts = SOURCE / "deploy" / "slurm"

    def submit(self, script, *arguments, slurm_options, env=None):
        """A job, whose log is `log`."""
        self.jobs += 1
        self.log = self.directory / f"job-{self.jobs}.log"
        self.log.touch()
        return self.cluster.submit(f"--output={self.log}", *slurm_options, self.scripts / script, *arguments, env=env)

    def preempt(self, *nodes):
        """A job of the better partition, which wants all of these nodes, comes and goes."""
        better = self.cluster.submit("--partition=high", "--output=/dev/null", f"--cpus-per-task={slurm.CPUS}",
                                     f"--nodes={len(nodes)}", f"--nodelist={','.join(nodes)}", "--wrap", "sleep 1")
        self.cluster.wait(better, *ENDED)
        self.assertEqual(self.cluster.state(better), "COMPLETED")

    def finish(self, job, restarts):
        self.cluster.wait(job, *ENDED)
        facts = self.cluster.job(job)
        self.assertEqual((facts["JobState"], facts["ExitCode"], facts["Restarts"]), ("COMPLETED", "0:0", str(restarts)),
                         self.log.read_text())

    def report(self, name="picture"):
        return json.loads((self.directory / f"{name}.json").read_text())

    def expected(self, settings):
        """The hash of the picture that one process renders."""
        done = run("render", SCENE, *settings, "-q", "-o", self.directory / "expected.exr", "--report",
                   self.directory / "expected.json", timeout=300)
        self.assertEqual(done.returncode, 0, done.stderr)
        return self.report("expected")["image_sha256"]

    def assert_lines(self, *texts):
        """The job's log has them in this order."""
        log = self.log.read_text()
        at = 0
        for text in texts:
            at = log.find(text, at)
            self.assertNotEqual(at, -1, f"{text!r} is missing, or comes too early:\n{log}")


class Mpi(Jobs):
    def render(self, *options):
        return self.submit("mpi.sbatch", SCENE, *SETTINGS, "-o", "picture.exr", "--report", "picture.json",
                           "--checkpoint", "1", *options, slurm_options=ALL)

    def wait_for_rows(self):
        wait_for(lambda: kept_bytes(self.directory / "picture.exr.state") > 200_000, "rows to be kept")

    def test_a_job_that_is_preempted_and_one_out_of_time_go_on_from_their_rows_to_the_same_picture(self):
        job = self.render()
        self.wait_for_rows()
        self.preempt(*slurm.NODES)
        self.cluster.wait(job, "RUNNING")
        wait_for(lambda: "continuing from" in self.log.read_text(), "the job to go on")
        self.cluster.command("scancel", "--batch", "--signal=USR1", job)  # as Slurm does before the time limit
        self.finish(job, restarts=2)
        self.assert_lines("DUE TO PREEMPTION", "continuing from", "DUE TO JOB REQUEUE", "continuing from",
                          "wrote picture.exr")
        report = self.report()
        self.assertEqual(report["image_sha256"], self.expected(SETTINGS))
        self.assertEqual(report["mpi"]["transport"], "window")
        self.assertEqual([(rank["host"], rank["threads"]) for rank in report["mpi"]["ranks"]],
                         [(name, slurm.CPUS) for name in slurm.NODES])
        self.assertFalse((self.directory / "picture.exr.state").exists())

    def test_srun_launches_ranks_as_mpirun_does_and_one_of_them_prints(self):
        command = ["srun", "--mpi=pmix", *ALL, "parray-mpi", "--quiet", SCENE, *SMALL]
        self.cluster.command(*command, "-o", "picture.exr", "--report", "picture.json")
        report = self.report()
        self.assertEqual(report["image_sha256"], self.expected(SMALL))
        self.assertEqual({rank["host"] for rank in report["mpi"]["ranks"]}, set(slurm.NODES))
        refused = self.cluster.run(*command)
        self.assertNotEqual(refused.returncode, 0)
        self.assertEqual(refused.stderr.count("parray-mpi: --output is required"), 1, refused.stderr)


class Farm(Jobs):
    def start(self, *arguments, idle=3, nodes=()):
        """The job and its log."""
        job = self.submit("farm.sbatch", "farm", *arguments, slurm_options=(*ONE_NODE, *nodes),
                          env={"PARRAY_IDLE": str(idle)})
        return job, self.log

    def address(self):
        file = self.directory / "farm" / "address"
        return wait_for(lambda: file.exists() and file.read_text().strip(), "the farm to open")

    def client(self, *arguments):
        key = self.directory / "farm" / "keys" / "admin.key"
        return self.cluster.command("parray", *arguments, env={"PARRAY_COORDINATOR": self.address(),
                                                               "PARRAY_KEYS": str(key)})

    def workers(self):
        return {worker["host"] for worker in json.loads(self.client("workers", "--json"))}

    def progress(self, picture):
        return json.loads(self.client("show", picture, "--json"))["progress"]

    def test_a_farm_hands_back_leases_goes_on_when_preempted_and_closes_when_idle(self):
        farm, log = self.start()
        picture = self.client("submit", SCENE, *SETTINGS).strip()
        joined, _ = self.start("join", nodes=["--nodelist=n2"])
        wait_for(lambda: self.workers() == set(slurm.NODES), "workers on both nodes")
        wait_for(lambda: self.progress(picture) > 0.1, "some progress")
        self.preempt("n2")  # the worker's node
        self.assertRegex(log.read_text(), r"worker 2 'n2-\d+' left \(worker stopped\); its [12] leases are free again")
        wait_for(lambda: self.cluster.job(joined)["Restarts"] == "1", "the worker to be requeued")
        self.preempt("n1")  # the coordinator's
        self.client("watch", picture)
        self.client("fetch", picture, "-o", "picture.exr", "--report", "picture.json")
        self.assertEqual(self.report()["image_sha256"], self.expected(SETTINGS))
        self.log = log
        self.finish(farm, restarts=1)
        self.assert_lines("DUE TO PREEMPTION", "resumed 1 unfinished jobs", "no work for 3 s: leaving")
        self.assertFalse((self.directory / "farm" / "address").exists())

    def test_a_worker_that_has_joined_follows_a_coordinator_that_was_requeued(self):
        farm, _ = self.start(idle=600)
        before = self.address()
        _, log = self.start("join", idle=25)
        wait_for(lambda: f"connected to {before}" in log.read_text(), "the worker")
        self.cluster.command("scontrol", "requeue", farm)
        wait_for(lambda: self.cluster.job(farm)["Restarts"] == "1", "the coordinator to be requeued")
        wait_for(lambda: self.address() != before, "the coordinator at another port")
        wait_for(lambda: f"connected to {self.address()}" in log.read_text(), "the worker to follow")

    def test_a_worker_that_joins_a_farm_without_coordinator_says_so_and_exits(self):
        (self.directory / "farm").mkdir()
        job, log = self.start("join")
        self.cluster.wait(job, "FAILED")
        self.assertIn("no coordinator in 3 s: there is no farm/address", log.read_text())


if __name__ == "__main__":
    hosts.enter()
    unittest.main()
