#include "worker/rank_worker.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <deque>
#include <map>
#include <vector>

#include "tests/support/window_rig.h"

namespace parray {
namespace {

using test::ManualClock;
using test::SimCellTeam;
using Answer = LeaseSource::Answer;

constexpr Time microsecond = std::chrono::microseconds(1);
constexpr double speed = 1e7;  // samples a second

/// Gives what the test has prepared, and notes what it is asked.
class ScriptedLeases final : public LeaseSource {
 public:
  explicit ScriptedLeases(ManualClock& clock) : clock_(clock) {}

  Taken take(double samples_per_second, bool idle) override {
    asked.push_back({clock_.now(), samples_per_second, idle});
    clock_.go_on(take_time);
    if (answers.empty()) {
      return {Answer::wait, {}};
    }
    const Taken answer = answers.front();
    answers.pop_front();
    return answer;
  }
  void complete(const CellRange& range, std::span<const std::byte> records) override {
    clock_.go_on(complete_time);
    done.push_back(range);
    bytes.push_back(records.size());
  }
  void tell(WindowLayout::RankWord word, std::uint64_t value) override {
    told[word].emplace_back(clock_.now(), value);
  }
  void lease(std::uint64_t begin, std::uint64_t end) {
    answers.push_back({Answer::lease, {begin, end}});
  }
  void say(Answer answer) { answers.push_back({answer, {}}); }

  struct Asked {
    Time when;
    double speed;
    bool idle;
  };
  std::deque<Taken> answers;
  std::vector<Asked> asked;
  std::vector<CellRange> done;
  std::vector<std::size_t> bytes;
  std::map<WindowLayout::RankWord, std::vector<std::pair<Time, std::uint64_t>>> told;
  Time take_time{};
  Time complete_time{};

 private:
  ManualClock& clock_;
};

/// A worker whose team has `speed`; cells of 2000 samples, 0.2 ms.
struct Rig {
  Rig() : plan(test::made_settings(1000, 1000, 500), {{0, 1000, 0, 500}}) {
    REQUIRE(plan.cell_samples() == 2000);
  }
  /// Calls the worker whenever it wants to be, or the team is done, until `end`.
  void run(Time end) {
    while (clock.now() < end) {
      const Time due = worker.tick(clock.now());
      if (worker.over()) {
        return;
      }
      const Time next = std::min({due, team.due(), end});
      clock.go_on(std::max(next - clock.now(), microsecond));
      idle += team.busy() ? Time(0) : std::max(next - clock.now(), microsecond);
    }
  }

  WorkPlan plan;
  ManualClock clock;
  ScriptedLeases leases{clock};
  SimCellTeam team{plan, clock, speed};
  RankWorker worker{plan, leases, team, clock};
  Time idle{};
};

Time time_of(std::uint64_t cells) { return std::chrono::microseconds(200 * cells); }

}  // namespace

TEST_CASE("a worker takes a lease at once, says that it is idle, and traces all of it once") {
  Rig rig;
  rig.leases.lease(100, 150);
  rig.worker.tick(rig.clock.now());
  REQUIRE(rig.leases.asked.size() == 1);
  CHECK(rig.leases.asked[0].idle);
  CHECK(rig.leases.asked[0].speed == 0);
  CHECK(rig.team.range() == CellRange{100, 150});
  rig.run(seconds(1));
  REQUIRE(rig.leases.done.size() == 1);
  CHECK(rig.leases.done[0] == CellRange{100, 150});
  CHECK(rig.leases.bytes[0] == 50 * record_bytes_of(rig.plan));
}

TEST_CASE("the next lease is taken before the team runs dry, but not long before") {
  Rig rig;
  rig.leases.take_time = std::chrono::microseconds(100);
  std::uint64_t cell = 0;
  for (int i = 0; i < 30; ++i) {
    rig.leases.lease(cell, cell + 100);
    cell += 100;
  }
  rig.run(30 * time_of(100) + milliseconds(2));
  REQUIRE(rig.leases.asked.size() >= 30);
  // The first has no speed to go by; it is over when the second is asked for.
  for (std::size_t i = 2; i < 30; ++i) {
    CAPTURE(i);
    const Time gap = rig.leases.asked[i].when - rig.leases.asked[i - 1].when;
    CHECK_FALSE(rig.leases.asked[i].idle);
    CHECK(rig.leases.asked[i].speed == doctest::Approx(speed));
    CHECK(gap > time_of(100) - milliseconds(1));
    CHECK(gap < time_of(100) + milliseconds(1));
  }
  CHECK(rig.worker.tally().takes == 30);
  CHECK(rig.worker.tally().taking == 30 * rig.leases.take_time);
  CHECK(rig.worker.tally().samples == 30 * 100 * 2000);
  CHECK(rig.worker.tally().busy == doctest::Approx(30 * 0.02));
  CHECK(rig.leases.done.size() == 30);
}

TEST_CASE("a slow source of leases is asked earlier") {
  for (const Time take_time : {milliseconds(1), milliseconds(4)}) {
    Rig rig;
    rig.leases.take_time = take_time;
    std::uint64_t cell = 0;
    for (int i = 0; i < 20; ++i) {
      rig.leases.lease(cell, cell + 100);
      cell += 100;
    }
    rig.run(time_of(100) * 15);
    for (std::size_t i = 3; i + 1 < rig.leases.asked.size(); ++i) {
      CHECK_FALSE(rig.leases.asked[i].idle);
    }
    const auto per_lease = rig.idle / 15;
    CHECK(per_lease < milliseconds(2));
  }
}

TEST_CASE("the team goes on while a result travels") {
  Rig rig;
  rig.leases.complete_time = milliseconds(10);
  for (std::uint64_t i = 0; i < 10; ++i) {
    rig.leases.lease(i * 100, i * 100 + 100);
  }
  rig.run(time_of(100) * 6);
  // 10 ms of every 20 ms go into putting, and the team has hardly waited.
  CHECK(rig.leases.done.size() >= 5);
  CHECK(rig.worker.tally().putting >= 5 * rig.leases.complete_time);
}

TEST_CASE("a long lease is handed in slices of half a second, without a gap or an overlap") {
  Rig rig;
  rig.leases.lease(0, 100);
  rig.leases.lease(100, 20'100);  // 4 s
  rig.run(seconds(5));
  REQUIRE(rig.leases.done.size() == 9);
  std::uint64_t end = 0;
  for (const CellRange& range : rig.leases.done) {
    CHECK(range.begin == end);
    CHECK(range.count() <= 2500);
    end = range.end;
  }
  CHECK(end == 20'100);
  // Nothing is taken before the last slice has begun.
  REQUIRE(rig.leases.asked.size() >= 3);
  CHECK(rig.leases.asked[2].when > seconds(3) + milliseconds(500));
}

TEST_CASE("a first lease, however long, is traced in small slices, for its speed is unknown") {
  Rig rig;
  rig.leases.lease(0, 20'000);
  rig.worker.tick(rig.clock.now());
  REQUIRE(rig.team.range());
  CHECK(rig.team.range()->count() <= 500);
}

TEST_CASE("no slice is larger than a result may be") {
  const WorkPlan plan(test::made_settings(60'000, 1000, 1), {{0, 1000, 0, 1}});
  ManualClock clock;
  ScriptedLeases leases(clock);
  SimCellTeam team(plan, clock, 1e12);
  RankWorker worker(plan, leases, team, clock);
  leases.lease(0, plan.cells() / 2);
  leases.lease(plan.cells() / 2, plan.cells());
  for (int i = 0; i < 300 && leases.done.size() < 3; ++i) {
    worker.tick(clock.now());
    if (team.range()) {
      REQUIRE(team.range()->count() * record_bytes_of(plan) <= std::size_t{1} << 25);
    }
    clock.go_on(milliseconds(1));
  }
  CHECK(leases.done.size() == 3);
}

TEST_CASE("told to wait, a worker waits longer each time, up to milliseconds, while it is idle") {
  Rig rig;
  rig.run(milliseconds(200));
  const auto& asked = rig.leases.asked;
  REQUIRE(asked.size() > 10);
  CHECK(asked[1].when - asked[0].when < milliseconds(1));
  for (std::size_t i = 1; i + 1 < asked.size(); ++i) {
    CHECK(asked[i].idle);
    CHECK(asked[i + 1].when - asked[i].when >= asked[i].when - asked[i - 1].when - microsecond);
    CHECK(asked[i + 1].when - asked[i].when <= milliseconds(6));
  }
  CHECK(asked.size() < 60);
}

TEST_CASE("told to wait while its team is at work, a worker asks again when the work is done") {
  Rig rig;
  rig.leases.lease(0, 100);
  rig.leases.lease(100, 200);
  rig.run(2 * time_of(100) + milliseconds(1));
  const auto& asked = rig.leases.asked;
  REQUIRE(asked.size() >= 4);
  CHECK_FALSE(asked[2].idle);  // just before the second is done
  CHECK(asked[3].idle);
  CHECK(asked[3].when >= 2 * time_of(100));
  CHECK(asked[3].when < 2 * time_of(100) + milliseconds(1));
}

TEST_CASE("a lease that comes after a wait is traced at once") {
  Rig rig;
  for (int i = 0; i < 5; ++i) {
    rig.leases.say(Answer::wait);
  }
  rig.leases.lease(7, 9);
  rig.run(milliseconds(100));
  CHECK(rig.leases.done == std::vector<CellRange>{{7, 9}});
}

TEST_CASE("a worker is over when the source says so, and asks no more") {
  Rig rig;
  rig.leases.lease(0, 10);
  rig.leases.say(Answer::over);
  rig.run(seconds(1));
  CHECK(rig.worker.over());
  CHECK(rig.clock.now() < milliseconds(50));
  const std::size_t asked = rig.leases.asked.size();
  for (int i = 0; i < 5; ++i) {
    rig.worker.tick(rig.clock.now());
    rig.clock.go_on(seconds(1));
  }
  CHECK(rig.leases.asked.size() == asked);
  CHECK(rig.leases.done == std::vector<CellRange>{{0, 10}});
}

TEST_CASE("a stopped worker gives up its team's work and the rest of its lease") {
  Rig rig;
  rig.leases.lease(0, 20'000);
  rig.run(milliseconds(120));  // in the middle of a slice
  const std::size_t done = rig.leases.done.size();
  CHECK(rig.team.busy());
  rig.worker.stop();
  CHECK(rig.worker.over());
  CHECK_FALSE(rig.team.busy());
  const std::uint64_t started = rig.team.started();
  for (int i = 0; i < 5; ++i) {
    rig.worker.tick(rig.clock.now());
    rig.clock.go_on(seconds(1));
  }
  CHECK(rig.team.started() == started);
  CHECK(rig.leases.done.size() == done);
}

TEST_CASE("a worker's beat counts its samples and says whether it is at work") {
  Rig rig;
  rig.leases.lease(0, 10'000);  // 2 s
  rig.run(seconds(3));
  const auto& beats = rig.leases.told[WindowLayout::beat];
  REQUIRE(beats.size() >= 10);
  std::uint64_t samples = 0;
  for (std::size_t i = 0; i < beats.size(); ++i) {
    const auto& [when, value] = beats[i];
    CHECK(((value & beat_flags::tracing) != 0) == (when < seconds(2)));
    CHECK((value & beat_flags::building) == 0);
    CHECK((value & ~beat_flags::tracing) >= samples);
    samples = value & ~beat_flags::tracing;
    if (i > 0) {
      CHECK(when - beats[i - 1].first >= milliseconds(250));
      CHECK(when - beats[i - 1].first < milliseconds(400));
    }
  }
  CHECK(samples == 10'000 * 2000);
}

TEST_CASE("a report holds what the rank has done") {
  Rig rig;
  rig.leases.take_time = microsecond;
  rig.leases.complete_time = 2 * microsecond;
  rig.leases.lease(0, 10);
  rig.leases.lease(10, 30);
  rig.run(milliseconds(50));
  rig.worker.report();
  const auto value = [&](WindowLayout::RankWord word) {
    REQUIRE_FALSE(rig.leases.told[word].empty());
    return rig.leases.told[word].back().second;
  };
  CHECK(value(WindowLayout::samples) == 30 * 2000);
  CHECK(value(WindowLayout::takes) == 2);
  CHECK(value(WindowLayout::taking) == 2000);
  CHECK(value(WindowLayout::putting) == 4000);
  CHECK(value(WindowLayout::busy) == doctest::Approx(6e6));
}

}  // namespace parray
