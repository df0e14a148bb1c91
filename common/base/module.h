#pragma once

#include <filesystem>
#include <string>

#include "common/rooms.h"

namespace parray::base {

/// Returns the path of a file of ParRay that programs load: a module (.so), or data such as the
/// font. `name` has no directory. The path is in the directory of this program if the file exists
/// there. Otherwise it is in ../lib/parray relative to that directory, where the file may be
/// missing. Throws RunError if the system does not say where this program is.
std::filesystem::path module_file(const std::string& name);

/// Loads module_file(file) and returns the address of the symbol `entry` that the module exports.
/// The module stays loaded until the program ends. Throws RunError "loading WHAT: ...: REMEDY" if
/// the module is missing, cannot be loaded, or lacks `entry`.
void* module_entry(const std::string& file, const char* entry, const std::string& what,
                   const std::string& remedy);

}  // namespace parray::base
