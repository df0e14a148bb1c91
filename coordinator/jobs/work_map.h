#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "coordinator/jobs/journal.h"

namespace parray::coordinator {

/// Shows how much time each pixel of a job took and which worker traced it, from the journal.
struct WorkMap {
  static constexpr std::uint32_t no_worker = std::numeric_limits<std::uint32_t>::max();

  std::uint32_t width = 0;
  std::uint32_t height = 0;
  /// Thread-seconds of each pixel, row by row, the top row first. All samples of a lease count the
  /// same. Retracted results count, too.
  std::vector<float> seconds;
  /// Index in `workers` of the worker that traced the latest samples of each pixel, or `no_worker`.
  std::vector<std::uint32_t> tracer;
  std::vector<std::string> workers;  ///< names, in the order of the journal
};

/// Computes the map. Ignores leases of passes without a JournalGrid. Throws DecodeError if entries
/// contradict each other or the size of the picture.
WorkMap work_map(const std::vector<JournalEntry>& journal, std::uint32_t width,
                 std::uint32_t height);

}  // namespace parray::coordinator
