"""A farm of any size that renders nothing: what the page does with 10,000 jobs and 2,000 workers, and
with a server that asks for tokens, has no room for streams, or goes away. The interface is that of
coordinator/http/openapi.json; the page is read from its files."""

import array
import copy
import http.server
import json
import math
import pathlib
import sys
import threading
import time
import traceback
import urllib.parse

import fake_console
import fake_rules
from fake_job_lists import ENDED, change_jobs, page_of_jobs, thumbnail

PAGE = pathlib.Path(__file__).resolve().parents[2] / "coordinator/http/page"
TYPES = {".html": "text/html; charset=utf-8", ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml"}
POLICY = ("default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; font-src 'self'; "
          "connect-src 'self'; worker-src 'self'; manifest-src 'self'; base-uri 'none'; form-action 'none'; "
          "frame-ancestors 'none'")
NAMES = ["one-weekend-484", "capsid", "copper-dislocation", "granular-packing", "plummer-1M", "glass", "helix"]
USERS = ["ann", "ben", "chi", "dora", "eve"]
STATES = ["done"] * 12 + ["failed", "cancelled", "paused", "queued"]
UNFINISHED = {"queued", "running", "paused", "finishing"}


def job_of(number, newest):
    state = "running" if number > newest - 20 and number % 2 else STATES[number * 7919 % len(STATES)]
    progress = {"done": 1.0, "queued": 0.0}.get(state, (number * 37 % 97) / 100)
    submitted = time.time() - 47 * (newest - number + 1) - number % 40
    age = time.time() - submitted
    taken = None if state == "queued" else age * (0.05 + number * 37 % 90 / 100)
    job = {"id": number, "name": NAMES[number % len(NAMES)], "user": USERS[number % 5],
           "state": state, "priority": 50, "progress": progress,
           "samples_per_second": 3.1e7 if state == "running" else 0.0,
           "seconds_left": 40.0 + number % 500 if state == "running" else -1, "reason": "", "waits_for": "",
           "flag": "", "width": 1200, "height": 800, "samples_per_pixel": None if number % 6 == 3 else 500, "sampler": "sobol", "whole": True,
           "submitted": submitted, "started": None if taken is None else submitted + 5, "seconds_taken": taken,
           "finished": submitted + 5 + taken if state in ENDED else None, "samples_taken": 500 * progress, "has_picture": progress > 0,
           "waits_for_job": None, "queue_place": None, "starts_in": None, "denoise": False}
    if state == "failed":
        job["reason"] = "three workers failed at the same rows"
    if state == "queued":
        place = 1 + number % 9
        job.update(waits_for_job=newest - 1 if place > 1 else None, waits_for=f"job {newest - 1} of priority 50" if place > 1 else "a worker", queue_place=place,
                   starts_in=35.0 * place if place > 2 else None)
    if number % 3 == 0:
        job["target_error"] = 0.01
    if progress > 0.1:
        rmse = 0.009 / math.sqrt(progress)
        job["error"] = {"rmse": rmse, "low": rmse * 0.98, "high": rmse * 1.02, "half_width_p50": rmse, "half_width_p99": 3 * rmse}
    return job


def worker_of(number):
    state = "quarantined" if number % 173 == 9 else "drained" if number % 61 == 5 else "ready"
    busy = state == "ready" and number % 8 != 6
    speed = 4e7 * (0.5 + number * 7 % 10 / 10)
    return {"name": f"node{number:04}", "host": f"rack{number // 40}", "threads": 64, "leases": 2 * busy,
            "accepted": number * 31 % 5000, "samples_per_second": speed, "contribution": 0.8 * speed * busy,
            "state": state, "reason": "gave two wrong rows" if state == "quarantined" else "", "seconds_silent": 0,
            "version": "0.2.0", "processors": 64, "memory_bytes": 270e9, "load": 63.2 if busy else 0.3,
            "address": f"10.0.{number // 250}.{number % 250}:41022", "since": time.time() - 3600 * (1 + number % 50), "failures": number % 3,
            "tracing": {"job": 1 + number % 5, "seconds": 12.0 + number} if busy else None}


class FakeFarm:
    """with FakeFarm(jobs=10000, workers=2000) as farm: ...farm.url. `token`: what it asks for;
    `streams`: whether it has event streams; `changes`: jobs that change each tenth of a second."""

    def __init__(self, jobs=100, workers=10, token=None, streams=True, changes=20, user="", role="any"):
        self.jobs = {number: job_of(number, jobs) for number in range(1, jobs + 1)}
        self.workers = {worker["name"]: worker for worker in map(worker_of, range(workers))}
        self.token, self.streams, self.changes = token, streams, changes
        self.user, self.role = user, role  # what /server says of who asks
        self.locked = set()  # numbers of jobs that this user may not change, whatever the role
        self.drained_hosts = set()
        self.refused = []  # (method, path, status, detail) of every refusal
        self.width, self.height = 240, 160
        self.samples = 1000
        self.asked = []  # (method, path with query)
        self.bodies = {}  # path: the last body
        self.refusal = None  # (status, detail) of the next change
        self.sent = []  # (path, body) of every POST
        self.farm_fields, self.server_fields, self.plan_fields = {}, {}, {}  # replace fields of /farm, /server and /plan
        self.options = fake_console.option_names()  # that POST /jobs takes
        self.descriptions = {}  # of options, instead of those of openapi.json
        self.log_refusal = None  # (status, detail) of each request for a worker's log
        self.port = 0

    def __enter__(self):
        self.start()
        return self

    def __exit__(self, *_):
        self.stop()

    @property
    def url(self):
        return f"http://127.0.0.1:{self.port}/"

    def start(self):
        self.stopping = threading.Event()
        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", self.port), handler_of(self))
        self.server.daemon_threads = True
        self.server.handle_error = report_error
        self.port = self.server.server_port
        threading.Thread(target=self.server.serve_forever, daemon=True).start()

    def stop(self):
        self.stopping.set()
        self.server.shutdown()
        self.server.server_close()

    def busy(self):
        """The jobs of which events tell, as those of the coordinator do: not the frames of a series."""
        return [job for job in list(self.jobs.values()) if job["state"] in UNFINISHED and "frame" not in job]

    def listed(self):
        """The states of the jobs of which events tell."""
        return {number: job["state"] for number, job in list(self.jobs.items()) if "frame" not in job}

    def refusal_of(self, number, word):
        """Why this user may not change a job now: (status, detail) or None."""
        if number in self.locked:
            return 403, f"job {number} belongs to '{self.jobs[number]['user']}'"
        return fake_rules.job_refusal(self.jobs, number, word, (self.role, self.user))

    def answer_job(self, handler, method, parts, options):
        """For subclasses: answers a request below /jobs and returns true, or returns false."""
        return False

    def pixels(self):
        values = array.array("f")
        for y in range(self.height):
            for x in range(self.width):
                values.extend((x / self.width, y / self.height, 2.0 if (x // 20 + y // 20) % 2 else 0.25))
        return values.tobytes()


def report_error(*_):
    if not isinstance(sys.exc_info()[1], ConnectionError):  # a page that was closed
        traceback.print_exc()


def handler_of(farm):
    class Handler(http.server.BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"

        def log_message(self, *_):
            pass

        def reply(self, body, kind="application/json", status=200, **fields):
            if not isinstance(body, bytes):
                body = json.dumps(body).encode() if kind.endswith("json") else body.encode()
            self.send_response(status)
            self.send_header("Content-Type", kind)
            self.send_header("Content-Length", str(len(body)))
            for name, value in fields.items():
                self.send_header(name.replace("_", "-"), str(value))
            self.end_headers()
            try:
                self.wfile.write(body)
            except OSError:  # the page no longer wants it
                self.close_connection = True

        def problem(self, status, detail):
            farm.refused.append((self.command, self.path, status, detail))
            self.reply({"type": "about:blank", "title": "", "status": status, "detail": detail}, "application/problem+json", status)

        def do_GET(self):
            self.answer("GET")

        def do_POST(self):
            self.answer("POST")

        def do_PUT(self):
            self.answer("PUT")

        def do_DELETE(self):
            self.answer("DELETE")

        def answer(self, method):
            body = self.rfile.read(int(self.headers.get("Content-Length", 0)))
            path, _, query = self.path.partition("?")
            if not path.startswith("/api/"):
                return self.asset(path)
            farm.asked.append((method, self.path))
            if body:
                farm.bodies[path] = body
                farm.sent.append((path, body))
            if path == "/api/v1/openapi.json":  # which needs no token
                return self.reply(fake_console.openapi(farm))
            if farm.token and self.headers.get("Authorization") != "Bearer " + farm.token:
                return self.problem(401, "a token is missing")
            if method != "GET" and farm.refusal and not path.endswith("/plan"):
                refusal, farm.refusal = farm.refusal, None
                return self.problem(*refusal)
            parts = [urllib.parse.unquote(part) for part in path.split("/")[3:]]
            options = {name: values[0] for name, values in urllib.parse.parse_qs(query).items()}
            if parts[0] == "jobs":
                return self.of_jobs(method, parts[1:], options)
            if parts[0] == "workers" and len(parts) > 1:
                return self.of_worker(method, parts[1:], options)
            if parts[0] == "workers":
                begin = int(options.get("offset", 0))
                return self.reply({"workers": list(farm.workers.values())[begin:begin + 1000], "total": len(farm.workers)})
            if parts[0] == "farm":
                return self.reply(fake_console.farm_history(farm) if parts[1:] else fake_console.farm_map(farm))
            if parts[0] == "plan":
                return self.reply({**fake_console.plan_of(fake_console.options_of(body)), **farm.plan_fields})
            if parts[0] == "server":
                return self.reply(fake_console.server_map(farm))
            if parts[0] == "events" and farm.streams:
                return self.events()
            return self.problem(503, "no more event streams")

        def of_worker(self, method, parts, options):
            if method != "GET":
                refusal = fake_rules.worker_refusal((farm.role, farm.user))
                if refusal:
                    return self.problem(*refusal)
                found = fake_rules.steer_workers(farm.workers, farm.drained_hosts, parts[0], parts[1], options.get("host") == "true")
                return self.reply({"workers": found, "total": len(found)})
            worker = farm.workers.get(parts[0])
            if not worker or fake_rules.is_absent(worker):
                return self.problem(404, f"no worker {parts[0]}")
            if len(parts) == 1:
                return self.reply(fake_console.worker_details(worker))
            return self.problem(*farm.log_refusal) if farm.log_refusal else self.reply(fake_console.worker_log(worker))

        def of_jobs(self, method, parts, options):
            if farm.answer_job(self, method, parts, options):
                return None
            if not parts and method == "POST":
                unknown = set(fake_console.options_of(farm.bodies[self.path])) - set(farm.options)
                if unknown:
                    return self.problem(422, f"options: /{min(unknown)}: unknown option")
                number = max(farm.jobs) + 1
                farm.jobs[number] = {**job_of(number, number), "state": "running"}
                return self.reply({"id": number}, status=201)
            if not parts:
                return self.reply(page_of_jobs(farm, options))
            if method == "POST" and len(parts) == 1:
                return self.reply(change_jobs(farm, parts[0], farm.bodies[self.path]))
            job = farm.jobs.get(int(parts[0]))
            if not job:
                return self.problem(404, f"no job {parts[0]}: parray jobs lists all jobs")
            if method != "GET":
                return self.steer(job, "forget" if method == "DELETE" else parts[1])
            if len(parts) == 1:
                return self.reply({**job, "events": [{"at": time.time() - 60, "what": "submitted"}]})
            refusal = fake_rules.file_refusal(farm.jobs, job["id"], parts[1])
            if refusal:
                return self.problem(*refusal)
            size = {"Parray_Width": farm.width, "Parray_Height": farm.height}
            if parts[1] == "pixels.f32":
                return self.reply(farm.pixels(), "application/octet-stream", ETag=f'"{farm.samples}"',
                                  Parray_Partial=int(job["state"] != "done"), Parray_Samples=farm.samples, **size)
            if parts[1] in ("image.png", "error.png", "image.exr"):
                return self.reply(thumbnail(job, int(options.get("width", 64))), "image/x-exr" if parts[1] == "image.exr" else "image/png")
            if parts[1] == "error.f32":
                values = array.array("f", (0.001 * (1 + i % farm.width) for i in range(farm.width * farm.height)))
                return self.reply(values.tobytes(), "application/octet-stream", **size)
            if parts[1] == "report":
                return self.reply({"image_sha256": "ab" * 32, "seconds": {"render": 12.5}, "spheres": 484})
            return self.problem(404, f"nothing is at {self.path}")

        def steer(self, job, word):
            refusal = farm.refusal_of(job["id"], word)
            if refusal:
                return self.problem(*refusal)
            fake_rules.change_job(farm.jobs, job["id"], word, json.loads(farm.bodies[self.path])["priority"] if word == "priority" else 50)
            if word != "forget":
                return self.reply(farm.jobs[job["id"]])
            self.send_response(204)
            return self.end_headers()

        def events(self):
            self.send_response(200)
            self.send_header("Content-Type", "text/event-stream")
            self.send_header("Connection", "close")
            self.end_headers()

            def send(kind, items):
                self.wfile.write("".join(f"event: {kind}\ndata: {json.dumps(item)}\n\n" for item in items).encode())

            try:
                send("job", farm.busy())
                send("worker", farm.workers.values())
                known = farm.listed()
                workers = copy.deepcopy(farm.workers)
                while not farm.stopping.wait(0.1):
                    before, known = known, farm.listed()
                    send("job", [farm.jobs[number] for number, state in known.items() if before.get(number) != state and number in farm.jobs])
                    send("forgotten", [{"id": number} for number in before.keys() - known.keys()])
                    old, workers = workers, copy.deepcopy(farm.workers)
                    send("worker", [worker for name, worker in workers.items() if old.get(name) != worker])
                    send("gone", [{"name": name} for name in old.keys() - workers.keys()])
                    changed = farm.busy()[-farm.changes:] if farm.changes else []
                    for job in changed:
                        if job["state"] == "running":
                            job["progress"] = min(0.99, job["progress"] + 0.001)
                    send("job", changed)
                    self.wfile.write(b":\n\n")
            except OSError:
                pass
            self.close_connection = True

        def asset(self, path):
            file = PAGE / {"": "index.html", "api": "api.html"}.get(path.lstrip("/"), path.lstrip("/"))
            if file.parent != PAGE or not file.is_file():
                return self.problem(404, "nothing is there")
            fields = {"Content_Security_Policy": POLICY} if file.suffix == ".html" else {}
            return self.reply(file.read_bytes(), TYPES[file.suffix], **fields)

    return Handler
