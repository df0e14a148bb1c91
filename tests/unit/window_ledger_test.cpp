#include "coordinator/window_ledger.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <numeric>
#include <vector>

#include "tests/support/dice.h"
#include "tests/support/window_rig.h"
#include "worker/window_leases.h"

namespace parray {
namespace {

using test::Dice;
using test::made_block;
using test::made_framebuffer;
using test::made_records;
using test::same_sums;
using test::WindowMemory;
using Word = WindowLayout::Word;

constexpr Time arrival_time = seconds(2);

/// A coordinator of made-up samples, and ranks that hand in what the test says.
struct Rig {
  Rig(const RenderSettings& s, std::vector<WorkRect> pending, std::uint32_t tile = 0,
      std::uint32_t ranks = 3)
      : settings(s),
        plan(settings, std::move(pending), tile),
        layout(plan, ranks),
        memory(layout.bytes()),
        window(memory.bytes()),
        framebuffer(settings),
        expected(made_framebuffer(settings, plan.rects())),
        ledger(plan, layout, window, memory.bytes(), framebuffer, Time(0)),
        rank(plan, layout, window, {}) {}
  explicit Rig(const RenderSettings& s) : Rig(s, {{0, s.height, 0, s.samples_per_pixel}}) {}

  void put(const CellRange& range, std::uint64_t nanoseconds = 7) {
    rank.complete(range, made_records(plan, range, nanoseconds));
  }
  /// `range`, with one bit of the sums of its last cell flipped after the digest was taken.
  void put_corrupt(const CellRange& range) {
    auto records = made_records(plan, range);
    const auto digest = range_digest(cell_digests(records, layout.record_bytes()));
    records[records.size() - layout.record_bytes() + sizeof(CellHeader)] ^= std::byte{1};
    window.put(layout.record_offset(range.begin), records);
    rank.log(range, digest);
  }
  bool collect(Time now = Time(0)) { return ledger.collect(now, std::uint64_t{1} << 40); }
  /// Issues copies until nothing new comes, and hands each in.
  void trace_copies(Time& now) {
    for (int i = 0; i < 100'000 && !ledger.done(); ++i) {
      window.fetch_add(Word::tickets, 1);
      now += milliseconds(10);
      const std::uint64_t before = window.load(Word::copies);
      ledger.issue_copies(now);
      for (std::uint64_t copy = before; copy < window.load(Word::copies); ++copy) {
        put(range_from_word(window.load(layout.copy_word(copy))));
      }
      collect(now);
    }
  }

  RenderSettings settings;
  WorkPlan plan;
  WindowLayout layout;
  WindowMemory memory;
  LocalWindow window;
  Framebuffer framebuffer;
  Framebuffer expected;
  WindowLedger ledger;
  WindowLeases rank;
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

/// Two rectangles, something before, between and after them done.
std::vector<WorkRect> two_rects(const RenderSettings& settings) {
  const std::uint32_t spp = settings.samples_per_pixel;
  const std::uint32_t middle = settings.height / 2;
  std::vector<WorkRect> rects = {{middle, settings.height, spp / 3, spp},
                                 {0, middle, 0, spp % 3 == 0 ? spp : spp - spp / 3}};
  if (spp % 2 == 0) {
    std::swap(rects[0], rects[1]);
  }
  return rects;
}

RenderSettings fixed_settings() { return test::made_settings(30, 9, 150); }

}  // namespace

TEST_CASE("results in any order, in parts of any size, make the framebuffer of one pass") {
  Dice dice(1);
  for (int i = 0; i < 60; ++i) {
    CAPTURE(i);
    const RenderSettings settings = random_settings(dice);
    Rig rig(settings, two_rects(settings), dice.one_in(3) ? 5 : 0);
    const auto ranges = shuffled_ranges(dice, rig.plan.cells());
    for (const CellRange& range : ranges) {
      CHECK_FALSE(rig.ledger.done());
      rig.put(range);
      if (dice.one_in(2)) {
        CHECK(rig.collect());
      }
    }
    rig.collect();
    CHECK(rig.ledger.done());
    CHECK(rig.ledger.progress() == 1);
    CHECK(same_sums(rig.framebuffer, rig.expected));
    CHECK(rig.ledger.tally().entries == ranges.size());
    CHECK(rig.ledger.tally().duplicates == 0);
    CHECK(rig.ledger.tally().corrupt == 0);
  }
}

TEST_CASE("rows for the store are complete, each handed out once, neighbours as one block") {
  Dice dice(2);
  for (int i = 0; i < 60; ++i) {
    CAPTURE(i);
    const RenderSettings settings = random_settings(dice);
    Rig rig(settings, two_rects(settings), dice.one_in(3) ? 5 : 0);
    Framebuffer stored(settings);
    for (const CellRange& range : shuffled_ranges(dice, rig.plan.cells())) {
      rig.put(range);
      rig.collect();
      if (dice.one_in(4)) {
        while (const auto kept = rig.ledger.take_finished_rows()) {
          const RowBlock& block = *kept;
          REQUIRE(block == made_block(settings, block.rect));
          stored.merge(block);
        }
        CHECK(same_sums(stored, rig.framebuffer));
        CHECK(!rig.ledger.take_finished_rows());
      }
    }
    while (const auto kept = rig.ledger.take_finished_rows()) {
      const RowBlock& block = *kept;
      stored.merge(block);
    }
    CHECK(same_sums(stored, rig.expected));
  }
  Rig rig(test::made_settings(30, 9, 20));
  rig.put({0, rig.plan.cells()});
  rig.collect();
  CHECK(rig.ledger.take_finished_rows());
  CHECK(!rig.ledger.take_finished_rows());
}

TEST_CASE("a result that comes again with the same bits is counted and changes nothing") {
  Rig rig(fixed_settings());
  const std::uint64_t half = rig.plan.cells() / 2;
  rig.put({0, half}, 7);
  rig.collect();
  rig.put({0, half}, 8);  // another time is no other result
  rig.put({0, rig.plan.cells()}, 9);
  rig.put({1, 3});
  rig.collect();
  CHECK(rig.ledger.done());
  CHECK(rig.ledger.done_cells() == rig.plan.cells());
  CHECK(rig.ledger.tally().duplicates == 2 * half + 2);
  CHECK(rig.ledger.tally().mismatches == 0);
  CHECK(same_sums(rig.framebuffer, rig.expected));
}

TEST_CASE("a result that comes again with another bit is a mismatch and changes nothing") {
  Rig rig(fixed_settings());
  rig.put({0, rig.plan.cells()});
  rig.collect();
  auto records = made_records(rig.plan, {2, 4});
  records[rig.layout.record_bytes() + sizeof(CellHeader)] ^= std::byte{1};
  rig.rank.complete({2, 4}, records);
  rig.collect();
  CHECK(rig.ledger.tally().mismatches == 1);
  CHECK(rig.ledger.tally().duplicates == 1);
  CHECK(same_sums(rig.framebuffer, rig.expected));
}

TEST_CASE("bytes that arrive after the entry that speaks of them are waited for") {
  Rig rig(fixed_settings());
  const CellRange range{0, rig.plan.cells()};
  const auto records = made_records(rig.plan, range);
  rig.rank.log(range, range_digest(cell_digests(records, rig.layout.record_bytes())));
  const std::span<const std::byte> bytes(records);
  CHECK_FALSE(rig.collect(milliseconds(1)));
  rig.window.put(rig.layout.record_offset(0), bytes.first(bytes.size() / 2));
  CHECK_FALSE(rig.collect(milliseconds(2)));  // torn
  rig.window.put(rig.layout.record_offset(0), bytes);
  CHECK(rig.collect(milliseconds(3)));
  CHECK(rig.ledger.done());
  CHECK(rig.ledger.tally().corrupt == 0);
  CHECK(same_sums(rig.framebuffer, rig.expected));
}

TEST_CASE("a corrupt result is not taken in, and its cells are traced again") {
  Rig rig(fixed_settings());
  const std::uint64_t cells = rig.plan.cells();
  rig.put_corrupt({0, 5});
  rig.put({5, cells});
  CHECK(rig.collect());
  CHECK(rig.ledger.done_cells() == cells - 5);
  rig.collect(arrival_time - Time(1));
  CHECK(rig.ledger.tally().corrupt == 0);
  rig.collect(arrival_time);
  CHECK(rig.ledger.tally().corrupt == 1);
  CHECK(rig.ledger.done_cells() == cells - 5);
  Time now = arrival_time;
  rig.trace_copies(now);
  CHECK(rig.ledger.done());
  CHECK(same_sums(rig.framebuffer, rig.expected));
}

TEST_CASE("a corrupt copy of cells that are in already neither spoils their rows nor the store") {
  Dice dice(3);
  std::uint64_t corrupt = 0;
  for (int i = 0; i < 200; ++i) {
    CAPTURE(i);
    Rig rig(fixed_settings());
    const auto ranges = shuffled_ranges(dice, rig.plan.cells());
    Framebuffer stored(rig.settings);
    const auto store = [&] {
      while (const auto kept = rig.ledger.take_finished_rows()) {
        const RowBlock& block = *kept;
        REQUIRE(block == made_block(rig.settings, block.rect));
        stored.merge(block);
      }
    };
    Time now{};
    for (const CellRange& range : ranges) {
      rig.put(range);
      rig.collect(now);
      if (dice.one_in(3)) {
        rig.put_corrupt(ranges[dice.below(ranges.size())]);
      }
      if (dice.one_in(3)) {
        store();
      }
      now += milliseconds(300);
      rig.collect(now);
    }
    now += 2 * arrival_time;
    rig.collect(now);
    corrupt += rig.ledger.tally().corrupt;
    rig.trace_copies(now);
    CHECK(rig.ledger.done());
    CHECK(same_sums(rig.framebuffer, rig.expected));
    store();  // never a wrong row
  }
  CHECK(corrupt > 200);
}

TEST_CASE("an entry that is no range of the plan's cells is dropped") {
  Rig rig(fixed_settings());
  const std::uint64_t cells = rig.plan.cells();
  rig.rank.log({cells - 1, cells + 1}, 5);
  rig.rank.log({cells + 7, cells + 8}, 5);
  rig.window.store(rig.layout.log_word(2), std::uint64_t{1} << 24);  // an empty range
  rig.window.fetch_add(Word::log_head, 1);
  rig.put({0, cells});
  rig.collect();
  CHECK(rig.ledger.done());
  rig.collect(2 * arrival_time);
  CHECK(rig.ledger.tally().corrupt == 3);
  CHECK(same_sums(rig.framebuffer, rig.expected));
}

TEST_CASE("an entry that was claimed and never written stops nothing") {
  Rig rig(fixed_settings());
  const std::uint64_t cells = rig.plan.cells();
  rig.window.fetch_add(Word::log_head, 1);  // a rank that died in between
  rig.put({0, cells / 2});
  rig.window.fetch_add(Word::log_head, 3);
  CHECK(rig.collect());
  CHECK(rig.ledger.done_cells() == cells / 2);
  Time now = arrival_time;
  rig.trace_copies(now);
  CHECK(rig.ledger.done());
  CHECK(same_sums(rig.framebuffer, rig.expected));
}

TEST_CASE("an entry that is written long after it was claimed is taken in") {
  Rig rig(fixed_settings());
  const auto records = made_records(rig.plan, {3, 8});
  rig.window.fetch_add(Word::log_head, 1);
  CHECK_FALSE(rig.collect(seconds(1)));
  CHECK_FALSE(rig.collect(seconds(100)));
  rig.window.put(rig.layout.record_offset(3), records);
  rig.window.store(rig.layout.log_word(0) + 1,
                   range_digest(cell_digests(records, rig.layout.record_bytes())));
  rig.window.store(rig.layout.log_word(0), to_word({3, 8}));
  CHECK(rig.collect(seconds(101)));
  CHECK(rig.ledger.done_cells() == 5);
}

TEST_CASE("a log that claims more entries than there is room for is read to its end only") {
  Rig rig(test::made_settings(8, 3, 4));
  rig.put({0, rig.plan.cells()});
  rig.window.store(Word::log_head, UINT64_MAX);
  CHECK(rig.collect());
  CHECK(rig.ledger.done());
}

TEST_CASE("collect takes in about as many cells as it is asked to") {
  Rig rig(fixed_settings());
  const std::uint64_t cells = rig.plan.cells();
  REQUIRE(cells > 20);
  for (std::uint64_t cell = 0; cell < cells; ++cell) {
    rig.put({cell, cell + 1});
  }
  CHECK(rig.ledger.collect(Time(0), 10));
  CHECK(rig.ledger.done_cells() == 10);
  CHECK(rig.ledger.collect(Time(0), 10));
  CHECK(rig.ledger.done_cells() == 20);
  CHECK(rig.collect());
  CHECK(rig.ledger.done());
  CHECK_FALSE(rig.collect());
}

TEST_CASE("copies go to those who wait, cover what is unfinished, and begin again if need be") {
  Rig rig(fixed_settings());
  const std::uint64_t cells = rig.plan.cells();
  rig.put({2, cells});
  rig.collect();
  rig.ledger.issue_copies(seconds(1));
  CHECK(rig.window.load(Word::copies) == 0);  // nobody waits
  rig.window.store(Word::tickets, 1);
  rig.ledger.issue_copies(seconds(2));
  CHECK(rig.window.load(Word::copies) == 0);  // perhaps everybody ends now
  rig.ledger.issue_copies(seconds(2) + milliseconds(5));
  REQUIRE(rig.window.load(Word::copies) == 1);
  CHECK(range_from_word(rig.window.load(rig.layout.copy_word(0))) == CellRange{0, 1});
  rig.window.store(Word::tickets, 9);
  rig.ledger.issue_copies(seconds(3));
  rig.ledger.issue_copies(seconds(3) + milliseconds(5));
  REQUIRE(rig.window.load(Word::copies) == 2);  // the round is over
  CHECK(range_from_word(rig.window.load(rig.layout.copy_word(1))) == CellRange{1, 2});
  rig.ledger.issue_copies(seconds(3) + milliseconds(40));
  CHECK(rig.window.load(Word::copies) == 2);
  rig.window.store(Word::tickets, 4);
  rig.ledger.issue_copies(seconds(60));
  CHECK(rig.window.load(Word::copies) == 4);  // another round: the first copies were lost
  CHECK(rig.ledger.tally().copies == 4);
  rig.put({0, 2});
  rig.collect();
  rig.window.store(Word::tickets, 9);
  rig.ledger.issue_copies(seconds(600));
  rig.ledger.issue_copies(seconds(601));
  CHECK(rig.window.load(Word::copies) == 4);
}

TEST_CASE("no more copies are issued than the window has places for") {
  Rig rig(test::made_settings(8, 3, 4));
  rig.window.store(Word::tickets, UINT64_MAX);
  for (Time now{}; rig.window.load(Word::copies) < rig.layout.most_copies(); now += seconds(1000)) {
    const std::uint64_t before = rig.ledger.tally().copies;
    rig.ledger.issue_copies(now);
    REQUIRE((rig.ledger.tally().copies > before || now == Time(0)));
    if (rig.ledger.tally().copies > 500) {
      break;  // they come, round by round
    }
  }
  CHECK(rig.window.load(Word::copies) <= rig.layout.most_copies());
}

TEST_CASE("the time that a row took is the sum of its cells' times") {
  Rig rig(fixed_settings());
  rig.put({0, rig.plan.cells()}, 1000);
  rig.collect();
  std::vector<std::uint64_t> expected(rig.settings.height);
  for (std::uint64_t cell = 0; cell < rig.plan.cells(); ++cell) {
    expected[rig.plan.cell(cell).position] += 1000;
  }
  CHECK(rig.ledger.row_nanoseconds() == expected);
}

TEST_CASE("a rank is silent when it is at work and its beat stands still") {
  Rig rig(fixed_settings());
  const auto beat = [&](std::uint32_t rank, std::uint64_t value) {
    rig.window.store(WindowLayout::rank_word(rank, WindowLayout::beat), value);
  };
  beat(0, 100);  // idle
  beat(1, 100 | beat_flags::tracing);
  beat(2, beat_flags::building);
  rig.ledger.listen(seconds(1));
  CHECK(rig.ledger.last_sign_of_life() == seconds(1));
  rig.ledger.listen(seconds(5));
  CHECK(rig.ledger.last_sign_of_life() == seconds(1));
  CHECK(rig.ledger.silent_ranks(seconds(5), seconds(5)).empty());
  CHECK(rig.ledger.silent_ranks(seconds(6), seconds(5)) == std::vector<std::uint32_t>{1, 2});
  beat(1, 101 | beat_flags::tracing);
  rig.ledger.listen(seconds(6));
  CHECK(rig.ledger.last_sign_of_life() == seconds(6));
  CHECK(rig.ledger.silent_ranks(seconds(7), seconds(5)) == std::vector<std::uint32_t>{2});
  rig.put({0, 1});
  rig.collect(seconds(8));
  CHECK(rig.ledger.last_sign_of_life() == seconds(8));
}

TEST_CASE("finish() tells every rank") {
  Rig rig(fixed_settings());
  CHECK(rig.window.load(Word::finished) == 0);
  rig.ledger.finish();
  CHECK(rig.window.load(Word::finished) != 0);
}

TEST_CASE("a job of which nothing is left is done at once") {
  Rig rig(fixed_settings(), {});
  CHECK(rig.ledger.done());
  CHECK(rig.ledger.progress() == 1);
}

TEST_CASE("rows of a pass that gives each pixel samples of its own are kept as they are merged") {
  Dice dice(11);
  for (int i = 0; i < 60; ++i) {
    CAPTURE(i);
    const RenderSettings settings = random_settings(dice);
    Framebuffer framebuffer(settings);
    Framebuffer expected(settings);
    Framebuffer kept(settings);
    for (int pass = 0; pass < 3; ++pass) {
      const auto counts =
          test::ragged_counts(dice, framebuffer.samples(), settings.samples_per_pixel);
      for (Framebuffer* each : {&framebuffer, &expected, &kept}) {
        each->begin_pass(counts);
      }
      const WorkRect all = framebuffer.pass_rect();
      if (all.units() == 0) {
        continue;
      }
      const WorkPlan plan(settings, {all}, dice.below32(9), framebuffer.pass_samples());
      const WindowLayout layout(plan, 3);
      WindowMemory memory(layout.bytes());
      LocalWindow window(memory.bytes());
      WindowLedger ledger(plan, layout, window, memory.bytes(), framebuffer, Time(0));
      WindowLeases rank(plan, layout, window, {});
      for (const CellRange& range : shuffled_ranges(dice, plan.cells())) {
        rank.complete(range, made_records(plan, range));
        ledger.collect(Time(0), 1000);
        if (const auto block = ledger.take_finished_rows()) {
          CHECK(*block == made_block(settings, block->rect, expected.samples_of(block->rect)));
          kept.merge(*block);
        }
      }
      while (const auto block = ledger.take_finished_rows()) {
        kept.merge(*block);
      }
      expected.merge(made_block(settings, all, expected.samples_of(all)));
      REQUIRE(ledger.done());
      CHECK(plan.samples() == expected.sample_count(all));
      CHECK(framebuffer.samples() == counts);
      CHECK(same_sums(framebuffer, expected));
      CHECK(same_sums(kept, expected));
    }
  }
}

TEST_CASE("a row that is spoilt after it was merged is not kept, and the ledger says so") {
  Rig rig(fixed_settings());
  const CellRange all{0, rig.plan.cells()};
  rig.put(all);
  rig.collect();
  REQUIRE(rig.ledger.done());
  rig.put_corrupt({3, 4});
  std::uint32_t rows = 0;
  while (const auto block = rig.ledger.take_finished_rows()) {
    rows += block->rect.rows();
  }
  CHECK(rig.ledger.rows_left_out() == 1);
  CHECK(rows == rig.plan.passes() - 1);
}

TEST_CASE("a ledger counts on from the one before") {
  Rig first(fixed_settings());
  first.put({0, first.plan.cells()});
  first.put({0, 3});
  first.collect();
  Rig second(fixed_settings());
  second.ledger.go_on_from(first.ledger);
  second.put({0, 2});
  second.collect();
  CHECK(second.ledger.tally().entries == 3);
  CHECK(second.ledger.tally().duplicates == 3);
  CHECK(second.ledger.row_nanoseconds() == first.ledger.row_nanoseconds());
}

}  // namespace parray
