#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/math/vec.h"

namespace parray {

/// What a file of particles says, column by column. Positions and radii are in the file's own unit.
/// A column that the file lacks is empty; the others have one entry a particle, in the file's
/// order.
struct Particles {
  std::vector<Vec3d> positions;        ///< finite, |component| <= limits::max_length
  std::vector<double> radii;           ///< > 0, in [limits::min_radius, limits::max_length]
  std::vector<Vec3d> colors;           ///< linear RGB in [0, 1]
  std::vector<std::uint8_t> elements;  ///< atomic number, 1 .. 118; 0: unknown
  std::vector<std::uint32_t> types;    ///< index into type_names
  std::vector<std::string>
      type_names;  ///< distinct, in the order in which the file first uses them

  [[nodiscard]] std::size_t count() const { return positions.size(); }
};

enum class ParticleFormat : std::uint8_t { ply, csv, xyz, lammps, pdb, mmcif };

/// Format by the file name's extension, ".gz" looked through: ply, csv, xyz and extxyz, lammpstrj
/// and dump, pdb and ent, cif and mmcif. Throws InputError that lists the known ones.
ParticleFormat particle_format_of(const std::filesystem::path& path);

/// True when the file name's extension is that of a particle file.
bool is_particle_file(const std::filesystem::path& path);

/// True when a file of that name may hold several frames (models, in PDB).
bool may_hold_frames(const std::filesystem::path& path);

/// Reads one frame of a particle file, the first by default; common/input/particles/readers.h says
/// what counts in each format. A file without particles is an error. Strict: what is not a number,
/// not finite, out of range or missing is InputError "FILE:LINE: problem: remedy" (a byte offset
/// for binary files). Streams: beside the columns, memory does not grow with the file.
/// The same, errors too, for any number of threads.
Particles read_particles(const std::filesystem::path& path, std::uint64_t frame = 0,
                         int threads = 1);

}  // namespace parray
