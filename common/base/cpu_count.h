#pragma once

#include "common/rooms.h"

namespace parray::base {

/// Returns the number of CPUs that this process may use; at least 1. The number may be below the
/// machine's. An affinity mask (taskset, cpusets, batch systems) limits it, and so does a quota of
/// CPU time (cgroups: containers, systemd), rounded up.
int usable_cpus();

}  // namespace parray::base
