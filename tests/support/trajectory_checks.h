#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.h"
#include "common/math/vec.h"
#include "tests/support/particle_columns.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_trajectories.h"

namespace parray::test {

inline const Frame first_frame{{1, 2, 3}, {4, 5, 6}, {7, 8, 9}};
inline const Frame second_frame{{-1, 2, 3}, {-4, 5, 6}, {-7, 8, 9}};

/// Returns whether a position that was stored in single precision is `b`.
inline bool near_stored(const Vec3d& a, const Vec3d& b, double tolerance = 1e-5) {
  return length(a - b) <= tolerance * (1 + length(b));
}

inline bool same_positions(const std::vector<Vec3d>& a, const Frame& b, double tolerance = 1e-5) {
  return std::ranges::equal(a, b, [&](auto& p, auto& q) { return near_stored(p, q, tolerance); });
}

inline bool has_edges(const Particles& particles, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  if (!particles.cell) return false;
  const auto& edges = particles.cell->edges;
  return near_stored(edges[0], a) && near_stored(edges[1], b) && near_stored(edges[2], c);
}

/// Checks that every file that is cut somewhere is refused in one line, or has fewer frames.
inline void check_cuts(const char* name, const std::string& bytes, std::size_t whole_frames) {
  const ParticleFiles files;
  for (std::size_t length = 1; length < bytes.size(); length += length < 400 ? 1 : 13) {
    const auto file = files.write(name, bytes.substr(0, length));
    try {
      const Particles particles = read_particles(file, everything);
      CHECK(particles.facts.frames.value_or(0) < whole_frames);
    } catch (const InputError& error) {
      CHECK(std::string_view(error.what()).find('\n') == std::string_view::npos);
    }
  }
}

}  // namespace parray::test
