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

}  // namespace

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

TEST_CASE("SDF: V3000 is read with continued lines, and a note counts unknown elements") {
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

TEST_CASE("SDF: incomplete and damaged molecules are refused with their line") {
  const ParticleFiles files;
  const std::string head = "\n\n\n  2  0  0     0  0            999 V2000\n";
  CHECK(files.message("a.sdf", head + "    1.0000    0.0000    0.0000 C   0  0\n") ==
        "a.sdf:5: the file ends within a molecule: check that the file is complete");
  CHECK(files.message("a.sdf", head + "    1.0000    0.0000    0.0000 C   0  0\n$$$$\n") ==
        "a.sdf:6: the molecule ends before its 2 atoms and 0 bonds: check these numbers");
  CHECK(files.message("a.sdf", "a\nb\n") ==
        "a.sdf:2: the file ends within a molecule's header: check that the file is complete");
  CHECK(files.message("a.sdf", head + "1.0 nan 0.0 C\n") ==
        "a.sdf:5: y 'nan' is not a finite number: write a number such as 0.5 or 1e3");
  CHECK(files.message("a.sdf", head + "    1.0000    0.0000    0.0000 C   0  0\n  1  2  2  0\n") ==
        "a.sdf:6: the line needs x, y, z and a symbol: check the number of atoms in the molecule's "
        "fourth line");
}

}  // namespace parray
