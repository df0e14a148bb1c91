#pragma once

#include <string>

#include "common/rooms.h"

namespace parray::base {

/// What a module exports under the name `entry`, loaded from bin/../lib/parray, where it is built
/// and where it is installed, or from beside a program that is there itself. Stays loaded until the
/// program ends. Throws RunError "loading WHAT: ...: REMEDY" when it is not there.
void* module_entry(const std::string& file, const char* entry, const std::string& what,
                   const std::string& remedy);

}  // namespace parray::base
