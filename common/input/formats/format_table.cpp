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
constexpr std::array<std::string_view, 3> data_names{".data", ".lmp", ".lammps"};
constexpr std::array<std::string_view, 1> dcd_names{".dcd"};
constexpr std::array<std::string_view, 1> xtc_names{".xtc"};
constexpr std::array<std::string_view, 1> trr_names{".trr"};
constexpr std::array<std::string_view, 3> netcdf_names{".nc", ".ncdf", ".ncrst"};
constexpr std::array<std::string_view, 3> inpcrd_names{".inpcrd", ".rst7", ".restrt"};
constexpr std::array<std::string_view, 1> psf_names{".psf"};
constexpr std::array<std::string_view, 3> prmtop_names{".prmtop", ".parm7", ".top"};
constexpr std::array<std::string_view, 3> pdb_names{".pdb", ".ent", ".pdb1"};
constexpr std::array<std::string_view, 1> pdbqt_names{".pdbqt"};
constexpr std::array<std::string_view, 1> pqr_names{".pqr"};
constexpr std::array<std::string_view, 1> gro_names{".gro"};
constexpr std::array<std::string_view, 3> sdf_names{".sdf", ".mol", ".sd"};
constexpr std::array<std::string_view, 1> mol2_names{".mol2"};
constexpr std::array<std::string_view, 2> cif_names{".cif", ".mmcif"};

constexpr std::array<ParticleFormat, 19> formats{
    {{"PLY", ply_names, false, read_ply},
     {"CSV", csv_names, false, read_csv},
     {"XYZ", xyz_names, true, read_xyz},
     {"LAMMPS dump", lammps_names, true, read_lammps},
     {"LAMMPS data file", data_names, false, read_lammps_data},
     {"DCD", dcd_names, true, read_dcd},
     {"XTC", xtc_names, true, read_xtc},
     {"TRR", trr_names, true, read_trr},
     {"AMBER NetCDF", netcdf_names, true, read_netcdf},
     {"AMBER restart", inpcrd_names, false, read_inpcrd},
     {"PSF", psf_names, false, read_psf, false},
     {"PRMTOP", prmtop_names, false, read_prmtop, false},
     {"PDB", pdb_names, true, read_pdb},
     {"PDBQT", pdbqt_names, true, read_pdbqt},
     {"PQR", pqr_names, true, read_pqr},
     {"GRO", gro_names, true, read_gro},
     {"SDF", sdf_names, true, read_sdf},
     {"MOL2", mol2_names, true, read_mol2},
     {"CIF", cif_names, true, read_cif}}};

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
