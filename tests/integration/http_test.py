"""The coordinator's HTTP interface for programs and browsers, with real processes and plain sockets."""

import gzip
import hashlib
import http.client
import json
import os
import pathlib
import shutil
import socket
import struct
import subprocess
import tempfile
import threading
import unittest

from farm import BIN, SOURCE, run, wait_for
from web import SCENE, WATER, Answer, Listener, Web, WebCase


class Jobs(WebCase):
    def test_maps_show_the_cost_of_pixels_and_their_workers(self):
        with Web() as farm:
            farm.start_worker("one")
            farm.start_worker("two")
            job = farm.submitted(farm.post_scene({**SCENE, "image": {"width": 300, "height": 200},
                                                  "render": {"samples_per_pixel": 200}}))
            wait_for(lambda: farm.state(job) == "done", "the picture")
            cost = farm.get(f"/jobs/{job}/cost.f32")
            self.assertEqual((cost.status, cost.headers["Parray-Width"]), (200, "300"))
            seconds = struct.unpack("<60000f", cost.body)
            self.assertGreater(min(seconds), 0)
            traced = farm.get(f"/jobs/{job}/report").json()["seconds"]["render"]
            self.assertLess(sum(seconds), 2.5 * traced + 1)
            names = farm.get(f"/jobs/{job}/workers.json").json()["workers"]
            self.assertLessEqual(set(names), {"one", "two"})
            numbers = set(struct.unpack("<60000I", farm.get(f"/jobs/{job}/workers.u32").body))
            self.assertEqual(numbers, set(range(len(names))))
            self.assertEqual(farm.get(f"/jobs/{job}/cost.f32", **{"If-None-Match": cost.headers["ETag"]}).status, 304)
            self.assertEqual(farm.get("/jobs/999/cost.f32").status, 404)

    def test_a_scene_is_submitted_rendered_and_fetched_with_the_bits_of_the_command_line(self):
        with Web() as farm:
            farm.start_worker("one")
            job = farm.submitted(farm.post_scene())
            wait_for(lambda: farm.state(job) == "done", "the picture")
            shown = farm.get(f"/jobs/{job}").json()
            self.assertEqual(shown, {**farm.job(job)})
            pixels = farm.get(f"/jobs/{job}/pixels.f32")
            self.assertEqual(len(pixels.body), 60 * 40 * 12)
            self.assertEqual((pixels.headers["Parray-Width"], pixels.headers["Parray-Height"],
                              pixels.headers["Parray-Partial"]), ("60", "40", "0"))
            report = farm.get(f"/jobs/{job}/report").json()
            self.assertEqual(hashlib.sha256(pixels.body).hexdigest(), report["image_sha256"])
            scene = farm.directory / "scene.json"
            scene.write_text(json.dumps(SCENE))
            local = farm.directory / "local.json"
            self.assertEqual(run("render", scene, "-o", farm.directory / "a.exr", "--report", local).returncode, 0)
            self.assertEqual(json.loads(local.read_text())["image_sha256"], report["image_sha256"])

            png = farm.get(f"/jobs/{job}/image.png")
            self.assertEqual(png.headers["Content-Type"], "image/png")
            self.assertEqual(png.body[:8], b"\x89PNG\r\n\x1a\n")
            exr = farm.get(f"/jobs/{job}/image.exr")
            self.assertEqual(exr.body[:4], b"\x76\x2f\x31\x01")
            kept = farm.directory / "fetched.exr"
            kept.write_bytes(exr.body)
            verified = run("verify", kept, scene)
            self.assertEqual(verified.returncode, 0, verified.stderr)
            widths = farm.get(f"/jobs/{job}/error.f32")
            self.assertEqual(len(widths.body), 60 * 40 * 4)
            self.assertGreater(max(struct.unpack("<2400f", widths.body)), 0)
            self.assertEqual(farm.get(f"/jobs/{job}/error.png").body[1:4], b"PNG")
            self.assertEqual(farm.get(f"/jobs/{job}/image.png", **{"If-None-Match": png.headers["ETag"]}).status, 304)

    def test_an_unfinished_picture_is_shown_and_changes_its_etag(self):
        with Web() as farm:
            worker = farm.start_worker("one")
            job = farm.submitted(farm.post_form(
                ("scene", None, json.dumps(SCENE)),
                ("options", None, json.dumps({"spp": 100000, "width": 200, "height": 100, "progressive": True}))))
            def shown():
                answer = farm.get(f"/jobs/{job}/pixels.f32")
                return answer if answer.status == 200 and int(answer.headers["Parray-Samples"]) > 0 else None
            first = wait_for(shown, "a first picture")
            self.assertEqual(first.headers["Parray-Partial"], "1")
            self.assertEqual(farm.get(f"/jobs/{job}/image.png").body[1:4], b"PNG")
            self.assertEqual(farm.get(f"/jobs/{job}/image.exr").body[:4], b"\x76\x2f\x31\x01")
            second = wait_for(lambda: (lambda a: a if a.headers["ETag"] != first.headers["ETag"] else None)(shown()),
                              "another picture")
            self.assertGreater(int(second.headers["Parray-Samples"]), int(first.headers["Parray-Samples"]))
            wait_for(lambda: farm.get(f"/jobs/{job}").json()["samples_taken"] >= 2, "two samples of each pixel")
            widths = farm.get(f"/jobs/{job}/error.f32")
            self.assertEqual((len(widths.body), widths.headers["Parray-Partial"]), (200 * 100 * 4, "1"))
            self.assertGreater(max(struct.unpack("<20000f", widths.body)), 0)
            cost = farm.get(f"/jobs/{job}/cost.f32")
            self.assertEqual((cost.headers["Parray-Partial"], cost.headers["Parray-Samples"]), ("1", None))
            self.assertEqual(farm.get(f"/jobs/{job}/error.png").body[1:4], b"PNG")
            farm.ask("POST", f"/api/v1/jobs/{job}/pause")
            worker.terminate()
            wait_for(lambda: farm.get("/workers").json()["total"] == 0, "the worker's last message")
            self.assertEqual(farm.state(job), "paused")
            taken = farm.get(f"/jobs/{job}").json()["progress"]
            cancelled = farm.ask("POST", f"/api/v1/jobs/{job}/cancel").json()
            self.assertEqual(cancelled["progress"], taken)
            wait_for(lambda: farm.get(f"/jobs/{job}").json()["has_picture"], "the picture of the cancelled job")
            kept = farm.get(f"/jobs/{job}/image.png")
            self.assertEqual((kept.body[1:4], kept.headers["Parray-Partial"]), (b"PNG", "1"))
            self.assertEqual(farm.get(f"/jobs/{job}/image.exr").body[:4], b"\x76\x2f\x31\x01")

    def test_a_job_without_a_sample_has_no_picture(self):
        with Web() as farm:
            job = farm.submitted(farm.post_scene())
            self.assertIs(farm.get(f"/jobs/{job}").json()["has_picture"], False)
            for name in ("image.png", "error.png", "image.exr"):
                self.assert_problem(farm.get(f"/jobs/{job}/{name}"), 409, "has no picture yet: try again later")

    def test_particle_files_come_as_parts_and_options_are_the_command_lines(self):
        with Web() as farm:
            scene = {**SCENE, "particles": [{"file": "water.xyz", "material": "by-element", "radius": "by-element"}]}
            job = farm.submitted(farm.post_form(
                ("scene", "pool.json", json.dumps(scene)), ("atoms", "water.xyz", WATER),
                ("options", None, json.dumps({"spp": 9, "width": 70, "priority": 90, "sampler": "sobol",
                                              "name": "a pool", "target_error": 0.5, "adaptive": False}))))
            shown = farm.get(f"/jobs/{job}").json()
            self.assertEqual((shown["name"], shown["width"], shown["height"], shown["samples_per_pixel"],
                              shown["priority"], shown["sampler"], shown["target_error"]),
                             ("a pool", 70, 40, 9, 90, "sobol", 0.5))
            alone = farm.submitted(farm.post_form(("file", "water.xyz.gz", gzip.compress(WATER.encode()))))
            self.assertEqual(farm.get(f"/jobs/{alone}").json()["name"], "water.xyz.gz")

    def test_a_key_makes_one_job_of_two_requests(self):
        with Web() as farm:
            key = {"Idempotency-Key": "once"}
            first = farm.submitted(farm.post_scene(**key))
            self.assertEqual(farm.submitted(farm.post_scene(**key)), first)
            self.assertNotEqual(farm.submitted(farm.post_scene()), first)
            both = []
            threads = [threading.Thread(target=lambda: both.append(farm.post_scene(**{"Idempotency-Key": "twice"})))
                       for _ in range(4)]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
            self.assertEqual(len({farm.submitted(answer) for answer in both}), 1)
            self.assert_problem(farm.post_scene(**{"Idempotency-Key": "a key"}), 400, "Idempotency-Key")

    def test_jobs_are_listed_in_pages_the_newest_first(self):
        with Web() as farm:
            ids = [farm.submitted(farm.post_scene()) for _ in range(5)]
            farm.ask("POST", f"/api/v1/jobs/{ids[0]}/cancel")
            page = farm.get("/jobs?limit=2").json()
            self.assertEqual([job["id"] for job in page["jobs"]], [ids[4], ids[3]])
            page = farm.get(f"/jobs?limit=2&before={page['next']}").json()
            self.assertEqual([job["id"] for job in page["jobs"]], [ids[2], ids[1]])
            page = farm.get(f"/jobs?limit=2&before={page['next']}").json()
            self.assertEqual(([job["id"] for job in page["jobs"]], page["next"]), ([ids[0]], None))
            self.assertEqual([job["id"] for job in farm.get("/jobs?state=cancelled,failed").json()["jobs"]], [ids[0]])
            self.assertEqual(len(farm.get("/jobs?state=queued").json()["jobs"]), 4)
            self.assert_problem(farm.get("/jobs?limit=0"), 400, "'0' is not a whole number from 1 to 1000")
            self.assert_problem(farm.get("/jobs?state=dnoe"), 400, "did you mean 'done'?")
            self.assert_problem(farm.get("/jobs?limits=2"), 400, "did you mean 'limit'?")

    def test_jobs_are_listed_by_user_name_and_order(self):
        with Web() as farm:
            ids = [farm.submitted(farm.post_with(name=name, priority=priority))
                   for name, priority in (("Water", 10), ("glass", 90), ("deep water", 50))]
            listed = lambda query: [ids.index(job["id"]) for job in farm.get("/jobs?" + query).json()["jobs"]]
            self.assertEqual(listed("name=wATer"), [2, 0])
            self.assertEqual(listed("sort=priority"), [1, 2, 0])
            self.assertEqual(listed("sort=priority&order=asc&limit=2"), [0, 2])
            self.assertEqual(listed("sort=priority&order=asc&limit=2&offset=2"), [1])
            self.assertEqual(listed("sort=name&order=asc"), [2, 1, 0])
            page = farm.get("/jobs?name=water&limit=1&sort=name").json()
            self.assertEqual((page["total"], page["next"]), (2, None))
            self.assertEqual(listed("user=nobody"), [])
            self.assert_problem(farm.get("/jobs?sort=nmae"), 400, "did you mean 'name'?")
            self.assert_problem(farm.get("/jobs?order=down"), 400, "order")

    def test_many_jobs_are_changed_with_one_request(self):
        with Web() as farm:
            ids = [farm.submitted(farm.post_scene()) for _ in range(3)]
            json_type = {"Content-Type": "application/json"}
            steer = lambda action, body: farm.ask("POST", f"/api/v1/jobs/{action}", json.dumps(body), json_type)
            results = steer("cancel", {"ids": [ids[0], 999, ids[1]]}).json()["results"]
            self.assertEqual([result["id"] for result in results], [ids[0], 999, ids[1]])
            self.assertEqual(results[0]["job"]["state"], "cancelled")
            self.assertEqual(results[1]["problem"]["status"], 404)
            self.assertEqual(steer("cancel", {"ids": [ids[0]]}).json()["results"][0]["problem"]["status"], 409)
            self.assertEqual(steer("priority", {"ids": [ids[2]], "priority": 80}).json()["results"][0]["job"]["priority"], 80)
            self.assertIn("job", steer("forget", {"ids": ids[:1]}).json()["results"][0])
            self.assert_problem(farm.get(f"/jobs/{ids[0]}"), 404)
            self.assertEqual(len(steer("pause", {"ids": [ids[2]] * 500}).json()["results"]), 500)
            self.assert_problem(steer("cancel", {"ids": [ids[2]] * 501}), 422, "ids: use at most 500 numbers of jobs")
            self.assertEqual(farm.job(ids[2])["state"], "paused")
            for body in ({"ids": []}, {"ids": ["1"]}, {"ids": [0]}, {}, [], {"ids": [1], "x": 2}):
                self.assert_problem(steer("pause", body), 422)
            self.assert_problem(steer("priority", {"ids": [ids[2]]}), 422)
            self.assert_problem(farm.ask("POST", "/api/v1/jobs/pause", '{"ids": [1]}'), 415)

    def test_a_waiting_job_says_what_it_waits_for_and_its_place(self):
        with Web() as farm:
            job = farm.submitted(farm.post_scene())
            wait_for(lambda: farm.get(f"/jobs/{job}").json()["queue_place"] == 1, "its place in the queue")
            shown = farm.get(f"/jobs/{job}").json()
            self.assertEqual(shown["waits_for"], "a worker (none is connected)")
            self.assertEqual((shown["waits_for_job"], shown["starts_in"]), (None, None))

    def test_a_quick_look_names_its_job_and_is_deleted_with_it(self):
        with Web() as farm:
            job = farm.submitted(farm.post_scene())
            look = farm.submitted(farm.post_with(preview_of=job))
            self.assertEqual(farm.get(f"/jobs/{look}").json()["preview_of"], job)
            self.assert_problem(farm.post_with(preview_of=999), 422, "there is no job or series 999")
            self.assert_problem(farm.post_with(preview_of=look), 422, "is itself a quick look")
            self.assert_problem(farm.post_with(preview_of="7"), 422, "preview_of")
            farm.ask("POST", f"/api/v1/jobs/{job}/cancel")
            self.assertEqual(farm.ask("DELETE", f"/api/v1/jobs/{job}").status, 204)
            self.assert_problem(farm.get(f"/jobs/{look}"), 404)

    def test_jobs_are_steered_and_forgotten(self):
        with Web() as farm:
            job = farm.submitted(farm.post_scene())
            steer = lambda action: farm.ask("POST", f"/api/v1/jobs/{job}/{action}")
            self.assertEqual(steer("pause").json()["state"], "paused")
            self.assertEqual(steer("resume").json()["state"], "queued")
            self.assert_problem(steer("resume"), 409, "only paused jobs can be resumed")
            priority = lambda body: farm.ask("PUT", f"/api/v1/jobs/{job}/priority", body, {"Content-Type": "application/json"})
            self.assertEqual(priority('{"priority": 99}').json()["priority"], 99)
            for body in ('{"priority": 101}', '{"priority": "9"}', "[]", "{", '{"priority": 1, "x": 2}'):
                self.assert_problem(priority(body), 422)
            self.assert_problem(farm.ask("DELETE", f"/api/v1/jobs/{job}"), 409)
            self.assertEqual(steer("cancel").json()["state"], "cancelled")
            self.assertEqual(steer("requeue").json()["state"], "queued")
            steer("cancel")
            self.assert_problem(steer("cancel"), 409, "only unfinished jobs can be cancelled")
            self.assert_problem(farm.ask("DELETE", f"/api/v1/jobs/{job}", "x" * (5 << 20)), 413, "does not take a body")
            self.assertEqual(farm.ask("DELETE", f"/api/v1/jobs/{job}", "{}").status, 204)  # it still exists
            self.assert_problem(farm.get(f"/jobs/{job}"), 404)
            self.assert_problem(steer("pause"), 404)

    def test_workers_are_listed_drained_and_readmitted(self):
        with Web() as farm:
            farm.start_worker("one")
            wait_for(lambda: farm.get("/workers").json()["total"] == 1, "the worker")
            worker = farm.get("/workers").json()["workers"][0]
            self.assertEqual((worker["name"], worker["state"], worker["threads"]), ("one", "ready", 1))
            self.assertEqual(farm.ask("POST", "/api/v1/workers/one/drain").json()["workers"][0]["state"], "drained")
            self.assertEqual(farm.ask("POST", "/api/v1/workers/one/readmit").json()["workers"][0]["state"], "ready")
            self.assertEqual(farm.get("/workers?offset=1").json(), {"total": 1, "workers": []})

    def test_it_stops_at_once_even_with_open_connections(self):
        with Web() as farm:
            listener = Listener(farm, "/api/v1/events")
            idle = http.client.HTTPConnection(farm.web, timeout=60)
            idle.request("GET", "/healthz")
            idle.getresponse().read()
            farm.coordinator.terminate()
            self.assertEqual(farm.coordinator.wait(timeout=60), 0, farm.coordinator_log())
            wait_for(lambda: listener.ended, "the end of the stream")
            idle.close()
            self.assertEqual(list(farm.directory.glob("parray-http-*")), [])

    def test_it_serves_its_version_and_its_own_description(self):
        with Web() as farm:
            self.assertEqual(farm.ask("GET", "/healthz").body, b"ok\n")
            self.assertEqual(farm.ask("GET", "/readyz").body, b"ok\n")
            self.assertEqual(farm.get("/openapi.json").json(),
                             json.loads((SOURCE / "coordinator/http/openapi.json").read_text()))
            server = farm.get("/server").json()
            self.assertEqual((server["user"], server["role"]), ("", "any"))
            head = farm.ask("HEAD", "/api/v1/openapi.json")
            self.assertEqual((head.status, head.body), (200, b""))
            self.assertEqual(farm.get("/server").headers["X-Content-Type-Options"], "nosniff")


class Problems(WebCase):
    def test_problems_have_the_messages_of_the_command_line(self):
        with Web() as farm:
            folder = farm.directory / "scene"
            folder.mkdir()
            bad_scenes = [{**SCENE, "sphers": []},
                          {**SCENE, "spheres": [{"center": [0, 0], "radius": 1, "material": "red"}]},
                          {**SCENE, "spheres": [{"center": [0, 0, 0], "radius": -1, "material": "red"}]},
                          {**SCENE, "camera": {"look_from": [0, 0, 0], "look_at": [0, 0, 0]}},
                          {**SCENE, "particles": [{"file": "gone.xyz"}]}]
            for scene in bad_scenes:
                (folder / "scene.json").write_text(json.dumps(scene))
                said = subprocess.run([BIN / "parray", "submit", "scene.json"], cwd=folder, text=True,
                                      capture_output=True).stderr.strip().removeprefix("parray: ")
                self.assertEqual(self.assert_problem(farm.post_scene(scene), 422), said)
            self.assert_problem(farm.post_scene({}), 422)
            (folder / "scene.json").write_text(json.dumps(SCENE))
            for options, words in (({"spp": 0}, ["--spp=0"]), ({"sampler": "sobel"}, ["--sampler=sobel"]),
                                   ({"width": 65536, "height": 65536}, ["--width=65536", "--height=65536"]),
                                   ({"target_error": -1}, ["--target-error=-1"]),
                                   ({"target_error": 1e-9}, ["--target-error=1e-9"])):
                said = subprocess.run([BIN / "parray", "submit", "scene.json", *words], cwd=folder, text=True,
                                      capture_output=True).stderr.strip().removeprefix("parray: ")
                option, text = said.removesuffix("; see `parray submit --help`").split(": ", 1)
                pointer = "options: /" + option.split(",")[0].split(" ")[0].removeprefix("--").replace("-", "_") + ": "
                answer = farm.post_form(("scene", None, json.dumps(SCENE)), ("options", None, json.dumps(options)))
                self.assertIn(self.assert_problem(answer, 422), (pointer + text, pointer + option + ": " + text))
            said = farm.client("show", 77).stderr.strip().removeprefix("parray: ")
            self.assertEqual(self.assert_problem(farm.get("/jobs/77"), 404), said)
            self.assertEqual(self.assert_problem(farm.get("/jobs/77/image.png"), 404), said)

    def test_a_scene_names_parts_of_its_own_request_only(self):
        with Web() as farm:
            secret = farm.directory / "secret.xyz"
            secret.write_text(WATER)
            for name in (str(secret), "../secret.xyz", "./secret.xyz", "parts/../secret.xyz", ".."):
                scene = {**SCENE, "particles": [{"file": name, "material": "by-element", "radius": "by-element"}]}
                detail = self.assert_problem(farm.post_scene(scene), 422)
                self.assertNotIn("water", detail)
            for name in ("../a.xyz", "/tmp/a.xyz", ".hidden", "-o.xyz", "a\tb.xyz"):
                self.assert_problem(farm.post_form(("scene", None, json.dumps(SCENE)), ("f", name, WATER)), 422, "is not a valid file name")
            self.assert_problem(farm.post_form(("a", "a.xyz", WATER), ("b", "b.xyz", WATER)), 422, "no part 'scene'")
            self.assert_problem(farm.post_form(("a", "a.xyz", WATER), ("b", "a.xyz", WATER)), 422, "two parts")
            self.assert_problem(farm.post_form(("what", None, WATER)), 422, "has no file name")
            self.assert_problem(farm.post_form(), 400, "the request body is damaged")
            self.assert_problem(farm.post_form(("options", None, "{}")), 422, "there is no scene")
            self.assertEqual(farm.get("/jobs").json()["jobs"], [])

    def test_hostile_requests_are_refused_and_harm_nobody(self):
        with Web("--http-body", "1", "--http-parts", "3") as farm:
            json_type = {"Content-Type": "application/json"}
            self.assert_problem(farm.ask("POST", "/api/v1/jobs", "x" * (2 << 20), json_type), 413, "--http-body")
            self.assert_problem(farm.post_form(*[("f", f"{i}.xyz", "") for i in range(4)]), 413, "--http-parts")
            self.assert_problem(farm.ask("POST", "/api/v1/jobs", "scene", {"Content-Type": "text/plain"}), 415)
            self.assert_problem(farm.ask("POST", "/api/v1/jobs"), 415)
            self.assert_problem(farm.ask("POST", "/api/v1/jobs", "", json_type), 422, "there is no scene")
            for body in ("[" * 500000, '{"version":' * 90000, "\x00\x00", "{" + '"a":1,' * 9999):
                self.assert_problem(farm.ask("POST", "/api/v1/jobs", body, json_type), 422)
            self.assert_problem(farm.ask("POST", "/api/v1/jobs", "--x\r\n", {"Content-Type": "multipart/form-data; boundary=y"}), 400)
            self.assert_problem(farm.ask("POST", "/api/v1/jobs", "x", {"Content-Type": "multipart/form-data"}), 400)
            self.assert_problem(farm.ask("POST", "/api/v1/jobs", "x", {"Content-Type": "multipart/ form-data; boundary=y"}), 400, "has blanks")
            bomb = gzip.compress(b" " * (300 << 20))
            answer = farm.ask("POST", "/api/v1/jobs", bomb, {**json_type, "Content-Encoding": "gzip"})
            self.assertIn(answer.status, (413, 415), answer.body)
            self.assert_problem(farm.ask("PATCH", "/api/v1/jobs", "{}", json_type), 405)
            self.assert_problem(farm.ask("OPTIONS", "/api/v1/jobs"), 405)
            self.assert_problem(farm.ask("GET", "/" + "a" * 5000), 404)
            self.assert_problem(farm.ask("POST", "/" + "a" * 5000), 404)
            for job in ("0", "-1", "x", "1e3", "99999999999999999999", "%00", "1%2F..", "%ff"):
                self.assertIn(farm.get(f"/jobs/{job}").status, (400, 404))
            for ranges in ("bytes=0-1", "bytes=9999999-", "bytes=5-2", "bytes=-5,3-", "bytes=" + "0-1," * 500 + "0-1",
                           "bytes=99999999999999999999999-"):
                self.assertIn(farm.get("/openapi.json", Range=ranges).status, (200, 206, 416))
            host, port = farm.web.split(":")
            for text in (b"GET\r\n\r\n", b"\x16\x03\x01\x02\x00", b"GET / HTTP/1.1\r\n" + b"a: b\r\n" * 5000 + b"\r\n",
                         b"GET / HTTP/9.9\r\nHost: localhost\r\n\r\n", b"POST /api/v1/jobs HTTP/1.1\r\nHost: localhost\r\n"
                         b"Content-Type: application/json\r\nContent-Length: -5\r\n\r\n{}",
                         b"POST /api/v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
                         b"Transfer-Encoding: chunked\r\n\r\nffffffffffffffff\r\n{}\r\n",
                         b"POST /api/v1/jobs/7/pause HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99999999999999999999\r\n\r\n"):
                with socket.create_connection((host, int(port)), timeout=20) as plain:
                    plain.sendall(text)
                    plain.shutdown(socket.SHUT_WR)
                    try:
                        plain.recv(100)
                    except ConnectionResetError:
                        pass
            self.assertEqual(farm.ask("GET", "/readyz").status, 200)
            self.assertEqual(farm.get("/jobs").json()["jobs"], [])

    def test_the_unread_rest_of_a_body_is_never_read_as_a_request(self):
        hidden = b"DELETE /api/v1/jobs/1 HTTP/1.1\r\nHost: localhost\r\n\r\n"
        with Web() as farm:
            job = farm.submitted(farm.post_scene())
            farm.ask("POST", f"/api/v1/jobs/{job}/cancel")
            host, port = farm.web.split(":")
            size = f"Host: localhost\r\nContent-Length: {len(hidden)}\r\n".encode()
            for head in (b"GET /healthz HTTP/1.1\r\n", b"POST /api/v1/nothing HTTP/1.1\r\n", b"GET /nothing HTTP/1.1\r\n",
                         b"POST /api/v1/jobs HTTP/1.1\r\nContent-Type: text/plain\r\n", b"HEAD /healthz HTTP/1.1\r\n",
                         b"OPTIONS /api/v1/jobs HTTP/1.1\r\n", b"POST /api/v1/jobs/1/cancel HTTP/1.1\r\n",
                         b"QUERY /api/v1/jobs HTTP/1.1\r\n"):
                with socket.create_connection((host, int(port)), timeout=20) as plain:
                    plain.sendall(head + size + b"\r\n" + hidden)
                    plain.shutdown(socket.SHUT_WR)
                    answer = b""
                    try:
                        while more := plain.recv(65536):
                            answer += more
                    except ConnectionResetError:
                        pass
                self.assertEqual(farm.get(f"/jobs/{job}").status, 200, head + answer)
            # Two requests of one connection, the first refused with its body unread: both are answered.
            connection = http.client.HTTPConnection(farm.web, timeout=60)
            connection.request("POST", "/api/v1/nothing", b"x" * 100000)
            self.assertEqual(Answer(connection.getresponse()).status, 404)
            connection.request("GET", "/healthz")
            self.assertEqual(Answer(connection.getresponse()).status, 200)
            connection.close()

    @unittest.skipIf(os.environ.get("PARRAY_SANITIZED"), "its readers' memory is not limited")
    def test_a_scene_that_takes_too_much_ends_its_reader_and_nothing_else(self):
        with Web("--http-scene-memory", "0.2") as farm:
            spheres = "\n".join(f"H {i} {i % 1000} {i % 77}" for i in range(3_000_000))
            answer = farm.post_form(("file", "many.xyz", f"3000000\nmany\n{spheres}\n"))
            self.assert_problem(answer, 422, "--http-scene-memory")
            self.assertEqual(farm.ask("GET", "/readyz").status, 200)
            self.assertEqual(list(farm.directory.glob("parray-http-*/*")), [])


class Compression(WebCase):
    def test_answers_are_compressed_with_gzip_or_not_at_all(self):
        with Web() as farm:
            document = farm.get("/openapi.json").body
            packed = farm.get("/openapi.json", **{"Accept-Encoding": "gzip, deflate, br, zstd"})
            self.assertEqual(packed.headers["Content-Encoding"], "gzip")
            self.assertEqual(gzip.decompress(packed.body), document)
            self.assertLess(len(packed.body), len(document) / 3)
            plain = farm.get("/openapi.json", **{"Accept-Encoding": "br"})  # brotli would take 0.7 s for a list of 500 jobs
            self.assertIsNone(plain.headers["Content-Encoding"])
            self.assertEqual(plain.body, document)


class Access(WebCase):
    def test_other_sites_pages_and_names_are_refused_on_loopback(self):
        with Web("--http-host", "farm.example") as farm:
            self.assert_problem(farm.get("/jobs", Host="evil.example"), 421, "--http-host evil.example")
            for name in ("farm.example", "Farm.Example", "LOCALHOST:7480"):
                self.assertEqual(farm.get("/jobs", Host=name).status, 200)
            for origin in ("https://evil.example", "null", "http://localhost:1"):
                self.assert_problem(farm.post_scene(Origin=origin), 403, "another site")
            self.assertEqual(farm.post_scene(Origin=f"http://{farm.web}").status, 201)

    def test_tokens_stand_for_users_and_their_roles(self):
        with tempfile.TemporaryDirectory() as directory:
            keys = pathlib.Path(directory) / "keys"
            self.assertEqual(run("keygen", keys).returncode, 0)
            for name in ("ann", "bob"):
                self.assertEqual(run("keygen", keys, "--name", name).returncode, 0)
            token = lambda name: {"Authorization": "Bearer " + run("keygen", keys, "--token", name).stdout.strip()}
            ann, bob, admin = token("ann"), token("bob"), token("admin")
            self.assertEqual(run("keygen", keys, "--token", "worker").returncode, 2)
            with Web("--keys", keys) as farm:
                for path in ("/api/v1/jobs", "/api/v1/events", "/api/v1/server", "/api/v1/jobs/1/image.png"):
                    answer = farm.ask("GET", path)
                    self.assert_problem(answer, 401, "a token is missing")
                    self.assertIn("Bearer", answer.headers["WWW-Authenticate"])
                self.assert_problem(farm.get("/jobs", Authorization="Bearer no"), 401, "unknown")
                # Of a form, too, which nobody reads then.
                self.assert_problem(farm.post_form(("scene", None, json.dumps(SCENE))), 401, "a token is missing")
                large = farm.post_form(("scene", None, json.dumps(SCENE)), ("file", "water.xyz", WATER * 100000))
                self.assert_problem(large, 401, "a token is missing")
                self.assertEqual(farm.ask("GET", "/healthz").status, 200)
                self.assertEqual(farm.get("/server", **ann).json()["user"], "ann")
                job = farm.submitted(farm.post_scene(**ann))
                self.assertEqual(farm.get(f"/jobs/{job}", **bob).json()["user"], "ann")
                self.assert_problem(farm.ask("POST", f"/api/v1/jobs/{job}/cancel", headers=bob), 403,
                                    "belongs to 'ann'")
                self.assert_problem(farm.ask("POST", "/api/v1/workers/x/drain", headers=ann), 403)
                self.assertEqual(farm.ask("POST", "/api/v1/workers/x/drain", headers=admin).status, 200)
                self.assertEqual(farm.ask("POST", f"/api/v1/jobs/{job}/cancel", headers=admin).status, 200)
                self.assertEqual(run("keygen", keys, "--remove", "ann").returncode, 0)
                wait_for(lambda: farm.get("/jobs", **ann).status == 401, "the token's end")

    def test_it_serves_other_machines_with_keys_or_insecure_only(self):
        result = subprocess.run([BIN / "parray-coordinator", "--bind", "tcp://127.0.0.1:*", "--http", "0.0.0.0:0"],
                                capture_output=True, text=True, timeout=60)
        self.assertEqual(result.returncode, 2)
        self.assertIn("--http 0.0.0.0:0: refused", result.stderr)
        for address in ("7480", "localhost:x", "127.0.0.1:70000", ":1", "a:b:80"):
            result = subprocess.run([BIN / "parray-coordinator", "--bind", "tcp://127.0.0.1:*", "--insecure", "--http", address],
                                    capture_output=True, text=True, timeout=60)
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertIn("is not an address to serve", result.stderr)
        with Web() as farm:
            result = subprocess.run([BIN / "parray-coordinator", "--bind", "tcp://127.0.0.1:*", "--http", farm.web],
                                    capture_output=True, text=True, timeout=60)
            self.assertEqual(result.returncode, 1)
            self.assertIn("cannot be bound", result.stderr)


SCHEMATHESIS = os.environ.get("SCHEMATHESIS") or shutil.which("schemathesis")


@unittest.skipUnless(SCHEMATHESIS, "schemathesis (PyPI) is not installed: put it into PATH, or name it by SCHEMATHESIS")
class Description(WebCase):
    def test_the_server_does_what_its_description_says(self):
        with Web() as farm:
            worker = farm.start_worker("one")
            farm.submitted(farm.post_scene())
            settings = farm.directory / "schemathesis.toml"
            # What fits the description can still be no scene: 422. Streams do not end.
            settings.write_text('[checks.positive_data_acceptance]\n'
                                'expected-statuses = ["2xx", "304", "401", "403", "404", "409", "422"]\n')
            result = subprocess.run([SCHEMATHESIS, "--config-file", settings, "run",
                                     f"http://{farm.web}/api/v1/openapi.json", "--exclude-path-regex", "/events$",
                                     "--max-examples", "10", "--seed", "1", "--request-timeout", "60"],
                                    capture_output=True, text=True, timeout=1000, cwd=farm.directory)
            self.assertEqual(result.returncode, 0, result.stdout[-6000:] + result.stderr[-2000:])
            self.assertIsNone(worker.poll())
            self.assertEqual(farm.ask("GET", "/readyz").status, 200)


if __name__ == "__main__":
    unittest.main()
