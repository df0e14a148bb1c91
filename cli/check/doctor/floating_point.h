#pragma once

#include <span>

#include "cli/check/doctor/check.h"

/// The floating-point mode of threads. Every bit of a picture depends on it.
namespace parray::doctor {

/// Checks the control words (common/math/float_mode.h) of new threads: rounding, denormals,
/// exception masks. A fast mode, set by another library, is a warning only, because tracing sets
/// its own mode (FloatMode).
CheckResult check_float_mode(std::span<const unsigned> found);
/// Does the same for this thread and a team of OpenMP threads.
CheckResult check_float_mode();

}  // namespace parray::doctor
