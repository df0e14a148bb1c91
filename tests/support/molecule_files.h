#pragma once

#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"

namespace parray::test {

using Xs = std::vector<double>;
using Elements = std::vector<std::uint8_t>;
using Names = std::vector<std::string>;

/// Returns a record ATOM of PDB at (x, 0, 0), with `name` from column 13 on.
inline std::string pdb_line(const std::string& name, char location, const std::string& residue,
                            int number, double x, double occupancy = 1,
                            const std::string& element = "") {
  std::string line(120, '\0');
  const int length = std::snprintf(
      line.data(), line.size(),
      "ATOM  %5d %-4s%c%3s A%4d    %8.3f   0.000   0.000%6.2f  0.00          %2s\n", 1,
      name.c_str(), location, residue.c_str(), number, x, occupancy, element.c_str());
  line.resize(static_cast<std::size_t>(length));
  return line;
}

inline Xs xs_of(const Particles& particles) {
  Xs xs;
  for (const Vec3d& p : particles.positions) xs.push_back(p.x);
  return xs;
}

/// Returns the count of the note with this key; 0 if there is none.
inline std::uint64_t note(const Particles& particles, std::string_view key) {
  for (const ParticleNote& note : particles.facts.notes) {
    if (note.key == key) return note.count;
  }
  return 0;
}

}  // namespace parray::test
