#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "common/scene/scene.h"
#include "common/scene/settings_fwd.h"
#include "common/trace/integrator/path_tracer.h"

namespace parray::denoise {

/// One number for each pixel of a picture and of a margin around it, so that windows around whole
/// tiles can be read. repeat_border() fills the margin with the values of the border.
class Plane {
 public:
  static constexpr std::size_t margin = 8;
  static constexpr std::size_t tile = 32;

  Plane(std::uint32_t width, std::uint32_t height)
      : width_(width),
        height_(height),
        stride_(whole_tiles(width) + 2 * margin),
        values_(stride_ * (whole_tiles(height) + 2 * margin)) {}

  [[nodiscard]] std::uint32_t width() const { return width_; }
  [[nodiscard]] std::uint32_t height() const { return height_; }
  /// Returns the distance between rows.
  [[nodiscard]] std::size_t stride() const { return stride_; }
  [[nodiscard]] float* row(std::size_t y) { return values_.data() + start(y); }
  [[nodiscard]] const float* row(std::size_t y) const { return values_.data() + start(y); }

  void repeat_border();

 private:
  static std::size_t whole_tiles(std::size_t side) { return (side + tile - 1) / tile * tile; }
  [[nodiscard]] std::size_t start(std::size_t y) const { return (y + margin) * stride_ + margin; }

  std::uint32_t width_;
  std::uint32_t height_;
  std::size_t stride_;
  std::vector<float> values_;
};

/// Means over the first hits of a pixel's camera rays: albedo (R, G, B), normal (x, y, z, on the
/// side of the ray), and 1 / depth, scaled to vary by about 1 over the picture. For the sky the
/// normal points back along the ray, because the sky's radiance is linear in it; the other features
/// are 0.
inline constexpr std::size_t feature_count = 7;
using FeaturePlanes = std::vector<Plane>;  ///< feature_count planes

/// The features of a picture: from the samples of either half, and exact.
struct Features {
  /// From the first samples of the even and of the odd half. Their noise is correlated with the
  /// half's radiance, so that the filter can remove it.
  std::array<FeaturePlanes, 2> own;
  /// From many other samples, which neither half contains.
  FeaturePlanes steady;
  /// In image order: whether all these samples hit only sky, which has almost no noise. Empty:
  /// false everywhere.
  std::vector<char> plain_sky;
};

/// Samples per pixel, both halves together, for the features of the halves.
inline constexpr std::uint32_t own_feature_samples = 16;
/// Samples for the steady features: few if they and those of the neighbours hit the same sphere,
/// otherwise many.
inline constexpr std::uint32_t few_steady_samples = 8;
inline constexpr std::uint32_t many_steady_samples = 64;

/// Traces the features with the accelerator of `tracer`, which belongs to `scene` and `settings`.
/// Each pixel of the picture has at least `samples` samples, 2 or more. The result is the same for
/// any number of threads. Calls `between_bands`, if set, several times a second; an exception of it
/// ends the work.
Features trace_features(const PathTracer& tracer, const Scene& scene,
                        const RenderSettings& settings, std::uint32_t samples, int threads,
                        const std::function<void()>& between_bands = {});

/// Does the same with another tracer for the steady features: steady_tracer(), or a part of it.
Features trace_features(const PathTracer& tracer, const PathTracer& steady, const Scene& scene,
                        const RenderSettings& settings, std::uint32_t samples, int threads,
                        const std::function<void()>& between_bands = {});

/// Returns a tracer of samples that the picture does not contain.
std::unique_ptr<PathTracer> steady_tracer(const PathTracer& tracer, const Scene& scene,
                                          const RenderSettings& settings);

}  // namespace parray::denoise
