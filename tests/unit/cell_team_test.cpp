#include "worker/cell_team.h"

#include <doctest/doctest.h>

#include <atomic>
#include <cstring>
#include <memory>
#include <vector>

#include "common/base/error.h"
#include "common/schedule/row_order.h"
#include "coordinator/window_ledger.h"
#include "tests/support/dice.h"
#include "tests/support/sample_scenes.h"
#include "tests/support/window_rig.h"
#include "worker/team.h"
#include "worker/window_leases.h"

namespace parray {
namespace {

using test::Dice;
using test::small_scene;

RenderSettings sized(std::uint32_t width, std::uint32_t height, std::uint32_t spp) {
  RenderSettings settings = test::small_settings(small_scene());
  settings.width = width;
  settings.height = height;
  settings.samples_per_pixel = spp;
  return settings;
}

std::shared_ptr<const WorkPlan> plan_of(const RenderSettings& settings, std::uint32_t tile = 0) {
  const WorkRect all{0, settings.height, 0, settings.samples_per_pixel};
  return std::make_shared<const WorkPlan>(settings, std::vector{all}, tile);
}

/// What the team makes of a range; waits for it.
TracedCells traced(ThreadCellTeam& team, const CellRange& range) {
  team.start(range);
  CHECK(team.busy());
  for (;;) {
    team.wait(seconds(1));
    if (auto result = team.take()) {
      return std::move(*result);
    }
  }
}

/// The records that a kernel makes without a team, a cell after the other; without times.
std::vector<std::byte> plain_records(const RenderSettings& settings, const WorkPlan& plan,
                                     const CellRange& range) {
  const auto kernel = make_kernel(small_scene(), settings);
  const auto row_at = make_row_order(settings.row_order, settings.height);
  std::vector<std::byte> records;
  for (std::uint64_t index = range.begin; index < range.end; ++index) {
    const Cell cell = plan.cell(index);
    std::vector<PixelSums> sums(plan.cell_pixels());
    TraceCounts counts;
    for (std::uint32_t x = cell.x_begin; x < cell.x_end; ++x) {
      kernel->trace({row_at[cell.position], x, x + 1}, {cell.sample_begin, cell.sample_end},
                    {&sums[x - cell.x_begin], 1}, counts);
    }
    const CellHeader header{counts.rays, counts.nonfinite, counts.lost, 0};
    const auto* const head = reinterpret_cast<const std::byte*>(&header);
    const auto pixels = std::as_bytes(std::span(sums));
    records.insert(records.end(), head, head + sizeof header);
    records.insert(records.end(), pixels.begin(), pixels.end());
  }
  return records;
}

std::vector<std::byte> without_times(std::vector<std::byte> records, std::size_t record_bytes) {
  for (std::size_t at = 0; at < records.size(); at += record_bytes) {
    std::memset(records.data() + at + offsetof(CellHeader, nanoseconds), 0, sizeof(std::uint64_t));
  }
  return records;
}

}  // namespace

TEST_CASE("a team's records are those of a kernel, whatever its threads, tiles and ranges") {
  Dice dice(1);
  for (const auto& settings : {sized(20, 13, 6), sized(3, 2, 5000), sized(500, 4, 9)}) {
    for (const std::uint32_t tile : {0U, 4U}) {
      const auto shared = plan_of(settings, tile);
      const WorkPlan& plan = *shared;
      const std::uint64_t begin = dice.below(plan.cells());
      const CellRange part{begin, begin + 1 + dice.below(plan.cells() - begin)};
      for (const CellRange& range : {CellRange{0, plan.cells()}, part}) {
        const auto expected = plain_records(settings, plan, range);
        for (const int threads : {1, 2, 3}) {
          CAPTURE(threads);
          CAPTURE(tile);
          ThreadCellTeam team(small_scene(), settings, shared, threads);
          const TracedCells result = traced(team, range);
          CHECK(result.range == range);
          CHECK(without_times(result.records, record_bytes_of(plan)) == expected);
          CHECK(result.samples == team.traced());
          CHECK(result.seconds > 0);
          CHECK_FALSE(team.busy());
        }
      }
    }
  }
}

TEST_CASE("a team traces range after range and counts the samples of each") {
  const RenderSettings settings = sized(21, 13, 250);
  const auto shared = plan_of(settings);
  const WorkPlan& plan = *shared;
  ThreadCellTeam team(small_scene(), settings, shared, 2);
  std::uint64_t samples = 0;
  for (std::uint64_t begin = 0; begin < plan.cells(); begin += 7) {
    const CellRange range{begin, std::min(begin + 7, plan.cells())};
    const TracedCells result = traced(team, range);
    std::uint64_t expected = 0;
    for (std::uint64_t cell = range.begin; cell < range.end; ++cell) {
      expected += plan.cell(cell).samples();
    }
    CHECK(result.samples == expected);
    samples += result.samples;
    CHECK(team.traced() == samples);
  }
  CHECK(samples == 21 * 13 * 250);
  CHECK_FALSE(team.building());
  CHECK(team.built().bytes > 0);
  CHECK_FALSE(team.built().isa.empty());
}

TEST_CASE("records carry the time that their cells took") {
  const RenderSettings settings = sized(20, 20, 100);
  const auto shared = plan_of(settings);
  const WorkPlan& plan = *shared;
  ThreadCellTeam team(small_scene(), settings, shared, 1);
  const TracedCells result = traced(team, {0, plan.cells()});
  double nanoseconds = 0;
  for (std::size_t at = 0; at < result.records.size(); at += record_bytes_of(plan)) {
    CellHeader header;
    std::memcpy(&header, result.records.data() + at, sizeof header);
    CHECK(header.nanoseconds > 0);
    nanoseconds += static_cast<double>(header.nanoseconds);
  }
  CHECK(nanoseconds <= 1e9 * result.seconds);
}

TEST_CASE("an abandoned range leaves no result, and the next one is right") {
  const RenderSettings settings = sized(100, 100, 20'000);
  const auto shared = plan_of(settings);
  const WorkPlan& plan = *shared;
  ThreadCellTeam team(small_scene(), settings, shared, 2);
  for (int i = 0; i < 5; ++i) {
    team.start({0, 50'000});
    const std::uint64_t before = team.traced();
    while (i % 2 == 0 && team.traced() == before) {
      team.wait(milliseconds(1));
    }
    team.abandon();
    while (team.busy()) {
      team.wait(seconds(1));
    }
    CHECK_FALSE(team.take());
  }
  const TracedCells result = traced(team, {5, 7});
  CHECK(without_times(result.records, record_bytes_of(plan)) ==
        plain_records(settings, plan, {5, 7}));
  CHECK(result.samples == plan.cell(5).samples() + plan.cell(6).samples());
}

TEST_CASE("a team that is destroyed while it traces ends") {
  const RenderSettings settings = sized(100, 100, 20'000);
  const auto shared = plan_of(settings);
  const WorkPlan& plan = *shared;
  ThreadCellTeam team(small_scene(), settings, shared, 2);
  team.start({0, plan.cells() / 2});
  while (team.traced() == 0) {
    team.wait(milliseconds(1));
  }
}

TEST_CASE("a failure to trace is thrown to whoever asks for the result") {
  const RenderSettings settings = sized(20, 13, 6);
  const auto shared = plan_of(settings);
  ThreadCellTeam team(small_scene(), settings, shared, 1);
  team.start({0, std::uint64_t{1} << 50});  // more memory than a vector may have
  team.wait(seconds(60));
  CHECK_THROWS_AS(team.take(), RunError);
}

TEST_CASE("teams, leases and the ledger together make the picture of one thread") {
  RenderSettings settings = sized(33, 21, 100);
  for (const auto policy : {SchedulePolicy::static_split, SchedulePolicy::weighted}) {
    for (const std::uint32_t tile : {0U, 6U}) {
      settings.schedule = policy;
      const auto shared = plan_of(settings, tile);
      const WorkPlan& plan = *shared;
      const WindowLayout layout(plan, 2);
      test::WindowMemory memory(layout.bytes());
      LocalWindow window(memory.bytes());
      Framebuffer framebuffer(settings);
      WindowLedger ledger(plan, layout, window, memory.bytes(), framebuffer, Time(0));
      for (std::uint32_t rank = 0; rank < 2; ++rank) {
        WindowLeaseOptions options;
        options.policy = policy;
        options.rank = rank;
        options.all_threads = 2;
        WindowLeases leases(plan, layout, window, options);
        ThreadCellTeam team(small_scene(), settings, shared, 1);
        for (auto taken = leases.take(0, false); taken.answer == LeaseSource::Answer::lease;
             taken = leases.take(1e6, false)) {
          leases.complete(taken.range, traced(team, taken.range).records);
          if (rank == 0 && policy == SchedulePolicy::static_split) {
            break;
          }
        }
      }
      while (ledger.collect(Time(0), 100)) {
      }
      REQUIRE(ledger.done());
      CHECK(framebuffer.counts().samples == 33 * 21 * 100);
      CHECK(image_sha256(resolve_image(framebuffer, largest_radiance(small_scene()))) ==
            test::reference_sha256(small_scene(), settings));
    }
  }
}

/// Everything of the pass under way in `framebuffer`, by two ranks over a window.
void trace_pass(const RenderSettings& settings, std::uint32_t tile, Framebuffer& framebuffer,
                std::vector<std::unique_ptr<ThreadCellTeam>>& teams) {
  const auto plan = std::make_shared<const WorkPlan>(settings, std::vector{framebuffer.pass_rect()},
                                                     tile, framebuffer.pass_samples());
  const WindowLayout layout(*plan, 2);
  test::WindowMemory memory(layout.bytes());
  LocalWindow window(memory.bytes());
  WindowLedger ledger(*plan, layout, window, memory.bytes(), framebuffer, Time(0));
  std::vector<std::unique_ptr<WindowLeases>> leases;
  for (std::uint32_t rank = 0; rank < 2; ++rank) {
    WindowLeaseOptions options;
    options.rank = rank;
    options.all_threads = 2;
    leases.push_back(std::make_unique<WindowLeases>(*plan, layout, window, options));
    teams[rank]->change_plan(plan);
  }
  for (std::size_t turn = 0;; ++turn) {
    const auto taken = leases[turn % 2]->take(1e6, false);
    if (taken.answer != LeaseSource::Answer::lease) {
      break;
    }
    leases[turn % 2]->complete(taken.range, traced(*teams[turn % 2], taken.range).records);
  }
  while (ledger.collect(Time(0), 100)) {
  }
  REQUIRE(ledger.done());
}

TEST_CASE("passes that give each pixel samples of its own come out as without a window") {
  Dice dice(2);
  for (const auto& settings : {sized(33, 21, 50), sized(200, 3, 5), sized(2, 2, 4000)}) {
    for (const std::uint32_t tile : {0U, 6U}) {
      const auto kernel = make_kernel(small_scene(), settings);
      std::vector<std::unique_ptr<ThreadCellTeam>> teams;
      for (const int threads : {1, 2}) {
        teams.push_back(
            std::make_unique<ThreadCellTeam>(small_scene(), settings, nullptr, threads));
      }
      Framebuffer framebuffer(settings);
      Framebuffer expected(settings);
      for (int pass = 0; pass < 4; ++pass) {
        CAPTURE(pass);
        const auto counts = pass == 0 ? std::vector<std::uint32_t>(framebuffer.samples().size(), 6)
                                      : test::ragged_counts(dice, framebuffer.samples(),
                                                            settings.samples_per_pixel);
        framebuffer.begin_pass(counts);
        trace_pass(settings, tile, framebuffer, teams);
        expected.begin_pass(counts);
        std::atomic<std::uint64_t> done = 0;
        expected.merge(trace_rect(*kernel, settings, expected.pass_rect(), 1, done, false,
                                  expected.samples_of(expected.pass_rect())));
        CHECK(framebuffer.samples() == counts);
        CHECK(test::same_sums(framebuffer, expected));
      }
      CHECK(teams[0]->built().seconds > 0);
    }
  }
}

}  // namespace parray
