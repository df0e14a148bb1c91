#!/usr/bin/env python3
"""Monitoring of a farm: metrics for Prometheus, dashboards and alerts that use only existing metrics, and logs in
JSON."""

import json
import re
import shutil
import subprocess
import time
import unittest

from farm import BIN, SOURCE, wait_for
from web import SCENE, Web

MONITORING = SOURCE / "deploy" / "monitoring"
SAMPLE = re.compile(r"([a-z_]+)(?:\{(.*)\})? (\S+)")


def metrics_of(text):
    """Values by name and labels; of those without labels by name."""
    found = {}
    for line in text.splitlines():
        if not line.startswith("#"):
            name, labels, value = SAMPLE.fullmatch(line).groups()
            found[(name, labels) if labels else name] = float(value)
    return found


def promtool(*arguments, text=None):
    return subprocess.run(["promtool", *map(str, arguments)], input=text, capture_output=True, text=True, timeout=60)


class Metrics(unittest.TestCase):
    def setUp(self):
        self.farm = Web()
        self.addCleanup(self.farm.close)
        self.began = time.time()
        self.farm.start_coordinator()

    def text(self):
        answer = self.farm.ask("GET", "/metrics")
        self.assertEqual(answer.status, 200, answer.body)
        self.assertTrue(answer.headers["Content-Type"].startswith("text/plain; version=0.0.4"))
        return answer.body.decode()

    def metrics(self):
        return metrics_of(self.text())

    def test_it_says_when_the_coordinator_began(self):
        self.assertAlmostEqual(self.metrics()["process_start_time_seconds"], self.began, delta=60)
        time.sleep(1.5)  # not when somebody asked
        self.assertEqual(*(self.metrics()["process_start_time_seconds"] for _ in range(2)))

    def test_http_requests_are_counted_by_status(self):
        count = lambda status: self.metrics().get(("parray_http_requests_total", f'status="{status}"'), 0)
        self.assertEqual((count(404), count(431)), (0, 0))
        for _ in range(3):
            self.farm.get("/jobs/77")
        self.farm.ask("GET", "/healthz", headers={"X": "x" * 70000})  # refused before any handler reads it
        self.assertEqual((count(404), count(431)), (3, 1))
        before = count(200)
        self.farm.ask("GET", "/healthz")
        self.farm.get("/openapi.json")
        self.assertEqual(count(200), before + 3)  # and the request of `before`

    def test_jobs_workers_and_samples_are_counted(self):
        before = self.metrics()
        self.assertEqual(before["parray_samples_total"], 0)
        self.assertEqual(before[("parray_workers", 'state="ready"')], 0)
        job = self.farm.submitted(self.farm.post_scene())
        waiting = self.metrics()
        self.assertEqual(sum(waiting[("parray_jobs", f'state="{state}"')] for state in ("queued", "running")), 1)
        self.assertGreater(waiting["parray_work_left_thread_seconds"], 0)
        self.farm.start_worker("one", threads=3)
        wait_for(lambda: self.farm.state(job) == "done", "the picture")
        after = self.metrics()
        self.assertEqual(after[("parray_jobs", 'state="done"')], 1)
        self.assertEqual(after[("parray_jobs", 'state="queued"')], 0)
        self.assertEqual(after["parray_samples_total"], 60 * 40 * 4)
        self.assertEqual(after[("parray_workers", 'state="ready"')], 1)
        self.assertEqual(after["parray_worker_threads"], 3)
        self.assertEqual(after["parray_work_left_thread_seconds"], 0)
        self.assertEqual(after["parray_leases_granted_total"], after[("parray_results_total", 'verdict="accepted"')])
        self.assertEqual(after[("parray_jobs_ended_total", 'state="done"')], 1)
        self.assertEqual(after[("parray_user_jobs", 'user="",state="done"')], 1)
        self.assertGreater(after[("parray_user_thread_seconds_total", 'user=""')], 0)
        self.assertEqual(after["parray_queue_seconds_count"], 1)
        self.assertGreater(after["parray_queue_seconds_sum"], 0)
        self.assertEqual(after["parray_oldest_queued_job_seconds"], 0)
        self.assertGreater(after["process_cpu_seconds_total"], 0)
        self.assertGreater(after["process_resident_memory_bytes"], 1e6)

    def test_the_age_of_a_queued_job_grows_and_a_killed_worker_is_lost(self):
        worker = self.farm.start_worker("one")
        wait_for(lambda: self.metrics()["parray_worker_threads"] == 1, "the worker")
        self.assertEqual(self.metrics()["parray_workers_lost_total"], 0)
        worker.kill()
        wait_for(lambda: self.metrics()["parray_workers_lost_total"] == 1, "its loss")
        self.farm.submitted(self.farm.post_scene())
        first = self.metrics()["parray_oldest_queued_job_seconds"]
        wait_for(lambda: self.metrics()["parray_oldest_queued_job_seconds"] > first, "its age")

    def test_dashboards_and_alerts_name_only_metrics_that_there_are(self):
        self.farm.submitted(self.farm.post_scene())  # for those of users
        there = {key if isinstance(key, str) else key[0] for key in self.metrics()} | {"up"}
        dashboard = json.loads((MONITORING / "grafana-dashboard.json").read_text())
        expressions = [target["expr"] for panel in dashboard["panels"] for target in panel["targets"]]
        expressions += re.findall(r"expr: (?:>-\n)?((?:.|\n)*?)\n +(?:for|labels):", (MONITORING / "alerts.yml").read_text())
        self.assertGreater(len(expressions), 20)
        for expression in expressions:
            named = set(re.findall(r"\b(?:parray|process)_[a-z_]+|\bup\b", expression))
            self.assertTrue(named, expression)
            self.assertLessEqual(named, there, expression)

    @unittest.skipUnless(shutil.which("promtool"), "promtool is missing (package prometheus)")
    def test_promtool_finds_nothing_to_say(self):
        checked = promtool("check", "metrics", text=self.text())
        self.assertEqual((checked.returncode, checked.stdout, checked.stderr), (0, "", ""))
        for what, file in (("rules", "alerts.yml"), ("config", "prometheus.yml")):
            checked = promtool("check", what, MONITORING / file)
            self.assertEqual(checked.returncode, 0, checked.stderr)


class JsonLogs(unittest.TestCase):
    def test_every_line_is_an_object_whatever_names_hold(self):
        with Web("--log-format", "json") as farm:
            worker = farm._start("parray-worker", "--connect", farm.address, "--threads", "1", "--name", 'a "b" \\ c',
                                 "--log-format", "json")
            job = farm.submitted(farm.post_scene())
            wait_for(lambda: farm.state(job) == "done", "the picture")
            for log, logger in ((farm.coordinator.log, "coordinator"), (worker.log, "worker")):
                lines = [json.loads(line) for line in log.read_text().splitlines()]
                self.assertGreater(len(lines), 1)
                for line in lines:
                    self.assertEqual(list(line), ["time", "level", "logger", "message"])
                    self.assertRegex(line["time"], r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{6}[+-]\d\d:\d\d$")
                    self.assertEqual(line["logger"], logger)
            self.assertTrue(any('a "b" \\ c' in json.loads(line)["message"]
                                for line in farm.coordinator.log.read_text().splitlines()))

    def test_another_format_is_refused(self):
        refused = subprocess.run([BIN / "parray-worker", "--log-format", "xml"], capture_output=True, text=True,
                                 timeout=60)
        self.assertEqual(refused.returncode, 2)
        self.assertIn("--log-format", refused.stderr)


if __name__ == "__main__":
    unittest.main()
