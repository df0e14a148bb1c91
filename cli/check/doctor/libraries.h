#pragma once

#include <filesystem>

#include "cli/check/doctor/check.h"

/// Checks linked libraries, and files that they write and read back.
namespace parray::doctor {

/// Lists versions: of the loaded library if it states one, otherwise of its headers. Fails if the
/// loaded ZeroMQ has another major version than its headers.
CheckResult check_libraries();

/// Writes an EXR and a PNG picture to `directory` and reads them back. Fails if a value of float32
/// (EXR) or a byte (PNG) differs.
CheckResult check_pictures(const std::filesystem::path& directory);

/// Makes a coordinator's state in `directory`/state, commits a scene and opens the state again.
/// Fails if the scene is missing or differs.
CheckResult check_state(const std::filesystem::path& directory);

}  // namespace parray::doctor
