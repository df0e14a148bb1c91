#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/input/particles/particles.h"

namespace parray::input {

/// Names and their counts, in the order in which the file first uses the names.
using NameCounts = std::vector<std::pair<std::string, std::uint64_t>>;

/// The range of a number over all particles.
struct NumberRangeSeen {
  std::string name;
  std::optional<double> low{};  ///< empty: no particle has a value
  std::optional<double> high{};
  std::uint64_t missing = 0;  ///< number of particles without a value
  std::string unit{};         ///< empty: unknown
};

/// The content of a particle file, so that users can check that ParRay understood the file.
struct ParticleSummary {
  std::uint64_t count = 0;
  NameCounts elements;  ///< element_counts(); empty: the file has no elements
  NameCounts types;
  NameCounts chains;         ///< with their numbers of particles
  NameCounts residue_names;  ///< with their numbers of residues
  std::uint64_t residues = 0;
  Vec3d low;  ///< bounds of the positions
  Vec3d high;
  std::vector<NumberRangeSeen> numbers;  ///< radii come first, under the name "radius"
};

/// Returns the symbols of elements that occur in a column, and their counts, by atomic number, and
/// "unknown" last.
NameCounts element_counts(const std::vector<std::uint8_t>& elements);

/// Returns whether two particles have the same chain, residue number, insertion code and residue
/// name. Columns that the file lacks are the same for all particles.
bool same_residue(const Particles& particles, std::size_t i, std::size_t j);

/// Returns whether a residue begins at particle i.
bool begins_residue(const Particles& particles, std::size_t i);

/// Returns the summary. A residue is a run of particles that are the same_residue().
ParticleSummary summary_of(const Particles& particles);

/// Return the lengths of a cell's edges a, b, c, and the angles in degrees between b and c, a and
/// c, a and b.
Vec3d lengths_of(const ParticleCell& cell);
Vec3d angles_of(const ParticleCell& cell);

}  // namespace parray::input
