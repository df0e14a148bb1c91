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
  /// Returns the distance between rows in floats.
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

/// Number of features of a pixel. A feature is a mean over the first hits of the pixel's camera
/// rays. The features are the albedo (R, G, B), the normal (x, y, z, on the side from which the ray
/// comes), and 1 / depth. 1 / depth is scaled so that its standard deviation over the picture is 1.
/// A ray that hits only the sky counts with a normal opposite to its direction, because the sky's
/// radiance is a linear function of the direction. Its other features are 0.
inline constexpr std::size_t feature_count = 7;
using FeaturePlanes = std::vector<Plane>;  ///< feature_count planes

/// The features of a picture. The samples of each pixel form two halves, the even and the odd ones;
/// the filter denoises each half by itself.
struct Features {
  /// Features of the even and of the odd half, from the first samples of the half. Their noise is
  /// correlated with the noise of the half's radiance, because both come from the same samples. So
  /// the filter can predict a part of the radiance's noise and subtract it.
  std::array<FeaturePlanes, 2> own;
  /// Features with little noise, from samples that belong to neither half: few_steady_samples or
  /// many_steady_samples for each pixel.
  FeaturePlanes steady;
  /// One entry per pixel, row by row, without a margin. 1: all steady samples of the pixel hit only
  /// the sky; such a pixel has almost no noise. Empty: 0 for all pixels.
  std::vector<char> plain_sky;
};

/// Most samples per pixel, both halves together, for the features of the halves.
inline constexpr std::uint32_t own_feature_samples = 16;
/// Samples per pixel for the steady features: few if those of the pixel and of its 8 neighbours all
/// hit the same shape, or all the sky; otherwise many.
inline constexpr std::uint32_t few_steady_samples = 8;
inline constexpr std::uint32_t many_steady_samples = 64;

/// Traces the features of a picture. `tracer` is the tracer of the picture, made from `scene` and
/// `settings`. `samples`: the number of samples of the pixel that has the fewest; it must be at
/// least 2. `threads`: at least 1; the result is the same for any number. Calls `between_bands`, if
/// set, in the calling thread before each band of rows, several times a second. If `between_bands`
/// throws, the function stops and rethrows the exception.
Features trace_features(const PathTracer& tracer, const Scene& scene,
                        const RenderSettings& settings, std::uint32_t samples, int threads,
                        const std::function<void()>& between_bands = {});

/// Does the same with a given tracer for the steady features: the result of steady_tracer(). If
/// `tracer` traces only a part of the picture (PartOfPicture), `steady` must trace the same part.
Features trace_features(const PathTracer& tracer, const PathTracer& steady, const Scene& scene,
                        const RenderSettings& settings, std::uint32_t samples, int threads,
                        const std::function<void()>& between_bands = {});

/// Returns a tracer with another seed than the picture's: the picture contains none of its samples.
std::unique_ptr<PathTracer> steady_tracer(const PathTracer& tracer, const Scene& scene,
                                          const RenderSettings& settings);

}  // namespace parray::denoise
