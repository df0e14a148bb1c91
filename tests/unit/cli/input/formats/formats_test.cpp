#include <doctest/doctest.h>

#include <map>
#include <string>
#include <vector>

#include "cli/input/formats/format_table.h"
#include "tests/support/molecule_files.h"
#include "tests/support/particle_columns.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"
#include "tests/support/three_particles.h"

namespace parray {
namespace {

using test::binary_positions;
using test::Elements;
using test::Names;
using test::packed;
using test::ParticleFiles;
using test::ply_header;
using test::three_positions;
using test::types_of;
using test::xyz_properties;

/// The text as Windows' editors save it.
std::string with_crlf(const std::string& text) {
  std::string result;
  for (const char c : text) result += c == '\n' ? std::string("\r\n") : std::string(1, c);
  return result;
}

}  // namespace

TEST_CASE("the extension gives the format, in any letter case and compression") {
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
      CHECK(particles.positions == three_positions());
      const bool ply = name.ends_with(".ply");
      CHECK(particles.elements == (ply ? Elements{} : Elements{6, 8, 6}));
      CHECK(types_of(particles) == (ply ? Names{} : Names{"C", "O", "C"}));
    }
  }
}

}  // namespace parray
