#pragma once

#include <filesystem>

#include "cli/check/doctor/check.h"

/// Checks linked libraries, and files that they write and read back.
namespace parray::doctor {

/// Lists versions: of the loaded library if it states one, otherwise of its headers. Fails if the
/// loaded ZeroMQ has another major version than its headers.
CheckResult check_libraries();

/// Writes pictures to `directory` and reads them back: EXR with every bit, PNG with every byte.
CheckResult check_pictures(const std::filesystem::path& directory);

/// Opens a coordinator's state in `directory`, commits a change and opens it again.
CheckResult check_state(const std::filesystem::path& directory);

}  // namespace parray::doctor
