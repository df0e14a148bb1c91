// Jobs of parray-mpi on a simulated window, in virtual time, with ranks of all speeds that stall
// and die.
#include <doctest/doctest.h>

#include <cmath>
#include <numeric>

#include "common/scene/settings.h"
#include "tests/experiments/simulation/sim_job.h"
#include "tests/support/dice.h"
#include "tests/support/rooms.h"
#include "tests/support/trials.h"

namespace parray::test {
namespace {

using namespace simulation;

/// Returns costs of rows, `seconds` in total. A tenth of the rows, in the middle, costs 20 times as
/// much as the others.
std::vector<double> hot_band(std::uint32_t height, double seconds) {
  std::vector<double> rows(height, 1.0);
  std::fill(rows.begin() + height * 9 / 20, rows.begin() + height * 11 / 20, 20.0);
  const double sum = std::accumulate(rows.begin(), rows.end(), 0.0);
  for (double& row : rows) row *= seconds / sum;
  return rows;
}

JobOptions job_of(std::uint32_t ranks, SchedulePolicy schedule, RowOrder order) {
  JobOptions job;
  job.settings.width = 600;
  job.settings.height = 400;
  job.settings.samples_per_pixel = 200;
  job.settings.schedule = schedule;
  job.settings.row_order = order;
  job.row_seconds = hot_band(400, 12);
  job.ranks = ranks;
  job.threads = 2;
  job.link = known_links().front();
  job.give_up = std::chrono::hours(1);
  return job;
}

JobOptions random_job(Dice& dice) {
  JobOptions job = job_of(1 + dice.below32(40), static_cast<SchedulePolicy>(dice.below(4)),
                          dice.one_in(2) ? RowOrder::sequential : RowOrder::interleaved);
  job.settings.width = 1 + dice.below32(100);
  job.settings.height = 1 + dice.below32(80);
  job.settings.samples_per_pixel = 1 + dice.below32(5000);
  job.row_seconds = std::vector<double>(job.settings.height);
  for (double& row : job.row_seconds) row = dice.ten_to(-3, 1);
  job.cell_noise = dice.unit();
  job.seed = dice.bits();
  job.threads = 1 + dice.below32(4);
  job.link.atomic = dice.ten_to(-7, -3);
  job.link.atomic_service = dice.unit() * job.link.atomic;
  job.link.bytes_per_second = dice.ten_to(6, 10);
  job.link.needs_target = dice.one_in(2);
  job.start.build = dice.unit();
  job.start.mpi = dice.unit();
  const double ideal = std::accumulate(job.row_seconds.begin(), job.row_seconds.end(), 0.0) /
                       (job.ranks * job.threads);
  for (std::uint32_t rank = 0; rank < job.ranks; ++rank) {
    job.speeds.push_back(dice.ten_to(-0.5, 0.5));
    if (dice.one_in(3)) {
      const Time begin = to_time(2 * ideal * dice.unit());
      const bool dies = rank > 0 && dice.one_in(2);
      job.stops.push_back({rank, begin, dies ? never : begin + to_time(3 * ideal * dice.unit())});
    }
  }
  return job;
}

void check_job_picture(const SimJob& job, const JobOptions& options) {
  const Framebuffer& picture = job.framebuffer();
  const RenderSettings& settings = options.settings;
  const std::vector<std::uint32_t> all(picture.pixels().size(), settings.samples_per_pixel);
  REQUIRE(std::ranges::equal(picture.samples(), all));
  CHECK(picture.counts().rays == job.plan().cells());  // a simulated cell is one ray
  CHECK(picture.counts().samples ==
        std::uint64_t{settings.width} * settings.height * settings.samples_per_pixel);
  CHECK(job.totals().mismatches == 0);
  CHECK(job.totals().corrupt == 0);
}

void check_account(const SimJob& job, const JobOptions& options) {
  for (const Spent& spent : job.spent()) {
    REQUIRE(spent.sum() == doctest::Approx(options.threads * job.seconds()).epsilon(1e-6));
  }
  CHECK(job.spent_together().useful == doctest::Approx(job.work_seconds()).epsilon(1e-6));
}

double efficiency_of(const JobOptions& options) {
  SimJob job(options);
  REQUIRE(job.run());
  check_job_picture(job, options);
  check_account(job, options);
  return job.running_efficiency();
}

}  // namespace

TEST_CASE(
    "100 random jobs end while rank 0 lives: every cell merged once, every second accounted for") {
  std::uint64_t copies = 0;
  std::uint64_t duplicates = 0;
  for (std::uint64_t seed = 0; seed < trials(100); ++seed) {
    CAPTURE(seed);
    Dice dice(seed);
    const JobOptions options = random_job(dice);
    SimJob job(options);
    REQUIRE(job.run());
    check_job_picture(job, options);
    check_account(job, options);
    copies += job.totals().copies;
    duplicates += job.totals().duplicates;
  }
  CHECK(copies > 0);
  CHECK(duplicates > 0);
}

TEST_CASE("A job ends if all ranks except the first die at once, but not if the first dies") {
  JobOptions options = job_of(32, SchedulePolicy::weighted, RowOrder::interleaved);
  for (std::uint32_t rank = 1; rank < 32; ++rank) {
    options.stops.push_back({rank, milliseconds(20), never});
  }
  SimJob job(options);
  CHECK(job.run());
  check_job_picture(job, options);
  check_account(job, options);
  CHECK(job.seconds() > 4);  // the work takes 12 seconds of two threads

  options.stops = {{0, milliseconds(20), never}};
  options.give_up = seconds(60);
  SimJob headless(options);
  CHECK_FALSE(headless.run());
}

TEST_CASE("No rank waits for a stopped rank") {
  JobOptions options = job_of(16, SchedulePolicy::weighted, RowOrder::interleaved);
  options.stops = {{7, milliseconds(100), seconds(1000)}};
  SimJob job(options);
  CHECK(job.run());
  CHECK(job.seconds() < 0.6);  // 0.4 without the stop
  CHECK(job.totals().copies > 0);
}

TEST_CASE("The same job takes the same time, to the nanosecond") {
  const JobOptions options = job_of(24, SchedulePolicy::weighted, RowOrder::interleaved);
  SimJob first(options);
  SimJob second(options);
  REQUIRE(first.run());
  REQUIRE(second.run());
  CHECK(first.seconds() == second.seconds());
}

TEST_CASE(
    "A hot band of rows: interleaved weighted leases lose little, contiguous guided ones much") {
  const double weighted =
      efficiency_of(job_of(32, SchedulePolicy::weighted, RowOrder::interleaved));
  const double guided = efficiency_of(job_of(32, SchedulePolicy::guided, RowOrder::sequential));
  CHECK(weighted > 0.93);
  CHECK(guided < 0.75);
}

TEST_CASE("One rank 4 times as slow: weighted leases follow its speed, static ones do not") {
  JobOptions weighted = job_of(16, SchedulePolicy::weighted, RowOrder::interleaved);
  weighted.speeds.assign(16, 1.0);
  weighted.speeds[3] = 0.25;
  JobOptions fixed = weighted;
  fixed.settings.schedule = SchedulePolicy::static_split;
  const double followed = efficiency_of(weighted);
  CHECK(followed > 0.95);
  CHECK(followed > efficiency_of(fixed) + 0.02);
}

TEST_CASE("Ranks of equal speed get equal shares although rows differ 20 times in cost") {
  const JobOptions options = job_of(16, SchedulePolicy::weighted, RowOrder::interleaved);
  SimJob job(options);
  REQUIRE(job.run());
  for (std::uint32_t rank = 0; rank < options.ranks; ++rank) {
    CHECK(job.normalized_seconds(rank) > 0.9);
  }
}

}  // namespace parray::test
