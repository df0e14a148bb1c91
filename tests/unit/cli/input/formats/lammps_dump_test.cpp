#include <doctest/doctest.h>

#include <string>
#include <vector>

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
using test::ParticleFiles;
using test::three_positions;
using test::types_of;

std::string dump(const std::string& box, const std::string& columns, const std::string& row) {
  return "ITEM: UNITS\nmetal\nITEM: TIME\n2.5\nITEM: TIMESTEP\n40\nITEM: NUMBER OF ATOMS\n1\n" +
         ("ITEM: BOX BOUNDS " + box) + "ITEM: ATOMS " + columns + "\n" + row + "\n";
}

}  // namespace

TEST_CASE("a LAMMPS dump is read: any order of columns, types as text, radii or diameters") {
  const ParticleFiles files;
  const std::string head =
      "ITEM: UNITS\nlj\nITEM: TIMESTEP\n100\nITEM: NUMBER OF ATOMS\n2\n"
      "ITEM: BOX BOUNDS pp pp ff\n-1 3\n0 2\n10 20\n";
  const std::string second = "ITEM: TIMESTEP\n200\n";
  Particles particles =
      files.read("a.lammpstrj", head +
                                    "ITEM: ATOMS id type xs x y z element diameter vx \n"
                                    "2 10 0.5 1 -2 3.5 Fe 1.5 0\n1 2 0.5 0 0.25 -1e3 Qq 0.5 0\n" +
                                    second);
  CHECK(particles.positions == std::vector<Vec3d>{three_positions()[0], three_positions()[1]});
  CHECK(types_of(particles) == Names{"10", "2"});
  CHECK(particles.elements == Elements{26, 0});
  CHECK(particles.radii == std::vector<double>{0.75, 0.25});
  particles = files.read("a.dump", head + "ITEM: ATOMS xu yu zu radius\n1 2 3 4\n5 6 7 8\n");
  CHECK(particles.positions == std::vector<Vec3d>{{1, 2, 3}, {5, 6, 7}});
  CHECK(particles.radii == std::vector<double>{4, 8});
  CHECK(particles.types.empty());
  particles = files.read("a.dump", head + "ITEM: ATOMS type xs ys zs\n1 0 0.5 1\n1 0.25 -1 0.5\n");
  CHECK(particles.positions == std::vector<Vec3d>{{-1, 1, 20}, {0, -2, 15}});
}

TEST_CASE("scaled positions in a tilted LAMMPS box become Cartesian") {
  // Edges a = (4, 0, 0), b = (1, 3, 0), c = (-2, 0.5, 5) from the origin (10, 20, 30): the bounds
  // that LAMMPS writes are those of the box around it.
  const ParticleFiles files;
  const std::string head =
      "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n5\nITEM: BOX BOUNDS xy xz yz pp pp pp\n"
      "8 15 1\n20 23.5 -2\n30 35 0.5\n";
  const Particles particles = files.read(
      "a.dump", head + "ITEM: ATOMS xs ys zs\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n0.5 0.5 0.5\n");
  CHECK(particles.positions ==
        std::vector<Vec3d>{
            {10, 20, 30}, {14, 20, 30}, {11, 23, 30}, {8, 20.5, 35}, {11.5, 21.75, 32.5}});
}

TEST_CASE("LAMMPS dumps: boxes of all kinds, the time, more columns") {
  const ParticleFiles files;
  const auto file = files.write("a.dump", dump("xy xz yz pp pp pp\n0 11 1\n0 10 0\n0 10 0\n",
                                               "id x y z c_pe VX", "7 1 2 3 -4 5"));
  const Particles particles = read_particles(file, everything);
  CHECK(names_of(particles) == "id c_pe vx");
  CHECK(particles.facts.time == 2.5);
  REQUIRE(particles.cell);
  CHECK(particles.cell->edges[0] == Vec3d{10, 0, 0});
  CHECK(particles.cell->edges[1] == Vec3d{1, 10, 0});
  const Particles general = files.read(
      "b.dump", dump("abc origin pp pp pp\n2 0 0 1\n0 0 4 1\n0 -3 0 1\n", "xs ys zs", "0.5 0.5 1"));
  CHECK(general.positions[0] == Vec3d{2, -2, 3});
  REQUIRE(general.cell);
  CHECK(general.cell->origin == Vec3d{1, 1, 1});
}

TEST_CASE("LAMMPS dumps: empty frames at the beginning are skipped") {
  const ParticleFiles files;
  const std::string empty =
      "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n0\nITEM: BOX BOUNDS pp pp pp\n0 8\n0 8\n0 8\n"
      "ITEM: ATOMS x y z\n";
  const Particles particles =
      files.read("a.dump", empty + empty + dump("pp pp pp\n0 1\n0 1\n0 1\n", "x y z", "1 2 3"));
  CHECK(particles.facts.frame == 2);
  CHECK(particles.positions[0] == Vec3d{1, 2, 3});
  CHECK(has_note(particles, "empty_frames"));
}

TEST_CASE("LAMMPS dumps: UNITS in the first frame gives all frames their unit of length") {
  const ParticleFiles files;
  const std::string frame = "ITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS x y z\n1 2 3\n";
  for (const auto& row : {std::pair("metal", "angstrom"), std::pair("nano", "nm"),
                          std::pair("si", "m"), std::pair("lj", "")}) {
    const char* const style = row.first;  // Clang 14 does not capture a structured binding
    const char* const unit = row.second;
    CAPTURE(style);
    const auto file =
        files.write("a.dump", std::string("ITEM: UNITS\n") + style + "\n" + frame + frame);
    CHECK(read_particles(file).facts.length_unit == unit);
    CHECK(read_particles(file, {.frame = FrameChoice{1}}).facts.length_unit == unit);
  }
  CHECK(files.read("a.dump", frame).facts.length_unit.empty());
}

}  // namespace parray
