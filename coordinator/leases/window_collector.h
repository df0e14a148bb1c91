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

/// Rank 0's threads, and those of all ranks together.
struct RankThreads {
  std::uint32_t own = 1;
  std::uint32_t all = 1;
};

/// The coordinator's side of leases over a window, for one pass: takes in what ranks have logged,
/// checks it against its digest, merges it, and has missing cells traced again by ranks that have
/// nothing left to do.
///
/// Plain state: `now` is an argument. One thread calls it. Never waits for anybody.
class WindowCollector {
 public:
  /// What comes of a job, pass after pass.
  struct Totals {
    std::uint64_t entries = 0;     ///< results taken in
    std::uint64_t duplicates = 0;  ///< cells that came again with the same bits
    std::uint64_t mismatches = 0;  ///< cells that came again with other bits
    std::uint64_t corrupt = 0;     ///< results that did not match their digest, or cannot be
    std::uint64_t copies = 0;      ///< ranges issued once more
    /// Time that each row of the image took to trace, on one thread.
    std::vector<std::uint64_t> row_nanoseconds{};
  };
  /// Called by one thread at a time, but perhaps not by the one that calls the collector.
  struct Hooks {
    /// Which samples of a batch of one cell are not finite; asked where its record says that some
    /// are. Sorted.
    std::function<std::vector<ExcludedSamples>(const CellBatch& cell)> locate;
    /// Gets every result that has brought something new, when it is merged.
    std::function<void(TracerKey tracer, TracedCells cells)> merged;
  };

  /// `picture`, which `judge` speaks of, has begun the pass. `window` is for writing, `memory` for
  /// reading the same window in place; all references outlive the object.
  WindowCollector(JobPicture& picture, RankJudge& judge, const WindowLayout& layout, Window& window,
                  std::span<const std::byte> memory, Time now, Totals& totals, Hooks hooks,
                  RankThreads threads = {});

  /// Takes in logged results, about `most_cells` at a time, with merging_threads() threads. True if
  /// it found any.
  bool collect(Time now, std::uint64_t most_cells);
  /// The last collect() has left results for the next.
  [[nodiscard]] bool behind() const { return behind_; }
  /// Of so many ranks that rank 0's threads do better to take results in than to trace, as long as
  /// results come.
  [[nodiscard]] bool wants_all_threads(Time now) const;
  /// Threads that take results in.
  [[nodiscard]] std::uint32_t merging_threads() const { return merging_threads_; }
  /// All cells are in, and rank 0 has checked what it had to.
  [[nodiscard]] bool done() const {
    return !overtaken() && picture_.collector().done() && !judge_.has_rechecks();
  }
  /// The picture was begun again, because a faulty rank's bits had decided its passes.
  [[nodiscard]] bool overtaken() const { return picture_.plan() != plan_; }
  /// Share of the pass's cells that are in, those of earlier lives included, 0 .. 1.
  [[nodiscard]] double progress() const;

  /// Issues copies of missing cells to ranks that wait for them. Each round over the missing cells
  /// starts at least twice the time later that the one before took: a copy costs, too.
  void issue_copies(Time now);
  /// Tells all ranks to stop: those that wait at once, those at work with their next beat.
  void finish();

  /// Looks at every rank's beat, and shows that rank 0 is alive.
  void listen(Time now);
  /// Ranks at work that have not traced anything for `patience`.
  [[nodiscard]] std::vector<std::uint32_t> silent_ranks(Time now, Time patience) const;
  /// When a result came in, or any rank was seen to get on, last.
  [[nodiscard]] Time last_sign_of_life() const { return last_life_; }
  /// Changes whenever a rank takes or hands in something.
  [[nodiscard]] std::uint64_t activity() const;
  /// A word of a rank's own.
  [[nodiscard]] std::uint64_t rank_value(std::uint32_t rank, WindowLayout::RankWord word) const {
    return load(WindowLayout::rank_word(rank, word));
  }

 private:
  struct Entry {
    std::uint64_t index;
    Time since;  ///< when it was there, as far as we know
  };
  /// What is left of a block of the log.
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
  std::mutex mutex_;  ///< of what follows a check: picture, totals, hooks
  std::vector<Block> blocks_;
  std::uint64_t claimed_blocks_ = 0;
  std::vector<Entry> waiting_;  ///< not taken in yet
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
  std::size_t verdicts_heeded_ = 0;
  Time last_life_;
};

}  // namespace parray::coordinator
