#include "common/schedule/chunk_sizer.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

#include "common/scene/settings.h"
#include "tests/support/dice.h"
#include "tests/support/rooms.h"
#include "tests/support/window_rig.h"

/// What the policies say: schedule_test.cpp. Here: what they are asked.
namespace parray {
namespace {

using test::Dice;

/// Of 200 rows of 100 pixels and 1024 samples: cells of two pixels, 2048 samples each.
RenderSettings job(SchedulePolicy policy) {
  RenderSettings settings = test::made_settings(100, 200, 1024);
  settings.schedule = policy;
  return settings;
}
constexpr double cell_samples = 2048;

ChunkSizer sizer(SchedulePolicy policy, LeaseLength length = {0.002, 1}) {
  return {policy, *test::whole_plan(job(policy)), length};
}

/// `workers` of one thread, all measured at the same speed.
FarmSpeed speeds_of(std::uint32_t workers, double each) {
  return {each * workers, workers, workers, workers};
}

}  // namespace

TEST_CASE("a chunk has at least a cell and at most what remains, whoever asks whenever") {
  Dice dice(1);
  for (int round = 0; round < 20'000; ++round) {
    const auto policy = static_cast<SchedulePolicy>(dice.below(4));
    static const std::vector<ChunkSizer> sizers{
        sizer(SchedulePolicy::static_split), sizer(SchedulePolicy::guided),
        sizer(SchedulePolicy::factoring), sizer(SchedulePolicy::weighted)};
    const LeaseRequest request{1 + dice.below32(4096), dice.one_in(3) ? 0 : dice.ten_to(-300, 18)};
    FarmSpeed speeds;
    speeds.threads = dice.below(dice.one_in(2) ? 3 : 1'000'000);
    speeds.measured_threads = dice.below(speeds.threads + 2);
    speeds.samples_per_second = dice.one_in(3) ? 0 : dice.ten_to(-300, 18);
    speeds.workers = dice.below32(dice.one_in(2) ? 3 : 100'000);
    const std::uint64_t remaining = 1 + dice.below(10'000);
    const std::uint64_t cells = sizers[static_cast<std::size_t>(policy)].cells(
        request, speeds, remaining, dice.below(1000));
    REQUIRE(cells >= 1);
    REQUIRE(cells <= remaining);
  }
}

TEST_CASE("leases by speed: each asker gets a share as large as its part of all speed") {
  const ChunkSizer weighted = sizer(SchedulePolicy::weighted, {0, 1e9});
  const FarmSpeed speeds{1000, 4, 4, 4};
  const auto of = [&](double speed) {
    return static_cast<double>(weighted.cells({1, speed}, speeds, 10'000, 0));
  };
  CHECK(of(400) / of(100) == doctest::Approx(4).epsilon(0.02));
  CHECK(of(400) == of(400));
}

TEST_CASE("leases by speed last between the shortest and the longest time, but for the last") {
  const ChunkSizer weighted = sizer(SchedulePolicy::weighted, {0.01, 0.5});
  for (const double speed : {1e5, 1e6, 1e7}) {
    const auto length = [&](std::uint32_t workers, std::uint64_t remaining) {
      return static_cast<double>(
                 weighted.cells({1, speed}, speeds_of(workers, speed), remaining, 0)) *
             cell_samples / speed;
    };
    const double cell = cell_samples / speed;
    CHECK(length(1, 10'000) <= 0.5 + cell);
    CHECK(length(10'000, 10'000) >= 0.01 - cell);
    CHECK(length(10'000, 1) <= cell * 1.001);
  }
}

TEST_CASE("who is not measured yet counts as fast, a thread, as the others, and gets little") {
  const ChunkSizer weighted = sizer(SchedulePolicy::weighted);
  const FarmSpeed half{2e6, 2, 4, 4};
  const std::uint64_t unknown = weighted.cells({1, 0}, half, 10'000, 0);
  CHECK(static_cast<double>(unknown) * cell_samples <= 1e5 + cell_samples);
  CHECK(weighted.cells({8, 0}, half, 10'000, 0) > unknown);
  CHECK(weighted.cells({1, 1e6}, half, 10'000, 0) > unknown);
}

TEST_CASE("a speed that nobody can have makes nobody's share nothing") {
  const ChunkSizer weighted = sizer(SchedulePolicy::weighted);
  const FarmSpeed odd{1e20, 2, 2, 2};
  CHECK(weighted.cells({1, 1e6}, odd, 10'000, 0) >= 1);
  CHECK(weighted.cells({1, 1e20}, odd, 10'000, 0) <= 10'000);
}

TEST_CASE("policies for whole rows deal out whole rows") {
  const std::uint64_t row = 50;  // cells
  for (const auto policy :
       {SchedulePolicy::static_split, SchedulePolicy::guided, SchedulePolicy::factoring}) {
    std::uint64_t remaining = 200 * row;
    for (std::uint64_t step = 0; remaining > 0; ++step) {
      const std::uint64_t cells = sizer(policy).cells({2, 0}, speeds_of(3, 0), remaining, step);
      CHECK(cells % row == 0);
      remaining -= cells;
    }
  }
}

TEST_CASE("chunks that every rank computes begin where one asker after the other would begin") {
  const ChunkSizer guided = sizer(SchedulePolicy::guided);
  const auto starts = guided.starts(4, 2);
  CHECK(starts.front() == 0);
  CHECK(starts.back() == 10'000);
  CHECK(std::is_sorted(starts.begin(), starts.end()));
  std::uint64_t at = 0;
  for (std::size_t step = 0; step + 1 < starts.size(); ++step) {
    CHECK(starts[step] == at);
    at += guided.cells({2, 0}, {0, 0, 8, 4}, 10'000 - at, step);
  }
}

TEST_CASE("of a part of a plan's cells, shares are of that part") {
  const auto plan = test::whole_plan(job(SchedulePolicy::static_split));
  const ChunkSizer part(SchedulePolicy::static_split, *plan, {}, 1000);
  CHECK(part.starts(4, 1) == std::vector<std::uint64_t>{0, 250, 500, 750, 1000});
}

}  // namespace parray
