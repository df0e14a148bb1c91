#pragma once

#include <filesystem>

#include "cli/farm/direct_render.h"
#include "cli/measure/plan/effort.h"

namespace parray::plan {

/// Makes the allocator return each large block to the system when it is freed, from now on. Then
/// measurements begin without memory of earlier ones, as a new render does, and include the time
/// for touching each page for the first time. Call it before other threads allocate.
void forget_memory();

/// Time that a coordinator takes to check and merge the results of a pass.
struct Collecting {
  Effort again;     ///< time of each pass
  Effort touching;  ///< additional time of the first pass: it touches memory for the first time
};
/// Measures this time for a pass that gives each pixel as many samples as it has in `traced`.
Collecting effort_of_collecting(const Framebuffer& traced);

/// Measures the steps after the last sample: estimates, hashes, and writing a file with the
/// extension `extension` (".exr") to the directory for temporary files. Throws RunError.
Effort measure_overheads(const DirectRender& picture, const std::filesystem::path& extension);

}  // namespace parray::plan
