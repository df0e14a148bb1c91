#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/math/vec.h"

namespace parray::input {

class FrameCursor;
class PackedFile;

/// Names of the particles, each distinct name once. Particle i has the name names[index[i]]. After
/// a filter or in a film, some names may have no particle.
struct NameColumn {
  std::vector<std::string> names;    ///< distinct; from a reader: in the order of their first use
  std::vector<std::uint32_t> index;  ///< one per particle; empty: the file has no such column

  [[nodiscard]] bool empty() const { return index.empty(); }
  [[nodiscard]] const std::string& of(std::size_t particle) const { return names[index[particle]]; }
};

/// A numeric column of the particles, under the name in the file.
struct NumberColumn {
  std::string name;            ///< lower case: "vx", "charge", "b_factor"
  std::vector<double> values;  ///< one per particle; NaN: not known
  std::string unit{};          ///< as the file has it; empty: unknown
};

/// The box of a simulation or the cell of a crystal. The particles need not fill it.
struct ParticleCell {
  Vec3d origin;
  std::array<Vec3d, 3> edges;  ///< a, b, c; in the unit of the positions
  std::array<bool, 3> periodic{true, true,
                               true};  ///< along a, b, c; true if the file does not tell
};

/// A message about values that a reader guessed, corrected or left out.
struct ParticleNote {
  std::string key;          ///< for programs: "guessed_elements"
  std::uint64_t count = 0;  ///< number of particles, or of the things that the text names; > 0
  std::string text;         ///< for people, without the count: "elements guessed from names"
};

/// Returns the words that follow a count in a note.
inline std::string in_number(std::uint64_t count, const char* one, const char* several) {
  return count == 1 ? one : several;
}

/// Facts about a particle file that was read.
struct ParticleFacts {
  std::string format;                     ///< "PDB"
  std::string packing{};                  ///< PackedFile::packing(): "gzip"; empty: not packed
  std::uint64_t frame = 0;                ///< number of the frame that was read, from 0
  std::optional<std::uint64_t> frames{};  ///< number of frames in the file, if they were counted
  std::optional<double> time{};           ///< time, step or number, as the file has it
  std::string length_unit{};              ///< of positions and radii; empty: not known
  std::vector<ParticleNote> notes{};

  /// Adds a note unless `count` is 0.
  void note(std::string key, std::uint64_t count, std::string text);
};

/// A bond that the file states, between particles `first` < `second`.
struct StatedBond {
  std::uint32_t first = 0;
  std::uint32_t second = 0;

  friend auto operator<=>(const StatedBond&, const StatedBond&) = default;
};

/// The content of a particle file in columns. Positions and radii are in the file's own unit, but
/// readers of GROMACS and AMBER files turn nanometres into angstrom. A column that the file lacks
/// is empty. All other columns have one entry per particle, in the file's order.
struct Particles {
  std::vector<Vec3d> positions;        ///< finite, |component| <= limits::max_length
  std::vector<double> radii;           ///< > 0, in [limits::min_radius, limits::max_length]
  std::vector<Vec3d> colors;           ///< linear RGB in [0, 1]
  std::vector<std::uint8_t> elements;  ///< atomic number, 1 .. 118; 0: unknown
  NameColumn types;
  // only for molecules:
  NameColumn atom_names;
  NameColumn residue_names;
  NameColumn chains;
  std::vector<std::int32_t> residue_numbers;
  std::vector<char> insertion_codes;  ///< of residues with the same number; blank: none
  std::vector<char> alternatives;     ///< letters of locations if all are read; blank: none
  std::vector<NumberColumn> numbers;  ///< the numeric columns that the request wants
  /// Index of each particle before keep() removed others. Empty: 0, 1, 2 and so on.
  std::vector<std::uint32_t> indices;
  std::optional<ParticleCell> cell;
  std::vector<StatedBond> bonds;  ///< distinct, in ascending order; empty: the file states none
  bool all_bonds = false;         ///< whether `bonds` are complete; false: PDB states only some
  ParticleFacts facts;

  [[nodiscard]] std::size_t count() const { return positions.size(); }
  /// Returns the index of a particle, from 0, among all particles that the reader returned and
  /// their copies.
  [[nodiscard]] std::size_t index_of(std::size_t particle) const {
    return indices.empty() ? particle : indices[particle];
  }
  /// Returns the numbers with this name. Null: there are none.
  [[nodiscard]] const NumberColumn* numbers_named(std::string_view name) const;
};

/// One byte per particle: 1 or 0.
using ParticleMask = std::vector<std::uint8_t>;

/// Removes the particles whose mask is 0. Keeps the order, and the index_of() of each particle.
void keep(Particles& particles, const ParticleMask& mask);

/// Repeats all particles, so that there are `times` (> 0) as many: copy after copy, each in the
/// same order. Bonds stay those of the first copy; replicate() repeats them.
void repeat(Particles& particles, std::uint64_t times);

/// Appends copies of the particles with the indices `sources`. A copy bonds to the particles that
/// bond to its source, and to their copies.
void append_copies(Particles& particles, const std::vector<std::size_t>& sources);

/// Which alternative locations of an atom are read.
struct AlternativeChoice {
  enum class Rule : std::uint8_t {
    best,   ///< the location with the highest occupancy, the first of several equal ones
    all,    ///< all of them
    letter  ///< the location with this letter, or the best location if there is none
  };
  Rule rule = Rule::best;
  char letter = ' ';

  friend bool operator==(const AlternativeChoice&, const AlternativeChoice&) = default;
};

/// Parses "best", "all" or one printable ASCII character. Throws InputError, which names no place,
/// for other texts.
AlternativeChoice alternatives_from(std::string_view text);

/// Returns the text that alternatives_from() parses to `choice`. Returns "" for `best`.
std::string text_of(const AlternativeChoice& choice);

/// The word for the last frame of a file.
inline constexpr std::string_view last_frame_word = "last";

/// The choice of a frame.
struct FrameChoice {
  std::uint64_t number = 0;  ///< from 0
  bool last = false;         ///< true: the last frame of the file

  friend bool operator==(const FrameChoice&, const FrameChoice&) = default;
};

/// Parses a number from 0 to limits::max_frame, or last_frame_word. Throws InputError, which names
/// no place, for other texts.
std::optional<FrameChoice> frame_from(std::string_view text);

/// Returns the text that frame_from() parses to `choice`. Returns "" if no frame is chosen.
std::string text_of(const std::optional<FrameChoice>& choice);

/// What to read from a file.
struct ParticleRequest {
  std::optional<FrameChoice> frame{};            ///< not given: the first frame with particles
  std::set<std::string, std::less<>> numbers{};  ///< names of the columns that are needed
  std::filesystem::path topology{};              ///< file with names and elements; empty: none
  AlternativeChoice alternatives{};              ///< which locations of an atom are read
  bool all = false;                              ///< true: read every column, and count the frames
  int threads = 1;
  /// Where the last read of the same file ended, so that reading later frames goes on there. Null:
  /// the file is read from its front.
  FrameCursor* cursor = nullptr;

  /// Returns whether the cursor decides where reading begins.
  [[nodiscard]] bool continues() const {
    return cursor != nullptr && frame && !frame->last && !all;
  }
  [[nodiscard]] bool wants(std::string_view number) const {
    return all || numbers.contains(number);
  }
  /// Returns the number of the chosen frame. Returns 0 for the last frame and for no choice.
  [[nodiscard]] std::uint64_t frame_number() const { return frame ? frame->number : 0; }
};

/// Reads one frame of a particle file. The sources of the formats (cli/input/formats) describe what
/// each format supports. Throws InputError "FILE:LINE: problem: remedy" (a byte offset for binary
/// files) for values that are missing, not numbers, not finite or out of range. Throws it also for
/// a file without particles. Memory holds the columns and one block of the file. Results and errors
/// are the same for any number of threads.
Particles read_particles(const std::filesystem::path& path, const ParticleRequest& request = {});

/// Does the same for an open file.
Particles read_particles(PackedFile& file, const ParticleRequest& request = {});

/// Reads a file for its names and other columns. Also accepts files without positions, such as PSF:
/// their positions are 0.
Particles read_names(const std::filesystem::path& path, const ParticleRequest& request = {});

}  // namespace parray::input
