"""Packages made from a build, and a machine to install them on: Debian with systemd as its first process,
in namespaces of its own, on an overlay that is thrown away."""

import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

BIN = pathlib.Path(os.environ["PARRAY_BIN_DIR"])
SOURCE = pathlib.Path(os.environ["PARRAY_SOURCE_DIR"])
BUILD = BIN.parent
PACKAGES = [name for name in ("parray", "parray-coordinator", "parray-worker", "parray-mpi") if (BIN / name).exists()]


def output(*command, **options):
    """What a command that has to succeed prints."""
    result = subprocess.run([str(part) for part in command], capture_output=True, text=True, **options)
    if result.returncode != 0:
        raise AssertionError(f"{command}: status {result.returncode}\n{result.stdout}\n{result.stderr}")
    return result.stdout


def need(*programs, root=False):
    missing = [name for name in programs if shutil.which(name, path=os.environ["PATH"] + ":/usr/sbin") is None]
    if missing:
        raise unittest.SkipTest("not installed: " + ", ".join(missing))
    if root and os.geteuid() != 0:
        raise unittest.SkipTest("needs root")


def pack(generator, directory, *definitions):
    """cpack's files of the build, by package name."""
    need("cpack", "dpkg-shlibdeps")
    output("cpack", "--config", BUILD / "CPackConfig.cmake", "-G", generator, "-B", directory,
           *(part for definition in definitions for part in ("-D", definition)))
    shutil.rmtree(pathlib.Path(directory) / "_CPack_Packages")
    return {file.name.split("_")[0]: file for file in sorted(pathlib.Path(directory).iterdir())}


def field(package, name):
    return output("dpkg-deb", "--field", package, name).strip()


def dependencies(package, kind="Depends"):
    return {word.split()[0] for word in field(package, kind).split(",") if word}


def debian_root(includes):
    """A Debian with systemd and `includes` below the build directory; made once, which takes minutes."""
    need("mmdebstrap", root=True)
    root = BUILD / "packages-root"
    mark = BUILD / "packages-root.includes"
    wanted = ",".join(sorted({"systemd-sysv", *includes}))
    if not mark.exists() or mark.read_text() != wanted:
        mark.unlink(missing_ok=True)
        shutil.rmtree(root, ignore_errors=True)
        result = subprocess.run(["mmdebstrap", "--quiet", "--variant=minbase", "--include=" + wanted, "bookworm", root],
                                capture_output=True, text=True)
        if result.returncode != 0:
            raise unittest.SkipTest("no Debian root could be made: " + result.stderr[-500:])
        mark.write_text(wanted)
    return root


class Machine:
    """with Machine(root) as machine: machine.run("systemctl", "status")"""

    def __init__(self, root):
        need("systemd-nspawn", "nsenter", root=True)
        self.base = root
        self.directory = pathlib.Path(tempfile.mkdtemp(prefix="parray-machine-"))
        self.root = self.directory / "root"
        self.process = None

    def __enter__(self):
        for name in ("root", "upper", "work"):
            (self.directory / name).mkdir()
        try:
            output("mount", "-t", "overlay", "overlay", "-o", f"lowerdir={self.base},"
                   f"upperdir={self.directory}/upper,workdir={self.directory}/work", self.root)
            self.boot()
        except AssertionError as problem:
            self.close()
            raise unittest.SkipTest(f"no machine with systemd can be started here: {problem}") from problem
        return self

    def __exit__(self, *_):
        self.close()

    def boot(self):
        with (self.directory / "console").open("w") as log:
            self.process = subprocess.Popen(
                ["systemd-nspawn", "--quiet", "--register=no", "--keep-unit", "--private-network", "--boot", "--machine",
                 f"parray-{os.getpid()}", "--directory", self.root], stdin=subprocess.DEVNULL, stdout=log, stderr=log)
        self.until(lambda: self.process.poll() is not None or self.leader() and
                   self.call("systemctl", "is-system-running").stdout.strip() in ("running", "degraded"))
        if self.process.poll() is not None:
            raise AssertionError((self.directory / "console").read_text()[-1000:])

    def leader(self):
        children = pathlib.Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children").read_text().split()
        return children[0] if children else None

    @staticmethod
    def until(condition, seconds=300):
        end = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > end:
                raise AssertionError(f"waited {seconds} s")
            time.sleep(0.2)

    def call(self, *command):
        return subprocess.run(["nsenter", "--target", self.leader(), "--all", "--root", "--wd", "env", "-i",
                               "PATH=/usr/sbin:/usr/bin", "HOME=/root", "DEBIAN_FRONTEND=noninteractive", *map(str, command)],
                              capture_output=True, text=True, stdin=subprocess.DEVNULL)

    def run(self, *command):
        result = self.call(*command)
        if result.returncode != 0:
            raise AssertionError(f"{command}: status {result.returncode}\n{result.stdout}\n{result.stderr}\n" +
                                 self.call("journalctl", "--no-pager", "-n", "30", "-u", "parray-*").stdout)
        return result.stdout

    def state(self, service, what="ActiveState"):
        return self.run("systemctl", "show", "--value", "-p", what, service).strip()

    def copy(self, files):
        """Where the machine has the host's files now."""
        target = self.root / "packages"
        shutil.rmtree(target, ignore_errors=True)
        target.mkdir()
        for file in files:
            shutil.copy(file, target)
        return ["/packages/" + file.name for file in files]

    def close(self):
        if self.process and self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)  # an orderly shutdown
            try:
                self.process.wait(60)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
        subprocess.run(["umount", self.root], capture_output=True)
        shutil.rmtree(self.directory)
