#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "cli/input/particles/bonds.h"
#include "cli/input/particles/cell.h"
#include "tests/support/molecule_files.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_atoms.h"

namespace parray {
namespace {

using test::atoms_at;
using test::cubic_cell;

using Pairs = std::set<std::pair<std::uint32_t, std::uint32_t>>;

Particles shipped(const std::string& name) {
  return read_particles(std::string(PARRAY_SOURCE_DIR) + "/scenes/particles/" + name);
}

std::size_t count_of(const Particles& particles, BondSource source = BondSource::automatic) {
  return drawn_bonds(particles, source).size();
}

Pairs pairs_of(const Particles& particles) {
  Pairs pairs;
  for (const DrawnBond& bond : drawn_bonds(particles, BondSource::automatic)) {
    pairs.emplace(bond.first, bond.second);
  }
  return pairs;
}

/// Sets names of atoms and residues, one residue per atom.
void name_atoms(Particles& particles, const std::vector<std::string>& residues,
                const std::vector<std::string>& names) {
  for (std::uint32_t i = 0; i < particles.count(); ++i) {
    particles.residue_names.names.push_back(residues[i]);
    particles.residue_names.index.push_back(i);
    particles.atom_names.names.push_back(names[i]);
    particles.atom_names.index.push_back(i);
    particles.residue_numbers.push_back(static_cast<std::int32_t>(i));
  }
}

/// Returns 27 molecules of water in a box whose faces break some of them.
Particles water_box() {
  Particles water;
  std::int32_t molecule = 0;
  water.residue_names.names = {"SOL"};
  for (int n = 0; n < 27; ++n, ++molecule) {
    const Vec3d oxygen{3.1 * (n % 3), 3.1 * (n / 3 % 3), 3.1 * (n / 9)};
    for (const Vec3d& step : {Vec3d{}, Vec3d{0.757, 0.586, 0}, Vec3d{-0.757, 0.586, 0}}) {
      water.positions.push_back(oxygen + step);
      water.elements.push_back(step == Vec3d{} ? 8 : 1);
      water.residue_numbers.push_back(molecule);
      water.residue_names.index.push_back(0);
    }
  }
  water.cell = cubic_cell(9.3);
  wrap(water);
  return water;
}

}  // namespace

TEST_CASE("caffeine has 25 bonds, and each atom has its valence of neighbours") {
  const Particles caffeine = shipped("caffeine.xyz");
  CHECK(count_of(caffeine) == 25);
  CHECK(count_of(caffeine, BondSource::file) == 0);
  CHECK(count_of(caffeine, BondSource::off) == 0);
  std::vector<int> neighbours(caffeine.count());
  for (const auto& [first, second] : pairs_of(caffeine)) {
    ++neighbours[first];
    ++neighbours[second];
  }
  for (std::size_t i = 0; i < caffeine.count(); ++i) {
    const std::uint8_t element = caffeine.elements[i];
    if (element == 1 || element == 8) CHECK(neighbours[i] == 1);
    if (element == 7) CHECK((neighbours[i] == 2 || neighbours[i] == 3));
    if (element == 6) CHECK((neighbours[i] == 3 || neighbours[i] == 4));
  }
}

TEST_CASE("a helix of twelve residues has the bonds of its residues and eleven peptide bonds") {
  const Particles helix = shipped("helix.pdb");
  CHECK(count_of(helix) == 64);  // 65 atoms without rings, and water without hydrogen
  Particles dipeptide = helix;
  ParticleMask mask(helix.count(), 0);
  std::fill_n(mask.begin(), 11, std::uint8_t{1});
  keep(dipeptide, mask);
  CHECK(pairs_of(dipeptide) ==
        Pairs{{0, 1}, {1, 2}, {1, 4}, {2, 3}, {2, 5}, {5, 6}, {6, 7}, {6, 9}, {7, 8}, {9, 10}});
}

TEST_CASE("shuffled atoms have the same bonds") {
  for (const char* name : {"caffeine.xyz", "helix.pdb"}) {
    const Particles molecule = shipped(name);
    std::vector<std::size_t> order(molecule.count());
    std::iota(order.begin(), order.end(), std::size_t{0});
    for (std::size_t i = 0; i < order.size(); ++i) {
      std::swap(order[i], order[(i * 7919 + 13) % order.size()]);
    }
    Particles shuffled = molecule;
    append_copies(shuffled, order);
    ParticleMask copies(shuffled.count(), 0);
    std::fill(copies.begin() + static_cast<std::ptrdiff_t>(order.size()), copies.end(),
              std::uint8_t{1});
    keep(shuffled, copies);
    Pairs found;
    for (const auto& [first, second] : pairs_of(shuffled)) {
      found.emplace(std::minmax(static_cast<std::uint32_t>(order[first]),
                                static_cast<std::uint32_t>(order[second])));
    }
    CHECK(found == pairs_of(molecule));
  }
}

TEST_CASE("water molecules have two bonds each, across faces and despite close neighbours") {
  Particles water = water_box();
  CHECK(count_of(water) == 54);
  for (const DrawnBond& bond : drawn_bonds(water, BondSource::automatic)) {
    CHECK(length(bond.delta) == doctest::Approx(0.957).epsilon(0.001));
  }
  for (std::size_t i = 3; i < 6; ++i) water.positions[i] = water.positions[i] - Vec3d{1.5, 0, 0};
  CHECK(count_of(water) == 54);
}

TEST_CASE("rock salt has no bonds") {
  Particles salt;
  for (int n = 0; n < 8; ++n) {
    salt.positions.push_back({2.82 * (n % 2), 2.82 * (n / 2 % 2), 2.82 * (n / 4)});
    salt.elements.push_back((n % 2 + n / 2 % 2 + n / 4) % 2 == 0 ? 11 : 17);
  }
  salt.cell = cubic_cell(5.64);
  CHECK(count_of(salt) == 0);
  CHECK(add_boundary_copies(salt, {1e-3, 1e-3, 1e-3}) > 0);
  CHECK(count_of(salt) == 0);
}

TEST_CASE("metals bond to each other unless they bond to a nonmetal") {
  const std::vector<Vec3d> bridge{{0, 0, 0}, {1.5, 1.9, 0}, {3, 0, 0}};
  CHECK(pairs_of(atoms_at(bridge, {42, 16, 42})) == Pairs{{0, 1}, {1, 2}});
  CHECK(pairs_of(atoms_at(bridge, {42, 42, 42})) == Pairs{{0, 1}, {0, 2}, {1, 2}});
}

TEST_CASE("a chain across a face has a bond whose vector leads to the nearest image") {
  Particles chain;
  for (int n = 0; n < 8; ++n) {
    chain.positions.push_back({0.5 + 1.25 * n, 5, 5});
    chain.elements.push_back(6);
  }
  chain.cell = cubic_cell(10);
  const std::vector<DrawnBond> bonds = drawn_bonds(chain, BondSource::automatic);
  CHECK(bonds.size() == 8);
  CHECK(std::ranges::count_if(bonds, [](const DrawnBond& bond) {
          return length(bond.delta - Vec3d{-1.25, 0, 0}) < 1e-9 && bond.first == 0 &&
                 bond.second == 7;
        }) == 1);
  chain.cell.reset();
  CHECK(count_of(chain) == 7);
}

TEST_CASE("an atom may bond to its own image and, with two images, twice to another atom") {
  Particles wire = atoms_at({{1, 5, 5}}, {6});
  wire.cell = *cell_from({1.5, 10, 10}, {90, 90, 90});
  const std::vector<DrawnBond> own = drawn_bonds(wire, BondSource::automatic);
  REQUIRE(own.size() == 1);
  CHECK(own[0].first == own[0].second);
  CHECK(length(own[0].delta) == doctest::Approx(1.5));
  Particles two = atoms_at({{0, 5, 5}, {1.5, 5, 5}}, {6, 6});
  two.cell = *cell_from({3, 10, 10}, {90, 90, 90});
  CHECK(count_of(two) == 2);
  CHECK(pairs_of(two).size() == 1);
  REQUIRE(add_boundary_copies(two, {1e-3, 1e-3, 1e-3}) == 1);
  CHECK(pairs_of(two) == Pairs{{0, 1}, {1, 2}});
  CHECK(count_of(two) == 2);
}

TEST_CASE("stated bonds decide which atoms of a residue bond, and other atoms bond by distance") {
  Particles ring = atoms_at({{0, 0, 0}, {1.5, 0, 0}, {0.75, 1.3, 0}, {0, -1.4, 0}}, {6, 6, 6, 6});
  CHECK(count_of(ring) == 4);
  ring.bonds = {{0, 1}, {1, 2}};
  CHECK(pairs_of(ring) == Pairs{{0, 1}, {0, 3}, {1, 2}});
  ring.all_bonds = true;
  CHECK(pairs_of(ring) == Pairs{{0, 1}, {1, 2}});
}

TEST_CASE("residues of polymers bond only by their links, and water to no other residue") {
  const auto bonds = [](const std::string& first, const std::string& second, const std::string& one,
                        const std::string& other, std::uint8_t element) {
    Particles pair = atoms_at({{0, 0, 0}, {1.4, 0, 0}}, {element, 6});
    name_atoms(pair, {first, second}, {one, other});
    return count_of(pair);
  };
  CHECK(bonds("ALA", "GLY", "N", "C", 7) == 1);
  CHECK(bonds("ALA", "GLY", "CB", "CA", 6) == 0);
  CHECK(bonds("DA", "DG", "P", "O3'", 15) == 1);
  CHECK(bonds("CYS", "CYS", "SG", "SG", 16) == 1);
  CHECK(bonds("ALA", "HOH", "CB", "O", 6) == 0);
  CHECK(bonds("LIG", "HOH", "C1", "O", 6) == 0);
  CHECK(bonds("ALA", "LIG", "CB", "C1", 6) == 1);
  CHECK(bonds("ALA", "ALA", "OXT", "CA", 8) == 0);
}

TEST_CASE("a ligand with stated bonds does not bond to residues that only come close") {
  Particles pair = atoms_at({{0, 0, 0}, {1.4, 0, 0}, {-1.4, 0, 0}}, {6, 6, 6});
  name_atoms(pair, {"LIG", "LIG", "ALA"}, {"C1", "C2", "CB"});
  CHECK(count_of(pair) == 2);
  pair.bonds = {{0, 1}};
  CHECK(pairs_of(pair) == Pairs{{0, 1}});
}

TEST_CASE("a chain has its links to a modified residue whose other bonds are stated") {
  Particles chain = atoms_at({{0, 0, 0}, {1.6, 0, 0}, {3.1, 0, 0}}, {8, 15, 8});
  name_atoms(chain, {"DA", "TAF", "TAF"}, {"O3'", "P", "O5'"});
  chain.residue_numbers = {1, 2, 2};
  chain.bonds = {{1, 2}};
  CHECK(pairs_of(chain) == Pairs{{0, 1}, {1, 2}});
  chain.bonds = {{0, 1}, {1, 2}};
  CHECK(count_of(chain) == 2);  // each once
}

TEST_CASE("atoms of different alternative locations do not bond, nor do atoms at one place") {
  Particles atoms = atoms_at({{0, 0, 0}, {1.5, 0, 0}, {1.5, 0.9, 0}}, {6, 6, 6});
  atoms.alternatives = {' ', 'A', 'B'};
  CHECK(pairs_of(atoms) == Pairs{{0, 1}, {0, 2}});
  const Particles shared =
      atoms_at({{0, 0, 0}, {1.5, 0, 0}, {1.5, 0.01, 0}, {8, 0, 0}, {9.5, 0, 0}}, {6, 6, 6, 6, 6});
  CHECK(pairs_of(shared) == Pairs{{0, 1}, {0, 2}, {3, 4}});
}

TEST_CASE("bonds that keep water rigid are not drawn, but the molecule of hydrogen is") {
  Particles water = atoms_at(
      {{0, 0, 0}, {0.757, 0.586, 0}, {-0.757, 0.586, 0}, {9, 0, 0}, {9.74, 0, 0}}, {8, 1, 1, 1, 1});
  water.bonds = {{0, 1}, {0, 2}, {1, 2}, {3, 4}};
  water.all_bonds = true;
  CHECK(pairs_of(water) == Pairs{{0, 1}, {0, 2}, {3, 4}});
  CHECK(count_of(water, BondSource::file) == 4);
}

TEST_CASE("files in other units have the same bonds if they state the unit") {
  Particles caffeine = shipped("caffeine.xyz");
  for (Vec3d& position : caffeine.positions) position = 0.1 * position;
  CHECK(test::message_of<InputError>([&] { (void)count_of(caffeine); }) ==
        "atoms are too close for bonds if lengths are in angstrom: correct the unit of positions "
        "and cell");
  caffeine.facts.length_unit = "nm";
  CHECK(count_of(caffeine) == 25);
  for (Vec3d& position : caffeine.positions) position = 0.1 * position;
  CHECK(test::message_of<InputError>([&] {
          (void)count_of(caffeine);
        }).starts_with("atoms are too close for bonds if lengths are in nm: "));
}

TEST_CASE("particles without elements have only the bonds of the file, in any unit") {
  Particles beads = atoms_at({{0, 0, 0}, {0.01, 0, 0}, {0.02, 0, 0}}, {});
  CHECK(count_of(beads) == 0);
  beads.bonds = {{0, 1}, {1, 2}};
  CHECK(pairs_of(beads) == Pairs{{0, 1}, {1, 2}});
}

}  // namespace parray
