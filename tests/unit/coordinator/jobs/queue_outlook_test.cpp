#include "coordinator/jobs/queue_outlook.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/support/rooms.h"

namespace parray::test {
namespace {

QueueOutlook::Entry waiting(JobId id, const std::string& user, double work,
                            std::uint32_t priority = 50) {
  QueueOutlook::Entry entry;
  entry.id = id;
  entry.user = user;
  entry.priority = priority;
  entry.work_left = work;
  entry.until_starving = 600;
  return entry;
}

QueueOutlook::Entry traced(JobId id, const std::string& user, double work,
                           std::uint32_t priority = 50) {
  QueueOutlook::Entry entry = waiting(id, user, work, priority);
  entry.begun = true;
  return entry;
}

QueueOutlook outlook_of(const std::vector<QueueOutlook::Entry>& jobs, double threads = 2) {
  QueueOutlook outlook;
  outlook.assign(jobs, threads, 1);
  return outlook;
}

}  // namespace

TEST_CASE("a job of a lower priority begins after all work of the higher one") {
  const QueueOutlook outlook = outlook_of({traced(7, "ann", 100), waiting(8, "ann", 1, 10)});
  CHECK(outlook.of(7) == nullptr);
  REQUIRE(outlook.of(8) != nullptr);
  CHECK(outlook.of(8)->number == 1);
  CHECK(outlook.of(8)->behind == 7);
  CHECK(outlook.of(8)->priority_behind == 50);
  CHECK(outlook.of(8)->starts_in.value() == doctest::Approx(50));
}

TEST_CASE("a short job of the same priority begins at once, in the express lane") {
  const QueueOutlook outlook = outlook_of({traced(7, "ann", 1e6), waiting(8, "ann", 1)});
  CHECK(outlook.of(8)->behind == 0);
  CHECK(outlook.of(8)->starts_in.value() == 0);
}

TEST_CASE("short jobs behind a long one go through a quarter of the user's time") {
  const QueueOutlook outlook =
      outlook_of({traced(7, "ann", 1e6), waiting(8, "ann", 10), waiting(9, "ann", 20)});
  CHECK(outlook.of(8)->starts_in.value() == 0);
  CHECK(outlook.of(9)->starts_in.value() == doctest::Approx(10 / 0.25 / 2));
  CHECK(outlook.of(9)->number == 2);
}

TEST_CASE("users share the farm: half of it makes the wait twice as long") {
  const QueueOutlook outlook =
      outlook_of({traced(7, "ann", 100), waiting(8, "ann", 1, 10), traced(9, "bob", 1000)});
  CHECK(outlook.of(8)->starts_in.value() == doctest::Approx(100));
}

TEST_CASE("a user with no work left leaves the farm to the others") {
  const QueueOutlook outlook =
      outlook_of({traced(7, "ann", 100), waiting(8, "ann", 1, 10), traced(9, "bob", 50)});
  CHECK(outlook.of(8)->starts_in.value() == doctest::Approx(75));
}

TEST_CASE("a job behind an endless one begins by the lane against starvation, in turn") {
  std::vector<QueueOutlook::Entry> jobs = {traced(7, "ann", 1e9)};
  for (JobId id = 8; id < 11; ++id) jobs.push_back(waiting(id, "ann", 0.001, 10));
  jobs[1].until_starving = 30;
  jobs[2].until_starving = 30;
  const QueueOutlook outlook = outlook_of(jobs);
  CHECK(outlook.of(8)->starts_in.value() == doctest::Approx(30));
  CHECK(outlook.of(9)->starts_in.value() == doctest::Approx(30 + 0.001 / 0.05 / 2));
  CHECK(outlook.of(10)->starts_in.value() == doctest::Approx(600));
}

TEST_CASE("no time is stated behind a job of unknown length before starvation, or without speed") {
  QueueOutlook::Entry unknown = traced(7, "ann", 5);
  unknown.work_known = false;
  QueueOutlook::Entry behind = waiting(8, "ann", 1, 10);
  behind.until_starving = 1e14;
  CHECK_FALSE(outlook_of({unknown, behind}).of(8)->starts_in);
  const QueueOutlook still = outlook_of({traced(7, "ann", 100), waiting(8, "ann", 1, 10)}, 0);
  CHECK_FALSE(still.of(8)->starts_in);
  CHECK(still.of(8)->number == 1);
}

TEST_CASE("the outlook for 20,000 jobs of one user is complete") {
  std::vector<QueueOutlook::Entry> jobs;
  for (JobId id = 1; id <= 20'000; ++id) {
    jobs.push_back(waiting(id, "ann", static_cast<double>(id % 97), id % 3 == 0 ? 50 : 40));
  }
  const QueueOutlook outlook = outlook_of(jobs);
  std::vector<bool> seen(jobs.size() + 1);
  for (JobId id = 1; id <= jobs.size(); ++id) seen.at(outlook.of(id)->number) = true;
  CHECK(std::count(seen.begin(), seen.end(), true) == 20'000);
}

}  // namespace parray::test
