#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/scene/settings_fwd.h"
#include "common/schedule/cell_list.h"
#include "common/schedule/chunk_sizer.h"
#include "common/schedule/work_plan.h"
#include "proto/window.h"
#include "worker/lease_source.h"

/// Leases of the ranks of one mpirun, without anybody's help: see PROTOCOL.md, "The window".
namespace parray::worker {

/// What a rank traces for, through all passes.
struct RankJob {
  Boxed<RenderSettings> settings;  ///< resolved
  std::string scene_id;
  std::shared_ptr<const Scene> scene;  ///< let go when the first result is there
};

/// A pass, as every rank that takes part knows it.
struct RankPass {
  std::uint32_t number = 0;
  std::shared_ptr<const WorkPlan> plan;
  CellList missing;  ///< cells to trace: not those that an earlier life of the job has kept
};

/// How a rank sizes its leases; the same on every rank, but for `rank` and `threads`.
struct WindowOptions {
  SchedulePolicy policy = SchedulePolicy::weighted;
  std::uint32_t rank = 0;
  std::uint32_t threads = 1;
  std::uint32_t all_threads = 1;  ///< of all ranks
  /// A lease takes no message, so that short ones at the end cost little.
  LeaseLength length{.shortest = 0.0005};
};

/// The ledgers as a rank reaches them, by number, and how its group is made.
struct LedgerWindows {
  Ledgers ledgers;
  std::vector<Window*> windows;
};

/// Leases over a window: the rank takes a step number, or a run of cells, by an atomic addition and
/// computes its chunk. Weighted leases come from the ledger of its group, and when that is empty
/// from those of others. Long leases come in parts, so that results come in steadily and buffers
/// stay small. When nothing is left it draws a ticket and waits for a copy of cells that others
/// have not finished. A rank makes one for each window: its results are logged where only it
/// writes.
class WindowSource final : public LeaseSource {
 public:
  /// References outlive the object. `window` is rank 0's, and the one ledger if none are given.
  WindowSource(RankJob& job, const RankPass& pass, const WindowLayout& layout, Window& window,
               const WindowOptions& options, std::optional<LedgerWindows> ledgers = {});

  Taken take(Time now, double samples_per_second, bool idle) override;
  /// Throws RunError for a lease that failed: ranks do not outlive a failure.
  void complete(Time now, Finished finished) override;
  Time tick(Time now, const TeamState& team) override;
  void report(const WorkTally& tally) override;

  struct Part {
    Answer answer = Answer::none;
    CellRange cells;
    bool fresh = true;
  };
  /// As take() has it. A part has no more cells than one result may have.
  Part take_part(double samples_per_second, bool idle);
  /// Hands in the records of a part.
  void put(const CellRange& cells, std::span<const std::byte> records);
  /// Writes a word of this rank's own. With a beat it also reads whether rank 0 has told this rank
  /// to stop.
  void publish(WindowLayout::RankWord word, std::uint64_t value);
  /// Writes the log entry of `cells`, whose records are in the window: the second half of put().
  void log(const CellRange& cells, std::uint64_t digest);

 private:
  std::optional<CellRange> take_step();
  std::optional<CellRange> take_weighted(double samples_per_second);
  std::optional<CellRange> take_from(std::uint32_t ledger, double samples_per_second);
  [[nodiscard]] std::uint32_t ledger_after(std::uint32_t empty) const;
  Part take_copy();
  SpeedSum speed_of(std::uint32_t ledger, double samples_per_second);
  void cut(const CellRange& places, double samples_per_second);

  RankJob& job_;
  const RankPass& pass_;
  std::uint64_t parts_taken_ = 0;
  Time next_beat_{};
  const WorkPlan& plan_;
  const CellList& missing_;
  const WindowLayout& layout_;
  Window& window_;
  const WindowOptions options_;
  const ChunkSizer sizer_;
  std::vector<std::uint64_t> starts_;  ///< of the chunks; empty if weighted
  std::deque<CellRange> parts_;        ///< of the lease, not taken yet
  const LedgerWindows ledgers_;
  const std::uint32_t home_;         ///< this rank's ledger
  std::uint32_t empty_ledgers_ = 0;  ///< of those that it has looked at
  SpeedSum published_;               ///< this rank's part of its ledger's sum
  std::uint64_t next_entry_ = 0;     ///< of the log
  std::uint64_t entries_left_ = 0;   ///< of its block
  bool first_block_ = true;
  bool exhausted_ = false;
  bool stopped_ = false;  ///< rank 0 wants no more
  std::optional<std::uint64_t> ticket_;
};

}  // namespace parray::worker
