#pragma once

#include <filesystem>
#include <span>

#include "common/rooms.h"

namespace parray::farm {
struct DirectRender;
}
namespace parray::image {
class Framebuffer;
}

namespace parray::plan {

/// Time in seconds: wall-clock time, and processor time of all threads together.
struct Effort {
  double wall = 0;
  double cpu = 0;

  friend Effort operator+(Effort a, Effort b) { return {a.wall + b.wall, a.cpu + b.cpu}; }
  friend Effort operator-(Effort a, Effort b) { return {a.wall - b.wall, a.cpu - b.cpu}; }
  friend Effort operator*(double factor, Effort a) { return {factor * a.wall, factor * a.cpu}; }
};

/// Returns the time since an arbitrary start. The difference of two calls is the time between them.
Effort effort_now();

/// A traced pass.
struct TracedPass {
  double samples = 0;  ///< of all pixels together
  Effort effort;
};

/// The time of a pass with n samples, of all pixels together, is pass + n * sample. So `pass` is
/// the constant part, which does not depend on the number of samples.
struct PassCost {
  Effort pass;
  Effort sample;
  double doubt = 0;  ///< relative standard error of predicted wall-clock times, at least 0.05
};

/// Fits at least two passes. Least squares of relative errors give the constant part, at most 0.7
/// of the shortest pass. The rest of the total time gives the time per sample. The fit uses
/// processor time, which other programs disturb less. It assumes that busy processors lengthen the
/// wall-clock times of both parts by the same factor.
PassCost fit_pass_cost(std::span<const TracedPass> passes);

/// Returns the time per sample that fits `passes`, if the constant part of the time of each is
/// `pass`. The result accounts for at least 0.3 of their total time.
Effort sample_effort(std::span<const TracedPass> passes, Effort pass);

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
