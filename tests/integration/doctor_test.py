#!/usr/bin/env python3
"""parray doctor on a fit machine and on broken ones."""

import json
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import unittest
import unittest.mock

import mpi
from farm import BIN, run, wait_for

STATUSES = {"ok", "warning", "failed", "skipped"}
NEED_DISK = {"pictures", "state", "mpi"}


class Doctor(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix="parray-doctor-test-")
        self.addCleanup(temporary.cleanup)
        self.directory = pathlib.Path(temporary.name)
        self.scratch = self.directory / "tmp"
        self.scratch.mkdir()

    def doctor(self, *options, **environment):
        """The exit status and the checks by name."""
        result = run("doctor", "--json", *options, env={"TMPDIR": str(self.scratch), **environment})
        self.assertEqual(result.stderr, "")
        report = json.loads(result.stdout)
        self.assertEqual(set(report), {"version", "status", "failed", "warnings", "skipped",
                                       "seconds", "checks"})
        self.assertEqual(report["failed"] > 0, result.returncode == 1)
        self.assertEqual(report["failed"] > 0, report["status"] == "failed")
        checks = {check["name"]: check for check in report["checks"]}
        self.assertEqual(len(checks), len(report["checks"]))
        for check in report["checks"]:
            self.assertEqual(set(check), {"name", "status", "detail", "remedy", "facts"})
            self.assertIn(check["status"], STATUSES)
            self.assertNotIn("\n", check["detail"] + check["remedy"])
            self.assertTrue(check["detail"], check["name"])
            if check["status"] in ("failed", "warning"):
                self.assertTrue(check["remedy"], check["name"])
        for key, status in (("failed", "failed"), ("warnings", "warning"), ("skipped", "skipped")):
            self.assertEqual(report[key], len(self.named(checks, status)))
        return result.returncode, checks

    @staticmethod
    def named(checks, *statuses):
        return {name for name, check in checks.items() if check["status"] in statuses}

    def program(self, name, lines):
        directory = self.directory / "bin"
        directory.mkdir(exist_ok=True)
        (directory / name).write_text("#!/bin/sh\n" + lines + "\n")
        (directory / name).chmod(0o755)
        return str(directory)

    def test_a_fit_machine_passes_without_variables_for_mpi(self):
        set_for_mpi = [name for name in os.environ if name.startswith("OMPI_")]
        with unittest.mock.patch.dict(os.environ):
            for name in set_for_mpi:
                del os.environ[name]
            status, checks = self.doctor()
        self.assertEqual((status, self.named(checks, "failed")), (0, set()))
        self.assertEqual(list(self.scratch.iterdir()), [])
        sets = checks["processor"]["facts"]["instruction_sets"]
        self.assertEqual(sets[0], "scalar")
        self.assertIn(checks["processor"]["facts"]["automatic"], sets)
        for isa in sets:
            self.assertEqual(checks[f"{isa} picture"]["status"], "ok")
        for name in ("threads", "repetition", "libraries", "pictures",
                     "state", "messages", "keys"):
            self.assertEqual(checks[name]["status"], "ok", checks[name])
        self.assertEqual(set(checks["libraries"]["facts"]),
                         {"OpenEXR", "OpenImageIO", "ZeroMQ", "SQLite", "nlohmann-json", "spdlog", "OpenMP"})
        if not mpi.why_not():
            self.assertEqual(checks["mpi"]["status"], "ok", checks["mpi"])
            self.assertIn("over a window", checks["mpi"]["detail"])

    def test_extremes_are_checked_on_request(self):
        _, usual = self.doctor(PATH=str(self.scratch))
        status, checks = self.doctor("--extremes", PATH=str(self.scratch))
        self.assertEqual((status, self.named(checks, "failed")), (0, set()))
        sets = checks["processor"]["facts"]["instruction_sets"]
        extremes = {f"{isa} {what}" for isa in sets for what in ("furnaces", "self-hits", "scaling")}
        self.assertEqual(set(checks) - set(usual), extremes | {"rounding", "sphere hits"})

    def test_a_person_gets_a_line_for_every_check_and_a_verdict_without_mpirun_too(self):
        result = run("doctor", env={"TMPDIR": str(self.scratch), "PATH": str(self.scratch)})
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        table, verdict = result.stdout.split("\n\n")
        lines = table.split("\n")
        findings = [line for line in lines if not line.startswith(" ")]
        for line in findings:
            self.assertIn(line.split()[0], STATUSES)
        self.assertEqual(lines[-2:], [
            "skipped  mpi                  no mpirun in PATH",
            "                              -> to use parray-mpi, install openmpi-bin (Debian)"])
        self.assertRegex(verdict, r"\AThis machine is fit for ParRay: "
                         rf"{len(findings)} checks, 0 failed, [^\n]* skipped, [^\n]* s\n\Z")

    def test_a_temporary_directory_that_is_not_there_is_one_failure(self):
        status, checks = self.doctor(TMPDIR="/nonexistent/place")
        self.assertEqual(status, 1)
        self.assertEqual(self.named(checks, "failed"), {"temporary directory"})
        self.assertIn("/nonexistent/place", checks["temporary directory"]["detail"])
        self.assertIn("TMPDIR", checks["temporary directory"]["remedy"])
        self.assertLessEqual(NEED_DISK, self.named(checks, "skipped"))

    def test_an_mpirun_that_fails_is_a_failure_in_its_own_words(self):
        path = self.program("mpirun", "echo 'no slots left' >&2\nexit 7")
        status, checks = self.doctor(PATH=path + ":/usr/bin:/bin")
        self.assertEqual((status, self.named(checks, "failed")), (1, {"mpi"}))
        self.assertIn("status 7: no slots left", checks["mpi"]["detail"])

    @unittest.skipIf(mpi.why_not(), mpi.why_not())
    def test_disabled_windows_of_open_mpi_are_a_warning(self):
        status, checks = self.doctor(OMPI_MCA_osc="^rdma,sm,pt2pt,ucx,monitoring,portals4")
        self.assertEqual((status, checks["mpi"]["status"]), (0, "warning"), checks["mpi"])
        self.assertIn("OMPI_MCA_osc", checks["mpi"]["remedy"])

    @unittest.skipUnless(shutil.which("gcc"), "gcc is missing")
    def test_a_library_in_fast_mode_is_a_warning_and_harms_no_bit(self):
        source = self.directory / "fast.c"
        source.write_text("int fast_mode;\n")
        library = self.directory / "fast.so"
        subprocess.run(["gcc", "-shared", "-fPIC", "-ffast-math", "-o", library, source], check=True)
        status, checks = self.doctor(LD_PRELOAD=str(library), PATH=str(self.scratch))
        if checks["float mode"]["status"] == "ok":
            self.skipTest("this compiler's libraries leave the mode alone")
        self.assertEqual(status, 0)
        self.assertEqual(checks["float mode"]["status"], "warning")
        self.assertIn("denormal", checks["float mode"]["detail"])
        self.assertEqual(self.named(checks, "failed"), set())

    def test_an_interrupt_leaves_neither_files_nor_processes(self):
        mark = self.directory / "started"
        path = self.program("mpirun", f"echo $$ > {mark}.new; mv {mark}.new {mark}\n"
                            "exec sleep 1000")
        process = subprocess.Popen(
            [BIN / "parray", "doctor"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            env={**os.environ, "TMPDIR": str(self.scratch), "PATH": path + ":/usr/bin:/bin"})
        try:
            wait_for(mark.exists, "the trial of mpirun")
            process.send_signal(signal.SIGINT)
            _, stderr = process.communicate(timeout=30)
        finally:
            process.kill()
        self.assertEqual((process.returncode, stderr), (130, "parray: interrupted\n"))
        self.assertEqual(list(self.scratch.iterdir()), [])
        self.assertFalse(pathlib.Path(f"/proc/{mark.read_text().strip()}").exists())

    def test_arguments_that_doctor_does_not_have_are_refused(self):
        for arguments in (["scene.json"], ["--threads", "2"]):
            result = run("doctor", *arguments)
            self.assertEqual((result.returncode, result.stdout), (2, ""))
            self.assertRegex(result.stderr, r"\Aparray: [^\n]*\n\Z")


if __name__ == "__main__":
    unittest.main()
