#include "cli/input/formats/format_table.h"

#include <algorithm>
#include <array>
#include <string>

#include "cli/input/formats/foreign_files.h"
#include "cli/input/formats/json_kind.h"
#include "cli/input/formats/readers.h"
#include "cli/input/formats/recognisers.h"
#include "cli/input/particles/particle_text.h"

namespace parray::input {
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
constexpr std::array<std::string_view, 3> cif_names{".cif", ".mmcif", ".pdbx"};

/// Of proteins or of crystals.
Likeness looks_like_any_cif(const FileStart& start) {
  return std::max(looks_like_mmcif(start), looks_like_cif(start));
}

constexpr std::array<ParticleFormat, 19> formats{
    {{"PLY", ply_names, false, looks_like_ply, read_ply},
     {"XYZ", xyz_names, true, looks_like_xyz, read_xyz},
     {"LAMMPS dump", lammps_names, true, looks_like_lammps_dump, read_lammps},
     {"LAMMPS data file", data_names, false, looks_like_lammps_data, read_lammps_data},
     {"DCD", dcd_names, true, looks_like_dcd, read_dcd, ParticleFormat::Holds::positions},
     {"XTC", xtc_names, true, looks_like_xtc, read_xtc, ParticleFormat::Holds::positions},
     {"TRR", trr_names, true, looks_like_trr, read_trr, ParticleFormat::Holds::positions},
     {"AMBER NetCDF", netcdf_names, true, looks_like_netcdf, read_netcdf,
      ParticleFormat::Holds::positions},
     {"AMBER restart", inpcrd_names, false, looks_like_inpcrd, read_inpcrd,
      ParticleFormat::Holds::positions},
     {"PSF", psf_names, false, looks_like_psf, read_psf, ParticleFormat::Holds::names},
     {"PRMTOP", prmtop_names, false, looks_like_prmtop, read_prmtop, ParticleFormat::Holds::names},
     {"PDB", pdb_names, true, looks_like_pdb, read_pdb},
     {"PDBQT", pdbqt_names, true, looks_like_pdbqt, read_pdbqt},
     {"PQR", pqr_names, true, looks_like_pqr, read_pqr},
     {"GRO", gro_names, true, looks_like_gro, read_gro},
     {"SDF", sdf_names, true, looks_like_sdf, read_sdf},
     {"MOL2", mol2_names, true, looks_like_mol2, read_mol2},
     {"CIF", cif_names, true, looks_like_any_cif, read_cif},
     {"CSV", csv_names, false, looks_like_csv, read_csv}}};  // last: any table could be one

struct Guess {
  const ParticleFormat* format = nullptr;
  Likeness likeness = Likeness::none;
};

/// The format that the file looks like most: of equals the first, but `named` rather than what is
/// only likely, if it could be that as well.
Guess best_guess(const FileStart& start, const ParticleFormat* named) {
  Guess best;
  for (const ParticleFormat& format : formats) {
    const Likeness likeness = format.looks(start);
    if (likeness > best.likeness) best = {&format, likeness};
  }
  const bool fits = named != nullptr && named->looks(start) != Likeness::none;
  return fits && best.likeness != Likeness::certain ? Guess{named, Likeness::likely} : best;
}

/// Fails if `other_json` names what the file is instead of a scene.
void refuse_json(const FilePlace& place, const std::string& other_json) {
  if (!other_json.empty()) place.fail("looks like " + other_json);
}

std::string known_formats() {
  std::string text;
  for (const ParticleFormat& format : formats) text += ", " + std::string(format.name);
  return "scene JSON" + text;
}

}  // namespace

std::span<const ParticleFormat> particle_formats() { return formats; }

const ParticleFormat* format_by_name(const std::filesystem::path& path) {
  const std::string extension = lower_case(unpacked_name(path).extension().string());
  const auto has_it = [&](const ParticleFormat& format) {
    return std::ranges::find(format.extensions, extension) != format.extensions.end();
  };
  const auto found = std::ranges::find_if(formats, has_it);
  return found == formats.end() ? nullptr : &*found;
}

const ParticleFormat* particle_format_of(PackedFile& file) {
  const FileStart& start = file.start();
  const FilePlace place{file.name()};
  const char first = first_character(file);
  const std::string other_json = json_without_scene(start, first);
  if (first == '{' && other_json.empty()) return nullptr;
  const ParticleFormat* const named = format_by_name(file.path());
  const Guess guess = best_guess(start, named);
  const bool is_table = guess.format == &formats.back();  // which a JSON list resembles
  if (first == '{' || is_table) refuse_json(place, other_json);
  if (guess.likeness >= Likeness::likely) return guess.format;
  refuse_json(place, other_json);
  if (start.bytes().empty()) place.fail("the file is empty: is it complete?");
  const std::string foreign = foreign_file(start, unpacked_name(file.path()));
  if (!foreign.empty()) place.fail("looks like " + foreign);
  if (named != nullptr) return named;
  if (guess.format != nullptr) return guess.format;
  place.fail("neither a scene nor particles, but " + first_words(start) + ": ParRay reads " +
             known_formats());
}

}  // namespace parray::input
