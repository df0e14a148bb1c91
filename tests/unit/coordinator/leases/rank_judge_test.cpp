#include "coordinator/leases/rank_judge.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "common/scene/settings.h"
#include "tests/support/faulty_team.h"
#include "tests/support/rooms.h"
#include "tests/support/window_rig.h"

namespace parray {
namespace {

using test::made_cells;
using test::same_sums;
using Ranks = std::vector<std::uint32_t>;

constexpr std::uint32_t ranks = 4;

RenderSettings even_settings() { return test::made_settings(30, 9, 600); }

RenderSettings settings_in_passes() {
  RenderSettings settings = test::made_settings(30, 9, 4096);
  settings.adaptive = true;
  settings.passes = {4 * 30 * 9, 9 * 30 * 9};
  return settings;
}

/// A window of four ranks, which log the results that a test gives. Wrong bits are plausible
/// numbers.
struct JudgeRig : test::WindowRig {
  explicit JudgeRig(const RenderSettings& its_settings = even_settings(),
                    const std::vector<CellRange>& done = {},
                    const std::vector<std::string>& hosts = {})
      : WindowRig(its_settings, ranks, 0, done, hosts), cells(plan().cells()) {
    for (std::uint32_t rank = 0; rank < ranks; ++rank) sources.push_back(source_of(rank));
  }
  void put(std::uint32_t rank, const CellRange& range) {
    sources[rank].put(range, test::made_records(plan(), range));
    collect(now);
  }
  /// The first cell of the range has wrong sums.
  void lie(std::uint32_t rank, const CellRange& range) {
    TracedCells cells_of_range = made_cells(plan().batch(range));
    test::falsify(cells_of_range, layout.record_bytes());
    sources[rank].put(range, cells_of_range.records);
    collect(now);
  }
  [[nodiscard]] std::vector<CellRange> missing() const { return picture.collector().missing(); }
  [[nodiscard]] bool told_to_stop(std::uint32_t rank) {
    return window.load(WindowLayout::rank_word(rank, WindowLayout::stop)) != 0;
  }
  void finish_and_check() {
    put(0, {0, cells});
    collect(now);
    CHECK(collector.done());
    CHECK(same_sums(picture.framebuffer(), test::made_framebuffer(settings)));
    // A later process has the same picture, from the log.
    JobPicture next(settings, picture.scene());
    for (const std::string& entry : log) next.replay(entry);
    CHECK(same_sums(next.framebuffer(), picture.framebuffer()));
  }

  std::uint64_t cells;
  std::vector<WindowSource> sources;
  Time now{};
};

void check_verdict(const JudgeRig& rig, std::uint32_t rank, std::uint64_t cells) {
  REQUIRE(rig.judge.verdicts().size() == 1);
  const RankJudge::Verdict& verdict = rig.judge.verdicts().front();
  CHECK(verdict.rank == rank);
  CHECK(verdict.left_out == Ranks{rank});
  CHECK(verdict.cells == cells);
  CHECK_FALSE(verdict.restarted);
  CHECK_FALSE(rig.judge.self_doubt());
}

}  // namespace

TEST_CASE("if the first bits are wrong, their rank is faulty and all its cells are retracted") {
  JudgeRig rig;
  rig.lie(2, {0, 5});
  rig.put(2, {10, 12});
  rig.put(3, {20, 22});
  rig.put(1, {0, 5});
  check_verdict(rig, 2, 7);
  CHECK(rig.totals.mismatches == 1);
  CHECK(rig.retracted == std::vector<CellRange>{{0, 5}, {10, 12}});
  CHECK(rig.missing() == std::vector<CellRange>{{5, 20}, {22, rig.cells}});
  rig.finish_and_check();
}

TEST_CASE("if the second bits are wrong, their rank is faulty and its result is dropped") {
  JudgeRig rig;
  rig.put(1, {0, 5});
  rig.put(2, {10, 12});
  rig.lie(2, {4, 9});
  check_verdict(rig, 2, 2);
  CHECK(rig.totals.mismatches == 1);
  CHECK(rig.missing() == std::vector<CellRange>{{5, rig.cells}});
  rig.finish_and_check();
}

TEST_CASE("if both ranks are wrong, both are faulty") {
  JudgeRig rig;
  rig.lie(1, {0, 5});
  TracedCells other = made_cells(rig.plan().batch({0, 5}));
  test::falsify(other, rig.layout.record_bytes());
  test::falsify(other, rig.layout.record_bytes());
  rig.sources[2].put({0, 5}, other.records);
  rig.collect();
  REQUIRE(rig.judge.verdicts().size() == 2);
  CHECK(rig.judge.left_out(1));
  CHECK(rig.judge.left_out(2));
  CHECK(rig.picture.collector().done_cells() == 0);
  rig.finish_and_check();
}

TEST_CASE("a faulty rank is stopped, and its later results are dropped") {
  JudgeRig rig;
  rig.put(1, {0, 5});
  CHECK_FALSE(rig.told_to_stop(2));
  rig.lie(2, {0, 5});
  CHECK(rig.told_to_stop(2));
  CHECK_FALSE(rig.told_to_stop(1));
  const std::uint64_t entries = rig.totals.entries;
  rig.put(2, {5, 9});
  CHECK(rig.totals.entries == entries);
  CHECK(rig.missing() == std::vector<CellRange>{{5, rig.cells}});
  rig.finish_and_check();
}

TEST_CASE("a stopped rank takes no more work after its next heartbeat") {
  JudgeRig rig;
  WindowSource& source = rig.sources[2];
  CHECK(source.take_part(1e6, true).answer == LeaseSource::Answer::lease);
  rig.window.store(WindowLayout::rank_word(2, WindowLayout::stop), 1);
  source.publish(WindowLayout::samples, 5);
  CHECK(source.take_part(1e6, true).answer == LeaseSource::Answer::lease);
  source.publish(WindowLayout::beat, 5);
  CHECK(source.take_part(1e6, true).answer == LeaseSource::Answer::over);
  CHECK(rig.sources[1].take_part(1e6, true).answer == LeaseSource::Answer::lease);
}

TEST_CASE("a faulty rank is stopped in the next pass, too") {
  JudgeRig rig;
  rig.put(1, {0, 5});
  rig.lie(2, {0, 5});
  rig.window.store(WindowLayout::rank_word(2, WindowLayout::stop), 0);
  const WindowCollector next(rig.picture, rig.judge, rig.layout, rig.window, rig.memory.bytes(),
                             Time(0), rig.totals, {});
  CHECK(rig.told_to_stop(2));
  CHECK_FALSE(rig.told_to_stop(1));
}

TEST_CASE("before the pass ends, rank 0 traces cells that only a faulty rank had checked") {
  JudgeRig rig;
  rig.put(1, {0, 40});
  rig.put(2, {0, 30});  // confirms
  rig.put(3, {40, rig.cells});
  const std::uint64_t before = rig.traced_in_rank_0;
  SUBCASE("and they are right") {
    rig.lie(2, {35, 38});
    CHECK_FALSE(rig.collector.done());
    for (int turn = 0; turn < 10; ++turn) rig.collect();
    CHECK(rig.traced_in_rank_0 == before + 1 + 30);
    check_verdict(rig, 2, 0);
    CHECK(rig.missing().empty());
    rig.finish_and_check();
  }
  SUBCASE("unless another rank has checked them") {
    rig.put(3, {0, 30});
    rig.lie(2, {35, 38});
    for (int turn = 0; turn < 10; ++turn) rig.collect();
    CHECK(rig.traced_in_rank_0 == before + 1);
    rig.finish_and_check();
  }
}

TEST_CASE("two ranks with the same wrong bits confirm each other until one is found faulty") {
  JudgeRig rig;
  rig.lie(1, {0, 5});
  rig.lie(2, {0, 5});
  rig.put(3, {5, rig.cells});
  CHECK(rig.judge.verdicts().empty());
  CHECK(rig.collector.done());
  rig.lie(2, {5, 9});
  for (int turn = 0; turn < 10; ++turn) rig.collect();
  REQUIRE(rig.judge.verdicts().size() == 2);
  CHECK(rig.judge.left_out(1));
  CHECK(rig.judge.left_out(2));
  rig.finish_and_check();
}

TEST_CASE("ranks of a host are one machine, except on rank 0's host") {
  JudgeRig rig(even_settings(), {}, {"head", "head", "node", "node"});
  rig.put(1, {0, 2});
  rig.put(2, {2, 4});
  rig.put(3, {4, 6});
  SUBCASE("another host") {
    rig.lie(3, {0, 2});
    REQUIRE(rig.judge.verdicts().size() == 1);
    CHECK(rig.judge.verdicts()[0].rank == 3);
    CHECK(rig.judge.verdicts()[0].left_out == Ranks{2, 3});
    CHECK(rig.judge.verdicts()[0].cells == 4);
    CHECK(rig.told_to_stop(2));
    CHECK(rig.missing() == std::vector<CellRange>{{2, rig.cells}});
  }
  SUBCASE("rank 0's host") {
    rig.lie(1, {4, 6});
    check_verdict(rig, 1, 2);
    CHECK_FALSE(rig.told_to_stop(0));
    CHECK(rig.missing() == std::vector<CellRange>{{0, 2}, {6, rig.cells}});
  }
  rig.finish_and_check();
}

TEST_CASE("wrong bits of an earlier mpirun are retracted, and no present rank is faulty") {
  JudgeRig rig;
  TracedCells wrong = made_cells(rig.plan().batch({0, 5}));
  test::falsify(wrong, rig.layout.record_bytes());
  rig.keep(test::earlier_tracer(), wrong);
  rig.picture.collector().take(test::earlier_tracer(), wrong);
  rig.put(1, {0, 2});
  REQUIRE(rig.judge.verdicts().size() == 1);
  CHECK_FALSE(rig.judge.verdicts()[0].rank);
  CHECK(rig.judge.verdicts()[0].left_out.empty());
  CHECK(rig.judge.verdicts()[0].cells == 5);
  CHECK(rig.missing() == std::vector<CellRange>{{2, rig.cells}});
  rig.finish_and_check();
}

TEST_CASE("if rank 0 contradicts its own bits, it decides nothing and its cells are retracted") {
  JudgeRig rig;
  rig.lie(0, {0, 5});
  rig.put(2, {5, 9});
  rig.put(1, {0, 5});
  CHECK(rig.judge.self_doubt());
  CHECK(rig.missing() == std::vector<CellRange>{{0, 5}, {9, rig.cells}});
  rig.lie(3, {5, 9});
  CHECK(rig.judge.verdicts().size() == 1);
}

TEST_CASE("rank 0 blames no other rank for a cell for which it contradicts its own bits") {
  JudgeRig rig;
  rig.put(1, {0, 5});
  rig.rank_0_lies = true;
  rig.put(0, {0, 3});
  CHECK_FALSE(rig.judge.self_doubt());  // equal bits are not traced again
  rig.lie(0, {3, 5});
  CHECK(rig.judge.self_doubt());
  CHECK(rig.judge.verdicts().size() == 1);
  CHECK_FALSE(rig.judge.left_out(1));
}

TEST_CASE("rank 0 checks no more cells of other ranks after it contradicts its own bits") {
  JudgeRig rig;
  rig.lie(0, {0, 1});
  rig.lie(1, {1, 5});
  rig.lie(2, {0, 1});
  rig.lie(2, {1, 5});
  rig.put(3, {5, rig.cells});
  CHECK(rig.judge.verdicts().empty());
  rig.lie(2, {5, 9});  // then rank 0 traces again what only rank 2 had checked, from cell 0 on
  CHECK(rig.judge.self_doubt());
  CHECK(rig.judge.verdicts().size() == 2);
  CHECK(rig.judge.left_out(2));
  CHECK_FALSE(rig.judge.left_out(1));
}

TEST_CASE("a wrong result of rank 0 for cells of another rank is found") {
  JudgeRig rig;
  rig.put(0, {0, 5});
  rig.rank_0_lies = true;
  rig.lie(1, {0, 5});
  CHECK(rig.judge.self_doubt());
}

TEST_CASE("a picture in passes restarts if a faulty rank's bits influenced its passes") {
  JudgeRig rig(settings_in_passes());
  rig.lie(2, {0, 2});
  rig.put(1, {2, rig.cells});
  rig.put(1, {0, 2});
  REQUIRE(rig.judge.verdicts().size() == 1);
  CHECK(rig.judge.verdicts()[0].rank == 2);
  CHECK(rig.judge.verdicts()[0].restarted);
  CHECK(rig.restarts == 1);
  CHECK(rig.collector.overtaken());
  CHECK_FALSE(rig.collector.done());
  CHECK(rig.picture.framebuffer().counts().samples == 0);
  rig.put(1, {2, 5});  // of the plan before
  CHECK(rig.picture.framebuffer().counts().samples == 0);
  rig.collector.issue_copies(seconds(1));
  rig.collector.finish();
  for (std::uint32_t rank = 0; rank < ranks; ++rank) CHECK(rig.told_to_stop(rank));
  rig.collector.finish();
}

TEST_CASE("without Hooks::trace the first bits stay, and differences are counted") {
  JudgeRig rig;
  RankJudge judge(rig.picture, rank_voices(test::hosts_apart(ranks)), {});
  WindowCollector collector(rig.picture, judge, rig.layout, rig.window, rig.memory.bytes(), Time(0),
                            rig.totals,
                            {[](const CellBatch& cell) { return made_cells(cell).excluded; }, {}});
  rig.sources[1].put({0, 5}, test::made_records(rig.plan(), {0, 5}));
  collector.collect(Time(0), 100);
  TracedCells wrong = made_cells(rig.plan().batch({2, 4}));
  test::falsify(wrong, rig.layout.record_bytes(), 1);
  rig.sources[2].put({2, 4}, wrong.records);
  collector.collect(Time(0), 100);
  CHECK(rig.totals.mismatches == 1);
  CHECK(rig.totals.duplicates == 1);
  CHECK(judge.verdicts().empty());
}

}  // namespace parray
