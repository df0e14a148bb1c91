#include "coordinator/lease_table.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <set>
#include <stdexcept>
#include <vector>

/// Each arrow of the picture "A lease" in proto/PROTOCOL.md, and the bounds around it.
/// Histories of many steps: lease_history_test.cpp.
namespace parray {
namespace {

using enum msg::Verdict;
using Workers = std::vector<WorkerId>;

constexpr WorkerId ann = 1;
constexpr WorkerId bob = 2;
constexpr WorkerId cid = 3;
constexpr ResultDigest digest = 77;
constexpr ResultDigest other_digest = 78;

RenderSettings job(std::uint32_t height, std::uint32_t spp,
                   SchedulePolicy policy = SchedulePolicy::guided) {
  RenderSettings settings;
  settings.width = 10;
  settings.height = height;
  settings.samples_per_pixel = spp;
  settings.schedule = policy;
  return settings;
}

Asker asker(WorkerId worker, std::uint32_t workers = 2) {
  Asker result;
  result.worker = worker;
  result.workers = workers;
  return result;
}

/// A job of two rows in one lease, granted to Ann until 10 s.
struct OneLease {
  OneLease() : table(job(2, 4)), lease(*table.grant(seconds(10), asker(ann), false)) {}
  LeaseTable table;
  Lease lease;
};

}  // namespace

TEST_CASE("a new job is all pending") {
  const LeaseTable table(job(6, 4));
  CHECK(table.has_pending());
  CHECK(table.pending_units() == 24);
  CHECK(table.total_units() == 24);
  CHECK(table.done_units() == 0);
  CHECK(table.progress() == 0);
  CHECK(table.leased() == 0);
  CHECK(table.next_deadline() == never);
  CHECK_FALSE(table.done());
}

TEST_CASE("a job in passes has the work that is added to it") {
  RenderSettings settings = job(6, 4);
  settings.adaptive = true;
  LeaseTable table(settings);
  CHECK_FALSE(table.has_pending());
  CHECK(table.done());
  table.add({0, 6, 0, 2}, 0.5);
  table.add({0, 6, 2, 4}, 0.25);
  CHECK(table.pending_units() == 24);
  CHECK(table.pending() == std::vector<WorkRect>{{0, 6, 0, 2}, {0, 6, 2, 4}});
  CHECK(table.density() == 0.5);
  // Guided: half of what is left of the first part, not of all.
  CHECK(table.grant(seconds(1), asker(ann), false)->rect == WorkRect{0, 3, 0, 2});
  CHECK(table.grant(seconds(1), asker(ann), false)->rect == WorkRect{3, 5, 0, 2});
  CHECK(table.grant(seconds(1), asker(ann), false)->rect == WorkRect{5, 6, 0, 2});
  CHECK(table.grant(seconds(1), asker(ann), false)->rect == WorkRect{0, 3, 2, 4});
  CHECK(table.density() == 0.25);
  CHECK(table.leased_rect(1) == WorkRect{0, 3, 0, 2});
  CHECK_FALSE(table.leased_rect(99));
}

TEST_CASE("a progressive job begins with one sample of every pixel, whatever the policy") {
  for (const auto policy : {SchedulePolicy::static_split, SchedulePolicy::guided,
                            SchedulePolicy::factoring, SchedulePolicy::weighted}) {
    RenderSettings settings = job(8, 100, policy);
    settings.progressive = true;
    LeaseTable table(settings);
    std::vector<std::uint32_t> begins;
    std::uint64_t units = 0;
    while (const auto lease = table.grant(seconds(1), asker(ann), false)) {
      units += lease->rect.units();
      begins.push_back(lease->rect.sample_begin);
    }
    CHECK(units == 800);
    CHECK(std::is_sorted(begins.begin(), begins.end()));
    CHECK(std::set<std::uint32_t>(begins.begin(), begins.end()).contains(1));
    CHECK(std::set<std::uint32_t>(begins.begin(), begins.end()).contains(16));
  }
}

TEST_CASE("restoring takes from every part of the work") {
  RenderSettings settings = job(6, 20);
  settings.progressive = true;
  LeaseTable table(settings);
  table.restore({0, 6, 16, 20});
  table.restore({2, 3, 0, 1});
  CHECK(table.pending_units() == 6 * 16 - 1);
  CHECK(table.done_units() == 25);
  CHECK_THROWS_AS(table.restore({0, 1, 16, 20}), std::logic_error);
  table.restore({0, 6, 1, 16});
  table.restore({0, 2, 0, 1});
  table.restore({3, 6, 0, 1});
  CHECK(table.done());
}

TEST_CASE("pending work becomes leased by a grant") {
  LeaseTable table(job(6, 4), 100);
  const auto first = table.grant(seconds(10), asker(ann), false);
  REQUIRE(first);
  CHECK(first->epoch == 100);
  CHECK(first->rect == WorkRect{0, 3, 0, 4});
  CHECK_FALSE(first->copy);
  const auto second = table.grant(seconds(5), asker(bob), false);
  REQUIRE(second);
  CHECK(second->epoch == 101);
  CHECK(second->rect == WorkRect{3, 5, 0, 4});
  CHECK(table.leased() == 2);
  CHECK(table.held_by(ann) == 1);
  CHECK(table.held_by(cid) == 0);
  CHECK(table.pending_units() == 4);
  CHECK(table.next_deadline() == seconds(5));
}

TEST_CASE("a leased rectangle is done with its first result") {
  OneLease f;
  const auto completion = f.table.complete(ann, f.lease.epoch, f.lease.rect, digest);
  CHECK(completion.verdict == accepted);
  CHECK(completion.others.empty());
  CHECK(f.table.done());
  CHECK(f.table.progress() == 1);
  CHECK(f.table.leased() == 0);
  CHECK(f.table.next_deadline() == never);
}

TEST_CASE("a result that comes again is a duplicate, whoever sends it") {
  OneLease f;
  f.table.complete(ann, f.lease.epoch, f.lease.rect, digest);
  for (const WorkerId worker : {ann, bob}) {
    CHECK(f.table.complete(worker, f.lease.epoch, f.lease.rect, digest).verdict == duplicate);
  }
  CHECK(f.table.done_units() == 8);
}

TEST_CASE("a result with other bytes for done samples is a mismatch, and changes nothing") {
  OneLease f;
  f.table.complete(ann, f.lease.epoch, f.lease.rect, digest);
  CHECK(f.table.complete(bob, f.lease.epoch, f.lease.rect, other_digest).verdict == mismatch);
  CHECK(f.table.complete(bob, f.lease.epoch, {0, 1, 0, 4}, digest).verdict == mismatch);
  CHECK(f.table.complete(bob, f.lease.epoch, f.lease.rect, digest).verdict == duplicate);
  CHECK(f.table.done_units() == 8);
}

TEST_CASE("a result for an epoch never granted, or for another rectangle, is stale") {
  OneLease f;
  CHECK(f.table.complete(ann, f.lease.epoch + 1, f.lease.rect, digest).verdict == stale);
  CHECK(f.table.complete(ann, 0, f.lease.rect, digest).verdict == stale);
  CHECK(f.table.complete(ann, f.lease.epoch, {0, 1, 0, 4}, digest).verdict == stale);
  CHECK(f.table.complete(ann, f.lease.epoch, f.lease.rect, digest).verdict == accepted);
}

TEST_CASE("a lease whose deadline passes is retired: its work is pending, its result stale") {
  OneLease f;
  CHECK(f.table.expire(seconds(10) - Time(1)).empty());
  const auto expired = f.table.expire(seconds(10));
  REQUIRE(expired.size() == 1);
  CHECK(expired[0].epoch == f.lease.epoch);
  CHECK(expired[0].worker == ann);
  CHECK(f.table.pending_units() == 8);
  CHECK(f.table.leased() == 0);
  CHECK(f.table.complete(ann, f.lease.epoch, f.lease.rect, digest).verdict == stale);
  CHECK(f.table.done_units() == 0);
  CHECK(f.table.expire(seconds(99)).empty());
}

TEST_CASE("a lost worker's leases are retired") {
  LeaseTable table(job(8, 4));
  const auto first = table.grant(seconds(10), asker(ann), false);
  const auto kept = table.grant(seconds(10), asker(bob), false);
  const auto second = table.grant(seconds(10), asker(ann), false);
  CHECK(table.drop_worker(ann) == std::vector<Epoch>{first->epoch, second->epoch});
  CHECK(table.leased() == 1);
  CHECK(table.held_by(bob) == 1);
  CHECK(table.drop_worker(ann).empty());
  CHECK(table.complete(ann, first->epoch, first->rect, digest).verdict == stale);
  CHECK(table.complete(bob, kept->epoch, kept->rect, digest).verdict == accepted);
}

TEST_CASE("retired work is granted again first, under an epoch never used before") {
  LeaseTable table(job(8, 4));
  const auto lost = table.grant(seconds(10), asker(ann), false);
  table.grant(seconds(10), asker(bob), false);
  table.drop_worker(ann);
  const auto again = table.grant(seconds(10), asker(bob), false);
  CHECK(again->epoch == 3);
  CHECK(again->rect.row_begin == lost->rect.row_begin);
  // The old result comes late, the new one after it.
  CHECK(table.complete(ann, lost->epoch, lost->rect, digest).verdict == stale);
  CHECK(table.complete(bob, again->epoch, again->rect, digest).verdict == accepted);
  CHECK(table.complete(ann, lost->epoch, lost->rect, digest).verdict == stale);
}

TEST_CASE("a heartbeat moves the deadline on, never back") {
  OneLease f;
  CHECK(f.table.extend(ann, f.lease.epoch, seconds(20)));
  CHECK(f.table.next_deadline() == seconds(20));
  CHECK(f.table.extend(ann, f.lease.epoch, seconds(15)));
  CHECK(f.table.next_deadline() == seconds(20));
  CHECK(f.table.expire(seconds(19)).empty());
  CHECK(f.table.expire(seconds(20)).size() == 1);
}

TEST_CASE("only a holder's heartbeat counts, and none once the lease has ended") {
  OneLease f;
  CHECK_FALSE(f.table.extend(bob, f.lease.epoch, seconds(20)));
  CHECK_FALSE(f.table.extend(ann, f.lease.epoch + 1, seconds(20)));
  CHECK(f.table.next_deadline() == seconds(10));
  f.table.complete(ann, f.lease.epoch, f.lease.rect, digest);
  CHECK_FALSE(f.table.extend(ann, f.lease.epoch, seconds(20)));
}

TEST_CASE("a copy has the epoch and rectangle of the lease, and waits until nothing is pending") {
  LeaseTable table(job(4, 4));
  const auto first = table.grant(seconds(10), asker(ann), true);
  CHECK_FALSE(first->copy);
  const auto second = table.grant(seconds(10), asker(bob), true);
  CHECK_FALSE(second->copy);
  CHECK_FALSE(table.grant(seconds(10), asker(cid), false));
  const auto copy = table.grant(seconds(12), asker(cid), true);
  REQUIRE(copy);
  CHECK(copy->copy);
  CHECK(copy->epoch == first->epoch);  // the oldest
  CHECK(copy->rect == first->rect);
  CHECK(table.leased() == 2);
  CHECK(table.held_by(cid) == 1);
}

TEST_CASE("nobody gets a copy of his own lease, and no lease a third holder") {
  OneLease f;
  CHECK_FALSE(f.table.grant(seconds(10), asker(ann), true));
  CHECK(f.table.grant(seconds(10), asker(bob), true));
  CHECK_FALSE(f.table.grant(seconds(10), asker(bob), true));
  CHECK_FALSE(f.table.grant(seconds(10), asker(cid), true));
  static_assert(LeaseTable::most_holders == 2);
}

TEST_CASE("of two copies the first result wins, and the other holder is named") {
  for (const ResultDigest second : {digest, other_digest}) {
    OneLease f;
    f.table.grant(seconds(10), asker(bob), true);
    const auto completion = f.table.complete(bob, f.lease.epoch, f.lease.rect, digest);
    CHECK(completion.verdict == accepted);
    CHECK(completion.others == Workers{ann});
    CHECK(f.table.complete(ann, f.lease.epoch, f.lease.rect, second).verdict ==
          (second == digest ? duplicate : mismatch));
    CHECK(f.table.done_units() == 8);
  }
}

TEST_CASE("a lease with a copy ends with its last holder only") {
  OneLease f;
  f.table.grant(seconds(30), asker(bob), true);
  CHECK(f.table.expire(seconds(10)).size() == 1);  // Ann's
  CHECK(f.table.leased() == 1);
  CHECK(f.table.pending_units() == 0);
  SUBCASE("the copy's result counts") {
    const auto completion = f.table.complete(bob, f.lease.epoch, f.lease.rect, digest);
    CHECK(completion.verdict == accepted);
    CHECK(completion.others.empty());
  }
  SUBCASE("so does the late one of the first holder: the epoch is still current") {
    const auto completion = f.table.complete(ann, f.lease.epoch, f.lease.rect, digest);
    CHECK(completion.verdict == accepted);
    CHECK(completion.others == Workers{bob});
  }
  SUBCASE("without the copy the work is pending") {
    f.table.drop_worker(bob);
    CHECK(f.table.pending_units() == 8);
    CHECK(f.table.complete(ann, f.lease.epoch, f.lease.rect, digest).verdict == stale);
  }
}

TEST_CASE("both holders may expire at once") {
  OneLease f;
  f.table.grant(seconds(8), asker(bob), true);
  CHECK(f.table.next_deadline() == seconds(8));
  CHECK(f.table.expire(seconds(10)).size() == 2);
  CHECK(f.table.pending_units() == 8);
}

TEST_CASE("restored rectangles are done and never granted") {
  LeaseTable table(job(6, 4), 50);
  table.restore({1, 3, 0, 4});
  table.restore({4, 5, 1, 3});
  CHECK(table.done_units() == 10);
  CHECK(table.pending_units() == 14);
  std::set<std::pair<std::uint32_t, std::uint32_t>> granted;
  while (const auto lease = table.grant(seconds(1), asker(ann, 1), false)) {
    CHECK(lease->epoch >= 50);
    for (std::uint32_t row = lease->rect.row_begin; row < lease->rect.row_end; ++row) {
      for (std::uint32_t s = lease->rect.sample_begin; s < lease->rect.sample_end; ++s) {
        CHECK(granted.emplace(row, s).second);
        const bool restored = (row >= 1 && row < 3) || (row == 4 && s >= 1 && s < 3);
        CHECK_FALSE(restored);
      }
    }
    CHECK(table.complete(ann, lease->epoch, lease->rect, digest).verdict == accepted);
  }
  CHECK(granted.size() == 14);
  CHECK(table.done());
}

TEST_CASE("a job restored as a whole is done") {
  LeaseTable table(job(6, 4));
  table.restore({0, 6, 0, 4});
  CHECK(table.done());
  CHECK_FALSE(table.has_pending());
  CHECK_FALSE(table.grant(seconds(1), asker(ann), true));
}

TEST_CASE("restoring samples twice, or from outside of the picture, is an error") {
  LeaseTable table(job(6, 4));
  table.restore({1, 3, 0, 4});
  for (const WorkRect& bad : {WorkRect{1, 3, 0, 4}, WorkRect{2, 4, 1, 2}, WorkRect{0, 6, 0, 4},
                              WorkRect{5, 7, 0, 4}, WorkRect{5, 6, 3, 5}}) {
    CHECK_THROWS_AS(table.restore(bad), std::logic_error);
    CHECK(table.done_units() == 8);
    CHECK(table.pending_units() == 16);
  }
  table.restore({3, 6, 0, 4});
  table.restore({0, 1, 0, 4});
  CHECK(table.done());
}

TEST_CASE("a lease may cover part of a row's samples, and the rest follows") {
  LeaseTable table(job(2, 1000, SchedulePolicy::weighted));
  Asker slow = asker(ann);
  slow.share = 0.1;
  const auto first = table.grant(seconds(1), slow, false);
  CHECK(first->rect == WorkRect{0, 1, 0, 100});
  const auto second = table.grant(seconds(1), slow, false);
  CHECK(second->rect == WorkRect{0, 1, 100, 195});
  slow.least_units = 2000;
  const auto third = table.grant(seconds(1), slow, false);
  CHECK(third->rect == WorkRect{0, 1, 195, 1000});  // one rectangle: the row's rest
  const auto last = table.grant(seconds(1), slow, false);
  CHECK(last->rect == WorkRect{1, 2, 0, 1000});
  CHECK_FALSE(table.has_pending());
}

TEST_CASE("a lease's result fits a message: 64 MiB of sums at most") {
  RenderSettings settings = job(4096, 16, SchedulePolicy::static_split);
  settings.width = 16384;
  LeaseTable table(settings);
  while (const auto lease = table.grant(seconds(1), asker(ann, 1), false)) {
    REQUIRE(std::uint64_t{lease->rect.rows()} * settings.width * sizeof(PixelSums) <=
            std::uint64_t{64} << 20);
  }
  settings.width = 65536;
  settings.height = 1;
  LeaseTable wide(settings);
  CHECK(wide.grant(seconds(1), asker(ann, 1), false)->rect.rows() == 1);
}

TEST_CASE("an asker from a farm of no workers counts as one") {
  LeaseTable table(job(6, 4));
  CHECK(table.grant(seconds(1), asker(ann, 0), false)->rect.rows() == 6);
}

}  // namespace parray
