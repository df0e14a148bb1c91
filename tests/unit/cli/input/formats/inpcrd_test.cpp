#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_trajectories.h"

namespace parray {
namespace {

using test::ParticleFiles;

}  // namespace

TEST_CASE("AMBER restart files: positions, time and box") {
  const ParticleFiles files;
  const Particles particles = files.read("a.rst7", test::inpcrd());
  CHECK(particles.positions == std::vector<Vec3d>{{1, 2, 3}, {4, 5, 6}});
  CHECK(particles.facts.time == 15);
  REQUIRE(particles.cell);
  CHECK(particles.cell->edges[2].z == 30);
}

}  // namespace parray
