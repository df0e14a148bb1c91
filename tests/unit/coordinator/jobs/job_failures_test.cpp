#include "coordinator/jobs/job_failures.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "tests/support/rooms.h"

namespace parray {
namespace {

MachineId machine(int number) {
  return {MachineId::Kind::address, "10.0.0." + std::to_string(number)};
}

/// Adds a reported failure of the machine's only worker, or of `worker`.
Failure said(int number, CellRange range, TracerKey worker = 0) {
  return {range, machine(number), worker != 0 ? worker : static_cast<TracerKey>(number), "worker",
          "not enough memory"};
}

/// Adds the loss of a worker with a lease; the worker returns as another process.
Failure died(int number, CellRange range, TracerKey worker) {
  Failure failure = said(number, range, worker);
  failure.by_loss = true;
  return failure;
}

/// Returns one worker on each of the machines [begin, end).
std::vector<AbleWorker> able(int begin, int end) {
  std::vector<AbleWorker> able;
  for (int i = begin; i < end; ++i) able.push_back({machine(i), static_cast<TracerKey>(i)});
  return able;
}

}  // namespace

TEST_CASE("a job is not at fault while a machine that has not tried may still get a lease") {
  JobFailures failures;
  for (int round = 0; round < 5; ++round) {
    for (int sick = 1; sick <= 3; ++sick) {
      failures.add(said(sick, {0, 10}));
      CHECK_FALSE(failures.verdict({0, 10}, able(1, 10), 3));
    }
  }
  for (int late = 4; late < 9; ++late) {
    failures.add(said(late, {50, 60}));
    CHECK_FALSE(failures.verdict({50, 60}, able(1, 10), 3));
  }
  failures.add(said(9, {50, 60}));
  CHECK(failures.verdict({50, 60}, able(1, 10), 3) == "9 machines");
}

TEST_CASE("once a machine has succeeded, only failures at the same cells count") {
  JobFailures failures;
  failures.note_success(machine(1));
  for (int sick = 2; sick <= 4; ++sick) {
    failures.add(said(sick, {0, 10}));
    CHECK_FALSE(failures.verdict({0, 10}, able(1, 5), 3));
  }
  failures.add(said(1, {10, 20}));
  CHECK_FALSE(failures.verdict({10, 20}, able(1, 5), 3));
  failures.add(said(1, {5, 20}));
  CHECK(failures.verdict({5, 20}, able(1, 5), 3));
}

TEST_CASE("three machines that trace other cells are enough, however many have not tried") {
  JobFailures failures;
  for (int number = 1; number <= 3; ++number) {
    failures.note_success(machine(number));
    CHECK_FALSE(failures.verdict({0, 1}, able(1, 1000), 3));
    failures.add(said(number, {0, 1}));
  }
  CHECK(failures.verdict({0, 1}, able(1, 1000), 3) == "3 machines");
}

TEST_CASE("fewer machines than --max-failures must each fail twice") {
  JobFailures failures;
  failures.add(said(1, {0, 1}));
  CHECK_FALSE(failures.verdict({0, 1}, able(1, 3), 3));
  failures.add(said(2, {1, 2}));
  CHECK_FALSE(failures.verdict({1, 2}, able(1, 3), 3));
  failures.add(said(1, {2, 3}));
  CHECK_FALSE(failures.verdict({2, 3}, able(1, 3), 3));
  failures.add(said(2, {3, 4}));
  CHECK(failures.verdict({3, 4}, able(1, 3), 3) == "2 machines, twice");
}

TEST_CASE("a machine has failed only if all its workers have failed") {
  JobFailures failures;
  std::vector<AbleWorker> nine;
  for (TracerKey worker = 1; worker <= 9; ++worker) nine.push_back({machine(1), worker});
  for (int round = 0; round < 50; ++round) {
    for (TracerKey sick = 1; sick <= 3; ++sick) failures.add(said(1, {0, 1}, sick));
  }
  CHECK_FALSE(failures.verdict({0, 1}, nine, 3));
}

TEST_CASE("a job that kills each process of the only machine is at fault, after a few deaths") {
  JobFailures failures;
  int deaths = 0;
  while (!failures.verdict({0, 1}, {{machine(1), 1000}}, 3) && deaths < 100) {
    failures.add(died(1, {0, 1}, static_cast<TracerKey>(++deaths)));
  }
  CHECK(deaths < 10);
}

TEST_CASE("losses do not count as deaths if the same processes return") {
  JobFailures failures;
  for (int number = 1; number <= 3; ++number) {
    Failure lost = died(number, {0, 1}, static_cast<TracerKey>(number));
    lost.excused = true;
    failures.add(lost);
  }
  CHECK(failures.note_joined(machine(1), 1, "another name").empty());
  CHECK(failures.all().size() == 2);
  const auto deaths = failures.note_joined(machine(2), 77, "another name");
  REQUIRE(deaths.size() == 1);
  CHECK(deaths.front().machine == machine(2));
}

}  // namespace parray
