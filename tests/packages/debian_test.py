"""The Debian packages: what they hold, and a life of theirs on a machine with systemd."""

import json
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

from packs import BUILD, PACKAGES, SOURCE, Machine, debian_root, dependencies, field, need, output, pack

SERVICES = ["parray-coordinator", "parray-worker"]
# What the system changes by itself: logs, caches, and copies of what was before.
CHANGING = ["/var/log/*", "/var/cache/*", "/var/tmp/*", "/var/backups/*", "/var/lib/apt/*", "/var/lib/systemd/timers/*",
            "/var/lib/private*", "/var/lib/dpkg/*-old", "/etc/*-"]


class Packed(unittest.TestCase):
    __test__ = False

    @classmethod
    def setUpClass(cls):
        cls.directory = pathlib.Path(tempfile.mkdtemp(prefix="parray-packages-"))
        cls.addClassCleanup(shutil.rmtree, cls.directory)
        cls.first = pack("DEB", cls.directory / "1")

    def unpacked(self, name):
        target = self.directory / "unpacked" / name
        if not target.exists():
            target.mkdir(parents=True)
            output("dpkg-deb", "--extract", self.first[name], target)
        return target


class Contents(Packed):
    def test_there_is_a_package_for_each_role(self):
        self.assertEqual(sorted(self.first), sorted(PACKAGES))
        for name, file in self.first.items():
            self.assertTrue((self.unpacked(name) / "usr/bin" / name).exists(), name)
            self.assertEqual(field(file, "Package"), name)

    def test_services_need_no_pictures_and_no_mpi(self):
        for name in SERVICES:
            heavy = [word for word in dependencies(self.first[name]) if re.search("openimageio|opencv|mpi", word)]
            self.assertEqual(heavy, [])

    def test_what_programs_load_from_lib_parray_comes_with_them(self):
        homes = {path.name: name for name in self.first for path in (self.unpacked(name) / "usr/lib/parray").glob("*")}
        self.assertLessEqual({"exr_codec.so", "image_codec.so", "unpack.so"}, set(homes))
        for name, file in self.first.items():
            present = {name} | dependencies(file) | dependencies(file, "Recommends")
            programs = [*(self.unpacked(name) / "usr/bin").iterdir(), *(self.unpacked(name) / "usr/lib/parray").glob("*")]
            for program in programs:
                for part, home in homes.items():
                    if part.encode() in program.read_bytes():
                        self.assertIn(home, present, f"{program.name} needs {part}")

    def test_no_package_has_anothers_files(self):
        paths = [path.relative_to(self.unpacked(name)) for name in self.first
                 for path in self.unpacked(name).rglob("*") if not path.is_dir()]
        self.assertEqual(len(paths), len(set(paths)))

    def test_configuration_is_kept_by_dpkg(self):
        for name in SERVICES:
            listed = output("dpkg-deb", "--info", self.first[name], "conffiles").split()
            there = ["/" + str(path.relative_to(self.unpacked(name)))
                     for path in (self.unpacked(name) / "etc").rglob("*") if path.is_file()]
            self.assertEqual(listed, there)

    def test_lintian_finds_no_error(self):
        need("lintian")
        # The address of whoever builds packages for others is CPACK_PACKAGE_CONTACT.
        said = subprocess.run(["lintian", "--allow-root", "--suppress-tags=bogus-mail-host,bogus-mail-host-in-debian-changelog",
                               *self.first.values()], capture_output=True, text=True).stdout
        self.assertEqual([line for line in said.splitlines() if line.startswith("E:")], [])

    def test_units_are_sound_and_shut_off(self):
        need("systemd-analyze")
        for name in SERVICES:
            unit = self.unpacked(name) / f"usr/lib/systemd/system/{name}.service"
            # On this machine there need be neither program nor manual.
            checked = self.directory / unit.name
            checked.write_text(unit.read_text().replace("/usr/bin/", str(BUILD / "bin") + "/"))
            said = subprocess.run(["systemd-analyze", "verify", "--man=no", checked], capture_output=True, text=True)
            self.assertEqual([line for line in said.stderr.splitlines() if unit.name in line], [])
            self.assertEqual(said.returncode, 0, said.stderr)
            # An exposure of at most 1.5 of 10.
            output("systemd-analyze", "security", "--offline=true", "--threshold=15", "--no-pager", checked)


class Life(Packed):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.second = pack("DEB", cls.directory / "2", "CPACK_DEBIAN_PACKAGE_RELEASE=2")
        needed = set().union(*(dependencies(file) for file in cls.first.values()))
        cls.machine = cls.enterClassContext(Machine(debian_root(needed - set(PACKAGES))))

    def snapshot(self):
        """Every file of the machine that is to stay, and its users."""
        files = self.machine.run("find", "/etc", "/usr", "/var", "/opt", "/root", "/home", "-xdev",
                                 *(word for path in CHANGING for word in ("-not", "-path", path)))
        return set(files.splitlines()), self.machine.run("cat", "/etc/passwd", "/etc/group")

    def install(self, packages):
        self.machine.run("dpkg", "--install", *self.machine.copy(packages.values()))

    def wait_active(self):
        for service in SERVICES:
            self.machine.until(lambda service=service: self.machine.state(service) == "active", 60)

    def sha256(self, *command):
        report = "/tmp/report.json"
        self.machine.run(*command, "-o", "/tmp/picture.exr", "--report", report)
        return json.loads(self.machine.run("cat", report))["image_sha256"]

    def job(self, number):
        return json.loads(self.machine.run("parray", "show", number, "--json"))

    def configure(self, role, text):
        (self.machine.root / f"etc/parray/{role}.conf").write_text(text)
        self.machine.run("systemctl", "restart", f"parray-{role}")

    def test_installed_used_upgraded_removed_purged_and_nothing_left(self):
        machine = self.machine
        before = self.snapshot()
        scene = "/usr/share/parray/scenes/one-weekend-8.json"
        small = [scene, "--width", "64", "--height", "48", "--spp", "16"]
        long = [scene, "--width", "400", "--height", "200", "--spp", "1000"]

        # Installed: both services run, as their own user, and are started with the machine.
        self.install(self.first)
        self.wait_active()
        for service in SERVICES:
            self.assertEqual(machine.run("systemctl", "is-enabled", service).strip(), "enabled")
            pid = machine.state(service, "MainPID")
            self.assertEqual(machine.run("stat", "-c", "%U", f"/proc/{pid}").strip(), "parray")
        self.assertEqual(machine.run("stat", "-c", "%U %a", "/var/lib/parray").strip(), "parray 700")

        # A job's picture is that of this machine alone, and of an mpirun.
        here = self.sha256("parray", "render", *small)
        self.assertEqual(self.sha256("parray", "submit", *small, "--wait"), here)
        if "parray-mpi" in self.first:
            self.assertEqual(self.sha256("mpirun", "--allow-run-as-root", "--oversubscribe", "-n", "2", "parray-mpi",
                                         *small), here)

        # Upgraded in the middle of a job, which goes on; what the administrator has written stays.
        conffile = machine.root / "etc/parray/coordinator.conf"
        conffile.write_text(conffile.read_text() + "# mine\n")
        job = machine.run("parray", "submit", *long).strip()
        machine.until(lambda: self.job(job)["state"] != "queued")
        machine.run("parray", "pause", job)
        self.assertEqual(self.job(job)["state"], "paused")
        self.install(self.second)
        self.wait_active()
        self.assertEqual(machine.run("dpkg-query", "-W", "-f", "${Version}", "parray-worker"), field(self.second["parray-worker"], "Version"))
        self.assertIn("# mine", conffile.read_text())
        self.assertEqual(self.job(job)["state"], "paused")
        machine.run("parray", "resume", job)
        machine.run("parray", "watch", job)
        machine.run("parray", "fetch", job, "-o", "/tmp/long.exr", "--report", "/tmp/long.json")
        self.assertEqual(json.loads(machine.run("cat", "/tmp/long.json"))["image_sha256"],
                         self.sha256("parray", "render", *long))

        # With keys, for other machines.
        machine.run("runuser", "-u", "parray", "--", "parray", "keygen", "/etc/parray/keys")
        machine.run("install", "-o", "parray", "-m", "600", "/etc/parray/keys/worker.key", "/etc/parray/worker.key")
        self.configure("coordinator", 'OPTIONS="--coordinator tcp://*:7400 --keys /etc/parray/keys"\n')
        self.configure("worker", "PARRAY_KEYS=/etc/parray/worker.key\n")
        self.wait_active()
        self.assertEqual(self.sha256("parray", "submit", *small, "--wait", "--keys", "/etc/parray/keys/admin.key"), here)

        # Killed, it is started again; told nonsense, it is not.
        machine.run("systemctl", "kill", "--signal=KILL", "parray-worker")
        machine.until(lambda: machine.state("parray-worker", "NRestarts") == "1" and machine.state("parray-worker") == "active")
        self.configure("worker", 'OPTIONS="--nonsense"\n')
        machine.until(lambda: machine.state("parray-worker") == "failed")
        self.assertEqual(machine.state("parray-worker", "ExecMainStatus"), "2")

        # Removed: state, keys and configuration stay.
        machine.run("dpkg", "--remove", *PACKAGES)
        self.assertEqual(machine.call("pgrep", "parray").stdout, "")
        for kept in ("/var/lib/parray", "/etc/parray/keys/coordinator.key", "/etc/parray/worker.key", "/etc/parray/worker.conf"):
            machine.run("test", "-e", kept)
        # Installed again it serves what it had.
        machine.run("dpkg", "--install", *machine.copy([self.second["parray"], self.second["parray-coordinator"]]))
        machine.until(lambda: machine.state("parray-coordinator") == "active", 60)
        self.assertEqual(machine.run("systemctl", "is-enabled", "parray-coordinator").strip(), "enabled")
        jobs = json.loads(machine.run("parray", "jobs", "--json", "--keys", "/etc/parray/keys/admin.key"))
        self.assertIn(int(job), [entry["id"] for entry in jobs])
        machine.run("dpkg", "--remove", "parray", "parray-coordinator")
        # Purged, the coordinator leaves the worker's user, the worker nobody's.
        machine.run("dpkg", "--purge", "parray-coordinator")
        machine.run("getent", "passwd", "parray")
        machine.run("dpkg", "--purge", *PACKAGES)
        after = self.snapshot()
        self.assertEqual(sorted(after[0] - before[0]), [])
        self.assertEqual(sorted(before[0] - after[0]), [])
        self.assertEqual(after[1], before[1])


del Packed

if __name__ == "__main__":
    unittest.main()
