#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace parray {

/// Half-widths of 95 % intervals, calibrated by the picture itself: how far replicates of pixels
/// with such variances lie apart says how far a mean lies from the truth, because (A - B) / 2 and
/// the error (A + B) / 2 - mu are alike but for the sign of a half. So a sampler that does better
/// than independent samples is measured, not assumed. Values are of one pixel and channel.
///
/// Two answers, averaged as squares. By the variance around the pixel: a share of 95 % of the
/// pixels with such surroundings; a pixel that has seen none of its rare bright samples cannot fool
/// it, but one unlike its surroundings can. By the pixel's own variance: the other way round.
class HalfWidths {
 public:
  /// `largest`: the largest radiance of a sample.
  explicit HalfWidths(double largest);

  /// All values are added before any is asked for. `count` >= 2.
  void add(double own_variance, double variance_around, double difference, std::uint32_t count);
  void calibrate();

  [[nodiscard]] double of(double own_variance, double variance_around, std::uint32_t count) const;

 private:
  static constexpr std::size_t levels = 160;  ///< of variance, two to an octave; level 0: none
  static constexpr std::size_t ratios = 256;  ///< of |difference| / deviation, 16 to an octave
  struct Around {
    std::array<std::uint32_t, ratios> found{};
    double values = 0;
  };
  struct Own {
    double values = 0;
    double differences = 0;  ///< sum of squares
    double variances = 0;    ///< sum, of means
  };

  [[nodiscard]] std::size_t level_of(double variance) const;

  double unit_;  ///< of variance: largest^2
  std::vector<Around> around_;
  std::array<Own, levels> own_{};
  std::array<double, levels> around_factor_{};  ///< half-width / deviation of the mean
  std::array<double, levels> own_factor_{};
  // Level 0.
  double unseen_squares_ = 0;  ///< of differences, times count
  double unseen_values_ = 0;
  double unseen_samples_ = 0;
  double unseen_variance_ = 0;
};

}  // namespace parray
