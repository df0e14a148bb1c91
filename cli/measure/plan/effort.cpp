#include "cli/measure/plan/effort.h"

#include <algorithm>
#include <cmath>
#include <ctime>

namespace parray::plan {

static double seconds_of(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

Effort effort_now() { return {seconds_of(CLOCK_MONOTONIC), seconds_of(CLOCK_PROCESS_CPUTIME_ID)}; }

static constexpr double least_doubt = 0.05;
/// Smallest share of a pass's time that belongs to its samples.
static constexpr double least_share = 0.3;

PassCost fit_pass_cost(std::span<const TracedPass> passes) {
  // Weighted by 1 / time^2: minimises the sum of (pass / t + sample * n / t - 1)^2.
  double u = 0;
  double un = 0;
  double unn = 0;
  double right = 0;
  double right_n = 0;
  Effort all;
  double samples = 0;
  double shortest = INFINITY;
  for (const TracedPass& one : passes) {
    const double t = one.effort.cpu;
    u += 1 / (t * t);
    un += one.samples / (t * t);
    unn += one.samples * one.samples / (t * t);
    right += 1 / t;
    right_n += one.samples / t;
    all = all + one.effort;
    samples += one.samples;
    shortest = std::min(shortest, t);
  }
  const double determinant = u * unn - un * un;
  const double exact = determinant > 0 ? (right * unn - right_n * un) / determinant : 0;
  const double pass = std::clamp(exact, 0.0, (1 - least_share) * shortest);
  const double slower = all.wall / all.cpu;
  const auto count = static_cast<double>(passes.size());
  PassCost times;
  times.pass = {slower * pass, pass};
  times.sample = 1 / samples * (all - count * times.pass);
  double squares = 0;
  for (const TracedPass& one : passes) {
    const double expected = times.pass.wall + one.samples * times.sample.wall;
    squares += std::pow(one.effort.wall / expected - 1, 2);
  }
  times.doubt = std::max(least_doubt, std::sqrt(squares / (count * (count - 1))));
  return times;
}

Effort sample_effort(std::span<const TracedPass> passes, Effort pass) {
  Effort all;
  double samples = 0;
  for (const TracedPass& one : passes) {
    all = all + one.effort;
    samples += one.samples;
  }
  const auto count = static_cast<double>(passes.size());
  const Effort rest = all - count * pass;
  return 1 / samples *
         Effort{std::max(rest.wall, least_share * all.wall),
                std::max(rest.cpu, least_share * all.cpu)};
}

}  // namespace parray::plan
