#!/usr/bin/env python3
"""Workers whose address space is limited (ulimit -v), as batch systems and containers do it."""

import json
import os
import pathlib
import random
import re
import resource
import subprocess
import unittest

from farm import BIN, Farm, run, wait_for

PICTURE = ["--width", "60", "--height", "40", "--spp", "4"]
SCARCE = 75_000 * 1024  # bytes: the scene below does not fit


def write_atoms(path, count):
    dice = random.Random(1)
    rows = (f"C {dice.uniform(0, 200):.3f} {dice.uniform(0, 200):.3f} {dice.uniform(0, 200):.3f}\n"
            for _ in range(count))
    path.write_text(f"{count}\n\n" + "".join(rows))


def start_limited(farm, name):
    log = farm.directory / f"{name}.log"
    with log.open("w") as stderr:
        worker = subprocess.Popen([BIN / "parray-worker", "--connect", farm.address, "--threads", "1", "--name", name],
                                  stderr=stderr, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (SCARCE, SCARCE)))
    worker.log = log
    farm.processes.append(worker)
    return worker


@unittest.skipIf(os.environ.get("PARRAY_SANITIZED"), "sanitizers reserve more address space than that")
class ScarceMemory(unittest.TestCase):
    def test_a_job_is_done_by_the_worker_that_has_room_for_its_scene(self):
        with Farm() as farm:
            atoms = farm.directory / "atoms.xyz"
            write_atoms(atoms, 400_000)
            poor = [start_limited(farm, name) for name in ("poor1", "poor2", "poor3")]
            farm.start_worker("rich")
            wait_for(lambda: len(farm.workers()) == 4, "four workers")
            report = farm.finish(farm.submit(atoms, *PICTURE))
            rendered = farm.directory / "rendered.json"
            run("render", atoms, *PICTURE, "-o", farm.directory / "rendered.png", "--report", rendered)
            self.assertEqual(report["image_sha256"], json.loads(rendered.read_text())["image_sha256"])
            self.assertEqual([worker.poll() for worker in poor], [None] * 3)  # alive: they say that they cannot

    def test_the_threads_of_a_limited_worker_reserve_no_heaps_of_their_own(self):
        with Farm() as farm:
            worker = start_limited(farm, "poor")
            wait_for(lambda: len(farm.workers()) == 1, "a worker")
            status = pathlib.Path(f"/proc/{worker.pid}/status").read_text()
            peak = int(re.search(r"VmPeak:\s+(\d+) kB", status)[1])
            self.assertLess(peak, 64 * 1024, "one more heap would take 64 MiB")

    def test_a_job_that_fits_nowhere_fails_with_the_reason(self):
        with Farm() as farm:
            atoms = farm.directory / "atoms.xyz"
            write_atoms(atoms, 400_000)
            start_limited(farm, "poor")
            wait_for(lambda: len(farm.workers()) == 1, "a worker")
            job = farm.submit(atoms, *PICTURE)
            self.assertEqual(farm.client("watch", job).returncode, 1)
            self.assertEqual(farm.job(job)["state"], "failed")
            self.assertIn("not enough memory", farm.job(job)["reason"])


if __name__ == "__main__":
    unittest.main()
