#pragma once

#include <string_view>

#include "common/scene/settings.h"

namespace parray {

/// The instruction sets that this processor, and its operating system, can run.
bool runs_on_this_machine(Isa isa);

/// The best of them.
Isa best_isa();

}  // namespace parray
