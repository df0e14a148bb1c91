#include "coordinator/leases/lease_table.h"

#include <doctest/doctest.h>

#include <set>
#include <stdexcept>
#include <vector>

#include "common/scene/settings.h"
#include "tests/support/rooms.h"

/// Tests each arrow of the diagram "A lease" in proto/PROTOCOL.md, and its limits.
/// lease_history_test.cpp tests histories of many steps.
namespace parray {
namespace {

using enum LeaseTable::Arrival;
using Workers = std::vector<WorkerId>;
using Ranges = std::vector<CellRange>;

constexpr WorkerId ann = 1;
constexpr WorkerId bob = 2;
constexpr WorkerId cid = 3;

/// Makes leases of half of the remaining cells, as for two workers.
ChunkSizer halves() {
  RenderSettings settings;
  settings.width = 10;
  settings.height = 100;  // a cell is a row
  settings.samples_per_pixel = 4;
  settings.schedule = SchedulePolicy::guided;
  settings.row_order = RowOrder::sequential;
  return {settings.schedule, WorkPlan(settings, {{{0, 4}}, {}}), {}};
}

LeaseTable table_of(Ranges pending, Epoch first_epoch = 1, std::uint64_t most = UINT64_MAX) {
  return {halves(), std::move(pending), first_epoch, most};
}

std::optional<Lease> grant(LeaseTable& table, WorkerId worker, Time deadline = seconds(10)) {
  return table.grant(deadline, worker, {1, 0}, {0, 0, 2, 2}, worker);
}

/// A table with two cells in one lease, granted to Ann until 10 s.
struct OneLease {
  LeaseTable table = table_of({{0, 2}});
  Epoch epoch = grant(table, ann)->epoch;
};

std::vector<Epoch> epochs_of(const std::vector<Lease>& leases) {
  std::vector<Epoch> epochs;
  for (const Lease& lease : leases) epochs.push_back(lease.epoch);
  return epochs;
}

}  // namespace

TEST_CASE("grants lease the first pending cells, across gaps, until none is left") {
  LeaseTable table = table_of({{0, 6}, {8, 9}}, 100);
  CHECK(table.pending_cells() == 7);
  CHECK(table.next_deadline() == never);
  Ranges granted;
  for (Epoch epoch = 100; const auto lease = grant(table, ann, seconds(epoch)); ++epoch) {
    CHECK(lease->epoch == epoch);
    granted.push_back(lease->range);
  }
  CHECK(granted == Ranges{{0, 4}, {4, 6}, {8, 9}});
  CHECK(table.leased() == 3);
  CHECK(table.held_by(ann) == 3);
  CHECK(table.held_by(bob) == 0);
  CHECK(table.next_deadline() == seconds(100));
  CHECK(table.range_of(101) == CellRange{4, 6});
  CHECK_FALSE(table.range_of(99));
  CHECK(table.pending_cells() == 0);
  CHECK_FALSE(table.idle());
}

TEST_CASE("a lease has at most `most_cells` cells") {
  LeaseTable table = table_of({{0, 100}}, 1, 3);
  CHECK(grant(table, ann)->range == CellRange{0, 3});
  LeaseTable least = table_of({{0, 100}}, 1, 0);
  CHECK(grant(least, ann)->range.count() == 1);
}

TEST_CASE("a lease ends with its holder's result") {
  OneLease f;
  const auto arrived = f.table.arrive(ann, f.epoch);
  CHECK(arrived.kind == first);
  CHECK(arrived.range == CellRange{0, 2});
  CHECK(f.table.held_by(ann) == 0);
  CHECK(f.table.next_deadline() == never);
  CHECK_FALSE(f.table.idle());  // it is being merged
  CHECK(f.table.finish(f.epoch).empty());
  CHECK(f.table.idle());
  CHECK(f.table.arrive(ann, f.epoch).kind == stale);  // again
}

TEST_CASE("to finish a lease that has ended or never existed changes nothing") {
  OneLease f;
  CHECK(f.table.finish(f.epoch + 1).empty());
  CHECK(f.table.leased() == 1);
  f.table.arrive(ann, f.epoch);
  f.table.finish(f.epoch);
  CHECK(f.table.finish(f.epoch).empty());
  CHECK(f.table.idle());
}

TEST_CASE("a partial result makes the other cells pending at once and ends copies") {
  OneLease f;
  REQUIRE(f.table.grant_copy(seconds(10), bob));
  const auto arrived = f.table.arrive(ann, f.epoch, 1);
  CHECK(arrived.kind == first);
  CHECK(arrived.range == CellRange{0, 1});
  CHECK(arrived.dropped == Workers{bob});
  CHECK(f.table.held_by(bob) == 0);
  CHECK(f.table.pending_cells() == 1);
  CHECK(f.table.arrive(bob, f.epoch).kind == stale);
  CHECK(grant(f.table, cid)->range == CellRange{1, 2});
  SUBCASE("the result is merged") {
    CHECK(f.table.finish(f.epoch).empty());
    CHECK(f.table.pending_cells() == 0);
  }
  SUBCASE("the result is invalid") {
    f.table.reject(f.epoch);
    CHECK(grant(f.table, ann)->range == CellRange{0, 1});
  }
}

TEST_CASE("a partial result after another result of the lease is stale") {
  OneLease f;
  REQUIRE(f.table.grant_copy(seconds(10), bob));
  f.table.arrive(bob, f.epoch);
  SUBCASE("while the other is being merged") {}
  SUBCASE("after the other was merged") { f.table.finish(f.epoch); }
  CHECK(f.table.arrive(ann, f.epoch, 1).kind == stale);
  CHECK(f.table.held_by(ann) == 0);
}

TEST_CASE("only the first holder may return a part, not the holder of a copy or check") {
  OneLease f;
  LeaseTable table = table_of({{0, 2}});
  const auto lease = grant(table, ann);
  CHECK(lease->divisible);
  CHECK_FALSE(table.grant_copy(seconds(10), bob)->divisible);
  table.arrive(ann, lease->epoch);
  table.finish(lease->epoch);
  table.want_check({lease->range, bob, {ann}});
  CHECK_FALSE(grant(table, bob)->divisible);
}

TEST_CASE("a result of a worker that does not hold the lease is stale and changes nothing") {
  OneLease f;
  CHECK(f.table.arrive(bob, f.epoch).kind == stale);
  CHECK(f.table.arrive(ann, f.epoch + 1).kind == stale);
  CHECK(f.table.arrive(ann, 0).kind == stale);
  CHECK(f.table.held_by(ann) == 1);
  CHECK(f.table.arrive(ann, f.epoch).kind == first);
  CHECK(f.table.arrive(bob, f.epoch).kind == stale);
}

TEST_CASE("cells of an invalid result or a failed lease are pending again, under a new epoch") {
  OneLease f;
  SUBCASE("the result is invalid") {
    f.table.arrive(ann, f.epoch);
    f.table.reject(f.epoch);
  }
  SUBCASE("the worker reports a failure") { CHECK(f.table.give_back(ann, f.epoch)); }
  CHECK_FALSE(f.table.give_back(ann, f.epoch));
  CHECK(f.table.pending_cells() == 2);
  CHECK(f.table.held_by(ann) == 0);
  const auto again = grant(f.table, bob);
  CHECK(again->epoch == f.epoch + 1);
  CHECK(again->range == CellRange{0, 2});
  CHECK(f.table.arrive(ann, f.epoch).kind == stale);
}

TEST_CASE("a worker cannot give back a lease that it does not hold") {
  OneLease f;
  CHECK_FALSE(f.table.give_back(bob, f.epoch));
  CHECK_FALSE(f.table.give_back(ann, f.epoch + 1));
  CHECK(f.table.held_by(ann) == 1);
}

TEST_CASE("a failure does not end a lease whose result is being merged") {
  OneLease f;
  REQUIRE(f.table.grant_copy(seconds(10), bob));
  REQUIRE(f.table.arrive(ann, f.epoch).kind == first);
  CHECK_FALSE(f.table.give_back(ann, f.epoch));
  CHECK_FALSE(f.table.give_back(cid, f.epoch));
  CHECK(f.table.give_back(bob, f.epoch));
  CHECK(f.table.pending_cells() == 0);
  CHECK(f.table.finish(f.epoch).empty());
  CHECK(f.table.idle());
}

TEST_CASE("after the deadline the cells of a lease are pending and its result is stale") {
  OneLease f;
  CHECK(f.table.expire(seconds(10) - Time(1)).empty());
  const auto expired = f.table.expire(seconds(10));
  REQUIRE(expired.size() == 1);
  CHECK(expired[0].lease.epoch == f.epoch);
  CHECK(expired[0].worker == ann);
  CHECK(f.table.pending_cells() == 2);
  CHECK(f.table.leased() == 0);
  CHECK(f.table.arrive(ann, f.epoch).kind == stale);
  CHECK(f.table.expire(seconds(99)).empty());
}

TEST_CASE("a lost worker's cells become pending, join adjacent cells and are granted first") {
  LeaseTable table = table_of({{0, 8}});
  const auto first_lease = grant(table, ann);  // 0 .. 3
  const auto kept = grant(table, bob);         // 4, 5
  const auto second = grant(table, ann);       // 6, 7
  CHECK(epochs_of(table.drop_worker(ann)) == std::vector<Epoch>{first_lease->epoch, second->epoch});
  CHECK(table.held_by(bob) == 1);
  CHECK(table.drop_worker(ann).empty());
  CHECK(table.arrive(ann, second->epoch).kind == stale);
  CHECK(table.arrive(bob, kept->epoch).kind == first);
  table.reject(kept->epoch);
  CHECK(grant(table, cid)->range == CellRange{0, 4});  // half of one run of eight
}

TEST_CASE("a heartbeat moves a deadline to a later time, never to an earlier one") {
  OneLease f;
  CHECK(f.table.extend(ann, f.epoch, seconds(20)));
  CHECK(f.table.extend(ann, f.epoch, seconds(15)));
  CHECK(f.table.next_deadline() == seconds(20));
  CHECK(f.table.expire(seconds(19)).empty());
  CHECK(f.table.expire(seconds(20)).size() == 1);
}

TEST_CASE("only a heartbeat of a holder without a result extends a lease") {
  OneLease f;
  CHECK_FALSE(f.table.extend(bob, f.epoch, seconds(20)));
  CHECK_FALSE(f.table.extend(ann, f.epoch + 1, seconds(20)));
  CHECK(f.table.next_deadline() == seconds(10));
  f.table.arrive(ann, f.epoch);
  CHECK_FALSE(f.table.extend(ann, f.epoch, seconds(20)));
}

TEST_CASE("a copy is of the oldest lease without a copy, except the worker's own") {
  LeaseTable table = table_of({{0, 4}});
  const auto oldest = grant(table, ann);
  const auto second = grant(table, bob);
  const auto copy = table.grant_copy(seconds(12), bob);
  REQUIRE(copy);
  CHECK(copy->epoch == oldest->epoch);
  CHECK(copy->range == oldest->range);
  CHECK(table.leased() == 2);
  CHECK(table.held_by(bob) == 2);
  CHECK_FALSE(table.grant_copy(seconds(12), bob));
  CHECK(table.grant_copy(seconds(12), cid)->epoch == second->epoch);
  CHECK_FALSE(table.grant_copy(seconds(12), cid));
  static_assert(LeaseTable::most_holders == 2);
}

TEST_CASE("the first result of two holders is merged; the second is compared, once") {
  OneLease f;
  f.table.grant_copy(seconds(10), bob);
  CHECK(f.table.arrive(bob, f.epoch).kind == first);
  SUBCASE("while the first is being merged") {
    CHECK(f.table.arrive(ann, f.epoch).kind == again);
    CHECK(f.table.finish(f.epoch).empty());
  }
  SUBCASE("after that") {
    CHECK(f.table.finish(f.epoch) == Workers{ann});
    CHECK(f.table.held_by(ann) == 0);
    CHECK_FALSE(f.table.extend(ann, f.epoch, seconds(20)));
    const auto late = f.table.arrive(ann, f.epoch);
    CHECK(late.kind == again);
    CHECK(late.range == CellRange{0, 2});
  }
  CHECK(f.table.arrive(ann, f.epoch).kind == stale);
  CHECK(f.table.arrive(cid, f.epoch).kind == stale);
  CHECK(f.table.idle());
}

TEST_CASE("late copies of a lost worker are stale") {
  OneLease f;
  f.table.grant_copy(seconds(10), bob);
  f.table.arrive(bob, f.epoch);
  f.table.finish(f.epoch);
  f.table.drop_worker(ann);
  CHECK(f.table.arrive(ann, f.epoch).kind == stale);
}

TEST_CASE("while a result is being merged, its lease has no deadline and no copies") {
  OneLease f;
  f.table.arrive(ann, f.epoch);
  CHECK_FALSE(f.table.grant_copy(seconds(10), bob));
  CHECK(f.table.expire(seconds(99)).empty());
  CHECK(f.table.drop_worker(ann).empty());
  CHECK(f.table.pending_cells() == 0);
}

TEST_CASE("the holder of a copy keeps it if the first result is invalid") {
  OneLease f;
  f.table.grant_copy(seconds(10), bob);
  f.table.arrive(ann, f.epoch);
  f.table.reject(f.epoch);
  CHECK(f.table.pending_cells() == 0);
  CHECK(f.table.arrive(bob, f.epoch).kind == first);
}

TEST_CASE("cells of a lease with a copy become pending only after the last holder") {
  OneLease f;
  f.table.grant_copy(seconds(30), bob);
  CHECK(f.table.expire(seconds(10)).size() == 1);  // Ann's
  CHECK(f.table.leased() == 1);
  CHECK(f.table.pending_cells() == 0);
  SUBCASE("the copy's result counts, the first holder's does not") {
    CHECK(f.table.arrive(ann, f.epoch).kind == stale);
    CHECK(f.table.arrive(bob, f.epoch).kind == first);
  }
  SUBCASE("without the copy it is pending") {
    f.table.drop_worker(bob);
    CHECK(f.table.pending_cells() == 2);
  }
}

TEST_CASE("holders of one lease may expire together, with equal or different deadlines") {
  for (const Time second : {seconds(8), seconds(10)}) {
    OneLease f;
    f.table.grant_copy(second, bob);
    CHECK(f.table.next_deadline() == second);
    CHECK(f.table.expire(seconds(10)).size() == 2);
    CHECK(f.table.pending_cells() == 2);
    CHECK(f.table.next_deadline() == never);
  }
  OneLease f;
  f.table.grant_copy(seconds(10), bob);  // one deadline for both
  f.table.arrive(bob, f.epoch);
  f.table.reject(f.epoch);
  CHECK(f.table.next_deadline() == seconds(10));
}

TEST_CASE("a check precedes pending work and goes only to the named machine") {
  LeaseTable table = table_of({{0, 4}});
  const Lease done = *grant(table, ann);
  table.arrive(ann, done.epoch);
  table.finish(done.epoch);
  table.want_check({done.range, bob, {ann}});
  CHECK_FALSE(table.idle());
  CHECK(grant(table, ann)->range == CellRange{2, 4});
  CHECK_FALSE(grant(table, cid));
  const auto check_lease = grant(table, bob);
  CHECK(check_lease->range == done.range);
  CHECK_FALSE(grant(table, bob));                                       // there is one check
  CHECK(table.grant_copy(seconds(10), cid)->range == CellRange{2, 4});  // never of a check
  CHECK_FALSE(table.grant_copy(seconds(10), ann));
  CHECK(table.arrive(bob, check_lease->epoch).kind == check);
  CHECK(table.finish(check_lease->epoch).empty());
  CHECK(table.pending_cells() == 0);
}

TEST_CASE("any worker of the named machine may make a check") {
  LeaseTable table = table_of({});
  table.want_check({{0, 2}, 77, {ann}});
  CHECK_FALSE(grant(table, ann));
  CHECK(table.grant(seconds(10), cid, {1, 0}, {0, 0, 2, 2}, 77)->range == CellRange{0, 2});
}

TEST_CASE("a failed check is returned and names the machine that must not make it again") {
  LeaseTable table = table_of({});
  table.want_check({{0, 2}, bob, {ann}});
  const auto lost = grant(table, bob);
  SUBCASE("the holder failed") { CHECK(table.give_back(bob, lost->epoch)); }
  SUBCASE("the result is invalid") {
    table.arrive(bob, lost->epoch);
    table.reject(lost->epoch);
  }
  CHECK(table.pending_cells() == 0);
  CHECK(table.checks_remain());
  CHECK_FALSE(grant(table, bob));
  const auto orphans = table.take_orphans({ann, bob, cid});
  REQUIRE(orphans.size() == 1);
  CHECK(orphans[0].range == CellRange{0, 2});
  CHECK(orphans[0].not_by == std::set<MachineKey>{ann, bob});
  CHECK_FALSE(table.checks_remain());
  CHECK(table.idle());
}

TEST_CASE("a machine may make a check again until it has lost three of them in a row") {
  LeaseTable table = table_of({});
  const auto lose_one = [&](int turn) {
    table.want_check({{0, 2}, bob, {ann}});
    REQUIRE(grant(table, bob));
    if (turn % 2 == 0) {
      CHECK(table.drop_worker(bob).size() == 1);
    } else {
      CHECK(table.expire(seconds(10)).size() == 1);
    }
    CHECK(table.checks_remain());
    const auto orphans = table.take_orphans({ann, bob, cid});
    REQUIRE(orphans.size() == 1);
    return orphans[0].not_by.contains(bob);
  };
  for (int round = 0; round < 2; ++round) {
    CHECK_FALSE(lose_one(1));
    CHECK_FALSE(lose_one(2));
    table.want_check({{0, 2}, bob, {ann}});
    const auto made = grant(table, bob);
    table.arrive(bob, made->epoch);
    table.finish(made->epoch);
  }
  CHECK_FALSE(lose_one(1));
  CHECK_FALSE(lose_one(2));
  CHECK(lose_one(3));
  CHECK(lose_one(4));
}

TEST_CASE("a check that names no machine waits until take_orphans()") {
  LeaseTable table = table_of({});
  table.want_check({{0, 2}, 0, {ann}});
  CHECK_FALSE(table.grant(seconds(10), bob, {1, 0}, {0, 0, 2, 2}, 0));
  CHECK(table.checks_remain());
  CHECK(table.take_orphans({ann, bob}).size() == 1);
  CHECK(table.idle());
}

TEST_CASE("take_orphans() returns checks of machines that have left, except leased ones") {
  LeaseTable table = table_of({});
  table.want_check({{0, 2}, ann, {}});
  table.want_check({{4, 5}, bob, {}});
  const auto begun = grant(table, ann);
  CHECK(table.take_orphans({ann, bob}).empty());
  CHECK(table.take_orphans({cid}).size() == 1);
  CHECK(table.checks_remain());
  CHECK_FALSE(grant(table, bob));
  table.arrive(ann, begun->epoch);
  CHECK(table.checks_remain());
  table.finish(begun->epoch);
  CHECK_FALSE(table.checks_remain());
  CHECK(table.idle());
}

TEST_CASE("done cells can be put back once") {
  OneLease f;
  f.table.arrive(ann, f.epoch);
  f.table.finish(f.epoch);
  f.table.put_back({{1, 2}, {5, 9}});
  CHECK(f.table.pending_cells() == 5);
  for (const CellRange& twice : {CellRange{1, 2}, CellRange{0, 2}, CellRange{8, 12}}) {
    LeaseTable table = table_of({{1, 2}, {5, 9}});
    CHECK_THROWS_AS(table.put_back({twice}), std::logic_error);
    CHECK(table.pending_cells() == 5);
  }
  CHECK(grant(f.table, bob)->range == CellRange{1, 2});
  CHECK(grant(f.table, bob)->range == CellRange{5, 7});
}

}  // namespace parray
