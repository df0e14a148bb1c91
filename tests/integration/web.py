"""A farm with HTTP, as real processes, and requests to it, for tests."""

import http.client
import json
import os
import re
import socket
import threading
import unittest

from farm import Farm, wait_for

SCENE = {"spheres": [{"center": [0, 0, 0], "radius": 1, "material": "red"}],
         "materials": {"red": {"type": "diffuse", "albedo": [0.7, 0.2, 0.1]}},
         "version": 1,
         "camera": {"look_from": [0, 0, 5], "look_at": [0, 0, 0], "vfov": 40},
         "image": {"width": 60, "height": 40},
         "render": {"samples_per_pixel": 4}}
WATER = "3\nwater\nO 0 0 0\nH 0.96 0 0\nH -0.24 0.93 0\n"


class Answer:
    def __init__(self, response):
        self.status = response.status
        self.headers = response.headers
        self.body = response.read()

    def json(self):
        return json.loads(self.body)


class Web(Farm):
    """A farm with HTTP."""

    def start_coordinator(self, bind=None):
        self.options = tuple(self.options)
        if "--http" not in self.options:
            self.options += ("--http", "127.0.0.1:0")
        outside = os.environ.get("TMPDIR")
        os.environ["TMPDIR"] = str(self.directory)  # what a killed coordinator leaves goes with the farm
        super().start_coordinator(bind)
        if outside is None:
            del os.environ["TMPDIR"]
        else:
            os.environ["TMPDIR"] = outside
        found = wait_for(lambda: re.search(r"HTTP is served at http://([\w.:\[\]]+)", self.coordinator_log()),
                         "the HTTP address")
        self.web = found.group(1)

    def ask(self, method, path, body=None, headers=None, timeout=60):
        connection = http.client.HTTPConnection(self.web, timeout=timeout)
        try:
            connection.request(method, path, body, headers or {})
            return Answer(connection.getresponse())
        finally:
            connection.close()

    def get(self, path, **headers):
        return self.ask("GET", "/api/v1" + path, headers=headers)

    def post_scene(self, scene=SCENE, **headers):
        return self.ask("POST", "/api/v1/jobs", json.dumps(scene),
                        {"Content-Type": "application/json", **headers})

    def post_form(self, *parts, **headers):
        """Parts: (name, file name or None, contents)."""
        body, kind = form(*parts)
        return self.ask("POST", "/api/v1/jobs", body, {"Content-Type": kind, **headers})

    def post_with(self, **options):
        """Submits the usual scene with these options."""
        return self.post_form(("scene", None, json.dumps(SCENE)), ("options", None, json.dumps(options)))

    def submitted(self, answer):
        assert answer.status == 201, answer.body
        return answer.json()["id"]

    def state(self, job):
        return self.get(f"/jobs/{job}").json()["state"]


def form(*parts):
    mark = "----a-mark-of-parts"
    body = b""
    for name, file, contents in parts:
        field = f'form-data; name="{name}"' + (f'; filename="{file}"' if file else "")
        contents = contents if isinstance(contents, bytes) else contents.encode()
        body += f"--{mark}\r\nContent-Disposition: {field}\r\n\r\n".encode() + contents + b"\r\n"
    return body + f"--{mark}--\r\n".encode(), f"multipart/form-data; boundary={mark}"


class WebCase(unittest.TestCase):
    def assert_problem(self, answer, status, detail=None):
        self.assertEqual(answer.status, status, answer.body)
        self.assertEqual(answer.headers["Content-Type"], "application/problem+json")
        problem = answer.json()
        self.assertEqual(problem["status"], status)
        self.assertTrue(problem["title"])
        if detail is not None:
            self.assertIn(detail, problem["detail"])
        self.assertNotIn("\n", problem["detail"])
        return problem["detail"]


class Listener:
    """Server-sent events, read by a thread."""

    def __init__(self, farm, path):
        self.connection = http.client.HTTPConnection(farm.web, timeout=60)
        self.connection.request("GET", path)
        self.response = self.connection.getresponse()
        self.events = []
        self.ended = False
        self.thread = threading.Thread(target=self._read, daemon=True)
        if self.response.status == 200:
            self.thread.start()

    def _read(self):
        name = None
        try:
            for line in self.response:
                line = line.decode().rstrip("\n")
                if line.startswith("event: "):
                    name = line.removeprefix("event: ")
                elif line.startswith("data: "):
                    self.events.append((name, json.loads(line.removeprefix("data: "))))
        except (OSError, http.client.HTTPException, ValueError, AttributeError):
            return
        self.ended = True

    def close(self):
        self.connection.sock and self.connection.sock.shutdown(socket.SHUT_RDWR)
        self.connection.close()
