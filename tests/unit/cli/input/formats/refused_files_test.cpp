#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/memory.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::bytes_of;
using test::packed;
using test::ParticleFiles;

struct Damage {
  std::string name;
  std::string file;
  std::string text;
  std::string message;  ///< exact
};

void check_all(const std::vector<Damage>& table) {
  const ParticleFiles files;
  for (const Damage& damage : table) {
    CAPTURE(damage.name);
    CHECK(files.message(damage.file, damage.text) == damage.message);
  }
}

constexpr const char* xyz_floats = "property float x\nproperty float y\nproperty float z\n";

std::string ascii_ply(const std::string& count, const std::string& more = "") {
  return "ply\nformat ascii 1.0\nelement vertex " + count + "\n" + xyz_floats + more +
         "end_header\n";
}

std::string binary_ply(const std::string& count, const std::string& more = "") {
  return "ply\nformat binary_little_endian 1.0\nelement vertex " + count + "\n" + xyz_floats +
         more + "end_header\n";
}

std::string floats(float x, float y, float z) { return bytes_of(x) + bytes_of(y) + bytes_of(z); }

std::string dump_of(const std::string& count, const std::string& rest) {
  return "ITEM: NUMBER OF ATOMS\n" + count + "\nITEM: ATOMS x y z\n" + rest;
}

std::string cif_rows(const std::string& values) {
  return "data_a\nloop_\n_atom_site.Cartn_x\n_atom_site.Cartn_y\n_atom_site.Cartn_z\n" + values;
}

std::string pdb(const std::string& x) {
  return "ATOM      1  CA  ALA A   1    " + x + "   2.000   3.000  1.00  0.00           C\n";
}

constexpr const char* scale_lengths = ", or scale all lengths, for example from metres to parsecs";
constexpr const char* position_range = " is out of range: use a number from -1e+15 to 1e+15";
constexpr const char* radius_range = " is out of range: use a number from 1e-15 to 1e+15";

}  // namespace

TEST_CASE("missing files, empty files, directories and unknown names are refused") {
  const ParticleFiles files;
  const auto message = [](const std::filesystem::path& path) {
    return test::message_of<InputError>([&] { read_particles(path); });
  };
  const std::filesystem::path folder = files.path() / "folder.xyz";
  std::filesystem::create_directory(folder);
  CHECK(message(files.path() / "none.xyz") ==
        (files.path() / "none.xyz").string() + ": no such file: check the path");
  CHECK(message(folder) == folder.string() + ": is a directory: name a file in it");
  for (const char* name : {"a.ply", "a.csv", "a.xyz", "a.dump", "a.pdb", "a.cif", "a.xyz.gz"}) {
    CHECK(files.message(name, "") ==
          std::string(name) + ": the file is empty: check that the file is complete");
  }
}

TEST_CASE("file names in errors have no control characters") {
  CHECK(test::message_of<InputError>([] { read_particles("a\x1b[2J.xyz"); }) ==
        "a\\x1b[2J.xyz: no such file: check the path");
}

TEST_CASE(
    "texts that are not numbers, and numbers not finite or out of range, are refused with their "
    "line") {
  const auto not_finite = [](const std::string& text) {
    return " '" + text + "' is not a finite number: write a number such as 0.5 or 1e3";
  };
  check_all({
      {"NaN", "a.xyz", "1\n\nC 0 nan 0\n", "a.xyz:3: y" + not_finite("nan")},
      {"infinity", "a.xyz", "1\n\nC 0 0 -inf\n", "a.xyz:3: z" + not_finite("-inf")},
      {"overflow", "a.xyz", "1\n\nC 1e999 0 0\n", "a.xyz:3: x" + not_finite("1e999")},
      {"a word", "a.csv", "x,y,z\n1,2,3\n1,two,3\n", "a.csv:3: y" + not_finite("two")},
      {"two commas in a number", "a.csv", "x;y;z\n1,5,0;2;3\n", "a.csv:2: x" + not_finite("1,5,0")},
      {"nothing", "a.csv", "x,y,z\n1,,3\n", "a.csv:2: y" + not_finite("")},
      {"hexadecimal", "a.csv", "x,y,z\n1,0x10,3\n", "a.csv:2: y" + not_finite("0x10")},
      {"two signs", "a.csv", "x,y,z\n1,+-1,3\n", "a.csv:2: y" + not_finite("+-1")},
      {"NaN in a dump", "a.dump", dump_of("1", "0 NaN 0\n"), "a.dump:4: y" + not_finite("NaN")},
      {"a terminal's escape", "a.xyz", "1\n\nC \x1b[2J 0 0\n",
       "a.xyz:3: x" + not_finite("\\x1b[2J")},
      {"NaN in PLY", "a.ply", ascii_ply("1") + "0 0 nan\n", "a.ply:8: value" + not_finite("nan")},
      {"NaN in PDB", "a.pdb", pdb("     nan"), "a.pdb:1: x" + not_finite("nan")},
      {"blank in PDB", "a.pdb", "REMARK\n" + pdb("        "), "a.pdb:2: x" + not_finite("")},
      {"NaN in mmCIF", "a.cif", cif_rows("1 2\nnan\n"), "a.cif:7: cartn_z" + not_finite("nan")},
      {"a quoted word in mmCIF", "a.cif", cif_rows("1 2 'a b'\n"),
       "a.cif:6: cartn_z" + not_finite("'a b'")},
      {"too far in mmCIF", "a.cif", cif_rows("1 2 1e16\n"),
       std::string("a.cif:6: coordinate 1e+16") + position_range + scale_lengths},
      {"too far", "a.xyz", "1\n\nC 0 0 -1e16\n",
       std::string("a.xyz:3: coordinate -1e+16") + position_range + scale_lengths},
      {"NaN in binary", "a.ply", binary_ply("1") + floats(0, NAN, 0),
       std::string("a.ply: byte 123: coordinate nan") + position_range},
      {"infinity in binary", "a.ply", binary_ply("1") + floats(INFINITY, 0, 0),
       std::string("a.ply: byte 123: coordinate inf") + position_range},
  });
}

TEST_CASE("radii that are not positive and invalid colours are refused") {
  const std::string radius = "property float radius\n";
  const std::string color = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  check_all({
      {"negative", "a.csv", "x,y,z,radius\n0,0,0,-1\n",
       std::string("a.csv:2: radius -1") + radius_range},
      {"zero", "a.ply", ascii_ply("1", radius) + "0 0 0 0\n",
       std::string("a.ply:9: radius 0") + radius_range},
      {"NaN in binary", "a.ply", binary_ply("1", radius) + floats(0, 0, 0) + bytes_of(NAN),
       std::string("a.ply: byte 149: radius nan") + radius_range},
      {"huge diameter", "a.dump",
       "ITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS x y z diameter\n0 0 0 4e15\n",
       std::string("a.dump:4: radius 2e+15") + radius_range},
      {"colour above 255", "a.ply", ascii_ply("1", color) + "0 0 0 0 256 0\n",
       "a.ply:11: colour component 256 is out of range: use a whole number from 0 to 255"},
      {"colour with a fraction", "a.ply", ascii_ply("1", color) + "0 0 0 0 0.5 0\n",
       "a.ply:11: colour component 0.5 is out of range: use a whole number from 0 to 255"},
      {"linear colour above 1", "a.xyz", "1\nProperties=pos:R:3:color:R:3\n0 0 0 0 0 1.01\n",
       "a.xyz:3: colour component 1.01 is out of range: use a number from 0 to 1"},
      {"negative colour", "a.csv", "x,y,z,red,green,blue\n0,0,0,-1,0,0\n",
       "a.csv:2: colour component -1 is out of range: use a number from 0 to 255"},
      {"two scales", "a.csv", "x y z red green blue\n0 0 0 0.5 0 0\n0 0 0 1 0 0\n0 0 0 200 0 0\n",
       "a.csv:4: the file mixes two colour scales (fractions on line 2, above 1 on line 4): use 0 "
       "to 1 for all colours, or "
       "whole numbers 0 to 255 for all"},
      {"colours of different types", "a.ply",
       ascii_ply("1", "property uchar red\nproperty uchar green\nproperty float blue\n") +
           "0 0 0 0 0 0\n",
       "a.ply:10: the colour properties must be all uchar, all float or all double: change their "
       "types"},
      {"colours of int", "a.ply",
       ascii_ply("1", "property int red\nproperty int green\nproperty int blue\n") +
           "0 0 0 0 0 0\n",
       "a.ply:10: the colour properties must be all uchar, all float or all double: change their "
       "types"},
      {"no element", "a.csv", "x,y,z,element\n0,0,0,Sj\n",
       "a.csv:2: 'Sj' is not an element: write a symbol, an atomic number or X, or name the column "
       "'type'"},
  });
}

TEST_CASE("PLY: invalid headers are refused") {
  const std::string start = "ply\nformat ascii 1.0\n";
  const std::string no_format =
      "line 2 is not a PLY format: write 'format ascii 1.0', 'format binary_little_endian 1.0' or "
      "'format "
      "binary_big_endian 1.0'";
  check_all({
      {"text", "a.ply", "solid cube\n",
       "a.ply:1: this is not a PLY file: its first line is not 'ply'"},
      {"no format", "a.ply", "ply\nelement vertex 1\n", "a.ply:2: " + no_format},
      {"a later version", "a.ply", "ply\nformat ascii 2.0\n", "a.ply:2: " + no_format},
      {"no end", "a.ply", start + "element vertex 1\n",
       "a.ply:3: the file ends before end_header: check that the file is complete"},
      {"a strange line", "a.ply", start + "vertex 1\n",
       "a.ply:3: 'vertex 1' is unknown in a PLY header: use comment, element, property or "
       "end_header"},
      {"a strange type", "a.ply", start + "element vertex 1\nproperty real x\n",
       "a.ply:4: unknown type 'real': use char, uchar, short, ushort, int, uint, float or double"},
      {"a property too early", "a.ply", start + "property float x\n",
       "a.ply:3: a property precedes the first element: move the property"},
      {"a property twice", "a.ply", start + "element vertex 1\nproperty int x\nproperty int x\n",
       "a.ply:5: two properties are named 'x': rename one"},
      {"half a property", "a.ply", start + "element vertex 1\nproperty list int x\n",
       "a.ply:4: the line is not a valid property: write 'property TYPE NAME' or 'property list "
       "TYPE TYPE NAME'"},
      {"a list's size that is float", "a.ply",
       start + "element vertex 1\nproperty list float int x\n",
       "a.ply:4: the size of a list cannot be a float: use uchar or int"},
      {"no vertex", "a.ply", start + "element point 1\nproperty float x\nend_header\n0\n",
       "a.ply:5: the file has no element 'vertex': add one, because its instances are the "
       "particles"},
      {"vertex twice", "a.ply", start + "element vertex 0\nelement vertex 0\nend_header\n",
       "a.ply:5: two elements are named 'vertex': rename one"},
      {"no z", "a.ply",
       start + "element vertex 1\nproperty float x\nproperty float y\nend_header\n0 0\n",
       "a.ply:6: element 'vertex' has no scalar property 'z': add x, y and z"},
      {"z as a list", "a.ply",
       start + "element vertex 1\nproperty float x\nproperty float y\nproperty list uchar float z\n"
               "end_header\n0 0 1 0\n",
       "a.ply:7: element 'vertex' has no scalar property 'z': add x, y and z"},
      {"no properties", "a.ply", start + "element face 1\nend_header\n",
       "a.ply:4: element 'face' has no properties: add them"},
      {"a count that is none", "a.ply", start + "element vertex -1\n",
       "a.ply:3: '-1' is not a number of particles: write a whole number"},
      {"an absurd count", "a.ply", start + "element vertex 99999999999\n",
       "a.ply:3: 99999999999 particles are too many: use at most 100000000"},
      {"an absurd count of faces", "a.ply", start + "element face 4294967296\n",
       "a.ply:3: '4294967296' is not a number of elements: use 0 to 4294967295"},
      {"no particles", "a.ply", ascii_ply("0"),
       "a.ply:7: the file has no particles: check that this is the right file"},
  });
}

TEST_CASE("PLY: data that do not fit the header are refused") {
  const std::string list = "property list char int l\n";
  const std::string too_short =
      "check that the file is complete, and the counts and properties in the header";
  check_all({
      {"short text", "a.ply", ascii_ply("2") + "10.25 0 0.125\n",
       "a.ply:8: the file ends within its elements 'vertex': " + too_short},
      {"long text", "a.ply", ascii_ply("1") + "0 0 0\n1 1 1\n",
       "a.ply:9: text follows the last element: check the counts in the header"},
      {"too few values", "a.ply", ascii_ply("1") + "0.125 0.125\n",
       "a.ply:8: 2 values do not fit the properties of element 'vertex': write one value for each "
       "property; for a list, its length and then its items"},
      {"too many values", "a.ply", ascii_ply("1") + "0 0 0 0\n",
       "a.ply:8: 4 values do not fit the properties of element 'vertex': write one value for each "
       "property; for a list, its length and then its items"},
      {"a long list", "a.ply", ascii_ply("1", list) + "0 0 0 3 1 2\n",
       "a.ply:9: 6 values do not fit the properties of element 'vertex': write one value for each "
       "property; for a list, its length and then its items"},
      {"a list of nonsense", "a.ply", ascii_ply("1", list) + "0 0 0 -1\n",
       "a.ply:9: list 'l' has no valid size: check that the header fits the data"},
      {"short data", "a.ply", binary_ply("2") + floats(0, 0, 0) + floats(0, 0, 0).substr(1),
       "a.ply:7: the header requires at least 24 bytes of data, but only 23 follow it: check that "
       "the "
       "file is complete"},
      {"short packed data", "a.ply.gz", packed(binary_ply("2") + floats(0, 0, 0)),
       "a.ply.gz: byte 127: the file ends within its elements 'vertex': " + too_short},
      {"long data", "a.ply", binary_ply("1") + floats(0, 0, 0) + "x",
       "a.ply: byte 127: data follow the last element: check the counts, properties and types in "
       "the header"},
      {"a list beyond the end", "a.ply", binary_ply("1", list) + floats(0, 0, 0) + "\x7f",
       "a.ply: byte 153: the file ends within its elements 'vertex': " + too_short},
      {"a negative list", "a.ply", binary_ply("1", list) + floats(0, 0, 0) + "\xff",
       "a.ply: byte 152: list 'l' has no valid size: check that the header fits the data"},
  });
}

TEST_CASE("CSV: invalid tables are refused") {
  check_all({
      {"only comments", "a.csv", "# nothing\n\n",
       "a.csv:2: the file has no header line: add one that names the columns x, y and z"},
      {"two columns without header", "a.csv", "1,2\n",
       "a.csv:1: the table has no column 'x': name the columns x, y and z"},
      {"no y", "a.csv", "x,z,r\n",
       "a.csv:1: the table has no column 'y': name the columns x, y and z"},
      {"x twice", "a.csv", "x,X,y,z\n", "a.csv:1: two columns are named 'x': rename one"},
      {"no rows", "a.csv", "x,y,z\n",
       "a.csv:1: the file has no particles: check that this is the right file"},
      {"a short row", "a.csv", "x,y,z\n1,2,3\n\n1,2\n",
       "a.csv:4: 2 fields, but the header has 3: use the same number"},
      {"a long row", "a.csv", "x y z\n1 2 3 4\n",
       "a.csv:2: 4 fields, but the header has 3: use the same number"},
      {"an open quote", "a.csv", "x,y,z,type\n1,2,3,\"a\n",
       "a.csv:2: the quote is not closed: add '\"'"},
      {"text after a quote", "a.csv", "x,y,z,type\n1,2,3,\"a\"b\n",
       "a.csv:2: text follows the closing quote: double each quote inside a quoted field"},
  });
  std::string table = "x,y,z,type\n0,0,0," + std::string(257, 'a') + "\n";
  check_all({{"a long type", "a.csv", table,
              "a.csv:2: the type '" + std::string(57, 'a') +
                  "...' is longer than 256 bytes: shorten it"}});
  table = "x,y,z,type\n";
  for (int i = 0; i <= 65536; ++i) table += "0,0,0,t" + std::to_string(i) + "\n";
  check_all(
      {{"too many types", "a.csv", table,
        "a.csv:65538: more than 65536 types: check that this column contains types, not names"}});
}

TEST_CASE("XYZ: invalid frames are refused") {
  const auto no_property = [](const std::string& name) {
    return "a.xyz:2: Properties has no valid NAME:TYPE:COUNT at '" + name +
           "': write for example species:S:1:pos:R:3";
  };
  check_all({
      {"no count", "a.xyz", "C 0 0 0\n",
       "a.xyz:1: 'C 0 0 0' is not a number of particles: write a whole number"},
      {"an absurd count", "a.xyz", "100000001\n\n",
       "a.xyz:1: 100000001 particles are too many: use at most 100000000"},
      {"a count beyond 64 bits", "a.xyz", "99999999999999999999\n\n",
       "a.xyz:1: '99999999999999999999' is not a number of particles: write a whole number"},
      {"no comment", "a.xyz", "1",
       "a.xyz:1: the file ends before its comment line: check that the file is "
       "complete"},
      {"too few atoms", "a.xyz", "3\n\nC 0 0 0\n",
       "a.xyz:3: the file ends after 1 of 3 particles: check that the file is complete"},
      {"too many atoms", "a.xyz", "1\n\nC 0 0 0\nC 0 0 0\n",
       "a.xyz:4: text follows the last particle: check the number of particles in the frame's "
       "first line"},
      {"too few columns", "a.xyz", "1\n\nC 0 0\n",
       "a.xyz:3: 3 columns, but 4 are needed: write a name and three coordinates, or correct the "
       "number of particles"},
      {"no atoms", "a.xyz", "0\n\n",
       "a.xyz:2: the file has no particles: check that this is the right file"},
      {"other columns than announced", "a.xyz", "1\nProperties=species:S:1:pos:R:3\nC 0 0 0 0\n",
       "a.xyz:3: 5 columns, but 4 are needed: write the number that Properties requires"},
      {"no positions", "a.xyz", "1\nProperties=species:S:1\nC\n",
       "a.xyz:2: Properties has no pos:R:3: add it"},
      {"half a property", "a.xyz", "1\nProperties=species:S:1:pos:R\n", no_property("pos")},
      {"an unknown type", "a.xyz", "1\nProperties=pos:Q:3\n", no_property("pos")},
      {"no columns", "a.xyz", "1\nProperties=pos:R:0\n", no_property("pos")},
      {"absurd columns", "a.xyz", "1\nProperties=pos:R:18446744073709551615\n", no_property("pos")},
  });
}

TEST_CASE("LAMMPS: invalid dumps are refused") {
  check_all({
      {"a log", "a.dump", "LAMMPS (29 Sep 2021)\n",
       "a.dump: looks like a log of LAMMPS: name the dump file of that run"},
      {"another kind of dump", "a.dump", "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ENTRIES\n1\n",
       "a.dump:3: unknown item 'NUMBER OF ENTRIES': check that this is a LAMMPS text dump of "
       "atoms"},
      {"no count", "a.dump", "ITEM: ATOMS x y z\n",
       "a.dump:1: the frame has no ITEM: NUMBER OF ATOMS before its atoms: add it"},
      {"an absurd count", "a.dump", dump_of("4000000000", ""),
       "a.dump:2: 4000000000 particles are too many: use at most 100000000"},
      {"no atoms", "a.dump", "ITEM: NUMBER OF ATOMS\n1\n",
       "a.dump:2: the frame has no ITEM: ATOMS: check that the file is complete"},
      {"an end in the header", "a.dump", "ITEM: TIMESTEP\n",
       "a.dump:1: the file ends within its header: check that the file is complete"},
      {"no positions", "a.dump", "ITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS id type x y\n1 1 0 0\n",
       "a.dump:3: the dump has no positions: dump x y z, xu yu zu or xs ys zs"},
      {"scaled without a box", "a.dump", "ITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS xs ys zs\n0 0 0\n",
       "a.dump:3: scaled positions need the box's bounds along x, y and z: dump x y z"},
      {"a box without tilts", "a.dump", "ITEM: BOX BOUNDS xy xz yz pp pp pp\n0 1\n",
       "a.dump:2: 2 numbers, but a line of the box needs 3: write low, high and tilt"},
      {"too few atoms", "a.dump", dump_of("2", "0 0 0\n"),
       "a.dump:4: the file ends after 1 of 2 atoms: check that the file is complete"},
      {"too many atoms", "a.dump", dump_of("1", "0 0 0\n0 0 0\n"),
       "a.dump:5: text follows the last atom: correct the number of atoms in the header, or "
       "remove the text"},
      {"too few columns", "a.dump", dump_of("1", "0 0\n"),
       "a.dump:4: 2 columns, but ITEM: ATOMS names 3: use the same number"},
      {"too many columns", "a.dump", dump_of("1", "0 0 0 0\n"),
       "a.dump:4: 4 columns, but ITEM: ATOMS names 3: use the same number"},
  });
}

TEST_CASE("PDB and mmCIF: invalid files are refused") {
  check_all({
      {"no atoms", "a.pdb", "HEADER\nEND\n",
       "a.pdb:2: the file has no particles: check that this is the right file"},
      {"a short record", "a.pdb", pdb("   1.000").substr(0, 53),
       "a.pdb:1: the record ends before column 54, the last of its coordinates: check that the "
       "file is complete"},
      {"a zero byte", "a.pdb", pdb("   1.000").replace(7, 1, 1, '\0'),
       "a.pdb:1: the record contains a zero byte: the file is probably damaged, copy it again"},
      {"shifted columns", "a.pdb",
       "ATOM      1  CA  ALA A   1  1.000   2.000   3.000                C\n",
       "a.pdb:1: x '000   2.' is not a finite number: write a number such as 0.5 or 1e3"},
      {"no CIF", "a.cif", "HEADER\n",
       "a.cif:1: the file is not valid CIF (expected block header (data_)): check that this is the "
       "right file"},
      {"an open quote", "a.cif", "data_a\n_a.b 'c\n",
       "a.cif:2: the file is not valid CIF (unterminated 'string'): check that this is the right "
       "file"},
      {"another kind of CIF", "a.cif", "data_a\nloop_\n_atom_site_fract_x\n0.5\n",
       "a.cif:4: the table has a column fract_x, but no fract_y: add it"},
      {"no atoms in CIF", "a.cif", "data_a\n_a.b c\n",
       "a.cif:2: the file has no atoms: add _atom_site or _chem_comp_atom with Cartesian or "
       "fractional coordinates"},
      {"no z", "a.cif", "data_a\nloop_\n_atom_site.Cartn_x\n_atom_site.Cartn_y\n1 2\n",
       "a.cif:5: the table has a column cartn_x, but no cartn_z: add it"},
      {"a short row", "a.cif", cif_rows("1 2 3\n4 5\n"),
       "a.cif:7: the last row of the atom table has 2 of 3 values: check that the file is "
       "complete"},
      {"an empty loop", "a.cif", cif_rows(""),
       "a.cif:5: the file has no particles: check that this is the right file"},
      {"an endless text", "a.cif", "data_a\n_a.b\n;" + std::string(5'000'000, 'a'),
       "a.cif:2: the file is not valid CIF (a text has more than 4194304 bytes): check that this "
       "is the right file"},
  });
}

TEST_CASE("a line of a megabyte and a file of noise give one short message in every format") {
  const ParticleFiles files;
  std::string noise;
  for (std::uint32_t i = 0, state = 1; i < 100'000; ++i) {
    state = state * 1664525U + 1013904223U;
    noise += static_cast<char>(state >> 24);
  }
  for (const char* name : {"a.ply", "a.csv", "a.xyz", "a.dump", "a.pdb", "a.cif"}) {
    CAPTURE(name);
    for (const std::string& text : {std::string(1'000'000, '7'), std::string(1'000'000, '\0'),
                                    std::string(1'000'000, ' '), noise}) {
      const std::string message = files.message(name, text);
      CHECK(message.starts_with(std::string(name) + ":"));
      CHECK(message.size() < 250);
      CHECK(message.find_first_of(std::string("\0\n\x1b", 3)) == std::string::npos);
    }
  }
  CHECK(files.message("a.xyz", std::string(2'000'000, '7')) ==
        "a.xyz:1: a line has more than 1048576 bytes: check that this is a text file");
  CHECK(files.message("a.pdb", noise + pdb("   1.000")) != "no error");
}

TEST_CASE("a count that exceeds the file's size allocates no memory") {
  const ParticleFiles files;
  const std::uint64_t before = test::peak_address_space();
  for (const auto& [name, text] : std::vector<std::pair<std::string, std::string>>{
           {"a.ply", binary_ply("100000000") + floats(0, 0, 0)},
           {"b.ply", ascii_ply("100000000") + "0 0 0\n"},
           {"c.ply.gz", packed(binary_ply("100000000") + floats(0, 0, 0))},
           {"a.xyz", "100000000\n\nC 0 0 0\n"},
           {"b.xyz.gz", packed("100000000\n\nC 0 0 0\n")},
           {"a.dump", dump_of("100000000", "0 0 0\n")}}) {
    CHECK(files.message(name, text) != "no error");
  }
  CHECK(test::peak_address_space() - before < 64'000'000);
}

}  // namespace parray
