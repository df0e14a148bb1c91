"""The lists of jobs of a fake farm: search, order, pages, requests for many jobs, thumbnails."""

import json
import struct
import zlib

import fake_rules

ENDED = ("done", "failed", "cancelled")
KEYS = {"id": lambda job: job["id"], "name": lambda job: job["name"].lower(), "user": lambda job: job["user"],
        "state": lambda job: job["state"], "priority": lambda job: job["priority"],
        "submitted": lambda job: job.get("submitted"), "finished": lambda job: job.get("finished"),
        "taken": lambda job: job.get("seconds_taken"), "progress": lambda job: job["progress"]}


def page_of_jobs(farm, options):
    """The answer of GET /jobs."""
    states = set(options.get("state", "").split(",")) - {""}
    user, name = options.get("user"), options.get("name", "").lower()
    found = [job for job in farm.jobs.values() if (not states or job["state"] in states) and (not user or job["user"] == user) and
             name in job["name"].lower() and "frame" not in job]
    key = KEYS[options.get("sort", "id")]
    found.sort(key=lambda job: -job["id"])
    found.sort(key=lambda job: -1 if key(job) is None else key(job), reverse=options.get("order", "desc") == "desc")
    total, limit, offset = len(found), int(options.get("limit", 100)), int(options.get("offset", 0))
    if "before" in options:
        found = [job for job in found if job["id"] < int(options["before"])]
    page = found[offset:offset + limit]
    more = len(found) > offset + limit
    by_id = options.get("sort", "id") == "id" and options.get("order", "desc") == "desc"
    return {"jobs": page, "next": page[-1]["id"] if by_id and more else None, "total": total}


def change_jobs(farm, word, body):
    """The answer of POST /jobs/pause and the others."""
    wanted = json.loads(body)
    assert len(wanted["ids"]) <= 500
    results = []
    for number in wanted["ids"]:
        refusal = farm.refusal_of(number, word)
        if refusal:
            farm.refused.append(("POST", f"/api/v1/jobs/{word}", *refusal))
            results.append({"id": number, "problem": {"status": refusal[0], "detail": refusal[1]}})
            continue
        fake_rules.change_job(farm.jobs, number, word, wanted.get("priority", 50))
        results.append({"id": number} if word == "forget" else {"id": number, "job": farm.jobs[number]})
    return {"results": results}


def thumbnail(job, width):
    """A PNG: a gradient whose colours depend on the job's name."""
    height = max(1, width * job["height"] // job["width"])
    red, green, blue = (zlib.crc32((job["name"] + part).encode()) % 150 + 50 for part in "rgb")
    rows = bytearray()
    for y in range(height):
        rows.append(0)
        for x in range(width):
            shade = 1.2 if (x - width * 0.5) ** 2 + (y - height * 0.6) ** 2 < (0.3 * height) ** 2 else 0.4 + 0.4 * y / height
            rows += bytes(min(255, int(shade * value)) for value in (red, green, blue))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(bytes(rows), 1)) + chunk(b"IEND", b""))
