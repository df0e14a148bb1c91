#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "common/image/picture_bytes.h"
#include "common/scene/scene.h"
#include "common/scene/setting_choices.h"
#include "common/scene/settings_fwd.h"
#include "common/trace/integrator/path_tracer.h"

/// Denoising, and the remaining error.
///
/// The samples of a picture form two halves A and B: the even and the odd samples of each pixel.
/// The filter denoises each half, and the picture is the mean of the two. The filter fits the
/// radiance around a pixel to its features (Features) by a weighted linear regression. The weight
/// of a neighbouring pixel depends on how similar the patches around the two pixels are (Buades,
/// Coll and Morel, "A non-local algorithm for image denoising", 2005; Bitterli et al., "Nonlinearly
/// weighted first-order regression for denoising Monte Carlo renderings", 2016). The fit is
/// evaluated at the steady features instead of the half's own features. Radiance and features of a
/// half share their noise, and this step removes it (control variates). The filter computes two
/// results, with less and with more smoothing. It mixes these and the unfiltered half so that,
/// around a pixel and without the pixel itself, the mixture is closest to the other half. So a
/// pixel that the filter would make worse stays as it is.
///
/// The filtered half F in a pixel does not depend on B in that pixel. Therefore the mean of
/// (F - m)(B - m) is 0, where m is the truth. With G from B and D = (F + G) / 2,
///   |F - B|^2 / 2 + |G - A|^2 / 2 - |A - B|^2 / 2 - |F - G|^2 / 4
///     = |D - m|^2 - (F - m)(B - m) - (G - m)(A - m) + (A - m)(B - m).
/// This is the square error of D, including the filter's bias, and three terms with mean 0. (F
/// depends a little on B in that pixel, by one factor of the noise estimate that comes from all
/// pixels. The effect is one part in the number of pixels.)
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
/// `settings`. `steady` traces the steady features: the result of steady_tracer(). If `tracer`
/// traces only a part of the picture (PartOfPicture), `steady` must trace the same part. `samples`:
/// the number of samples of the pixel that has the fewest; it must be at least 2. `threads`: at
/// least 1; the result is the same for any number. Calls `between_bands`, if set, in the calling
/// thread before each band of rows, several times a second. If `between_bands` throws, the function
/// stops and rethrows the exception.
Features trace_features(const PathTracer& tracer, const PathTracer& steady, const Scene& scene,
                        const PictureSettings& settings, std::uint32_t samples, int threads,
                        const std::function<void()>& between_bands = {});

/// Returns a tracer with another seed than the picture's: the picture contains none of its samples.
std::unique_ptr<PathTracer> steady_tracer(const PathTracer& tracer, const Scene& scene,
                                          const PictureSettings& settings);

struct Denoised {
  std::vector<float> rgb;  ///< linear radiance, 3 values per pixel, in image order
  /// Root mean square error over pixels and channels, and its 95 % confidence interval. 0 if the
  /// estimate of the square is negative. The interval lacks light that no sample has shown:
  /// unseen_square() (common/adaptive/error_estimate.h).
  double rmse = 0;
  double low = 0;
  double high = 0;
};

/// Denoises a picture. `replicates` and `features` belong to the same picture. `isa` is automatic
/// or one that this machine has. The bits are the same for any `threads` and `isa`. Calls
/// `between_bands`, if set, several times a second; an exception of it ends the work. Uses about
/// 200 bytes of memory per pixel, including the features.
Denoised denoise(const Replicates& replicates, const Features& features, int threads,
                 Isa isa = Isa::automatic, const std::function<void()>& between_bands = {});

}  // namespace parray::denoise
