#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "tests/support/noise_trials.h"
#include "tests/support/rooms.h"

namespace parray::test {

/// Approximates a picture with infinitely many samples. One value per pixel and channel.
struct Reference {
  std::vector<double> mean;
  std::vector<double> variance;  ///< variance of one sample
  double samples = 0;            ///< samples per pixel
};

/// Traces a reference from independent samples with a separate seed.
Reference trace_reference(const NoisyScene& scene, std::uint32_t samples);

/// Returns the picture's RMSE, from the difference to the reference. Subtracts the reference's own
/// error.
double true_rmse(const GrowingPicture& picture, const Reference& reference);

/// Counts how often the errors that pictures state are right, over many pictures of some scenes.
class Coverage {
 public:
  /// Sorts the pixels and channels of all scenes into strata, four by mean and five by variance.
  explicit Coverage(const std::vector<Reference>& references);

  void add(std::size_t scene, const GrowingPicture& picture, const ErrorEstimate& error);

  [[nodiscard]] std::size_t stratum_of(std::size_t scene, std::size_t value) const {
    return stratum_of_[scene][value];
  }
  [[nodiscard]] double pooled() const;           ///< share of intervals that hold
  [[nodiscard]] double least_of_strata() const;  ///< the same in the worst stratum
  [[nodiscard]] double pictures() const;         ///< share of [low, high] that hold
  [[nodiscard]] double claimed_to_true() const;  ///< ratio of the root mean squares
  struct Bias {
    double value = 0;      ///< mean error / mean
    double scatter = 0;    ///< standard error of `value`
    double allowance = 0;  ///< mean error / mean half-width
  };
  static constexpr std::size_t strata = 20;
  [[nodiscard]] Bias bias(std::size_t at) const;
  [[nodiscard]] double of_stratum(std::size_t stratum) const;

 private:
  struct Stratum {
    double intervals = 0;
    double hold = 0;
    double mean = 0;
    double half_width = 0;
    double pictures = 0;
    double error = 0;
    double squares = 0;  ///< sum of squared errors of pictures' means over the stratum
  };

  const std::vector<Reference>& references_;
  std::vector<std::vector<std::uint8_t>> stratum_of_;
  std::array<Stratum, strata> strata_{};
  double pictures_ = 0;
  double pictures_hold_ = 0;
  double claimed_ = 0;
  double true_ = 0;
};

}  // namespace parray::test
