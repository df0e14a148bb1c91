#!/usr/bin/env python3
"""What an operator sees of a farm: the farm at a glance, its last hour, single workers and their logs, as HTTP and the
command line show them."""

import json
import os
import re
import signal
import socket
import time
import unittest

from farm import wait_for
from mpi import committed
from web import SCENE, Web, WebCase

LONG = {**SCENE, "render": {"samples_per_pixel": 4_000_000}}


class Glance(WebCase):
    def test_users_events_and_workers_that_left_are_shown(self):
        with Web() as farm:
            worker = farm.start_worker("one")
            job = farm.submitted(farm.post_scene())
            wait_for(lambda: farm.state(job) == "done", "the picture")
            worker.kill()
            shown = wait_for(lambda: (map_ := farm.get("/farm").json())["left"] and map_, "the loss")
            self.assertEqual(shown["left"][0]["name"], "one")
            self.assertTrue(shown["left"][0]["lost"])
            self.assertIn("silent", shown["left"][0]["reason"])
            self.assertEqual([event["kind"] for event in shown["events"]], ["lost", "job_done", "joined", "started"])
            self.assertEqual(shown["events"][1]["job"], job)
            self.assertLess(abs(shown["events"][0]["at"] - time.time()), 600)
            self.assertEqual(shown["seconds_left"], 0)
            (user,) = shown["users"]
            self.assertEqual((user["user"], user["done_jobs"], user["open_jobs"], user["share"]), ("", 1, 0, 1))
            self.assertGreater(user["thread_seconds"], 0)
            self.assertGreaterEqual(user["queue_seconds_mean"], 0)
            farm.start_worker("one")
            wait_for(lambda: farm.get("/farm").json()["left"] == [], "its return")

    def test_a_worker_that_stops_has_left_and_is_not_lost(self):
        with Web() as farm:
            worker = farm.start_worker("one")
            wait_for(lambda: farm.get("/workers").json()["total"] == 1, "the worker")
            worker.terminate()
            left = wait_for(lambda: farm.get("/farm").json()["left"], "its goodbye")
            self.assertEqual((left[0]["reason"], left[0]["lost"]), ("worker stopped", False))
            self.assert_problem(farm.get("/workers/one"), 404, "it left")

    def test_the_last_hour_has_lists_of_equal_length(self):
        with Web() as farm:
            farm.start_worker("one")
            farm.submitted(farm.post_scene(LONG))
            history = wait_for(lambda: (found := farm.get("/farm/history").json())["samples_per_second"]
                               and found["samples_per_second"][-1] > 0 and found, "ten seconds")
            self.assertEqual(history["interval"], 10)
            lengths = {len(history[key]) for key in ("samples_per_second", "busy_threads", "threads", "queued")}
            self.assertEqual(len(lengths), 1)
            self.assertEqual((history["busy_threads"][-1], history["threads"][-1]), (1, 1))
            self.assertLess(abs(history["end"] - time.time()), 600)

    def test_tracing_time_of_users_survives_a_restart(self):
        with Web() as first:
            state = first.directory / "state"
            with Web("--state", state) as farm:
                worker = farm.start_worker("one")
                job = farm.submitted(farm.post_scene())
                wait_for(lambda: farm.state(job) == "done", "the picture")
                had = farm.get("/farm").json()["users"][0]["thread_seconds"]
                long = farm.submitted(farm.post_scene(LONG))
                # Progress and tracing time are stored a few seconds after progress has changed.
                wait_for(lambda: farm.get(f"/jobs/{long}").json()["progress"] > 0, "some progress")
                worker.send_signal(signal.SIGSTOP)  # it needs no processor meanwhile
                stored = lambda: json.loads(committed(state, "SELECT text FROM notes WHERE name = 'users'") or "{}")
                wait_for(lambda: stored().get("", 0) >= 0.999 * had, "the tracing time to be stored")
                farm.coordinator.kill()
                farm.coordinator.wait()
                farm.start_coordinator(farm.address)
                self.assertGreaterEqual(farm.get("/farm").json()["users"][0]["thread_seconds"], 0.999 * had)


class Server(WebCase):
    def test_it_names_the_address_and_the_command_for_workers(self):
        with Web() as farm:
            server = farm.get("/server").json()
            self.assertEqual(server["worker_address"], farm.address)
            self.assertEqual(server["worker_command"], "parray-worker --coordinator " + farm.address)
            self.assertEqual((server["loopback"], server["keys"], server["webhooks"]), (True, False, False))

    def test_an_address_for_all_networks_is_shown_with_this_machines_name(self):
        with Web("--insecure", "--webhook-host", "example.org", bind="tcp://*:*") as farm:
            server = farm.get("/server").json()
            self.assertEqual(server["worker_address"],
                             f"tcp://{socket.gethostname()}:{farm.address.rsplit(':', 1)[1]}")
            self.assertEqual((server["loopback"], server["webhooks"]), (False, True))


class Workers(WebCase):
    def test_a_worker_tells_about_its_machine(self):
        with Web() as farm:
            farm.start_worker("one")
            job = farm.submitted(farm.post_scene(LONG))
            worker = wait_for(lambda: (found := farm.get("/workers/one").json()).get("tracing") and found,
                              "a worker at work")
            self.assertEqual(worker["tracing"]["job"], job)
            self.assertEqual(worker["version"], farm.get("/server").json()["version"])
            self.assertGreaterEqual(worker["processors"], 1)
            self.assertGreater(worker["memory_bytes"], 1e6)
            self.assertGreaterEqual(worker["load"], 0)
            self.assertEqual((worker["address"], worker["failures"], worker["recent_failures"]), ("127.0.0.1", 0, []))
            wait_for(lambda: farm.get("/workers/one").json()["contribution"] > 0, "its contribution")
            contribution = farm.get("/farm").json()["contribution"]
            self.assertGreater(contribution, 0)
            wait_for(lambda: re.search(rf"traces +job {job} for", farm.client("workers", "show", "one").stdout), "its job")
            self.assertEqual(json.loads(farm.client("workers", "show", "one", "--json").stdout)["name"], "one")
            self.assertIn("LAST MINUTE", farm.client("workers").stdout)

    def test_its_log_is_read_on_demand(self):
        with Web() as farm:
            farm.start_worker("one")
            def log_once_connected():
                found = farm.get("/workers/one/log").json().get("lines", [])
                return found if any("info: connected to" in line for line in found) else None
            lines = wait_for(log_once_connected, "its log with the line that it writes after it is connected")
            self.assertTrue(any("worker 'one', 1 threads" in line for line in lines), lines)
            self.assertEqual(farm.client("workers", "log", "one").stdout.splitlines()[0], lines[0])

    def test_a_stopped_worker_delays_only_the_request_for_its_log(self):
        with Web("--heartbeat", "10", "--lease-timeout", "60") as farm:  # it is silent, but not lost
            worker = farm.start_worker("one")
            wait_for(lambda: farm.get("/workers").json()["total"] == 1, "the worker")
            os.kill(worker.pid, signal.SIGSTOP)
            self.assert_problem(farm.get("/workers/one/log"), 502, "read its output on its machine")
            self.assertEqual(farm.get("/workers/one").status, 200)
            refused = farm.client("workers", "log", "one")
            self.assertEqual((refused.returncode, refused.stdout), (1, ""))
            self.assertIn("did not send its log", refused.stderr)

    def test_unknown_workers_are_named(self):
        with Web() as farm:
            for path in ("/workers/nobody", "/workers/nobody/log"):
                self.assert_problem(farm.get(path), 404, "no worker 'nobody' is connected")
            self.assert_problem(farm.get("/workers/" + "x" * 200), 404)
            refused = farm.client("workers", "show", "nobody")
            self.assertEqual(refused.returncode, 2)
            self.assertIn("no worker 'nobody'", refused.stderr)
            for usage in (("show",), ("log",), ("log", "one", "--host")):
                self.assertEqual(farm.client("workers", *usage).returncode, 2)


if __name__ == "__main__":
    unittest.main()
