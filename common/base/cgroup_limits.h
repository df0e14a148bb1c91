#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>

#include "common/rooms.h"

namespace parray::base {

/// What the control groups of this process allow it, of both versions (man 7 cgroups): the least of
/// its own group's limit and those above it, as far as they are mounted here.
struct CgroupLimits {
  double cpus = std::numeric_limits<double>::infinity();  ///< processor seconds a second, above 0
  std::uint64_t memory = std::numeric_limits<std::uint64_t>::max();  ///< bytes
};

/// Limits as files below `root` tell them; what is not there or not understood limits nothing.
CgroupLimits cgroup_limits(const std::filesystem::path& root = "/");

/// Bytes of memory that this process may use: the machine's, or fewer where a group limits it.
std::uint64_t usable_memory();

}  // namespace parray::base
