"""One history: a farm of real processes behind a proxy, the events of its plan, and the checks at the end."""

import contextlib
import datetime
import functools
import heapq
import itertools
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time

import impostors
import plans
from proxy import Faults, Proxy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "integration"))
from farm import BIN, SCENES, Farm, run, wait_for  # noqa: E402

SMALL_DISK = 16 << 20  # bytes
PATIENCE = 90  # seconds until all jobs must be done, once nothing disturbs them any more
WRONG_SHARE = 0.2  # share of the faulty worker's results that are wrong
UNCHECKED = "not checked completely"  # part of the flag of a job


class Wrong(Exception):
    """A violation of what must always be true."""


def picture_facts(report):
    """Returns the facts that must be the same for all pictures of a job."""
    return {key: report[key] for key in ("image_sha256", "samples", "rays", "nonfinite_samples")}


def expected_facts(kind):
    """Returns the facts of the picture of `parray render`."""
    scene, *options = plans.SPECS[kind]
    with tempfile.TemporaryDirectory() as directory:
        done = run("render", SCENES / scene, *plans.SIZE, *options, "--quiet", "-o", f"{directory}/a.png",
                   "--report", f"{directory}/a.json")
        if done.returncode != 0:
            raise Wrong(f"parray render: {done.stderr}")
        return picture_facts(json.loads(pathlib.Path(directory, "a.json").read_text()))


# A second machine's. All addresses that begin with 127 are one machine's.
FAULTY_ADDRESS = "10.77.0.2"


def own_namespaces():
    """Returns whether the history has its own mounts, processes and addresses."""
    return os.environ.get("PARRAY_OWN_NAMESPACES") == "1"


def add_address():
    if own_namespaces():
        for command in (["link", "set", "lo", "up"], ["address", "add", FAULTY_ADDRESS + "/32", "dev", "lo"]):
            subprocess.run(["ip", *command], check=True, capture_output=True)


@functools.cache
def may_audit():
    """Returns whether this parray has the command audit."""
    return "\n  audit " in run("--help").stdout


class ChaosFarm(Farm):
    """A farm with workers and clients that connect through `proxy`."""

    def __init__(self, plan):
        state = pathlib.Path(tempfile.mkdtemp(prefix="parray-chaos-state-"))
        super().__init__("--state", state, "--heartbeat", "0.1", "--lease-timeout", "1", "--max-failures", "1000",
                         "--spot-checks", plan.spot_checks)
        self.state = state
        self.stack = contextlib.ExitStack()
        self.stack.callback(self._remove_state)
        self.small_disk = plan.small_disk and own_namespaces()
        if self.small_disk:
            subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={SMALL_DISK}", "tmpfs", state], check=True)
            self.stack.callback(subprocess.run, ["umount", state], check=True)
        self.seed = plan.seed
        self.names = itertools.count(1)
        self.workers_now = []

    def _remove_state(self):
        subprocess.run(["rm", "-r", self.state], check=True)

    def __enter__(self):
        super().__enter__()
        port = int(self.address.rsplit(":", 1)[1])
        self.proxy = self.stack.enter_context(Proxy(("127.0.0.1", port), self.seed))
        return self

    def close(self):
        super().close()
        self.stack.close()

    def start_impostor(self, rewrite, source=None):
        """Starts a worker with a separate proxy that rewrites its messages. The coordinator sees it at the address `source`."""
        proxy = self.stack.enter_context(Proxy(self.proxy.target, self.seed, rewrite, source))
        return self._start("parray-worker", "--connect", proxy.address, "--threads", 1, "--name", "impostor")

    def add_worker(self):
        """Starts a worker with a new name, because a worker that is lost repeatedly fails its job, as it should."""
        worker = self._start("parray-worker", "--connect", self.proxy.address, "--threads", 1, "--name",
                             f"w{next(self.names)}")
        self.workers_now.append(worker)

    def start_submit(self, scene, *options):
        submit = self._start("parray", "submit", SCENES / scene, *plans.SIZE, *options, "--coordinator",
                             self.proxy.address, stdout=subprocess.PIPE)
        return submit

    def ballast(self):
        return self.state / "ballast"

    def fill_disk(self):
        with contextlib.suppress(OSError), self.ballast().open("wb", buffering=0) as file:
            while True:
                file.write(bytes(4096))

    def coordinator_logs(self):
        return "".join(log.read_text() for log in sorted(self.directory.glob("*-parray-coordinator.log")))


def processes_left():
    """Returns the processes that are left in the own process namespace. Child processes of a killed coordinator become
children of this process, the first of the namespace, which reads their exit statuses here."""
    with contextlib.suppress(ChildProcessError):
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass
    return [pid for pid in os.listdir("/proc") if pid.isdigit() and int(pid) != os.getpid()]


class History:
    def __init__(self, plan, expected):
        self.plan = plan
        self.expected = expected  # facts by kind
        self.notes = []
        self.due = []  # (time, order, what to do)
        self.order = itertools.count()
        self.submits = []  # (job, process, report)
        self.steering = []  # clients that pause and resume
        self.kills = 0
        self.unchecked = 0  # number of wrong pictures whose reports say that a part was not checked
        self.event_times = []

    def run(self):
        """Runs the history and returns its figures. Raises Wrong or AssertionError; `notes` then has the events."""
        self.began = time.monotonic()
        with ChaosFarm(self.plan) as self.farm:
            try:
                for _ in range(self.plan.workers):
                    self.farm.add_worker()
                self.start_impostor()
                for job in self.plan.jobs:
                    self.at(job.at, lambda job=job: self.submit(job))
                for event in self.plan.events:
                    self.at(event.at, lambda event=event: self.begin(event))
                self.play()
                self.settle()
                self.check_jobs()
                self.check_logs()
                self.check_impostor()
                self.end()
                return self.figures()
            except BaseException:
                self.keep_logs()
                raise

    def start_impostor(self):
        self.faulty = impostors.FaultyWorker(self.plan.seed, WRONG_SHARE)
        if self.plan.impostor == "another release":
            self.impostor = self.farm.start_impostor(impostors.of_another_release)
        elif self.plan.impostor == "faulty" and own_namespaces():
            self.impostor = self.farm.start_impostor(self.faulty, FAULTY_ADDRESS)

    # What happens

    def at(self, seconds, what):
        heapq.heappush(self.due, (self.began + seconds, next(self.order), what))

    def later(self, seconds, what):
        self.at(time.monotonic() - self.began + seconds, what)

    def note(self, text):
        self.notes.append(f"{time.monotonic() - self.began:6.2f} {text}")

    def play(self):
        while self.due:
            moment, _, what = heapq.heappop(self.due)
            time.sleep(max(0, moment - time.monotonic()))
            what()

    def begin(self, event):
        self.event_times.append(datetime.datetime.now())
        self.note(f"{event.what} {event.lasts or ''} {event.which}")
        getattr(self, event.what)(event)

    def submit(self, job):
        scene, *options = plans.SPECS[job.kind]
        number = len(self.submits)
        report = self.farm.directory / f"submit-{number}.json"
        if job.waits:
            options += ["--wait", "-o", self.farm.directory / f"submit-{number}.png", "--report", report, "--quiet"]
        self.note(f"submit {job.kind}")
        self.submits.append((job, self.farm.start_submit(scene, *options, "--priority", job.priority), report))

    def some_worker(self, event):
        alive = [worker for worker in self.farm.workers_now if worker.poll() is None]
        return alive[event.which % len(alive)] if alive else None

    def kill_worker(self, event):
        worker = self.some_worker(event)
        if worker:
            worker.kill()
            worker.wait()
            self.kills += 1
            self.farm.workers_now.remove(worker)
        self.later(event.lasts, self.farm.add_worker)

    def stop_worker(self, event):
        worker = self.some_worker(event)
        if worker:
            worker.send_signal(signal.SIGSTOP)
            self.later(event.lasts, lambda: worker.send_signal(signal.SIGCONT))

    def end_worker(self, event):
        worker = self.some_worker(event)
        if worker:
            self.farm.workers_now.remove(worker)
            self.end_process(worker)
        self.later(event.lasts, self.farm.add_worker)

    def new_worker(self, _):
        self.farm.add_worker()

    def coordinator_lives(self):
        return self.farm.coordinator.poll() is None

    def kill_coordinator(self, event):
        if self.coordinator_lives():
            self.farm.coordinator.kill()
            self.farm.coordinator.wait()
            self.kills += 1
            self.later(event.lasts, self.restart_coordinator)

    def end_coordinator(self, event):
        if self.coordinator_lives():
            self.end_process(self.farm.coordinator)
            self.later(event.lasts, self.restart_coordinator)

    def stop_coordinator(self, event):
        coordinator = self.farm.coordinator
        if self.coordinator_lives():
            coordinator.send_signal(signal.SIGSTOP)
            self.later(event.lasts, lambda: coordinator.send_signal(signal.SIGCONT))

    def restart_coordinator(self):
        self.note("the coordinator starts again")
        try:
            self.farm.start_coordinator(self.farm.address)
        except AssertionError:
            if not self.farm.ballast().exists():
                raise
            self.note("which it cannot, with its disk full")
            self.later(0.5, self.restart_coordinator)

    def end_process(self, process):
        process.send_signal(signal.SIGCONT)
        process.send_signal(signal.SIGTERM)
        try:
            status = process.wait(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            raise Wrong(f"{process.args[0]} does not end on SIGTERM: {process.log}") from None
        said = process.log.read_text()
        if status != 0 and (status != -signal.SIGTERM or said):  # before its first word it may not have been ready
            raise Wrong(f"{process.args[0]} ends with status {status} on SIGTERM: {said}")

    def cut(self, _):
        self.farm.proxy.cut()

    def tear(self, _):
        self.farm.proxy.tear()

    def freeze(self, event):
        self.farm.proxy.freeze(True)
        self.later(event.lasts, lambda: self.farm.proxy.freeze(False))

    def swallow(self, event):
        self.farm.proxy.swallow(True)
        self.later(event.lasts, lambda: self.farm.proxy.swallow(False))

    def _mistreat(self, event, faults):
        self.farm.proxy.faults = faults
        self.later(event.lasts, lambda: setattr(self.farm.proxy, "faults", Faults()))

    def lose(self, event):
        self._mistreat(event, Faults(drop=(event.which % 5 + 1) / 10))

    def shuffle(self, event):
        self._mistreat(event, Faults(repeat=0.3, reorder=0.3))

    def corrupt(self, event):
        self._mistreat(event, Faults(corrupt=0.3))

    def slow(self, event):
        self._mistreat(event, Faults(delay=0.1, reorder=0.1))

    def pause_job(self, event):
        """Pauses a job, with a client that may get no answer because the coordinator is away."""
        job = event.which % 3 + 1
        self._start_steering("pause", job)
        self.later(event.lasts, lambda: self._start_steering("resume", job))

    def _start_steering(self, command, job):
        self.steering.append(self.farm._start("parray", command, job, "--coordinator", self.farm.proxy.address))

    def fill_disk(self, event):
        if self.farm.small_disk:
            self.farm.fill_disk()
            self.later(event.lasts, lambda: self.farm.ballast().unlink(missing_ok=True))

    # What must be true

    def settle(self):
        """Ends all faults. There are workers, so everything must now complete."""
        self.note("calm")
        self.farm.proxy.calm()
        if not self.coordinator_lives():
            raise Wrong("the coordinator has ended by itself: " + self.farm.coordinator.log.read_text())
        for worker in self.farm.workers_now:
            if worker.poll() is not None:
                raise Wrong(f"a worker has ended by itself, status {worker.returncode}: " + worker.log.read_text())
        for client in self.steering:
            client.wait(timeout=PATIENCE)
        for number in range(1, len(self.submits) + 1):
            self.farm.client("resume", number)  # because its `resume` may have arrived before the `pause`
        self.acknowledged = {}  # number: kind
        self.perhaps = []  # kinds of jobs that may have been submitted nevertheless
        again = [job for job, process, report in self.submits if not self.end_submit(job, process, report)]
        for job in again:
            scene, *options = plans.SPECS[job.kind]
            self.acknowledged[self.farm.submit(SCENES / scene, *plans.SIZE, *options)] = job.kind

    def end_submit(self, job, process, report):
        """Ends a submit. Returns False if the client got no answer and said so."""
        try:
            process.wait(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            raise Wrong(f"a client still waits: parray {process.args[1:]}: {process.log.read_text()}") from None
        printed = process.stdout.read().strip()
        process.stdout.close()
        said = process.log.read_text()
        if process.returncode == 0:
            if job.waits:
                self.compare(job.kind, json.loads(report.read_text()))
                self.perhaps.append(job.kind)
            else:
                self.acknowledged[int(printed)] = job.kind
            return True
        excused = "no answer from the coordinator" in said or (self.farm.small_disk and "No space left" in said)
        if process.returncode != 1 or not excused:
            raise Wrong(f"submit {job.kind}: status {process.returncode}: {said}")
        self.note(f"submit {job.kind} was given up: {said.strip()}")
        self.perhaps.append(job.kind)
        return False

    def compare(self, kind, report):
        facts = picture_facts(report)
        if facts != self.expected[kind] and not self.excused(report):
            raise Wrong(f"job '{kind}': {facts} instead of {self.expected[kind]}")

    def excused(self, report):
        """Returns whether a faulty worker may have changed the picture, because its report says that nobody checked a part."""
        return bool(self.faulty.wrong) and UNCHECKED in report["flag"]

    def jobs(self):
        listed = self.farm.client("jobs", "--json")
        if listed.returncode != 0:
            raise Wrong(f"parray jobs: {listed.stderr}")
        return {job["id"]: job for job in json.loads(listed.stdout)}

    def check_jobs(self):
        ended = ("done", "failed", "cancelled")
        try:
            wait_for(lambda: all(job["state"] in ended for job in self.jobs().values()), "all jobs to end", PATIENCE)
        except AssertionError:
            raise Wrong(f"jobs that do not end: {self.jobs()}") from None
        jobs = self.jobs()
        lost = self.acknowledged.keys() - jobs.keys()
        if lost:
            raise Wrong(f"acknowledged jobs {lost} are lost")
        if len(jobs) > len(self.acknowledged) + len(self.perhaps):
            raise Wrong(f"{len(jobs)} jobs of {len(self.acknowledged) + len(self.perhaps)} submits")
        for number, job in jobs.items():
            if job["state"] != "done":
                raise Wrong(f"job {number} is {job['state']}: {job['reason']}")
            # A flag about a check without a second machine is not an error.
            if job["flag"] and UNCHECKED not in job["flag"] and not self.faulty.wrong:
                raise Wrong(f"job {number} is flagged: {job['flag']}")
            self.check_picture(number)
        self.pictures = len(jobs)

    def check_picture(self, number):
        report = self.farm.fetch(number)
        facts = picture_facts(report)
        kind = self.acknowledged.get(number)
        wanted = [self.expected[kind]] if kind else [self.expected[kind] for kind in self.perhaps]
        if facts not in wanted and self.excused(report):
            self.unchecked += 1
        elif facts not in wanted:
            raise Wrong(f"job {number} {kind or self.perhaps}: {facts} instead of {wanted}")
        if may_audit():
            self.audit(number)

    def audit(self, number):
        audit = self.farm.client("audit", number)
        if audit.returncode != 0:
            raise Wrong(f"audit of job {number}: {audit.stdout}{audit.stderr}")

    def check_logs(self):
        expected = ["jobs wait: "] if self.farm.small_disk else []
        if self.faulty.wrong:
            expected += [f"worker 'impostor' (address {FAULTY_ADDRESS}) returned wrong bits", "returned different bits for the same samples"]
        for line in self.farm.coordinator_logs().splitlines():
            if ("[error]" in line or "[critical]" in line) and not any(text in line for text in expected):
                raise Wrong("the coordinator's log: " + line)

    def check_impostor(self):
        if self.plan.impostor == "another release":
            if self.impostor.wait(timeout=PATIENCE) != 1 or "trace version" not in self.impostor.log.read_text():
                raise Wrong("a worker of another release was not refused: " + self.impostor.log.read_text())

    def end(self):
        """Checks that all processes end on SIGTERM."""
        for process in self.farm.processes:
            if process.poll() is None and not process.args[0].name == "parray":
                self.end_process(process)
        if own_namespaces():
            for process in self.farm.processes:
                process.wait(timeout=PATIENCE)
            try:
                wait_for(lambda: not processes_left(), "all processes to end", PATIENCE)
            except AssertionError:
                raise Wrong("processes are left: " + " ".join(
                    pathlib.Path("/proc", pid, "cmdline").read_text() for pid in processes_left())) from None

    def keep_logs(self):
        self.logs = pathlib.Path(tempfile.mkdtemp(prefix=f"parray-chaos-failed-{self.plan.seed}-"))
        for log in self.farm.directory.iterdir():
            (self.logs / log.name).write_bytes(log.read_bytes())

    def late(self, log):
        """Returns the number of events after all jobs were done."""
        done = max(re.findall(r"^\[([^]]*)\].* job \d+ '[^']*' is done", log, re.M))
        return sum(at.isoformat(" ") > done for at in self.event_times)

    def figures(self):
        log = self.farm.coordinator_logs()
        counts = self.farm.proxy.counts
        return {"seed": self.plan.seed, "seconds": round(time.monotonic() - self.began, 2), "kills": self.kills,
                "pictures": self.pictures, "leases": len(re.findall(r"job \d+ lease \d+ to worker", log)),
                "accepted": len(re.findall(r"lease \d+ accepted", log)),
                "cuts": counts["cuts"] + counts["torn"],
                "messages": counts["messages"],
                "wrong_results": len(self.faulty.wrong), "unchecked": self.unchecked, "late": self.late(log),
                "faults": sum(counts[kind] for kind in ("drop", "repeat", "reorder", "corrupt", "swallowed"))}
