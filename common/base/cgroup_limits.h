#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>

#include "common/rooms.h"

namespace parray::base {

/// The limits that the control groups of this process set, in both versions (man 7 cgroups). Each
/// is the smallest limit of the process's own group and of those above it, as far as they are
/// mounted here.
struct CgroupLimits {
  /// Processor seconds per second, above 0. Infinity: no limit.
  double cpus = std::numeric_limits<double>::infinity();
  /// Bytes. The largest number: no limit.
  std::uint64_t memory = std::numeric_limits<std::uint64_t>::max();
};

/// Reads the limits from proc/self/ and the mounted control groups below `root`, which tests
/// replace. A missing or unreadable file sets no limit.
CgroupLimits cgroup_limits(const std::filesystem::path& root = "/");

/// Returns the bytes of memory that this process may use: the machine's memory, or less if a group
/// limits it.
std::uint64_t usable_memory();

}  // namespace parray::base
