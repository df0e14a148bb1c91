#pragma once

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
  Particles (*read)(PackedFile& file, const ParticleRequest& request) = nullptr;
};

/// All of them.
std::span<const ParticleFormat> particle_formats();

/// By the file name's extension, that of a packed file looked through; nullptr: none.
const ParticleFormat* format_by_name(const std::filesystem::path& path);

}  // namespace parray
