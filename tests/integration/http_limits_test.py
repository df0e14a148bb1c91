"""Limits of what strangers can take of the coordinator's HTTP interface: connections, memory, time, turns."""

import bz2
import ctypes
import gzip
import hashlib
import http.client
import json
import lzma
import os
import pathlib
import socket
import subprocess
import tempfile
import threading
import time
import unittest

from farm import BIN, run, wait_for
from web import SCENE, WATER, Web


def connect(farm):
    host, port = farm.web.split(":")
    return socket.create_connection((host, int(port)), timeout=60)


def is_closed(connection):
    """Whether the other side has closed it; what it has sent is thrown away."""
    connection.setblocking(False)
    try:
        while connection.recv(65536):
            pass
        return True
    except BlockingIOError:
        return False
    except OSError:
        return True


HEAD = b"GET / HTTP/1.1\r\nHost: localhost\r\nX: "
BODY = (b"POST /api/v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
        b"Content-Length: 100000\r\n\r\n{")


class SlowConnections:
    """They send a byte of a request now and then."""

    def __init__(self, farm, count, begin=HEAD):
        self.connections = [connect(farm) for _ in range(count)]
        self.ended = False
        for connection in self.connections:
            connection.sendall(begin)
        self.thread = threading.Thread(target=self._send, daemon=True)
        self.thread.start()

    def _send(self):
        while not self.ended:
            for connection in self.connections:
                try:
                    connection.send(b"x")
                except OSError:
                    pass
            time.sleep(0.5)

    def open(self):
        return [connection for connection in self.connections if not is_closed(connection)]

    def close(self):
        self.ended = True
        self.thread.join()
        for connection in self.connections:
            connection.close()


def make_keys(directory):
    """The directory of a farm's keys, and what ann and bob send to be known."""
    keys = pathlib.Path(directory) / "keys"
    made = [run("keygen", keys)]
    heads = []
    for name in ("ann", "bob"):
        made.append(run("keygen", keys, "--name", name))
        heads.append({"Authorization": "Bearer " + run("keygen", keys, "--token", name).stdout.strip()})
    assert all(result.returncode == 0 for result in made), made
    return keys, *heads


class Connections(unittest.TestCase):
    def test_200_slow_connections_delay_no_answer_and_are_ended(self):
        with Web() as farm:
            slow = SlowConnections(farm, 200)
            bodies = SlowConnections(farm, 10, BODY)
            for path in ("/healthz", "/readyz", "/api/v1/jobs", "/metrics"):
                self.assertEqual(farm.ask("GET", path, timeout=8).status, 200, path)
            self.assertEqual(len(slow.open()), 200)
            self.assertEqual(farm.post_scene().status, 201)
            for connections in (slow, bodies):
                wait_for(lambda: not connections.open(), "the end of slow connections")
                connections.close()

    def test_it_stops_while_200_slow_connections_are_open(self):
        with Web() as farm:
            slow = SlowConnections(farm, 200)
            farm.coordinator.terminate()
            self.assertEqual(farm.coordinator.wait(timeout=30), 0, farm.coordinator_log())
            slow.close()

    def test_silent_connections_make_room_for_new_ones(self):
        with Web("--http-connections-per-address", "8") as farm:
            silent = [connect(farm) for _ in range(20)]
            self.assertEqual(farm.ask("GET", "/api/v1/jobs").status, 200)
            wait_for(lambda: sum(is_closed(connection) for connection in silent) >= 12, "the end of the oldest")
            for connection in silent:
                connection.close()

    def test_beyond_the_most_connections_health_is_still_answered(self):
        with Web("--http-connections-per-address", "3") as farm:
            streams = []
            for _ in range(3):
                streams.append(http.client.HTTPConnection(farm.web, timeout=60))
                streams[-1].request("GET", "/api/v1/events")
                self.assertEqual(streams[-1].getresponse().status, 200)
            refused = farm.ask("GET", "/api/v1/jobs")
            self.assertEqual(refused.status, 503)
            self.assertIn("--http-connections-per-address", refused.json()["detail"])
            self.assertTrue(refused.headers["Retry-After"])
            self.assertEqual(farm.ask("GET", "/healthz").status, 200)
            self.assertEqual(farm.ask("GET", "/readyz").status, 200)
            for stream in streams:
                stream.close()

    def test_health_is_answered_while_all_seats_are_taken_and_80_connections_a_second_come(self):
        with Web("--http-connections-per-address", "20") as farm:
            streams = [connect(farm) for _ in range(20)]
            for stream in streams:
                stream.sendall(b"GET /api/v1/events HTTP/1.1\r\nHost: localhost\r\n\r\n")
                self.assertIn(b"200 OK", stream.recv(100))
            for request in b"", b"GET /api/v1/jobs HTTP/1.1\r\nHost: localhost\r\n\r\n":
                crowd = []  # of clients that never close their connections
                for _ in range(160):
                    crowd.append(connect(farm))
                    crowd[-1].sendall(request)
                    if len(crowd) % 8 == 0:
                        self.assertEqual(farm.ask("GET", "/healthz", timeout=8).status, 200, request)
                    time.sleep(1 / 80)
                for connection in crowd:
                    connection.close()
            for stream in streams:
                stream.close()

    def slow_bodies(self, farm, token=b""):
        """200 bodies that come slowly, of each kind."""
        put = b"PUT /api/v1/jobs/1/priority HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n" + token
        post = b"POST /api/v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n" + token
        chunked = b"Transfer-Encoding: chunked\r\n\r\n"
        kinds = (post + b"Content-Length: 100000\r\n\r\n", post + chunked + b"9000\r\n" + b" " * 20000,
                 post + b"Expect: 100-continue\r\nContent-Length: 2000\r\n\r\n", put + chunked + b"9000\r\n",
                 put + b"Expect: 100-continue\r\n" + chunked)
        return [SlowConnections(farm, 40, kind) for kind in kinds]

    def test_200_slow_bodies_delay_no_scene_of_others(self):
        large = json.dumps(SCENE) + " " * 100_000
        with tempfile.TemporaryDirectory() as directory:
            keys, ann, bob = make_keys(directory)
            with Web("--keys", keys) as farm:
                bodies = self.slow_bodies(farm, f"Authorization: {ann['Authorization']}\r\n".encode())
                for body in json.dumps(SCENE), large, iter([large.encode()]):
                    answer = farm.ask("POST", "/api/v1/jobs", body,
                                      {"Content-Type": "application/json", **bob}, timeout=8)
                    self.assertEqual(answer.status, 201, answer.body)
                for slow in bodies:
                    slow.close()

    def test_200_slow_bodies_delay_no_small_scene_of_the_same_address(self):
        with Web() as farm:
            bodies = self.slow_bodies(farm)
            self.assertEqual(farm.ask("POST", "/api/v1/jobs", json.dumps(SCENE), {"Content-Type": "application/json"},
                                      timeout=8).status, 201)
            for slow in bodies:
                slow.close()


class Heads(unittest.TestCase):
    def sent_before_the_end(self, farm, begin, part, most=64 << 20):
        """How many bytes of an endless request are taken."""
        with connect(farm) as connection:
            connection.sendall(begin)
            block = part * ((1 << 16) // len(part))
            sent = 0
            try:
                while sent < most:
                    connection.sendall(block)
                    sent += len(block)
            except OSError:
                pass
            return sent

    def test_endless_requests_are_ended(self):
        head = b"POST /api/v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
        endless = {"a request line": (b"GET /", b"a"),
                   "a field": (b"GET / HTTP/1.1\r\nX: ", b"a"),
                   "fields": (b"GET / HTTP/1.1\r\n", b"a: b\r\n"),
                   "empty lines": (b"", b"\r\n"),
                   "a chunk's size": (head + b"Transfer-Encoding: chunked\r\n\r\n1;", b"a")}
        with Web() as farm:
            for what, (begin, part) in endless.items():
                self.assertLess(self.sent_before_the_end(farm, begin, part), 64 << 20, what)

    def test_a_long_head_is_refused_with_a_reason(self):
        with Web() as farm:
            with connect(farm) as connection:
                connection.sendall(b"GET / HTTP/1.1\r\n" + b"a: b\r\n" * 12000)
                answer = http.client.HTTPResponse(connection)
                answer.begin()
                self.assertEqual(answer.status, 431)
                self.assertIn(b"65536 bytes", answer.read())

    def test_an_ambiguous_head_is_refused(self):
        post = b"POST /api/v1/jobs HTTP/1.1\r\nHost: localhost\r\n"
        heads = {post + b"Content-Length: 2\r\nContent-Length: 3\r\n\r\n{}": 400,
                 post + b"Content-Length: 2\r\nTransfer-Encoding: chunked\r\n\r\n{}": 400,
                 post + b"Content-Length : 2\r\n\r\n{}": 400,
                 post + b"Content-Length: +2\r\n\r\n{}": 400,
                 post + b"Transfer-Encoding: gzip, chunked\r\n\r\n": 501,
                 b"GET / HTTP/1.1\r\nHost: localhost\r\nX: a\n b\r\n\r\n": 400,
                 b"GET /\x00 HTTP/1.1\r\nHost: localhost\r\n\r\n": 400,
                 b"GET / HTTP/2.0\r\n\r\n": 505}
        with Web() as farm:
            for head, status in heads.items():
                with connect(farm) as connection:
                    connection.sendall(head)
                    answer = http.client.HTTPResponse(connection)
                    answer.begin()
                    self.assertEqual(answer.status, status, head)
                    self.assertEqual(answer.getheader("Content-Type"), "application/problem+json")

    def test_requests_that_come_together_are_answered_in_turn(self):
        with Web() as farm, connect(farm) as connection:
            ask = lambda path: f"GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n".encode()
            connection.sendall(ask("/healthz") + ask("/api/v1/jobs") + ask("/healthz") + ask("/nothing"))
            statuses = []
            for _ in range(4):
                answer = http.client.HTTPResponse(connection)
                answer.fp = connection.makefile("rb", buffering=0)  # nothing of the next one is read
                answer.begin()
                statuses.append(answer.status)
                answer.fp.read(int(answer.getheader("Content-Length")))
            self.assertEqual(statuses, [200, 200, 200, 404])


class Repeats(unittest.TestCase):
    def test_a_repeated_idempotency_key_with_other_content_is_refused(self):
        with tempfile.TemporaryDirectory() as state, Web("--state", state) as farm:
            key = {"Idempotency-Key": "once"}
            parts = lambda spp: (("scene", None, json.dumps(SCENE)), ("options", None, json.dumps({"spp": spp})))
            job = farm.submitted(farm.post_form(*parts(5), **key))
            for _ in range(2):
                self.assertEqual(farm.submitted(farm.post_form(*parts(5), **key)), job)
                for other in (farm.post_form(*parts(6), **key), farm.post_scene(**key)):
                    self.assertEqual(other.status, 422, other.body)
                    self.assertIn(f"job {job} was submitted with this Idempotency-Key", other.json()["detail"])
                farm.coordinator.terminate()  # and the next one knows it, too
                farm.coordinator.wait()
                farm.start_coordinator()
            self.assertEqual(len(farm.get("/jobs").json()["jobs"]), 1)


@unittest.skipIf(os.environ.get("PARRAY_SANITIZED"), "reading takes minutes")
class Turns(unittest.TestCase):
    def test_pictures_do_not_wait_for_scenes_nor_small_scenes_for_large_ones_of_others(self):
        block = "".join(f"H {i} {i % 1000} {i % 77}\n" for i in range(10_000)).encode()
        large = gzip.compress(b"9000000\nmany\n" + 900 * block, 1)  # takes all the time that there is
        self.assertTrue(any(self.asked_in_time(large, seconds) for seconds in (1, 3, 9, 24)))

    def asked_in_time(self, large, seconds):
        """Returns whether the answers that must not wait came while the large scenes were still being read."""
        with tempfile.TemporaryDirectory() as directory:
            keys, ann, bob = make_keys(directory)
            with Web("--keys", keys, "--http-scene-seconds", str(seconds)) as farm:
                farm._start("parray-worker", "--connect", farm.address, "--threads", 1, "--keys", keys / "worker.key")
                job = farm.submitted(farm.post_scene(**bob))
                wait_for(lambda: farm.get(f"/jobs/{job}", **bob).json()["state"] == "done", "the picture")
                ended = []

                def upload():
                    ended.append(farm.post_form(("file", "large.xyz.gz", large), **ann))

                uploads = [threading.Thread(target=upload) for _ in range(3)]
                for thread in uploads:
                    thread.start()
                reads = lambda: list(farm.directory.glob("parray-http-*/request-*/parts.messages"))
                wait_for(lambda: len(reads()) == 2 or ended, "two readers")
                self.assertEqual(farm.get(f"/jobs/{job}/image.png", **bob).status, 200)
                self.assertEqual(farm.post_scene(**bob).status, 201)
                in_time = not ended
                for thread in uploads:
                    thread.join()
                stopped = [answer.json()["detail"] for answer in ended if answer.status == 422]
                self.assertNotEqual(stopped, [])
                for detail in stopped:
                    self.assertRegex(detail, f"took more than ({seconds} seconds of processor time|{2 * seconds} seconds), "
                                             ".* --http-scene-seconds")
                return in_time


@unittest.skipIf(os.environ.get("PARRAY_SANITIZED"), "sanitizers keep what is freed")
class Memory(unittest.TestCase):
    PICTURE = 1024 * 1024 * 12

    def resident(self, farm):
        status = pathlib.Path(f"/proc/{farm.coordinator.pid}/status").read_text()
        return int(next(line for line in status.splitlines() if line.startswith("VmRSS")).split()[1]) << 10

    def ask_and_wait(self, farm, path):
        """A connection whose answer has begun, and of which nobody reads the rest."""
        connection = connect(farm)
        connection.sendall(f"GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n".encode())
        self.assertIn(b"200 OK", connection.recv(100))
        return connection

    def test_clients_that_do_not_read_take_no_memory(self):
        scene = {**SCENE, "image": {"width": 1024, "height": 1024}, "render": {"samples_per_pixel": 1}}
        with tempfile.TemporaryDirectory() as state, Web("--state", state) as farm:
            farm.start_worker("one", threads=2)
            jobs = [farm.submitted(farm.post_scene(scene)) for _ in range(4)]
            for job in jobs:
                wait_for(lambda: farm.state(job) == "done", "the picture")
            farm.coordinator.terminate()  # the next one has not rendered anything yet
            farm.coordinator.wait()
            farm.start_coordinator()
            files = lambda: len(os.listdir(f"/proc/{farm.coordinator.pid}/fd"))
            idle, before = files(), self.resident(farm)
            readers = [self.ask_and_wait(farm, f"/api/v1/jobs/{job}/pixels.f32") for job in jobs for _ in range(5)]
            self.assertLess(self.resident(farm) - before, 3.5 * self.PICTURE)
            whole = farm.get(f"/jobs/{jobs[0]}/pixels.f32").body  # beside them
            self.assertEqual(hashlib.sha256(whole).hexdigest(),
                             farm.get(f"/jobs/{jobs[0]}/report").json()["image_sha256"])
            # The file of each picture stays open.
            wait_for(lambda: files() <= idle + len(jobs), "the end of readers who do not read")
            for reader in readers:
                reader.close()

    def test_an_answer_that_is_read_slowly_arrives_completely(self):
        with Web() as farm:
            farm.start_worker("one", threads=2)
            job = farm.submitted(farm.post_scene({**SCENE, "image": {"width": 900, "height": 700}}))
            wait_for(lambda: farm.state(job) == "done", "the picture")
            digest = farm.get(f"/jobs/{job}/report").json()["image_sha256"]
            host, port = farm.web.split(":")
            with socket.socket() as connection:
                connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 16)
                connection.connect((host, int(port)))
                connection.sendall(f"GET /api/v1/jobs/{job}/pixels.f32 HTTP/1.1\r\nHost: localhost\r\n\r\n".encode())
                answer = http.client.HTTPResponse(connection)
                answer.begin()
                body = b""
                while part := answer.read(100_000):
                    body += part
                    time.sleep(0.01)
                self.assertEqual(hashlib.sha256(body).hexdigest(), digest)


def kernel_knows_landlock():
    """landlock_create_ruleset(2), asked for its version."""
    return ctypes.CDLL(None).syscall(444, None, 0, 1) >= 1


@unittest.skipIf(os.environ.get("PARRAY_SANITIZED"), "sanitizers need what is refused")
@unittest.skipUnless(kernel_knows_landlock(), "this kernel knows no Landlock")
class Containment(unittest.TestCase):
    def child(self, directory, *arguments):
        return subprocess.run([BIN.parent / "lib/parray/parray-http-child", "--memory", str(2 << 30), "--seconds", "20",
                               *map(str, arguments)], cwd=directory, capture_output=True, text=True, timeout=60)

    def test_the_process_that_reads_scenes_opens_nothing_outside_its_directory(self):
        with tempfile.TemporaryDirectory() as request, tempfile.TemporaryDirectory() as outside:
            parts = pathlib.Path(request) / "parts"
            parts.mkdir()
            (parts / "own.json").write_text(json.dumps(SCENE))
            scene = pathlib.Path(outside) / "scene.json"
            scene.write_text(json.dumps(SCENE))
            (parts / "link.json").symlink_to(scene)
            self.assertEqual(self.child(parts, "submit", "own.json").returncode, 0)
            self.assertTrue((pathlib.Path(request) / "control-0").exists())
            self.assertEqual(self.child(parts, "submit", "link.json").returncode, 2)
            self.assertEqual(self.child(parts, "submit", scene).returncode, 2)

    def test_the_process_that_makes_pictures_opens_nothing_outside_its_directory(self):
        with tempfile.TemporaryDirectory() as request, tempfile.TemporaryDirectory() as outside:
            files = pathlib.Path(request) / "picture"
            files.mkdir()
            (pathlib.Path(outside) / "report").write_text("{}")
            (files / "report").symlink_to(pathlib.Path(outside) / "report")
            self.assertIn("reading report failed", self.child(files, "picture", "image.png", 1, 1).stderr)

    def test_the_confined_process_cannot_escape(self):
        with tempfile.TemporaryDirectory() as request, tempfile.TemporaryDirectory() as outside:
            files = pathlib.Path(request) / "files"
            files.mkdir()
            secret = pathlib.Path(outside) / "secret"
            secret.write_text("secret")
            tried = self.child(files, "confinement", secret)
            self.assertEqual((tried.returncode, tried.stderr), (0, ""))

    def test_packed_files_are_read_as_before(self):
        packers = {"gz": gzip.compress, "xz": lzma.compress, "bz2": bz2.compress}
        with Web() as farm:
            for name, pack in packers.items():
                answer = farm.post_form(("file", f"water.xyz.{name}", pack(WATER.encode())))
                self.assertEqual(answer.status, 201, answer.body)
            self.assertNotIn("does not fully confine", farm.coordinator_log())


if __name__ == "__main__":
    unittest.main()
