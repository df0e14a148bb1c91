// Ranks and a ledger over a window whose operations are slow, late, torn or corrupt, and whose
// ranks die at any operation, in virtual time: as long as rank 0 lives, the sums come out exactly
// right.
#include <doctest/doctest.h>

#include <algorithm>
#include <memory>

#include "coordinator/window_ledger.h"
#include "tests/support/faulty_window.h"
#include "tests/support/window_rig.h"
#include "worker/rank_worker.h"
#include "worker/window_leases.h"

namespace parray::test {
namespace {

struct Storm {
  std::uint64_t seed = 0;
  std::uint32_t ranks = 1;
  WindowFaults faults;
  RenderSettings settings;
  std::vector<WorkRect> pending;
  std::uint32_t tile = 0;
};

/// One job from beginning to end.
class Job {
 public:
  explicit Job(const Storm& storm)
      : storm_(storm),
        dice_(storm.seed),
        plan_(storm.settings, storm.pending, storm.tile),
        layout_(plan_, storm.ranks),
        memory_(layout_.bytes()),
        window_(memory_.bytes()),
        framebuffer_(storm.settings),
        ledger_(plan_, layout_, window_, memory_.bytes(), framebuffer_, Time(0)) {}

  void run() {
    std::vector<std::function<void(std::size_t)>> tasks = {[this](std::size_t) { lead(); }};
    for (std::uint32_t rank = 1; rank < storm_.ranks; ++rank) {
      tasks.emplace_back([this](std::size_t self) { follow(self); });
    }
    turns_.run(tasks);
  }

  void check() const {
    CHECK(ledger_.done());
    const Framebuffer expected = made_framebuffer(storm_.settings, storm_.pending);
    CHECK(same_sums(framebuffer_, expected));
    CHECK(wrong_rows_ == 0);
    CHECK(ledger_.tally().mismatches == 0);
  }
  [[nodiscard]] const WindowLedger::Tally& tally() const { return ledger_.tally(); }
  [[nodiscard]] const FaultyWindow::Tally& faults() const { return faults_; }

 private:
  WindowLeaseOptions options(std::size_t rank) const {
    WindowLeaseOptions own;
    own.policy = storm_.settings.schedule;
    own.rank = static_cast<std::uint32_t>(rank);
    own.all_threads = storm_.ranks;
    return own;
  }

  /// Rank 0, as the program's does it.
  void lead() {
    const WindowFaults slow{storm_.faults.longest_operation, 0, 0, {}, 0, 0};
    FaultyWindow window(window_, turns_, mail_, 0, slow, dice_.bits(), faults_);
    WindowLeases leases(plan_, layout_, window, options(0));
    SimCellTeam team(plan_, turns_, 1e4 * (1 + dice_.unit()));
    RankWorker worker(plan_, leases, team, turns_);
    try {
      while (!ledger_.done()) {
        mail_.deliver(turns_.now(), window_);
        ledger_.collect(turns_.now(), 1 + dice_.below(20));
        ledger_.issue_copies(turns_.now());
        ledger_.listen(turns_.now());
        if (dice_.one_in(4)) {
          store();
        }
        const Time due = std::min(worker.tick(turns_.now()), team.due());
        turns_.sleep(0, std::clamp(due - turns_.now(), Time(1), Time(milliseconds(5))));
      }
    } catch (const Turns::Over&) {  // check() sees that it is not done
    }
    ledger_.finish();
  }

  void store() {
    while (const auto kept = ledger_.take_finished_rows()) {
      const RowBlock& block = *kept;
      wrong_rows_ += block == made_block(storm_.settings, block.rect) ? 0 : 1;
    }
  }

  void follow(std::size_t self) {
    const double speed = 1e4 * dice_.ten_to(-1, 1);
    FaultyWindow window(window_, turns_, mail_, self, storm_.faults, dice_.bits(), faults_);
    WindowLeases leases(plan_, layout_, window, options(self));
    SimCellTeam team(plan_, turns_, speed);
    RankWorker worker(plan_, leases, team, turns_);
    try {
      while (!worker.over()) {
        const Time due = std::min(worker.tick(turns_.now()), team.due());
        turns_.sleep(self, std::max(due - turns_.now(), Time(1)));
      }
    } catch (const FaultyWindow::Death&) {
    } catch (const Turns::Over&) {
    }
  }

  const Storm storm_;
  Dice dice_;
  WorkPlan plan_;
  WindowLayout layout_;
  WindowMemory memory_;
  LocalWindow window_;
  Framebuffer framebuffer_;
  WindowLedger ledger_;
  Turns turns_{std::chrono::hours(1)};
  Mail mail_;
  FaultyWindow::Tally faults_;
  std::uint64_t wrong_rows_ = 0;
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
  storm.tile = dice.one_in(3) ? 8 : 0;
  const std::uint32_t spp = storm.settings.samples_per_pixel;
  const std::uint32_t rows = storm.settings.height;
  storm.pending = {{rows / 2, rows, 0, spp}, {0, rows / 3, spp / 2, spp}};
  return storm;
}

struct Seen {
  WindowLedger::Tally ledger;
  FaultyWindow::Tally faults;

  void add(const Job& job) {
    ledger.duplicates += job.tally().duplicates;
    ledger.corrupt += job.tally().corrupt;
    ledger.copies += job.tally().copies;
    faults.deaths += job.faults().deaths;
    faults.late += job.faults().late;
    faults.torn += job.faults().torn;
    faults.corrupt += job.faults().corrupt;
  }
};

template <typename MakeFaults>
Seen run_storms(std::uint64_t first_seed, std::uint64_t count, MakeFaults faults) {
  Seen seen;
  for (std::uint64_t seed = first_seed; seed < first_seed + count; ++seed) {
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

TEST_CASE("100 windows with slow operations: every sum is right, whoever overtakes whom") {
  const Seen seen = run_storms(
      0, 100, [](Dice& dice) { return WindowFaults{Time(dice.below(4'000'000)), 0, 0, {}, 0, 0}; });
  CHECK(seen.ledger.corrupt == 0);
  CHECK(seen.ledger.duplicates > 100);  // copies raced with originals
}

TEST_CASE("100 windows whose ranks die at any operation: every sum is right") {
  const Seen seen = run_storms(1000, 100, [](Dice& dice) {
    return WindowFaults{Time(dice.below(1'000'000)), 0.1 * dice.unit(), 0, {}, 0, 0};
  });
  CHECK(seen.faults.deaths > 60);
  CHECK(seen.ledger.copies > 60);
}

TEST_CASE("100 windows where puts arrive after their log entry, in parts or corrupt") {
  const Seen seen = run_storms(2000, 100, [](Dice& dice) {
    const Time latest = dice.one_in(2) ? seconds(1) : seconds(10);
    return WindowFaults{
        Time(dice.below(1'000'000)), 0, dice.unit() / 2, latest, 0.5, dice.unit() / 4};
  });
  CHECK(seen.faults.late > 100);
  CHECK(seen.faults.torn > 50);
  CHECK(seen.faults.corrupt > 50);
  CHECK(seen.ledger.corrupt > 30);
}

TEST_CASE("100 windows with all of that at once") {
  const Seen seen = run_storms(3000, 100, [](Dice& dice) {
    return WindowFaults{Time(dice.below(3'000'000)),
                        0.03 * dice.unit(),
                        dice.unit() / 2,
                        seconds(4),
                        0.5,
                        dice.unit() / 4};
  });
  CHECK(seen.faults.deaths > 30);
  CHECK(seen.faults.corrupt > 30);
}

}  // namespace parray::test
