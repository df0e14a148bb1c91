#include "common/adaptive/noise_model.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace parray::adaptive {
namespace {

/// Weight of the surroundings, in samples, in a pixel's own mean square error. Two samples alone
/// say little.
constexpr double few = 4;
/// Number of values that a level needs. A level with fewer also uses values of adjacent levels.
constexpr double enough = 600;
/// Weight of the prior, a normal distribution, as a number of values.
constexpr double prior = 10;

/// Returns the position of a positive number on a logarithmic scale: 0 for 2^lowest, and 2^bits
/// parts per octave.
std::ptrdiff_t octave_part(double value, int bits, int lowest) {
  const auto pattern = std::bit_cast<std::uint64_t>(value);
  return static_cast<std::ptrdiff_t>(pattern >> (52 - bits)) -
         (static_cast<std::ptrdiff_t>(1023 + lowest) << bits);
}

/// Returns the smallest number of part `part`.
double part_begin(std::size_t part, int bits, int lowest) {
  const auto pattern = (static_cast<std::uint64_t>(1023 + lowest) << bits) + part;
  return std::bit_cast<double>(pattern << (52 - bits));
}

constexpr int level_bits = 1;
constexpr int lowest_level = -40;  ///< a deviation of 1e-6 of the largest radiance
constexpr int ratio_bits = 4;
constexpr int lowest_ratio = -10;

/// Returns the levels [first, last) around `level` that together have enough values, or all levels.
std::pair<std::size_t, std::size_t> enough_levels(std::size_t level, std::size_t end,
                                                  const auto& values_at) {
  std::size_t first = level;
  std::size_t last = level + 1;
  double values = values_at(level);
  while (values < enough && (first > 1 || last < end)) {
    if (first > 1) values += values_at(--first);
    if (last < end) values += values_at(last++);
  }
  return {first, last};
}

}  // namespace

void NoiseModel::Around::operator+=(const Around& other) {
  if (other.values == 0) return;
  for (std::size_t ratio = 0; ratio < ratios; ++ratio) found[ratio] += other.found[ratio];
  values += other.values;
  squares += other.squares;
  variances += other.variances;
}

void NoiseModel::Own::operator+=(const Own& other) {
  values += other.values;
  differences += other.differences;
  variances += other.variances;
}

void NoiseModel::Findings::operator+=(const Findings& other) {
  for (std::size_t i = 0; i < places; ++i) around[i] += other.around[i];
  for (std::size_t i = 0; i < levels; ++i) own[i] += other.own[i];
  samples += other.samples;
  unseen_squares += other.unseen_squares;
  unseen_values += other.unseen_values;
  unseen_samples += other.unseen_samples;
}

NoiseModel::NoiseModel(const FramebufferView& state, NeighbourhoodSize horizon, std::size_t asked)
    : unit_(state.largest_radiance * state.largest_radiance), per_unit_(1 / unit_) {
  const std::size_t stride = std::max<std::size_t>(1, state.pixels.size() / asked);
  const bool alone = noise_threads(stride) == 1;
  std::vector<Findings> bands(alone ? 1 : noise_bands(state.height));
  visit_noise(state, stride, horizon, [&](std::size_t band, auto, const NoiseNearby& row) {
    add(row, bands[alone ? 0 : band]);
  });
  for (const Findings& band : bands) found_ += band;
  Levels before;
  for (std::size_t place = 1; place < places; ++place) {
    const Levels found = levels_of(place);
    // Many levels have no values of their own and use the same adjacent levels.
    if (place > 1 && found == before) {
      around_factors_[place] = around_factors_[place - 1];
    } else {
      calibrate_around(place, found);
    }
    before = found;
  }
  for (std::size_t level = 1; level < levels; ++level) calibrate_own(level);
  // Level 0: the surroundings show no variance. Their variance is that of the pixels themselves
  // plus the rule of three: with 95 % confidence, at most 3 bright samples are expected among all
  // samples. The three channels of a sample count as one sample.
  const double seen = found_.unseen_values > 0 ? found_.unseen_squares / found_.unseen_values : 0;
  const double samples = found_.unseen_values > 0 ? found_.unseen_samples : found_.samples;
  unseen_variance_ = seen + (samples > 0 ? 3 * unit_ / (samples / 3) : unit_);
  around_factors_[0] = {1, normal_95 * normal_95};
}

inline std::size_t NoiseModel::level_of(double variance) const {
  const std::ptrdiff_t part = octave_part(variance * per_unit_, level_bits, lowest_level) + 1;
  return static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(part, 0, levels - 1));
}

inline std::size_t NoiseModel::place_of(double variance, double ridge) const {
  const std::size_t level = level_of(variance);
  // Without branches, because noise would make them unpredictable.
  const auto below = [ridge](double limit) { return std::size_t{ridge < limit ? 1U : 0U}; };
  const std::size_t kind = 3 - below(variance / 16) - below(variance / 4) - below(variance);
  return level == 0 ? 0 : kind * levels + level;
}

void NoiseModel::add(const NoiseNearby& row, Findings& findings) const {
  for (std::size_t i = 0; i < row.own.count.size(); ++i) {
    const double count = row.own.count[i];
    const double square = row.own.difference[i] * row.own.difference[i];
    const double variance = row.around.mean[i];
    Own& own = findings.own[level_of(row.own.variance[i])];
    own.values += 1;
    own.differences += square;
    own.variances += row.own.variance[i] / count;
    findings.samples += count;
    const std::size_t place = place_of(variance, row.around.ridge[i]);
    if (place == 0) {
      findings.unseen_squares += square * count;
      findings.unseen_values += 1;
      findings.unseen_samples += count;
      continue;
    }
    const double ratio = std::abs(row.own.difference[i]) / std::sqrt(variance / count);
    const std::ptrdiff_t part = octave_part(ratio, ratio_bits, lowest_ratio);
    Around& like = findings.around[place];
    ++like.found[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(part, 0, ratios - 1))];
    like.values += 1;
    like.squares += square * count;
    like.variances += variance;
  }
}

NoiseModel::Levels NoiseModel::levels_of(std::size_t place) const {
  const std::size_t begin = place / levels * levels;
  const Around* const kind = found_.around.data() + begin;
  auto [first, last] =
      enough_levels(place % levels, levels, [&](std::size_t i) { return kind[i].values; });
  while (first < last && kind[first].values == 0) ++first;
  while (first < last && kind[last - 1].values == 0) --last;
  return {begin + first, begin + last};
}

void NoiseModel::calibrate_around(std::size_t place, const Levels& borrowed) {
  Around sum;
  for (std::size_t i = borrowed.first; i < borrowed.last; ++i) sum += found_.around[i];
  const auto& [found, values, squares, variances] = sum;
  double rest = 0.95 * values;
  std::size_t ratio = 0;
  while (ratio + 1 < ratios && rest > found[ratio]) rest -= found[ratio++];
  const double begin = part_begin(ratio, ratio_bits, lowest_ratio);
  const double end = part_begin(ratio + 1, ratio_bits, lowest_ratio);
  const double share = found[ratio] > 0 ? rest / found[ratio] : 0;
  const double quantile = begin + (end - begin) * share;
  const double factor = (quantile * values + normal_95 * prior) / (values + prior);
  const double gain = variances > 0 ? squares / variances : 1;
  const double expected = (gain * values + prior) / (values + prior);
  // If nearly all differences are 0, the quantile is too small, and the mean square applies.
  around_factors_[place] = {expected, std::max(factor * factor, expected)};
}

void NoiseModel::calibrate_own(std::size_t level) {
  const auto [first, last] =
      enough_levels(level, levels, [&](std::size_t i) { return found_.own[i].values; });
  Own sum;
  for (std::size_t i = first; i < last; ++i) sum += found_.own[i];
  const double gain = sum.variances > 0 ? sum.differences / sum.variances : 1;
  own_factor_[level] = (gain * sum.values + prior) / (sum.values + prior);
}

void NoiseModel::predict(const NoiseNearby& row, NoiseForecast& forecast) const {
  for (std::size_t i = 0; i < forecast.own.size(); ++i) {
    const double variance = row.own.variance[i];
    forecast.own[i] = own_factor_[level_of(variance)] * variance;
    const std::size_t place = place_of(row.around.mean[i], row.around.ridge[i]);
    const double around = place == 0 ? unseen_variance_ : row.around.mean[i];
    forecast.expected[i] = around_factors_[place].expected * around;
    forecast.half_width[i] = around_factors_[place].half_width * around;
  }
}

void half_widths(std::span<const double> count, const NoiseForecast& forecast,
                 std::span<float> half_widths) {
  for (std::size_t i = 0; i < half_widths.size(); ++i) {
    const double own = (forecast.own[i] * count[i] + forecast.expected[i] * few) / (count[i] + few);
    half_widths[i] =
        static_cast<float>(std::sqrt(half_width_square(own, forecast.half_width[i]) / count[i]));
  }
}

}  // namespace parray::adaptive
