#pragma once

#include <span>

#include "cli/measure/plan/effort.h"

namespace parray::plan {

/// A traced pass.
struct TracedPass {
  double samples = 0;  ///< of all pixels together
  Effort effort;
};

/// The time of a pass with n samples, of all pixels together, is pass + n * sample.
struct PassCost {
  Effort pass;
  Effort sample;
  double doubt = 0;  ///< relative standard error of wall-clock times, at least 0.05
};

/// Fits at least two passes, by least squares of relative errors. Processor time, which other
/// programs disturb less, separates the constant part from the part per sample. Busy processors
/// lengthen both parts by the same factor.
PassCost fit_pass_cost(std::span<const TracedPass> passes);

/// Returns the time per sample that fits `passes`, if the constant part of their time is `pass`.
Effort sample_effort(std::span<const TracedPass> passes, Effort pass);

}  // namespace parray::plan
