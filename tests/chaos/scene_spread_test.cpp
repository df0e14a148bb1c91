#include <doctest/doctest.h>

#include "tests/support/dice.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"
#include "tests/support/sim_spread.h"

namespace parray {
namespace {

using test::Faults;
using test::Honesty;
using test::SimSpread;

/// Returns a scene of about 60 chunks of SimSpread's size, which compress very little.
Scene dusty_scene() {
  Scene scene = test::small_scene();
  test::Dice dice(7);
  for (int i = 0; i < 2000; ++i) {
    Sphere sphere = scene.spheres.front();
    sphere.center = dice.in_cube(1);
    sphere.radius = 0.001 + dice.unit();
    scene.spheres.push_back(sphere);
  }
  return scene;
}

std::uint64_t packed_size(const Scene& scene) {
  SimSpread alone(scene, 1, {}, 1);
  REQUIRE(alone.run(seconds(10)));
  return alone.coordinator.sent_bytes();
}

const Faults lossy{0.1, 0.1, 0.1, milliseconds(20)};

}  // namespace

TEST_CASE("the coordinator sends a scene to two machines, for any number of workers") {
  const Scene scene = dusty_scene();
  const std::uint64_t once = packed_size(scene);
  for (const std::size_t workers : {2U, 8U, 40U, 150U}) {
    CAPTURE(workers);
    SimSpread spread(scene, workers, {}, 1);
    REQUIRE(spread.run(seconds(60)));
    CHECK(spread.coordinator.sent_bytes() <= 2 * once);
    CHECK(spread.coordinator.sent.size() <= 2);
    for (std::size_t i = 0; i < workers; ++i) {
      const auto& tally = spread.worker(i)->exchange.tally();
      CHECK(tally.from_coordinator + tally.from_workers == once);
      // A worker serves two other machines and at most two workers of its own machine.
      CHECK(tally.handed_on <= 4 * once);
    }
  }
}

TEST_CASE("time grows by the delay of a chunk, not of a scene, for each level of the tree") {
  const Scene scene = dusty_scene();
  const auto time_for = [&](std::size_t workers) {
    SimSpread spread(scene, workers, {0, 0, 0, milliseconds(10)}, 3);
    REQUIRE(spread.run(seconds(60)));
    return spread.network.now();
  };
  CHECK(time_for(100) < 3 * time_for(2));
}

TEST_CASE("every worker gets the scene on a network that loses, repeats, truncates and reorders") {
  const Scene scene = dusty_scene();
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    CAPTURE(seed);
    SimSpread spread(scene, 12, lossy, seed);
    CHECK(spread.run(seconds(600)));
    CHECK(spread.network.tally().dropped > 0);
  }
}

TEST_CASE("workers that die while they pass on a scene are replaced, and no worker begins again") {
  const Scene scene = dusty_scene();
  const std::uint64_t once = packed_size(scene);
  for (const bool noticed : {true, false}) {
    CAPTURE(noticed);
    SimSpread spread(scene, 20, {0, 0, 0, milliseconds(20)}, 5);
    int dead = 0;
    REQUIRE(spread.run(seconds(300), [&](SimSpread& s) {
      // First the root of the tree, then any worker.
      for (const std::size_t victim : {std::size_t{0}, std::size_t{3}, std::size_t{5}}) {
        const auto* worker = s.worker(victim);
        if (worker != nullptr &&
            worker->exchange.tally().from_coordinator + worker->exchange.tally().from_workers >
                once / 3) {
          noticed ? s.kill(victim) : s.stop(victim);
          ++dead;
        }
      }
    }));
    CHECK(dead == 3);
    for (std::size_t i = 0; i < 20; ++i) {
      if (const auto* worker = spread.worker(i)) {
        const auto& tally = worker->exchange.tally();
        CHECK(tally.from_coordinator + tally.from_workers == once);
      }
    }
  }
}

TEST_CASE("workers request damaged chunks again") {
  SimSpread spread(dusty_scene(), 3, {}, 1, {{0, Honesty::corrupting}});
  // The other worker of its machine gets nothing useful from it, and finally gets another source.
  CHECK(spread.run(seconds(300)));
}

TEST_CASE(
    "a worker that passes on false chunks is detected, and the others get the scene nevertheless") {
  const Scene scene = dusty_scene();
  for (const auto& faulty_workers :
       {std::map<std::size_t, Honesty>{{0, Honesty::lying}},
        std::map<std::size_t, Honesty>{{0, Honesty::lying}, {2, Honesty::lying}}}) {
    SimSpread spread(scene, 10, {}, 1, faulty_workers);
    REQUIRE(spread.run(seconds(300)));
    for (std::size_t i = 0; i < 10; ++i) {
      CHECK(spread.worker(i)->opened->scene->spheres.size() == scene.spheres.size());
    }
  }
}

}  // namespace parray
