#!/usr/bin/env python3
"""An administrator sets up a farm with keys: keygen, copy one file, start."""

import json
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import unittest

from farm import BIN, SCENES, Farm, run, wait_for

SCENE = SCENES / "one-weekend-20.json"
SMALL = ["--width", "60", "--height", "40", "--spp", "16"]


class Keys(unittest.TestCase):
    def setUp(self):
        directory = tempfile.TemporaryDirectory()
        self.addCleanup(directory.cleanup)
        self.keys = pathlib.Path(directory.name, "keys")
        self.assertEqual(run("keygen", self.keys).returncode, 0)

    def add(self, name, *options):
        result = run("keygen", self.keys, "--name", name, *options)
        self.assertEqual(result.returncode, 0, result.stderr)
        return self.keys / f"{name}.key"

    def farm(self, *options):
        return Farm("--keys", self.keys, *options, bind="tcp://0.0.0.0:*")

    def refused(self, result, *parts):
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        for part in parts:
            self.assertIn(part, result.stderr)

    def test_one_copied_file_makes_a_worker_and_a_user(self):
        ann = self.add("ann")
        with self.farm() as farm, tempfile.TemporaryDirectory() as elsewhere:
            address = farm.address.replace("0.0.0.0", "127.0.0.1")
            key = shutil.copy2(self.keys / "worker.key", elsewhere)
            worker = farm._start("parray-worker", "--coordinator", address, "--keys", key, "--name", "far")
            env = {"PARRAY_COORDINATOR": address, "PARRAY_KEYS": str(ann)}
            picture = pathlib.Path(elsewhere, "a.png")
            done = run("submit", SCENE, *SMALL, "--wait", "-o", picture, env=env)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertTrue(picture.exists())
            job = json.loads(run("show", "1", "--json", env=env).stdout)
            self.assertEqual((job["user"], job["state"]), ("ann", "done"))
            workers = json.loads(run("workers", "--json", "--keys", self.keys, env=env).stdout)
            self.assertEqual([w["name"] for w in workers], ["far"])
            # Taken off the list it is gone, with its connection as it is.
            self.assertEqual(run("keygen", self.keys, "--remove", "worker").returncode, 0)
            self.assertEqual(worker.wait(timeout=60), 1)
            self.assertIn("the worker's or client's key is no longer allowed", worker.log.read_text())

    def test_lists_that_others_can_write_are_refused_and_not_followed_any_more(self):
        allowed = self.keys / "allowed"
        self.assertEqual(run("keygen", self.keys, "--token", "admin").returncode, 0)
        for path, mode in ((allowed, 0o666), (self.keys / "tokens", 0o620), (self.keys, 0o777)):
            before = path.stat().st_mode
            path.chmod(mode)
            started = subprocess.run([BIN / "parray-coordinator", "--bind", "tcp://127.0.0.1:*", "--keys", self.keys],
                                     capture_output=True, text=True, timeout=60)
            self.refused(started, "others on this machine can write it", f"chmod go-w {path}")
            path.chmod(before)
        with self.farm() as farm:
            ann = self.add("ann")
            env = {"PARRAY_COORDINATOR": farm.address.replace("0.0.0.0", "127.0.0.1"), "PARRAY_KEYS": str(ann)}
            self.assertEqual(run("jobs", env=env).returncode, 0)
            allowed.chmod(0o666)
            wait_for(lambda: f"chmod go-w {allowed}" in farm.coordinator_log(), "a word about it")
            allowed.write_text(allowed.read_text().replace("client ann", "admin ann"))
            self.assertEqual(run("jobs", env=env).returncode, 0)
            self.assertNotEqual(run("workers", "drain", "nobody", env=env).returncode, 0)  # no administrator yet
            allowed.chmod(0o644)
            wait_for(lambda: "are readable again" in farm.coordinator_log(), "that it is mended")

    def test_strangers_and_wrong_roles_are_refused_with_a_message(self):
        ann = self.add("ann")
        with self.farm() as farm:
            address = farm.address.replace("0.0.0.0", "127.0.0.1")
            env = {"PARRAY_COORDINATOR": address}
            silent = run("jobs", env=env)
            self.assertEqual(silent.returncode, 1)
            self.assertIn("or it requires a key: --keys", silent.stderr)
            self.refused(run("jobs", "--keys", self.keys / "worker.key", env=env), "has the role worker")
            posing = farm._start("parray-worker", "--coordinator", address, "--keys", ann)
            self.assertEqual(posing.wait(timeout=60), 1)
            self.assertIn("the key 'ann' has the role client", posing.log.read_text())
            mine = run("submit", SCENE, *SMALL, "--keys", self.keys / "admin.key", env=env)
            self.refused(run("cancel", mine.stdout.strip(), "--keys", ann, env=env), "belongs to 'admin'")
            self.assertEqual(run("cancel", mine.stdout.strip(), "--keys", self.keys, env=env).returncode, 0)

    def test_a_farm_with_keys_goes_on_after_a_restart_with_its_owners(self):
        ann = self.add("ann")
        with tempfile.TemporaryDirectory() as state, self.farm("--state", state) as farm:
            env = {"PARRAY_COORDINATOR": farm.address.replace("0.0.0.0", "127.0.0.1")}
            run("submit", SCENE, *SMALL, "--keys", ann, env=env)
            farm.coordinator.send_signal(signal.SIGKILL)
            farm.coordinator.wait()
            farm.start_coordinator(farm.address)
            job = json.loads(run("show", "1", "--json", "--keys", ann, env=env).stdout)
            self.assertEqual(job["user"], "ann")

    def test_bad_keys_are_refused_in_one_line(self):
        key = self.keys / "admin.key"
        self.refused(run("keygen", self.keys), "already exists")
        self.refused(run("keygen", self.keys, "--name", "../x"), "cannot name a key")
        self.refused(run("keygen", self.keys, "--name", "admin"), "already")
        self.refused(run("keygen", self.keys, "--role", "client"), "--name")
        self.refused(run("keygen", self.keys, "--remove", "nobody"), "nobody")
        before = sorted(path.name for path in self.keys.iterdir())
        for one, other in (("--name", "--remove"), ("--name", "--token"), ("--remove", "--token")):
            self.refused(run("keygen", self.keys, one, "worker", other, "admin"),
                         f"{one} and {other} exclude each other: leave one of them out; see `parray keygen --help`")
        self.assertEqual(sorted(path.name for path in self.keys.iterdir()), before)
        self.refused(run("keygen", "/proc/keys-here"), "/proc/keys-here")
        self.refused(run("keygen", "/tmp", "--name", "ann"), "coordinator.key")
        self.refused(run("jobs", "--keys", self.keys / "none.key"), "none.key")
        self.refused(run("jobs", "--keys", "/dev/null"), "/dev/null is a device and holds no key: name a key file")
        os.chmod(key, 0o640)
        self.refused(run("jobs", "--keys", key), "chmod 600")
        os.chmod(key, 0o600)
        key.write_text("public short\n")
        self.refused(run("jobs", "--keys", key), "admin.key", "coordinator key")

    def test_a_report_does_not_replace_the_key(self):
        key = self.keys / "admin.key"
        before = key.read_text()
        picture = self.keys.parent / "a.png"
        for keys in (key, self.keys):
            for command in (["fetch", "1"], ["submit", SCENE, "--wait"]):
                self.refused(run(*command, "-o", picture, "--report", key, "--keys", keys), "admin.key is an input file")
        self.assertEqual(key.read_text(), before)

    def test_serving_other_machines_needs_keys_or_insecure(self):
        coordinator = BIN / "parray-coordinator"
        result = subprocess.run([coordinator, "--coordinator", "tcp://0.0.0.0:*"], capture_output=True,
                                text=True, timeout=60)
        self.refused(result, "parray keygen", "--keys", "--insecure")
        with Farm("--insecure", bind="tcp://0.0.0.0:*") as farm:
            wait_for(lambda: "--insecure: anyone" in farm.coordinator_log(), "the warning")


if __name__ == "__main__":
    unittest.main(verbosity=2)
