#!/usr/bin/env python3
"""A series of frames on a farm: each frame has the bits of `parray render`, whatever is killed meanwhile, and a frame
that cannot be rendered does not stop the others."""

import json
import pathlib
import signal
import tempfile
import unittest

from farm import SCENES, Farm, run, wait_for

SIZE = ["--width", "64", "--height", "40", "--spp", "8"]


def scene(x=0.0, camera=None, **more):
    return {"version": 1,
            "camera": camera or {"look_from": [x, 1, 8], "look_at": [0, 0, 0], "vfov": 40},
            "materials": {"red": {"type": "diffuse", "albedo": [0.8, 0.2, 0.2]}},
            "spheres": [{"center": [0, 0, 0], "radius": 1, "material": "red"}], **more}


def write(path, document):
    path.write_text(document if isinstance(document, str) else json.dumps(document))
    return path


class FrameCase(unittest.TestCase):
    def setUp(self):
        directory = tempfile.TemporaryDirectory()
        self.addCleanup(directory.cleanup)
        self.directory = pathlib.Path(directory.name)

    def rendered(self, name, document):
        """What `parray render` makes of one frame."""
        path = write(self.directory / f"{name}.json", document)
        report = self.directory / f"{name}-report.json"
        result = run("render", path, *SIZE, "-o", self.directory / f"{name}.png", "--report", report)
        self.assertEqual(result.returncode, 0, result.stderr)
        return json.loads(report.read_text())["image_sha256"]

    def outputs(self):
        return ["-o", self.directory / "out-####.exr", "--report", self.directory / "out-####.json"]

    def written(self, frame):
        report = json.loads((self.directory / f"out-{frame:04}.json").read_text())
        self.assertTrue((self.directory / f"out-{frame:04}.exr").exists())
        return report["image_sha256"]

    def submit(self, farm, *arguments, expected=0):
        result = farm.client("submit", *arguments, *SIZE, "--wait", *self.outputs())
        self.assertEqual(result.returncode, expected, result.stderr)
        return result


class Kinds(FrameCase):
    def test_numbered_scenes_a_camera_path_and_a_trajectory_give_the_bits_of_each_frame_alone(self):
        with Farm() as farm:
            farm.start_worker("a")
            farm.start_worker("b")
            self.numbered_scenes(farm)
            self.camera_path(farm)
            self.trajectory(farm)
            jobs = json.loads(farm.client("jobs", "--json").stdout)
            self.assertEqual([(job["frames"], job["frames_done"]) for job in jobs], [(3, 3)] * 3)
            self.assertIn("done 3/3 frames", farm.client("jobs").stdout)

    def numbered_scenes(self, farm):
        for frame in (1, 3, 5):
            write(self.directory / f"scene-{frame:03}.json", scene(frame))
        result = self.submit(farm, self.directory / "scene-###.json", "--frames", "1-5:2")
        for frame in (1, 3, 5):
            self.assertEqual(self.written(frame), self.rendered("alone", scene(frame)))
        series = int(result.stdout.split()[0])
        refused = farm.client("fetch", series, "-o", self.directory / "one.png")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("is a series of frames: write ####", refused.stderr)
        single = farm.client("fetch", series + 1, "-o", self.directory / "one-#.png")
        self.assertIn("is not a series of frames", single.stderr)
        fetched = farm.client("fetch", series, "-o", self.directory / "again-##.png")
        self.assertEqual(fetched.returncode, 0, fetched.stderr)
        self.assertEqual(sorted(p.name for p in self.directory.glob("again-*")),
                         ["again-01.png", "again-03.png", "again-05.png"])

    def camera_path(self, farm):
        keys = [{"frame": 0, "look_from": [-4, 1, 8], "look_at": [0, 0, 0], "vfov": 40},
                {"frame": 2, "look_from": [4, 3, 8], "look_at": [0, 1, 0], "vfov": 30}]
        path = write(self.directory / "path.json", {"cameras": keys})
        still = write(self.directory / "still.json", scene())
        self.submit(farm, still, "--camera-path", path, "--frames", "0-2")
        middle = {"look_from": [0, 2, 8], "look_at": [0, 0.5, 0], "vfov": 35}
        for frame, camera in enumerate([keys[0], middle, keys[1]]):
            camera = {key: value for key, value in camera.items() if key != "frame"}
            self.assertEqual(self.written(frame), self.rendered("alone", scene(camera=camera)))

    def trajectory(self, farm):
        write(self.directory / "dance.xyz", "".join(
            f"2\nstep\nC {x} 0 0\nO 0 {x} 0\n" for x in (0.5, 1, 1.5)))
        moving = write(self.directory / "moving.json", scene(particles=[{"file": "dance.xyz"}]))
        self.submit(farm, moving, "--frames", "0-2")
        for frame in range(3):
            alone = scene(particles=[{"file": "dance.xyz", "frame": frame}])
            self.assertEqual(self.written(frame), self.rendered("alone", alone))

    def test_another_width_in_print_is_another_series(self):
        write(self.directory / "scene-1.json", scene())
        with Farm() as farm:
            farm.start_worker("a")
            for millimetres, width in ((2, 24), (4, 47)):
                result = farm.client("submit", self.directory / "scene-#.json", "--frames", "1-1", "--spp", "1",
                                     "--width-mm", str(millimetres), "--wait", *self.outputs())
                self.assertEqual(result.returncode, 0, result.stderr)
                report = json.loads((self.directory / "out-0001.json").read_text())
                self.assertEqual(report["width"], width)

    def test_another_size_of_letters_for_which_the_camera_of_a_crystal_makes_room_is_another_series(self):
        write(self.directory / "salt-1.vasp", "NaCl\n1.0\n5.64 0 0\n0 5.64 0\n0 0 5.64\nNa Cl\n4 4\nDirect\n0 0 0\n0 .5 .5\n"
                                              ".5 0 .5\n.5 .5 0\n.5 0 0\n0 .5 0\n0 0 .5\n.5 .5 .5\n")
        with Farm() as farm:
            farm.start_worker("a")
            hashes = set()
            for points in (6, 9):
                result = farm.client("submit", self.directory / "salt-#.vasp", "--frames", "1-1", "--width", "160",
                                     "--height", "120", "--spp", "1", "--font-size", str(points), "--wait", *self.outputs())
                self.assertEqual(result.returncode, 0, result.stderr)
                hashes.add(self.written(1))
            self.assertEqual(len(hashes), 2)
            self.assertEqual(len(json.loads(farm.client("jobs", "--json").stdout)), 2)


class Troubles(FrameCase):
    def test_a_client_killed_in_the_middle_goes_on_when_run_again(self):
        for frame in range(6):
            write(self.directory / f"scene-{frame}.json", scene(frame))
        arguments = ["submit", self.directory / "scene-#.json", "--frames", "0-5", *SIZE, "--wait",
                     *self.outputs()]
        (self.directory / "scene-3.json").rename(self.directory / "hidden")
        with Farm() as farm:
            farm.start_worker("a")
            client = farm.start_client(*arguments)
            wait_for(lambda: (self.directory / "out-0000.json").exists(), "the first frame")
            client.send_signal(signal.SIGKILL)
            client.wait()
            (self.directory / "hidden").rename(self.directory / "scene-3.json")
            result = farm.client(*arguments)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertRegex(result.stderr, "series 1 continues: [1-6] of 6 frames")
            jobs = json.loads(farm.client("jobs", "--json").stdout)
            self.assertEqual([(job["id"], job["state"]) for job in jobs], [(1, "done")])
            self.assertEqual(len(farm.job(1)["frame_list"]), 6)
        for frame in range(6):
            self.assertEqual(self.written(frame), self.rendered("alone", scene(frame)))

    def test_a_frame_that_cannot_be_read_has_a_line_and_the_others_are_rendered(self):
        for frame in (0, 2):
            write(self.directory / f"scene-{frame}.json", scene(frame))
        with Farm() as farm:
            farm.start_worker("a")
            result = self.submit(farm, self.directory / "scene-#.json", "--frames", "0-2",
                                 expected=1)
            self.assertRegex(result.stderr, "parray: frame 1: .*scene-1.json: no such file")
            self.written(0)
            self.written(2)
            shown = farm.job(int(result.stdout.split()[0]))
            self.assertEqual((shown["state"], shown["frames_done"]), ("queued", 2))
            self.assertIn("1 of 3 frames: repeat the same parray submit", shown["waits_for"])

    def test_where_there_is_no_room_the_client_waits_and_goes_on(self):
        for frame in range(2):
            write(self.directory / f"scene-{frame}.json", scene(frame))
        with Farm("--max-user-jobs", "1") as farm:
            blocking = farm.submit(SCENES / "one-weekend-20.json", "--spp", "1000000")
            client = farm.start_client("submit", self.directory / "scene-#.json", "--frames", "0-1",
                                       *SIZE, "--wait", *self.outputs())
            wait_for(lambda: "frame 0 waits" in client.log.read_text(), "the client to wait")
            farm.start_worker("a")
            farm.client("cancel", blocking)
            self.assertEqual(client.wait(timeout=60), 0, client.log.read_text())
            self.written(1)

    def along_path(self, frames, vfov=40):
        """Arguments of a series of one scene along a path."""
        path = {"cameras": [{"frame": frame, "look_from": [frame, 1, 8], "look_at": [0, 0, 0], "vfov": vfov}
                            for frame in (1, frames)]}
        return ["submit", write(self.directory / "still.json", scene()), "--frames", f"1-{frames}",
                "--camera-path", write(self.directory / "path.json", path), *SIZE]

    def frame_list(self, farm, series):
        return [(entry["frame"], entry["job"]) for entry in farm.job(series)["frame_list"]]

    def test_many_frames_are_submitted_at_once_and_in_their_order(self):
        with Farm() as farm:
            result = farm.client(*self.along_path(300))
            self.assertEqual((result.returncode, result.stdout, result.stderr), (0, "1\n", ""))
            first = self.frame_list(farm, 1)[0][1]
            self.assertEqual(self.frame_list(farm, 1), [(frame, first + frame - 1) for frame in range(1, 301)])

    def test_a_client_killed_between_many_submits_goes_on_without_a_frame_twice(self):
        arguments = self.along_path(900)
        state = self.directory / "state"
        with Farm("--state", state) as farm:
            client = farm.start_client(*arguments)
            wait_for(lambda: json.loads(farm.client("jobs", "--json").stdout), "the first frames")
            client.send_signal(signal.SIGKILL)
            client.wait()
            result = farm.client(*arguments)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertRegex(result.stderr, "series 1 continues: [1-9][0-9]* of 900 frames")
            frames = self.frame_list(farm, 1)
            self.assertEqual([frame for frame, _ in frames], list(range(1, 901)))
            self.assertEqual(len({job for _, job in frames}), 900)

    def test_frames_that_the_coordinator_refuses_have_a_line_each_and_the_others_are_taken(self):
        for frame in range(1, 101):
            wide = {"image": {"width": 3000, "height": 3000}} if frame in (40, 41) else {}
            write(self.directory / f"scene-{frame}.json", scene(frame, **wide))
        with Farm("--max-pixels", "1000000") as farm:
            result = farm.client("submit", self.directory / "scene-#.json", "--frames", "1-100", "--spp", "1")
            self.assertEqual(result.returncode, 1, result.stderr)
            lines = result.stderr.splitlines()
            self.assertEqual(len(lines), 2, result.stderr)
            for frame, line in zip((40, 41), lines):
                self.assertRegex(line, f"^parray: frame {frame}: .*pixels")
            self.assertEqual([frame for frame, _ in self.frame_list(farm, 1)],
                             [frame for frame in range(1, 101) if frame not in (40, 41)])

    def test_one_line_says_which_drawings_of_the_scene_files_a_series_lacks(self):
        for number in (1, 2):
            write(self.directory / f"s-{number}.json", scene(finishing={"outline": True}, labels={"text": "a"}))
        with Farm() as farm:
            result = farm.client("submit", self.directory / "s-#.json", "--frames", "1-2")
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual(result.stderr.count("draws no outlines and no depth cue and no labels on the picture"), 1, result.stderr)

    def test_outputs_that_would_replace_an_input_of_any_frame_are_refused(self):
        path = write(self.directory / "path-0002.json", '{"cameras": []}')
        write(self.directory / "run-0001.xyz", "1\n\nC 0 0 0\n" * 3)
        numbered = [write(self.directory / f"s-{frame:04}.json", scene()) for frame in range(3)]
        named = write(self.directory / "named.json", scene(particles=[{"file": "run-0001.xyz"}]))
        write(numbered[2], named.read_text())
        contents = {file: file.read_text() for file in self.directory.iterdir()}
        for arguments, report, says in (
                ([self.directory / "s-####.json"], "s-####.json", "s-0000.json"),
                ([self.directory / "s-####.json"], "run-####.xyz", "run-0001.xyz"),
                ([numbered[0], "--camera-path", path], "path-####.json", "path-0002.json"),
                ([named], "run-####.xyz", "run-0001.xyz")):
            result = run("submit", *arguments, "--frames", "0-2", "--wait", "-o", self.directory / "a-####.png",
                         "--report", self.directory / report)
            with self.subTest(report=report):
                self.assertEqual((result.returncode, result.stdout), (2, ""), result.stderr)
                self.assertEqual(result.stderr,
                                 f"parray: {self.directory / says} is an input file: name another output file\n")
        self.assertEqual({file: file.read_text() for file in self.directory.iterdir()}, contents)

    def test_what_is_no_series_is_refused_before_any_work(self):
        still = write(self.directory / "still.json", scene())
        write(self.directory / "a.xyz", "1\n\nC 0 0 0\n")
        for arguments, says in [
                ([still, "--frames", "5-1"], "is not a range of frames"),
                ([still, "--frames", "0-1", "--wait", "-o", "a.exr"], "write #### for the frame's number"),
                ([still, "--camera-path", "p.json"], "--camera-path"),
                ([self.directory / "a.xyz", "--frames", "0-1"], "automatic camera of a particle file"),
                ([still, "--frames", "0-1", "--wait", "--preview", "p.png"],
                 "--preview: not possible for a series of frames"),
                ([still, "--preview", "p.png", "--frames", "0-1"], "--preview: not possible for a series of frames"),
                ([still, "--display", "h:1", "--frames", "0-1"], "--display: not possible for a series of frames"),
                ([still, "--frames", "0-1", "--wait", "--display", "h:1"],
                 "--display: not possible for a series of frames"),
                ([still, "--frames", "0-1", "--like", "a.exr"], "--like: not possible for a series of frames"),
                ([still, "--frames", "0-1", "--wait", "-o", "a-#.exr", "--denoise"],
                 "--denoise: not possible for a series of frames: leave it out, or render the frames one by one"),
                ([still, "--frames", "0-1", "--wait", "-o", "a-#.png", "--outline", "on"], "--outline: not possible"),
                ([still, "--frames", "0-1", "--wait", "-o", "a-#.exr", "--aov", "depth,samples"],
                 "--aov depth: not possible for a series of frames")]:
            result = run("submit", *arguments)
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertIn(says, result.stderr)
        with Farm() as farm:
            result = farm.client("submit", still, "--frames", "0-1")
            self.assertEqual(result.returncode, 1)
            self.assertIn("all frames would be equal", result.stderr)


if __name__ == "__main__":
    unittest.main()
