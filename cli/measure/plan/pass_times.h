#pragma once

#include <span>

#include "cli/measure/plan/effort.h"

namespace parray::plan {

/// A pass that was traced.
struct TracedPass {
  double samples = 0;  ///< all pixels together
  Effort effort;
};

/// time = pass + samples * sample
struct FittedPassTimes {
  Effort pass;
  Effort sample;
  double doubt = 0;  ///< standard error of times / times, on the wall
};

/// From two passes or more, by least squares of relative errors. What a pass takes whatever its
/// samples is told from what samples take by processor time, which other programs disturb less;
/// processors that were busy with those make all of it longer alike.
FittedPassTimes fit_pass_times(std::span<const TracedPass> passes);

/// A sample's, of passes that have the same `pass`.
Effort sample_effort(std::span<const TracedPass> passes, Effort pass);

}  // namespace parray::plan
