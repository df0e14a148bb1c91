// Tests the classes for checks, disputes and quarantines without a farm.
#include <doctest/doctest.h>

#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/scene/settings.h"
#include "coordinator/disputes/check_policy.h"
#include "coordinator/disputes/machines.h"
#include "coordinator/disputes/referee_desk.h"
#include "tests/support/dice.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"
#include "tests/support/sim_referee.h"

namespace parray {
namespace {

using test::Dice;
using test::SimReferee;

CheckPolicy policy(double share, std::uint64_t seed = 1) {
  CheckPolicy::Options options;
  options.share = share;
  return {options, [dice = std::make_shared<Dice>(seed)] { return dice->unit(); }};
}

std::uint64_t address(const std::string& name) {
  return machine_key({MachineId::Kind::address, name});
}

/// A desk with a referee that answers at once or fails, and a plan of many cells.
struct Desk {
  explicit Desk(RefereeDesk::Options options = {})
      : referee(std::make_shared<SimReferee>([this] { return now; })), desk(referee, options) {}

  [[nodiscard]] RefereeCase made(bool dispute, std::vector<std::uint64_t> cells,
                                 std::uint64_t generation = 1) const {
    RefereeCase one;
    one.generation = generation;
    one.dispute = dispute;
    one.plan = plan;
    one.scene = "scene";
    one.payload = ScenePayload(std::make_shared<const Scene>(test::small_scene()));
    one.settings = settings;
    one.cells_at_once = 2;
    one.claimant = 77;
    one.claims = dispute ? cells : std::vector<std::uint64_t>{};
    one.cells = std::move(cells);
    return one;
  }
  /// Asks, lets time pass, and returns the answers.
  std::vector<RefereeDesk::Traced> turn(Time by = milliseconds(1),
                                        std::uint64_t memory = UINT64_MAX) {
    desk.ask_next(now, memory);
    now += by;
    return desk.take_answers(now);
  }

  RenderSettings settings = [] {
    RenderSettings made = test::small_settings(test::small_scene());
    made.samples_per_pixel = 1;
    return made;
  }();
  std::shared_ptr<const WorkPlan> plan =
      std::make_shared<const WorkPlan>(settings, Pass{{{0, 1}}, {}});
  Time now = seconds(1000);
  std::shared_ptr<SimReferee> referee;
  RefereeDesk desk;
};

}  // namespace

TEST_CASE("the first leases of a machine and of a process are checked more often") {
  const CheckPolicy checks = policy(0.01);
  CHECK(checks.share_of({0, 0, false}) == 0.1);
  CHECK(checks.share_of({99, 99, false}) == 0.1);
  CHECK(checks.share_of({100, 100, false}) == 0.01);
  CHECK(checks.share_of({5000, 19, false}) == 0.1);
  CHECK(checks.share_of({5000, 20, false}) == 0.01);
  CHECK(policy(0.5).share_of({0, 0, false}) == 0.5);
}

TEST_CASE("workers of the coordinator's own user are checked only with ours_too") {
  CHECK(policy(0.01).share_of({0, 0, true}) == 0);
  CHECK(policy(0).share_of({0, 0, false}) == 0);
  CheckPolicy::Options options;
  options.share = 0.2;
  options.ours_too = true;
  CHECK(CheckPolicy(options, [] { return 0.5; }).share_of({500, 500, true}) == 0.2);
}

TEST_CASE("the share of checked leases is `share`; the referee checks one in ten of them") {
  CheckPolicy checks = policy(0.25);
  int wanted = 0;
  int by_referee = 0;
  std::map<std::size_t, int> by_machine;
  for (int i = 0; i < 20000; ++i) {
    wanted += checks.wants_check({1000, 1000, false}) ? 1 : 0;
    const auto drawn = checks.draw_checker(3);
    by_referee += drawn ? 0 : 1;
    if (drawn) ++by_machine[*drawn];
  }
  CHECK(wanted == doctest::Approx(5000).epsilon(0.05));
  CHECK(by_referee == doctest::Approx(2000).epsilon(0.1));
  REQUIRE(by_machine.size() == 3);
  for (const auto& [machine, times] : by_machine) {
    CHECK(times == doctest::Approx(6000).epsilon(0.05));
  }
  CHECK_FALSE(checks.draw_checker(0));
}

TEST_CASE("after its accumulated time the referee gets a tenth of a core on average") {
  RefereeBudget budget(0.1, 30);
  Time now{};
  double spent = 0;
  for (; now < seconds(10000); now += milliseconds(100)) {
    if (budget.left(now) >= 0) {
      budget.spend(now, 0.7);
      spent += 0.7;
    }
  }
  CHECK(spent <= 30 + 0.1 * 10000 + 0.7);
  CHECK(spent >= 0.1 * 10000);
  budget.spend(now, 100);
  CHECK(budget.left(now) < 0);
  const Time again = budget.when(now, 0);
  CHECK(budget.left(again) >= -1e-9);
  CHECK(budget.left(again - seconds(1)) < 0);
  CHECK(budget.left(now + seconds(100000)) == 30);
}

TEST_CASE("a quarantine of an address ends after a day, a quarantine of a key does not") {
  QuarantineLedger ledger;
  const std::uint64_t key = machine_key({MachineId::Kind::key, "node-1"});
  CHECK(ledger.add({address("10.0.0.3"), "address 10.0.0.3", "ann", "attic", "wrong", 1000, 0}));
  CHECK(ledger.add({key, "key node-1", "bob", "attic", "wrong", 1000, 0}));
  CHECK_FALSE(ledger.add({key, "key node-1", "bob", "attic", "again", 5000, 0}));
  CHECK(ledger.find(address("10.0.0.3"))->until == 1000 + 24 * 3600);
  CHECK(ledger.find(key)->until == 0);
  CHECK(ledger.expire(1000 + 24 * 3600 - 1) == 0);
  CHECK(ledger.expire(1000 + 24 * 3600) == 1);
  CHECK(ledger.find(address("10.0.0.3")) == nullptr);
  CHECK(ledger.expire(1e12) == 0);
  CHECK(ledger.find(key) != nullptr);
}

TEST_CASE("readmit() accepts a machine's name, address or key, or its worker's name") {
  for (const std::string name : {"10.0.0.3", "address 10.0.0.3", "ann"}) {
    QuarantineLedger ledger;
    ledger.add({address("10.0.0.3"), "address 10.0.0.3", "ann", "attic", "wrong", 1000, 0});
    CHECK(ledger.readmit("10.0.0.4", false) == 0);
    CHECK(ledger.readmit(name, false) == 1);
    CHECK(ledger.all().empty());
  }
}

TEST_CASE("readmit() of a host ends the quarantines of all its machines, and of no other") {
  QuarantineLedger ledger;
  ledger.add({address("10.0.0.3"), "address 10.0.0.3", "ann", "attic", "wrong", 1000, 0});
  ledger.add({address("10.0.0.4"), "address 10.0.0.4", "bob", "attic", "wrong", 1000, 0});
  ledger.add({address("10.0.0.5"), "address 10.0.0.5", "attic", "cellar", "wrong", 1000, 0});
  CHECK(ledger.readmit("attic", true) == 2);
  CHECK(ledger.find(address("10.0.0.5")) != nullptr);
}

TEST_CASE("quarantines are unchanged after writing and reading") {
  QuarantineLedger ledger;
  ledger.add({address("10.0.0.3"), "address 10.0.0.3", "ann", "attic", "wrong", 1000, 0});
  ledger.add({machine_key({MachineId::Kind::key, "n"}), "key n", "bob", "attic", "wrong", 2000, 0});
  const auto again = QuarantineLedger::from_json(ledger.to_json());
  CHECK(again.to_json() == ledger.to_json());
  CHECK(again.find(address("10.0.0.3"))->until == ledger.find(address("10.0.0.3"))->until);
  CHECK_THROWS_AS(QuarantineLedger::from_json({{{"machine", "x"}}}), nlohmann::json::exception);
}

TEST_CASE("the desk asks one question at a time, disputes first, and splits cases") {
  Desk farm;
  CHECK(farm.desk.open(farm.now, farm.made(false, {9})));
  CHECK(farm.desk.open(farm.now, farm.made(true, {1, 2, 3, 7})));
  const auto first = farm.turn();
  REQUIRE(first.size() == 1);
  CHECK(first[0].dispute);
  CHECK(first[0].range == CellRange{1, 3});
  CHECK(first[0].claims == std::vector<std::uint64_t>{1, 2});
  CHECK(farm.desk.busy_with(1));
  farm.desk.continue_case(first[0].number);
  CHECK(farm.turn()[0].range == CellRange{3, 4});
  farm.desk.continue_case(first[0].number);
  CHECK(farm.turn()[0].range == CellRange{7, 8});
  farm.desk.continue_case(first[0].number);
  CHECK(farm.desk.disputes() == 0);
  CHECK(farm.turn()[0].range == CellRange{9, 10});
  CHECK(farm.referee->asked == 4);
}

TEST_CASE("a slow referee gets no second question, and a late answer counts") {
  Desk farm;
  farm.referee->ailments.delay = seconds(40);
  farm.desk.open(farm.now, farm.made(true, {1}));
  farm.desk.open(farm.now, farm.made(true, {5}, 2));
  CHECK(farm.turn(seconds(20)).empty());
  CHECK(farm.desk.hold(farm.now, 1).empty());
  CHECK(farm.turn(seconds(15)).empty());
  CHECK(farm.referee->asked == 1);
  CHECK_FALSE(farm.desk.hold(farm.now, 1).empty());
  CHECK_FALSE(farm.desk.hold(farm.now, 2).empty());
  CHECK(farm.desk.hold(farm.now, 3).empty());  // it has no dispute
  CHECK(farm.turn(seconds(6)).size() == 1);
}

TEST_CASE("a job waits for a referee that is silent at a check, until the check is cancelled") {
  Desk farm;
  farm.referee->ailments.silent = true;
  farm.desk.open(farm.now, farm.made(false, {1}));
  farm.turn(milliseconds(1));
  REQUIRE(farm.referee->asked == 1);
  CHECK(farm.desk.wait(farm.now, 1).empty());
  farm.turn(seconds(12));
  CHECK(farm.desk.wait(farm.now, 1)
            .find("the referee, which has been tracing cells again for a check for 1") == 0);
  CHECK(farm.desk.wait(farm.now, 2).empty());  // another job
  CHECK(farm.desk.busy_with(1));
  farm.turn(seconds(50));
  CHECK(farm.referee->forgotten == 1);
  CHECK_FALSE(farm.desk.busy_with(1));
  CHECK(farm.desk.wait(farm.now, 1).empty());
}

TEST_CASE("a silent referee restarts and gets the same case again") {
  Desk farm;
  farm.referee->ailments.silent = true;
  farm.desk.open(farm.now, farm.made(true, {1}));
  farm.turn(seconds(601));
  CHECK(farm.referee->forgotten == 1);
  farm.referee->ailments = {};
  for (int i = 0; i < 10000 && farm.desk.disputes() > 0; ++i) {
    for (const auto& traced : farm.turn(seconds(1))) farm.desk.close(traced.number);
  }
  CHECK(farm.desk.disputes() == 0);
  CHECK(farm.referee->asked == 2);
}

TEST_CASE("a failing referee is asked again after increasing pauses; checks are dropped") {
  Desk farm;
  farm.referee->ailments.failure = "it was killed by signal 9";
  farm.desk.open(farm.now, farm.made(true, {1}));
  farm.desk.open(farm.now, farm.made(false, {5}, 2));
  for (int i = 0; i < 600; ++i) farm.turn(seconds(1));
  CHECK(farm.referee->asked > 5);
  CHECK(farm.referee->asked < 25);
  CHECK(farm.desk.hold(farm.now, 1).find("signal 9") != std::string::npos);
  CHECK(farm.desk.next(farm.now) <= farm.now + seconds(60));
}

TEST_CASE("without processor time the referee is not asked; checks leave a reserve for disputes") {
  Desk farm;
  farm.referee->ailments.seconds = 20;
  farm.desk.open(farm.now, farm.made(true, {1}));
  farm.desk.close(farm.turn().at(0).number);
  CHECK_FALSE(farm.desk.may_check(farm.now));
  farm.desk.open(farm.now, farm.made(false, {5}));
  CHECK(farm.turn().empty());
  farm.desk.open(farm.now, farm.made(true, {6}));
  farm.desk.close(farm.turn().at(0).number);
  farm.desk.open(farm.now, farm.made(true, {7}));
  CHECK(farm.turn().empty());  // 10 s more than were left
  CHECK(farm.desk.hold(farm.now, 1).find("processor time") != std::string::npos);
  CHECK(farm.turn(seconds(101)).empty());
  CHECK(farm.turn().size() == 1);
  CHECK(farm.desk.drop_checks(1) == 1);
}

TEST_CASE("a job with the maximum number of open disputes pauses") {
  Desk farm({.most_disputes = 3});
  farm.referee->ailments.silent = true;
  for (std::uint64_t i = 0; i < 3; ++i) {
    CHECK(farm.desk.hold(farm.now, 1).empty());
    CHECK(farm.desk.open(farm.now, farm.made(true, {i})));
  }
  CHECK_FALSE(farm.desk.open(farm.now, farm.made(true, {9})));
  CHECK(farm.desk.open(farm.now, farm.made(true, {9}, 2)));
  CHECK(farm.desk.hold(farm.now, 1).find("3 disputes") != std::string::npos);
  farm.desk.drop_claims(77);
  CHECK(farm.desk.disputes() == 0);
  CHECK(farm.desk.hold(farm.now, 1).empty());
}

TEST_CASE("the referee's memory is counted, limited, and freed after an idle time") {
  Desk farm;
  RefereeCase large = farm.made(true, {1});
  large.memory = 1000;
  farm.desk.open(farm.now, large);
  CHECK(farm.turn(milliseconds(1), 999).empty());
  CHECK(farm.desk.hold(farm.now, 1).find("--memory") != std::string::npos);
  CHECK(farm.referee->asked == 0);
  farm.turn(seconds(2), 2000);
  farm.desk.close(farm.turn(milliseconds(1), 2000).size());  // it was asked, whatever the outcome
  CHECK(farm.referee->asked == 1);
  CHECK(farm.desk.memory() == farm.referee->memory);
  farm.desk.drop(1);
  farm.turn(seconds(61));
  farm.turn();
  CHECK(farm.referee->forgotten == 1);
  CHECK(farm.desk.memory() == 0);
}

TEST_CASE("without a referee every job with a dispute pauses") {
  Desk farm;
  RefereeDesk none(nullptr, {});
  CHECK(none.open(farm.now, farm.made(true, {1})));
  CHECK_FALSE(none.open(farm.now, farm.made(false, {1})));
  CHECK(none.hold(farm.now, 1).find("no referee") != std::string::npos);
  CHECK(none.next(farm.now) == never);
}

}  // namespace parray
