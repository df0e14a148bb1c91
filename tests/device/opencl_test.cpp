#include "tests/device/opencl.h"

#include <doctest/doctest.h>

#include <string>

#include "common/trace/device/device_fingerprint.h"
#include "common/trace/selfcheck/fingerprint.h"
#include "tests/device/host_kernels.h"
#include "tests/device/scenes.h"
#include "tests/support/device_picture.h"
#include "tests/support/rooms.h"
#include "tests/support/tracers.h"

/// The kernels through OpenCL: another compiler and another machine's instructions.
namespace parray::test {
namespace {

const std::string kernels = PARRAY_DEVICE_DIR "/kernels.spir";

/// Says why a test is left out, if it is.
bool skipped(const std::string& file) {
  const std::string reason = OpenCl::reason_without(file);
  if (!reason.empty()) MESSAGE("skipped: " << reason);
  return !reason.empty();
}

/// Compares a picture of a device with the CPU's.
void check_opencl_picture(OpenCl& device, const Scene& scene, const RenderSettings& settings) {
  const DevicePictureSums found =
      device_sums(scene, settings, [&](const Launch& launch) { device.run(launch); });
  CHECK(found.sums == sums_of(*make_path_tracer(scene, settings), settings));
  CHECK(found.handed_back == 0);
}

}  // namespace

TEST_CASE("through OpenCL, kernels have the scalar tracer's bits for every scene file") {
  if (skipped(kernels)) return;
  OpenCl device(kernels);
  for (const NamedScene& named : all_scene_files(60, 40, 8)) {
    CAPTURE(named.name);
    check_opencl_picture(device, named.scene, named.settings);
  }
}

TEST_CASE("long: through OpenCL, every scene file in every precision, sampler and search" *
          doctest::skip()) {
  if (skipped(kernels)) return;
  OpenCl device(kernels);
  for (const NamedScene& named : all_scene_files(60, 40, 8)) {
    CAPTURE(named.name);
    RenderSettings settings = named.settings;
    for (const Precision precision : {Precision::f32, Precision::mixed, Precision::f64}) {
      for (const Sampler sampler : {Sampler::independent, Sampler::sobol}) {
        for (const AcceleratorKind search : {AcceleratorKind::linear, AcceleratorKind::bvh}) {
          settings.precision = precision;
          settings.sampler = sampler;
          settings.accelerator = search;
          check_opencl_picture(device, named.scene, settings);
        }
      }
    }
  }
}

TEST_CASE("through OpenCL, kernels hand back pixels with deeper nests than they store") {
  if (skipped(kernels)) return;
  OpenCl device(kernels);
  RenderSettings settings;
  settings.width = 60;
  settings.height = 40;
  settings.samples_per_pixel = 2;
  settings.precision = Precision::f32;
  settings.accelerator = AcceleratorKind::bvh;
  for (const bool around_eye : {false, true}) {
    CAPTURE(around_eye);
    const Scene scene = nested_balls(15, around_eye);
    const DevicePictureSums found =
        device_sums(scene, settings, [&](const Launch& launch) { device.run(launch); });
    CHECK(found.sums == sums_of(*make_path_tracer(scene, settings), settings));
    CHECK(found.handed_back > 0);
  }
}

TEST_CASE("through OpenCL, kernels have both pinned fingerprints") {
  if (skipped(kernels)) return;
  OpenCl device(kernels);
  const auto launch = [&](const Launch& l) { device.run(l); };
  CHECK(fingerprint_of(launch) == pinned_device_fingerprint);
  CHECK(trace_fingerprint([&](const Scene& scene, const RenderSettings& settings) {
          return std::make_unique<DeviceTracer>(scene, settings, launch);
        }) == pinned_fingerprint);
}

TEST_CASE("through OpenCL, f32 kernels that fuse products and sums have another fingerprint") {
  const std::string fused = PARRAY_DEVICE_DIR "/fused.spir";
  if (skipped(fused)) return;
  OpenCl device(fused);
  std::uint64_t launches = 0;
  const std::string found = fingerprint_of([&](const Launch& launch) {
    if (launch.kernel.find("_f32_") == std::string::npos) return launch_on_host(launch);
    device.run(launch);
    ++launches;
  });
  CHECK(launches == 4);
  CHECK(found != pinned_device_fingerprint);
}

}  // namespace parray::test
