"""Messages that the HTTP interface sends by itself: streams of events and webhooks."""

import http.server
import json
import pathlib
import socket
import tempfile
import threading
import unittest

from farm import wait_for
from mpi import committed
from standby_test import Twins, run_coordinator
from web import SCENE, Listener, Web, WebCase


class Events(WebCase):
    def test_a_stream_reports_jobs_and_workers_until_the_end(self):
        with Web("--heartbeat", "0.2") as farm:  # a killed worker is missed after five
            listener = Listener(farm, "/api/v1/events")
            self.assertEqual(listener.response.headers["Content-Type"], "text/event-stream")
            farm.start_worker("one")
            job = farm.submitted(farm.post_scene())
            def seen(kind, **values):
                return any(event == kind and all(data.get(key) == value for key, value in values.items())
                           for event, data in listener.events)
            wait_for(lambda: seen("job", id=job, state="done"), "the job's end")
            wait_for(lambda: seen("worker", name="one"), "the worker")
            late = Listener(farm, "/api/v1/events")
            wait_for(lambda: any(event == "worker" for event, _ in late.events), "what there is")
            self.assertEqual(farm.ask("DELETE", f"/api/v1/jobs/{job}").status, 204)
            wait_for(lambda: seen("forgotten", id=job), "that it is forgotten")
            farm.processes[-1].kill()
            wait_for(lambda: seen("gone", name="one"), "that the worker is gone")
            listener.close()
            late.close()

    def test_the_stream_of_a_job_ends_with_it(self):
        with Web() as farm:
            job = farm.submitted(farm.post_scene())
            listener = Listener(farm, f"/api/v1/jobs/{job}/events")
            wait_for(lambda: listener.events, "its state")
            self.assertEqual(listener.events[0][1]["state"], "queued")
            farm.start_worker("one")
            wait_for(lambda: listener.ended, "the end")
            self.assertEqual(listener.events[-1][1]["state"], "done")
            self.assert_problem(farm.get("/jobs/99/events"), 404)

    def test_streams_are_bounded_and_requests_are_served_beside_them(self):
        with Web("--http-streams", "3") as farm:
            listeners = [Listener(farm, "/api/v1/events") for _ in range(3)]
            self.assert_problem(farm.get("/events"), 503, "--http-streams")
            self.assertEqual(farm.get("/jobs").status, 200)
            listeners.pop().close()
            def again():
                listener = Listener(farm, "/api/v1/events")
                if listener.response.status == 200:
                    listeners.append(listener)
                    return True
                listener.connection.close()
                return False
            wait_for(again, "room for another")
            for listener in listeners:
                listener.close()


class Hook(http.server.BaseHTTPRequestHandler):
    """Notes the webhooks that it gets in its server's `told`. The first fails."""

    def do_POST(self):
        self.server.told.append((self.headers["Host"], json.loads(self.rfile.read(int(self.headers["Content-Length"])))))
        self.send_response(500 if len(self.server.told) == 1 else 204)
        self.end_headers()

    def log_message(self, *_):
        pass


class HookServer(http.server.ThreadingHTTPServer):
    def __init__(self, address):
        self.told = []
        self.address_family = socket.AF_INET6 if ":" in address else socket.AF_INET
        super().__init__((address, 0), Hook)
        threading.Thread(target=self.serve_forever, daemon=True).start()


class WebTwins(Web, Twins):
    pass


class Webhook(WebCase):
    def test_the_notice_of_a_jobs_end_is_repeated_after_failures_and_a_restart(self):
        server = HookServer("127.0.0.1")
        url = f"http://127.0.0.1:{server.server_port}/hook"
        with tempfile.TemporaryDirectory() as state, Web("--state", state, "--webhook-host", "127.0.0.1") as farm:
            scene = ("scene", None, json.dumps(SCENE))
            self.assert_problem(farm.post_form(scene, ("options", None, '{"webhook": "http://other/x"}')), 422, "--webhook-host other")
            self.assert_problem(farm.post_form(scene, ("options", None, '{"webhook": "file:///x"}')), 422, "is not a URL")
            job = farm.submitted(farm.post_form(scene, ("options", None, json.dumps({"webhook": url}))))
            farm.coordinator.terminate()
            farm.coordinator.wait()
            farm.start_coordinator()
            farm.start_worker("one")
            wait_for(lambda: len(server.told) >= 2, "both tries")
            host, told = server.told[1]
            self.assertEqual((host, told["event"]), (f"127.0.0.1:{server.server_port}", "job-ended"))
            self.assertEqual((told["job"]["id"], told["job"]["state"]), (job, "done"))
            kept = "SELECT text FROM notes WHERE name = 'webhooks'"
            wait_for(lambda: committed(pathlib.Path(state), kept) == "", "the note's end")
        server.shutdown()

    def test_a_standby_that_takes_over_sends_the_notices_of_its_primary(self):
        server = HookServer("127.0.0.1")
        with WebTwins("--webhook-host", "127.0.0.1", "--http", "127.0.0.1:0") as farm:
            farm.wait_until_in_step()
            job = farm.submitted(farm.post_with(webhook=f"http://127.0.0.1:{server.server_port}/hook"))
            farm.kill_the_first()
            farm.address = farm.second
            farm.start_worker("one")
            wait_for(lambda: server.told, "the notice")
            self.assertEqual(server.told[0][1]["job"]["id"], job)
        server.shutdown()

    def test_a_coordinator_sends_the_notices_of_its_restored_backup(self):
        server = HookServer("127.0.0.1")
        with tempfile.TemporaryDirectory() as folder:
            state, copy = pathlib.Path(folder, "state"), pathlib.Path(folder, "copy")
            with Web("--state", state, "--webhook-host", "127.0.0.1") as farm:
                job = farm.submitted(farm.post_with(webhook=f"http://127.0.0.1:{server.server_port}/hook"))
                made = run_coordinator("--backup", state, copy)
                self.assertEqual(made.returncode, 0, made.stderr)
            with Web("--state", copy, "--webhook-host", "127.0.0.1") as farm:
                farm.start_worker("one")
                wait_for(lambda: server.told, "the notice")
                self.assertEqual(server.told[0][1]["job"]["id"], job)
        server.shutdown()

    def test_a_webhook_may_address_a_permitted_ipv6_address(self):
        try:
            server = HookServer("::1")
        except OSError:
            self.skipTest("this machine has no IPv6")
        authority = f"[::1]:{server.server_port}"
        with Web("--webhook-host", "::1") as farm:
            self.assert_problem(farm.post_with(webhook="http://[::2]/x"), 422, "--webhook-host ::2")
            job = farm.submitted(farm.post_with(webhook=f"http://{authority}/hook"))
            farm.ask("POST", f"/api/v1/jobs/{job}/cancel")
            wait_for(lambda: server.told, "the notice")
            self.assertEqual((server.told[0][0], server.told[0][1]["job"]["id"]), (authority, job))
        server.shutdown()


if __name__ == "__main__":
    unittest.main()
