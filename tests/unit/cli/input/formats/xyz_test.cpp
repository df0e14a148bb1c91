#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "cli/output/picture/srgb.h"
#include "tests/support/molecule_files.h"
#include "tests/support/particle_columns.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"
#include "tests/support/three_particles.h"

namespace parray {
namespace {

using test::Elements;
using test::everything;
using test::has_note;
using test::Names;
using test::names_of;
using test::numbers_of;
using test::packed;
using test::ParticleFiles;
using test::three_positions;
using test::types_of;

}  // namespace

TEST_CASE("XYZ is read: symbols, atomic numbers, other names, further columns, first frame") {
  const ParticleFiles files;
  const std::string text =
      "4\na comment, Lattice or not\nC 1 -2 3.5 0.1 word\n 8\t0 0.25 -1e3\nOW -0.125 7 0\nd 0 0 0\n"
      "1\nsecond frame\nC 9 9 9\n";
  for (const std::string& file : {text, packed(text)}) {
    const Particles particles = files.read("a.xyz", file);
    CHECK(particles.positions ==
          std::vector<Vec3d>{
              three_positions()[0], three_positions()[1], three_positions()[2], {0, 0, 0}});
    CHECK(particles.elements == Elements{6, 8, 0, 1});
    CHECK(types_of(particles) == Names{"C", "8", "OW", "d"});
  }
  CHECK(test::note(files.read("b.xyz", "3\n\nXx 0 0 0\nC 1 1 1\nQ 2 0 0"), "unknown_elements") ==
        2);
  const Particles beads = files.read("a.xyz", "2\n\nA1 0 0 0\nB1 1 1 1");
  CHECK(test::note(beads, "unknown_elements") == 0);  // these are types
  CHECK(beads.elements.empty());                      // names of types, none of them an element
  CHECK(beads.types.names == Names{"A1", "B1"});
}

TEST_CASE("extended XYZ is read by its Properties") {
  const ParticleFiles files;
  const Particles particles = files.read(
      "a.extxyz",
      "2\nLattice=\"5 0 0 0 5 0 0 0 5\" Properties=id:I:1:pos:R:3:species:S:1:force:R:3:radius:R:1:"
      "color:R:3:fixed:L:1 pbc=\"T T F\"\n1 1 -2 3.5 Si 0 0 0 0.5 1 0.25 0 T\n"
      "2 0 0.25 -1e3 Zz 0 0 0 0.75 0 0 1 F\n");
  CHECK(particles.positions == std::vector<Vec3d>{three_positions()[0], three_positions()[1]});
  CHECK(particles.elements == Elements{14, 0});
  CHECK(types_of(particles) == Names{"Si", "Zz"});
  CHECK(particles.radii == std::vector<double>{0.5, 0.75});
  CHECK(particles.colors == std::vector<Vec3d>{{1, 0.25, 0}, {0, 0, 1}});
  const Particles bytes = files.read(
      "b.xyz", "1\nmyproperties=1 properties=\"pos:R:3:color:I:3\"\r\n1 2 3 255 0 128\r\n");
  CHECK(bytes.colors == std::vector<Vec3d>{{1, 0, srgb_decode(128.0 / 255)}});
  CHECK(bytes.types.empty());
}

TEST_CASE("XYZ of LAMMPS has numbers of types instead of elements") {
  const ParticleFiles files;
  const Particles dumped = files.read("a.xyz", "2\nAtoms. Timestep: 500\n3 0 0 0\n1 1 0 0\n");
  CHECK(dumped.elements.empty());
  CHECK(dumped.types.names == std::vector<std::string>{"3", "1"});
  CHECK(dumped.facts.time == 500);
  CHECK(has_note(dumped, "numbers_as_types"));
  const Particles counted = files.read("a.xyz", "3\n\n2 0 0 0\n1 1 0 0\n3 2 0 0\n");
  CHECK(counted.elements.empty());
  const Particles water = files.read("a.xyz", "3\n\n8 0 0 0\n1 1 0 0\n1 2 0 0\n");
  CHECK(water.elements == std::vector<std::uint8_t>{8, 1, 1});
  CHECK_FALSE(has_note(water, "numbers_as_types"));
  const Particles named = files.read("a.xyz", "2\nAtoms. Timestep: 0\nO 0 0 0\nH 1 0 0\n");
  CHECK(named.elements == std::vector<std::uint8_t>{8, 1});
}

TEST_CASE("extended XYZ: the cell, the time, and numbers of every property") {
  const ParticleFiles files;
  const auto file = files.write(
      "a.xyz",
      "1\nLattice=\"4 0 0 1 5 0 0 0 6\" Origin=\"-1 -2 -3\" pbc=\"T T F\" Time=2.5 "
      "Properties=species:S:1:pos:R:3:forces:R:3:q:R:1:tag:I:2:mol:S:1\nC 1 2 3 3 4 0 -1 7 8 A\n");
  const Particles particles = read_particles(file, everything);
  REQUIRE(particles.cell);
  CHECK(particles.cell->origin == Vec3d{-1, -2, -3});
  CHECK(particles.cell->edges[1] == Vec3d{1, 5, 0});
  CHECK(particles.facts.time == 2.5);
  CHECK(names_of(particles) == "forces forces_x forces_y forces_z q tag_0 tag_1");
  CHECK(numbers_of(particles, "forces") == std::vector<double>{5});
  CHECK(numbers_of(particles, "forces_y") == std::vector<double>{4});
  CHECK(names_of(read_particles(file, {.numbers = {"q"}})) == "q");
  const Particles flat = files.read("b.xyz", "1\nLattice=\"1 0 0 1 0 0 0 0 1\"\nC 0 0 0\n");
  CHECK_FALSE(flat.cell);
  const Particles numbered = files.read("b.xyz", "1\nProperties=Z:I:1:pos:R:3\n26 0 0 0\n");
  CHECK(numbered.elements == std::vector<std::uint8_t>{26});
}

}  // namespace parray
