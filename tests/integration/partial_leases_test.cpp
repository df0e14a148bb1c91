// A whole coordinator in virtual time, whose workers return parts of leases that take long.
#include <doctest/doctest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "cli/audit/audit.h"
#include "tests/support/crash_store.h"
#include "tests/support/service.h"
#include "tests/support/timed_cells.h"

namespace parray::test {
namespace {

/// Seconds that a row of a job takes.
using RowCost = std::function<double(JobId job, std::uint32_t row)>;

/// A worker that traces one lease after the other, each for as long as its rows take.
class TimedHand {
 public:
  TimedHand(Service& service, const std::string& name, RowCost cost)
      : service_(service), hand_(service, name, 2), cost_(std::move(cost)) {}

  void act() {
    hand_.listen();
    if (busy_ && !hand_.held.contains(lease_)) {
      busy_ = false;
    }
    if (busy_ && service_.now() >= due_) {
      busy_ = false;
      hand_.held.erase(lease_);
      hand_.say(result_);
    }
    if (!busy_ && !hand_.held.empty()) {
      begin(hand_.held.begin()->second);
    }
    hand_.beat();
  }

  double longest_lease = 0;       ///< seconds
  int parts = 0;                  ///< results that are not of a whole lease
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
    due_ = service_.now() +
           std::chrono::duration_cast<Time>(std::chrono::duration<double>(part.seconds));
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

Audit audit_of(Service& service, JobId job) {
  const auto data = service.ask<msg::JournalData>(msg::FetchJournal{1, job});
  return audit_journal(read_journal(data.journal.data.view()));
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

}  // namespace parray::test
