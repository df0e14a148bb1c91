#pragma once

#include <string>
#include <vector>

#include "common/adaptive/error_estimate.h"
#include "common/adaptive/passes.h"
#include "common/scene/settings.h"
#include "common/trace/tracer.h"
#include "tests/support/rooms.h"

namespace parray::test {

/// A scene with a special kind of noise, and settings to trace it.
struct NoisyScene {
  std::string name;
  Scene scene;
  RenderSettings settings;
};

/// Returns five scenes: many materials; a crevice; caustics of glass shells; particles smaller than
/// a pixel; a room that gets light only through rare small gaps.
std::vector<NoisyScene> noisy_scenes(std::uint32_t width, std::uint32_t height);
/// Returns shipped scenes, which check findings from the scenes above.
std::vector<NoisyScene> other_scenes(std::uint32_t width, std::uint32_t height);

inline Vec3d grey(double value) { return {value, value, value}; }

/// A picture that grows by passes.
struct GrowingPicture {
  std::uint32_t width = 0;
  double largest_radiance = 1;
  std::vector<PixelSums> pixels;
  std::vector<std::uint32_t> counts;

  GrowingPicture(const RenderSettings& settings, double largest);
  [[nodiscard]] FramebufferView state() const;
  [[nodiscard]] std::uint64_t samples() const;
  /// Traces each pixel's samples up to `until`.
  void trace(const PathTracer& tracer, const std::vector<std::uint32_t>& until);
  /// Does the same with made-up samples: radiance_of(pixel, sample) is a Vec3d.
  template <typename RadianceOf>
  void make_up(const std::vector<std::uint32_t>& until, RadianceOf&& radiance_of) {
    const RadianceScale scale(largest_radiance);
    TraceCounts ignored;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      for (std::uint32_t sample = counts[i]; sample < until[i]; ++sample) {
        add_sample(radiance_of(i, sample), scale, sample, pixels[i], ignored);
      }
    }
    counts = until;
  }
  /// Returns the means in image order, 3 values per pixel.
  [[nodiscard]] std::vector<double> means() const;
};

/// Returns the size of a pass with a placement of its own.
inline PassSize size_of_pass(const FramebufferView& state, const RenderSettings& settings,
                             std::uint32_t pass, const Affordable& affordable = {}) {
  Placement placement(state, settings);
  return next_pass_size(state, settings, pass, placement, affordable);
}

/// Completes a picture pass by pass, as the settings ask. grow(until) traces the samples of a pass.
/// Returns why the picture is complete.
template <typename Grow>
StopReason grow_in_passes(const RenderSettings& settings, GrowingPicture& picture, Grow&& grow) {
  NoiseWeights found;
  for (std::uint32_t pass = 0;; ++pass) {
    Placement placement(picture.state(), settings, &found);
    const PassSize size = next_pass_size(picture.state(), settings, pass, placement);
    if (size.samples == 0) return size.stop;
    grow(placement.counts(size.samples));
  }
}

}  // namespace parray::test
