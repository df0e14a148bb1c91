#pragma once

#include <vector>

#include "cli/check/doctor/check.h"

namespace parray::doctor {

/// Returns the checks of `parray doctor` in their order, with those of `--extremes` (extremes.h) if
/// `extremes`. Run the checks in this order: the check "temporary directory" creates a directory in
/// which later checks write. Without the directory, these are skipped. The directory lasts until
/// all copies of the checks are destroyed.
std::vector<Check> doctor_checks(bool extremes);

}  // namespace parray::doctor
