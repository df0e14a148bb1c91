#include "coordinator/jobs/journal.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "cli/check/audit/audit.h"
#include "common/base/bytes.h"
#include "common/base/error.h"
#include "coordinator/jobs/work_map.h"
#include "tests/support/rooms.h"

namespace parray::test {
namespace {

using Entries = std::vector<JournalEntry>;

JournalPass pass(std::uint32_t number, std::uint64_t cells) {
  return {number, cells, 10, {cells, 10, 1, 2048}};
}
JournalMerge merge(TracerKey tracer, std::uint64_t epoch, CellRange range,
                   std::uint32_t in_pass = 0) {
  return {in_pass, tracer, epoch, range, 2048 * range.count(), 10, 12, 2, 77};
}

/// A journal of 100 cells in two leases of two workers.
Entries whole() {
  return {pass(0, 100), JournalWorker{1, 2, "ann"}, merge(1, 1, {0, 60}),
          JournalWorker{2, 4, "bob"}, merge(2, 2, {60, 100})};
}

/// 5 cells across each of 20 rows, of two pixels.
GridShape grid(RowOrder order = RowOrder::sequential) {
  GridShape shape;
  shape.width = 10;
  shape.height = 20;
  shape.row_order = order;
  shape.cell_pixels = 2;
  shape.layer_samples = 4;
  shape.stages = {{0, 4}};
  return shape;
}

bool has_problem(Entries entries, JournalEntry last) {
  entries.push_back(std::move(last));
  return !audit_journal(entries).problems.empty();
}

}  // namespace

TEST_CASE("a journal is read as it was written, by one process or by two") {
  Entries entries = whole();
  entries.emplace_back(JournalRetraction{0, 13, {{0, 10}, {20, 30}}});
  entries.emplace_back(JournalGrid{0, grid(RowOrder::interleaved)});
  Journal journal;
  Journal second;
  for (const JournalEntry& entry : entries) second.replay(journal.add(entry));
  CHECK(second.bytes() == journal.bytes());
  CHECK(second.knows(1));
  CHECK_FALSE(second.knows(3));
  CHECK(second.has_pass(0));
  const Entries back = read_journal(journal.bytes());
  REQUIRE(back.size() == entries.size());
  CHECK(std::get<JournalWorker>(back[1]).name == "ann");
  CHECK(std::get<JournalMerge>(back[4]).digest == 77);
  CHECK(std::get<JournalRetraction>(back[5]).cells.back() == CellRange{20, 30});
  CHECK(std::get<JournalPass>(back[0]).grain.row_cells == 10);
  CHECK(std::get<JournalGrid>(back[6]).shape == grid(RowOrder::interleaved));
}

TEST_CASE("a journal that is cut or damaged is refused") {
  Journal journal;
  for (const JournalEntry& entry : whole()) journal.add(entry);
  const std::string& bytes = journal.bytes();
  CHECK_THROWS_AS(read_journal(std::string_view(bytes).substr(0, bytes.size() - 1)), DecodeError);
  CHECK_THROWS_AS(read_journal(std::string(4, '\x09')), DecodeError);
  CHECK_THROWS_AS(read_journal(bytes + "x"), DecodeError);
}

TEST_CASE("the message about a damaged journal names the job and the damage") {
  try {
    read_journal(std::string(4, '\x09'));
    FAIL("the journal was accepted");
  } catch (const DecodeError& error) {
    CHECK(damaged_journal(7, error.what()) ==
          "the journal of job 7 is damaged (an entry of an unknown kind): submit the scene again "
          "for a new journal");
  }
}

TEST_CASE("the work map shows the seconds of each pixel and the worker that traced it last") {
  Entries entries = whole();
  CHECK(work_map(entries, 10, 20).tracer ==
        std::vector(200, WorkMap::no_worker));  // the journal has no grid
  entries.insert(entries.begin(), JournalGrid{0, grid()});
  WorkMap map = work_map(entries, 10, 20);
  CHECK(map.workers == std::vector<std::string>{"ann", "bob"});
  CHECK(map.tracer[0] == 0);
  CHECK(map.tracer[119] == 0);
  CHECK(map.tracer[120] == 1);  // cell 60 begins row 12
  CHECK(map.seconds[0] == doctest::Approx(2 * 2 / 120.0));
  CHECK(map.seconds[199] == doctest::Approx(2 * 4 / 80.0));
  entries.emplace_back(JournalRetraction{0, 13, {{0, 1}}});
  entries.emplace_back(merge(2, 3, {0, 1}));
  map = work_map(entries, 10, 20);
  CHECK(map.tracer[1] == 1);
  CHECK(map.tracer[2] == 0);
  CHECK(map.seconds[1] ==
        doctest::Approx(2 * 2 / 120.0 + 2 * 4 / 2.0));  // retracted time counts, too
  CHECK_THROWS_AS(work_map(entries, 20, 10), DecodeError);
  entries.emplace_back(merge(2, 4, {100, 101}));
  CHECK_THROWS_AS(work_map(entries, 10, 20), DecodeError);
}

TEST_CASE("an audit of a journal with every cell merged once is clean and names the workers") {
  const Audit audit = audit_journal(whole());
  CHECK(audit.complete());
  CHECK(audit.cells == 100);
  CHECK(audit.leases == 2);
  REQUIRE(audit.workers.size() == 2);
  CHECK(audit.workers[0].name == "ann");
  CHECK(audit.workers[0].cells == 60);
  CHECK(audit.workers[1].cells == 40);
  Entries unfinished = whole();
  unfinished.pop_back();
  CHECK(audit_journal(unfinished).problems.empty());
  CHECK_FALSE(audit_journal(unfinished).complete());
}

TEST_CASE("an audit finds cells merged twice, leases merged twice, and unknown passes or workers") {
  CHECK(has_problem(whole(), merge(1, 3, {59, 60})));
  CHECK(has_problem(whole(), merge(1, 3, {0, 100})));
  CHECK(has_problem({pass(0, 100), JournalWorker{1, 2, "ann"}, merge(1, 1, {0, 10})},
                    merge(1, 1, {10, 20})));
  CHECK(has_problem({pass(0, 100)}, merge(1, 1, {0, 10})));
  CHECK(has_problem({pass(0, 100), JournalWorker{1, 2, "ann"}}, merge(1, 1, {0, 10}, 1)));
  CHECK(has_problem({pass(0, 100), JournalWorker{1, 2, "ann"}}, merge(1, 1, {90, 101})));
  CHECK(has_problem(whole(), pass(0, 100)));
}

TEST_CASE("exactly the retracted cells may be merged once more") {
  Entries entries = whole();
  entries.emplace_back(JournalRetraction{0, 13, {{10, 20}, {55, 65}}});
  CHECK(audit_journal(entries).merged == 80);
  CHECK(audit_journal(entries).set_back == 20);
  CHECK(has_problem(entries, JournalRetraction{0, 14, {{5, 15}}}));
  CHECK(has_problem(entries, merge(1, 3, {9, 20})));
  entries.emplace_back(merge(1, 3, {10, 20}));
  entries.emplace_back(merge(2, 4, {55, 65}));
  CHECK(audit_journal(entries).complete());
}

TEST_CASE("the audit splits the time into start, tracing, between leases and the end") {
  // Two workers of one thread: the first begins at 0, has the scene at 2, traces until 10; the
  // second traces from 0 to 5 and then has nothing more.
  const Entries entries = {pass(0, 100),
                           JournalWorker{1, 1, "ann"},
                           JournalWorker{2, 1, "bob"},
                           JournalMerge{0, 1, 1, {0, 40}, 1, 0, 6, 4, 0},
                           JournalMerge{0, 2, 2, {40, 60}, 1, 0, 5, 5, 0},
                           JournalMerge{0, 1, 3, {60, 100}, 1, 6, 10, 3, 0}};
  const TimeSpent spent = time_spent(entries);
  CHECK(spent.seconds == doctest::Approx(10));
  CHECK(spent.threads == 2);
  CHECK(spent.tracing == doctest::Approx(12.0 / 20));
  CHECK(spent.start == doctest::Approx(2.0 / 20));
  CHECK(spent.tail == doctest::Approx(5.0 / 20));
  CHECK(spent.between == doctest::Approx(1.0 / 20));
  CHECK(time_spent({}).threads == 0);
}

TEST_CASE("a simulated pass with even costs takes work divided by threads with every policy") {
  Entries entries = {pass(0, 10'000), JournalWorker{1, 2, "ann"}};
  for (std::uint64_t i = 0; i < 100; ++i) {
    JournalMerge one = merge(1, i + 1, {100 * i, 100 * (i + 1)});
    one.seconds = 0.5;
    entries.emplace_back(one);
  }
  for (const SchedulePolicy policy : {SchedulePolicy::static_split, SchedulePolicy::guided,
                                      SchedulePolicy::factoring, SchedulePolicy::weighted}) {
    for (const std::uint32_t copies : {1U, 4U}) {
      const Replayed replayed = replay_job(entries, policy, copies);
      CHECK(replayed.seconds == doctest::Approx(50.0 / copies).epsilon(0.02));
      CHECK(replayed.efficiency <= 1 + 1e-9);
      CHECK(replayed.efficiency > 0.97);
    }
  }
}

TEST_CASE("a simulated picture with an expensive end shows the cost of static leases") {
  Entries entries = {pass(0, 1000), JournalWorker{1, 1, "ann"}};
  for (std::uint64_t i = 0; i < 100; ++i) {
    JournalMerge one = merge(1, i + 1, {10 * i, 10 * (i + 1)});
    one.seconds = i < 75 ? 0.1 : 1;
    entries.emplace_back(one);
  }
  const double all = replay_job(entries, SchedulePolicy::weighted, 4).efficiency;
  CHECK(replay_job(entries, SchedulePolicy::static_split, 4).seconds == doctest::Approx(25));
  CHECK(all > 0.9);
  CHECK_THROWS_AS(replay_job({}, SchedulePolicy::weighted, 1), RunError);
}

TEST_CASE("a simulated pass counts cells that were set back only with their last result") {
  Entries entries = {pass(0, 10), JournalWorker{1, 1, "ann"}};
  const auto add = [&](std::uint64_t epoch, CellRange range) {
    JournalMerge one = merge(1, epoch, range);
    one.seconds = static_cast<double>(range.count());
    entries.emplace_back(one);
  };
  add(1, {0, 10});
  entries.emplace_back(JournalRetraction{0, 13, {{2, 4}}});
  CHECK(replay_job(entries, SchedulePolicy::static_split, 1).seconds == doctest::Approx(8));
  add(2, {2, 4});
  for (const SchedulePolicy policy : {SchedulePolicy::static_split, SchedulePolicy::weighted}) {
    CHECK(replay_job(entries, policy, 1).seconds == doctest::Approx(10));
    CHECK(replay_job(entries, policy, 1).efficiency == doctest::Approx(1));
  }
}

TEST_CASE("an even pass takes work divided by total speed; slow workers hardly delay it") {
  const ChunkGrain grain{100'000, 100, 1, 64};
  const std::vector<ImaginedWorker> workers = {{2, 1}, {1, 0.1}, {4, 2}};
  for (const SchedulePolicy policy : {SchedulePolicy::weighted, SchedulePolicy::factoring}) {
    const Replayed replayed = replay_even_pass(grain, 1000, workers, policy);
    const double even = 1000 / 10.1;
    CHECK(replayed.seconds >= even * (1 - 1e-9));
    CHECK(replayed.seconds < even * (policy == SchedulePolicy::weighted ? 1.02 : 1.1));
    CHECK(replayed.efficiency == doctest::Approx(even / replayed.seconds));
  }
}

}  // namespace parray::test
