#include "common/adaptive/noise_model.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace parray {
namespace {

constexpr double normal_95 = 1.959964;  ///< half the width of a normal's 95 % interval
/// A pixel much noisier than its surroundings keeps that share of what its own variance says.
constexpr double alone = 0.8;
/// That many samples of the surroundings' are added to a pixel's own: two alone say little.
constexpr double few = 4;
/// Of that many pixels at least, a large picture is asked.
constexpr std::size_t sample_size = 1 << 17;
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

NoiseModel::NoiseModel(const FramebufferView& state, NeighbourhoodSize horizon)
    : unit_(state.largest_radiance * state.largest_radiance),
      per_unit_(1 / unit_),
      around_(places) {
  const std::size_t stride = std::max<std::size_t>(1, state.pixels.size() / sample_size);
  visit_noise(state, stride, horizon, [&](std::size_t i, const NoiseNearby& noise) {
    for (std::size_t channel = 0; channel < 3; ++channel) {
      add(noise.own.variance[channel], noise.around[channel], noise.own.difference[channel],
          state.counts[i]);
    }
  });
  for (std::size_t place = 1; place < places; ++place) {
    calibrate_around(place);
  }
  for (std::size_t level = 1; level < levels; ++level) {
    calibrate_own(level);
  }
  // Where no pixel around has seen anything: what the pixels themselves have, and what three
  // samples of all of them could still have hidden, 95 times of 100. Channels see the same things.
  const double seen = unseen_values_ > 0 ? unseen_squares_ / unseen_values_ : 0;
  const double samples = unseen_values_ > 0 ? unseen_samples_ : samples_;
  unseen_variance_ = seen + (samples > 0 ? 3 * unit_ / (samples / 3) : unit_);
}

std::size_t NoiseModel::level_of(double variance) const {
  const std::ptrdiff_t part = octave_part(variance * per_unit_, level_bits, lowest_level) + 1;
  return static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(part, 0, levels - 1));
}

std::size_t NoiseModel::place_of(const NeighbourhoodNoise& around) const {
  const std::size_t level = level_of(around.mean);
  const double ridge = around.ridge;
  const std::size_t kind = ridge < around.mean / 16  ? 0
                           : ridge < around.mean / 4 ? 1
                           : ridge < around.mean     ? 2
                                                     : 3;
  return level == 0 ? 0 : kind * levels + level;
}

void NoiseModel::add(double own_variance, const NeighbourhoodNoise& around, double difference,
                     std::uint32_t count) {
  Own& own = own_[level_of(own_variance)];
  own.values += 1;
  own.differences += difference * difference;
  own.variances += own_variance / count;
  samples_ += count;
  const std::size_t place = place_of(around);
  if (place == 0) {
    unseen_squares_ += difference * difference * count;
    unseen_values_ += 1;
    unseen_samples_ += count;
    return;
  }
  const double ratio = std::abs(difference) / std::sqrt(around.mean / count);
  const std::ptrdiff_t part = octave_part(ratio, ratio_bits, lowest_ratio);
  Around& like = around_[place];
  ++like.found[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(part, 0, ratios - 1))];
  like.values += 1;
  like.squares += difference * difference * count;
  like.variances += around.mean;
}

void NoiseModel::calibrate_around(std::size_t place) {
  const Around* const kind = around_.data() + place / levels * levels;
  const auto [first, last] =
      enough_levels(place % levels, levels, [&](std::size_t i) { return kind[i].values; });
  std::array<double, ratios> found{};
  double values = 0;
  double squares = 0;
  double variances = 0;
  for (std::size_t i = first; i < last; ++i) {
    if (kind[i].values == 0) {
      continue;
    }
    values += kind[i].values;
    squares += kind[i].squares;
    variances += kind[i].variances;
    for (std::size_t ratio = 0; ratio < ratios; ++ratio) {
      found[ratio] += kind[i].found[ratio];
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
  const double gain = variances > 0 ? squares / variances : 1;
  expected_factor_[place] = (gain * values + prior) / (values + prior);
  // Where nearly all differences are 0, the few that are not count.
  around_factor_[place] = std::max(factor * factor, expected_factor_[place]);
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
  own_factor_[level] = (gain * values + prior) / (values + prior);
}

double NoiseModel::half_width(double own_variance, const NeighbourhoodNoise& around,
                              std::uint32_t count) const {
  const double own =
      (own_square(own_variance) * count + expected_square(around) * few) / (count + few);
  return std::sqrt(half_width_square(own, around) / count);
}

double NoiseModel::half_width_square(double own_square, const NeighbourhoodNoise& around) const {
  const double by_own = normal_95 * normal_95 * own_square;
  const double by_around = around_square(around);
  return std::max((by_own + by_around) / 2, alone * by_own);
}

double NoiseModel::own_square(double own_variance) const {
  return own_factor_[level_of(own_variance)] * own_variance;
}

double NoiseModel::around_square(const NeighbourhoodNoise& around) const {
  const std::size_t place = place_of(around);
  return place == 0 ? normal_95 * normal_95 * unseen_variance_
                    : around_factor_[place] * around.mean;
}

double NoiseModel::expected_square(const NeighbourhoodNoise& around) const {
  const std::size_t place = place_of(around);
  return place == 0 ? unseen_variance_ : expected_factor_[place] * around.mean;
}

}  // namespace parray
