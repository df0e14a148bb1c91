#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "cli/check/doctor/check.h"
#include "cli/check/doctor/rounding_cases.h"

/// Floating point as IEEE 754 has it: what every bit of a picture rests on.
namespace parray::doctor {

/// Looks at control words (common/math/float_mode.h) that threads started with: rounding,
/// denormals, masks. Another library's fast mode is a warning, because tracing sets its own
/// (FloatMode).
Finding check_float_mode(std::span<const unsigned> found);
/// The same for this thread and a team of OpenMP threads.
Finding check_float_mode();

/// + - x / sqrt on hard cases, in every OpenMP thread, in the mode that tracing has.
Finding check_rounding(std::span<const RoundingCase<std::uint32_t>> singles,
                       std::span<const RoundingCase<std::uint64_t>> doubles);
Finding check_rounding();

}  // namespace parray::doctor
