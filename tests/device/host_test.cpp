#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/math/float_mode.h"
#include "common/trace/device/device_fingerprint.h"
#include "common/trace/inside_stack.h"
#include "common/trace/selfcheck/fingerprint.h"
#include "tests/device/host_kernels.h"
#include "tests/device/scenes.h"
#include "tests/support/device_picture.h"
#include "tests/support/extreme_scenes.h"
#include "tests/support/precisions.h"
#include "tests/support/rooms.h"
#include "tests/support/tracers.h"

/// The device code as ordinary C++ functions, against the CPU's scalar tracer.
namespace parray::test {
namespace {

constexpr std::array searches{AcceleratorKind::linear, AcceleratorKind::bvh};
constexpr std::array samplers{Sampler::sobol, Sampler::independent};

/// Number of pixels that were handed back, for each limit of nested shapes.
struct HandedBack {
  std::uint64_t at_0 = 0, at_1 = 0, at_2 = 0, at_8 = 0;
};

/// Traces a picture with the scalar tracer, and in every search with every limit of nested shapes.
void check_picture(const Scene& scene, RenderSettings settings, HandedBack& handed_back) {
  const ReferenceSums expected = sums_of(*make_scalar_tracer(scene, settings), settings);
  for (const AcceleratorKind search : searches) {
    CAPTURE(name_of(search));
    settings.accelerator = search;
    const auto with_limit = [&](std::uint32_t most_inside, std::uint64_t& count) {
      CAPTURE(most_inside);
      const DevicePictureSums found = device_sums(
          scene, settings, [&](const Launch& launch) { launch_on_host(launch, most_inside); });
      CHECK(found.sums == expected);
      count += found.handed_back;
    };
    with_limit(0, handed_back.at_0);
    with_limit(1, handed_back.at_1);
    with_limit(2, handed_back.at_2);
    with_limit(8, handed_back.at_8);
  }
}

HandedBack check_scene(const std::string& name, const Scene& scene, RenderSettings settings) {
  CAPTURE(name);
  HandedBack handed_back;
  for (const Precision precision : precisions) {
    CAPTURE(name_of(precision));
    for (const Sampler sampler : samplers) {
      CAPTURE(name_of(sampler));
      settings.precision = precision;
      settings.sampler = sampler;
      check_picture(scene, settings, handed_back);
    }
  }
  return handed_back;
}

RenderSettings small_picture() {
  RenderSettings settings;
  settings.width = 16;
  settings.height = 12;
  settings.samples_per_pixel = 3;
  settings.max_depth = 20;
  return settings;
}

}  // namespace

TEST_CASE("device code has the scalar tracer's bits for every scene file") {
  for (const NamedScene& named : all_scene_files(12, 8, 2)) {
    check_scene(named.name, named.scene, named.settings);
  }
}

TEST_CASE("device code has the scalar tracer's bits for overlapping glass, balls and sticks") {
  const HandedBack handed_back = check_scene("overlapping", overlapping_shapes(), small_picture());
  CHECK(handed_back.at_0 > handed_back.at_1);
  CHECK(handed_back.at_1 > handed_back.at_2);
  CHECK(handed_back.at_2 > handed_back.at_8);
}

TEST_CASE("a path inside more shapes than the stack holds hands its pixel back to the CPU") {
  for (const bool around_eye : {false, true}) {
    CAPTURE(around_eye);
    const HandedBack few = check_scene("8 nested", nested_balls(8, around_eye), small_picture());
    CHECK(few.at_2 > 0);
    CHECK(few.at_8 == 0);
    const HandedBack many = check_scene("15 nested", nested_balls(15, around_eye), small_picture());
    CHECK(many.at_8 > 0);
    const std::uint64_t pixels = 16 * 12;
    constexpr std::uint64_t pictures = 12;  // precisions, samplers, searches
    if (around_eye) CHECK(many.at_8 == pixels * pictures);
  }
}

TEST_CASE(
    "device code has the scalar tracer's bits where paths cross hundreds of sticks in a body") {
  Scene scene = small_scene();
  for (std::uint32_t i = 0; i < 150; ++i) {  // more than most_crossings side by side
    const double x = 0.05 * i - 4;
    scene.capsules.push_back({{x, 0.5, -2}, {x, 0.5, 2}, 0.4, 2});
  }
  RenderSettings settings = small_picture();
  settings.width = 8;
  settings.height = 6;
  settings.samples_per_pixel = 2;
  check_scene("sticks", scene, settings);
}

TEST_CASE("device code has the scalar tracer's bits for scenes of extreme numbers") {
  RenderSettings settings = small_picture();
  settings.samples_per_pixel = 1;
  const ExtremeScenes extremes(4);
  for (std::uint64_t i = 0; i < 22; ++i) {
    const ExtremeScene extreme = extremes.make(i);
    check_scene(extreme.kind, extreme.scene, settings);
  }
}

TEST_CASE("device code as C++ has the pinned fingerprint of a machine") {
  const std::string found = trace_fingerprint([](const Scene& scene, const RenderSettings& s) {
    return std::make_unique<DeviceTracer>(scene, s, [](const Launch& l) { launch_on_host(l); });
  });
  CHECK(found == pinned_fingerprint);
}

TEST_CASE("the scalar tracer and device code as C++ have the pinned fingerprint of devices") {
  const std::string scalar =
      device_fingerprint([](const Scene& scene, const RenderSettings& s,
                            std::span<PixelSums> pixels, TraceCounts& counts) {
        const auto tracer = make_scalar_tracer(scene, s);
        for (std::uint32_t y = 0; y < s.height; ++y) {
          tracer->trace({y, 0, s.width}, {0, s.samples_per_pixel},
                        pixels.subspan(std::size_t{y} * s.width, s.width), counts);
        }
      });
  CHECK(scalar == pinned_device_fingerprint);
  CHECK(fingerprint_of([](const Launch& launch) { launch_on_host(launch); }) ==
        pinned_device_fingerprint);
}

TEST_CASE("device code that flushes denormals to zero has another fingerprint") {
  if (float_control::denormal_results == 0) return;  // an unknown processor
  const std::string found = fingerprint_of([](const Launch& launch) {
    const FloatMode restored_afterwards;
    float_control::write(float_control::ieee | float_control::denormal_results);
    launch_on_host(launch);
  });
  CHECK(found != pinned_device_fingerprint);
}

TEST_CASE("a list of nested shapes keeps their order and says that it is full") {
  ShortList<3> list;
  for (const std::uint32_t shape : {5U, 6U, 7U}) list.push_back(shape);
  CHECK_FALSE(list.overflowed());
  list.erase(list.begin());
  CHECK(std::vector<std::uint32_t>(list.begin(), list.end()) == std::vector<std::uint32_t>{6, 7});
  list.push_back(8);
  CHECK_FALSE(list.overflowed());
  list.push_back(9);
  CHECK(list.overflowed());
  list.erase(list.begin());
  CHECK(list.overflowed());
  list.clear();
  CHECK_FALSE(list.overflowed());
  CHECK(list.begin() == list.end());
}

TEST_CASE("the CPU traces a scene whose tree is deeper than the stack of a kernel") {
  Scene scene = small_scene();
  for (double radius = 1e-15; radius < 1e15; radius *= 1.1) {  // each a little farther away
    scene.spheres.push_back({radius * Vec3d{20, 3, -7}, radius, 1});
  }
  RenderSettings settings = small_picture();
  settings.precision = Precision::f64;
  settings.accelerator = AcceleratorKind::bvh;
  const DeviceScene tables(scene, settings.precision, settings.accelerator);
  CHECK_FALSE(tables.fits());
  CHECK(DeviceScene(scene, settings.precision, AcceleratorKind::linear).fits());
  const DevicePictureSums found =
      device_sums(scene, settings, [](const Launch&) { throw std::logic_error("launched"); });
  CHECK(found.sums == sums_of(*make_scalar_tracer(scene, settings), settings));
  CHECK(found.handed_back == found.sums.pixels.size());
}

TEST_CASE("an empty item and a scene without shapes have sums of their own") {
  Scene scene = small_scene();
  scene.spheres.clear();
  check_scene("sky", scene, small_picture());
  const DeviceScene tables(scene, Precision::f32, AcceleratorKind::bvh);
  const DevicePicture picture(tables, scene.camera, small_picture());
  const std::array<DeviceItem, 1> items{{{3, 4, 7, 7}}};
  std::array<DeviceSums, 1> sums;
  launch_on_host({kernel_name(tables, picture), tables.bytes(), picture.bytes(), items, sums});
  PixelSums pixel;
  TraceCounts counts;
  add_result(items[0], sums[0], pixel, counts);
  CHECK(pixel == PixelSums{});
  CHECK(counts == TraceCounts{});
}

}  // namespace parray::test
