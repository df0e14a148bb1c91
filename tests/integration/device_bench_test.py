#!/usr/bin/env python3
"""The bench of device code, with the stand-in for CUDA's driver library. Its times mean nothing here."""

import json
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

BIN = pathlib.Path(os.environ["PARRAY_BIN_DIR"])
SOURCE = pathlib.Path(os.environ["PARRAY_SOURCE_DIR"])
DEVICE = BIN.parent / "device"
STAND_IN = DEVICE / "libcuda_stand_in.so"
SCENES = SOURCE / "scenes"
SMALL = ["--picture", "12x8x1", "--operations", "40000", "--speed-picture", "24x16", "--caps", "none,64",
         "--blocks", "64,128", "--launch-ms", "0.5", "--rounds", "2", "--cpu-seconds", "0.01"]


def code_in(folder):
    """A folder with device code: that of the build, or the names of the kernels if the build has no clang."""
    for name in ("kernels.ptx", "probe.ptx"):
        built = DEVICE / name
        text = built.read_text() if built.exists() else "//\n" + "".join(
            f".entry {kernel}(\n" for kernel in all_kernels())
        pathlib.Path(folder, name).write_text(text)
    return folder


def all_kernels():
    headers = (SOURCE / "common/trace/device/device_entry.h", SOURCE / "tests/bench/device_probe.h")
    return [name for header in headers for name in re.findall(r"\((trace_\w+|probe_f\w+),", header.read_text())]


class DeviceBench(unittest.TestCase):
    def setUp(self):
        directory = tempfile.TemporaryDirectory()
        self.addCleanup(directory.cleanup)
        self.folder = pathlib.Path(directory.name)
        self.code = code_in(self.folder)

    def bench(self, *options, fault="", driver=STAND_IN):
        return subprocess.run([BIN / "bench_device", "--code", self.code, "--scenes", SCENES, "--generated", SCENES,
                               "--driver", driver, "--spheres", "8,20", *SMALL, *options], capture_output=True, text=True, timeout=300,
                              env={**os.environ, "PARRAY_CUDA_STAND_IN": fault})

    def assert_one_line(self, result, status, *parts):
        self.assertEqual(result.returncode, status, result.stdout + result.stderr)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        for part in parts:
            self.assertIn(part, result.stderr)

    def assert_wrong(self, result, pattern):
        self.assertEqual(result.returncode, 1, result.stdout + result.stderr)
        self.assertRegex(result.stdout, "(?m)^WRONG: " + pattern)

    def test_a_right_device_passes_and_is_measured(self):
        out = self.folder / "out"
        result = self.bench("-o", out, "--only", "fingerprint", "--only", "pictures", "--only", "operations", "--only", "speed")
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertEqual(result.stderr, "")
        self.assertIn("as pinned", result.stdout)
        report = json.loads((out / "device.json").read_text())
        self.assertEqual(report["wrong"], [])
        self.assertEqual(report["pictures"]["different"], 0)
        self.assertGreaterEqual(report["pictures"]["pictures"], 12 * 20)
        self.assertEqual(len(report["operations"]), 12)
        self.assertEqual(sum(o["count"] for o in report["operations"]), 4 * 10000 + 8 * 1000)
        rows = report["speed"]["rows"]
        self.assertEqual({(r["spheres"], r["precision"], r["search"]) for r in rows},
                         {(n, p, s) for n in (8, 20) for p in ("f32", "mixed", "f64") for s in ("linear", "bvh")})
        for row in rows:
            self.assertEqual({(c["most_registers"], c["block"]) for c in row["cells"]},
                             {(cap, block) for cap in ("none", "64") for block in (64, 128)})
        text = (out / "device.md").read_text()
        self.assertIn("| 20 | mixed | bvh |", text)
        self.assertNotIn("Wrong", text)

    def test_a_wrong_bit_in_a_picture_is_found_and_named(self):
        result = self.bench("--only", "pictures", fault="flip trace_mixed_linear_8")
        self.assert_wrong(result, r"picture glass \(mixed, linear, sobol\), pixel \(0, 4\): the sum of channel 0 is \d+, "
                                  r"not \d+ \(1 of 96 pixels differ\)")
        self.assertNotIn("(f32", result.stdout)

    def test_a_wrong_bit_in_the_fingerprint_is_found_and_named(self):
        result = self.bench("--only", "fingerprint", fault="flip trace_f64_bvh_8")
        self.assert_wrong(result, r"picture of the fingerprint \d \(f64, bvh, \w+\), pixel \(\d+, \d+\): ")
        self.assert_wrong(result, r"fingerprint [0-9a-f]{64}, not the pinned ")

    def test_a_wrong_bit_in_an_operation_is_found_and_named(self):
        result = self.bench("--only", "operations", fault="flip probe_f64_div")
        self.assert_wrong(result, r"probe_f64_div, operation 5000 of a = .* is .*, not .* \(1 of 10000 operations differ\)")

    def test_a_wrong_bit_in_a_measured_picture_is_found_and_named(self):
        result = self.bench("--only", "speed", fault="flip trace_f32_bvh_8")
        self.assert_wrong(result, r"picture of 20 spheres \(f32, bvh\) with the limit of registers none and blocks of 64, "
                                  r"pixel \(8, 2\), samples 0 to 15: the sum of channel 0 is \d+, not \d+")

    def test_a_measured_launch_that_computes_nothing_is_wrong(self):
        result = self.bench("--only", "speed", "--precisions", "f32", fault="skip trace_f32_linear_8")
        self.assert_wrong(result, r"picture of 8 spheres \(f32, linear\)")
        self.assertNotIn("(f32, bvh)", result.stdout)

    def test_a_scene_for_which_no_time_is_left_is_left_out_by_name(self):
        out = self.folder / "out"
        result = self.bench("-o", out, "--only", "speed", "--precisions", "f32", "--time-limit", "0.0001")
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        report = json.loads((out / "device.json").read_text())
        self.assertEqual(report["speed"]["left_out"], ["8 f32", "20 f32"])
        self.assertIn("Left out, because the time was over: 20 f32", (out / "device.md").read_text())

    def test_without_driver_device_or_code_it_says_so_with_status_77(self):
        self.assert_one_line(self.bench(driver=self.folder / "none.so"), 77, "no CUDA driver", "none.so")
        self.assert_one_line(self.bench(fault="no_device"), 77, "no CUDA device", "CUDA_ERROR_NO_DEVICE")
        self.assert_one_line(self.bench("--device", "3"), 77, "no CUDA device 3: the driver lists 1")
        (self.folder / "probe.ptx").unlink()
        self.assert_one_line(self.bench(), 77, "no device code", "probe.ptx is missing")

    def test_a_failure_of_the_driver_is_one_line_with_its_function_and_error(self):
        self.assert_one_line(self.bench(fault="out_of_memory"), 1, "cuMemAlloc_v2", "CUDA_ERROR_OUT_OF_MEMORY", "bytes")
        self.assert_one_line(self.bench(fault="launch_fails"), 1, "cuCtxSynchronize", "CUDA_ERROR_LAUNCH_FAILED")
        self.assert_one_line(self.bench(fault="invalid_ptx"), 1, "cuModuleLoadDataEx", "CUDA_ERROR_INVALID_PTX")


class PackedBench(unittest.TestCase):
    def test_the_packed_bench_runs_by_itself(self):
        with tempfile.TemporaryDirectory() as directory:
            build, pack = pathlib.Path(directory, "build"), pathlib.Path(directory, "pack")
            (build / "device").mkdir(parents=True)
            (build / "bin").symlink_to(BIN)
            code_in(build / "device")
            script = SOURCE / "tests/bench/device"
            subprocess.run([script, "--build", build, "--pack", pack], check=True, timeout=300)
            result = subprocess.run([pack / "tests/bench/device", "--build", pack, "--driver", STAND_IN, "-o", pack / "out",
                                     *SMALL, "--spheres", "486", "--precisions", "f32"], capture_output=True, text=True,
                                    timeout=300, env={"PATH": "/usr/bin:/bin"})
            self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
            self.assertIn("0 wrong", result.stdout)
            told = subprocess.run([pack / "tests/bench/device", "--help", "--build", pack], capture_output=True, text=True,
                                  check=True).stdout
            self.assertIn("--pack DIR", told)
            self.assertIn("--operations", told)
            self.assertRegex(result.stdout, r"Goal: 0\.50 G samples/s in f32 at 486 spheres\. Measured: .*(Not r|R)eached\.")
            self.assertIn("tiles of 8 x 4", (pack / "out/device.md").read_text())
            libraries = subprocess.run(["ldd", pack / "bin/bench_device"], capture_output=True, text=True, check=True).stdout
            outside = [line for line in libraries.splitlines() if " => /" in line and str(pack) not in line]
            self.assertEqual(sorted(line.split()[0] for line in outside), ["libc.so.6", "libm.so.6"])


if __name__ == "__main__":
    unittest.main()
