#!/usr/bin/env python3
"""--display, with a viewer that speaks tev's protocol: the picture grows and is finally the result, and no viewer
delays a render."""

import hashlib
import json
import pathlib
import socket
import struct
import tempfile
import threading
import time
import unittest

import mpi
from farm import BIN, SCENES, Farm, run, wait_for

SCENE = SCENES / "one-weekend-20.json"
SIZE = ["--width", "200", "--height", "120"]


class Reader:
    """The fields of a message."""

    def __init__(self, data):
        self.data = data
        self.at = 0

    def take(self, layout):
        values = struct.unpack_from("<" + layout, self.data, self.at)
        self.at += struct.calcsize("<" + layout)
        return values[0] if len(values) == 1 else values

    def text(self):
        end = self.data.index(b"\0", self.at)
        text = self.data[self.at:end].decode()
        self.at = end + 1
        return text


class Viewer:
    """Takes connections at a free port and keeps what they show, by name of the window."""

    def __init__(self, reads=True):
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.address = "127.0.0.1:%d" % self.listener.getsockname()[1]
        self.images = {}
        self.updates = 0
        self.faults = []
        self.connections = []
        self.readers = []
        self.reads = reads
        self.thread = threading.Thread(target=self.serve, daemon=True)
        self.thread.start()

    def serve(self):
        while True:
            try:
                connection, _ = self.listener.accept()
            except OSError:
                return
            self.connections.append(connection)
            if self.reads:
                reader = threading.Thread(target=self.read, args=(connection,), daemon=True)
                reader.start()
                self.readers.append(reader)

    def read(self, connection):
        try:
            with connection.makefile("rb") as stream:
                while len(head := stream.read(4)) == 4:
                    (size,) = struct.unpack("<I", head)
                    self.take(Reader(stream.read(size - 4)))
        except Exception as error:  # said by the test, which runs elsewhere
            self.faults.append(repr(error))

    def take(self, message):
        kind, _ = message.take("bb")
        name = message.text()
        if kind == 4:
            width, height, channels = message.take("iii")
            assert [message.text() for _ in range(channels)] == ["R", "G", "B"]
            self.images[name] = (width, height, bytearray(4 * 3 * width * height))
        else:
            assert kind == 6, kind
            channels = message.take("i")
            assert [message.text() for _ in range(channels)] == ["R", "G", "B"]
            x, y, width, height = message.take("iiii")
            assert message.take("qqq") == (0, 1, 2) and message.take("qqq") == (3, 3, 3)
            whole, rows, pixels = self.images[name]
            assert x == 0 and width == whole and y + height <= rows
            data = message.data[message.at:]
            assert len(data) == 4 * 3 * width * height, len(data)
            pixels[4 * 3 * width * y:4 * 3 * width * (y + height)] = data
            self.updates += y == 0

    def wait_for_the_end(self):
        """Until all that a process has sent before its end is read."""
        wait_for(lambda: self.readers and not any(reader.is_alive() for reader in self.readers), "the end of the connection")

    def shown(self, name):
        """SHA-256 of a window's pixels, as reports have it."""
        return hashlib.sha256(self.images[name][2]).hexdigest()

    def close(self):
        self.listener.close()
        for connection in self.connections:
            connection.close()


class Display(unittest.TestCase):
    def setUp(self):
        directory = tempfile.TemporaryDirectory()
        self.addCleanup(directory.cleanup)
        self.directory = pathlib.Path(directory.name)

    def viewer(self, **options):
        viewer = Viewer(**options)
        self.addCleanup(viewer.close)
        return viewer

    def expect_picture(self, viewer, name):
        report = json.loads((self.directory / "report.json").read_text())
        viewer.wait_for_the_end()
        self.assertEqual(viewer.faults, [])
        self.assertEqual(list(viewer.images), [name])
        self.assertEqual(viewer.images[name][:2], (200, 120))
        self.assertEqual(viewer.shown(name), report["image_sha256"])

    def outputs(self):
        return ["-o", self.directory / "picture.png", "--report", self.directory / "report.json"]

    def test_a_picture_grows_and_is_finally_the_result(self):
        viewer = self.viewer()
        done = run("render", SCENE, *SIZE, "--spp", "700", "--threads", "1", *self.outputs(), "--display", viewer.address)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.expect_picture(viewer, SCENE.name)
        self.assertGreater(viewer.updates, 1)

    def test_the_same_is_true_for_submitted_and_watched_jobs(self):
        viewer, watcher = self.viewer(), self.viewer()
        with Farm() as farm:
            at = ["--coordinator", farm.address]
            job = run("submit", SCENE, *SIZE, "--spp", "400", *at).stdout.strip()
            watch = farm.start_client("watch", job, "--display", watcher.address)
            farm.start_worker("a")
            self.assertEqual(watch.wait(timeout=120), 0, watch.log.read_text())
            fetched = run("fetch", job, *self.outputs(), *at)
            self.assertEqual(fetched.returncode, 0, fetched.stderr)
            self.expect_picture(watcher, SCENE.name)
            done = run("submit", SCENE, *SIZE, "--spp", "200", "--wait", *self.outputs(), "--display", viewer.address, *at)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.expect_picture(viewer, SCENE.name)

    @unittest.skipIf(mpi.why_not(), mpi.why_not())
    def test_the_same_is_true_for_ranks(self):
        viewer = self.viewer()
        done = run_mpi(SCENE, *SIZE, "--spp", "200", *self.outputs(), "--display", viewer.address)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.expect_picture(viewer, SCENE.name)

    def test_a_viewer_that_is_away_or_takes_nothing_delays_no_render(self):
        deaf = self.viewer(reads=False)
        # A socket that is bound but does not listen refuses connections, and keeps its port from other processes.
        refusing = socket.socket()
        self.addCleanup(refusing.close)
        refusing.bind(("127.0.0.1", 0))
        away = "127.0.0.1:%d" % refusing.getsockname()[1]
        size = ["--width", "1200", "--height", "800", "--spp", "3"]  # more than a socket holds
        for address, said in ((away, "no viewer takes pictures at " + away), (deaf.address, "")):
            begin = time.monotonic()
            done = run("render", SCENE, *size, *self.outputs(), "--display", address)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn(said, done.stderr)
            self.assertEqual(done.stderr.count("--display"), 1 if said else 0)
            self.assertLess(time.monotonic() - begin, 60)  # it would be for ever

    def test_an_invalid_address_is_refused_before_any_work(self):
        for wrong in ("viewer", "host:", ":14158", "host:0", "host:65536", "host:1x", "host:-1"):
            done = run("render", SCENE, *SIZE, "--spp", "1", *self.outputs(), "--display", wrong)
            self.assertEqual(done.returncode, 2, wrong)
            self.assertIn(f"--display {wrong}: give the host and port of the viewer", done.stderr)
            self.assertFalse((self.directory / "picture.png").exists())


def run_mpi(*arguments):
    import subprocess
    return subprocess.run(["mpirun", "-n", "2", "--oversubscribe", BIN / "parray-mpi", *map(str, arguments)],
                          capture_output=True, text=True, timeout=120, env=mpi.ENVIRONMENT)


if __name__ == "__main__":
    unittest.main()
