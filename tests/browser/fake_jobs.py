"""A farm with one job in each state and a series, with the fields and requests that show a job: times, queue, passes of
the error, maps, thumbnails, frames.zip. Like its base it renders nothing: the picture of a frame is a disc at a place
that depends on the frame."""

import array
import io
import json
import math
import struct
import time
import zipfile
import zlib

import fake_rules
from fake_farm import FakeFarm, job_of

QUEUED, RUNNING, PAUSED, DONE, FAILED, CANCELLED, LOOK, UNLIMITED, BOTH, SERIES = 1, 2, 3, 4, 5, 6, 7, 8, 9, 100
ENDED = ("done", "failed", "cancelled")


def png(width, height, frame=0, frames=60, share=1.0):
    """A disc on a gradient; without `share` of its rows."""
    angle = 2 * math.pi * frame / frames
    x0, y0, r2 = width * (0.5 + 0.3 * math.cos(angle)), height * (0.5 + 0.3 * math.sin(angle)), (0.15 * width) ** 2
    rows = bytearray()
    for y in range(height):
        rows.append(0)
        shade = 60 + 120 * y // height
        for x in range(width):
            inside = (x - x0) ** 2 + (y - y0) ** 2 < r2
            rows += b"\0\0\0" if y > share * height else bytes((225, 120, 60)) if inside else bytes((shade, shade + 20, shade + 50))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(bytes(rows), 1)) + chunk(b"IEND", b""))


def rich(number, state, progress, **more):
    now = time.time()
    job = {**job_of(number, 0), "name": "capsid.json", "user": "ann", "state": state, "progress": progress,
           "samples_per_second": 3.1e7 if state == "running" else 0.0, "seconds_left": 73.0 if state == "running" else -1.0,
           "reason": "", "waits_for": "", "waits_for_job": None, "queue_place": None, "starts_in": None,
           "submitted": now - 420, "started": now - 300, "finished": now - 251 if state in ENDED else None,
           "seconds_taken": 49.0, "samples_taken": 500 * progress, "samples_per_pixel": 500, "has_picture": progress > 0,
           "denoise": False}
    job.pop("target_error", None)
    job.pop("error", None)
    if progress > 0:
        job["error"] = error_of(0.009 / math.sqrt(progress))
    if state == "done":
        job["ended_by"] = "samples"
    return {**job, **more}


def error_of(rmse):
    return {"rmse": rmse, "low": rmse * 0.98, "high": rmse * 1.02, "half_width_p50": rmse, "half_width_p99": 3 * rmse}


def passes_of(job):
    if not {"error", "seconds_taken", "samples_taken"} <= job.keys():
        return []
    return [{"seconds": job["seconds_taken"] * share, "samples": job["samples_taken"] * share, "rmse": job["error"]["rmse"] / math.sqrt(share)}
            for share in (0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.75, 1)]


REPORT = {
    "accelerator": "octree", "accelerator_bytes": 81920, "adaptive": True, "checked_share": 0.0, "duplicates_removed": 0,
    "error": {"half_width_p50": 0.009, "half_width_p99": 0.027, "high": 0.0092, "low": 0.0088, "method": "replicates", "rmse": 0.009,
              "truncation": 2e-9},
    "features": ["diffuse", "metal"], "fill_block": 1, "filled_pixels": 0, "flag": "", "height": 160, "image_sha256": "ab" * 32,
    "isa": "avx512", "least_samples": 490, "max_depth": 32, "most_samples": 510, "nonfinite": [], "nonfinite_samples": 0,
    "passes": [480000, 60000], "precision": "f32", "rays": 1623470, "rays_per_second": 1.95e7, "sampler": "sobol", "samples": 540000,
    "samples_per_pixel": 500, "samples_per_second": 6.5e6, "scene_sha256": "cd" * 32, "schedule": "weighted",
    "seconds": {"build": 0.5, "deciding": 0.0, "load": 0.1, "render": 47.9}, "seed": 1, "spheres": 147730, "stopped_by": "samples",
    "target_error": 0.0, "target_half_width": 0.0, "threads": 16, "time_limit": 0.0, "trace_version": 5, "version": "0.2.0", "width": 240,
    "workers": 2}


class JobFarm(FakeFarm):
    """with JobFarm(frames=61, user="ann", role="client") as farm: ... The numbers of its jobs are above."""

    def __init__(self, frames=7, **options):
        super().__init__(jobs=0, workers=2, changes=0, **options)
        for job in (
                rich(QUEUED, "queued", 0.0, waits_for="job 2 of priority 50", waits_for_job=RUNNING, queue_place=3, starts_in=240.0,
                     started=None, seconds_taken=None),
                rich(RUNNING, "running", 0.4, denoise=True), rich(PAUSED, "paused", 0.3, reason="paused by 'ann'"), rich(DONE, "done", 1.0),
                rich(FAILED, "failed", 0.2, reason="3 workers did not have enough memory (oak, birch, elm)"),
                rich(CANCELLED, "cancelled", 0.028, reason="cancelled by 'ann'"),
                rich(LOOK, "done", 1.0, name="capsid.json (quick look)", preview_of=RUNNING),
                rich(UNLIMITED, "running", 0.5, samples_per_pixel=None, samples_taken=47.2, target_error=0.01,
                     warning="needs about 121 days of all 16 present threads: cancel it, or submit it with a larger target or a time limit"),
                rich(BOTH, "done", 1.0, samples_per_pixel=None, samples_taken=153.0, target_error=0.01, target_half_width=0.01,
                     ended_by="target_error", error={**error_of(0.0096), "half_width_p99": 0.0369})):
            self.jobs[job["id"]] = {**job, "width": 240, "height": 160}
        self.began = time.time() - 420
        self.samples = 40 * self.width * self.height
        self.add_series(frames)

    def add_series(self, frames):
        """Frames 0 to `frames` - 1: a third is done, one of them failed and one took much longer, two run."""
        done = max(3, frames // 3)
        common = {"series": SERIES, "width": 240, "height": 160}
        for frame in range(frames):
            state = "failed" if frame == 2 else "done" if frame < done else "running" if frame < done + 2 else "queued"
            job = rich(SERIES + 1 + frame, state, {"done": 1.0, "running": 0.4, "failed": 0.1}.get(state, 0.0), frame=frame, name="orbit.json", **common)
            job["seconds_taken"] = None if state == "queued" else 200.0 if frame == 1 else 40 + 10 * math.sin(frame / 3)
            job["reason"] = "the scene of frame 2 is damaged" if state == "failed" else ""
            self.jobs[job["id"]] = job
        states = [job["state"] for job in self.frames()]
        series = rich(SERIES, "running", 0.35, name="orbit.json", frames=frames, frames_done=states.count("done"), seconds_taken=900.0, **common)
        series.pop("error")
        self.jobs[SERIES] = {**series, "series": "orbit-token", "has_picture": False}
        fake_rules.sum_up(self.jobs, self.jobs[SERIES])

    def frames(self):
        return [job for job in self.jobs.values() if job.get("series") == SERIES]

    def entry(self, job):
        return {"frame": job["frame"], "job": job["id"], "state": job["state"], "reason": job["reason"], "seconds": job["seconds_taken"],
                "rmse": job.get("error", {}).get("rmse"), "progress": job["progress"], "has_picture": job["has_picture"]}

    def answer_job(self, handler, method, parts, options):
        """Answers what FakeFarm does not know. Returns false for the rest."""
        job = self.jobs.get(int(parts[0])) if parts and parts[0].isdigit() else None
        if method != "GET" or job is None:
            return False
        refusal = len(parts) > 1 and fake_rules.file_refusal(self.jobs, job["id"], parts[1])
        if refusal:
            handler.problem(*refusal)
        elif len(parts) == 1:
            handler.reply(self.details(job, int(options.get("from_frame", 0))))
        elif parts[1] == "image.png":
            self.picture(handler, job, min(job["width"], int(options.get("width", job["width"]))))
        elif parts[1] == "frames.zip":
            handler.reply(self.zip(), "application/zip")
        elif parts[1] == "report" and job["state"] == "done":
            handler.reply(REPORT)
        elif parts[1] in ("cost.f32", "workers.u32"):
            size = self.width * self.height
            values = array.array("f", ((1 + i % 97) * 1e-6 for i in range(size))) if parts[1] == "cost.f32" else array.array("I", (i // 20 % 2 for i in range(size)))
            handler.reply(values.tobytes(), "application/octet-stream", Parray_Width=self.width, Parray_Height=self.height)
        elif parts[1] == "workers.json":
            handler.reply({"workers": ["oak", "birch"]})
        else:
            return False
        return True

    def details(self, job, first):
        taken = [f"submitted by '{job['user']}'"] + ["started"] * bool(job.get("started")) + \
            [{"paused": "paused by 'ann'", "cancelled": "cancelled: cancelled by 'ann'", "done": "done",
              "failed": "failed: " + job["reason"]}.get(job["state"])]
        more = {"events": [{"at": self.began + 60 * index, "what": what} for index, what in enumerate(filter(None, taken))],
                "passes": passes_of(job)}
        if job["id"] == SERIES:
            more = {"events": [], "frame_list": [self.entry(frame) for frame in self.frames() if frame["frame"] >= first][:1000]}
        return {**job, **more}

    def picture(self, handler, job, width):
        if not job.get("has_picture"):
            return handler.problem(409, f"job {job['id']} has no picture yet")
        share = 1.0 if job["state"] == "done" else 0.5
        return handler.reply(png(width, width * job["height"] // job["width"], job.get("frame", 0), share=share), "image/png",
                             ETag=f'"{job["id"]}-{width}"', Parray_Partial=int(share < 1), Parray_Samples=self.samples)

    def zip(self):
        out = io.BytesIO()
        with zipfile.ZipFile(out, "w") as archive:
            for job in self.frames():
                if job["state"] == "done":
                    archive.writestr(f"frame-{job['frame']:04}.png", png(24, 16, job["frame"]))
        return out.getvalue()
