#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "common/schedule/cell_grid.h"
#include "common/schedule/chunk_sizer.h"
#include "coordinator/leases/result_collector.h"

namespace parray::coordinator {

// The journal lists which worker traced which merged cells, and when: 80 bytes per lease. It proves
// that every cell of every pass counts once (cli/check/audit/audit.h), and it shows where the time
// was spent. `at`, `granted` and `arrived` are seconds since 1970.

/// A worker. It precedes the worker's first merge.
struct JournalWorker {
  TracerKey tracer = 0;
  std::uint32_t threads = 0;
  std::string name;
};
/// A pass has begun.
struct JournalPass {
  std::uint32_t pass = 0;
  std::uint64_t cells = 0;
  double at = 0;
  ChunkGrain grain{};  ///< of the pass's plan
};
/// The positions of a pass's cells, for work_map.h.
struct JournalGrid {
  std::uint32_t pass = 0;
  GridShape shape;
};
/// The cells of a lease were merged.
struct JournalMerge {
  std::uint32_t pass = 0;
  TracerKey tracer = 0;
  std::uint64_t epoch = 0;
  CellRange range;
  std::uint64_t samples = 0;
  double granted = 0;        ///< when the lease was granted
  double arrived = 0;        ///< when its result arrived
  double seconds = 0;        ///< duration of tracing that the worker reported
  std::uint64_t digest = 0;  ///< XXH3-64 of the packed cells; 0: they were not packed
};
/// Results of the pass were removed, because a faulty machine had traced some of them. If it traced
/// a cell of a pixel, all cells with this pixel are removed, also those of other machines. `cells`
/// are the removed cells. They count as not traced.
struct JournalRetraction {
  std::uint32_t pass = 0;
  double at = 0;
  std::vector<CellRange> cells;
};
using JournalEntry =
    std::variant<JournalWorker, JournalPass, JournalMerge, JournalRetraction, JournalGrid>;

/// The journal of one job, encoded. Not thread-safe.
class Journal {
 public:
  /// Appends an entry. Returns its bytes, for the job's log.
  std::string add(const JournalEntry& entry);
  /// Appends the bytes of an entry that an earlier process wrote. Throws DecodeError.
  void replay(std::string_view entry);
  /// Removes all entries, because the picture restarts.
  void clear() { *this = {}; }

  /// Returns whether there is a JournalWorker for `tracer`.
  [[nodiscard]] bool knows(TracerKey tracer) const { return workers_.contains(tracer); }
  [[nodiscard]] bool has_pass(std::uint32_t pass) const { return passes_.contains(pass); }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  void note(const JournalEntry& entry);

  std::string bytes_;
  std::set<TracerKey> workers_;
  std::set<std::uint32_t> passes_;
};

/// Decodes a journal. Throws DecodeError.
std::vector<JournalEntry> read_journal(std::string_view bytes);

/// Returns the message for a user whose job has a damaged journal. `damage`: what the DecodeError
/// of read_journal() or work_map() says.
std::string damaged_journal(std::uint64_t job, const std::string& damage);

}  // namespace parray::coordinator
