#include "common/image/noise_model.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace parray {
namespace {

constexpr double normal_95 = 1.959964;  ///< half the width of a normal's 95 % interval
/// A level with fewer values borrows from the levels next to it.
constexpr double enough = 600;
/// That many values of a normal's are added to those found.
constexpr double prior = 10;

/// The octave of a positive number, in parts of 2^-`bits`, from 0 for 2^lowest.
std::ptrdiff_t octave_part(double value, int bits, int lowest) {
  const auto pattern = std::bit_cast<std::uint64_t>(value);
  return static_cast<std::ptrdiff_t>(pattern >> (52 - bits)) -
         (static_cast<std::ptrdiff_t>(1023 + lowest) << bits);
}

/// Where part number `part` begins.
double part_begin(std::size_t part, int bits, int lowest) {
  const auto pattern = (static_cast<std::uint64_t>(1023 + lowest) << bits) + part;
  return std::bit_cast<double>(pattern << (52 - bits));
}

constexpr int level_bits = 1;
constexpr int lowest_level = -40;  ///< a deviation of 1e-6 of the largest radiance
constexpr int ratio_bits = 4;
constexpr int lowest_ratio = -10;

/// Levels [first, last) next to `level` that have enough values, or all.
template <typename ValuesAt>
std::pair<std::size_t, std::size_t> enough_levels(std::size_t level, std::size_t end,
                                                  const ValuesAt& values_at) {
  std::size_t first = level;
  std::size_t last = level + 1;
  double values = values_at(level);
  while (values < enough && (first > 1 || last < end)) {
    if (first > 1) {
      values += values_at(--first);
    }
    if (last < end) {
      values += values_at(last++);
    }
  }
  return {first, last};
}

}  // namespace

NoiseModel::NoiseModel(double largest) : unit_(largest * largest), around_(levels) {}

std::size_t NoiseModel::level_of(double variance) const {
  const std::ptrdiff_t part = octave_part(variance / unit_, level_bits, lowest_level) + 1;
  return static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(part, 0, levels - 1));
}

void NoiseModel::add(double own_variance, double variance_around, double difference,
                     std::uint32_t count) {
  Own& own = own_[level_of(own_variance)];
  own.values += 1;
  own.differences += difference * difference;
  own.variances += own_variance / count;
  const std::size_t level = level_of(variance_around);
  if (level == 0) {
    unseen_squares_ += difference * difference * count;
    unseen_values_ += 1;
    unseen_samples_ += count;
    return;
  }
  const double ratio = std::abs(difference) / std::sqrt(variance_around / count);
  const std::ptrdiff_t part = octave_part(ratio, ratio_bits, lowest_ratio);
  Around& around = around_[level];
  ++around.found[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(part, 0, ratios - 1))];
  around.values += 1;
  around.squares += difference * difference * count;
  around.variances += variance_around;
}

void NoiseModel::calibrate() {
  for (std::size_t level = 1; level < levels; ++level) {
    calibrate_around(level);
    calibrate_own(level);
  }
  // Where no pixel around has seen anything: what the pixels themselves have, and what three
  // samples of all of them could still have hidden, 95 times of 100.
  unseen_variance_ =
      unseen_values_ > 0 ? unseen_squares_ / unseen_values_ + 3 * unit_ / unseen_samples_ : 0;
}

void NoiseModel::calibrate_around(std::size_t level) {
  const auto [first, last] =
      enough_levels(level, levels, [&](std::size_t i) { return around_[i].values; });
  std::array<double, ratios> found{};
  double values = 0;
  double squares = 0;
  double variances = 0;
  for (std::size_t i = first; i < last; ++i) {
    values += around_[i].values;
    squares += around_[i].squares;
    variances += around_[i].variances;
    for (std::size_t ratio = 0; ratio < ratios; ++ratio) {
      found[ratio] += around_[i].found[ratio];
    }
  }
  double rest = 0.95 * values;
  std::size_t ratio = 0;
  while (ratio + 1 < ratios && rest > found[ratio]) {
    rest -= found[ratio++];
  }
  const double begin = part_begin(ratio, ratio_bits, lowest_ratio);
  const double end = part_begin(ratio + 1, ratio_bits, lowest_ratio);
  const double share = found[ratio] > 0 ? rest / found[ratio] : 0;
  const double quantile = begin + (end - begin) * share;
  const double factor = (quantile * values + normal_95 * prior) / (values + prior);
  around_factor_[level] = factor * factor;
  const double gain = variances > 0 ? squares / variances : 1;
  expected_factor_[level] = (gain * values + prior) / (values + prior);
}

void NoiseModel::calibrate_own(std::size_t level) {
  const auto [first, last] =
      enough_levels(level, levels, [&](std::size_t i) { return own_[i].values; });
  double differences = 0;
  double variances = 0;
  double values = 0;
  for (std::size_t i = first; i < last; ++i) {
    differences += own_[i].differences;
    variances += own_[i].variances;
    values += own_[i].values;
  }
  const double gain = variances > 0 ? differences / variances : 1;
  own_factor_[level] = normal_95 * normal_95 * (gain * values + prior) / (values + prior);
}

double NoiseModel::half_width(double own_variance, double variance_around,
                              std::uint32_t count) const {
  const double own = own_factor_[level_of(own_variance)] * own_variance;
  return std::sqrt((own + around_square(variance_around)) / 2 / count);
}

double NoiseModel::around_square(double variance_around) const {
  const std::size_t level = level_of(variance_around);
  return level == 0 ? normal_95 * normal_95 * unseen_variance_
                    : around_factor_[level] * variance_around;
}

double NoiseModel::expected_square(double variance_around) const {
  const std::size_t level = level_of(variance_around);
  return level == 0 ? unseen_variance_ : expected_factor_[level] * variance_around;
}

double NoiseModel::expected_half_width_square(double variance_around) const {
  const double own = normal_95 * normal_95 * expected_square(variance_around);
  return (own + around_square(variance_around)) / 2;
}

}  // namespace parray
