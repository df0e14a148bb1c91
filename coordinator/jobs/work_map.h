#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "coordinator/jobs/journal.h"

namespace parray::coordinator {

/// Where the time of a job went, and who traced what, by its journal.
struct WorkMap {
  static constexpr std::uint32_t nobody = std::numeric_limits<std::uint32_t>::max();

  std::uint32_t width = 0;
  std::uint32_t height = 0;
  /// Seconds of one thread that each pixel took, image order: those of a lease, all that its worker
  /// spent on it, evenly over the samples that it held.
  std::vector<float> seconds;
  /// Number in `workers` of whoever traced the latest samples of each pixel; or nobody.
  std::vector<std::uint32_t> tracer;
  std::vector<std::string> workers;  ///< names, as they came
};

/// Leases of passes whose cells the journal does not place (it was begun by an earlier version)
/// are left out. Throws DecodeError where entries do not fit each other, or the picture.
WorkMap work_map(const std::vector<JournalEntry>& journal, std::uint32_t width,
                 std::uint32_t height);

}  // namespace parray::coordinator
