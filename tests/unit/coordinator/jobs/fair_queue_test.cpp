#include "coordinator/jobs/fair_queue.h"

#include <doctest/doctest.h>

#include <map>
#include <string>
#include <vector>

#include "tests/support/rooms.h"

namespace parray::test {
namespace {

FairQueue::Entry entry(JobId id, const std::string& user, std::uint32_t priority = 50,
                       double work_left = 1000, bool fresh = false) {
  return {id, user, 1, priority, fresh, work_left};
}

/// Returns the job whose turn it is. The caller charges for it.
JobId grant_next(FairQueue& queue) {
  JobId granted = 0;
  queue.visit([&](JobId job) {
    granted = job;
    return FairQueue::Answer::granted;
  });
  return granted;
}

/// Grants `count` leases of equal length. Returns the thread-seconds of each job.
std::map<JobId, double> grant(FairQueue& queue, int leases, double seconds = 1) {
  std::map<JobId, double> had;
  for (int i = 0; i < leases; ++i) {
    const JobId granted = grant_next(queue);
    queue.charge(seconds);
    had[granted] += seconds;
  }
  return had;
}

}  // namespace

TEST_CASE("users get equal parts, however many jobs each has") {
  FairQueue queue;
  queue.assign({entry(1, "ann"), entry(2, "bob"), entry(3, "bob"), entry(4, "bob")});
  const auto had = grant(queue, 1000);
  CHECK(had.at(1) == 500);
}

TEST_CASE("users get thread-seconds, not leases, in proportion to their shares") {
  FairQueue queue;
  auto ann = entry(1, "ann");
  ann.share = 3;
  queue.assign({ann, entry(2, "bob")});
  double of_ann = 0;
  double of_bob = 0;
  for (int i = 0; i < 4000; ++i) {
    const JobId granted = grant_next(queue);
    const double cost = granted == 1 ? 0.1 : 1.7;
    queue.charge(cost);
    (granted == 1 ? of_ann : of_bob) += cost;
  }
  CHECK(of_ann / of_bob == doctest::Approx(3).epsilon(0.02));
}

TEST_CASE("a user accumulates no credit while away, and a new user is next") {
  FairQueue queue;
  queue.assign({entry(1, "ann"), entry(2, "bob")});
  grant(queue, 10);
  queue.assign({entry(1, "ann")});
  grant(queue, 1000);
  queue.assign({entry(1, "ann"), entry(3, "bob")});
  CHECK(grant(queue, 1).contains(3));
  const auto had = grant(queue, 100);
  CHECK(had.at(3) >= 49);
  CHECK(had.at(3) <= 51);
}

TEST_CASE("among the jobs of one user the highest priority goes first, then the oldest") {
  FairQueue queue;
  queue.assign({entry(1, "ann"), entry(2, "ann"), entry(3, "ann", 51)});
  CHECK(grant(queue, 100) == std::map<JobId, double>{{3, 100}});
  queue.assign({entry(1, "ann"), entry(2, "ann")});
  CHECK(grant(queue, 100) == std::map<JobId, double>{{1, 100}});
}

TEST_CASE("a short job gets its first lease at once, then a quarter beside an older long job") {
  FairQueue queue;
  queue.assign({entry(1, "ann", 50, 1e6)});
  grant(queue, 100);
  queue.assign({entry(1, "ann", 50, 1e6), entry(2, "ann", 50, 10, true)});
  CHECK(grant(queue, 1).contains(2));
  queue.assign({entry(1, "ann", 50, 1e6), entry(2, "ann", 50, 9)});
  const auto had = grant(queue, 1000);
  CHECK(had.at(2) >= 248);
  CHECK(had.at(2) <= 252);
  // But not if the long job has a higher priority.
  queue.assign({entry(1, "ann", 60, 1e6), entry(2, "ann", 50, 9)});
  CHECK(grant(queue, 100) == std::map<JobId, double>{{1, 100}});
}

TEST_CASE("a job without work blocks no other; a job in preparation blocks its user's later jobs") {
  FairQueue queue;
  queue.assign({entry(1, "ann"), entry(2, "ann"), entry(3, "bob")});
  std::vector<JobId> asked;
  const auto visit = [&](FairQueue::Answer of_first) {
    asked.clear();
    return queue.visit([&](JobId job) {
      asked.push_back(job);
      return job == 1 ? of_first : FairQueue::Answer::nothing;
    });
  };
  CHECK_FALSE(visit(FairQueue::Answer::nothing));
  CHECK(asked == std::vector<JobId>{3, 1, 2});
  CHECK_FALSE(visit(FairQueue::Answer::wait));
  CHECK(asked == std::vector<JobId>{3, 1});
}

TEST_CASE("users share by the real cost of leases, not by the expected cost") {
  FairQueue queue;
  queue.assign({entry(1, "ann"), entry(2, "bob")});
  double of_ann = 0;
  double of_bob = 0;
  for (int i = 0; i < 4000; ++i) {
    const JobId granted = grant_next(queue);
    queue.charge(1);
    const double cost = granted == 1 ? 40 : 0.5;
    queue.correct(granted == 1 ? "ann" : "bob", cost - 1);
    (granted == 1 ? of_ann : of_bob) += cost;
  }
  CHECK(of_ann / of_bob == doctest::Approx(1).epsilon(0.05));
  queue.correct("a user who has left", 1);
}

TEST_CASE("a job that starves gets a twentieth of its user's turns, whatever its priority") {
  FairQueue queue;
  auto low = entry(2, "ann", 0);
  auto lower = entry(3, "ann", 0);
  queue.assign({entry(1, "ann", 100), entry(4, "ann", 100), low, lower, entry(5, "bob")});
  CHECK(grant(queue, 1000).count(2) == 0);
  low.starving = lower.starving = true;
  lower.waited = 1;
  queue.assign({entry(1, "ann", 100), entry(4, "ann", 100), low, lower, entry(5, "bob")});
  const auto had = grant(queue, 4000);
  CHECK(had.at(3) == doctest::Approx(100).epsilon(0.03));  // of ann's 2000
  CHECK(had.count(2) == 0);
  CHECK(had.at(5) == doctest::Approx(2000).epsilon(0.01));
}

}  // namespace parray::test
