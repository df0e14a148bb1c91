#!/usr/bin/env python3
"""Real processes over ZeroMQ: whichever workers render, and whatever dies, the picture has the bits of `parray
render`."""

import json
import os
import pathlib
import re
import signal
import socket
import subprocess
import tempfile
import time
import unittest

from farm import BIN, SCENES, SOURCE, Farm, run, wait_for
from longer_jobs import JobOverTooEarly, LongerJobs, again_with_longer_jobs
from mpi import committed_bytes, kept_bytes

SCENE = SCENES / "one-weekend-20.json"


def size(spp):
    return ["--width", "160", "--height", "100", "--spp", str(spp)]


SIZE = size(150)
LONG_SPP = 700  # more than a second of a core
LONG = size(LONG_SPP)  # long enough to be interrupted
ENDLESS = size(1000000)


def render_report(scene, *options):
    with tempfile.TemporaryDirectory() as directory:
        result = run("render", scene, "-o", f"{directory}/a.png", "--report", f"{directory}/a.json",
                     *options)
        assert result.returncode == 0, result.stderr
        with open(f"{directory}/a.json") as file:
            return json.load(file)


class FarmCase(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.expected = render_report(SCENE, *SIZE, "--threads", 1)["image_sha256"]


class Deaths(LongerJobs, FarmCase):
    @classmethod
    def take_jobs(cls):
        cls.long = size(cls.longer * LONG_SPP)
        cls.expected_long = render_report(SCENE, *cls.long)

    @again_with_longer_jobs
    def test_a_worker_killed_in_mid_job_changes_nothing(self):
        with Farm("--heartbeat", "0.1") as farm:
            victim = farm.start_worker("victim")
            farm.start_worker("survivor")
            wait_for(lambda: len(farm.workers()) == 2, "two workers")
            job = farm.submit(SCENE, *self.long)
            wait_for(lambda: farm.job(job)["progress"] > 0.1, "some progress")
            victim.send_signal(signal.SIGKILL)
            victim.wait()
            if farm.job(job)["progress"] == 1:
                raise JobOverTooEarly("the workers were faster than the test")
            report = farm.finish(job)
            self.assertEqual(report["image_sha256"], self.expected_long["image_sha256"])
            self.assertEqual(report["samples"], self.expected_long["samples"])
            wait_for(lambda: "'victim' left (silent for too long)" in farm.coordinator_log(), "the loss to be noticed")

    @again_with_longer_jobs
    def test_a_worker_stopped_beyond_its_deadline_and_continued_later_changes_nothing(self):
        with Farm("--heartbeat", "0.1", "--lease-timeout", "1") as farm:
            sleeper = farm.start_worker("sleeper")
            wait_for(lambda: len(farm.workers()) == 1, "the sleeper")
            # Static: the whole picture is one lease, so that it is certainly held when stopped.
            job = farm.submit(SCENE, *self.long, "--schedule", "static")
            wait_for(lambda: "lease 1 to worker" in farm.coordinator_log(), "the lease")
            sleeper.send_signal(signal.SIGSTOP)
            wait_for(lambda: "'sleeper' left" in farm.coordinator_log(), "the loss to be noticed")
            if "lease 1 accepted" in farm.coordinator_log():
                raise JobOverTooEarly("the sleeper was faster than the test")
            farm.start_worker("successor")
            wait_for(lambda: re.search("lease 2 to worker . 'successor'", farm.coordinator_log()),
                     "the lease to go to another")
            sleeper.send_signal(signal.SIGCONT)
            wait_for(lambda: len(farm.workers()) == 2, "the sleeper to be back")
            report = farm.finish(job)
            # Lease 1 is dead: the sleeper was told so, or, had it finished just then, refused.
            self.assertNotRegex(farm.coordinator_log(), "lease 1 accepted")
            self.assertRegex(farm.coordinator_log(), "lease [0-9]+ accepted")
            self.assertEqual(report["image_sha256"], self.expected_long["image_sha256"])
            self.assertEqual(report["samples"], self.expected_long["samples"])

    @again_with_longer_jobs
    def test_a_coordinator_killed_in_mid_job_goes_on_where_it_was(self):
        with tempfile.TemporaryDirectory() as state, Farm("--state", state, "--heartbeat",
                                                          "0.1") as farm:
            farm.start_worker("w1")
            farm.start_worker("w2")
            job = farm.submit(SCENE, *self.long)
            # What is merged shows as progress; what is committed, too, is acknowledged.
            wait_for(lambda: farm.job(job)["progress"] > 0.2, "some progress")
            kept = wait_for(lambda: committed_bytes(pathlib.Path(state)), "rows to be kept")
            farm.coordinator.send_signal(signal.SIGKILL)
            farm.coordinator.wait()
            left = committed_bytes(pathlib.Path(state)), kept_bytes(pathlib.Path(state))
            farm.start_coordinator(farm.address)
            # What is kept is read when a worker is there.
            if wait_for(lambda: farm.job(job)["progress"], "the job to be taken up") == 1:
                raise JobOverTooEarly("the workers were faster than the test, or than the disk")
            self.assertGreaterEqual(left[0], kept, "acknowledged rows were lost")
            self.assertGreaterEqual(left[1], kept, "their file was cut")
            report = farm.finish(job)
            expected = self.expected_long
            self.assertEqual(report["image_sha256"], expected["image_sha256"])
            self.assertEqual(report["samples"], expected["samples"])
            self.assertEqual(report["rays"], expected["rays"])
            # And once more, now that it is done: the picture is kept.
            farm.coordinator.send_signal(signal.SIGKILL)
            farm.coordinator.wait()
            farm.start_coordinator(farm.address)
            self.assertEqual(farm.fetch(job)["image_sha256"], expected["image_sha256"])

    def test_a_paused_job_is_shown_alike_before_and_after_a_restart_of_the_coordinator(self):
        with tempfile.TemporaryDirectory() as state, Farm("--state", state, "--heartbeat", "0.1") as farm:
            farm.start_worker("w1")
            job = farm.submit(SCENE, *ENDLESS, "--target-error", "0.000001")
            wait_for(lambda: farm.job(job).get("error"), "the first pass")
            farm.client("pause", job)
            wait_for(lambda: not any(worker["leases"] for worker in farm.workers()), "the last leases to end")
            figures = lambda: {key: farm.job(job)[key] for key in ("error", "samples_taken")}
            progress = lambda: farm.job(job)["progress"]
            before = figures(), progress()
            self.assertIsNotNone(before[0]["error"]["low"])
            farm.coordinator.send_signal(signal.SIGTERM)
            self.assertEqual(farm.coordinator.wait(timeout=60), 0)
            farm.start_coordinator(farm.address)
            self.assertEqual(figures(), before[0])
            self.assertAlmostEqual(progress(), before[1], places=4)

    def test_a_picture_in_passes_has_one_hash_on_any_farm(self):
        expected = render_report(SCENE, *size(20), "--target-error", "0.006")
        self.assertEqual(expected["stopped_by"], "samples")  # --spp 20 comes first
        options = ["--width", "160", "--height", "100", "--target-error", "0.006"]
        expected = render_report(SCENE, *options)
        self.assertEqual(expected["stopped_by"], "error")
        self.assertLessEqual(expected["error"]["rmse"], 0.006)
        self.assertGreater(len(expected["passes"]), 2)
        with tempfile.TemporaryDirectory() as state, Farm("--state", state, "--heartbeat",
                                                          "0.1") as farm:
            for count in (1, 2):
                farm.start_worker(f"w{count}")
                wait_for(lambda: len(farm.workers()) == count, "the worker")
                report = farm.finish(farm.submit(SCENE, *options))
                self.assertEqual(report["image_sha256"], expected["image_sha256"])
                self.assertEqual(report["error"], expected["error"])
                self.assertEqual(report["passes"], expected["passes"])
            # A coordinator that is killed in a later pass goes on with it.
            harder = ["--width", "160", "--height", "100", "--target-error", "0.0015"]
            job = farm.submit(SCENE, *harder)
            wait_for(lambda: re.search(rf"job {job} lease .* pass [1-9]",
                                       farm.coordinator_log()), "a later pass")
            farm.coordinator.send_signal(signal.SIGKILL)
            farm.coordinator.wait()
            farm.start_coordinator(farm.address)
            report = farm.finish(job)
            self.assertEqual(report["image_sha256"],
                             render_report(SCENE, *harder)["image_sha256"])


class Service(FarmCase):
    def test_one_two_and_three_workers_give_the_bits_of_render(self):
        with Farm() as farm:
            for count in (1, 2, 3):
                farm.start_worker(f"w{count}")
                wait_for(lambda: len(farm.workers()) == count, "the worker")
                report = farm.finish(farm.submit(SCENE, *SIZE))
                self.assertEqual(report["image_sha256"], self.expected)
                self.assertEqual(report["samples"], 160 * 100 * 150)
            for spp in (600, 2400, 9600):
                if report["workers"] < 3:  # the others were done before its first result
                    report = farm.finish(farm.submit(SCENE, *size(spp)))
            self.assertEqual(report["workers"], 3)

    def test_a_time_limit_is_kept_and_its_passes_repeat_the_picture(self):
        size = ["--width", "160", "--height", "100"]
        limited = render_report(SCENE, *size, "--time-limit", "0.4")
        self.assertEqual(limited["stopped_by"], "time")
        self.assertGreater(limited["samples"], 0)  # how many a second brings is the machine's affair
        passes = ",".join(map(str, limited["passes"]))
        again = render_report(SCENE, *size, "--passes", passes, "--threads", "1")
        self.assertEqual(again["image_sha256"], limited["image_sha256"])
        self.assertEqual(again["stopped_by"], "passes")

    def test_a_finished_job_is_listed_with_the_samples_of_its_picture_and_not_with_its_limit(self):
        with Farm() as farm:
            farm.start_worker("w1")
            job = farm.submit(SCENE, *size(100000), "--time-limit", "0.5")
            farm.finish(job)
            taken = farm.job(job)["samples_taken"]
            self.assertLess(taken, 100000)
            mean = f"{taken:.3g}" if taken < 999.5 else f"{taken:.0f}"
            self.assertIn(f" pixels, {mean} samples each (", farm.client("show", job).stdout)
            self.assertIn(f"  160 x 100  {mean}  ", farm.client("jobs").stdout)

    def test_several_jobs_are_changed_listed_by_name_and_sorted_with_one_command(self):
        with Farm() as farm:
            jobs = [farm.submit(SCENE, *ENDLESS, "--priority", priority) for priority in ("10", "90", "50")]
            listed = json.loads(farm.client("jobs", "--name", SCENE.stem[:3].upper(), "--sort", "priority", "--json").stdout)
            self.assertEqual([job["id"] for job in listed], [jobs[0], jobs[2], jobs[1]])
            self.assertEqual(json.loads(farm.client("jobs", "--name", "no such name", "--json").stdout), [])
            top = farm.client("jobs", "--sort", "priority", "--order", "desc", "--limit", 2, "--json")
            self.assertEqual([job["id"] for job in json.loads(top.stdout)], [jobs[1], jobs[2]])
            self.assertEqual(top.stderr, "parray: the first 2 of 3 jobs\n")
            for option, value in (("--sort", "colour"), ("--order", "up"), ("--limit", 0)):
                self.assertEqual(farm.client("jobs", option, value).returncode, 2)
            raised = farm.client("priority", jobs[0], jobs[1], 70)
            self.assertEqual(raised.stdout, f"job {jobs[0]}: priority 70\njob {jobs[1]}: priority 70\n")
            self.assertEqual(farm.client("cancel", jobs[2]).returncode, 0)
            cancelled = farm.client("cancel", *jobs, 999)
            self.assertEqual(cancelled.returncode, 2)
            self.assertEqual(cancelled.stdout, f"job {jobs[0]}: cancelled\njob {jobs[1]}: cancelled\n")
            self.assertIn(f"job {jobs[2]} is cancelled: only unfinished jobs can be cancelled", cancelled.stderr)
            self.assertIn("no job 999", cancelled.stderr)
            again = farm.client("cancel", jobs[0])
            self.assertEqual((again.returncode, again.stdout), (2, ""))
            self.assertEqual(farm.client("forget", *jobs).stdout, "".join(f"job {job}: deleted\n" for job in jobs))

    def test_a_preview_shows_the_picture_before_it_is_done(self):
        with Farm() as farm:
            preview = farm.directory / "preview.png"
            farm.start_worker("w1")
            job = farm.submit(SCENE, *ENDLESS)
            watch = farm.start_client("watch", job, "--preview", preview)
            wait_for(preview.exists, "the preview of a job that somebody else has begun")
            farm.client("cancel", job)
            self.assertEqual(watch.wait(60), 1)
            first = preview.read_bytes()
            picture = farm.directory / "picture.exr"
            submit = farm.start_client("submit", SCENE, *ENDLESS, "--wait", "-o", picture,
                                       "--preview", preview)
            wait_for(lambda: preview.read_bytes() != first and preview.stat().st_size > 10000,  # noise everywhere
                     "the preview of a progressive job")
            farm.client("cancel", job + 1)
            self.assertEqual(submit.wait(60), 1)
            self.assertFalse(picture.exists())

    def test_what_a_preview_ends_with_is_the_picture(self):
        with Farm() as farm:
            farm.start_worker("w1")
            picture, preview = farm.directory / "picture.png", farm.directory / "preview.png"
            for command in (["submit", SCENE, *size(4), "--wait"], ["render", SCENE, *size(4)],
                            ["render", SCENE, *size(4), "--denoise"],
                            ["render", SCENE, *size(400), "--target-error", "0.1"]):
                result = farm.client(*command, "-o", picture, "--preview", preview)
                self.assertEqual(result.returncode, 0, result.stderr)
                self.assertEqual(preview.read_bytes(), picture.read_bytes())
                preview.unlink()
            job = farm.submit(SCENE, *size(4))
            self.assertEqual(farm.client("watch", job, "--preview", preview).returncode, 0)
            farm.client("fetch", job, "-o", picture)
            self.assertEqual(preview.read_bytes(), picture.read_bytes())

    def test_two_coordinators_cannot_share_a_state(self):
        with tempfile.TemporaryDirectory() as state, Farm("--state", state):
            second = Farm("--state", state)
            try:
                with self.assertRaisesRegex(AssertionError, "another process uses"):
                    second.start_coordinator()
            finally:
                second.close()

    def test_several_jobs_run_one_after_another_by_priority(self):
        with Farm() as farm:
            first = farm.submit(SCENE, *SIZE)
            low = farm.submit(SCENE, *SIZE, "--seed", "2", "--priority", "10")
            high = farm.submit(SCENE, *SIZE, "--seed", "3", "--priority", "90")
            farm.start_worker("w1", threads=2)
            reports = [farm.finish(job) for job in (first, low, high)]
            log = farm.coordinator_log()
            done = [int(number) for number in re.findall(r"job (\d+) '[^']*' is done", log)]
            self.assertEqual(done, [high, first, low])
            self.assertEqual(reports[0]["image_sha256"], self.expected)
            self.assertEqual(len({r["image_sha256"] for r in reports}), 3)
            # One worker: the scene has travelled once, although three jobs use it.
            self.assertEqual(len(re.findall("scene .* for worker", log)), 1)

    def test_a_cancelled_job_stops_its_workers_and_cannot_be_fetched(self):
        with Farm("--heartbeat", "0.1") as farm:
            farm.start_worker("w1")
            job = farm.submit(SCENE, *ENDLESS)
            wait_for(lambda: farm.job(job)["state"] == "running", "the job to run")
            self.assertEqual(farm.client("cancel", job).returncode, 0)
            self.assertEqual(farm.job(job)["state"], "cancelled")
            self.assertEqual(farm.client("watch", job).returncode, 1)
            fetched = farm.client("fetch", job, "-o", farm.directory / "no.png")
            self.assertEqual(fetched.returncode, 2)
            self.assertFalse((farm.directory / "no.png").exists())
            # The worker is free for the next job at once.
            report = farm.finish(farm.submit(SCENE, *SIZE))
            self.assertEqual(report["image_sha256"], self.expected)

    def test_garbage_on_the_port_disturbs_nobody(self):
        with Farm() as farm:
            port = int(farm.address.rsplit(":", 1)[1])
            for size in (1, 64, 100000):
                with socket.create_connection(("127.0.0.1", port)) as connection:
                    connection.sendall(os.urandom(size))
            farm.start_worker("w1", threads=2)
            report = farm.finish(farm.submit(SCENE, *SIZE))
            self.assertEqual(report["image_sha256"], self.expected)

    def test_daemons_stop_cleanly_on_a_signal(self):
        with Farm() as farm:
            worker = farm.start_worker("w1")
            wait_for(lambda: len(farm.workers()) == 1, "the worker")
            farm.submit(SCENE, *ENDLESS)
            worker.send_signal(signal.SIGTERM)
            self.assertEqual(worker.wait(timeout=60), 0)
            wait_for(lambda: not farm.workers(), "the goodbye to arrive")
            farm.coordinator.send_signal(signal.SIGINT)
            self.assertEqual(farm.coordinator.wait(timeout=60), 0)

    def test_a_name_with_control_characters_stays_in_one_line_of_the_worker_s_log(self):
        with Farm() as farm:
            worker = farm.start_worker("a\x1b[31mb\nINJECT")
            wait_for(lambda: len(farm.workers()) == 1, "the worker")
            log = worker.log.read_text()
            self.assertIn(r"worker 'a\x1b[31mb\x0aINJECT', 1 threads", log)
            self.assertNotIn("\x1b", log)
            for line in log.splitlines():
                self.assertRegex(line, r"\A\[\d{4}-\d\d-\d\d \d\d:\d\d:\d\d\.\d{3}\] \[worker\] \[info\] ")

    def test_beyond_loopback_is_refused_without_keys(self):
        for address in ("tcp://0.0.0.0:7400", "tcp://*:7400", "tcp://127.example.org:7400"):
            result = subprocess.run([BIN / "parray-coordinator", "--bind", address],
                                    capture_output=True, text=True, timeout=60)
            self.assertEqual(result.returncode, 2, address)
            self.assertIn("refused", result.stderr)

    def test_an_address_without_a_port_from_1_to_65535_is_refused_before_anything_is_served(self):
        standby = ["--state", "/nonexistent/state"]
        http = ["--coordinator", "tcp://127.0.0.1:*", "--http"]
        for program, options, free in ((["parray-coordinator"], ["--coordinator"], True),
                                       (["parray-coordinator"], [*standby, "--standby"], True),
                                       (["parray-coordinator"], [*standby, "--replicate-to"], False),
                                       (["parray-worker"], ["--coordinator"], False),
                                       (["parray", "jobs"], ["--coordinator"], False)):
            for port in ("99999", "-1", "75x", "0", "99999999999", "+7400", "", *([] if free else ["*"])):
                address = f"tcp://127.0.0.1:{port}"
                with self.subTest(program=program, options=options, port=port):
                    result = subprocess.run([BIN / program[0], *program[1:], *options, address], capture_output=True,
                                            text=True, timeout=60)
                    self.assertEqual((result.returncode, result.stdout), (2, ""), result.stderr)
                    self.assertRegex(result.stderr, r"\A[^\n]*the port must be a number from 1 to 65535[^\n]*\n\Z")
                    self.assertIn(address, result.stderr)
        for address in ("127.0.0.1:99999", "127.0.0.1"):
            result = subprocess.run([BIN / "parray-coordinator", *http, address], capture_output=True, text=True, timeout=60)
            self.assertEqual((result.returncode, result.stdout), (2, ""))
            self.assertRegex(result.stderr, r"\A[^\n]*is not an address to serve[^\n]*\n\Z")

    def test_the_seed_format_and_v1_of_one_scene_give_one_picture(self):
        seed = json.loads((SOURCE / "tests/integration/seed-scene.json").read_text())
        kinds = {"lambertian": "diffuse", "metal": "metal", "dielectric": "dielectric"}
        v1 = {"version": 1,
              "camera": {"look_from": [13, 2, 3], "look_at": [0, 0, 0], "vfov": 20,
                         "aperture": 0.1, "focus_distance": 10},
              "materials": {}, "spheres": []}
        for number, entry in enumerate(seed["spheres"]):
            sphere = entry["sphere"]
            material = sphere["material"]
            new = {"type": kinds[material["type"]]}
            if "color" in material:
                new["albedo"] = [material["color"][c] for c in "rgb"]
            if "fuzz" in material:
                new["fuzz"] = material["fuzz"]
            if "refraction_index" in material:
                new["ior"] = material["refraction_index"]
            v1["materials"][f"m{number}"] = new
            v1["spheres"].append({"center": [sphere["location"][a] for a in "xyz"],
                                  "radius": sphere["radius"], "material": f"m{number}"})
        with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
            json.dump(v1, file)
            file.flush()
            options = ["--width", "90", "--height", "60", "--spp", "8"]
            a = render_report(SOURCE / "tests/integration/seed-scene.json", *options)
            b = render_report(file.name, *options)
        self.assertEqual(a["image_sha256"], b["image_sha256"])
        self.assertEqual(a["scene_sha256"], b["scene_sha256"])


if __name__ == "__main__":
    unittest.main(verbosity=2)
