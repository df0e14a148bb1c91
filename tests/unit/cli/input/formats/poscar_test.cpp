#include <doctest/doctest.h>

#include <cmath>
#include <string>
#include <vector>

#include "cli/input/formats/format_table.h"
#include "tests/support/memory.h"
#include "tests/support/molecule_files.h"
#include "tests/support/particle_columns.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::Elements;
using test::Names;
using test::numbers_of;
using test::packed;
using test::ParticleFiles;
using test::told;

const std::string lattice = "2 0 0\n0 4 0\n1 0 8\n";

/// A file with two sodium atoms and a chlorine atom.
std::string poscar(const std::string& scale, const std::string& mode,
                   const std::string& rows = "0 0 0\n0.5 0.5 0.5\n1 0.25 -0.5\n") {
  return "salt\n" + scale + "\n" + lattice + "Na_pv Cl\n2 1\n" + mode + "\n" + rows;
}

Particles read_poscar(const std::string& text, const char* name = "POSCAR") {
  const ParticleFiles files;
  return read_particles(files.write(name, text), {.all = true});
}

Particles xdatcar_frame(const std::string& text, std::uint64_t number) {
  const ParticleFiles files;
  return read_particles(files.write("XDATCAR", text),
                        {.frame = FrameChoice{number, false}, .all = true});
}

}  // namespace

TEST_CASE("POSCAR: fractions become positions in the cell; names of species give the elements") {
  const Particles particles = read_poscar(poscar("2", "Direct"));
  CHECK(particles.positions == std::vector<Vec3d>{{0, 0, 0}, {3, 4, 8}, {3, 2, -8}});
  CHECK(particles.elements == Elements{11, 11, 17});
  CHECK(particles.types.names == Names{"Na_pv", "Cl"});
  REQUIRE(particles.cell);
  CHECK(particles.cell->edges == std::array<Vec3d, 3>{Vec3d{4, 0, 0}, {0, 8, 0}, {2, 0, 16}});
  CHECK(particles.cell->origin == Vec3d{});
  CHECK(particles.facts.format == "POSCAR");
  CHECK(particles.facts.frames == 1U);
  CHECK_FALSE(particles.facts.time);
}

TEST_CASE("POSCAR: a scale is a factor, a volume with a minus sign, or three factors") {
  CHECK(read_poscar(poscar("2 ! factor", "cartesian")).positions[2] == Vec3d{2, 0.5, -1});
  const Particles three = read_poscar(poscar("1 2 3", "Kartesian"));
  CHECK(three.positions[2] == Vec3d{1, 0.5, -1.5});
  CHECK(three.cell->edges[2] == Vec3d{1, 0, 24});
  const Particles volume = read_poscar(poscar("-512", "C"));  // the lattice has the volume 64
  CHECK(std::abs(volume.positions[2].x - 2) < 1e-12);
  CHECK(std::abs(volume.cell->edges[1].y - 8) < 1e-12);
}

TEST_CASE("POSCAR: selective dynamics and the species of a row do not change the positions") {
  const std::string rows = "0 0 0 T T F Na\n0.5 0.5 0.5 F F F\n1 0.25 -0.5 T T T\n";
  const Particles particles = read_poscar(poscar("1", "Selective dynamics\ndirect", rows));
  CHECK(particles.positions == read_poscar(poscar("1", "Direct")).positions);
  CHECK(particles.elements == Elements{11, 11, 17});
}

TEST_CASE("POSCAR of VASP 4: symbols of rows, or else of the title, give the elements") {
  const auto old = [](const std::string& title, const std::string& rows) {
    return read_poscar(title + "\n1\n" + lattice + "1 1 ! counts\nDirect\n" + rows);
  };
  const std::string plain = "0 0 0\n0.5 0.5 0.5\n";
  const Particles rows = old("Fe O", "0 0 0 Na\n0.5 0.5 0.5 Cl1\n");
  CHECK(rows.elements == Elements{11, 17});
  CHECK(told(rows, "guessed_elements").empty());
  CHECK(old("Fe O", plain).elements == Elements{26, 8});
  CHECK(old("Fe2O3 bulk", plain).elements == Elements{26, 8});
  CHECK(told(old("Fe2O3 bulk", plain), "guessed_elements") ==
        "2 elements taken from the file's title");
  for (const char* title : {"", "bulk", "Fe", "Fe O H", "In a box", "Qq O"}) {
    CAPTURE(title);
    const Particles unknown = old(title, plain);
    CHECK(unknown.elements.empty());
    CHECK(unknown.types.names == Names{"1", "2"});
    CHECK(told(unknown, "unknown_elements") ==
          "2 atoms of unknown elements, because the file names none");
  }
}

TEST_CASE("POSCAR: names of species may have a potential, a fraction, a number or a hash") {
  const Particles particles =
      read_poscar("t\n1\n" + lattice + "H.75 Fe2 O/6a2f546d Xx\n1 1 1 1\nDirect\n" +
                  "0 0 0\n0 0 0.25\n0 0 0.5\n0 0 0.75\n");
  CHECK(particles.elements == Elements{1, 26, 8, 0});
  CHECK(particles.types.names == Names{"H.75", "Fe2", "O", "Xx"});
}

TEST_CASE("CONTCAR: velocities follow the positions, also after those of the lattice") {
  const std::string velocities = "0.5 1 1.5\n0 0 0\n-1 -2 -3\n";
  const std::string lattice_part =
      "Lattice velocities and vectors\n1\n0 0 0\n0 0 0\n0 0 0\n" + lattice;
  for (const std::string& between :
       {std::string("\n"), std::string("Cartesian\n"), lattice_part + "\n"}) {
    CAPTURE(between);
    const Particles particles =
        read_poscar(poscar("2", "Direct") + between + velocities + "\n1\n0.5\n");
    CHECK(numbers_of(particles, "vx") == std::vector<double>{0.5, 0, -1});
    CHECK(numbers_of(particles, "vz") == std::vector<double>{1.5, 0, -3});
  }
  const Particles fractions = read_poscar(poscar("2", "Direct") + "Direct\n" + velocities);
  CHECK(numbers_of(fractions, "vx") == std::vector<double>{5, 0, -10});
  CHECK(numbers_of(fractions, "vy") == std::vector<double>{8, 0, -16});
  const ParticleFiles files;
  ParticleRequest one;
  one.numbers = {"vy"};
  const Particles wanted =
      read_particles(files.write("CONTCAR", poscar("1", "C") + "\n" + velocities), one);
  CHECK(wanted.numbers.size() == 1);
}

TEST_CASE("CHGCAR: the grid after the atoms is not read as velocities") {
  const Particles particles = read_poscar(poscar("1", "Direct") + "\n 2 2 2\n1 2 3 4 5\n6 7 8\n");
  CHECK(particles.count() == 3);
  CHECK(particles.numbers.empty());
}

TEST_CASE("XDATCAR: frames share the lattice, or each has its own; the number is the time") {
  const std::string head = "salt\n1\n" + lattice + "Na Cl\n1 1\n";
  const std::string wide = "salt\n2\n" + lattice + "Na Cl\n1 1\n";
  const std::string one = "Direct configuration=     1\n0 0 0\n0.5 0.5 0.5\n";
  const std::string two = "Direct configuration=     2\n0 0 0\n0 0.5 0\n";
  const Particles same = xdatcar_frame(head + one + two, 1);
  CHECK(same.positions == std::vector<Vec3d>{{0, 0, 0}, {0, 2, 0}});
  CHECK(same.facts.frames == 2U);
  CHECK(same.facts.time == 2);
  const Particles own = xdatcar_frame(head + one + wide + two + "\n", 1);
  CHECK(own.positions == std::vector<Vec3d>{{0, 0, 0}, {0, 4, 0}});
  CHECK(own.cell->edges[1] == Vec3d{0, 8, 0});
  CHECK(own.facts.frames == 2U);
  CHECK(xdatcar_frame(head + one + wide + two, 0).cell->edges[1] == Vec3d{0, 4, 0});
  const Particles blank = xdatcar_frame(head + "\n0 0 0\n0.5 0.5 0.5\n\n0 0 0\n0 0.5 0\n\n", 1);
  CHECK(blank.positions == same.positions);
  CHECK(blank.facts.frames == 2U);
  const Particles cut = xdatcar_frame(head + one + two.substr(0, 34), 0);
  CHECK(cut.facts.frames == 1U);
  CHECK(told(cut, "unreadable_frames").find("ends within a frame") != std::string::npos);
}

TEST_CASE("POSCAR: the content or the beginning of the name gives the format") {
  for (const char* name : {"POSCAR", "CONTCAR.gz", "poscar_relaxed", "XDATCAR-2", "POSCAR.3",
                           "a.vasp", "a.POSCAR", "run/CONTCAR"}) {
    CAPTURE(name);
    REQUIRE(format_by_name(name) != nullptr);
    CHECK(format_by_name(name)->name == "POSCAR");
  }
  CHECK(format_by_name("POSCAR.xyz")->name == "XYZ");
  CHECK(format_by_name("poscars") == nullptr);
  CHECK(format_by_name("my_POSCAR") == nullptr);
  for (const char* name : {"noname", "a.xyz", "a.pdb", "a.gro", "a.csv"}) {
    CHECK(read_poscar(poscar("1", "Direct"), name).facts.format == "POSCAR");
  }
  CHECK(read_poscar(packed(poscar("1", "Direct"), "xz"), "a").facts.format == "POSCAR");
  const std::string wide =
      "salt\n    1\n    5.430000    0.000000    0.000000\n"
      "    0.000000    5.430000    0.000000\n"
      "    0.000000    0.000000    5.430000\nNa\n1\n\n0 0 0\n";
  CHECK(read_poscar(wide, "a").facts.format == "POSCAR");  // columns like those of GRO
}

TEST_CASE("POSCAR: invalid lines are refused with their place and a remedy") {
  const ParticleFiles files;
  const auto says = [&](const std::string& text) { return files.message("POSCAR", text); };
  const std::string head = "t\n1\n" + lattice;
  CHECK(says("t\n1\n") ==
        "POSCAR:2: the file ends within its header: check that the file is complete");
  CHECK(says("t\nx\n" + lattice) ==
        "POSCAR:2: 0 scale factors: write one number, or three positive numbers");
  CHECK(says("t\n0\n" + lattice) ==
        "POSCAR:2: the scale factor is 0: write a positive number, or the volume of the cell with "
        "a minus sign");
  CHECK(says("t\n1 -1 1\n" + lattice) ==
        "POSCAR:2: three scale factors must be positive: write positive numbers");
  CHECK(says("t\n1\n1 0\n") ==
        "POSCAR:3: 2 numbers, but 3 are needed: write a vector of the lattice");
  CHECK(says("t\n1\n1 0 0\n1 0 0\n0 0 1\nH\n1\nDirect\n0 0 0\n") ==
        "POSCAR:5: the three vectors of the lattice span no volume: correct them");
  CHECK(says(head + "Na Cl\n2\nDirect\n") ==
        "POSCAR:7: 1 numbers of atoms, but 2 species: write one whole number per species");
  CHECK(says(head + "Na\nDirect\n") ==
        "POSCAR:7: 'Direct' are not numbers of atoms: write one whole number per species");
  CHECK(says(head + "Na\n1\n0 0 0\n") ==
        "POSCAR:8: '0 0 0' is not the mode of the positions: write Direct or Cartesian");
  CHECK(says(head + "Na\n2\nDirect\n0 0 0\n") ==
        "POSCAR:9: the file ends after 1 of 2 atoms: check that the file is complete");
  CHECK(says(head + "Na\n1\nDirect\n0 0\n") ==
        "POSCAR:9: 2 columns, but 3 are needed: write x, y and z of each atom");
  CHECK(says(head + "Na\n1\nDirect\n0 0 T\n") ==
        "POSCAR:9: z 'T' is not a finite number: write a number such as 0.5 or 1e3");
  CHECK(says(head + "Na\n0\nDirect\n").find("no particles") != std::string::npos);
}

TEST_CASE("POSCAR: a count that exceeds the file's size allocates no memory") {
  const ParticleFiles files;
  const std::uint64_t before = test::peak_address_space();
  const std::string text = "t\n1\n" + lattice + "Na\n100000000\nDirect\n0 0 0\n";
  CHECK(files.message("POSCAR", text).find("ends after 1 of 100000000") != std::string::npos);
  CHECK(files.message("b.vasp.gz", packed(text)).find("ends after 1 of") != std::string::npos);
  const std::string many = "t\n1\n" + lattice + "Na Cl\n100000000 1\nDirect\n0 0 0\n";
  CHECK(files.message("POSCAR", many).find("too many") != std::string::npos);
  CHECK(test::peak_address_space() - before < 64'000'000);
}

}  // namespace parray
