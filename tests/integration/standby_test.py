"""Coordinators that take over from one another, as real processes."""

import re
import signal
import socket
import tempfile
import time
import unittest

from farm import SCENES, Farm, run, wait_for
from farm_test import LONG, SCENE, render_report


def free_address():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"tcp://127.0.0.1:{probe.getsockname()[1]}"


class OnOneHost(unittest.TestCase):
    def test_the_next_coordinator_takes_the_killed_ones_place_and_finishes_the_job(self):
        expected = render_report(SCENE, *LONG)["image_sha256"]
        with tempfile.TemporaryDirectory() as state, \
                Farm("--state", state, "--heartbeat", "0.1", bind=free_address()) as farm:
            farm.start_worker("w1")
            farm.start_worker("w2")
            second = farm._start("parray-coordinator", "--bind", farm.address, "--wait", *farm.options)
            wait_for(lambda: "waiting for its end" in second.log.read_text(), "the second to wait")
            job = farm.submit(SCENE, *LONG)
            wait_for(lambda: farm.job(job)["progress"] > 0.1, "some progress")
            farm.coordinator.send_signal(signal.SIGSTOP)
            time.sleep(1)
            self.assertNotIn("serves", second.log.read_text(), "a stopped coordinator still has its state")
            farm.coordinator.send_signal(signal.SIGCONT)
            farm.coordinator.send_signal(signal.SIGKILL)
            killed = time.monotonic()
            wait_for(lambda: "serves" in second.log.read_text(), "the second to serve")
            self.assertLess(time.monotonic() - killed, 3)
            self.assertEqual(second.log.read_text().count("waiting for its end"), 1)
            self.assertLess(farm.job(job)["progress"], 1)
            self.assertEqual(farm.finish(job)["image_sha256"], expected)

    def test_a_signal_ends_the_wait(self):
        with tempfile.TemporaryDirectory() as state, Farm("--state", state) as farm:
            second = farm._start("parray-coordinator", "--bind", farm.bind, "--wait", *farm.options)
            wait_for(lambda: "waiting for its end" in second.log.read_text(), "the second to wait")
            second.send_signal(signal.SIGTERM)
            self.assertEqual(second.wait(timeout=10), 130)


if __name__ == "__main__":
    unittest.main()
