#pragma once

#include <string>

#include "common/rooms.h"

namespace parray::base {

/// Loads a module and returns the symbol `entry` that it exports. The module lies in
/// bin/../lib/parray, both in the build and when installed, or beside a program in that folder. It
/// stays loaded until the program ends. Throws RunError "loading WHAT: ...: REMEDY" if the module
/// is missing.
void* module_entry(const std::string& file, const char* entry, const std::string& what,
                   const std::string& remedy);

}  // namespace parray::base
