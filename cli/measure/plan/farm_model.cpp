#include "cli/measure/plan/farm_model.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "cli/check/audit/audit.h"
#include "common/scene/limits.h"
#include "common/scene/settings.h"

namespace parray::plan {

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

}  // namespace parray::plan
