"""What a fake farm says about itself: users, events, limits, histories, workers one by one, forecasts."""

import copy
import json
import math
import pathlib
import re
import time

OPENAPI = json.loads((pathlib.Path(__file__).resolve().parents[2] / "coordinator/http/openapi.json").read_text())
KINDS = ["joined", "job_done", "started", "lost", "job_failed", "quarantined", "left", "drained", "job_cancelled", "readmitted", "backoff"]
STEPS = 360  # of 10 s each


def history(scale=1.0, steps=STEPS):
    """Samples per second of the last hour: a rise, a break of ten minutes, and a steady rest."""
    def share(i):
        if i < 40:
            return i / 40
        if 150 <= i < 210:
            return 0.0
        return 0.86 + 0.1 * math.sin(i / 9) + 0.04 * math.sin(i * 1.7)

    return [scale * share(i) for i in range(STEPS - steps, STEPS)]


def farm_history(farm):
    threads = sum(worker["threads"] for worker in farm.workers.values())
    steps = getattr(farm, "steps", STEPS)
    return {"interval": 10, "end": time.time(), "samples_per_second": history(5.2e5 * threads, steps),
            "busy_threads": [round(value) for value in history(threads * 0.99, steps)],
            "threads": [threads - 64 * (150 <= i < 210 and threads > 64) for i in range(STEPS - steps, STEPS)],
            "queued": [max(0, 30 - i // 12) for i in range(STEPS - steps, STEPS)]}


def event_of(number, farm):
    kind = KINDS[number % len(KINDS)]
    worker = f"node{number % 7:04}"
    job = 1 + number * 13 % max(1, len(farm.jobs))
    event = {"at": time.time() - 25 * number * (1 + number / 20) - 5, "kind": kind}
    if kind.startswith("job") or kind == "started":
        texts = {"job_done": "done, 24 s on 3 workers", "started": "started", "job_cancelled": "cancelled by ben",
                 "job_failed": "failed: three workers failed at the same rows"}
        return {**event, "job": job, "text": f"job {job} {texts[kind]}"}
    texts = {"joined": "joined with 64 threads", "lost": "lost: silent for 5 s", "left": "left: stopped by its user",
             "quarantined": "quarantined: gave two wrong rows", "drained": "drained by ann", "readmitted": "resumed by ann",
             "backoff": "waits 30 s after a failure"}
    return {**event, "worker": worker, "text": f"{worker} {texts[kind]}"}


def users_of(farm):
    found = {}
    for job in farm.jobs.values():
        user = found.setdefault(job["user"], {"user": job["user"], "share": 1, "open_jobs": 0, "done_jobs": 0, "failed_jobs": 0,
                                              "cancelled_jobs": 0, "thread_seconds": 0, "queue_seconds_mean": 42.0})
        kind = job["state"] if job["state"] in ("done", "failed", "cancelled") else "open"
        user[kind + "_jobs"] += 1
        user["thread_seconds"] += 900 + job["id"] % 2000
    return sorted(found.values(), key=lambda user: -user["thread_seconds"])


def count_states(items):
    counts = {}
    for item in items:
        counts[item["state"]] = counts.get(item["state"], 0) + 1
    return counts


def farm_map(farm):
    able = [worker for worker in farm.workers.values() if worker["state"] == "ready"]
    return {"jobs": count_states(farm.jobs.values()), "workers": count_states(farm.workers.values()),
            "threads": sum(worker["threads"] for worker in able), "leases": sum(worker["leases"] for worker in able),
            "samples_per_second": sum(worker["samples_per_second"] for worker in able), "contribution": sum(worker.get("contribution", 0) for worker in able), "thread_seconds_left": 1.6e6 * bool(farm.busy()),
            "seconds_left": 4210.0 if able and farm.busy() else None if farm.busy() else 0,
            "memory": {"used": 11.3e9, "most": 16e9}, "disk": {"used": 96.5e9, "most": 107e9}, "storage": "",
            "users": users_of(farm), "events": [event_of(number, farm) for number in range(60)] if farm.jobs else [],
            "left": [{"name": "w1", "host": "rack9", "at": time.time() - 125, "reason": "silent", "machine": "key workers", "lost": True},
                     {"name": "w2", "host": "rack9", "at": time.time() - 1900, "reason": "stopped", "machine": "key workers", "lost": False}] if farm.jobs else [],
            "since_start": {"samples": 4.4e12, "granted": 91834, "accepted": 90211, "duplicate": 12, "stale": 3, "mismatch": 2,
                            "failed": 31, "malformed": 0}, **farm.farm_fields}


def worker_details(worker):
    return {**worker, "history": {"interval": 10, "end": time.time(), "samples_per_second": history(worker["contribution"] or 2e7)},
            "recent_failures": [{"at": time.time() - 700, "job": 7, "reason": "not enough memory"},
                                {"at": time.time() - 4000, "job": 3, "reason": "two wrong rows"}][:worker["failures"]]}


def worker_log(worker):
    return {"lines": [f"2026-11-26 18:{i // 60:02}:{i % 60:02}.{i * 37 % 1000:03} info  {worker['name']}: traced cell {i} of job {1 + i // 30} in 0.{i % 10}1 s"
                      for i in range(99)] + ["2026-11-26 18:01:40.002 warning  the coordinator has not answered for 3 s"]}


def option_names():
    return list(OPENAPI["components"]["schemas"]["Options"]["properties"])


def openapi(farm):
    """The description, with the options that this farm takes."""
    document = copy.deepcopy(OPENAPI)
    options = document["components"]["schemas"]["Options"]
    options["properties"] = {name: farm.descriptions.get(name, options["properties"].get(name, {})) for name in farm.options}
    return document


def options_of(body):
    """The part `options` of a form."""
    found = re.search(rb'name="options"[^\r]*\r\n(?:[^\r]+\r\n)*\r\n(.*?)\r\n--', body, re.S)
    return json.loads(found[1]) if found else {}


def plan_of(options):
    """The forecast: a target of 1e-8 takes months, others minutes."""
    tiny = options.get("target_error", 1) < 1e-6
    expected = 1.05e7 if tiny else 180.0
    return {"seconds": {"low": expected * 0.8, "expected": expected, "high": expected * 1.3}, "samples_per_pixel": 188,
            "error": {"rmse": options.get("target_error", 0.02)}, "threads": 8, "queue_seconds": 720.0, "thread_seconds": 8 * expected,
            "notes": []}


def server_map(farm):
    return {"version": "0.2.0", "user": getattr(farm, "user", "") or ("ann" if farm.token else ""), "role": getattr(farm, "role", "any"),
            "limits": {"body_bytes": 2**28, "parts": 100, "streams": 128},
            "worker_address": "tcp://farm.example:17400", "keys": bool(farm.token), "webhooks": False, "loopback": False,
            "worker_command": "parray-worker --coordinator tcp://farm.example:17400", **farm.server_fields}
