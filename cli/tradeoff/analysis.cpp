#include "cli/tradeoff/analysis.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace parray::tradeoff {
namespace {

double root(double square) { return square > 0 ? std::sqrt(square) : 0; }

template <typename Value>
double mean_of(const std::vector<const Run*>& runs, Value Run::*member) {
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

template <typename Function>
std::vector<double> values_of(const std::vector<const Run*>& runs, const Function& function) {
  std::vector<double> values;
  values.reserve(runs.size());
  for (const Run* run : runs) values.push_back(function(*run));
  return values;
}

/// The stated interval, wider by what the reference does not know.
bool claim_holds(const Run& run) {
  const double square = run.claimed * run.claimed;
  const double doubt = normal_quantile[3] * run.mse_scatter;
  const double error = run.mse - square;
  return error >= -std::hypot(square - run.low * run.low, doubt) &&
         error <= std::hypot(run.high * run.high - square, doubt);
}

}  // namespace

double PairedBias::rms() const { return square > 2 * scatter ? root(square) : 0; }

double Budget::predicted() const {
  return std::sqrt(monte_carlo * monte_carlo + depth * depth + precision * precision);
}

double Budget::predicted_8bit() const { return std::hypot(predicted(), quantisation); }

Quartiles quartiles_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
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
  row.knob = variant.knob;
  row.settings = variant.settings;
  row.options = options_of(variant.settings);
  row.runs = runs.size();
  row.seconds =
      quartiles_of(values_of(runs, [&](const Run& run) { return timing.seconds_of(run); }));
  row.cpu_seconds =
      quartiles_of(values_of(runs, [](const Run& run) { return run.cpu_seconds; })).median;
  row.samples = mean_of(runs, &Run::samples);
  row.rays = mean_of(runs, &Run::rays);
  row.mse = mean_of(runs, &Run::mse);
  row.mse_deviation = deviation_of(values_of(runs, [](const Run& run) { return run.mse; }));
  row.rmse = root(row.mse);
  row.rmse_deviation = deviation_of(values_of(runs, [](const Run& run) { return root(run.mse); }));
  row.rmse_8bit = root(mean_of(runs, &Run::mse_8bit));
  row.mse_scatter = mean_of(runs, &Run::mse_scatter);
  row.bias = mean_of(runs, &Run::bias);
  row.truncation = mean_of(runs, &Run::truncation);
  double claimed = 0;
  for (const Run* run : runs) {
    const auto share = 1 / static_cast<double>(runs.size());
    claimed += run->claimed * run->claimed * share;
    row.claims_held += claim_holds(*run) ? share : 0;
    for (std::size_t i = 0; i < row.coverage.size(); ++i) {
      row.coverage[i] += run->coverage[i] * share;
    }
  }
  row.claimed = std::sqrt(claimed);
  row.budget.monte_carlo = row.claimed;
  row.budget.quantisation = root(mean_of(runs, &Run::quantisation));
  return row;
}

void mark_front(std::vector<Row>& rows) {
  constexpr double as_accurate = 1.001;
  const auto dominates = [](const Row& a, const Row& b) {
    return a.seconds.median <= b.seconds.median && a.rmse <= b.rmse * as_accurate &&
           (a.seconds.median < b.seconds.median || a.rmse * as_accurate < b.rmse);
  };
  for (Row& row : rows) {
    const Row* fastest = nullptr;
    for (const Row& other : rows) {
      if (dominates(other, row) &&
          (fastest == nullptr || other.seconds.median < fastest->seconds.median)) {
        fastest = &other;
      }
    }
    row.on_front = fastest == nullptr;
    row.dominated_by = fastest == nullptr ? "" : fastest->options;
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
