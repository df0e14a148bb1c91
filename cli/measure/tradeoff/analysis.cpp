#include "cli/measure/tradeoff/analysis.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "common/adaptive/pixel_noise.h"

namespace parray::tradeoff {
namespace {

/// Half differences of replicates, and sums for the variance of the mean square.
struct Differences {
  std::vector<double> value;   ///< 3 per pixel, row by row
  double squares = 0;          ///< sum of squares
  double variances = 0;        ///< sum of the variances of means
  double by_own_variance = 0;  ///< sum over pixels of square times variance, channels added up
};

Differences differences_of(const FramebufferView& state) {
  Differences all;
  all.value.reserve(3 * state.pixels.size());
  NoiseRows rows(state, NeighbourhoodSize::neighbours);
  for (std::size_t y = 0; y < state.height; ++y) {
    const NoiseRow row = rows.own(y);
    for (std::size_t i = 0; i < row.count.size(); i += 3) {
      double square = 0;
      double variance = 0;
      for (std::size_t value = i; value < i + 3; ++value) {
        all.value.push_back(row.difference[value]);
        square += row.difference[value] * row.difference[value];
        variance += row.variance[value] / row.count[i];
      }
      all.squares += square;
      all.variances += variance;
      all.by_own_variance += square * variance;
    }
  }
  return all;
}

/// Means over all pairs of adjacent pixels, horizontally and vertically. Their noise is
/// independent; only the covariance of channels is similar.
struct Neighbours {
  double products = 0;    ///< squared scalar product of their differences
  double magnitudes = 0;  ///< product of the squared lengths of their differences
};

Neighbours neighbours_of(const std::vector<double>& difference, std::size_t width,
                         std::size_t height) {
  Neighbours sum;
  double pairs = 0;
  const auto product_of = [&](std::size_t pixel, std::size_t other) {
    double product = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      product += difference[3 * pixel + c] * difference[3 * other + c];
    }
    return product;
  };
  const auto add = [&](std::size_t pixel, std::size_t other) {
    const double product = product_of(pixel, other);
    sum.products += product * product;
    sum.magnitudes += product_of(pixel, pixel) * product_of(other, other);
    pairs += 1;
  };
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x) {
      const std::size_t pixel = y * width + x;
      if (x + 1 < width) add(pixel, pixel + 1);
      if (y + 1 < height) add(pixel, pixel + width);
    }
  }
  if (pairs == 0) return sum;
  return {sum.products / pairs, sum.magnitudes / pairs};
}

/// Returns the variance of the mean square error, divided by its square.
double relative_variance(const Differences& all, std::size_t width, std::size_t height) {
  if (!(all.squares > 0)) return 0;
  const Neighbours near = neighbours_of(all.value, width, height);
  const double alike = near.magnitudes > 0 ? near.products / near.magnitudes : 1;
  const double high = all.by_own_variance * all.squares / all.variances * alike;
  const double low = near.products * static_cast<double>(width * height);
  return 4 * std::sqrt(low * high) / (all.squares * all.squares);
}

double root(double square) { return square > 0 ? std::sqrt(square) : 0; }

double mean_of(const std::vector<const Run*>& runs, double Run::*member) {
  double sum = 0;
  for (const Run* run : runs) sum += run->*member;
  return sum / static_cast<double>(runs.size());
}

double deviation_of(const std::vector<double>& values) {
  if (values.size() < 2) return 0;
  double mean = 0;
  for (const double value : values) mean += value / static_cast<double>(values.size());
  double squares = 0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return std::sqrt(squares / static_cast<double>(values.size() - 1));
}

std::vector<double> values_of(const std::vector<const Run*>& runs, const auto& function) {
  std::vector<double> values;
  values.reserve(runs.size());
  for (const Run* run : runs) values.push_back(std::invoke(function, *run));
  return values;
}

/// Adds `share` of a run's values to the mean.
void add_share(const ByLevel& of_run, double share, ByLevel& mean) {
  for (std::size_t i = 0; i < mean.size(); ++i) mean.at(i) += of_run.at(i) * share;
}

}  // namespace

ErrorIntervals::ErrorIntervals(const FramebufferView& state, const ErrorEstimate& error) {
  const Differences all = differences_of(state);
  std::vector<double> ratios;
  for (std::size_t i = 0; i < all.value.size(); ++i) {
    if (all.value[i] != 0) ratios.push_back(std::abs(all.value[i]) / error.half_width[i]);
  }
  const double deviation = std::sqrt(relative_variance(all, state.width, state.height));
  for (std::size_t level = 0; level < interval_levels.size(); ++level) {
    const double normal = normal_half_widths[level] / normal_half_widths[stated_level];
    scales_[level] = normal;
    rmse_[level] = {error.rmse - normal * (error.rmse - error.low),
                    error.rmse + normal * (error.high - error.rmse)};
    if (level >= stated_level) continue;
    if (!ratios.empty()) {
      const auto rank = static_cast<std::ptrdiff_t>(interval_levels[level] *
                                                    static_cast<double>(ratios.size() - 1));
      std::nth_element(ratios.begin(), ratios.begin() + rank, ratios.end());
      scales_[level] = ratios[static_cast<std::size_t>(rank)];
    }
    // Approximately e^relative, as in the stated interval.
    const double relative = normal_half_widths[level] * deviation;
    const double factor = std::sqrt(1 + relative + relative * relative / 2);
    rmse_[level] = {error.rmse / factor, error.rmse * factor};
  }
}

bool claim_holds(const Run& run, double low, double high, std::size_t level) {
  const double square = run.claimed * run.claimed;
  const double doubt = normal_half_widths.at(level) * run.mse_scatter;
  const double error = run.mse - square;
  return error >= -std::hypot(square - low * low, doubt) &&
         error <= std::hypot(high * high - square, doubt);
}

double PairedBias::rms() const { return square > 2 * scatter ? root(square) : 0; }

double Budget::predicted() const {
  return std::sqrt(monte_carlo * monte_carlo + depth * depth + precision * precision);
}

double Budget::predicted_8bit() const { return std::hypot(predicted(), quantisation); }

Quartiles quartiles_of(std::vector<double> values) {
  std::ranges::sort(values);
  const auto at = [&](double share) {
    const double rank = share * static_cast<double>(values.size() - 1);
    const auto below = static_cast<std::size_t>(rank);
    const std::size_t above = std::min(below + 1, values.size() - 1);
    return values[below] + (rank - static_cast<double>(below)) * (values[above] - values[below]);
  };
  return {at(0.25), at(0.5), at(0.75)};
}

Timing timing_of(const std::vector<Run>& runs, int threads) {
  double wall = 0;
  double cpu = 0;
  for (const Run& run : runs) {
    wall += run.seconds;
    cpu += run.cpu_seconds;
  }
  return {cpu < 0.85 * wall * threads, threads};
}

Row row_of(const Variant& variant, const std::vector<const Run*>& runs, const Timing& timing) {
  Row row;
  row.varied = variant.varied;
  row.settings = variant.settings;
  row.options = options_of(variant.settings);
  row.runs = runs.size();
  row.seconds =
      quartiles_of(values_of(runs, [&](const Run& run) { return timing.seconds_of(run); }));
  row.cpu_seconds = quartiles_of(values_of(runs, &Run::cpu_seconds)).median;
  row.samples = mean_of(runs, &Run::samples);
  row.rays = mean_of(runs, &Run::rays);
  row.mse = mean_of(runs, &Run::mse);
  row.mse_deviation = deviation_of(values_of(runs, &Run::mse));
  row.rmse = root(row.mse);
  row.rmse_deviation = deviation_of(values_of(runs, [](const Run& run) { return root(run.mse); }));
  row.rmse_8bit = root(mean_of(runs, &Run::mse_8bit));
  row.mse_scatter = mean_of(runs, &Run::mse_scatter);
  row.passes = mean_of(runs, &Run::passes);
  double denoise = 0;  // sum of shares of the time
  for (const Run* run : runs) denoise += run->seconds > 0 ? run->denoise_seconds / run->seconds : 0;
  row.denoise_seconds = row.seconds.median * denoise / static_cast<double>(runs.size());
  row.bias = mean_of(runs, &Run::bias);
  row.truncation = mean_of(runs, &Run::truncation);
  double claimed = 0;
  for (const Run* run : runs) {
    const auto share = 1 / static_cast<double>(runs.size());
    claimed += run->claimed * run->claimed * share;
    add_share(run->claims, share, row.claims);
    add_share(run->coverage, share, row.coverage);
  }
  row.claimed = std::sqrt(claimed);
  row.budget.monte_carlo = row.claimed;
  row.budget.quantisation = root(mean_of(runs, &Run::quantisation));
  return row;
}

std::vector<std::size_t> dominators_of(const std::vector<CostAndError>& points) {
  constexpr double as_accurate = 1.001;
  const auto dominates = [](const CostAndError& a, const CostAndError& b) {
    return a.seconds <= b.seconds && a.rmse <= b.rmse * as_accurate &&
           (a.seconds < b.seconds || a.rmse * as_accurate < b.rmse);
  };
  std::vector<std::size_t> fastest(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    fastest[i] = i;
    for (std::size_t other = 0; other < points.size(); ++other) {
      if (dominates(points[other], points[i]) &&
          (fastest[i] == i || points[other].seconds < points[fastest[i]].seconds)) {
        fastest[i] = other;
      }
    }
  }
  return fastest;
}

void mark_front(std::vector<Row>& rows) {
  std::vector<Row*> known;
  std::vector<CostAndError> points;
  for (Row& row : rows) {
    row.on_front = false;
    row.dominated_by.clear();
    if (!(row.rmse > 0)) continue;
    known.push_back(&row);
    points.push_back({row.seconds.median, row.rmse});
  }
  const std::vector<std::size_t> dominators = dominators_of(points);
  for (std::size_t i = 0; i < known.size(); ++i) {
    known[i]->on_front = dominators[i] == i;
    if (!known[i]->on_front) known[i]->dominated_by = known[dominators[i]]->options;
  }
}

double PowerLaw::at(double x) const { return std::exp(intercept + slope * std::log(x)); }

std::optional<PowerLaw> fit_power_law(const std::vector<std::pair<double, double>>& points) {
  const auto count = static_cast<double>(points.size());
  double mean_x = 0;
  double mean_y = 0;
  for (const auto& [x, y] : points) {
    if (!(x > 0) || !(y > 0)) return std::nullopt;
    mean_x += std::log(x) / count;
    mean_y += std::log(y) / count;
  }
  double xx = 0;
  double xy = 0;
  double yy = 0;
  for (const auto& [x, y] : points) {
    const double dx = std::log(x) - mean_x;
    const double dy = std::log(y) - mean_y;
    xx += dx * dx;
    xy += dx * dy;
    yy += dy * dy;
  }
  if (points.size() < 2 || !(xx > 0)) return std::nullopt;
  PowerLaw law;
  law.slope = xy / xx;
  law.intercept = mean_y - law.slope * mean_x;
  const double rest = std::max(yy - law.slope * xy, 0.0);
  law.slope_error = points.size() > 2 ? std::sqrt(rest / (count - 2) / xx) : 0;
  return law;
}

LogCurve::LogCurve(const std::vector<std::pair<double, double>>& points, double slope) {
  std::map<double, double> logarithms;
  for (const auto& [x, y] : points) {
    if (x > 0 && y > 0) logarithms[std::log(x)] = std::log(y);
  }
  points_.assign(logarithms.begin(), logarithms.end());
  if (points_.size() == 1 && slope != 0) {
    points_.emplace_back(points_[0].first + 1, points_[0].second + slope);
  }
}

double LogCurve::at(double x) const {
  const double at = std::log(x);
  const auto after =
      std::upper_bound(points_.begin() + 1, points_.end() - 1, std::pair{at, 0.0},
                       [](const auto& a, const auto& b) { return a.first < b.first; });
  const auto [x1, y1] = *after;
  const auto [x0, y0] = *(after - 1);
  return std::exp(y0 + (at - x0) / (x1 - x0) * (y1 - y0));
}

}  // namespace parray::tradeoff
