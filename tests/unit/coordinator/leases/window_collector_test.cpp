#include "coordinator/leases/window_collector.h"

#include <doctest/doctest.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "common/scene/settings.h"
#include "tests/support/collector_rig.h"
#include "tests/support/rooms.h"

namespace parray {

using test::arrival_time;
using test::CollectorRig;
using test::Dice;
using test::fixed_settings;
using test::made_records;
using test::random_settings;
using test::same_sums;
using test::shuffled_ranges;

TEST_CASE("results of any size in any order make the same picture") {
  Dice dice(1);
  for (int i = 0; i < 60; ++i) {
    CAPTURE(i);
    CollectorRig rig(random_settings(dice), dice.one_in(3) ? 5 : 0);
    const auto ranges = shuffled_ranges(dice, rig.cells);
    for (const CellRange& range : ranges) {
      CHECK_FALSE(rig.collector.done());
      rig.put(range);
      if (dice.one_in(2)) CHECK(rig.collect());
    }
    rig.collect();
    rig.check_picture();
    CHECK(rig.collector.done());
    CHECK(rig.totals.entries == ranges.size());
    CHECK(rig.totals.duplicates == 0);
    CHECK(rig.totals.corrupt == 0);
  }
}

TEST_CASE("merged results reach the store, from which a later process resumes") {
  Dice dice(2);
  for (int i = 0; i < 40; ++i) {
    CAPTURE(i);
    CollectorRig rig(random_settings(dice), 0);
    const auto ranges = shuffled_ranges(dice, rig.cells);
    for (std::size_t range = 0; range < (ranges.size() + 1) / 2; ++range) {
      rig.put(ranges[range]);
      rig.put(ranges[dice.below(range + 1)]);  // repeated: no new cells
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

TEST_CASE("a repeated result with the same bits is counted and changes nothing") {
  CollectorRig rig(fixed_settings());
  const std::uint64_t half = rig.cells / 2;
  rig.put({0, half}, 7);
  rig.collect();
  rig.put({0, half}, 8);  // another tracing time does not make another result
  rig.put({0, rig.cells}, 9);
  rig.put({1, 3});
  rig.collect();
  rig.check_picture();
  CHECK(rig.totals.duplicates == 2 * half + 2);
  CHECK(rig.totals.mismatches == 0);
}

TEST_CASE("a result with impossible numbers is dropped") {
  CollectorRig rig(fixed_settings());
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

TEST_CASE("the collector waits for bytes that arrive after their entry") {
  CollectorRig rig(fixed_settings());
  const CellRange range{0, rig.cells};
  const auto records = made_records(rig.plan(), range);
  rig.rank.log(range, range_digest(cell_digests(records, rig.layout.record_bytes())));
  const std::span<const std::byte> bytes(records);
  CHECK_FALSE(rig.collect(milliseconds(1)));
  rig.window.put(rig.layout.record_offset(0), bytes.first(bytes.size() / 2));
  CHECK_FALSE(rig.collect(milliseconds(2)));  // incomplete
  rig.window.put(rig.layout.record_offset(0), bytes);
  CHECK(rig.collect(milliseconds(3)));
  rig.check_picture();
  CHECK(rig.totals.corrupt == 0);
}

TEST_CASE("a corrupt result is dropped, and its cells are traced again") {
  CollectorRig rig(fixed_settings());
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

TEST_CASE("an entry with a range outside the plan is dropped") {
  CollectorRig rig(fixed_settings());
  rig.rank.log({rig.cells - 1, rig.cells + 1}, 5);
  rig.rank.log({rig.cells + 7, rig.cells + 8}, 5);
  // An empty range of another rank.
  rig.window.store(rig.layout.log_word(WindowLayout::block_entries), std::uint64_t{1} << 24);
  rig.put({0, rig.cells});
  rig.collect();
  rig.collect(2 * arrival_time);
  CHECK(rig.totals.corrupt == 3);
  rig.check_picture();
}

TEST_CASE("an entry that is written late is merged") {
  CollectorRig rig(fixed_settings());
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

TEST_CASE("collect() merges about as many cells as requested") {
  CollectorRig rig(fixed_settings());
  REQUIRE(rig.cells > 20);
  for (std::uint64_t cell = 0; cell < rig.cells; ++cell) rig.put({cell, cell + 1});
  for (const std::uint64_t done : {10U, 20U}) {
    CHECK(rig.collector.collect(Time(0), 10));
    CHECK(rig.picture.collector().done_cells() == done);
  }
  CHECK(rig.collect());
  rig.check_picture();
  CHECK_FALSE(rig.collect());
}

TEST_CASE("the time of a row is the sum of its cells' times, each counted once") {
  CollectorRig rig(fixed_settings());
  rig.put({0, rig.cells}, 1000);
  rig.collect();
  rig.put({0, rig.cells / 2}, 500);
  rig.collect();
  std::vector<std::uint64_t> expected(rig.settings.height);
  for (std::uint64_t cell = 0; cell < rig.cells; ++cell) expected[rig.plan().cell(cell).y] += 1000;
  CHECK(rig.totals.row_nanoseconds == expected);
}

TEST_CASE("passes with different samples per pixel work over windows and are resumed from a log") {
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
      const RankPass pass{plan, CellList(picture.collector().missing())};
      const WindowLayout layout(*plan->grid(), 3);
      test::WindowMemory memory(layout.bytes());
      LocalWindow window(memory.bytes());
      RankJudge judge(picture, rank_voices(test::hosts_apart(3)), {});
      WindowCollector collector(
          picture, judge, layout, window, memory.bytes(), Time(0), totals,
          {[](const CellBatch& cell) { return test::made_cells(cell).excluded; },
           [&](TracerKey tracer, const TracedCells& cells) {
             log.push_back(JobPicture::cells_entry(picture.passes().pass(), tracer, cells.range,
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
    for (const std::string& entry : log) next.replay(entry);
    CHECK(same_sums(next.framebuffer(), expected));
  }
}

}  // namespace parray
