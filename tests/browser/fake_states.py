"""A fake farm with one job, series, frame or worker in a given state, and the buttons that the page must offer for it."""

import copy

import fake_rules
from fake_farm import worker_of
from fake_jobs import CANCELLED, DONE, FAILED, PAUSED, QUEUED, RUNNING, SERIES, UNLIMITED, JobFarm

FRAME = SERIES + 1  # number of the job of frame 0
FRAMES = 5
LABELS = {"pause": "Pause", "resume": "Resume", "cancel": "Cancel", "requeue": "Requeue", "forget": "Delete", "priority": "Set"}
DOWNLOADS = {"image.png": "PNG", "image.exr": "EXR", "error.png": "Error map", "report": "Report", "frames.zip": "All frames (zip)"}


def one(number, **fields):
    """Makes a state: a single job of JobFarm with other fields."""
    def make(farm):
        farm.jobs[number].update(fields)
        if not farm.jobs[number]["has_picture"]:
            farm.jobs[number].pop("error", None)
        return number
    return make


def series(*states, shown=None, missing=()):
    """Makes a state: a series with frames in these states. `shown`: the frame to look at, otherwise the series."""
    def make(farm):
        for index, state in enumerate(states):
            set_frame(farm.jobs[FRAME + index], state)
        for index in missing:
            del farm.jobs[FRAME + index]
        fake_rules.sum_up(farm.jobs, farm.jobs[SERIES])
        return SERIES if shown is None else FRAME + shown
    return make


def set_frame(job, state):
    begun = state not in ("queued", "paused")
    job.update(state=state, progress={"done": 1.0, "running": 0.4}.get(state, 0.0), has_picture=state in ("done", "running", "failed"),
               started=1.7e9 if begun else None, seconds_taken=40.0 if begun else None,
               reason={"failed": "the scene is damaged", "paused": "paused by 'ann'"}.get(state, ""))
    if not job["has_picture"]:
        job.pop("error", None)


DONE_FRAMES = ("done",) * FRAMES
JOB_STATES = {
    "queued": one(QUEUED), "running": one(RUNNING), "paused": one(PAUSED), "finishing": one(RUNNING, state="finishing"), "done": one(DONE),
    "failed": one(FAILED), "cancelled": one(CANCELLED), "running for days": one(UNLIMITED),
    "held back by the coordinator": one(PAUSED, reason="the disk is full: free some space"),
    "done, its picture no longer kept": one(DONE, has_picture=False), "cancelled without a picture": one(CANCELLED, has_picture=False),
    "queued series": series(*["queued"] * FRAMES), "running series": series("done", "running", "queued", "queued", "queued"),
    "running series with stopped frames": series("done", "failed", "cancelled", "running", "queued"),
    "running series with a paused frame": series("done", "paused", "running", "queued", "queued"),
    "paused series": series("done", "paused", "paused", "paused", "paused"), "done series": series(*DONE_FRAMES),
    "failed series": series("failed", *DONE_FRAMES[1:]), "cancelled series": series("done", *["cancelled"] * 4),
    "series that waits for a frame": series(*DONE_FRAMES, missing=[2]),
    "series with a failed frame that waits for another": series("failed", *DONE_FRAMES[1:], missing=[2]),
    "done frame of a running series": series("done", "running", "queued", "queued", "queued", shown=0),
    "running frame": series("done", "running", "queued", "queued", "queued", shown=1),
    "queued frame": series("done", "running", "queued", "queued", "queued", shown=2),
    "paused frame": series("done", "running", "paused", "queued", "queued", shown=2),
    "failed frame of a running series": series("failed", "running", "queued", "queued", "queued", shown=0),
    "cancelled frame of a running series": series("cancelled", "running", "queued", "queued", "queued", shown=0),
    "done frame of a done series": series(*DONE_FRAMES, shown=0), "failed frame of a failed series": series("failed", *DONE_FRAMES[1:], shown=0),
    "frame of a series that waits for another": series(*DONE_FRAMES, missing=[2], shown=0)}


class StateFarm(JobFarm):
    """A JobFarm for one user after another state: become("running series")."""

    def __init__(self, user, **options):
        super().__init__(frames=FRAMES, role=user[0], user=user[1], **options)
        self.fresh = copy.deepcopy(self.jobs)

    def become(self, state):
        """Returns the number of the job in this state. All other jobs are those of JobFarm."""
        self.jobs = copy.deepcopy(self.fresh)
        self.refused.clear()
        return JOB_STATES[state](self)

    def permitted(self, number):
        """The words that the rules permit and that change something."""
        return [word for word in fake_rules.JOB_WORDS
                if not self.refusal_of(number, word) and fake_rules.changes_something(self.jobs, number, word)]

    def labels_of(self, number):
        """The buttons that act on a job, or download of it, that the page must offer: {label: word or file}."""
        job = self.jobs[number]
        labels = {LABELS[word]: word for word in self.permitted(number)}
        if "Requeue" in labels and "frames" in job and fake_rules.unfinished(job):
            labels[self.requeue_label(number)] = labels.pop("Requeue")
        if "Cancel" in labels and job.get("warning"):
            labels["Cancel job"] = "cancel"
        for file, label in DOWNLOADS.items():
            if not fake_rules.file_refusal(self.jobs, number, file) and (file != "error.png" or job.get("error")):
                labels[label] = file
        return labels

    def requeue_label(self, number):
        states = [job["state"] for job in fake_rules.frames_of(self.jobs, number)]
        stopped = [state for state in ("failed", "cancelled") if state in states]
        count = sum(states.count(state) for state in stopped)
        return f"Requeue {count} {' or '.join(stopped)} {'frame' if count == 1 else 'frames'}"


WORKER = "node0001"
WORKER_STATES = {
    "idle": {"state": "ready", "leases": 0, "tracing": None}, "tracing": {"state": "ready", "leases": 2},
    "backoff": {"state": "backoff", "leases": 0, "tracing": None, "reason": "failed at job 7", "backoff_seconds": 60.0},
    "draining": {"state": "draining", "leases": 2}, "drained": {"state": "drained", "leases": 0, "tracing": None},
    "quarantined": {"state": "quarantined", "leases": 0, "tracing": None, "reason": "gave two wrong rows"}}
ABSENT = {"name": WORKER, "host": "", "threads": 0, "leases": 0, "accepted": 0, "samples_per_second": 0.0, "state": "quarantined",
          "reason": "gave two wrong rows", "machine": "address 10.0.0.1", "quarantine_ends": 0, "seconds_silent": 60.0}


def set_worker(farm, state):
    """Makes a worker have a state: one of WORKER_STATES, or "absent", a machine in quarantine without a worker."""
    farm.drained_hosts.clear()
    farm.refused.clear()
    farm.workers = {worker["name"]: worker for worker in map(worker_of, range(3))}
    farm.workers[WORKER].update(WORKER_STATES.get(state, {}))
    if state == "absent":
        farm.workers[WORKER] = dict(ABSENT)


def worker_labels(farm):
    """The buttons that the page must offer for the worker: those that change its state."""
    state = farm.workers[WORKER]["state"]
    if fake_rules.worker_refusal((farm.role, farm.user)):
        return {}
    return {**({"Drain": "drain"} if state in ("ready", "backoff") else {}), **({"Resume": "readmit"} if state != "ready" else {})}
