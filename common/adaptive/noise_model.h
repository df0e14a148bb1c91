#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/adaptive/pixel_noise.h"

namespace parray {

/// What the picture's replicates say about the errors of its pixels, by how noisy a pixel's own
/// samples and the pixels around it are. The half difference (A - B) / 2 of two replicates and the
/// error (A + B) / 2 - mu of their mean are alike but for the sign of a half: so a sampler that
/// does better than independent samples is measured, not assumed. Values are of one pixel and
/// channel; all are added before any is asked for.
class NoiseModel {
 public:
  /// Each pixel has at least 2 samples. Of large pictures every few rows are asked. `horizon`: of
  /// the surroundings that it is going to be asked about.
  NoiseModel(const FramebufferView& state, NeighbourhoodSize horizon);

  /// Half the width of the 95 % interval. Two answers, averaged as squares. By the variance around
  /// the pixel: what covers 95 % of the pixels with such surroundings; a pixel that has seen none
  /// of its rare bright samples cannot fool it, but one unlike its surroundings can. By the pixel's
  /// own variance: the other way round.
  [[nodiscard]] double half_width(double own_variance, const NeighbourhoodNoise& around,
                                  std::uint32_t count) const;

  // All of the following is to be divided by a pixel's count.
  /// Mean square error by what surrounds a pixel.
  [[nodiscard]] double expected_square(const NeighbourhoodNoise& around) const;
  /// Mean square error by the pixel's own variance.
  [[nodiscard]] double own_square(double own_variance) const;
  /// Square of the half-width of a pixel whose own variance means `own_square`.
  [[nodiscard]] double half_width_square(double own_square, const NeighbourhoodNoise& around) const;

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

  void add(double own_variance, const NeighbourhoodNoise& around, double difference,
           std::uint32_t count);
  [[nodiscard]] std::size_t level_of(double variance) const;
  [[nodiscard]] std::size_t place_of(const NeighbourhoodNoise& around) const;
  void calibrate_around(std::size_t place);
  void calibrate_own(std::size_t level);
  [[nodiscard]] double around_square(const NeighbourhoodNoise& around) const;

  double unit_;  ///< of variance: the largest radiance squared
  double per_unit_;
  std::vector<Around> around_;
  std::array<Own, levels> own_{};
  // For independent samples of variance 1: squares of half-widths, and mean square errors.
  std::array<double, places> around_factor_{};
  std::array<double, levels> own_factor_{};
  std::array<double, places> expected_factor_{};
  double samples_ = 0;  ///< of all values
  // Level 0.
  double unseen_squares_ = 0;  ///< of differences, times count
  double unseen_values_ = 0;
  double unseen_samples_ = 0;
  double unseen_variance_ = 0;
};

}  // namespace parray
