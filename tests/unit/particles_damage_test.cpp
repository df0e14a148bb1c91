#include <doctest/doctest.h>

#include <cmath>
#include <map>
#include <string>

#include "common/input/particles/elements.h"
#include "common/scene/limits.h"
#include "tests/support/dice.h"
#include "tests/support/memory.h"
#include "tests/support/particle_files.h"

namespace parray {
namespace {

using test::bytes_of;
using test::Dice;
using test::ParticleFiles;

std::string binary_ply() {
  std::string text =
      "ply\nformat binary_big_endian 1.0\nelement vertex 6\nproperty float x\nproperty double y\n"
      "property float z\nproperty float radius\nproperty uchar red\nproperty uchar green\n"
      "property uchar blue\nproperty list ushort int l\nelement face 1\nproperty list uchar int v\n"
      "end_header\n";
  constexpr auto big = std::endian::big;
  for (int i = 0; i < 6; ++i) {
    text += bytes_of(static_cast<float>(i), big) + bytes_of(0.5 * i, big) + bytes_of(-1.0F, big) +
            bytes_of(0.25F, big) + "abc" + bytes_of(std::uint16_t{1}, big) + bytes_of(i, big);
  }
  return text + "\2" + bytes_of(0, big) + bytes_of(1, big);
}

std::map<std::string, std::string> valid_files() {
  return {
      {"a.ply",
       "ply\nformat ascii 1.0\ncomment x\nelement vertex 3\nproperty float x\nproperty float y\n"
       "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
       "property list uchar int l\nend_header\n1 2 3 255 0 9 1 7\n4 5 6 0 0 0 0\n7 8 9 1 1 1 0\n"},
      {"b.ply", binary_ply()},
      {"a.csv",
       "# table\nx,y,z,radius,element,type,red,green,blue\n1,2,3,0.5,C,\"a \"\"b\"\"\",0,0.5,1\n"
       "4,5,6,0.25,8,b,1,1,1\n-7,8e2,9,0.125,X,a,0,0,0\n"},
      {"a.xyz",
       "3\nLattice=\"1 0 0 0 1 0 0 0 1\" Properties=species:S:1:pos:R:3:radius:R:1:color:R:3\n"
       "C 1 2 3 0.5 0 0 1\nO 4 5 6 0.5 0 1 1\nQq 7 8 9 0.5 0 0 1\n"},
      {"a.dump",
       "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS xy xz yz pp pp pp\n8 15 1\n"
       "20 23.5 -2\n30 35 0.5\nITEM: ATOMS id type element xs ys zs diameter\n1 1 C 0 0.5 1 2\n"
       "2 3 O 1 0 0 2.5\nITEM: TIMESTEP\n1\n"},
      {"a.pdb",
       "HEADER    X\nMODEL        1\n"
       "ATOM      1  CA AALA A   1       1.000   2.000   3.000  0.40  0.00           C\n"
       "ATOM      2  CA BALA A   1       4.000   5.000   6.000  0.60  0.00           C\n"
       "HETATM    3 ZN    ZN A   2      -1.000   2.000   3.000  1.00  0.00          ZN2+\n"
       "ENDMDL\nEND\n"},
      {"a.cif",
       "data_a\n_entry.id 'a b'\nloop_\n_atom_site.type_symbol\n_atom_site.label_alt_id\n"
       "_atom_site.label_atom_id\n_atom_site.Cartn_x\n_atom_site.Cartn_y\n_atom_site.Cartn_z\n"
       "_atom_site.occupancy\n_atom_site.pdbx_PDB_model_num\nC A \"C'\" 1 2 3 0.4 1\n"
       "C B \"C'\" 4 5 6(2) 0.6 1\nFE . FE 7 8 9 . 1\nO . O 1 1 1 1 "
       "2\n#\nloop_\n_x.y\n;text\n;\n2\n"}};
}

/// One to three mild injuries: bytes changed, cut out, doubled, moved; or the end cut off.
void damage(std::string& text, Dice& dice) {
  for (std::uint64_t n = 1 + dice.below(3); n > 0 && !text.empty(); --n) {
    const std::size_t place = dice.below(text.size());
    const std::size_t length = 1 + dice.below(12);
    constexpr std::string_view likely = "0123456789-+.eE,;:\"'# \t\n\r\0nN\xFF_";
    switch (dice.below(7)) {
      case 0:
        text[place] = static_cast<char>(dice.below(256));
        break;
      case 1:
        text[place] = static_cast<char>(text[place] ^ (1 << dice.below(8)));
        break;
      case 2:
        text[place] = likely[dice.below(likely.size())];
        break;
      case 3:
        text.erase(place, length);
        break;
      case 4:
        text.insert(place, text.substr(dice.below(text.size()), length));
        break;
      case 5:
        text.insert(place, std::string(length, likely[dice.below(likely.size())]));
        break;
      default:
        if (dice.one_in(3)) text.resize(place);
    }
  }
}

bool in_range(double value, double low, double high) { return value >= low && value <= high; }

/// What the header of Particles promises.
void check_promises(const Particles& particles) {
  const std::size_t count = particles.count();
  CHECK(count > 0);
  CHECK((particles.radii.empty() || particles.radii.size() == count));
  CHECK((particles.colors.empty() || particles.colors.size() == count));
  CHECK((particles.elements.empty() || particles.elements.size() == count));
  CHECK((particles.types.empty() || particles.types.size() == count));
  bool good = true;
  for (const Vec3d& p : particles.positions) {
    for (const double c : {p.x, p.y, p.z}) {
      good = good && in_range(std::abs(c), 0, limits::max_length);
    }
  }
  for (const double r : particles.radii) {
    good = good && in_range(r, limits::min_radius, limits::max_length);
  }
  for (const Vec3d& color : particles.colors) {
    for (const double c : {color.x, color.y, color.z}) good = good && in_range(c, 0, 1);
  }
  for (const std::uint8_t element : particles.elements) good = good && element <= last_element;
  for (const std::uint32_t type : particles.types) {
    good = good && type < particles.type_names.size();
  }
  CHECK(good);
}

/// Reads a file damaged in `rounds` ways; how many of them were read and how many refused.
std::pair<int, int> read_damaged(const std::string& name, const std::string& valid, int rounds) {
  const ParticleFiles files;
  int read = 0;
  int refused = 0;
  for (int seed = 0; seed < rounds; ++seed) {
    Dice dice(static_cast<std::uint64_t>(seed));
    std::string text = valid;
    damage(text, dice);
    CAPTURE(seed);
    CAPTURE(name);
    try {  // anything but an InputError fails the test
      check_promises(files.read(name, text));
      ++read;
    } catch (const InputError& error) {
      const std::string message = error.what();
      CHECK(message.find(name) != std::string::npos);
      CHECK(message.find('\n') == std::string::npos);
      CHECK(message.size() < 400);
      ++refused;
    }
  }
  return {read, refused};
}

}  // namespace

TEST_CASE("files damaged in thousands of ways are read as valid particles or refused") {
  const std::uint64_t before = test::peak_address_space();
  for (const auto& file : valid_files()) {
    const std::string& name = file.first;
    const std::string& valid = file.second;
    CAPTURE(name);
    REQUIRE(ParticleFiles().message(name, valid) == "no error");
    const auto [read, refused] = read_damaged(name, valid, 2000);
    CHECK(read > 100);  // mild enough to get far into the reader
    CHECK(refused > 100);
  }
  // A count that is believed takes gigabytes; the address sanitizer keeps 256 MiB of freed memory.
  CHECK(test::peak_address_space() - before < 1'000'000'000);
}

TEST_CASE("packed files damaged in many ways are read or refused") {
  for (const auto& [name, valid] : valid_files()) {
    const auto [read, refused] = read_damaged(name + ".gz", test::packed(valid), 300);
    CHECK(read + refused == 300);
    CHECK(refused > 200);
  }
}

TEST_CASE("every beginning of a file is read or refused") {
  const ParticleFiles files;
  for (const auto& file : valid_files()) {
    const std::string& name = file.first;
    const std::string& valid = file.second;
    CAPTURE(name);
    for (std::size_t length = 0; length < valid.size(); ++length) {
      try {
        check_promises(files.read(name, valid.substr(0, length)));
      } catch (const InputError& error) {
        CHECK(std::string(error.what()).find(name) != std::string::npos);
      }
    }
  }
}

}  // namespace parray
