#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cli/measure/plan/probe.h"
#include "common/scene/settings_fwd.h"

namespace parray::plan {

/// Predicts the time of passes on a farm from their time on this machine. Without workers, the farm
/// is this machine, and its time is that of this machine.
class FarmModel {
 public:
  FarmModel() = default;
  /// `speeds`: samples per second of each worker, divided by those of this machine with `threads`
  /// threads; all > 0. Each worker has `threads` threads. `settings`: those of the picture.
  FarmModel(const RenderSettings& settings, std::vector<double> speeds, std::uint32_t threads);

  /// Returns whether the farm is this machine.
  [[nodiscard]] bool here() const { return speeds_.empty(); }
  [[nodiscard]] const std::vector<double>& speeds() const { return speeds_; }

  /// Returns the farm's seconds for tracing that takes `wall` seconds here, in `passes` equal
  /// passes with `samples` per pixel in total. Replays the coordinator's lease rules in virtual
  /// time (cli/check/audit/audit.h), with the same cost for every cell. Leaves out the network,
  /// the scene's transfer and the coordinator's own work.
  [[nodiscard]] double seconds(double wall, double samples, int passes) const;

 private:
  Boxed<RenderSettings> settings_;
  std::vector<double> speeds_;
  std::uint32_t threads_ = 1;
};

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
