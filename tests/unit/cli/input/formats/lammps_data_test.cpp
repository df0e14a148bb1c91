#include <doctest/doctest.h>

#include <algorithm>
#include <string>

#include "tests/support/particle_columns.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_trajectories.h"

namespace parray {
namespace {

using test::everything;
using test::has_note;
using test::names_of;
using test::numbers_of;
using test::ParticleFiles;

}  // namespace

TEST_CASE("LAMMPS data: atoms in the file's order, elements by mass, velocities, the box") {
  const ParticleFiles files;
  const Particles particles =
      read_particles(files.write("a.data", test::lammps_data()), everything);
  CHECK(particles.positions == std::vector<Vec3d>{{1, 2, 3}, {4, 5, 6}});
  CHECK(particles.elements == std::vector<std::uint8_t>{6, 8});
  CHECK(names_of(particles) == "id molecule charge vx vy vz");
  CHECK(numbers_of(particles, "charge") == std::vector<double>{-0.5, 0.5});
  CHECK(numbers_of(particles, "vy") == std::vector<double>{0.5, 0.2});
  CHECK(has_note(particles, "guessed_elements"));
  CHECK_FALSE(has_note(particles, "guessed_style"));
  REQUIRE(particles.cell);
  CHECK(particles.cell->edges[1] == Vec3d{1, 8, 0});
}

TEST_CASE("LAMMPS data: without a hint, the columns give the style and a note says so") {
  const ParticleFiles files;
  const auto with = [](const std::string& atoms, const std::string& hint = "") {
    return "\n1 atoms\n2 atom types\n0 9 xlo xhi\n0 9\tylo yhi\n0 9 zlo zhi\n\nAtoms" + hint +
           "\n\n" + atoms + "\n";
  };
  for (const char* row : {"1 2 4 5 6", "1 2 -0.5 4 5 6", "1 1 2 4 5 6", "1 1 2 -0.5 4 5 6",
                          "1 2 0.5 7.8 4 5 6", "1 2 4 5 6 0 0 -1", "1 1 2 0.5 4 5 6 0 0 0"}) {
    CAPTURE(row);
    const Particles particles = files.read("a.data", with(row));
    CHECK(particles.positions == std::vector<Vec3d>{{4, 5, 6}});
    CHECK(particles.types.names == std::vector<std::string>{"2"});
    CHECK(has_note(particles, "guessed_style"));
  }
  CHECK(files.message("a.data", with("1 2 3 4")).find("the atom style is unclear") !=
        std::string::npos);
  CHECK(files.message("a.data", with("1 2 3 4", " # foo bar")) ==
        "a.data:10: the atom style is unclear from 4 columns, because 'foo' is unknown: write its "
        "name, such as 'Atoms # full'");
  const auto notes = files.read("a.data", with("1 2 4 5 6", " # foo")).facts.notes;
  CHECK(std::ranges::any_of(notes, [](const ParticleNote& note) {
    return note.text ==
           "atom read with atom style atomic, guessed from the number of columns, "
           "because 'foo' is unknown";
  }));
  CHECK(files.message("a.data", with("1 2 4 5 6\n2 2 4 5 6")).find("text follows the last atom") !=
        std::string::npos);
}

TEST_CASE("masses in reduced units and of beads give no elements") {
  const ParticleFiles files;
  const auto elements = [&](const std::string& masses) {
    return files
        .read("a.data", "\n2 atoms\n2 atom types\n0 9 xlo xhi\n\nMasses\n\n" + masses +
                            "\nAtoms # atomic\n\n1 1 0 0 0\n2 2 1 1 1\n")
        .elements;
  };
  CHECK(elements("1 1.0\n2 4.0\n").empty());
  CHECK(elements("1 72.0\n2 45.0\n").empty());
  CHECK(elements("1 14.027\n2 15.035\n").empty());  // united atoms CH2 and CH3
  CHECK(elements("1 1.0\n2 12.0\n") == std::vector<std::uint8_t>{1, 6});
  CHECK(elements("1 55.85\n2 2.014\n") == std::vector<std::uint8_t>{26, 1});
}

TEST_CASE("LAMMPS data: labels name the types, and types with the same label become one") {
  const ParticleFiles files;
  const Particles particles = files.read(
      "a.data",
      "\n4 atoms\n4 atom types\n0 9 xlo xhi\n\nAtom Type Labels\n\n1 C\n2 O\n3 C\n\nMasses\n\n"
      "1 12\n2 16\n3 12.011\n4 1.008\n\nAtoms # atomic\n\n"
      "1 1 0 0 0\n2 2 1 1 1\n3 3 2 2 2\n4 4 3 3 3\n");
  CHECK(particles.types.names == std::vector<std::string>{"C", "O", "4"});
  CHECK(particles.types.index == std::vector<std::uint32_t>{0, 1, 0, 2});
  CHECK(particles.elements == std::vector<std::uint8_t>{6, 8, 6, 1});
}

TEST_CASE("LAMMPS data: the title of write_data has the style of units") {
  const ParticleFiles files;
  const auto unit = [&](const std::string& title) {
    return files
        .read("a.data", title +
                            "\n\n1 atoms\n1 atom types\n0 9 xlo xhi\n\nAtoms # atomic\n\n"
                            "1 1 0 0 0\n")
        .facts.length_unit;
  };
  CHECK(unit("LAMMPS data file via write_data, version 2 Aug 2023, timestep = 0, units = micro") ==
        "um");
  CHECK(unit("LAMMPS data file via write_data, version 2 Aug 2023, timestep = 0").empty());
}

}  // namespace parray
