#!/usr/bin/env python3
"""What scripts and lists of jobs ask of the HTTP interface: to wait for a job, thumbnails, all pictures of a series,
messages with their remedy."""

import concurrent.futures
import http.client
import io
import json
import select
import struct
import threading
import unittest
import zipfile

from farm import wait_for
from png import read_rgb
from web import SCENE, Web, WebCase

ENDLESS = {**SCENE, "image": {"width": 200, "height": 100}, "render": {"samples_per_pixel": 1000000}}


class Waits(WebCase):
    def test_a_wait_ends_with_its_job(self):
        with Web() as farm:
            job = farm.submitted(farm.post_scene())
            answers = []
            waiters = [threading.Thread(target=lambda: answers.append(farm.get(f"/jobs/{job}?wait=60")))
                       for _ in range(5)]
            for waiter in waiters:
                waiter.start()
            self.assertEqual(farm.get(f"/jobs/{job}?wait=1").json()["state"], "queued")  # there is no worker
            self.assertEqual(answers, [])
            farm.start_worker("one")
            for waiter in waiters:
                waiter.join()
            self.assertEqual([answer.json()["state"] for answer in answers], ["done"] * 5)
            self.assertEqual(farm.get(f"/jobs/{job}?wait=60").json(), farm.get(f"/jobs/{job}").json())

    def test_a_wait_ends_when_its_job_is_cancelled_or_deleted(self):
        with Web() as farm, concurrent.futures.ThreadPoolExecutor() as pool:
            job = farm.submitted(farm.post_scene())
            cancelled = pool.submit(farm.get, f"/jobs/{job}?wait=60")
            farm.ask("POST", f"/api/v1/jobs/{job}/cancel")
            self.assertEqual(cancelled.result().json()["state"], "cancelled")
            self.assertEqual(farm.ask("DELETE", f"/api/v1/jobs/{job}").status, 204)
            self.assert_problem(farm.get(f"/jobs/{job}?wait=60"), 404)
            for wait in ("0", "61", "x", ""):
                self.assert_problem(farm.get(f"/jobs/{job}?wait={wait}"), 400, "wait: ")

    def test_500_clients_that_wait_stop_no_other(self):
        """They come from two addresses, because one address has at most 256 connections."""
        with Web("--http-streams", "40") as farm:
            job = farm.submitted(farm.post_scene())
            host, port = farm.web.split(":")
            waiting = []
            for i in range(500):
                connection = http.client.HTTPConnection(host, int(port), timeout=60,
                                                        source_address=(f"127.0.0.{2 + i % 2}", 0))
                connection.request("GET", f"/api/v1/jobs/{job}?wait=60")
                waiting.append(connection)
            for _ in range(20):
                self.assertEqual(farm.get("/jobs").status, 200)
            stream = http.client.HTTPConnection(farm.web, timeout=60)
            stream.request("GET", "/api/v1/events")
            self.assertEqual(stream.getresponse().status, 200)
            refused = select.poll()
            for connection in waiting:
                refused.register(connection.sock, select.POLLIN)
            wait_for(lambda: len(refused.poll(0)) >= 460, "the refusals")  # the others wait until the job is done
            farm.start_worker("one")
            statuses = []
            for connection in waiting:
                answer = connection.getresponse()
                if answer.status == 503:
                    self.assertTrue(answer.headers["Retry-After"])
                else:
                    self.assertEqual(json.loads(answer.read())["state"], "done")
                statuses.append(answer.status)
                connection.close()
            self.assertEqual({200: statuses.count(200), 503: statuses.count(503)}, {200: 40, 503: 460})
            stream.close()


def srgb_byte(value):
    value = min(max(value, 0), 1)
    return round(255 * (12.92 * value if value <= 0.0031308 else 1.055 * value ** (1 / 2.4) - 0.055))


class Thumbnails(WebCase):
    def pixels(self, farm, answer):
        path = farm.directory / "thumbnail.png"
        path.write_bytes(answer.body)
        return read_rgb(path)

    def test_a_thumbnail_is_the_mean_of_linear_values(self):
        with Web() as farm:
            farm.start_worker("one")
            job = farm.submitted(farm.post_scene({**SCENE, "image": {"width": 96, "height": 60}}))
            self.assertEqual(farm.get(f"/jobs/{job}?wait=60").json()["state"], "done")
            linear = struct.unpack(f"<{96 * 60 * 3}f", farm.get(f"/jobs/{job}/pixels.f32").body)
            small = farm.get(f"/jobs/{job}/image.png?width=32")
            self.assertEqual((small.status, small.headers["Content-Type"]), (200, "image/png"))
            width, height, found = self.pixels(farm, small)
            self.assertEqual((width, height), (32, 20))
            for y in range(20):
                for x in range(32):
                    for channel in range(3):
                        mean = sum(linear[((3 * y + j) * 96 + 3 * x + i) * 3 + channel]
                                   for j in range(3) for i in range(3)) / 9
                        self.assertAlmostEqual(found[(y * 32 + x) * 3 + channel], srgb_byte(mean), delta=1)
            again = farm.get(f"/jobs/{job}/image.png?width=32", **{"If-None-Match": small.headers["ETag"]})
            self.assertEqual((again.status, again.body), (304, b""))
            whole = farm.get(f"/jobs/{job}/image.png")
            self.assertNotEqual(whole.headers["ETag"], small.headers["ETag"])
            self.assertEqual(self.pixels(farm, whole)[:2], (96, 60))
            self.assertEqual(self.pixels(farm, farm.get(f"/jobs/{job}/image.png?width=1024"))[:2], (96, 60))
            self.assertEqual(self.pixels(farm, farm.get(f"/jobs/{job}/image.png?width=25"))[:2], (25, 16))
            for wrong in ("15", "1025", "-64", "x"):
                self.assert_problem(farm.get(f"/jobs/{job}/image.png?width={wrong}"), 400, "width: ")
            self.assert_problem(farm.get(f"/jobs/{job}/image.exr?width=64"), 400, "unknown parameter 'width'")

    def test_an_unfinished_job_has_a_thumbnail(self):
        with Web() as farm:
            farm.start_worker("one")
            job = farm.submitted(farm.post_scene(ENDLESS))
            small = wait_for(lambda: (lambda a: a if a.status == 200 else None)(
                farm.get(f"/jobs/{job}/image.png?width=64")), "a thumbnail")
            self.assertEqual((self.pixels(farm, small)[:2], small.headers["Parray-Partial"]), ((64, 32), "1"))


class Archives(WebCase):
    def test_the_done_frames_of_a_series_come_as_a_zip_file(self):
        with Web() as farm:
            farm.start_worker("one")
            scene = farm.directory / "scene.json"
            scene.write_text(json.dumps(SCENE))
            path = farm.directory / "path.json"
            path.write_text(json.dumps({"cameras": [
                {"frame": frame, "look_from": [frame, 0, 5], "look_at": [0, 0, 0], "vfov": 40} for frame in (0, 5)]}))
            result = farm.client("submit", scene, "--frames", "0-5", "--camera-path", path)
            self.assertEqual(result.returncode, 0, result.stderr)
            series = next(job["id"] for job in farm.get("/jobs").json()["jobs"] if "frames" in job)
            self.assertEqual(farm.get(f"/jobs/{series}?wait=60").json()["state"], "done")
            frames = farm.get(f"/jobs/{series}").json()["frame_list"]
            answer = farm.get(f"/jobs/{series}/frames.zip")
            self.assertEqual((answer.status, answer.headers["Content-Type"]), (200, "application/zip"))
            archive = zipfile.ZipFile(io.BytesIO(answer.body))
            self.assertIsNone(archive.testzip())
            self.assertEqual(archive.namelist(), [f"frame-{frame:04}.png" for frame in range(6)])
            self.assertEqual({member.compress_type for member in archive.infolist()}, {zipfile.ZIP_STORED})
            for frame in frames:
                picture = farm.get(f"/jobs/{frame['job']}/image.png").body
                self.assertEqual(archive.read(f"frame-{frame['frame']:04}.png"), picture)
            self.assertEqual(farm.get(f"/jobs/{series}/frames.zip").body, answer.body)
            head = farm.ask("HEAD", f"/api/v1/jobs/{series}/frames.zip")
            self.assertEqual((head.status, head.body), (200, b""))

    def test_what_is_no_series_or_has_no_done_frame_has_no_zip_file(self):
        with Web() as farm:
            job = farm.submitted(farm.post_scene())
            self.assert_problem(farm.get(f"/jobs/{job}/frames.zip"), 409, "is not a series")
            self.assert_problem(farm.get("/jobs/99/frames.zip"), 404)
            scene = farm.directory / "scene-0.json"
            scene.write_text(json.dumps(SCENE))
            farm.client("submit", farm.directory / "scene-#.json", "--frames", "0-0")
            series = next(job["id"] for job in farm.get("/jobs").json()["jobs"] if "frames" in job)
            self.assert_problem(farm.get(f"/jobs/{series}/frames.zip"), 409, "no frame of series")


class Names(WebCase):
    def test_submit_names_a_job_and_all_frames_of_a_series(self):
        with Web() as farm:
            scene = farm.directory / "scene-0.json"
            scene.write_text(json.dumps(SCENE))
            job = farm.submit(scene, "--name", "a pool")
            self.assertEqual(farm.get(f"/jobs/{job}").json()["name"], "a pool")
            series = farm.submit(farm.directory / "scene-#.json", "--frames", "0-0", "--name", "pools")
            self.assertEqual(farm.get(f"/jobs/{series}").json()["name"], "pools")
            result = farm.client("submit", scene, "--name", "")
            self.assertEqual(result.returncode, 2)
            self.assertIn("--name", result.stderr)


class Remedies(WebCase):
    def test_the_page_of_the_description_is_served_and_runs_only_its_own_scripts(self):
        with Web() as farm:
            page = farm.ask("GET", "/api")
            self.assertEqual((page.status, page.headers["Content-Type"]), (200, "text/html; charset=utf-8"))
            self.assertIn("script-src 'self';", page.headers["Content-Security-Policy"])
            for asset in ("api_page.js", "api.css"):
                self.assertIn(asset.encode(), page.body)
                self.assertEqual(farm.ask("GET", "/" + asset).status, 200)

    def test_a_wrong_media_type_names_the_header_to_send(self):
        with Web() as farm:
            curl = {"Content-Type": "application/x-www-form-urlencoded"}
            for headers, named in ((curl, "'application/x-www-form-urlencoded' is not supported"),
                                   ({}, "the request has no Content-Type")):
                detail = self.assert_problem(farm.ask("POST", "/api/v1/jobs", json.dumps(SCENE), headers), 415, named)
                self.assertIn("'Content-Type: application/json'", detail)
            job = farm.submitted(farm.post_scene())
            detail = self.assert_problem(farm.ask("PUT", f"/api/v1/jobs/{job}/priority", '{"priority": 3}', curl), 415)
            self.assertIn("'Content-Type: application/json'", detail)


if __name__ == "__main__":
    unittest.main()
