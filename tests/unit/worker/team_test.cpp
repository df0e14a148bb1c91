#include "worker/team.h"

#include <doctest/doctest.h>

#include <atomic>
#include <cfenv>
#include <chrono>
#include <cstring>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "common/math/float_mode.h"
#include "common/scene/settings.h"
#include "common/trace/isa.h"
#include "tests/support/dice.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"
#include "tests/support/window_rig.h"
#include "worker/cell_tracer.h"

namespace parray {
namespace {

using test::Dice;
using test::small_scene;

std::shared_ptr<const Scene> shared_scene() {
  static const auto scene = std::make_shared<const Scene>(small_scene());
  return scene;
}

RenderSettings sized(std::uint32_t width, std::uint32_t height, std::uint32_t spp) {
  RenderSettings settings = test::small_settings(*shared_scene());
  settings.width = width;
  settings.height = height;
  settings.samples_per_pixel = spp;
  return settings;
}

/// Hours of work, in cells of a fifth of a millisecond.
RenderSettings endless() { return sized(64, 64, 1U << 17); }

CellBatch whole(const RenderSettings& settings, std::uint32_t tile = 0) {
  const auto plan = test::whole_plan(settings, tile);
  return plan->batch({0, plan->cells()});
}

/// Traces cells without a team and checks the number of samples.
TracedCells traced(const PathTracer& tracer, const CellBatch& batch, int threads) {
  std::atomic<std::uint64_t> count = 0;
  TracedCells cells = trace_cells(tracer, batch, threads, count, false);
  CHECK(count == batch.sample_count());
  return cells;
}

std::vector<std::byte> without_times(const TracedCells& cells) {
  std::vector<std::byte> records = cells.records;
  const std::size_t size = records.size() / cells.range.count();
  for (std::size_t at = 0; at < records.size(); at += size) {
    std::memset(records.data() + at + offsetof(CellHeader, nanoseconds), 0, sizeof(std::uint64_t));
  }
  return records;
}

/// Returns the records that a tracer makes without a team, sample by sample.
std::vector<std::byte> plain_records(const RenderSettings& settings, const CellBatch& batch) {
  const FloatMode ieee;
  const auto tracer = make_path_tracer(*shared_scene(), settings);
  std::vector<std::byte> records;
  for (std::uint64_t index = batch.range.begin; index < batch.range.end; ++index) {
    const Cell cell = batch.grid->cell(index);
    const auto ranges = batch.ranges_of(index);
    std::vector<PixelSums> sums(batch.grid->shape().cell_pixels);
    TraceCounts counts;
    for (std::uint32_t i = 0; i < cell.pixels(); ++i) {
      for (std::uint32_t s = ranges[i].begin; s < ranges[i].end; ++s) {
        const std::uint32_t x = cell.x_begin + i;
        tracer->trace({cell.y, x, x + 1}, {s, s + 1}, {&sums[i], 1}, counts);
      }
    }
    const CellHeader header{counts.rays, counts.nonfinite, counts.lost, 0};
    const auto* const head = reinterpret_cast<const std::byte*>(&header);
    const auto pixels = std::as_bytes(std::span(sums));
    records.insert(records.end(), head, head + sizeof header);
    records.insert(records.end(), pixels.begin(), pixels.end());
  }
  return records;
}

/// Waits until `condition` is true. Returns false after a minute.
template <typename Condition>
bool eventually(Condition condition) {
  for (int i = 0; i < 60'000; ++i) {
    if (condition()) {
      return true;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

LeaseWork assignment(std::uint64_t epoch, const RenderSettings& settings) {
  return {7, 3, epoch, whole(settings), settings, "the small scene", shared_scene()};
}

/// Returns the team's result of a lease.
LeaseResult finished_by(ThreadTeam& team, LeaseWork lease) {
  team.start(std::move(lease));
  std::optional<LeaseResult> finished;
  REQUIRE(eventually([&] {
    finished = team.take();
    return finished.has_value();
  }));
  return std::move(*finished);
}

/// A tracer that throws at one pixel, in the thread that traces it.
class ThrowingTracer final : public PathTracer {
 public:
  explicit ThrowingTracer(std::function<void()> fail)
      : PathTracer(make_path_tracer(*shared_scene(), sized(6, 5, 4))->accelerator()),
        fail_(std::move(fail)) {}
  void trace_run(const PixelRun& run, const RunSamples& samples, std::span<PixelSums> sums,
                 TraceCounts& counts) const override {
    if (run.y == 5 && run.x_begin <= 3 && 3 < run.x_end) {
      fail_();
    }
    for (std::size_t i = 0; i < sums.size(); ++i) {
      counts.samples += samples[i].count();
    }
  }
  void first_hits(const PixelRun& /*run*/, const SampleRange& /*samples*/,
                  std::span<FirstHit> /*hits*/) const override {}
  void add_sky_samples(const PixelRun& /*run*/, const RunSamples& /*samples*/,
                       std::span<SkySamples> /*sky*/) const override {}

 private:
  std::function<void()> fail_;
};

/// Puts the thread into a floating-point mode that a careless library might leave.
class OtherMode {
 public:
  OtherMode() { std::fesetround(FE_UPWARD); }
  ~OtherMode() { std::fesetround(FE_TONEAREST); }
  OtherMode(const OtherMode&) = delete;
  OtherMode& operator=(const OtherMode&) = delete;
  [[nodiscard]] static bool in_force() { return std::fegetround() == FE_UPWARD; }
};

}  // namespace

TEST_CASE("cells have the bits of single samples, whatever the threads, tiles and ranges") {
  Dice dice(1);
  for (const auto& settings :
       {sized(20, 13, 6), sized(3, 2, 5000), sized(500, 4, 9), sized(1, 1, 20'000)}) {
    const auto tracer = make_path_tracer(*shared_scene(), settings);
    for (const std::uint32_t tile : {0U, 4U}) {
      const auto plan = test::whole_plan(settings, tile);
      const std::uint64_t begin = dice.below(plan->cells());
      const CellRange part{begin, begin + 1 + dice.below(plan->cells() - begin)};
      for (const CellRange& range : {CellRange{0, plan->cells()}, part}) {
        const CellBatch batch = plan->batch(range);
        const auto expected = plain_records(settings, batch);
        for (const int threads : {1, 2, 3, 8}) {
          CAPTURE(threads);
          CAPTURE(tile);
          const TracedCells cells = traced(*tracer, batch, threads);
          CHECK(cells.range == range);
          CHECK(without_times(cells) == expected);
          CHECK(cells.samples == batch.sample_count());
          CHECK(fault_of(cells, batch, settings.max_depth).empty());
        }
      }
    }
  }
}

TEST_CASE("pixels with their own sample ranges get exactly these samples") {
  Dice dice(2);
  for (const auto& settings : {sized(33, 21, 50), sized(200, 3, 5), sized(2, 2, 4000)}) {
    const auto tracer = make_path_tracer(*shared_scene(), settings);
    const std::vector<std::uint32_t> before(std::size_t{settings.width} * settings.height, 6);
    const auto ranges = test::ragged_ranges(dice, before, settings.samples_per_pixel);
    const WorkPlan plan(settings, {{{6, 6 + settings.samples_per_pixel}}, ranges});
    const CellBatch batch = plan.batch({0, plan.cells()});
    for (const int threads : {1, 2}) {
      CHECK(without_times(traced(*tracer, batch, threads)) == plain_records(settings, batch));
    }
  }
}

TEST_CASE("records contain the time that their cells took") {
  const RenderSettings settings = sized(20, 20, 100);
  const CellBatch batch = whole(settings);
  const TracedCells cells = traced(*make_path_tracer(*shared_scene(), settings), batch, 1);
  double nanoseconds = 0;
  const std::size_t size = record_bytes(batch.grid->shape().cell_pixels);
  for (std::size_t at = 0; at < cells.records.size(); at += size) {
    const CellHeader header = header_of(std::span(cells.records).subspan(at));
    CHECK(header.nanoseconds > 0);
    nanoseconds += static_cast<double>(header.nanoseconds);
  }
  CHECK(nanoseconds <= 1e9 * cells.seconds);
}

TEST_CASE("the floating-point mode of the calling thread does not change a sample's bits") {
  const RenderSettings settings = sized(20, 13, 6);
  const auto expected = plain_records(settings, whole(settings));
  const auto tracer = make_path_tracer(*shared_scene(), settings);
  const OtherMode mode;  // from here on, every division rounds up
  SUBCASE("of whoever calls trace_cells") {
    for (const int threads : {1, 2}) {
      CHECK(without_times(traced(*tracer, whole(settings), threads)) == expected);
    }
    CHECK(OtherMode::in_force());  // tracing has restored the mode
  }
  SUBCASE("of whoever makes a team, which builds too") {
    ThreadTeam team(2);
    CHECK(without_times(*finished_by(team, assignment(1, settings)).cells) == expected);
  }
}

TEST_CASE("a long lease returns its first cells, with the same bits") {
  const RenderSettings settings = sized(64, 64, 1024);
  const auto tracer = make_path_tracer(*shared_scene(), settings);
  const CellBatch batch = whole(settings);
  for (const int threads : {1, 2, 3}) {
    std::atomic<std::uint64_t> count = 0;
    const TracedCells part = trace_cells(*tracer, batch, threads, count, false, 1e-3);
    REQUIRE(part.range.begin == batch.range.begin);
    REQUIRE(part.range.count() > 0);
    REQUIRE(part.range.end < batch.range.end);
    const CellBatch first{batch.grid, part.range, {}};
    CHECK(part.samples == first.sample_count());
    CHECK(part.samples <= count);
    CHECK(without_times(part) == without_times(traced(*tracer, first, threads)));
    CHECK(fault_of(part, first, settings.max_depth).empty());
  }
}

TEST_CASE("a lease without time traces one piece") {
  const RenderSettings settings = sized(64, 64, 4);
  const auto tracer = make_path_tracer(*shared_scene(), settings);
  const CellBatch batch = whole(settings);
  std::atomic<std::uint64_t> count = 0;
  const TracedCells part = trace_cells(*tracer, batch, 1, count, false, 1e-12);
  CHECK(part.range.count() == batch.grid->shape().piece_cells);
}

TEST_CASE("a stop ends tracing early") {
  const auto tracer = make_path_tracer(*shared_scene(), endless());
  const auto plan = test::whole_plan(endless());
  const CellBatch batch = plan->batch({0, 10'000});
  std::atomic<std::uint64_t> count = 0;
  std::atomic<bool> stop = true;
  CHECK(trace_cells(*tracer, batch, 2, count, stop).samples == 0);
  CHECK(count == 0);
  stop = false;
  std::thread stopper([&] {
    eventually([&] { return count > 0; });
    stop = true;
  });
  const TracedCells cells = trace_cells(*tracer, batch, 2, count, stop);
  stopper.join();
  CHECK(cells.samples == count);
  CHECK(count > 0);
  CHECK(count < batch.sample_count());
}

TEST_CASE("an exception of a thread stops the others and reaches the caller unchanged") {
  const CellBatch batch = whole(endless());
  const ThrowingTracer tracer([] { throw std::runtime_error("a broken sphere"); });
  for (const int threads : {1, 2, 4}) {
    std::atomic<std::uint64_t> count = 0;
    CHECK_THROWS_WITH_AS(trace_cells(tracer, batch, threads, count, false), "a broken sphere",
                         std::runtime_error);
    CHECK(count < batch.sample_count());
  }
}

TEST_CASE("a team traces a lease, calls on_finished, and returns the result once") {
  std::atomic<int> rung = 0;
  ThreadTeam team(2, [&] { ++rung; });
  CHECK(team.idle());
  CHECK_FALSE(team.take());
  const RenderSettings settings = sized(20, 13, 6);
  team.start(assignment(42, settings));
  CHECK_FALSE(team.idle());
  REQUIRE(eventually([&] { return rung == 1; }));
  CHECK_FALSE(team.idle());  // until the result is taken
  const auto finished = team.take();
  REQUIRE(finished);
  CHECK(finished->key() == LeaseKey{7, 42});
  CHECK(finished->pass == 3);
  CHECK(finished->failure.empty());
  REQUIRE(finished->cells);
  CHECK(without_times(*finished->cells) == plain_records(settings, whole(settings)));
  CHECK(finished->grid->shape() == whole(settings).grid->shape());
  CHECK(finished->isa == name_of(best_isa()));
  CHECK(finished->accelerator_bytes > 0);
  CHECK(finished->build_seconds > 0);
  CHECK(team.traced() == 20 * 13 * 6);
  CHECK(team.idle());
  CHECK_FALSE(team.preparing());
  CHECK_FALSE(team.take());
}

TEST_CASE("a team changes scenes and settings, and builds accelerators only if necessary") {
  int built = 0;
  ThreadTeam team(
      1, [] {}, std::make_shared<AcceleratorCache>(),
      [&](const LeaseWork& lease, int threads) {
        ++built;
        return make_path_tracer(*lease.scene, lease.settings, {threads});
      });
  Scene dark = *shared_scene();
  dark.sky = {{0, 0, 0}, {0, 0, 0}};
  const auto dark_scene = std::make_shared<const Scene>(dark);
  for (const RenderSettings& settings : {sized(8, 4, 2), sized(4, 8, 2)}) {
    for (const bool is_dark : {false, true, false, false}) {
      LeaseWork next = assignment(1, settings);
      next.settings->samples_per_pixel += is_dark ? 0 : 5;  // does not change the bits of a sample
      if (is_dark) {
        next.scene = dark_scene;
        next.scene_id = "dark";
      }
      const LeaseResult finished = finished_by(team, next);
      REQUIRE(finished.cells);
      CHECK((without_times(*finished.cells) == plain_records(settings, next.cells)) == !is_dark);
    }
  }
  CHECK(built == 6);
}

TEST_CASE("a scene may be released once the team has its tracer") {
  ThreadTeam team(1);
  LeaseWork lease = assignment(1, sized(6, 5, 4));
  REQUIRE(finished_by(team, lease).cells);
  lease.scene.reset();
  CHECK(finished_by(team, lease).cells);
  lease.scene_id = "another";
  const LeaseResult failed = finished_by(team, lease);
  CHECK_FALSE(failed.cells);
  CHECK(failed.failure == "a lease without its scene");
}

TEST_CASE("only a lease that cannot be traced fails, and the team continues") {
  std::function<void()> fail;
  int built = 0;
  ThreadTeam team(
      2, [] {}, std::make_shared<AcceleratorCache>(),
      [&](const LeaseWork& lease, int threads) -> std::shared_ptr<const PathTracer> {
        ++built;
        if (lease.scene_id == "poison") {
          fail();
        }
        if (lease.scene_id == "slow poison") {
          return std::make_shared<const ThrowingTracer>(fail);
        }
        return make_path_tracer(*lease.scene, lease.settings, {threads});
      });
  const RenderSettings settings = sized(20, 13, 6);
  const auto expected = plain_records(settings, whole(settings));
  std::string reason;
  SUBCASE("an exception") {
    fail = [] { throw std::runtime_error("a broken\nsphere"); };
    reason = "a broken\\x0asphere";  // one printable line
  }
  SUBCASE("too little memory") {
    fail = [] { throw std::bad_alloc(); };
    reason = "not enough memory";
  }
  for (const char* scene :
       {"poison", "slow poison"}) {  // fails while building, fails in a tracing thread
    CHECK(finished_by(team, assignment(1, settings)).cells);
    LeaseWork bad = assignment(2, settings);
    bad.scene_id = scene;
    for (int i = 0; i < 2; ++i) {
      const LeaseResult failed = finished_by(team, bad);
      CHECK(failed.key() == LeaseKey{7, 2});
      CHECK_FALSE(failed.cells);
      CHECK(failed.failure == reason);
      CHECK(team.idle());
      CHECK_FALSE(team.preparing());
    }
    const LeaseResult good = finished_by(team, assignment(3, settings));
    REQUIRE(good.cells);
    CHECK(without_times(*good.cells) == expected);
  }
  CHECK(built == 7);  // a failed tracer is never used again
}

// Sanitizers end a program that requests more memory than possible.
TEST_CASE("only a lease larger than any memory fails" * doctest::skip(PARRAY_SANITIZED)) {
  ThreadTeam team(1);
  LeaseWork large = assignment(1, sized(20, 13, 6));
  large.cells.range.end = std::uint64_t{1} << 50;
  const LeaseResult failed = finished_by(team, large);
  CHECK_FALSE(failed.cells);
  CHECK_FALSE(failed.failure.empty());
  CHECK(finished_by(team, assignment(2, sized(20, 13, 6))).cells);
}

TEST_CASE("an abandoned lease has no result, and the team traces the next one") {
  ThreadTeam team(2);
  team.abandon();  // an idle team: no harm
  CHECK(team.idle());
  team.start(assignment(1, endless()));
  SUBCASE("at once") {}
  SUBCASE("while it traces") {
    REQUIRE(eventually([&] { return team.traced() > 0; }));
  }
  team.abandon();
  REQUIRE(eventually([&] { return team.idle(); }));
  CHECK_FALSE(team.take());
  const std::uint64_t before = team.traced();
  const RenderSettings settings = sized(6, 5, 4);
  const LeaseResult finished = finished_by(team, assignment(2, settings));
  CHECK(finished.epoch == 2);
  CHECK(without_times(*finished.cells) == plain_records(settings, whole(settings)));
  CHECK(team.traced() == before + 120);
  team.start(assignment(3, settings));
  team.wait(seconds(60));
  team.abandon();  // the result is dropped
  CHECK(team.idle());
  CHECK_FALSE(team.take());
}

TEST_CASE("leases started, abandoned and taken in any order neither hang nor mix") {
  ThreadTeam team(2);
  const RenderSettings settings = sized(20, 13, 6);
  const auto expected = plain_records(settings, whole(settings));
  Dice dice(2);
  int taken = 0;
  for (std::uint64_t epoch = 1; epoch <= 300; ++epoch) {
    REQUIRE(eventually([&] { return team.idle(); }));
    if (dice.one_in(2)) {
      team.start(assignment(epoch, settings));
      for (std::uint64_t spin = dice.below(3); spin > 0; --spin) {
        std::this_thread::yield();
      }
      team.abandon();
      continue;
    }
    const LeaseResult finished = finished_by(team, assignment(epoch, settings));
    REQUIRE(finished.epoch == epoch);
    REQUIRE(without_times(*finished.cells) == expected);
    ++taken;
  }
  CHECK(taken > 100);
  CHECK(taken < 200);
}

TEST_CASE("a team that is destroyed while it traces stops") {
  std::atomic<int> rung = 0;
  {
    ThreadTeam team(2, [&] { ++rung; });
    team.start(assignment(1, endless()));
    REQUIRE(eventually([&] { return team.traced() > 0; }));
  }
  CHECK(rung <= 1);
}

TEST_CASE("teams over a window make the picture of one thread, for all policies and tiles") {
  RenderSettings settings = sized(33, 21, 100);
  for (const auto policy : {SchedulePolicy::static_split, SchedulePolicy::weighted}) {
    for (const std::uint32_t tile : {0U, 6U}) {
      settings.schedule = policy;
      test::WindowRig rig(settings, 3, tile);
      for (std::uint32_t rank = 0; rank < 2; ++rank) {
        WindowSource source = rig.source({policy, rank, 1, 2, {}});
        rig.job.scene = shared_scene();
        ThreadTeam team(1);
        for (int lease = 0;; ++lease) {
          auto taken = source.take(Time(0), lease == 0 ? 0 : 1e6, false);
          if (taken.answer != LeaseSource::Answer::lease || (rank == 0 && lease > 2)) {
            break;
          }
          source.complete(Time(0), finished_by(team, std::move(taken.lease)));
          CHECK_FALSE(rig.job.scene);
        }
      }
      // A third rank gets the dropped leases as copies.
      WindowSource third = rig.source({policy, 2, 1, 2, {}});
      for (Time now{}; !rig.collector.done() && now < seconds(60); now += milliseconds(60)) {
        rig.collect(now);
        rig.window.fetch_add(WindowLayout::copy_requests, 1);
        const std::uint64_t before = rig.window.load(WindowLayout::copies);
        rig.collector.issue_copies(now);
        const auto tracer = make_path_tracer(*shared_scene(), settings);
        for (std::uint64_t i = before; i < rig.window.load(WindowLayout::copies); ++i) {
          const CellRange copy = range_from_word(rig.window.load(rig.layout.copy_word(i)));
          third.put(copy, traced(*tracer, rig.plan().batch(copy), 1).records);
        }
      }
      REQUIRE(rig.collector.done());
      CHECK(
          image_sha256(resolve_image(rig.picture.framebuffer(), largest_radiance(small_scene()))) ==
          test::reference_sha256(small_scene(), settings));
    }
  }
}

}  // namespace parray
