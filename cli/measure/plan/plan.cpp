#include "cli/measure/plan/plan.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

#include "cli/check/audit/audit.h"
#include "cli/output/text.h"
#include "common/adaptive/noise_model.h"
#include "common/adaptive/rounding_limit.h"
#include "common/base/error.h"
#include "common/scene/limits.h"
#include "common/scene/settings.h"

namespace parray::plan {
namespace {

constexpr double most_samples = limits::max_samples_per_pixel;
/// The share of its time limit that a render uses, and the standard deviation of its logarithm.
/// Measured on 16 scenes: 95 % of renders use 0.90 to 0.99 of it.
constexpr double used_limit = 0.945;
constexpr double limit_doubt = 0.022;
/// Standard deviation of the log of the samples with which passes meet a target, even if the law is
/// known exactly: the last pass is planned from an estimated error (32 renders of 16 scenes).
constexpr double passes_doubt = 0.09;
/// Standard deviation of the time of any command, in seconds.
constexpr double starting_doubt = 0.03;
/// Standard deviation of the log error of a picture around the law that was measured on a part.
constexpr double law_doubt = 0.04;
/// Standard deviation of the log error of evenly spread points around their law.
constexpr double points_doubt = 0.04;

double normal_share(double x) { return std::erfc(-x / std::sqrt(2.0)) / 2; }

/// Returns the probability that a log-normal value with this prediction is at most `most`.
double probability(const Expected& expected, double most) {
  const double relative = std::log(expected.high / expected.value) / normal_95;
  const double above = std::log(most / expected.value);
  return relative > 0 ? normal_share(above / relative) : above >= 0 ? 1 : 0;
}

Expected around(double value, double relative) {
  const double factor = std::exp(normal_95 * relative);
  return {value, value / factor, value * factor};
}

class Chooser {
 public:
  Chooser(const Probe& probe, const RenderSettings& settings, PlanGoal goal, Effort load,
          const FarmModel& farm)
      : probe_(probe),
        farm_(farm),
        goal_(goal),
        quantile_(normal_quantile(goal.confidence)),
        fixed_(load + probe.fixed),
        pixels_(static_cast<double>(pixel_count(settings))) {}

  [[nodiscard]] Choice uniform(const SamplerProbe& sampler) const {
    const double exactly =
        goal_.error > 0 ? enough(sampler) : affordable(sampler.uniform_sample, surely_in_time());
    // The number must be even, because each replicate has half the samples, and at least 2, because
    // otherwise the error is unknown.
    const double even = 2 * (goal_.error > 0 ? std::ceil(exactly / 2) : std::floor(exactly / 2));
    Choice choice;
    choice.sampler = sampler.sampler;
    const double samples = std::clamp(even, 2.0, most_samples);
    choice.samples_per_pixel = static_cast<std::uint32_t>(samples);
    choice.samples = {samples, samples, samples};
    choice.error = around(sampler.uniform.at(samples), uniform_doubt(sampler, samples));
    add_time(choice, samples * pixels_ * sampler.uniform_sample, {samples, 0, 1, 0});
    choice.keeps = goal_.error > 0 ? probability(choice.error, goal_.error)
                                   : probability(choice.seconds, goal_.seconds);
    return choice;
  }

  [[nodiscard]] Choice adaptive(const SamplerProbe& sampler) const {
    return goal_.error > 0 ? to_error(sampler) : in_time(sampler);
  }

  [[nodiscard]] Effort least() const { return fixed_ + probe_.collect + probe_.overheads; }

  /// Returns the target error. Passes end when the upper end of the stated interval meets the
  /// target, so the error is below it with 97.5 % probability. For a higher probability the target
  /// is below the goal.
  [[nodiscard]] double target() const {
    const double relative = std::log(probe_.stated_adaptive.factor) / 2 / normal_95;
    return goal_.error * std::exp(-std::max(quantile_ - normal_95, 0.0) * relative);
  }

 private:
  /// Returns the value to aim at, so that the real value is at most `most` with the required
  /// probability. `relative`: standard deviation of its logarithm.
  [[nodiscard]] double surely(double most, double relative) const {
    return most * std::exp(-quantile_ * relative);
  }

  /// Returns the standard deviation of the logarithm of a command's `seconds`.
  [[nodiscard]] double time_doubt(double seconds) const {
    return std::hypot(probe_.timing_doubt, starting_doubt / seconds);
  }

  /// Returns the seconds to aim at. Iterates, because their uncertainty depends on the result.
  [[nodiscard]] double surely_in_time() const {
    double aim = goal_.seconds;
    for (int step = 0; step < 20; ++step) aim = surely(goal_.seconds, time_doubt(aim));
    return aim;
  }

  /// Returns how many times faster the farm traces than this machine.
  [[nodiscard]] double speedup(Effort sample, double samples, int passes) const {
    const double wall = samples * pixels_ * sample.wall;
    return wall > 0 ? wall / farm_.seconds(wall, samples, passes) : 1;
  }

  /// Returns the samples per pixel that fit into `seconds` besides the fixed steps.
  [[nodiscard]] double affordable(Effort sample, double seconds) const {
    const double here = (seconds - least().wall) / sample.wall / pixels_;
    double samples = here;
    // Iterates, because the speedup of a farm grows with the time of tracing.
    for (int step = 0; step < (farm_.here() ? 0 : 6); ++step) {
      samples = here * speedup(sample, std::clamp(samples, 1.0, most_samples), 1);
    }
    return samples;
  }

  /// Returns the standard deviation of log(error).
  [[nodiscard]] static double uniform_doubt(const SamplerProbe& sampler, double samples) {
    const double ripple = sampler.sampler == Sampler::sobol ? points_doubt : 0;
    return std::hypot(ripple, sampler.uniform.relative_at(samples));
  }

  /// Returns the uniform samples that meet the error with the required probability. Iterates,
  /// because the uncertainty of the error depends on their number.
  [[nodiscard]] double enough(const SamplerProbe& sampler) const {
    double samples = sampler.uniform.samples_for(goal_.error);
    for (int step = 0; step < 8; ++step) {
      const double aim = surely(goal_.error, uniform_doubt(sampler, samples));
      samples = std::max(samples, sampler.uniform.samples_for(aim));
    }
    return samples;
  }

  /// Returns the effort of tracing `samples` per pixel in adaptive passes. `placed`: passes after
  /// the pilot place their samples by noise.
  [[nodiscard]] Effort tracing(const SamplerProbe& sampler, double samples, bool placed) const {
    const double pilot = placed ? std::min<double>(samples, pilot_samples) : samples;
    return pixels_ * (pilot * sampler.uniform_sample + (samples - pilot) * sampler.adaptive_sample);
  }

  [[nodiscard]] Choice to_error(const SamplerProbe& sampler) const {
    Choice choice;
    choice.target_error = target();
    const Forecast forecast =
        forecast_target({sampler.uniform, sampler.adaptive, probe_.stated_uniform,
                         probe_.stated_adaptive, sampler.sampler, probe_.placing_pays},
                        choice.target_error, most_samples);
    const bool placed = forecast.decisions > 0;
    choice.sampler = sampler.sampler;
    choice.adaptive = true;
    // A law that is wrong by 1 % changes the samples by 2 %, but not the error at the end, which is
    // between the plan of the last pass and the goal.
    const ErrorModel& law = placed ? sampler.adaptive : sampler.uniform;
    choice.samples =
        around(forecast.samples, std::hypot(passes_doubt, 2 * law.relative_at(forecast.samples)));
    choice.error = {forecast.rmse, 0.95 * forecast.rmse,
                    std::max(forecast.rmse, choice.target_error)};
    if (forecast.passes == 1) {  // no later pass stops close to the target
      choice.error.low = around(forecast.rmse, uniform_doubt(sampler, forecast.samples)).low;
    }
    add_time(choice, tracing(sampler, forecast.samples, placed), forecast);
    choice.keeps = forecast.rmse <= goal_.error ? normal_share(std::max(quantile_, normal_95)) : 0;
    return choice;
  }

  [[nodiscard]] Choice in_time(const SamplerProbe& sampler) const {
    Choice choice;
    choice.sampler = sampler.sampler;
    choice.adaptive = true;
    choice.time_limit = std::max(goal_.seconds, ranges::time_limit.least);
    const double faster = speedup(sampler.uniform_sample, pilot_samples, 1);
    const PassCosts costs{pixels_ * sampler.uniform_sample.wall / faster,
                          pixels_ * sampler.adaptive_sample.wall / faster,
                          probe_.pass.wall + probe_.collect.wall};
    const Forecast forecast = forecast_time(
        costs, used_limit * choice.time_limit - fixed_.wall - probe_.overheads.wall, most_samples);
    const double samples = forecast.samples;
    const bool known = samples > pilot_samples;
    const ErrorModel& law = known ? sampler.adaptive : sampler.uniform;
    choice.samples = around(samples, probe_.timing_doubt);
    choice.error = around(law.at(samples), std::hypot(law.relative_at(samples),
                                                      0.5 * probe_.timing_doubt, law_doubt));
    add_time(choice, tracing(sampler, samples, probe_.placing_pays), forecast);
    choice.keeps = probability(choice.seconds, goal_.seconds);
    return choice;
  }

  void add_time(Choice& choice, Effort tracing, const Forecast& forecast) const {
    const Effort rest = fixed_ + forecast.passes * probe_.collect +
                        forecast.decisions * probe_.pass + probe_.overheads;
    const double traced = farm_.seconds(tracing.wall, choice.samples.value, forecast.passes);
    const double total = rest.wall + traced;
    const double of_samples = std::log(choice.samples.high / choice.samples.value) / normal_95;
    const double doubt = std::hypot(of_samples * traced / total, time_doubt(total));
    choice.seconds = around(total, doubt);
    choice.cpu_seconds = rest.cpu + tracing.cpu;
    if (choice.time_limit > 0) {
      // Passes end at the limit, even if samples are slow, except for a picture of least samples.
      const bool least = choice.samples.value <= 2;
      choice.seconds =
          around(least ? total : std::min(total, used_limit * choice.time_limit), limit_doubt);
    }
  }

  const Probe& probe_;
  const FarmModel& farm_;
  const PlanGoal goal_;
  const double quantile_;  ///< quantile of the standard normal distribution for the confidence
  const Effort fixed_;
  const double pixels_;
};

void check_samples(const std::vector<SamplerProbe>& samplers, PlanGoal goal) {
  double best = INFINITY;
  for (const SamplerProbe& sampler : samplers) {
    best = std::min(best, sampler.adaptive.at(most_samples));
  }
  if (goal.error < best) {
    throw InputError(std::string(goal.error_option) + " " + number_cell(goal.error) +
                     ": needs more than " + std::to_string(limits::max_samples_per_pixel) +
                     " samples per pixel, the largest possible number: use " + goal.error_option +
                     " " + formatted("%.1e", 1.1 * best) + " or more");
  }
}

}  // namespace

FarmModel::FarmModel(const RenderSettings& settings, std::vector<double> speeds,
                     std::uint32_t threads)
    : settings_(settings), speeds_(std::move(speeds)), threads_(threads) {}

double FarmModel::seconds(double wall, double samples, int passes) const {
  if (here() || wall <= 0) return wall;
  RenderSettings settings = settings_;
  settings.samples_per_pixel = static_cast<std::uint32_t>(
      std::clamp<double>(std::round(samples / passes), 1, limits::max_samples_per_pixel));
  const WorkPlan plan(settings, Pass{{{0, settings.samples_per_pixel}}, {}});
  std::vector<ImaginedWorker> workers;
  for (const double speed : speeds_) workers.push_back({threads_, speed});
  // A longer pass has the same beginning and end, so only `longest` is replayed.
  constexpr double longest = 100;
  const double power = std::accumulate(speeds_.begin(), speeds_.end(), 0.0);
  const double pass = wall / passes;
  const double replayed = std::min(pass, longest * power);
  const Replayed result =
      replay_even_pass(grain_of(plan), replayed * threads_, workers, settings.schedule);
  return passes * (result.seconds + (pass - replayed) / power);
}

double normal_quantile(double p) {
  double low = -40;
  double high = 40;
  for (int step = 0; step < 60; ++step) {
    const double middle = (low + high) / 2;
    (normal_share(middle) < p ? low : high) = middle;
  }
  return high;
}

std::vector<Choice> choices(const Probe& probe, const RenderSettings& settings, PlanGoal goal,
                            Effort load, const FarmModel& farm) {
  const Chooser chooser(probe, settings, goal, load, farm);
  if (goal.seconds > 0 && goal.seconds <= 1.05 * chooser.least().wall) {
    throw InputError(std::string(goal.seconds_option) + " " + number_cell(goal.seconds) +
                     ": the steps before and after tracing alone take about " +
                     duration_text(chooser.least().wall) + ": use a longer time");
  }
  if (goal.error > 0) {
    check_above_rounding(goal.error_option, goal.error, probe.largest_radiance,
                         chooser.target() / goal.error);
    check_samples(probe.samplers, goal);
  }
  std::vector<Choice> all;
  for (const SamplerProbe& sampler : probe.samplers) {
    all.push_back(chooser.adaptive(sampler));
    all.push_back(chooser.uniform(sampler));
  }
  const auto unsure = [&](const Choice& choice) { return choice.keeps < goal.confidence - 1e-6; };
  if (goal.seconds > 0 && !std::ranges::all_of(all, unsure)) std::erase_if(all, unsure);
  const auto cost = [&](const Choice& choice) {
    return std::tuple(choice.samples_per_pixel > 0, unsure(choice),
                      goal.error > 0 ? choice.seconds.value : choice.error.value);
  };
  std::ranges::stable_sort(all, {}, cost);
  return all;
}

}  // namespace parray::plan
