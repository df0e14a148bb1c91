"""How a farm is spoken to, against a server that answers what a test tells it: tries, problems, tokens, forms."""

import asyncio
import email
import http.server
import itertools
import json
import re
import socket
import threading
import unittest.mock

from support import SCENE, SOURCE, Test, cloud, main, parray

JOB = {"id": 7, "name": "a", "user": "", "state": "running", "priority": 50, "progress": 0.5, "samples_per_second": 1e6,
       "seconds_left": 3, "reason": "", "waits_for": "", "flag": "", "width": 4, "height": 3, "samples_per_pixel": 9,
       "sampler": "sobol", "whole": True, "error": {"rmse": 0.2, "low": 0.1, "high": 0.3}}


class Server:
    """Answers a request by the next of `answers` for its method and path; the last goes on. Keeps what was asked."""

    def __init__(self):
        self.asked = []
        self.answers = {}
        server = self

        class Handler(http.server.BaseHTTPRequestHandler):
            def answer(self):
                body = self.rfile.read(int(self.headers.get("Content-Length", 0)))
                server.asked.append((f"{self.command} {self.path}", dict(self.headers), body))
                answers = server.answers[f"{self.command} {self.path}"]
                status, reply, *headers = answers.pop(0) if len(answers) > 1 else answers[0]
                if status == 0:  # the connection breaks
                    self.close_connection = True
                    return
                data = reply if isinstance(reply, bytes) else json.dumps(reply).encode()
                self.send_response(status)
                for name, value in headers:
                    self.send_header(name, value)
                self.send_header("Content-Length", str(len(data)))
                self.end_headers()
                self.wfile.write(data)

            do_GET = do_POST = do_PUT = do_DELETE = answer

            def log_message(self, *_):
                pass

        self._server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.url = f"http://127.0.0.1:{self._server.server_port}"
        self._thread = threading.Thread(target=self._server.serve_forever, kwargs={"poll_interval": 0.05})
        self._thread.start()

    def close(self):
        self._server.shutdown()
        self._thread.join()
        self._server.server_close()

    def parts(self, number=-1):
        """Of a form that was sent: the name of the file, or else of the part -> type and bytes."""
        _, headers, body = self.asked[number]
        message = email.message_from_bytes(f"Content-Type: {headers['Content-Type']}\r\n\r\n".encode() + body)
        return {part.get_filename() or part.get_param("name", header="Content-Disposition"):
                (part.get_content_type(), part.get_payload(decode=True))
                for part in message.get_payload()}


def problem(status, detail, exit_status=1):
    return status, {"type": "about:blank", "title": "t", "status": status, "detail": detail, "exit_status": exit_status}


class HttpTest(Test):
    def setUp(self):
        super().setUp()
        self.server = Server()
        self.addCleanup(self.server.close)
        self.answers = self.server.answers
        self.answers["GET /api/v1/server"] = [(200, {"version": "1", "user": "ann"})]
        self.answers["POST /api/v1/jobs"] = [(201, {"id": 7})]
        self.farm = parray.Farm(self.server.url, "secret", patience=5)
        self.server.asked.clear()

    def names(self):
        return [name for name, _, _ in self.server.asked]


class Requests(HttpTest):
    def test_paths_are_those_of_the_servers_document(self):
        """Where the coordinator has one: every request of the client is in it."""
        document = SOURCE / "coordinator/http/openapi.json"
        if not document.exists():
            self.skipTest("this coordinator serves no HTTP")
        known = {(method.upper(), re.sub(r"\{id\}", "7", path)) for path, methods in
                 json.loads(document.read_text())["paths"].items() for method in methods}
        for path in {path for _, path in known}:
            for method in ("GET", "POST", "PUT", "DELETE"):
                self.answers[f"{method} {path}"] = [(200, JOB)]
        self.answers["GET /api/v1/jobs/7/image.png?width=64"] = [(200, b"")]
        self.answers["GET /api/v1/workers"] = [(200, {"workers": []})]
        job = self.farm.job(7)
        for act in (job.show, job.png, job.thumbnail, job.pause, job.resume, job.cancel, job.requeue, job.forget, self.farm.workers,
                    lambda: job.set_priority(3)):
            act()
        bulk = {name: path for name in ("pause", "resume", "cancel", "requeue", "forget", "priority")
                if ("POST", path := f"/api/v1/jobs/{name}") in known}
        for name, path in bulk.items():
            self.answers[f"POST {path}"] = [(200, {"results": []})]
            self.farm._steer(name, [7])
        asked = {tuple(name.partition("?")[0].split(" ", 1)) for name in self.names()}
        self.assertLessEqual(asked | {("POST", "/api/v1/jobs"), ("GET", "/api/v1/jobs"), ("GET", "/api/v1/server")}, known)

    def test_a_token_goes_with_every_request_and_to_no_other_server(self):
        other = Server()
        self.addCleanup(other.close)
        other.answers["GET /x"] = [(200, JOB)]
        self.answers["GET /api/v1/jobs/7"] = [(200, JOB), (302, b"", ("Location", other.url + "/x"))]
        job = self.farm.job(7)
        self.assertEqual(job.state, "running")
        self.assertEqual(self.server.asked[0][1]["Authorization"], "Bearer secret")
        self.refused(parray.RenderError, "status 302", lambda: job.state)
        self.assertEqual(other.asked, [])

    def test_problems_have_their_text_and_the_exception_of_their_exit_status(self):
        for answer, kind, text in ((problem(422, "scene.json: /camera: missing", 2), parray.InputError, "/camera: missing"),
                                   (problem(403, "job 7 is ann's"), parray.RenderError, "job 7 is ann's"),
                                   ((404, b"not json"), parray.RenderError, "status 404"),
                                   ((500, [1]), parray.RenderError, "status 500")):
            self.answers["GET /api/v1/jobs/7"] = [answer]
            self.refused(kind, text, self.farm.job(7).show)

    def test_a_broken_connection_and_a_busy_server_are_tried_again_with_the_same_key(self):
        self.answers["POST /api/v1/jobs"] = [(0, b""), problem(503, "busy"), (201, {"id": 7})]
        self.assertEqual(self.farm.submit(SCENE, spp=4).id, 7)
        keys = {headers["Idempotency-Key"] for _, headers, _ in self.server.asked}
        bodies = {body for _, _, body in self.server.asked}
        self.assertEqual((len(self.server.asked), len(keys), len(bodies)), (3, 1, 1))
        self.assertRegex(keys.pop(), r"^[A-Za-z0-9_.-]{1,48}$")

    def test_a_farm_that_is_not_there_is_given_up_with_the_remedy(self):
        self.server.close()
        self.server.close = lambda: None
        remedy = "check that parray-coordinator --http listens there"
        self.refused(parray.RenderError, remedy, parray.Farm, self.server.url, patience=0.3)
        farm = parray.Farm(self.server.url, patience=0.3, check=False)
        self.refused(parray.RenderError, remedy, farm.jobs)
        for url in ("tcp://127.0.0.1:7400", "127.0.0.1:7480", "http://", "http://:80", "http://a:b", "http://me@a", ""):
            self.refused(parray.InputError, "give http://HOST:PORT", parray.Farm, url)
        for url in ("http://a", "https://a.b:7480", "http://[::1]:7480/", "https://a/farm/"):
            parray.Farm(url, check=False)

    def test_a_wrong_token_and_another_server_are_noticed_at_once(self):
        for answer, text in ((problem(401, "this token is unknown"), "this token is unknown"),
                             ((200, b"<html>"), "check that this is the address of parray-coordinator --http"),
                             ((404, b"<html>"), "status 404")):
            self.answers["GET /api/v1/server"] = [answer]
            self.refused(parray.RenderError, text, parray.Farm, self.server.url)
        self.answers["GET /api/v1/server"] = [problem(503, "busy")]
        parray.Farm(self.server.url)  # it is there

    def test_an_answer_to_half_a_form_is_heard(self):
        """As that of a server to which it is too large."""
        text = json.dumps(problem(413, "too large")[1]).encode()
        with socket.create_server(("127.0.0.1", 0)) as server:
            def answer():
                connection, _ = server.accept()
                with connection:
                    connection.recv(1000)
                    connection.sendall(b"HTTP/1.1 413 X\r\nContent-Length: %d\r\n\r\n" % len(text) + text)
            thread = threading.Thread(target=answer)
            thread.start()
            self.addCleanup(thread.join)
            farm = parray.Farm(f"http://127.0.0.1:{server.getsockname()[1]}", patience=0.2, check=False)
            self.refused(parray.RenderError, "too large", farm.submit, *cloud(300000))

    def test_jobs_are_listed_page_by_page(self):
        first = "GET /api/v1/jobs?state=queued,running&limit=1000"
        page = [{"id": id} for id in range(2000, 1000, -1)]
        self.answers[first] = [(200, {"jobs": page, "next": 1001})]
        self.answers[first + "&before=1001"] = [(200, {"jobs": [{"id": 5}], "next": None})]
        jobs = self.farm.jobs(["queued", "running"])
        self.assertEqual([job.id for job in jobs[-3:]], [1002, 1001, 5])
        self.assertEqual(len(jobs), 1001)

    def test_jobs_are_filtered_sorted_and_limited_by_the_server(self):
        first = "GET /api/v1/jobs?state=done&user=ann&name=a+b&sort=taken&order=desc&limit="
        page = [{"id": id} for id in range(1000)]
        self.answers[first + "1000"] = [(200, {"jobs": page, "next": None})]
        self.answers[first + "500&offset=1000"] = [(200, {"jobs": page[:500], "next": None})]
        jobs = self.farm.jobs("done", user="ann", name="a b", sort="taken", order="desc", limit=1500)
        self.assertEqual(len(jobs), 1500)
        self.answers["GET /api/v1/jobs?limit=2"] = [(200, {"jobs": page[:2], "next": 1})]
        self.assertEqual([job.id for job in self.farm.jobs(limit=2)], [0, 1])
        self.assertEqual(self.farm.jobs(limit=0), [])

    def test_many_jobs_are_steered_with_few_requests_and_refusals_are_told_at_the_end(self):
        good = [{"id": id, "job": JOB} for id in range(500)]
        bad = [{"id": id, "problem": {"status": 403, "detail": f"job {id} is ann's"}} for id in range(5)]
        self.answers["POST /api/v1/jobs/cancel"] = [(200, {"results": good}), (200, {"results": bad})]
        self.refused(parray.RenderError, "refused for 5 of 700 jobs: job 0: job 0 is ann's; ", self.farm.cancel,
                     [self.farm.job(1), *range(2, 701)])
        bodies = [json.loads(body)["ids"] for _, _, body in self.server.asked]
        self.assertEqual(bodies, [list(range(1, 501)), list(range(501, 701))])
        self.answers["POST /api/v1/jobs/priority"] = [(200, {"results": []})]
        self.farm.set_priority([3], 90)
        self.assertEqual(json.loads(self.server.asked[-1][2]), {"ids": [3], "priority": 90})
        self.farm.cancel([])

    def test_a_thumbnail_has_a_width(self):
        self.answers["GET /api/v1/jobs/7/image.png?width=128"] = [(200, b"PNG")]
        self.assertEqual(self.farm.job(7).thumbnail(128), b"PNG")


class Forms(HttpTest):
    def test_a_scene_is_sent_with_the_options_under_their_names(self):
        self.farm.submit(SCENE, width=30, spp=4, adaptive=True, passes=[8, 8], target_error=0.5, name="a", priority=60)
        parts = self.server.parts()
        self.assertEqual(set(parts), {"options", "scene"})
        self.assertEqual(json.loads(parts["options"][1]), {"width": 30, "spp": 4, "adaptive": True, "passes": [8, 8],
                                                           "target_error": 0.5, "name": "a", "priority": 60})
        self.assertEqual(json.loads(parts["scene"][1]), SCENE)
        self.refused(TypeError, "unknown option 'threads'", self.farm.submit, SCENE, threads=2)

    def test_arrays_are_sent_as_the_file_that_a_program_would_get(self):
        self.farm.submit(*cloud(100))
        parts = self.server.parts()
        self.assertEqual(set(parts), {"options", "particles.ply"})
        kind, data = parts["particles.ply"]
        self.assertEqual(kind, "application/octet-stream")
        expected = parray.Particles(*cloud(100)).write(self.folder)
        self.assertEqual(data, expected.read_bytes())

    def test_files_of_a_scene_go_along_under_names_of_their_own(self):
        odd = 'my "atoms" \u00e4.xyz'
        for folder in ("a", "b"):
            (self.folder / folder).mkdir()
            (self.folder / folder / odd).write_text(f"1\n\n{folder} 0 0 0\n")
        scene = {**SCENE, "particles": [{"file": f"a/{odd}"}, {"file": f"b/{odd}", "radius": 2}]}
        (self.folder / "scene.json").write_text(json.dumps(scene))
        self.farm.submit(self.folder / "scene.json")
        parts = self.server.parts()
        sent = json.loads(parts["scene"][1])["particles"]
        self.assertEqual([parts[item["file"]][1] for item in sent], [b"1\n\na 0 0 0\n", b"1\n\nb 0 0 0\n"])
        for item in sent:
            self.assertRegex(item["file"], r"^[0-9a-z_.-]+\.xyz$")
        self.assertEqual(sent[1]["radius"], 2)

    def test_a_scene_file_without_files_goes_as_it_is(self):
        """It may be in the format of another program, or wrong, which the server says better."""
        for text in ('  {"spheres": [ ]  }', '{"version": 1', '[1]', ''):
            (self.folder / "odd.json").write_text(text)
            self.farm.submit(self.folder / "odd.json")
            self.assertEqual(self.server.parts()["scene"][1], text.encode())
        self.refused(parray.InputError, "none.json: no such file", self.farm.submit, self.folder / "none.json")
        self.refused(parray.InputError, "none.xyz: no such file", self.farm.submit, self.folder / "none.xyz")


class Waiting(HttpTest):
    def picture(self):
        (self.folder / "p").mkdir(exist_ok=True)
        picture = parray.render(SCENE, width=8, height=6, spp=4)
        picture.save(self.folder / "p" / "a.exr")
        self.answers["GET /api/v1/jobs/7/image.exr"] = [(200, (self.folder / "p" / "a.exr").read_bytes())]
        self.answers["GET /api/v1/jobs/7/report"] = [(200, picture.report)]
        return picture

    def states(self, *states):
        self.answers["GET /api/v1/jobs/7"] = [(200, {**JOB, **state}) for state in states]

    def test_a_job_is_waited_for_and_its_picture_has_report_and_bits(self):
        expected = self.picture()
        self.states({"state": "queued", "progress": 0}, {}, {"state": "done", "progress": 1})
        told = []
        picture = self.farm.render(SCENE, progress=told.append)
        self.assertEqual([p.state for p in told], ["queued", "running", "done"])
        self.assertEqual(picture.pixels.tobytes(), expected.pixels.tobytes())
        self.assertEqual(picture.report, expected.report)
        self.states({}, {"state": "done"})
        self.assertEqual(asyncio.run(self.farm.render_async(SCENE)).error, expected.error)

    def test_a_long_wait_is_one_request_and_a_busy_server_is_asked_again(self):
        self.picture()
        self.states({}, {"state": "done"})
        wait = "GET /api/v1/jobs/7?wait=30"
        self.answers[wait] = [problem(503, "busy"), (200, {**JOB, "state": "running"}), (200, {**JOB, "state": "done"})]
        clock = itertools.count(0, 5)
        with unittest.mock.patch("parray.farm.time") as time:
            time.monotonic.side_effect = lambda: next(clock)
            self.states(*[{}] * 9)
            self.farm.job(7).wait()
        self.assertEqual([name for name in self.names() if name.startswith("GET /api/v1/jobs/7?")], [wait] * 3)
        time.sleep.assert_called_once()  # after the server was busy

    def test_the_picture_so_far_has_the_error_so_far(self):
        self.picture()
        self.states({})
        self.assertEqual(self.farm.job(7).picture().error, (0.2, 0.1, 0.3))

    def test_a_job_that_fails_says_why(self):
        for state, reason, text in (("failed", "out of memory", "job 7 failed: out of memory"),
                                    ("cancelled", "", "job 7 was cancelled")):
            self.states({"state": state, "reason": reason})
            self.refused(parray.RenderError, text, self.farm.job(7).wait)

    def test_a_timeout_leaves_the_job_and_what_ends_a_render_cancels_it(self):
        self.states({})
        self.answers["POST /api/v1/jobs/7/cancel"] = [(200, JOB)]
        with self.assertRaises(TimeoutError):
            self.farm.job(7).wait(timeout=0.2)
        self.assertNotIn("POST /api/v1/jobs/7/cancel", self.names())

        def interrupt(_):
            raise KeyboardInterrupt
        with self.assertRaises(KeyboardInterrupt):
            self.farm.render(SCENE, progress=interrupt)
        self.assertEqual(self.names().count("POST /api/v1/jobs/7/cancel"), 1)

        async def cancelled():
            seen = asyncio.Event()
            loop = asyncio.get_running_loop()
            task = asyncio.create_task(
                self.farm.render_async(SCENE, progress=lambda _: loop.call_soon_threadsafe(seen.set)))
            await seen.wait()
            task.cancel()
            with self.assertRaises(asyncio.CancelledError):
                await task
        asyncio.run(cancelled())
        self.assertEqual(self.names().count("POST /api/v1/jobs/7/cancel"), 2)

    def test_a_notebook_shows_a_job_and_its_bar(self):
        self.states({"waits_for": "<workers>"})
        self.assertIn("waits for: &lt;workers&gt;", self.farm.job(7)._repr_html_())


if __name__ == "__main__":
    main()
