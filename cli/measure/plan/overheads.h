#pragma once

#include <filesystem>

#include "cli/farm/direct_render.h"
#include "cli/measure/plan/effort.h"

namespace parray::plan {

/// Makes the allocator return large blocks to the system from now on. Then measurements begin
/// without memory of earlier ones, as a new render does, and include the time for touching each
/// page for the first time.
void forget_memory();

/// Time that a coordinator takes to check and merge results.
struct Collecting {
  Effort again;     ///< time of each pass
  Effort touching;  ///< additional time of the first pass: it touches memory for the first time
};
Collecting effort_of_collecting(const Framebuffer& traced);

/// Measures the steps after the last sample: estimates, hashes, and writing a file with this
/// extension to the directory for temporary files. Throws RunError.
Effort measure_overheads(const DirectRender& picture, const std::filesystem::path& extension);

}  // namespace parray::plan
