#pragma once

#include <filesystem>

#include "cli/farm/direct_render.h"
#include "cli/measure/plan/effort.h"

namespace parray::plan {

/// From now on large pieces of memory come from the system and go back to it: a render begins with
/// none, and pays for the first touch of each.
void forget_memory();

/// What a coordinator takes to check and merge what was traced.
struct Collecting {
  Effort again;     ///< in every pass
  Effort touching;  ///< once: memory is touched for the first time
};
Collecting effort_of_collecting(const Framebuffer& traced);

/// What comes after the last sample, done for nothing: estimates, hashes, and a file with
/// this extension in the system's directory for temporary files. Throws RunError.
Effort finish(const DirectRender& picture, const std::filesystem::path& extension);

}  // namespace parray::plan
