#pragma once

#include <vector>

#include "cli/check/doctor/check.h"

namespace parray::doctor {

/// Returns the checks of `parray doctor` in their order, with those of `--extremes` (extremes.h) if
/// `extremes`. The checks share a temporary directory. It lasts until all copies of the checks are
/// destroyed. Run the checks in this order: later ones need the directory.
std::vector<Check> doctor_checks(bool extremes);

}  // namespace parray::doctor
