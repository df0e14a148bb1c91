#include "common/adaptive/allocation.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "common/adaptive/noise_model.h"
#include "common/adaptive/ordered_sums.h"
#include "common/adaptive/pixel_noise.h"

namespace parray::adaptive {
namespace {

/// Largest bias of a pixel, relative to its mean, that its own samples may cause. If a share s of a
/// pixel's count depends on its own variance, the bias is at most
/// s * third moment / (variance * count) <= s * largest radiance / count.
constexpr double bias_allowed = 0.001;

/// Largest square error of a sample, relative to the squared radiance, of a pixel without noise. A
/// slowly changing sky stays below this limit; hardly anything else does.
constexpr double quiet_share = 1e-4;

/// Computes the expected mean square errors of a row's values, times their counts.
void expect(const NoiseNearby& row, const NoiseForecast& forecast, double largest_radiance,
            std::span<double> squares) {
  // The model's forecast for such surroundings includes pixels that missed rare bright samples. The
  // more bright samples the surroundings have, the more this forecast counts.
  constexpr double much = 8;
  const bool windows = !row.around.seen.empty();
  const std::span<const double> radiances = windows ? row.around.radiance : row.own.mean;
  for (std::size_t i = 0; i < squares.size(); ++i) {
    const double mean = row.around.mean[i];
    const double seen = windows ? row.around.seen[i] / (row.around.seen[i] + much) : 1;
    const double trust = mean > 0 ? seen * seen : 1;
    const double expected = trust * forecast.expected[i] + (1 - trust) * mean;
    const double radiance = std::min(row.own.mean[i], radiances[i]);
    const double share =
        std::min(1.0, bias_allowed * radiance * row.own.count[i] / largest_radiance);
    squares[i] = (1 - share) * expected + share * forecast.own[i];
  }
}

}  // namespace

Allocation::Allocation(const FramebufferView& state, bool equal_half_widths, std::size_t stride) {
  const NeighbourhoodSize horizon =
      stride > 1 ? NeighbourhoodSize::neighbours : NeighbourhoodSize::windows;
  // Weights need less accuracy than stated errors, so a small part of the picture suffices.
  constexpr std::size_t asked = std::size_t{1} << 15;
  const NoiseModel model(state, horizon, std::min(asked, state.pixels.size() / stride));
  // The unit of squares. In this unit they fit the range of float for every scene.
  const double unit = state.largest_radiance * state.largest_radiance;
  const std::size_t bands = noise_bands(state.height);
  std::vector<NoiseForecast> forecasts(bands, NoiseForecast(state.width));
  std::vector<std::vector<double>> expected(bands,
                                            std::vector<double>(std::size_t{3} * state.width));
  const std::size_t size = (state.height + stride - 1) / stride * state.width;
  counts_.resize(size);
  weights_.resize(size);
  squares_.resize(size);
  quiet_.resize(size);
  visit_noise(state, stride, horizon, [&](std::size_t band, std::size_t y, const NoiseNearby& row) {
    NoiseForecast& forecast = forecasts[band];
    std::vector<double>& squares = expected[band];
    model.predict(row, forecast);
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
      counts_[i] = state.counts[y * state.width + x];
      weights_[i] = static_cast<float>(equal_half_widths ? most / unit : std::sqrt(sum / unit));
      squares_[i] = static_cast<float>(own / unit);
      quiet_[i] = own <= quiet_share * radiance * radiance ? 1 : 0;
    }
  });
}

double Allocation::square_error_at(double level) const {
  const SampleShares shares = this->shares();
  return ordered_sum<double>(shares.size(), [&](std::size_t begin, std::size_t end) {
    double square = 0;
    for (std::size_t i = begin; i < end; ++i) square += squares_[i] / shares.count_at(i, level);
    return square;
  });
}

double Allocation::level_for_square_error(double share) const {
  const double wanted = share * square_error_at(0);
  // The error is roughly inversely proportional to the level, so this iteration converges.
  double level = shares().level_for(shares().total_at(0) / share);
  for (int step = 0; step < 4; ++step) level *= square_error_at(level) / wanted;
  return level;
}

double Allocation::total_for_square_error(double share) const {
  return shares().total_at(level_for_square_error(share));
}

double Allocation::share_of_square_error(double total) const {
  const double now = square_error_at(0);
  return now > 0 ? square_error_at(shares().level_for(total)) / now : 1;
}

double Allocation::total_for_square_half_width(double share) const {
  // Finds the pixel with the 99th percentile of the half-widths.
  std::vector<double> levels(counts_.size());
  for (std::size_t i = 0; i < levels.size(); ++i) {
    levels[i] = weights_[i] > 0 ? counts_[i] / double{weights_[i]} : 0;
  }
  const auto worst = levels.begin() + static_cast<std::ptrdiff_t>(levels.size() / 100);
  std::nth_element(levels.begin(), worst, levels.end());
  return shares().total_at(*worst / share);
}

double Allocation::relative_cost(double share, double rays) const {
  if (!(square_error_at(0) > 0)) return 1;
  const SampleShares shares = this->shares();
  const auto size = static_cast<double>(shares.size());
  const auto quiet = static_cast<double>(std::ranges::count(quiet_, 1));
  const double noisy_rays =
      quiet < size ? std::max(1.0, (rays * size - quiet) / (size - quiet)) : 1;
  const double level = level_for_square_error(share);
  double placed = 0;
  double even = 0;
  for (std::size_t i = 0; i < shares.size(); ++i) {
    const double cost = quiet_[i] != 0 ? 1 : noisy_rays;
    placed += cost * (shares.count_at(i, level) - shares.count(i));
    even += cost * shares.count(i) * (1 / share - 1);
  }
  return placed / even;
}

}  // namespace parray::adaptive
