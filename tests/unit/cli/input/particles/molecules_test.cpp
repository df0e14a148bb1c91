#include <doctest/doctest.h>

#include <cmath>
#include <string>
#include <utility>

#include "cli/input/particles/bonds.h"
#include "cli/input/particles/cell.h"
#include "cli/input/particles/cell_operations.h"
#include "common/base/error.h"
#include "tests/support/message_of.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_atoms.h"

namespace parray {
namespace {

using test::atoms_at;
using test::cubic_cell;
using test::message_of;

Particles atoms_in(const ParticleCell& cell, std::vector<Vec3d> positions,
                   std::vector<std::uint8_t> elements) {
  Particles particles = atoms_at(std::move(positions), std::move(elements));
  particles.cell = cell;
  return particles;
}

/// Returns the lengths of bonds, without the search.
std::size_t bonds_by_search(const Particles& particles, double longest) {
  const CellFractions fractions(*particles.cell);
  std::size_t found = 0;
  for (std::size_t i = 0; i < particles.count(); ++i) {
    for (std::size_t j = i; j < particles.count(); ++j) {
      for (int n = 0; n < 343; ++n) {
        const CellImage image{n % 7 - 3, n / 7 % 7 - 3, n / 49 - 3};
        if (i == j && n <= 171) continue;  // each image of an atom once, and not the atom
        const Vec3d d =
            particles.positions[j] + fractions.translation(image) - particles.positions[i];
        found += length(d) <= longest ? 1 : 0;
      }
    }
  }
  return found;
}

}  // namespace

TEST_CASE("bonds across faces are found once, whatever the cell's size and shape") {
  for (const ParticleCell& cell :
       {cubic_cell(20), cubic_cell(3.5), cubic_cell(2.2), *cell_from({4, 6, 9}, {65, 80, 100}),
        *cell_from({3, 3, 3}, {60, 60, 60})}) {
    CAPTURE(cell.edges[0].x);
    Particles carbon = atoms_in(cell, {}, {});
    for (int n = 0; n < 12; ++n) {
      carbon.positions.push_back(
          {std::sin(5 * n) * 12, std::sin(7 * n + 1) * 12, std::sin(11 * n + 2) * 12});
      carbon.elements.push_back(6);
    }
    Particles wrapped = carbon;
    wrap(wrapped);
    CHECK(covalent_bonds(carbon).size() == bonds_by_search(wrapped, 2 * 0.76 + 0.4));
    const CellFractions fractions(cell);
    for (const PeriodicBond& bond : covalent_bonds(carbon)) {
      const Vec3d d = carbon.positions[bond.to] + fractions.translation(bond.image) -
                      carbon.positions[bond.from];
      CHECK(length(d) <= 2 * 0.76 + 0.4);
    }
  }
}

TEST_CASE("hydrogens, ions and unknown elements do not bond where atoms of carbon would") {
  const auto bonds = [](std::uint8_t first, std::uint8_t second) {
    return covalent_bonds(atoms_in(cubic_cell(20), {{1, 1, 1}, {1.9, 1, 1}}, {first, second}))
        .size();
  };
  CHECK(bonds(6, 1) == 1);
  CHECK(bonds(1, 1) == 0);
  CHECK(bonds(11, 8) == 0);
  CHECK(bonds(0, 6) == 0);
  CHECK(bonds(26, 7) == 1);
}

TEST_CASE("no bond crosses a face that is not periodic") {
  Particles slab = atoms_in(cubic_cell(10), {{5, 5, 0.2}, {5, 5, 9.6}}, {6, 6});
  CHECK(covalent_bonds(slab).size() == 1);
  slab.cell->periodic = {true, true, false};
  CHECK(covalent_bonds(slab).empty());
}

TEST_CASE("lengths that cannot be in angstrom are refused") {
  const char* const refusal =
      "atoms are too close for bonds if lengths are in angstrom: correct the unit of positions "
      "and cell";
  CHECK(message_of<InputError>([] {
          (void)covalent_bonds(atoms_in(cubic_cell(0.1), {{0, 0, 0}}, {6}));
        }) == refusal);
  const Particles heap = atoms_in(cubic_cell(50), std::vector<Vec3d>(3000, {1, 1, 1}),
                                  std::vector<std::uint8_t>(3000, 6));
  CHECK(message_of<InputError>([&] { (void)covalent_bonds(heap); }) == refusal);
}

TEST_CASE("water that a corner breaks becomes whole beside its first atom") {
  Particles water = atoms_in(
      cubic_cell(10), {{9.8, 9.9, 0.1}, {0.6, 0.2, 9.9}, {9.5, 9.5, 0.9}, {5, 5, 5}}, {8, 1, 1, 8});
  const Molecules molecules = make_whole(water);
  CHECK(molecules.of == std::vector<std::uint32_t>{0, 0, 0, 1});
  CHECK(molecules.endless == 0);
  CHECK(water.positions[0] == Vec3d{9.8, 9.9, 0.1});
  CHECK(length(water.positions[1] - Vec3d{10.6, 10.2, -0.1}) < 1e-12);
  CHECK(water.positions[3] == Vec3d{5, 5, 5});
}

TEST_CASE("a long chain becomes whole although it is longer than half the cell") {
  Particles chain = atoms_in(cubic_cell(10), {}, {});
  for (int n = 0; n < 18; ++n) {
    chain.positions.push_back({std::fmod(1.4 * n, 10), std::fmod(0.5 * n, 10), 5});
    chain.elements.push_back(6);
  }
  (void)make_whole(chain);
  for (int n = 0; n < 18; ++n) {
    CHECK(length(chain.positions.at(static_cast<std::size_t>(n)) - Vec3d{1.4 * n, 0.5 * n, 5}) <
          1e-9);
  }
}

TEST_CASE("a network without end stays as it is, and its atoms are molecules of their own") {
  Particles diamond = atoms_in(cubic_cell(1.5), {{0.2, 0.2, 0.2}}, {6});
  const Molecules molecules = make_whole(diamond);
  CHECK(molecules.endless == 1);
  CHECK(diamond.positions[0] == Vec3d{0.2, 0.2, 0.2});
  Particles sheet = atoms_in(*cell_from({3, 3, 20}, {90, 90, 90}),
                             {{0, 0, 5}, {1.5, 0, 5}, {0, 1.5, 5}, {1.5, 1.5, 5}}, {6, 6, 6, 6});
  CHECK(make_whole(sheet).of == std::vector<std::uint32_t>{0, 1, 2, 3});
  CHECK(sheet.positions[3] == Vec3d{1.5, 1.5, 5});
}

TEST_CASE("without elements, molecules follow from numbers, in the order of ids") {
  Particles beads = atoms_in(cubic_cell(10), {{9, 5, 5}, {3, 5, 5}, {1, 5, 5}, {5, 5, 5}}, {});
  beads.numbers = {{"id", {1, 3, 2, 4}}, {"mol", {1, 1, 1, 2}}};
  CHECK(make_whole(beads).of == std::vector<std::uint32_t>{0, 0, 0, 1});
  CHECK(beads.positions == std::vector<Vec3d>{{9, 5, 5}, {13, 5, 5}, {11, 5, 5}, {5, 5, 5}});
}

TEST_CASE("without elements and molecules, residues are kept whole") {
  Particles beads = atoms_in(cubic_cell(10), {{9, 5, 5}, {1, 5, 5}, {1, 5, 5}}, {});
  beads.residue_numbers = {1, 1, 2};
  CHECK(make_whole(beads).of == std::vector<std::uint32_t>{0, 0, 1});
  CHECK(beads.positions == std::vector<Vec3d>{{9, 5, 5}, {11, 5, 5}, {1, 5, 5}});
}

TEST_CASE("particles without elements, molecules and residues cannot be made whole") {
  Particles points = atoms_in(cubic_cell(10), {{9, 5, 5}}, {});
  CHECK(message_of<InputError>([&] { (void)make_whole(points); }) ==
        "the file has no elements, no molecule numbers and no residue numbers: add a topology, or "
        "use \"wrap\" instead");
}

}  // namespace parray
