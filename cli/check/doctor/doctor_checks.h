#pragma once

#include <vector>

#include "cli/check/doctor/check.h"

namespace parray::doctor {

/// Returns the checks of `parray doctor` in their order, with those of `--extremes` if `extremes`.
/// Checks share a temporary directory, which the last of them removes.
std::vector<Check> doctor_checks(bool extremes);

}  // namespace parray::doctor
