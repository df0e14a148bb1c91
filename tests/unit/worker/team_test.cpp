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
#include "tests/support/small_traces.h"
#include "tests/support/window_rig.h"
#include "worker/cell_tracer.h"

namespace parray {
namespace {

using test::Dice;
using test::endless;
using test::eventually;
using test::plain_records;
using test::shared_scene;
using test::sized;
using test::small_scene;
using test::ThrowingTracer;
using test::traced;
using test::whole;
using test::without_times;

LeaseWork assignment(std::uint64_t epoch, const RenderSettings& settings) {
  return {7, epoch, whole(settings), settings, "the small scene", shared_scene()};
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

/// Puts the thread into a floating-point mode that a careless library might leave.
class OtherMode {
 public:
  OtherMode() { std::fesetround(FE_UPWARD); }
  ~OtherMode() { std::fesetround(FE_TONEAREST); }
  OtherMode& operator=(OtherMode&&) = delete;
  [[nodiscard]] static bool in_force() { return std::fegetround() == FE_UPWARD; }
};

}  // namespace

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
        return make_path_tracer(*lease.scene, lease.settings, threads);
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
        if (lease.scene_id == "poison") fail();
        if (lease.scene_id == "slow poison") return std::make_shared<const ThrowingTracer>(fail);
        return make_path_tracer(*lease.scene, lease.settings, threads);
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
      for (std::uint64_t spin = dice.below(3); spin > 0; --spin) std::this_thread::yield();
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
          if (taken.answer != LeaseSource::Answer::lease || (rank == 0 && lease > 2)) break;
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
