#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "tests/support/molecule_files.h"
#include "tests/support/particle_columns.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::Elements;
using test::ParticleFiles;
using test::read_all;

const std::string gro =
    "Water and ion, t= 12.5\n  5\n"
    "    1SOL     OW    1   0.126   1.624   1.679  0.1227 -0.0580  0.0434\n"
    "    1SOL    HW1    2   0.190   1.661   1.747  0.8085  0.3191 -0.7791\n"
    "    1SOL    HW2    3   0.177   1.568   1.613 -0.9045 -2.6469  1.3180\n"
    "    1SOL     MW    4   0.130   1.624   1.679  0.1227 -0.0580  0.0434\n"
    "99999NA+    NA+99999   1.275   0.053   0.622  0.2519  0.3140 -0.1734\n"
    "   1.82060   1.82060   1.82060\n";

}  // namespace

TEST_CASE("GRO: positions in nm become angstrom with a note; box, time and velocities are read") {
  const ParticleFiles files;
  const Particles particles = read_all(files, "a.gro", gro);
  CHECK(particles.positions[0] == Vec3d{10 * 0.126, 10 * 1.624, 10 * 1.679});
  CHECK(particles.elements == Elements{8, 1, 1, 0, 11});
  CHECK(test::note(particles, "length_unit") == 5);
  CHECK(test::note(particles, "unknown_elements") == 0);  // MW is a virtual site
  CHECK(particles.residue_names.names == std::vector<std::string>{"SOL", "NA+"});
  CHECK(particles.residue_numbers.back() == 99999);
  CHECK(particles.facts.time == 12.5);
  REQUIRE(particles.cell.has_value());
  CHECK(particles.cell->edges[1].y == doctest::Approx(18.206));
  REQUIRE(particles.numbers.size() == 3);
  CHECK(particles.numbers[0].name == "vx");
  CHECK(particles.numbers[0].values[0] == doctest::Approx(1.227));
}

TEST_CASE("GRO: any precision, triclinic boxes, blank titles and names, several frames") {
  const ParticleFiles files;
  const std::string second =
      "\n1\n    1              1   1.12345   2.12345  -3.12345\n 1 2 3 0 0 0.5 0 0.25 0.125\n";
  const Particles particles = read_all(files, "a.gro", gro + second + "\n", 1);
  CHECK(particles.positions == std::vector<Vec3d>{{11.2345, 21.2345, -31.2345}});
  CHECK(particles.facts.frames == 2);
  CHECK(particles.residue_names.empty());
  REQUIRE(particles.cell.has_value());
  CHECK(particles.cell->edges ==
        std::array<Vec3d, 3>{Vec3d{10, 0, 0}, Vec3d{5, 20, 0}, Vec3d{2.5, 1.25, 30}});
}

TEST_CASE("GRO: the numbers of a wide box may have no blanks between them") {
  const ParticleFiles files;
  const Particles particles = read_all(
      files, "a.gro",
      "wide\n1\n    1SOL     OW    1   0.126   1.624   1.679\n40000.0000040001.0000040002.00000\n");
  REQUIRE(particles.cell.has_value());
  CHECK(particles.cell->edges[2].z == 400020);
}

TEST_CASE("GRO: missing and invalid numbers are refused with their line") {
  const ParticleFiles files;
  CHECK(files.message("a.gro", "title\n2\n    1SOL     OW    1   0.126   1.624   1.679\n") ==
        "a.gro:3: the file ends after 1 of 2 atoms and the box: check that the file is complete");
  CHECK(files.message("a.gro", "title\n1\n    1SOL     OW    1   0.126   1.6x4   1.679\n1 1 1\n") ==
        "a.gro:3: y '1.6x4' is not a finite number: write a number such as 0.5 or 1e3");
  CHECK(files.message("a.gro", "title\nmany\n") ==
        "a.gro:2: 'many' is not a number of particles: write a whole number");
  CHECK(files.message("a.gro", "title\n1\n    1SOL     OW    1   0.126   1.624   1.679\n1 1\n") ==
        "a.gro:4: 2 numbers describe the box, but 3 or 9 are needed: check the number of atoms in "
        "the frame's second line, and that the file is complete");
  CHECK(files.message(
            "a.gro",
            "title\n2\n    1SOL     OW    1   0.126   1.624   1.679\n   1.0   1.0   1.0\n") ==
        "a.gro:4: the line ends before the z of an atom: check the number of atoms in the frame's "
        "second line");
}

}  // namespace parray
