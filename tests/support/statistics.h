#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "tests/support/rooms.h"

namespace parray::test {

/// Returns how many standard deviations a mean of `count` values lies from its expectation.
inline double z_score(double sum, double count, double mean, double variance) {
  return (sum / count - mean) / std::sqrt(variance / count);
}

/// Returns Pearson's chi-square of counts against equal probabilities, as a standard normal number.
/// It is large if the counts are uneven. Source: Wilson and Hilferty, "The distribution of
/// chi-square", 1931.
inline double chi_square_z(const std::vector<double>& counts) {
  double total = 0;
  for (const double count : counts) total += count;
  const auto bins = static_cast<double>(counts.size());
  const double expected = total / bins;
  double chi_square = 0;
  for (const double count : counts) {
    chi_square += (count - expected) * (count - expected) / expected;
  }
  const double freedom = bins - 1;
  const double spread = 2 / (9 * freedom);
  return (std::cbrt(chi_square / freedom) - (1 - spread)) / std::sqrt(spread);
}

/// Bound of a statistical check. With fixed seeds and a thousand checks, a correct build passes all
/// of them with a probability of 0.999, so a failure should mean a bug.
inline constexpr double z_limit = 5;

/// Returns the bin of `value`, from 0 to 1, among `bins` equal bins.
inline std::size_t bin_of(double value, std::size_t bins) {
  const auto bin = static_cast<std::size_t>(value * static_cast<double>(bins));
  return bin < bins ? bin : bins - 1;
}

}  // namespace parray::test
