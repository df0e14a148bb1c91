#pragma once

#include "common/rooms.h"

namespace parray::worker {

/// What the man page says beyond the options, in the form of common/process/manual_page.h.
inline constexpr const char* worker_manual =
    R"(One a machine; as many as you like, at any time. It traces with all processors that it may use, comes
back when the coordinator does, and goes round a list of addresses by itself: one that is silent is
left after 5 s. Workers hand scenes on to each other, at a free port, encrypted; where they cannot
reach each other the coordinator serves them, and `--sharing off` saves them the trying.

SIGTERM and Ctrl-C make it leave: its leases go to others at once.
)";

}  // namespace parray::worker
