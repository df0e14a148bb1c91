#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "cli/scene_sandbox/confinement.h"

/// Limits and files of parray-http-child, the process that a coordinator starts for one HTTP
/// request. Its current directory has the files of the request. It writes pictures there, and jobs
/// and forecasts to the parent directory.
namespace parray::scene_sandbox {

/// Limits of parray-http-child.
struct ChildResources {
  std::size_t memory = 0;   ///< address space in bytes
  std::size_t seconds = 0;  ///< processor time in seconds
};

/// Returns the permissions of this process: access to the parent of its current directory and all
/// folders in it, and files of at most `file_bytes` bytes.
Enclosure enclosure_of(std::uint64_t file_bytes);

/// Limits memory and processor time (SIGXCPU ends the process), and calls enclose_process() with
/// enclosure_of(file_bytes): a malicious upload may take this process over. Makes the process end
/// when its parent ends. Throws RunError if a limit cannot be set. Builds with sanitizers limit
/// only processor time.
void confine(const ChildResources& resources, std::uint64_t file_bytes);

/// keep_bytes() writes a file, kept_bytes() reads a whole file. Both throw RunError if that fails.
void keep_bytes(const std::filesystem::path& file, std::string_view bytes);
std::string kept_bytes(const std::filesystem::path& file);

}  // namespace parray::scene_sandbox
