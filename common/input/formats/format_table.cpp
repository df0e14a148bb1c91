#include "common/input/formats/format_table.h"

#include <algorithm>
#include <array>
#include <string>

#include "common/input/formats/readers.h"
#include "common/input/particles/particle_text.h"

namespace parray {
namespace {

constexpr std::array<std::string_view, 1> ply_names{".ply"};
constexpr std::array<std::string_view, 1> csv_names{".csv"};
constexpr std::array<std::string_view, 2> xyz_names{".xyz", ".extxyz"};
constexpr std::array<std::string_view, 2> lammps_names{".lammpstrj", ".dump"};
constexpr std::array<std::string_view, 2> pdb_names{".pdb", ".ent"};
constexpr std::array<std::string_view, 2> cif_names{".cif", ".mmcif"};

constexpr std::array<ParticleFormat, 6> formats{{{"PLY", ply_names, false, read_ply},
                                                 {"CSV", csv_names, false, read_csv},
                                                 {"XYZ", xyz_names, true, read_xyz},
                                                 {"LAMMPS dump", lammps_names, true, read_lammps},
                                                 {"PDB", pdb_names, true, read_pdb},
                                                 {"mmCIF", cif_names, false, read_mmcif}}};

}  // namespace

std::span<const ParticleFormat> particle_formats() { return formats; }

const ParticleFormat* format_by_name(const std::filesystem::path& path) {
  std::string extension = lower_case(path.extension().string());
  if (extension == ".gz") extension = lower_case(path.stem().extension().string());
  const auto has_it = [&](const ParticleFormat& format) {
    return std::ranges::find(format.extensions, extension) != format.extensions.end();
  };
  const auto found = std::ranges::find_if(formats, has_it);
  return found == formats.end() ? nullptr : &*found;
}

}  // namespace parray
