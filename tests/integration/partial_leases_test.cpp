// A real coordinator in virtual time. Its workers return parts of leases that take too long.
#include <doctest/doctest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "common/scene/settings.h"
#include "tests/support/crash_store.h"
#include "tests/support/rooms.h"
#include "tests/support/service.h"
#include "tests/support/timed_cells.h"

namespace parray::test {
namespace {

/// The seconds that each row of a job takes.
using RowCost = std::function<double(JobId job, std::uint32_t row)>;

/// A worker that traces one lease after the other in virtual time. A lease takes the time of its
/// rows.
class TimedHand {
 public:
  TimedHand(Service& service, const std::string& name, RowCost cost)
      : service_(service), hand_(service, name, 2), cost_(std::move(cost)) {}

  void act() {
    hand_.listen();
    if (busy_ && !hand_.held.contains(lease_)) busy_ = false;
    if (busy_ && service_.now() >= due_) {
      busy_ = false;
      hand_.held.erase(lease_);
      hand_.say(result_);
    }
    if (!busy_ && !hand_.held.empty()) begin(hand_.held.begin()->second);
    hand_.beat();
  }

  double longest_lease = 0;       ///< seconds
  int parts = 0;                  ///< number of results with a part of a lease
  std::map<JobId, double> spent;  ///< seconds

 private:
  void begin(const msg::Grant& grant) {
    lease_ = {grant.job, grant.epoch};
    const TimedCells part =
        cells_within(grant.cells, grant.longest, [&](const CellBatch& batch, std::uint64_t cell) {
          return cost_(grant.job, batch.grid->cell(cell).y);
        });
    parts += part.cells.range == grant.cells.range ? 0 : 1;
    longest_lease = std::max(longest_lease, part.seconds);
    spent[grant.job] += part.seconds;
    msg::Grant traced = grant;
    traced.cells = part.cells;
    result_ = Hand::result(grant, Hand::trace(small_scene(), traced));
    result_.seconds = part.seconds;
    result_.count = part.cells.range.count();
    due_ = service_.now() + from_seconds(part.seconds);
    busy_ = true;
  }

  Service& service_;
  Hand hand_;
  RowCost cost_;
  bool busy_ = false;
  std::pair<JobId, Epoch> lease_;
  msg::Result result_;
  Time due_{};
};

RenderSettings of_rows(std::uint32_t height) {
  RenderSettings settings = small_settings(small_scene());
  settings.height = height;
  settings.samples_per_pixel = 4;
  settings.schedule = SchedulePolicy::weighted;
  settings.row_order = RowOrder::sequential;
  return settings;
}

}  // namespace

TEST_CASE(
    "a job whose last rows are 250 times as dear keeps no worker long, and pays for what it "
    "takes") {
  constexpr std::uint32_t rows = 700;
  constexpr std::uint32_t first_dear = 500;
  constexpr double cheap = 0.002;
  constexpr double dear = 0.5;
  constexpr double even = 0.05;
  Service service;
  const JobId of_ann = service.submit(small_scene(), of_rows(rows), 50, "ann");
  const JobId of_bob = service.submit(small_scene(), of_rows(4000), 50, "bob");
  const RowCost cost = [&](JobId job, std::uint32_t row) {
    return job == of_bob ? even : row < first_dear ? cheap : dear;
  };
  TimedHand first(service, "first", cost);
  TimedHand second(service, "second", cost);
  for (int i = 0; i < 10'000 && service.state(of_ann) != "done"; ++i) {
    service.turn(milliseconds(50));
    first.act();
    second.act();
  }
  REQUIRE(service.state(of_ann) == "done");
  CHECK(service.sha256(of_ann) == reference_sha256(small_scene(), of_rows(rows)));
  const Audit audit = audit_of(service, of_ann);
  CHECK(audit.complete());
  CHECK(audit.cells == rows);

  CHECK(first.parts + second.parts > 2);
  const double longest = 2 * service_options().lease_length.longest;
  CHECK(std::max(first.longest_lease, second.longest_lease) <= longest + dear);
  const double ann_had = first.spent[of_ann] + second.spent[of_ann];
  const double bob_had = first.spent[of_bob] + second.spent[of_bob];
  CHECK(bob_had == doctest::Approx(ann_had).epsilon(0.05));
}

TEST_CASE("a part from a faulty worker is traced again, and the rest from another worker remains") {
  constexpr std::uint64_t part = 5;
  for (const bool rest_comes_first : {false, true}) {
    CAPTURE(rest_comes_first);
    Service service(checking_all());
    Hand faulty(service, "faulty");
    Hand ann(service, "ann");
    const RenderSettings settings = many_leases();
    const JobId job = service.submit(small_scene(), settings);
    service.turn();
    faulty.listen();
    const msg::Grant lease = faulty.put_down();
    REQUIRE(lease.cells.range.count() > part);
    service.ask<msg::Workers>(msg::SteerWorkers{1, msg::WorkerAction::drain, false, "faulty"});
    faulty.send_part(lease, part, true);
    Hand bob(service, "bob");
    bob.listen();
    REQUIRE(bob.held.size() == 1);
    const msg::Grant rest = bob.put_down();
    REQUIRE(rest.cells.range.begin == lease.cells.range.begin + part);
    if (rest_comes_first) {
      bob.send_part(rest, 1);
      service.turn();
    }

    ann.listen();
    ann.send_honest(ann.put_down());
    service.turn();
    ann.listen();
    const msg::Grant check = ann.put_down();
    REQUIRE(check.longest == 0);
    REQUIRE(check.cells.range.begin == lease.cells.range.begin);
    REQUIRE(check.cells.range.count() == part);
    ann.send_honest(check);
    service.turn();
    service.turn();  // the referee has answered
    CHECK(service.worker("faulty").at("state") == "quarantined");
    if (!rest_comes_first) {
      bob.send_part(rest, 1);
      service.turn();
    }
    bob.listen();
    CHECK(bob.verdicts == std::vector<msg::Verdict>{msg::Verdict::accepted});
    service.ask<msg::Workers>(msg::SteerWorkers{1, msg::WorkerAction::readmit, false, "faulty"});
    work(service, {{&ann, in_parts(1)}, {&bob, in_parts(2)}, {&faulty, in_parts(3)}}, job);
    CHECK(check_right(service, job, settings).set_back == part);
  }
}

TEST_CASE("results of faulty workers are undone, also among workers that return parts") {
  std::uint64_t set_back = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    CAPTURE(seed);
    const RenderSettings settings =
        std::vector{many_leases(), in_layers(), in_passes()}.at(seed % 3);
    CoordinatorOptions options = service_options();
    options.checks.share = 1;
    options.random = [dice = std::make_shared<Dice>(seed)] { return dice->unit(); };
    Service service(options);
    Hand ann(service, "ann", 2);
    Hand bob(service, "bob");
    Hand faulty(service, "faulty", 2);
    const JobId job = service.submit(small_scene(), settings);
    work(service,
         {{&faulty, in_parts(seed, 3)}, {&ann, in_parts(seed + 1)}, {&bob, in_parts(seed + 2)}},
         job, 2000);
    set_back += check_right(service, job, settings).set_back;
    CHECK(service.worker("ann").at("state") == "ready");
    CHECK(service.worker("bob").at("state") == "ready");
  }
  CHECK(set_back > 100);
}

TEST_CASE("workers return parts of leases under every schedule and row order, and in passes") {
  for (const SchedulePolicy schedule : {SchedulePolicy::static_split, SchedulePolicy::guided,
                                        SchedulePolicy::factoring, SchedulePolicy::weighted}) {
    for (const RowOrder order : {RowOrder::sequential, RowOrder::interleaved}) {
      for (RenderSettings settings : {many_leases(), in_layers(), in_passes()}) {
        settings.schedule = schedule;
        settings.row_order = order;
        CAPTURE(static_cast<int>(schedule));
        CAPTURE(static_cast<int>(order));
        CAPTURE(settings.height);
        Service service;
        Hand ann(service, "ann", 2);
        Hand bob(service, "bob");
        const JobId job = service.submit(small_scene(), settings);
        work(service, {{&ann, in_parts(1)}, {&bob, in_parts(2)}}, job, 5000);
        check_right(service, job, settings);
      }
    }
  }
}

}  // namespace parray::test
