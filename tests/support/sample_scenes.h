#pragma once

#include "common/image/image.h"
#include "common/scene/requirements.h"
#include "common/scene/scene_bytes.h"
#include "common/trace/kernel.h"

namespace parray::test {

/// Every material, a lens, a bubble in glass: small, but nothing that a path can meet is missing.
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

/// The picture that one thread makes in one piece, without leases, messages or a team.
inline std::string reference_sha256(const Scene& scene, RenderSettings settings) {
  settings.accelerator = AcceleratorKind::linear;
  settings.row_order = RowOrder::sequential;
  const auto kernel = make_kernel(scene, settings);
  Framebuffer framebuffer(settings);
  for (std::uint32_t y = 0; y < settings.height; ++y) {
    RowBlock row{{y, y + 1, 0, settings.samples_per_pixel},
                 settings.width,
                 {},
                 std::vector<PixelSums>(settings.width)};
    kernel->trace({y, 0, settings.width}, {0, settings.samples_per_pixel}, row.pixels, row.counts);
    framebuffer.merge(row);
  }
  return image_sha256(resolve_image(framebuffer, largest_radiance(scene)));
}

/// The same of a picture that goes in passes.
inline std::string reference_passes_sha256(const Scene& scene, RenderSettings settings) {
  settings.accelerator = AcceleratorKind::linear;
  settings.row_order = RowOrder::sequential;
  const auto kernel = make_kernel(scene, settings);
  const double largest = largest_radiance(scene);
  Framebuffer framebuffer(settings);
  for (std::uint32_t pass = 0;; ++pass) {
    const PassSize size = next_pass_size(framebuffer.state(largest), settings, pass);
    if (size.samples == 0) {
      return image_sha256(resolve_image(framebuffer, largest));
    }
    framebuffer.begin_pass(
        counts_after_pass(framebuffer.state(largest), settings, pass, size.samples));
    const WorkRect& rect = framebuffer.pass_rect();
    RowBlock block{rect, settings.width, {}, std::vector<PixelSums>(framebuffer.pixels().size())};
    for (std::uint32_t y = 0; y < settings.height; ++y) {
      const auto samples = framebuffer.samples_of({y, y + 1, rect.sample_begin, rect.sample_end});
      const std::vector<SampleRange> all(settings.width, rect.sample_range());
      kernel->trace_run(
          {y, 0, settings.width}, RunSamples(samples.empty() ? all : samples),
          std::span(block.pixels).subspan(std::size_t{y} * settings.width, settings.width),
          block.counts);
    }
    framebuffer.merge(block);
  }
}

}  // namespace parray::test
