#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "cli/input/formats/pdb_record.h"
#include "cli/input/particles/particle_summary.h"
#include "tests/support/molecule_files.h"
#include "tests/support/particle_columns.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::Elements;
using test::everything;
using test::ParticleFiles;
using test::pdb_line;
using test::Xs;
using test::xs_of;

/// A record of PDB with its fields in their columns.
std::string record(const std::string& kind, const std::string& name, char location,
                   const std::string& residue, int number, double x, double occupancy,
                   const std::string& element) {
  std::string line(120, '\0');
  line.resize(static_cast<std::size_t>(
      std::snprintf(line.data(), line.size(),
                    "%-6s%5d %-4s%c%3s A%4d    %8.3f%8.3f%8.3f%6.2f%6.2f          %2s\n",
                    kind.c_str(), 1, name.c_str(), location, residue.c_str(), number, x, 2 * x,
                    3 * x, occupancy, 0.0, element.c_str())));
  return line;
}

}  // namespace

TEST_CASE("PDB: atoms and hetero atoms of the first model are read, nothing else") {
  const ParticleFiles files;
  const std::string first = "HEADER    X\nREMARK   2\nMODEL        1\n" +
                            record("ATOM", " CA", ' ', "ALA", 1, 1.5, 1, " C") +
                            "ANISOU    1  CA  ALA A   1     2406   1892   1614\nTER\n" +
                            record("HETATM", "ZN", ' ', " ZN", 2, -2, 1, "ZN") +
                            "CONECT    1    2\n";
  const Particles particles =
      files.read("a.pdb", first + "ENDMDL\nMODEL        2\n" +
                              record("ATOM", " CA", ' ', "ALA", 1, 9, 1, " C") + "ENDMDL\nEND\n");
  CHECK(particles.positions == std::vector<Vec3d>{{1.5, 3, 4.5}, {-2, -4, -6}});
  CHECK(particles.elements == Elements{6, 30});
  CHECK(particles.types.names == std::vector<std::string>{"C", "Zn"});
  CHECK(particles.radii.empty());
}

TEST_CASE("PDB: without an element, the columns of the name distinguish calcium from C-alpha") {
  const ParticleFiles files;
  const Particles particles =
      files.read("a.ent", record("ATOM", " CA", ' ', "ALA", 1, 1, 1, "") +
                              record("HETATM", "CA", ' ', " CA", 2, 2, 1, "") +
                              record("ATOM", "1HB", ' ', "ALA", 3, 3, 1, "") +
                              record("ATOM", "HG11", ' ', "VAL", 4, 4, 1, ""));
  CHECK(particles.elements == Elements{6, 20, 1, 1});
}

TEST_CASE(
    "PDB: without an element, a small second letter in column 14 makes a symbol of two letters") {
  const ParticleFiles files;
  const Particles particles =
      files.read("a.pdb", record("ATOM", "Pt", ' ', "UNK", 1, 1, 1, "") +
                              record("ATOM", "Cl2", ' ', "UNK", 1, 2, 1, "") +
                              record("ATOM", "Co12", ' ', "LIG", 1, 3, 1, "") +
                              record("ATOM", " C1", ' ', "UNK", 1, 4, 1, "") +
                              record("ATOM", "Hg12", ' ', "LIG", 1, 5, 1, ""));
  CHECK(particles.elements == Elements{78, 17, 27, 6, 1});
  CHECK(test::note(particles, "guessed_elements") == 2);  // C1 and Hg12
}

TEST_CASE("PDB: without an element, one letter in column 14 is the symbol, except of a bead") {
  const ParticleFiles files;
  const Particles particles =
      files.read("a.pdb", record("ATOM", " F", ' ', "UNK", 1, 1, 1, "") +
                              record("ATOM", " K", ' ', "UNK", 1, 2, 1, "") +
                              record("ATOM", " W", ' ', "LIG", 1, 3, 1, "") +
                              record("ATOM", " W", ' ', "  W", 1, 4, 1, ""));
  CHECK(particles.elements == Elements{9, 19, 74, 0});
  CHECK(test::note(particles, "guessed_elements") == 0);
  CHECK(test::note(particles, "unknown_elements") == 1);
}

TEST_CASE("PDB: residues that differ only by the insertion code are different residues") {
  const ParticleFiles files;
  const auto inserted = [](double x, char code) {
    std::string line = record("ATOM", " CA", ' ', "PRO", 60, x, 1, " C");
    line[26] = code;
    return line;
  };
  const Particles particles = files.read(
      "a.pdb", inserted(1, ' ') + inserted(2, 'B') + inserted(3, 'B') + inserted(4, 'C'));
  CHECK(particles.insertion_codes == std::vector<char>{' ', 'B', 'B', 'C'});
  CHECK(input::summary_of(particles).residues == 3);
  CHECK(files.read("b.pdb", inserted(1, ' ')).insertion_codes.empty());
}

TEST_CASE("PDB: a record may end after its coordinates") {
  const ParticleFiles files;
  const std::string line = record("ATOM", " O", ' ', "HOH", 1, 1, 1, " O").substr(0, 54);
  CHECK(xs_of(files.read("a.pdb", line)) == Xs{1});
  CHECK(xs_of(files.read("a.pdb", line + "\r\nEND\r\n")) == Xs{1});
}

TEST_CASE("PDB: the alternative location of highest occupancy stays, or the first of equal ones") {
  const ParticleFiles files;
  const auto at = [](const char* name, char location, double x, double occupancy) {
    return record("ATOM", name, location, "SER", 7, x, occupancy, "");
  };
  CHECK(xs_of(files.read("a.pdb", at(" CB", 'A', 1, 0.4) + at(" CB", 'B', 2, 0.6) +
                                      at(" OG", 'A', 3, 0.5) + at(" OG", 'B', 4, 0.5) +
                                      at(" C", ' ', 5, 1))) == Xs{2, 3, 5});
  // Also where the locations stand apart, as whole conformers.
  CHECK(xs_of(files.read("a.pdb", at(" CB", 'A', 1, 0.4) + at(" OG", 'A', 3, 0.4) +
                                      at(" CB", 'B', 2, 0.6) + at(" OG", 'B', 4, 0.6))) ==
        Xs{2, 4});
  // Another residue is another atom.
  CHECK(xs_of(files.read("a.pdb", at(" CB", 'A', 1, 0.4) + record("ATOM", " CB", 'B', "SER", 8, 2,
                                                                  0.6, ""))) == Xs{1, 2});
}

TEST_CASE("PDB: of two alternative residues, the one of higher occupancy stays whole") {
  const ParticleFiles files;
  const auto text = [](double first, double second) {
    return record("ATOM", " CB", 'A', "SER", 7, 1, first, "") +
           record("ATOM", " OG", 'A', "SER", 7, 2, first, "") +
           record("ATOM", " CB", 'B', "THR", 7, 3, second, "") +
           record("ATOM", " CG2", 'B', "THR", 7, 4, second, "");
  };
  CHECK(xs_of(files.read("a.pdb", text(0.4, 0.6))) == Xs{3, 4});
  CHECK(xs_of(files.read("a.pdb", text(0.5, 0.5))) == Xs{1, 2});
}

TEST_CASE("PDB: a residue name of four letters from column 17 on is not an alternative location") {
  const ParticleFiles files;
  const auto lines = [](char letter, const char* residue) {
    return pdb_line(" C11", letter, residue, 1, 1) + pdb_line(" C11", letter, residue, 1, 2) +
           pdb_line(" P", letter, residue, 1, 3);
  };
  // By itself "P" before "OPC" could be a location: but all atoms have it, and none is partly
  // there.
  std::string four = lines(' ', "POP");
  for (std::size_t at = four.find("POP "); at != std::string::npos; at = four.find("POP ")) {
    four.replace(at, 4, "POPC");
  }
  for (const std::string& text : {lines('P', "OPC"), four}) {
    const Particles particles = files.read("a.pdb", text);
    CHECK(xs_of(particles) == Xs{1, 2, 3});
    CHECK(particles.residue_names.names == std::vector<std::string>{"POPC"});
    CHECK(test::note(particles, "alternatives") == 0);
  }
}

TEST_CASE("PDB: atoms that share name and letter of their location all stay") {
  const ParticleFiles files;
  const Particles particles = files.read("a.pdb", pdb_line(" H", 'A', "LIG", 1, 1, 0.5) +
                                                      pdb_line(" H", 'A', "LIG", 1, 2, 0.5) +
                                                      pdb_line(" H", 'B', "LIG", 1, 3, 0.5));
  CHECK(xs_of(particles) == Xs{1, 2});
  REQUIRE(particles.facts.notes.size() == 1);
  CHECK(particles.facts.notes[0].count == 1);
  CHECK(particles.facts.notes[0].text == "alternative location left out");
}

TEST_CASE("PDB: a request can choose all alternative locations or those of one letter") {
  const ParticleFiles files;
  const std::string text =
      pdb_line(" CB", 'A', "SER", 7, 1, 0.6) + pdb_line(" CB", 'B', "SER", 7, 2, 0.4) +
      pdb_line(" OG", 'A', "SER", 7, 3, 0.5) + pdb_line(" OG", 'C', "SER", 7, 4, 0.5) +
      pdb_line(" C", ' ', "SER", 7, 5, 1);
  const auto xs = [&](const char* alternatives) {
    ParticleRequest request;
    request.alternatives = alternatives_from(alternatives);
    return xs_of(read_particles(files.write("a.pdb", text), request));
  };
  CHECK(xs("best") == Xs{1, 3, 5});
  CHECK(files.read("a.pdb", text).index_of(1) == 1);  // not counting what was left out
  CHECK(xs("all") == Xs{1, 2, 3, 4, 5});
  CHECK(xs("B") == Xs{2, 3, 5});  // of an atom without B, the best
  CHECK(xs("C") == Xs{1, 4, 5});
  CHECK_THROWS_AS(alternatives_from("AB"), InputError);
  CHECK_THROWS_AS(alternatives_from(""), InputError);
  CHECK(text_of(alternatives_from("B")) == "B");
}

TEST_CASE("PDB: without a column of elements, names that start in column 13 are not metals") {
  const ParticleFiles files;
  const Particles particles =
      files.read("a.pdb", pdb_line("CA", ' ', "ALA", 1, 1) + pdb_line("HG", ' ', "SER", 2, 2) +
                              pdb_line("CE", ' ', "LYS", 3, 3) + pdb_line("CA", ' ', "LIG", 4, 4) +
                              pdb_line("CAL", ' ', "CAL", 5, 5) + pdb_line("CA", ' ', " CA", 6, 6));
  CHECK(particles.elements == Elements{6, 1, 6, 6, 20, 20});
  CHECK(test::note(particles, "guessed_elements") == 6);
}

TEST_CASE("PDB: invalid elements and elements that repeat the name are corrected with a note") {
  const ParticleFiles files;
  const Particles particles = files.read("a.pdb", pdb_line(" CA", ' ', "ALA", 1, 1, 1, "CA") +
                                                      pdb_line(" CB", ' ', "ALA", 1, 2, 1, "A1") +
                                                      pdb_line("ZN", ' ', " ZN", 2, 3, 1, "ZN") +
                                                      pdb_line("CA", ' ', " CA", 3, 4, 1, "CA"));
  CHECK(particles.elements == Elements{6, 6, 30, 20});
  CHECK(test::note(particles, "mended_elements") == 1);
  CHECK(test::note(particles, "guessed_elements") == 1);
}

TEST_CASE("PDB: the entry name in columns 73 to 80 of old files is not an element or a chain") {
  const ParticleFiles files;
  const std::string line =
      "ATOM     39  CB  ASN     6      -7.206  17.820  24.791  1.00  0.00      1GPDF  6\n";
  const Particles particles = files.read("a.pdb", line);
  CHECK(particles.elements == Elements{6});
  CHECK(particles.chains.empty());
}

TEST_CASE("PDB: a note counts particles without an element, except virtual sites") {
  const ParticleFiles files;
  const Particles particles =
      files.read("a.pdb", pdb_line(" OW", ' ', "SOL", 1, 1) + pdb_line(" MW", ' ', "SOL", 1, 2) +
                              pdb_line(" ?7", ' ', "LIG", 2, 3));
  CHECK(particles.elements == Elements{8, 0, 0});
  CHECK(test::note(particles, "unknown_elements") == 1);
}

TEST_CASE("PDB: records in lower case and with tabs are read") {
  const ParticleFiles files;
  std::string lower = pdb_line(" CA", ' ', "ALA", 1, 1.5, 1, " C");
  std::ranges::transform(lower, lower.begin(),
                         [](char c) { return static_cast<char>(std::tolower(c)); });
  CHECK(xs_of(files.read("a.pdb", lower + "end\n")) == Xs{1.5});
  const Particles tabs =
      files.read("a.pdb", "ATOM\t1\tCA\tALA\tA\t12\t1.5\t2.5\t3.5\t1.00\t0.00\tC\nEND\n");
  CHECK(tabs.positions == std::vector<Vec3d>{{1.5, 2.5, 3.5}});
  CHECK(tabs.elements == Elements{6});
  CHECK(tabs.residue_numbers == std::vector<std::int32_t>{12});
  CHECK(tabs.chains.names == std::vector<std::string>{"A"});
}

TEST_CASE("PDB: serial numbers of six digits shift a line, and residue numbers overflow") {
  const ParticleFiles files;
  const std::string long_serial =
      "ATOM  100000  CA  ALA A   1       1.500   2.500   3.500  1.00  0.00           C\n"
      "HETATM100001  O   HOH A9999       4.500   2.500   3.500  1.00  0.00           O\n"
      "HETATM*****  O   HOH A****       5.500   2.500   3.500  1.00  0.00           O\n"
      "HETATM186a0  O   HOH AA000       6.500   2.500   3.500  1.00  0.00           O\n";
  const Particles particles = files.read("a.pdb", long_serial);
  CHECK(xs_of(particles) == Xs{1.5, 4.5, 5.5, 6.5});
  CHECK(particles.residue_numbers == std::vector<std::int32_t>{1, 9999, 0, 10000});
  CHECK(particles.elements == Elements{6, 8, 8, 8});
  CHECK(residue_number_in("A000") == 10000);
  CHECK(residue_number_in("ZZZZ") == 10000 + 26 * 36 * 36 * 36 - 1);
  CHECK(residue_number_in("-5") == -5);
  CHECK(residue_number_in("27a1") == 0x27a1);
  CHECK(!residue_number_in("****"));
}

TEST_CASE("PDB: coordinates outside their columns are read if blanks separate them") {
  const ParticleFiles files;
  CHECK(files
            .read("a.pdb",
                  "ATOM      1  CA  ALA A   1    -10001.500 20002.500 30003.500  1.00  0.00        "
                  "   C\n")
            .positions == std::vector<Vec3d>{{-10001.5, 20002.5, 30003.5}});
  CHECK(
      files.message("a.pdb",
                    "ATOM      1  CA  ALA A   1    -10001.500-20002.500-30003.500  1.00  0.00\n") !=
      "no error");
}

TEST_CASE("PDB: END separates frames as ENDMDL does, CRYST1 is the cell of those after it") {
  const ParticleFiles files;
  const std::string text =
      "CRYST1   10.000   20.000   30.000  90.00  90.00  90.00 P 1           1\n" +
      pdb_line(" O", ' ', "HOH", 1, 1) + "END\n" +
      "CRYST1   11.000   20.000   30.000  90.00  90.00  90.00 P 1           1\n" +
      pdb_line(" O", ' ', "HOH", 1, 2) + "END\n" + "MODEL        3\n" +
      pdb_line(" O", ' ', "HOH", 1, 3) + "ENDMDL\nEND\n";
  for (std::uint64_t frame = 0; frame < 3; ++frame) {
    ParticleRequest request = everything;
    request.frame = {frame, false};
    const Particles particles = read_particles(files.write("a.pdb", text), request);
    CHECK(xs_of(particles) == Xs{static_cast<double>(frame + 1)});
    REQUIRE(particles.cell.has_value());
    CHECK(particles.cell->edges[0].x == (frame == 0 ? 10 : 11));
    CHECK(particles.cell->edges[2] == Vec3d{0, 0, 30});
    CHECK(particles.facts.frames == 3);
  }
  const std::string behind =
      pdb_line(" O", ' ', "HOH", 1, 1) + "ENDMDL\n" + text.substr(0, text.find('\n') + 1);
  REQUIRE(files.read("a.pdb", behind).cell.has_value());
  const std::string none =
      "CRYST1    1.000    1.000    1.000  90.00  90.00  90.00 P 1           1\n";
  CHECK(!files.read("a.pdb", none + pdb_line(" O", ' ', "HOH", 1, 1)).cell);
}

TEST_CASE("PDB: numbers, names, chains and segments are read on request") {
  const ParticleFiles files;
  const std::string line =
      "HETATM    3 ZN    ZN B   2A     -1.000   2.000   3.000  0.75 12.50          ZN2+\n"
      "ATOM      4  CA  ALA     3       1.000   2.000   3.000  1.00  0.00      SEGA\n";
  const Particles particles = read_particles(files.write("a.pdb", line), everything);
  REQUIRE(particles.numbers.size() == 3);
  CHECK(particles.numbers[0].name == "occupancy");
  CHECK(particles.numbers[0].values == std::vector<double>{0.75, 1});
  CHECK(particles.numbers[1].values == std::vector<double>{12.5, 0});
  CHECK(particles.numbers[2].values[0] == 2);
  CHECK(std::isnan(particles.numbers[2].values[1]));
  CHECK(particles.chains.names == std::vector<std::string>{"B", "SEGA"});
  CHECK(particles.residue_numbers == std::vector<std::int32_t>{2, 3});
  CHECK(particles.atom_names.names == std::vector<std::string>{"ZN", "CA"});
  CHECK(files.read("a.pdb", line).numbers.empty());
}

TEST_CASE("PDB: of a mutant and the wild type, the residue of higher occupancy stays") {
  const ParticleFiles files;
  CHECK(xs_of(files.read("a.pdb", pdb_line(" CB", 'A', "SER", 7, 1, 0.4) +
                                      pdb_line(" CB", 'B', "THR", 7, 2, 0.6) +
                                      pdb_line(" CG2", 'B', "THR", 7, 3, 0.6))) == Xs{2, 3});
}

TEST_CASE("PDBQT: AutoDock's types give elements, its charges are partial") {
  const ParticleFiles files;
  const std::string text =
      "REMARK\nROOT\n"
      "ATOM      1  CA  LIG A   1       1.000   2.000   3.000  1.00  0.00    +0.123 A \n"
      "ATOM      2  N1  LIG A   1       2.000   2.000   3.000  1.00  0.00    -0.250 NA\n"
      "ATOM      3  H   LIG A   1       3.000   2.000   3.000  1.00  0.00     0.163 HD\n"
      "ATOM      4  CL  LIG A   1       4.000   2.000   3.000  1.00  0.00    -0.050 Cl\n"
      "ATOM      5  G   LIG A   1       5.000   2.000   3.000  1.00  0.00     0.000 G0\n"
      "ATOM      6  C   LIG A   1       6.000   2.000   3.000  1.00  0.00     0.000 CG0\n"
      "ENDROOT\nTORSDOF 0\n";
  const Particles particles = read_particles(files.write("a.pdbqt", text), everything);
  CHECK(particles.elements == Elements{6, 7, 1, 17, 0, 6});
  CHECK(particles.types.names == std::vector<std::string>{"A", "NA", "HD", "Cl", "G0", "CG0"});
  REQUIRE(particles.numbers.size() == 3);
  CHECK(particles.numbers[2].values[0] == doctest::Approx(0.123));
  CHECK(test::note(particles, "unknown_elements") == 0);  // the glue is a virtual site
}

TEST_CASE("PQR: fields separated by blanks, with and without a chain, give charges and radii") {
  const ParticleFiles files;
  const std::string text =
      "REMARK\n"
      "ATOM      1  N   ALA A   1      1.0 2.0 3.0 -0.4 1.55\n"
      "ATOM 2 CA ALA 2 4 5.5 6.0 0.1 2.0\n"
      "HETATM 3 HG1 SER 3B 7.0 8.0 9.0 0.3 0\n"
      "ATOM      4  I   ION12     -1.000    0.000   0.000  1.00 1.98\n"
      "TER\nEND\n";
  CHECK(files.message("a.pqr", text) != "no error");  // x of the second has no decimal point
  std::string good = text;
  good.replace(good.find(" 4 5.5"), 6, " 4.0 5.5");
  const Particles particles = read_particles(files.write("a.pqr", good), everything);
  CHECK(particles.positions == std::vector<Vec3d>{{1, 2, 3}, {4, 5.5, 6}, {7, 8, 9}, {-1, 0, 0}});
  CHECK(particles.elements == Elements{7, 6, 1, 53});
  CHECK(particles.radii == std::vector<double>{1.55, 2, 1.1, 1.98});
  CHECK(test::note(particles, "zero_radii") == 1);
  CHECK(std::ranges::count(particles.facts.notes,
                           "radius of 0 replaced by the van der Waals radius",
                           &ParticleNote::text) == 1);
  CHECK(particles.residue_numbers == std::vector<std::int32_t>{1, 2, 3, 12});
  CHECK(particles.chains.names == std::vector<std::string>{"A", ""});
  REQUIRE(particles.numbers.size() == 1);
  CHECK(particles.numbers[0].values == std::vector<double>{-0.4, 0.1, 0.3, 1});
}

TEST_CASE("PQR: without blanks between fields, the columns of PDB separate them") {
  const ParticleFiles files;
  const Particles particles = files.read(
      "a.pqr", "ATOM  12345 HD11 LEU A1000    -110.123-100.456 -99.000  0.1000 1.2000\n");
  CHECK(particles.positions == std::vector<Vec3d>{{-110.123, -100.456, -99}});
  CHECK(particles.elements == Elements{1});
  const std::string whole = "ATOM 1 N ALA 1 1.0 2.0 3.0 0.5 1.5\n";
  CHECK(files.message("a.pqr", whole + whole + "ATOM 2 C ALA 1 1.0 2.0 3.0 0.5\n") != "no error");
}

}  // namespace parray
