#include "common/trace/selfcheck/fingerprint.h"

#include <span>
#include <vector>

#include "common/base/sha256.h"
#include "common/math/float_mode.h"
#include "common/scene/settings.h"

namespace parray::trace {
namespace {

Scene built_in_scene() {
  Scene scene;
  scene.camera.tan_half_vfov = 0.25;
  scene.materials = {{MaterialType::diffuse, {0.5, 0.6, 0.7}, 0, 1},
                     {MaterialType::metal, {0.9, 0.8, 0.7}, 0.3, 1},
                     {MaterialType::dielectric, {1, 1, 1}, 0, 1.5},
                     {MaterialType::dielectric, {1, 1, 1}, 0, 1 / 1.5}};
  scene.spheres = {{{0, -1000, 0}, 1000, 0}, {{0, 1, 0}, 1, 2},      {{0, 1, 0}, 0.9, 3},
                   {{4, 1, 0}, 1, 1},        {{-4, 1, 0}, 1, 0},     {{6, 0.4, 1.5}, 0.4, 2},
                   {{5, 0.3, 2}, 0.3, 0},    {{7, 0.25, 2}, 0.25, 1}};
  for (std::uint32_t i = 0; i < 64; ++i) {  // enough for a tree of several levels
    const std::uint32_t row = i / 8;
    scene.spheres.push_back({{0.75 * (i % 8) - 1, 0.2, 0.75 * row - 3}, 0.2, i % 3});
  }
  // Sticks of every material; some glass ones overlap a ball of the same glass.
  for (std::uint32_t i = 0; i < 40; ++i) {
    const std::uint32_t row = i / 8;
    const Vec3d from{0.8 * (i % 8) - 1, 0.3, row - 2.5};
    const Vec3d along{0.1 * (i % 3), 0.25 * (i % 5), 0.5 - 0.125 * (i % 7)};
    scene.capsules.push_back({from, from + along, 0.0625 * (1 + i % 3), i % 4});
  }
  return scene;
}

}  // namespace

std::string trace_fingerprint(const TracerMaker& make) {
  const FloatMode ieee;
  const Scene scene = built_in_scene();
  RenderSettings settings;
  settings.width = 24;
  settings.height = 16;
  settings.accelerator = AcceleratorKind::bvh;
  std::vector<PixelSums> sums(6ULL * settings.width * settings.height);
  // High enough that every part of a point's number matters.
  constexpr SampleRange samples{999, 1003};
  std::size_t next = 0;
  for (const Sampler sampler : {Sampler::independent, Sampler::sobol}) {
    settings.sampler = sampler;
    for (const Precision precision : {Precision::f32, Precision::mixed, Precision::f64}) {
      settings.precision = precision;
      const auto tracer = make(scene, settings);
      for (std::uint32_t y = 0; y < settings.height; ++y) {
        TraceCounts counts;
        tracer->trace({y, 0, settings.width}, samples,
                      std::span(sums).subspan(next, settings.width), counts);
        next += settings.width;
      }
    }
  }
  return sha256_hex(std::as_bytes(std::span(sums)));
}

}  // namespace parray::trace
