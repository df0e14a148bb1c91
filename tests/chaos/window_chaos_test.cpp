// Ranks and a collector over a window in virtual time. Operations are slow, late, torn or corrupt,
// and ranks die at any operation. As long as rank 0 lives, the sums are exactly right.
#include <doctest/doctest.h>

#include <algorithm>
#include <deque>
#include <memory>

#include "common/scene/settings.h"
#include "tests/support/faulty_window.h"
#include "tests/support/rooms.h"
#include "tests/support/trials.h"
#include "tests/support/window_rig.h"
#include "worker/lease_runner.h"

namespace parray::test {
namespace {

struct Storm {
  std::uint64_t seed = 0;
  std::uint32_t ranks = 1;
  std::uint32_t ledger_ranks = 1;  ///< the argument of Ledgers
  bool by_requests = false;        ///< ranks use the window by requests to rank 0
  WindowFaults faults;
  RenderSettings settings;
  std::vector<CellRange> done;  ///< cells of an earlier run
  std::uint32_t tile = 0;
};

/// One complete job.
class Job {
 public:
  explicit Job(const Storm& storm)
      : storm_(storm),
        dice_(storm.seed),
        rig_(storm.settings, storm.ranks, storm.tile, storm.done),
        requests_(request_window(rig_.memory.bytes())),
        ledgers_(storm.ranks, storm.ledger_ranks) {
    for (std::uint32_t ledger = 0; ledgers_.count() > 1 && ledger < ledgers_.count(); ++ledger) {
      ledger_memory_.emplace_back(WindowLayout::shared_words * sizeof(std::uint64_t));
    }
  }

  void run() {
    std::vector<std::function<void(std::size_t)>> tasks = {[this](std::size_t) { lead(); }};
    for (std::uint32_t rank = 1; rank < storm_.ranks; ++rank) {
      tasks.emplace_back([this](std::size_t self) { follow(self); });
    }
    turns_.run(tasks);
  }

  void check() const {
    CHECK(rig_.collector.done());
    CHECK(same_sums(rig_.picture.framebuffer(), made_framebuffer(storm_.settings)));
    CHECK(rig_.totals.mismatches == 0);
    CHECK(rig_.judge.verdicts().empty());
    // The stored results are the rest of the picture, without a wrong cell.
    JobPicture next(storm_.settings, rig_.picture.scene(), {}, storm_.tile);
    next.begin_pass();
    for (const CellRange& range : storm_.done) {
      next.collector().take(earlier_tracer(), made_cells(rig_.plan().batch(range)));
    }
    for (const TracedCells& cells : rig_.merged) {
      next.replay(
          next.cells_entry(earlier_tracer(), cells.range, pack_cells(cells, *rig_.plan().grid())));
    }
    CHECK(same_sums(next.framebuffer(), rig_.picture.framebuffer()));
  }
  [[nodiscard]] const WindowCollector::Totals& totals() const { return rig_.totals; }
  [[nodiscard]] const FaultyWindow::Tally& faults() const { return faults_; }

 private:
  WindowSource source(std::size_t rank, Window& window, LedgerWindows ledgers) {
    return {rig_.job,
            rig_.pass,
            rig_.layout,
            window,
            {storm_.settings.schedule, static_cast<std::uint32_t>(rank), 1, storm_.ranks, {}},
            std::move(ledgers)};
  }

  /// The ledgers of a rank. They are in the memory of other ranks and have the same faults.
  struct Reached {
    Reached(Job& job, Window& first, std::size_t self, const WindowFaults& faults)
        : all{job.ledgers_, {}} {
      for (WindowMemory& memory : job.ledger_memory_) {
        kept.push_back(std::make_unique<LocalWindow>(memory.bytes()));
        faulty.push_back(std::make_unique<FaultyWindow>(*kept.back(), job.turns_, job.mail_, self,
                                                        faults, job.dice_.bits(), job.faults_));
        all.windows.push_back(faulty.back().get());
      }
      if (all.windows.empty()) all.windows.push_back(&first);
    }
    std::vector<std::unique_ptr<LocalWindow>> kept;
    std::vector<std::unique_ptr<FaultyWindow>> faulty;
    LedgerWindows all;
  };

  /// Runs rank 0 as the program does.
  void lead() {
    const WindowFaults slow{storm_.faults.longest_operation, 0, 0, {}, 0, 0};
    FaultyWindow window(rig_.window, turns_, mail_, 0, slow, dice_.bits(), faults_);
    const Reached ledgers(*this, window, 0, slow);
    WindowSource leases = source(0, window, ledgers.all);
    MadeTeam team(turns_, 1e4 * (1 + dice_.unit()));
    LeaseRunner runner(leases, team, turns_);
    WindowCollector& collector = rig_.collector;
    try {
      while (!collector.done()) {
        mail_.deliver(turns_.now(), rig_.window);
        collector.collect(turns_.now(), 1 + dice_.below(20));
        collector.issue_copies(turns_.now());
        collector.listen(turns_.now());
        const Time due = std::min(runner.tick(turns_.now()), team.due());
        turns_.sleep(0, std::clamp(due - turns_.now(), Time(1), Time(milliseconds(5))));
      }
    } catch (const Turns::Over&) {  // check() finds that the job is not done
    }
    collector.finish();
  }

  void follow(std::size_t self) {
    const double speed = 1e4 * dice_.ten_to(-1, 1);
    Window& reached = storm_.by_requests ? static_cast<Window&>(requests_) : rig_.window;
    FaultyWindow window(reached, turns_, mail_, self, storm_.faults, dice_.bits(), faults_);
    const Reached ledgers(*this, window, self, storm_.faults);
    WindowSource leases = source(self, window, ledgers.all);
    MadeTeam team(turns_, speed);
    LeaseRunner runner(leases, team, turns_);
    try {
      while (!runner.over()) {
        const Time due = std::min(runner.tick(turns_.now()), team.due());
        turns_.sleep(self, std::max(due - turns_.now(), Time(1)));
      }
    } catch (const FaultyWindow::Death&) {
    } catch (const Turns::Over&) {
    }
  }

  const Storm storm_;
  Dice dice_;
  WindowRig rig_;
  RequestWindow requests_;
  Turns turns_{std::chrono::hours(1)};
  Mail mail_;
  FaultyWindow::Tally faults_;
  const Ledgers ledgers_;
  std::deque<WindowMemory> ledger_memory_;  ///< empty if rank 0 has the only ledger
};

Storm storm_of(std::uint64_t seed) {
  Dice dice(seed);
  Storm storm;
  storm.seed = seed;
  storm.ranks = 1 + dice.below32(6);
  storm.settings =
      made_settings(20 + dice.below32(60), 5 + dice.below32(20), 20 + dice.below32(300));
  storm.settings.schedule = static_cast<SchedulePolicy>(seed % 4);
  storm.settings.row_order = dice.one_in(2) ? RowOrder::sequential : RowOrder::interleaved;
  storm.ledger_ranks = 1 + dice.below32(storm.ranks);
  storm.by_requests = seed / 4 % 2 == 1;
  if (storm.by_requests) storm.ledger_ranks = storm.ranks;
  storm.tile = dice.one_in(3) ? 8 : 0;
  const std::uint64_t cells = whole_plan(storm.settings, storm.tile)->cells();
  if (dice.one_in(2)) {
    storm.done = {{cells / 5, cells / 3}, {cells / 2, cells / 2 + cells / 7}};
    std::erase_if(storm.done, [](const CellRange& range) { return range.count() == 0; });
  }
  return storm;
}

struct Seen {
  WindowCollector::Totals totals;
  FaultyWindow::Tally faults;

  void add(const Job& job) {
    totals.duplicates += job.totals().duplicates;
    totals.corrupt += job.totals().corrupt;
    totals.copies += job.totals().copies;
    faults.deaths += job.faults().deaths;
    faults.late += job.faults().late;
    faults.torn += job.faults().torn;
    faults.corrupt += job.faults().corrupt;
  }
};

template <typename MakeFaults>
Seen run_storms(std::uint64_t first_seed, std::uint64_t count, MakeFaults faults) {
  Seen seen;
  for (std::uint64_t seed = first_seed; seed < first_seed + trials(count); ++seed) {
    CAPTURE(seed);
    Storm storm = storm_of(seed);
    Dice dice(seed + 7);
    storm.faults = faults(dice);
    Job job(storm);
    job.run();
    job.check();
    seen.add(job);
  }
  return seen;
}

}  // namespace

TEST_CASE("50 windows with slow operations: every sum is right in any order of operations") {
  const Seen seen = run_storms(
      0, 50, [](Dice& dice) { return WindowFaults{Time(dice.below(4'000'000)), 0, 0, {}, 0, 0}; });
  CHECK(seen.totals.corrupt == 0);
  CHECK(seen.totals.duplicates > 50);  // copies raced with originals
}

TEST_CASE("50 windows whose ranks die at any operation: every sum is right") {
  const Seen seen = run_storms(1000, 50, [](Dice& dice) {
    return WindowFaults{Time(dice.below(1'000'000)), 0.1 * dice.unit(), 0, {}, 0, 0};
  });
  CHECK(seen.faults.deaths > 30);
  CHECK(seen.totals.copies > 30);
}

TEST_CASE("50 windows where puts arrive after their log entry, in parts or corrupt") {
  const Seen seen = run_storms(2000, 50, [](Dice& dice) {
    const Time latest = dice.one_in(2) ? seconds(1) : seconds(10);
    return WindowFaults{
        Time(dice.below(1'000'000)), 0, dice.unit() / 2, latest, 0.5, dice.unit() / 4};
  });
  CHECK(seen.faults.late > 50);
  CHECK(seen.faults.torn > 25);
  CHECK(seen.faults.corrupt > 25);
  CHECK(seen.totals.corrupt > 15);
}

TEST_CASE("50 windows with all of these faults at once") {
  const Seen seen = run_storms(3000, 50, [](Dice& dice) {
    return WindowFaults{Time(dice.below(3'000'000)),
                        0.03 * dice.unit(),
                        dice.unit() / 2,
                        seconds(4),
                        0.5,
                        dice.unit() / 4};
  });
  CHECK(seen.faults.deaths > 15);
  CHECK(seen.faults.corrupt > 15);
}

}  // namespace parray::test
