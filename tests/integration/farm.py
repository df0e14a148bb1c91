"""A coordinator, workers and clients as real processes, for tests. Free ports, everything ended by
its process id when the test is over."""

import json
import os
import pathlib
import resource
import shutil
import signal
import subprocess
import tempfile
import time

BIN = pathlib.Path(os.environ["PARRAY_BIN_DIR"])
SOURCE = pathlib.Path(os.environ["PARRAY_SOURCE_DIR"])
SCENES = SOURCE / "scenes"


def run(*arguments, timeout=120, env=None):
    """A finished parray command."""
    return subprocess.run([BIN / "parray", *map(str, arguments)], capture_output=True, text=True,
                          errors="surrogateescape", timeout=timeout, env={**os.environ, **(env or {})})


def child_processor_seconds():
    """Used by the children that have ended, with theirs."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def wait_for(condition, what, timeout=60):
    """Asks less often if a question takes long, because those that start a process would need half a processor."""
    end = time.monotonic() + timeout
    while (begin := time.monotonic()) < end:
        result = condition()
        if result:
            return result
        time.sleep(min(max(0.02, 5 * (time.monotonic() - begin)), 0.2))
    raise AssertionError(f"waited {timeout} s for {what}")


class Farm:
    """with Farm() as farm: ..."""

    def __init__(self, *options, log_level="debug", bind="tcp://127.0.0.1:*"):
        self.options = options
        self.bind = bind
        self.log_level = log_level
        self.directory = pathlib.Path(tempfile.mkdtemp(prefix="parray-test-"))
        self.processes = []
        self.logs = 0

    def __enter__(self):
        self.start_coordinator()
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        for process in self.processes:
            if process.poll() is None:
                process.send_signal(signal.SIGCONT)
                process.kill()
            process.wait()
        shutil.rmtree(self.directory)

    def _start(self, program, *arguments, stdout=subprocess.DEVNULL):
        self.logs += 1
        log = self.directory / f"{self.logs}-{program}.log"
        with log.open("w") as stderr:
            process = subprocess.Popen([BIN / program, *map(str, arguments)], stdout=stdout,
                                       stderr=stderr, text=True)
        process.log = log
        self.processes.append(process)
        return process

    def start_coordinator(self, bind=None):
        self.coordinator = self._start("parray-coordinator", "--bind", bind or self.bind, "--log-level", self.log_level,
                                       *self.options, stdout=subprocess.PIPE)
        self.address = self.coordinator.stdout.readline().strip()
        self.coordinator.stdout.close()
        if not self.address:
            raise AssertionError("no coordinator: " + self.coordinator.log.read_text())

    def start_worker(self, name, threads=1):
        return self._start("parray-worker", "--connect", self.address, "--threads", threads,
                           "--name", name)

    def client(self, *arguments, timeout=120):
        return run(*arguments, timeout=timeout, env={"PARRAY_COORDINATOR": self.address})

    def start_client(self, *arguments):
        """A parray command that goes on by itself."""
        return self._start("parray", *arguments, "--coordinator", self.address)

    def submit(self, scene, *options):
        result = self.client("submit", scene, *options)
        assert result.returncode == 0, result.stderr
        return int(result.stdout)

    def job(self, number):
        result = self.client("show", number, "--json")
        assert result.returncode == 0, result.stderr
        return json.loads(result.stdout)

    def workers(self):
        result = self.client("workers", "--json")
        assert result.returncode == 0, result.stderr
        return json.loads(result.stdout)

    def fetch(self, number):
        """The report of a finished job, its picture written beside."""
        picture = self.directory / f"{number}.png"  # five times as fast as .exr
        report = self.directory / f"{number}.json"
        result = self.client("fetch", number, "-o", picture, "--report", report)
        assert result.returncode == 0, result.stderr
        return json.loads(report.read_text())

    def finish(self, number, timeout=120):
        result = self.client("watch", number, timeout=timeout)
        assert result.returncode == 0, result.stderr
        return self.fetch(number)

    def coordinator_log(self):
        return self.coordinator.log.read_text()
