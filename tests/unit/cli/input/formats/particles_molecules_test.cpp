#include <doctest/doctest.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "cli/input/particles/elements.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::ParticleFiles;

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

std::vector<double> xs_of(const Particles& particles) {
  std::vector<double> xs;
  for (const Vec3d& p : particles.positions) xs.push_back(p.x);
  return xs;
}

using Xs = std::vector<double>;
using Elements = std::vector<std::uint8_t>;

/// mmCIF whose loop has these items and values.
std::string cif(const std::string& items, const std::string& values) {
  std::string text = "data_1ABC\n_entry.id 1ABC\nloop_\n";
  for (std::size_t at = 0; at < items.size();) {
    const std::size_t end = std::min(items.find(' ', at), items.size());
    text += "_atom_site." + items.substr(at, end - at) + "\n";
    at = end + 1;
  }
  return text + values + "\n#\n";
}

std::map<std::string, int> composition(const Particles& particles) {
  std::map<std::string, int> counts;
  for (const std::uint8_t number : particles.elements) {
    ++counts[std::string(element(number).symbol)];
  }
  return counts;
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

TEST_CASE("PDB: where the element is missing, the name's columns tell calcium from C-alpha") {
  const ParticleFiles files;
  const Particles particles =
      files.read("a.ent", record("ATOM", " CA", ' ', "ALA", 1, 1, 1, "") +
                              record("HETATM", "CA", ' ', " CA", 2, 2, 1, "") +
                              record("ATOM", "1HB", ' ', "ALA", 3, 3, 1, "") +
                              record("ATOM", "HG11", ' ', "VAL", 4, 4, 1, ""));
  CHECK(particles.elements == Elements{6, 20, 1, 1});
}

TEST_CASE("PDB: a record may end after its coordinates") {
  const ParticleFiles files;
  const std::string line = record("ATOM", " O", ' ', "HOH", 1, 1, 1, " O").substr(0, 54);
  CHECK(xs_of(files.read("a.pdb", line)) == Xs{1});
  CHECK(xs_of(files.read("a.pdb", line + "\r\nEND\r\n")) == Xs{1});
}

TEST_CASE("PDB: of alternative locations the fullest stays, the first of equals, in its place") {
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

TEST_CASE("PDB: of a residue that is one of two, the fuller one stays whole, the first of equals") {
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

TEST_CASE("mmCIF: the atoms of the first model are read from their loop") {
  const ParticleFiles files;
  const std::string items =
      "group_PDB id type_symbol label_alt_id label_atom_id label_comp_id "
      "label_seq_id auth_asym_id Cartn_x Cartn_y Cartn_z occupancy "
      "pdbx_PDB_model_num";
  const Particles particles = files.read("a.cif", cif(items,
                                                      "ATOM 1 C . CA ALA 1 A 1.5 2(1) 3 1 1\n"
                                                      "ATOM 2 O A \"O5'\" ALA 1 A 4 5 6 0.3 1\n"
                                                      "ATOM 3 O B \"O5'\" ALA 1 A 7 8 9 0.7 1\n"
                                                      "HETATM 4 FE ? FE HEM . B -1 -2 -3 . 1\n"
                                                      "ATOM 1 C . CA ALA 1 A 9 9 9 1 2"));
  CHECK(particles.positions == std::vector<Vec3d>{{1.5, 2, 3}, {7, 8, 9}, {-1, -2, -3}});
  CHECK(particles.elements == Elements{6, 8, 26});
  CHECK(particles.types.names == std::vector<std::string>{"C", "O", "Fe"});
}

TEST_CASE("mmCIF: a single atom outside a loop is read") {
  const ParticleFiles files;
  const std::string text =
      "data_x\n_cell.length_a 10\n_atom_site.Cartn_x 1\n_atom_site.cartn_Y 2\n"
      "_atom_site.CARTN_Z 3\n_atom_site.type_symbol 'Na'\n";
  for (const char* end : {"", "_cell.length_b 1\n", "loop_\n_a.b\n1 2 3\n", "data_y\n"}) {
    CAPTURE(end);
    const Particles particles = files.read("a.cif", text + end);
    CHECK(particles.positions == std::vector<Vec3d>{{1, 2, 3}});
    CHECK(particles.elements == Elements{11});
  }
}

TEST_CASE("mmCIF: text fields, comments, other loops and later blocks are passed over") {
  const ParticleFiles files;
  const std::string own = cif("type_symbol Cartn_x Cartn_y Cartn_z", "C 1 2 3");
  const std::string before =
      "# about\ndata_first\nloop_\n_a.b\n_a.c\n1 'two words'\n;text\n"
      "loop_ _atom_site.Cartn_x 9\n;\n4\n_d.e 5\n";
  CHECK(xs_of(files.read("a.cif", before + own)) == Xs{1});
  CHECK(xs_of(files.read("a.cif", own + cif("Cartn_x Cartn_y Cartn_z", "7 8 9"))) == Xs{1});
}

TEST_CASE("the shipped molecules have the atoms that their names promise") {
  const std::filesystem::path folder = PARRAY_SOURCE_DIR "/scenes/particles";
  CHECK(composition(read_particles(folder / "caffeine.xyz")) ==
        std::map<std::string, int>{{"C", 8}, {"H", 10}, {"N", 4}, {"O", 2}});
  CHECK(composition(read_particles(folder / "helix.pdb")) ==
        std::map<std::string, int>{{"C", 36}, {"N", 12}, {"O", 18}, {"S", 2}});
}

TEST_CASE("in the shipped molecules no two atoms are nearer than a bond is long") {
  for (const char* name : {"caffeine.xyz", "helix.pdb"}) {
    const auto particles =
        read_particles(std::filesystem::path(PARRAY_SOURCE_DIR) / "scenes" / "particles" / name);
    for (std::size_t i = 0; i < particles.count(); ++i) {
      double nearest = 1e9;
      for (std::size_t j = 0; j < particles.count(); ++j) {
        if (i == j) continue;
        nearest = std::min(nearest, length(particles.positions[i] - particles.positions[j]));
      }
      CHECK(nearest > 1.05);
      const bool water = particles.count() > 65 && i >= 65;
      if (!water) CHECK(nearest < 1.85);
    }
  }
}

}  // namespace parray
