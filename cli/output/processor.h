#pragma once

#include <istream>
#include <string>

#include "common/rooms.h"

namespace parray::output {

/// Value of the first line "KEY : VALUE" of a file such as /proc/cpuinfo; empty if there is none.
std::string value_of(std::istream& lines, const std::string& key);

/// Of this machine's processor, as it names itself; "unknown processor" where it does not.
std::string processor_model();

/// Such a name without what says nothing: "AMD EPYC 9V74" of "AMD EPYC 9V74 80-Core Processor",
/// "Intel Xeon Platinum 8375C" of "Intel(R) Xeon(R) Platinum 8375C CPU @ 2.90GHz".
std::string short_processor(const std::string& model);

}  // namespace parray::output
