"""Renders that are interrupted, or whose disk is full."""

import contextlib
import json
import os
import pathlib
import resource
import signal
import subprocess
import time
import unittest

from cli_usage_test import LONG, SCENE, CliTest
from farm import BIN, SCENES, run, wait_for
from png import read_text

# A shell that may mount file systems of its own.
ALONE = "unshare", "--user", "--map-root-user", "--mount", "sh", "-c"


class Failures(CliTest):
    def start(self, *arguments, **options):
        process = subprocess.Popen([BIN / "parray", *map(str, arguments)], stderr=subprocess.PIPE, text=True,
                                   **{"stdout": subprocess.PIPE, **options})
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process

    def wait_for_handler(self, process):
        """Until the process catches SIGINT: a slow build is still loading its libraries before."""
        def caught():
            status = pathlib.Path(f"/proc/{process.pid}/status").read_text()
            mask = int(next(line for line in status.splitlines()
                            if line.startswith("SigCgt")).split()[1], 16)
            return mask >> (signal.SIGINT - 1) & 1
        wait_for(lambda: process.poll() is not None or caught(), "the signal handler")

    def test_an_interrupted_render_stops_at_once_and_leaves_nothing(self):
        self.path("a.exr").write_text("an older picture")
        for number, pause in ((signal.SIGINT, 0), (signal.SIGTERM, 0.1), (signal.SIGINT, 0.7)):
            process = self.start("render", self.scene, "-o", self.path("a.exr"), "--report",
                                 self.path("r.json"), *LONG)
            self.wait_for_handler(process)
            time.sleep(pause)  # into the loading, into the rendering
            self.assertIsNone(process.poll())
            process.send_signal(number)
            process.send_signal(number)  # people press it twice
            _, stderr = process.communicate(timeout=60)  # the picture would take far longer
            self.assertEqual(process.returncode, 130)
            self.assertEqual(stderr, "parray: interrupted\n")
            self.assertEqual(self.files(), self.before | {"a.exr"})
        self.assertEqual(self.path("a.exr").read_text(), "an older picture")

    def test_paths_of_a_million_segments_do_not_delay_an_interrupt(self):
        """A closed mirror ball around the camera: hardly a path ever ends by itself."""
        scene = {**SCENE, "materials": {"mirror": {"type": "metal", "albedo": [1, 1, 1], "fuzz": 0}},
                 "spheres": [{"center": [0, 0, 0], "radius": 50, "material": "mirror"}]}
        self.scene.write_text(json.dumps(scene))
        process = self.start("render", self.scene, "-o", self.path("a.exr"), "--max-depth",
                             "1048576", *LONG)
        self.wait_for_handler(process)
        time.sleep(0.5)  # into the rendering
        self.assertIsNone(process.poll())
        process.send_signal(signal.SIGINT)
        _, stderr = process.communicate(timeout=60)
        self.assertEqual((process.returncode, stderr), (130, "parray: interrupted\n"))
        self.assertEqual(self.files(), self.before)

    def test_signals_after_the_picture_is_written_do_not_change_the_exit_status(self):
        for more in ((), ("--views", "front,top")):
            reading, writing = os.pipe()
            os.set_blocking(writing, False)
            with contextlib.suppress(BlockingIOError):
                while True:
                    os.write(writing, bytes(4096))
            os.set_blocking(writing, True)
            # The program writes its last line into the full pipe, so it cannot end before somebody reads.
            file = self.path("a.png")
            process = self.start("render", SCENES / "particles" / "helix.pdb", "-o", file, "--width", "60", "--height",
                                 "40", "--spp", "4", "-q", *more, stdout=writing)
            os.close(writing)
            wait_for(file.exists, "the picture")
            for _ in range(20):
                process.send_signal(signal.SIGINT)
                time.sleep(0.02)
            with open(reading, "rb") as pipe:
                said = pipe.read().strip(bytes(1))
            _, stderr = process.communicate(timeout=60)
            self.assertEqual((process.returncode, stderr), (0, ""))
            self.assertIn(b"wrote ", said)
            file.unlink()

    def test_an_interrupt_while_the_picture_is_written_leaves_nothing(self):
        for width in (2000, 6000, 12000, 24000):  # a wider one if the signal comes after the writing
            process = self.start("render", self.scene, "-o", self.path("a.png"), "--width", str(width),
                                 "--height", "2000", "--spp", "1", "-q")
            wait_for(lambda: process.poll() is not None or self.writing() > 1000, "the writing", timeout=120)
            process.send_signal(signal.SIGINT)
            process.communicate(timeout=60)
            if not self.path("a.png").exists():
                break
            self.path("a.png").unlink()
        else:
            self.fail("no interrupt kept a picture from being written")
        self.assertEqual(process.returncode, 130)
        self.assertEqual(self.files(), self.before)

    def writing(self):
        """Bytes in the unfinished picture; the probe before the rendering has none."""
        for name in self.files() - self.before:
            try:
                return self.path(name).stat().st_size
            except FileNotFoundError:
                pass
        return 0

    @unittest.skipIf(os.environ.get("PARRAY_SANITIZED"), "its OpenMP has a file that becomes too large")
    def test_a_full_disk_is_a_failure_that_leaves_what_was_there(self):
        small = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
        for name in ("a.exr", "a.png"):
            self.path(name).write_text("an older picture")
            process = self.start("render", self.scene, "-o", self.path(name), "-q",
                                 preexec_fn=small)
            _, stderr = process.communicate(timeout=60)
            self.assertEqual(process.returncode, 1)
            self.assertEqual(stderr, f"parray: writing {self.path(name)}: File too large\n")
            self.assertEqual(self.path(name).read_text(), "an older picture")
        self.assertEqual(self.files(), self.before | {"a.exr", "a.png"})

    @unittest.skipUnless(subprocess.run([*ALONE, "mount -t tmpfs tmpfs /mnt"], capture_output=True).returncode == 0,
                         "no mounts of one's own here")
    def test_a_picture_is_written_elsewhere_if_its_disk_is_full(self):
        full, spare = self.path("full"), self.path("spare")
        full.mkdir()
        spare.mkdir()
        render = (f"mount -t tmpfs -o size=8k tmpfs {full} && TMPDIR={spare} '{BIN}/parray' render {self.scene} -q "
                  f"--width 200 --height 150 -o {full}/a.png; echo $?; ls {full}")
        failed = subprocess.run([*ALONE, render], capture_output=True, text=True, timeout=60)
        self.assertEqual(failed.stdout, "1\n", failed.stderr)
        self.assertEqual(failed.stderr, f"parray: writing {full}/a.png: No space left on device: "
                         f"the picture was saved to {spare}/a.png\n")
        self.assertEqual(run("render", self.scene, "-q", "--width", "200", "--height", "150", "-o",
                             self.path("b.png")).returncode, 0)
        self.assertEqual(read_text(spare / "a.png")["parray:image_sha256"],
                         read_text(self.path("b.png"))["parray:image_sha256"])

    def test_a_closed_output_is_a_failure_and_no_crash(self):
        with open("/dev/full", "w", encoding="utf-8") as full:
            result = subprocess.run([BIN / "parray", "validate", self.scene], stdout=full,
                                    stderr=subprocess.PIPE, text=True, check=False)
        self.assertEqual(result.returncode, 1)
        self.assertEqual(result.stderr, "parray: writing to standard output failed\n")

if __name__ == "__main__":
    unittest.main()
