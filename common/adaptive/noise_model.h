#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/adaptive/pixel_noise.h"

namespace parray::adaptive {

/// Half-width of the 95 % confidence interval of a standard normal distribution.
inline constexpr double normal_95 = 1.959964;

/// A NoiseModel's forecast for the pixels of a row, 3 values per pixel: mean square errors and
/// squared half-widths. Divide each value by the pixel's count.
struct NoiseForecast {
  explicit NoiseForecast(std::size_t width)
      : own(3 * width), expected(3 * width), half_width(3 * width) {}
  std::vector<double> own;         ///< mean square error, from the pixel's own variance
  std::vector<double> expected;    ///< mean square error, from the surroundings
  std::vector<double> half_width;  ///< squared half-width, from the surroundings
};

/// Returns the square of the half-width of a pixel's 95 % confidence interval, from two estimates
/// of it. The result is their mean, but at least 0.8 of the second estimate.
///
/// The first estimate is `by_around`, a squared half-width from the variance around the pixel. It
/// covers 95 % of the pixels with such surroundings. It is right for a pixel that missed its rare
/// bright samples, and wrong for a pixel that differs from its surroundings. The second estimate
/// follows from `own_square`, the mean square error by the pixel's own samples. It is wrong for a
/// pixel that missed its rare bright samples, and right for a pixel that differs from its
/// surroundings.
inline double half_width_square(double own_square, double by_around) {
  // A pixel much noisier than its surroundings keeps this share of its own estimate.
  constexpr double alone = 0.8;
  const double by_own = normal_95 * normal_95 * own_square;
  return std::max((by_own + by_around) / 2, alone * by_own);
}

/// Computes the half-widths of a row, in linear radiance, from the counts and the forecast. All
/// have 3 values per pixel; the three values of `count` are equal.
void half_widths(std::span<const double> count, const NoiseForecast& forecast,
                 std::span<float> half_widths);

/// Predicts the errors of pixels from the picture's replicates: the means A of the even and B of
/// the odd samples. The model groups pixels by the noise of their own samples and by the noise
/// around them. The error of a pixel is (A + B) / 2 - mu, where mu is the true value. It differs
/// from the known half difference (A - B) / 2 only in the sign of the error of B. So the model
/// measures how much better than independent samples a sampler is, and does not assume it. A value
/// belongs to one pixel and channel. Only the constructor reads the picture.
class NoiseModel {
 public:
  /// Fits the model to `state`. Each pixel must have at least 2 samples. In a large picture the
  /// model is fitted to some rows only, with about `asked` pixels in total. `horizon`: the reach of
  /// the surroundings in the rows that predict() will get, which NoiseRows with the same `horizon`
  /// computes.
  NoiseModel(const FramebufferView& state, NeighbourhoodSize horizon,
             std::size_t asked = std::size_t{1} << 17);

  /// Computes the forecast of a row. `forecast` must be made for the row's number of pixels.
  void predict(const NoiseNearby& row, NoiseForecast& forecast) const;

 private:
  /// Levels of variance, two per octave; level 0: no variance.
  static constexpr std::size_t levels = 160;
  static constexpr std::size_t ratios = 256;  ///< bins of |difference| / deviation, 16 per octave
  /// Kinds of surroundings, by ridge / mean: see NeighbourhoodRow.
  static constexpr std::size_t kinds = 4;
  static constexpr std::size_t places = kinds * levels;
  /// Statistics of the values with similar noise around their pixels.
  struct Around {
    std::array<std::uint32_t, ratios> found{};
    double values = 0;     ///< their number
    double squares = 0;    ///< sum of squared differences times counts
    double variances = 0;  ///< sum

    void operator+=(const Around& other);
  };
  /// Statistics of the values with a similar variance of their own.
  struct Own {
    double values = 0;       ///< their number
    double differences = 0;  ///< sum of squares
    double variances = 0;    ///< sum of the means' variances

    void operator+=(const Own& other);
  };

  /// Sums over some of the rows.
  struct Findings {
    std::vector<Around> around = std::vector<Around>(places);
    std::array<Own, levels> own{};
    double samples = 0;  ///< summed over all values
    // Of level 0.
    double unseen_squares = 0;  ///< of differences, times counts
    double unseen_values = 0;
    double unseen_samples = 0;

    void operator+=(const Findings& other);
  };

  /// Factors for independent samples of variance 1, by the surroundings of a pixel.
  struct Factors {
    double expected = 0;    ///< mean square error
    double half_width = 0;  ///< square of the half-width
  };

  void add(const NoiseNearby& row, Findings& findings) const;
  [[nodiscard]] std::size_t level_of(double variance) const;
  [[nodiscard]] std::size_t place_of(double variance, double ridge) const;
  /// The range of places (a place is a kind and a level) that are used together. The first and the
  /// last have values if any place has.
  struct Levels {
    std::size_t first = 0;
    std::size_t last = 0;
    friend bool operator==(const Levels&, const Levels&) = default;
  };
  [[nodiscard]] Levels levels_of(std::size_t place) const;
  void calibrate_around(std::size_t place, const Levels& borrowed);
  void calibrate_own(std::size_t level);

  double unit_;  ///< of variance: the largest radiance squared
  double per_unit_;
  Findings found_;
  std::array<Factors, places> around_factors_{};
  std::array<double, levels> own_factor_{};  ///< mean square error for variance 1
  double unseen_variance_ = 0;               ///< of level 0
};

}  // namespace parray::adaptive
