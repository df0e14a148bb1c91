#include <doctest/doctest.h>

#include <map>
#include <string>
#include <vector>

#include "cli/input/formats/format_table.h"
#include "cli/input/particles/elements.h"
#include "cli/output/picture/srgb.h"
#include "tests/support/molecule_files.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::bytes_of;
using test::packed;
using test::ParticleFiles;

std::vector<Vec3d> three() { return {{1, -2, 3.5}, {0, 0.25, -1e3}, {-0.125, 7, 0}}; }

std::string ply_header(const std::string& format, const std::string& properties) {
  return "ply\nformat " + format + " 1.0\ncomment made by hand\nelement vertex 3\n" + properties +
         "end_header\n";
}

constexpr const char* xyz_properties = "property float x\nproperty double y\nproperty float z\n";

std::string binary_positions(std::endian order) {
  std::string bytes;
  for (const Vec3d& p : three()) {
    bytes += bytes_of(static_cast<float>(p.x), order) + bytes_of(p.y, order) +
             bytes_of(static_cast<float>(p.z), order);
  }
  return bytes;
}

std::vector<std::string> types_of(const Particles& particles) {
  std::vector<std::string> types;
  for (const std::uint32_t type : particles.types.index) {
    types.push_back(particles.types.names.at(type));
  }
  return types;
}

/// The text as Windows' editors save it.
std::string with_crlf(const std::string& text) {
  std::string result;
  for (const char c : text) result += c == '\n' ? std::string("\r\n") : std::string(1, c);
  return result;
}

using Names = std::vector<std::string>;
using Elements = std::vector<std::uint8_t>;

}  // namespace

TEST_CASE("a file's name says its format by its extension, whatever its case and packing") {
  const std::map<std::string, std::string> known = {{"a.ply", "PLY"},
                                                    {"a.CSV", "CSV"},
                                                    {"a.xyz", "XYZ"},
                                                    {"a.extxyz.gz", "XYZ"},
                                                    {"a.lammpstrj", "LAMMPS dump"},
                                                    {"a.b.dump", "LAMMPS dump"},
                                                    {"a.pdb.GZ", "PDB"},
                                                    {"a.ent", "PDB"},
                                                    {"a.pdb1", "PDB"},
                                                    {"a.cif.zst", "CIF"},
                                                    {"a.ply.BZ2", "PLY"},
                                                    {"a.xyz.xz", "XYZ"},
                                                    {"dir.x/a.cif", "CIF"},
                                                    {"a.mmcif", "CIF"}};
  for (const auto& [name, format] : known) CHECK(format_by_name(name)->name == format);
  for (const char* name : {"a.json", "a", ".gz", "a.gz", "ply", "a.ply.lz4", "dir.ply/a"}) {
    CHECK(format_by_name(name) == nullptr);
  }
}

TEST_CASE("PLY is read as text and as binary data of both byte orders") {
  const ParticleFiles files;
  const std::string ascii =
      ply_header("ascii", xyz_properties) + "1 -2 3.5\n0 0.25 -1e3\n-0.125 7 0\n";
  const std::string little =
      ply_header("binary_little_endian", xyz_properties) + binary_positions(std::endian::little);
  const std::string big =
      ply_header("binary_big_endian", xyz_properties) + binary_positions(std::endian::big);
  for (const std::string& file : {ascii, little, big, packed(ascii), packed(big)}) {
    const Particles particles = files.read("a.ply", file);
    CHECK(particles.positions == three());
    CHECK(particles.radii.empty());
    CHECK(particles.colors.empty());
    CHECK(particles.elements.empty());
    CHECK(particles.types.empty());
    CHECK(particles.types.names.empty());
  }
}

TEST_CASE("every scalar type of PLY is read, signed where it is") {
  const ParticleFiles files;
  const std::string header =
      "ply\nformat binary_big_endian 1.0\nelement vertex 1\nproperty char x\nproperty short y\n"
      "property int32 z\nproperty uint8 a\nproperty ushort b\nproperty uint c\nproperty float64 "
      "radius\nend_header\n";
  constexpr auto big = std::endian::big;
  const Particles particles = files.read(
      "a.ply", header + bytes_of(std::int8_t{-1}, big) + bytes_of(std::int16_t{-300}, big) +
                   bytes_of(std::int32_t{-70000}, big) + bytes_of(std::uint8_t{255}, big) +
                   bytes_of(std::uint16_t{65535}, big) + bytes_of(std::uint32_t{1}, big) +
                   bytes_of(0.3, big));
  CHECK(particles.positions == std::vector<Vec3d>{{-1, -300, -70000}});
  CHECK(particles.radii == std::vector<double>{0.3});
}

TEST_CASE("PLY's radii and colours are read: uchar with the sRGB curve, float as it is") {
  const ParticleFiles files;
  const std::string one =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
      "property float y\nproperty float z\n";
  Particles particles =
      files.read("a.ply", one +
                              "property float radius\nproperty uchar red\nproperty uchar green\n"
                              "property uchar blue\nend_header\n1 2 3 0.5 255 128 0\n");
  CHECK(particles.radii == std::vector<double>{0.5});
  CHECK(particles.colors == std::vector<Vec3d>{{1, srgb_decode(128.0 / 255), 0}});
  particles = files.read("a.ply", one +
                                      "property float red\nproperty float green\n"
                                      "property float blue\nend_header\n1 2 3 1 0.5 0\n");
  CHECK(particles.colors == std::vector<Vec3d>{{1, 0.5, 0}});
  particles = files.read("a.ply", one + "property float r\nend_header\n1 2 3 4\n");
  CHECK(particles.radii == std::vector<double>{4});
  particles = files.read("a.ply", one +
                                      "property uchar r\nproperty uchar g\nproperty uchar b\n"
                                      "end_header\n1 2 3 4 0 255\n");
  CHECK(particles.radii.empty());
  CHECK(particles.colors == std::vector<Vec3d>{{srgb_decode(4.0 / 255), 0, 1}});
}

TEST_CASE("PLY's other properties, lists and elements are passed over, before and after") {
  const ParticleFiles files;
  const std::string header = R"(
element camera 2
property list uchar int values
property double focus
element vertex 2
property list ushort double before
property float x
property float quality
property float y
property float z
property list uint8 uint8 after
element face 1
property list uchar int vertex_indices
end_header
)";
  const Particles ascii = files.read("a.ply", "ply\nformat ascii 1.0" + header + R"(2 7 8 0.5
0 nan
1 9.5 1 nan 2 3 0
0 4 x 5 6 3 1 2 3
3 0 1 1
)");
  const auto count = [](int n) { return bytes_of(static_cast<std::uint8_t>(n)); };
  const Particles binary = files.read(
      "b.ply", "ply\nformat binary_little_endian 1.0" + header +  //
                   count(2) + bytes_of(7) + bytes_of(8) + bytes_of(0.5) + count(0) + bytes_of(0.5) +
                   bytes_of(std::uint16_t{1}) + bytes_of(9.5) + bytes_of(1.0F) + bytes_of(NAN) +
                   bytes_of(2.0F) + bytes_of(3.0F) + count(0) +  //
                   bytes_of(std::uint16_t{0}) + bytes_of(4.0F) + bytes_of(9.0F) + bytes_of(5.0F) +
                   bytes_of(6.0F) + count(3) + "abc" +  //
                   count(3) + bytes_of(0) + bytes_of(1) + bytes_of(1));
  const std::vector<Vec3d> expected{{1, 2, 3}, {4, 5, 6}};
  CHECK(ascii.positions == expected);
  CHECK(binary.positions == expected);
}

TEST_CASE("CSV is read with every separator, quotes, comments and any letter case") {
  const ParticleFiles files;
  const std::vector<std::string> tables = {
      "x,y,z,type\n1,-2,3.5,a\n0,0.25,-1e3,b c\n-0.125,7,0,a\n",
      "# made by hand\n\n Type ; X;Y;Z\na;1;-2;3.5\n#x\nb c;0;+0.25;-1E3\n \t\na;-0.125;7;0",
      "x\ty\tz\ttype\tnote\n1\t-2\t3.5\ta\t\n0\t0.25\t-1e3\tb c\t,;\n-0.125\t7\t0\ta\tx",
      "  x y   z   type\n1 -2 3.5 a\n0 0.25 -1e3 \"b c\"\n\t-0.125 7 0 a  \n",
      ("\xEF\xBB\xBF\"x\",\"y\",\"z\",\"a,\"\"b\"\"\",\"type\"\r\n\"1\",-2,3.5,\"\",a\r\n"
       "0,0.25,-1e3,\"\"\"\",\"b c\"\r\n-0.125, 7 ,0,,\"a\" \r\n")};
  for (const std::string& table : tables) {
    CAPTURE(table);
    const Particles particles = files.read("a.csv", table);
    CHECK(particles.positions == three());
    CHECK(types_of(particles) == Names{"a", "b c", "a"});
    CHECK(particles.types.names == Names{"a", "b c"});
    CHECK(particles.elements.empty());
    CHECK(particles.radii.empty());
  }
}

TEST_CASE("CSV: a quote after empty tab-separated fields keeps its column") {
  const ParticleFiles files;
  const Particles particles = files.read("a.csv", "a\tb\tx\ty\tz\n\t\t\"1\"\t2\t3\n");
  CHECK(particles.positions == std::vector<Vec3d>{{1, 2, 3}});
}

TEST_CASE("CSV: r is a radius, but red where g and b stand beside it") {
  const ParticleFiles files;
  CHECK(files.read("a.csv", "x,y,z,r\n0,0,0,2\n").radii == std::vector<double>{2});
  const Particles colored = files.read("a.csv", "x,y,z,r,g,b\n0,0,0,1,0.5,0\n");
  CHECK(colored.radii.empty());
  CHECK(colored.colors == std::vector<Vec3d>{{1, 0.5, 0}});
  const Particles both = files.read("a.csv", "x,y,z,red,green,blue,r\n0,0,0,1,0.5,0,3\n");
  CHECK(both.radii == std::vector<double>{3});
  CHECK(both.colors == std::vector<Vec3d>{{1, 0.5, 0}});
}

TEST_CASE("CSV: colours above 1 anywhere make the whole file 8-bit sRGB") {
  const ParticleFiles files;
  const Particles particles =
      files.read("a.csv", "x,y,z,Red,Green,Blue\n0,0,0,1,0,1\n0,0,1,255,128,0\n");
  CHECK(particles.colors == std::vector<Vec3d>{{srgb_decode(1.0 / 255), 0, srgb_decode(1.0 / 255)},
                                               {1, srgb_decode(128.0 / 255), 0}});
}

TEST_CASE("CSV: elements are symbols or atomic numbers, and the types where there are no others") {
  const ParticleFiles files;
  Particles particles = files.read("a.csv", "x,y,z,element\n0,0,0,CL\n0,0,1,6\n0,0,2,X\n0,0,3,\n");
  CHECK(particles.elements == Elements{17, 6, 0, 0});
  CHECK(types_of(particles) == Names{"CL", "6", "X", ""});
  particles = files.read("a.csv", "x,y,z,element,type\n0,0,0,O,water\n");
  CHECK(particles.elements == Elements{8});
  CHECK(types_of(particles) == Names{"water"});
}

TEST_CASE("XYZ is read: symbols, atomic numbers, other names, further columns, first frame") {
  const ParticleFiles files;
  const std::string text =
      "4\na comment, Lattice or not\nC 1 -2 3.5 0.1 word\n 8\t0 0.25 -1e3\nOW -0.125 7 0\nd 0 0 0\n"
      "1\nsecond frame\nC 9 9 9\n";
  for (const std::string& file : {text, packed(text)}) {
    const Particles particles = files.read("a.xyz", file);
    CHECK(particles.positions == std::vector<Vec3d>{three()[0], three()[1], three()[2], {0, 0, 0}});
    CHECK(particles.elements == Elements{6, 8, 0, 1});
    CHECK(types_of(particles) == Names{"C", "8", "OW", "d"});
  }
  CHECK(test::note(files.read("b.xyz", "3\n\nXx 0 0 0\nC 1 1 1\nQ 2 0 0"), "unknown_elements") ==
        2);
  const Particles beads = files.read("a.xyz", "2\n\nA1 0 0 0\nB1 1 1 1");
  CHECK(test::note(beads, "unknown_elements") == 0);  // these are types
  CHECK(beads.elements.empty());                      // names of types, none of them an element
  CHECK(beads.types.names == Names{"A1", "B1"});
}

TEST_CASE("extended XYZ is read as its Properties say") {
  const ParticleFiles files;
  const Particles particles = files.read(
      "a.extxyz",
      "2\nLattice=\"5 0 0 0 5 0 0 0 5\" Properties=id:I:1:pos:R:3:species:S:1:force:R:3:radius:R:1:"
      "color:R:3:fixed:L:1 pbc=\"T T F\"\n1 1 -2 3.5 Si 0 0 0 0.5 1 0.25 0 T\n"
      "2 0 0.25 -1e3 Zz 0 0 0 0.75 0 0 1 F\n");
  CHECK(particles.positions == std::vector<Vec3d>{three()[0], three()[1]});
  CHECK(particles.elements == Elements{14, 0});
  CHECK(types_of(particles) == Names{"Si", "Zz"});
  CHECK(particles.radii == std::vector<double>{0.5, 0.75});
  CHECK(particles.colors == std::vector<Vec3d>{{1, 0.25, 0}, {0, 0, 1}});
  const Particles bytes = files.read(
      "b.xyz", "1\nmyproperties=1 properties=\"pos:R:3:color:I:3\"\r\n1 2 3 255 0 128\r\n");
  CHECK(bytes.colors == std::vector<Vec3d>{{1, 0, srgb_decode(128.0 / 255)}});
  CHECK(bytes.types.empty());
}

TEST_CASE("a LAMMPS dump is read: any order of columns, types as text, radii or diameters") {
  const ParticleFiles files;
  const std::string head =
      "ITEM: UNITS\nlj\nITEM: TIMESTEP\n100\nITEM: NUMBER OF ATOMS\n2\n"
      "ITEM: BOX BOUNDS pp pp ff\n-1 3\n0 2\n10 20\n";
  const std::string second = "ITEM: TIMESTEP\n200\n";
  Particles particles =
      files.read("a.lammpstrj", head +
                                    "ITEM: ATOMS id type xs x y z element diameter vx \n"
                                    "2 10 0.5 1 -2 3.5 Fe 1.5 0\n1 2 0.5 0 0.25 -1e3 Qq 0.5 0\n" +
                                    second);
  CHECK(particles.positions == std::vector<Vec3d>{three()[0], three()[1]});
  CHECK(types_of(particles) == Names{"10", "2"});
  CHECK(particles.elements == Elements{26, 0});
  CHECK(particles.radii == std::vector<double>{0.75, 0.25});
  particles = files.read("a.dump", head + "ITEM: ATOMS xu yu zu radius\n1 2 3 4\n5 6 7 8\n");
  CHECK(particles.positions == std::vector<Vec3d>{{1, 2, 3}, {5, 6, 7}});
  CHECK(particles.radii == std::vector<double>{4, 8});
  CHECK(particles.types.empty());
  particles = files.read("a.dump", head + "ITEM: ATOMS type xs ys zs\n1 0 0.5 1\n1 0.25 -1 0.5\n");
  CHECK(particles.positions == std::vector<Vec3d>{{-1, 1, 20}, {0, -2, 15}});
}

TEST_CASE("scaled positions in a tilted LAMMPS box are undone by its edges") {
  // Edges a = (4, 0, 0), b = (1, 3, 0), c = (-2, 0.5, 5) from the origin (10, 20, 30): the bounds
  // that LAMMPS writes are those of the box around it.
  const ParticleFiles files;
  const std::string head =
      "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n5\nITEM: BOX BOUNDS xy xz yz pp pp pp\n"
      "8 15 1\n20 23.5 -2\n30 35 0.5\n";
  const Particles particles = files.read(
      "a.dump", head + "ITEM: ATOMS xs ys zs\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n0.5 0.5 0.5\n");
  CHECK(particles.positions ==
        std::vector<Vec3d>{
            {10, 20, 30}, {14, 20, 30}, {11, 23, 30}, {8, 20.5, 35}, {11.5, 21.75, 32.5}});
}

TEST_CASE("equal content is equal in every format, packed and with any line ends") {
  const ParticleFiles files;
  const std::vector<std::pair<std::string, std::string>> texts = {
      {"a.ply", ply_header("ascii", xyz_properties) + "1 -2 3.5\n0 0.25 -1000\n-0.125 7 0\n"},
      {"b.ply",
       ply_header("binary_big_endian", xyz_properties) + binary_positions(std::endian::big)},
      {"a.csv", "x;y;z;element\n1;-2;3.5;C\n0;0.25;-1e3;O\n-0.125;7;0;C\n"},
      {"a.xyz", "3\n\nC 1 -2 3.5\nO 0 0.25 -1000\nC -0.125 7 0\n"},
      {"b.xyz", "3\nProperties=species:S:1:pos:R:3\nC 1 -2 3.5\nO 0 0.25 -1e+03\nC -.125 7. 0\n"},
      {"a.dump",
       "ITEM: NUMBER OF ATOMS\n3\nITEM: ATOMS element x y z\nC 1 -2 3.5\n"
       "O 0 0.25 -1000\nC -0.125 7 0\n"},
      {"a.pdb",
       "ATOM      1  CA  GLY A   1       1.000  -2.000   3.500  1.00  0.00           C\n"
       "ATOM      2  O   GLY A   1       0.000   0.250   -1000  1.00  0.00           O\n"
       "ATOM      3  C   GLY A   1      -0.125   7.000   0.000  1.00  0.00           C\n"},
      {"a.cif",
       "data_a\nloop_\n_atom_site.type_symbol\n_atom_site.Cartn_x\n_atom_site.Cartn_y\n"
       "_atom_site.Cartn_z\nC 1 -2 3.5 O 0 0.25 -1000 C -0.125 7 0\n"}};
  for (const auto& [file, content] : texts) {
    const std::string& name = file;
    const std::string& text = content;
    const bool binary = name == "b.ply";
    const std::vector<std::pair<std::string, std::string>> versions = {
        {name, text}, {name + ".gz", packed(text)}, {name, binary ? text : with_crlf(text)}};
    for (const auto& version : versions) {
      CAPTURE(version.first);
      const Particles particles = files.read(version.first, version.second);
      CHECK(particles.positions == three());
      const bool ply = name.ends_with(".ply");
      CHECK(particles.elements == (ply ? Elements{} : Elements{6, 8, 6}));
      CHECK(types_of(particles) == (ply ? Names{} : Names{"C", "O", "C"}));
    }
  }
}

}  // namespace parray
