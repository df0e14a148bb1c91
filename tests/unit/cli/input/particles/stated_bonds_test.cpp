#include "cli/input/particles/stated_bonds.h"

#include <doctest/doctest.h>

#include <vector>

#include "cli/input/particles/bonds.h"
#include "cli/input/particles/cell.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using Bonds = std::vector<StatedBond>;

Particles chain_of_four() {
  Particles particles;
  particles.positions = {{1, 5, 5}, {2, 5, 5}, {3, 5, 5}, {4, 5, 5}};
  particles.bonds = {{0, 1}, {1, 2}, {2, 3}};
  return particles;
}

/// Returns two particles in a cell of 10, bonded across the face of x.
Particles pair_across_face(double first, double second) {
  Particles particles;
  particles.positions = {{first, 5, 5}, {second, 5, 5}};
  particles.bonds = {{0, 1}};
  particles.cell = cell_from({10, 10, 10}, {90, 90, 90});
  return particles;
}

}  // namespace

TEST_CASE("bonds of removed particles disappear, and the others keep their particles") {
  Particles particles = chain_of_four();
  keep(particles, {1, 1, 0, 1});
  CHECK(particles.bonds == Bonds{{0, 1}});
  particles = chain_of_four();
  keep(particles, {0, 1, 1, 1});
  CHECK(particles.bonds == Bonds{{0, 1}, {1, 2}});
}

TEST_CASE("in replicas, a bond across a face leads to the next copy") {
  Particles particles = pair_across_face(1, 9.4);
  replicate(particles, {{3, 1, 1}});
  CHECK(particles.bonds == Bonds{{0, 5}, {1, 2}, {3, 4}});
  for (const DrawnBond& bond : drawn_bonds(particles, BondSource::file)) {
    CHECK(length(bond.delta) == doctest::Approx(1.6));
  }
  Particles block = pair_across_face(1, 2);
  replicate(block, {{2, 2, 2}});
  CHECK(block.bonds.size() == 8);
  for (const StatedBond& bond : block.bonds) CHECK(bond.second == bond.first + 1);
}

TEST_CASE("in replicas along an edge that is not periodic, bonds stay inside their copy") {
  Particles particles = pair_across_face(1, 9.4);
  particles.cell->periodic = {false, true, true};
  replicate(particles, {{2, 1, 1}});
  CHECK(particles.bonds == Bonds{{0, 1}, {2, 3}});
}

TEST_CASE("a copy on the opposite face takes over the bond across the face") {
  Particles particles = pair_across_face(0, 8.6);
  REQUIRE(add_boundary_copies(particles, {1e-3, 1e-3, 1e-3}) == 1);
  CHECK(particles.bonds == Bonds{{0, 1}, {1, 2}});
  const std::vector<DrawnBond> drawn = drawn_bonds(particles, BondSource::file);
  REQUIRE(drawn.size() == 1);
  CHECK(drawn[0].first == 1);
  CHECK(drawn[0].second == 2);
  CHECK(drawn[0].delta.x == doctest::Approx(1.4));
}

TEST_CASE("copies of two bonded particles bond to each other") {
  Particles particles = pair_across_face(0, 0);
  particles.positions[1].y = 6.4;
  REQUIRE(add_boundary_copies(particles, {1e-3, 1e-3, 1e-3}) == 2);
  const std::vector<DrawnBond> drawn = drawn_bonds(particles, BondSource::file);
  REQUIRE(drawn.size() == 2);
  CHECK(drawn[0].second == 1);
  CHECK(drawn[1].first == 2);
  CHECK(drawn[1].second == 3);
}

TEST_CASE("renumbered bonds join the same particles") {
  CHECK(renumbered({{0, 1}, {1, 2}}, {2, 0, 1}) == Bonds{{0, 2}, {1, 2}});
  CHECK(renumbered({{0, 1}, {1, 2}}, {1, 0}) == Bonds{{0, 1}});
}

}  // namespace parray
