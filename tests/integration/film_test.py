#!/usr/bin/env python3
"""parray film: frames with one camera, here or on a farm; what an interrupted film keeps; what ffmpeg is told."""

import json
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import unittest

from farm import BIN, Farm, run, wait_for
from png import read_rgb

SIZE = ["--width", "48", "--height", "36"]
FRAMES = 6
FAKE_FFMPEG = """#!/bin/sh
for last; do :; done
printf '%s\\n' "$@" > "$(dirname "$0")/arguments"
echo film > "$last"
"""
BROKEN_FFMPEG = """#!/bin/sh
echo 'first line' >&2
echo 'no such encoder' >&2
exit 3
"""


def trajectory(frames=FRAMES):
    """Two atoms, one of which moves, and a number that grows."""
    return "".join("2\nProperties=species:S:1:pos:R:3:speed:R:1\n"
                   f"O 0 0 0 0\nC {2 + 0.5 * frame} 0 1 {frame}\n" for frame in range(frames))


class FilmCase(unittest.TestCase):
    def setUp(self):
        directory = tempfile.TemporaryDirectory(prefix="parray-film-")
        self.addCleanup(directory.cleanup)
        self.directory = pathlib.Path(directory.name)
        self.run_file = self.path("run.xyz")
        self.run_file.write_text(trajectory())
        self.programs = self.path("programs")
        self.programs.mkdir()

    def path(self, name):
        return self.directory / name

    def with_ffmpeg(self, text):
        program = self.programs / "ffmpeg"
        program.write_text(text)
        program.chmod(0o755)

    def shell_path(self):
        """A PATH with the programs of this test, and with a shell and its tools but without ffmpeg."""
        tools = self.path("tools")
        if not tools.exists():
            tools.mkdir()
            for name in ("sh", "dirname"):
                (tools / name).symlink_to(pathlib.Path("/bin") / name)
        return f"{self.programs}:{tools}"

    def words(self, name, *options):
        report = self.path(name).with_suffix(".report.json")
        return ["film", self.run_file, "-o", self.path(name), "--report", report, *SIZE, "-q", *options]

    def film(self, name, *options, expected=0, **environment):
        result = run(*self.words(name, *options), env={"PATH": self.shell_path(), **environment})
        self.assertEqual(result.returncode, expected, result.stderr)
        return result

    def report(self, name):
        return json.loads(self.path(name).with_suffix(".report.json").read_text())

    def hashes(self, name):
        return [frame["image_sha256"] for frame in self.report(name)["frame_list"]]

    def pictures(self, name):
        return sorted(self.path(name).with_suffix(".frames").glob("*.png"))


class Here(FilmCase):
    def test_without_ffmpeg_the_frames_stay_and_one_line_says_so(self):
        result = self.film("a.mp4")
        self.assertRegex(result.stderr, r"\Aparray: no \S+a.mp4: ffmpeg is missing \(apt-get install ffmpeg\); the frames "
                                        r"are \S+frame-000000.png to frame-000005.png\n\Z")
        self.assertRegex(result.stdout, r"\Awrote \S+a.frames: 6 frames of 48 x 36 pixels, error 0.0\d+ to 0.0\d+, ")
        self.assertEqual(len(self.pictures("a.mp4")), FRAMES)
        self.assertFalse(self.path("a.mp4").exists())

    def test_the_address_of_a_farm_in_the_environment_needs_no_farm(self):
        self.film("a.mp4", "--spp", "1", "--frames", "0:1", PARRAY_COORDINATOR="tcp://127.0.0.1:1", PARRAY_KEYS="none.key")
        self.assertEqual(len(self.pictures("a.mp4")), 2)

    def test_every_frame_reaches_the_same_error_and_shows_the_same_scenery(self):
        self.film("a.mp4", "--color-by", "speed", "--target-error", "0.03")
        report = self.report("a.mp4")
        self.assertEqual([frame["frame"] for frame in report["frame_list"]], list(range(FRAMES)))
        for frame in report["frame_list"]:
            self.assertLessEqual(frame["error"]["high"], 0.03)
            self.assertEqual(frame["stopped_by"], "error")
            self.assertGreater(frame["samples"], 0)
        legends = [json.loads(path.with_suffix(".json").read_text()).get("legends") for path in self.pictures("a.mp4")]
        self.assertEqual(legends, [legends[0]] * FRAMES)
        # The picture of a frame alone has a camera of its own, so the film's first frame differs.
        alone = self.path("alone.json")
        result = run("render", self.run_file, "--frame", "0", "-o", self.path("alone.png"), *SIZE, "-q", "--report", alone,
                     "--color-by", "speed", "--target-error", "0.03")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertNotEqual(json.loads(alone.read_text())["image_sha256"], self.hashes("a.mp4")[0])

    def test_a_film_killed_in_the_middle_goes_on_and_keeps_its_frames(self):
        options = ["--spp", "1500", "--threads", "1"]
        process = subprocess.Popen([BIN / "parray", *map(str, self.words("a.mp4", *options))], stderr=subprocess.DEVNULL,
                                   stdout=subprocess.DEVNULL, env={**os.environ, "PATH": self.shell_path()})
        folder = self.path("a.frames")
        try:
            wait_for((folder / "frame-000001.json").exists, "the second frame")
        finally:
            process.send_signal(signal.SIGKILL)
            process.wait()
        kept = {path: (path.stat().st_ino, path.stat().st_mtime_ns) for path in
                (folder / f"frame-00000{place}.png" for place in (0, 1))}
        result = self.film("a.mp4", *options)
        self.assertRegex(result.stderr, r"parray: [2-6] of 6 frames are in \S+a.frames from an earlier run\n")
        for path, (inode, written) in kept.items():
            self.assertEqual((path.stat().st_ino, path.stat().st_mtime_ns), (inode, written))
        self.assertEqual([path for path in folder.iterdir() if "partial" in path.name], [])
        self.film("b.mp4", *options)
        self.assertEqual(self.hashes("a.mp4"), self.hashes("b.mp4"))

    def test_a_damaged_report_of_a_frame_is_named_with_the_remedy(self):
        self.film("a.mp4", "--spp", "4")
        report = self.path("a.frames") / "frame-000000.json"
        report.write_text(report.read_text().replace('"width"', '"wide"'))
        said = self.film("a.mp4", "--spp", "4", expected=1).stderr
        self.assertIn(f"parray: {report} is not the report of a frame: delete it", said)

    def test_other_settings_or_another_file_make_all_frames_again(self):
        self.film("a.mp4", "--spp", "2")
        again = self.film("a.mp4", "--spp", "2", "--fps", "30")
        self.assertNotIn("rendering all frames", again.stderr)
        self.assertIn("6 of 6 frames are in", again.stderr)
        other = r"parray: the frames in \S+a.frames were made with other options, files or another release: rendering all frames again\n"
        self.assertRegex(self.film("a.mp4", "--spp", "3").stderr, other)
        self.run_file.write_text(trajectory().replace("C 2.0", "C 2.1"))
        self.assertRegex(self.film("a.mp4", "--spp", "3").stderr, other)
        (self.path("a.frames") / "frame-000002.png").unlink()
        self.assertIn("5 of 6 frames are in", self.film("a.mp4", "--spp", "3").stderr)

    def test_a_refused_film_does_not_say_that_it_renders_frames_again(self):
        self.film("a.mp4", "--spp", "2", "--frames", "0:1")
        kept = self.hashes("a.mp4")
        refused = self.film("a.mp4", "--frames", "0:1", "--denoise", "--target-error", "0.1", expected=2)
        self.assertRegex(refused.stderr, r"\Aparray: [^\n]*\n\Z")
        self.assertNotIn("rendering all frames again", refused.stderr)
        self.assertIn("2 of 2 frames are in", self.film("a.mp4", "--spp", "2", "--frames", "0:1").stderr)
        self.assertEqual(self.hashes("a.mp4"), kept)

    def test_the_last_line_of_progress_counts_the_last_frame(self):
        large = ["--width", "600", "--height", "400", "--spp", "8"]  # traced for some time before it is written
        for frames, count in (("0:0", 1), ("0:1", 2)):
            words = [word for word in self.words(f"{count}.mp4", *large, "--frames", frames) if word != "-q"]
            result = run(*words, env={"PATH": self.shell_path()})
            self.assertEqual(result.returncode, 0, result.stderr)
            done = [line for line in result.stderr.splitlines() if line.startswith("film: ")]
            self.assertEqual(done, [f"film: 100.0 %  {count}/{count} frames  done"])

    def test_frames_that_cannot_be_rendered_have_a_line_each_and_the_others_stay(self):
        for number, text in ((1, "1\n\nC 0 0 0\n"), (2, "1\n\nC 0 0 1\n")):
            self.path(f"s-{number}.json").write_text(json.dumps({
                "version": 1, "camera": {"look_from": [0, 0, 9], "look_at": [0, 0, 0], "vfov": 40},
                "particles": [{"file": f"p-{number}.xyz"}]}))
            self.path(f"p-{number}.xyz").write_text(text)
        self.run_file = self.path("s-#.json")
        self.path("p-2.xyz").write_text("1\n\nC 0 0 x\n")
        options = ["--frames", "1:2", "--spp", "1"]
        result = self.film("a.mp4", *options, expected=1)
        self.assertRegex(result.stderr, r"\Aparray: frame 2: [^\n]*p-2.xyz:3[^\n]*\n"
                                        r"parray: no \S+a.mp4: frames are missing: remove the causes above, and run the same command again\n\Z")
        self.assertEqual(len(self.pictures("a.mp4")), 1)

    def test_an_interrupted_film_says_how_to_go_on(self):
        log = self.path("log")
        with log.open("w") as stderr:
            process = subprocess.Popen([BIN / "parray", *map(str, self.words("a.mp4", "--spp", "100000"))], stderr=stderr,
                                       stdout=subprocess.DEVNULL, env={**os.environ, "PATH": self.shell_path()})
            wait_for(self.path("a.frames").exists, "the folder")
            process.send_signal(signal.SIGINT)
            self.assertEqual(process.wait(timeout=60), 130)

    def test_a_turntable_and_a_camera_path_move_the_camera_around_one_scene(self):
        still = self.path("still.xyz")
        still.write_text("2\n\nO 0 0 0\nC 2 0 0\n")
        self.run_file = still
        self.film("a.gif", "--turntable", "360", "--count", "4", "--spp", "4", "--style", "flat")
        self.assertEqual(len(set(self.hashes("a.gif"))), 4)
        path = self.path("path.json")
        path.write_text(json.dumps({"cameras": [
            {"frame": frame, "look_from": [x, -40, 5], "look_at": [0, 0, 0], "up": [0, 0, 1], "vfov": 20}
            for frame, x in ((0, 0), (2, 20))]}))
        self.film("b.gif", "--camera-path", path, "--spp", "4", "--style", "flat")
        self.assertEqual([frame["frame"] for frame in self.report("b.gif")["frame_list"]], [0, 1, 2])

    def test_a_time_limit_is_that_of_each_frame(self):
        self.film("a.mp4", "--time-limit", "0.2", "--frames", "0:3")
        ends = [frame["stopped_by"] for frame in self.report("a.mp4")["frame_list"]]
        self.assertEqual(set(ends), {"time"})  # the first frame leaves time for the others
        self.assertGreater(len(ends), 2)

    def test_arrows_cells_labels_and_the_depth_cue_are_those_of_all_frames_though_atoms_appear(self):
        head = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n{}\nITEM: BOX BOUNDS pp pp pp\n0 8\n0 8\n0 8\n" \
               "ITEM: ATOMS id type x y z vx vy vz\n"
        near, far = "1 1 1 1 1 0 1 0\n2 1 3 1 1 0 0 1\n", "3 2 7 7 7 0 9 0\n"
        self.run_file = self.path("run.dump")
        self.run_file.write_text(head.format(2) + near + head.format(3) + near + far)
        self.film("a.mp4", "--spp", "1", "--arrows", "velocity", "--legend", "--cell", "--solid-cell", "--time-stamp",
                  "--depth-cue", "1", "--width", "480", "--height", "360")
        legends = [json.loads(path.with_suffix(".json").read_text())["legends"] for path in self.pictures("a.mp4")]
        self.assertEqual([entry["name"] for entry in legends[0][0]["entries"]], ["1", "2"])
        self.assertEqual(legends[0][1], legends[1][1])
        self.assertEqual(legends[0][1]["entries"], [{"name": "longest = 9", "arrow": True}])

    def test_a_frame_with_one_atom_has_arrows_of_the_scale_of_the_other_frames(self):
        head = "Properties=species:S:1:pos:R:3:velo:R:3\n"
        one, two = f"1\n{head}Ar 0 0 0 0 0 2\n", f"2\n{head}Ar 0 0 0 0 0 2\nAr 4 0 0 0 0 1\n"
        options = ["--spp", "1", "--arrows", "velocity", "--legend", "--width", "300", "--height", "200"]
        for frames in (one + two, two + one):
            self.run_file.write_text(frames)
            self.film("a.mp4", *options)
            legends = [json.loads(path.with_suffix(".json").read_text())["legends"] for path in self.pictures("a.mp4")]
            self.assertEqual(legends[0][1], legends[1][1])
            self.assertEqual(legends[0][1]["entries"], [{"name": "longest = 2", "arrow": True}])
        self.run_file.write_text(one + one)
        result = run("film", self.run_file, "-o", self.path("b.mp4"), *options)
        self.assertEqual(result.returncode, 2)
        self.assertIn("--arrow-scale: the particles have no neighbours", result.stderr)

    def test_sticks_without_elements_of_numbered_files_make_a_film(self):
        for number in (1, 2):
            self.path(f"n-{number}.data").write_text(
                "title\n\n2 atoms\n1 bonds\n1 bond types\n1 atom types\n0 9 xlo xhi\n0 9 ylo yhi\n0 9 zlo zhi\n\n"
                f"Atoms # bond\n\n1 1 1 1 1 1\n2 1 1 {1 + number} 1 1\n\nBonds\n\n1 1 1 2\n")
        self.run_file = self.path("n-#.data")
        self.film("a.mp4", "--style", "sticks", "--frames", "1:2", "--spp", "4", "--crystal", "off")
        self.assertEqual(len(set(self.hashes("a.mp4"))), 2)

    def test_labels_and_outlines_are_drawn(self):
        self.film("a.mp4", "--spp", "2", "--frames", "0:1", "--style", "publication", "--legend", "--color-by", "speed",
                  "--width", "300", "--height", "200")
        facts = json.loads((self.path("a.frames") / "frame-000000.json").read_text())
        self.assertEqual(facts["legends"][0]["high"], 1)  # of these two frames
        self.assertEqual(read_rgb(self.pictures("a.mp4")[0])[:2], (300, 200))

    def test_a_film_whose_name_is_not_utf_8_has_a_report(self):
        name = os.fsdecode(b"a\xff.mp4")
        self.with_ffmpeg(FAKE_FFMPEG)
        self.film(name, "--spp", "1", "--frames", "0:1")
        self.assertTrue(self.path(name).exists())
        self.assertTrue(self.report(name)["film"].endswith("/a\ufffd.mp4"))
        self.assertTrue(self.report(name)["frames_folder"].endswith("/a\ufffd.frames"))


class Encoding(FilmCase):
    def test_ffmpeg_gets_the_frames_and_makes_the_film(self):
        self.with_ffmpeg(FAKE_FFMPEG)
        result = self.film("a.mp4", "--spp", "1", "--fps", "12.5", "--frames", "1:5:2")
        self.assertEqual(result.stderr, "")
        self.assertRegex(result.stdout, r"\Awrote \S+a.mp4: 3 frames")
        self.assertEqual(self.path("a.mp4").read_text(), "film\n")
        words = (self.programs / "arguments").read_text().splitlines()
        for name, value in (("-framerate", "12.5"), ("-i", str(self.path("a.frames/frame-%06d.png"))), ("-frames:v", "3"),
                            ("-pix_fmt", "yuv420p"), ("-start_number", "0")):
            self.assertEqual(words[words.index(name) + 1], value)
        self.assertTrue(words[-1].endswith(".mp4"))
        self.assertEqual([path.name for path in self.directory.iterdir() if "partial" in path.name], [])

    def test_odd_sizes_are_padded_and_a_line_says_so(self):
        self.with_ffmpeg(FAKE_FFMPEG)
        result = self.film("a.mp4", "--spp", "1", "--frames", "0:1", "--width", "51")
        self.assertEqual(result.stderr, "parray: .mp4 and .webm films have an even width and height: "
                         "black pixels were added at the edge\n")
        self.assertIn("pad=ceil(iw/2)*2:ceil(ih/2)*2", (self.programs / "arguments").read_text())

    def test_a_failure_of_ffmpeg_is_told_by_its_last_line(self):
        self.with_ffmpeg(BROKEN_FFMPEG)
        result = self.film("a.webm", "--spp", "1", "--frames", "0:1", expected=1)
        self.assertRegex(result.stderr, r"\Aparray: no \S+a.webm: ffmpeg failed: no such encoder; the frames are [^\n]*\n\Z")
        self.assertEqual(self.report("a.webm")["film"], None)
        self.with_ffmpeg(FAKE_FFMPEG)
        self.assertIn("2 of 2 frames", self.film("a.webm", "--spp", "1", "--frames", "0:1").stderr)


class OnAFarm(FilmCase):
    def test_two_workers_make_the_same_frames_as_this_machine(self):
        self.film("here.mp4", "--color-by", "speed")
        with Farm() as farm:
            farm.start_worker("a")
            farm.start_worker("b")
            self.film("there.mp4", "--color-by", "speed", "--farm", PARRAY_COORDINATOR=farm.address)
            jobs = json.loads(farm.client("jobs", "--json").stdout)
            self.assertEqual([(job["name"], job["frames"], job["frames_done"]) for job in jobs], [("there.mp4", 6, 6)])
        self.assertEqual(self.hashes("here.mp4"), self.hashes("there.mp4"))
        for here, there in zip(self.pictures("here.mp4"), self.pictures("there.mp4")):
            self.assertEqual(read_rgb(here), read_rgb(there))

    def test_a_killed_client_goes_on_with_the_same_series(self):
        with Farm() as farm:
            client = farm.start_client(*self.words("a.mp4", "--spp", "1500", "--farm"))
            wait_for(lambda: json.loads(farm.client("jobs", "--json").stdout), "the series")
            client.send_signal(signal.SIGKILL)
            client.wait()
            farm.start_worker("a")
            result = self.film("a.mp4", "--spp", "1500", "--farm", PARRAY_COORDINATOR=farm.address)
            self.assertRegex(result.stderr, "series 1 continues: [1-6] of 6 frames")
            self.assertEqual(len(json.loads(farm.client("jobs", "--json").stdout)), 1)
            again = self.film("a.mp4", "--spp", "1500", "--farm", PARRAY_COORDINATOR=farm.address)
            self.assertIn("6 of 6 frames are in", again.stderr)


class Refusals(FilmCase):
    def test_a_numbered_file_that_cannot_be_read_is_refused_with_its_frame(self):
        scene = json.dumps({"version": 1, "camera": {"look_from": [0, 0, 9], "look_at": [0, 0, 0], "vfov": 40},
                            "materials": {}, "spheres": []})
        for name, good, bad in (("s-#.json", scene, scene[:-1]), ("p-#.xyz", trajectory(1), "2\n\nC 0 0 0\n")):
            self.path(name.replace("#", "1")).write_text(good)
            self.path(name.replace("#", "2")).write_text(bad)
            for frames, frame in (("1:2", 2), ("0:1", 0), ("1:3", 2)):
                with self.subTest(name=name, frames=frames):
                    result = run("film", self.path(name), "-o", self.path("a.mp4"), "--frames", frames, *SIZE)
                    self.assertEqual((result.returncode, result.stdout), (2, ""))
                    self.assertRegex(result.stderr, r"\Aparray: [^\n]*" + name.replace("#", str(frame)) + r":[^\n]* \(this is "
                                     rf"frame {frame}; --frames chooses others\)\n\Z")
                    self.assertFalse(self.path("a.frames").exists())

    def test_what_is_no_film_is_refused_in_one_line(self):
        still = self.path("still.xyz")
        still.write_text("1\n\nO 0 0 0\n")
        path = self.path("path.json")
        path.write_text('{"cameras": [{"frame": 0, "look_from": [0, 0, 9], "look_at": [0, 0, 0], "vfov": 400}]}')
        before = sorted(self.directory.iterdir())
        for name, options, mentions in (
                ("a.avi", [], "use a name that ends in .mp4, .webm or .gif"),
                ("none/a.mp4", [], "does not exist"),
                ("a.mp4", ["--frames", "0:9"], "has 6 frames, 0 to 5: write at most 0:5\n"),
                ("a.mp4", ["--frames", "2:1000:5"], "has 6 frames, 0 to 5: write at most 2:5:5\n"),
                ("a.mp4", ["--select", "element C and speed < 1"], f"parray: {self.run_file}: --select: "),
                ("a.mp4", ["--select", "element C and speed < 1"], " (this is frame 1; --frames chooses others)\n"),
                ("a.mp4", ["--select", "speed > 0"], " (this is frame 0; --frames chooses others)\n"),
                ("a.mp4", ["--legend"], "--legend: the label does not fit into 48 x 36 pixels: use a smaller --font-size, or "
                                        "leave out --legend, or legend in the scene file\n"),
                ("a.mp4", ["--scale-bar"], "a larger picture or fewer labels\n"),
                ("a.mp4", ["--frames", "5-1"], "is not a range of frames"),
                ("a.mp4", ["--count", "3"], "--count: "),
                ("a.mp4", ["--frame", "0"], "add --turntable 360 or --camera-path"),
                ("a.mp4", ["--frames", "0:1", "--frame", "0"], "--frames and --frame exclude each other"),
                ("a.mp4", ["--turntable", "360", "--camera-path", path], "exclude each other"),
                ("a.mp4", ["--camera-path", path], "path.json:1: /cameras/0/vfov"),
                ("a.mp4", ["--camera-path", self.path("no.json")], "no.json: cannot be read"),
                ("a.mp4", ["--turntable", "x"], "--turntable: 'x' is not a number"),
                ("a.mp4", ["--priority", "5"], "--farm"),
                ("a.mp4", ["--coordinator", "tcp://127.0.0.1:7400"], "--coordinator requires --farm; see `parray film"),
                ("a.mp4", ["--keys", "ann.key"], "--keys requires --farm; see `parray film"),
                ("a.mp4", ["--farm", "--threads", "2"], "--threads has no effect with --farm"),
                ("a.mp4", ["--fps", "0"], "--fps: '0' is not a number from 0.1 to 240")):
            result = run("film", self.run_file, "-o", self.path(name), *SIZE, *options)
            with self.subTest(options=options):
                self.assertEqual((result.returncode, result.stdout), (2, ""), result.stderr)
                self.assertRegex(result.stderr, r"\Aparray: [^\n]*\n\Z")
                self.assertIn(mentions, result.stderr)
        result = run("film", still, "-o", self.path("a.mp4"), *SIZE)
        self.assertEqual(result.returncode, 2)
        self.assertIn("it shows one frame", result.stderr)
        self.assertEqual(sorted(self.directory.iterdir()), before)
        self.path("a.frames").write_text("in the way")
        result = run("film", self.run_file, "-o", self.path("a.mp4"), *SIZE)
        self.assertEqual(result.returncode, 2)
        self.assertIn("remove the file of this name", result.stderr)

    def test_outputs_that_would_replace_an_input_are_refused(self):
        made = self.path("made.json")
        self.assertEqual(run("convert", self.run_file, made, "--width", "48").returncode, 0)
        self.path("b.frames").mkdir()
        inside = self.path("b.frames") / "frame-000001.json"
        inside.write_text(made.read_text().replace("run.xyz", "../run.xyz"))
        shutil.copy(self.run_file, self.path("top.xyz"))
        shutil.copy(self.run_file, self.path("c.gif"))
        before = {path: path.read_bytes() for path in self.directory.rglob("*") if path.is_file()}
        for arguments, film, report, mentions in (
                ([made], "a.gif", self.run_file, "run.xyz"),
                ([made], "a.gif", made, "made.json"),
                ([self.run_file, "--topology", self.path("top.xyz")], "a.gif", self.path("top.xyz"), "top.xyz"),
                ([self.path("c.gif")], "c.gif", self.path("r.json"), "c.gif"),
                ([inside], "b.gif", self.path("r.json"), "frame-000001.json")):
            with self.subTest(film=film, report=report):
                result = run("film", *arguments, "-o", self.path(film), "--report", report, *SIZE)
                self.assertEqual((result.returncode, result.stdout), (2, ""), result.stderr)
                self.assertRegex(result.stderr, rf"\Aparray: [^\n]*{mentions} is an input file: name another output file\n\Z")
        self.assertEqual({path: path.read_bytes() for path in self.directory.rglob("*") if path.is_file()}, before)
        self.assertFalse(self.path("a.frames").exists())

    def test_a_transparent_film_is_refused_with_a_remedy(self):
        result = self.film("a.mp4", "--transparent", "on", expected=2)
        self.assertIn("use --transparent off or, for a file of particles, --background COLOR instead", result.stderr)
        self.film("a.mp4", "--background", "#ff0000", "--spp", "1", "--frames", "0:0")
        self.assertEqual(read_rgb(self.pictures("a.mp4")[0])[2][:3], b"\xff\x00\x00")


if __name__ == "__main__":
    unittest.main()
