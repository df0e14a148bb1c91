#pragma once

#include <vector>

#include "cli/check/doctor/check.h"

namespace parray::doctor {

/// Everything that `parray doctor` looks at, in its order. Checks share a temporary directory,
/// which goes with the last of them.
std::vector<Check> doctor_checks();

}  // namespace parray::doctor
