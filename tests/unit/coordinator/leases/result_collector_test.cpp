#include "coordinator/leases/result_collector.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "common/scene/settings.h"
#include "tests/support/dice.h"
#include "tests/support/faulty_team.h"
#include "tests/support/rooms.h"
#include "tests/support/window_rig.h"

namespace parray {
namespace {

using test::Dice;
using test::faulty_tracer;
using test::made_cells;
using Ranges = std::vector<CellRange>;

constexpr TracerKey ann_tracer = 11;
constexpr TracerKey bob_tracer = 22;

/// A picture of made-up samples: 40 x 12 pixels of 300 samples, in stages.
struct ResultRig {
  explicit ResultRig(bool ragged = false)
      : settings(test::made_settings(40, 12, 300)),
        framebuffer(settings.width, settings.height),
        plan(make_plan(settings, ragged)),
        collector(plan, framebuffer) {}

  static std::shared_ptr<const WorkPlan> make_plan(const RenderSettings& settings, bool ragged) {
    Pass pass{{{0, 1}, {1, 16}, {16, 300}}, {}};
    if (ragged) {
      Dice dice(9);
      pass = {{{0, 300}}, test::ragged_ranges(dice, std::vector<std::uint32_t>(480), 300)};
    }
    return std::make_shared<const WorkPlan>(settings, std::move(pass));
  }
  ResultCollector::Taken take(TracerKey tracer, const CellRange& range) {
    return collector.take(tracer, made_cells(plan->batch(range)));
  }
  /// The first cell is wrong.
  ResultCollector::Taken take_lie(const CellRange& range) {
    TracedCells cells = made_cells(plan->batch(range));
    test::falsify(cells, record_bytes(plan->grid()->shape().cell_pixels));
    return collector.take(faulty_tracer, cells);
  }
  std::vector<std::uint64_t> honest(const CellRange& range) const {
    return cell_digests(made_cells(plan->batch(range)).records,
                        record_bytes(plan->grid()->shape().cell_pixels));
  }
  void take_missing(TracerKey tracer) {
    for (const CellRange& range : collector.missing()) take(tracer, range);
  }
  [[nodiscard]] bool complete() const {
    Framebuffer expected(settings.width, settings.height);
    std::vector<SampleRange> ranges = plan->pixel_samples();
    if (ranges.empty()) ranges.assign(480, {0, 300});
    test::make_into(expected, ranges);
    return collector.done() && test::same_sums(framebuffer, expected);
  }

  RenderSettings settings;
  Framebuffer framebuffer;
  std::shared_ptr<const WorkPlan> plan;
  ResultCollector collector;
};

std::uint64_t cells_in(const Ranges& ranges) {
  std::uint64_t cells = 0;
  for (const CellRange& range : ranges) cells += range.count();
  return cells;
}

}  // namespace

TEST_CASE("every cell is merged once, whatever results are repeated, in any order") {
  std::uint64_t duplicates = 0;
  for (const bool ragged : {false, true}) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      CAPTURE(seed);
      Dice dice(seed);
      ResultRig rig(ragged);
      ResultCollector::Taken all;
      while (!rig.collector.done()) {
        const std::uint64_t begin = dice.below(rig.plan->cells());
        const std::uint64_t most = rig.plan->cells() - begin;
        const std::uint64_t missing = rig.plan->cells() - rig.collector.done_cells();
        const auto taken = rig.take(1 + dice.below(4), {begin, begin + 1 + dice.below(most)});
        CHECK(taken.mismatches == 0);
        CHECK(taken.fresh + rig.plan->cells() - missing == rig.collector.done_cells());
        all.fresh += taken.fresh;
        all.duplicates += taken.duplicates;
        all.fresh_samples += taken.fresh_samples;
      }
      CHECK(all.fresh == rig.plan->cells());
      CHECK(all.fresh_samples == rig.plan->samples());
      duplicates += all.duplicates;
      CHECK(rig.complete());
    }
  }
  CHECK(duplicates > 100);  // in all histories together
}

TEST_CASE("other bits for merged cells are counted and change nothing") {
  ResultRig rig;
  rig.take(ann_tracer, {0, 5});
  const auto taken = rig.take_lie({0, 7});
  CHECK(taken.mismatches == 1);
  CHECK(taken.duplicates == 4);
  CHECK(taken.fresh == 2);
  rig.take_missing(ann_tracer);
  CHECK(rig.complete());
}

TEST_CASE("compare() merges nothing") {
  ResultRig rig;
  rig.take(ann_tracer, {0, 3});
  auto digests = rig.honest({0, 5});
  digests[1] ^= 1;
  const auto taken = rig.collector.compare({0, 5}, digests);
  CHECK(taken.duplicates == 2);
  CHECK(taken.mismatches == 1);
  CHECK(taken.fresh == 0);
  CHECK(rig.collector.done_cells() == 3);
}

TEST_CASE("differing() returns the cells that differ and the tracers of the merged bits") {
  ResultRig rig;
  rig.take(bob_tracer, {0, 1});
  rig.take(ann_tracer, {1, 4});
  auto digests = rig.honest({0, 6});
  CHECK(rig.collector.differing({0, 6}, digests).empty());
  digests[0] ^= 1;
  digests[2] ^= 1;
  digests[5] ^= 1;  // not merged
  const auto found = rig.collector.differing({0, 6}, digests);
  REQUIRE(found.size() == 2);
  CHECK(found[0].cell == 0);
  CHECK(found[0].tracer == bob_tracer);
  CHECK(found[1].cell == 2);
  CHECK(found[1].tracer == ann_tracer);
}

TEST_CASE("a check counts only if another tracer has traced the cells") {
  ResultRig rig;
  rig.take(ann_tracer, {0, 4});
  rig.take(bob_tracer, {4, 6});
  CHECK(rig.collector.checked_cells() == 0);
  rig.collector.note_check(bob_tracer, {0, 5});
  CHECK(rig.collector.checked_cells() == 4);  // its own cells do not count
  rig.collector.note_check(ann_tracer, {2, 5});
  CHECK(rig.collector.checked_cells() == 5);
  CHECK(rig.collector.relies_on(ann_tracer));
  CHECK_FALSE(rig.collector.has_cells_of(faulty_tracer));
}

TEST_CASE("unchecked cells are listed in ranges of one tracer and of limited length") {
  ResultRig rig;
  rig.take(ann_tracer, {0, 4});
  rig.take(bob_tracer, {4, 9});
  rig.collector.note_check(bob_tracer, {1, 6});
  const auto listed = rig.collector.unchecked_cells(3);
  REQUIRE(listed.size() == 3);
  CHECK(listed[0].range == CellRange{0, 1});
  CHECK(listed[0].tracer == ann_tracer);
  CHECK(listed[1].range == CellRange{4, 7});
  CHECK(listed[1].tracer == bob_tracer);
  CHECK(listed[2].range == CellRange{7, 9});
  CHECK(listed[2].tracer == bob_tracer);
}

TEST_CASE("wanted cells are the merged ones of wanted checks that no other tracer has checked") {
  ResultRig rig;
  CHECK(rig.collector.wanted_cells(9).empty());
  rig.take(ann_tracer, {0, 4});
  rig.take(bob_tracer, {4, 7});
  rig.collector.note_wanted({2, 6});
  rig.collector.note_wanted({6, 9});
  rig.collector.note_check(bob_tracer, {0, 3});
  rig.collector.note_check(ann_tracer, {3, 5});
  const auto listed = rig.collector.wanted_cells(9);
  REQUIRE(listed.size() == 2);
  CHECK(listed[0].range == CellRange{3, 4});
  CHECK(listed[0].tracer == ann_tracer);
  CHECK(listed[1].range == CellRange{5, 7});
  CHECK(listed[1].tracer == bob_tracer);
}

TEST_CASE("cells that a faulty worker has checked stay merged and are unchecked again") {
  ResultRig rig;
  rig.take(ann_tracer, {0, 5});
  rig.take(bob_tracer, {5, 6});
  rig.collector.note_check(faulty_tracer, {1, 3});
  rig.collector.note_check(faulty_tracer, {4, 6});
  rig.collector.note_check(bob_tracer, {0, 2});
  CHECK(rig.collector.relies_on(faulty_tracer));
  CHECK_FALSE(rig.collector.has_cells_of(faulty_tracer));
  const auto gone = rig.collector.retract(faulty_tracer);
  CHECK(gone.cells.empty());
  REQUIRE(gone.unchecked.size() == 3);
  CHECK(gone.unchecked[0].range == CellRange{1, 3});
  CHECK(gone.unchecked[0].tracer == ann_tracer);
  CHECK(gone.unchecked[1].range == CellRange{4, 5});
  CHECK(gone.unchecked[1].tracer == ann_tracer);
  CHECK(gone.unchecked[2].range == CellRange{5, 6});
  CHECK(gone.unchecked[2].tracer == bob_tracer);
  CHECK(rig.collector.checked_cells() == 2);
  CHECK_FALSE(rig.collector.relies_on(faulty_tracer));
}

TEST_CASE("a check does not count for cells that are merged later") {
  ResultRig rig;
  rig.take(ann_tracer, {0, 2});
  rig.take(ann_tracer, {4, 6});
  rig.collector.note_check(bob_tracer, {0, 8});
  rig.take(ann_tracer, {2, 4});
  rig.take(ann_tracer, {6, 8});
  CHECK(rig.collector.checked_cells() == 4);
  CHECK_FALSE(rig.collector.is_checked(2));
  CHECK(rig.collector.is_checked(4));
}

TEST_CASE("cells that are traced again are unchecked") {
  ResultRig rig;
  rig.take(faulty_tracer, {0, 4});
  rig.collector.note_check(bob_tracer, {0, 4});
  rig.collector.retract(faulty_tracer);
  rig.take_missing(ann_tracer);
  CHECK(rig.collector.checked_cells() == 0);
}

TEST_CASE("retract() removes all cells of a faulty worker; the final picture is right") {
  for (const bool ragged : {false, true}) {
    for (std::uint64_t seed = 1; seed <= 30; ++seed) {
      CAPTURE(seed);
      Dice dice(seed);
      ResultRig rig(ragged);
      for (std::uint64_t at = 0; at < rig.plan->cells();) {
        const CellRange range{at, std::min(at + 1 + dice.below(9), rig.plan->cells())};
        at = range.end + dice.below(3);  // some are not merged yet
        at = std::min(at, rig.plan->cells());
        dice.one_in(3) ? rig.take_lie(range)
                       : rig.take(dice.one_in(2) ? ann_tracer : bob_tracer, range);
      }
      const std::uint64_t done = rig.collector.done_cells();
      const bool relied = rig.collector.relies_on(faulty_tracer);
      const Ranges gone = rig.collector.retract(faulty_tracer).cells;
      CHECK(relied == !gone.empty());
      CHECK(cells_in(gone) == done - rig.collector.done_cells());
      CHECK_FALSE(rig.collector.relies_on(faulty_tracer));
      for (const CellRange& range : gone) {
        for (std::uint64_t cell = range.begin; cell < range.end; ++cell) {
          CHECK_FALSE(rig.collector.has(cell));
          for (const std::uint64_t same : rig.plan->grid()->cells_of_same_pixels(cell)) {
            CHECK_FALSE(rig.collector.has(same));  // the sums of a pixel cannot be separated
          }
        }
      }
      CHECK(rig.collector.retract(faulty_tracer).cells.empty());
      rig.take_missing(ann_tracer);
      CHECK(rig.complete());
    }
  }
}

TEST_CASE("retract() also removes checked cells, because the checker may be faulty, too") {
  ResultRig rig;
  rig.take(faulty_tracer, {0, 6});
  rig.collector.note_check(bob_tracer, {2, 4});
  rig.collector.retract(faulty_tracer);
  CHECK(rig.collector.done_cells() == 0);
  CHECK_FALSE(rig.collector.relies_on(99));  // unknown
  CHECK(rig.collector.retract(99).cells.empty());
}

TEST_CASE("ranges of a logged retraction can be retracted") {
  ResultRig rig;
  rig.take(ann_tracer, {0, 20});
  const Ranges gone = rig.collector.retract(Ranges{{3, 5}, {4, 6}});
  CHECK(gone == Ranges{{3, 6}});
  CHECK(rig.collector.retract(Ranges{{3, 6}}).empty());
  rig.take_missing(bob_tracer);
  CHECK(rig.complete());
}

TEST_CASE("next_missing() returns runs of at most the requested length") {
  ResultRig rig;
  CHECK(rig.collector.missing() == Ranges{{0, rig.plan->cells()}});
  CHECK(rig.collector.next_missing(0, 7) == CellRange{0, 7});
  rig.take(ann_tracer, {2, 4});
  rig.take(ann_tracer, {9, rig.plan->cells()});
  CHECK(rig.collector.missing() == Ranges{{0, 2}, {4, 9}});
  CHECK(rig.collector.next_missing(2, 100) == CellRange{4, 9});
  CHECK(rig.collector.next_missing(9, 100).count() == 0);
  rig.take_missing(bob_tracer);
  CHECK(rig.collector.missing().empty());
  CHECK(rig.complete());
}

TEST_CASE("a result that excludes a sample of another pixel is a mismatch") {
  ResultRig rig;
  const auto leaving_out = [&](std::uint32_t x) {
    TracedCells cells = made_cells(rig.plan->batch({0, 2}));
    CellHeader header = header_of(cells.records);
    header.nonfinite = 1;
    std::memcpy(cells.records.data(), &header, sizeof header);
    const Cell cell = rig.plan->cell(0);
    cells.excluded = {{cell.y, cell.x_begin + x, cell.samples.begin, 1}};
    return cells;
  };
  rig.collector.take(ann_tracer, leaving_out(0));
  CHECK(rig.collector.take(bob_tracer, leaving_out(0)).mismatches == 0);
  CHECK(rig.collector.take(faulty_tracer, leaving_out(1)).mismatches == 1);
  CHECK(rig.collector.compare({0, 2}, rig.collector.digests_of(leaving_out(1))).mismatches == 1);
}

}  // namespace parray
