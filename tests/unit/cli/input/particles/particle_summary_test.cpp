#include "cli/input/particles/particle_summary.h"

#include <doctest/doctest.h>

#include <cmath>

#include "tests/support/particle_columns.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::unknown_number;

}  // namespace

TEST_CASE("a summary counts particles by element and type, and missing values") {
  Particles particles;
  particles.positions = {{1, 5, -2}, {-3, 4, 8}, {0, 9, 1}};
  particles.elements = {8, 0, 1};
  particles.types = {{"b", "unused", "a"}, {0, 2, 0}};
  particles.radii = {2, 0.5, 1};
  particles.numbers = {{"vx", {unknown_number, -4, 7}},
                       {"charge", {unknown_number, unknown_number, unknown_number}}};
  const ParticleSummary summary = summary_of(particles);
  CHECK(summary.count == 3);
  CHECK(summary.elements == NameCounts{{"H", 1}, {"O", 1}, {"unknown", 1}});
  CHECK(summary.types == NameCounts{{"b", 2}, {"a", 1}});
  CHECK(summary.low == Vec3d{-3, 4, -2});
  CHECK(summary.high == Vec3d{1, 9, 8});
  REQUIRE(summary.numbers.size() == 3);
  CHECK(summary.numbers[0].name == "radius");
  CHECK(summary.numbers[0].low == 0.5);
  CHECK(summary.numbers[0].missing == 0);
  CHECK(summary.numbers[1].low == -4.0);
  CHECK(summary.numbers[1].high == 7.0);
  CHECK(summary.numbers[1].missing == 1);
  CHECK_FALSE(summary.numbers[2].low);
  CHECK_FALSE(summary.numbers[2].high);
  CHECK(summary.numbers[2].missing == 3);
}

TEST_CASE("residues are runs of one chain, number and name") {
  Particles particles;
  particles.positions.resize(7);
  particles.chains = {{"A", "B"}, {0, 0, 0, 0, 1, 1, 1}};
  particles.residue_names = {{"ALA", "HOH"}, {0, 0, 0, 1, 1, 1, 1}};
  particles.residue_numbers = {1, 1, 2, 2, 2, 2, 3};
  const ParticleSummary summary = summary_of(particles);
  CHECK(summary.residues == 5);
  CHECK(summary.residue_names == NameCounts{{"ALA", 2}, {"HOH", 3}});
  CHECK(summary.chains == NameCounts{{"A", 4}, {"B", 3}});
  CHECK(summary_of(Particles{}).residues == 0);
}

TEST_CASE("a cell has the lengths and angles of crystallography") {
  const ParticleCell cell{{}, {{{3, 0, 0}, {0, 4, 0}, {-5, 0, 5}}}};
  CHECK(lengths_of(cell).x == 3);
  CHECK(lengths_of(cell).y == 4);
  CHECK(lengths_of(cell).z == doctest::Approx(std::sqrt(50.0)));
  CHECK(angles_of(cell).x == doctest::Approx(90));
  CHECK(angles_of(cell).y == doctest::Approx(135));
  CHECK(angles_of(cell).z == doctest::Approx(90));
}

TEST_CASE("the faces of a mesh are left out, and counted") {
  const test::ParticleFiles files;
  const std::string mesh =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
      "property float z\nelement face 2\nproperty list uchar int v\nelement edge 1\n"
      "property int a\nend_header\n0 0 0\n1 0\n1 0\n7\n";
  const std::vector<ParticleNote> notes = files.read("mesh.ply", mesh).facts.notes;
  REQUIRE(notes.size() == 2);
  CHECK(notes[0].key == "faces");
  CHECK(notes[0].count == 2);
  CHECK(notes[0].text == "faces of a mesh not shown");
  CHECK(notes[1].text == "instance of element 'edge' not shown");
}

TEST_CASE("a binary PLY file may end in blank lines") {
  const test::ParticleFiles files;
  const std::string data =
      "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
      "property float z\nend_header\n" +
      std::string(12, '\0');
  CHECK(files.read("a.ply", data + "\r\n").count() == 1);
  CHECK(files.message("a.ply", data + "\nx").find("data follow the last element") !=
        std::string::npos);
}

}  // namespace parray
