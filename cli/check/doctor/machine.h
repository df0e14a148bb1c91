#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "cli/check/doctor/check.h"
#include "common/base/files.h"

/// Checks processor, memory and disks.
namespace parray::doctor {

CheckResult check_processor();
CheckResult check_memory();

/// Makes the directory for files of later checks, in the system's directory for temporary files
/// (TMPDIR).
CheckResult check_temporary_directory(std::optional<OwnedPath>& scratch);
/// Checks whether `directory` is writable.
CheckResult check_current_directory(const std::filesystem::path& directory);

/// Returns the bytes of shared memory that one rank per processor needs for a picture of 1200 x 800
/// pixels: the window, and Open MPI's own buffers.
std::uint64_t window_bytes();
/// Checks whether `needed` bytes fit into `available` bytes of shared memory.
CheckResult check_shared_memory(std::uint64_t available, std::uint64_t needed);
/// Does the same for /dev/shm.
CheckResult check_shared_memory();

}  // namespace parray::doctor
