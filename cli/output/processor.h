#pragma once

#include <istream>
#include <string>

#include "common/rooms.h"

namespace parray::output {

/// Returns the value of the first line "KEY : VALUE" of a file like /proc/cpuinfo. Returns "" if
/// there is no such line.
std::string value_of(std::istream& lines, const std::string& key);

/// Returns the name of this machine's processor. Returns "unknown processor" if /proc/cpuinfo does
/// not have it, as on many ARM machines.
std::string processor_model();

/// Shortens the name of a processor: "AMD EPYC 9V74" for "AMD EPYC 9V74 80-Core Processor", "Intel
/// Xeon Platinum 8375C" for "Intel(R) Xeon(R) Platinum 8375C CPU @ 2.90GHz".
std::string short_processor(const std::string& model);

}  // namespace parray::output
