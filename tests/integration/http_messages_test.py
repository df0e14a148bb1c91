"""The form of requests and answers on the wire (RFC 9112): chunks, lengths, versions, targets, hosts."""

import http.client
import json
import socket
import tempfile
import unittest

from farm import run
from web import SCENE, Web

POST = b"POST /api/v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
CHUNKED = POST + b"Transfer-Encoding: chunked\r\n\r\n"
LAST = b"GET /nothing HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n"
BODY = json.dumps(SCENE).encode()
SIZE = b"%x" % len(BODY)


def connect(farm, timeout=60):
    host, port = farm.web.split(":")
    return socket.create_connection((host, int(port)), timeout=timeout)


def answers(farm, request, ends=False, timeout=60):
    """(status, body) of each answer until the server closes the connection. `ends`: the client sends no more."""
    with connect(farm, timeout) as connection:
        connection.sendall(request)
        if ends:
            connection.shutdown(socket.SHUT_WR)
        received = b""
        while part := connection.recv(1 << 16):
            received += part
    found = []
    while received:
        head, _, received = received.partition(b"\r\n\r\n")
        fields = dict(line.lower().split(b": ", 1) for line in head.split(b"\r\n")[1:])
        length = int(fields[b"content-length"])
        found.append((int(head.split()[1]), received[:length]))
        received = received[length:]
    return found


def statuses(*arguments, **options):
    return [status for status, _ in answers(*arguments, **options)]


class Chunks(unittest.TestCase):
    def test_chunks_extensions_and_trailers_end_where_the_next_request_begins(self):
        half = len(BODY) // 2
        bodies = {"one chunk": SIZE + b"\r\n" + BODY + b"\r\n0\r\n\r\n",
                  "two chunks": b"%X\r\n%s\r\n%x\r\n%s\r\n0\r\n\r\n" % (half, BODY[:half], len(BODY) - half, BODY[half:]),
                  "leading zeros": SIZE.rjust(16, b"0") + b"\r\n" + BODY + b"\r\n000\r\n\r\n",
                  "an extension": SIZE + b";a=b\r\n" + BODY + b"\r\n0;c\r\n\r\n",
                  "a trailer": SIZE + b"\r\n" + BODY + b"\r\n0\r\nX-Sum: 1\r\nHost: elsewhere\r\n\r\n",
                  "blanks behind the scene": SIZE + b"\r\n" + BODY + b"\r\n9000\r\n" + b" " * 0x9000 + b"\r\n0\r\nA: b\r\n\r\n"}
        with Web() as farm:
            for what, body in bodies.items():
                self.assertEqual(statuses(farm, CHUNKED + body + LAST), [201, 404], what)

    def test_a_damaged_chunk_is_refused_and_what_follows_is_no_request(self):
        rest = b"\r\n" + BODY + b"\r\n0\r\n\r\n"
        bodies = [prefix + SIZE + rest for prefix in (b"+", b"-", b" ", b"\t", b"0x", b"g", b"0" * 16, b"f" * 16, b"\x00")]
        bodies += [SIZE + suffix + rest for suffix in (b" ", b"\t", b" ;a", b"g", b"\n", b"\r", b";" + b"a" * 2000)]
        bodies += [rest, SIZE + b"\n" + BODY + b"\n0\n\n",
                   b"1" + SIZE + b"\r\n" + BODY + b"\r\n0\r\n\r\n", SIZE + b"\r\n" + BODY + b"x\r\n0\r\n\r\n",
                   SIZE + b"\r\n" + BODY + b"\r\n0\r\nGET /healthz HTTP/1.1\r\n\r\n",
                   SIZE + b"\r\n" + BODY + b"\r\n0\r\nA : b\r\n\r\n", SIZE + b"\r\n" + BODY + b"\r\n0\r\n" + b"A: b\r\n" * 2000 + b"\r\n"]
        with Web() as farm:
            for body in bodies:
                self.assertEqual(statuses(farm, CHUNKED + body + LAST, ends=True), [400], body[:40])
            self.assertEqual(farm.get("/jobs").json()["jobs"], [])


class Lengths(unittest.TestCase):
    def test_a_body_that_ends_before_its_length_is_400(self):
        with Web() as farm:
            for request in (POST + b"Content-Length: 2000\r\n\r\n{", POST + b"Content-Length: 200000\r\n\r\n{",
                            CHUNKED + b"100\r\n{", CHUNKED + b"9000\r\n" + b" " * 20000):
                (status, body), = answers(farm, request, ends=True)
                self.assertEqual(status, 400)
                self.assertIn(b"ended early", body)

    def test_a_length_above_the_limit_is_413_before_any_of_the_body_comes(self):
        put = b"PUT /api/v1/jobs/1/priority HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
        with Web() as farm:
            for head, limit in ((POST + b"Content-Length: 99999999999\r\n\r\n", b"--http-body"),
                                (POST + b"Expect: 100-continue\r\nContent-Length: 99999999999\r\n\r\n", b"--http-body"),
                                (put + b"Content-Length: 4097\r\n\r\n", b"4096 bytes"),
                                (put + b"Content-Length: 100000\r\n\r\n", b"4096 bytes")):
                with connect(farm) as connection:
                    connection.settimeout(8)  # less than the server waits for a body
                    connection.sendall(head)
                    answer = http.client.HTTPResponse(connection)
                    answer.begin()
                    self.assertEqual(answer.status, 413, head)
                    self.assertIn(limit, answer.read())

    def test_a_client_that_waits_for_100_continue_gets_it(self):
        with Web() as farm:
            for size in len(BODY), 100_000:
                with connect(farm) as connection:
                    connection.sendall(POST + b"Expect: 100-continue\r\nConnection: close\r\nContent-Length: %d\r\n\r\n" % size)
                    self.assertEqual(connection.recv(1 << 16), b"HTTP/1.1 100 Continue\r\n\r\n")
                    connection.sendall(BODY.ljust(size))
                    self.assertTrue(connection.recv(1 << 16).startswith(b"HTTP/1.1 201 "), size)


class Versions(unittest.TestCase):
    def test_probes_of_http_1_0_need_no_host(self):
        with Web() as farm:
            for path in b"/healthz", b"/readyz":
                self.assertEqual(answers(farm, b"GET " + path + b" HTTP/1.0\r\n\r\n"), [(200, b"ok\n")])
            self.assertEqual(statuses(farm, b"GET /api/v1/jobs HTTP/1.0\r\n\r\n"), [421])

    def test_events_go_to_http_1_0_without_chunks_until_the_connection_ends(self):
        with Web() as farm:
            job = farm.submitted(farm.post_scene())
            farm.ask("POST", f"/api/v1/jobs/{job}/cancel")
            with connect(farm) as connection:
                connection.sendall(f"GET /api/v1/jobs/{job}/events HTTP/1.0\r\nHost: localhost\r\n\r\n".encode())
                received = b""
                while part := connection.recv(1 << 16):
                    received += part
            head, _, body = received.partition(b"\r\n\r\n")
            self.assertIn(b"Connection: close", head)
            for field in b"Transfer-Encoding", b"Content-Length", b"Keep-Alive":
                self.assertNotIn(field, head)
            self.assertTrue(body.startswith(b"event: job\ndata: {"), body)
            self.assertTrue(body.endswith(b"}\n\n"), body)


class Heads(unittest.TestCase):
    def test_a_target_may_name_its_host(self):
        get = lambda target, host=b"localhost": b"GET " + target + b" HTTP/1.1\r\nHost: " + host + b"\r\nConnection: close\r\n\r\n"
        with Web() as farm:
            for path in b"/healthz", b"/api/v1/jobs?limit=1":
                self.assertEqual(statuses(farm, get(b"http://localhost" + path)), [200])
                self.assertEqual(statuses(farm, get(b"HTTP://127.0.0.1:80" + path, b"elsewhere")), [200])
                self.assertEqual(statuses(farm, get(b"http://elsewhere" + path)), [421])
            self.assertEqual(statuses(farm, get(b"http://localhost")), [200])
            for target in b"http:///healthz", b"http://user@localhost/healthz":
                self.assertEqual(statuses(farm, get(target)), [400])

    def test_two_hosts_are_refused(self):
        with Web() as farm:
            for second in b"localhost", b"elsewhere":
                head = b"GET /healthz HTTP/1.1\r\nHost: localhost\r\nhost: " + second + b"\r\n\r\n"
                self.assertEqual(statuses(farm, head), [400])

    def test_the_scheme_of_a_token_is_case_insensitive(self):
        with tempfile.TemporaryDirectory() as directory:
            keys = f"{directory}/keys"
            self.assertEqual(run("keygen", keys).returncode, 0)
            self.assertEqual(run("keygen", keys, "--name", "ann").returncode, 0)
            token = run("keygen", keys, "--token", "ann").stdout.strip()
            with Web("--keys", keys) as farm:
                for scheme in "Bearer", "bearer", "BEARER", "bearer ":
                    self.assertEqual(farm.get("/jobs", Authorization=f"{scheme} {token}").status, 200, scheme)
                for field in token, f"Basic {token}", f"bearer{token}", "bearer ":
                    self.assertEqual(farm.get("/jobs", Authorization=field).status, 401, field)


if __name__ == "__main__":
    unittest.main()
