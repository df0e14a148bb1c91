#pragma once

#include <string>
#include <vector>

#include "cli/measure/plan/farm_model.h"
#include "cli/measure/plan/probe.h"
#include "common/scene/settings_fwd.h"

namespace parray::plan {

/// The user's goal: an error or a time. Exactly one of `error` and `seconds` is > 0.
struct PlanGoal {
  double error = 0;          ///< RMSE, linear radiance
  double seconds = 0;        ///< time of the whole render
  double confidence = 0.95;  ///< required probability that the render meets the goal, in [0.5, 1)
  // The options that give the goal, for messages.
  const char* error_option = "--error";
  const char* seconds_option = "--time";
};

/// A predicted value with its 95 % confidence interval.
struct Expected {
  double value = 0;
  double low = 0;
  double high = 0;
};

/// A way to render the picture, with its prediction.
struct Choice {
  Sampler sampler = Sampler::independent;
  bool adaptive = false;
  std::uint32_t samples_per_pixel = 0;  ///< option --spp; 0: no fixed number, adaptive passes
  double time_limit = 0;                ///< option --time-limit; 0: none
  double target_error = 0;              ///< option --target-error; 0: none
  Expected samples;                     ///< per pixel
  Expected error;                       ///< RMSE, linear radiance
  Expected seconds;                     ///< wall-clock time of the whole render
  double cpu_seconds = 0;               ///< processor time, all of it at the speed of this machine
  double keeps = 0;                     ///< probability that the render meets the goal
};

/// Returns the quantile of the standard normal distribution for `p` in (0, 1).
double normal_quantile(double p);

/// Returns ways to meet the goal, the recommended one first: adaptive passes and a fixed number of
/// samples, for each sampler of the probe. If the goal is a time, leaves out choices whose `keeps`
/// is below the required confidence, unless all are below it. Choices that stop at the goal by
/// themselves (a target error, a time limit) precede those with a number of samples. In both
/// groups, choices with the required confidence come first. Then the order is by time, or by error
/// if the goal is a time. `settings`: of the picture. `load`: the time of reading the scene. `farm`
/// traces; this machine does everything else. Throws InputError, which names the option, if the
/// goal is out of reach.
std::vector<Choice> choices(const Probe& probe, const RenderSettings& settings, PlanGoal goal,
                            Effort load, const FarmModel& farm = {});

}  // namespace parray::plan
