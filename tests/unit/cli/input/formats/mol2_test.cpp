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
using test::Xs;
using test::xs_of;

}  // namespace

TEST_CASE(
    "MOL2: types of SYBYL, GAFF and AMBER give elements; residues, charges and cell are read") {
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
        "a.mol2:3: the line needs number, name, x, y, z and type of an atom: check that the file "
        "is complete");
}

TEST_CASE(
    "MOL2: types of force fields that are not GAFF's do not give elements; names do, with a note") {
  const ParticleFiles files;
  const Particles particles = read_all(
      files, "a.mol2",
      "@<TRIPOS>MOLECULE\nNMA\n@<TRIPOS>ATOM\n1 C1 1 0 0 opls_135 1 UNK\n2 H1 2 0 0 opls_140 1 "
      "UNK\n"
      "3 O1 3 0 0 opls_236 1 UNK\n4 N1 4 0 0 opls_238 1 UNK\n5 CL1 5 0 0 x7 1 UNK\n"
      "6 N2 6 0 0 nh 1 UNK\n7 S1 7 0 0 sy 1 UNK\n8 X 8 0 0 c2 1 UNK\n9 Fe 9 0 0 opls_1 1 UNK\n");
  CHECK(particles.elements == Elements{6, 1, 8, 7, 17, 7, 16, 6, 26});
  CHECK(test::note(particles, "guessed_elements") == 6);
}

}  // namespace parray
