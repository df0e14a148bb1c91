#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "cli/scene_sandbox/confinement.h"

/// Limits of parray-http-child, and its files. The current directory of the process has the files
/// of a request. Pictures are written there, jobs and forecasts to its parent.
namespace parray::scene_sandbox {

/// Limits of memory in bytes, and of processor time in seconds.
struct ChildResources {
  std::size_t memory = 0;
  std::size_t seconds = 0;
};

/// Returns the permissions of this process: the parent of its current directory, and files of at
/// most `file_bytes` bytes.
Enclosure enclosure_of(std::uint64_t file_bytes);

/// Limits memory and processor time, and confines this process, in case a damaged file takes it
/// over. Makes the process end when its parent ends. Throws RunError.
void confine(const ChildResources& resources, std::uint64_t file_bytes);

/// Write or read a whole file. Throw RunError.
void keep_bytes(const std::filesystem::path& file, std::string_view bytes);
std::string kept_bytes(const std::filesystem::path& file);

}  // namespace parray::scene_sandbox
