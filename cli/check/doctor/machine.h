#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "cli/check/doctor/check.h"
#include "cli/check/doctor/scratch.h"

/// Processor, memory and disks.
namespace parray::doctor {

Finding check_processor();
Finding check_memory();

/// Makes the directory that later checks write to.
Finding check_temporary_directory(Scratch& scratch);
/// Whether pictures could be written to `directory`.
Finding check_current_directory(const std::filesystem::path& directory);

/// Shared memory that a rank for every processor takes for a picture of 1200 x 800 pixels: the
/// window, and Open MPI's own buffers.
std::uint64_t window_bytes();
/// Whether that fits into shared memory with `available` free bytes.
Finding check_shared_memory(std::uint64_t available, std::uint64_t needed);
/// The same for /dev/shm.
Finding check_shared_memory();

}  // namespace parray::doctor
