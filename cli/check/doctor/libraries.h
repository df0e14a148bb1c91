#pragma once

#include <filesystem>

#include "cli/check/doctor/check.h"

/// The libraries that programs link, and files that they write and read back.
namespace parray::doctor {

/// Versions: those that run where a library says so, those that were compiled in where it does not.
Finding check_libraries();

/// Pictures written to `directory` and read back: EXR with every bit, PNG with every byte.
Finding check_pictures(const std::filesystem::path& directory);

/// A coordinator's state: opened in `directory`, committed, opened again.
Finding check_state(const std::filesystem::path& directory);

}  // namespace parray::doctor
