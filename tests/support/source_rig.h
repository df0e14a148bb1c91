#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "common/scene/settings.h"
#include "tests/support/rooms.h"
#include "tests/support/window_rig.h"

namespace parray::test {

using enum SchedulePolicy;
using Answer = LeaseSource::Answer;
using Word = WindowLayout::Word;

/// The window of a job and the lease sources of its ranks, which have the same number of threads.
struct SourceRig : WindowRig {
  SourceRig(const RenderSettings& its_settings, std::uint32_t ranks, SchedulePolicy policy,
            std::uint32_t threads = 1, std::uint32_t tile = 0,
            const std::vector<CellRange>& done = {})
      : WindowRig(its_settings, ranks, tile, done) {
    options.policy = policy;
    options.threads = threads;
    options.all_threads = threads * ranks;
  }
  WindowSource rank(std::uint32_t number) {
    WindowOptions own = options;
    own.rank = number;
    return {job, pass, layout, window, own, ledgers};
  }
  /// Makes several ledgers, each in separate memory.
  void split(std::uint32_t ledger_ranks) {
    ledgers.emplace(LedgerWindows{Ledgers(layout.ranks(), ledger_ranks), {}});
    for (std::uint32_t ledger = 0; ledger < ledgers->ledgers.count(); ++ledger) {
      ledger_memory.emplace_back(WindowLayout::shared_words * sizeof(std::uint64_t));
      kept.push_back(std::make_unique<LocalWindow>(ledger_memory.back().bytes()));
      ledgers->windows.push_back(kept.back().get());
    }
  }
  WindowSource rank(std::uint32_t number, double shortest, double longest) {
    options.length = {shortest, longest};
    return rank(number);
  }
  [[nodiscard]] std::uint64_t left() { return plan().cells() - window.load(Word::position); }

  WindowOptions options;
  std::optional<LedgerWindows> ledgers;
  std::deque<WindowMemory> ledger_memory;
  std::vector<std::unique_ptr<LocalWindow>> kept;
};

inline RenderSettings medium() { return made_settings(60, 40, 700); }

/// Returns whether the ranges contain each of the plan's cells exactly once.
inline bool is_partition(std::vector<CellRange> ranges, std::uint64_t cells) {
  std::sort(ranges.begin(), ranges.end(),
            [](const CellRange& a, const CellRange& b) { return a.begin < b.begin; });
  std::uint64_t end = 0;
  for (const CellRange& range : ranges) {
    if (range.begin != end || range.end <= range.begin) return false;
    end = range.end;
  }
  return end == cells;
}

/// Takes all leases. Reports `speed` after the first one.
inline std::vector<CellRange> take_all(WindowSource& source, double speed) {
  std::vector<CellRange> parts;
  for (auto part = source.take_part(0, false); part.answer == Answer::lease;
       part = source.take_part(speed, false)) {
    parts.push_back(part.cells);
  }
  return parts;
}

/// Takes the rank's next lease, which has `cells` cells. Its parts follow each other without a gap,
/// and only the first is fresh.
inline CellRange take_lease(WindowSource& source, std::uint64_t cells, double speed = 0) {
  CellRange lease;
  for (bool fresh = true; lease.count() < cells; fresh = false) {
    const auto part = source.take_part(speed, false);
    REQUIRE(part.answer == Answer::lease);
    REQUIRE(part.fresh == fresh);
    REQUIRE((fresh || part.cells.begin == lease.end));
    lease = {fresh ? part.cells.begin : lease.begin, part.cells.end};
  }
  return lease;
}

/// Takes the rank's next weighted lease, and returns its number of cells.
inline double weighted_cells(SourceRig& rig, WindowSource& source, double speed) {
  const std::uint64_t before = rig.window.load(Word::position);
  const CellRange first = source.take_part(speed, false).cells;
  const std::uint64_t count = rig.window.load(Word::position) - before;
  for (std::uint64_t taken = first.count(); taken < count;) {
    const auto part = source.take_part(speed, false);
    REQUIRE_FALSE(part.fresh);
    taken += part.cells.count();
  }
  return static_cast<double>(count);
}

/// A window that records the places of all puts, in their order.
class OrderWindow final : public Window {
 public:
  explicit OrderWindow(Window& window) : window_(window) {}
  std::uint64_t fetch_add(std::size_t word, std::uint64_t delta) override {
    return window_.fetch_add(word, delta);
  }
  std::uint64_t load(std::size_t word) override { return window_.load(word); }
  void store(std::size_t word, std::uint64_t value) override { window_.store(word, value); }
  void put(std::size_t offset, std::span<const std::byte> bytes) override {
    offsets.push_back(offset);
    window_.put(offset, bytes);
  }
  std::vector<std::size_t> offsets;

 private:
  Window& window_;
};

inline ChunkRequest job_of(const SourceRig& rig) {
  ChunkRequest job;
  job.total = rig.pass.missing.count();
  job.remaining = job.total;
  job.row_units = rig.plan().grid()->cells_per_row();
  job.workers = rig.layout.ranks();
  job.threads = rig.options.threads;
  return job;
}

}  // namespace parray::test
