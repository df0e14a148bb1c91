#pragma once

#include <istream>
#include <string>

#include "common/rooms.h"

namespace parray::output {

/// Returns the value of the first line "KEY : VALUE" of a file like /proc/cpuinfo. Empty if there
/// is no such line.
std::string value_of(std::istream& lines, const std::string& key);

/// The name of this machine's processor; "unknown processor" if it has none.
std::string processor_model();

/// Shortens such a name: "AMD EPYC 9V74" of "AMD EPYC 9V74 80-Core Processor", "Intel Xeon Platinum
/// 8375C" of "Intel(R) Xeon(R) Platinum 8375C CPU @ 2.90GHz".
std::string short_processor(const std::string& model);

}  // namespace parray::output
