#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <thread>
#include <vector>

#include "common/base/error.h"
#include "tests/support/dice.h"
#include "tests/support/rooms.h"
#include "tests/support/source_rig.h"
#include "worker/window_source.h"

namespace parray::test {
namespace {

using Rig = SourceRig;

}  // namespace

TEST_CASE("a result is at its offset and in the log, with its digest and its rank") {
  Rig rig(medium(), 2, weighted);
  WindowSource rank = rig.rank(1);
  const CellRange range{4, 9};
  const auto records = made_records(rig.plan(), range);
  rank.put({0, 1}, made_records(rig.plan(), {0, 1}));
  rank.put(range, records);
  const std::size_t offset = rig.layout.record_offset(4);
  CHECK(std::equal(records.begin(), records.end(),
                   rig.memory.bytes().begin() + static_cast<std::ptrdiff_t>(offset)));
  CHECK(rig.window.load(Word::log_head) == 0);  // the first block is the rank's own
  const std::size_t entry = rig.layout.log_word(WindowLayout::block_entries + 1);
  CHECK(rig.window.load(entry) == to_word(range));
  CHECK(rig.window.load(entry + 1) ==
        entry_digest(range_digest(cell_digests(records, rig.layout.record_bytes())), 1));
  CHECK(rig.window.load(entry + 2) == 2);
  rank.publish(WindowLayout::takes, 17);
  CHECK(rig.window.load(WindowLayout::rank_word(1, WindowLayout::takes)) == 17);
}

TEST_CASE("a result is put before its log entry") {
  Rig rig(medium(), 2, weighted);
  OrderWindow window(rig.window);
  WindowSource rank(rig.job, rig.pass, rig.layout, window, rig.options);
  rank.put({4, 9}, made_records(rig.plan(), {4, 9}));
  CHECK(window.offsets ==
        std::vector<std::size_t>{rig.layout.record_offset(4), 8 * rig.layout.log_word(0)});
}

TEST_CASE("a rank that has filled its block of the log claims a new one") {
  Rig rig(made_settings(60, 4, 2000), 2, weighted);
  WindowSource first = rig.rank(0);
  WindowSource second = rig.rank(1);
  REQUIRE(rig.plan().cells() > 5 * WindowLayout::block_entries);
  for (std::uint64_t cell = 0; cell < rig.plan().cells(); ++cell) {
    WindowSource& rank = cell % 3 == 0 ? first : second;
    rank.put({cell, cell + 1}, made_records(rig.plan(), {cell, cell + 1}));
  }
  rig.collect();
  CHECK(rig.collector.done());
  CHECK(rig.totals.duplicates == 0);
}

TEST_CASE("a full log stays unchanged") {
  Rig rig(made_settings(8, 2, 3), 1, weighted);
  WindowSource rank = rig.rank(0);
  for (std::uint64_t entry = 0; entry < WindowLayout::block_entries; ++entry) rank.log({0, 1}, 5);
  rig.window.store(Word::log_head, rig.layout.log_blocks());
  const auto before = std::vector(rig.memory.bytes().begin(), rig.memory.bytes().end());
  rank.log({0, 1}, 5);
  rig.window.store(Word::log_head, rig.layout.log_blocks());
  CHECK(std::equal(before.begin(), before.end(), rig.memory.bytes().begin()));
}

TEST_CASE("a long lease has parts of half a second, without gaps or overlaps") {
  Rig rig(made_settings(1000, 1000, 500), 2, static_split);
  WindowSource rank = rig.rank(0);
  const std::uint64_t half = rig.plan().cells() / 2;
  std::uint64_t end = 0;
  for (int i = 0; end < half; ++i) {
    const auto part = rank.take_part(i == 0 ? 0 : 1e7, false);
    REQUIRE(part.answer == Answer::lease);
    CHECK(part.cells.begin == end);
    // The first lease is cut before any speed is known.
    CHECK(static_cast<double>(part.cells.count()) * rig.plan().cell_samples() <= 1e6);
    end = part.cells.end;
  }
  CHECK(end == half);
  CHECK(rank.take_part(1e7, false).fresh);  // the other half
}

TEST_CASE("no part is larger than the largest result") {
  Rig rig(made_settings(8192, 1000, 1), 1, static_split);
  WindowSource rank = rig.rank(0);
  for (auto part = rank.take_part(1e15, false); part.answer == Answer::lease;
       part = rank.take_part(1e15, false)) {
    CHECK(part.cells.count() * rig.layout.record_bytes() <= std::size_t{1} << 25);
  }
}

TEST_CASE("ranks lease only the missing cells of a pass that an earlier run began") {
  Dice dice(7);
  for (const SchedulePolicy policy : {static_split, guided, factoring, weighted}) {
    for (int i = 0; i < 10; ++i) {
      CAPTURE(name_of(policy));
      const std::uint64_t cells = whole_plan(medium())->cells();
      std::vector<CellRange> done;
      for (std::uint64_t cell = dice.below(20); cell + 20 < cells; cell += 1 + dice.below(90)) {
        done.push_back({cell, cell + 1 + dice.below(19)});
        cell = done.back().end;
      }
      Rig rig(medium(), 2, policy, 1, 0, done);
      std::vector<CellRange> all = done;
      WindowSource first = rig.rank(0);
      WindowSource second = rig.rank(1);
      for (bool found = true; found;) {
        found = false;
        for (WindowSource* rank : {&first, &second}) {
          const auto part = rank->take_part(1e6, false);
          if (part.answer == Answer::lease) {
            found = true;
            all.push_back(part.cells);
            rank->put(part.cells, made_records(rig.plan(), part.cells));
          }
        }
      }
      CHECK(is_partition(all, rig.plan().cells()));
      rig.collect();
      CHECK(rig.totals.duplicates == 0);
      CHECK(same_sums(rig.picture.framebuffer(), made_framebuffer(rig.settings)));
    }
  }
}

TEST_CASE("a lease contains everything for tracing, and the source releases the scene afterwards") {
  Rig rig(medium(), 1, weighted);
  rig.job.scene = std::make_shared<const Scene>(small_scene());
  WindowSource source = rig.rank(0);
  auto first = source.take(Time(0), 0, true);
  auto second = source.take(Time(0), 0, true);
  CHECK(first.lease.scene == rig.job.scene);
  CHECK(first.lease.scene_id == "made up");
  CHECK(first.lease.settings == rig.settings);
  CHECK_FALSE(first.lease.key() == second.lease.key());
  CHECK(source.wants(first.lease.key()));
  CHECK(first.samples ==
        static_cast<double>(first.lease.cells.range.count()) * rig.plan().cell_samples());
  LeaseResult finished;
  finished.cells = std::make_shared<const TracedCells>(made_cells(first.lease.cells));
  source.complete(Time(0), finished);
  CHECK_FALSE(rig.job.scene);
  rig.collect();
  CHECK(rig.picture.collector().done_cells() == first.lease.cells.range.count());
  finished.cells.reset();
  finished.failure = "not enough memory";
  CHECK_THROWS_WITH_AS(source.complete(Time(0), finished), "tracing: not enough memory", RunError);
}

TEST_CASE("a rank's heartbeat shows its samples and its team's state, four times a second") {
  Rig rig(medium(), 2, weighted);
  WindowSource source = rig.rank(1);
  const auto beat = [&] { return rig.window.load(WindowLayout::rank_word(1, WindowLayout::beat)); };
  CHECK(source.tick(seconds(1), {77, true, false}) == milliseconds(1250));
  CHECK(beat() == (77 | beat_flags::tracing));
  source.tick(milliseconds(1249), {99, true, false});
  CHECK(beat() == (77 | beat_flags::tracing));
  source.tick(milliseconds(1250), {99, true, true});
  CHECK(beat() == (99 | beat_flags::tracing | beat_flags::building));
  source.tick(milliseconds(1500), {99, false, false});
  CHECK(beat() == 99);
}

TEST_CASE("a report contains the work of the rank") {
  Rig rig(medium(), 2, weighted);
  rig.rank(1).report({6000, 2, Time(2000), Time(4000), 6e-3, 0.5, 1234});
  const auto value = [&](WindowLayout::RankWord word) {
    return rig.window.load(WindowLayout::rank_word(1, word));
  };
  CHECK(value(WindowLayout::samples) == 6000);
  CHECK(value(WindowLayout::takes) == 2);
  CHECK(value(WindowLayout::taking) == 2000);
  CHECK(value(WindowLayout::putting) == 4000);
  CHECK(value(WindowLayout::busy) == 6'000'000);
  CHECK(value(WindowLayout::build) == 500'000'000);
  CHECK(value(WindowLayout::tree_bytes) == 1234);
}

}  // namespace parray::test
