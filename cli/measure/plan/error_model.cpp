#include "cli/measure/plan/error_model.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/adaptive/allocation.h"

namespace parray::plan {
namespace {

/// Relative uncertainty of a law per octave of distance from the largest measured number of
/// samples.
constexpr double doubt_per_octave = 0.03;
constexpr double least_relative = 0.005;

constexpr double unit = 1 << 20;  ///< passes count samples per pixel in units of 1 / unit

constexpr double search_begin = -7;  ///< limits of every search: logarithms of samples
constexpr double search_end = 60;

/// Returns the number of samples at which a falling function has the value `wanted`.
double samples_where(const auto& falling, double wanted) {
  double low = search_begin;
  double high = search_end;
  for (int step = 0; step < 60; ++step) {
    const double middle = (low + high) / 2;
    (falling(std::exp(middle)) > wanted ? low : high) = middle;
  }
  return std::exp(high);
}

/// The loss of worth of a number of Sobol points, as a difference of logarithms, over two octaves:
/// at 16, 18, 20 ... 30 points, then at 32, 36 ... 60, then at 64. It repeats above and below.
constexpr std::array<double, 17> uneven{0,     0.407, 0.429, 0.612, 0.450, 0.618,
                                        0.476, 0.491, 0.214, 0.514, 0.487, 0.482,
                                        0.267, 0.385, 0.330, 0.218, 0};

/// Returns the samples per pixel that the next pass needs. `samples`: per pixel so far.
double wanted(const TargetLaws& laws, double samples, double share, bool placed) {
  const auto lacking = [&](double total) { return lacking_for_error(total, samples); };
  const bool may_place = laws.placing_pays && samples >= pilot_samples;
  const double even = lacking(samples / share);
  if (!placed && (!may_place || even < samples / 2)) return even;
  const ModelError& model = laws.placed.model();
  return lacking(model.samples_for(model.at(samples) * std::sqrt(share)));
}

}  // namespace

double even_points(double samples) {
  const double octaves = std::log2(samples);
  const double octave = std::floor(octaves);
  const bool second = static_cast<long>(octave) % 2 != 0;
  const double place = (second ? 8 : 0) + 8 * (std::exp2(octaves - octave) - 1);
  const auto before = static_cast<std::size_t>(std::clamp(std::floor(place), 0.0, 15.0));
  const double share = place - static_cast<double>(before);
  return samples * std::exp(-std::lerp(uneven[before], uneven[before + 1], share));
}

ModelError ModelError::uniform(double deviation) {
  return ModelError({{0.0, std::log(deviation)}});
}

ModelError ModelError::adaptive(const FramebufferView& state, double rmse) {
  const Allocation allocation(state, false);
  const auto pixels = static_cast<double>(state.counts.size());
  const double first = state.counts[0];
  std::vector<std::pair<double, double>> points;
  for (int half_octaves = 0; half_octaves <= 20; ++half_octaves) {
    const double samples = first * std::exp2(half_octaves / 2.0);
    const double share = allocation.share_of_square_error(samples * pixels);
    points.emplace_back(std::log(samples), std::log(rmse) + std::log(share) / 2);
  }
  return ModelError(std::move(points));
}

double ModelError::at(double samples) const {
  const double x = std::log(samples);
  const auto after =
      std::ranges::upper_bound(points_, x, {}, [](const auto& p) { return p.first; });
  if (after == points_.begin()) {
    return std::exp(points_.front().second - (x - points_.front().first) / 2);
  }
  const auto before = after - 1;
  const double slope = after == points_.end()
                           ? -0.5
                           : (after->second - before->second) / (after->first - before->first);
  return std::exp(before->second + slope * (x - before->first));
}

double ModelError::samples_for(double rmse) const {
  return samples_where([this](double samples) { return at(samples); }, rmse);
}

ErrorModel::ErrorModel(ModelError model, std::span<const MeasuredError> measured,
                       ExponentPrior exponent, Spread spread)
    : model_(std::move(model)), spread_(spread) {
  for (const MeasuredError& one : measured) {
    const double doubt = doubt_per_octave * std::log2(measured.back().samples / one.samples);
    const double relative = std::max(one.relative, least_relative);
    gains_.push_back({std::log(one.samples), points_of(one.samples),
                      std::log(one.rmse / model_.at(one.samples)), relative,
                      1 / (relative * relative + doubt * doubt)});
  }
  fit_exponent(exponent);
  if (exponent.deviation == 0) average_gains();
}

double ErrorModel::points_of(double samples) const {
  return std::log(spread_ == Spread::points ? even_points(samples) : samples);
}

void ErrorModel::fit_exponent(ExponentPrior prior) {
  exponent_ = prior.mean;
  if (prior.deviation == 0) return;
  double weights = 0;
  double middle = 0;
  for (const Gain& one : gains_) {
    weights += one.weight;
    middle += one.weight * one.points;
  }
  middle /= weights;
  double precision = 1 / (prior.deviation * prior.deviation);
  double sum = prior.mean * precision;
  for (const Gain& one : gains_) {
    const double x = one.points - middle;
    precision += one.weight * x * x;
    sum -= one.weight * x * one.gain;
  }
  exponent_ = sum / precision;
  exponent_variance_ = 1 / precision;
}

void ErrorModel::average_gains() {
  Gain mean = gains_.back();
  mean.gain = 0;
  double weights = 0;
  for (const Gain& one : gains_) {
    weights += one.weight;
    mean.gain += one.weight * (one.gain + exponent_ * (one.points - mean.points));
  }
  mean.gain /= weights;
  mean.relative = 1 / std::sqrt(weights);
  gains_ = {mean};
}

double ErrorModel::at(double samples) const {
  const double x = std::log(samples);
  const auto after =
      std::ranges::find_if(gains_, [x](const Gain& one) { return one.samples >= x; });
  // Deviation of a measurement from the law of the exponent.
  const auto off = [this](const Gain& one) { return one.gain + exponent_ * one.points; };
  double offset = 0;
  if (after == gains_.begin() || after == gains_.end()) {
    offset = off(after == gains_.end() ? gains_.back() : gains_.front());
  } else {
    const Gain& before = *(after - 1);
    const double share = (x - before.samples) / (after->samples - before.samples);
    offset = std::lerp(off(before), off(*after), share);
  }
  return model_.at(samples) * std::exp(offset - exponent_ * points_of(samples));
}

double ErrorModel::samples_for(double rmse) const {
  return samples_where([this](double samples) { return at(samples); }, rmse);
}

double ErrorModel::relative_at(double samples) const {
  const double x = points_of(samples);
  const double away = std::max({gains_.front().points - x, x - gains_.back().points, 0.0});
  const double relative = gains_.back().relative;
  return std::sqrt(relative * relative + exponent_variance_ * away * away);
}

double UpperBound::of(double rmse, double samples) const {
  return std::sqrt(factor * rmse * rmse + unseen / samples);
}

Forecast forecast_target(const TargetLaws& laws, double target, double most_samples) {
  Forecast now{std::min<double>(first_samples, most_samples), 0, 1, 0};
  for (bool placed = false;; ++now.passes) {
    now.rmse = (placed ? laws.placed : laws.even).at(now.samples);
    const double high = (placed ? laws.stated_placed : laws.stated_even).of(now.rmse, now.samples);
    if (high <= target || now.samples >= most_samples) return now;
    const double share = share_to_go_for(target * target / (high * high), laws.sampler);
    const double lacking =
        std::min(wanted(laws, now.samples, share, placed), most_samples - now.samples);
    const auto traced = static_cast<std::uint64_t>(now.samples * unit);
    const std::uint64_t more = part_of(static_cast<std::uint64_t>(lacking * unit) + 1, traced);
    const bool piloted = now.samples >= pilot_samples;
    placed = placed || (laws.placing_pays && piloted && more >= traced / 2);
    now.decisions += placed && !is_little(more, traced) ? 1 : 0;
    const double most = piloted ? most_samples : std::min<double>(most_samples, pilot_samples);
    now.samples = std::min(now.samples + static_cast<double>(more) / unit, most);
    if (!placed) now.samples = std::min(std::ceil(now.samples), most);
  }
}

Forecast forecast_time(const PassCosts& costs, double seconds, double most_samples) {
  Forecast now{std::min<double>(pilot_samples, most_samples), 0, 1, 0};
  const double affordable_pilot = (seconds - costs.pass) / costs.pilot_sample;
  if (affordable_pilot < now.samples) {
    now.samples = std::max(affordable_pilot, 2.0);
    return now;
  }
  double left = seconds - now.samples * costs.pilot_sample - costs.pass;
  double sample = costs.pilot_sample;  // measured in the previous pass; decides on the next
  for (; left > 0; ++now.passes, ++now.decisions) {
    const auto traced = static_cast<std::uint64_t>(now.samples * unit);
    const auto lacking = static_cast<std::uint64_t>((most_samples - now.samples) * unit);
    const auto affordable =
        static_cast<std::uint64_t>(std::min(left / sample, most_samples) * unit);
    const std::uint64_t more = within_time(part_of(lacking, traced), traced, affordable);
    if (more == 0) break;
    const double samples = static_cast<double>(more) / unit;
    now.samples += samples;
    left -= samples * costs.later_sample + costs.pass;
    sample = costs.later_sample;
  }
  return now;
}

}  // namespace parray::plan
