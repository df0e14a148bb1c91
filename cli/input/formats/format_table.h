#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

#include "cli/input/particles/packed_file.h"
#include "cli/input/particles/particles.h"

namespace parray::input {

/// A format that ParRay reads.
struct ParticleFormat {
  std::string_view name;                         ///< for people: "LAMMPS dump"
  std::span<const std::string_view> extensions;  ///< lower case, with the dot; the first is usual
  bool frames = false;                           ///< a file may hold several
  Recogniser looks = nullptr;
  Particles (*read)(PackedFile& file, const ParticleRequest& request) = nullptr;
  enum class Holds : std::uint8_t {
    all,
    names,      ///< and elements only, for the topology of a trajectory
    positions,  ///< only: what is there, a topology says
  };
  Holds holds = Holds::all;
};

/// All of them.
std::span<const ParticleFormat> particle_formats();

/// By the file name's extension, that of a packed file looked through; nullptr: none.
const ParticleFormat* format_by_name(const std::filesystem::path& path);

/// Returns the format that the file's first bytes show. A file whose first character after blanks
/// and a byte order mark is a brace is JSON, and no format is asked: nullptr stands for a scene
/// file. Of the formats, this order decides: one that is certain, the one of the file's name if it
/// is possible, one that is likely, the one of the name, one that is possible. Throws InputError
/// "FILE: problem: remedy", with what the file seems to be, for anything else.
const ParticleFormat* particle_format_of(PackedFile& file);

}  // namespace parray::input
