#pragma once

#include <sched.h>

namespace parray {

/// CPUs that this process may use; at least 1. Not the machine's: a container or taskset may allow
/// fewer.
inline int usable_cpus() {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof set, &set) != 0) {
    return 1;
  }
  const int count = CPU_COUNT(&set);
  return count > 0 ? count : 1;
}

}  // namespace parray
