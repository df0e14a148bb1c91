#include <doctest/doctest.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "coordinator/leases/window_collector.h"
#include "tests/support/collector_rig.h"
#include "tests/support/rooms.h"

namespace parray {

using Rig = test::CollectorRig;
using test::arrival_time;
using test::Dice;
using test::fixed_settings;
using test::made_records;
using test::random_settings;
using test::shuffled_ranges;
using Word = WindowLayout::Word;

TEST_CASE("cells of an earlier run are complete, and copies of them are only compared") {
  Rig rig(fixed_settings(), 0, {{3, 10}, {20, 25}});
  CHECK(rig.picture.collector().done_cells() > 0);
  rig.put({0, 5});
  rig.collect();
  CHECK(rig.totals.duplicates == 2);
  Time now{};
  rig.trace_copies(now);
  rig.check_picture();
  CHECK(rig.totals.duplicates == 2);
}

TEST_CASE("corrupt copies of merged cells change neither picture nor store") {
  Dice dice(3);
  std::uint64_t corrupt = 0;
  for (int i = 0; i < 200; ++i) {
    CAPTURE(i);
    Rig rig(fixed_settings());
    const auto ranges = shuffled_ranges(dice, rig.cells);
    Time now{};
    for (const CellRange& range : ranges) {
      rig.put(range);
      rig.collect(now);
      if (dice.one_in(3)) rig.put_corrupt(ranges[dice.below(ranges.size())]);
      now += milliseconds(300);
      rig.collect(now);
    }
    now += 2 * arrival_time;
    rig.collect(now);
    corrupt += rig.totals.corrupt;
    rig.trace_copies(now);
    rig.check_picture();
    for (const TracedCells& cells : rig.merged) {
      REQUIRE(cells.records == made_records(rig.plan(), cells.range));
    }
  }
  CHECK(corrupt > 200);
}

TEST_CASE("claimed blocks of the log that stay empty stop nothing") {
  Rig rig(fixed_settings());
  rig.window.fetch_add(Word::log_head, 1);  // a rank died in between
  rig.put({0, rig.cells / 2});
  rig.window.fetch_add(Word::log_head, 3);
  CHECK(rig.collect());
  CHECK(rig.picture.collector().done_cells() == rig.cells / 2);
  Time now = arrival_time;
  rig.trace_copies(now);
  rig.check_picture();
}

TEST_CASE("a lost entry hides later ones only until ranks have no work left") {
  Rig rig(test::made_settings(30, 9, 400));
  for (std::uint64_t cell = 0; cell < rig.cells; ++cell) rig.put({cell, cell + 1});
  REQUIRE(rig.cells > 2 * WindowLayout::block_entries);
  const std::size_t lost = rig.layout.log_word(1);
  const std::uint64_t range = rig.window.load(lost);
  rig.window.store(lost, 0);
  CHECK(rig.collect());
  CHECK(rig.picture.collector().done_cells() == rig.cells - WindowLayout::block_entries + 1);
  rig.window.store(Word::copy_requests, 1);
  rig.collector.issue_copies(seconds(1));
  rig.collect(seconds(1));
  CHECK(rig.picture.collector().missing() == std::vector{range_from_word(range)});
  rig.window.store(lost, range);  // the entry was only late
  rig.collect(seconds(2));
  CHECK(rig.totals.copies == 0);
  rig.check_picture();
}

TEST_CASE("rank 0's threads merge results of many ranks together and detect corrupt ones") {
  Dice dice(12);
  for (int i = 0; i < 20; ++i) {
    CAPTURE(i);
    Rig rig(random_settings(dice), dice.one_in(3) ? 5 : 0);
    std::uint64_t merged = 0;
    WindowCollector collector(
        rig.picture, rig.judge, rig.layout, rig.window, rig.memory.bytes(), Time(0), rig.totals,
        {[](const CellBatch& cell) { return test::made_cells(cell).excluded; },
         [&](TracerKey, const TracedCells& cells) { merged += cells.range.count(); }},
        {.own = 4, .all = 4096});
    CHECK(collector.merging_threads() == 4);
    std::vector<CellRange> spoilt;
    for (const CellRange& range : shuffled_ranges(dice, rig.cells)) {
      if (dice.one_in(9)) {
        rig.put_corrupt(range);
        spoilt.push_back(range);
      } else {
        rig.put(range);
      }
      if (dice.one_in(8)) collector.collect(Time(0), 1 + dice.below(50));
    }
    for (int turn = 0; turn < 3; ++turn) {
      collector.collect(arrival_time, UINT64_MAX);
      collector.collect(2 * arrival_time, UINT64_MAX);
    }
    CHECK(rig.totals.corrupt == spoilt.size());
    for (const CellRange& range : spoilt) {
      rig.put(range);
      rig.put(range);
    }
    collector.collect(3 * arrival_time, UINT64_MAX);
    CHECK(merged == rig.cells);
    rig.check_picture();
  }
}

TEST_CASE("rank 0 of many ranks does not trace as long as results arrive") {
  Rig rig(fixed_settings());
  const auto collector_of = [&](RankThreads threads) {
    return std::make_unique<WindowCollector>(
        rig.picture, rig.judge, rig.layout, rig.window, rig.memory.bytes(), seconds(1), rig.totals,
        WindowCollector::Hooks{
            [](const CellBatch& cell) { return test::made_cells(cell).excluded; }, {}},
        threads);
  };
  const auto few = collector_of({.own = 2, .all = 1024});
  const auto many = collector_of({.own = 2, .all = 1026});
  CHECK(few->merging_threads() == 1);
  CHECK(many->merging_threads() == 2);
  CHECK(collector_of({.own = 16, .all = 4096})->merging_threads() == 4);
  CHECK_FALSE(few->wants_all_threads(seconds(1)));
  CHECK(many->wants_all_threads(seconds(1)));
  CHECK_FALSE(many->wants_all_threads(seconds(2)));
  rig.put({0, 1});
  CHECK(many->collect(seconds(2), 10));
  CHECK(many->wants_all_threads(milliseconds(2900)));
  CHECK_FALSE(many->wants_all_threads(seconds(3)));
}

TEST_CASE("a log that claims more entries than it has is read only to its end") {
  Rig rig(test::made_settings(8, 3, 4));
  rig.put({0, rig.cells});
  rig.window.store(Word::log_head, UINT64_MAX);
  CHECK(rig.collect());
  rig.check_picture();
}

TEST_CASE("waiting ranks get copies of all unfinished cells, repeatedly if necessary") {
  Rig rig(fixed_settings());
  const auto copies = [&] { return rig.window.load(Word::copies); };
  const auto copy = [&](std::uint64_t number) {
    return range_from_word(rig.window.load(rig.layout.copy_word(number)));
  };
  rig.put({2, rig.cells});
  rig.collect();
  rig.collector.issue_copies(seconds(1));
  CHECK(copies() == 0);  // no rank waits
  rig.window.store(Word::copy_requests, 1);
  rig.collector.issue_copies(seconds(2));
  CHECK(copies() == 0);  // all ranks may end now
  rig.collector.issue_copies(seconds(2) + milliseconds(5));
  REQUIRE(copies() == 1);
  CHECK(copy(0) == CellRange{0, 1});
  rig.window.store(Word::copy_requests, 9);
  rig.collector.issue_copies(seconds(3));
  rig.collector.issue_copies(seconds(3) + milliseconds(5));
  REQUIRE(copies() == 2);  // the round is over
  CHECK(copy(1) == CellRange{1, 2});
  rig.collector.issue_copies(seconds(3) + milliseconds(40));
  CHECK(copies() == 2);
  rig.window.store(Word::copy_requests, 4);
  rig.collector.issue_copies(seconds(60));
  CHECK(copies() == 4);  // another round: the first copies were lost
  CHECK(rig.totals.copies == 4);
  rig.put({0, 2});
  rig.collect();
  rig.window.store(Word::copy_requests, 9);
  rig.collector.issue_copies(seconds(600));
  rig.collector.issue_copies(seconds(601));
  CHECK(copies() == 4);
}

TEST_CASE("copies are issued in rounds, at most as many as the window has places") {
  Rig rig(test::made_settings(8, 3, 4));
  rig.window.store(Word::copy_requests, UINT64_MAX);
  for (Time now{}; rig.totals.copies <= 500; now += seconds(1000)) {
    const std::uint64_t before = rig.totals.copies;
    rig.collector.issue_copies(now);
    REQUIRE((rig.totals.copies > before || now == Time(0)));
  }
  CHECK(rig.window.load(Word::copies) <= WindowLayout::most_copies);
}

TEST_CASE("a rank is silent if it works and its heartbeat does not change") {
  Rig rig(fixed_settings());
  WindowCollector& collector = rig.collector;
  const auto beat = [&](std::uint32_t rank, std::uint64_t value) {
    rig.window.store(WindowLayout::rank_word(rank, WindowLayout::beat), value);
  };
  beat(0, 100);  // idle
  beat(1, 100 | beat_flags::tracing);
  beat(2, beat_flags::building);
  collector.listen(seconds(1));
  CHECK(collector.last_sign_of_life() == seconds(1));
  collector.listen(seconds(5));
  CHECK(collector.last_sign_of_life() == seconds(1));
  CHECK(collector.silent_ranks(seconds(5), seconds(5)).empty());
  CHECK(collector.silent_ranks(seconds(6), seconds(5)) == std::vector<std::uint32_t>{1, 2});
  beat(1, 101 | beat_flags::tracing);
  collector.listen(seconds(6));
  CHECK(collector.last_sign_of_life() == seconds(6));
  CHECK(collector.silent_ranks(seconds(7), seconds(5)) == std::vector<std::uint32_t>{2});
  rig.put({0, 1});
  rig.collect(seconds(8));
  CHECK(collector.last_sign_of_life() == seconds(8));
}

TEST_CASE("finish() stops every rank") {
  Rig rig(fixed_settings());
  CHECK(rig.window.load(Word::finished) == 0);
  rig.collector.finish();
  CHECK(rig.window.load(Word::finished) != 0);
}

}  // namespace parray
