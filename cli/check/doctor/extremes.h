#pragma once

#include <cstdint>
#include <span>

#include "cli/check/doctor/check.h"
#include "cli/check/doctor/rounding_cases.h"
#include "cli/check/doctor/tracing.h"

/// Numerical extremes for `parray doctor --extremes`: scenes and operands for which the result is
/// known exactly. A check fails if any result differs. `make` makes the tracers to check: those of
/// one instruction set. Each check that traces does so in every precision, with linear search and
/// with the BVH. tests/extremes has more cases of the same scenes (known_pictures.h).
namespace parray::doctor {

/// Traces white_balls() and closed_ball(). Every sample of white_balls() must be exactly 1. Every
/// sample of closed_ball() must be exactly 0, and every path must have max_depth segments.
CheckResult check_furnaces(const TracerMaker& make);

/// Traces grey_ball(). Every path must have two segments, and every sample must be exactly 1/2.
CheckResult check_self_hits(const TracerMaker& make);

/// Traces doctor_scene() scaled by 2^-40, 1 and 2^40. The sums must be those of scalar code
/// (path.h) for the unscaled scene.
CheckResult check_scaling(const TracerMaker& make);

/// Computes + - x / sqrt of hard cases in every OpenMP thread, in the floating-point mode of
/// tracing (FloatMode).
CheckResult check_rounding(std::span<const RoundingCase<std::uint32_t>> singles = single_cases,
                           std::span<const RoundingCase<std::uint64_t>> doubles = double_cases);

}  // namespace parray::doctor
