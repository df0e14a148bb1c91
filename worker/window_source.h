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
#include "common/schedule/cell_grid.h"
#include "common/schedule/chunk_sizer.h"
#include "common/schedule/work_plan.h"
#include "proto/window.h"
#include "worker/lease_source.h"

/// Leases of the ranks of one mpirun, which each rank takes itself: PROTOCOL.md, "The window".
namespace parray::worker {

/// The job of a rank. It is the same in all passes.
struct RankJob {
  Boxed<RenderSettings> settings;      ///< no value is `automatic`, except perhaps `isa`
  std::string scene_id;                ///< scene_identity()
  std::shared_ptr<const Scene> scene;  ///< WindowSource sets it to null at the rank's first result
};

/// A pass. It is the same on every rank.
struct RankPass {
  std::shared_ptr<const WorkPlan> plan;
  CellList missing;  ///< cells to trace: all except those stored by an earlier run of the job
};

/// The options for sizing leases. All but `rank` and `threads` are the same on every rank.
struct WindowOptions {
  SchedulePolicy policy = SchedulePolicy::weighted;
  std::uint32_t rank = 0;
  std::uint32_t threads = 1;
  std::uint32_t all_threads = 1;  ///< sum over all ranks
  /// In seconds. Short leases at the end cost little, because a lease needs no message.
  LeaseLength length{.shortest = 0.0005};
};

/// The division of the ranks into groups, and the window of each ledger.
struct LedgerWindows {
  Ledgers ledgers;
  std::vector<Window*> windows;  ///< by number of the ledger; not owned
};

/// Takes leases over a window, by atomic additions. PROTOCOL.md, "The window", explains the words.
/// With the policy `weighted`, the rank takes a run of cells from the ledger of its group. If that
/// ledger is empty, it tries three others at most. With other policies, the rank takes the number
/// of a chunk and computes the chunk's cells. Long leases come in parts, so that results arrive
/// steadily and buffers stay small. If no work is left, the rank draws a ticket and waits for a
/// copy of unfinished cells. A rank makes one object for each pass. Its log entries go where no
/// other rank writes.
class WindowSource final : public LeaseSource {
 public:
  /// The references must outlive the object. `window` is rank 0's. Without `ledgers`, it is also
  /// the only ledger.
  WindowSource(RankJob& job, const RankPass& pass, const WindowLayout& layout, Window& window,
               const WindowOptions& options, std::optional<LedgerWindows> ledgers = {});

  Taken take(Time now, double samples_per_second, bool idle) override;
  /// Throws RunError if the lease failed, because a failure ends the whole mpirun.
  void complete(Time now, LeaseResult finished) override;
  Time tick(Time now, const TeamState& team) override;
  void report(const WorkTally& tally) override;

  /// A part of a lease. Its records fit into one result.
  struct Part {
    Answer answer = Answer::none;
    CellRange cells;
    bool fresh = true;  ///< see LeaseSource::Taken
  };
  /// Takes a part with the arguments of take().
  Part take_part(double samples_per_second, bool idle);
  /// Writes the records of a part to the window, then their log entry.
  void put(const CellRange& cells, std::span<const std::byte> records);
  /// Writes one of this rank's words. After a heartbeat it also reads whether rank 0 stops this
  /// rank.
  void publish(WindowLayout::RankWord word, std::uint64_t value);
  /// Writes the log entry of `cells`. Their records must be in the window; `digest` is their
  /// range_digest(). put() calls this function.
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
  Time next_heartbeat_{};
  const WorkPlan& plan_;
  const CellList& missing_;
  const WindowLayout& layout_;
  Window& window_;
  const WindowOptions options_;
  const ChunkSizer sizer_;
  std::vector<std::uint64_t> starts_;  ///< first cells of the chunks; empty if weighted
  std::deque<CellRange> parts_;        ///< remaining parts of the lease
  const LedgerWindows ledgers_;
  const std::uint32_t home_;         ///< the ledger of this rank's group
  std::uint32_t empty_ledgers_ = 0;  ///< number of ledgers found empty
  SpeedSum published_;               ///< this rank's part of the ledger's sum of speeds
  std::uint64_t next_entry_ = 0;     ///< next entry of the log
  std::uint64_t entries_left_ = 0;   ///< free entries in the current block
  bool first_block_ = true;
  bool exhausted_ = false;
  bool stopped_ = false;  ///< rank 0 has stopped this rank
  std::optional<std::uint64_t> ticket_;
};

}  // namespace parray::worker
