#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/adaptive/passes.h"
#include "common/image/image.h"
#include "common/scene/largest_radiance.h"
#include "common/scene/requirements.h"
#include "common/scene/scene_bytes.h"
#include "common/scene/settings.h"
#include "common/trace/tracer.h"
#include "tests/support/rooms.h"

namespace parray::test {

/// Returns a small scene with everything that a path can meet: all materials, a lens, a bubble in
/// glass.
inline Scene small_scene() {
  Scene scene;
  scene.camera.tan_half_vfov = 0.25;
  scene.materials = {{MaterialType::diffuse, {0.5, 0.6, 0.7}, 0, 1},
                     {MaterialType::metal, {0.9, 0.8, 0.7}, 0.3, 1},
                     {MaterialType::dielectric, {1, 1, 1}, 0, 1.5},
                     {MaterialType::dielectric, {1, 1, 1}, 0, 1 / 1.5}};
  scene.spheres = {{{0, -1000, 0}, 1000, 0}, {{0, 1, 0}, 1, 2},  {{0, 1, 0}, 0.9, 3},
                   {{4, 1, 0}, 1, 1},        {{-4, 1, 0}, 1, 0}, {{6, 0.4, 1.5}, 0.4, 2},
                   {{5, 0.3, 2}, 0.3, 0}};
  return scene;
}

inline RenderSettings small_settings(const Scene& scene) {
  RenderSettings settings;
  settings.width = 20;
  settings.height = 13;
  settings.samples_per_pixel = 6;
  settings.max_depth = 8;
  return resolve_settings(requirements_of(scene), settings).settings;
}

/// Adds the samples `ranges` of all pixels, in image order, in one thread.
inline void trace_into(Framebuffer& framebuffer, const PathTracer& tracer,
                       const std::vector<SampleRange>& ranges) {
  const std::uint32_t width = framebuffer.width();
  for (std::uint32_t y = 0; y < framebuffer.height(); ++y) {
    const auto row = std::span(ranges).subspan(std::size_t{y} * width, width);
    std::vector<PixelSums> sums(width);
    TraceCounts counts;
    tracer.trace_run({y, 0, width}, RunSamples(row), sums, counts);
    framebuffer.add(y, 0, sums, RunSamples(row));
    framebuffer.add(counts);
  }
}

/// Returns the picture that one thread traces at once, without leases, messages or a team.
inline std::string reference_sha256(const Scene& scene, RenderSettings settings) {
  settings.accelerator = AcceleratorKind::linear;
  Framebuffer framebuffer(settings.width, settings.height);
  trace_into(
      framebuffer, *make_path_tracer(scene, settings),
      std::vector<SampleRange>(framebuffer.pixels().size(), {0, settings.samples_per_pixel}));
  return image_sha256(resolve_image(framebuffer, largest_radiance(scene)));
}

/// Does the same for a picture in passes.
inline std::string reference_passes_sha256(const Scene& scene, RenderSettings settings) {
  settings.accelerator = AcceleratorKind::linear;
  const auto tracer = make_path_tracer(scene, settings);
  const double largest = largest_radiance(scene);
  Framebuffer framebuffer(settings.width, settings.height);
  NoiseWeights found;
  for (std::uint32_t pass = 0;; ++pass) {
    const FramebufferView state = framebuffer.view(largest);
    Placement placement(state, settings, &found);
    const PassSize size = next_pass_size(state, settings, pass, placement);
    if (size.samples == 0) return image_sha256(resolve_image(framebuffer, largest));
    const auto targets = placement.counts(size.samples);
    std::vector<SampleRange> ranges;
    for (std::size_t i = 0; i < targets.size(); ++i) {
      ranges.push_back({framebuffer.samples()[i], targets[i]});
    }
    trace_into(framebuffer, *tracer, ranges);
  }
}

}  // namespace parray::test
