#include <doctest/doctest.h>

#include "tests/support/dice.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"
#include "tests/support/sim_spread.h"

namespace parray {
namespace {

using test::Faults;
using test::Manner;
using test::SimSpread;

/// Some 60 chunks of the size that SimSpread cuts, hardly shorter when packed.
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

TEST_CASE("a scene leaves the coordinator for two machines, however many workers there are") {
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
      // To two machines, and to two workers of its own.
      CHECK(tally.handed_on <= 4 * once);
    }
  }
}

TEST_CASE("time grows by a chunk's way for each level of the tree, not by a scene's") {
  const Scene scene = dusty_scene();
  const auto time_for = [&](std::size_t workers) {
    SimSpread spread(scene, workers, {0, 0, 0, milliseconds(10)}, 3);
    REQUIRE(spread.run(seconds(60)));
    return spread.network.now();
  };
  CHECK(time_for(100) < 3 * time_for(2));
}

TEST_CASE("on a network that loses, repeats, cuts and reorders, everybody gets the scene") {
  const Scene scene = dusty_scene();
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    CAPTURE(seed);
    SimSpread spread(scene, 12, lossy, seed);
    CHECK(spread.run(seconds(600)));
    CHECK(spread.network.tally().dropped > 0);
  }
}

TEST_CASE("workers that die in the middle are replaced, and nobody begins anew") {
  const Scene scene = dusty_scene();
  const std::uint64_t once = packed_size(scene);
  for (const bool noticed : {true, false}) {
    CAPTURE(noticed);
    SimSpread spread(scene, 20, {0, 0, 0, milliseconds(20)}, 5);
    int dead = 0;
    REQUIRE(spread.run(seconds(300), [&](SimSpread& s) {
      // The first of all, then one that may be anywhere.
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

TEST_CASE("chunks that are damaged on their way are asked for again") {
  SimSpread spread(dusty_scene(), 3, {}, 1, {{0, Manner::corrupting}});
  // Its own machine's other worker gets nothing of use from it, and another source in the end.
  CHECK(spread.run(seconds(300)));
}

TEST_CASE("a worker that hands on other chunks is found out, and the scene comes all the same") {
  const Scene scene = dusty_scene();
  for (const auto& faulty_workers :
       {std::map<std::size_t, Manner>{{0, Manner::lying}},
        std::map<std::size_t, Manner>{{0, Manner::lying}, {2, Manner::lying}}}) {
    SimSpread spread(scene, 10, {}, 1, faulty_workers);
    REQUIRE(spread.run(seconds(300)));
    for (std::size_t i = 0; i < 10; ++i) {
      CHECK(spread.worker(i)->opened->scene->spheres.size() == scene.spheres.size());
    }
  }
}

}  // namespace parray
