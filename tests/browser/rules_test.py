#!/usr/bin/env python3
"""fake_rules.py says what a real coordinator does: for each user, each state of a job that a small farm reaches, and each
request. So the tests of the page against the fake farm prove something about a real one."""

import copy
import json
import os
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "integration"))
if "PARRAY_BIN_DIR" not in os.environ or "PARRAY_SOURCE_DIR" not in os.environ:
    print("skipped: PARRAY_BIN_DIR and PARRAY_SOURCE_DIR name no programs")
    sys.exit(77)

import fake_rules
from farm import run, wait_for
from scarce_memory_test import start_limited, write_atoms
from web import SCENE, Web

FILES = ("report", "frames.zip", *fake_rules.PICTURES)
LONG = {**SCENE, "image": {"width": 1200, "height": 800}, "render": {"samples_per_pixel": 100000}}
SMALL = {"width": 48, "height": 36, "spp": 4}
TRAJECTORY = "".join(f"2\nframe {i}\nO 0 0 0\nO {1 + i / 4} 0 0\n" for i in range(3))
ANY = ("any", "")


class KeyFarm:
    """A farm with keys: ann, whose jobs all are, bob, and an administrator. Without keys: anybody."""

    def __init__(self, keys):
        self.directory = tempfile.TemporaryDirectory()
        folder = pathlib.Path(self.directory.name)
        self.users = {ANY: {}}
        more = ()
        if keys:
            for options in ((), ("--name", "ann"), ("--name", "bob")):
                assert run("keygen", folder / "keys", *options).returncode == 0
            head = lambda name: {"Authorization": "Bearer " + run("keygen", folder / "keys", "--token", name).stdout.strip()}
            self.users = {("client", "bob"): head("bob"), ("client", "ann"): head("ann"), ("admin", "admin"): head("admin")}
            self.worker_key = folder / "keys" / "worker.key"
            more = ("--keys", folder / "keys")
        self.owner = self.users.get(("client", "ann"), {})
        self.web = Web("--state", folder / "state", *more)

    def __enter__(self):
        self.web.__enter__()
        return self

    def __exit__(self, *error):
        self.web.__exit__(*error)
        self.directory.cleanup()

    def start_worker(self):
        return self.web._start("parray-worker", "--connect", self.web.address, "--threads", "1", "--name", "one", "--keys", self.worker_key)

    def get(self, path):
        return self.web.get(path, **self.owner).json()

    def ask(self, number, word, head):
        """Sends the request of a word about a job."""
        path = f"/api/v1/jobs/{number}"
        if word == "forget":
            return self.web.ask("DELETE", path, headers=head)
        if word == "priority":
            return self.web.ask("PUT", path + "/priority", json.dumps({"priority": 70}), {**head, "Content-Type": "application/json"})
        return self.web.ask("POST", f"{path}/{word}", headers=head)

    def must(self, number, *words):
        for word in words:
            answer = self.ask(number, word, self.owner)
            assert answer.status in (200, 204), answer.body
        return number

    def job(self, scene=SCENE):
        return self.web.submitted(self.web.post_scene(scene, **self.owner))

    def series(self):
        form = ("f", "run.xyz", TRAJECTORY), ("options", None, json.dumps({**SMALL, "frames": "0:2", "name": "apart"}))
        return self.web.submitted(self.web.post_form(*form, **self.owner))

    def frame(self, series, index=0):
        return self.get(f"/jobs/{series}")["frame_list"][index]["job"]

    def reach(self, number, state):
        wait_for(lambda: self.get(f"/jobs/{number}")["state"] == state, state)
        return number

    def jobs_around(self, number):
        """The maps of a job, of its series and of all its frames."""
        job = self.get(f"/jobs/{number}")
        jobs = {number: job}
        series = job["series"] if "frame" in job else number if "frames" in job else None
        if series is not None:
            jobs[series] = self.get(f"/jobs/{series}")
            jobs.update({entry["job"]: self.get(f"/jobs/{entry['job']}") for entry in jobs[series]["frame_list"]})
        return jobs


class Rules(unittest.TestCase):
    moving = False  # a worker traces, so queued jobs soon run, and running ones end

    def compare_requests(self, farm, make):
        """`make()`: returns the number of a fresh job in the state to be tested."""
        number = make()
        for user, head in farm.users.items():
            for word in fake_rules.JOB_WORDS:
                with self.subTest(user=user, word=word):
                    jobs = farm.jobs_around(number)
                    expected = fake_rules.job_refusal(jobs, number, word, user)
                    answer = farm.ask(number, word, head)
                    if expected:
                        self.assertEqual((answer.status, answer.json()["detail"].split(":")[0]), (expected[0], expected[1].split(":")[0]))
                        continue
                    self.assertIn(answer.status, (200, 204), answer.body)
                    self.compare_effect(farm, jobs, number, word)
                    number = make()

    def compare_effect(self, farm, jobs, number, word):
        said = copy.deepcopy(jobs)
        fake_rules.change_job(said, number, word, 70)
        for one in jobs:
            answer = farm.web.get(f"/jobs/{one}", **farm.owner)
            self.assertEqual(answer.status, 200 if one in said else 404, f"job {one} after {word} of {number}")
            if one not in said:
                continue
            shown = answer.json()
            also = ("queued", "running", "finishing", "done") if self.moving and fake_rules.unfinished(said[one]) and said[one]["state"] != "paused" else ()
            self.assertIn(shown["state"], (said[one]["state"], *also), f"job {one} after {word} of {number}")
            if word == "priority":
                self.assertEqual(shown["priority"], said[one]["priority"])
            if "frames" in shown and not also:
                self.assertEqual(bool(shown["waits_for"].startswith(said[one]["waits_for"])), True)
                self.assertEqual(shown["reason"].split(":")[0].split(" by ")[0], said[one]["reason"].split(":")[0].split(" by ")[0])

    def compare_files(self, farm, number):
        jobs = farm.jobs_around(number)
        for file in FILES:
            with self.subTest(file=file):
                refusal = fake_rules.file_refusal(jobs, number, file)
                answer = farm.web.get(f"/jobs/{number}/{file}", **farm.owner)
                self.assertEqual(answer.status, refusal[0] if refusal else 200, answer.body[:200])

    def compare(self, farm, states):
        for name, make in states.items():
            with self.subTest(state=name):
                self.compare_files(farm, make())
                self.compare_requests(farm, make)

    def test_what_has_not_begun_is_refused_and_changed_as_by_a_real_coordinator(self):
        with KeyFarm(keys=True) as farm:
            mixed = lambda: self.with_frame(farm, "pause")
            self.compare(farm, {
                "queued": farm.job, "paused": lambda: farm.must(farm.job(), "pause"), "cancelled": lambda: farm.must(farm.job(), "cancel"),
                "queued series": farm.series, "paused series": lambda: farm.must(farm.series(), "pause"),
                "cancelled series": lambda: farm.must(farm.series(), "cancel"),
                "series with a paused frame": mixed, "series with a cancelled frame": lambda: self.with_frame(farm, "cancel"),
                "frame of a queued series": lambda: farm.frame(farm.series()), "paused frame": lambda: farm.frame(mixed()),
                "cancelled frame of a queued series": lambda: farm.frame(self.with_frame(farm, "cancel")),
                "frame of a cancelled series": lambda: farm.frame(farm.must(farm.series(), "cancel"))})

    def with_frame(self, farm, word):
        """A series whose first frame was changed."""
        series = farm.series()
        farm.must(farm.frame(series), word)
        return series

    def test_what_has_begun_or_is_done_is_refused_and_changed_as_by_a_real_coordinator(self):
        self.moving = True
        with KeyFarm(keys=True) as farm:
            farm.start_worker()
            done = lambda: farm.reach(farm.series(), "done")

            def with_a_hole():
                series = done()
                farm.must(farm.frame(series, 1), "forget")
                return series

            self.compare(farm, {
                "done": lambda: farm.reach(farm.job(), "done"), "done series": done, "frame of a done series": lambda: farm.frame(done()),
                "series with a missing frame": with_a_hole, "frame of a series with a missing frame": lambda: farm.frame(with_a_hole())})

            def running():
                for job in farm.get("/jobs?state=queued,running,paused")["jobs"]:
                    farm.ask(job["id"], "cancel", farm.owner)  # refused for a series that waits for its missing frame
                job = farm.reach(farm.job(LONG), "running")
                wait_for(lambda: farm.get(f"/jobs/{job}")["has_picture"], "samples")
                return job

            self.compare(farm, {"running": running, "paused": lambda: farm.must(running(), "pause"), "cancelled": lambda: farm.must(running(), "cancel")})
            self.compare_workers(farm)

    def compare_workers(self, farm):
        """A drained host keeps its workers drained until the host is resumed."""
        worker = lambda: farm.get("/workers/one")
        drained_hosts = set()
        state = lambda: {"draining": "drained", "backoff": "ready"}.get(worker()["state"], worker()["state"])
        for word, host in (("drain", False), ("readmit", False), ("drain", True), ("readmit", False), ("readmit", True)):
            for user, head in farm.users.items():
                with self.subTest(word=word, host=host, user=user):
                    known = {"one": {**worker(), "leases": 0}}
                    name = worker()["host"] if host else "one"
                    refusal = fake_rules.worker_refusal(user)
                    answer = farm.web.ask("POST", f"/api/v1/workers/{name}/{word}{'?host=true' if host else ''}", headers=head)
                    self.assertEqual(answer.status, refusal[0] if refusal else 200, answer.body)
                    if refusal:
                        self.assertEqual(answer.json()["detail"], refusal[1])
                        continue
                    found = fake_rules.steer_workers(known, drained_hosts, name, word, host)
                    self.assertEqual([one["name"] for one in answer.json()["workers"]], [one["name"] for one in found])
                    self.assertEqual(state(), known["one"]["state"])

    @unittest.skipIf(os.environ.get("PARRAY_SANITIZED"), "sanitizers reserve more address space than the worker has")
    def test_a_failed_job_is_refused_and_changed_as_by_a_real_coordinator_without_keys(self):
        self.moving = True
        with KeyFarm(keys=False) as farm:
            atoms = farm.web.directory / "atoms.xyz"
            write_atoms(atoms, 400_000)
            start_limited(farm.web, "poor")
            wait_for(lambda: len(farm.web.workers()) == 1, "a worker")
            self.compare(farm, {"failed": lambda: farm.reach(farm.web.submit(atoms, "--width", "60", "--height", "40", "--spp", "4"), "failed")})


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v", *sys.argv[1:]])
