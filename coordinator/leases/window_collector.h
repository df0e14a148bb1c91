#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <span>
#include <vector>

#include "coordinator/jobs/job_picture.h"
#include "coordinator/leases/rank_judge.h"
#include "proto/clock.h"
#include "proto/window.h"

namespace parray::coordinator {

/// Numbers of threads of rank 0 and of all ranks together.
struct RankThreads {
  std::uint32_t own = 1;
  std::uint32_t all = 1;
};

/// Collects the results of one pass of an mpirun. The ranks put results into the window, the memory
/// of rank 0 (proto/window.h), and log an entry for each. This object reads the entries, checks the
/// results against their digests and merges them. If ranks have no work left, it lets them trace
/// cells again that other ranks have not returned yet (copies).
///
/// Not thread-safe. Reads no clock: `now` is an argument. Never waits.
class WindowCollector {
 public:
  /// Counts over all passes of a job.
  struct Totals {
    std::uint64_t entries = 0;     ///< accepted results, also those without a new cell
    std::uint64_t duplicates = 0;  ///< repeated cells with the same bits
    std::uint64_t mismatches = 0;  ///< repeated cells with other bits
    std::uint64_t corrupt = 0;     ///< results with a wrong digest or impossible numbers
    std::uint64_t copies = 0;      ///< ranges that were issued again
    /// Tracing time of each row of the picture, in thread-nanoseconds.
    std::vector<std::uint64_t> row_nanoseconds{};
  };
  /// Callbacks. One thread at a time calls them; it may be a merging thread.
  struct Hooks {
    /// Returns the non-finite samples of a cell, sorted. Called if the cell's record counts any:
    /// the window does not hold which samples these are.
    std::function<std::vector<ExcludedSamples>(const CellBatch& cell)> locate;
    /// Called after a result with new cells was merged.
    std::function<void(TracerKey tracer, TracedCells cells)> merged;
  };

  /// `picture` must have begun the pass; `judge` must belong to it. `window` serves for writing,
  /// `memory` for reading the same window in place. All references must outlive this object.
  WindowCollector(JobPicture& picture, RankJudge& judge, const WindowLayout& layout, Window& window,
                  std::span<const std::byte> memory, Time now, Totals& totals, Hooks hooks,
                  RankThreads threads = {});

  /// Merges logged results of about `most_cells` cells with merging_threads() threads. Also lets
  /// the judge trace a few of its rechecks, and stops faulty ranks. False: it has accepted no
  /// result.
  bool collect(Time now, std::uint64_t most_cells);
  /// Returns whether the last collect() left logged results for the next call.
  [[nodiscard]] bool behind() const { return behind_; }
  /// Returns whether all threads of rank 0 should merge results instead of tracing: there are very
  /// many threads for each thread of rank 0, and the last result was merged, or the pass begun,
  /// less than a second ago.
  [[nodiscard]] bool wants_all_threads(Time now) const;
  /// Returns the number of threads that merge results.
  [[nodiscard]] std::uint32_t merging_threads() const { return merging_threads_; }
  /// Returns whether all cells are merged and rank 0 has no cells to check.
  [[nodiscard]] bool done() const {
    return !overtaken() && picture_.collector().done() && !judge_.has_rechecks();
  }
  /// Returns whether the picture has restarted, because a faulty rank's bits had influenced its
  /// passes. Then this object is obsolete.
  [[nodiscard]] bool overtaken() const { return picture_.plan() != plan_; }

  /// Issues copies of missing cells to ranks that wait for work. Copies cost time. So after a round
  /// over all missing cells, the next round begins after twice the duration of this one, at least
  /// 50 ms.
  void issue_copies(Time now);
  /// Ends the pass for ranks that find no work left. If overtaken(), also stops the ranks that are
  /// still tracing, at their next heartbeat.
  void finish();

  /// Reads the heartbeats of all ranks and increments that of rank 0.
  void listen(Time now);
  /// Returns the ranks that are tracing or building but made no progress for `patience`.
  [[nodiscard]] std::vector<std::uint32_t> silent_ranks(Time now, Time patience) const;
  /// Returns when the last result was merged or the last heartbeat changed.
  [[nodiscard]] Time last_sign_of_life() const { return last_life_; }
  /// Returns a number that changes when a result is merged, a rank finds no work left, or a rank
  /// takes work from the memory of rank 0.
  [[nodiscard]] std::uint64_t activity() const;
  /// Returns a word of the window that belongs to a rank.
  [[nodiscard]] std::uint64_t rank_value(std::uint32_t rank, WindowLayout::RankWord word) const {
    return load(WindowLayout::rank_word(rank, word));
  }

 private:
  struct Entry {
    std::uint64_t index;
    Time since;  ///< when this object first saw it
  };
  /// The part of a block of the log that is not read yet.
  struct Block {
    std::uint64_t next;
    std::uint64_t end;
  };
  void find_entries(Time now);
  void find_gaps(Time now);
  [[nodiscard]] std::size_t entries_of(std::uint64_t most_cells);
  bool read_entry(Time now, const Entry& entry);
  bool take(std::uint32_t rank, const CellRange& range, std::uint64_t digest);
  void merge(std::uint32_t rank, TracedCells traced, std::vector<std::uint64_t> digests,
             std::span<const Cell> cells);
  [[nodiscard]] std::vector<CellRange> cells_in(const CellRange& range) const;
  void stop_faulty_ranks();
  bool complete(TracedCells& traced, std::span<const Cell> cells);
  [[nodiscard]] std::uint64_t load(std::size_t word) const;

  JobPicture& picture_;
  RankJudge& judge_;
  const std::shared_ptr<const WorkPlan> plan_;
  const WindowLayout& layout_;
  Window& window_;
  std::span<const std::byte> memory_;
  Totals& totals_;
  const Hooks hooks_;
  const bool many_ranks_;
  const std::uint32_t merging_threads_;
  std::mutex mutex_;  ///< guards picture, totals and hooks in merging threads
  std::vector<Block> blocks_;
  std::uint64_t claimed_blocks_ = 0;
  std::vector<Entry> waiting_;  ///< entries that are not merged yet
  bool behind_ = false;
  Time last_entry_;
  std::uint64_t copies_issued_ = 0;
  std::uint64_t copy_cursor_ = 0;
  Time waiting_since_ = never;
  Time round_began_{};
  Time next_round_{};
  struct Life {
    std::uint64_t beat = 0;
    Time changed{};
  };
  std::vector<Life> lives_;
  std::size_t verdicts_applied_ = 0;
  Time last_life_;
};

}  // namespace parray::coordinator
