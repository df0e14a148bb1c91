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

/// What has been merged into a job's picture, by whom and when: a list that grows, about 90 bytes a
/// lease, from which anybody can prove that every cell of every pass counts once
/// (cli/check/audit/audit.h), and where the time went. Times are seconds since 1970.
struct JournalWorker {
  TracerKey tracer = 0;
  std::uint32_t threads = 0;
  std::string name;
};
struct JournalPass {
  std::uint32_t pass = 0;
  std::uint64_t cells = 0;
  double at = 0;
  ChunkGrain grain{};  ///< of its plan
};
/// Where the cells of a pass lie (coordinator/jobs/work_map.h).
struct JournalGrid {
  std::uint32_t pass = 0;
  GridShape shape;
};
struct JournalMerge {
  std::uint32_t pass = 0;
  TracerKey tracer = 0;
  std::uint64_t epoch = 0;
  CellRange range;
  std::uint64_t samples = 0;
  double granted = 0;
  double arrived = 0;
  double seconds = 0;        ///< spent tracing, as the worker says
  std::uint64_t digest = 0;  ///< XXH3-64 of the packed cells; 0: they never were packed
};
/// Cells whose results were wrong: they count as not traced.
struct JournalRetraction {
  std::uint32_t pass = 0;
  double at = 0;
  std::vector<CellRange> cells;
};
using JournalEntry =
    std::variant<JournalWorker, JournalPass, JournalMerge, JournalRetraction, JournalGrid>;

class Journal {
 public:
  /// Returns the entry's bytes, for the job's log.
  std::string add(const JournalEntry& entry);
  /// Takes in the bytes of an earlier life's entry. Throws DecodeError.
  void replay(std::string_view entry);
  /// The picture is begun again: what has been merged counts no more.
  void clear() { *this = {}; }

  [[nodiscard]] bool knows(TracerKey tracer) const { return workers_.contains(tracer); }
  [[nodiscard]] bool has_pass(std::uint32_t pass) const { return passes_.contains(pass); }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  void note(const JournalEntry& entry);

  std::string bytes_;
  std::set<TracerKey> workers_;
  std::set<std::uint32_t> passes_;
};

/// The entries of a journal's bytes. Throws DecodeError.
std::vector<JournalEntry> read_journal(std::string_view bytes);

}  // namespace parray::coordinator
