"""A coordinator's state is damaged, checked, repaired and copied, with real processes."""

import os
import pathlib
import resource
import shutil
import signal
import subprocess
import tempfile
import unittest

from farm import BIN, Farm
from farm_test import SCENE

SMALL = ("--width", "32", "--height", "24", "--spp", "4")


ALONE = "unshare", "--user", "--map-root-user", "--mount", "sh", "-c"


def may_mount():
    """Whether a process may have a file system that no other process sees."""
    try:
        return subprocess.run([*ALONE, "mount -t tmpfs tmpfs /mnt"], capture_output=True).returncode == 0
    except OSError:
        return False


def coordinator(*arguments):
    return subprocess.run([BIN / "parray-coordinator", *map(str, arguments)], capture_output=True, text=True,
                          timeout=60)


class Damage(unittest.TestCase):
    def setUp(self):
        directory = tempfile.TemporaryDirectory()
        self.addCleanup(directory.cleanup)
        self.state = pathlib.Path(directory.name) / "state"

    def finish_jobs(self, farm, count):
        farm.start_worker("w")
        jobs = [farm.submit(SCENE, *SMALL) for _ in range(count)]
        return {job: farm.finish(job)["image_sha256"] for job in jobs}

    def serve_again(self, expected):
        with Farm("--state", self.state) as farm:
            for job, digest in expected.items():
                self.assertEqual(farm.fetch(job)["image_sha256"], digest)

    def test_a_flipped_byte_of_the_log_and_a_log_that_is_gone_delete_no_picture(self):
        with Farm("--state", self.state) as farm:
            expected = self.finish_jobs(farm, 5)
            farm.coordinator.send_signal(signal.SIGKILL)
            farm.coordinator.wait()
            killed = self.state.parent / "killed"
            shutil.copytree(self.state, killed)
        for gone in False, True:
            shutil.rmtree(self.state)
            shutil.copytree(killed, self.state)
            log = self.state / "parray.sqlite-wal"
            if gone:
                log.unlink()
            else:
                data = bytearray(log.read_bytes())
                data[3000] ^= 0xff
                log.write_bytes(data)
            refused = coordinator("--coordinator", "tcp://127.0.0.1:*", "--state", self.state)
            self.assertEqual(refused.returncode, 1)
            self.assertIn(f"--repair {self.state}", refused.stderr)
            self.assertEqual(len(refused.stderr.splitlines()), 1)
            checked = coordinator("--check", self.state)
            self.assertEqual(checked.returncode, 1)
            self.assertIn("jobs/3/job.json", checked.stdout)
            repaired = coordinator("--repair", self.state)
            self.assertEqual(repaired.returncode, 0, repaired.stderr)
            self.assertNotIn("lost:", repaired.stdout)
            self.assertEqual(coordinator("--check", self.state).returncode, 0)
            self.serve_again(expected)

    def test_a_killed_coordinator_needs_no_repair(self):
        with Farm("--state", self.state) as farm:
            expected = self.finish_jobs(farm, 2)
            farm.coordinator.send_signal(signal.SIGKILL)
            farm.coordinator.wait()
        self.assertEqual(coordinator("--check", self.state).returncode, 0)
        self.serve_again(expected)

    def test_a_backup_of_a_serving_coordinator_serves(self):
        target = self.state.parent / "copy"
        with Farm("--state", self.state) as farm:
            expected = self.finish_jobs(farm, 3)
            self.assertEqual(coordinator("--check", self.state).returncode, 2, "it is served")
            copied = coordinator("--backup", self.state, target)
            self.assertEqual(copied.returncode, 0, copied.stdout + copied.stderr)
        self.assertEqual(coordinator("--backup", self.state, target).returncode, 2, "it is not empty")
        for tool in (["--check", target], ["--repair", target], ["--backup", target, self.state.parent / "more"]):
            for option in (["--state", self.state], ["--check", target], ["--repair", target], ["--log-level", "debug"]):
                if option[0] != tool[0]:
                    refused = coordinator(*tool, *option)
                    self.assertEqual((refused.returncode, refused.stdout), (2, ""))
                    self.assertRegex(refused.stderr, r"\A[^\n]*: --[a-z-]+ has no effect with --[a-z]+: leave out one of the two\n\Z")
                    self.assertIn(option[0], refused.stderr)
        self.assertEqual(coordinator("--state", target, "--check", target).returncode, 0)  # as in a container
        self.assertFalse((self.state.parent / "more").exists())
        shutil.rmtree(self.state)
        self.state = target
        self.serve_again(expected)

    def test_a_backup_of_no_state_or_into_the_state_itself_is_refused(self):
        empty = self.state.parent / "empty"
        empty.mkdir()
        refused = coordinator("--backup", empty, self.state.parent / "copy")
        self.assertEqual((refused.returncode, len(refused.stderr.splitlines())), (2, 1))
        self.assertIn("holds no state", refused.stderr)
        with Farm("--state", self.state) as farm:
            self.finish_jobs(farm, 1)
            for inside in self.state / "copy", self.state / "jobs" / "copy":
                refused = coordinator("--backup", self.state, inside)
                self.assertEqual(refused.returncode, 2)
                self.assertIn("is inside the directory of the state", refused.stderr)
                self.assertFalse(inside.exists())

    def test_a_backup_that_was_not_finished_is_named_until_it_is_repaired(self):
        with Farm("--state", self.state) as farm:
            expected = self.finish_jobs(farm, 1)
        (self.state / "incomplete").write_text("as --backup leaves it when it is killed")
        refused = coordinator("--coordinator", "tcp://127.0.0.1:*", "--state", self.state)
        self.assertEqual(refused.returncode, 1)
        for command in "--check", "--repair":
            self.assertIn("this copy was not finished", coordinator(command, self.state).stdout)
        self.assertEqual(coordinator("--check", self.state).returncode, 0)
        self.serve_again(expected)

    def test_a_pipe_in_the_place_of_a_file_delays_nothing(self):
        with Farm("--state", self.state) as farm:
            expected = self.finish_jobs(farm, 2)
            picture = self.state / "jobs" / "2" / "picture"
            picture.unlink()
            os.mkfifo(picture)
            refused = farm.client("fetch", 2, "-o", farm.directory / "x.png")
            self.assertEqual((refused.returncode, len(refused.stderr.splitlines())), (1, 1))
            self.assertEqual(farm.fetch(1)["image_sha256"], expected[1])
        checked = coordinator("--check", self.state)
        self.assertEqual(checked.returncode, 1)
        self.assertIn("jobs/2/picture", checked.stdout)

    def test_a_pipe_in_the_place_of_the_database_or_of_rows_is_refused_at_once_and_moved_by_repair(self):
        with Farm("--state", self.state) as farm:
            paused = farm.submit(SCENE, *SMALL)
            self.assertEqual(farm.client("pause", paused).returncode, 0)
            expected = self.finish_jobs(farm, 1)
        pipes = self.state / "parray.sqlite", self.state / "jobs" / str(paused) / "rows"
        for pipe in pipes:
            pipe.unlink(missing_ok=True)
            os.mkfifo(pipe)
        checked = coordinator("--check", self.state)
        self.assertEqual(checked.returncode, 1)
        refused = coordinator("--coordinator", "tcp://127.0.0.1:*", "--state", self.state)
        self.assertEqual((refused.returncode, len(refused.stderr.splitlines())), (1, 1))
        self.assertIn(f"--repair {self.state}", refused.stderr)
        repaired = coordinator("--repair", self.state)
        self.assertEqual(repaired.returncode, 0, repaired.stderr)
        for pipe in pipes:
            line = f"{pipe.relative_to(self.state)} is a pipe, not a file"
            self.assertIn(line, checked.stdout)
            self.assertIn(line, repaired.stdout)
            self.assertTrue(list(self.state.glob(f"lost/*/{pipe.relative_to(self.state)}")))
        self.assertEqual(coordinator("--check", self.state).returncode, 0)
        self.serve_again(expected)

    def test_a_backup_onto_a_full_disk_says_so_and_leaves_nothing(self):
        def few_bytes():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (room, room))

        with Farm("--state", self.state) as farm:
            expected = self.finish_jobs(farm, 1)
        target = self.state.parent / "copy"
        for room, existed in (1000, False), (1000, True), (20, True), (20_000, True):
            if existed:
                target.mkdir(exist_ok=True)
            failed = subprocess.run([BIN / "parray-coordinator", "--backup", self.state, target], capture_output=True,
                                    text=True, timeout=60, preexec_fn=few_bytes)
            self.assertEqual((failed.returncode, len(failed.stderr.splitlines())), (2, 1), failed.stderr)
            self.assertIn(f"{target}: the copy was not finished", failed.stderr)
            self.assertIn("make room there, or name another directory", failed.stderr)
            self.assertEqual(target.exists(), existed)
            self.assertEqual(list(target.glob("*")), [])
        self.assertEqual(coordinator("--backup", self.state, target).returncode, 0)
        self.state = target
        self.serve_again(expected)

    @unittest.skipUnless(may_mount(), "needs a file system of its own")
    def test_a_backup_onto_a_full_file_system_names_the_reason(self):
        with Farm("--state", self.state) as farm:
            farm.start_worker("w")
            farm.finish(farm.submit(SCENE, "--width", "320", "--height", "240", "--spp", "4"))
        target = self.state.parent / "mounted"
        target.mkdir()
        for room in "8k", "64k", "600k":
            mount = f"mount -t tmpfs -o size={room} tmpfs {target}"
            backup = f"'{BIN}/parray-coordinator' --backup {self.state} {target}/copy"
            failed = subprocess.run([*ALONE, f"{mount} && {backup}; echo $?; ls {target}"], capture_output=True,
                                    text=True, timeout=60)
            self.assertEqual(failed.stdout, "2\n", failed.stderr)
            self.assertIn(f"{target}/copy: the copy was not finished, because the disk is full", failed.stderr)


if __name__ == "__main__":
    unittest.main()
