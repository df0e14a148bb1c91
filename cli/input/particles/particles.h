#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "cli/input/particles/alternatives.h"
#include "cli/input/particles/frame_choice.h"
#include "common/math/vec.h"

namespace parray::input {

class PackedFile;

/// Names of the particles, each kept once: particle i is called names[index[i]].
struct NameColumn {
  std::vector<std::string> names;    ///< distinct, in the order in which the file first uses them
  std::vector<std::uint32_t> index;  ///< one a particle; none: the file has no such column

  [[nodiscard]] bool empty() const { return index.empty(); }
  [[nodiscard]] const std::string& of(std::size_t particle) const { return names[index[particle]]; }
};

/// Numbers of the particles, under the name that the file gives them.
struct NumberColumn {
  std::string name;            ///< lower case: "vx", "charge", "b_factor"
  std::vector<double> values;  ///< one a particle; NaN where the file says nothing
};

/// The box of a simulation or the cell of a crystal, which the particles need not fill.
struct ParticleCell {
  Vec3d origin;
  std::array<Vec3d, 3> edges;  ///< a, b, c; in the file's own unit
};

/// Something that a reader has guessed, dropped or left out.
struct ParticleNote {
  std::string key;          ///< for programs: "guessed_elements"
  std::uint64_t count = 0;  ///< of particles, or of what the text names; > 0
  std::string text;         ///< for people, without the count: "elements guessed from names"
};

/// What else is known of a file that has been read.
struct ParticleFacts {
  std::string format;                     ///< "PDB"
  std::string packing{};                  ///< "gzip"; empty: not packed
  std::uint64_t frame = 0;                ///< the one that was read, from 0
  std::optional<std::uint64_t> frames{};  ///< in the file; counted only where asked
  std::optional<double> time{};           ///< of the frame, in the file's unit
  std::vector<ParticleNote> notes{};
};

/// What a file of particles says, column by column. Positions and radii are in the file's own unit.
/// A column that the file lacks is empty; the others have one entry a particle, in the file's
/// order.
struct Particles {
  std::vector<Vec3d> positions;        ///< finite, |component| <= limits::max_length
  std::vector<double> radii;           ///< > 0, in [limits::min_radius, limits::max_length]
  std::vector<Vec3d> colors;           ///< linear RGB in [0, 1]
  std::vector<std::uint8_t> elements;  ///< atomic number, 1 .. 118; 0: unknown
  NameColumn types;
  // Of molecules:
  NameColumn atom_names;
  NameColumn residue_names;
  NameColumn chains;
  std::vector<std::int32_t> residue_numbers;
  std::vector<NumberColumn> numbers;  ///< those that the request asks for
  std::optional<ParticleCell> cell;
  ParticleFacts facts;

  [[nodiscard]] std::size_t count() const { return positions.size(); }
};

/// What to read of a file, and how.
struct ParticleRequest {
  std::optional<FrameChoice> frame{};            ///< not given: the first
  std::set<std::string, std::less<>> numbers{};  ///< columns that somebody needs, by their names
  std::filesystem::path topology{};              ///< file of names and elements; empty: none
  AlternativeChoice alternatives{};              ///< of the locations of atoms
  bool all = false;                              ///< every column, and the number of frames
  int threads = 1;

  [[nodiscard]] bool wants(std::string_view number) const {
    return all || numbers.contains(number);
  }
  [[nodiscard]] std::uint64_t frame_number() const { return frame ? frame->number : 0; }
};

/// Reads one frame of a particle file; cli/input/formats/readers.h says what counts in each
/// format. A file without particles is an error. Strict: what is not a number, not finite, out of
/// range or missing is InputError "FILE:LINE: problem: remedy" (a byte offset for binary files).
/// Streams: beside the columns, memory does not grow with the file.
/// The same, errors too, for any number of threads.
Particles read_particles(const std::filesystem::path& path, const ParticleRequest& request = {});

/// The same of a file that is open.
Particles read_particles(PackedFile& file, const ParticleRequest& request = {});

/// What the file says beside the positions, so that files without any, such as PSF, will do; of
/// them, all positions are 0.
Particles read_names(const std::filesystem::path& path, const ParticleRequest& request = {});

}  // namespace parray::input
