#pragma once

#include <span>

#include "cli/check/doctor/check.h"

/// The floating-point mode of threads. Every bit of a picture depends on it.
namespace parray::doctor {

/// Checks control words (common/math/float_mode.h), one for each thread: rounding, denormals,
/// exception masks. Warns if one differs from the default of IEEE 754, as after -ffast-math in a
/// library. Never fails, because tracing sets its own mode (FloatMode).
CheckResult check_float_mode(std::span<const unsigned> found);
/// Does the same for this thread and a team of usable_cpus() OpenMP threads.
CheckResult check_float_mode();

}  // namespace parray::doctor
