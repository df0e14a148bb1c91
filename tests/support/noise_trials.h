#pragma once

#include <string>
#include <vector>

#include "common/image/error_estimate.h"
#include "common/image/passes.h"
#include "common/trace/kernel.h"

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

/// A picture that grows by passes.
struct NoisyPicture {
  std::vector<PixelSums> pixels;
  std::vector<std::uint32_t> counts;
  std::uint32_t width = 0;
  double largest_radiance = 1;

  NoisyPicture(const Scene& scene, const RenderSettings& settings);
  [[nodiscard]] PictureState state() const;
  [[nodiscard]] std::uint64_t samples() const;
  /// Traces each pixel's samples up to `until`.
  void trace(const Kernel& kernel, const std::vector<std::uint32_t>& until);
  /// By image row, 3 values a pixel.
  [[nodiscard]] std::vector<double> means() const;
};

/// The whole picture as settings ask, pass by pass; returns why it ended.
StopReason trace_in_passes(const Kernel& kernel, const RenderSettings& settings,
                           NoisyPicture& picture);

}  // namespace parray::test
