#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <string>

#include "cli/input/particles/elements.h"
#include "cli/input/particles/particles.h"
#include "common/scene/limits.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_molecules.h"

namespace parray::test {

inline std::string binary_ply() {
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

/// Returns, by name, a small file of every format. Each uses most features of its format.
inline std::map<std::string, std::string> valid_particle_files() {
  std::map<std::string, std::string> files{
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
  files.insert({"a.txyz",
                "2 water\n10.0 11.0 12.0 90 90 90\n1 O 0.0 0.0 0.0 1 2\n2 H 1.0 0.0 0.0 2 1\n"
                "1 ion\n1 Na+ 5.0 0.0 0.0 7\n"});
  files.merge(valid_molecule_files());
  return files;
}

/// Returns which promise of the header of Particles these particles break; empty: none.
inline std::string broken_promise(const Particles& particles) {
  const std::size_t count = particles.count();
  const auto fits = [&](const auto& column) { return column.empty() || column.size() == count; };
  const auto within = [](double value, double low, double high) {
    return value >= low && value <= high;
  };
  const auto all = [&](const Vec3d& v, double low, double high) {
    return within(v.x, low, high) && within(v.y, low, high) && within(v.z, low, high);
  };
  constexpr double reach = limits::max_length;
  if (count == 0) return "no particles";
  if (!fits(particles.radii) || !fits(particles.colors) || !fits(particles.elements) ||
      !fits(particles.types.index)) {
    return "a column of another length";
  }
  if (!std::ranges::all_of(particles.positions,
                           [&](const Vec3d& p) { return all(p, -reach, reach); })) {
    return "a position";
  }
  if (!std::ranges::all_of(particles.radii,
                           [&](double r) { return within(r, limits::min_radius, reach); })) {
    return "a radius";
  }
  if (!std::ranges::all_of(particles.colors, [&](const Vec3d& c) { return all(c, 0, 1); })) {
    return "a colour";
  }
  if (!std::ranges::all_of(particles.elements, [](auto e) { return e <= last_element; })) {
    return "an element";
  }
  const auto named = [&](const NameColumn& column) {
    return fits(column.index) && std::ranges::all_of(column.index, [&](std::uint32_t i) {
             return i < column.names.size();
           });
  };
  if (!named(particles.types)) return "a type";
  if (!named(particles.atom_names) || !named(particles.residue_names) || !named(particles.chains) ||
      !fits(particles.residue_numbers) || !fits(particles.insertion_codes)) {
    return "a name";
  }
  const bool numbered = std::ranges::all_of(
      particles.numbers, [&](const NumberColumn& column) { return column.values.size() == count; });
  return numbered ? "" : "a number";
}

}  // namespace parray::test
