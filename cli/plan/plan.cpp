#include "cli/plan/plan.h"

#include <algorithm>
#include <cmath>

#include "cli/output/text.h"
#include "common/adaptive/noise_model.h"
#include "common/base/error.h"
#include "common/scene/limits.h"
#include "common/scene/scene_ranges.h"

namespace parray {
namespace {

constexpr double most_samples = limits::max_samples_per_pixel;
/// A uniform picture does not look at its error: it gets some more samples, to be below the goal.
constexpr double uniform_margin = 1.03;
/// Adaptive passes look at their error as they go, or at the clock: worth some time, or error.
constexpr double looks_at_error = 0.95;
constexpr double looks_at_clock = 0.8;
/// By how much errors of evenly spread points are off their law: they are least at powers of two.
constexpr double between_powers = 0.03;
Expected around(double value, double relative) {
  const double factor = std::exp(normal_95 * relative);
  return {value, value / factor, value * factor};
}

class Chooser {
 public:
  Chooser(const Probe& probe, const RenderSettings& settings, PlanGoal goal, Effort load)
      : probe_(probe),
        goal_(goal),
        fixed_(load + probe.fixed),
        pixels_(static_cast<double>(settings.width) * settings.height) {}

  [[nodiscard]] Choice uniform(const SamplerProbe& sampler) const {
    const double exactly = goal_.error > 0
                               ? sampler.uniform.samples_for(goal_.error / uniform_margin)
                               : affordable(sampler.uniform_sample, goal_.seconds - least().wall);
    // Replicates are halves; a picture of less than two samples a pixel does not know its error.
    const double even = 2 * (goal_.error > 0 ? std::ceil(exactly / 2) : std::floor(exactly / 2));
    Choice choice;
    choice.sampler = sampler.sampler;
    const double samples = std::clamp(even, 2.0, most_samples);
    choice.samples_per_pixel = static_cast<std::uint32_t>(samples);
    choice.samples = {samples, samples, samples};
    const double ripple = sampler.sampler == Sampler::sobol ? between_powers : 0;
    choice.error = around(sampler.uniform.at(samples),
                          std::hypot(ripple, sampler.uniform.relative_at(samples)));
    add_time(choice, samples * pixels_ * sampler.uniform_sample, 0);
    return choice;
  }

  [[nodiscard]] Choice adaptive(const SamplerProbe& sampler) const {
    return goal_.error > 0 ? to_error(sampler) : in_time(sampler);
  }

  [[nodiscard]] Effort least() const { return fixed_ + probe_.collect + probe_.finish; }

 private:
  [[nodiscard]] double affordable(Effort sample, double seconds) const {
    return seconds / sample.wall / pixels_;
  }

  [[nodiscard]] static double pilot_of(double samples) {
    return std::min<double>(samples, pilot_samples);
  }

  /// Of tracing so many samples a pixel in adaptive passes.
  [[nodiscard]] Effort tracing(const SamplerProbe& sampler, double samples) const {
    const double pilot = pilot_of(samples);
    return pixels_ * (pilot * sampler.uniform_sample + (samples - pilot) * sampler.adaptive_sample);
  }

  [[nodiscard]] UpperBound stated(double samples) const {
    return samples > pilot_samples ? probe_.stated_adaptive : probe_.stated_uniform;
  }

  [[nodiscard]] Choice to_error(const SamplerProbe& sampler) const {
    // Up to the pilot's end all pixels are equal.
    const double pilot = pilot_samples;
    const double pilot_error = sampler.uniform.at(pilot);
    Forecast forecast{pilot, pilot_error, 1};
    if (stated(pilot).of(pilot_error, pilot) > goal_.error) {
      forecast =
          forecast_target(sampler.adaptive, probe_.stated_adaptive, goal_.error, most_samples);
    }
    Choice choice;
    choice.sampler = sampler.sampler;
    choice.adaptive = true;
    if (forecast.passes == 1) {
      choice.samples = {pilot, pilot, pilot};
      choice.error = around(pilot_error, sampler.uniform.relative_at(pilot));
    } else {
      // That the law is off by 1 % changes the samples by twice that, and not the error at which
      // passes end: it is between the last pass's plan and the goal.
      choice.samples = around(forecast.samples, 2 * sampler.adaptive.relative_at(forecast.samples));
      choice.error = {forecast.rmse, 0.95 * forecast.rmse, std::max(forecast.rmse, goal_.error)};
    }
    add_time(choice, tracing(sampler, forecast.samples), forecast.passes);
    return choice;
  }

  [[nodiscard]] Choice in_time(const SamplerProbe& sampler) const {
    Choice choice;
    choice.sampler = sampler.sampler;
    choice.adaptive = true;
    choice.time_limit = std::max(goal_.seconds, ranges::time_limit.least);
    const PassCosts costs{pixels_ * sampler.uniform_sample.wall,
                          pixels_ * sampler.adaptive_sample.wall,
                          probe_.pass.wall + probe_.collect.wall};
    const Forecast forecast =
        forecast_time(costs, choice.time_limit - fixed_.wall - probe_.finish.wall, most_samples);
    const double samples = forecast.samples;
    const bool known = samples > pilot_samples;
    const ErrorModel& law = known ? sampler.adaptive : sampler.uniform;
    choice.samples = around(samples, probe_.timing_doubt);
    choice.error =
        around(law.at(samples), std::hypot(law.relative_at(samples), 0.5 * probe_.timing_doubt));
    add_time(choice, tracing(sampler, samples), forecast.passes);
    return choice;
  }

  void add_time(Choice& choice, Effort tracing, int passes) const {
    const Effort rest = fixed_ + std::max(passes, 1) * probe_.collect +
                        std::max(passes - 1, 0) * probe_.pass + probe_.finish;
    const double total = rest.wall + tracing.wall;
    const double of_samples = std::log(choice.samples.high / choice.samples.value) / normal_95;
    const double doubt = std::hypot(of_samples * tracing.wall / total, probe_.timing_doubt);
    choice.seconds = around(total, doubt);
    choice.cpu_seconds = rest.cpu + tracing.cpu;
    if (choice.time_limit > 0) {  // it is kept
      choice.seconds = {total, 0.95 * total, 1.05 * total};
    }
  }

  const Probe& probe_;
  const PlanGoal goal_;
  const Effort fixed_;
  const double pixels_;
};

/// A picture of single-precision numbers is off by as much, whatever the samples: half an ulp of a
/// mean, evenly spread, at the middle of a binade.
double rounding_error(double mean_radiance) {
  return mean_radiance * 0x1p-23 / std::sqrt(12.0) / 1.5;
}

std::string error_option(double error) { return "--error " + number_cell(error) + ": "; }

void check_reachable(const Probe& probe, const std::vector<SamplerProbe>& samplers, PlanGoal goal) {
  const double rounding = rounding_error(probe.mean_radiance);
  if (goal.error < 2 * rounding) {
    throw InputError(error_option(goal.error) +
                     "the picture's own rounding to single precision is an error of " +
                     formatted("%.1e", rounding) + ": ask for " + formatted("%.1e", 2 * rounding) +
                     " or more");
  }
  double best = INFINITY;
  for (const SamplerProbe& sampler : samplers) {
    best = std::min(best, sampler.adaptive.at(most_samples));
  }
  if (goal.error < best) {
    throw InputError(error_option(goal.error) + "more than " +
                     std::to_string(limits::max_samples_per_pixel) +
                     " samples a pixel would be needed, the most there can be: ask for " +
                     formatted("%.1e", 1.1 * best) + " or more");
  }
}

}  // namespace

std::vector<Choice> choices(const Probe& probe, const RenderSettings& settings, PlanGoal goal,
                            Effort load) {
  const Chooser chooser(probe, settings, goal, load);
  if (goal.seconds > 0 && goal.seconds <= 1.05 * chooser.least().wall) {
    throw InputError("--time " + number_cell(goal.seconds) +
                     ": reading the scene and writing the picture alone take about " +
                     duration_text(chooser.least().wall) + ": allow more");
  }
  if (goal.error > 0) {
    check_reachable(probe, probe.samplers, goal);
  }
  std::vector<Choice> all;
  for (const SamplerProbe& sampler : probe.samplers) {
    all.push_back(chooser.adaptive(sampler));
    all.push_back(chooser.uniform(sampler));
  }
  if (goal.seconds > 0) {  // however short the time, adaptive passes begin with the pilot
    const auto late = [&](const Choice& choice) {
      return choice.seconds.value > 1.1 * goal.seconds;
    };
    if (!std::all_of(all.begin(), all.end(), late)) {
      std::erase_if(all, late);
    }
  }
  const auto worth = [&](const Choice& choice) {
    const double cost = goal.error > 0 ? choice.seconds.value : choice.error.value;
    const double bonus = goal.error > 0 ? looks_at_error : looks_at_clock;
    return choice.adaptive ? bonus * cost : cost;
  };
  std::stable_sort(all.begin(), all.end(),
                   [&](const Choice& a, const Choice& b) { return worth(a) < worth(b); });
  return all;
}

}  // namespace parray
