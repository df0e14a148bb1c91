// A standby takes over from a real coordinator: partial leases, quarantines and repaired jobs.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/scene/settings.h"
#include "coordinator/store/replication_state.h"
#include "tests/support/crash_store.h"
#include "tests/support/rooms.h"
#include "tests/support/service.h"
#include "tests/support/standby_line.h"
#include "tests/support/trials.h"

namespace parray::test {
namespace {

/// A primary and a standby that takes over.
class Twins {
 public:
  explicit Twins(const CoordinatorOptions& options) : service(options, &replicated_) {}

  /// Starts another standby, which gets a full copy.
  void replace_standby() {
    line_.become(third_);
    copy_ = &third_;
  }
  /// Ends the primary, which loses everything uncommitted.
  void take_over() {
    line_.cut_off = true;
    copy_->crash();
    serve_alone(*copy_);
    service.restart(copy_);
  }

 private:
  CrashStore first_{0, 1};
  CrashStore second_{0, 2};
  CrashStore third_{0, 3};
  CrashStore* copy_ = &second_;
  Standby line_{second_};
  ReplicatedStore replicated_{first_, line_, numbers(1)};

 public:
  Service service;
};

}  // namespace

TEST_CASE("a standby has the returned part of a lease, and grants the rest once") {
  Twins twins(service_options());
  Service& service = twins.service;
  Hand ann(service, "ann");
  const JobId job = service.submit(small_scene(), many_leases());
  service.turn();
  ann.listen();
  const msg::Grant lease = ann.put_down();
  constexpr std::uint64_t part = 5;
  ann.send_part(lease, part);
  service.turn();
  ann.listen();
  REQUIRE(ann.verdicts == std::vector<msg::Verdict>{msg::Verdict::accepted});
  const msg::Grant rest = ann.put_down();
  REQUIRE(rest.cells.range.begin == part);

  twins.take_over();
  ann.send_part(rest, 1);  // ann has not noticed the takeover
  service.turn();
  CHECK(service.heard<msg::Identify>(ann.peer()).size() == 1);
  ann.come_back();
  ann.send_part(rest, 1);
  ann.send_part(lease, part);
  service.turn();
  ann.listen();
  CHECK(std::ranges::count(ann.verdicts, msg::Verdict::stale) == 2);
  REQUIRE(ann.held.size() == 1);
  CHECK(ann.held.begin()->second.cells.range.begin == part);
  work(service, {{&ann, in_parts(1)}}, job);
  check_right(service, job, many_leases());
}

TEST_CASE("after any takeover, parts count once and results of faulty workers remain undone") {
  int quarantined = 0;
  for (std::uint64_t seed = 30; seed < 30 + trials(30); ++seed) {
    CAPTURE(seed);
    Dice dice(seed);
    const RenderSettings settings = seed % 2 == 0 ? many_leases() : in_passes();
    CoordinatorOptions options = service_options();
    options.checks.share = 1;
    options.random = [random = std::make_shared<Dice>(seed)] { return random->unit(); };
    Twins twins(options);
    Service& service = twins.service;
    Hand ann(service, "ann", 2);
    Hand bob(service, "bob");
    Hand faulty(service, "faulty", 2);
    const Hands hands{
        {&faulty, in_parts(seed, 3)}, {&ann, in_parts(seed + 1)}, {&bob, in_parts(seed + 2)}};
    const JobId job = service.submit(small_scene(), settings);
    work(service, hands, job, 1 + static_cast<int>(dice.below(40)));
    if (dice.one_in(3)) {
      twins.replace_standby();
      work(service, hands, job, 2);
    }
    const bool found_faulty = service.worker("faulty").at("state") == "quarantined";
    twins.take_over();
    for (const auto& [hand, manner] : hands) dice.one_in(2) ? hand->join() : hand->come_back();
    quarantined += found_faulty ? 1 : 0;
    CHECK((!found_faulty || service.worker("faulty").at("state") == "quarantined"));
    work(service, hands, job, 2000);
    check_right(service, job, settings);
  }
  CHECK(quarantined > 5);
  CHECK(quarantined < static_cast<int>(trials(30)));
}

TEST_CASE("a standby knows quarantines, from being in step and from a full copy") {
  for (const bool full_copy : {false, true}) {
    CAPTURE(full_copy);
    Twins twins(checking_all());
    Service& service = twins.service;
    Hand ann(service, "ann");
    Hand faulty(service, "faulty", "10.0.0.7");
    const Hands hands{{&ann, honest}, {&faulty, lying_loudly}};
    const JobId job = service.submit(small_scene(), many_leases());
    for (int i = 0; i < 100 && service.worker("faulty").at("state") == "ready"; ++i) {
      work(service, hands, job, 1);
    }
    REQUIRE(service.worker("faulty").at("state") == "quarantined");
    if (full_copy) twins.replace_standby();
    work(service, hands, job, 1);
    twins.take_over();
    CHECK(service.worker("faulty").at("state") == "quarantined");
    faulty.join_as("faulty under another name");
    service.turn();
    faulty.listen();
    CHECK(faulty.held.empty());
    ann.join();
    work(service, hands, job, 500, milliseconds(100));  // checks wait for another machine
    check_right(service, job, many_leases());
    CHECK(faulty.held.empty());
    service.ask<msg::Workers>(msg::SteerWorkers{1, msg::WorkerAction::readmit, false, "10.0.0.7"});
    const JobId next = service.submit(small_scene(), many_leases());
    work(service, {{&ann, idle}, {&faulty, honest}}, next, 3);
    CHECK_FALSE(service.worker("faulty under another name").at("accepted") == 0);
    work(service, {{&ann, honest}, {&faulty, honest}}, next);
    CHECK(service.state(next) == "done");
  }
}

TEST_CASE("a standby undoes wrong results in a job that was cancelled during the fault finding") {
  const auto draw = std::make_shared<double>(0.9);  // no checks
  CoordinatorOptions options = checking_all();
  options.random = [draw] { return *draw; };
  Twins twins(options);
  Service& service = twins.service;
  Hand ann(service, "ann");
  Hand faulty(service, "faulty");
  const JobId job = service.submit(small_scene(), many_leases());
  work(service, {{&faulty, lying_loudly}}, job, 3);
  service.steer(job, msg::JobAction::cancel);
  *draw = 0.2;
  const JobId other = service.submit(small_scene(), many_leases());
  work(service, {{&ann, honest}, {&faulty, lying_loudly}}, other);
  REQUIRE(service.worker("faulty").at("state") == "quarantined");
  service.turn();
  twins.take_over();
  service.steer(job, msg::JobAction::requeue);
  ann.join();
  work(service, {{&ann, honest}}, job, 500, milliseconds(100));  // checks wait for another machine
  check_right(service, job, many_leases());
}

namespace {

/// Random events of jobs, workers and coordinators.
class Storm {
 public:
  Storm(std::uint64_t seed, Twins& twins) : twins_(twins), dice_(seed) {}

  void submit(const RenderSettings& settings) {
    const auto priority = static_cast<std::uint32_t>(dice_.below(101));
    const std::string user = dice_.one_in(2) ? "ann" : "bob";
    jobs.emplace_back(twins_.service.submit(small_scene(), settings, priority, user), settings);
  }
  /// Runs a number of rounds, with a random event in every fifth.
  void blow(const Hands& hands, std::uint64_t rounds) {
    for (std::uint64_t round = 0; round < rounds; ++round) {
      work(twins_.service, hands, jobs.front().first, 1);
      if (dice_.one_in(5)) happen(hands);
    }
  }
  /// Continues until every job is done.
  void calm(const Hands& hands) {
    for (const auto& [job, settings] : jobs) {
      twins_.service.steer(job, msg::JobAction::resume);
      twins_.service.steer(job, msg::JobAction::requeue);
    }
    for (const auto& [hand, manner] : hands) hand->come_back();
    for (const auto& [job, settings] : jobs) work(twins_.service, hands, job, 3000);
  }

  std::vector<std::pair<JobId, RenderSettings>> jobs;

 private:
  void happen(const Hands& hands) {
    using enum msg::JobAction;
    const JobId job = jobs[dice_.below(jobs.size())].first;
    const auto action = std::array{pause, resume, cancel, requeue, prioritise}[dice_.below(5)];
    switch (dice_.below(6)) {
      case 0: twins_.service.restart(); return;
      case 1:
        if (!std::exchange(taken_over_, true)) twins_.take_over();
        return;
      case 2: {
        Hand* hand = hands[dice_.below(hands.size())].first;
        dice_.one_in(2) ? hand->join() : hand->come_back();
        return;
      }
      default: twins_.service.steer(job, action, static_cast<std::uint32_t>(dice_.below(101)));
    }
  }

  Twins& twins_;
  Dice dice_;
  bool taken_over_ = false;
};

}  // namespace

TEST_CASE("in any history, a machine's results are undone in all jobs after one fault finding") {
  std::uint64_t set_back = 0;
  for (std::uint64_t seed = 30; seed < 30 + trials(30); ++seed) {
    CAPTURE(seed);
    const auto draw = std::make_shared<double>(0.9);  // no checks
    CoordinatorOptions options = checking_all();
    options.random = [draw] { return *draw; };
    Twins twins(options);
    Service& service = twins.service;
    Storm storm(seed, twins);
    Hand ann(service, "ann");
    Hand bob(service, "bob", 2);
    Hand faulty(service, "faulty", 2);
    const Hands honest_ones{{&ann, in_parts(seed)}, {&bob, honest}};
    Hands all = honest_ones;
    all.emplace_back(&faulty, in_parts(seed + 1, 2));
    for (const RenderSettings& settings : {many_leases(), in_layers(), in_passes()}) {
      storm.submit(settings);
    }
    storm.blow(all, 20);
    *draw = 0.2;  // another machine checks every lease
    const JobId bait = service.submit(small_scene(), many_leases(), 100);
    const auto is_caught = [&] {
      const auto known = service.worker("faulty");
      return !known.is_null() && known.at("state") == "quarantined";
    };
    for (int i = 0; i < 300 && !is_caught(); ++i) {
      if (service.worker("faulty").is_null()) faulty.join();
      work(service, {{&ann, honest}, {&bob, honest}, {&faulty, lying_loudly}}, bait, 1);
    }
    REQUIRE(is_caught());
    std::vector<JobId> done;
    for (const auto& [job, settings] : storm.jobs) {
      if (service.state(job) == "done") {
        done.push_back(job);  // its picture may be wrong
      }
    }
    storm.blow(honest_ones, 20);
    storm.calm(honest_ones);
    for (const auto& [number, settings] : storm.jobs) {
      const JobId job = number;
      CAPTURE(job);
      if (std::ranges::find(done, job) == done.end()) {
        set_back += check_right(service, job, settings).set_back;
      }
    }
  }
  CHECK(set_back > 200);
}

}  // namespace parray::test
