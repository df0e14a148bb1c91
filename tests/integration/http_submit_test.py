#!/usr/bin/env python3
"""What POST /api/v1/jobs and POST /api/v1/plan take: denoising, options of particle files, series of frames, and
forecasts, with real processes."""

import json
import resource
import struct
import tempfile
import unittest

from exr import read_exr
from farm import SCENES, run, wait_for
from png import read_rgb
from web import SCENE, WATER, Web, WebCase, form

HELIX = SCENES / "particles/helix.pdb"
SMALL = {"width": 48, "height": 36, "spp": 4}


def options(**values):
    return "options", None, json.dumps(values)


def trajectory(frames):
    """An XYZ file whose atoms move apart."""
    return "".join(f"2\nframe {i}\nO 0 0 0\nO {1 + i / 4} 0 0\n" for i in range(frames))


class SubmitCase(WebCase):
    def done(self, farm, answer):
        job = farm.submitted(answer)
        wait_for(lambda: farm.state(job) == "done", "the picture")
        return job

    def kept(self, farm, name, answer):
        self.assertEqual(answer.status, 200, answer.body)
        path = farm.directory / name
        path.write_bytes(answer.body)
        return path


class Denoising(SubmitCase):
    def check_denoised(self, farm, job):
        """The pictures have the bits that `parray fetch` writes."""
        fetched, raw, png = (farm.directory / name for name in ("fetched.exr", "raw.exr", "fetched.png"))
        for path, more in ((fetched, ()), (raw, ("--raw",)), (png, ())):
            result = farm.client("fetch", job, "-o", path, *more)
            self.assertEqual(result.returncode, 0, result.stderr)
        expected = read_exr(fetched)[0]
        before = read_exr(raw)[0]
        got = read_exr(self.kept(farm, "got.exr", farm.get(f"/jobs/{job}/image.exr")))[0]
        self.assertEqual([expected[f"raw.{c}"] for c in "RGB"], [before[c] for c in "RGB"])
        self.assertNotEqual(expected["R"], before["R"])
        for channel in ("R", "G", "B", "raw.R", "raw.G", "raw.B"):
            self.assertEqual(got[channel], expected[channel], channel)
        shown = self.kept(farm, "got.png", farm.get(f"/jobs/{job}/image.png"))
        self.assertEqual(read_rgb(shown), read_rgb(png))
        pixels = struct.unpack(f"<{3 * len(got['R'])}f", farm.get(f"/jobs/{job}/pixels.f32").body)
        self.assertEqual([list(pixels[c::3]) for c in range(3)], [list(got[c]) for c in "RGB"])

    def test_the_pictures_of_a_done_job_are_denoised_also_after_a_restart(self):
        with tempfile.TemporaryDirectory() as state, Web("--state", state) as farm:
            worker = farm.start_worker("one")
            job = self.done(farm, farm.post_form(("scene", None, json.dumps(SCENE)), options(denoise=True, spp=16)))
            self.assertIs(farm.get(f"/jobs/{job}").json()["denoise"], True)
            self.check_denoised(farm, job)
            worker.kill()
            farm.coordinator.kill()
            farm.coordinator.wait()
            farm.start_coordinator()
            self.check_denoised(farm, job)

    def test_without_a_state_and_from_the_command_line_it_is_the_same(self):
        with Web() as farm:
            farm.start_worker("one")
            (farm.directory / "scene.json").write_text(json.dumps(SCENE))
            job = farm.submit(farm.directory / "scene.json", "--denoise", "--spp", "16")
            wait_for(lambda: farm.state(job) == "done", "the picture")
            self.check_denoised(farm, job)
            plain = self.done(farm, farm.post_scene())
            self.assertIs(farm.get(f"/jobs/{plain}").json()["denoise"], False)

    def test_an_unfinished_picture_is_not_denoised(self):
        with Web() as farm:
            farm.start_worker("one")
            job = farm.submitted(farm.post_form(("scene", None, json.dumps(SCENE)),
                                                options(denoise=True, spp=10**6, progressive=True)))
            answer = wait_for(lambda: (lambda a: a if a.status == 200 else None)(farm.get(f"/jobs/{job}/image.exr")),
                              "a first picture")
            self.assertEqual(answer.headers["Parray-Partial"], "1")
            self.assertEqual(set(read_exr(self.kept(farm, "now.exr", answer))[0]), {"R", "G", "B"})

    def test_a_target_of_the_denoised_picture_is_refused_with_a_pointer(self):
        with Web() as farm:
            answer = farm.post_form(("scene", None, json.dumps(SCENE)), options(denoise=True, target_error=0.01))
            self.assertIn("options: /target_error", self.assert_problem(answer, 422, "denoise"))


class Particles(SubmitCase):
    def report(self, farm, job):
        return farm.get(f"/jobs/{job}/report").json()

    def test_options_of_particle_files_give_the_bits_of_the_command_line(self):
        with Web() as farm:
            farm.start_worker("one")
            cases = [({"select": "resid 1:5", "color_by": "element", "view": "front", "style": "flat", "zoom": 1.1},
                      ["--select", "resid 1:5", "--color-by", "element", "--view", "front", "--style", "flat",
                       "--zoom", "1.1"]),
                     ({"color_by": "z", "colormap": "magma", "range": [0, 5], "radius": "covalent", "up": [0, 1, 1],
                       "azimuth": 20, "crystal": False, "show": [{"select": "element N", "radius": 1.5}]},
                      ["--color-by", "z", "--colormap", "magma", "--range", "0:5", "--radius", "covalent", "--up", "0,1,1",
                       "--azimuth", "20", "--crystal", "off", "--show", "element N", "--radius", "1.5"]),
                     ({"style": ["flat", "sticks"], "stick_radius": 0.2, "bonds": "auto",
                       "show": [{"select": "resid 1:5"}, {"select": "resid 6:12", "style": "balls-and-sticks"}]},
                      ["--style", "flat,sticks", "--stick-radius", "0.2", "--bonds", "auto", "--show", "resid 1:5",
                       "--show", "resid 6:12", "--style", "balls-and-sticks"])]
            for given, words in cases:
                job = self.done(farm, farm.post_form(("f", "helix.pdb", HELIX.read_bytes()), options(**SMALL, **given)))
                other = farm.submit(HELIX, "--width", "48", "--height", "36", "--spp", "4", *words)
                wait_for(lambda: farm.state(other) == "done", "the picture")
                self.assertEqual(self.report(farm, job)["image_sha256"], self.report(farm, other)["image_sha256"])

    def test_quality_is_that_of_the_command_line(self):
        with Web() as farm:
            job = farm.submitted(farm.post_form(("f", "water.xyz", WATER), options(quality="draft")))
            shown = farm.get(f"/jobs/{job}").json()
            self.assertEqual((shown["width"], shown["target_error"], shown["denoise"]), (600, 0.05, True))

    def test_wrong_options_are_refused_with_a_pointer_and_a_remedy(self):
        water = ("f", "water.xyz", WATER)
        with Web() as farm:
            for part, given, pointer, remedy in (
                    (water, {"selekt": "all"}, "options: /selekt: unknown option", "did you mean 'select'?"),
                    (water, {"select": "elephant O"}, "options: /select: ", ""),
                    (water, {"color_by": "vz"}, "", "color_by"),
                    (water, {"view": "abve"}, "options: /view: ", ""),
                    (water, {"spp": 0}, "options: /spp: '0' is not a whole number", ""),
                    (water, {"topology": "/etc/passwd"}, "options: /topology: '/etc/passwd' is a path", "write only its name"),
                    (water, {"topology": "../x.pdb"}, "options: /topology: '../x.pdb' is a path", ""),
                    (water, {"help": True}, "options: /help: unknown option", ""),
                    (water, {"first": 3}, "options: /first: unknown option", ""),
                    (water, {"threads": 3}, "options: /threads: unknown option", ""),
                    (water, {"memory": 3}, "options: /memory: unknown option", ""),
                    (water, {"like": "a.exr"}, "options: /like: not possible by HTTP",
                     "give the settings of the picture as options, or use parray render --like"),
                    (water, {"transparent": True}, "transparent: not possible", "leave it out, or use parray render"),
                    (("scene", None, json.dumps({**SCENE, "image": {"transparent": True}})), {}, "transparent: not possible",
                     "leave it out, or use parray render"),
                    (water, {"--spp": 3}, "options: /--spp: unknown option", ""),
                    (water, {"output": "/tmp/x"}, "options: /output: unknown option", ""),
                    (water, {"select": {"a": 1}}, "options: /select: use a string", ""),
                    (("scene", None, json.dumps(SCENE)), {"select": "all"}, "options: /select: ", "is not a particle file"),
            ):
                detail = self.assert_problem(farm.post_form(part, options(**given)), 422, remedy)
                self.assertIn(pointer, detail)
                self.assertNotIn("parray submit", detail)
            self.assertEqual(farm.get("/jobs").json()["jobs"], [])

    def test_an_upload_that_the_disk_cannot_store_is_refused(self):
        with Web() as farm:
            whole = resource.prlimit(farm.coordinator.pid, resource.RLIMIT_FSIZE)
            resource.prlimit(farm.coordinator.pid, resource.RLIMIT_FSIZE, (100, whole[1]))  # each file has only this room
            cut = "x,y,z\n" + "1,2,3\n" * 50
            for parts in ((("scene", None, json.dumps(SCENE)),), (("f", "a.csv", cut),), (("g", "b.csv", cut), ("scene", "a.csv", "1,2,3"))):
                self.assert_problem(farm.post_form(*parts), 503, "the server's disk may be full")
            resource.prlimit(farm.coordinator.pid, resource.RLIMIT_FSIZE, whole)
            self.assertEqual(farm.get("/jobs").json()["jobs"], [])
            farm.submitted(farm.post_form(("f", "a.csv", cut)))

    def test_the_media_type_of_a_form_may_have_capital_letters(self):
        with Web() as farm:
            for kind, boundary in (("Multipart/Form-Data", "boundary"), ("multipart/form-data", "Boundary")):
                body, _ = form(("scene", None, json.dumps(SCENE)))
                farm.submitted(farm.ask("POST", "/api/v1/jobs", body.replace(b"a-mark", b"A-Mark"),
                                        {"Content-Type": f"{kind}; {boundary}=----A-Mark-of-parts"}))

    def test_two_scenes_in_a_form_are_refused(self):
        scene = ("scene", None, json.dumps(SCENE))
        with Web() as farm:
            for again in (scene, ("scene", "b.json", json.dumps(SCENE))):
                self.assert_problem(farm.post_form(scene, again), 422, "send one request for each scene")
            self.assert_problem(farm.post_form(("a", "a.xyz", WATER), ("b", "b.xyz", WATER)), 422, "one request for each file")
            self.assert_problem(farm.post_form(scene, options(), options()), 422, "two parts are named 'options'")
            self.assertEqual(farm.get("/jobs").json()["jobs"], [])


class Labels(SubmitCase):
    CASES = (({"color_by": "z", "legend": True, "style": "publication", "view": "front", "text": "helix", "depth_cue": 0.4},
              ["--color-by", "z", "--legend", "--style", "publication", "--view", "front", "--text", "helix",
               "--depth-cue", "0.4"]),
             ({"background": "white", "scale_bar": True, "denoise": True},
              ["--background", "white", "--scale-bar", "--denoise"]))

    def test_a_finished_png_has_labels_outlines_and_background_as_the_command_line_draws_them(self):
        size = {"width": 240, "height": 180, "spp": 8}
        with tempfile.TemporaryDirectory() as state, Web("--state", state) as farm:
            farm.start_worker("one")
            for given, words in self.CASES:
                job = self.done(farm, farm.post_form(("f", "helix.pdb", HELIX.read_bytes()), options(**size, **given)))
                self.assertIs(farm.get(f"/jobs/{job}").json()["drawn"], True)
                shown = read_rgb(self.kept(farm, "shown.png", farm.get(f"/jobs/{job}/image.png")))
                for name, result in (
                        ("fetched.png", farm.client("fetch", job, "-o", farm.directory / "fetched.png")),
                        ("local.png", run("render", HELIX, "-q", "--width", "240", "--height", "180", "--spp", "8", *words,
                                          "-o", farm.directory / "local.png"))):
                    self.assertEqual(result.returncode, 0, result.stderr)
                    self.assertEqual(shown, read_rgb(farm.directory / name), (name, given))
                self.assertEqual(farm.get(f"/jobs/{job}/image.exr").status, 200)

    def test_labels_of_options_must_fit_and_those_of_a_scene_are_left_out_if_they_do_not(self):
        with Web() as farm:
            helix = "f", "helix.pdb", HELIX.read_bytes()
            self.assert_problem(farm.post_form(helix, options(width=20, height=15, spp=1, color_by="z", legend=True)), 422)
            self.assertIn("options: /legend_title", self.assert_problem(
                farm.post_form(helix, options(legend_title="depth")), 422, "has no effect without a legend"))
            series = farm.post_form(("f", "run.xyz", trajectory(2)), options(width=20, height=15, spp=1, frames="all",
                                                                             color_by="z", legend=True))
            self.assertNotIn("frame 0", self.assert_problem(series, 422))  # all frames have the labels
            labelled = {**SCENE, "labels": {"text": "a long text that fits no small picture"}, "image": {"width": 8, "height": 8}}
            small = farm.submitted(farm.post_scene(labelled))
            self.assertNotIn("drawn", farm.get(f"/jobs/{small}").json())
            large = farm.submitted(farm.post_scene({**labelled, "image": {"width": 900, "height": 600}}))
            self.assertIs(farm.get(f"/jobs/{large}").json()["drawn"], True)


class Frames(SubmitCase):
    def frames_of(self, farm, series):
        return {entry["frame"]: entry["job"] for entry in farm.get(f"/jobs/{series}").json()["frame_list"]}

    def hashes(self, farm, jobs):
        for job in jobs:
            wait_for(lambda: farm.state(job) == "done", "a frame")
        return [farm.get(f"/jobs/{job}/report").json()["image_sha256"] for job in jobs]

    def test_a_trajectory_becomes_a_series_with_the_camera_of_its_first_frame(self):
        with Web() as farm:
            farm.start_worker("one")
            answer = farm.post_form(("f", "run.xyz", trajectory(5)), options(**SMALL, frames="0:4:2", name="apart"))
            self.assertEqual(answer.status, 201, answer.body)
            self.assertEqual(answer.json()["frames"], 3)
            series = answer.json()["id"]
            self.assertEqual(answer.headers["Location"], f"/api/v1/jobs/{series}")
            frames = self.frames_of(farm, series)
            self.assertEqual(list(frames), [0, 2, 4])
            shown = farm.get(f"/jobs/{series}").json()
            self.assertEqual((shown["frames"], shown["name"]), (3, "apart"))
            look = farm.post_form(("f", "run.xyz", trajectory(1)), options(**SMALL, preview_of=frames[2]))
            self.assert_problem(look, 422, f"job {frames[2]} is a frame of series {series}: name the series")

            (farm.directory / "run.xyz").write_text(trajectory(5))
            scene = farm.directory / "run.json"
            made = farm.client("convert", farm.directory / "run.xyz", scene, "--width", "48", "--height", "36")
            self.assertEqual(made.returncode, 0, made.stderr)
            submitted = farm.client("submit", scene, "--frames", "0-4:2", "--spp", "4")
            self.assertEqual(submitted.returncode, 0, submitted.stderr)
            others = self.frames_of(farm, int(submitted.stdout))
            self.assertEqual(self.hashes(farm, frames.values()), self.hashes(farm, others.values()))

            scene_parts = ("scene", "run.json", scene.read_bytes()), ("f", "run.xyz", trajectory(5))
            named = farm.post_form(*scene_parts, options(spp=4, frames="all"))
            self.assertEqual(named.json()["frames"], 5)
            self.assertEqual(self.hashes(farm, self.frames_of(farm, named.json()["id"]).values())[::2],
                             self.hashes(farm, frames.values()))

    def test_a_repeated_request_makes_no_second_series(self):
        with Web() as farm:
            post = lambda **more: farm.post_form(("f", "run.xyz", trajectory(4)), options(**SMALL, frames="all", **more),
                                                 **{"Idempotency-Key": "once"})
            first = post().json()
            self.assertEqual(first["frames"], 4)
            self.assertEqual(post().json(), first)
            self.assertEqual(len(farm.get("/jobs").json()["jobs"]), 1)
            self.assert_problem(post(name="b"), 422, "different content")

    def test_a_frame_that_cannot_be_read_is_named_with_what_was_submitted(self):
        broken = trajectory(2) + "2\nframe 2\nO 0 0 0\nO x 0 0\n" + trajectory(1)
        with Web() as farm:
            answer = farm.post_form(("f", "run.xyz", broken), options(**SMALL, frames="0:3"))
            detail = self.assert_problem(answer, 422, "has 2 of 4 frames")
            self.assertIn("frame 2: run.xyz:", detail)
            series = farm.get("/jobs").json()["jobs"][0]
            self.assertEqual(series["frames"], 4)
            self.assertIn(f"series {series['id']} has 2 of 4", detail)

    def test_a_series_of_frames_that_do_not_exist_is_refused_and_makes_no_job(self):
        with Web() as farm:
            for frames, problem in (("0:9", "frame 9: run.xyz:"), ("0:9:4", "frame 8: run.xyz:"),
                                    ("1-3", "is not a range of frames"), ("9:0", "is not"),
                                    ("0:99999", "more than the limit"), ("5", "frame 5: ")):
                body, kind = form(("f", "run.xyz", trajectory(2)), options(**SMALL, frames=frames))
                for path in ("/api/v1/jobs", "/api/v1/plan"):
                    self.assert_problem(farm.ask("POST", path, body, {"Content-Type": kind}), 422, problem)
            self.assert_problem(farm.post_form(("scene", None, json.dumps(SCENE)), options(frames="all")), 422,
                                "names no trajectory")
            self.assert_problem(farm.post_form(("f", "run.xyz", trajectory(2)), options(frames="all", frame=1)), 422,
                                "exclude each other")
            self.assertEqual(farm.get("/jobs").json()["jobs"], [])

    def test_more_frames_than_a_batch_are_submitted(self):
        with Web() as farm:
            answer = farm.post_form(("f", "run.xyz", trajectory(300)), options(**SMALL, frames="all"))
            self.assertEqual(answer.json()["frames"], 300)
            self.assertEqual(len(self.frames_of(farm, answer.json()["id"])), 300)


class Plans(SubmitCase):
    def plan(self, farm, *parts):
        body, kind = form(*parts)
        answer = farm.ask("POST", "/api/v1/plan", body, {"Content-Type": kind})
        self.assertEqual(answer.status, 200, answer.body)
        return answer.json()

    def check_interval(self, interval):
        self.assertGreater(interval["low"], 0)
        self.assertLess(interval["low"], interval["expected"])
        self.assertLess(interval["expected"], interval["high"])

    def test_a_forecast_says_time_samples_and_error_and_stores_nothing(self):
        size = {"width": 48, "height": 36}
        scene = ("scene", None, (SCENES / "glass.json").read_text())
        with Web() as farm:
            alone = self.plan(farm, scene, options(**size, spp=64))
            self.assertEqual((alone["threads"], alone["seconds"], alone["queue_seconds"]), (0, None, None))
            self.assertIn("No workers are connected.", alone["notes"])
            farm.start_worker("one")
            wait_for(lambda: farm.get("/workers").json()["total"] == 1, "the worker")
            counted = self.plan(farm, scene, options(**size, spp=64))
            self.assertEqual((counted["threads"], counted["samples_per_pixel"]), (1, 64))
            self.check_interval(counted["seconds"])
            self.assertGreater(counted["thread_seconds"], 0)
            self.assertGreater(counted["error"]["rmse"], 0)
            self.assertEqual(counted["queue_seconds"], 0)
            more = self.plan(farm, scene, options(**size, spp=640))
            self.assertGreater(more["thread_seconds"], 4 * counted["thread_seconds"])
            self.assertLess(more["error"]["rmse"], counted["error"]["rmse"])
            target = self.plan(farm, scene, options(**size, target_error=0.01))
            self.check_interval(target["seconds"])
            self.assertLessEqual(target["error"]["rmse"], 0.01)
            limited = self.plan(farm, scene, options(**size, time_limit=20))
            self.assertLess(limited["seconds"]["expected"], 20.5)
            self.assertGreater(limited["samples_per_pixel"], 1)
            both = self.plan(farm, scene, options(**size, time_limit=20, target_error=0.0002))
            self.check_interval(both["seconds"])
            self.assertLessEqual(both["seconds"]["high"], 20)
            self.assertEqual(farm.get("/jobs").json()["jobs"], [])

    def test_a_series_is_forecast_as_a_whole_and_bad_input_is_refused(self):
        with Web() as farm:
            farm.start_worker("one")
            wait_for(lambda: farm.get("/workers").json()["total"] == 1, "the worker")
            moving = ("f", "run.xyz", trajectory(20))
            series = self.plan(farm, moving, options(**SMALL, frames="all"))
            single = self.plan(farm, moving, options(**SMALL))
            self.assertGreater(series["thread_seconds"], 4 * single["thread_seconds"])
            answer = farm.ask("POST", "/api/v1/plan", "{}", {"Content-Type": "application/json"})
            self.assert_problem(answer, 422)
            half_width = self.plan(farm, moving, options(target_half_width=0.01, target_error=0.01))
            self.assertIn("The forecast ignores the target half-width.", half_width["notes"])


if __name__ == "__main__":
    unittest.main()
