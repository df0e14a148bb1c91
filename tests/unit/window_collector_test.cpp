#include "coordinator/window_collector.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "tests/support/dice.h"
#include "tests/support/window_rig.h"

namespace parray {
namespace {

using test::Dice;
using test::made_records;
using test::same_sums;
using Word = WindowLayout::Word;

constexpr Time arrival_time = seconds(2);

/// A coordinator of made-up samples, and a rank that hands in what the test says.
struct Rig : test::WindowRig {
  explicit Rig(const RenderSettings& its_settings, std::uint32_t tile = 0,
               const std::vector<CellRange>& done = {})
      : WindowRig(its_settings, 3, tile, done),
        cells(plan().cells()),
        expected(test::made_framebuffer(settings)),
        rank(source()) {}

  void put(const CellRange& range, std::uint64_t nanoseconds = 7) {
    rank.put(range, made_records(plan(), range, nanoseconds));
  }
  /// `range`, with one bit of the sums of its last cell flipped after the digest was taken.
  void put_corrupt(const CellRange& range) {
    auto records = made_records(plan(), range);
    const auto digest = range_digest(cell_digests(records, layout.record_bytes()));
    records[records.size() - layout.record_bytes() + sizeof(CellHeader)] ^= std::byte{1};
    window.put(layout.record_offset(range.begin), records);
    rank.log(range, digest);
  }
  /// Issues copies until nothing new comes, and hands each in.
  void trace_copies(Time& now) {
    for (int i = 0; i < 100'000 && !collector.done(); ++i) {
      window.fetch_add(Word::tickets, 1);
      now += milliseconds(10);
      const std::uint64_t before = window.load(Word::copies);
      collector.issue_copies(now);
      for (std::uint64_t copy = before; copy < window.load(Word::copies); ++copy) {
        put(range_from_word(window.load(layout.copy_word(copy))));
      }
      collect(now);
    }
  }
  void check_picture() const {
    CHECK(collector.done());
    CHECK(same_sums(picture.framebuffer(), expected));
  }

  std::uint64_t cells;
  Framebuffer expected;
  WindowSource rank;
};

std::vector<CellRange> shuffled_ranges(Dice& dice, std::uint64_t cells) {
  std::vector<CellRange> ranges;
  for (std::uint64_t begin = 0; begin < cells;) {
    const std::uint64_t end = std::min(cells, begin + 1 + dice.below(9));
    ranges.push_back({begin, end});
    begin = end;
  }
  for (std::size_t i = ranges.size(); i > 1; --i) {
    std::swap(ranges[i - 1], ranges[dice.below(i)]);
  }
  return ranges;
}

RenderSettings random_settings(Dice& dice) {
  if (dice.one_in(4)) {  // rows that are cut into ranges of samples
    return test::made_settings(1 + dice.below32(3), 2 + dice.below32(9), 3000 + dice.below32(6000));
  }
  return test::made_settings(1 + dice.below32(40), 2 + dice.below32(12), 1 + dice.below32(400));
}

RenderSettings fixed_settings() { return test::made_settings(30, 9, 150); }

}  // namespace

TEST_CASE("results in any order, in parts of any size, make the picture of one piece") {
  Dice dice(1);
  for (int i = 0; i < 60; ++i) {
    CAPTURE(i);
    Rig rig(random_settings(dice), dice.one_in(3) ? 5 : 0);
    const auto ranges = shuffled_ranges(dice, rig.cells);
    for (const CellRange& range : ranges) {
      CHECK_FALSE(rig.collector.done());
      rig.put(range);
      if (dice.one_in(2)) {
        CHECK(rig.collect());
      }
    }
    rig.collect();
    rig.check_picture();
    CHECK(rig.collector.progress() == 1);
    CHECK(rig.totals.entries == ranges.size());
    CHECK(rig.totals.duplicates == 0);
    CHECK(rig.totals.corrupt == 0);
  }
}

TEST_CASE("what is merged is handed on for the store, from which another life goes on") {
  Dice dice(2);
  for (int i = 0; i < 40; ++i) {
    CAPTURE(i);
    Rig rig(random_settings(dice), 0);
    const auto ranges = shuffled_ranges(dice, rig.cells);
    for (std::size_t range = 0; range < (ranges.size() + 1) / 2; ++range) {
      rig.put(ranges[range]);
      rig.put(ranges[dice.below(range + 1)]);  // again: nothing new
      rig.collect();
    }
    JobPicture next(rig.settings, SceneFacts(test::small_scene()));
    for (const TracedCells& cells : rig.merged) {
      next.replay(rig.picture.cells_entry(rig.judge.tracer(0), cells.range,
                                          pack_cells(cells, *rig.plan().grid())));
    }
    CHECK(same_sums(next.framebuffer(), rig.picture.framebuffer()));
    CHECK(next.collector().missing() == rig.picture.collector().missing());
  }
}

TEST_CASE("cells of an earlier life are not waited for, and a copy of them is only compared") {
  Rig rig(fixed_settings(), 0, {{3, 10}, {20, 25}});
  CHECK(rig.collector.progress() > 0);
  rig.put({0, 5});
  rig.collect();
  CHECK(rig.totals.duplicates == 2);
  Time now{};
  rig.trace_copies(now);
  rig.check_picture();
  CHECK(rig.totals.duplicates == 2);
}

TEST_CASE("a result that comes again with the same bits is counted and changes nothing") {
  Rig rig(fixed_settings());
  const std::uint64_t half = rig.cells / 2;
  rig.put({0, half}, 7);
  rig.collect();
  rig.put({0, half}, 8);  // another time is no other result
  rig.put({0, rig.cells}, 9);
  rig.put({1, 3});
  rig.collect();
  rig.check_picture();
  CHECK(rig.totals.duplicates == 2 * half + 2);
  CHECK(rig.totals.mismatches == 0);
}

TEST_CASE("a result with numbers that no tracing gives is not taken in") {
  Rig rig(fixed_settings());
  auto records = made_records(rig.plan(), {2, 4});
  const std::uint64_t many = UINT64_MAX;
  std::memcpy(records.data(), &many, sizeof many);  // rays
  rig.rank.put({2, 4}, records);
  CHECK_FALSE(rig.collect());
  rig.collect(arrival_time);
  CHECK(rig.totals.corrupt == 1);
  Time now = arrival_time;
  rig.trace_copies(now);
  rig.check_picture();
}

TEST_CASE("bytes that arrive after the entry that speaks of them are waited for") {
  Rig rig(fixed_settings());
  const CellRange range{0, rig.cells};
  const auto records = made_records(rig.plan(), range);
  rig.rank.log(range, range_digest(cell_digests(records, rig.layout.record_bytes())));
  const std::span<const std::byte> bytes(records);
  CHECK_FALSE(rig.collect(milliseconds(1)));
  rig.window.put(rig.layout.record_offset(0), bytes.first(bytes.size() / 2));
  CHECK_FALSE(rig.collect(milliseconds(2)));  // torn
  rig.window.put(rig.layout.record_offset(0), bytes);
  CHECK(rig.collect(milliseconds(3)));
  rig.check_picture();
  CHECK(rig.totals.corrupt == 0);
}

TEST_CASE("a corrupt result is not taken in, and its cells are traced again") {
  Rig rig(fixed_settings());
  rig.put_corrupt({0, 5});
  rig.put({5, rig.cells});
  CHECK(rig.collect());
  rig.collect(arrival_time - Time(1));
  CHECK(rig.totals.corrupt == 0);
  rig.collect(arrival_time);
  CHECK(rig.totals.corrupt == 1);
  CHECK(rig.picture.collector().missing() == std::vector<CellRange>{{0, 5}});
  Time now = arrival_time;
  rig.trace_copies(now);
  rig.check_picture();
}

TEST_CASE("corrupt copies of cells that are in already spoil neither picture nor store") {
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
      if (dice.one_in(3)) {
        rig.put_corrupt(ranges[dice.below(ranges.size())]);
      }
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

TEST_CASE("an entry that is no range of the plan's cells is dropped") {
  Rig rig(fixed_settings());
  rig.rank.log({rig.cells - 1, rig.cells + 1}, 5);
  rig.rank.log({rig.cells + 7, rig.cells + 8}, 5);
  // Another rank's: an empty range.
  rig.window.store(rig.layout.log_word(WindowLayout::block_entries), std::uint64_t{1} << 24);
  rig.put({0, rig.cells});
  rig.collect();
  rig.collect(2 * arrival_time);
  CHECK(rig.totals.corrupt == 3);
  rig.check_picture();
}

TEST_CASE("blocks of the log that were claimed and never written stop nothing") {
  Rig rig(fixed_settings());
  rig.window.fetch_add(Word::log_head, 1);  // a rank that died in between
  rig.put({0, rig.cells / 2});
  rig.window.fetch_add(Word::log_head, 3);
  CHECK(rig.collect());
  CHECK(rig.picture.collector().done_cells() == rig.cells / 2);
  Time now = arrival_time;
  rig.trace_copies(now);
  rig.check_picture();
}

TEST_CASE("an entry that was lost hides those behind it only until ranks have nothing to do") {
  Rig rig(test::made_settings(30, 9, 400));
  for (std::uint64_t cell = 0; cell < rig.cells; ++cell) {
    rig.put({cell, cell + 1});
  }
  REQUIRE(rig.cells > 2 * WindowLayout::block_entries);
  const std::size_t lost = rig.layout.log_word(1);
  const std::uint64_t range = rig.window.load(lost);
  rig.window.store(lost, 0);
  CHECK(rig.collect());
  CHECK(rig.picture.collector().done_cells() == rig.cells - WindowLayout::block_entries + 1);
  rig.window.store(Word::tickets, 1);
  rig.collector.issue_copies(seconds(1));
  rig.collect(seconds(1));
  CHECK(rig.picture.collector().missing() == std::vector{range_from_word(range)});
  rig.window.store(lost, range);  // it was only late
  rig.collect(seconds(2));
  CHECK(rig.totals.copies == 0);
  rig.check_picture();
}

TEST_CASE("of many ranks rank 0's threads take in results together, corrupt ones among them") {
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
    CHECK(collector.crew() == 4);
    std::vector<CellRange> spoilt;
    for (const CellRange& range : shuffled_ranges(dice, rig.cells)) {
      if (dice.one_in(9)) {
        rig.put_corrupt(range);
        spoilt.push_back(range);
      } else {
        rig.put(range);
      }
      if (dice.one_in(8)) {
        collector.collect(Time(0), 1 + dice.below(50));
      }
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

TEST_CASE("rank 0 of many leaves tracing to the others as long as their results come") {
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
  CHECK(few->crew() == 1);
  CHECK(many->crew() == 2);
  CHECK(collector_of({.own = 16, .all = 4096})->crew() == 4);
  CHECK_FALSE(few->wants_all_threads(seconds(1)));
  CHECK(many->wants_all_threads(seconds(1)));
  CHECK_FALSE(many->wants_all_threads(seconds(2)));
  rig.put({0, 1});
  CHECK(many->collect(seconds(2), 10));
  CHECK(many->wants_all_threads(milliseconds(2900)));
  CHECK_FALSE(many->wants_all_threads(seconds(3)));
}

TEST_CASE("an entry that is written long after ranks have begun is taken in") {
  Rig rig(fixed_settings());
  const auto records = made_records(rig.plan(), {3, 8});
  CHECK_FALSE(rig.collect(seconds(1)));
  CHECK_FALSE(rig.collect(seconds(100)));
  rig.window.put(rig.layout.record_offset(3), records);
  rig.window.store(rig.layout.log_word(0) + 1,
                   entry_digest(range_digest(cell_digests(records, rig.layout.record_bytes())), 2));
  rig.window.store(rig.layout.log_word(0) + 2, 3);
  rig.window.store(rig.layout.log_word(0), to_word({3, 8}));
  CHECK(rig.collect(seconds(101)));
  CHECK(rig.picture.collector().done_cells() == 5);
}

TEST_CASE("a log that claims more entries than there is room for is read to its end only") {
  Rig rig(test::made_settings(8, 3, 4));
  rig.put({0, rig.cells});
  rig.window.store(Word::log_head, UINT64_MAX);
  CHECK(rig.collect());
  rig.check_picture();
}

TEST_CASE("collect takes in about as many cells as it is asked to") {
  Rig rig(fixed_settings());
  REQUIRE(rig.cells > 20);
  for (std::uint64_t cell = 0; cell < rig.cells; ++cell) {
    rig.put({cell, cell + 1});
  }
  for (const std::uint64_t done : {10U, 20U}) {
    CHECK(rig.collector.collect(Time(0), 10));
    CHECK(rig.picture.collector().done_cells() == done);
  }
  CHECK(rig.collect());
  rig.check_picture();
  CHECK_FALSE(rig.collect());
}

TEST_CASE("copies go to those who wait, cover what is missing, and begin again if need be") {
  Rig rig(fixed_settings());
  const auto copies = [&] { return rig.window.load(Word::copies); };
  const auto copy = [&](std::uint64_t number) {
    return range_from_word(rig.window.load(rig.layout.copy_word(number)));
  };
  rig.put({2, rig.cells});
  rig.collect();
  rig.collector.issue_copies(seconds(1));
  CHECK(copies() == 0);  // nobody waits
  rig.window.store(Word::tickets, 1);
  rig.collector.issue_copies(seconds(2));
  CHECK(copies() == 0);  // perhaps everybody ends now
  rig.collector.issue_copies(seconds(2) + milliseconds(5));
  REQUIRE(copies() == 1);
  CHECK(copy(0) == CellRange{0, 1});
  rig.window.store(Word::tickets, 9);
  rig.collector.issue_copies(seconds(3));
  rig.collector.issue_copies(seconds(3) + milliseconds(5));
  REQUIRE(copies() == 2);  // the round is over
  CHECK(copy(1) == CellRange{1, 2});
  rig.collector.issue_copies(seconds(3) + milliseconds(40));
  CHECK(copies() == 2);
  rig.window.store(Word::tickets, 4);
  rig.collector.issue_copies(seconds(60));
  CHECK(copies() == 4);  // another round: the first copies were lost
  CHECK(rig.totals.copies == 4);
  rig.put({0, 2});
  rig.collect();
  rig.window.store(Word::tickets, 9);
  rig.collector.issue_copies(seconds(600));
  rig.collector.issue_copies(seconds(601));
  CHECK(copies() == 4);
}

TEST_CASE("copies come round by round, and no more than the window has places for") {
  Rig rig(test::made_settings(8, 3, 4));
  rig.window.store(Word::tickets, UINT64_MAX);
  for (Time now{}; rig.totals.copies <= 500; now += seconds(1000)) {
    const std::uint64_t before = rig.totals.copies;
    rig.collector.issue_copies(now);
    REQUIRE((rig.totals.copies > before || now == Time(0)));
  }
  CHECK(rig.window.load(Word::copies) <= rig.layout.most_copies());
}

TEST_CASE("the time that a row took is the sum of its cells' times, each counted once") {
  Rig rig(fixed_settings());
  rig.put({0, rig.cells}, 1000);
  rig.collect();
  rig.put({0, rig.cells / 2}, 500);
  rig.collect();
  std::vector<std::uint64_t> expected(rig.settings.height);
  for (std::uint64_t cell = 0; cell < rig.cells; ++cell) {
    expected[rig.plan().cell(cell).y] += 1000;
  }
  CHECK(rig.totals.row_nanoseconds == expected);
}

TEST_CASE("a rank is silent when it is at work and its beat stands still") {
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

TEST_CASE("finish() tells every rank") {
  Rig rig(fixed_settings());
  CHECK(rig.window.load(Word::finished) == 0);
  rig.collector.finish();
  CHECK(rig.window.load(Word::finished) != 0);
}

TEST_CASE("passes of pixels with samples of their own add up over windows, and go on from a log") {
  Dice dice(11);
  for (int i = 0; i < 20; ++i) {
    CAPTURE(i);
    RenderSettings settings = random_settings(dice);
    settings.adaptive = true;
    const std::uint64_t pixels = std::uint64_t{settings.width} * settings.height;
    settings.samples_per_pixel = 4096;
    settings.passes = {4 * pixels, pixels * (1 + dice.below(40)), pixels * (1 + dice.below(90))};
    const SceneFacts facts(test::small_scene());
    JobPicture picture(settings, facts);
    std::vector<std::string> log;
    Framebuffer expected(settings.width, settings.height);
    WindowCollector::Totals totals;
    while (picture.begin_pass()) {
      const auto plan = picture.plan();
      test::make_into(expected,
                      plan->pixel_samples().empty()
                          ? std::vector<SampleRange>(pixels, plan->grid()->shape().stages[0])
                          : plan->pixel_samples());
      const RankPass pass{picture.passes().pass(), plan, CellList(picture.collector().missing())};
      const WindowLayout layout(*plan->grid(), 3);
      test::WindowMemory memory(layout.bytes());
      LocalWindow window(memory.bytes());
      RankJudge judge(picture, rank_voices(test::hosts_apart(3)), {});
      WindowCollector collector(
          picture, judge, layout, window, memory.bytes(), Time(0), totals,
          {[](const CellBatch& cell) { return test::made_cells(cell).excluded; },
           [&](TracerKey tracer, const TracedCells& cells) {
             log.push_back(JobPicture::cells_entry(pass.number, tracer, cells.range,
                                                   pack_cells(cells, *plan->grid())));
           }});
      RankJob job{settings, "", nullptr};
      WindowSource rank(job, pass, layout, window, {});
      for (const CellRange& range : shuffled_ranges(dice, plan->cells())) {
        rank.put(range, made_records(*plan, range));
        collector.collect(Time(0), 1000);
      }
      while (collector.collect(Time(0), 1000)) {
      }
      REQUIRE(collector.done());
      CHECK(same_sums(picture.framebuffer(), expected));
    }
    CHECK(picture.passes().begun() == settings.passes);
    JobPicture next(settings, facts, picture.passes().begun());
    for (const std::string& entry : log) {
      next.replay(entry);
    }
    CHECK(same_sums(next.framebuffer(), expected));
  }
}

}  // namespace parray
