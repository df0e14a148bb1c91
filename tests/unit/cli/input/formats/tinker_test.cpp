#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "tests/support/molecule_files.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::Elements;
using test::ParticleFiles;
using test::Xs;

const std::string tinker_rows =
    "     1  N     1.0  0.0  0.0   7   2\n     2  CT    2.0  0.0  0.0   8   1   3\n"
    "     3  Na+   3.0  0.0  0.0  49   2\n";

}  // namespace

TEST_CASE("Tinker: files with and without a box and a title are read under every name") {
  const ParticleFiles files;
  const std::string box = "   18.643   19.0   20.0   90.0   90.0   90.0\n";
  for (const std::string title : {"", "  a title 7"}) {
    for (const char* name : {"a.xyz", "a.txyz", "a"}) {
      const Particles boxed = files.read(name, "     3" + title + "\n" + box + tinker_rows);
      CHECK(boxed.facts.format == "Tinker");
      CHECK(test::xs_of(boxed) == Xs{1, 2, 3});
      CHECK(boxed.elements == Elements{7, 6, 11});
      CHECK(boxed.types.names == std::vector<std::string>{"7", "8", "49"});
      REQUIRE(boxed.cell.has_value());
      CHECK(boxed.cell->edges[0].x == 18.643);
      CHECK(boxed.cell->edges[2].z == 20);
      CHECK(boxed.bonds == std::vector<StatedBond>{{0, 1}, {1, 2}});
      const Particles bare = files.read(name, "     3" + title + "\n" + tinker_rows);
      CHECK(test::xs_of(bare) == Xs{1, 2, 3});
      CHECK_FALSE(bare.cell.has_value());
    }
  }
}

TEST_CASE("Tinker: the structures of an archive are frames") {
  const ParticleFiles files;
  const std::string box = " 9.0 9.0 9.0 90.0 90.0 90.0\n";
  const std::string archive = "3 first\n" + tinker_rows + "1 second\n" + box +
                              "1 C 9.0 0.0 0.0 1\n" + "1 third\n" + box + "1 O 8.0 0.0 0.0 1\n";
  const auto frame = [&](std::uint64_t number) {
    ParticleRequest request;
    request.frame = {number, false};
    return read_particles(files.write("a.arc", archive), request);
  };
  CHECK(test::xs_of(frame(0)) == Xs{1, 2, 3});
  CHECK(test::xs_of(frame(1)) == Xs{9});
  CHECK(test::xs_of(frame(2)) == Xs{8});
  CHECK(frame(2).cell.has_value());
}

TEST_CASE("Tinker: incomplete files are refused with their line") {
  const ParticleFiles files;
  CHECK(files.message("a.xyz", "4 a\n" + tinker_rows) ==
        "a.xyz:4: the file ends after 3 of 4 atoms: check that the file is complete");
  CHECK(files.message("a.xyz", "3 a\n1 C 0.0 0.0 0.0 1\n2 C 0.0 0.0 0.0 1\n3 C\n") ==
        "a.xyz:4: the line needs number, name, x, y, z and type of an atom: check the number of "
        "atoms in the frame's first line");
}

TEST_CASE("XYZ files are not taken for Tinker's") {
  const ParticleFiles files;
  CHECK(files.read("a.xyz", "2\n1 C 0.0 0.0 0.0 1\nC 1 2 3\nO 4 5 6\n").facts.format == "XYZ");
  CHECK(files.read("a.xyz", "1\n\n1 2 3 4 5 6\n").facts.format == "XYZ");
}

}  // namespace parray
