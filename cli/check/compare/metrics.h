#pragma once

#include <cstddef>
#include <cstdint>

#include "common/image/image.h"

/// Error metrics of a picture F against a reference R of the same size.
///
/// All metrics use unclamped values of linear RGB; a value is one channel of one pixel. Pixels that
/// are not finite in R or F are left out.
namespace parray::compare {

/// Keeps relative errors of dark values finite; part of the definitions.
inline constexpr double relative_epsilon = 0.01;

struct ErrorMetrics {
  /// Mean of (F - R)^2.
  double mse = 0;
  /// Its square root.
  double rmse = 0;
  /// -10 log10(mse), in decibel: peak signal to noise for a peak of 1. Infinite if mse is 0.
  double psnr = 0;
  /// Mean of (F - R)^2 / (R^2 + relative_epsilon): Rousselle, Knaus and Zwicker, "Adaptive
  /// Sampling and Reconstruction using Greedy Error Minimization", 2011.
  double relative_mse = 0;
  /// Mean of |F - R| / (|F| + |R| + relative_epsilon), in [0, 1): the symmetric mean absolute
  /// percentage error of Vogels et al., "Denoising with Kernel Prediction and Asymmetric Loss
  /// Functions", 2018, as a fraction.
  double smape = 0;
  /// Mean of |F - R|.
  double mean_absolute = 0;
  /// Mean of F - R.
  double bias = 0;
  /// 99.9th percentile of |F - R| (nearest rank).
  double absolute_999 = 0;
  /// Largest |F - R|, and its first pixel in reading order.
  double largest_absolute = 0;
  std::uint32_t worst_x = 0;
  std::uint32_t worst_y = 0;

  std::size_t nonfinite_in_reference = 0;  ///< pixels of R with an infinity or a NaN
  std::size_t nonfinite_in_image = 0;      ///< pixels of F with one
  std::size_t excluded = 0;                ///< pixels with one in R or F

  /// Returns the number of pixels with an infinity or a NaN in R and in F.
  [[nodiscard]] std::size_t nonfinite_in_both() const {
    return nonfinite_in_reference + nonfinite_in_image - excluded;
  }
  /// False if every pixel was left out: then the errors are NaN and there is no worst pixel.
  [[nodiscard]] bool any() const { return compared > 0; }
  std::size_t compared = 0;  ///< pixels that were not left out
};

/// Precondition: both have the same size, at least one pixel.
ErrorMetrics error_metrics(const Image& reference, const Image& image);

/// Returns whether every channel of pixel `index` (y * width + x) is finite.
bool finite_pixel(const Image& image, std::size_t index);

/// Returns whether both have the same size and the same bits in every value. NaN may equal NaN; -0
/// differs from 0.
bool same_bits(const Image& a, const Image& b);

/// The sum of the differences between pictures F and a reference picture R: V = sum of |R - F|, for
/// each channel of each pixel in linear RGB. It is the verification picture (equation 1, figure 11)
/// in the report of the seed program. ParRay started from that program.
///
/// Equal infinities, and NaN in both R and F, count as 0. NaN in one of them counts as 1. Other
/// infinite differences make V infinite.
class DifferenceImage {
 public:
  /// `reference` is R; it must outlive this object.
  explicit DifferenceImage(const Image& reference);

  /// Adds a picture F, which must have the size of R.
  void add(const Image& image);

  /// Returns the largest value of V: 0 if all pictures equal R.
  [[nodiscard]] float largest() const;

  /// Returns the picture max(0, 1 - V) in linear RGB: 1 where all pictures equal R, darker for
  /// larger differences, black where V is 1 or more. V is not scaled, so two such pictures can be
  /// compared.
  [[nodiscard]] Image drawn() const;

 private:
  const Image& reference_;
  Image sum_;
};

}  // namespace parray::compare
