#pragma once

#include "common/rooms.h"

namespace parray::base {

/// CPUs that this process may use; at least 1. Not the machine's: an affinity mask (taskset,
/// cpusets, batch systems) or a quota of CPU time (cgroups: containers, systemd), which counts
/// rounded up, may allow fewer.
int usable_cpus();

}  // namespace parray::base
