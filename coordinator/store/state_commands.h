#pragma once

#include <string>
#include <vector>

#include "common/rooms.h"

/// The options of parray-coordinator that look after a state instead of serving it. Each prints its
/// lines to standard output, returns the exit status, and throws what state_tools.h throws. `now`:
/// seconds since 1970.
namespace parray::store {

int check_command(const std::string& directory);  ///< 1: there is damage
int repair_command(const std::string& directory, double now);
/// `places`: the state's directory and the target. 1: something was left out of the copy.
int backup_command(const std::vector<std::string>& places, double now);

}  // namespace parray::store
