"""An mpirun of parray-mpi as real processes, for tests: everything that it started is ended when the
test is over, by process id."""

import contextlib
import json
import os
import pathlib
import re
import shutil
import signal
import sqlite3
import subprocess
import tempfile

from farm import BIN, wait_for
from longer_jobs import JobOverTooEarly

# Open MPI unloads parts of itself that hold memory: a sanitized build would call that leaks.
ENVIRONMENT = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
               "ASAN_OPTIONS": "detect_leaks=0"}


def why_not():
    """Why parray-mpi cannot be tested here; empty if it can."""
    if not shutil.which("mpirun"):
        return "mpirun is missing"
    return "" if (BIN / "parray-mpi").exists() else "parray-mpi is not built"


def processes_of_session(session):
    """Process ids, with their parents, states and names."""
    found = {}
    for entry in pathlib.Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            name, fields = re.match(r"\d+ \((.*)\) (.*)", (entry / "stat").read_text(),
                                    re.DOTALL).groups()
        except OSError:  # it has just ended
            continue
        state, parent, _, own_session = fields.split()[:4]
        if int(own_session) == session and state != "Z":
            found[int(entry.name)] = (int(parent), state, name)
    return found


class MpiRun:
    """with MpiRun(2, scene, *options) as run: ... One mpirun, in a session of its own."""

    def __init__(self, ranks, *options, mpirun=(), env=None, picture="a.png", program="parray-mpi"):
        """`ranks` None: parray-mpi without mpirun. `picture`: a PNG file is written five times as fast as an EXR one,
        whose library loads 260 others."""
        self.directory = pathlib.Path(tempfile.mkdtemp(prefix="parray-test-"))
        self.picture = self.directory / picture
        options = list(options)
        self.state = options[options.index("--state") + 1] if "--state" in options else None
        if "-o" not in options:
            options += ["-o", self.picture, "--report", self.directory / "a.json"]
        self.log = self.directory / "log"
        launcher = ["mpirun", "-n", str(ranks), "--oversubscribe", *mpirun] if ranks else []
        with self.log.open("w") as log:
            self.process = subprocess.Popen(
                [*launcher, BIN / program, *map(str, options)],
                stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT,
                env={**ENVIRONMENT, **(env or {})}, start_new_session=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        try:
            self._end_all()
        finally:
            self.process.wait()
            shutil.rmtree(self.directory)

    def _end_all(self):
        def gone():
            left = processes_of_session(self.process.pid)
            for pid in left:
                for number in (signal.SIGCONT, signal.SIGKILL):
                    try:
                        os.kill(pid, number)
                    except ProcessLookupError:
                        pass
            self.process.poll()
            return not left

        wait_for(gone, "everything to end", timeout=30)

    def rank_pid(self, rank):
        """The process id of a rank, once it runs."""
        def find():
            self.check_runs()
            for pid, (_, _, name) in processes_of_session(self.process.pid).items():
                try:
                    environment = pathlib.Path(f"/proc/{pid}/environ").read_bytes().split(b"\0")
                except OSError:
                    continue
                if (name.startswith("parray-mpi") and
                        f"OMPI_COMM_WORLD_RANK={rank}".encode() in environment):
                    return pid
            return None

        return wait_for(find, f"rank {rank}")

    def check_runs(self):
        if self.process.poll() is not None:
            raise JobOverTooEarly("the job is over: " + self.text())

    def send(self, number, rank):
        """Sends a signal to a rank, and returns its process id."""
        pid = self.rank_pid(rank)
        try:
            os.kill(pid, number)
        except ProcessLookupError:
            raise JobOverTooEarly(f"rank {rank} is over: {self.text()}") from None
        return pid

    @contextlib.contextmanager
    def stopped(self, rank):
        """A rank is stopped meanwhile."""
        pid = self.send(signal.SIGSTOP, rank)
        yield
        try:
            os.kill(pid, signal.SIGCONT)
        except ProcessLookupError:
            raise JobOverTooEarly(f"rank {rank} ended before it was stopped: {self.text()}") from None

    def ranks(self):
        return [pid for pid, (_, _, name) in processes_of_session(self.process.pid).items()
                if name.startswith("parray-mpi")]

    def wait(self, timeout=120):
        """The exit status; no rank is left then."""
        self.process.wait(timeout)
        wait_for(lambda: not self.ranks(), "the ranks to end")
        return self.process.returncode

    def wait_for_failure(self, may_be_done=False):
        """Until a disturbed job has failed. `may_be_done`: other ranks can finish its work meanwhile."""
        if self.wait() == 0 or (not may_be_done and re.search("100.0 % +done", self.text())):
            raise JobOverTooEarly("the job is done: " + self.text())
        if self.state:
            check_unfinished(self.state)

    def text(self):
        return self.log.read_text()

    def lines(self):
        """What parray-mpi itself has said, without what Open MPI says about it."""
        return [line for line in self.text().splitlines() if line.startswith("parray-mpi: ")]

    def report(self):
        return json.loads((self.directory / "a.json").read_text())

    def finish(self, timeout=120):
        """The report of a job that succeeds."""
        status = self.wait(timeout)
        assert status == 0, f"exit status {status}: {self.text()}"
        return self.report()


def kept_bytes(state):
    """How much of finished rows a state has on the disk, of whichever job."""
    return sum(rows_files(state))


def committed(state, query):
    """The value that the state's database has for a query, even while a coordinator runs; None: none, or ask again."""
    with tempfile.TemporaryDirectory() as copy:  # a coordinator locks its database
        for name in ("parray.sqlite", "parray.sqlite-wal"):
            with contextlib.suppress(FileNotFoundError):
                shutil.copy(state / name, copy)
        try:
            with contextlib.closing(sqlite3.connect(f"file:{copy}/parray.sqlite?mode=rw", uri=True)) as store:
                found = store.execute(query).fetchone()
                return found and found[0]
        except sqlite3.Error:  # copied while it was made or written
            return None


def committed_bytes(state):
    """How many bytes of finished rows the last commit counts."""
    return committed(state, "SELECT total(bytes) FROM logs") or 0


def check_unfinished(state):
    """The state of a killed program has no finished job."""
    if committed(state, "SELECT count(*) FROM pictures"):
        raise JobOverTooEarly(f"the job in {state} is done")


def rows_files(state):
    """The size of each file of rows."""
    for path in state.glob("jobs/*/rows*"):
        with contextlib.suppress(FileNotFoundError):
            found = path.stat()
            yield found.st_size


def kept_passes(state):
    """How many passes of its first job the last commit knows of."""
    record = committed(state, "SELECT record FROM jobs WHERE id = 1")
    return len(json.loads(record)["passes"]) if record else 0
