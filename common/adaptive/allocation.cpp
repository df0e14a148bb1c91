#include "common/adaptive/allocation.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "common/adaptive/noise_model.h"
#include "common/adaptive/pixel_noise.h"

namespace parray {
namespace {

/// Bias that a pixel's own luck may bring, of its mean. If the pixel's count follows its own
/// variance to a share s, the bias is up to s * third moment / (variance * count) <= s * largest /
/// count.
constexpr double bias_allowed = 0.001;

/// Square error of a sample, over that of the radiance, that a slowly changing sky has within a
/// pixel and hardly anything else.
constexpr double quiet_share = 1e-4;

/// Mean square errors expected of a row's values, times their counts.
void expect(const NoiseNearby& row, const NoiseForecast& forecast, double largest_radiance,
            std::span<double> squares) {
  // What the model has learnt of pixels with such surroundings knows of their luck, too: it counts
  // for as much as has been seen there.
  constexpr double much = 8;
  for (std::size_t i = 0; i < squares.size(); ++i) {
    const double mean = row.around.mean[i];
    const double seen = row.around.seen[i] / (row.around.seen[i] + much);
    const double trust = mean > 0 ? seen * seen : 1;
    const double expected = trust * forecast.expected[i] + (1 - trust) * mean;
    const double own_radiance = row.own.mean[i];
    const double radiance_around = row.around.radiance[i];
    const double radiance = std::min(own_radiance, radiance_around);
    const double share =
        std::min(1.0, bias_allowed * radiance * row.own.count[i] / largest_radiance);
    squares[i] = (1 - share) * expected + share * forecast.own[i];
  }
}

/// The shares of `state`'s rows, and what else an Allocation keeps of them.
SampleShares shares_of(const FramebufferView& state, bool equal_half_widths, std::size_t stride,
                       std::vector<double>& own_squares, std::vector<char>& quiet) {
  constexpr NeighbourhoodSize horizon = NeighbourhoodSize::windows;
  const NoiseModel model = stride > 1 ? NoiseModel(state, horizon, state.pixels.size() / stride)
                                      : NoiseModel(state, horizon);
  const std::size_t bands = noise_bands(state.height);
  std::vector<NoiseForecast> forecasts(bands, NoiseForecast(state.width));
  std::vector<std::vector<double>> expected(bands,
                                            std::vector<double>(std::size_t{3} * state.width));
  const std::size_t size = (state.height + stride - 1) / stride * state.width;
  std::vector<std::uint32_t> counts(size);
  std::vector<double> weights(size);
  own_squares.resize(size);
  quiet.resize(size);
  visit_noise(state, stride, horizon, [&](std::size_t band, std::size_t y, const NoiseNearby& row) {
    NoiseForecast& forecast = forecasts[band];
    std::vector<double>& squares = expected[band];
    model.foresee(row, forecast);
    expect(row, forecast, state.largest_radiance, squares);
    for (std::size_t x = 0; x < state.width; ++x) {
      double most = 0;
      double sum = 0;
      double own = 0;
      double radiance = 0;
      for (std::size_t value = 3 * x; value < 3 * x + 3; ++value) {
        most = std::max(most, half_width_square(squares[value], forecast.half_width[value]));
        sum += squares[value];
        own += forecast.own[value];
        radiance += row.own.mean[value];
      }
      const std::size_t i = y / stride * state.width + x;
      counts[i] = state.counts[y * state.width + x];
      weights[i] = equal_half_widths ? most : std::sqrt(sum);
      own_squares[i] = own;
      quiet[i] = own <= quiet_share * radiance * radiance ? 1 : 0;
    }
  });
  return {std::move(counts), std::move(weights)};
}

}  // namespace

Allocation::Allocation(const FramebufferView& state, bool equal_half_widths, std::size_t stride)
    : shares_(shares_of(state, equal_half_widths, stride, squares_, quiet_)) {}

double Allocation::square_error_at(double level) const {
  double square = 0;
  for (std::size_t i = 0; i < squares_.size(); ++i) {
    square += squares_[i] / shares_.count_at(i, level);
  }
  return square;
}

double Allocation::level_for_square_error(double share) const {
  const double wanted = share * square_error_at(0);
  // The error at a level falls about as fast as the level rises.
  double level = shares_.level_for(shares_.total_at(0) / share);
  for (int step = 0; step < 4; ++step) {
    level *= square_error_at(level) / wanted;
  }
  return level;
}

double Allocation::total_for_square_error(double share) const {
  return shares_.total_at(level_for_square_error(share));
}

double Allocation::share_of_square_error(double total) const {
  const double now = square_error_at(0);
  return now > 0 ? square_error_at(shares_.level_for(total)) / now : 1;
}

double Allocation::total_for_square_half_width(double share) const {
  // The pixel whose half-width 99 % of the pixels keep below.
  std::vector<double> levels(shares_.size());
  for (std::size_t i = 0; i < levels.size(); ++i) {
    levels[i] = shares_.weight(i) > 0 ? shares_.count(i) / shares_.weight(i) : 0;
  }
  const auto worst = levels.begin() + static_cast<std::ptrdiff_t>(levels.size() / 100);
  std::nth_element(levels.begin(), worst, levels.end());
  return shares_.total_at(*worst / share);
}

double Allocation::relative_cost(double share, double rays) const {
  if (!(square_error_at(0) > 0)) {
    return 1;
  }
  const auto size = static_cast<double>(shares_.size());
  const auto quiet = static_cast<double>(std::count(quiet_.begin(), quiet_.end(), 1));
  const double noisy_rays =
      quiet < size ? std::max(1.0, (rays * size - quiet) / (size - quiet)) : 1;
  const double level = level_for_square_error(share);
  double placed = 0;
  double even = 0;
  for (std::size_t i = 0; i < shares_.size(); ++i) {
    const double cost = quiet_[i] != 0 ? 1 : noisy_rays;
    placed += cost * (shares_.count_at(i, level) - shares_.count(i));
    even += cost * shares_.count(i) * (1 / share - 1);
  }
  return placed / even;
}

bool adaptive_pays(const FramebufferView& state) {
  constexpr std::size_t asked = 1 << 14;  // pixels
  constexpr double well = 0.9;
  const std::size_t stride = std::max<std::size_t>(1, state.pixels.size() / asked);
  return Allocation(state, false, stride).relative_cost(0.5, state.rays_per_sample) < well;
}

}  // namespace parray
