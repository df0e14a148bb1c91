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

const ParticleRequest all{.all = true};

/// The names of the number columns, with blanks between.
std::string names_of(const Particles& particles) {
  std::string names;
  for (const NumberColumn& column : particles.numbers) {
    names += (names.empty() ? "" : " ") + column.name;
  }
  return names;
}

std::vector<double> numbers(const Particles& particles, std::string_view name) {
  const auto found = std::ranges::find(particles.numbers, name, &NumberColumn::name);
  return found == particles.numbers.end() ? std::vector<double>{} : found->values;
}

bool has_note(const Particles& particles, std::string_view key) {
  return std::ranges::any_of(particles.facts.notes, [&](auto& note) { return note.key == key; });
}

std::string dump(const std::string& box, const std::string& columns, const std::string& row) {
  return "ITEM: UNITS\nmetal\nITEM: TIME\n2.5\nITEM: TIMESTEP\n40\nITEM: NUMBER OF ATOMS\n1\n" +
         ("ITEM: BOX BOUNDS " + box) + "ITEM: ATOMS " + columns + "\n" + row + "\n";
}

}  // namespace

TEST_CASE("no column of numbers is read that nobody asks for") {
  const ParticleFiles files;
  const auto table = files.write("a.csv", "x,y,z,vx,name,Charge [e]\n1,2,3,4,n,-1\n5,6,7,8,m,\n");
  CHECK(read_particles(table).numbers.empty());
  CHECK(names_of(read_particles(table, {.numbers = {"charge"}})) == "charge");
  const Particles every = read_particles(table, all);
  CHECK(names_of(every) == "vx charge");  // the names are no numbers
  CHECK(numbers(every, "vx") == std::vector<double>{4, 8});
  CHECK(std::isnan(numbers(every, "charge").at(1)));
}

TEST_CASE("CSV: positions under the names that programs give them, with units in brackets") {
  const ParticleFiles files;
  for (const char* header :
       {"X,Y,Z", "x [nm],y [nm],z [nm]", "pos_x,pos_y,pos_z", "PositionX,PositionY,PositionZ",
        "Position X,Position Y,Position Z", "\"Points:0\",\"Points:1\",\"Points:2\"",
        "Points_0,Points_1,Points_2", "Position.X,Position.Y,Position.Z", "x_coord,y_coord,z_coord",
        "Center X (um),Center Y (um),Center Z (um)"}) {
    CAPTURE(header);
    const Particles particles = files.read("a.csv", std::string(header) + "\n1,2,3\n");
    CHECK(particles.positions == std::vector<Vec3d>{{1, 2, 3}});
  }
  CHECK(files.message("a.csv", "px,py\n1,2\n").find("no column 'x'") != std::string::npos);
  const Particles both = files.read("a.csv", "pos_x,pos_y,pos_z,x,y,z\n1,1,1,7,8,9\n");
  CHECK(both.positions[0] == Vec3d{7, 8, 9});
  const Particles balls = files.read("a.csv", "x,y,z,diameter\n1,2,3,4\n");
  CHECK(balls.radii == std::vector<double>{2});
}

TEST_CASE("XYZ of LAMMPS has numbers of types where elements stand") {
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
  const Particles particles = read_particles(file, all);
  REQUIRE(particles.cell);
  CHECK(particles.cell->origin == Vec3d{-1, -2, -3});
  CHECK(particles.cell->edges[1] == Vec3d{1, 5, 0});
  CHECK(particles.facts.time == 2.5);
  CHECK(names_of(particles) == "forces forces_x forces_y forces_z q tag_0 tag_1");
  CHECK(numbers(particles, "forces") == std::vector<double>{5});
  CHECK(numbers(particles, "forces_y") == std::vector<double>{4});
  CHECK(names_of(read_particles(file, {.numbers = {"q"}})) == "q");
  const Particles flat = files.read("b.xyz", "1\nLattice=\"1 0 0 1 0 0 0 0 1\"\nC 0 0 0\n");
  CHECK_FALSE(flat.cell);
  const Particles numbered = files.read("b.xyz", "1\nProperties=Z:I:1:pos:R:3\n26 0 0 0\n");
  CHECK(numbered.elements == std::vector<std::uint8_t>{26});
}

TEST_CASE("LAMMPS dumps: boxes of all kinds, the time, more columns") {
  const ParticleFiles files;
  const auto file = files.write("a.dump", dump("xy xz yz pp pp pp\n0 11 1\n0 10 0\n0 10 0\n",
                                               "id x y z c_pe VX", "7 1 2 3 -4 5"));
  const Particles particles = read_particles(file, all);
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

TEST_CASE("LAMMPS dumps: empty frames at the beginning are passed over") {
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

TEST_CASE("LAMMPS data: atoms in the file's order, elements by mass, velocities, the box") {
  const ParticleFiles files;
  const Particles particles = read_particles(files.write("a.data", test::lammps_data()), all);
  CHECK(particles.positions == std::vector<Vec3d>{{1, 2, 3}, {4, 5, 6}});
  CHECK(particles.elements == std::vector<std::uint8_t>{6, 8});
  CHECK(names_of(particles) == "id molecule charge vx vy vz");
  CHECK(numbers(particles, "charge") == std::vector<double>{-0.5, 0.5});
  CHECK(numbers(particles, "vy") == std::vector<double>{0.5, 0.2});
  CHECK(has_note(particles, "guessed_elements"));
  CHECK_FALSE(has_note(particles, "guessed_style"));
  REQUIRE(particles.cell);
  CHECK(particles.cell->edges[1] == Vec3d{1, 8, 0});
}

TEST_CASE("LAMMPS data: without a hint the columns tell the style, with a note") {
  const ParticleFiles files;
  const auto with = [](const std::string& atoms) {
    return "\n1 atoms\n2 atom types\n0 9 xlo xhi\n0 9\tylo yhi\n0 9 zlo zhi\n\nAtoms\n\n" + atoms +
           "\n";
  };
  for (const char* row : {"1 2 4 5 6", "1 2 -0.5 4 5 6", "1 1 2 4 5 6", "1 1 2 -0.5 4 5 6",
                          "1 2 0.5 7.8 4 5 6", "1 2 4 5 6 0 0 -1", "1 1 2 0.5 4 5 6 0 0 0"}) {
    CAPTURE(row);
    const Particles particles = files.read("a.data", with(row));
    CHECK(particles.positions == std::vector<Vec3d>{{4, 5, 6}});
    CHECK(particles.types.names == std::vector<std::string>{"2"});
    CHECK(has_note(particles, "guessed_style"));
  }
  CHECK(files.message("a.data", with("1 2 3 4")).find("cannot tell the atom style") !=
        std::string::npos);
  CHECK(files.message("a.data", with("1 2 4 5 6\n2 2 4 5 6")).find("text after the last atom") !=
        std::string::npos);
}

TEST_CASE("masses of reduced units and of beads are no elements") {
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

TEST_CASE("PLY: numbers of vertices, as text and binary, and line ends of CR") {
  const ParticleFiles files;
  const std::string header =
      "element vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
      "property float Quality\nproperty uchar flag\n";
  const std::string text =
      "ply\nformat ascii 1.0\n" + header + "end_header\n1 2 3 0.5 7\n4 5 6 nan 8\n";
  std::string binary = "ply\nformat binary_little_endian 1.0\n" + header + "end_header\n";
  for (const float x : {1.0F, 2.0F, 3.0F, 0.5F}) binary += test::bytes_of(x);
  binary += "\x07";
  for (const float x : {4.0F, 5.0F, 6.0F, std::nanf("")}) binary += test::bytes_of(x);
  binary += "\x08";
  std::string returns = text;
  std::ranges::replace(returns, '\n', '\r');
  for (const std::string& bytes : {text, binary, returns}) {
    const auto file = files.write("a.ply", bytes);
    CHECK(read_particles(file).numbers.empty());
    const Particles particles = read_particles(file, all);
    CHECK(particles.positions[1] == Vec3d{4, 5, 6});
    CHECK(names_of(particles) == "quality flag");
    CHECK(numbers(particles, "quality")[0] == 0.5);
    CHECK(std::isnan(numbers(particles, "quality")[1]));
    CHECK(numbers(particles, "flag") == std::vector<double>{7, 8});
  }
}

TEST_CASE("AMBER restart files: positions, time and box") {
  const ParticleFiles files;
  const Particles particles = files.read("a.rst7", test::inpcrd());
  CHECK(particles.positions == std::vector<Vec3d>{{1, 2, 3}, {4, 5, 6}});
  CHECK(particles.facts.time == 15);
  REQUIRE(particles.cell);
  CHECK(particles.cell->edges[2].z == 30);
}

}  // namespace parray
