#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/input/particles/particles.h"

namespace parray::input {

/// Names and how often each occurs, in the order in which the file first uses them.
using NameCounts = std::vector<std::pair<std::string, std::uint64_t>>;

/// The values of one number of all particles.
struct NumberRangeSeen {
  std::string name;
  std::optional<double> low{};  ///< none: no particle has a value
  std::optional<double> high{};
  std::uint64_t missing = 0;  ///< particles of which the file does not say it
};

/// What is in a file of particles, for people who want to know whether it was understood.
struct ParticleSummary {
  std::uint64_t count = 0;
  NameCounts elements;  ///< by atomic number; "unknown" last; empty: the file has none
  NameCounts types;
  NameCounts chains;         ///< with their particles
  NameCounts residue_names;  ///< with their residues
  std::uint64_t residues = 0;
  Vec3d low;  ///< bounds of the positions
  Vec3d high;
  std::vector<NumberRangeSeen> numbers;  ///< radii under the name "radius" first
};

/// Residues are runs of particles of one chain, residue number and residue name.
ParticleSummary summary_of(const Particles& particles);

/// Lengths of a cell's edges a, b, c, and in degrees the angles between b and c, a and c, a and b.
Vec3d lengths_of(const ParticleCell& cell);
Vec3d angles_of(const ParticleCell& cell);

}  // namespace parray::input
