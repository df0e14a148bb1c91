#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "common/image/framebuffer.h"
#include "common/schedule/work_plan.h"
#include "proto/clock.h"
#include "proto/window.h"

namespace parray {

/// The coordinator's side of leases over a window: takes in what ranks have logged, checks it
/// against its digest, merges rows that are complete, and has unfinished cells traced again by
/// ranks that have nothing left to do.
///
/// Plain state: `now` is an argument. One thread. Never waits for anybody.
class WindowLedger {
 public:
  /// Which samples of a cell are not finite; asked for cells whose records say that there are some.
  using Locate = std::function<std::vector<ExcludedSamples>(const Cell&)>;

  /// `window` is for writing, `memory` for reading the same window in place; all references outlive
  /// the ledger. `framebuffer` holds what an earlier life of the job has finished.
  WindowLedger(const WorkPlan& plan, const WindowLayout& layout, Window& window,
               std::span<std::byte> memory, Framebuffer& framebuffer, Time now,
               Locate locate = no_location);

  /// Takes in logged results, about `most_cells` at a time. True if it found any.
  bool collect(Time now, std::uint64_t most_cells);

  /// Changes whenever a rank takes or hands in something.
  [[nodiscard]] std::uint64_t activity();

  /// Issues copies of unfinished cells to ranks that wait for them. Each round over the unfinished
  /// cells starts at least twice the time later that the one before took: a copy costs, too.
  void issue_copies(Time now);

  /// Counts on from the ledger of the pass before.
  void go_on_from(const WindowLedger& before);

  /// Tells all ranks to stop.
  void finish() { window_.store(WindowLayout::finished, 1); }

  [[nodiscard]] bool done() const { return done_cells_ == plan_.cells(); }
  /// Share of this life's cells that are in, 0 .. 1.
  [[nodiscard]] double progress() const;
  /// Share of this life's rows that are complete, 0 .. 1: what can be kept.
  [[nodiscard]] double complete_rows() const;
  [[nodiscard]] std::uint64_t done_cells() const { return done_cells_; }

  /// Rows that have become complete and were not taken yet, for the store, as one block of
  /// neighbours of at most 32 MiB; none when all are taken. A row that a late result has spoilt
  /// since is left out.
  std::optional<RowBlock> take_finished_rows();
  /// Rows that were left out.
  [[nodiscard]] std::uint64_t rows_left_out() const { return rows_left_out_; }

  /// Ranks at work that have not traced anything for `patience`.
  [[nodiscard]] std::vector<std::uint32_t> silent_ranks(Time now, Time patience) const;
  /// When a result came in, or any rank was seen to get on, last.
  [[nodiscard]] Time last_sign_of_life() const { return last_life_; }
  /// Looks at every rank's beat, and shows that rank 0 is alive.
  void listen(Time now);

  struct Tally {
    std::uint64_t entries = 0;     ///< results taken in
    std::uint64_t duplicates = 0;  ///< cells that came again with the same bits
    std::uint64_t mismatches = 0;  ///< cells that came again with other bits
    std::uint64_t corrupt = 0;     ///< results, and rows of cells, that did not match their digest
    std::uint64_t copies = 0;      ///< ranges issued once more
  };
  [[nodiscard]] const Tally& tally() const { return tally_; }
  /// A word of a rank's own.
  [[nodiscard]] std::uint64_t rank_value(std::uint32_t rank, WindowLayout::RankWord word);
  /// Time that each row took to trace, on one thread, by position in the row order.
  [[nodiscard]] const std::vector<std::uint64_t>& row_nanoseconds() const {
    return row_nanoseconds_;
  }

 private:
  static std::vector<ExcludedSamples> no_location(const Cell& /*cell*/) { return {}; }

  struct Entry {
    std::uint64_t index;
    Time since;  ///< when it was claimed, as far as we know
  };
  enum class Reading : std::uint8_t { taken, not_yet, corrupt };
  Reading read_entry(Time now, const Entry& entry);
  void take_cell(std::uint64_t cell, std::uint64_t digest);
  void merge_pass(std::uint64_t pass);
  struct Row {
    RowBlock block;
    std::uint64_t nanoseconds = 0;
    std::vector<std::uint64_t> spoilt;  ///< cells that are no longer what was taken in
  };
  [[nodiscard]] Row row_of(std::uint64_t pass) const;
  CellRange next_unfinished(std::uint64_t from, std::uint64_t most) const;

  const WorkPlan& plan_;
  const WindowLayout& layout_;
  Window& window_;
  std::span<std::byte> memory_;
  LocalWindow view_;
  Framebuffer& framebuffer_;
  Locate locate_;
  std::uint64_t next_entry_ = 0;
  std::vector<Entry> waiting_;                  ///< claimed, but not valid when last looked at
  std::vector<std::uint64_t> digests_;          ///< of each cell; 0: not in
  std::vector<std::uint64_t> cells_left_;       ///< of each pass
  std::set<std::uint64_t> fresh_passes_;        ///< complete, not taken for the store
  std::vector<std::uint64_t> row_nanoseconds_;  ///< by position
  std::uint64_t done_cells_ = 0;
  std::uint64_t merged_passes_ = 0;
  std::uint64_t rows_left_out_ = 0;
  bool behind_ = false;  ///< collect() has left results for the next time
  std::uint64_t copies_issued_ = 0;
  std::uint64_t copy_cursor_ = 0;
  Time hungry_since_ = never;
  Time round_began_{};
  Time next_round_{};
  struct Life {
    std::uint64_t beat = 0;
    Time changed{};
  };
  std::vector<Life> lives_;
  Time last_life_;
  Tally tally_;
};

}  // namespace parray
