#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "tests/support/molecule_files.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::Elements;
using test::ParticleFiles;
using test::Xs;
using test::xs_of;

Particles read_all(const ParticleFiles& files, const std::string& name, const std::string& text,
                   std::uint64_t frame = 0) {
  ParticleRequest request;
  request.all = true;
  request.frame = {frame, false};
  return read_particles(files.write(name, text), request);
}

const std::string gro =
    "Water and ion, t= 12.5\n  5\n"
    "    1SOL     OW    1   0.126   1.624   1.679  0.1227 -0.0580  0.0434\n"
    "    1SOL    HW1    2   0.190   1.661   1.747  0.8085  0.3191 -0.7791\n"
    "    1SOL    HW2    3   0.177   1.568   1.613 -0.9045 -2.6469  1.3180\n"
    "    1SOL     MW    4   0.130   1.624   1.679  0.1227 -0.0580  0.0434\n"
    "99999NA+    NA+99999   1.275   0.053   0.622  0.2519  0.3140 -0.1734\n"
    "   1.82060   1.82060   1.82060\n";

}  // namespace

TEST_CASE(
    "GRO: positions in nm become angstrom, and a note says so; box, time and velocities too") {
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

TEST_CASE("GRO: the numbers of a wide box may run together") {
  const ParticleFiles files;
  const Particles particles = read_all(
      files, "a.gro",
      "wide\n1\n    1SOL     OW    1   0.126   1.624   1.679\n40000.0000040001.0000040002.00000\n");
  REQUIRE(particles.cell.has_value());
  CHECK(particles.cell->edges[2].z == 400020);
}

TEST_CASE("GRO: what is missing or no number is told with its line") {
  const ParticleFiles files;
  CHECK(files.message("a.gro", "title\n2\n    1SOL     OW    1   0.126   1.624   1.679\n") ==
        "a.gro:3: the file ends after 1 of 2 atoms and the box: is it complete?");
  CHECK(files.message("a.gro", "title\n1\n    1SOL     OW    1   0.126   1.6x4   1.679\n1 1 1\n") ==
        "a.gro:3: y '1.6x4' is not a finite number: write it as 0.5 or 1e3");
  CHECK(files.message("a.gro", "title\nmany\n") ==
        "a.gro:2: 'many' is not a number of particles: write a whole number");
  CHECK(files.message("a.gro", "title\n1\n    1SOL     OW    1   0.126   1.624   1.679\n1 1\n") ==
        "a.gro:4: 2 numbers of the box where 3 or 9 are needed: is the file complete?");
}

TEST_CASE("MOL and SDF: molecules are frames, charges come from M CHG or the atom block") {
  const ParticleFiles files;
  const std::string methoxide =
      "methoxide\n  program\n\n  2  1  0  0  0  0            999 V2000\n"
      "    1.0000    0.0000    0.0000 C   0  0  0  0  0  0\n"
      "   -0.5000    0.2500    0.1250 O   0  5  0  0  0  0\n"
      "  1  2  1  0\nM  END\n";
  CHECK(read_all(files, "a.mol", methoxide).positions ==
        std::vector<Vec3d>{{1, 0, 0}, {-0.5, 0.25, 0.125}});
  const Particles first =
      read_all(files, "a.sdf", methoxide + "> <id>\n1\n\n$$$$\n" + methoxide + "$$$$\n");
  CHECK(first.elements == Elements{6, 8});
  CHECK(first.facts.frames == 2);
  REQUIRE(first.numbers.size() == 1);
  CHECK(first.numbers[0].values == std::vector<double>{0, -1});
  std::string listed = methoxide;
  listed.replace(listed.find("M  END"), 0, "M  CHG  1   1   2\n");
  CHECK(read_all(files, "a.mol", listed).numbers[0].values == std::vector<double>{2, 0});
}

TEST_CASE("SDF: V3000 is read, continued lines too, and what is no element is counted") {
  const ParticleFiles files;
  const std::string text =
      "\n\n\n  0  0  0     0  0            999 V3000\nM  V30 BEGIN CTAB\n"
      "M  V30 COUNTS 3 0 0 0 0\nM  V30 BEGIN ATOM\nM  V30 1 N 1.5 2.5 3.5 0 CHG=1\n"
      "M  V30 2 Cl 4.5 5.5 -\nM  V30 6.5 0\nM  V30 3 R# 7 8 9 0\nM  V30 END ATOM\n"
      "M  V30 END CTAB\nM  END\n$$$$\n\n\n";
  const Particles particles = read_all(files, "a.sdf", text);
  CHECK(particles.positions == std::vector<Vec3d>{{1.5, 2.5, 3.5}, {4.5, 5.5, 6.5}, {7, 8, 9}});
  CHECK(particles.elements == Elements{7, 17, 0});
  CHECK(particles.numbers[0].values == std::vector<double>{1, 0, 0});
  CHECK(test::note(particles, "unknown_elements") == 1);
  CHECK(particles.facts.frames == 1);
}

TEST_CASE("SDF: incomplete and damaged molecules are told with their line") {
  const ParticleFiles files;
  const std::string head = "\n\n\n  2  0  0     0  0            999 V2000\n";
  CHECK(files.message("a.sdf", head + "    1.0000    0.0000    0.0000 C   0  0\n") ==
        "a.sdf:5: the file ends within a molecule: is it complete?");
  CHECK(files.message("a.sdf", head + "    1.0000    0.0000    0.0000 C   0  0\n$$$$\n") ==
        "a.sdf:6: the molecule ends before its 2 atoms");
  CHECK(files.message("a.sdf", "a\nb\n") ==
        "a.sdf:2: the file ends within a molecule's header: is it complete?");
  CHECK(files.message("a.sdf", head + "1.0 nan 0.0 C\n") ==
        "a.sdf:5: y 'nan' is not a finite number: write it as 0.5 or 1e3");
}

TEST_CASE("MOL2: SYBYL's, GAFF's and AMBER's types tell elements; residues, charges and cell") {
  const ParticleFiles files;
  const std::string text =
      "# comment\n@<TRIPOS>MOLECULE\nfirst\n 6 0 1\nSMALL\nUSER_CHARGES\n\n@<TRIPOS>ATOM\n"
      "1 CA 1.0 0.0 0.0 C.ar 1 ALA12 -0.5\n2 X1 2.0 0.0 0.0 ca 2 LIG 0.25\n"
      "3 CA 3.0 0.0 0.0 Ca 3 CA301\n4 C1 4.0 0.0 0.0 CA 1 <0>\n5 L1 5.0 0.0 0.0 LP\n"
      "6 O1 6.0 0.0 0.0 O.co2\n@<TRIPOS>CRYSIN\n10 20 30 90 90 90 1 1\n"
      "@<TRIPOS>MOLECULE\nsecond\n@<TRIPOS>ATOM\n1 BR 7 0 0 Br\n";
  const Particles particles = read_all(files, "a.mol2", text);
  CHECK(xs_of(particles) == Xs{1, 2, 3, 4, 5, 6});
  CHECK(particles.elements == Elements{6, 6, 20, 6, 0, 8});
  CHECK(test::note(particles, "guessed_elements") == 1);
  CHECK(particles.residue_names.names == std::vector<std::string>{"ALA", "LIG", "CA", ""});
  CHECK(particles.residue_numbers == std::vector<std::int32_t>{12, 2, 301, 1, 0, 0});
  CHECK(particles.numbers[0].values[0] == -0.5);
  REQUIRE(particles.cell.has_value());
  CHECK(particles.cell->edges[1] == Vec3d{0, 20, 0});
  CHECK(particles.facts.frames == 2);
  CHECK(xs_of(read_all(files, "a.mol2", text, 1)) == Xs{7});
  CHECK(files.message("a.mol2", "@<TRIPOS>MOLECULE\n@<TRIPOS>ATOM\n1 C 1 2 3\n") ==
        "a.mol2:3: an atom has number, name, x, y, z and type: is the file complete?");
}

}  // namespace parray
