#pragma once

#include <string>
#include <vector>

#include "common/adaptive/error_estimate.h"
#include "common/adaptive/passes.h"
#include "common/scene/settings.h"
#include "common/trace/tracer.h"
#include "tests/support/rooms.h"

namespace parray::test {

/// A scene with noise of its own kind, and the settings to trace it with.
struct NoisyScene {
  std::string name;
  Scene scene;
  RenderSettings settings;
};

/// Many materials; a crevice; caustics of glass shells; particles smaller than a pixel; a room
/// whose only light falls through rare small gaps.
std::vector<NoisyScene> noisy_scenes(std::uint32_t width, std::uint32_t height);
/// Shipped scenes, to check on what was found out with the ones above.
std::vector<NoisyScene> other_scenes(std::uint32_t width, std::uint32_t height);

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
  /// The same with made-up samples: radiance_of(pixel, sample), a Vec3d.
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
  /// By image row, 3 values a pixel.
  [[nodiscard]] std::vector<double> means() const;
};

/// The whole picture as settings ask, pass by pass; grow(until) traces. Returns why it ended.
template <typename Grow>
StopReason grow_in_passes(const RenderSettings& settings, GrowingPicture& picture, Grow&& grow) {
  NoiseWeights found;
  for (std::uint32_t pass = 0;; ++pass) {
    const PassSize size = next_pass_size(picture.state(), settings, pass);
    if (size.samples == 0) {
      return size.stop;
    }
    grow(Placement(picture.state(), settings, &found).counts(size.samples));
  }
}

}  // namespace parray::test
