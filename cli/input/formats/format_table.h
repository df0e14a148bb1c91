#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

#include "cli/input/particles/frames.h"
#include "cli/input/particles/packed_file.h"
#include "cli/input/particles/particles.h"

/// The formats of particle files. Each format has its own source (xyz.cpp) with a recogniser, a
/// reader and an entry of the table.
namespace parray::input {

/// How certain a recogniser is that a file has its format.
enum class Confidence : std::uint8_t {
  none,      ///< the file has another format, or nothing indicates this one
  possible,  ///< nothing contradicts the format; the file's name may confirm it
  likely,    ///< the first lines have the shape of the format
  certain    ///< a signature that no other format has
};

inline Confidence certain_if(bool condition) {
  return condition ? Confidence::certain : Confidence::none;
}

/// A format that ParRay reads.
struct ParticleFormat {
  std::string_view name;                       ///< for people: "LAMMPS dump"
  std::array<std::string_view, 3> extensions;  ///< lower case, with the dot; unused ones are empty
  /// Lower case beginnings of names of files without a known extension: "poscar" for "POSCAR_1".
  std::array<std::string_view, 3> names{};
  bool frames = false;  ///< true: a file may contain several frames
  /// true: lengths are in angstrom, by the definition of the format, by convention (XYZ, DCD) or
  /// because the reader converts them.
  bool in_angstrom = false;
  /// Whether files may list their atoms in any order. Then the column `id` has their numbers.
  bool unordered = false;
  /// Judges the first bytes of a file. At most one format is `likely` or better, unless the text
  /// fits several formats equally well.
  Confidence (*confidence)(const FileStart& start) = nullptr;
  /// Returns whether the first bytes contain only a header of this format, so that later bytes must
  /// decide. nullptr: the first bytes suffice.
  bool (*only_header)(const FileStart& start) = nullptr;
  /// Reads the frame that the request chooses. Throws the errors of read_particles().
  Particles (*read)(PackedFile& file, const ParticleRequest& request) = nullptr;
  /// What files of the format contain.
  enum class Holds : std::uint8_t {
    all,        ///< positions, and maybe names
    names,      ///< names and elements without positions, which are 0; useful as a topology
    positions,  ///< positions without names; a topology may give the names
  };
  Holds holds = Holds::all;
};

/// Returns a format whose files may have several frames, which `Frames` reads (see read_frame()),
/// with lengths in angstrom.
template <typename Frames>
constexpr ParticleFormat frames_in_angstrom(
    std::string_view name, const std::array<std::string_view, 3>& extensions,
    Confidence (*confidence)(const FileStart& start),
    ParticleFormat::Holds holds = ParticleFormat::Holds::all) noexcept {
  return {.name = name,
          .extensions = extensions,
          .frames = true,
          .in_angstrom = true,
          .confidence = confidence,
          .read = read_frame<Frames>,
          .holds = holds};
}

extern const ParticleFormat ply_format, xyz_format, lammps_dump_format, lammps_data_format,
    dcd_format, xtc_format, trr_format, netcdf_format, gsd_format, inpcrd_format, psf_format,
    prmtop_format, pdb_format, pdbqt_format, pqr_format, poscar_format, gro_format, sdf_format,
    mol2_format, tinker_format, cif_format, csv_format;

/// Returns all formats, in the order in which their recognisers run.
std::span<const ParticleFormat* const> particle_formats();

/// Returns the format with the extension of the file's name, or with the beginning of the name, or
/// nullptr. Ignores the extension of a compressed file: "a.pdb.gz" is PDB.
const ParticleFormat* format_by_name(const std::filesystem::path& path);

/// Returns the format of the file by its first bytes, or nullptr for a scene. If these contain only
/// a header or comments, looks further, up to 16 MiB. A file is a scene if
/// its first character after blanks and a byte order mark is a brace, unless it is recognised as
/// other JSON, which is an error. For other files the first of these decides:
/// 1. a certain format
/// 2. the format of the file's name, if it is at least possible
/// 3. a likely format
/// 4. a format that ParRay recognises but does not support, which is an error
/// 5. the format of the file's name, although its recogniser refuses the contents
/// 6. a possible format
///
/// Throws InputError "FILE: problem: remedy" for empty and all other files. The problem says what
/// the file seems to be.
const ParticleFormat* particle_format_of(PackedFile& file);

}  // namespace parray::input
