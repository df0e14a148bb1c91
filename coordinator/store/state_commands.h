#pragma once

#include <string>
#include <vector>

#include "common/rooms.h"

/// The options --check, --repair and --backup of parray-coordinator. Each function prints lines to
/// standard output, returns the exit status, and throws what state_tools.h throws. `now`: seconds
/// since 1970.
namespace parray::store {

int check_command(const std::string& directory);  ///< returns 1 if the state is damaged
int repair_command(const std::string& directory, double now);  ///< returns 0
/// Returns 1 if the copy lacks damaged files. `places`: the state's directory and the target.
int backup_command(const std::vector<std::string>& places, double now);

}  // namespace parray::store
