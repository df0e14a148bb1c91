#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

#include "common/input/particles/packed_file.h"
#include "common/input/particles/particles.h"

namespace parray {

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

/// The format that the file's first bytes show: one that is certain, the one of its name if that is
/// possible, one that is likely, the one of its name, one that is possible, in this order. nullptr:
/// a scene file, which begins with a brace. Throws InputError "FILE: problem: remedy", with what
/// the file seems to be, for any other.
const ParticleFormat* particle_format_of(PackedFile& file);

}  // namespace parray
