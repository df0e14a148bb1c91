#include "worker/lease_runner.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <deque>
#include <set>
#include <vector>

#include "common/scene/settings.h"
#include "tests/support/rooms.h"
#include "tests/support/window_rig.h"

namespace parray {
namespace {

using test::MadeTeam;
using test::ManualClock;
using Answer = LeaseSource::Answer;

constexpr Time microsecond = std::chrono::microseconds(1);
constexpr double speed = 1e7;  // samples a second

/// A source that returns the answers of the test and records the requests.
class ScriptedSource final : public LeaseSource {
 public:
  ScriptedSource(ManualClock& clock, std::shared_ptr<const WorkPlan> plan)
      : clock_(clock), plan_(std::move(plan)) {}

  Taken take(Time now, double samples_per_second, bool idle) override {
    asked.push_back({now, samples_per_second, idle});
    clock_.go_on(take_time);
    if (answers.empty()) return {otherwise};
    Taken answer = std::move(answers.front());
    answers.pop_front();
    return answer;
  }
  void complete(Time /*now*/, LeaseResult finished) override {
    clock_.go_on(complete_time);
    done.push_back(std::move(finished));
  }
  [[nodiscard]] bool wants(const LeaseKey& lease) const override {
    return !unwanted.contains(lease.second);
  }
  Time tick(Time now, const TeamState& team) override {
    states.push_back(team);
    return now + seconds(1);
  }
  void report(const WorkTally& tally) override { reported.push_back(tally); }

  void lease(std::uint64_t begin, std::uint64_t end, bool fresh = true, bool length_known = true) {
    const auto count = static_cast<double>(end - begin);
    answers.push_back({Answer::lease,
                       {1, ++epoch_, plan_->batch({begin, end}), made_settings(), "", nullptr},
                       fresh,
                       length_known ? count * plan_->cell_samples() : 0});
  }
  void say(Answer answer) { answers.push_back({answer}); }
  [[nodiscard]] std::vector<CellRange> ranges() const {
    std::vector<CellRange> ranges;
    for (const LeaseResult& finished : done) ranges.push_back(finished.cells->range);
    return ranges;
  }
  static RenderSettings made_settings() { return test::made_settings(1000, 1000, 500); }

  struct Asked {
    Time when;
    double speed;
    bool idle;
  };
  std::deque<Taken> answers;
  Answer otherwise = Answer::wait;
  std::vector<Asked> asked;
  std::vector<LeaseResult> done;
  std::vector<TeamState> states;
  std::vector<WorkTally> reported;
  std::set<std::uint64_t> unwanted;  ///< epochs
  Time take_time{};
  Time complete_time{};

 private:
  ManualClock& clock_;
  std::shared_ptr<const WorkPlan> plan_;
  std::uint64_t epoch_ = 0;
};

/// A runner with a team of speed `speed`. A cell has 2000 samples and takes 0.2 ms.
struct RunnerRig {
  /// Calls the runner at its deadlines and whenever the team is done, until `end`.
  void run(Time end) {
    while (clock.now() < end) {
      const Time due = runner.tick(clock.now());
      if (runner.over()) return;
      const Time next = std::min({due, team.due(), end});
      clock.go_on(std::max(next - clock.now(), microsecond));
      idle += team.idle() ? std::max(next - clock.now(), microsecond) : Time(0);
    }
  }
  void leases(int count) {
    for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(count); ++i) {
      source.lease(100 * i, 100 * i + 100);
    }
  }

  ManualClock clock;
  ScriptedSource source{clock, test::whole_plan(ScriptedSource::made_settings())};
  MadeTeam team{clock, speed};
  LeaseRunner runner{source, team, clock};
  Time idle{};
};

Time time_of(std::uint64_t cells) { return std::chrono::microseconds(200 * cells); }

}  // namespace

TEST_CASE("a runner takes a lease at once, reports an idle team, and hands in the result") {
  RunnerRig rig;
  rig.source.lease(100, 150);
  rig.runner.tick(rig.clock.now());
  REQUIRE(rig.source.asked.size() == 1);
  CHECK(rig.source.asked[0].idle);
  CHECK(rig.source.asked[0].speed == 0);
  REQUIRE(rig.team.lease());
  CHECK(rig.source.states.back().tracing);
  rig.run(seconds(1));
  CHECK(rig.source.ranges() == std::vector<CellRange>{{100, 150}});
  CHECK_FALSE(rig.source.states.back().tracing);
  CHECK(rig.source.states.back().traced == 50 * 2000);
}

TEST_CASE("a runner takes the next lease shortly before its team runs out of work") {
  RunnerRig rig;
  rig.source.take_time = std::chrono::microseconds(100);
  rig.leases(30);
  rig.run(30 * time_of(100) + milliseconds(2));
  REQUIRE(rig.source.asked.size() >= 30);
  // Without a speed, the runner takes the second lease only after the first has ended.
  for (std::size_t i = 2; i < 30; ++i) {
    CAPTURE(i);
    const Time gap = rig.source.asked[i].when - rig.source.asked[i - 1].when;
    CHECK_FALSE(rig.source.asked[i].idle);
    CHECK(rig.source.asked[i].speed == doctest::Approx(speed));
    CHECK(gap > time_of(100) - milliseconds(1));
    CHECK(gap < time_of(100) + milliseconds(1));
  }
  const WorkTally& tally = rig.runner.tally();
  CHECK(tally.leases == 30);
  CHECK(tally.taking == 30 * rig.source.take_time);
  CHECK(tally.samples == 30 * 100 * 2000);
  CHECK(tally.busy == doctest::Approx(30 * 0.02));
  CHECK(tally.build_seconds == 0.25);
  CHECK(tally.accelerator_bytes == 1234);
  CHECK(rig.source.done.size() == 30);
}

TEST_CASE("a runner takes leases earlier from a slow source") {
  for (const Time take_time : {milliseconds(1), milliseconds(4)}) {
    RunnerRig rig;
    rig.source.take_time = take_time;
    rig.leases(20);
    rig.run(time_of(100) * 15);
    for (std::size_t i = 3; i + 1 < rig.source.asked.size(); ++i) {
      CHECK_FALSE(rig.source.asked[i].idle);
    }
    CHECK(rig.idle / 15 < milliseconds(2));
  }
}

TEST_CASE("further parts of a lease are neither counted nor timed as leases") {
  RunnerRig rig;
  rig.source.take_time = microsecond;
  rig.source.lease(0, 100);
  rig.source.lease(100, 200, false);
  rig.source.lease(200, 300, false);
  rig.run(seconds(1));
  CHECK(rig.source.done.size() == 3);
  CHECK(rig.runner.tally().leases == 1);
  CHECK(rig.runner.tally().taking == microsecond);
}

TEST_CASE("without the length of a lease, a runner takes the next one after its end") {
  RunnerRig rig;
  rig.source.otherwise = Answer::none;
  for (std::uint64_t i = 0; i < 5; ++i) rig.source.lease(100 * i, 100 * i + 100, true, false);
  rig.run(6 * time_of(100));
  CHECK(rig.source.done.size() == 5);
  REQUIRE(rig.source.asked.size() > 5);
  for (int i = 0; i < 5; ++i) {
    CHECK(rig.source.asked[static_cast<std::size_t>(i)].when >= i * time_of(100));
  }
  CHECK(rig.idle < time_of(101));  // at the end
}

TEST_CASE("the team continues while a result travels") {
  RunnerRig rig;
  rig.source.complete_time = milliseconds(10);
  rig.leases(10);
  rig.run(time_of(100) * 6);
  // Handing in takes 10 ms of every 20 ms, but the team hardly waits.
  CHECK(rig.source.done.size() >= 5);
  CHECK(rig.runner.tally().putting >= 5 * rig.source.complete_time);
}

TEST_CASE("after the answer wait, an idle runner waits longer each time, up to milliseconds") {
  RunnerRig rig;
  rig.run(milliseconds(200));
  const auto& asked = rig.source.asked;
  REQUIRE(asked.size() > 10);
  CHECK(asked[1].when - asked[0].when < milliseconds(1));
  for (std::size_t i = 1; i + 1 < asked.size(); ++i) {
    CHECK(asked[i].idle);
    CHECK(asked[i + 1].when - asked[i].when >= asked[i].when - asked[i - 1].when - microsecond);
    CHECK(asked[i + 1].when - asked[i].when <= milliseconds(6));
  }
  CHECK(asked.size() < 60);
}

TEST_CASE("after the answer wait, a busy runner asks again when its team is done") {
  RunnerRig rig;
  rig.leases(2);
  rig.run(2 * time_of(100) + milliseconds(1));
  const auto& asked = rig.source.asked;
  REQUIRE(asked.size() >= 5);
  CHECK_FALSE(asked[2].idle);  // just before the second is done
  CHECK_FALSE(asked[3].idle);  // the runner hands in the result before it asks for copies
  CHECK(asked[4].idle);
  CHECK(asked[4].when >= 2 * time_of(100));
  CHECK(asked[4].when < 2 * time_of(100) + milliseconds(1));
}

TEST_CASE(
    "after the answer none, a runner sleeps until a message arrives, and asks at every turn") {
  RunnerRig rig;
  rig.source.otherwise = Answer::none;
  CHECK(rig.runner.tick(Time(0)) == seconds(1));  // the deadline of the source
  CHECK(rig.runner.tick(milliseconds(3)) == milliseconds(1003));
  CHECK(rig.source.asked.size() == 2);
  rig.source.lease(7, 9);
  rig.runner.tick(milliseconds(4));
  CHECK(rig.team.lease());
}

TEST_CASE("a lease after a wait is traced at once") {
  RunnerRig rig;
  for (int i = 0; i < 5; ++i) rig.source.say(Answer::wait);
  rig.source.lease(7, 9);
  rig.run(milliseconds(100));
  CHECK(rig.source.ranges() == std::vector<CellRange>{{7, 9}});
}

TEST_CASE("a runner gives up an unwanted lease, traced or not, and takes another one") {
  RunnerRig rig;
  rig.leases(4);
  rig.runner.tick(Time(0));
  REQUIRE(rig.team.lease()->epoch == 1);
  rig.source.unwanted = {1};
  rig.runner.tick(milliseconds(1));
  REQUIRE(rig.team.lease());
  CHECK(rig.team.lease()->epoch == 2);
  rig.run(seconds(1));
  REQUIRE(rig.source.done.size() == 3);
  CHECK(rig.source.done[0].epoch == 2);
}

TEST_CASE("a runner hands in a failed lease as failed and traces the next one") {
  RunnerRig rig;
  rig.leases(2);
  rig.runner.tick(Time(0));
  rig.team.failure = "no luck";
  rig.run(time_of(100));
  rig.runner.tick(rig.clock.now());
  REQUIRE(rig.source.done.size() == 1);
  CHECK(rig.source.done[0].failure == "no luck");
  CHECK_FALSE(rig.source.done[0].cells);
  rig.team.failure.clear();
  rig.run(seconds(1));
  REQUIRE(rig.source.done.size() == 2);
  CHECK(rig.source.done[1].cells);
  CHECK(rig.runner.tally().samples == 100 * 2000);
}

TEST_CASE("a runner ends when the source has no more work") {
  RunnerRig rig;
  rig.source.lease(0, 10);
  rig.source.say(Answer::over);
  rig.run(seconds(1));
  CHECK(rig.runner.over());
  CHECK(rig.clock.now() < milliseconds(50));
  const std::size_t asked = rig.source.asked.size();
  for (int i = 0; i < 5; ++i) {
    rig.runner.tick(rig.clock.now());
    rig.clock.go_on(seconds(1));
  }
  CHECK(rig.source.asked.size() == asked);
  CHECK(rig.source.ranges() == std::vector<CellRange>{{0, 10}});
}

TEST_CASE("a stopped runner gives up all leases and reports its tally") {
  RunnerRig rig;
  rig.leases(5);
  rig.run(time_of(250));
  const std::size_t done = rig.source.done.size();
  CHECK_FALSE(rig.team.idle());
  rig.runner.stop();
  CHECK(rig.runner.over());
  CHECK(rig.team.idle());
  REQUIRE(rig.source.reported.size() == 1);
  CHECK(rig.source.reported[0].samples == 2 * 100 * 2000);
  const std::uint64_t started = rig.team.started();
  for (int i = 0; i < 5; ++i) {
    rig.runner.tick(rig.clock.now());
    rig.clock.go_on(seconds(1));
  }
  CHECK(rig.team.started() == started);
  CHECK(rig.source.done.size() == done);
}

TEST_CASE("a runner that follows another continues its speed and tally") {
  RunnerRig rig;
  rig.leases(2);
  rig.run(time_of(250));
  LeaseRunner next(rig.source, rig.team, rig.clock, rig.runner.tally());
  rig.leases(1);
  next.tick(rig.clock.now());
  CHECK(rig.source.asked.back().speed == doctest::Approx(speed));
  CHECK(next.tally().leases == 3);
}

}  // namespace parray
