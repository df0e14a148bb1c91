"""The coordinator's rules: which request about a job or a worker it refuses, with which status, and what a request changes.
rules_test.py compares them with a real coordinator. A job is a map of the HTTP interface; a user is (role, name)."""

ENDED = ("done", "failed", "cancelled")
JOB_WORDS = ("pause", "resume", "cancel", "requeue", "priority", "forget")
WORKER_WORDS = ("drain", "readmit")
PICTURES = ("image.png", "image.exr", "pixels.f32", "error.png", "error.f32")


def frames_of(jobs, number):
    """The frames of a series; none if the number is that of a single job."""
    return [job for job in jobs.values() if job.get("series") == number and "frame" in job]


def unfinished(job):
    return job["state"] not in ENDED


def held_back(job):
    """Whether the coordinator itself holds the job back: its state is shown as paused, but nobody has paused it."""
    return job["state"] == "paused" and bool(job.get("reason")) and not job["reason"].startswith("paused by ")


def misfit(jobs, job, word, named):
    """Why the state of one job does not permit a word, or None. `named`: the number that the user has named."""
    number, state = job["id"], job["state"]
    wrong = f"job {number} is {state}: only "
    if word == "pause" and (not unfinished(job) or state == "finishing"):
        return wrong + "queued and running jobs can be paused"
    if word == "resume" and held_back(job):
        return f"job {number} continues by itself: no client has paused it; it waits: {job['reason']}"
    if word == "resume" and state != "paused":
        return wrong + "paused jobs can be resumed"
    if word == "cancel" and not unfinished(job):
        return wrong + "unfinished jobs can be cancelled"
    if word == "requeue" and state not in ("failed", "cancelled"):
        return wrong + "failed and cancelled jobs can be queued again"
    if word == "priority" and not unfinished(job):
        return f"job {number} has ended: only unfinished jobs have a priority"
    if word == "forget" and unfinished(job):
        return f"job {number} has not ended yet: cancel it first"
    if word == "forget" and named == number and "frame" in job and unfinished(jobs[job["series"]]):
        return f"job {number} is a frame of series {job['series']}, which has not ended yet: cancel the series first, or delete it as a whole"
    return None


def job_refusal(jobs, number, word, user):
    """(status, detail) of a refused request about a job or a series, or None."""
    if number not in jobs:
        return 404, f"no job {number}: parray jobs lists all jobs"
    role, name = user
    job = jobs[number]
    if role == "client" and job["user"] != name:
        return 403, f"job {number} belongs to '{job['user']}', not to '{name}': ask its owner or an administrator"
    frames = frames_of(jobs, number)
    misfits = [misfit(jobs, one, word, number) for one in frames or [job]]
    if all(misfits) or word == "forget" and any(misfits):
        return 409, (f"series {number}: " if len(frames) > 1 else "") + next(filter(None, misfits))
    return None


def changes_something(jobs, number, word):
    """Whether an accepted request changes anything that a user sees: a paused job can be paused again, without effect."""
    states = [job["state"] for job in frames_of(jobs, number) or [jobs[number]]]
    return word != "pause" or bool({"queued", "running"} & set(states))


def change_job(jobs, number, word, priority=50):
    """Does what the coordinator does after job_refusal() has permitted it."""
    for job in frames_of(jobs, number) or [jobs[number]]:
        if not misfit(jobs, job, word, number):
            change_one(jobs, job, word, priority)
    if word == "forget":
        jobs.pop(number, None)
    for series in [job for job in jobs.values() if "frames" in job]:
        sum_up(jobs, series)


def change_one(jobs, job, word, priority):
    if word == "forget":
        del jobs[job["id"]]
    elif word == "priority":
        job["priority"] = priority
    elif word == "pause":
        if job["state"] != "paused":
            job.update(state="paused", reason=f"paused by a client: parray resume {job['id']}")
    elif word == "resume":
        job.update(state="running" if job.get("started") else "queued", reason="")
    elif word == "cancel":
        job.update(state="cancelled", reason="cancelled by a client")
    else:
        job.update(state="queued", reason="")


def sum_up(jobs, series):
    """Makes the map of a series that of its frames, or removes it with its last frame."""
    frames = frames_of(jobs, series["id"])
    if not frames:
        del jobs[series["id"]]
        return
    states = [job["state"] for job in frames]
    missing = series["frames"] - len(frames)
    state = series_state(states, [bool(job.get("started")) for job in frames], missing)
    waits = f"{missing} of {series['frames']} frames: repeat the same parray submit to submit them"
    waiting = state == "queued" and all(one in ENDED for one in states)
    series.update(state=state, frames_done=states.count("done"), reason=series_reason(frames, series["frames"]), waits_for=waits if waiting else "",
                  priority=next((job for job in frames if unfinished(job)), frames[0])["priority"])


def series_state(states, begun, missing):
    busy = [state for state in states if state not in ENDED]
    if busy and all(state == "paused" for state in busy):
        return "paused"
    if busy:
        return "running" if len(busy) < len(states) or any(begun) else "queued"
    if "cancelled" in states:
        return "cancelled"
    if missing:
        return "queued"
    return "failed" if "failed" in states else "done"


def series_reason(frames, total):
    states = [job["state"] for job in frames]
    if "failed" in states:
        first = frames[states.index("failed")]
        return f"{states.count('failed')} of {total} frames failed: first frame {first['frame']}: {first['reason']}"
    if "cancelled" in states:
        return f"{states.count('cancelled')} of {total} frames were cancelled"
    busy = [job for job in frames if unfinished(job)]
    return busy[0]["reason"] if busy and all(job["state"] == "paused" for job in busy) else ""


def file_refusal(jobs, number, file):
    """(status, detail) of a refused request for a file of a job, or None. Everybody may read every picture."""
    job = jobs.get(number)
    if not job:
        return 404, f"no job {number}: parray jobs lists all jobs"
    if "frames" in job and file != "frames.zip":
        return 409, f"{number} is a series of frames: name the job of one frame"
    if file == "frames.zip":
        if "frames" not in job:
            return 409, f"job {number} is not a series: its picture is image.png"
        done = any(frame["state"] == "done" for frame in frames_of(jobs, number))
        return None if done else (409, f"no frame of series {number} is done: /api/v1/jobs/{number} lists the states of its frames")
    if file == "report" and job["state"] != "done":
        return 409, f"job {number} is {job['state']}, not done: parray watch shows its progress"
    if file in (*PICTURES, "report") and not job.get("has_picture", job["state"] != "queued"):
        return (500, f"the coordinator no longer keeps the picture of job {number}: submit its scene again") if job["state"] == "done" else \
            (409, f"job {number} has no picture yet: try again later")
    return None


def worker_refusal(user):
    role, name = user
    return (403, f"the key '{name}' is a client's: only an administrator may drain and readmit workers") if role == "client" else None


def is_absent(worker):
    """Whether this is a machine in quarantine without a connected worker."""
    return worker["threads"] == 0


def steer_workers(workers, drained_hosts, name, word, host):
    """Drains or readmits the workers of a name or a host, and returns them. `drained_hosts`: set of names of hosts."""
    if host:
        drained_hosts.add(name) if word == "drain" else drained_hosts.discard(name)
    named = [worker for worker in workers.values() if worker["host" if host else "name"] == name]
    found = [worker for worker in named if not is_absent(worker)]
    for worker in named:
        if word == "readmit" and is_absent(worker):
            del workers[worker["name"]]
    for worker in found:
        if word == "drain" and worker["state"] != "quarantined":
            worker["state"] = drained(worker)
        elif word == "readmit":
            worker["state"] = drained(worker) if worker["host"] in drained_hosts else "ready"
            worker.update(reason="")
    return found


def drained(worker):
    return "draining" if worker["leases"] else "drained"
