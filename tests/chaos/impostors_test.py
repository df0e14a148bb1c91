#!/usr/bin/env python3
"""Real workers whose messages a proxy rewrites: a liar is found and its cells are mended, a worker of another
release is refused."""

import json
import pathlib
import sys
import unittest

import impostors
from proxy import Proxy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "integration"))
from farm import SCENES, Farm, run, wait_for  # noqa: E402

SCENE = SCENES / "one-weekend-20.json"
SETTINGS = ("--width", "64", "--height", "48", "--spp", "600")


class Impostors(unittest.TestCase):
    def start(self, farm, rewrite):
        port = int(farm.address.rsplit(":", 1)[1])
        proxy = self.enterContext(Proxy(("127.0.0.1", port), 1, rewrite))
        return farm._start("parray-worker", "--connect", proxy.address, "--threads", 1, "--name", "impostor")

    def test_a_liar_is_found_by_checks_and_what_it_has_traced_is_traced_again(self):
        for settings in (SETTINGS, ("--width", "64", "--height", "48", "--target-error", "0.004")):
            with self.subTest(settings), Farm("--spot-checks", 1) as farm:
                expected = farm.directory / "expected.json"
                rendered = run("render", SCENE, *settings, "-q", "-o", farm.directory / "a.png", "--report", expected)
                self.assertEqual(rendered.returncode, 0, rendered.stderr)
                liar = impostors.Liar(1, 1)
                self.start(farm, liar)
                farm.start_worker("ann")
                farm.start_worker("bob")
                wait_for(lambda: len(farm.workers()) == 3, "three workers")
                job = farm.submit(SCENE, *settings)
                report = farm.finish(job)
                self.assertGreater(len(liar.lies), 0)
                self.assertEqual(report["image_sha256"], json.loads(expected.read_text())["image_sha256"])
                states = {worker["name"]: worker["state"] for worker in farm.workers()}
                self.assertEqual(states, {"impostor": "quarantined", "ann": "ready", "bob": "ready"})
                # Of a liar whose results were only second opinions there is nothing to trace again.
                self.assertRegex(farm.job(job)["flag"], "'impostor'.* returned (wrong|different) bits")

    def test_a_worker_of_another_release_is_refused_with_a_word(self):
        with Farm() as farm:
            worker = self.start(farm, impostors.of_another_release)
            self.assertEqual(worker.wait(timeout=30), 1)
            self.assertIn("trace version 1000000, but this coordinator's pictures are of", worker.log.read_text())
            self.assertEqual(farm.workers(), [])


if __name__ == "__main__":
    unittest.main()
