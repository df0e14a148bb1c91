#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/adaptive/pixel_noise.h"

namespace parray::adaptive {

/// Half the width of a normal's 95 % interval.
inline constexpr double normal_95 = 1.959964;

/// What a NoiseModel says of the pixels of a row, 3 values a pixel: mean square errors and a square
/// of half-widths, each to be divided by the pixel's count.
struct NoiseForecast {
  explicit NoiseForecast(std::size_t width)
      : own(3 * width), expected(3 * width), half_width(3 * width) {}
  std::vector<double> own;         ///< by the pixel's own variance
  std::vector<double> expected;    ///< by what surrounds it
  std::vector<double> half_width;  ///< by what surrounds it
};

/// Square of the half-width of the 95 % interval, from two answers, averaged as squares. By the
/// variance around the pixel (`by_around`): what covers 95 % of the pixels with such surroundings;
/// a pixel that has seen none of its rare bright samples cannot fool it, but one unlike its
/// surroundings can. By the pixel's own mean square error: the other way round.
inline double half_width_square(double own_square, double by_around) {
  // A pixel much noisier than its surroundings keeps that share of what its own variance says.
  constexpr double alone = 0.8;
  const double by_own = normal_95 * normal_95 * own_square;
  return std::max((by_own + by_around) / 2, alone * by_own);
}

/// Half-widths of a row's values, `count` samples each.
void half_widths(std::span<const double> count, const NoiseForecast& forecast,
                 std::span<float> half_widths);

/// What the picture's replicates say about the errors of its pixels, by how noisy a pixel's own
/// samples and the pixels around it are. The half difference (A - B) / 2 of two replicates and the
/// error (A + B) / 2 - mu of their mean are alike but for the sign of a half: so a sampler that
/// does better than independent samples is measured, not assumed. Values are of one pixel and
/// channel; all are added before any is asked for.
class NoiseModel {
 public:
  /// Each pixel has at least 2 samples. Of large pictures rows are asked of some `asked` pixels.
  /// `horizon`: of the surroundings that it is going to be asked about.
  NoiseModel(const FramebufferView& state, NeighbourhoodSize horizon,
             std::size_t asked = std::size_t{1} << 17);

  /// Says it of a row; `forecast` is that of as many pixels.
  void foresee(const NoiseNearby& row, NoiseForecast& forecast) const;

 private:
  static constexpr std::size_t levels = 160;  ///< of variance, two to an octave; level 0: none
  static constexpr std::size_t ratios = 256;  ///< of |difference| / deviation, 16 to an octave
  static constexpr std::size_t kinds = 4;     ///< of surroundings, by ridge / mean
  static constexpr std::size_t places = kinds * levels;
  struct Around {
    std::array<std::uint32_t, ratios> found{};
    double values = 0;
    double squares = 0;    ///< sum, of differences times their counts
    double variances = 0;  ///< sum
  };
  struct Own {
    double values = 0;
    double differences = 0;  ///< sum of squares
    double variances = 0;    ///< sum, of means
  };

  /// What is found in some of the rows.
  struct Findings {
    std::vector<Around> around = std::vector<Around>(places);
    std::array<Own, levels> own{};
    double samples = 0;  ///< of all values
    // Level 0.
    double unseen_squares = 0;  ///< of differences, times count
    double unseen_values = 0;
    double unseen_samples = 0;

    Findings& operator+=(const Findings& other);
  };

  /// Of independent samples of variance 1, by what surrounds a pixel.
  struct Factors {
    double expected = 0;    ///< mean square error
    double half_width = 0;  ///< its square
  };

  void add(const NoiseNearby& row, Findings& findings) const;
  [[nodiscard]] std::size_t level_of(double variance) const;
  [[nodiscard]] std::size_t place_of(double variance, double ridge) const;
  /// Places whose findings one goes by; the first and the last have values, if any has.
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
