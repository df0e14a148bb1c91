#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "cli/input/particles/particles.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"

namespace parray::test {

inline const ParticleRequest everything{.all = true};
inline const ParticleRequest last_frame{.frame = FrameChoice{0, true}};

/// The value of a number column for a particle without a number.
inline constexpr double unknown_number = std::numeric_limits<double>::quiet_NaN();

/// Writes a file with this text, and reads all columns of one of its frames.
inline Particles read_all(const ParticleFiles& files, const std::string& name,
                          const std::string& text, std::uint64_t frame = 0) {
  return read_particles(files.write(name, text), {.frame = FrameChoice{frame, false}, .all = true});
}

/// Returns the names of the number columns, with blanks between.
inline std::string names_of(const Particles& particles) {
  std::string names;
  for (const NumberColumn& column : particles.numbers) {
    names += (names.empty() ? "" : " ") + column.name;
  }
  return names;
}

/// Returns the values of the number column with this name. Empty: there is none.
inline std::vector<double> numbers_of(const Particles& particles, std::string_view name) {
  const auto found = std::ranges::find(particles.numbers, name, &NumberColumn::name);
  return found == particles.numbers.end() ? std::vector<double>{} : found->values;
}

/// Returns the name of each particle's type.
inline std::vector<std::string> types_of(const Particles& particles) {
  std::vector<std::string> types;
  for (const std::uint32_t type : particles.types.index) {
    types.push_back(particles.types.names.at(type));
  }
  return types;
}

/// Appends a particle with this name to the column.
inline void add_name(NameColumn& column, const std::string& name) {
  const auto known = std::ranges::find(column.names, name);
  column.index.push_back(static_cast<std::uint32_t>(known - column.names.begin()));
  if (known == column.names.end()) column.names.push_back(name);
}

inline bool has_note(const Particles& particles, std::string_view key) {
  return std::ranges::any_of(particles.facts.notes, [&](auto& note) { return note.key == key; });
}

/// Returns the text of the note with this key, with its count. Empty: there is none.
inline std::string told(const Particles& particles, std::string_view key) {
  for (const ParticleNote& note : particles.facts.notes) {
    if (note.key == key) return std::to_string(note.count) + " " + note.text;
  }
  return "";
}

}  // namespace parray::test
