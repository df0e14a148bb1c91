#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "common/schedule/work_plan.h"
#include "proto/window.h"

namespace parray {

/// Where a rank gets its leases from and where the results go: over the window, or by messages to
/// the coordinator. One thread.
class LeaseSource {
 public:
  virtual ~LeaseSource() = default;

  enum class Answer : std::uint8_t {
    lease,  ///< trace `range`
    wait,   ///< nothing to do now: ask again in a few milliseconds
    over    ///< every cell is in, or the job has been given up
  };
  struct Taken {
    Answer answer = Answer::wait;
    CellRange range;
  };
  /// `samples_per_second`: of this rank, as measured; 0: not yet. `idle`: it has nothing to do, so
  /// that a copy of what others have not finished is better than nothing.
  virtual Taken take(double samples_per_second, bool idle) = 0;

  /// Hands in the records of a range, of at most most_cells_in_word cells, which lay in one lease.
  virtual void complete(const CellRange& range, std::span<const std::byte> records) = 0;

  /// Says that this rank is alive, and how it fares.
  virtual void tell(WindowLayout::RankWord word, std::uint64_t value) = 0;
};

}  // namespace parray
