#pragma once

#include <string>
#include <vector>

#include "cli/measure/plan/farm_model.h"
#include "cli/measure/plan/probe.h"

namespace parray::plan {

/// What the user asks for: one of the first two is > 0.
struct PlanGoal {
  double error = 0;          ///< RMSE, linear radiance
  double seconds = 0;        ///< in all
  double confidence = 0.95;  ///< probability with which it is to be kept, 0.5 or more and below 1
};

/// A value, and the interval that it is expected in, 95 % of the time.
struct Expected {
  double value = 0;
  double low = 0;
  double high = 0;
};

/// A way to render the picture, and what is expected of it.
struct Choice {
  Sampler sampler = Sampler::independent;
  bool adaptive = false;
  std::uint32_t samples_per_pixel = 0;  ///< to ask for; 0: adaptive, as many as it takes
  double time_limit = 0;                ///< to ask for; 0: none
  double target_error = 0;              ///< to ask for; 0: none
  Expected samples;                     ///< a pixel
  Expected error;
  Expected seconds;
  double cpu_seconds = 0;
  double keeps = 0;  ///< probability that the goal is kept, by the interval of what it is about
};

/// The number that a standard normal variable is below with probability `p`, in (0, 1).
double normal_quantile(double p);

/// All choices that meet the goal, the one to take first: those that stop at the goal by themselves
/// (a target error, a time limit), then those with a number of samples. Each group begins with
/// those that keep the goal as surely as is asked for, by time, or by error if time was the goal.
/// `load`: what reading the scene took. `farm`: who is to trace; all else is done here. Throws
/// InputError, naming the option, for a goal that cannot be met.
std::vector<Choice> choices(const Probe& probe, const RenderSettings& settings, PlanGoal goal,
                            Effort load, const FarmModel& farm = {});

}  // namespace parray::plan
